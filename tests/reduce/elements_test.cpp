// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "mesh/model/cells/record.hpp"
#include "mesh/model/geometry.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/elements/solid.hpp"
#include "reduce/elements/surface.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using mesh::CellType;

struct Kind {
  CellType type;
  Formulation formulation = Formulation::standard;
};

std::string name_of_kind(const ::testing::TestParamInfo<Kind>& info) {
  const char* const of[] = {"", "Enhanced", "Reduced", "MeanVolume"};
  return std::string(mesh::name_of(info.param.type)) + of[static_cast<int>(info.param.formulation)];
}

/// Every solid cell there is, and the other formulations.
std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds = {{CellType::hex8, Formulation::enhanced},
                             {CellType::hex8, Formulation::reduced},
                             {CellType::hex8, Formulation::mean_volume},
                             {CellType::hex20, Formulation::reduced}};
  for (const mesh::CellRecord& record : mesh::cell_records())
    if (record.is_solid()) kinds.push_back({record.type});
  return kinds;
}

// A block of two cells each way whose nodes are shaken, so that no two cells are alike.
mesh::Mesh shaken_block(CellType type, bool straight) {
  mesh::Mesh mesh = box({0.3, 0.2, 0.25}, {2, 2, 2}, type);
  deform(
      mesh,
      [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
        const Eigen::Vector3d shake(std::sin(31 * x(0) + 17 * x(1) + 5 * x(2)),
                                    std::sin(13 * x(0) - 29 * x(1) + 7 * x(2) + 1.0),
                                    std::cos(11 * x(0) + 19 * x(1) - 23 * x(2)));
        return x + 0.012 * shake;
      },
      straight);
  return mesh;
}

Part free_part(mesh::Mesh mesh, Formulation formulation) {
  Part part;
  part.mesh = std::move(mesh);
  part.materials = {steel()};
  part.formulation = formulation;
  return part;
}

AssemblyOptions free_body() {
  AssemblyOptions options;
  options.may_be_free = true;
  options.shift = 1e-300;
  return options;
}

class SolidElements : public ::testing::TestWithParam<Kind> {};

// A linear displacement field is in the element's space whatever its shape (straight edges), so interior
// nodes are in balance and the energy is exact.  Round-off: sums of about 100 products, each 1e-16 of the
// largest force.
TEST_P(SolidElements, DistortedPatchIsInConstantStrain) {
  const Part part = free_part(shaken_block(GetParam().type, true), GetParam().formulation);
  const TiedModel model(part, free_body());
  Eigen::Matrix3d gradient;
  gradient << 0.3, -0.7, 0.2, 0.5, 0.9, -0.4, -0.1, 0.6, -0.8;
  gradient *= 1e-3;
  Eigen::MatrixXd u(model.n_i(), 1), f;
  for (int a = 0; a < model.n_nodes(); ++a)
    u.block<3, 1>(3 * a, 0) = gradient * part.mesh.points.row(a).transpose();
  model.K_ii().multiply(u, f);
  Eigen::Matrix<double, 6, 1> strain;
  strain << gradient(0, 0), gradient(1, 1), gradient(2, 2), gradient(0, 1) + gradient(1, 0),
      gradient(1, 2) + gradient(2, 1), gradient(2, 0) + gradient(0, 2);
  const double volume = mesh::measure_volume(part.mesh).volume;
  const double energy = 0.5 * strain.dot(part.materials[0].D * strain) * volume;
  EXPECT_NEAR(0.5 * (u.transpose() * f)(0, 0) / energy, 1.0, 1e-12);
  std::vector<char> outer(model.n_nodes(), 0);
  for (const auto& block : part.mesh.boundary)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) outer[block.nodes.data()[k]] = 1;
  const double largest = f.cwiseAbs().maxCoeff();
  int n_inner = 0;
  for (int a = 0; a < model.n_nodes(); ++a) {
    if (outer[a]) continue;
    ++n_inner;
    EXPECT_LT((f.block<3, 1>(3 * a, 0).norm()), 1e-12 * largest) << "node " << a;
  }
  EXPECT_GT(n_inner, 0);
}

// Curved cells as well.
TEST_P(SolidElements, RigidMotionsAreStrainFreeAndNothingElseIs) {
  for (const bool straight : {true, false}) {
    const Part part = free_part(shaken_block(GetParam().type, straight), GetParam().formulation);
    const TiedModel model(part, free_body());
    Eigen::MatrixXd f;
    model.K_ii().multiply(model.motions().rigid_nodes(), f);
    const Eigen::MatrixXd K = dense(model.K_ii());
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-14 * 81 * K.cwiseAbs().maxCoeff());
    const Eigen::VectorXd values = linalg::symmetric_eigen(K).values;
    EXPECT_LT(values.head(6).cwiseAbs().maxCoeff(), 1e-12 * values.maxCoeff());
    EXPECT_GT(values(6), 1e-6 * values.maxCoeff());  // no hour-glass modes
  }
}

TEST_P(SolidElements, MassMatrixHasTheMassCentreAndInertiaOfTheCurvedCells) {
  const Part part = free_part(shaken_block(GetParam().type, false), GetParam().formulation);
  const TiedModel model(part, free_body());
  const Eigen::MatrixXd m = dense(model.m());
  const mesh::Volumes volumes = mesh::measure_volume(part.mesh);
  const double rho = part.materials[0].density, mass = rho * volumes.volume;
  EXPECT_NEAR(m.sum() / mass, 1.0, 1e-12);
  const Eigen::Vector3d S_x = part.mesh.points.transpose() * m.rowwise().sum();
  EXPECT_LT((S_x - mass * volumes.centroid).norm(), 1e-12 * mass * 0.3);
  const Eigen::Matrix3d S_xx = part.mesh.points.transpose() * m * part.mesh.points;
  const Eigen::Matrix3d about_origin = S_xx.trace() * Eigen::Matrix3d::Identity() - S_xx;
  const Eigen::Vector3d c = volumes.centroid;
  const Eigen::Matrix3d expected =
      rho * volumes.inertia + mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  EXPECT_LT((about_origin - expected).norm(), 1e-12 * expected.norm());
  EXPECT_GT(linalg::symmetric_eigen(m).values(0), 0.0);
}

TEST_P(SolidElements, LumpedMassIsPositiveAndSumsToTheTotal) {
  Part part = free_part(shaken_block(GetParam().type, true), GetParam().formulation);
  part.mass = MassKind::lumped;
  const TiedModel model(part, free_body());
  const Eigen::MatrixXd m = dense(model.m());
  const double mass = part.materials[0].density * mesh::measure_volume(part.mesh).volume;
  EXPECT_GT(m.diagonal().minCoeff(), 0.0);
  EXPECT_EQ((m - Eigen::MatrixXd(m.diagonal().asDiagonal())).norm(), 0.0);
  EXPECT_NEAR(m.sum() / mass, 1.0, 1e-12);
}

// A cantilever under an end moment bends into a circle: with one layer of cells, l/h = 10, sideways
// contraction free. Euler-Bernoulli's tip deflection M l^2 / (2 E I) is exact up to the clamped end (rigid
// face), where contraction is suppressed over a length of about h / 2: 2 percent.
TEST(Bending, EnhancedBricksBendAndPlainOnesLock) {
  const double l = 1.0, h = 0.1, E = 2.1e11;
  const auto deflection = [&](Formulation formulation) {
    Part part = beam({l, h, h}, {10, 1, 1}, CellType::hex8, Tie::rigid, Tie::average);
    part.formulation = formulation;
    const Eigen::MatrixXd compliance = full_static_compliance(part, "left", "right");
    return compliance(6 + 2, 4);  // u_z for a moment about y, whose positive sense lowers the tip
  };
  const double exact = -l * l / (2.0 * E * h * h * h * h / 12.0);
  EXPECT_NEAR(deflection(Formulation::enhanced) / exact, 1.0, 0.02);
  EXPECT_LT(deflection(Formulation::standard) / exact, 0.75);
}

// Abaqus' own cantilever (Getting Started with Abaqus, "Choosing the shape and number of elements": 150 x 2.5 x 5 mm, nu = 0): the tip's
// deflection over beam theory, with layers x elements along it, by C3D8R and by C3D8.  Layers of uniform strains bend as plates that slide
// on one another, 1 - 1/n^2 of the whole, and what holds hourglasses; C3D8 locks in shear.  Within a unit of the printed digits, of C3D8R
// within five: the end is held otherwise, and the hourglass stiffness is known to a digit.
TEST(Bending, BricksOfAbaqusBendAsThere) {
  const double l = 0.15, h = 0.005, b = 0.0025, E = 70e9;
  const struct {
    int layers, along;
    double reduced, whole;
  } rows[] = {{1, 6, 0.0, 0.077}, {2, 12, 1.323, 0.248}, {4, 12, 1.063, 0.243}, {8, 24, 1.015, 0.563}};
  for (const auto& row : rows) {
    const auto deflection = [&](Formulation formulation) {
      Part part = beam({l, b, h}, {row.along, 1, row.layers}, CellType::hex8, Tie::rigid, Tie::average);
      part.materials = {isotropic("nu 0", E, 0.0, 2700.0)};
      part.formulation = formulation;
      return full_static_compliance(part, "left", "right")(6 + 2, 2) * 3.0 * E * (b * h * h * h / 12.0) /
             (l * l * l);
    };
    EXPECT_NEAR(deflection(Formulation::mean_volume), row.whole, 1e-3) << row.layers;
    if (row.layers > 1) {  // a single layer bends against nothing but the hourglass stiffness
      EXPECT_NEAR(deflection(Formulation::reduced), row.reduced, 5e-3) << row.layers;
    }
  }
}

// A nearly incompressible block that is pressed between rigid ends: where the volume's change is its mean over each brick, it stays as
// soft as the deviator lets it be; element by element it locks.
TEST(Bending, MeanVolumeBricksBulgeWhereOthersLock) {
  const auto stiffness = [&](Formulation formulation, double nu) {
    Part part = beam({0.2, 0.1, 0.1}, {8, 4, 4}, CellType::hex8, Tie::rigid, Tie::rigid);
    part.materials = {isotropic("rubber", 3e6 * (1.0 + nu) / 1.5, nu, 1000.0)};  // G = 1 MPa
    part.formulation = formulation;
    return 1.0 / full_static_compliance(part, "left", "right")(6 + 1, 1);  // bent and sheared sideways
  };
  const double soft = stiffness(Formulation::enhanced, 0.49);
  EXPECT_LT(stiffness(Formulation::mean_volume, 0.49999) / soft, 1.3);
  EXPECT_GT(stiffness(Formulation::standard, 0.49999) / soft, 1.3);
}

INSTANTIATE_TEST_SUITE_P(Types, SolidElements, ::testing::ValuesIn(all_kinds()), name_of_kind);

TEST(SurfaceIntegrals, MassOfAPlaneFaceIntegratesQuadraticsExactly) {
  // The face z = c of a box: integral of x^2 y^2 over [0, a] x [0, b] is (a b)^3 / 9; x y is in the space of
  // tri6.
  const double a = 0.7, b = 0.4;
  const mesh::Mesh mesh = box({a, b, 0.2}, {3, 2, 1}, CellType::tet10);
  const mesh::NodeSet face = nodes_where(mesh, [](const Eigen::Vector3d& x) { return x(2) > 0.2 - 1e-12; });
  const Eigen::SparseMatrix<double> W = surface_mass(mesh, face.faces, face.nodes);
  Eigen::VectorXd xy(face.nodes.size());
  for (std::size_t k = 0; k < face.nodes.size(); ++k)
    xy(static_cast<Eigen::Index>(k)) = mesh.points(face.nodes[k], 0) * mesh.points(face.nodes[k], 1);
  EXPECT_NEAR(xy.dot(W * xy) / (std::pow(a * b, 3) / 9.0), 1.0, 1e-13);
  const Eigen::MatrixXd load = pressure_load(mesh, mesh.boundary);
  EXPECT_LT(load.colwise().sum().norm(), 1e-14);  // a closed surface under uniform pressure is in balance
}

TEST(Materials, OrthotropicWithEqualConstantsIsIsotropic) {
  const Material iso = isotropic("a", 3e9, 0.25, 1000.0);
  const double G = 3e9 / 2.5;
  const Material ortho = orthotropic("b", {3e9, 3e9, 3e9, 0.25, 0.25, 0.25, G, G, G}, 1000.0);
  EXPECT_LT((iso.D - ortho.D).norm(), 1e-14 * iso.D.norm());
}

// Pulled at an angle to its fibres: 1/E(a) = cos^4 a / E_x + sin^4 a / E_y + (1/G_xy - 2 nu_xy/E_x) sin^2 a
// cos^2 a (S. G. Lekhnitskii, Theory of Elasticity of an Anisotropic Body, section 9).  Round-off only.
TEST(Materials, TurnedPlyHasTheOffAxisModulus) {
  const OrthotropicConstants c{130e9, 9e9, 11e9, 0.28, 0.4, 0.02, 5e9, 3e9, 4e9};
  const double a = 0.4;
  Eigen::Matrix3d R;  // the fibres lie at a to the mesh's x
  R << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1;
  const Material ply = turned(orthotropic("ply", c, 1600), R);
  const double C2 = std::pow(std::cos(a), 2), S2 = std::pow(std::sin(a), 2);
  const double compliance = C2 * C2 / c.E_x + S2 * S2 / c.E_y + (1 / c.G_xy - 2 * c.nu_xy / c.E_x) * S2 * C2;
  EXPECT_NEAR(ply.D.inverse().eval()(0, 0) / compliance, 1.0, 1e-12);
  EXPECT_LT((ply.D - ply.D.transpose()).norm(), 1e-15 * ply.D.norm());
  const Material back = turned(ply, R.transpose());
  EXPECT_LT((back.D - orthotropic("ply", c, 1600).D).norm(), 1e-14 * ply.D.norm());
}

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(Materials, ValuesOutOfRangeAreRefused) {
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal([] { isotropic("steel", 2e11, 0.5, 7850); }),
              HasSubstr("material 'steel': Poisson's ratio is 0.5, but it must lie above -1 and below 0.5"));
  EXPECT_THAT(refusal([] { isotropic("steel", 2e11, 0.3, -7850); }),
              HasSubstr("the density is -7850 kg/m^3, but it must be positive"));
  EXPECT_THAT(refusal([] { isotropic("steel", 0, 0.3, 7850); }), HasSubstr("Young's modulus is 0 Pa"));
  EXPECT_THAT(refusal([] { isotropic("steel", std::nan(""), 0.3, 7850); }),
              HasSubstr("Young's modulus is nan"));
  EXPECT_THAT(refusal([] {
                orthotropic("ply", {1e9, 1e9, 1e9, 0.9, 0.9, 0.9, 1e9, 1e9, 1e9}, 1);
              }),
              HasSubstr("not be positive definite"));
}

}  // namespace
}  // namespace flexura::reduce
