// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Bodies of an imported assembly made flexible by `flexura simulate --reduce`, as a user does it.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "cases/assembly/drawing.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using namespace drawing;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const gp_Dir kY(0, 1, 0);

// A bar of 400 mm x 10 mm x 6 mm that hangs on a pin of a block.
class Hanging : public testing::Test {
 protected:
  Hanging() {
    Assembly a("hanging");
    a.place(a.part("block", box({-60, 5, -30}, {60, 60, 30}) + cylinder({0, -5, 0}, kY, 2, 10) +
                                cylinder({0, -6, 0}, kY, 4, 3) - cylinder({0, -3, 0}, kY, 1.0, 1.0)),
            at({0, 0, 0}));
    a.place(a.part("bar", box({-5, -3, -390}, {5, 3, 10}) - cylinder({0, -3, 0}, kY, 2, 6), 7850),
            at({0, 0, 0}));
    a.write(folder / "a.step");
    const Outcome o = run("flexura", {"import", folder / "a.step", "-o", folder / "out"});
    EXPECT_EQ(o.exit_code, 0) << o.err;
  }
  Outcome simulate(std::vector<std::string> more) const {
    std::vector<std::string> words = {
        "simulate", folder / "out/mechanism.toml", "-o", folder / "r.h5", "--end-time", "0.002"};
    words.insert(words.end(), more.begin(), more.end());
    return run("flexura", words);
  }
  std::vector<fs::path> reduced() const {
    std::vector<fs::path> list;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder / "out/parts/reduced", none))
      if (entry.path().string().ends_with(".se.h5")) list.push_back(entry.path());
    return list;
  }
  Folder folder;
};

const std::string kFlexible = "body.bar.fidelity=modal";

TEST_F(Hanging, IsReducedOnceAndBendsAsABarDoes) {
  const std::string rigid = read_text(folder / "out/parts/bar.se.h5");
  const Outcome without = simulate({"--set", kFlexible});
  EXPECT_NE(without.exit_code, 0);  // a rigid superelement cannot deform
  EXPECT_THAT(without.err, HasSubstr("flexura simulate --reduce"));
  const Outcome o = simulate({"--reduce", "--set", kFlexible});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("bar.toml reduced in"));
  EXPECT_EQ(read_text(folder / "out/parts/bar.se.h5"), rigid);  // nothing of the user's is replaced
  ASSERT_EQ(reduced().size(), 1U);
  const superelement::Superelement se = superelement::read(reduced()[0], {.mesh_error = true});
  // Euler and Bernoulli's free bar bends first over its 6 mm: (4.730 / L)^2 sqrt(E I / rho A) / 2 pi; a bore of 4 mm near the
  // end, shear and turning of sections are worth less than 2 %.
  const double L = 0.4, h = 0.006;
  const double f_1 =
      std::pow(4.7300407 / L, 2) * std::sqrt(210e9 / 7850.0 * h * h / 12.0) / (2.0 * std::numbers::pi);
  ASSERT_TRUE(se.mesh_error && !se.mesh_error->modes.empty());
  const Outcome modes = run("flexura", {"modes", reduced()[0], "--json"});
  ASSERT_EQ(modes.exit_code, 0) << modes.err;
  bool found = false;
  for (const superelement::MeshError::Mode& mode : se.mesh_error->modes)
    found = found || std::abs(mode.frequency_hz / f_1 - 1.0) < 0.02;
  EXPECT_TRUE(found) << f_1 << " Hz is none of " << se.mesh_error->modes.front().frequency_hz;
  // Again: from the cache.
  const Outcome again = simulate({"--reduce", "--set", kFlexible});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, AllOf(HasSubstr("was reduced before"), Not(HasSubstr("reduced in"))));
  // Another material is another part.
  const fs::path part = folder / "out/parts/bar.toml";
  folder.write("out/parts/bar.toml", replaced(read_text(part), "210 GPa", "70 GPa"));
  EXPECT_EQ(simulate({"--reduce", "--set", kFlexible}).exit_code, 0);
  EXPECT_EQ(reduced().size(), 2U);
}

// A joint's marker that stands on the bore by its position, as the page writes it, and on no interface.
TEST_F(Hanging, MarkerOnNoInterfaceTakesThatOfItsFace) {
  std::string text = read_text(folder / "out/mechanism.toml");
  const auto table = text.find("[body.bar.marker."), on = text.find("on = \"face", table);
  ASSERT_NE(on, std::string::npos);
  const std::string line = text.substr(on, text.find('\n', on) + 1 - on),
                    face = line.substr(6, line.size() - 8);
  folder.write("out/mechanism.toml", text.erase(on, line.size()));
  const Outcome o = simulate({"--reduce", "--set", kFlexible});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  ASSERT_EQ(reduced().size(), 1U);
  const superelement::Superelement se = superelement::read(reduced()[0], {});
  ASSERT_EQ(se.interfaces.size(), 1U);
  EXPECT_EQ(se.interfaces[0].name, face);
}

TEST_F(Hanging, WhatCannotBeReducedIsSaidInOneSentence) {
  const fs::path part = folder / "out/parts/bar.toml";
  const std::string good = read_text(part);
  folder.write("out/parts/bar.toml", replaced(good, "poisson = 0.3", "poisson = 0.7"));
  Outcome o = simulate({"--reduce", "--set", kFlexible});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, AllOf(HasSubstr("bar.toml"), HasSubstr("poisson")));
  EXPECT_FALSE(fs::exists(folder / "r.h5"));
  fs::remove(part);
  o = simulate({"--reduce", "--set", kFlexible});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, AllOf(HasSubstr("bar.toml"), HasSubstr("is not there either")));
  // Rigid it needs none.
  EXPECT_EQ(simulate({"--reduce"}).exit_code, 0);
}

}  // namespace
}  // namespace flexura::test
