// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/releases.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <stdexcept>
#include <vector>

namespace flexura::beam {
namespace {

using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 12, 12>;

// Inverse of a symmetric positive definite matrix whose rows differ by units.
Small scaled_inverse(const Small& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 12, 1> scale =
      matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(unit);
  if (factor.info() != Eigen::Success || !unit.allFinite())
    throw std::invalid_argument("a beam element's flexibility is not positive definite; check its section");
  Small inverse = factor.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  inverse = (0.5 * (inverse + inverse.transpose())).eval();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

[[noreturn]] void refuse(const std::string& motion) {
  throw std::invalid_argument("its releases let it " + motion + " by itself; release fewer directions");
}

// Resultants of one bending plane that the releases leave: columns (V, M) at mid-span.  `slope` is dM/dx / V.
std::vector<Eigen::Vector2d> bending_basis(bool shear_1, bool shear_2, bool moment_1, bool moment_2,
                                           double half, double slope, const char* axis) {
  if (shear_1 && shear_2) refuse(fmt::format("slide along its {} axis", axis));
  if ((shear_1 || shear_2) && moment_1 && moment_2)
    refuse(fmt::format("move across along its {} axis", axis));
  const bool shear = shear_1 || shear_2;
  if (shear && (moment_1 || moment_2)) return {};
  if (shear) return {{0.0, 1.0}};
  if (moment_1 && moment_2) return {};
  if (moment_1) return {{1.0, slope * half}};  // M(-h) = M - slope h V = 0
  if (moment_2) return {{1.0, -slope * half}};
  return {{1.0, 0.0}, {0.0, 1.0}};
}

}  // namespace

ReleasedElement release(const Matrix6d& F, const Matrix6x12d& H, double length, Releases releases) {
  ReleasedElement result;
  if (releases.none()) {
    result.F_inverse = scaled_inverse(F);
    return result;
  }
  if (releases[0] && releases[6]) refuse("slide along its axis");
  if (releases[3] && releases[9]) refuse("spin about its axis");
  const auto in_z = bending_basis(releases[2], releases[8], releases[4], releases[10], length / 2, 1.0, "z");
  const auto in_y = bending_basis(releases[1], releases[7], releases[5], releases[11], length / 2, -1.0, "y");

  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6> Z =
      Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>::Zero(6, 6);
  int n = 0;
  if (!releases[0] && !releases[6]) Z(N, n++) = 1.0;
  if (!releases[3] && !releases[9]) Z(T, n++) = 1.0;
  for (const Eigen::Vector2d& column : in_z) {
    Z(V_z, n) = column(0);
    Z(M_y, n++) = column(1);
  }
  for (const Eigen::Vector2d& column : in_y) {
    Z(V_y, n) = column(0);
    Z(M_z, n++) = column(1);
  }
  if (n > 0) {
    const Small basis = Z.leftCols(n);
    result.F_inverse = basis * scaled_inverse(basis.transpose() * F * basis) * basis.transpose();
  }

  // H_r^+ in lengths of the element, so that forces times lever and moments compare.
  std::vector<int> released;
  for (int dof = 0; dof < 12; ++dof)
    if (releases[dof]) released.push_back(dof);
  Vector6d weight;
  weight << 1, 1, 1, 1 / length, 1 / length,
      1 / length;  // on stretches (u, v, w, l theta): rows of H times weight^-1
  Small H_r(6, static_cast<int>(released.size()));
  for (std::size_t k = 0; k < released.size(); ++k) H_r.col(k) = H.col(released[k]);
  const Small weighted = weight.cwiseInverse().asDiagonal() * H_r;
  const Small inverse = scaled_inverse(weighted.transpose() * weighted) * weighted.transpose() *
                        weight.cwiseInverse().asDiagonal();
  for (std::size_t k = 0; k < released.size(); ++k) result.slip.row(released[k]) = inverse.row(k);
  return result;
}

}  // namespace flexura::beam
