// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the reference page says that elements of a type give to results is what they give.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/examples.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

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
    return read(std::string(kThreeBodies) + "[" + table + ".x]\ntype = \"" + type + "\"\n" + keys);
  }
};

TEST_F(ResultsOfTypes, OfForcesAreAsTheReferenceSays) {
  for (const ForceType& type : force_types()) {
    // Their elements need superelements: load_case_test.cpp and tests/mbs/surfaces.
    if (type.name == "user" || type.name == "distributed_load" || type.name == "surface_contact") continue;
    ASSERT_TRUE(force_examples().contains(type.name)) << type.name << " has no sample here";
    compare(type,
            with("force", type.name, force_examples().at(type.name)).description.forces.at(0)->outputs());
  }
}

TEST_F(ResultsOfTypes, OfConstraintsAreAsTheReferenceSays) {
  for (const ConstraintType& type : constraint_types()) {
    if (type.name == "user") continue;
    ASSERT_TRUE(constraint_examples().contains(type.name)) << type.name << " has no sample here";
    compare(type, with("constraint", type.name, constraint_examples().at(type.name))
                      .description.constraints.at(0)
                      ->outputs());
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
