// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every mechanism file: a key of a body that says nothing of what the body is made of is refused by its name, and no other; what
// a file says does not depend on how many files place it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>

#include "mbs/file/elements/element_types.hpp"
#include "mbs/joints/joint.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/study/parts_on_demand.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::mbs {
namespace {

using chance::Chance;
using ::testing::HasSubstr;
using ::testing::Not;

// What a key goes with, as docs/MECHANISM_FILE says in words.
struct KeyCase {
  const char *name, *line;
  bool of_rigid, of_superelement, of_beam;
};
const KeyCase kKeys[] = {
    {"center", "center = [0.1, 0, 0]", true, false, false},
    {"inertia", "inertia = [1, 1, 1]", true, false, false},
    {"velocity", "velocity = [1, 0, 0]", true, true, true},
    {"angular_velocity", "angular_velocity = [0, 1, 0]", true, true, true},
    {"position", "position = [0, 0, 1]", true, true, true},
    {"modes", "modes = 2", false, true, true},
    {"max_frequency", "max_frequency = \"1 MHz\"", false, true, true},
    {"coupling", "coupling = \"partial\"", false, true, true},
    {"attachments", "attachments = \"none\"", false, true, true},
    {"response_frequency", "response_frequency = 0", false, true, true},
    {"frame", "frame = \"mean_axis\"", false, true, true},
    {"boundary", "boundary = \"free\"", false, true, true},
    {"critical_above", "critical_above = \"1 MHz\"", false, true, true},
    {"rayleigh_alpha", "rayleigh_alpha = 1", false, true, true},
    {"rayleigh_beta", "rayleigh_beta = 1e-9", false, true, true},
    {"stress", "stress = false", false, true, false},
};

TEST_F(MechanismFileTest, KeysThatSayNothingOfTheBodyAreRefusedAndNoOthers) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(3).se);
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Chance chance(seed);
    const int kind = chance.below(3);
    std::string text = "[body.b]\n";
    // A superelement that does not deform is the choice of one run; its keys stay for the others.
    if (kind == 0) text += "mass = 2\n";
    if (kind == 1) text += "superelement = \"beam.se.h5\"\n";
    if (kind == 1 && chance.flip(0.5))
      text += chance.flip(0.5) ? "fidelity = \"rigid\"\n" : "fidelity = \"modal\"\n";
    if (kind == 2) text += chance.flip(0.5) ? "fidelity = \"beam\"\n" : "fidelity = \"rigid\"\n";
    std::vector<const KeyCase*> foreign, own;
    for (const KeyCase& key : kKeys) {
      if (!chance.flip(0.15)) continue;
      const bool fits = kind == 0 ? key.of_rigid : kind == 1 ? key.of_superelement : key.of_beam;
      (fits ? own : foreign).push_back(&key);
      text += std::string(key.line) + "\n";
    }
    if (kind == 2)
      text +=
          "[body.b.beam]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\ndiameter = 0.02\nyoung = 210e9\npoisson = "
          "0.3\ndensity = 7850\n"
          "elements = 4\n";
    const std::string said = refusal(text);
    if (foreign.empty()) {
      EXPECT_EQ(said, "accepted") << "seed " << seed << "\n" << text;
      continue;
    }
    ++refused;
    for (const KeyCase* key : foreign)
      EXPECT_THAT(said, HasSubstr(key->name)) << "seed " << seed << "\n" << text;
    for (const KeyCase* key : own)
      if (std::string(key->name) != "velocity")  // in "angular_velocity", of which nothing is said either
        EXPECT_THAT(said, Not(HasSubstr(key->name))) << "seed " << seed << "\n" << text;
    EXPECT_THAT(said, HasSubstr("away"));
  }
  EXPECT_GT(refused, 100);  // three in four of the files of few keys have a foreign one
}

TEST_F(MechanismFileTest, ABodyOfMassAloneIsNotToldToDeform) {
  for (const char* const fidelity : {"modal", "modal-stiffened", "ked", "static"})
    EXPECT_THAT(refusal(fmt::format("[body.b]\nmass = 1\nfidelity = \"{}\"\n", fidelity)),
                HasSubstr("does not deform; give a superelement"));
  for (const char* const fidelity : {"rigid", "auto"})
    EXPECT_EQ(refusal(fmt::format("[body.b]\nmass = 1\nfidelity = \"{}\"\n", fidelity)), "accepted");
}

// Of every table: places and directions say in which frame they stand.
void add_vectors(const input::TableSchema& table, std::string path, std::vector<std::string>& without) {
  path += "." + table.name;
  for (const input::Key& key : table.keys) {
    if (key.kind == input::Kind::vector3 || key.kind == input::Kind::vectors3) {
      const std::string doc = key.doc + table.doc;
      const bool says =
          std::ranges::any_of(std::array{"frame", " axes", "in F", "section's y"},
                              [&](const char* word) { return doc.find(word) != std::string::npos; });
      if (!says) without.push_back(path + "." + key.name + ": " + key.doc);
    }
    if (key.table) add_vectors(*key.table, path, without);
  }
  for (const auto& [name, variant] : table.variants) add_vectors(variant, path + "." + name, without);
}

TEST(MechanismSchema, PlacesAndDirectionsNameTheirFrame) {
  std::vector<std::string> without;
  add_vectors(mechanism_schema(solver_schema()), "", without);
  EXPECT_THAT(without, ::testing::IsEmpty());
}

// What the reference says of components (mechanism_schema.cpp): in the axes of F.
TEST(MechanismSchema, ComponentsOfJointsStandInTheAxesOfTheFirstMarker) {
  int seen = 0;
  for (const JointType& type : joint_types()) {
    const auto joint = make_joint(type.name);
    const auto speeds = joint->speeds();
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Chance chance(seed);
      std::vector<double> q(static_cast<std::size_t>(joint->n_p()));
      joint->coordinates_of({chance.rotation(), chance.vector(1.0)}, q.data());
      MotionMatrix S(6, joint->n_v());
      joint->motion(q.data(), S);
      for (std::size_t j = 0; j < speeds.size(); ++j)
        for (int axis = 0; axis < 3; ++axis)
          for (const auto& [name, row] : {std::pair("omega_", axis), std::pair("v_", 3 + axis)})
            if (speeds[j].name == std::string(name) + "xyz"[axis]) {
              EXPECT_LT((S.col(static_cast<Eigen::Index>(j)) - Vector6d::Unit(row)).norm(), 1e-12)
                  << type.name << "." << speeds[j].name;
              ++seen;
            }
    }
  }
  EXPECT_GE(seen, 20 * 20);
}

// Files that place one another by chance, down to leaf.toml with its body "rod".
class Placed {
 public:
  Placed(std::uint64_t seed, const std::filesystem::path& folder) : chance_(seed), folder_(folder) {
    text_ = place(chance_.below(3), "", "");
  }
  std::string text_;
  std::vector<std::string> rods_, keys_;       ///< "a1.b2.rod", "subsystem.a1.subsystem.b2.body.rod"
  std::vector<std::string> gravities_differ_;  ///< subsystems that state another gravity than the whole

 private:
  std::string place(int depth, const std::string& prefix, const std::string& keys) {
    std::string text;
    if (prefix.empty() || chance_.flip(0.4)) {
      const bool differs = !prefix.empty() && chance_.flip(0.5);
      text = differs ? "gravity = [0, 0, -1.62]\n" : "gravity = [0, -9.81, 0]\n";
      if (differs) gravities_differ_.push_back(prefix.substr(0, prefix.size() - 1));
    }
    const int n = 1 + chance_.below(2);
    for (int i = 0; i < n; ++i) {
      const std::string name = fmt::format("s{}", i), below = prefix + name + ".",
                        keys_below = keys + "subsystem." + name + ".";
      const bool is_leaf = depth == 0 || chance_.flip(0.3);
      std::string file = "leaf.toml";
      if (is_leaf) {
        rods_.push_back(below + "rod");
        keys_.push_back(keys_below + "body.rod");
      } else {
        file = fmt::format("f{}.toml", ++n_files_);
        const std::string its = place(depth - 1, below, keys_below);
        std::ofstream(folder_ / file) << its;
      }
      text += fmt::format("[subsystem.{}]\nfile = \"{}\"\nposition = [{}, 0, 0]\n", name, file, i);
      if (is_leaf) text += "parameters = { reach = 0.2 }\n";
    }
    return text;
  }
  Chance chance_;
  std::filesystem::path folder_;
  int n_files_ = 0;
};

const char* const kLeaf = R"toml(
[parameters]
reach = 0.1
[body.rod]
superelement = "rod.se.h5"
[body.rod.marker.half]
on = "tip"
position = ["reach", 0, 0]
[joint.j]
type = "fixed"
from = "ground"
to = "rod.root"
)toml";
const char* const kPart = R"toml(
[material.steel]
young = "210 GPa"
poisson = 0.3
density = 7850
[section.s]
type = "circle"
diameter = "20 mm"
[node.root]
position = [0, 0, 0]
[node.tip]
position = [0.4, 0, 0]
[member.m]
nodes = ["root", "tip"]
section = "s"
elements = 2
[interface.root]
[interface.tip]
[modes]
count = 2
)toml";

TEST_F(MechanismFileTest, GravityThatDoesNotCountIsSaidForEachSubsystemThatStatesIt) {
  file("[body.rod]\nmass = 1\ninertia = [1, 1, 1]\n[parameters]\nreach = 0.1\n", "leaf.toml");
  int said = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Placed placed(seed, folder_);
    const MechanismFile read_file = read(placed.text_);
    EXPECT_EQ(read_file.description.gravity, Vector3d(0.0, -9.81, 0.0));
    EXPECT_EQ(read_file.notes.size(), placed.gravities_differ_.size()) << "seed " << seed;
    for (const std::string& name : placed.gravities_differ_)
      EXPECT_THAT(read_file.notes, ::testing::Contains(::testing::AllOf(
                                       HasSubstr("subsystem \"" + name + "\""), HasSubstr("[0, 0, -1.62]"),
                                       HasSubstr("[0, -9.81, 0]"))))
          << "seed " << seed;
    said += static_cast<int>(placed.gravities_differ_.size());
  }
  EXPECT_GT(said, 20);
}

// One reduction; the rest comes from the cache.
TEST_F(MechanismFileTest, BodiesOfSubsystemsAreReducedOnDemandWhereverTheyStand) {
  file(kLeaf, "leaf.toml");
  file(kPart, "rod.toml");
  std::string told;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Placed placed(seed, folder_);
    const auto top = file(placed.text_);
    int made = 0;
    study::PartsOnDemand parts(
        top, FLEXURA_BIN_DIR, {}, false,
        {.progress = [](std::string_view) {},
         .note = [&](const std::string& s) { made += s.find(" reduced in ") != std::string::npos; },
         .warning = [&](const std::string& s) { told += s; }});
    const std::vector<std::string> set = parts.provide({}, {});
    EXPECT_EQ(made, seed == 1 ? 1 : 0);
    ASSERT_EQ(set.size(), placed.keys_.size()) << "seed " << seed;
    for (const std::string& key : placed.keys_)
      EXPECT_THAT(set, ::testing::Contains(::testing::StartsWith(key + ".superelement="))) << "seed " << seed;
    const MechanismFile with = read_mechanism(top, solver_schema(), set);
    for (const std::string& rod : placed.rods_) {
      const auto& bodies = with.description.bodies;
      const auto body = std::ranges::find(bodies, rod, &BodyDescription::name);
      ASSERT_NE(body, bodies.end()) << rod;
      ASSERT_TRUE(body->flexible) << rod;
    }
  }
}

}  // namespace
}  // namespace flexura::mbs
