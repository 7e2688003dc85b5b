// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Parts of other programs through the part file: decks with their materials, ties and masses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/superelement/file.hpp"
#include "reduce/app/write_reduced.hpp"
#include "reduce/assembly/point_mass.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/part/make_part.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const std::filesystem::path kDecks = std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/mesh/data";

class ForeignPart : public ::testing::Test {
 protected:
  ForeignPart() {
    folder_ = std::filesystem::temp_directory_path() / ("flexura_foreign_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~ForeignPart() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  ModelledPart part(const std::string& deck, const std::string& rest) const {
    const auto path = deck.find('/') == std::string::npos ? kDecks / deck : std::filesystem::path(deck);
    const PartInput input =
        read_part(put("part.toml", "[geometry]\nfile = \"" + path.string() + "\"\n" + rest));
    return make_part(input, load_part_mesh(input, {}));
  }
  std::string refusal(const std::string& deck, const std::string& rest) const {
    try {
      craig_bampton(part(deck, rest).part, {});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

// Deflection in y of the second tie's node under gravity along +y, the first clamped.
double tip_under_gravity(const Part& part, const std::string& clamped, const std::string& tip) {
  ReductionOptions options;
  options.n_modes = 0;
  LoadField gravity{.name = "gravity", .forces = {}, .acceleration = {}};
  gravity.acceleration = Eigen::RowVector3d(0, 9.81, 0).replicate(part.mesh.n_nodes(), 1);
  options.loads = {gravity};
  const Reduction se = craig_bampton(part, options);
  int held = -1, free = -1;
  for (const ReducedInterface& interface : se.interfaces) {
    if (interface.name == clamped) held = interface.first_dof;
    if (interface.name == tip) free = interface.first_dof;
  }
  EXPECT_GE(held, 0);
  EXPECT_GE(free, 0);
  EXPECT_EQ(se.n_b, 12);
  const Eigen::MatrixXd K = se.K_se.block(free, free, 6, 6);
  const Eigen::VectorXd p = se.loads[0].p_se.segment(free, 6);
  return K.ldlt().solve(p)(1);
}

// FEDEM's reducer on the same decks (six printed digits, so 5e-6 of the last): 1 m x 0.2 x 0.1, RBE2 spiders
// on both ends.  FEDEM's PENTA6 is a formulation of its own (1.86711e-5); the figure here is a wedge that
// passes the patch test, computed independently (reference collection of the project's founder).
struct Cantilever {
  const char* deck;
  double tip;
};

class FedemCantilever : public ForeignPart, public ::testing::WithParamInterface<Cantilever> {};

TEST_P(FedemCantilever, SagsAsPublished) {
  const ModelledPart modelled = part(GetParam().deck, "");
  ASSERT_EQ(modelled.n_interfaces, 2);
  // The clamped node has the lower number: the spider at z = 0 or z = 1, whichever holds node 8.
  const auto& interfaces = modelled.part.interfaces;
  const PartInput input = read_part(folder_ / "part.toml");
  const PartMesh from = load_part_mesh(input, {});
  ASSERT_EQ(from.ties.size(), 2u);
  const int low = from.ties[0].node < from.ties[1].node ? 0 : 1;
  const double tip = tip_under_gravity(modelled.part, interfaces[low].name, interfaces[1 - low].name);
  EXPECT_NEAR(tip / GetParam().tip, 1.0, 5e-6);
}

INSTANTIATE_TEST_SUITE_P(Decks, FedemCantilever,
                         ::testing::Values(Cantilever{"CHEXA08_.nas", 3.35442e-5},
                                           Cantilever{"CTETRA04_.nas", 1.87644e-5},
                                           Cantilever{"CPENTA06_.nas", 3.26748e-5}),
                         [](const auto& info) { return std::string(info.param.deck).substr(0, 6); });

const char* const kConrodBores = R"(
[interface.big_end]
by = "cylinder"
point = [0, 0, 0]
axis = [0, 0, 1]
radius = "5 mm"
[interface.small_end]
by = "cylinder"
point = [0, "80 mm", 0]
axis = [0, 0, 1]
radius = "5 mm"
)";

// A deck of hexahedra with its own steel: read, its bores found, reduced.
TEST_F(ForeignPart, AbaqusConrodIsReadAndReduced) {
  const ModelledPart modelled = part("job_matrix_generate_conrod.inp", kConrodBores);
  ReductionOptions options;
  options.n_modes = 6;
  options.certify = true;
  const Reduction se = craig_bampton(modelled.part, options);
  EXPECT_EQ(se.n_b, 12);
  EXPECT_EQ(se.report.certified_modes, se.n_q);
  const mesh::Volumes volumes = mesh::measure_volume(modelled.part.mesh);
  EXPECT_NEAR(se.inertia.mass / (7850.0 * volumes.volume), 1.0, 1e-12);
  const Eigen::VectorXd ours = reduced_free_modes(se);
  const linalg::EigenPairs full = full_free_modes(modelled.part, 3, ours(6));
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(ours(6 + k) / full.omega2(6 + k), 1.0 - 1e-8);
    EXPECT_LT(ours(6 + k) / full.omega2(6 + k), 1.01);
  }
}

TEST_F(ForeignPart, UnitsOfTheDeckScaleTheMass) {
  // The same numbers taken as mm and t: lengths 1e-3, mass 1e3, so densities 1e12 times.
  const ModelledPart si = part("job_matrix_generate_conrod.inp", kConrodBores);
  const PartInput input = read_part(
      put("mm.toml", "[geometry]\nfile = \"" + (kDecks / "job_matrix_generate_conrod.inp").string() +
                         "\"\nunit = \"mm\"\n[interface.all]\nby = \"nodes\"\nnodes = [1, 2, 3]\n"));
  const PartMesh mm = load_part_mesh(input, {});
  EXPECT_NEAR(mm.materials[0].density / si.part.materials[0].density, 1e12, 1.0);
  EXPECT_NEAR(mm.materials[0].D(0, 0) / si.part.materials[0].D(0, 0), 1e6, 1e-6);
  EXPECT_NEAR(mm.mesh.points.maxCoeff() / si.part.mesh.points.maxCoeff(), 1e-3, 1e-15);
}

TEST_F(ForeignPart, WhatTheDeckLacksIsNamed) {
  std::ifstream in(kDecks / "job_matrix_generate_conrod.inp");
  std::string deck((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::string no_density = deck;
  no_density.replace(no_density.find("*Density"), std::string("*Density").size(), "** Density");
  EXPECT_THAT(refusal(put("bare.inp", no_density).string(), kConrodBores), HasSubstr("density"));
  EXPECT_THAT(refusal("job_matrix_generate_conrod.inp", std::string(kConrodBores) + R"(
[material.steal]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
)"),
              HasSubstr("did you mean \"steel\""));
  EXPECT_THAT(refusal("CHEXA08_.nas", "[interface.a]\nby = \"tie\"\nelement = 7\n"),
              AllOf(HasSubstr("there is no tie 7"), HasSubstr("65, 66")));
  EXPECT_THAT(
      refusal("job_matrix_generate_conrod.inp", std::string("[mesh]\nsize = \"2 mm\"\n") + kConrodBores),
      AllOf(HasSubstr("mesh.size"), HasSubstr("is for CAD parts")));
}

// gmsh's bar, 1 x 1 x 3 m (tests/mesh/data/gmsh), in its own formats (2: hex20.msh, 4: the others) and as
// universal files, from the file to the superelement.  Without contraction across, a bar between rigid ends
// stretches uniformly, which all cells represent: EA/l to round-off of one solve.  The same cells give the
// same superelement whatever the format.
class GmshBar : public ForeignPart {
 protected:
  superelement::Superelement reduced(const std::string& mesh, const std::string& tie = "rigid",
                                     const std::string& modes = "") const {
    const auto path = kDecks / "gmsh" / mesh;
    std::string text = "[geometry]\nfile = \"" + path.string() +
                       "\"\n[material.steel]\nyoung = \"210 GPa\"\npoisson = 0\ndensity = \"7850 kg/m^3\"\n" +
                       "[modes]\ncount = 6\n" + modes;
    for (const std::string end : {"foot", "top"})
      text += "[interface." + end + "]\nby = \"group\"\ngroup = \"" + end + "\"\ntie = \"" + tie + "\"\n";
    const auto output = folder_ / (mesh + ".se.h5");
    PartInput input = read_part(put("bar.toml", text));
    input.cad.worker = std::filesystem::path(FLEXURA_BIN_DIR) / "flexura-mesh";
    reduce_to_file(input, output, {.report = {}, .quiet = true});
    return superelement::read(output);
  }
};

TEST_F(GmshBar, IsTheSameFromEveryFormat) {
  std::map<std::string, superelement::Superelement> all;
  for (const std::string mesh : {"hex20.msh", "hex27_binary.msh", "wedge15.msh", "tet10.msh", "hex8.unv",
                                 "hex20.unv", "wedge15.unv", "tet10.unv"}) {
    const superelement::Superelement& se = all[mesh] = reduced(mesh);
    ASSERT_EQ(se.n_b, 12) << mesh;
    EXPECT_NEAR(se.inertia.mass / (3.0 * 7850.0), 1.0, 1e-9) << mesh;
    EXPECT_NEAR(se.K_se(8, 8) / (2.1e11 / 3.0), 1.0, 1e-9) << mesh;
    EXPECT_NEAR(se.K_se(2, 8) / (2.1e11 / 3.0), -1.0, 1e-9) << mesh;
  }
  for (const std::string cells : {"hex20", "tet10", "wedge15"}) {
    const superelement::Superelement &own = all[cells + ".msh"], &other = all[cells + ".unv"];
    // Files print 16 digits, and the order of the nodes is that of the file.
    const Eigen::MatrixXd K = own.K_se.topLeftCorner(12, 12);
    EXPECT_LT((K - other.K_se.topLeftCorner(12, 12)).norm(), 1e-9 * K.norm()) << cells;
    EXPECT_LT((own.omega2 - other.omega2).cwiseQuotient(own.omega2).cwiseAbs().maxCoeff(), 1e-8) << cells;
  }
}

// An elastic tie through the part file: six dofs at each end and interface modes beside the others.
TEST_F(GmshBar, TakesInterfaceModes) {
  const superelement::Superelement se = reduced("hex20.msh", "elastic", "interface_count = 5\n");
  EXPECT_EQ(se.n_b, 12);
  EXPECT_GE(se.n_q, 11);
  EXPECT_EQ(se.interfaces[0].tie, "elastic");
  EXPECT_THAT(se.report_json, HasSubstr("interface reduction: "));
  const auto refused = [&](const std::string& tie, const std::string& modes) -> std::string {
    try {
      reduced("hex20.msh", tie, modes);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refused("rigid", "interface_count = 5\n"), HasSubstr("is about elastic ties"));
  EXPECT_THAT(refused("elastic", "set = \"craig_chang\"\n"), HasSubstr("does not go with elastic ties"));
  EXPECT_THAT(refused("elastic", "interface_count = 5\ninterface_accuracy = 0.1\n"),
              HasSubstr("one of them"));
}

TEST_F(ForeignPart, ASpringToTheGroundIsRefusedWithTheWayOut) {
  EXPECT_THAT(refusal("CHEXA08_.nas",
                      "[link.spring]\ninterfaces = [\"tie 65\", \"ground\"]\nstiffness = \"1 kN/m\"\n"),
              AllOf(HasSubstr("link.spring"), HasSubstr("bushing")));
}

// A mass with offset and inertia on an interface: the superelement gains exactly the rigid body's mass, first
// and second moments.
TEST(PointMasses, AddTheRigidBodysMassAndInertia) {
  Part part = testing::beam({0.4, 0.05, 0.03}, {4, 1, 1}, mesh::CellType::tet10, Tie::rigid, Tie::rigid);
  ReductionOptions options;
  options.n_modes = 3;
  const Reduction bare = craig_bampton(part, options);
  PointMass mass{.mass = 2.5, .offset = {0.1, -0.02, 0.03}};
  mass.inertia << 0.02, 0.003, 0.0, 0.003, 0.03, -0.002, 0.0, -0.002, 0.025;
  add_mass_to_interface(part, 1, mass);
  const Reduction se = craig_bampton(part, options);
  const Eigen::Vector3d x = part.interfaces[1].point + mass.offset;
  EXPECT_NEAR(se.inertia.mass - bare.inertia.mass, 2.5, 1e-12);
  EXPECT_LT((se.inertia.S_x - bare.inertia.S_x - 2.5 * x).norm(), 1e-12);
  const Eigen::Matrix3d C = 0.5 * mass.inertia.trace() * Eigen::Matrix3d::Identity() - mass.inertia;
  EXPECT_LT((se.inertia.S_xx - bare.inertia.S_xx - C - 2.5 * x * x.transpose()).norm(), 1e-12);
  // On the interface's own dofs: m, m [d], J about the node.
  const Eigen::MatrixXd gain = se.M_se.block(6, 6, 6, 6) - bare.M_se.block(6, 6, 6, 6);
  EXPECT_NEAR(gain(0, 0), 2.5, 1e-10);
  EXPECT_NEAR(gain(3, 3), mass.inertia(0, 0) + 2.5 * (0.02 * 0.02 + 0.03 * 0.03), 1e-10);
  // The fixed-interface modes do not feel it.
  EXPECT_LT((se.omega2 - bare.omega2).norm(), 1e-8 * bare.omega2.norm());
}

TEST(PointMasses, WhatNoBodyHasIsRefused) {
  Part part = testing::beam({0.4, 0.05, 0.03}, {2, 1, 1}, mesh::CellType::tet10, Tie::rigid, Tie::average);
  PointMass mass{.mass = 1.0};
  mass.inertia.diagonal() << 1.0, 0.1, 0.1;
  EXPECT_THROW(add_mass_to_interface(part, 0, mass), std::invalid_argument);
  mass.inertia.setZero();
  EXPECT_THROW(add_mass_to_interface(part, 1, mass), std::invalid_argument) << "an averaging tie";
  mass.node = 3;
  mass.offset.x() = 0.1;
  EXPECT_THROW(add_mass_to_node(part, mass), std::invalid_argument);
}

// A spring between the two ends of a bar lies parallel to it: compliance along the bar 1 / (EA/l + k).
TEST(Links, SpringAndDamperLieParallelToTheBar) {
  Part part = testing::beam({0.4, 0.05, 0.03}, {4, 1, 1}, mesh::CellType::hex20, Tie::rigid, Tie::rigid);
  ReductionOptions options;
  options.n_modes = 2;
  const double bar = craig_bampton(part, options).K_se(6, 6);
  const mesh::Index a = add_tied_node(part, 0, part.interfaces[0].point),
                    b = add_tied_node(part, 1, part.interfaces[1].point);
  part.links.push_back({"strut", a, b, 3e8, 700.0});
  const Reduction se = craig_bampton(part, options);
  EXPECT_NEAR(se.K_se(6, 6) - bar, 3e8, 1e-9 * bar);
  EXPECT_NEAR(se.K_se(0, 6) + se.K_se(6, 6), 0.0, 1e-9 * bar);
  ASSERT_EQ(se.D_se.rows(), se.n());
  EXPECT_NEAR(se.D_se(6, 6), 700.0, 1e-9);
  EXPECT_NEAR(se.D_se(0, 6), -700.0, 1e-9);
  EXPECT_NEAR(se.D_se(1, 1), 0.0, 1e-9) << "across the line it does nothing";
  EXPECT_LT(se.report.rigid_strain, 1e-11);
}

// Abaqus' own K and M with the nodes of its deck: the superelement that was computed from them elsewhere
// (tests/reduce/abaqus_block_test.cpp has its fixed-interface frequencies from our elements, too).
TEST_F(ForeignPart, FinishedMatricesGiveAbaqusOwnSuperelement) {
  const std::filesystem::path block =
      std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/reduce/data/abaqus_block";
  const std::string matrices = "\n[matrices]\nstiffness = \"" + (block / "blockC3D10_STIF1.mtx.gz").string() +
                               "\"\nmass = \"" + (block / "blockC3D10_MASS1.mtx.gz").string() + "\"\n";
  const std::string ends = R"(
[interface.left]
by = "plane"
point = [0, 0, 0]
normal = [1, 0, 0]
reference = [0, 0.5, 0.5]
[interface.right]
by = "plane"
point = [4, 0, 0]
normal = [1, 0, 0]
reference = [4, 0.5, 0.5]
)";
  const ModelledPart given = part((block / "blockC3D10.inp").string(), matrices + ends);
  ReductionOptions options;
  options.n_modes = 10;
  const Reduction ours = craig_bampton(given.part, options);
  std::ifstream in(block / "craig_bampton_C3D10.json");
  const nlohmann::json reference = nlohmann::json::parse(in);
  // 1e-6: the reference's matrices agree with themselves (symmetry) to 1e-8 of the largest entry.
  const auto hertz = [](double omega2) { return std::sqrt(omega2) / (2.0 * std::numbers::pi); };
  const auto fixed = reference.at("C3D10").at("fixed_interface_Hz").get<std::vector<double>>();
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(hertz(ours.omega2(k)) / fixed[k], 1.0, 1e-6) << k;
  options.set = ModeSet::guyan;
  const Eigen::VectorXd condensed = reduced_free_modes(craig_bampton(given.part, options));
  const auto guyan = reference.at("C3D10").at("Guyan_freefree_Hz").get<std::vector<double>>();
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(hertz(condensed(6 + k)) / guyan[k], 1.0, 1e-6) << k;
}

// Other programs' mass matrices hold the point masses of their decks.
TEST_F(ForeignPart, PointMassesAreNotAddedToTheirMatrix) {
  const std::string deck =
      put("masses.inp",
          "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=MASS, ELSET=P\n1, 2\n"
          "*MASS, ELSET=P\n5.\n*ELEMENT, TYPE=S3, ELSET=E\n2, 1, 2, 3\n*SHELL SECTION, ELSET=E, MATERIAL=M\n"
          "0.01\n*MATERIAL, NAME=M\n*ELASTIC\n1e9, 0.3\n*DENSITY\n1.\n")
          .string();
  const ModelledPart modelled = part(
      deck, "[matrices]\nstiffness = \"" + put("K.mtx", "1 1 2\n4 4 1\n7 7 1\n1 4 -1\n1 7 -1\n").string() +
                "\"\nmass = \"" +
                put("M.mtx", "1 1 1\n2 2 1\n3 3 1\n4 4 6\n5 5 6\n6 6 6\n7 7 1\n8 8 1\n9 9 1\n").string() +
                "\"\n[interface.a]\nby = \"nodes\"\nnodes = [1, 2, 3]\ntie = \"rigid\"\n");
  EXPECT_TRUE(modelled.part.masses.empty());
  EXPECT_THAT(modelled.notes, Contains(HasSubstr("1 point mass of the deck is in the mass matrix")));
  ReductionOptions options;
  options.n_modes = 0;
  EXPECT_NEAR(craig_bampton(modelled.part, options).inertia.mass, 8.0, 1e-12);
}

TEST_F(ForeignPart, MatricesThatDoNotFitTheNodesAreRefused) {
  const std::string nodes = put("nodes.csv", "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n").string();
  const auto with = [&](const std::string& K, const std::string& M) {
    return refusal(nodes, "[matrices]\nstiffness = \"" + put("K.mtx", K).string() + "\"\nmass = \"" +
                              put("M.mtx", M).string() + "\"\n[interface.a]\nby = \"nodes\"\nnodes = [1]\n" +
                              "tie = \"node\"\n");
  };
  EXPECT_THAT(with("1 1 5\n10 10 3\n", "1 1 1\n"),
              AllOf(HasSubstr("K.mtx, line 2"), HasSubstr("beyond the 9")));
  EXPECT_THAT(with("1 2 5\n2 1 6\n", "1 1 1\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("mirror image differ")));
  EXPECT_THAT(with("1 1 5\n", "1 1 1\n2 2 2\n3 3 1\n"),
              HasSubstr("must be the same in the three directions"));
  // Six rows a node: consistent beams, inertia that nothing holds, points of modes.
  const std::string turning = "1, 4, 1, 4, 5.\n1, 1, 1, 1, 5.\n";
  EXPECT_THAT(with(turning, "1, 1, 1, 5, 2.\n1, 2, 1, 4, 2.\n"),
              AllOf(HasSubstr("as an offset of a mass does"), HasSubstr("COUPMASS")));
  EXPECT_THAT(with(turning, "2, 4, 2, 4, 1.\n"),
              AllOf(HasSubstr("node 2 has rotary inertia"), HasSubstr("K.mtx")));
  EXPECT_THAT(with(turning, "1, 7, 1, 1, 1.\n"), HasSubstr("direction 7 is none of 1 to 6"));
  const std::string head = "DMIG    KFLEX          0       6       2\n";
  EXPECT_THAT(
      with(
          head +
              "DMIG*   KFLEX                  1000001               0\n*               1000001               "
              "0  1.000000000D+00\n",
          ""),
      HasSubstr("scalar point"));
  EXPECT_THAT(with("DMIG    K       0       6       3\n", ""),
              AllOf(HasSubstr("line 1"), HasSubstr("complex")));
  EXPECT_THAT(with("DMIG    K1      0       6       1\nDMIG    K2      0       6       1\n", ""),
              AllOf(HasSubstr("2 of its DMIG"), HasSubstr("K1, K2")));
  EXPECT_THAT(refusal(nodes, "[interface.a]\nby = \"nodes\"\nnodes = [1]\n"),
              HasSubstr("add a table [matrices]"));
}

}  // namespace
}  // namespace flexura::reduce
