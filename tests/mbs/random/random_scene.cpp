// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/random_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/maker.hpp"

namespace flexura::mbs::chance {

Maker::Maker(std::uint64_t seed)
    : chance_(seed),
      second_(~seed),
      third_(seed ^ 0x5555555555555555u),
      fourth_(seed ^ 0x3333333333333333u),
      has_second_(seed % 3 == 0),
      has_third_(seed % 8 == 3),
      has_fourth_(seed % 25 == 7 && !has_third_) {
  s_.bodies.resize(1);
}

Scene Maker::make() {
  s_.gravity = chance_.flip(0.3) ? Vector3d::Zero() : Vector3d(9.81 * chance_.direction());
  if (chance_.flip(0.5)) s_.gravity = {0.0, 0.0, s_.gravity.isZero() ? 0.0 : -9.81};
  choose_kind();
  decorate();
  if (has_second_) {
    if (second_.flip(0.2)) add_wheel();
    if (second_.flip(0.3)) add_curve();
    decorate_more();
  }
  choose_start();
  if (s_.digits < 17) round_markers();
  if (s_.start == Start::guess) guess();
  if (has_third_) make_flexible();
  if (has_fourth_) make_beams();
  // Deformations vibrate many times in a tenth of that.
  s_.end_time = chance_.between(0.15, 0.4) * (s_.has_beams() ? 0.05 : s_.is_flexible() ? 0.2 : 1.0);
  s_.output_step = s_.end_time / 20.0;
  return std::move(s_);
}

void Maker::choose_kind() {
  switch (chance_.below(6)) {
    case 0:
      return tree();
    case 1:
      return spatial_loops();
    case 2:
    case 3:
      return planar();
    case 4:
      return door();
    default:
      return gears();
  }
}

void Maker::guess() {
  for (const Place& place : s_.places()) s_.guess.push_back(place.X_WB);
  for (std::size_t b = 1; b < s_.guess.size(); ++b) {
    s_.guess[b].R = rotation_exp(chance_.vector(0.03)) * s_.guess[b].R;
    s_.guess[b].p += chance_.vector(0.005);
  }
}

// Some of the bodies become flexible ones: where they stand and what sits on them stays.
void Maker::make_flexible() {
  const int n = static_cast<int>(s_.bodies.size()) - 1, surely = 1 + third_.below(n);
  for (int b = 1; b <= n; ++b) {
    if (b != surely && !third_.flip(0.4)) continue;
    SceneBody& body = s_.bodies[b];
    body.part = flexible_part(third_.below(kFlexibleParts));
    body.center.setZero();
    body.modes = third_.flip(0.6) ? body.part->n_modes() : 1 + third_.below(body.part->n_modes());
    if (third_.flip(0.5)) body.damping = third_.between(0.002, 0.05);
    const bool on_one = third_.flip(0.3);
    for (SceneMarker& marker : s_.markers)
      if (marker.body == b) marker.interface = on_one ? 0 : third_.below(2);
  }
  keep_a_joint_undriven();
  s_.what += ", flexible";
}

// Some become beams, of absolute nodal coordinates or of segments, whose tip goes as far as it likes.
void Maker::make_beams() {
  const int n = static_cast<int>(s_.bodies.size()) - 1, surely = 1 + fourth_.below(n);
  for (int b = 1; b <= n; ++b) {
    if (b != surely && !fourth_.flip(0.25)) continue;
    SceneBody& body = s_.bodies[b];
    SceneBeam beam;
    beam.fidelity = fourth_.flip(0.5) ? "ancf" : "segments";
    beam.elements = 1 + fourth_.below(2);
    beam.length = fourth_.between(0.2, 0.5);
    beam.mass = fourth_.between(0.1, 1.0);
    beam.side = beam.length / fourth_.between(8.0, 20.0);
    beam.bending = std::pow(10.0, fourth_.between(-0.5, 1.0));
    if (fourth_.flip(0.85)) beam.damping_time = std::pow(10.0, fourth_.between(-3.5, -2.5));
    body.beam = beam;
    body.part = std::make_shared<FlexiblePart>(beam.length, beam.mass);
    body.center.setZero();
    body.modes = 6;
    const bool on_one = fourth_.flip(0.3);
    for (SceneMarker& marker : s_.markers)
      if (marker.body == b) marker.interface = on_one ? 0 : fourth_.below(2);
  }
  keep_a_joint_undriven();
  s_.what += ", beams";
}

void Maker::keep_a_joint_undriven() {
  // Bodies that bend let every joint of a loop be driven, but one has to close it and has no start of its own then.
  if (std::ranges::all_of(s_.joints, [](const SceneJoint& joint) { return !joint.drives.empty(); }) &&
      !s_.joints.empty())
    s_.joints.back().drives.clear();
}

// The program's tree takes driven and coupled joints first; the others that close a loop here are cut, so that
// initial values stand on joints of the tree.
void Maker::choose_start() {
  bool has_free_root = false;
  for (std::size_t b = 1; b < s_.bodies.size(); ++b)
    has_free_root = has_free_root || !is_held(static_cast<int>(b));
  const auto is_wanted = [&](int j) {
    return !s_.joints[j].drives.empty() || std::ranges::any_of(s_.constraints, [&](const SceneConstraint& c) {
      return std::ranges::any_of(c.terms, [&](const auto& term) { return term.joint == j; });
    });
  };
  bool tree_is_ours = true, has_speeds = false;
  for (int j = 0; j < static_cast<int>(s_.joints.size()); ++j) {
    if (s_.joints[j].closes && !s_.joints[j].is_connection && is_wanted(j)) tree_is_ours = false;
    has_speeds = has_speeds || !s_.joints[j].speeds.empty();
  }
  s_.start = chance_.flip(0.2)                                     ? Start::guess
             : tree_is_ours && !has_free_root && chance_.flip(0.5) ? Start::joints
                                                                   : Start::poses;
  if (!tree_is_ours) {
    for (SceneJoint& joint : s_.joints) joint.speeds.clear();
    for (SceneBody& body : s_.bodies) body.velocity.setZero();
  } else if (s_.start == Start::joints || has_speeds || chance_.flip(0.5))
    for (SceneJoint& joint : s_.joints) joint.cut = joint.closes && !joint.is_connection;
  // What the body that leads a floating tree does at the start is not said where no joint says it.
  s_.order_matters = has_free_root && s_.bodies.size() > 2;
}

// By a joint, to ground at last.
bool Maker::is_held(int b) const {
  std::vector<bool> held(s_.bodies.size(), false);
  held[0] = true;
  for (std::size_t pass = 0; pass < s_.bodies.size(); ++pass)
    for (const SceneJoint& joint : s_.joints) {
      const int F = s_.markers[joint.F].body, M = s_.markers[joint.M].body;
      if (joint.closes) continue;
      if (held[F] || held[M]) held[F] = held[M] = true;
    }
  return held[b];
}

// As a file with so many digits gives them.
void Maker::round_markers() {
  const auto rounded = [&](double x) { return std::stod(fmt::format("{:.{}g}", x, s_.digits)); };
  for (SceneMarker& marker : s_.markers) {
    marker.X_BP.p = marker.X_BP.p.unaryExpr(rounded);
    if (marker.X_BP.R.isIdentity(0.0)) continue;
    const Eigen::Vector4d q = quaternion_of_rotation(marker.X_BP.R).unaryExpr(rounded);
    marker.X_BP.R = rotation_of_quaternion(q.data());
  }
}

Scene random_scene(std::uint64_t seed) {
  return Maker(seed).make();
}

}  // namespace flexura::mbs::chance
