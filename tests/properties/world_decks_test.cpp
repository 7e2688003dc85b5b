// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks as other programs take them: what the syntax leaves open changes nothing, materials with directions are those of
// their tensors, and what is repaired gives the body that the repaired deck describes.
#include "tests/properties/world_decks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "mesh/import/abaqus.hpp"
#include "mesh/import/nastran.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using mbs::chance::Chance;
using mbs::test::refusal_of;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

std::string cased(Chance& chance, std::string text) {
  for (char& c : text)
    if (chance.flip(0.5)) c = static_cast<char>(chance.flip(0.5) ? std::tolower(c) : std::toupper(c));
  return text;
}

// A line of fields as hands and programs write it: blanks and tabs around fields, a comma at the end.
std::string loose(Chance& chance, const std::vector<std::string>& fields, bool may_end_in_comma) {
  std::string line;
  const auto blank = [&] {
    for (int n = chance.below(3); n > 0; --n) line += chance.flip(0.7) ? ' ' : '\t';
  };
  for (std::size_t k = 0; k < fields.size(); ++k) {
    blank();
    line += fields[k];
    blank();
    if (k + 1 < fields.size() || (may_end_in_comma && chance.flip(0.5))) line += ',';
  }
  if (chance.flip(0.2)) line += '\r';
  return line + "\n";
}

// Two bricks of random corners.
std::vector<std::vector<std::string>> random_nodes(Chance& chance) {
  std::vector<std::vector<std::string>> nodes;
  for (int k = 0; k < 3; ++k)
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      const Vector3d at = Vector3d(x, y, k) + chance.vector(0.1);
      nodes.push_back({std::to_string(nodes.size() + 1), fmt::format("{:.12g}", at.x()),
                       fmt::format("{:.12g}", at.y()), fmt::format("{:.12g}", at.z())});
    }
  return nodes;
}

void expect_same_model(const mesh::ImportedModel& a, const mesh::ImportedModel& b) {
  ASSERT_EQ(a.mesh.points.rows(), b.mesh.points.rows());
  EXPECT_EQ((a.mesh.points - b.mesh.points).norm(), 0.0);
  ASSERT_EQ(a.mesh.solids.size(), 1u);
  ASSERT_EQ(b.mesh.solids.size(), 1u);
  ASSERT_EQ(a.mesh.solids[0].nodes.rows(), b.mesh.solids[0].nodes.rows());
  EXPECT_TRUE(a.mesh.solids[0].nodes == b.mesh.solids[0].nodes);
  EXPECT_EQ(a.mesh.solids[0].material, b.mesh.solids[0].material);
  EXPECT_EQ(a.mesh.solids[0].variant, b.mesh.solids[0].variant);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (std::size_t k = 0; k < a.materials.size(); ++k) {
    EXPECT_EQ(a.materials[k].E, b.materials[k].E);
    EXPECT_EQ(a.materials[k].nu, b.materials[k].nu);
    EXPECT_EQ(a.materials[k].rho, b.materials[k].rho);
  }
  ASSERT_EQ(a.mesh.sets.size(), b.mesh.sets.size());
}

TEST_F(WorldDecks, AbaqusSyntaxThatChangesNothing) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const auto nodes = random_nodes(chance);
    const std::vector<std::vector<std::string>> elements = {{"1", "1", "2", "3", "4", "5", "6", "7", "8"},
                                                            {"2", "5", "6", "7", "8", "9", "10", "11", "12"}};
    const double E = chance.between(1e9, 3e11), rho = chance.between(500.0, 9000.0);
    const std::string number = fmt::format("{:.9e}", E);
    std::string plain = "*NODE\n", odd;
    for (const auto& node : nodes) plain += fmt::format("{}\n", fmt::join(node, ","));
    plain += "*ELEMENT,TYPE=C3D8I,ELSET=E\n";
    for (const auto& element : elements) plain += fmt::format("{}\n", fmt::join(element, ","));
    plain += fmt::format(
        "*MATERIAL,NAME=M\n*ELASTIC\n{},0.3\n*DENSITY\n{:.17g}\n*SOLID SECTION,ELSET=E,MATERIAL=M\n", number,
        rho);

    const auto comment = [&] {
      if (chance.flip(0.3)) odd += chance.flip(0.5) ? "** a comment, of\n" : "**\n";
      if (chance.flip(0.1)) odd += "   \n";
      if (chance.flip(0.1)) odd += "*\n";
    };
    const auto keyword = [&](const std::string& name, const std::vector<std::string>& parameters) {
      comment();
      odd += "*" + cased(chance, name);
      for (const std::string& parameter : parameters) {
        odd += chance.flip(0.3) ? ",\n" : chance.flip(0.5) ? ", " : ",";
        const std::size_t equals = parameter.find('=');
        odd += cased(chance, parameter.substr(0, equals)) + (chance.flip(0.3) ? " = " : "=") +
               cased(chance, parameter.substr(equals + 1));
      }
      odd += "\n";
    };
    if (chance.flip(0.3)) odd += "a title that no keyword is before, 1, 2\n";
    keyword("NODE", {});
    for (const auto& node : nodes) comment(), odd += loose(chance, node, true);
    keyword("ELEMENT", {"TYPE=C3D8I", "ELSET=E"});
    for (const auto& element : elements) {
      // In one line, a comma at its end or none, or in two after a comma.
      const auto cut = chance.flip(0.4) ? 1 + chance.below(8) : 9;
      const std::vector<std::string> first(element.begin(), element.begin() + cut),
          rest(element.begin() + cut, element.end());
      if (rest.empty()) {
        odd += loose(chance, first, true);
      } else {
        odd += fmt::format("{},\n", fmt::join(first, ", "));
        odd += loose(chance, rest, true);
      }
    }
    keyword("MATERIAL", {"NAME=M"});
    std::string exponent = number;
    if (chance.flip(0.5)) std::ranges::replace(exponent, 'e', chance.flip(0.5) ? 'D' : 'E');
    keyword("ELASTIC",
            chance.flip(0.5) ? std::vector<std::string>{"TYPE=ISOTROPIC"} : std::vector<std::string>{});
    odd += loose(chance, {exponent, "0.3"}, true);
    keyword("DENSITY", {});
    odd += loose(chance, {fmt::format("{:.17g}", rho)}, true);
    keyword("SOLID SECTION", {"ELSET=E", "MATERIAL=M"});
    if (chance.flip(0.5)) odd += ",\n";
    // What tells of results, loads and steps alone.
    keyword("BOUNDARY", {});
    odd += "1, 1, 3\n";
    keyword("STEP", {});
    keyword("FREQUENCY", {});
    odd += "10\n";
    keyword("NODE PRINT", {"NSET=ALL"});
    odd += "U\n";
    keyword("END STEP", {});
    SCOPED_TRACE(odd);
    expect_same_model(mesh::read_abaqus(file(odd, "odd.inp"), mesh::DeckProgram::calculix),
                      mesh::read_abaqus(file(plain, "plain.inp"), mesh::DeckProgram::calculix));
  }
}

Matrix6 isotropic_stiffness(double E, double nu) {
  Matrix6 D = Matrix6::Zero();
  const double mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  D.topLeftCorner<3, 3>().setConstant(lambda);
  D.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  return D;
}

// C'_ijkl = R_ip R_jq R_kr R_ls C_pqrs by the tensor's 81 components.
Matrix6 turned_tensor(const Matrix6& D, const Matrix3d& R) {
  constexpr int kOf[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  constexpr int kPair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Matrix6 out = Matrix6::Zero();
  for (int I = 0; I < 6; ++I)
    for (int J = 0; J < 6; ++J)
      for (int p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q)
          for (int r = 0; r < 3; ++r)
            for (int s = 0; s < 3; ++s)
              out(I, J) += R(kPair[I][0], p) * R(kPair[I][1], q) * R(kPair[J][0], r) * R(kPair[J][1], s) *
                           D(kOf[p][q], kOf[r][s]);
  return out;
}

Matrix6 random_stiffness(Chance& chance, bool orthotropic) {
  Matrix6 A;
  for (double& c : A.reshaped()) c = chance.between(-1.0, 1.0);
  Matrix6 D = 1e11 * (A * A.transpose() + Matrix6::Identity());
  if (orthotropic) {
    const Eigen::Matrix<double, 6, 1> diagonal = D.diagonal();
    const Matrix3d corner = D.topLeftCorner<3, 3>();
    D.setZero();
    D.diagonal() = diagonal;
    D.topLeftCorner<3, 3>() = corner;
  }
  return D;
}

// *ELASTIC of all types and MAT9, along random axes: the tensor's own rotation.
TEST_F(WorldDecks, StiffnessesWithDirections) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const Matrix3d R = chance.rotation();
    const int kind = chance.below(4);  // ORTHO, ANISO, an isotropic one written as ANISO, MAT9
    const Matrix6 D = kind == 2 ? isotropic_stiffness(2.1e11, chance.between(0.0, 0.45))
                                : random_stiffness(chance, kind == 0);
    PartMesh mesh;
    if (kind < 3) {
      // Abaqus: the upper triangle by columns, 11 22 33 12 13 23; here the fifth is yz, the sixth zx.
      constexpr int kAt[6] = {0, 1, 2, 3, 5, 4};
      std::vector<std::string> numbers;
      for (int column = 0; column < 6; ++column)
        for (int row = 0; row <= column; ++row)
          if (kind > 0 || column < 3 || row == column)
            numbers.push_back(fmt::format("{:.16e}", D(kAt[row], kAt[column])));
      std::string lines;
      for (std::size_t k = 0; k < numbers.size(); ++k) lines += numbers[k] + (k % 8 == 7 ? "\n" : ", ");
      constexpr const char* kNames[] = {"ORTHO", "ANISO", "ANISOTROPIC"};
      mesh = load(
          kBrick + fmt::format("*MATERIAL,NAME=M\n*ELASTIC,TYPE={}\n{}\n*DENSITY\n7800\n*ORIENTATION,NAME=O\n"
                               "{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n"
                               "*SOLID SECTION,ELSET=E,MATERIAL=M,ORIENTATION=O\n",
                               kind == 0 && chance.flip(0.5) ? "ORTHOTROPIC" : kNames[kind], lines, R(0, 0),
                               R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1)),
          "deck.inp");
    } else {
      std::string numbers;
      for (int row = 0; row < 6; ++row)
        for (int column = row; column < 6; ++column) numbers += fmt::format(",{:.16e}", D(row, column));
      std::string deck = "BEGIN BULK\nPSOLID,1,9,7\n";
      const Vector3d b = R.col(2), c = R.col(0);
      deck += fmt::format("CORD2R,7,,0.,0.,0.,{:.16e},{:.16e},{:.16e},+\n+,{:.16e},{:.16e},{:.16e}\n", b.x(),
                          b.y(), b.z(), c.x(), c.y(), c.z());
      deck += "MAT9,9" + numbers + ",7800.\n";
      for (int k = 0; k < 8; ++k)
        deck += fmt::format("GRID,{},,{}.,{}.,{}.\n", k + 1, (k % 4 == 1 || k % 4 == 2) ? 1 : 0,
                            k % 4 > 1 ? 1 : 0, k / 4);
      mesh = load(deck + "CHEXA,1,1,1,2,3,4,5,6,+\n+,7,8\nENDDATA\n", "deck.bdf");
    }
    ASSERT_EQ(mesh.mesh.solids.size(), 1u);
    const Matrix6 read = mesh.materials.at(static_cast<std::size_t>(mesh.mesh.solids[0].material.at(0))).D,
                  wanted = kind == 2 ? D : turned_tensor(D, R);
    EXPECT_LE((read - wanted).norm(), 1e-12 * wanted.norm());  // round-off of sums of 81 products
  }
  EXPECT_THAT(refusal_of([&] {
                load(std::string(kBrick) +
                         "*MATERIAL,NAME=M\n*ELASTIC,TYPE=ORTHO\n1,2,1,0,0,1,1,1\n1\n*DENSITY\n7800\n"
                         "*SOLID SECTION,ELSET=E,MATERIAL=M\n",
                     "deck.inp");
              }),
              HasSubstr("not those of a positive definite stiffness"));
}

// A brick of random corners whose nodes are numbered the other way round is that brick.
TEST_F(WorldDecks, LeftHandedNumberings) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const auto nodes = random_nodes(chance);
    std::string head = "*NODE\n";
    for (std::size_t k = 0; k < 8; ++k) head += fmt::format("{}\n", fmt::join(nodes[k], ","));
    struct Type {
      const char *name, *right, *left;
    };
    constexpr Type kTypes[] = {{"C3D8", "1,2,3,4,5,6,7,8", "5,6,7,8,1,2,3,4"},
                               {"C3D6", "1,2,3,5,6,7", "5,6,7,1,2,3"},
                               {"C3D4", "1,2,3,5", "1,3,2,5"}};
    const Type& type = chance.one_of(kTypes);
    const auto deck = [&](const char* order) {
      return head +
             fmt::format(
                 "*ELEMENT,TYPE={},ELSET=E\n1,{}\n*MATERIAL,NAME=M\n*ELASTIC\n2e11,0.3\n*DENSITY\n7800\n"
                 "*SOLID SECTION,ELSET=E,MATERIAL=M\n",
                 type.name, order);
    };
    const PartMesh right = load(deck(type.right), "right.inp"), left = load(deck(type.left), "left.inp");
    EXPECT_GT(left.report.volume, 0.0);
    EXPECT_NEAR(left.report.volume, right.report.volume, 1e-13);
    EXPECT_THAT(left.warnings, Contains(HasSubstr("left-handed by its numbering")));
    EXPECT_THAT(right.warnings, Each(Not(HasSubstr("left-handed"))));
    PartInput strict = part(file(deck(type.left), "left.inp"));
    strict.strict = true;
    EXPECT_THAT(refusal_of([&] { load_part_mesh(strict, {}); }), HasSubstr("left-handed by its numbering"));
  }
}

TEST_F(WorldDecks, AllFaultsAreToldAtOnce) {
  const std::string text = refusal_of([&] {
    load(std::string(kBrick) +
             "*NODE\n1x,0,0,0\n*MATERIAL,NAME=A\n*ELASTIC,TYPE=ODD\n1\n*SOLID SECTION,ELSET=E,"
             "MATERIAL=A,COMPOSITE\n1\n",
         "deck.inp");
  });
  EXPECT_THAT(text, HasSubstr("3 kinds of faults stop the deck"));
  EXPECT_THAT(text, HasSubstr("\"1x\" is not a whole number"));
  EXPECT_THAT(text, HasSubstr("TYPE=ODD is not read"));
  EXPECT_THAT(text, HasSubstr("COMPOSITE is not read"));
  const std::string cards = refusal_of([&] {
    load(
        "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nMAT1,1,2.+11,,.3,7800.\n"
        "CBAR,1,8,1,2,0.,0.,1.\nCBAR,2,8,2,3,0.,0.,1.\nCTRIA3,3,9,1,2,3\nENDDATA\n",
        "deck.bdf");
  });
  EXPECT_THAT(cards,
              HasSubstr("property 8 of CBAR 1 is no PBAR, PBARL, PBEAM or PBEAML of this file (and 1 more of "
                        "this kind)"));
  EXPECT_THAT(cards, HasSubstr("property 9 of CTRIA3 3 is no PSHELL, PCOMP or PCOMPG of this file"));
}

// --density, and a sector's own ties: neither moves a node.
TEST_F(WorldDecks, DensityAndCyclicTies) {
  const std::string deck = std::string(kBrick) +
                           "*MATERIAL,NAME=M\n*ELASTIC\n2e11,0.3\n*SOLID SECTION,ELSET=E,MATERIAL=M\n"
                           "*SURFACE,NAME=A\nE,S4\n*SURFACE,NAME=B\nE,S6\n*TIE,CYCLIC SYMMETRY,NAME=T\nA,B\n";
  PartInput input = part(file(deck, "sector.inp"));
  EXPECT_THAT(refusal_of([&] { load_part_mesh(input, {}); }), HasSubstr("--density \"7800 kg/m^3\""));
  input.density = 2700.0;
  const PartMesh mesh = load_part_mesh(input, {});
  EXPECT_EQ(mesh.materials.at(0).density, 2700.0);
  EXPECT_THAT(mesh.messages, Contains(HasSubstr("2700 kg/m^3, as asked")));
  EXPECT_THAT(mesh.warnings, Contains(HasSubstr("CYCLIC SYMMETRY: left out")));
  EXPECT_NEAR(mesh.report.volume, 1.0, 1e-14);
}

}  // namespace
}  // namespace flexura::reduce
