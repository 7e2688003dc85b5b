// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/watch/turn_watch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>

namespace flexura::app {

TurnWatch::TurnWatch(const mbs::Mechanism& mechanism)
    : mechanism_(mechanism), scratch_(mechanism.make_scratch()) {
  const mbs::MechanismDescription& d = mechanism.description();
  std::map<std::string, std::string> readers;  // of angles, by name
  const auto name_of = [&](mbs::CoordinateRef c) {
    return fmt::format("{}.{}", d.joints[c.joint].name, d.joints[c.joint].joint->coordinates()[c.index].name);
  };
  const auto closes = [&](std::size_t joint) { return !mechanism.in_tree(static_cast<int>(joint)); };
  for (const auto& force : d.forces) {
    for (const mbs::CoordinateRef& c : force->coordinates())
      if (closes(static_cast<std::size_t>(c.joint)) &&
          c.index < static_cast<int>(d.joints[c.joint].joint->coordinates().size()))
        readers.emplace(name_of(c), fmt::format("force \"{}\" acts along it", force->name()));
    for (const int signal : force->reads())
      readers.emplace(d.signals.names()[signal], fmt::format("force \"{}\" reads it", force->name()));
  }
  for (const auto& control : d.controls)
    for (const int signal : control->reads())
      readers.emplace(d.signals.names()[signal], fmt::format("control \"{}\" reads it", control->name()));
  if (readers.empty()) return;
  std::map<std::string, bool> is_angle;  // of joints that close loops
  for (std::size_t j = 0; j < d.joints.size(); ++j)
    if (closes(j))
      for (const mbs::CoordinateInfo& info : d.joints[j].joint->coordinates())
        if (info.dimension == input::dim::angle) is_angle[d.joints[j].name + "." + info.name] = true;
  if (is_angle.empty()) return;
  const std::vector<mbs::OutputInfo> quantities = mechanism.quantities();
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const auto reader = readers.find(quantities[i].name);
    if (reader == readers.end() || !is_angle.contains(quantities[i].name)) continue;
    which_.push_back(static_cast<int>(i));
    names_.push_back(reader->first);
    readers_.push_back(reader->second);
  }
  now_.resize(static_cast<Eigen::Index>(which_.size()));
}

void TurnWatch::observe(const mbs::State& s, const Eigen::VectorXd& v_dot) {
  if (which_.empty()) return;
  mechanism_.evaluate(which_, s, v_dot, *scratch_, now_);
  if (before_.size() > 0 && reason_.empty())
    for (Eigen::Index i = 0; i < now_.size(); ++i)
      if (std::abs(now_(i) - before_(i)) > std::numbers::pi)
        reason_ = fmt::format(
            "\"{}\" went beyond 180 deg by t = {:.6g} s, where the angle of a joint that closes a loop jumps "
            "by a whole "
            "turn, and {}: cut another joint of the loop with cut = true, so that this one counts its turns",
            names_[static_cast<std::size_t>(i)], s.t, readers_[static_cast<std::size_t>(i)]);
  before_ = now_;
}

}  // namespace flexura::app
