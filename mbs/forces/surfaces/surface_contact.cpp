// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/surfaces/surface_contact.hpp"

#include "mbs/kinematics/deformation_derivatives.hpp"

namespace flexura::mbs {
namespace {

/// tanh(|v| / v_0) / |v|, and its derivative by |v|.
struct Onset {
  double phi, slope;
  Onset(double speed, double v_0) {
    const double z = speed / v_0;
    if (z < 1e-4) {  // tanh z / z = 1 - z^2 / 3
      phi = (1.0 - z * z / 3.0) / v_0;
      slope = -2.0 / 3.0 * z / (v_0 * v_0);
      return;
    }
    const double step = std::tanh(z);
    phi = step / speed;
    slope = ((1.0 - step * step) / v_0 - phi) / speed;
  }
};

}  // namespace

SurfaceContact::View SurfaceContact::view(const Kinematics& kin) const {
  const BodyState& body = kin.bodies[static_cast<std::size_t>(body_)];
  return {kin.relative_motion(F_, B_), body.s, body.s_dot};
}

SurfacePatch::Least SurfaceContact::nearest(const View& at) const {
  const Pose& X = at.rel.X_FM;
  return patch_->least(at.s, [&](const Vector3d& rho) {
    Vector3d n;
    return shape_.distance(X.p + X.R * rho, n);
  });
}

template <class Take>
void SurfaceContact::for_touching(const View& at, const Take& take) const {
  const Pose& X = at.rel.X_FM;
  const Vector3d w = at.rel.V.head<3>(), u = at.rel.V.tail<3>();
  patch_->visit(
      at.s,
      [&](const Vector3d& c, double radius) {
        Vector3d n;
        return shape_.distance(X.p + X.R * c, n) < radius;
      },
      [&](int j, const Vector3d& rho) {
        Touch t;
        t.r = X.R * rho;
        const double gap = shape_.distance(X.p + t.r, t.n);
        if (!(gap < 0.0)) return;
        t.node = j;
        t.turned_v = X.R * patch_->velocity(j, at.s_dot);
        t.v = u + w.cross(t.r) + t.turned_v;
        t.gap_rate = t.n.dot(t.v);
        t.area = patch_->area(j);
        t.p = law_.at(-gap, -t.gap_rate);
        t.sliding = t.v - t.gap_rate * t.n;
        t.friction.setZero();
        if (friction_.mu > 0.0)
          t.friction =
              -friction_.mu * t.area * t.p.p * Onset(t.sliding.norm(), friction_.v_0).phi * t.sliding;
        take(t);
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
  if (least.value != 0.0) return;
  const Vector3d r = at.rel.X_FM.R * least.rho;
  Vector3d n;
  shape_.distance(at.rel.X_FM.p + r, n);
  const Vector3d v = at.rel.V.tail<3>() + at.rel.V.head<3>().cross(r) +
                     at.rel.X_FM.R * patch_->velocity(least.node, at.s_dot);
  root[0] = n.dot(v) < 0.0 ? 1 : 0;
}

void SurfaceContact::apply(const Kinematics& kin, const double*, Loads& loads) const {
  if (kin.own.root[0] == 0) return;
  const View at = view(kin);
  Vector6d on_B = Vector6d::Zero();
  thread_local Eigen::VectorXd modal;  // nothing is allocated in a run
  modal.setZero(patch_->m());
  for_touching(at, [&](const Touch& t) {
    const Vector3d f = t.force();
    on_B.head<3>() += t.r.cross(f);
    on_B.tail<3>() += f;
    if (modal.size() > 0)
      modal.noalias() += patch_->shapes(t.node).transpose() * (at.rel.X_FM.R.transpose() * f);
  });
  loads.apply_between(kin, F_, B_, on_B);
  if (modal.size() > 0) loads.apply_modal(body_, modal, 1.0);
}

// With n the gradient of the gap and H its Hessian: d gap = n . dp, d(gap') = n . dv + v . H dp, and of the sliding velocity
// v_t = v - n (n . v): d v_t = dv - n d(gap') - (H dp) (n . v).
void SurfaceContact::slopes(const Touch& t, const Vector3d& p, Matrix3d& by_place,
                            Matrix3d& by_velocity) const {
  const Matrix3d H = shape_.turning(p, t.n), nn = t.n * t.n.transpose();
  const double N = t.area * t.p.p;
  const Eigen::RowVector3d rate_by_place = t.v.transpose() * H;
  const Eigen::RowVector3d N_by_place =
      -t.area * (t.p.by_depth * t.n.transpose() + t.p.by_rate * rate_by_place);
  const Eigen::RowVector3d N_by_velocity = -t.area * t.p.by_rate * t.n.transpose();
  by_place = t.n * N_by_place + N * H;
  by_velocity = t.n * N_by_velocity;
  if (!(friction_.mu > 0.0)) return;
  const double speed = t.sliding.norm();
  const Onset onset(speed, friction_.v_0);
  const Matrix3d sliding_by_place = -t.n * rate_by_place - H * t.gap_rate,
                 sliding_by_velocity = Matrix3d::Identity() - nn;
  Matrix3d by_sliding = onset.phi * Matrix3d::Identity();
  if (speed > 0.0) by_sliding += onset.slope / speed * t.sliding * t.sliding.transpose();
  by_place -= friction_.mu * (onset.phi * t.sliding * N_by_place + N * by_sliding * sliding_by_place);
  by_velocity -=
      friction_.mu * (onset.phi * t.sliding * N_by_velocity + N * by_sliding * sliding_by_velocity);
}

void SurfaceContact::differentiate(const Kinematics& kin, const double*, Derivatives& d) const {
  if (kin.own.root[0] == 0) return;
  const View at = view(kin);
  const Matrix3d& R = at.rel.X_FM.R;
  const Vector3d w = at.rel.V.head<3>();
  const int m = at.s ? patch_->m() : 0;
  Vector6d on_B = Vector6d::Zero();
  Eigen::Matrix<double, 6, 12> on_B_by = Eigen::Matrix<double, 6, 12>::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> on_B_by_s = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, m),
                                           on_B_by_s_dot = on_B_by_s;
  Eigen::MatrixXd modal_by = Eigen::MatrixXd::Zero(m, 12), modal_by_s = Eigen::MatrixXd::Zero(m, m),
                  modal_by_s_dot = modal_by_s;
  for_touching(at, [&](const Touch& t) {
    Matrix3d K, D;
    slopes(t, at.rel.X_FM.p + t.r, K, D);
    const Vector3d f = t.force();
    const Matrix3d r_x = skew(t.r), f_x = skew(f);
    // dp = dp_B + dtheta x r + R Phi ds;  dv = du + dw x r + w x (dtheta x r + R Phi ds) + dtheta x R Phi s' + R Phi ds'.
    Eigen::Matrix<double, 3, 12> f_by;
    f_by.leftCols<3>() = -K * r_x - D * (skew(w) * r_x + skew(t.turned_v));
    f_by.middleCols<3>(3) = K;
    f_by.middleCols<3>(6) = -D * r_x;
    f_by.rightCols<3>() = D;
    on_B.head<3>() += t.r.cross(f);
    on_B.tail<3>() += f;
    on_B_by.topRows<3>() += r_x * f_by;
    on_B_by.topLeftCorner<3, 3>() += f_x * r_x;
    on_B_by.bottomRows<3>() += f_by;
    if (m == 0) return;
    const Matrix3d by_moved = (K + D * skew(w)) * R, by_rate = D * R;
    const auto Phi = patch_->shapes(t.node);
    on_B_by_s.topRows<3>().noalias() += (r_x * by_moved - f_x * R) * Phi;
    on_B_by_s.bottomRows<3>().noalias() += by_moved * Phi;
    on_B_by_s_dot.topRows<3>().noalias() += (r_x * by_rate) * Phi;
    on_B_by_s_dot.bottomRows<3>().noalias() += by_rate * Phi;
    // R^T f: R turns with dtheta, -R^T (dtheta x f).
    Eigen::Matrix<double, 3, 12> in_B = R.transpose() * f_by;
    in_B.leftCols<3>() += R.transpose() * f_x;
    modal_by.noalias() += Phi.transpose() * in_B;
    const Matrix3d by_moved_B = R.transpose() * by_moved, by_rate_B = R.transpose() * by_rate;
    modal_by_s.noalias() += Phi.transpose() * (by_moved_B * Phi);
    modal_by_s_dot.noalias() += Phi.transpose() * (by_rate_B * Phi);
  });
  d.between(F_, B_, on_B);
  d.by_relative(F_, B_, on_B_by);
  if (m == 0) return;
  DeformationDerivatives& deformation = d.deformations();
  for (int i = 0; i < m; ++i) {
    d.by_deformation(body_, i, on_B_by_s.col(i));
    deformation.by_deformation_rate(body_, i, on_B_by_s_dot.col(i));
  }
  deformation.modal_forces(body_, F_, B_, modal_by);
  deformation.modal_forces_by(body_, body_, modal_by_s, modal_by_s_dot);
}

void SurfaceContact::add_powers(const Kinematics& kin, const double*, Powers& powers) const {
  if (kin.own.root[0] == 0) return;
  for_touching(view(kin), [&](const Touch& t) {
    powers.potential += t.area * t.p.energy;
    powers.dissipated += t.area * (t.p.elastic - t.p.p) * t.gap_rate - t.friction.dot(t.sliding);
  });
}

std::vector<OutputInfo> SurfaceContact::outputs() const {
  using namespace input;
  return {{"gap", dim::length, "least distance of a node; negative: penetration"},
          {"normal_force", dim::force, "sum of the sizes of the pressures' forces"},
          {"friction_force", dim::force, "size of the sum"},
          {"force_x", dim::force, "on the body, in the axes of `from`"},
          {"force_y", dim::force, "on the body, in the axes of `from`"},
          {"force_z", dim::force, "on the body, in the axes of `from`"},
          {"area", dim::area, "of the nodes that touch"},
          {"pressure", dim::pressure, "the greatest"},
          {"nodes", dim::none, "how many touch"}};
}

void SurfaceContact::evaluate_outputs(const Kinematics& kin, const double*, double* values) const {
  const View at = view(kin);
  double normal = 0.0, area = 0.0, pressure = 0.0;
  int nodes = 0;
  Vector3d friction = Vector3d::Zero(), force = Vector3d::Zero();
  if (kin.own.root[0] == 1)
    for_touching(at, [&](const Touch& t) {
      normal += t.area * t.p.p;
      friction += t.friction;
      force += t.force();
      area += t.area;
      pressure = std::max(pressure, t.p.p);
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
