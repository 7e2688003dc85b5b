// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/surfaces/surface_contact.hpp"

#include <algorithm>
#include <string>

#include "mbs/forces/surfaces/onset.hpp"

namespace flexura::mbs {
SurfaceContact::View SurfaceContact::view(const Kinematics& kin) const {
  const BodyState& body = kin.bodies[static_cast<std::size_t>(body_)];
  const int m_o = touched_->m();
  const BodyState other = m_o > 0 ? kin.bodies[static_cast<std::size_t>(other_)] : BodyState{};
  touched_->start(other.s);
  return {kin.relative_motion(F_, B_), body.s, body.s_dot, other.s, other.s_dot, m_o};
}

SurfacePatch::Least SurfaceContact::nearest(const View& at) const {
  const Pose& X = at.rel.X_FM;
  return patch_->least(
      at.s, [&](const Vector3d& c, double enough) { return touched_->bound(X.p + X.R * c, at.o, enough); },
      [&](const Vector3d& rho) { return touched_->separation(X.p + X.R * rho, at.o); });
}

void SurfaceContact::for_touching(const View& at, bool second,
                                  const std::function<void(const Touch&)>& take) const {
  const Pose& X = at.rel.X_FM;
  const Vector3d w = at.rel.V.head<3>(), u = at.rel.V.tail<3>();
  thread_local TouchedSurface::Foot foot;  // nothing is allocated in a run
  thread_local Eigen::VectorXd z_dot, force;
  patch_->visit(
      at.s,
      [&](const Vector3d& c, double radius) { return touched_->bound(X.p + X.R * c, at.o, radius) < radius; },
      [&](int j, const Vector3d& rho) {
        const Vector3d r = X.R * rho;
        if (!touched_->find_foot(X.p + r, at.o, second, foot) || !(foot.gap < 0.0)) return;
        const Vector3d turned_v = X.R * patch_->velocity(j, at.s_dot);
        z_dot.resize(foot.n());
        z_dot.head<3>() = u + w.cross(r) + turned_v;
        Vector3d v = z_dot.head<3>();
        for (std::size_t k = 0; k < foot.vertices.size(); ++k) {
          const auto i = static_cast<Eigen::Index>(k);
          z_dot.segment<3>(3 + 3 * i) = touched_->velocity(foot.vertices[k], at.o_dot);
          v -= foot.share(i) * z_dot.segment<3>(3 + 3 * i);
        }
        const double gap_rate = foot.gap_z.dot(z_dot), area = patch_->area(j);
        const Vector3d n = foot.gap_z.head<3>().normalized(), sliding = v - n.dot(v) * n;
        const PressureLaw::Value law = law_.at(-foot.gap, -gap_rate);
        const double p = foot.cover * law.p;
        force = area * p * foot.gap_z;
        if (foot.is_at_end) force -= area * law.energy * foot.cover_z;
        Vector3d friction = Vector3d::Zero();
        if (friction_.mu > 0.0) {
          friction = -friction_.mu * area * p * Onset(sliding.norm(), friction_.v_0).phi * sliding;
          force.head<3>() += friction;
          for (Eigen::Index k = 0; k < foot.share.size(); ++k)
            force.segment<3>(3 + 3 * k) -= foot.share(k) * friction;
        }
        take(Touch{j, r, turned_v, foot, z_dot, n, v, sliding, gap_rate, area, p, law, friction, force});
      });
}

void SurfaceContact::switching(const Kinematics& kin, const double*, double* values) const {
  const double gap = nearest(view(kin)).value;
  values[0] = kin.own.root[0] == 1 ? -gap : gap;
}

void SurfaceContact::start_switches(const Kinematics& kin, const double*, int* root, double*) const {
  const View at = view(kin);
  const SurfacePatch::Least least = nearest(at);
  root[0] = least.value < 0.0 ? 1 : 0;
  TouchedSurface::Foot foot;
  const Vector3d r = at.rel.X_FM.R * least.rho;
  if (least.value != 0.0 || !touched_->find_foot(at.rel.X_FM.p + r, at.o, false, foot)) return;
  const Vector3d v = at.rel.V.tail<3>() + at.rel.V.head<3>().cross(r) +
                     at.rel.X_FM.R * patch_->velocity(least.node, at.s_dot);
  double rate = foot.gap_z.head<3>().dot(v);
  for (std::size_t k = 0; k < foot.vertices.size(); ++k)
    rate += foot.gap_z.segment<3>(3 + 3 * static_cast<Eigen::Index>(k))
                .dot(touched_->velocity(foot.vertices[k], at.o_dot));
  root[0] = rate < 0.0 ? 1 : 0;
}

void SurfaceContact::apply(const Kinematics& kin, const double*, Loads& loads) const {
  if (kin.own.root[0] == 0) return;
  const View at = view(kin);
  Vector6d on_B = Vector6d::Zero();
  thread_local Eigen::VectorXd modal, other_modal;  // nothing is allocated in a run
  modal.setZero(patch_->m());
  other_modal.setZero(at.m_o);
  for_touching(at, false, [&](const Touch& t) {
    const Vector3d f = t.force.head<3>();
    on_B.head<3>() += t.r.cross(f);
    on_B.tail<3>() += f;
    if (modal.size() > 0)
      modal.noalias() += patch_->shapes(t.node).transpose() * (at.rel.X_FM.R.transpose() * f);
    if (at.m_o == 0) return;
    for (std::size_t k = 0; k < t.foot.vertices.size(); ++k)
      other_modal.noalias() += touched_->shapes(t.foot.vertices[k]).transpose() *
                               t.force.segment<3>(3 + 3 * static_cast<Eigen::Index>(k));
  });
  loads.apply_between(kin, F_, B_, on_B);
  if (modal.size() > 0) loads.apply_modal(body_, modal, 1.0);
  if (at.m_o > 0) loads.apply_modal(other_, other_modal, 1.0);
}

void SurfaceContact::add_powers(const Kinematics& kin, const double*, Powers& powers) const {
  if (kin.own.root[0] == 0) return;
  for_touching(view(kin), false, [&](const Touch& t) {
    powers.potential += t.area * t.foot.cover * t.law.energy;
    powers.dissipated +=
        t.area * t.foot.cover * (t.law.elastic - t.law.p) * t.gap_rate - t.friction.dot(t.sliding);
  });
}

std::vector<OutputInfo> SurfaceContact::outputs() const {
  using namespace input;
  std::vector<OutputInfo> infos = {{"gap", dim::length, "least distance of a node; negative: penetration"},
                                   {"normal_force", dim::force, "sum of the sizes of the pressures' forces"},
                                   {"friction_force", dim::force, "size of the sum"},
                                   {"force_x", dim::force, "on the body, in the axes of `from`"},
                                   {"force_y", dim::force, "on the body, in the axes of `from`"},
                                   {"force_z", dim::force, "on the body, in the axes of `from`"},
                                   {"area", dim::area, "of the nodes that touch"},
                                   {"pressure", dim::pressure, "the greatest"},
                                   {"nodes", dim::none, "how many touch"}};
  if (gives_pressures_)
    for (int k = 0; k < patch_->size(); ++k)
      infos.push_back({"pressure_at_" + std::to_string(patch_->number_of_given(k)), dim::pressure,
                       "at this vertex of the body's surface"});
  return infos;
}

void SurfaceContact::evaluate_outputs(const Kinematics& kin, const double*, double* values) const {
  const View at = view(kin);
  double normal = 0.0, area = 0.0, pressure = 0.0;
  int nodes = 0;
  Vector3d friction = Vector3d::Zero(), force = Vector3d::Zero();
  constexpr int n_of_all = 9;
  if (gives_pressures_) std::fill_n(values + n_of_all, patch_->size(), 0.0);
  if (kin.own.root[0] == 1)
    for_touching(at, false, [&](const Touch& t) {
      if (gives_pressures_) values[n_of_all + patch_->given(t.node)] = t.p;
      normal += t.area * t.p;
      friction += t.friction;
      force += t.force.head<3>();
      area += t.area;
      pressure = std::max(pressure, t.p);
      ++nodes;
    });
  values[0] = nearest(at).value;
  values[1] = normal;
  values[2] = friction.norm();
  Eigen::Map<Vector3d>(values + 3) = force;
  values[6] = area;
  values[7] = pressure;
  values[8] = nodes;
}

}  // namespace flexura::mbs
