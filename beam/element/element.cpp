// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/element.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "beam/element/quadrature.hpp"
#include "beam/element/releases.hpp"

namespace flexura::beam {
namespace {

// D X, X D and D^T X for the two entries D_{M_y,V_z} = 1, D_{M_z,V_y} = -1.
template <class Matrix>
Matrix D_times(const Matrix& X) {
  Matrix Y = Matrix::Zero();
  Y.row(M_y) = X.row(V_z);
  Y.row(M_z) = -X.row(V_y);
  return Y;
}
template <class Matrix>
Matrix D_transposed_times(const Matrix& X) {
  Matrix Y = Matrix::Zero();
  Y.row(V_z) = X.row(M_y);
  Y.row(V_y) = -X.row(M_z);
  return Y;
}
Matrix6d times_D(const Matrix6d& X) {
  Matrix6d Y = Matrix6d::Zero();
  Y.col(V_z) = X.col(M_y);
  Y.col(V_y) = -X.col(M_z);
  return Y;
}
// R(xi) X = X - xi D^T X
template <class Matrix>
Matrix transport(double xi, const Matrix& X) {
  return X - xi * D_transposed_times(X);
}

// Integrand b^T f b = f + xi (D^T f + f D) + xi^2 D^T f D.
Matrix6d flexibility_density(double xi, const Matrix6d& f) {
  const Matrix6d fD = times_D(f);
  return f + xi * (fD + fD.transpose()) + xi * xi * D_transposed_times(fD);
}

}  // namespace

SectionMatrices matrices_of(const Section& section, Theory theory) {
  return {theory == Theory::timoshenko ? section.f : section.f_shear_rigid, section.inertia};
}

Element::Element(double length, const SectionMatrices& section, Releases releases)
    : length_(length), uniform_(true), section_(section) {
  if (!(length > 0.0)) throw std::invalid_argument(fmt::format("its length {:g} must be positive", length));
  const Matrix6d& f = section.f;
  F_ = length * f + length * length * length / 12.0 * D_transposed_times(times_D(f));
  // Shapes are cubic, so mass integrands have degree 6: four points are exact.
  for (const auto& [point, weight] : gauss_points(4))
    stations_.push_back({0.5 * length * point, 0.5 * length * weight, section, Matrix6x12d::Zero()});
  finish(releases);
}

Element::Element(double length, const std::function<SectionMatrices(double)>& along, Releases releases,
                 int points)
    : length_(length), uniform_(false), along_(along) {
  if (!(length > 0.0)) throw std::invalid_argument(fmt::format("its length {:g} must be positive", length));
  if (points < 2 || points > 16)
    throw std::invalid_argument(fmt::format("{} integration points are outside 2 to 16", points));
  for (const auto& [point, weight] : gauss_points(points))
    stations_.push_back(
        {0.5 * length * point, 0.5 * length * weight, along(0.5 + 0.5 * point), Matrix6x12d::Zero()});
  for (const Station& station : stations_)
    F_ += station.weight * flexibility_density(station.xi, station.section.f);
  finish(releases);
}

void Element::finish(Releases releases) {
  const double h = 0.5 * length_;
  const Matrix6d unit = Matrix6d::Identity();
  H_ << -transport(h, unit), transport(-h, unit);
  const ReleasedElement released = release(F_, H_, length_, releases);
  F_inverse_ = released.F_inverse;
  slip_ = released.slip;
  K_ = H_.transpose() * F_inverse_ * H_;
  K_ = (0.5 * (K_ + K_.transpose())).eval();
  if (releases.any()) {
    ends_ += slip_ * (F_ * F_inverse_ - unit) * H_;
    for (int dof = 0; dof < 12; ++dof)
      if (releases[dof]) {
        ends_.col(dof).setZero();
        K_.row(dof).setZero();
        K_.col(dof).setZero();
      }
  }
  G_left_ = transported_flexibility(-h);
  G_right_ = transported_flexibility(h);
  for (Station& station : stations_)
    station.shape = shape_at(station.xi, transported_flexibility(station.xi));
}

Matrix6d Element::transported_flexibility(double xi) const {
  if (uniform_) {
    const Matrix6d fD = times_D(section_.f);
    return xi * section_.f + 0.5 * xi * xi * (fD - fD.transpose()) -
           xi * xi * xi / 6.0 * D_transposed_times(fD);
  }
  Matrix6d G = Matrix6d::Zero();
  for (const auto& [point, weight] : gauss_points(static_cast<int>(stations_.size()))) {
    const double t = 0.5 * xi * (1.0 + point);
    const Matrix6d f = along_(0.5 + t / length_).f;
    G += 0.5 * xi * weight * transport(xi - t, Matrix6d(f + t * times_D(f)));
  }
  return G;
}

Matrix6x12d Element::shape_at(double xi, const Matrix6d& G) const {
  const double h = 0.5 * length_;
  const Matrix6x12d s_m = F_inverse_ * H_;
  const Matrix6x12d left = ends_.topRows<6>() - G_left_ * s_m, right = ends_.bottomRows<6>() - G_right_ * s_m;
  const Matrix6x12d d_m = 0.5 * (transport(h, left) + transport(-h, right));
  return transport(xi, d_m) + G * s_m;
}

Matrix6x12d Element::shape(double x) const {
  const double xi = x - 0.5 * length_;
  return shape_at(xi, transported_flexibility(xi));
}

Matrix12d Element::mass(bool rotary_inertia) const {
  Matrix12d M = Matrix12d::Zero();
  for (const Station& station : stations_) {
    Matrix6d section = station.section.inertia.matrix();
    if (!rotary_inertia) {
      section.block<2, 2>(4, 4).setZero();
      section.block<1, 2>(0, 4).setZero();
      section.block<2, 1>(4, 0).setZero();
    }
    M += station.weight * (station.shape.transpose() * section * station.shape);
  }
  return 0.5 * (M + M.transpose());
}

Vector6d Element::particular_resultants(double xi, const LineLoad& load) const {
  // s' = D s - p with s(0) = 0, p = p_m + xi p_1.
  const Vector6d p_m = 0.5 * (load.at_1 + load.at_2), p_1 = (load.at_2 - load.at_1) / length_;
  return -(xi * p_m + 0.5 * xi * xi * p_1 +
           D_times(Vector6d(0.5 * xi * xi * p_m + xi * xi * xi / 6.0 * p_1)));
}

Vector6d Element::particular_stretch(const LineLoad& load) const {
  Vector6d stretch = Vector6d::Zero();
  for (const Station& station : stations_) {
    const Vector6d strain = station.section.f * particular_resultants(station.xi, load);
    stretch += station.weight * (strain + station.xi * D_transposed_times(strain));
  }
  return stretch;
}

Vector6d Element::particular_displacement(double xi, const LineLoad& load) const {
  Vector6d d = Vector6d::Zero();
  for (const auto& [point, weight] : gauss_points(static_cast<int>(stations_.size()))) {
    const double t = 0.5 * xi * (1.0 + point);
    const Matrix6d& f = uniform_ ? section_.f : along_(0.5 + t / length_).f;
    d += 0.5 * xi * weight * transport(xi - t, Vector6d(f * particular_resultants(t, load)));
  }
  return d;
}

Vector6d Element::mid_resultants(const Vector12d& q, const LineLoad& load) const {
  const double h = 0.5 * length_;
  Vector12d end_forces;
  end_forces << -particular_resultants(-h, load), particular_resultants(h, load);
  const Vector6d s_r = -slip_.transpose() * end_forces;  // cancels the load's forces at released ends
  return s_r + F_inverse_ * (H_ * q - particular_stretch(load) - F_ * s_r);
}

Vector12d Element::load(const LineLoad& load) const {
  const double h = 0.5 * length_;
  const Vector6d s_m = mid_resultants(Vector12d::Zero(), load);
  Vector12d end_forces;
  end_forces << -particular_resultants(-h, load), particular_resultants(h, load);
  return -(H_.transpose() * s_m + end_forces);
}

Vector6d Element::section_forces(double x, const Vector12d& q, const LineLoad& load) const {
  const double xi = x - 0.5 * length_;
  const Vector6d s_m = mid_resultants(q, load);
  return s_m + xi * D_times(s_m) + particular_resultants(xi, load);
}

Vector6d Element::displacement(double x, const Vector12d& q, const LineLoad& load) const {
  const double xi = x - 0.5 * length_, h = 0.5 * length_;
  const Vector6d s_m = mid_resultants(q, load);
  const Vector12d ends = q + slip_ * (F_ * s_m + particular_stretch(load) - H_ * q);
  const Vector6d left = ends.head<6>() - G_left_ * s_m - particular_displacement(-h, load);
  const Vector6d right = ends.tail<6>() - G_right_ * s_m - particular_displacement(h, load);
  const Vector6d d_m = 0.5 * (transport(h, left) + transport(-h, right));
  return transport(xi, d_m) + transported_flexibility(xi) * s_m + particular_displacement(xi, load);
}

}  // namespace flexura::beam
