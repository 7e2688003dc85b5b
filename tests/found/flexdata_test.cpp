// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// FlexData (MotionSolve's Reference_FlexData) out of a superelement and back, and from other programs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "mbs/results/results.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/modes.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::AllOf;
using testing::HasSubstr;

class FlexDataFiles : public testing::Test {
 protected:
  // A bent bar of beams, made as a superelement and written as FlexData.
  void SetUp() override {
    folder_.write(
        "bar.bdf",
        "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBARL,1,1,,BAR,,,,,.03,.05\n"
        "GRID,1,,0.,0.,0.\nGRID,2,,.3,0.,0.\nGRID,3,,.6,.05,0.\nGRID,4,,.8,.1,.2\nGRID,5,,1.,.1,.4\n"
        "CBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,2,3,0.,0.,1.\nCBAR,3,1,3,4,0.,1.,0.\nCBAR,4,1,4,5,0.,1.,0."
        "\nENDDATA\n");
    const auto part = folder_.write(
        "bar.toml",
        "[geometry]\nfile = \"bar.bdf\"\n[interface.\"left end\"]\nby = \"nodes\"\nnodes = [1]\n"
        "[interface.right--end]\nby = \"nodes\"\nnodes = [5]\n[modes]\ncount = 8\ndamping = 0.02\n");
    const Outcome reduced = run("flexura-reduce", {part.string(), "-q"});
    ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
    const Outcome written = run("flexura", {"export", folder_ / "bar.se.h5", "-f", "flexdata", "-o",
                                            folder_ / "bar.xml", "-n", "99"});
    ASSERT_EQ(written.exit_code, 0) << written.err;
  }
  Outcome read(const std::string& name, const std::string& text) {
    return run("flexura-reduce",
               {folder_.write(name, text).string(), "-o", (folder_ / "back.se.h5").string()});
  }
  superelement::Superelement back() const { return superelement::read(folder_ / "back.se.h5", {}); }
  std::string xml() const { return read_text(folder_ / "bar.xml"); }
  Folder folder_;
};

// All free modes span what the superelement spans: the same body, to round-off, up to the signs of its modes.
TEST_F(FlexDataFiles, AreReadBackToRoundOff) {
  const superelement::Superelement first = superelement::read(folder_ / "bar.se.h5", {});
  const Outcome outcome = read("again.xml", xml());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const superelement::Superelement second = back();
  ASSERT_EQ(second.n_q, first.n_q);
  ASSERT_EQ(second.interfaces.size(), 2u);
  EXPECT_EQ(second.interfaces[0].name, first.interfaces[0].name);
  EXPECT_EQ(second.interfaces[1].name, first.interfaces[1].name);
  EXPECT_NEAR(second.modal_damping, 0.02, 1e-14);
  VectorXd sign = VectorXd::Ones(first.n());
  for (int k = first.n_b; k < first.n(); ++k)
    if (first.M_se.row(k).head(first.n_b).dot(second.M_se.row(k).head(first.n_b)) < 0) sign(k) = -1;
  const auto compare = [&](const MatrixXd& a, const MatrixXd& b, const char* what) {
    // Of each dof's own size.
    const VectorXd size =
        a.diagonal().cwiseAbs().cwiseSqrt().cwiseMax(1e-3 * a.diagonal().cwiseAbs().cwiseSqrt().maxCoeff());
    const MatrixXd apart = size.cwiseInverse().asDiagonal() *
                           (a - MatrixXd(sign.asDiagonal() * b * sign.asDiagonal())) *
                           size.cwiseInverse().asDiagonal();
    EXPECT_LT(apart.cwiseAbs().maxCoeff(), 1e-10) << what;
  };
  compare(first.K_se, second.K_se, "K_se");
  compare(first.M_se, second.M_se, "M_se");
  for (int p = 0; p < 6; ++p)
    EXPECT_LT((first.inertia.S_phiphi[p] -
               MatrixXd(sign.asDiagonal() * second.inertia.S_phiphi[p] * sign.asDiagonal()))
                  .norm(),
              1e-10 * first.M_se.norm());
  EXPECT_LT((first.inertia.S_xphi - MatrixXd(second.inertia.S_xphi * sign.asDiagonal())).norm(),
            1e-10 * first.inertia.S_xphi.norm());
  const auto modes = superelement::natural_modes(first, {}), again = superelement::natural_modes(second, {});
  for (std::size_t k = 6; k < modes.modes.size(); ++k)
    EXPECT_NEAR(again.modes[k].omega2 / modes.modes[k].omega2, 1.0, 1e-12) << k;
}

// Without our comment: mass and inertia from the part file, in another program's units; what is not known is said.
TEST_F(FlexDataFiles, OfOtherProgramsTakeTheirMassFromThePartFile) {
  std::string text = xml();
  const std::size_t comment = text.find("<!-- Flexura:");
  text.erase(comment, text.find("-->", comment) + 3 - comment);
  const superelement::Superelement first = superelement::read(folder_ / "bar.se.h5", {});
  folder_.write("other.xml", text);
  const Outcome bare = read("bare.xml", text);
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_THAT(bare.err, AllOf(HasSubstr("no mass"), HasSubstr("[flexdata]")));
  const superelement::ModeAnalysis modes = superelement::natural_modes(first, {});
  const Eigen::Vector3d c = modes.mass_centre;
  const Eigen::Matrix3d& J = modes.inertia;
  const Outcome outcome =
      read("other.toml", fmt::format("[flexdata]\nfile = \"other.xml\"\nmass = {:.17g}\ncentre = [{:.17g}, "
                                     "{:.17g}, {:.17g}]\ninertia = [{:.17g}, {:.17g}, "
                                     "{:.17g}, {:.17g}, {:.17g}, {:.17g}]\nnames = [\"a\", \"b\"]\n",
                                     modes.mass, c.x(), c.y(), c.z(), J(0, 0), J(1, 1), J(2, 2), J(0, 1),
                                     J(1, 2), J(2, 0)));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("warning: the file has no inertia integrals"));
  const superelement::Superelement second = back();
  EXPECT_EQ(second.interfaces[1].name, "b");
  const auto again = superelement::natural_modes(second, {});
  for (std::size_t k = 6; k < modes.modes.size(); ++k)
    EXPECT_NEAR(again.modes[k].omega2 / modes.modes[k].omega2, 1.0, 1e-12) << k;
  EXPECT_LT((first.K_se.topLeftCorner(12, 12) - second.K_se.topLeftCorner(12, 12)).norm(),
            1e-10 * first.K_se.topLeftCorner(12, 12).norm());
}

// MotionSolve's own example has two nodes and five modes: fewer than the twelve dofs of its interfaces need.  What the modes do
// not move independently follows; read and written again nothing changes.
TEST_F(FlexDataFiles, OfFewModesGoAroundUnchanged) {
  const superelement::Superelement first = superelement::read(folder_ / "bar.se.h5", {});
  const auto modes = superelement::natural_modes(first, {});
  for (const int count : {5, 2}) {
    const Outcome written = run("flexura", {"export", folder_ / "bar.se.h5", "-f", "flexdata", "-o",
                                            folder_ / "few.xml", "-n", std::to_string(count)});
    ASSERT_EQ(written.exit_code, 0) << written.err;
    const Outcome outcome = read("few.xml", read_text(folder_ / "few.xml"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out,
                HasSubstr(fmt::format("move {} of the 12 interface dofs independently", 6 + count)));
    const superelement::Superelement second = back();
    EXPECT_EQ(second.n(), 6 + count);
    const auto again = superelement::natural_modes(second, {});
    ASSERT_EQ(again.modes.size(), 6u + static_cast<std::size_t>(count));
    for (std::size_t k = 6; k < again.modes.size(); ++k)
      EXPECT_NEAR(again.modes[k].omega2 / modes.modes[k].omega2, 1.0, 1e-12) << k;
    const superelement::FlexData a = superelement::read_flexdata(folder_ / "few.xml"),
                                 b = superelement::make_flexdata(second, again);
    ASSERT_EQ(a.shapes.size(), b.shapes.size());
    for (Eigen::Index j = 0; j < a.shapes.cols(); ++j) {
      const double sign = a.shapes.col(j).dot(b.shapes.col(j)) < 0 ? -1.0 : 1.0;
      EXPECT_LT((a.shapes.col(j) - sign * b.shapes.col(j)).norm(), 1e-12 * a.shapes.col(j).norm()) << j;
    }
    EXPECT_EQ(a.body->directions, b.body->directions);
  }
}

// A body of five modes moves as the body that keeps five of its own does: held at one end, pulled at the other.
TEST_F(FlexDataFiles, OfFewModesMoveAsTheBodyThatKeepsThese) {
  ASSERT_EQ(run("flexura",
                {"export", folder_ / "bar.se.h5", "-f", "flexdata", "-o", folder_ / "few.xml", "-n", "5"})
                .exit_code,
            0);
  ASSERT_EQ(read("few.xml", read_text(folder_ / "few.xml")).exit_code, 0);
  const auto scene = [&](const std::string& body) {
    const auto file = folder_.write("scene.toml", "gravity = [0, 0, -9.81]\n[body.arm]\n" + body + R"(
[joint.wall]
type = "fixed"
from = "ground"
to = "arm.left end"
[force.pull]
type = "force"
marker = "arm.right--end"
x = "20"
z = "100"
[solver]
end_time = 0.02
output_step = 0.001
[output]
quantities = ["wall.force_z", "wall.torque_y", "arm.position_z", "arm.strain_energy"]
)");
    const Outcome outcome = run("flexura", {"simulate", file.string(), "-q", "--no-estimate", "-o",
                                            folder_ / "rows.h5", "--set", "solver.method=runge_kutta"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return results::read(folder_ / "rows.h5").runs.at(0);
  };
  const results::Run
      own = scene("superelement = \"bar.se.h5\"\nmodes = 5\nboundary = \"free\"\nattachments = \"none\""),
      few = scene("superelement = \"back.se.h5\"\nboundary = \"free\"");
  ASSERT_EQ(own.values.rows(), few.values.rows());
  ASSERT_GT(own.values.rows(), 10);
  for (Eigen::Index k = 0; k < own.values.cols();
       ++k)  // the integrator's tolerance, 1e-6, on steps that round-off moves
    EXPECT_LT((own.values.col(k) - few.values.col(k)).cwiseAbs().maxCoeff(),
              1e-6 * std::max(own.values.col(k).cwiseAbs().maxCoeff(), 1e-3))
        << own.quantities[static_cast<std::size_t>(k)].name;
}

// As other programs print it, with eight digits and no integrals.
TEST_F(FlexDataFiles, OfFewModesInEightDigits) {
  const superelement::Superelement first = superelement::read(folder_ / "bar.se.h5", {});
  const superelement::ModeAnalysis modes = superelement::natural_modes(first, {});
  superelement::FlexData data = superelement::make_flexdata(first, superelement::natural_modes(first, {}, 5));
  std::string text = fmt::format(
      "<Reference_FlexData\n id = \"30102\"\n num_nodes = \"1022\"\n num_sel_modes = \"5\"\n "
      "num_sel_nodes = \"2\">\n<ModeData>\n");
  for (const auto& mode : data.modes)
    text += fmt::format("{} {:.7E} {:.7E} {:.7E}\n", mode.id, mode.frequency, mode.eigenvalue, mode.damping);
  text += "</Modedata>\n<NodeData>\n";
  for (const auto& node : data.nodes)
    text += fmt::format("{} {:.7E} {:.7E} {:.7E}\n", node.id, node.position.x(), node.position.y(),
                        node.position.z());
  for (Eigen::Index k = 0; k < data.shapes.size(); ++k)
    text += fmt::format("{:.7E}{}", data.shapes.data()[k], k % 6 == 5 ? "\n" : " ");
  folder_.write("printed.xml", text + "</NodeData>\n</Reference_FlexData>\n");
  const Eigen::Vector3d c = modes.mass_centre;
  const Eigen::Matrix3d& J = modes.inertia;
  const Outcome outcome = read(
      "printed.toml",
      fmt::format("[flexdata]\nfile = \"printed.xml\"\nmass = {:.17g}\ncentre = [{:.17g}, {:.17g}, {:.17g}]\n"
                  "inertia = [{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}]\n",
                  modes.mass, c.x(), c.y(), c.z(), J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(1, 2), J(2, 0)));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto again = superelement::natural_modes(back(), {});
  ASSERT_EQ(again.modes.size(), 11u);
  for (std::size_t k = 6; k < 11; ++k)
    EXPECT_NEAR(again.modes[k].omega2 / modes.modes[k].omega2, 1.0, 1e-6) << k;
}

TEST_F(FlexDataFiles, WhatIsBrokenIsRefusedByOneSentence) {
  const auto refusal = [&](const std::string& text) {
    const Outcome outcome = read("bad.xml", text);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "back.se.h5"));
    return outcome.err;
  };
  const std::string good = xml();
  for (const double part : {0.1, 0.4, 0.7, 0.95})
    EXPECT_THAT(refusal(good.substr(0, static_cast<std::size_t>(part * static_cast<double>(good.size())))),
                HasSubstr("bad.xml"));
  EXPECT_THAT(refusal("<a><b></a>"), HasSubstr("no Reference_FlexData"));
  EXPECT_THAT(refusal(replaced(good, "num_sel_modes = \"14\"", "num_sel_modes = \"13\"")),
              HasSubstr("goes on with"));
  EXPECT_THAT(refusal(replaced(good, "num_sel_nodes = \"2\"", "num_sel_nodes = \"1\"")),
              HasSubstr("goes on with"));
  EXPECT_THAT(refusal(replaced(good, "mass ", "mass -")), HasSubstr("no body has the mass"));
  EXPECT_THAT(refusal(replaced(good, "mass ", "mass nan ")), HasSubstr("a number of mass is wanted"));
  EXPECT_THAT(
      refusal(
          "<Reference_FlexData id = \"1\" num_nodes = \"9\" num_sel_modes = \"0\" num_sel_nodes = \"1\">\n"
          "<ModeData>\n</ModeData>\n<NodeData>\n1 0. 0. 0.\n</NodeData>\n</Reference_FlexData>\n"),
      HasSubstr("has no modes"));
  // Its options are those of finished modes.
  const Outcome option = run("flexura-reduce", {(folder_ / "bar.xml").string(), "--modes", "3"});
  EXPECT_EQ(option.exit_code, 2);
  EXPECT_THAT(option.err, HasSubstr("--modes is for parts that are reduced here"));
}

// Moments of inertia of points are those of a body, whatever their number: three make a flat one.  None where one principal moment is
// made greater than the others together.
TEST_F(FlexDataFiles, InertiaThatNoBodyHasIsRefused) {
  std::string text = xml();
  const std::size_t comment = text.find("<!-- Flexura:");
  text.erase(comment, text.find("-->", comment) + 3 - comment);
  folder_.write("other.xml", text);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    mbs::chance::Chance chance(seed);
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (int k = 2 + chance.below(3); k > 0; --k) {
      const Eigen::Vector3d x = chance.vector(0.5);
      second += x * x.transpose();
    }
    const bool flat_or_full = chance.flip(0.5);
    if (!flat_or_full) {  // int z^2 dm below zero along some direction, by a tenth of the whole
      const Eigen::Vector3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(second).eigenvectors().col(0);
      second -= (n.dot(second * n) + 0.1 * second.trace()) * n * n.transpose();
    }
    const Eigen::Matrix3d J = second.trace() * Eigen::Matrix3d::Identity() - second;
    const Outcome outcome = read(
        "other.toml",
        fmt::format(
            "[flexdata]\nfile = \"other.xml\"\nmass = 3\ncentre = [0.5, 0, 0]\ninertia = [{:.17g}, {:.17g}, "
            "{:.17g}, {:.17g}, {:.17g}, {:.17g}]\n",
            J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(1, 2), J(2, 0)));
    EXPECT_EQ(outcome.exit_code, flat_or_full ? 0 : 2) << seed << outcome.err;
    if (!flat_or_full) EXPECT_THAT(outcome.err, HasSubstr("none greater than the others together")) << seed;
  }
}

// A file with our comment is in kg and m, whatever the part file says.
TEST_F(FlexDataFiles, UnitsBesideTheFilesOwnIntegralsAreRefused) {
  for (const char* key : {"unit = \"mm\"", "unit = \"m\"", "mass_unit = \"t\""}) {
    const Outcome outcome = read("own.toml", fmt::format("[flexdata]\nfile = \"bar.xml\"\n{}\n", key));
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("brings its mass and inertia along"), HasSubstr("mass_unit out")));
  }
  EXPECT_EQ(read("own.toml", "[flexdata]\nfile = \"bar.xml\"\n").exit_code, 0);
}

TEST_F(FlexDataFiles, InUtf16AreToldTheirEncoding) {
  for (const bool has_mark : {true, false}) {
    std::string wide = has_mark ? std::string("\xff\xfe", 2) : "";
    for (const char c : xml()) wide += c, wide += '\0';
    const Outcome outcome = read("wide.xml", wide);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("UTF-16")) << has_mark;
  }
}

// Modes at a few nodes are no geometry: the file is known, and what to give instead is said.
TEST_F(FlexDataFiles, AsGeometryAreAnsweredWithTheKey) {
  folder_.write("arm.xml",
                "<Reference_FlexData\n id = \"1\"\n num_nodes = \"9\"\n num_sel_modes = \"0\"\n "
                "num_sel_nodes = \"0\">\n"
                "</Reference_FlexData>\n");
  const auto part =
      folder_.write("part.toml",
                    "[geometry]\nfile = \"arm.xml\"\n[material.steel]\nyoung = \"210 GPa\"\npoisson = "
                    "0.3\ndensity = 7850\n");
  const Outcome outcome = run("flexura-reduce", {part.string(), "-o", (folder_ / "x.se.h5").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("is a FlexData file"), HasSubstr("[flexdata]")));
}

}  // namespace
}  // namespace flexura::test
