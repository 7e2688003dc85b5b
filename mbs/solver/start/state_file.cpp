// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
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

// The states of a mechanism by name, of one kind first: modal coordinates of a one-way body are dynamic states.
class Places {
 public:
  Places(const Equations& eq, State& s, StateChange& change) : change_(change) {
    change.position.assign(s.p.size(), false);
    change.velocity.assign(s.v.size(), false);
    add("positions", s.p, [&](int i) { return eq.name_of_position(i); });
    add("velocities", s.v, [&](int i) { return eq.name_of_velocity(i); });
    add("dynamic", s.c, [&](int i) { return eq.name_of_dynamic(i); });
    add("algebraic", s.a, [&](int i) { return eq.name_of_algebraic(i); });
  }

  // The names under `kind` in the file.
  void take(const Json& document, const std::string& kind, const std::filesystem::path& path,
            const OfDeformation& of_deformation) {
    if (!document.contains(kind)) return;
    for (const auto& [state, value] : document[kind].items()) {
      constexpr double kLargest = 1e40;  // as of any input
      if (!value.is_number() || !(std::abs(value.get<double>()) <= kLargest))
        throw std::invalid_argument(fmt::format(
            "{}: {}: \"{}\" must be a number, up to 1e40; correct it there", path.string(), kind, state));
      const auto found = places_.find({kind, state});
      if (found != places_.end()) {
        put(found->first.first, found->second, value);
      } else if (of_deformation && of_deformation(state)) {
        put_elsewhere(state, value);
      } else {
        throw std::invalid_argument(fmt::format("{}: {}: the mechanism has no state \"{}\"{}", path.string(),
                                                kind, state, input::suggestion(state, names(kind))));
      }
    }
  }

 private:
  struct Place {
    double* value;
    std::size_t index;
  };

  void add(const std::string& kind, Eigen::VectorXd& x, const NameOf& name) {
    for (int i = 0; i < static_cast<int>(x.size()); ++i)
      places_[{kind, name(i)}] = {x.data() + i, static_cast<std::size_t>(i)};
  }
  void put(const std::string& kind, const Place& place, const Json& value) {
    *place.value = value.get<double>();
    if (kind == "positions") change_.position[place.index] = true;
    if (kind == "velocities") change_.velocity[place.index] = true;
  }
  void put_elsewhere(const std::string& state, const Json& value) {
    for (const char* kind : {"positions", "velocities", "dynamic"})
      if (const auto found = places_.find({kind, state}); found != places_.end())
        return put(kind, found->second, value);
    change_.left_out.push_back(state);
  }
  std::vector<std::string> names(const std::string& kind) const {
    std::vector<std::string> of_kind;
    for (const auto& [name, place] : places_)
      if (name.first == kind) of_kind.push_back(name.second);
    return of_kind;
  }

  StateChange& change_;
  std::map<std::pair<std::string, std::string>, Place> places_;
};

// Multipliers follow from the other states; where constraints have other names these begin at zero.
void take_multipliers(const Json& document, const Equations& eq, State& s) {
  if (!document.contains("multipliers")) return;
  const Json& given = document["multipliers"];
  for (int i = 0; i < static_cast<int>(s.lambda.size()); ++i)
    if (const auto found = given.find(eq.name_of_constraint(i)); found != given.end() && found->is_number())
      s.lambda(i) = found->get<double>();
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

StateChange read_state(const std::filesystem::path& path, const Equations& eq, State& s,
                       const OfDeformation& of_deformation) {
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
    change.is_whole = in.contains("mechanism");
    Places places(eq, s, change);
    for (const char* kind : {"positions", "velocities", "dynamic", "algebraic"})
      places.take(in, kind, path, of_deformation);
    take_multipliers(in, eq, s);
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
