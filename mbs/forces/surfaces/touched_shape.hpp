// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "mbs/forces/contacts/contact.hpp"
#include "mbs/kinematics/touched_surface.hpp"

namespace flexura::mbs {

/// A plane, sphere or cylinder that does not deform, as nodes of a surface touch it.
class TouchedShape final : public TouchedSurface {
 public:
  explicit TouchedShape(ContactSurface shape) : shape_(std::move(shape)) {}

  double separation(const Vector3d& p, const double*) const override {
    Vector3d n;
    return shape_.distance(p, n);
  }
  double bound(const Vector3d& c, const double* s, double) const override { return separation(c, s); }
  bool find_foot(const Vector3d& p, const double*, bool second, Foot& foot) const override {
    Vector3d n;
    foot.start();
    foot.gap = shape_.distance(p, n);
    if (foot.gap > 0.0) return false;
    foot.gap_z = n;
    if (!second) return true;
    foot.gap_zz = shape_.turning(p, n);
    foot.share_z.resize(0, 3);
    return true;
  }
  std::optional<DrawnSurface> drawn() const override { return shape_.drawn(); }

 private:
  ContactSurface shape_;
};

}  // namespace flexura::mbs
