// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/derivatives.hpp"

#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

void Derivatives::by_formula(const Expression& f, const double* signals, const Matrix& d) {
  for (const int place : f.reads()) by_signal(place, f.derivative(signals, place) * d);
}

}  // namespace flexura::mbs
