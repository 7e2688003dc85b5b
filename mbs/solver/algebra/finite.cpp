// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/finite.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexura::mbs {

namespace {

int first_non_finite(const Eigen::VectorXd& x) {
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (!std::isfinite(x(i))) return static_cast<int>(i);
  return -1;
}

}  // namespace

std::string describe_non_finite(const Equations& eq, double t, const Eigen::VectorXd& r,
                                const Eigen::VectorXd& c_rate, const Eigen::VectorXd& b) {
  if (const int i = first_non_finite(r); i >= 0)
    return fmt::format("the force on \"{}\" is not finite ({}) at t = {:.9g} s", eq.name_of_velocity(i), r(i),
                       t);
  if (const int i = first_non_finite(c_rate); i >= 0)
    return fmt::format("the rate of \"{}\" is not finite ({}) at t = {:.9g} s", eq.name_of_dynamic(i),
                       c_rate(i), t);
  if (const int i = first_non_finite(b); i >= 0)
    return fmt::format("the equation of \"{}\" is not finite ({}) at t = {:.9g} s", eq.name_of_algebraic(i),
                       b(i), t);
  return {};
}

void require_finite_forces(const Equations& eq, double t, const Eigen::VectorXd& r,
                           const Eigen::VectorXd& c_rate, const Eigen::VectorXd& b) {
  if (std::string text = describe_non_finite(eq, t, r, c_rate, b); !text.empty()) throw NonFiniteError(text);
}

}  // namespace flexura::mbs
