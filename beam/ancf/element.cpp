// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/element.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <stdexcept>
#include <tuple>
#include <type_traits>

#include "beam/ancf/hermite.hpp"
#include "beam/ancf/point_set.hpp"

namespace flexura::beam::ancf {

namespace {

void require_positive(const char* what, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} is {:g}, but it must be positive.", what, value));
}

void require_not_negative(const char* what, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} is {:g}, but it must not be negative.", what, value));
}

using Vector6 = Eigen::Matrix<double, 6, 1>;
Vector6 six(const PlanarStrain::Z& s) {
  return Vector6{{s[0], 0, 0, 0, 0, s[1]}};
}
Vector6 six(const CableStrain::Z& s) {
  return Vector6{{s[0], 0, 0, s[1], s[2], s[3]}};
}
Vector6 six(const AxisStrain::Z& s) {
  return s;
}

/// Sum of several point sets over the same coordinates.
template <class... Sets>
class ElementOf final : public Element {
 public:
  ElementOf(int dim, int vectors, double length, Sets... sets)
      : Element(dim, vectors, length), sets_(std::move(sets)...) {}

  void set_inertia(Eigen::MatrixXd mass, Eigen::VectorXd weight) {
    mass_ = std::move(mass);
    weight_ = std::move(weight);
  }

  int resultant_points() const override { return kHasAxis ? std::get<0>(sets_).size() : 0; }
  Vector6 resultants(const double* e, const double* e_dot, int k) const override {
    if (k < 0 || k >= resultant_points())
      throw std::invalid_argument(
          fmt::format("section forces asked for at point {} of an element that has {} such points; a solid "
                      "beam has none.",
                      k, resultant_points()));
    return six(std::get<0>(sets_).stress(k, e, e_dot));
  }

  double strain_energy(const double* e) const override {
    return std::apply([&](const Sets&... set) { return (set.energy(e) + ...); }, sets_);
  }
  double dissipation(const double* e, const double* e_dot) const override {
    return std::apply([&](const Sets&... set) { return (set.dissipation(e, e_dot) + ...); }, sets_);
  }
  void add_force(const double* e, const double* e_dot, const double* e_before, double* f, double* K,
                 double* D) const override {
    std::apply([&](const Sets&... set) { (set.add_force(e, e_dot, e_before, f, K, D), ...); }, sets_);
  }

 private:
  using Measure = typename std::tuple_element_t<0, std::tuple<Sets...>>::Measure;
  static constexpr bool kHasAxis = !std::is_same_v<Measure, GreenStrain>;

  std::tuple<Sets...> sets_;
};

// Along the axis of the solid beam: its stress integrals are of degree 8.
constexpr int kSolidPoints = 5;
// The consistent mass is of degree 6 in xi: four Gauss points.
constexpr int kMassPoints = 4;

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

// Shape rows of a fully parametrised beam over (r, r_x, r_y, r_z)_A, (...)_B.
using BeamRow = Eigen::Matrix<double, 1, 8>;
BeamRow axis_row(const Shapes& S) {
  return BeamRow{{S[0], S[1], 0, 0, S[2], S[3], 0, 0}};
}
BeamRow y_row(double at_A, double at_B) {
  return BeamRow{{0, 0, at_A, 0, 0, 0, at_B, 0}};
}
BeamRow z_row(double at_A, double at_B) {
  return BeamRow{{0, 0, 0, at_A, 0, 0, 0, at_B}};
}

template <class Concrete>
void set_beam_inertia(Concrete& element, const BeamSection& s) {
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(8, 8);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(8);
  const double l = element.length();
  for (const auto& q : gauss_rule(kMassPoints)) {
    const BeamRow S = axis_row(hermite(q.xi, l)), Y = y_row(1 - q.xi, q.xi), Z = z_row(1 - q.xi, q.xi);
    const double w = q.weight * l;
    mass += w * (s.m * S.transpose() * S + s.m_yy * Y.transpose() * Y + s.m_zz * Z.transpose() * Z);
    mass += w * s.m_y * (S.transpose() * Y + Y.transpose() * S);
    mass += w * s.m_z * (S.transpose() * Z + Z.transpose() * S);
    mass += w * s.m_yz * (Y.transpose() * Z + Z.transpose() * Y);
    weight += w * (s.m * S + s.m_y * Y + s.m_z * Z).transpose();
  }
  element.set_inertia(std::move(mass), std::move(weight));
}

void check_beam(const BeamSection& s, double length) {
  require_positive("the element's length [m]", length);
  if (!s.C.allFinite() || !s.C.isApprox(s.C.transpose(), 1e-12) ||
      s.C.selfadjointView<Eigen::Lower>().llt().info() != Eigen::Success)
    throw std::invalid_argument(
        "the section stiffness C is not symmetric and positive definite; a shear-rigid section needs finite "
        "shear "
        "areas here.");
  require_positive("the section's mass per length [kg/m]", s.m);
  Eigen::Matrix3d inertia;
  inertia << s.m, s.m_y, s.m_z, s.m_y, s.m_yy, s.m_yz, s.m_z, s.m_yz, s.m_zz;
  if (!inertia.allFinite() || inertia.llt().info() != Eigen::Success)
    throw std::invalid_argument(fmt::format(
        "the section's mass moments m_yy = {:g}, m_zz = {:g}, m_yz = {:g} kg m are not positive definite "
        "about the centre of gravity; r_y and r_z need inertia, so give them the section's own.",
        s.m_yy, s.m_zz, s.m_yz));
  require_not_negative("the section's damping time [s]", s.damping_time);
  require_not_negative("the section's in-plane stiffness [N]", s.section_stiffness);
}

}  // namespace

BeamSection uncoupled_section(double EA, double GA_sy, double GA_sz, double GI_t, double EI_y, double EI_z,
                              double rho_A, double rho_I_y, double rho_I_z) {
  BeamSection s;
  s.C.diagonal() << EA, GA_sy, GA_sz, GI_t, EI_y, EI_z;
  s.m = rho_A;
  s.m_zz = rho_I_y;
  s.m_yy = rho_I_z;
  return s;
}

std::unique_ptr<Element> make_planar_line(const LineSection& section, double length, const double* e_0) {
  return make_line<PlanarStrain>(section, length, e_0);
}

std::unique_ptr<Element> make_spatial_line(const LineSection& section, double length) {
  return make_line<CableStrain>(section, length, nullptr);
}

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
  set_beam_inertia(*element, section);
  return element;
}

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
  set_beam_inertia(*element, inertia);
  return element;
}

}  // namespace flexura::beam::ancf
