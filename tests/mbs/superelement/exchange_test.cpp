// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/exchange/exchange.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/setup/scratch_place.hpp"

namespace flexura::superelement {
namespace {

using testing::box_beam_points;
using testing::BoxBeamPoint;
using ::testing::HasSubstr;
using testing::make_box_beam;

class Exchange : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::flexura::test::scratch_place() / ("flexura_exchange_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string content(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  }

  const Superelement se_ = make_box_beam();
  std::filesystem::path folder_;
};

TEST_F(Exchange, MatrixMarketReadsBackBitForBit) {
  const auto files = write_matrix_market(folder_ / "beam", se_);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0], folder_ / "beam.K.mtx");
  for (const auto& [file, A] : {std::pair(files[0], se_.K_se), std::pair(files[1], se_.M_se)}) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "%%MatrixMarket matrix array real symmetric");
    while (std::getline(in, line) && line[0] == '%') {
    }
    EXPECT_EQ(line, "15 15");
    for (int j = 0; j < 15; ++j) {
      for (int i = j; i < 15; ++i) {
        ASSERT_TRUE(std::getline(in, line));
        ASSERT_EQ(std::strtod(line.c_str(), nullptr), A(i, j));
      }
    }
    EXPECT_FALSE(std::getline(in, line));
  }
}

// Reads fixed columns, as Nastran does. Ten digits are printed: 5e-10 of the value.
TEST_F(Exchange, DmigHoldsTheLowerTrianglesInFixedColumns) {
  const auto path = folder_ / "beam.pch";
  write_dmig(path, se_);
  std::istringstream in(content(path));
  std::map<std::string, Eigen::MatrixXd> matrices;
  const auto number = [](std::string field) {
    for (char& c : field) c = c == 'D' ? 'E' : c;
    return std::stod(field);
  };
  const auto dof = [&](const std::string& id, const std::string& component) {
    const int point = std::stoi(id), c = std::stoi(component);
    return point > 1'000'000 ? 12 + point - 1'000'001 : 6 * (point - 1) + c - 1;
  };
  std::string name;
  int column = 0, grids = 0, spoints = 0;
  Eigen::Vector3d position;
  for (std::string line; std::getline(in, line);) {
    ASSERT_LE(line.size(), 80u);
    const std::string card = line.substr(0, 8);
    if (card == "DMIG    ") {
      name = line.substr(8, 5);
      matrices[name] = Eigen::MatrixXd::Zero(15, 15);
      EXPECT_EQ(std::stoi(line.substr(24, 8)), 6);
    } else if (card == "DMIG*   ") {
      ASSERT_EQ(line.substr(8, 5), name);
      column = dof(line.substr(24, 16), line.substr(40, 16));
    } else if (card == "*       " && !name.empty()) {
      const int row = dof(line.substr(8, 16), line.substr(24, 16));
      matrices[name](row, column) = matrices[name](column, row) = number(line.substr(40, 16));
    } else if (card == "GRID*   ") {
      ++grids;
      position[0] = number(line.substr(40, 16));
      position[1] = number(line.substr(56, 16));
      ASSERT_TRUE(std::getline(in, line));
      position[2] = number(line.substr(8, 16));
      EXPECT_LT((position - se_.interfaces[static_cast<std::size_t>(grids - 1)].p_BoN_B).norm(), 1e-9);
    }
    spoints += card == "SPOINT  ";
  }
  EXPECT_EQ(grids, 2);
  EXPECT_EQ(spoints, 3);
  EXPECT_TRUE(matrices.at("KFLEX").isApprox(se_.K_se, 5e-10));
  EXPECT_TRUE(matrices.at("MFLEX").isApprox(se_.M_se, 5e-10));
}

TEST_F(Exchange, FlexDataReadsBackToThePrintedDigits) {
  const auto path = folder_ / "beam.xml";
  const ModeAnalysis modes = natural_modes(se_, {}, 5);
  const FlexData data = make_flexdata(se_, modes);
  write_flexdata(path, data);
  const FlexData back = read_flexdata(path);
  ASSERT_EQ(back.modes.size(), 5u);
  ASSERT_EQ(back.nodes.size(), 2u);
  EXPECT_EQ(back.num_nodes, 8);
  EXPECT_EQ(back.modes[0].id, 7);  // after six rigid ones, which the format forbids
  for (std::size_t j = 0; j < 5; ++j) {
    EXPECT_NEAR(back.modes[j].frequency, data.modes[j].frequency, 1e-14 * data.modes[j].frequency);
    EXPECT_NEAR(back.modes[j].eigenvalue, data.modes[j].eigenvalue, 1e-14 * data.modes[j].eigenvalue);
  }
  EXPECT_LT((back.shapes - data.shapes).cwiseAbs().maxCoeff(), 1e-14 * data.shapes.cwiseAbs().maxCoeff());
  EXPECT_LT((back.nodes[1].position - se_.interfaces[1].p_BoN_B).norm(), 1e-14);
  const std::string first = content(path);
  write_flexdata(path, back);
  EXPECT_EQ(content(path), first);
}

TEST_F(Exchange, FlexDataOfMotionSolveIsRead) {
  const auto path = folder_ / "other.xml";
  // As MotionSolve's guide prints it: tags that differ in case, a comment that is none, no ">" after the
  // attributes.
  std::ofstream(path)
      << "<Reference_FlexData\n id = \"30102\"\n num_nodes = \"1022\"\n num_sel_modes = \"1\"\n"
         " num_sel_nodes = \"2\"\n<ModeData>\n<!-- ID Frequency Eigenvalue Damping -->\n"
         "7 6.5E+01 1.668E+05 1.0E-02\n</Modedata>\n<NodeData>\n<!-- ID X Y Z -->\n"
         "1 0.0 4.5E+02 1.0E+02\n2 2.0E+03 4.5E+02 1.0E+02\n< ! -- Mode Shape -- >\n"
         "1 2 3 4 5 6\n-1 -2 -3 -4 -5 -6.5E+00\n</NodeData>\n</Reference_FlexData>\n";
  const FlexData data = read_flexdata(path);
  EXPECT_EQ(data.id, 30102);
  EXPECT_EQ(data.num_nodes, 1022);
  EXPECT_EQ(data.modes[0].damping, 0.01);
  EXPECT_EQ(data.nodes[1].position, Eigen::Vector3d(2000, 450, 100));
  EXPECT_EQ(data.shapes(11, 0), -6.5);
}

TEST_F(Exchange, BrokenFlexDataIsRefusedByLine) {
  const auto path = folder_ / "bad.xml";
  const auto refusal = [&](const std::string& text) {
    std::ofstream(path) << text;
    try {
      read_flexdata(path);
    } catch (const std::invalid_argument& failure) {
      return std::string(failure.what());
    }
    return std::string("accepted");
  };
  write_flexdata(path, make_flexdata(se_, natural_modes(se_, {}, 3)));
  const std::string good = content(path);
  EXPECT_EQ(refusal(good), "accepted");
  EXPECT_THAT(refusal("<xml/>"), HasSubstr("bad.xml:1: holds no Reference_FlexData"));
  EXPECT_THAT(refusal(good.substr(0, good.size() / 2)), HasSubstr("is not closed; the file is cut short"));
  EXPECT_THAT(refusal(std::regex_replace(good, std::regex("num_sel_modes = \"3\""), "num_sel_modes = \"4\"")),
              HasSubstr("the block ends where a mode's number is wanted"));
  EXPECT_THAT(
      refusal(std::regex_replace(good, std::regex("num_sel_nodes = \"2\""), "num_sel_nodes = \"9999999\"")),
      HasSubstr("stands where a node's number is wanted"));  // the shapes' numbers are none of nodes
  EXPECT_THAT(refusal(std::regex_replace(good, std::regex("num_sel_nodes"), "num_nodes_sel")),
              HasSubstr("num_sel_nodes"));
  EXPECT_THAT(refusal(std::regex_replace(good, std::regex("       7 "), "       x ")),
              HasSubstr("bad.xml:8: \"x "));
}

// The standard input data against the sums over the quadrature points of the body, for a random state:
// kinetic energy (its part odd in s is first order exactly) and the inertia forces on deformation and
// rotation.
TEST_F(Exchange, StandardInputDataGivesEnergyAndInertiaForces) {
  const int m = 4;
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  const auto random = [&](int rows, int columns) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); }));
  };
  const Eigen::MatrixXd Y = random(15, m);
  const StandardInputData sid = standard_input_data(se_, Y);
  const Eigen::VectorXd s = random(m, 1), s_dot = random(m, 1);
  const Eigen::Vector3d v = random(3, 1), w = random(3, 1);

  const auto energy = [&](const Eigen::VectorXd& deformation) {
    double T = 0.0;
    for (const BoxBeamPoint& p : box_beam_points()) {
      const Eigen::Vector3d r = p.x + p.N * Y * deformation;
      T += 0.5 * p.dm * (v + w.cross(r) + p.N * Y * s_dot).squaredNorm();
    }
    return T;
  };
  const double T_0 = 0.5 * se_.inertia.mass * v.squaredNorm() + v.dot(w.cross(sid.mdCM_0)) +
                     0.5 * w.dot(sid.J_0 * w) + s_dot.dot(sid.Ct_0 * v + sid.Cr_0 * w) +
                     0.5 * s_dot.dot(sid.Me * s_dot);
  double T_1 = v.dot(w.cross(sid.mdCM_1 * s));
  for (int k = 0; k < m; ++k) {
    const auto i = static_cast<std::size_t>(k);
    T_1 += s[k] * (0.5 * w.dot(sid.J_1[i] * w) + s_dot.dot(sid.Ct_1[i] * v + sid.Cr_1[i] * w));
  }
  // Sums of some hundred terms that reach 1e3 times the result.
  EXPECT_NEAR(energy(Eigen::VectorXd::Zero(m)) / T_0, 1.0, 1e-11);
  EXPECT_NEAR((energy(s) - energy(-s)) / 2 / T_1, 1.0, 1e-10);

  Eigen::Matrix<double, 6, 1> Omega;
  Omega << w[0] * w[0], w[1] * w[1], w[2] * w[2], w[0] * w[1], w[1] * w[2], w[0] * w[2];
  Eigen::VectorXd elastic = sid.Oe_0 * Omega;
  Eigen::Vector3d rotation = w.cross(sid.J_0 * w);
  for (int k = 0; k < m; ++k) {
    const auto i = static_cast<std::size_t>(k);
    elastic += s[k] * sid.Oe_1[i] * Omega + s_dot[k] * sid.Ge_0[i] * w;
    rotation += s_dot[k] * sid.Gr_0[i] * w;
  }
  Eigen::VectorXd elastic_sum = Eigen::VectorXd::Zero(m);
  Eigen::Vector3d rotation_sum = Eigen::Vector3d::Zero();
  for (const BoxBeamPoint& p : box_beam_points()) {
    const Eigen::Matrix3Xd phi = p.N * Y;
    const Eigen::Vector3d r = p.x + phi * s, relative = 2 * w.cross(phi * s_dot);
    elastic_sum += p.dm * phi.transpose() * (w.cross(w.cross(r)) + relative);
    rotation_sum += p.dm * p.x.cross(w.cross(w.cross(p.x)) + relative);
  }
  EXPECT_LT((elastic - elastic_sum).norm(), 1e-11 * elastic_sum.norm());
  EXPECT_LT((rotation - rotation_sum).norm(), 1e-11 * rotation_sum.norm());
}

// The text's numbers are those terms: read back every m0 and m1 of the sections that a reader needs.
TEST_F(Exchange, SidTextHoldsTheTerms) {
  const auto path = folder_ / "beam.SID_FEM";
  const ModeAnalysis modes = natural_modes(se_, {}, 3);
  write_sid(path, se_, modes);
  Eigen::MatrixXd Y(15, 3);
  for (int j = 0; j < 3; ++j) Y.col(j) = modes.modes[static_cast<std::size_t>(6 + j)].u_se;
  const StandardInputData sid = standard_input_data(se_, Y);

  std::istringstream in(content(path));
  std::map<std::string, double> values;
  std::string section, line;
  int nodes = 0;
  const std::regex number(R"(\s*(m[01]\([^)]*\)|mass)\s*=\s*(\S+))"), start(R"(\s{11}(\w+))");
  for (std::smatch match; std::getline(in, line);) {
    nodes += line.find("new node") != std::string::npos;
    if (std::regex_match(line, match, start)) section = match[1];
    if (!std::regex_match(line, match, number)) continue;
    std::string text = match[2];
    text[text.find('D')] = 'E';
    values[section + std::regex_replace(match[1].str(), std::regex(" "), "")] = std::stod(text);
  }
  EXPECT_EQ(nodes, 2);
  const auto expect = [&](const std::string& name, double value) {
    const auto found = values.find(name);
    EXPECT_NEAR(found == values.end() ? 0.0 : found->second, value, 1e-13 * std::abs(value) + 1e-300) << name;
  };
  expect("refmodmass", se_.inertia.mass);
  expect("mdCMm0(1,1)", sid.mdCM_0[0]);
  expect("Jm0(2,1)", sid.J_0(1, 1));
  expect("Jm0(5,1)", sid.J_0(0, 2));
  expect("Jm1(4,2,1)", sid.J_1[1](0, 1));
  expect("Crm1(3,2,1)", sid.Cr_1[1](2, 0));
  expect("Mem0(2,2)", 1.0);
  expect("Kem0(3,3)", modes.modes[8].omega2);
  expect("Grm0(2,4)", sid.Gr_0[1](1, 0));
  expect("Gem0(3,5)", sid.Ge_0[1](2, 1));
  expect("Oem0(2,6)", sid.Oe_0(1, 5));
  expect("Oem1(1,3,2)", sid.Oe_1[2](0, 1));
  EXPECT_THAT(content(path), HasSubstr("ielastq (   1)                  = Eigen Mode    7 : "));
}

std::string decoded(const std::string& text) {
  static const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<unsigned>(alphabet.find(c));
    if ((bits += 6) >= 8) bytes += static_cast<char>(group >> (bits -= 8) & 255);
  }
  return bytes;
}

TEST_F(Exchange, VtpHoldsPointsAndModes) {
  const auto path = folder_ / "beam.vtp";
  const ModeAnalysis modes = natural_modes(se_, {}, 2);
  write_vtp(path, se_, modes);
  const std::string text = content(path);
  const auto array = [&](const std::string& name, const std::string& inside = "<PolyData") {
    const std::size_t at = text.find("Name=\"" + name, text.find(inside));
    EXPECT_NE(at, std::string::npos) << name;
    const std::size_t start = text.find('\n', at) + 1;
    std::string bytes = decoded(text.substr(start, text.find('\n', start) - start));
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data(), 8);
    EXPECT_EQ(size, bytes.size() - 8);
    return bytes.substr(8);
  };
  const std::string points = array("Points"), shape = array("mode 7 ("),
                    triangles = array("connectivity", "<Polys");
  ASSERT_EQ(points.size(), 8 * 3 * 8u);
  ASSERT_EQ(shape.size(), 8 * 3 * 4u);
  ASSERT_EQ(triangles.size(), 4 * 3 * 4u);
  EXPECT_EQ(std::memcmp(points.data(), se_.surface.vertices.data(), points.size()), 0);
  EXPECT_EQ(std::memcmp(triangles.data(), se_.surface.triangles.data(), triangles.size()), 0);
  // The mode, scaled to a tenth of the box's diagonal; float32.
  Eigen::VectorXf u(24);
  std::memcpy(u.data(), shape.data(), shape.size());
  const Eigen::VectorXf mode = se_.shapes * modes.modes[6].u_se.cast<float>();
  const double diagonal = std::sqrt(0.8 * 0.8 + 0.03 * 0.03 + 0.05 * 0.05);
  EXPECT_NEAR(exchange::largest_displacement(u), 0.1 * diagonal, 1e-6 * diagonal);
  EXPECT_NEAR(u.dot(mode) / (u.norm() * mode.norm()), 1.0, 1e-6);
}

TEST_F(Exchange, GmshViewsHaveOneBlockForEachMode) {
  const auto path = folder_ / "beam.msh";
  write_gmsh_views(path, se_, natural_modes(se_, {}, 2));
  const std::string text = content(path);
  EXPECT_THAT(text, HasSubstr("$Nodes\n8\n1 0.3 -0.215"));
  EXPECT_THAT(text, HasSubstr("$Elements\n4\n1 2 2 2 2 1 5 7\n"));
  int views = 0;
  for (std::size_t at = 0; (at = text.find("$NodeData\n", at)) != std::string::npos; ++at) ++views;
  EXPECT_EQ(views, 2);
  Superelement bare = se_;
  bare.surface = {};
  EXPECT_THROW(write_gmsh_views(path, bare, natural_modes(se_, {}, 2)), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::superelement
