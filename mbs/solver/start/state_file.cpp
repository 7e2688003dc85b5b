// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/base/documents/document.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/json_text.hpp"
#include "mbs/solver/start/continuation_file.hpp"
#include "mbs/superelement/text_file.hpp"

namespace flexura::mbs {

namespace {

using Json = nlohmann::ordered_json;
using NameOf = std::function<std::string(int)>;

Json named(const Eigen::VectorXd& x, const NameOf& name) {
  Json out = Json::object();
  for (int i = 0; i < static_cast<int>(x.size()); ++i) out[name(i)] = x(i);
  return out;
}

std::vector<double> plain(const Eigen::VectorXd& x) {
  return {x.data(), x.data() + x.size()};
}

Eigen::VectorXd vector_of(const Json& values) {
  const auto v = values.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

std::array<double*, 10> numbers(EnergyAccount& e) {
  return {&e.now.kinetic, &e.now.strain, &e.now.potential, &e.now.input_power, &e.now.dissipated_power,
          &e.start,       &e.work_in,    &e.dissipated,    &e.gross_work,      &e.peak};
}

std::string checksum(Json document) {
  document.erase("checksum");
  return input::ContentHash().add(document.dump()).hex();
}

/// The names of all states, constraints and switches.
std::string signature(const Equations& eq) {
  const Sizes n = eq.sizes();
  input::ContentHash hash;
  for (int i = 0; i < n.n_p; ++i) hash.add(eq.name_of_position(i));
  for (int i = 0; i < n.n_v; ++i) hash.add(eq.name_of_velocity(i));
  for (int i = 0; i < n.n_dyn; ++i) hash.add(eq.name_of_dynamic(i));
  for (int i = 0; i < n.n_alg; ++i) hash.add(eq.name_of_algebraic(i));
  for (int i = 0; i < n.n_lambda; ++i) hash.add(eq.name_of_constraint(i));
  for (int i = 0; i < n.n_root; ++i) hash.add(eq.name_of_root(i));
  return hash.hex();
}

/// What masses, forces and constraints of the mechanism say in this state: its momentum balance, f_c and b, with
/// accelerations and multipliers of zero and of one.  Another mass, stiffness or place of a joint gives others.
Eigen::VectorXd answers(const Equations& eq, State s) {
  const Sizes n = eq.sizes();
  const auto scratch = eq.make_scratch();
  const int n_all = n.n_v + n.n_dyn + n.n_alg;
  Eigen::VectorXd out(3 * n_all);
  for (int k = 0; k < 3; ++k) {
    s.lambda = Eigen::VectorXd::Constant(n.n_lambda, k == 2 ? 1.0 : 0.0);
    auto part = out.segment(k * n_all, n_all);
    eq.momentum(s, Eigen::VectorXd::Constant(n.n_v, k == 1 ? 1.0 : 0.0), *scratch, part.head(n.n_v),
                part.segment(n.n_v, n.n_dyn), part.tail(n.n_alg));
  }
  return out;
}

/// Round-off differs between machines; what a user changes differs by more.
bool are_the_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() &&
         (a.size() == 0 || (a - b).cwiseAbs().maxCoeff() <= 1e-8 * a.cwiseAbs().maxCoeff());
}

std::vector<bool> take(const Json& document, const char* key, const std::filesystem::path& path,
                       const NameOf& name, Eigen::VectorXd& x) {
  std::vector<bool> taken(x.size(), false);
  if (!document.contains(key)) return taken;
  std::vector<std::string> known;
  for (int i = 0; i < static_cast<int>(x.size()); ++i) known.push_back(name(i));
  for (const auto& [state, value] : document[key].items()) {
    const auto found = std::find(known.begin(), known.end(), state);
    if (found == known.end())
      throw std::invalid_argument(fmt::format("{}: {}: the mechanism has no state \"{}\"{}", path.string(),
                                              key, state, input::suggestion(state, known)));
    constexpr double kLargest = 1e40;  // as of any input
    if (!value.is_number() || !(std::abs(value.get<double>()) <= kLargest))
      throw std::invalid_argument(fmt::format("{}: {}: \"{}\" must be a number, up to 1e40; correct it there",
                                              path.string(), key, state));
    x(found - known.begin()) = value.get<double>();
    taken[found - known.begin()] = true;
  }
  return taken;
}

}  // namespace

void write_state(const std::filesystem::path& path, const Equations& eq, const std::string& mechanism,
                 const State& s, const Continuation* continuation) {
  Json out;
  out["format"] = "flexura state";
  out["version"] = 1;
  out["mechanism"] = mechanism;
  out["time"] = s.t;
  out["positions"] = named(s.p, [&](int i) { return eq.name_of_position(i); });
  out["velocities"] = named(s.v, [&](int i) { return eq.name_of_velocity(i); });
  out["dynamic"] = named(s.c, [&](int i) { return eq.name_of_dynamic(i); });
  out["algebraic"] = named(s.a, [&](int i) { return eq.name_of_algebraic(i); });
  out["multipliers"] = named(s.lambda, [&](int i) { return eq.name_of_constraint(i); });
  out["switches"] = s.root;
  if (continuation != nullptr) {
    Json& c = out["continuation"];
    c["signature"] = signature(eq);
    if (const Eigen::VectorXd told = answers(eq, s); told.allFinite()) c["answers"] = plain(told);
    c["method"] = continuation->method;
    c["next_row"] = continuation->next_row;
    c["v_dot"] = plain(continuation->v_dot);
    EnergyAccount energy = continuation->energy;
    for (const double* x : numbers(energy)) c["energy"].push_back(*x);
    c["history"] = continuation->history;
    out["checksum"] = checksum(out);
  }
  superelement::write_whole(path, out.dump(1) + '\n');
}

namespace {

// What the library says of a broken file, without its own number for it.
std::string reason(const nlohmann::json::exception& e) {
  const std::string text = e.what();
  const auto at = text.find("] ");
  return text.starts_with('[') && at != std::string::npos ? text.substr(at + 2) : text;
}

}  // namespace

StateChange read_state(const std::filesystem::path& path, const Equations& eq, State& s) {
  files::note_input(path);
  std::ifstream file(path);
  if (!file)
    throw std::invalid_argument(fmt::format("{}: there is no such file; check its path", path.string()));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Json in;
  // The order of a state's names is kept, and each is looked for among those before it.
  constexpr std::ptrdiff_t kMostNames = 50'000;
  if (std::ranges::count(text, '"') > 2 * kMostNames)
    throw std::invalid_argument(fmt::format(
        "{}: holds more than {} names, the most that a state file may have", path.string(), kMostNames));
  try {
    in = files::read_json<Json>(text);
  } catch (const nlohmann::json::exception& e) {
    throw std::invalid_argument(fmt::format("{}: is not a state file: {}", path.string(), reason(e)));
  }
  if (!in.is_object() || !in.contains("format") || in["format"] != "flexura state")
    throw std::invalid_argument(
        fmt::format("{}: is not a state file; it must hold \"format\": \"flexura state\"", path.string()));
  StateChange change;
  try {
    s.t = in.value("time", s.t);
    change.position = take(
        in, "positions", path, [&](int i) { return eq.name_of_position(i); }, s.p);
    change.velocity = take(
        in, "velocities", path, [&](int i) { return eq.name_of_velocity(i); }, s.v);
    take(
        in, "dynamic", path, [&](int i) { return eq.name_of_dynamic(i); }, s.c);
    take(
        in, "algebraic", path, [&](int i) { return eq.name_of_algebraic(i); }, s.a);
    take(
        in, "multipliers", path, [&](int i) { return eq.name_of_constraint(i); }, s.lambda);
    if (in.contains("switches") && in["switches"].size() == s.root.size())
      s.root = in["switches"].get<std::vector<int>>();
    if (in.contains("continuation")) {
      const Json& c = in["continuation"];
      Continuation& to = change.continuation.emplace();
      to.method = c.at("method");
      if (!c.at("next_row").is_number_integer())
        throw std::invalid_argument(path.string() +
                                    ": continuation: next_row must be a whole number; save the state again");
      to.next_row = c.at("next_row");
      to.v_dot = vector_of(c.at("v_dot"));
      const auto energy = c.at("energy").get<std::vector<double>>();
      const auto place = numbers(to.energy);
      if (energy.size() != place.size())
        throw std::invalid_argument(path.string() +
                                    ": continuation: its energy account is cut short; save the state again");
      for (std::size_t i = 0; i < place.size(); ++i) *place[i] = energy[i];
      to.history = c.at("history").get<std::vector<double>>();
      to.state = s;
      const std::pair<const char*, std::size_t> counts[] = {
          {"positions", s.p.size()}, {"velocities", s.v.size()},       {"dynamic", s.c.size()},
          {"algebraic", s.a.size()}, {"multipliers", s.lambda.size()}, {"switches", s.root.size()}};
      change.continuation_fits = std::ranges::all_of(
          counts, [&](const auto& of) { return in.value(of.first, Json::array()).size() == of.second; });
      change.continuation_fits =
          change.continuation_fits && c.contains("signature") && c["signature"] == signature(eq) &&
          (!c.contains("answers") || are_the_same(vector_of(c["answers"]), answers(eq, s)));
    }
  } catch (const nlohmann::json::exception& e) {
    throw std::invalid_argument(fmt::format("{}: is not a state file: {}", path.string(), reason(e)));
  }
  return change;
}

void require_whole_continuation(const std::filesystem::path& path) {
  files::require_no_device(path);
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const Json in = files::try_read_json<Json>(text);
  if (!in.is_object()) return;  // read_state() says what it is
  if (!in.contains("continuation")) return;
  if (!in.contains("checksum") || in["checksum"] != checksum(in))
    throw std::invalid_argument(fmt::format(
        "{}: was changed after it was written ({}), and a run can go on only from what an integrator left; "
        "start from its states with --from-state",
        path.string(), in.contains("checksum") ? "its checksum does not fit" : "it has no checksum"));
}

}  // namespace flexura::mbs
