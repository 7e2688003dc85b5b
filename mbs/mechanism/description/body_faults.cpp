// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/description/body_faults.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace flexura::mbs {

// Of a mass distribution no principal moment is negative and none exceeds the sum of the other two: with
// I_1 = sum m (y^2 + z^2) and so on, I_1 + I_2 - I_3 = 2 sum m z^2.  Of a flat body that is zero, and moments
// printed with three digits (each off by up to half a per cent) leave 1 % of I_3.
std::optional<BodyFault> body_fault(double mass, const Vector3d& center, const Matrix3d& inertia) {
  if (!(mass >= 0.0 && std::isfinite(mass)))
    return BodyFault{"mass", fmt::format("is {:.6g} kg: it must be finite and not negative", mass),
                     "check its sign and unit"};
  if (!center.allFinite())
    return BodyFault{"center", "is not finite", "give three numbers, in the body's axes"};
  if (!inertia.allFinite()) return BodyFault{"inertia", "is not finite", "give its numbers"};
  const double size = inertia.cwiseAbs().maxCoeff();
  if (!(inertia - inertia.transpose()).isZero(1e-9 * size))
    return BodyFault{"inertia", "is not symmetric", "give the tensor about the centre of mass"};
  const Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  const auto fault = [&](const char* rule, const char* remedy) {
    return BodyFault{"inertia",
                     fmt::format("has the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2: {}", moments[0],
                                 moments[1], moments[2], rule),
                     remedy};
  };
  if (moments[0] < -1e-12 * moments.cwiseAbs().maxCoeff())
    return fault("none can be negative", "check the signs and units");
  if (moments[0] + moments[1] < 0.99 * moments[2])
    return fault(
        "the two smaller ones together cannot be less than the largest, I1 + I2 >= I3",
        "check the values (a flat body has I1 + I2 = I3, a thin rod [0, I, I]) and that they are about the "
        "centre of mass");
  return std::nullopt;
}

// Rotations that were multiplied a few hundred times are off by 1e-13; typed ones of six digits by 1e-6.
std::string pose_fault(const Pose& X) {
  if (!X.p.allFinite() || !X.R.allFinite()) return "its place is not finite; give numbers";
  const double off = (X.R.transpose() * X.R - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > 1e-5 || X.R.determinant() < 0.0)
    return fmt::format(
        "its matrix is no rotation (R^T R differs from the unit matrix by {:.2g}, its determinant is "
        "{:.3g}); "
        "give the axes as unit vectors at right angles, right-handed",
        off, X.R.determinant());
  return "";
}

}  // namespace flexura::mbs
