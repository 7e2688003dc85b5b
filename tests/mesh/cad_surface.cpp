// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Closed surfaces of triangles (STL) as parts.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>

#include "tests/mesh/cad_parts.hpp"
#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using Facets = std::vector<std::array<Vector3d, 3>>;

void add_quad(Facets& facets, const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  facets.push_back({a, b, c});
  facets.push_back({a, c, d});
}

Facets box(const Vector3d& low, const Vector3d& high) {
  const auto at = [&](int i) {
    return Vector3d(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  };
  Facets facets;
  for (const auto& q :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    add_quad(facets, at(q[0]), at(q[1]), at(q[2]), at(q[3]));
  return facets;
}

// A pipe along z as CAD programs write it: strips along the axis, n around.
Facets pipe(int n, double R, double r, double h) {
  Facets facets;
  const auto at = [&](double radius, int k, double z) {
    const double a = 2.0 * std::numbers::pi * k / n;
    return Vector3d(radius * std::cos(a), radius * std::sin(a), z);
  };
  for (int k = 0; k < n; ++k) {
    add_quad(facets, at(R, k, 0), at(R, k + 1, 0), at(R, k + 1, h), at(R, k, h));
    add_quad(facets, at(r, k + 1, 0), at(r, k, 0), at(r, k, h), at(r, k + 1, h));
    add_quad(facets, at(R, k, h), at(R, k + 1, h), at(r, k + 1, h), at(r, k, h));
    add_quad(facets, at(R, k + 1, 0), at(R, k, 0), at(r, k, 0), at(r, k + 1, 0));
  }
  return facets;
}

class SurfacePart : public ::testing::Test {
 protected:
  std::string write_text(const std::string& text) const {
    std::ofstream(scratch_.path()) << text;
    return scratch_.path().string();
  }
  std::string write(const Facets& facets) const {
    std::string text = "solid part\n";
    for (const auto& corners : facets) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const Vector3d& x : corners)
        text += fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", x.x(), x.y(), x.z());
      text += "endloop\nendfacet\n";
    }
    return write_text(text + "endsolid part\n");
  }
  std::string refusal(const Facets& facets) const {
    try {
      list_faces(options_for(write(facets)));
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "(accepted)";
  }

  Scratch scratch_{"part.stl", ""};
};

// What the facets enclose: of the pipe n / 2 sin(2 pi / n) (R^2 - r^2) h.  Files hold seven digits, here nine.
TEST_F(SurfacePart, HasTheVolumeAndTheFacesOfItsFacets) {
  const int n = 48;
  CadOptions options = options_for(write(pipe(n, 20, 12, 50)));
  options.size = 5e-3;
  const CadMesh part = mesh_cad(options);
  const double V = 0.5 * n * std::sin(2 * std::numbers::pi / n) * (20 * 20 - 12 * 12) * 50 * 1e-9;
  EXPECT_NEAR(part.cad.solids.at(0).volume, V, 1e-7 * V);
  EXPECT_NEAR(part.cad.solids.at(0).centroid.z(), 0.025, 1e-9);
  // About its axis an n-gon of circumradius R has n R^4 / 8 sin(2 pi / n) (1 - 2/3 sin^2(pi / n)).
  const double s = std::sin(std::numbers::pi / n), J = n / 4.0 * std::sin(2 * std::numbers::pi / n) *
                                                       (1 - 2.0 / 3.0 * s * s) *
                                                       (std::pow(0.020, 4) - std::pow(0.012, 4)) * 0.05;
  EXPECT_NEAR(part.cad.solids.at(0).inertia(2, 2), J, 1e-7 * J);
  ASSERT_EQ(part.cad.faces.size(), 4U);
  int planes = 0;
  for (const Face& face : part.cad.faces) {
    if (face.kind == FaceKind::plane) {
      ++planes;
      EXPECT_NEAR(std::abs(face.normal.z()), 1.0, 1e-9);
      continue;
    }
    ASSERT_EQ(face.kind, FaceKind::cylinder);
    EXPECT_NEAR(face.radius, face.hole ? 0.012 : 0.020, 1e-8);
    EXPECT_NEAR(face.length, 0.05, 1e-8);
    EXPECT_NEAR(face.sweep, 2 * std::numbers::pi, 0.01);  // n facets are 0.1 % less than their circle
    EXPECT_NEAR(face.axis.z(), 1.0, 1e-9);
  }
  EXPECT_EQ(planes, 2);
  // The mesh cuts some of the facets' edges.
  EXPECT_LT(std::abs(part.report.volume_error), 0.005);
  EXPECT_EQ(part.report.quality.n_inverted, 0);
  EXPECT_EQ(find_pieces(part.mesh).count, 1);
  EXPECT_EQ(count_faces_that_look_inwards(part), 0);
}

// What an interface chooses in the list has to be that in every mesh, however its triangles are refined.
TEST_F(SurfacePart, KeepsTheNumbersOfItsFaces) {
  CadOptions options = options_for(write(pipe(24, 20, 12, 90)));
  const CadReport listed = list_faces(options);
  for (const double size : {6e-3, 20e-3}) {
    options.size = size;
    const CadMesh part = mesh_cad(options);
    ASSERT_EQ(part.cad.faces.size(), listed.faces.size());
    for (const Face& face : listed.faces) {
      Vector3d moment = Vector3d::Zero();
      double area = 0;
      std::size_t k = 0;
      for (const CellBlock& block : part.mesh.boundary)
        for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++k) {
          if (part.mesh.boundary_face[k] != face.number) continue;
          const auto at = [&](int c) {
            return Vector3d(part.mesh.points.row(block.nodes(cell, c)).transpose());
          };
          const double own = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
          area += own;
          moment += own / 3.0 * (at(0) + at(1) + at(2));
        }
      // Meshes of 6 and 20 mm go across the facets, which are 5 mm wide.
      EXPECT_NEAR(area / face.area, 1.0, 0.1) << face.number << ' ' << size;
      EXPECT_LT((moment / area - face.centroid).norm(), 2e-3) << face.number << ' ' << size;
    }
  }
}

TEST_F(SurfacePart, OfPlanesIsMeshedExactlyHoweverItsTrianglesTurn) {
  Facets facets = box({0, 0, 0}, {100, 20, 10});
  const Facets cavity = box({20, 5, 3}, {80, 15, 7});
  facets.insert(facets.end(), cavity.begin(), cavity.end());
  for (std::size_t k = 0; k < facets.size(); k += 3) std::swap(facets[k][1], facets[k][2]);
  CadOptions options = options_for(write(facets));
  options.unit = "cm";
  options.size = 0.06;
  const CadMesh part = mesh_cad(options);
  const double V = (100 * 20 * 10 - 60 * 10 * 4) * 1e-6;
  EXPECT_NEAR(part.cad.solids.at(0).volume, V, 1e-9 * V);
  EXPECT_NEAR(part.report.volume, V, 1e-9 * V);
  EXPECT_EQ(part.cad.faces.size(), 12U);
  EXPECT_EQ(count_faces_that_look_inwards(part), 0);
}

TEST_F(SurfacePart, ThatBoundsNoBodyIsRefusedWithThePlace) {
  Facets open = box({0, 0, 0}, {100, 20, 10});
  open.pop_back();
  EXPECT_THAT(refusal(open),
              HasSubstr("is not closed, so that it has no inside: 3 of its 18 edges belong to one "
                        "triangle only, 52.361 mm together: (100, "));
  Facets two = box({0, 0, 0}, {1, 1, 1});
  const Facets other = box({2, 0, 0}, {3, 1, 1});
  two.insert(two.end(), other.begin(), other.end());
  EXPECT_THAT(refusal(two), HasSubstr("holds 2 closed surfaces beside one another"));
  Facets nested = box({0, 0, 0}, {10, 10, 10});
  for (const Facets& more : {box({1, 1, 1}, {9, 9, 9}), box({4, 4, 4}, {6, 6, 6})})
    nested.insert(nested.end(), more.begin(), more.end());
  EXPECT_THAT(refusal(nested), HasSubstr("holds 3 closed surfaces, one within a cavity"));
  CadOptions healed = options_for(write(box({0, 0, 0}, {1, 1, 1})));
  healed.heal = true;
  EXPECT_THROW(list_faces(healed), std::invalid_argument);
  Facets fin = box({0, 0, 0}, {100, 20, 10});
  fin.push_back({Vector3d(0, 0, 0), Vector3d(100, 0, 0), Vector3d(50, -30, 5)});
  EXPECT_THAT(refusal(fin), HasSubstr("or to more than two"));
  EXPECT_THAT(refusal({}), HasSubstr("save it again"));
  EXPECT_THROW(list_faces(options_for(write_text(std::string(200, 'x')))), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::mesh
