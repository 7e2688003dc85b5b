// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Elements of an elastic line: stretch and curvature, no section to turn.
#include "beam/ancf/element/element_of.hpp"

namespace flexura::beam::ancf {

namespace {

void check_line(const LineSection& section, double length) {
  require_positive("the element's length [m]", length);
  require_positive("the line's EA [N]", section.EA);
  require_not_negative("the line's EI [N m^2]", section.EI);
  require_positive("the line's mass per length [kg/m]", section.mass_per_length);
  require_not_negative("the line's axial damping time [s]", section.damping_time_axial);
  require_not_negative("the line's bending damping time [s]", section.damping_time_bending);
}

template <class Strain>
std::unique_ptr<Element> make_line(const LineSection& section, double length, const double* e_0) {
  check_line(section, length);
  using Set = PointSet<Strain, 4>;
  typename Set::Law C = Set::Law::Identity() * section.EI;
  C(0, 0) = section.EA;
  typename Set::Law C_d = C * section.damping_time_bending;
  C_d(0, 0) = section.EA * section.damping_time_axial;
  Set set;
  for (const auto& q : lobatto_rule()) {
    typename Set::Rows N;
    N << hermite_x(q.xi, length), hermite_xx(q.xi, length);
    set.add(q.weight * length, N, C, C_d, e_0);
  }
  auto element = std::make_unique<ElementOf<Set>>(Strain::dim, 2, length, std::move(set));
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(4, 4);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(4);
  for (const auto& q : gauss_rule(kMassPoints)) {
    const Shapes S = hermite(q.xi, length);
    const double dm = section.mass_per_length * q.weight * length;
    mass += dm * S.transpose() * S;
    weight += dm * S.transpose();
  }
  element->set_inertia(std::move(mass), std::move(weight));
  return element;
}

}  // namespace

std::unique_ptr<Element> make_planar_line(const LineSection& section, double length, const double* e_0) {
  return make_line<PlanarStrain>(section, length, e_0);
}

std::unique_ptr<Element> make_spatial_line(const LineSection& section, double length) {
  return make_line<CableStrain>(section, length, nullptr);
}

}  // namespace flexura::beam::ancf
