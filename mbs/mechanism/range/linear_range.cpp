// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/range/linear_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mbs/bodies/beams/ancf_part.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;

// Mean displacement by the body's size from where on its surface is looked at: a beam held at both ends misses 2 % of
// its stiffness at 0.17 of its thickness, one of 1/500 of its length so at 3e-4.
constexpr double kAskProbes = 1e-3, kAskLines = 3e-4;
// ANCF elements that turn by less are within turn^4/32 = 0.05 % of the beam's bending stiffness.
constexpr double kWellTurned = 20.0 * std::numbers::pi / 180.0;
// How often it is asked whether ends are held: where half as much more stiffness is left out.
constexpr double kAskAgain = 1.5;

// A rod of this radius of gyration about its middle is as long.
double length_of(const FlexibleBody& body) {
  double size = 0.0;
  if (const ModalData* const data = body.modal(); data && data->inertia.mass > 0.0) {
    const superelement::InertiaIntegrals& in = data->inertia;
    const Vector3d c = in.S_x / in.mass;
    size = std::sqrt(std::max(0.0, 12.0 * ((in.S_xx.trace()) / in.mass - c.squaredNorm())));
  }
  const auto& nodes = body.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) size = std::max(size, (nodes[i].p_BoN_B - nodes[j].p_BoN_B).norm());
  return size;
}

std::string at_place(const Vector3d& p) {
  return fmt::format("its surface at ({:.4g}, {:.4g}, {:.4g}) m", p.x(), p.y(), p.z());
}

}  // namespace

LinearRange::LinearRange(const Mechanism& mechanism, double span, const RangeLimits& limits)
    : mechanism_(mechanism), span_(span), limits_(limits), watched_(mechanism.description().bodies.size()) {
  std::string chain;
  for (std::size_t b = 0; b < watched_.size(); ++b) {
    const FlexibleBody* body = mechanism.deforming(static_cast<int>(b));
    if (!body) continue;
    watched_[b].size = length_of(*body);
    const std::string& name = mechanism.description().bodies[b].name;
    if (!body->stiff_direction() || (!chain.empty() && name.starts_with(chain))) continue;
    chain = name + ".";
    planar_.push_back(static_cast<int>(b));
  }
  if (!planar_.empty()) scratch_ = mechanism.make_scratch();
}

void LinearRange::observe_planes(const State& s) {
  const Vector3d& g = mechanism_.description().gravity;
  if (planar_.empty() || g.isZero(0.0)) return;
  mechanism_.body_poses(s, *scratch_, of_bodies_);
  for (const int b : planar_) {
    Worst& across = watched_[static_cast<std::size_t>(b)].across;
    const Vector3d n = *mechanism_.deforming(b)->stiff_direction();
    const double part = std::abs(g.dot(of_bodies_[static_cast<std::size_t>(b)].R * n)) / g.norm();
    if (part > across.value) across = {part, s.t, part * g.norm(), "", ""};
  }
}

void LinearRange::observe(const State& s) {
  observe_planes(s);
  for (std::size_t b = 0; b < watched_.size(); ++b) {
    const FlexibleBody* body = mechanism_.deforming(static_cast<int>(b));
    if (!body) continue;
    const double* modal = mechanism_.modal_coordinates(static_cast<int>(b), s);
    if (body->is_linear()) {
      observe_linear(static_cast<int>(b), s, modal);
      continue;
    }
    // Any bending is fine that its elements can follow; what it is made of stretches linearly.
    Watched& watched = watched_[b];
    if (const auto* const beam = dynamic_cast<const AncfPart*>(body))
      if (const double turn = beam->largest_turn(modal); turn > watched.turn.value)
        watched.turn = {turn, s.t, std::ceil(turn / kWellTurned) * beam->beam().n_elements(), "", ""};
    const auto& nodes = body->nodes();
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double l = (nodes[i].p_BoN_B - nodes[j].p_BoN_B).norm();
        const double now =
            (body->node_pose(static_cast<int>(i), modal).p - body->node_pose(static_cast<int>(j), modal).p)
                .norm();
        if (!(l > 1e-6 * watched.size) || !(now / l - 1.0 > watched.strain.value)) continue;
        watched.strain = {now / l - 1.0, s.t, 0.0,
                          "the line from \"" + nodes[j].name + "\" to \"" + nodes[i].name + "\"", ""};
        watched.of_size = {(now - l) / watched.size, s.t, now - l, nodes[i].name, nodes[j].name};
      }
  }
}

void LinearRange::observe_displacement(Watched& watched, double t, double moved, double distance,
                                       const std::string& what, const std::string& against) const {
  // Places at one point (the hub and the rim of a wheel) have no line between them that could turn.
  const double l = distance > 1e-3 * watched.size ? distance : watched.size;
  if (moved > watched.displacement.value * l) watched.displacement = {moved / l, t, moved, what, against};
  if (moved > watched.of_size.value * watched.size)
    watched.of_size = {moved / watched.size, t, moved, what, against};
}

void LinearRange::ask_surface(int b, const double* modal) {
  const FlexibleBody& body = *mechanism_.deforming(b);
  Watched& watched = watched_[b];
  const std::string& file = mechanism_.description().bodies[b].superelement;
  const ModalData* const data = body.modal();
  if (!data) return;
  // Second-order displacements know of the shortening, and a deformation that does not act back holds nothing.
  const bool has_lines = data->nodes.size() > 1 && !data->second && body.acts_back();
  const double moved = Eigen::Map<const Eigen::VectorXd>(modal, body.m()).norm() / std::sqrt(body.mass());
  const auto& of_beam = mechanism_.description().bodies[b].of_beam;
  if (watched.asked || (file.empty() && !of_beam) ||
      !(moved > (has_lines ? kAskLines : kAskProbes) * watched.size))
    return;
  watched.asked = true;
  superelement::Parts parts;
  parts.matrices = has_lines;
  parts.inertia = false;
  parts.surface = parts.shapes = true;
  try {
    const superelement::Superelement se = of_beam ? *of_beam : superelement::read(file, parts);
    auto probes = std::make_shared<DeformationProbes>(probes_of(se, data->Y));
    if (has_lines) watched.lines = bending_lines(se, *data);
    watched.size = std::max(watched.size, probes->size);
    watched.probes = std::move(probes);
  } catch (const std::exception&) {  // the file was moved: interfaces are judged alone
  }
}

void LinearRange::observe_lines(int b, const State& state, const Eigen::VectorXd& s) {
  Watched& watched = watched_[b];
  if (watched.lines.empty()) return;
  const FlexibleBody& body = *mechanism_.deforming(b);
  const double strain_energy = 0.5 * s.cwiseAbs2().dot(body.modal()->stiffness);
  for (const BendingLine& line : watched.lines) {
    const double closer = s.dot(line.Q * s), tension = closer / line.compliance;
    const double missed = tension * closer / strain_energy;
    if (!(missed > limits_.stiffness) || !(missed > kAskAgain * watched.line_asked)) continue;
    watched.line_asked = missed;
    const double held = how_held(mechanism_, b, line, state, span_);
    if (!(held * missed > watched.held.value)) continue;
    const auto& nodes = body.nodes();
    watched.held = {held * missed, state.t, closer, nodes[line.to].name, nodes[line.from].name};
    watched.tension = held * tension;
  }
}

void LinearRange::observe_linear(int b, const State& state, const double* modal) {
  const double t = state.t;
  const FlexibleBody& body = *mechanism_.deforming(b);
  Watched& watched = watched_[b];
  const auto& nodes = body.nodes();
  const int n = static_cast<int>(nodes.size()), m = body.m();
  poses_.resize(n);
  for (int i = 0; i < n; ++i) poses_[i] = body.node_pose(i, modal);
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) {
      const double angle = rotation_log(poses_[i].R.transpose() * poses_[j].R).norm();
      if (angle > watched.rotation.value) watched.rotation = {angle, t, 0.0, nodes[j].name, nodes[i].name};
    }
  const auto seen_from = [&](int j, const Vector3d& p, const Vector3d& p_0) {
    return (poses_[j].R.transpose() * (p - poses_[j].p) - (p_0 - nodes[j].p_BoN_B)).norm();
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (i != j)
        observe_displacement(watched, t, seen_from(j, poses_[i].p, nodes[i].p_BoN_B),
                             (nodes[i].p_BoN_B - nodes[j].p_BoN_B).norm(), "its \"" + nodes[i].name + "\"",
                             nodes[j].name);

  const Eigen::Map<const Eigen::VectorXd> s(modal, m);
  ask_surface(b, modal);
  observe_lines(b, state, s);
  if (!watched.probes || watched.probes->points.cols() == 0) return;
  const DeformationProbes& probes = *watched.probes;
  const Index n_points = probes.points.cols();
  displacements_.resize(3, n_points);
  Eigen::Map<Eigen::VectorXd>(displacements_.data(), 3 * n_points).noalias() = probes.displacements * s;
  for (Index k = 0; k < n_points; ++k) {
    const Vector3d p_0 = probes.points.col(k), p = p_0 + displacements_.col(k);
    for (int j = 0; j < n; ++j) {
      const double moved = seen_from(j, p, p_0), distance = (p_0 - nodes[j].p_BoN_B).norm();
      if (moved > watched.displacement.value * std::max(distance, 1e-3 * watched.size) ||
          moved > watched.of_size.value * watched.size)
        observe_displacement(watched, t, moved, distance, at_place(p_0), nodes[j].name);
    }
  }
  strains_.noalias() = probes.strains * s;
  Index which = 0;
  if (strains_.size() > 0)
    if (const double e = strains_.cwiseAbs().maxCoeff(&which); e > watched.strain.value)
      watched.strain = {e, t, 0.0, at_place(probes.strain_places.col(which)), ""};
}

std::vector<std::string> LinearRange::sentences() const {
  std::vector<std::string> out;
  for (std::size_t b = 0; b < watched_.size(); ++b) {
    const Watched& w = watched_[b];
    const std::string& name = mechanism_.description().bodies[b].name;
    const FlexibleBody* body = mechanism_.deforming(static_cast<int>(b));
    if (!body) continue;
    if (body->is_linear() && w.of_size.value > limits_.of_size) {
      out.push_back(fmt::format(
          "body \"{}\" is deformed by more than its own size: at t = {:.6g} s {} is displaced by {:.3g} m "
          "against "
          "\"{}\", and the body is {:.3g} m long: displacements linear in the modes mean nothing there",
          name, w.of_size.t, w.of_size.what, w.of_size.moved, w.of_size.against,
          w.of_size.moved / w.of_size.value));
    } else if (w.rotation.value > limits_.rotation) {
      out.push_back(
          fmt::format("body \"{}\" leaves the linear range of its deformation: at t = {:.6g} s its interface "
                      "\"{}\" is turned "
                      "by {:.3g} deg against \"{}\", and displacements linear in the modes are wrong by "
                      "about {:.2g} % of its "
                      "length",
                      name, w.rotation.t, w.rotation.what, w.rotation.value * 180.0 / std::numbers::pi,
                      w.rotation.against, 50.0 * w.rotation.value * w.rotation.value));
    } else if (w.displacement.value > limits_.displacement) {
      out.push_back(fmt::format(
          "body \"{}\" leaves the linear range of its deformation: at t = {:.6g} s {} is displaced by {:.3g} "
          "m "
          "against \"{}\", {:.3g} of their distance (linear up to about {:.3g}), and displacements linear in "
          "the "
          "modes are wrong by about {:.2g} % of that distance",
          name, w.displacement.t, w.displacement.what, w.displacement.moved, w.displacement.against,
          w.displacement.value, limits_.displacement, 60.0 * w.displacement.value * w.displacement.value));
    }
    if (w.across.value > limits_.across)
      out.push_back(
          fmt::format("body \"{}\" is planar and does not yield across its plane, where gravity has {:.3g} "
                      "m/s^2 at t = {:.6g} s: turn y_axis into the plane of the motion, or take planar away",
                      name, w.across.moved, w.across.t));
    if (w.held.value > limits_.stiffness)
      out.push_back(fmt::format(
          "body \"{}\" is held where its bending would bring its interfaces closer: \"{}\" and \"{}\" by "
          "{:.3g} m at "
          "t = {:.6g} s, which makes a tension of {:.3g} N and about {:.2g} % more stiffness that "
          "displacements linear in "
          "the modes do not have; take fidelity \"modal-stiffened\" (a superelement with stiffening = true), "
          "or segments",
          name, w.held.against, w.held.what, w.held.moved, w.held.t, w.tension, 100.0 * w.held.value));
    if (w.turn.value > limits_.turn)
      out.push_back(fmt::format(
          "body \"{}\" bends by {:.3g} degrees within an element at t = {:.6g} s, further than its "
          "{} elements can follow: give it {:g} (body.{}.beam.elements), or fidelity = \"beam\"",
          name, w.turn.value * 180.0 / std::numbers::pi, w.turn.t,
          static_cast<const AncfPart*>(body)->beam().n_elements(), w.turn.moved, name));
    if (w.strain.value > limits_.strain)
      out.push_back(
          fmt::format("body \"{}\" is strained by {:.3g} % at t = {:.6g} s at {}: its elasticity is linear, "
                      "and no material's is up to there",
                      name, 100.0 * w.strain.value, w.strain.t, w.strain.what));
  }
  return out;
}

bool LinearRange::is_left(int body) const {
  const Watched& w = watched_[static_cast<std::size_t>(body)];
  return w.rotation.value > limits_.rotation || w.displacement.value > limits_.displacement ||
         w.of_size.value > limits_.of_size || w.held.value > limits_.stiffness;
}

std::string LinearRange::runaway() const {
  for (std::size_t b = 0; b < watched_.size(); ++b) {
    const Watched& w = watched_[b];
    if (!(w.of_size.value > limits_.runaway)) continue;
    return fmt::format(
        "body \"{}\" is deformed by {:.3g} times its own size at t = {:.6g} s: its deformation grows without "
        "bound; the "
        "motion is unstable, or its loads are far beyond what it can carry (a body whose spin softens it "
        "needs "
        "fidelity \"modal-stiffened\", one with fidelity \"ked\" bears no load that depends on its "
        "deformation)",
        mechanism_.description().bodies[b].name, w.of_size.value, w.of_size.t);
  }
  return {};
}

}  // namespace flexura::mbs
