// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/flexible_part.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "mbs/base/math/rotation.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs::chance {

FlexiblePart::FlexiblePart(std::string name, int n_q, double bar_stiffness)
    : name_(std::move(name)), lattice_(lattice::make_lattice(n_q, bar_stiffness)) {
  lattice_.se.modal_damping = 0.0;  // the file of the mechanism says
  // The six rigid motions have no frequency; what is M-orthogonal to them has no momentum.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> free(lattice_.se.K_se, lattice_.se.M_se);
  const Eigen::Index m = lattice_.se.n() - 6;
  modes_ = free.eigenvectors().rightCols(m);
  omega2_ = free.eigenvalues().tail(m);
  shapes_ = lattice_.T * modes_;
}

FlexiblePart::FlexiblePart(double length, double mass) {
  const double r = 0.1 * length;
  lattice_.x.resize(3, 12);
  lattice_.mass = Eigen::VectorXd::Constant(12, mass / 12.0);
  shapes_.setZero(36, 6);
  for (int end = 0; end < 2; ++end) {
    superelement::Interface interface;
    interface.name = end == 0 ? "root" : "tip";
    interface.p_BoN_B = {end * length, 0.0, 0.0};
    interface.first_dof = 6 * end;
    lattice_.se.interfaces.push_back(interface);
    for (int k = 0; k < 6; ++k) {
      const Vector3d arm = (k % 2 == 0 ? r : -r) * Vector3d::Unit(k / 2);
      lattice_.x.col(6 * end + k) = interface.p_BoN_B + arm;
      if (end == 0) continue;
      shapes_.block<3, 3>(3 * (6 + k), 0).setIdentity();
      for (int i = 0; i < 3; ++i) shapes_.block<3, 1>(3 * (6 + k), 3 + i) = Vector3d::Unit(i).cross(arm);
    }
  }
  modes_.setZero(12, 6);
  modes_.bottomRows<6>().setIdentity();
  omega2_.setZero(6);
}

Eigen::VectorXd FlexiblePart::modal(const Eigen::VectorXd& u_se) const {
  return modes_.transpose() * (lattice_.se.M_se * u_se);
}

Pose FlexiblePart::carried(int i, const Eigen::VectorXd& q) const {
  const Eigen::VectorXd motion =
      modes_.block(lattice_.se.interfaces[i].first_dof, 0, 6, q.size()) * q;  // displacement, then rotation
  return {rotation_exp(motion.tail<3>()), motion.head<3>()};
}

Eigen::VectorXd FlexiblePart::unit_of_coordinates(double length, double mass) const {
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(lattice_.se.n());
  for (const superelement::Interface& interface : lattice_.se.interfaces)
    unit.segment<3>(interface.first_dof).setConstant(length);
  unit.tail(lattice_.se.n_q).setConstant(std::sqrt(mass) * length);  // of modes with unit generalised mass
  return unit;
}

Eigen::VectorXd FlexiblePart::from_units(const Eigen::VectorXd& u_se, double length, double mass) const {
  return u_se.cwiseQuotient(unit_of_coordinates(length, mass));
}

superelement::Superelement FlexiblePart::in_units(double length, double mass) const {
  superelement::Superelement se = lattice_.se;
  const Eigen::VectorXd shape = unit_of_coordinates(length, mass).cwiseInverse();
  const double energy = mass * length * length;
  const auto both = [&](const Eigen::MatrixXd& X) {
    return Eigen::MatrixXd(energy * (shape.asDiagonal() * X * shape.asDiagonal()));
  };
  for (superelement::Interface& interface : se.interfaces) interface.p_BoN_B *= length;
  se.K_se = both(se.K_se);
  se.M_se = both(se.M_se);
  superelement::InertiaIntegrals& I = se.inertia;
  I.mass *= mass;
  I.S_x *= mass * length;
  I.S_xx *= energy;
  I.S_phi = mass * length * (I.S_phi * shape.asDiagonal());
  I.S_xphi = energy * (I.S_xphi * shape.asDiagonal());
  for (Eigen::MatrixXd& S : I.S_phiphi) S = both(S);
  return se;
}

std::string FlexiblePart::file(const std::filesystem::path& folder, double length, double mass) const {
  const std::string name =
      fmt::format("{}{}.se.h5", name_, length == 1.0 && mass == 1.0 ? "" : "_in_other_units");
  if (!std::filesystem::exists(folder / name)) superelement::write(folder / name, in_units(length, mass));
  return name;
}

std::shared_ptr<const FlexiblePart> flexible_part(int which) {
  // Lowest free frequencies of some 20 and 90 Hz: what bends visibly under its loads, and what hardly does.
  static const std::array<std::shared_ptr<const FlexiblePart>, kFlexibleParts> parts = {
      std::make_shared<FlexiblePart>("soft", 0, 1e4),
      std::make_shared<FlexiblePart>("soft_with_modes", 3, 1e4),
      std::make_shared<FlexiblePart>("stiff", 0, 2e5),
      std::make_shared<FlexiblePart>("stiff_with_modes", 3, 2e5)};
  return parts.at(static_cast<std::size_t>(which));
}

}  // namespace flexura::mbs::chance
