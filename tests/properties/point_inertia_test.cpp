// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A moment of inertia without mass (*ROTARY INERTIA, CONM2) is in the mass matrix, and nothing else of it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "mbs/superelement/file.hpp"
#include "reduce/assembly/point_mass.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using mbs::chance::Chance;
using test::run;

/// Of a body: of points.
Matrix3d random_inertia(Chance& chance, double size) {
  Matrix3d J = Matrix3d::Zero();
  for (int k = 2 + chance.below(3); k > 0; --k) {
    const Vector3d x = chance.vector(size);
    J += x.squaredNorm() * Matrix3d::Identity() - x * x.transpose();
  }
  return J;
}

TEST(PointInertia, WithoutMassHasItsSecondMomentsAlone) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Chance chance(seed);
    const double size = std::pow(10.0, chance.between(-3.0, 2.0));
    reduce::Part part;
    part.mesh.points.resize(8, 3);
    for (int k = 0; k < 8; ++k) part.mesh.points.row(k) = chance.vector(size).transpose();
    reduce::InterfaceSpec spec;
    spec.tie = reduce::Tie::rigid;
    spec.point = chance.vector(size);
    part.interfaces.push_back(spec);
    const Matrix3d J = random_inertia(chance, size * std::pow(10.0, chance.between(-4.0, 2.0)));
    reduce::PointMass mass{.mass = 0.0};
    mass.inertia = J;
    add_mass_to_interface(part, 0, mass);
    double m = 0;
    Vector3d first = Vector3d::Zero();
    Matrix3d about = Matrix3d::Zero();
    double total = 0;
    for (const auto& point : part.masses) {
      const Vector3d x = part.mesh.points.row(point.node).transpose() - spec.point;
      m += point.mass, total += std::abs(point.mass);
      first += point.mass * x;
      about += point.mass * (x.squaredNorm() * Matrix3d::Identity() - x * x.transpose());
    }
    // Places are rounded beside the part's size.
    EXPECT_NEAR(m, 0.0, 1e-15 * total * 7) << seed;
    EXPECT_LT(first.norm(), 1e-14 * total * size) << seed;
    EXPECT_LT((about - J).norm(), 1e-12 * J.norm()) << seed;
  }
}

// Of a beam on whose end it stands: M_se with it less M_se without it.
TEST(PointInertia, OfADeckIsThatOfItsInterface) {
  const test::Folder folder;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Chance chance(seed);
    const Matrix3d J = random_inertia(chance, 0.05);
    const bool abaqus = chance.flip(0.5);
    const std::string name = abaqus ? "d.inp" : "d.bdf";
    const auto reduced = [&](bool has_it) {
      std::string deck;
      if (abaqus) {
        deck =
            "*NODE\n1,0,0,0\n2,.2,0,0\n3,.4,0,0\n*ELEMENT,TYPE=B31,ELSET=B\n1,1,2\n2,2,3\n*BEAM "
            "SECTION,ELSET=B,MATERIAL=S,"
            "SECTION=RECT\n.05,.03\n0,1,0\n*MATERIAL,NAME=S\n*ELASTIC\n2.1E11,.3\n*DENSITY\n7850\n";
        if (has_it)
          deck += fmt::format(
              "*ELEMENT,TYPE=ROTARYI,ELSET=M\n90,3\n*ROTARY INERTIA,ELSET=M\n{:.12e},{:.12e},{:.12e},{:.12e},"
              "{:.12e},{:.12e}\n",
              J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2));
      } else {
        deck =
            "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,.2,0.,0.\nGRID,3,,.4,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\n"
            "CBAR,2,1,2,3,0.,1.,0.\nPBAR,1,1,1.5-3,3.-7,1.-7,2.-7\nMAT1,1,2.1+11,,.3,7850.\n";
        if (has_it)  // wide fields; products with a plus sign
          deck += fmt::format(
              "CONM2*  {:<16}{:<16}{:<16}{:<16}\n*       \n*       {:16.9E}{:16.9E}{:16.9E}{:16.9E}\n*       "
              "{:16.9E}{:16.9E}\n",
              9, 3, 0, "0.", J(0, 0), -J(0, 1), J(1, 1), -J(0, 2), -J(1, 2), J(2, 2));
        deck += "ENDDATA\n";
      }
      folder.write(name, deck);
      const auto part = folder.write(
          "p.toml",
          fmt::format("[geometry]\nfile = \"{}\"\nunit = \"m\"\n[interface.a]\nby = \"nodes\"\nnodes = [1]\n"
                      "[interface.b]\nby = \"nodes\"\nnodes = [3]\n[modes]\nset = \"guyan\"\n",
                      name));
      const test::Outcome outcome =
          run("flexura-reduce", {part.string(), "-q", "-o", (folder / "p.se.h5").string()});
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err << deck;
      return superelement::read(folder / "p.se.h5", {});
    };
    const superelement::Superelement without = reduced(false), with = reduced(true);
    ASSERT_EQ(with.n(), 12);
    Eigen::MatrixXd expected = without.M_se;
    expected.bottomRightCorner<3, 3>() += J;
    // Nine digits of the deck.
    EXPECT_LT((with.M_se - expected).norm(), 1e-8 * expected.norm()) << seed;
    EXPECT_NEAR(with.inertia.mass, without.inertia.mass, 1e-12 * without.inertia.mass);
  }
}

}  // namespace
}  // namespace flexura::properties
