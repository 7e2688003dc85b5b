// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// FlexData (MotionSolve's Reference_FlexData) out of a superelement and back, and from other programs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "mbs/superelement/file.hpp"
#include "mbs/superelement/modes.hpp"
#include "tests/app/command.hpp"

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
  // Too few modes to move each interface by itself.
  const Outcome few = run(
      "flexura", {"export", folder_ / "bar.se.h5", "-f", "flexdata", "-o", folder_ / "few.xml", "-n", "4"});
  ASSERT_EQ(few.exit_code, 0) << few.err;
  EXPECT_THAT(refusal(read_text(folder_ / "few.xml")),
              AllOf(HasSubstr("4 modes"), HasSubstr("12 dofs need 6 modes at least")));
  // Its options are those of finished modes.
  const Outcome option = run("flexura-reduce", {(folder_ / "bar.xml").string(), "--modes", "3"});
  EXPECT_EQ(option.exit_code, 2);
  EXPECT_THAT(option.err, HasSubstr("--modes is for parts that are reduced here"));
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
