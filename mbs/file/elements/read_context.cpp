// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/read_context.hpp"

#include <fmt/format.h>

#include "mbs/base/documents/formula_text.hpp"
#include "mbs/controls/state.hpp"

namespace flexura::mbs {
namespace {

std::shared_ptr<const Expression> compile(const input::Section& section, const std::string& key,
                                          const std::string& formula, const SignalNames& signals,
                                          const std::map<std::string, double>& constants,
                                          const Curves& tables, SignalNames* held = nullptr) {
  const std::string path = section.path() + "." + key;
  try {
    auto f = std::make_shared<Expression>(path, formula, signals, constants, tables, held);
    // What depends on nothing has its value, or none, before any motion.
    if (f->reads().empty() && !f->reads_time() && f->conditions().empty()) {
      const std::vector<double> none(static_cast<std::size_t>(signals.size()), 0.0);
      f->evaluate(none.data());
    }
    return f;
  } catch (const std::runtime_error& error) {
    throw input::InputError(section.where(key) + ": " + error.what());
  } catch (const std::invalid_argument& error) {
    // The message opens with the path; in the file it also has a line.
    const std::string where = section.where(key);
    const std::string place = where.ends_with(path) ? where.substr(0, where.size() - path.size()) : "";
    throw input::InputError(place + error.what());
  }
}

}  // namespace

int ReadContext::body(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  std::vector<std::string> known;
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) {
    if (d_.bodies[b].name == prefix_ + name) return static_cast<int>(b);
    if (d_.bodies[b].name.starts_with(prefix_)) known.push_back(d_.bodies[b].name.substr(prefix_.size()));
  }
  section.refuse(key, fmt::format("there is no body \"{}\"{}", name, input::suggestion(name, known)));
}

int ReadContext::marker(const input::Section& section, const std::string& key) const {
  return marker_of(section, key, section.text(key));
}

int ReadContext::marker_of(const input::Section& section, const std::string& key,
                           const std::string& name) const {
  const std::string full = prefix_ + name;
  for (std::size_t i = 0; i < d_.markers.size(); ++i)
    if (d_.markers[i].name == full) return static_cast<int>(i);
  // The names of bodies in subsystems hold dots themselves: the longest that fits.
  std::vector<std::string> bodies, markers;
  int body = -1;
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) {
    const std::string& other = d_.bodies[b].name;
    if (other.starts_with(prefix_)) bodies.push_back(other.substr(prefix_.size()));
    if (full != other && !full.starts_with(other + ".")) continue;
    if (body < 0 || other.size() > d_.bodies[body].name.size()) body = static_cast<int>(b);
  }
  const std::string body_name =
      body < 0 ? name.substr(0, name.find('.')) : d_.bodies[body].name.substr(prefix_.size());
  if (body < 0)
    section.refuse(key,
                   fmt::format("there is no body \"{}\"{}", body_name, input::suggestion(body_name, bodies)));
  if (name == body_name) {
    const std::string frame = full + ".frame";
    for (std::size_t i = 0; i < d_.markers.size(); ++i)
      if (d_.markers[i].name == frame) return static_cast<int>(i);
    return d_.add_marker(body, "frame");
  }
  for (const MarkerDescription& marker : d_.markers)
    if (marker.body == body && marker.name.starts_with(prefix_))
      markers.push_back(marker.name.substr(prefix_.size()));
  section.refuse(key, fmt::format("body \"{}\" has no marker \"{}\"{}", body_name,
                                  name.substr(std::min(name.size(), body_name.size() + 1)),
                                  input::suggestion(name, markers)));
}

int ReadContext::joint(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  std::vector<std::string> known;
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    const std::string& other = d_.joints[j].name;
    if (other == prefix_ + name) return static_cast<int>(j);
    if (other.starts_with(prefix_)) known.push_back(other.substr(prefix_.size()));
  }
  section.refuse(key, fmt::format("there is no joint \"{}\"{}", name, input::suggestion(name, known)));
}

CoordinateRef ReadContext::speed(const input::Section& section, const std::string& joint_key,
                                 const std::string& coordinate_key) const {
  const std::string joint = section.text(joint_key);
  if (!section.has(coordinate_key)) return coordinate(section, joint_key, joint);
  return coordinate(section, joint_key, joint + "." + section.text(coordinate_key));
}

CoordinateRef ReadContext::coordinate(const input::Section& section, const std::string& key,
                                      const std::string& name) const {
  const std::string full = prefix_ + name;
  std::vector<std::string> known;
  int j = -1;
  for (std::size_t k = 0; k < d_.joints.size(); ++k) {
    const std::string& other = d_.joints[k].name;
    if (other.starts_with(prefix_)) known.push_back(other.substr(prefix_.size()));
    if (full != other && !full.starts_with(other + ".")) continue;
    if (j < 0 || other.size() > d_.joints[j].name.size()) j = static_cast<int>(k);
  }
  const std::string joint_name =
      j < 0 ? name.substr(0, name.find('.')) : d_.joints[j].name.substr(prefix_.size());
  if (j < 0)
    section.refuse(
        key, fmt::format("there is no joint \"{}\"{}", joint_name, input::suggestion(joint_name, known)));
  const Joint& joint = *d_.joints[j].joint;
  if (joint.n_p() != joint.n_v() || joint.n_v() == 0)
    section.refuse(key, fmt::format("a {} joint has no coordinate that can be acted on alone", joint.type()),
                   "use a force or torque at a marker");
  const auto coordinates = joint.coordinates();
  if (name == joint_name) {
    if (coordinates.size() == 1) return {j, 0};
    std::string names;
    for (const CoordinateInfo& c : coordinates) names += (names.empty() ? "\"" : ", \"") + c.name + "\"";
    section.refuse(key, fmt::format("a {} joint has the coordinates {}", joint.type(), names),
                   "say which is meant");
  }
  const std::string wanted = name.substr(joint_name.size() + 1);
  known.clear();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (coordinates[i].name == wanted) return {j, static_cast<int>(i)};
    known.push_back(coordinates[i].name);
  }
  section.refuse(key, fmt::format("joint \"{}\" has no coordinate \"{}\"{}", joint_name, wanted,
                                  input::suggestion(wanted, known)));
}

input::Dimension ReadContext::force_along(CoordinateRef c) const {
  // Of the speed: a ball's coordinates are a quaternion, but it turns in rad/s.
  const input::Dimension of = d_.joints[c.joint].joint->speeds()[c.index].dimension;
  return of == input::dim::angular_velocity ? input::dim::torque
         : of == input::dim::velocity       ? input::dim::force
                                            : input::dim::none;
}

CoordinateInfo ReadContext::coordinate_info(CoordinateRef c) const {
  CoordinateInfo info = d_.joints[c.joint].joint->coordinates()[c.index];
  info.name = d_.joints[c.joint].name + "." + info.name;
  return info;
}

std::shared_ptr<const Expression> ReadContext::expression(const input::Section& section,
                                                          const std::string& key) const {
  return expression_of(section, key, section.text(key));
}

std::shared_ptr<const Expression> ReadContext::expression_of(const input::Section& section,
                                                             const std::string& key,
                                                             const std::string& formula) const {
  auto f = compile(section, key, formula, d_.signals.within(prefix_), parameters_, tables_, &d_.signals);
  d_.formulas.push_back({f, false});
  return f;
}

std::shared_ptr<const Expression> ReadContext::plain_expression(const input::Section& section,
                                                                const std::string& key) const {
  return compile(section, key, section.text(key), d_.signals.within(prefix_), parameters_, tables_);
}

std::shared_ptr<const Expression> ReadContext::formula_of(const Measure& measure) const {
  for (const FormulaDescription& f : d_.formulas)
    if (f.expression.get() == measure.formula()) return f.expression;
  return nullptr;
}

std::shared_ptr<const Expression> ReadContext::time_expression(const input::Section& section,
                                                               const std::string& key) const {
  return time_expression_of(section, key, section.text(key));
}

std::shared_ptr<const Expression> ReadContext::time_expression_of(const input::Section& section,
                                                                  const std::string& key,
                                                                  const std::string& formula) const {
  auto f = compile(section, key, formula, SignalNames(), parameters_, tables_);
  d_.formulas.push_back({f, true});
  return f;
}

std::shared_ptr<const Expression> ReadContext::motion_expression(const input::Section& section,
                                                                 const std::string& key) const {
  return motion_expression_of(section, key, section.text(key));
}

std::shared_ptr<const Expression> ReadContext::motion_expression_of(const input::Section& section,
                                                                    const std::string& key,
                                                                    const std::string& formula) const {
  const SignalNames names = d_.signals.within(prefix_);
  // What depends on time alone holds no conditions.
  if (compile(section, key, formula, names, parameters_, tables_)->reads().empty())
    return time_expression_of(section, key, formula);
  auto f = compile(section, key, formula, names, parameters_, tables_, &d_.signals);
  d_.formulas.push_back({f, true});
  return f;
}

std::shared_ptr<const Expression> ReadContext::state_expression(const input::Section& section,
                                                                const std::string& key,
                                                                const std::string& name,
                                                                std::shared_ptr<const Expression> rate,
                                                                double start) const {
  std::string own = name;
  for (char& c : own)
    if (std::string_view(input::name_characters).find(c) == std::string_view::npos) c = '_';
  while (d_.signals.find(own) >= 0) own += '_';
  d_.signals.add(own);
  d_.controls.push_back(std::make_shared<StateEquation>(own, std::move(rate), start));
  auto f = compile(section, key, own, d_.signals, {}, {}, &d_.signals);
  d_.formulas.push_back({f, true});
  return f;
}

std::shared_ptr<const Expression> ReadContext::input_expression(const input::Section& section,
                                                                const std::string& key) const {
  return compile(section, key, section.text(key), SignalNames(), parameters_, tables_);
}

void ReadContext::add_measure(const input::Section& section, std::shared_ptr<const Measure> measure) const {
  const std::string& name = measure->name();
  if (d_.signals.find(name) >= 0)
    section.refuse("", fmt::format("\"{}\" is taken already in formulas", name), "choose another name");
  d_.signals.add(name);
  d_.measures.push_back(std::move(measure));
}

std::shared_ptr<const Curve> ReadContext::table(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  if (const auto found = tables_.find(name); found != tables_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, curve] : tables_) known.push_back(other);
  section.refuse(key, fmt::format("there is no table \"{}\"{}", name, input::suggestion(name, known)),
                 known.empty() ? "write [table." + name + "]" : "");
}

double ReadContext::number(const input::Section& section, const std::string& key) const {
  return number_of(section, key, section.text(key));
}

double ReadContext::number_of(const input::Section& section, const std::string& key,
                              const std::string& formula) const {
  const double at_start = 0.0;
  try {
    const auto compiled = compile(section, key, formula, SignalNames(), parameters_, tables_);
    if (compiled->reads_time())
      section.refuse(
          key, "reads the time t, and is one number for the whole run",
          "write a number or a formula of parameters; what changes with t goes into the formula of a "
          "force, a drive or a control");
    return compiled->evaluate(&at_start);
  } catch (const input::InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw input::InputError(section.where(key) + ": " + error.what());
  }
}

input::Key unit_key(const std::string& of_what) {
  return input::text(
      "unit", "of " + of_what +
                  ", in tables and plots: an SI unit as in \"N\", \"rad/s\"; without it a plain number");
}

input::Dimension read_unit(const input::Section& s) {
  if (!s.has("unit")) return input::dim::none;
  const std::string text = s.text("unit");
  input::Measured unit;
  try {
    unit = input::parse_unit(text);
  } catch (const std::invalid_argument& failure) {
    s.refuse("unit", failure.what(), "write an SI unit, as in \"N\" or \"rad/s\"");
  }
  if (unit.value != 1.0)
    s.refuse("unit", "is no SI unit",
             "formulas are computed in SI; write \"" + input::si_unit(unit.dimension) + "\"");
  return unit.dimension;
}

}  // namespace flexura::mbs
