// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace flexura::test {

enum class Cells { quadrilaterals, triangles };

/// An nx by ny grid over a (skewed) plate lx by ly in the plane z = 0; grid numbers run along x from 1.
struct Plate {
  double lx = 10.0, ly = 10.0, t = 0.05, E = 200e9, nu = 0.3, rho = 8000.0, skew = 0.0, offset = 0.0;
  int nx = 8, ny = 8;
  Cells cells = Cells::quadrilaterals;

  int node(int i, int j) const { return 1 + i + (nx + 1) * j; }
  std::array<double, 2> at(int i, int j) const {
    const double x = lx * i / nx, y = ly * j / ny;
    return {x + y * std::sin(skew), y * std::cos(skew)};
  }
  template <class Visit>
  void each_cell(const Visit& visit) const {
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
        if (cells == Cells::quadrilaterals) {
          visit(std::vector<int>{a, b, c, d});
        } else {
          visit(std::vector<int>{a, b, c});
          visit(std::vector<int>{a, c, d});
        }
      }
  }
  std::string nastran(const std::string& more = "") const {
    std::string text = fmt::format("BEGIN BULK\nMAT1,1,{:.9e},,{},{}\nPSHELL,1,1,{},1,,1\n", E, nu, rho, t);
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        text += fmt::format("GRID,{},,{:.15g},{:.15g},0.\n", node(i, j), at(i, j)[0], at(i, j)[1]);
    int e = 0;
    each_cell([&](const std::vector<int>& n) {
      text += fmt::format("{},{},1,{}", n.size() == 4 ? "CQUAD4" : "CTRIA3", ++e, fmt::join(n, ","));
      if (offset != 0.0) text += fmt::format(",,{}", offset);
      text += "\n";
    });
    return text + more + "ENDDATA\n";
  }
  std::string abaqus() const {
    std::string text = "*HEADING\nplate\n*NODE\n";
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        text += fmt::format("{}, {:.15g}, {:.15g}, 0.\n", node(i, j), at(i, j)[0], at(i, j)[1]);
    text += fmt::format("*ELEMENT, TYPE={}, ELSET=ALL\n", cells == Cells::quadrilaterals ? "S4R" : "S3");
    int e = 0;
    each_cell([&](const std::vector<int>& n) { text += fmt::format("{}, {}\n", ++e, fmt::join(n, ", ")); });
    return text +
           fmt::format(
               "*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL\n{}, 5\n*MATERIAL, NAME=STEEL\n*ELASTIC\n{:.9e}, "
               "{}\n*DENSITY\n{}\n",
               t, E, nu, rho);
  }
  std::string edge(const std::function<bool(int, int)>& on) const {
    std::vector<int> nodes;
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        if (on(i, j)) nodes.push_back(node(i, j));
    return fmt::format("by = \"nodes\"\nnodes = [{}]\n", fmt::join(nodes, ", "));
  }
  double mass() const { return rho * t * lx * ly * std::cos(skew); }
};

}  // namespace flexura::test
