// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The fully parametrised beam as a solid of rectangular section.
#include "beam/ancf/element/element_of.hpp"

namespace flexura::beam::ancf {

namespace {

// Along the axis: its stress integrals are of degree 8.
constexpr int kSolidPoints = 5;

}  // namespace

std::unique_ptr<Element> make_solid_beam(const SolidSection& s, double length, const double* e_0) {
  require_positive("the element's length [m]", length);
  require_positive("the section's E [Pa]", s.E);
  require_positive("the section's density [kg/m^3]", s.rho);
  require_positive("the section's width [m]", s.width);
  require_positive("the section's height [m]", s.height);
  require_positive("the section's shear factor k_y", s.k_y);
  require_positive("the section's shear factor k_z", s.k_z);
  require_not_negative("the section's damping time [s]", s.damping_time);
  if (!(s.nu > -1.0 && s.nu < 0.5))
    throw std::invalid_argument(
        fmt::format("the section's Poisson ratio is {:g}, but it must lie between -1 and 0.5.", s.nu));

  using Set = PointSet<GreenStrain, 8>;
  const double A = s.width * s.height, G = s.E / (2 * (1 + s.nu));
  Set::Law D_0 = Set::Law::Zero(), D_nu = Set::Law::Zero();
  D_0.diagonal() << s.E, s.E, s.E, G, s.k_z * G, s.k_y * G;
  D_nu.topLeftCorner<3, 3>() = s.E * s.nu / ((1 + s.nu) * (1 - 2 * s.nu)) *
                               (Eigen::Matrix3d::Ones() + (2 * s.nu - 1) * Eigen::Matrix3d::Identity());
  Set solid;
  const auto add = [&](double xi, double y, double z, double volume, const Set::Law& D) {
    Set::Rows N;
    N << axis_row(hermite_x(xi, length)) + y * y_row(-1 / length, 1 / length) +
             z * z_row(-1 / length, 1 / length),
        y_row(1 - xi, xi), z_row(1 - xi, xi);
    solid.add(volume, N, D, s.damping_time * D, e_0);
  };
  for (const auto& q : gauss_rule(kSolidPoints)) {
    for (const auto& q_y : gauss_rule(2))
      for (const auto& q_z : gauss_rule(2))
        add(q.xi, (q_y.xi - 0.5) * s.width, (q_z.xi - 0.5) * s.height,
            q.weight * q_y.weight * q_z.weight * A * length, D_0);
    add(q.xi, 0, 0, q.weight * A * length, D_nu);
  }
  auto element = std::make_unique<ElementOf<Set>>(3, 4, length, std::move(solid));
  BeamSection inertia;
  inertia.m = s.rho * A;
  inertia.m_yy = s.rho * A * s.width * s.width / 12;
  inertia.m_zz = s.rho * A * s.height * s.height / 12;
  Eigen::MatrixXd mass;
  Eigen::VectorXd weight;
  beam_inertia(inertia, length, mass, weight);
  element->set_inertia(std::move(mass), std::move(weight));
  return element;
}

}  // namespace flexura::beam::ancf
