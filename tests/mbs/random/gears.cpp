// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>
#include <string>
#include <utility>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/maker.hpp"

namespace flexura::mbs::chance {

namespace {
Matrix3d about_z(double angle) {
  return rotation_exp({0.0, 0.0, angle});
}
}  // namespace

// Shafts on a carrier, each in mesh with the next; racks; a ring that closes.
void Maker::gears() {
  s_.what = "gears";
  const int carrier = chance_.flip(0.3) ? grow("revolute", 0) : 0;
  const int n = 2 + chance_.below(3);
  const Matrix3d R = chance_.rotation();
  Train train;
  train.ends_in_rack = chance_.flip(0.3);
  for (int i = 0; i < n; ++i) {
    const Pose X = {R * about_z(angle()), R * Vector3d(0.3 * i, chance_.between(-0.1, 0.1), 0)};
    train.shafts.push_back(shaft(carrier, X, train.ends_in_rack && i == n - 1));
  }
  train.ratio.assign(n, 1.0);
  for (int k = 1; k < n; ++k) mesh(train, k - 1, k);
  if (chance_.flip(0.3) && n > 2 && !train.ends_in_rack) close_ring(train);
  drive(train);
}

int Maker::shaft(int carrier, const Pose& X_W, bool is_rack) {
  const int wheel = body(X_W * pose(0.02));
  const std::string type = is_rack ? "prismatic" : chance_.flip(0.2) ? "cylindrical" : "revolute";
  const Pose X_FM = is_rack ? Pose{Matrix3d::Identity(), {0, 0, chance_.between(-0.2, 0.2)}}
                            : Pose{about_z(chance_.between(-1, 1)), Vector3d::Zero()};
  Pose X_F = X_W * X_FM.inverse();
  if (is_rack) X_F = X_F * Pose{rotation_exp({0.5 * std::numbers::pi, 0, 0}), Vector3d::Zero()};
  return join(type, carrier, X_F, wheel, is_rack ? X_F * X_FM : X_W);
}

void Maker::mesh(Train& train, int i, int k) {
  SceneConstraint c;
  c.terms = {{train.shafts[i], 0, 1.0}, {train.shafts[k], 0, 1.0}};
  const double q_i = start_of(train.shafts[i]), q_k = start_of(train.shafts[k]);
  if (train.is_rack(k)) {
    c.type = "rack_and_pinion";
    std::swap(c.terms[0], c.terms[1]);
    c.length = chance_.either_sign(0.03, 0.1);
    c.offset = q_k - c.length * q_i;
    train.ratio[k] = train.ratio[i] * c.length;
  } else if (chance_.flip(0.3)) {
    c.type = "coupler";
    c.terms[1].factor = chance_.either_sign(0.5, 2.0);
    c.offset = q_i + c.terms[1].factor * q_k;
    train.ratio[k] = -train.ratio[i] / c.terms[1].factor;
  } else {
    c.type = "gear";
    c.teeth_1 = 10 + chance_.below(30);
    c.teeth_2 = 10 + chance_.below(30);
    c.internal = chance_.flip(0.3);
    const double factor = (c.internal ? -1.0 : 1.0) * c.teeth_2 / c.teeth_1;
    c.offset = q_i + factor * q_k;
    train.ratio[k] = -train.ratio[i] / factor;
  }
  s_.constraints.push_back(c);
}

// The last wheel back to the first, at the ratio that fits or another.
void Maker::close_ring(const Train& train) {
  const int first = train.shafts.front(), last = train.shafts.back();
  SceneConstraint c;
  c.type = "coupler";
  const bool agrees = chance_.flip(0.6);
  s_.what += agrees ? ", ring" : ", ring at another ratio";
  const double factor = -1.0 / train.ratio.back() * (agrees ? 1.0 : chance_.flip(0.5) ? 1.25 : 1.0001);
  c.terms = {{first, 0, 1.0}, {last, 0, factor}};
  c.offset = start_of(first) + factor * start_of(last);
  s_.constraints.push_back(c);
}

// None, one, or two drives that agree or not.
void Maker::drive(const Train& train) {
  const int first = train.shafts[0];
  const int n_drives = chance_.below(3);
  const Law law = drive_law(first, 0, start_of(first));
  const int derivative = chance_.below(3);
  if (n_drives > 0) s_.joints[first].drives = {{0, law, derivative}};
  if (n_drives > 1) {
    const int k = 1 + chance_.below(train.n() - 1), driven = train.shafts[k];
    Law other = law;
    other.a = start_of(driven) - train.ratio[k] * (law.value(0.0) - law.a);
    other.b *= train.ratio[k];
    other.c *= train.ratio[k];
    const bool agrees = chance_.flip(0.6);
    s_.what += agrees ? ", two drives that agree" : ", two drives that do not";
    if (!agrees) other.b += (train.is_rack(k) ? 0.02 : 0.3) * (chance_.flip(0.5) ? 1 : -1);
    s_.joints[driven].drives = {{0, other, chance_.flip(0.7) ? derivative : chance_.below(3)}};
  }
  if (n_drives == 0 && chance_.flip(0.5)) s_.joints[first].speeds = {{0, chance_.between(-3, 3)}};
}

}  // namespace flexura::mbs::chance
