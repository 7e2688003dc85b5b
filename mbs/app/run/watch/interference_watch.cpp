// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/watch/interference_watch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/body_shapes.hpp"
#include "mbs/view/tessellate.hpp"

namespace flexura::app {
namespace {

using mbs::Pose;
using mbs::Vector3d;
using terminal::number;

// Each shape a surface of its own: they may lie in one another.
std::vector<proximity::Surface> surfaces_of_shapes(const mbs::BodyDescription& body, double& radius) {
  std::vector<proximity::Surface> out;
  for (const auto& shape : view::parse_body_shapes(body.name, body.shape_json)) {
    view::Tessellation drawn;
    view::tessellate(shape, drawn);
    if (drawn.triangles.empty()) continue;
    Eigen::Matrix3Xd x(3, static_cast<Eigen::Index>(drawn.points.size()));
    for (std::size_t i = 0; i < drawn.points.size(); ++i) {
      x.col(static_cast<Eigen::Index>(i)) = drawn.points[i];
      radius = std::max(radius, drawn.points[i].norm());
    }
    Eigen::Matrix3Xi f(3, static_cast<Eigen::Index>(drawn.triangles.size()));
    for (std::size_t t = 0; t < drawn.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        f(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(t)) = drawn.triangles[t][k];
    out.emplace_back(x, f);
  }
  return out;
}

bool is_same(const Pose& a, const Pose& b, double radius) {
  return (a.p - b.p).norm() + radius * (a.R - b.R).norm() < 1e-9 * (1e-3 + radius);
}

}  // namespace

InterferenceWatch::InterferenceWatch(const mbs::PreparedMechanism& prepared, double tolerance)
    : tolerance_(tolerance) {
  const mbs::MechanismDescription& d = prepared.mechanism->description();
  bodies_.resize(d.bodies.size());
  for (std::size_t b = 0; b < d.bodies.size(); ++b) add_surfaces(d, b);
  std::set<std::pair<int, int>> joined;
  for (const mbs::JointDescription& joint : d.joints) {
    const int a = d.markers[static_cast<std::size_t>(joint.marker_F)].body,
              b = d.markers[static_cast<std::size_t>(joint.marker_M)].body;
    if (joint.joint->n_v() < 6) joined.insert(std::minmax(a, b));
  }
  const auto n = static_cast<int>(bodies_.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (!bodies_[static_cast<std::size_t>(a)].surfaces.empty() &&
          !bodies_[static_cast<std::size_t>(b)].surfaces.empty())
        pairs_.push_back({.a = a, .b = b, .is_joined = joined.contains({a, b})});
}

void InterferenceWatch::add_surfaces(const mbs::MechanismDescription& d, std::size_t b) {
  const mbs::BodyDescription& description = d.bodies[b];
  Body& body = bodies_[b];
  body.name = description.name;
  body.surfaces = surfaces_of_shapes(description, body.radius);
  if (!description.superelement.empty()) {
    superelement::Parts parts;
    parts.matrices = parts.inertia = false;
    parts.surface = true;
    const mbs::ModalData* const modal = description.flexible ? description.flexible->modal() : nullptr;
    parts.shapes = modal != nullptr;
    const superelement::Superelement se = superelement::read(description.superelement, parts);
    if (se.surface.triangles.rows() > 0) {
      const Eigen::Matrix3Xd x = se.surface.vertices.transpose().cast<double>();
      body.surfaces.clear();  // what the part looks like is better than what stands for it
      body.surfaces.emplace_back(x, se.surface.triangles.transpose().cast<int>());
      body.radius = x.colwise().norm().maxCoeff();
      if (modal) {
        body.vertices = x;
        body.shapes = se.shapes.cast<double>() * modal->Y;
      }
    }
  }
  for (const proximity::Surface& surface : body.surfaces) {
    body.is_closed = body.is_closed && surface.is_closed();
    body.facet_error = std::max(body.facet_error, surface.facet_error());
  }
}

void InterferenceWatch::take(double t, const std::vector<Pose>& poses,
                             const std::vector<Eigen::VectorXd>& modal) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<double> grown(bodies_.size(), 0.0);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (body.shapes.cols() == 0 || modal[b].size() != body.shapes.cols()) continue;
    const Eigen::VectorXd u = body.shapes * modal[b];
    const Eigen::Map<const Eigen::Matrix3Xd> by_vertex(u.data(), 3, body.vertices.cols());
    grown[b] = by_vertex.colwise().norm().maxCoeff();
    body.surfaces.front().move_vertices(body.vertices + by_vertex);
  }
  for (Pair& pair : pairs_) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    const double reach = bodies_[a].radius + bodies_[b].radius + grown[a] + grown[b];
    const Pose X_AB = poses[a].inverse() * poses[b];
    pass(X_AB, reach, pair);
    if ((poses[a].p - poses[b].p).norm() > reach) {
      pair.seen = true;
      meet(t, false, pair);
      continue;
    }
    const bool are_rigid = bodies_[a].shapes.cols() == 0 && bodies_[b].shapes.cols() == 0;
    if (are_rigid && pair.X_AB && is_same(*pair.X_AB, X_AB, reach)) {
      meet(t, pair.was_met, pair);
      continue;
    }
    if (are_rigid) pair.X_AB = X_AB;
    look(t, poses, pair);
  }
  wall_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// From the last row to this one: bodies whose spheres stay apart by more than they moved have not met.
void InterferenceWatch::pass(const Pose& X_AB, double reach, Pair& pair) {
  if (pair.row_X_AB) {
    const double way = (X_AB.p - pair.row_X_AB->p).norm() +
                       bodies_[static_cast<std::size_t>(pair.b)].radius * (X_AB.R - pair.row_X_AB->R).norm();
    if (std::min(X_AB.p.norm(), pair.row_X_AB->p.norm()) - reach < way)
      blind_way_ = std::max(blind_way_, way);
  }
  pair.row_X_AB = X_AB;
}

void InterferenceWatch::look(double t, const std::vector<Pose>& poses, Pair& pair) const {
  const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
  const double off = tolerance_ + bodies_[a].facet_error + bodies_[b].facet_error,
               allowed = off + (pair.is_joined ? pair.at_start : 0.0);
  // At the start of joined bodies every depth counts: it is what they are allowed later.
  const double beyond = pair.is_joined && !pair.seen ? 0.0 : allowed;
  std::optional<proximity::Overlap> deepest;
  for (const proximity::Surface& s : bodies_[a].surfaces)
    for (const proximity::Surface& u : bodies_[b].surfaces)
      if (const auto overlap = proximity::overlap_of(s, poses[a], u, poses[b], beyond))
        if (!deepest || !deepest->depth || (overlap->depth && *overlap->depth > *deepest->depth))
          deepest = overlap;
  const bool is_first = !pair.seen;
  if (is_first) {
    pair.seen = true;
    pair.at_start = deepest ? deepest->depth.value_or(0.0) : 0.0;
  }
  if (deepest && !deepest->depth) {
    // Joined bodies touch: without an inside of both there is nothing to tell that from more.
    pair.is_unknown = true;
    if (!pair.is_joined && !pair.is_told()) {
      pair.t = t;
      pair.p_W = deepest->p_W;
    }
    meet(t, !pair.is_joined, pair);
    return;
  }
  // What they are at the start is no news of it.
  if (pair.is_joined && is_first) {
    meet(t, false, pair);
    return;
  }
  const bool met = deepest && *deepest->depth > allowed;
  if (met && (!pair.depth || *deepest->depth > *pair.depth)) {
    pair.depth = deepest->depth;
    pair.t = t;
    pair.p_W = deepest->p_W;
  }
  meet(t, met, pair);
}

void InterferenceWatch::meet(double t, bool now, Pair& pair) {
  if (now && !pair.was_met) {
    if (pair.times++ == 0) pair.from = t;
  }
  if (now && pair.times == 1) pair.to = t;
  pair.was_met = now;
}

std::vector<const InterferenceWatch::Pair*> InterferenceWatch::told() const {
  std::vector<const Pair*> out;
  for (const Pair& pair : pairs_)
    if (pair.is_told()) out.push_back(&pair);
  std::ranges::stable_sort(
      out, [](const Pair* a, const Pair* b) { return a->depth.value_or(0.0) > b->depth.value_or(0.0); });
  return out;
}

std::string InterferenceWatch::sentence(const Pair& pair) const {
  const std::string &a = bodies_[static_cast<std::size_t>(pair.a)].name,
                    &b = bodies_[static_cast<std::size_t>(pair.b)].name;
  const std::string when =
      pair.from == pair.to ? fmt::format("at t = {} s", number(pair.from, 4))
                           : fmt::format("from t = {} s to {} s", number(pair.from, 4), number(pair.to, 4));
  const std::string again = pair.times > 1 ? fmt::format(" and {} more times", pair.times - 1) : "";
  const std::string where = fmt::format("({}, {}, {}) m", number(pair.p_W.x(), 4), number(pair.p_W.y(), 4),
                                        number(pair.p_W.z(), 4));
  if (!pair.depth)
    return fmt::format(
        "bodies \"{}\" and \"{}\" cross {}{}, at {}; how deep is unknown, as the surface of \"{}\" is "
        "not closed",
        a, b, when, again, where, bodies_[static_cast<std::size_t>(pair.a)].is_closed ? b : a);
  return fmt::format("bodies \"{}\" and \"{}\" overlap {}{}, by {} mm at most, at t = {} s about {}", a, b,
                     when, again, number(1e3 * *pair.depth, 3), number(pair.t, 4), where);
}

std::vector<std::string> InterferenceWatch::sentences() const {
  constexpr std::size_t most = 10;
  std::vector<std::string> out;
  const auto list = told();
  for (std::size_t i = 0; i < list.size() && i < most; ++i) out.push_back(sentence(*list[i]));
  if (list.size() > most)
    out.push_back(fmt::format("{} more pairs of bodies overlap; the summary of the results names them",
                              list.size() - most));
  std::vector<std::string> unknown, bare;
  for (const Pair& pair : pairs_)
    if (pair.is_unknown && pair.is_joined)
      unknown.push_back(fmt::format("\"{}\" and \"{}\"", bodies_[static_cast<std::size_t>(pair.a)].name,
                                    bodies_[static_cast<std::size_t>(pair.b)].name));
  if (!unknown.empty())
    out.push_back(fmt::format(
        "whether {} overlap is unknown: they are joined and touch, and a surface of theirs is not closed",
        fmt::join(unknown, ", ")));
  for (std::size_t b = 1; b < bodies_.size(); ++b)
    if (bodies_[b].surfaces.empty()) bare.push_back(bodies_[b].name);
  if (!bare.empty())
    out.push_back(fmt::format(
        "overlaps of {} are unknown: without a superelement or shapes there is no surface to look at",
        fmt::join(bare, ", ")));
  return out;
}

nlohmann::json InterferenceWatch::json() const {
  nlohmann::json out = nlohmann::json::array();
  for (const Pair* pair : told())
    out.push_back(
        {{"bodies",
          {bodies_[static_cast<std::size_t>(pair->a)].name, bodies_[static_cast<std::size_t>(pair->b)].name}},
         {"depth", pair->depth ? nlohmann::json(*pair->depth) : nlohmann::json()},
         {"time", pair->t},
         {"point", {pair->p_W.x(), pair->p_W.y(), pair->p_W.z()}},
         {"from", pair->from},
         {"to", pair->to},
         {"times", pair->times}});
  return out;
}

}  // namespace flexura::app
