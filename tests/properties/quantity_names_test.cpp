// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every mechanism: a measure, an input or a control with the name of another quantity is refused before the run, by both names,
// and one with any other name is there. Tables have names that formulas do not know already. Bodies of subsystems are not called as
// others are.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "mbs/mechanism/mechanism.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::mbs {
namespace {

using chance::Chance;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<std::string> names_of(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const auto& quantity : mechanism.quantities()) names.push_back(quantity.name);
  return names;
}

TEST_F(MechanismFileTest, NamesOfQuantitiesAreGivenOnce) {
  int refused = 0, accepted = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Chance chance(seed);
    const char* const joints[] = {"revolute", "prismatic", "spherical", "cylindrical", "universal"};
    std::string text = fmt::format(
        "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.k]\ntype = \"{}\"\nfrom = \"ground\"\nto = \"b\"\n"
        "[body.free]\nmass = 1\ninertia = [1, 1, 1]\nposition = [0, 0, 2]\n",
        chance.one_of(joints));
    if (chance.flip(0.5))
      text +=
          "[force.pull]\ntype = \"line_force\"\nfrom = \"ground\"\nto = \"free\"\nvalue = \"-2 * "
          "pull.length\"\n";
    if (chance.flip(0.5))
      text += "[constraint.far]\ntype = \"distance\"\nfrom = \"b\"\nto = \"free\"\nlength = 2\n";
    std::vector<std::string> names = names_of(Mechanism(read(text).description));
    names.insert(names.end(), {"energy.input", "energy.dissipated", "energy.balance"});
    const bool is_taken = chance.flip(0.7);
    std::string name = names[static_cast<std::size_t>(chance.below(static_cast<int>(names.size())))];
    if (!is_taken) name += chance.flip(0.5) ? "_too" : ".of_mine";
    const char* const kinds[] = {"measure", "input", "control"};
    const int kind = chance.below(3);
    text += fmt::format("[{}.\"{}\"]\n{}\n", kinds[kind], name,
                        kind == 0   ? "type = \"distance\"\nfrom = \"ground\"\nto = \"free\""
                        : kind == 1 ? "value = \"t\""
                                    : "type = \"state\"\nrate = 1");
    std::vector<std::string> after;
    const std::string said = test::refusal_of([&] { after = names_of(Mechanism(read(text).description)); });
    if (!is_taken) {
      ++accepted;
      EXPECT_EQ(said, "accepted") << "seed " << seed << "\n" << text;
      EXPECT_EQ(std::ranges::count(after, name), 1) << "seed " << seed << "\n" << text;
      continue;
    }
    ++refused;
    if (said.find("taken already in formulas") != std::string::npos) {
      EXPECT_THAT(said, HasSubstr(name))
          << text;  // the reader sees it first: coordinates, measures of elements
      continue;
    }
    EXPECT_THAT(said, AllOf(HasSubstr(fmt::format("\"{}\" is a quantity of ", name)),
                            HasSubstr(fmt::format("of {} \"{}\"", kinds[kind], name))))
        << "seed " << seed << "\n"
        << text;
  }
  EXPECT_GT(refused, 150);
  EXPECT_GT(accepted, 50);
}

TEST_F(MechanismFileTest, TablesHaveNoNameThatFormulasHave) {
  const std::string table = "x = [0, 1]\ny = [0, 1]\n";
  for (const char* name : {"sin", "cos", "tan", "asin", "atan2", "exp", "ln", "log", "sqrt", "abs", "sign",
                           "pow", "mod", "min", "max", "step", "t", "pi", "e"})
    EXPECT_THAT(refusal(fmt::format("[table.{}]\n{}", name, table)),
                AllOf(HasSubstr(fmt::format("table.{}", name)), HasSubstr("meaning of its own in formulas")));
  for (const char* name : {"sine", "lift", "Sin", "e1", "steps"})
    EXPECT_EQ(refusal(fmt::format("[table.{}]\n{}", name, table)), "accepted");
}

TEST_F(MechanismFileTest, BodiesOfSubsystemsAreNotCalledAsOthers) {
  const std::string body = "mass = 1\ninertia = [1, 1, 1]\n";
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Chance chance(seed);
    const char* const names[] = {"p", "q", "s.p", "s.q", "s.r.p", "r.p"};
    // Within `sub` within `top`: bodies p, r.p by a file of its own.
    file("[body.p]\n" + body, "inner.toml");
    std::string sub, top;
    std::vector<std::string> all = {"s.r.p"};
    for (const char* name : names) {
      if (chance.flip(0.25))
        sub += fmt::format("[body.\"{}\"]\n{}", name, body), all.push_back(std::string("s.") + name);
      if (chance.flip(0.25)) top += fmt::format("[body.\"{}\"]\n{}", name, body), all.push_back(name);
    }
    file(sub + "[subsystem.r]\nfile = \"inner.toml\"\n", "sub.toml");
    top += "[subsystem.s]\nfile = \"sub.toml\"\n";
    std::ranges::sort(all);
    const auto twice = std::ranges::adjacent_find(all);
    const std::string said = refusal(top);
    if (twice == all.end())
      EXPECT_EQ(said, "accepted") << "seed " << seed << "\n" << top << sub;
    else
      EXPECT_THAT(said, HasSubstr("in the mechanism, as another body is")) << "seed " << seed << "\n"
                                                                           << top << sub;
  }
}

}  // namespace
}  // namespace flexura::mbs
