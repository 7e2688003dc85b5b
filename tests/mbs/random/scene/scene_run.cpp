// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/scene/scene_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "mbs/base/math/rotation.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"

namespace flexura::mbs::chance {

bool is_documented(const std::exception& e) {
  return dynamic_cast<const std::invalid_argument*>(&e) || dynamic_cast<const std::runtime_error*>(&e);
}

std::string to_file(const Scene& scene, const Writing& how, const std::string& file) {
  const std::filesystem::path path = file + how.suffix + ".toml";
  std::ofstream(path) << to_toml(scene, path.parent_path(), how);
  return path;
}

RowReader::RowReader(const Scene& scene, const Writing& how, const Mechanism& m)
    : scene_(scene), how_(how), m_(m), scratch_(m.make_scratch()) {
  std::vector<std::string> names;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (scene.joints[j].is_connection) continue;
    for (const NamedCoordinate& c : coordinates_of(scene.joints[j].type)) {
      names.push_back(fmt::format("j{}.{}", j, c.name));
      names.push_back(fmt::format("j{}.{}", j, c.speed));
    }
  }
  if (!names.empty()) which_ = select_quantities(m, names);
  if (which_.size() != names.size()) throw std::logic_error("joint coordinates that are no quantities");
  values_.resize(static_cast<Eigen::Index>(which_.size()));
  // Their rates are their speeds: which, is asked.
  const State start = m.initial_state();
  Eigen::VectorXd rates(start.p.size());
  for (int b = 0; b < static_cast<int>(m.description().bodies.size()); ++b) modal_speed_.push_back(-1);
  for (Eigen::Index i = 0; i < start.v.size(); ++i) {
    m.kinematic(start.p, Eigen::VectorXd::Unit(start.v.size(), i), rates);
    for (std::size_t b = 0; b < modal_speed_.size(); ++b)
      if (const int at = m.modal_position(static_cast<int>(b)); at >= 0 && rates(at) == 1.0)
        modal_speed_[b] = static_cast<int>(i);
  }
}

RanRow RowReader::read(const State& s, const Eigen::VectorXd& v_dot) {
  std::vector<MarkerState> bodies;
  m_.body_motions(s, v_dot, *scratch_, bodies);
  RanRow row;
  row.t = s.t;
  row.motion.resize(scene_.bodies.size());
  for (int i = 1; i < static_cast<int>(bodies.size()); ++i) {
    const std::string& name = m_.description().bodies[i].name;
    if (name.find('.') != std::string::npos) continue;  // a piece of a beam
    read_body(i, bodies[i], s, v_dot, row.motion[std::stoul(name.substr(1))]);
  }
  read_ends(s, bodies, row);
  const EnergyReport energy = m_.energy(s, v_dot, *scratch_);
  const double joule = 1.0 / (how_.mass * how_.length * how_.length);
  row.kinetic = joule * energy.kinetic;
  row.potential = joule * (energy.potential + energy.strain);
  read_coordinates(s, v_dot, row);
  return row;
}

void RowReader::read_body(int b, const MarkerState& x, const State& s, const Eigen::VectorXd& v_dot,
                          BodyMotion& out) const {
  const double unit = 1.0 / how_.length;
  out.place.X_WB = {x.X_WP.R, unit * x.X_WP.p};
  out.V = {x.V.angular, unit * x.V.linear};
  out.A = {x.A.angular, unit * x.A.linear};
  if (modal_speed_[b] < 0 || scene_.bodies[std::stoul(m_.description().bodies[b].name.substr(1))].beam)
    return;
  out.place.q = modal(b, m_.modal_coordinates(b, s));
  out.q_dot = modal(b, s.v.data() + modal_speed_[b]);
  out.q_ddot = modal(b, v_dot.data() + modal_speed_[b]);
}

// A marker's motion in W.
MarkerState RowReader::marker(const std::string& name, const State& s,
                              const std::vector<MarkerState>& bodies) const {
  const MechanismDescription& d = m_.description();
  const auto marker = std::ranges::find(d.markers, name, &MarkerDescription::name);
  const MarkerState& B = bodies[marker->body];
  Pose X_BP = marker->X_BP;
  Spatial V;  // relative to B, expressed in B
  if (marker->node >= 0) {
    NodeMotion motion;
    const FlexibleBody& body = *d.bodies[marker->body].flexible;
    motion.map.resize(6, body.m());
    body.node_motion(marker->node, m_.modal_coordinates(marker->body, s),
                     s.v.data() + modal_speed_[marker->body], nullptr, motion);
    X_BP = motion.X_BN;
    V = motion.V;
  }
  MarkerState out;
  out.X_WP = B.X_WP * X_BP;
  out.V.angular = B.V.angular + B.X_WP.R * V.angular;
  out.V.linear = B.V.linear + B.V.angular.cross(Vector3d(out.X_WP.p - B.X_WP.p)) + B.X_WP.R * V.linear;
  return out;
}

// The frame of a scene's beam is that of its root, its coordinates are where the tip stands: u and theta with
// X_RT = (exp(theta), l + u).
void RowReader::read_ends(const State& s, const std::vector<MarkerState>& bodies, RanRow& row) const {
  const double unit = 1.0 / how_.length;
  for (std::size_t b = 1; b < scene_.bodies.size(); ++b) {
    if (!scene_.bodies[b].beam) continue;
    const MarkerState root = marker(fmt::format("b{}.root", b), s, bodies),
                      tip = marker(fmt::format("b{}.tip", b), s, bodies);
    const Pose X_RT = root.X_WP.inverse() * tip.X_WP;
    const Matrix3d to_root = root.X_WP.R.transpose();
    const Vector3d theta = rotation_log(X_RT.R), w = to_root * (tip.V.angular - root.V.angular),
                   v = to_root * (tip.V.linear - root.V.linear -
                                  root.V.angular.cross(Vector3d(tip.X_WP.p - root.X_WP.p)));
    BodyMotion& out = row.motion[b];
    out.place.X_WB = {root.X_WP.R, unit * root.X_WP.p};
    out.V = {root.V.angular, unit * root.V.linear};
    out.place.q.resize(6);
    out.place.q << unit * X_RT.p - scene_.bodies[b].part->interface_at(1), theta;
    out.q_dot.resize(6);
    out.q_dot << unit * v, left_jacobian(theta).inverse() * w;
    out.q_ddot = Eigen::VectorXd::Zero(6);
  }
}

// The program's coordinates are others than the scene's: u_se is what they have in common.
Eigen::VectorXd RowReader::modal(int b, const double* values) const {
  const BodyDescription& body = m_.description().bodies[b];
  const Eigen::MatrixXd& Y = body.flexible->modal()->Y;
  const SceneBody& of_scene = scene_.bodies[std::stoul(body.name.substr(1))];
  const Eigen::VectorXd u_se = Y * Eigen::Map<const Eigen::VectorXd>(values, Y.cols());
  return of_scene.part->modal(of_scene.part->from_units(u_se, how_.length, how_.mass)).head(of_scene.modes);
}

void RowReader::read_coordinates(const State& s, const Eigen::VectorXd& v_dot, RanRow& row) {
  m_.evaluate(which_, s, v_dot, *scratch_, values_);
  Eigen::Index k = 0;
  row.coordinates.resize(scene_.joints.size());
  row.speeds.resize(scene_.joints.size());
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    if (scene_.joints[j].is_connection) continue;
    for (const NamedCoordinate& c : coordinates_of(scene_.joints[j].type)) {
      const double unit = c.is_angle() ? 1.0 : 1.0 / how_.length;
      row.coordinates[j].push_back(unit * values_(k++));
      row.speeds[j].push_back(unit * values_(k++));
    }
  }
}

Ran simulate(const Scene& scene, const Writing& how, const std::string& file) {
  Ran ran;
  try {
    const PreparedMechanism p = prepare(to_file(scene, how, file));
    ran.end = Ran::End::stopped;
    RowReader reader(scene, how, *p.mechanism);
    RunCallbacks callbacks;
    callbacks.row = [&](const State& s, const Eigen::VectorXd& v_dot, const EnergyAccount&) {
      ran.rows.push_back(reader.read(s, v_dot));
    };
    const RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
    ran.balance = r.energy.relative_error();
    ran.warning = r.near_rank_loss;
    ran.steps = r.counts.steps;
    ran.message = r.stopped_because;
    if (r.complete) ran.end = Ran::End::complete;
  } catch (const std::exception& e) {
    if (ran.end == Ran::End::broken && is_documented(e)) ran.end = Ran::End::refused;
    if (!is_documented(e)) ran.end = Ran::End::broken;
    ran.message = e.what();
  }
  return ran;
}

double difference(const std::vector<BodyMotion>& a, const std::vector<BodyMotion>& b, double size) {
  double d = 0.0;
  for (std::size_t i = 1; i < a.size(); ++i)
    d = std::max({d, (a[i].place.X_WB.p - b[i].place.X_WB.p).norm() / size,
                  rotation_log(a[i].place.X_WB.R.transpose() * b[i].place.X_WB.R).norm()});
  return d;
}

// At the rows that both have.
double difference(const Ran& a, const Ran& b, double size) {
  double d = 0.0;
  for (std::size_t k = 0; k < std::min(a.rows.size(), b.rows.size()); ++k)
    d = std::max(d, difference(a.rows[k].motion, b.rows[k].motion, size));
  return d;
}

}  // namespace flexura::mbs::chance
