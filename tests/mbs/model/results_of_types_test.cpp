// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the reference page says that elements of a type give to results is what they give.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

/// Elements by type, each with the other keys that it needs between the bodies of kThreeBodies and a beam "rope".
using Elements = std::map<std::string, std::string>;

const std::string kEnds = "from = \"a.out\"\nto = \"b.in\"\n";
const std::string kPath = "path = [\"rope.root\", \"rope.middle\", \"rope.tip\"]\n";

const Elements kForces = {
    {"spring_damper", kEnds + "stiffness = 5\n"},
    {"line_force", kEnds + "value = 3\n"},
    {"force", "marker = \"a.out\"\nx = 1\n"},
    {"torque", "marker = \"a.out\"\nx = 1\n"},
    {"joint_force", "joint = \"third\"\nvalue = 2\n"},
    {"joint_spring_damper", "joint = \"second\"\ncoordinate = \"angle\"\nstiffness = 2\n"},
    {"bushing", kEnds + "stiffness = [1, 2, 3]\n"},
    {"actuator", "joint = \"third\"\ncommand = 2\ntime_constant = 0.1\n"},
    {"moving_load", kPath + "place = \"t\"\nz = -1\n"},
    {"contact", kEnds + "radius = 0.1\nstiffness = 1000\n"},
    {"bump_stop", "joint = \"second\"\ncoordinate = \"angle\"\nlower = -1\nstiffness = 1000\n"},
    {"gear_mesh",
     "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nradius_1 = 0.1\nradius_2 = 1\nstiffness = 1000\n"},
    {"involute_mesh", kEnds + "module = 0.05\nteeth_1 = 20\nteeth_2 = 30\nwidth = 0.1\n"},
    {"bearing", kEnds + "stiffness_matrix = [[9, 0, 0, 0, 0], [0, 9, 0, 0, 0], [0, 0, 9, 0, 0], "
                        "[0, 0, 0, 9, 0], [0, 0, 0, 0, 9]]\n"},
    {"rolling_bearing", kEnds + "elements = 8\ndiameter = 0.01\npitch_diameter = 0.05\n"},
    {"journal_bearing", kEnds + "radius = 0.05\nlength = 0.05\nclearance = 1e-3\nviscosity = 0.05\n"},
    {"joint_friction", "joint = \"third\"\ncoulomb = 1\n"},
    {"stick_slip", "joint = \"third\"\ncoulomb = 1\nstick_stiffness = 1000\n"},
};

const Elements kConstraints = {
    {"point_on_line", kEnds},
    {"point_on_plane", kEnds},
    {"point_on_curve", kEnds + "points = [[1, 0, 0], [0.8, 0.9, 0.3], [-0.2, 1.4, 0.5]]\n"},
    {"point_on_path", kPath + "to = \"b.in\"\norientation = \"fixed\"\nends = \"straight\"\n"},
    {"orientation", kEnds},
    {"parallel", kEnds},
    {"perpendicular", kEnds},
    {"distance", kEnds + "length = 1\n"},
    {"coupler", "joints = [\"second.angle\", \"third\"]\nfactors = [1, 2]\n"},
    {"gear", "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nteeth_1 = 1\nteeth_2 = 2\n"},
    {"rack_and_pinion", "rack = \"third\"\npinion = \"second.angle\"\nradius = 1\n"},
    {"rolling_disc", kEnds + "radius = 0.3\n"},
};

const std::string kRope = R"toml(
[body.rope]
fidelity = "beam"
[body.rope.beam]
to = [1, 0, 0]
elements = 2
young = 1e9
density = 1000
diameter = 0.02
[body.rope.beam.point.middle]
at = 0.5
[joint.rope]
type = "six_dof"
from = "ground"
to = "rope.root"
)toml";

std::set<std::string> split(const std::string& names) {
  std::set<std::string> list;
  std::istringstream in(names);
  for (std::string name; std::getline(in >> std::ws, name, ',');) list.insert(name);
  return list;
}

/// `outputs` against what the type says; what it says "of" other settings need not be there.
template <class Type>
void compare(const Type& type, const std::vector<OutputInfo>& outputs) {
  SCOPED_TRACE(type.name);
  std::set<std::string> there;
  for (const OutputInfo& output : outputs) {
    there.insert(output.name);
    const auto told = std::find_if(type.gives.begin(), type.gives.end(),
                                   [&](const Given& g) { return split(g.names).contains(output.name); });
    if (told == type.gives.end()) {
      // A coupler's count and those of a gear between slides follow from the joints: described in words.
      EXPECT_TRUE(type.name == "coupler" || type.name == "gear") << output.name << " is not told";
      continue;
    }
    const std::string unit = input::si_unit(output.dimension);
    EXPECT_TRUE(unit == told->unit || told->unit.starts_with(unit + " or ") ||
                told->unit.ends_with(" or " + unit))
        << output.name << " is in \"" << unit << "\", told \"" << told->unit << '"';
    EXPECT_FALSE(unit.empty() && !told->unit.empty()) << output.name << " has no unit";
  }
  for (const Given& given : type.gives) {
    bool is_there = given.names == "contact" || given.names == "rate";  // of the mechanism, beside its own
    for (const std::string& name : split(given.names)) is_there = is_there || there.contains(name);
    EXPECT_TRUE(is_there) << "told, but not there: " << given.names;
  }
}

class ResultsOfTypes : public MechanismFileTest {
 protected:
  MechanismFile with(const std::string& table, const std::string& type, const std::string& keys) const {
    return read(kThreeBodies + kRope + "[" + table + ".it]\ntype = \"" + type + "\"\n" + keys);
  }
};

TEST_F(ResultsOfTypes, OfForcesAreAsTheReferenceSays) {
  for (const ForceType& type : force_types()) {
    // Their elements need superelements: load_case_test.cpp and tests/mbs/surfaces.
    if (type.name == "user" || type.name == "distributed_load" || type.name == "surface_contact") continue;
    ASSERT_TRUE(kForces.contains(type.name)) << type.name << " has no sample here";
    compare(type, with("force", type.name, kForces.at(type.name)).description.forces.at(0)->outputs());
  }
}

TEST_F(ResultsOfTypes, OfConstraintsAreAsTheReferenceSays) {
  for (const ConstraintType& type : constraint_types()) {
    if (type.name == "user") continue;
    ASSERT_TRUE(kConstraints.contains(type.name)) << type.name << " has no sample here";
    compare(
        type,
        with("constraint", type.name, kConstraints.at(type.name)).description.constraints.at(0)->outputs());
  }
}

// What turns has a torque along its coordinate, what slides a force.
TEST_F(ResultsOfTypes, TheForceAlongACoordinateHasTheUnitOfTheCoordinate) {
  const auto unit = [&](const std::string& joint) {
    const auto file = with("force", "joint_force", "joint = \"" + joint + "\"\nvalue = 2\n");
    return input::si_unit(file.description.forces.at(0)->outputs().at(0).dimension);
  };
  EXPECT_EQ(unit("second\"\ncoordinate = \"angle"), "N*m");
  EXPECT_EQ(unit("third"), "N");
}

}  // namespace
}  // namespace flexura::mbs
