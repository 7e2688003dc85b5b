// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The fully parametrised beam with a section stiffness.
#include <Eigen/Cholesky>

#include "beam/ancf/element/element_of.hpp"

namespace flexura::beam::ancf {

namespace {

bool is_positive_definite(const Eigen::MatrixXd& matrix) {
  return matrix.allFinite() && matrix.llt().info() == Eigen::Success;
}

void check_beam(const BeamSection& s, double length) {
  require_positive("the element's length [m]", length);
  if (!is_positive_definite(s.C) || !s.C.isApprox(s.C.transpose(), 1e-12))
    throw std::invalid_argument(
        "the section stiffness C is not symmetric and positive definite; a shear-rigid section needs finite "
        "shear areas here.");
  require_positive("the section's mass per length [kg/m]", s.m);
  Eigen::Matrix3d inertia;
  inertia << s.m, s.m_y, s.m_z, s.m_y, s.m_yy, s.m_yz, s.m_z, s.m_yz, s.m_zz;
  if (!is_positive_definite(inertia))
    throw std::invalid_argument(fmt::format(
        "the section's mass moments m_yy = {:g}, m_zz = {:g}, m_yz = {:g} kg m are not positive definite "
        "about the centre of gravity; r_y and r_z need inertia, so give them the section's own.",
        s.m_yy, s.m_zz, s.m_yz));
  require_not_negative("the section's damping time [s]", s.damping_time);
  require_not_negative("the section's in-plane stiffness [N]", s.section_stiffness);
}

}  // namespace

std::unique_ptr<Element> make_spatial_beam(const BeamSection& section, double length, const double* e_0) {
  check_beam(section, length);
  using Axis = PointSet<AxisStrain, 8>;
  using Plane = PointSet<SectionStrain, 8>;
  Axis axis;
  for (const auto& q : lobatto_rule()) {
    Axis::Rows N;
    N << axis_row(hermite_x(q.xi, length)), y_row(1 - q.xi, q.xi), z_row(1 - q.xi, q.xi),
        y_row(-1 / length, 1 / length), z_row(-1 / length, 1 / length);
    axis.add(q.weight * length, N, section.C, section.damping_time * section.C, e_0);
  }
  // Shear in the section's own plane: G of an isotropic section with nu = 0 would be E/2.
  const double k = section.section_stiffness > 0.0 ? section.section_stiffness : section.C(0, 0);
  const Plane::Law C_plane = Eigen::Vector3d(k, k, 0.5 * k).asDiagonal();
  Plane plane;
  for (const double xi : {0.0, 1.0}) {
    Plane::Rows N;
    N << y_row(1 - xi, xi), z_row(1 - xi, xi);
    plane.add(0.5 * length, N, C_plane, section.damping_time * C_plane, e_0);
  }
  auto element = std::make_unique<ElementOf<Axis, Plane>>(3, 4, length, std::move(axis), std::move(plane));
  Eigen::MatrixXd mass;
  Eigen::VectorXd weight;
  beam_inertia(section, length, mass, weight);
  element->set_inertia(std::move(mass), std::move(weight));
  return element;
}

}  // namespace flexura::beam::ancf
