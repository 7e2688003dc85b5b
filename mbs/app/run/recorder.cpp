// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/recorder.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ranges>
#include <stdexcept>

#include "mbs/base/documents/units.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/mechanism/drawn_elements.hpp"

namespace flexura::app {

namespace {

/// A rigid body without shapes is drawn between its connections.  The last link of a chain has one, often at its origin, and
/// would be a dot: it is drawn from there to its mass centre.
std::string drawn_to_its_centre(const mbs::BodyDescription& body, const nlohmann::json& connections) {
  if (body.flexible || !body.superelement.empty() || body.name == "ground" || !(body.inertia.mass > 0.0))
    return {};
  const Eigen::Vector3d center = body.inertia.mass_center / body.inertia.mass;
  std::vector<Eigen::Vector3d> points;
  for (const auto& connection : connections) {
    if (connection.value("kind", "") == "marker" || connection.contains("surface") ||
        connection.contains("path"))
      continue;
    for (const auto& [of, place] : {std::pair{"body_1", "p_1"}, std::pair{"body_2", "p_2"}})
      if (connection.value(of, "") == body.name && connection.contains(place) && connection[place].is_array())
        points.emplace_back(connection[place][0], connection[place][1], connection[place][2]);
  }
  const auto is_elsewhere = [&](const Eigen::Vector3d& p) { return (p - points.front()).norm() > 1e-9; };
  if (points.empty() || std::ranges::any_of(points, is_elsewhere) || !is_elsewhere(center)) return {};
  const auto list = [](const Eigen::Vector3d& p) { return nlohmann::json::array({p.x(), p.y(), p.z()}); };
  return nlohmann::json::array({{{"type", "line"}, {"points", {list(points.front()), list(center)}}}}).dump();
}

std::string line_of(double length) {
  return nlohmann::json::array({{{"type", "line"}, {"points", {{0.0, 0.0, 0.0}, {length, 0.0, 0.0}}}}})
      .dump();
}

/// What stands on a planar beam moves with the element that it stands on: places and axes on the beam as they are given, in its
/// undeformed body, become those on that element, which pages and exports draw.
void put_on_elements(const mbs::Mechanism& mechanism, nlohmann::json& connections) {
  const auto& bodies = mechanism.description().bodies;
  const std::vector<mbs::DrawnElement> elements = mbs::drawn_elements(mechanism);
  if (elements.empty()) return;
  mbs::State undeformed = mechanism.initial_state();
  undeformed.p.setZero();
  const auto vector = [](const nlohmann::json& x) { return Eigen::Vector3d(x[0], x[1], x[2]); };
  for (auto& connection : connections)
    for (const std::string side : {"1", "2"}) {
      const std::string of = "body_" + side, at = "p_" + side, axis = "axis_" + side;
      if (!connection.contains(of) || !connection.contains(at) || !connection[at].is_array()) continue;
      const auto body =
          std::ranges::find(bodies, connection[of].get<std::string>(), &mbs::BodyDescription::name);
      const int b = static_cast<int>(body - bodies.begin());
      const auto first = std::ranges::find(elements, b, &mbs::DrawnElement::body);
      if (body == bodies.end() || first == elements.end()) continue;
      const std::vector<mbs::Pose> chords = mbs::drawn_chords(mechanism, b, undeformed);
      const Eigen::Vector3d p = vector(connection[at]);
      const auto far = [&](std::size_t k) {
        const Eigen::Vector3d x = chords[k].inverse() * p;
        return (x - Eigen::Vector3d(std::clamp(x.x(), 0.0, first->length), 0.0, 0.0)).norm();
      };
      std::size_t nearest = 0;
      for (std::size_t k = 1; k < chords.size(); ++k)
        if (far(k) < far(nearest)) nearest = k;
      const mbs::Pose to_element = chords[nearest].inverse();
      const Eigen::Vector3d x = to_element * p;
      connection[of] = first[static_cast<std::ptrdiff_t>(nearest)].name;
      connection[at] = {x.x(), x.y(), x.z()};
      if (!connection.contains(axis) || !connection[axis].is_array()) continue;
      const Eigen::Vector3d turned = to_element.R * vector(connection[axis]);
      connection[axis] = {turned.x(), turned.y(), turned.z()};
    }
}

}  // namespace

results::ModelHeader model_header(std::span<const NamedRun> runs, const std::filesystem::path& mechanism_file,
                                  const std::filesystem::path& results_file) {
  std::vector<const mbs::PreparedMechanism*> list;
  for (const NamedRun& run : runs) list.push_back(&run.prepared);
  return model_header(list, mechanism_file, results_file);
}

results::ModelHeader model_header(const std::vector<const mbs::PreparedMechanism*>& runs,
                                  const std::filesystem::path&, const std::filesystem::path& results_file) {
  const mbs::Mechanism& first = *runs.front()->mechanism;
  results::ModelHeader header;
  header.name = runs.front()->file.name;
  header.source = runs.front()->file.source;
  header.created_by = std::string("flexura ") + FLEXURA_VERSION;
  header.gravity = first.description().gravity;
  auto connections = nlohmann::json::parse(mbs::connections_json(first));
  put_on_elements(first, connections);
  header.connections_json = connections.dump();
  const auto results_folder = std::filesystem::absolute(results_file).parent_path();
  const std::vector<mbs::DrawnElement> elements = mbs::drawn_elements(first);
  for (std::size_t b = 0; b < first.description().bodies.size(); ++b) {
    const mbs::BodyDescription& body = first.description().bodies[b];
    results::BodyHeader line;
    line.name = body.name;
    line.shape_json = body.shape_json.empty() || body.shape_json == "[]"
                          ? drawn_to_its_centre(body, connections)
                          : body.shape_json;
    bool flexible = false;
    for (const mbs::PreparedMechanism* run : runs) {
      const auto& bodies = run->mechanism->description().bodies;
      if (b < bodies.size() && !bodies[b].superelement.empty()) flexible = flexible || bodies[b].flexible;
    }
    line.kind = b == 0 ? "ground" : flexible ? "flexible" : "rigid";
    if (!body.superelement.empty()) {
      // The document's folder stands in it already.
      const auto path = std::filesystem::absolute(body.superelement).lexically_normal();
      line.superelement = path.lexically_relative(results_folder.lexically_normal()).generic_string();
    }
    // What bends is drawn element by element.
    const auto part = std::ranges::find(elements, static_cast<int>(b), &mbs::DrawnElement::body);
    if (part != elements.end() && (body.shape_json.empty() || body.shape_json == "[]"))
      line.shape_json = line_of(1e-3 * part->length);
    header.bodies.push_back(std::move(line));
  }
  for (const mbs::DrawnElement& element : elements)
    header.bodies.push_back({element.name, "rigid", "", line_of(element.length)});
  return header;
}

std::vector<std::string> state_names(const mbs::Mechanism& m) {
  const mbs::Sizes n = m.sizes();
  std::vector<std::string> names;
  for (int i = 0; i < n.n_p; ++i) names.push_back(m.name_of_position(i));
  for (int i = 0; i < n.n_v; ++i) names.push_back(m.name_of_velocity(i) + "'");
  for (int i = 0; i < n.n_dyn; ++i) names.push_back(m.name_of_dynamic(i));
  for (int i = 0; i < n.n_alg; ++i) names.push_back(m.name_of_algebraic(i));
  for (int i = 0; i < n.n_lambda; ++i) names.push_back("lambda." + m.name_of_constraint(i));
  for (int i = 0; i < n.n_root; ++i) names.push_back("switch." + m.name_of_root(i));
  return names;
}

Eigen::VectorXd pack(const mbs::State& s) {
  Eigen::VectorXd roots(static_cast<Eigen::Index>(s.root.size()));
  for (std::size_t i = 0; i < s.root.size(); ++i) roots(static_cast<Eigen::Index>(i)) = s.root[i];
  Eigen::VectorXd all(s.p.size() + s.v.size() + s.c.size() + s.a.size() + s.lambda.size() + roots.size());
  all << s.p, s.v, s.c, s.a, s.lambda, roots;
  return all;
}

mbs::State unpack(const mbs::Mechanism& m, double t, const Eigen::VectorXd& states) {
  const mbs::Sizes n = m.sizes();
  mbs::State s;
  s.t = t;
  Eigen::Index at = 0;
  const auto take = [&](Eigen::VectorXd& part, int size) {
    part = states.segment(at, size);
    at += size;
  };
  take(s.p, n.n_p);
  take(s.v, n.n_v);
  take(s.c, n.n_dyn);
  take(s.a, n.n_alg);
  take(s.lambda, n.n_lambda);
  for (int i = 0; i < n.n_root; ++i) s.root.push_back(static_cast<int>(states(at + i)));
  return s;
}

Recorder::Recorder(const mbs::PreparedMechanism& prepared, results::Writer& writer,
                   const std::vector<std::string>& patterns, bool store_states)
    : mechanism_(*prepared.mechanism),
      writer_(writer),
      scratch_(mechanism_.make_scratch()),
      range_(mechanism_, prepared.options.end_time - prepared.state.t),
      turns_(mechanism_),
      paths_(mechanism_),
      creep_(mechanism_),
      store_states_(store_states) {
  which_ = mbs::select_quantities(mechanism_, patterns);
  const auto infos = mechanism_.quantities();
  for (const int i : which_) quantities_.push_back({infos[i].name, mbs::unit_of(infos[i]), infos[i].doc});
  for (const mbs::OutputInfo& info : mbs::run_quantities()) quantities_.push_back({info.name, "J", info.doc});
  const auto& bodies = mechanism_.description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    results::RunBody body;
    body.name = bodies[b].name;
    if (const mbs::FlexibleBody* deforms = mechanism_.deforming(static_cast<int>(b));
        deforms && deforms->modal())
      body.basis = deforms->modal()->Y;
    run_bodies_.push_back(std::move(body));
  }
  for (const mbs::DrawnElement& element : mbs::drawn_elements(mechanism_))
    run_bodies_.push_back({element.name, {}});
  row_.quantities.resize(static_cast<Eigen::Index>(quantities_.size()));
  row_.pose.assign(run_bodies_.size(), Eigen::Matrix<double, 7, 1>::Zero());
  for (auto& pose : row_.pose) pose(3) = 1.0;
  row_.modal.resize(run_bodies_.size());
}

void Recorder::begin(const std::string& name) {
  writer_.begin_run(name, quantities_, run_bodies_,
                    store_states_ ? state_names(mechanism_) : std::vector<std::string>{});
}

void Recorder::append(const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
  append(s, v_dot, EnergyRow{energy.work_in, energy.dissipated, energy.error()});
  watch(s, energy.now.kinetic);
}

void Recorder::watch(const mbs::State& s, double kinetic_energy) {
  double speed = 0.0;
  const double travel =
      s.p.size() > 0 ? (s.p - p_start_).cwiseQuotient(p_scale_).lpNorm<Eigen::Infinity>() : 0.0;
  if (!poses_before_.empty() && s.t > t_before_)
    for (std::size_t b = 0; b < poses_.size(); ++b)
      speed = std::max(speed, (poses_[b].p - poses_before_[b].p).norm() / (s.t - t_before_));
  growth_.observe(s.t, kinetic_energy, travel, speed);
  // The row that shows it is kept, and the run ends there.
  if (const std::string why = range_.runaway(); !why.empty()) throw std::runtime_error(why);
  if (!turns_.reason().empty()) throw std::runtime_error(turns_.reason());
  if (!paths_.reason().empty()) throw std::runtime_error(paths_.reason());
  if (!growth_.reason().empty()) throw std::runtime_error(growth_.reason());
}

void Recorder::append(const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
  if (p_start_.size() == 0) {
    p_start_ = p_scale_ = s.p;
    for (Eigen::Index i = 0; i < s.p.size(); ++i)
      p_scale_(i) = mechanism_.position_scale(static_cast<int>(i));
  }
  poses_before_ = poses_;
  t_before_ = row_.time;
  row_.time = s.t;
  const auto n = static_cast<Eigen::Index>(which_.size());
  mechanism_.evaluate(which_, s, v_dot, *scratch_, row_.quantities.head(n));
  row_.quantities(n) = energy.work_in;
  row_.quantities(n + 1) = energy.dissipated;
  row_.quantities(n + 2) = energy.balance;
  // What the file would refuse, before any of the row is in it: those before are kept.
  for (Eigen::Index i = 0; i < row_.quantities.size(); ++i)
    if (const double value = row_.quantities(i); !std::isfinite(value))
      throw std::runtime_error(fmt::format(
          "{} is {} at t = {:.9g} s, beyond all numbers; give the drive, force or control that leads there a "
          "bound",
          quantities_[static_cast<std::size_t>(i)].name, std::isnan(value) ? std::abs(value) : value, s.t));
  range_.observe(s);
  turns_.observe(s, v_dot);
  paths_.observe(s, v_dot);
  creep_.observe(s, v_dot);
  mechanism_.body_poses(s, *scratch_, poses_);
  const auto set_pose = [&](std::size_t b, const mbs::Pose& X) {
    row_.pose[b].head<3>() = X.p;
    const Eigen::Quaterniond q(X.R);
    Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
    // The sign that continues the last row: pictures interpolate.
    if (wxyz.dot(row_.pose[b].tail<4>()) < 0.0) wxyz = -wxyz;
    row_.pose[b].tail<4>() = wxyz;
  };
  std::size_t element = poses_.size();
  for (std::size_t b = 0; b < poses_.size(); ++b) {
    set_pose(b, poses_[b]);
    for (const mbs::Pose& X : mbs::drawn_chords(mechanism_, static_cast<int>(b), s))
      set_pose(element++, poses_[b] * X);
    if (const double* modal = mechanism_.modal_coordinates(static_cast<int>(b), s))
      row_.modal[b] = Eigen::Map<const Eigen::VectorXd>(modal, run_bodies_[b].basis.cols());
  }
  if (store_states_) row_.states = pack(s);
  writer_.append(row_);
  if (look_) look_(row_.time, poses_, row_.modal);
}

}  // namespace flexura::app
