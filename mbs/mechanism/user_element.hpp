// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/constraints/constraint.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"
#include "mbs/joints/joint.hpp"
#include "mbs/mechanism/differenced.hpp"

/// Joints, constraints, force elements, controls and measures of your own, in a shared library that the program loads when a
/// mechanism file names it.  A library is one source file:
///
///     #include "mbs/mechanism/user_element.hpp"
///     class Magnet final : public flexura::mbs::ForceElement { ... };
///     FLEXURA_ELEMENTS(elements) {
///       elements.forces["magnet"] = [](const flexura::mbs::UserArguments& a) {
///         return std::make_shared<Magnet>(a);
///       };
///     }
///
/// compiled by the compiler that built the program, with the project's root and Eigen on its path:
///
///     g++ -std=c++20 -O2 -shared -fPIC -I FLEXURA -I /usr/include/eigen3 magnet.cpp -o libmagnet.so
///
/// and used as
///
///     [force.pull]
///     type = "user"
///     library = "libmagnet.so"           # beside the mechanism file
///     element = "magnet"
///     markers = ["ground.coil", "ball"]
///     values = { strength = "3e-4" }
///
/// What the classes must do stands in force.hpp (ForceElement), constraint.hpp (Constraint;
/// RelativeConstraint takes rows on a relative pose), joint.hpp (Joint), control.hpp (Control) and measure.hpp (Measure).
/// Derivatives are optional: what a force or a constraint does not differentiate itself (derivatives.hpp) is differenced, all
/// coordinates through, which costs as much as the rest; controls and measures without derivatives are made from
/// DifferencedControl and DifferencedMeasure (differenced.hpp).  A control's one output is a function of its states, or an algebraic
/// state (is_algebraic()), or feeds its inputs through: the last are named in UserElements::direct_controls.  States that change at
/// switches alone say so (is_held()).  Elements are constant: what changes is handed in, and two threads may ask the
/// same element at once.  They may throw std::invalid_argument from the constructor, with one sentence: the
/// program adds file and line.
/// What an element does over a short piece of a way (a bump, a detent) the program cannot know from its code: a step that leaps
/// over it is found for formulas and curves alone.  Let the element read it as a formula (`inputs`), name it a curve
/// (ForceElement::curves()), or be a switch where it begins and ends (HasStates::switching); else bound the step
/// (solver.max_step).
///
/// cases/user_elements holds one of each.
namespace flexura::mbs {

/// What a mechanism file says to an element.
struct UserArguments {
  std::string name;          ///< of the element: pass it on to the base class
  std::vector<int> markers;  ///< of the key `markers`, in its order: indices for Kinematics and Loads
  std::vector<CoordinateRef> joints;  ///< of the key `joints`: coordinates
  std::vector<std::shared_ptr<const Expression>>
      inputs;                            ///< of the key `inputs`: formulas to evaluate(signals)
  std::map<std::string, double> values;  ///< of the key `values`, in SI

  /// Signals that the formulas of `inputs` read: for reads() of an element that evaluates them.
  std::vector<int> reads() const {
    std::vector<int> all;
    for (const auto& input : inputs)
      for (const int k : input->reads()) all.push_back(k);
    return all;
  }

  double value(const std::string& key) const {
    const auto found = values.find(key);
    if (found == values.end()) throw std::invalid_argument("values." + key + " is missing");
    return found->second;
  }
  double value(const std::string& key, double otherwise) const {
    const auto found = values.find(key);
    return found == values.end() ? otherwise : found->second;
  }
  /// Throw unless there are so many.
  void require_markers(std::size_t n) const { require("markers", markers.size(), n); }
  void require_joints(std::size_t n) const { require("joints", joints.size(), n); }
  void require_inputs(std::size_t n) const { require("inputs", inputs.size(), n); }

 private:
  static void require(const std::string& key, std::size_t given, std::size_t wanted) {
    if (given != wanted)
      throw std::invalid_argument(key + " has " + std::to_string(given) + " entries, " +
                                  std::to_string(wanted) + " are wanted");
  }
};

/// What a library offers, by name.
struct UserElements {
  template <class Element>
  using Makers = std::map<std::string, std::function<std::shared_ptr<const Element>(const UserArguments&)>>;
  Makers<ForceElement> forces;
  Makers<Constraint> constraints;
  Makers<Joint> joints;                       ///< have name and values only
  Makers<Control> controls, direct_controls;  ///< have name, inputs and values; the second feed through
  Makers<Measure> measures;                   ///< have name, markers, inputs and values
};

}  // namespace flexura::mbs

#define FLEXURA_TEXT_OF(x) #x
#define FLEXURA_TEXT(x) FLEXURA_TEXT_OF(x)
/// Program and library must agree on it: both see the same classes laid out in the same way. What lays them
/// out are Eigen and the standard library: g++ and clang use the same one, and the same binary interface.
#define FLEXURA_INTERFACE                                                                                       \
  "6, libstdc++ " FLEXURA_TEXT(_GLIBCXX_RELEASE) ", Eigen " FLEXURA_TEXT(EIGEN_WORLD_VERSION) "." FLEXURA_TEXT( \
      EIGEN_MAJOR_VERSION) ", alignment " FLEXURA_TEXT(EIGEN_MAX_ALIGN_BYTES) ", malloc " FLEXURA_TEXT(EIGEN_MALLOC_ALREADY_ALIGNED)

#define FLEXURA_ELEMENTS(elements)             \
  extern "C" const char* flexura_interface() { \
    return FLEXURA_INTERFACE;                  \
  }                                            \
  extern "C" void flexura_elements(::flexura::mbs::UserElements& elements)
