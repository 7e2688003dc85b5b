// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/mesh_error.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/estimate/enriched_error.hpp"
#include "reduce/estimate/enrichment.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::MatrixXd;
using Eigen::Vector3d;

const Vector3d kSize(1.0, 0.23, 0.17);

// Displacements of all nodes by a field.
MatrixXd nodal(const mesh::Mesh& mesh, const std::function<Vector3d(const Vector3d&)>& field) {
  MatrixXd T(3 * static_cast<Eigen::Index>(mesh.n_nodes()), 1);
  for (mesh::Index node = 0; node < mesh.n_nodes(); ++node)
    T.middleRows<3>(3 * static_cast<Eigen::Index>(node)) = field(mesh.points.row(node));
  return T;
}

Vector3d linear_field(const Vector3d& x) {
  return {1e-3 * x(0) + 2e-3 * x(1), -4e-4 * x(2), 5e-4 * x(0) - 3e-4 * x(1) + 1e-4 * x(2)};
}

Vector3d quadratic_field(const Vector3d& x) {
  return {1e-3 * x(0) * x(1) + 2e-3 * x(2) * x(2), -4e-4 * x(2) * x(0),
          5e-4 * x(0) * x(0) - 3e-4 * x(1) * x(2)};
}

// Twice the energy of the field, exactly integrated on the box: what errors are measured by.
double energy_of(const Part& part, const MatrixXd& T) {
  const TiedModel model(part, AssemblyOptions{.may_be_free = true});
  MatrixXd K_U, f_b, f_i,
      U_i = model.motions().interior_part(T, MatrixXd(0, 1), {MatrixXd::Zero(6, 1), MatrixXd::Zero(6, 1)});
  model.K_ii().multiply(U_i, K_U);
  return (U_i.transpose() * K_U)(0, 0);
}

// Stress of first degree is in the recovered space of every element, and in the elements of second degree themselves:
// nothing is left.  1e-10: the recovered stresses are kept to 7 digits, their error's square is left.
TEST(MeshError, OfAFieldThatTheMeshHoldsIsZero) {
  using mesh::CellType;
  for (const CellType type : {CellType::tet4, CellType::tet10, CellType::hex8, CellType::hex20,
                              CellType::wedge6, CellType::wedge15}) {
    Part part = beam(kSize, {5, 2, 2}, type, Tie::average, Tie::average);
    const bool quadratic = type == CellType::tet10 || type == CellType::hex20 || type == CellType::wedge15;
    const MatrixXd T = nodal(part.mesh, quadratic ? quadratic_field : linear_field);
    EXPECT_LT(recovered_energy(part, T, {}).energy(0), 1e-10 * energy_of(part, T)) << mesh::name_of(type);
  }
}

// On a regular grid of bricks the stress at the middle of a cell is exact for displacements of second degree
// (superconvergence), so the recovered stress is the exact one and the estimate the exact error: that of
// u_x = c x y / ..., integrated here by hand.  In a cell of h_x, h_y, h_z the interpolant of c x^2 along x has the
// stress error E' c (2 x - its mean), whose square integrates to (2 c)^2 D_11 h_x^2 / 12 over the volume, with
// energy density s^T C s.
TEST(MeshError, OfAParabolaOnBricksIsExact) {
  Part part = beam(kSize, {6, 3, 3}, mesh::CellType::hex8, Tie::average, Tie::average);
  const double c = 1e-3, h = kSize(0) / 6;
  const MatrixXd T = nodal(part.mesh, [&](const Vector3d& x) { return Vector3d(c * x(0) * x(0), 0.0, 0.0); });
  const double exact = 4 * c * c * part.materials[0].D(0, 0) * h * h / 12 * kSize.prod();
  EXPECT_NEAR(recovered_energy(part, T, {}).energy(0), exact,
              1e-5 * exact);  // digits of the float that keeps stresses
}

TEST(MeshError, HasNoPartOfRigidMotions) {
  Part part = beam(kSize, {5, 2, 2}, mesh::CellType::tet10, Tie::rigid, Tie::rigid);
  MatrixXd T(3 * static_cast<Eigen::Index>(part.mesh.n_nodes()), 2);
  T << nodal(part.mesh, [](const Vector3d& x) { return Vector3d(-x(1), x(0), 0.0); }),
      nodal(part.mesh, quadratic_field);
  const double energy = energy_of(part, 1e3 * T.col(1));
  EXPECT_LT(recovered_energy(part, T, {}).energy(0), 1e-12 * energy);
  // Forces are kept to seven digits; the strains that they come from are free of the motion.
  EXPECT_LT(enriched_energy(part, T, Eigen::VectorXd::Zero(2), {}, {}).energy(0), 1e-12 * energy);
}

// Gained functions are zero at nodes, and their derivatives are those of their values (central differences: 1e-6 steps
// leave 1e-10).
TEST(MeshError, EnrichmentsVanishAtNodes) {
  using mesh::CellType;
  for (const CellType type : {CellType::tet4, CellType::tet10, CellType::hex8, CellType::hex20,
                              CellType::wedge6, CellType::wedge15}) {
    const auto& nodes = mesh::reference_nodes(type);
    for (Eigen::Index a = 0; a < nodes.rows(); ++a) {
      const bool linear = nodes.rows() == mesh::shape_of(type).corners;
      if (a < mesh::shape_of(type).corners || !linear) {
        EXPECT_LT(evaluate_enrichment(type, nodes.row(a)).w.cwiseAbs().maxCoeff(), 1e-14)
            << mesh::name_of(type);
      }
    }
    const Vector3d x(0.21, 0.33, 0.17);
    const EnrichmentValues at = evaluate_enrichment(type, x);
    for (int d = 0; d < 3; ++d) {
      const Vector3d h = 1e-6 * Vector3d::Unit(d);
      const Eigen::VectorXd slope =
          (evaluate_enrichment(type, x + h).w - evaluate_enrichment(type, x - h).w) / 2e-6;
      EXPECT_LT((slope - at.dw.col(d)).cwiseAbs().maxCoeff(), 1e-8) << mesh::name_of(type);
    }
  }
}

// Pure bending by moments at averaging ties has u of second degree, which linear cells enriched hold: the energy gained is
// then all that is missing, C_exact - C_h with C = L / (E I).  Conjugate gradients stop where further steps
// would gain 5 % by how the last ones fall off.
TEST(MeshError, OfPureBendingOnBricksIsAllThatIsMissing) {
  const Part part = beam(kSize, {6, 2, 2}, mesh::CellType::hex8, Tie::average, Tie::average);
  ReductionOptions options;
  options.n_modes = 4;
  options.estimate_mesh = true;
  const Reduction r = craig_bampton(part, options);
  ASSERT_TRUE(r.mesh);
  const MatrixXd C = r.K_se.topLeftCorner(6, 6).inverse();
  const double I_y = kSize(1) * std::pow(kSize(2), 3) / 12, I_z = kSize(2) * std::pow(kSize(1), 3) / 12;
  const auto n_modes = static_cast<Eigen::Index>(r.mesh->modes.size());
  for (const auto& [direction, I] : {std::pair{4, I_y}, std::pair{5, I_z}}) {
    const double exact = kSize(0) / (2.1e11 * I), missing = exact / C(direction, direction) - 1.0,
                 estimate = r.mesh->by_cell.col(n_modes + direction).sum();
    // Its Poisson strains are held nowhere: the tie is an average.
    EXPECT_GT(estimate, 0.9 * missing) << direction << ": " << estimate << " of " << missing;
    EXPECT_LT(estimate, 1.07 * missing) << direction << ": " << estimate << " of " << missing;
  }
}

struct Case {
  mesh::CellType type;
  std::array<int, 3> n;
  double least, most;  // estimate over truth
};
class MeshErrorOfModes : public ::testing::TestWithParam<Case> {};

// Against the frequencies of a mesh whose own error is below a hundredth of the coarse ones' (20-node bricks, 24 along
// the beam).  0.5 to 2 is what an estimate is worth, also with a single cell across.
TEST_P(MeshErrorOfModes, IsThatOfTheFrequencies) {
  static const Eigen::VectorXd truth = [] {
    const Part fine = beam(kSize, {24, 6, 4}, mesh::CellType::hex20, Tie::average, Tie::average);
    return Eigen::VectorXd(full_free_modes(fine, 4, 1e8, {}, 1e-7).omega2);
  }();
  const Case& c = GetParam();
  const Part part = beam(kSize, c.n, c.type, Tie::average, Tie::average);
  const FreeModes modes = free_modes_on_nodes(part, {10, 0.0, 1e-7}, truth(6));
  const Eigen::VectorXd E =
      enriched_energy(part, modes.U.leftCols(10), modes.pairs.omega2.head(10).cwiseMax(0.0), {}, {}).energy;
  for (int k = 6; k < 10; ++k) {
    const double lambda = modes.pairs.omega2(k), error = (lambda - truth(k)) / lambda,
                 estimate = E(k) / lambda;
    SCOPED_TRACE(::testing::Message() << mesh::name_of(c.type) << " mode " << k - 5 << ": true " << error
                                      << ", estimate " << estimate);
    EXPECT_GT(estimate, c.least * error);
    EXPECT_LT(estimate, c.most * error);
  }
}

INSTANTIATE_TEST_SUITE_P(Beams, MeshErrorOfModes,
                         ::testing::Values(Case{mesh::CellType::tet10, {6, 2, 2}, 0.5, 2.0},
                                           Case{mesh::CellType::tet10, {4, 1, 1}, 0.5, 2.0},
                                           Case{mesh::CellType::hex20, {8, 2, 2}, 0.5, 2.0},
                                           Case{mesh::CellType::hex20, {4, 1, 1}, 0.5, 2.0},
                                           Case{mesh::CellType::hex8, {16, 4, 4}, 0.5, 2.0},
                                           Case{mesh::CellType::hex8, {8, 2, 2}, 0.5, 2.0},
                                           Case{mesh::CellType::tet4, {24, 6, 4}, 0.5, 2.0},
                                           Case{mesh::CellType::wedge15, {10, 2, 2}, 0.5, 2.0},
                                           Case{mesh::CellType::wedge15, {5, 1, 1}, 0.5, 2.0}));

}  // namespace
}  // namespace flexura::reduce
