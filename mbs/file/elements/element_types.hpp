// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/schema.hpp"
#include "mbs/constraints/constraint.hpp"
#include "mbs/controls/control.hpp"
#include "mbs/file/elements/read_context.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/joints/joint.hpp"
#include "mbs/measures/measure.hpp"

/// How the types of elements stand in a mechanism file: names, keys, words of the reference page, readers.  The
/// elements themselves (mbs/joints, mbs/constraints, mbs/forces, mbs/measures, mbs/controls) know no file; what each
/// is called and how its keys become an argument of its constructor stands in joints.cpp, constraints.cpp, forces.cpp,
/// contacts.cpp, surface_contacts.cpp, gears.cpp, bearings.cpp, frictions.cpp, measures.cpp and controls.cpp, one function for each type.
namespace flexura::mbs {

struct JointType {
  std::string name;
  std::string doc;                    ///< for the reference page, with the names other codes use
  std::vector<std::string> synonyms;  ///< accepted too
  std::vector<input::Key> keys;       ///< beyond those every joint has and those of its coordinates
  std::unique_ptr<Joint> (*make)(const input::Section*);  ///< nullptr: all keys at their defaults
};

/// What elements of a type give to results, for the reference page; tests/mbs/model/results_of_types_test.cpp holds it
/// against outputs() of elements.
struct Given {
  std::string names;  ///< "force" or "force_x, force_y": completes "NAME."; empty: the element's own name
  std::string unit;   ///< in SI, "N or N*m" where it depends on the joint; empty: none
  std::string doc;    ///< which, and in which axes
};

/// `keys` beside type.
template <class Element>
struct ElementType {
  std::string name;
  std::string doc;
  std::vector<input::Key> keys;
  std::vector<Given> gives;
  std::shared_ptr<const Element> (*read)(const std::string& name, const input::Section&, const ReadContext&);
  /// Keys that name bodies on whose surfaces it acts: these are then read with the bodies.
  std::vector<std::string> surfaces_of = {};
  /// Keys that name bodies whose surfaces it sees whole.
  std::vector<std::string> meshes_of = {};
  std::vector<std::string> synonyms = {};  ///< accepted too: what other programs call it
  bool is_read_last = false;               ///< a measure that names any other element: read after all of them
};
using ForceType = ElementType<ForceElement>;
using MeasureType = ElementType<Measure>;
using ConstraintType = ElementType<Constraint>;
struct ControlType : ElementType<Control> {
  /// As the element says: its output can be read by later controls and forces only.
  bool (*feeds_through)(const input::Section&) = [](const input::Section&) { return false; };
};

/// The type with the names by which other programs know it.
template <class Type>
Type also_called(Type type, std::vector<std::string> synonyms) {
  type.synonyms = std::move(synonyms);
  return type;
}

/// All types, in the order of the reference page.
const std::vector<JointType>& joint_types();
const std::vector<ConstraintType>& constraint_types();
const std::vector<ForceType>& force_types();
const std::vector<MeasureType>& measure_types();
const std::vector<ControlType>& control_types();

/// Parts of force_types().
std::vector<ForceType> contact_types();
std::vector<ForceType> gear_types();
std::vector<ForceType> bearing_types();
std::vector<ForceType> friction_types();
std::vector<ForceType> surface_contact_types();

}  // namespace flexura::mbs
