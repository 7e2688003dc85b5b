// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/modal_basis.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/test_folder.hpp"

/// Markers on several nodes: interpolation (RBE3) and rigid links (RBE2).
namespace flexura::mbs {
namespace {

using checks::Random;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

// Shapes of the surface are stored in single precision.
constexpr double kSingle = 6e-8;

/// "Shapes" that are the displacement fields u = a + G x, a and G by their twelve entries (a first, then G
/// row by row), at these places.
superelement::Superelement linear_fields(const MatrixXd& places) {
  superelement::Superelement se;
  se.n_q = 12;
  se.surface.vertices = places.transpose();
  se.shapes = Eigen::MatrixXf::Zero(3 * places.cols(), 12);
  for (int v = 0; v < places.cols(); ++v)
    for (int a = 0; a < 3; ++a) {
      se.shapes(3 * v + a, a) = 1.0f;
      for (int b = 0; b < 3; ++b) se.shapes(3 * v + a, 3 + 3 * a + b) = static_cast<float>(places(b, v));
    }
  return se;
}

NodePlaces all_vertices(const superelement::Superelement& se) {
  NodePlaces places;
  places.vertices.resize(se.surface.vertices.rows());
  std::iota(places.vertices.begin(), places.vertices.end(), 0);
  return places;
}

TEST(InterpolatedNode, AveragesALinearStrainFieldExactly) {
  // Corners of a cube about c: the mean displacement is that of the centre and the rotation half the curl,
  // while no strain turns it.
  const Vector3d c(0.5, -0.25, 1.0);
  MatrixXd corners(3, 8);
  for (int k = 0; k < 8; ++k)
    corners.col(k) = c + 0.125 * Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);  // exact in float
  const superelement::Superelement se = linear_fields(corners);
  const BodyNode node = interpolated_node(se, "x", all_vertices(se));
  EXPECT_LT((node.p_BoN_B - c).norm(), 1e-15);
  Random random(2);
  const Vector3d a = random.vector3();
  Matrix3d G;
  for (int i = 0; i < 3; ++i) G.row(i) = random.vector3();
  VectorXd x(12);
  x << a, G.row(0).transpose(), G.row(1).transpose(), G.row(2).transpose();
  const Vector6d q = node.rows * x;
  EXPECT_LT((q.head<3>() - (a + G * c)).norm(), 1e-14);
  const Vector3d half_curl = 0.5 * Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
  EXPECT_LT((q.tail<3>() - half_curl).norm(), 1e-14);
}

TEST(InterpolatedNode, FollowsRigidMotionAndWeighs) {
  Random random(3);
  MatrixXd places(3, 5);
  for (int k = 0; k < 5; ++k) places.col(k) = random.vector3().cast<float>().cast<double>();
  const superelement::Superelement se = linear_fields(places);
  NodePlaces chosen = all_vertices(se);
  chosen.weights = {1.0, 2.0, 0.5, 3.0, 1.5};
  const BodyNode node = interpolated_node(se, "x", chosen);
  // u = a + theta x x, by the skew G.
  for (int k = 0; k < 3; ++k) {
    VectorXd x = VectorXd::Zero(12);
    const Matrix3d G = skew(Vector3d::Unit(k));
    x.tail(9) << G.row(0).transpose(), G.row(1).transpose(), G.row(2).transpose();
    Vector6d expected;
    expected << Vector3d::Unit(k).cross(node.p_BoN_B), Vector3d::Unit(k);
    EXPECT_LT((node.rows * x - expected).norm(), 1e-13);  // ten times the condition of five random places
  }
  // The weighted mean, whatever the rest.
  const VectorXd any = random.vector(12);
  Vector3d mean = Vector3d::Zero();
  for (int v = 0; v < 5; ++v)
    mean += chosen.weights[v] / 8.0 * (se.shapes.middleRows(3 * v, 3).cast<double>() * any);
  EXPECT_LT((node.rows.topRows<3>() * any - mean).norm(), 1e-14);
}

TEST(InterpolatedNode, LoadsAreStaticallyEquivalent) {
  const superelement::Superelement se = lattice::with_surface(lattice::make_lattice(3));
  const BodyNode node = interpolated_node(se, "x", {{0}, {9, 14, 22}, {}});
  EXPECT_FALSE(node.is_on_interfaces);
  const Vector3d offset(0.1, 0.3, -0.2);
  const MatrixXd P = node_loads(node, offset), R = superelement::rigid_motions(se);
  // Work on rigid motions: force, and torque about Bo.
  Matrix6d resultant = Matrix6d::Zero();
  resultant.bottomLeftCorner<3, 3>().setIdentity();
  resultant.topRightCorner<3, 3>().setIdentity();
  resultant.bottomRightCorner<3, 3>() = skew(node.p_BoN_B + offset);
  EXPECT_LT((R.transpose() * P - resultant).norm(), 20.0 * kSingle);  // condition of four places
}

TEST(InterpolatedNode, NeedsThreePlacesThatAreNotOnALine) {
  const superelement::Superelement se = lattice::with_surface(lattice::make_lattice(3));
  const auto refusal = [&](const NodePlaces& places) {
    return test::refusal_of([&] { interpolated_node(se, "x", places); });
  };
  EXPECT_THAT(refusal({{0, 1}, {}, {}}),
              HasSubstr("its 2 places determine 5 of its six motions; give at least"));
  EXPECT_THAT(refusal({{}, {0, 6, 12}, {}}), HasSubstr("its 3 places determine 5"));  // i runs along a line
  EXPECT_THAT(refusal({{}, {4}, {}}), HasSubstr("its 1 places determine 3"));
}

// Between the ends of a beam that nothing else loads, the cubic is the beam's own: as an interface there moves in the finite-element
// model.  A marker beside the axis moves rigidly with its section.
TEST(BeamNode, MovesAsTheBeamBetweenItsEnds) {
  Random random(5);
  beams::StraightBeam b;
  b.EA = 7e3, b.GI_t = 3.0, b.EI_y = 5.0, b.EI_z = 11.0, b.length = 1.3;
  b.elements = 12, b.between = 2;
  const superelement::Superelement se = beams::beam_superelement(b);
  const auto place = [&](const char* name) {
    return static_cast<int>(std::ranges::find(se.interfaces, name, &superelement::Interface::name) -
                            se.interfaces.begin());
  };
  const int root = place("root"), tip = place("tip");
  for (int trial = 0; trial < 50; ++trial) {
    // Any motion of the ends; what lies between follows without load.
    VectorXd u = VectorXd::Zero(se.n());
    std::vector<int> given, open;
    for (int i = 0; i < se.n(); ++i) {
      const int r = i - se.interfaces[root].first_dof, t = i - se.interfaces[tip].first_dof;
      ((r >= 0 && r < 6) || (t >= 0 && t < 6) ? given : open).push_back(i);
    }
    for (const int i : given) u(i) = random.vector3().x();
    const MatrixXd K = se.K_se(open, open);
    u(open) = -K.ldlt().solve(se.K_se(open, given) * u(given));
    for (const char* name : {"p1", "p2"}) {
      const BodyNode at = interface_node(se, place(name));
      const BodyNode node = beam_node(se, "m", root, tip, at.p_BoN_B);
      // Round-off of a stiffness matrix whose entries differ by 1e4.
      EXPECT_LT((node.rows * u - at.rows * u).norm(), 1e-9) << name;
      const Vector3d beside = at.p_BoN_B + Vector3d(0, 0.1, -0.2);
      const BodyNode off = beam_node(se, "m", root, tip, beside);
      const Vector3d turn = (at.rows * u).tail<3>();
      EXPECT_LT(
          (off.rows.topRows<3>() * u - (at.rows * u).head<3>() - turn.cross(Vector3d(0, 0.1, -0.2))).norm(),
          1e-9);
    }
  }
  EXPECT_THROW(beam_node(se, "m", root, tip, Vector3d(1.5, 0, 0)), std::invalid_argument);
  EXPECT_THROW(beam_node(se, "m", root, root, Vector3d::Zero()), std::invalid_argument);
}

TEST(RigidLink, IsTheConstrainedEigenvalueProblem) {
  // Both faces in one rigid piece, by hand: u_b = D q, the modes free.
  const lattice::Lattice l = lattice::make_lattice(9);
  BasisOptions options;
  options.nodes = {rigidly_linked_node(l.se, "link", {0, 1})};
  EXPECT_EQ(options.nodes[0].ties.cols(), 6);
  BasisReport report;
  const ModalData data = modal_data(l.se, options, &report);
  const int n = l.se.n();
  MatrixXd Z = MatrixXd::Zero(n, n - 6);
  const Vector3d centre = 0.5 * (l.se.interfaces[0].p_BoN_B + l.se.interfaces[1].p_BoN_B);
  for (int i = 0; i < 2; ++i) {
    Z.block<6, 6>(6 * i, 0).setIdentity();
    Z.block<3, 3>(6 * i, 3) = -skew(l.se.interfaces[i].p_BoN_B - centre);
  }
  Z.bottomRightCorner(n - 12, n - 12).setIdentity();
  const VectorXd exact = Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(Z.transpose() * l.se.K_se * Z,
                                                                            Z.transpose() * l.se.M_se * Z)
                             .eigenvalues();
  ASSERT_EQ(data.stiffness.size(), n - 12);
  for (int k = 0; k < n - 12; ++k) EXPECT_NEAR(data.stiffness(k), exact(6 + k), 1e-9 * exact(6 + k)) << k;
  // The marker and both interfaces move as one piece.
  ASSERT_EQ(data.nodes.size(), 3u);
  const double size = data.nodes[2].Phi_t.norm();
  for (int i = 0; i < 2; ++i) {
    const Vector3d r = l.se.interfaces[i].p_BoN_B - centre;
    EXPECT_LT((data.nodes[i].Phi_r - data.nodes[2].Phi_r).norm(), 1e-11 * size);
    EXPECT_LT((data.nodes[i].Phi_t - data.nodes[2].Phi_t + skew(r) * data.nodes[2].Phi_r).norm(),
              1e-11 * size);
  }
  // Response modes stay within the link, and a joint may hold it.
  options.modes = 3;
  options.loads = node_loads(options.nodes[0]);
  options.frame = options.held = node_loads(options.nodes[0]);
  const ModalData held = modal_data(l.se, options);
  EXPECT_LT((options.nodes[0].ties.transpose() * held.Y).norm(), 1e-10 * held.Y.norm());
  EXPECT_LT((held.nodes[2].Phi_t.norm() + held.nodes[2].Phi_r.norm()), 1e-9 * held.Y.norm());
}

TEST(InterpolatedNode, OfInterfacesTakesTheirShareOfTheStiffening) {
  // Linear in the load: a unit load on the node is its shares on the interfaces.
  lattice::Lattice l = lattice::make_lattice(3);
  l.se.stiffening = lattice::any_stiffening(l.se.n(), 9);
  BasisOptions options;
  options.stiffening = true;
  BodyNode node = interface_node(l.se, 0);
  node.rows = 0.25 * node.rows + 0.75 * interface_node(l.se, 1).rows;
  options.nodes = {node};
  const ModalData data = modal_data(l.se, options);
  const MatrixXd share = 0.25 * data.nodes[0].second + 0.75 * data.nodes[1].second;
  EXPECT_LT((data.nodes[2].second - share).norm(), 1e-13 * share.norm());
}

}  // namespace
}  // namespace flexura::mbs
