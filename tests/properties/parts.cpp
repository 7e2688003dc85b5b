// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/properties/parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/modes.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/file/flexdata_file.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"

namespace flexura::properties {
namespace {

using Eigen::Vector3d;
using mbs::chance::Chance;

constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

// Half of the interfaces keep all six, the others any of the first `most` directions.
std::string some_directions(Chance& chance, const PartOptions& options, int most = 6) {
  if (options.all_directions || (most == 6 && chance.flip(0.5))) return "";
  std::vector<std::string> kept;
  for (int k = 0; k < most; ++k)
    if (chance.flip(0.5)) kept.push_back(fmt::format("\"{}\"", kDirections[k]));
  if (kept.empty()) kept.push_back(fmt::format("\"{}\"", kDirections[chance.below(most)]));
  return fmt::format("directions = [{}]\n", fmt::join(kept, ", "));
}

std::string modes_text(Chance& chance, const PartOptions& options) {
  // Few, or all there are.
  const int count = chance.flip(0.15) ? 500 : options.fewest_modes + chance.below(12);
  return fmt::format("[modes]\ncount = {}\ndamping = 0.0\n", count);
}

std::string beams(Chance& chance, const PartOptions& options) {
  const int n = 2 + chance.below(4);
  const bool is_straight = chance.flip(0.4);
  const Vector3d axis = chance.flip(0.5) ? Vector3d(Vector3d::UnitX()) : chance.direction();
  std::string text =
      "[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = \"7850 kg/m^3\"\n[section.s]\n";
  const double width = chance.between(5e-3, 4e-2);
  text += chance.flip(0.5) ? fmt::format("type = \"rectangle\"\nwidth = {:.17g}\nheight = {:.17g}\n", width,
                                         chance.between(5e-3, 4e-2))
                           : fmt::format("type = \"circle\"\ndiameter = {:.17g}\n", width);
  for (int k = 0; k < n; ++k) {
    const double along = k + chance.between(-0.3, 0.3);
    const Vector3d p = is_straight ? Vector3d(along * axis) : chance.vector(1.0) + along * Vector3d::UnitX();
    text += fmt::format("[node.n{}]\nposition = {}\n", k, list(p));
  }
  for (int k = 1; k < n; ++k) {
    const int from = is_straight || chance.flip(0.6) ? k - 1 : chance.below(k);
    text += fmt::format("[member.m{}]\nnodes = [\"n{}\", \"n{}\"]\n", k, from, k);
    if (is_straight && std::abs(axis.z()) > 0.9) text += "orientation = [1, 0, 0]\n";
  }
  const int n_interfaces = 1 + chance.below(n);
  for (int k = 0; k < n_interfaces; ++k)
    text += fmt::format("[interface.n{}]\n{}", k, some_directions(chance, options));
  text += fmt::format("[mesh]\nelements = {}\n", 1 + chance.below(5));
  return text + modes_text(chance, options);
}

// A bar of bricks along x, n x 2 x 2 (or a sheet, n x 2): *ELEMENT lines by node numbers from 1, x last.
struct Deck {
  std::string text;
  std::vector<std::vector<int>> sections;  ///< nodes at each x
};

Deck bricks(Chance& chance) {
  const int n = 2 + chance.below(4);
  const double dx = chance.between(0.02, 0.2), dy = chance.between(0.01, 0.05),
               dz = chance.between(0.01, 0.05);
  Deck deck{"*NODE\n", {}};
  int node = 0;
  for (int i = 0; i <= n; ++i) {
    deck.sections.emplace_back();
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        deck.text += fmt::format("{}, {:.12g}, {:.12g}, {:.12g}\n", ++node, i * dx, j * dy, k * dz);
        deck.sections.back().push_back(node);
      }
  }
  deck.text += "*ELEMENT, TYPE=C3D8, ELSET=ALL\n";
  int element = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        const auto at = [](int a, int b, int c) { return 9 * a + 3 * b + c + 1; };
        deck.text += fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", ++element, at(i, j, k),
                                 at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k), at(i, j, k + 1),
                                 at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1));
      }
  deck.text += "*SOLID SECTION, ELSET=ALL, MATERIAL=M\n";
  return deck;
}

Deck sheet(Chance& chance) {
  const int n = 3 + chance.below(4);
  const double dx = chance.between(0.02, 0.1), dy = chance.between(0.02, 0.1);
  const double turn = chance.between(0.0, 0.4);  // of the sheet's direction from one strip to the next
  Deck deck{"*NODE\n", {}};
  int node = 0;
  double x = 0.0, z = 0.0, angle = 0.0;
  for (int i = 0; i <= n; ++i) {
    deck.sections.emplace_back();
    for (int j = 0; j < 3; ++j) {
      deck.text += fmt::format("{}, {:.12g}, {:.12g}, {:.12g}\n", ++node, x, j * dy, z);
      deck.sections.back().push_back(node);
    }
    x += dx * std::cos(angle);
    z += dx * std::sin(angle);
    angle += turn;
  }
  deck.text += "*ELEMENT, TYPE=S4, ELSET=ALL\n";
  int element = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2; ++j)
      deck.text += fmt::format("{}, {}, {}, {}, {}\n", ++element, 3 * i + j + 1, 3 * i + j + 4, 3 * i + j + 5,
                               3 * i + j + 2);
  deck.text += fmt::format("*SHELL SECTION, ELSET=ALL, MATERIAL=M\n{:.6g}\n", chance.between(1e-3, 5e-3));
  return deck;
}

std::string part_of(Chance& chance, Deck& deck, const PartOptions& options) {
  deck.text += "*MATERIAL, NAME=M\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n";
  std::string text = "[geometry]\nfile = \"part.inp\"\nunit = \"m\"\n";
  const int last = static_cast<int>(deck.sections.size()) - 1;
  std::vector<int> at = {0, last};
  if (last > 2 && chance.flip(0.3)) at.push_back(last / 2);
  const int n = chance.flip(0.2) ? 1 : static_cast<int>(at.size());
  for (int k = 0; k < n; ++k) {
    const bool is_node = !options.all_directions && chance.flip(0.1);
    std::vector<int> nodes = deck.sections[static_cast<std::size_t>(at[static_cast<std::size_t>(k)])];
    if (is_node) nodes.resize(1);
    text += fmt::format("[interface.i{}]\nby = \"nodes\"\nnodes = [{}]\ntie = \"{}\"\n", k,
                        fmt::join(nodes, ", "), is_node || chance.flip(0.5) ? "rigid" : "average");
    text += some_directions(chance, options);
  }
  return text + modes_text(chance, options);
}

// A lattice of springs between points in space, with their masses: rows by node, three directions each.
std::string lattice(Chance& chance, const PartOptions& options, const test::Folder& folder) {
  const int n = 5 + chance.below(4);
  std::vector<Vector3d> x;
  for (int k = 0; k < n; ++k) x.push_back(chance.vector(1.0));
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * n, 3 * n), M = K;
  for (int a = 0; a < n; ++a) {
    M.block<3, 3>(3 * a, 3 * a) = chance.between(0.5, 5.0) * Eigen::Matrix3d::Identity();
    for (int b = 0; b < a; ++b) {
      const Vector3d e = (x[a] - x[b]).normalized();
      const Eigen::Matrix3d k = chance.between(1e4, 1e6) * e * e.transpose();
      K.block<3, 3>(3 * a, 3 * a) += k;
      K.block<3, 3>(3 * b, 3 * b) += k;
      K.block<3, 3>(3 * a, 3 * b) -= k;
      K.block<3, 3>(3 * b, 3 * a) -= k;
    }
  }
  const auto market = [](const Eigen::MatrixXd& A) {
    std::string entries;
    int count = 0;
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      for (Eigen::Index i = j; i < A.rows(); ++i)
        if (A(i, j) != 0.0) {
          entries += fmt::format("{} {} {:.17g}\n", i + 1, j + 1, A(i, j));
          ++count;
        }
    return fmt::format("%%MatrixMarket matrix coordinate real symmetric\n{} {} {}\n{}", A.rows(), A.cols(),
                       count, entries);
  };
  folder.write("K.mtx", market(K));
  folder.write("M.mtx", market(M));
  std::string nodes;
  for (int k = 0; k < n; ++k)
    nodes += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", k + 1, x[k].x(), x[k].y(), x[k].z());
  folder.write("nodes.csv", nodes);
  std::string text =
      "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n[matrices]\nstiffness = \"K.mtx\"\nmass = \"M.mtx\"\n"
      "[interface.i0]\nby = \"nodes\"\nnodes = [1, 2, 3]\ntie = \"average\"\n" +
      some_directions(chance, options);
  if (chance.flip(0.5))
    text += fmt::format("[interface.i1]\nby = \"nodes\"\nnodes = [{}, {}, {}]\ntie = \"average\"\n", n - 2,
                        n - 1, n) +
            some_directions(chance, options);
  return text + modes_text(chance, options);
}

superelement::Superelement reduced(const test::Folder& folder, const std::string& text, bool is_beams) {
  const auto file = folder.write("part.toml", text);
  return is_beams ? reduce::reduce(reduce::read_beam_part(file)).superelement
                  : reduce::reduce(reduce::read_part(file)).superelement;
}

}  // namespace

RandomPart random_part(Chance& chance, Kind kind, const test::Folder& folder, const PartOptions& options) {
  RandomPart out;
  bool is_beams = false;
  if (kind == Kind::beams || kind == Kind::flexdata) {
    out.text = beams(chance, options);
    is_beams = true;
  } else if (kind == Kind::matrices) {
    out.text = lattice(chance, options, folder);
  } else {
    Deck deck = kind == Kind::solids ? bricks(chance) : sheet(chance);
    out.text = part_of(chance, deck, options);
    folder.write("part.inp", deck.text);
    out.text += "# part.inp\n";
  }
  const int n_written = 1 + chance.below(9);  // of FlexData's modes
  try {
    out.superelement = reduced(folder, out.text, is_beams);
    if (kind == Kind::flexdata) {
      const superelement::ModeAnalysis modes = superelement::natural_modes(out.superelement, {}, n_written);
      superelement::write_flexdata(folder / "part.xml", superelement::make_flexdata(out.superelement, modes));
      out.text += fmt::format("# as FlexData of {} modes\n", n_written);
      out.superelement = reduce::reduce(reduce::read_flexdata_part(folder / "part.xml", {})).superelement;
    }
  } catch (const std::exception& error) {
    out.refused = error.what();
  }
  return out;
}

}  // namespace flexura::properties
