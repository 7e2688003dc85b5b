// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/apply_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace flexura::mbs {
namespace {

// "rod" of "rod.mode_3_rate": the body whose deformation this is, where one of the file's may deform.
std::string body_of(const std::string& state, const std::vector<std::string>& deformable,
                    const Mechanism& m) {
  for (const std::string& body : deformable)
    if (state.starts_with(body + ".")) return body;
  const auto mode = state.rfind(".mode_");  // of a subsystem's body
  if (mode == std::string::npos) return "";
  const std::string body = state.substr(0, mode);
  const auto& bodies = m.description().bodies;
  return std::ranges::find(bodies, body, &BodyDescription::name) != bodies.end() ? body : "";
}

class Application {
 public:
  Application(std::string source, const std::vector<std::string>& deformable, const Mechanism& m, State& s)
      : source_(std::move(source)), deformable_(deformable), m_(m), s_(s) {
    position_.assign(s.p.size(), false);
    velocity_.assign(s.v.size(), false);
  }

  void zero() {
    s_.p.setZero();
    s_.v.setZero();
    s_.c.setZero();
    s_.a.setZero();
    for (Eigen::Index i = 0; i < s_.p.size(); ++i)
      if (m_.name_of_position(static_cast<int>(i)).ends_with(".qw")) s_.p(i) = 1.0;
    position_.assign(s_.p.size(), true);
    velocity_.assign(s_.v.size(), true);
  }

  void take(const std::filesystem::path& path) {
    const StateChange change = read_state(
        path, m_, s_, [this](const std::string& state) { return !body_of(state, deformable_, m_).empty(); });
    for (std::size_t i = 0; i < position_.size(); ++i) position_[i] = position_[i] || change.position[i];
    for (std::size_t i = 0; i < velocity_.size(); ++i) velocity_[i] = velocity_[i] || change.velocity[i];
    for (const std::string& state : change.left_out) ++left_out_[body_of(state, deformable_, m_)];
    if (change.is_whole) tell_missing(change);
  }

  void take(const StateSet::Value& value) {
    for (const OutputInfo& info : m_.quantities())
      if (info.name == value.state) try {
          input::check_kind(value.value, info.dimension);
        } catch (const std::invalid_argument& trouble) {
          throw input::InputError(fmt::format("{} = {}: {}", value.where, value.value.value, trouble.what()));
        }
    std::vector<std::string> known;
    const auto put = [&](Eigen::VectorXd& x, auto name, std::vector<bool>* given) {
      for (int i = 0; i < static_cast<int>(x.size()); ++i) {
        known.push_back(name(i));
        if (known.back() != value.state) continue;
        x(i) = value.value.value;
        if (given != nullptr) (*given)[static_cast<std::size_t>(i)] = true;
        return true;
      }
      return false;
    };
    if (put(
            s_.p, [&](int i) { return m_.name_of_position(i); }, &position_) ||
        put(
            s_.v, [&](int i) { return m_.name_of_velocity(i); }, &velocity_) ||
        put(
            s_.c, [&](int i) { return m_.name_of_dynamic(i); }, nullptr) ||
        put(
            s_.a, [&](int i) { return m_.name_of_algebraic(i); }, nullptr))
      return;
    const std::string body = body_of(value.state, deformable_, m_);
    if (body.empty())
      throw input::InputError(value.where +
                              ": is none of the mechanism's states; take one that flexura assemble lists" +
                              input::suggestion(value.state, known));
    ++left_out_[body];
  }

  std::vector<std::string> finish(GivenState& given) {
    normalise();
    for (const auto& [body, count] : left_out_)
      notes_.push_back(fmt::format("{}: {} {} of \"{}\" left out, which its fidelity here does not have",
                                   source_, count, count == 1 ? "state" : "states", body));
    for (std::size_t i = 0; i < position_.size(); ++i)
      given.positions[i] = given.positions[i] || position_[i];
    for (std::size_t i = 0; i < velocity_.size(); ++i)
      given.velocities[i] = given.velocities[i] || velocity_[i];
    given.whole = given.whole || std::ranges::find(position_, false) == position_.end();
    return std::move(notes_);
  }

 private:
  // Deformation that the file's mechanism did not have.
  void tell_missing(const StateChange& change) {
    std::map<std::string, int> missing;
    for (std::size_t i = 0; i < change.position.size(); ++i)
      if (!change.position[i]) ++missing[body_of(m_.name_of_position(static_cast<int>(i)), deformable_, m_)];
    for (const auto& [body, count] : missing)
      if (!body.empty())
        notes_.push_back(fmt::format("{}: holds no value of {} {} of \"{}\"; they start at zero", source_,
                                     count, count == 1 ? "modal coordinate" : "modal coordinates", body));
  }

  // Four numbers typed by hand are hardly of length 1.
  void normalise() {
    for (int i = 0; i + 3 < static_cast<int>(s_.p.size()); ++i)
      if (m_.name_of_position(i).ends_with(".qw") && m_.name_of_position(i + 3).ends_with(".qz"))
        if (const double length = s_.p.segment<4>(i).norm(); length > 0.0) s_.p.segment<4>(i) /= length;
  }

  std::string source_;
  const std::vector<std::string>& deformable_;
  const Mechanism& m_;
  State& s_;
  std::vector<bool> position_, velocity_;
  std::map<std::string, int> left_out_;  ///< by body
  std::vector<std::string> notes_;
};

}  // namespace

std::vector<std::string> apply_state(const StateSet& set, const std::vector<std::string>& deformable,
                                     const Mechanism& m, State& s, GivenState& given) {
  Application application(fmt::format("state \"{}\"", set.name), deformable, m, s);
  if (set.zero) application.zero();
  if (!set.file.empty()) application.take(set.file);
  for (const StateSet::Value& value : set.values) application.take(value);
  if (set.time) s.t = *set.time;
  return application.finish(given);
}

std::vector<std::string> apply_state(const std::filesystem::path& path,
                                     const std::vector<std::string>& deformable, const Mechanism& m, State& s,
                                     GivenState& given) {
  Application application(path.string(), deformable, m, s);
  application.take(path);
  return application.finish(given);
}

}  // namespace flexura::mbs
