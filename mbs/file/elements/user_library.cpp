// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/user_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/file/elements/library_file.hpp"
#include "mbs/mechanism/user_element.hpp"

namespace flexura::mbs {
namespace {

using input::Section;

class Library {
 public:
  explicit Library(const Section& s) {
    const std::filesystem::path path = s.file("library");
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored))
      s.refuse("library", "there is no such file",
               "paths start at the folder of this file; compile it first");
    if (const std::string why = why_not_loadable(path); !why.empty())
      s.refuse("library", why, "compile it again");
    handle_.reset(dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL), [](void* handle) {
      if (handle != nullptr) dlclose(handle);
    });
    if (!handle_) s.refuse("library", "cannot be loaded: " + input::shown_text(dlerror(), 200));
    const auto interface = reinterpret_cast<const char* (*)()>(dlsym(handle_.get(), "flexura_interface"));
    const auto fill = reinterpret_cast<void (*)(UserElements&)>(dlsym(handle_.get(), "flexura_elements"));
    if (interface == nullptr || fill == nullptr)
      s.refuse("library", "has no FLEXURA_ELEMENTS", "mbs/mechanism/user_element.hpp says how it is written");
    const char* const version = interface();
    if (version == nullptr || std::string_view(version) != FLEXURA_INTERFACE)
      s.refuse(
          "library",
          fmt::format("is compiled for the interface {}, this program has {}",
                      version == nullptr ? "\"\"" : input::shown_text(version, 60), FLEXURA_INTERFACE),
          fmt::format("compile it again, without -march=native or -mavx, or with -DEIGEN_MAX_ALIGN_BYTES={} "
                      "-DEIGEN_MALLOC_ALREADY_ALIGNED={}",
                      EIGEN_MAX_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED));
    try {
      fill(elements_);
    } catch (...) {
      s.refuse("library", "throws where it should name its elements", "mend its FLEXURA_ELEMENTS");
    }
  }

  /// An element that keeps its library loaded.
  template <class Element>
  std::shared_ptr<const Element> make(const UserElements::Makers<Element>& makers, const std::string& kind,
                                      const Section& s, const UserArguments& arguments) const {
    const std::string wanted = s.text("element");
    const auto maker = makers.find(wanted);
    if (maker == makers.end()) {
      std::vector<std::string> known;
      for (const auto& [name, make] : makers) known.push_back(name);
      s.refuse("element",
               fmt::format("the library has no {} of this name{}", kind, input::suggestion(wanted, known)));
    }
    std::shared_ptr<const Element> made;
    try {
      if (maker->second == nullptr) s.refuse("element", "the library names it, but cannot make it");
      made = maker->second(arguments);
    } catch (const input::InputError&) {
      throw;
    } catch (const std::exception& error) {
      s.refuse("element", error.what());
    } catch (...) {
      s.refuse("element", "the library throws something that has no words");
    }
    if (!made) s.refuse("element", "the library made nothing of it");
    const Element* const element = made.get();
    // The element goes before the code of its destructor does.
    return std::shared_ptr<const Element>(element,
                                          [made, handle = handle_](const Element*) mutable { made.reset(); });
  }
  const UserElements& elements() const { return elements_; }

 private:
  std::shared_ptr<void> handle_;
  UserElements elements_;  // goes before the library
};

std::vector<input::Key> common_keys() {
  using namespace input;
  return {
      text("library", "shared library beside this file: mbs/mechanism/user_element.hpp says how to write one")
          .required(),
      text("element", "its name there").required(),
      formulas("values", "numbers for it: each a number, a quantity or a formula of parameters")};
}

input::Key key_of_markers() {
  return input::texts("markers", "markers that it sits on, in its order");
}
input::Key key_of_inputs() {
  return input::texts("inputs", "formulas that it reads");
}

std::vector<input::Key> keys_on_markers() {
  std::vector<input::Key> keys = common_keys();
  keys.push_back(key_of_markers());
  keys.push_back(
      input::texts("joints", "joint coordinates that it acts on, \"joint\" or \"joint.coordinate\""));
  keys.push_back(key_of_inputs());
  return keys;
}

UserArguments common_arguments(const std::string& name, const Section& s, const ReadContext& c) {
  UserArguments arguments;
  arguments.name = name;
  for (const auto& [key, formula] : s.formulas("values"))
    arguments.values[key] = c.number_of(s, "values", formula);
  return arguments;
}

void read_markers(const Section& s, const ReadContext& c, UserArguments& arguments) {
  for (const std::string& marker : s.texts("markers"))
    arguments.markers.push_back(c.marker_of(s, "markers", marker));
}

void read_inputs(const Section& s, const ReadContext& c, UserArguments& arguments) {
  for (const std::string& formula : s.texts("inputs"))
    arguments.inputs.push_back(c.expression_of(s, "inputs", formula));
}

UserArguments arguments_of(const std::string& name, const Section& s, const ReadContext& c) {
  UserArguments arguments = common_arguments(name, s, c);
  read_markers(s, c, arguments);
  for (const std::string& joint : s.texts("joints"))
    arguments.joints.push_back(c.coordinate(s, "joints", joint));
  read_inputs(s, c, arguments);
  return arguments;
}

// What would go wrong in silence: states that are none, and an output that follows signals which it should not see.
void require_sound(const Section& s, const Control& control) {
  if (control.n_states() < 0 || control.n_switches() < 0)
    s.refuse("element",
             fmt::format("has {} states and {} switches", control.n_states(), control.n_switches()),
             "mend its n_states() or n_switches()");
  if (control.feeds_through() || control.is_algebraic()) return;
  int last = 0;
  for (const int k : control.reads()) last = std::max(last, k);
  const std::vector<double> unknown(static_cast<std::size_t>(last) + 1,
                                    std::numeric_limits<double>::quiet_NaN());
  std::vector<double> c(static_cast<std::size_t>(control.n_states()) + 1, 0.0);
  control.start(c.data());
  const auto follows = [&] {
    try {
      return std::isnan(control.output(unknown.data(), c.data()));
    } catch (const std::exception&) {  // of a formula, whose value is no number
      return true;
    }
  };
  if (follows())
    s.refuse("element", "gives an output that follows its inputs at once, and does not say so",
             "override feeds_through() and name it in direct_controls");
}

}  // namespace

ForceType user_force() {
  return {"user",
          "A force element of your own, out of a shared library in C++; it names its results.",
          keys_on_markers(),
          {},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const ForceElement> {
            const Library library(s);
            return library.make(library.elements().forces, "force", s, arguments_of(name, s, c));
          }};
}

ConstraintType user_constraint() {
  return {"user",
          "A constraint of your own, out of a shared library in C++; it names its results.",
          keys_on_markers(),
          {},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            const Library library(s);
            return library.make(library.elements().constraints, "constraint", s, arguments_of(name, s, c));
          }};
}

ControlType user_control() {
  ControlType type;
  type.name = "user";
  type.doc = "A control of your own, out of a shared library in C++.";
  type.keys = common_keys();
  type.keys.push_back(key_of_inputs());
  type.feeds_through = [](const Section& s) {
    const Library library(s);
    return library.elements().direct_controls.contains(s.text("element"));
  };
  type.read = [](const std::string& name, const Section& s, const ReadContext& c) {
    const Library library(s);
    UserArguments arguments = common_arguments(name, s, c);
    read_inputs(s, c, arguments);
    const bool direct = library.elements().direct_controls.contains(s.text("element"));
    UserElements::Makers<Control> all = library.elements().controls;
    all.insert(library.elements().direct_controls.begin(), library.elements().direct_controls.end());
    std::shared_ptr<const Control> control = library.make(all, "control", s, arguments);
    require_sound(s, *control);
    if (control->feeds_through() != direct)
      s.refuse("element", direct ? "stands in direct_controls of its library and does not feed through"
                                 : "feeds through and does not stand in direct_controls of its library");
    return control;
  };
  return type;
}

MeasureType user_measure() {
  MeasureType type;
  type.name = "user";
  type.doc = "A measure of your own, out of a shared library in C++.";
  type.keys = common_keys();
  type.keys.push_back(key_of_markers());
  type.keys.push_back(key_of_inputs());
  type.gives = {{"", "that of its dimension()", ""}};
  type.read = [](const std::string& name, const Section& s, const ReadContext& c) {
    const Library library(s);
    UserArguments arguments = common_arguments(name, s, c);
    read_markers(s, c, arguments);
    read_inputs(s, c, arguments);
    return library.make(library.elements().measures, "measure", s, arguments);
  };
  return type;
}

std::vector<input::Key> user_joint_keys() {
  std::vector<input::Key> keys = common_keys();
  keys.push_back(input::formulas("start", "its coordinates at the start, by name"));
  keys.push_back(input::formulas("start_speed", "its speeds at the start, by name"));
  keys.push_back(input::formulas("drive", "drives its coordinates, by name: formulas of t and parameters"));
  keys.push_back(input::formulas("drive_speed", "drives its speeds instead, by name"));
  keys.push_back(input::formulas("drive_acceleration", "drives its accelerations instead, by name"));
  return keys;
}

std::shared_ptr<const Joint> make_user_joint(const std::string& name, const Section& s,
                                             const ReadContext& c) {
  const Library library(s);
  return library.make(library.elements().joints, "joint", s, common_arguments(name, s, c));
}

}  // namespace flexura::mbs
