// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <functional>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_solver.hpp"
#include "reduce/elements/surface.hpp"
#include "reduce/invariants/inertia_integrals.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using mesh::CellType;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const Part& part) {
  try {
    const TiedModel model(part);
    const TiedSolver solver(model);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was refused";
}

Part small_beam(Tie left = Tie::rigid, Tie right = Tie::rigid) {
  return beam({0.4, 0.1, 0.1}, {4, 2, 2}, CellType::tet10, left, right);
}

// All ties follow a rigid motion of the body: expanding R_b and the nodes' rigid motion gives that motion.
TEST(Ties, RigidMotionOfInterfacesIsRigidMotionOfTheBody) {
  for (const Tie left : {Tie::rigid, Tie::average})
    for (const Tie right : {Tie::rigid, Tie::average}) {
      const TiedModel model(small_beam(left, right));
      const TiedSolver solver(model);
      Eigen::MatrixXd g(model.A().rows(), 6);
      for (Eigen::Index r = 0; r < g.rows(); ++r)
        g.row(r) = model.motions().rigid_b().row(model.averaged_dofs()[r]);
      const Eigen::MatrixXd load = -(model.K_ib() * model.motions().rigid_b());
      const auto solution = solver.solve_refined(load, g);
      Eigen::MatrixXd U;
      model.motions().expand(solution.U, model.motions().rigid_b(), U);
      // Round-off of a static solution: condition number (1e4 here) times 1e-16.
      EXPECT_LT((U - model.motions().rigid_nodes()).cwiseAbs().maxCoeff(), 1e-11);
      if (g.rows() > 0) {
        EXPECT_LT(solution.mu.norm(), 1e-9 * model.K_ii().diagonal(0));
      }
    }
}

// K_ii + shift M_ii by adding products of the nodal mass matrix is what assembling by elements gives, also
// where an interface node keeps directions to itself; and the mass in it is that of the products M_ii X.
TEST(Ties, ShiftedStiffnessIsTheAssembledOne) {
  Part part = small_beam(Tie::rigid, Tie::rigid);
  part.interfaces[1].directions = {0, 2, 5};
  part.masses.push_back({part.mesh.solids[0].nodes(0, 0), 0.7});
  AssemblyOptions options;
  options.shift = -3.1e7;
  const Eigen::MatrixXd assembled = dense(TiedModel(part, options).K_ii());
  const TiedModel model(part);
  const Eigen::MatrixXd shifted = dense(model.matrices().shifted_stiffness(options.shift));
  Eigen::MatrixXd M;
  model.matrices().multiply_M_ii(Eigen::MatrixXd::Identity(model.n_i(), model.n_i()), M);
  // Sums of some tens of terms.
  EXPECT_LT((shifted - assembled).norm(), 1e-14 * assembled.norm());
  EXPECT_LT((shifted - dense(model.K_ii()) - options.shift * M).norm(), 1e-14 * assembled.norm());
}

TEST(Ties, AverageOfARigidMotionIsTheMotionOnCurvedFaces) {
  Part part = small_beam();
  deform(part.mesh, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return x + Eigen::Vector3d(0.01 * std::sin(30 * x(1)) * std::cos(20 * x(2)), 0, 0);
  });
  InterfaceSpec interface = part.interfaces[0];
  for (const bool weighted : {true, false}) {
    if (!weighted) interface.set.faces.clear();
    const auto average = averaging_map(part.mesh, interface);
    Eigen::MatrixXd motion(3 * interface.set.nodes.size(), 6);
    for (std::size_t a = 0; a < interface.set.nodes.size(); ++a)
      motion.middleRows<3>(3 * static_cast<Eigen::Index>(a)) =
          motion_at(part.mesh.points.row(interface.set.nodes[a]).transpose() - interface.point);
    EXPECT_LT((average * motion - Eigen::MatrixXd::Identity(6, 6)).norm(), 1e-12);
  }
}

// The transpose of the average distributes loads: a force and a moment on the interface node become nodal
// forces with the same resultant, and for a uniform force those of a uniform traction over the area.
TEST(Ties, AverageSpreadsLoadsIntoStaticallyEquivalentTractions) {
  const Part part = small_beam();
  const InterfaceSpec& interface = part.interfaces[0];
  const auto average = averaging_map(part.mesh, interface);
  const Vector6 load = random_matrix(6, 1);
  const Eigen::VectorXd forces = average.transpose() * load;
  Vector6 resultant = Vector6::Zero();
  for (std::size_t a = 0; a < interface.set.nodes.size(); ++a)
    resultant +=
        motion_at(part.mesh.points.row(interface.set.nodes[a]).transpose() - interface.point).transpose() *
        forces.segment<3>(3 * static_cast<Eigen::Index>(a));
  EXPECT_LT((resultant - load).norm(), 1e-12 * load.norm());

  const Eigen::VectorXd pull = average.transpose() * Vector6::Unit(0);
  const Eigen::MatrixXd pressure = pressure_load(part.mesh, interface.set.faces);
  for (std::size_t a = 0; a < interface.set.nodes.size(); ++a)  // outward normal of the face x = 0 is -x
    EXPECT_NEAR(pull(3 * static_cast<Eigen::Index>(a)), -pressure(interface.set.nodes[a], 0) / (0.1 * 0.1),
                1e-13);
}

// Averaging ties against the dense saddle-point system, no factorisation tricks.
TEST(Ties, SolverWithAveragesSolvesTheSaddlePointProblem) {
  for (const Tie left : {Tie::rigid, Tie::average}) {
    const TiedModel model(small_beam(left, Tie::average));
    EXPECT_EQ(model.pins().size(), left == Tie::rigid ? 0u : 6u);
    const TiedSolver solver(model);
    const int n = model.n_i(), n_a = static_cast<int>(model.A().rows());
    const double k = model.K_ii().diagonal(0);
    Eigen::MatrixXd saddle = Eigen::MatrixXd::Zero(n + n_a, n + n_a);
    saddle.topLeftCorner(n, n) = dense(model.K_ii()) / k;
    saddle.bottomLeftCorner(n_a, n) = Eigen::MatrixXd(model.A());
    saddle.topRightCorner(n, n_a) = Eigen::MatrixXd(model.A()).transpose();
    const Eigen::MatrixXd F = random_matrix(n, 2), g = random_matrix(n_a, 2, 2);
    Eigen::MatrixXd rhs(n + n_a, 2);
    rhs << F / k, g;
    const Eigen::MatrixXd exact = saddle.partialPivLu().solve(rhs);
    const auto solution = solver.solve_refined(F, g);
    EXPECT_LT((solution.U - exact.topRows(n)).norm(), 1e-9 * exact.topRows(n).norm());
    EXPECT_LT((solution.mu - k * exact.bottomRows(n_a)).norm(), 1e-9 * k * exact.bottomRows(n_a).norm());
  }
}

TEST(Ties, ExpandAndGatherAreTransposes) {
  const TiedModel model(small_beam(Tie::rigid, Tie::average));
  const Eigen::MatrixXd u_i = random_matrix(model.n_i(), 1), u_b = random_matrix(model.n_b(), 1, 2),
                        F = random_matrix(3 * model.n_nodes(), 1, 3);
  Eigen::MatrixXd U, f_i, f_b;
  model.motions().expand(u_i, u_b, U);
  model.motions().gather(F, f_i, f_b);
  EXPECT_NEAR((F.transpose() * U)(0, 0), (f_i.transpose() * u_i)(0, 0) + (f_b.transpose() * u_b)(0, 0),
              1e-13 * F.norm() * U.norm());
}

TEST(Refusals, NoInterface) {
  Part part = small_beam();
  part.interfaces.clear();
  EXPECT_THAT(refusal(part), HasSubstr("the part has no interface: name at least one face"));
}

TEST(Refusals, InterfacesThatShareNodes) {
  Part part = small_beam();
  part.interfaces.push_back(
      {"top", Tie::rigid, {0.2, 0.05, 0.1}, nodes_where(part.mesh, [](const Eigen::Vector3d& x) {
         return x(2) > 0.0999;
       })});
  // The edge x = 0, z = 0.1 of a face with two quadratic elements has five nodes.
  EXPECT_THAT(refusal(part),
              HasSubstr("interfaces 'left' and 'top' share 5 nodes: choose faces that do not touch"));
}

TEST(Refusals, InterfaceWithoutNodes) {
  Part part = small_beam();
  part.interfaces[1].set = {};
  EXPECT_THAT(refusal(part), HasSubstr("interface 'right' has no node"));
}

TEST(Refusals, InterfaceOnALine) {
  for (const Tie tie : {Tie::rigid, Tie::average}) {
    Part part = small_beam();
    part.interfaces[0].tie = tie;
    part.interfaces[0].set = nodes_where(
        part.mesh, [](const Eigen::Vector3d& x) { return x(0) < 1e-9 && std::abs(x(2) - 0.05) < 1e-9; });
    EXPECT_THAT(refusal(part),
                AllOf(HasSubstr("interface 'left' has 5 nodes, all on one line, and cannot hold a "
                                "rotation about the axis (0, 1, 0) through (0, 0, 0.05) m"),
                      HasSubstr("choose a face or more nodes")));
  }
}

TEST(Refusals, InterfaceInAPoint) {
  Part part = small_beam();
  part.interfaces[0].set = nodes_where(part.mesh, [](const Eigen::Vector3d& x) { return x.norm() < 1e-9; });
  EXPECT_THAT(refusal(part), HasSubstr("interface 'left' has 1 node, a point, and cannot hold a rotation"));
}

// Two single nodes leave the rotation about the line through them.
TEST(Refusals, InterfacesThatLeaveARotation) {
  Part part = small_beam();
  part.interfaces.clear();
  for (const double x : {0.0, 0.4})
    part.interfaces.push_back({x == 0.0 ? "a" : "b",
                               Tie::node,
                               {},
                               nodes_where(part.mesh,
                                           [=](const Eigen::Vector3d& p) {
                                             return (p - Eigen::Vector3d(x, 0.1, 0.0)).norm() < 1e-9;
                                           }),
                               {0, 1, 2}});
  EXPECT_THAT(refusal(part),
              AllOf(HasSubstr("leave the body free to move (1 of six rigid motions), for instance a "
                              "rotation about the axis (1, 0, 0) through (0, 0.1, 0) m"),
                    HasSubstr("add an interface or retain more directions")));
}

TEST(Refusals, InterfacesThatLeaveATranslation) {
  Part part = small_beam();
  part.interfaces[0].directions = {1, 2, 3, 4, 5};
  part.interfaces[1].directions = {1, 2};
  EXPECT_THAT(refusal(part), HasSubstr("for instance a translation along (1, 0, 0)"));
}

TEST(Refusals, LoosePieces) {
  Part part = small_beam();
  mesh::CellBlock& block = part.mesh.solids[0];
  const Eigen::Index n = part.mesh.points.rows();
  part.mesh.points.conservativeResize(n + 10, 3);
  for (int a = 0; a < 10; ++a)
    part.mesh.points.row(n + a) = part.mesh.points.row(block.nodes(0, a)) + Eigen::RowVector3d(0, 0, 1);
  block.nodes.conservativeResize(block.nodes.rows() + 1, 10);
  for (int a = 0; a < 10; ++a) block.nodes(block.nodes.rows() - 1, a) = static_cast<int>(n) + a;
  EXPECT_THAT(refusal(part),
              AllOf(HasSubstr("falls into 2 pieces that nothing joins; the smallest has 10 nodes"),
                    HasSubstr("fuse the solids")));
}

// A second block that touches the first in one node can turn about it.
TEST(Refusals, SolidsThatTouchInOneNodeAreNamedByNodeAndDirection) {
  Part part = beam({0.4, 0.1, 0.1}, {4, 2, 2}, CellType::tet4, Tie::rigid, Tie::rigid);
  mesh::CellBlock& block = part.mesh.solids[0];
  const Eigen::Index n = part.mesh.points.rows();
  Eigen::Index corner = 0;
  for (Eigen::Index a = 0; a < n; ++a)
    if ((part.mesh.points.row(a) - Eigen::RowVector3d(0.2, 0.1, 0.1)).norm() < 1e-9) corner = a;
  part.mesh.points.conservativeResize(n + 3, 3);
  for (int a = 0; a < 3; ++a)
    part.mesh.points.row(n + a) =
        part.mesh.points.row(corner) + 0.1 * (Eigen::RowVector3d::Unit(a) + Eigen::RowVector3d(0, 0, 0.1));
  block.nodes.conservativeResize(block.nodes.rows() + 1, 4);
  block.nodes.bottomRows(1) << static_cast<int>(corner), static_cast<int>(n), static_cast<int>(n) + 1,
      static_cast<int>(n) + 2;
  EXPECT_THAT(refusal(part), AllOf(HasSubstr("can move without strain, noticed at node"),
                                   HasSubstr("look for solids that touch in a single node or edge")));
}

TEST(Refusals, InvertedCellsAreNamed) {
  Part part = small_beam();
  mesh::CellBlock& block = part.mesh.solids[0];
  for (Eigen::Index e = 0; e < block.nodes.rows(); ++e) block.label.push_back(1000 + e);
  std::swap(block.nodes(7, 0), block.nodes(7, 1));
  EXPECT_THAT(refusal(part),
              HasSubstr("1 of 96 cells is inverted or flat (det J <= 0 at a quadrature point): cell "
                        "1007; mend the mesh"));
}

TEST(Refusals, MissingMaterial) {
  Part part = small_beam();
  part.mesh.solids[0].material.assign(96, 1);
  EXPECT_THAT(refusal(part), HasSubstr("a cell has material number 1, but the part has 1 material"));
}

// 600 shapes are taken in blocks: the integrals are those of all at once.
TEST(InertiaIntegrals, OfManyShapesAreTheProductsOfTheirDirections) {
  const Part part = testing::beam({0.4, 0.1, 0.1}, {3, 2, 2}, mesh::CellType::hex8, Tie::rigid, Tie::rigid);
  const TiedModel model(part);
  const Eigen::MatrixXd T = testing::random_matrix(3 * model.n_nodes(), 600), m = testing::dense(model.m());
  const InertiaIntegrals s = inertia_integrals(model.m(), part.mesh.points, T);
  const auto along = [&](int a) {
    return Eigen::MatrixXd(T(Eigen::seqN(a, model.n_nodes(), 3), Eigen::all));
  };
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (int k = 0; k < 6; ++k) {
    const Eigen::MatrixXd exact = along(kPairs[k][0]).transpose() * m * along(kPairs[k][1]);
    EXPECT_LT((s.S_phiphi[k] - exact).norm(), 1e-13 * exact.norm()) << k;
  }
}

}  // namespace
}  // namespace flexura::reduce
