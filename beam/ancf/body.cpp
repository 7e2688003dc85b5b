// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/body.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <functional>
#include <stdexcept>

namespace flexura::beam::ancf {

ReferenceCurve straight_curve(const Eigen::Vector3d& start, const Eigen::Vector3d& end, int n_elements,
                              const Eigen::Vector3d& y_axis) {
  if (n_elements < 1)
    throw std::invalid_argument(
        fmt::format("a beam of {} elements asked for; it needs at least one.", n_elements));
  const double length = (end - start).norm();
  if (!(length > 0.0)) throw std::invalid_argument("the beam's two ends coincide; give it a length.");
  const Eigen::Vector3d t = (end - start) / length, y = y_axis - t * t.dot(y_axis);
  if (!(y.norm() > 1e-6 * y_axis.norm()))
    throw std::invalid_argument("the beam's y axis lies along its own axis; choose another direction.");
  ReferenceCurve curve;
  curve.s = Eigen::VectorXd::LinSpaced(n_elements + 1, 0.0, length);
  curve.position = (t * curve.s.transpose()).colwise() + start;
  curve.tangent = t.replicate(1, n_elements + 1);
  curve.y_axis = y.normalized().replicate(1, n_elements + 1);
  return curve;
}

AncfBody::AncfBody(std::vector<std::unique_ptr<Element>> elements, Eigen::VectorXd q_rest)
    : elements_(std::move(elements)), q_rest_(std::move(q_rest)) {
  if (elements_.empty()) throw std::invalid_argument("a body without elements; it needs at least one.");
  for (const auto& element : elements_)
    if (element->dim() != dim() || element->vectors() != vectors())
      throw std::invalid_argument(
          "a body mixes elements of different kinds; join two bodies by a constraint instead.");
  if (q_rest_.size() != n_q())
    throw std::invalid_argument(fmt::format("{} coordinates given for {} nodes of {}; the body needs {}.",
                                            q_rest_.size(), n_nodes(), node_coordinates(), n_q()));
  mass_ = mass_times(Eigen::MatrixXd::Identity(dim(), dim()));
  mass_factor_.factor(mass_);
  for (const auto& element : elements_) {
    length_ += element->length();
    total_mass_ += element->compact_weight()[0] + element->compact_weight()[vectors()];
  }
}

AncfBody::Scratch AncfBody::make_scratch() const {
  const int n = 2 * node_coordinates();
  return {Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
}

Eigen::VectorXd AncfBody::placed(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) const {
  const int d = dim();
  if (d == 2 && (std::abs(R(2, 2) - 1) > 1e-12 || p[2] != 0.0))
    throw std::invalid_argument("a planar line can be placed in the x-y plane only.");
  Eigen::VectorXd q(n_q());
  for (int i = 0; i < n_q() / d; ++i) {
    q.segment(d * i, d) = R.topLeftCorner(d, d) * q_rest_.segment(d * i, d);
    if (i % vectors() == 0) q.segment(d * i, d) += p.head(d);
  }
  return q;
}

Eigen::VectorXd AncfBody::rigid_velocity(const Eigen::VectorXd& q, const Eigen::Vector3d& v_0,
                                         const Eigen::Vector3d& w) const {
  const int d = dim();
  if (d == 2 && (w[0] != 0.0 || w[1] != 0.0 || v_0[2] != 0.0))
    throw std::invalid_argument("a planar line moves in the x-y plane only.");
  Eigen::VectorXd v(n_q());
  for (int i = 0; i < n_q() / d; ++i) {
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    at.head(d) = q.segment(d * i, d);
    v.segment(d * i, d) = w.cross(at).head(d);
    if (i % vectors() == 0) v.segment(d * i, d) += v_0.head(d);
  }
  return v;
}

namespace {
// Velocities of a body at rest; as many as the largest element has coordinates.
constexpr double kStill[24] = {};
}  // namespace

void AncfBody::force(const Eigen::VectorXd& q, const Eigen::VectorXd* v, VectorRef f) const {
  f.setZero();
  for (int k = 0; k < n_elements(); ++k) {
    const int at = k * node_coordinates();
    elements_[k]->add_force(q.data() + at, v ? v->data() + at : kStill, nullptr, f.data() + at, nullptr,
                            nullptr);
  }
}

void AncfBody::force_and_tangents(const Eigen::VectorXd& q, const Eigen::VectorXd* v, Scratch& scratch,
                                  VectorRef f, BlockTridiagonal& K, BlockTridiagonal& D,
                                  const Eigen::VectorXd* q_before) const {
  f.setZero();
  K.set_zero();
  D.set_zero();
  for (int k = 0; k < n_elements(); ++k) {
    const int at = k * node_coordinates();
    scratch.K_e.setZero();
    scratch.D_e.setZero();
    elements_[k]->add_force(q.data() + at, v ? v->data() + at : kStill,
                            q_before ? q_before->data() + at : nullptr, f.data() + at, scratch.K_e.data(),
                            scratch.D_e.data());
    K.add_element(k, scratch.K_e);
    D.add_element(k, scratch.D_e);
  }
}

BlockTridiagonal AncfBody::mass_times(const Eigen::MatrixXd& W) const {
  const int d = dim(), n_s = 2 * vectors();
  BlockTridiagonal out(n_nodes(), node_coordinates());
  Eigen::MatrixXd M_e(d * n_s, d * n_s);
  for (int k = 0; k < n_elements(); ++k) {
    const Eigen::MatrixXd& m = elements_[k]->compact_mass();
    for (int s = 0; s < n_s; ++s)
      for (int t = 0; t < n_s; ++t) M_e.block(d * s, d * t, d, d) = m(s, t) * W;
    out.add_element(k, M_e);
  }
  return out;
}

Eigen::VectorXd AncfBody::gravity_force(const Eigen::Vector3d& g) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n_q());
  const int d = dim();
  for (int k = 0; k < n_elements(); ++k)
    for (int s = 0; s < 2 * vectors(); ++s)
      f.segment(k * node_coordinates() + d * s, d) += elements_[k]->compact_weight()[s] * g.head(d);
  return f;
}

double AncfBody::strain_energy(const Eigen::VectorXd& q) const {
  double sum = 0.0;
  for (int k = 0; k < n_elements(); ++k)
    sum += elements_[k]->strain_energy(q.data() + k * node_coordinates());
  return sum;
}

double AncfBody::kinetic_energy(const Eigen::VectorXd& v) const {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(n_q());
  mass_.multiply_add(0.5, v, p);
  return p.dot(v);
}

double AncfBody::dissipation(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const {
  double sum = 0.0;
  for (int k = 0; k < n_elements(); ++k) {
    const int at = k * node_coordinates();
    sum += elements_[k]->dissipation(q.data() + at, v.data() + at);
  }
  return sum;
}

Momentum AncfBody::momentum(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const {
  // L = int r x r' dm = sum_ij m_ij q_i x v_j over position and slope vectors; p the part that a translation
  // feels.
  Momentum out;
  Eigen::VectorXd p = Eigen::VectorXd::Zero(n_q());
  mass_.multiply_add(1.0, v, p);
  const int d = dim();
  for (int i = 0; i < n_q() / d; ++i) {
    Eigen::Vector3d q_i = Eigen::Vector3d::Zero(), p_i = Eigen::Vector3d::Zero();
    q_i.head(d) = q.segment(d * i, d);
    p_i.head(d) = p.segment(d * i, d);
    if (i % vectors() == 0) out.linear += p_i;
    out.angular += q_i.cross(p_i);
  }
  return out;
}

MaterialPoint AncfBody::locate(double s) const {
  // The last digits of a sum of element lengths are forgiven.
  if (!(s >= -1e-12 * length_ && s <= (1 + 1e-12) * length_))
    throw std::invalid_argument(
        fmt::format("the point at arc length {:g} m lies outside the beam's 0 to {:g} m.", s, length_));
  double start = 0.0;
  for (int k = 0;; ++k) {
    const double l = elements_[k]->length();
    if (s <= start + l || k + 1 == n_elements()) return {k, std::clamp((s - start) / l, 0.0, 1.0)};
    start += l;
  }
}

namespace {

using MakeElement = std::function<std::unique_ptr<Element>(double length, const double* e_0)>;

AncfBody make_body(const ReferenceCurve& curve, int dim, int vectors, const MakeElement& make) {
  const int n_nodes = static_cast<int>(curve.s.size());
  if (n_nodes < 2 || curve.position.cols() != n_nodes || curve.tangent.cols() != n_nodes ||
      (vectors == 4 && curve.y_axis.cols() != n_nodes))
    throw std::invalid_argument(fmt::format(
        "a curve of {} nodes with {} positions, {} tangents and {} y axes; it needs at least two nodes and "
        "one of each for every node.",
        n_nodes, curve.position.cols(), curve.tangent.cols(), curve.y_axis.cols()));
  Eigen::VectorXd q(n_nodes * dim * vectors);
  for (int i = 0; i < n_nodes; ++i) {
    const Eigen::Vector3d t = curve.tangent.col(i);
    if (dim == 2 && (curve.position(2, i) != 0.0 || t[2] != 0.0))
      throw std::invalid_argument(fmt::format("node {} of a planar line lies outside the x-y plane.", i));
    auto node = q.segment(i * dim * vectors, dim * vectors);
    node.head(dim) = curve.position.col(i).head(dim);
    node.segment(dim, dim) = t.head(dim);
    if (vectors == 4) {
      const Eigen::Vector3d y = curve.y_axis.col(i);
      if (std::abs(y.dot(t)) > 1e-9 || std::abs(y.norm() - 1) > 1e-9 || std::abs(t.norm() - 1) > 1e-9)
        throw std::invalid_argument(fmt::format("tangent and y axis of node {} are not orthonormal.", i));
      node.segment(6, 3) = y;
      node.segment(9, 3) = t.cross(y);
    }
  }
  std::vector<std::unique_ptr<Element>> elements;
  for (int k = 0; k + 1 < n_nodes; ++k)
    elements.push_back(make(curve.s[k + 1] - curve.s[k], q.data() + k * dim * vectors));
  return AncfBody(std::move(elements), std::move(q));
}

}  // namespace

AncfBody planar_line(const LineSection& section, const ReferenceCurve& curve) {
  return make_body(curve, 2, 2,
                   [&](double l, const double* e_0) { return make_planar_line(section, l, e_0); });
}

AncfBody spatial_line(const LineSection& section, const ReferenceCurve& curve) {
  return make_body(curve, 3, 2, [&](double l, const double*) { return make_spatial_line(section, l); });
}

AncfBody spatial_beam(const BeamSection& section, const ReferenceCurve& curve) {
  return make_body(curve, 3, 4,
                   [&](double l, const double* e_0) { return make_spatial_beam(section, l, e_0); });
}

AncfBody solid_beam(const SolidSection& section, const ReferenceCurve& curve) {
  return make_body(curve, 3, 4,
                   [&](double l, const double* e_0) { return make_solid_beam(section, l, e_0); });
}

}  // namespace flexura::beam::ancf
