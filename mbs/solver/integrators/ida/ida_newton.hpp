// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include "mbs/solver/integrators/newton_matrix.hpp"

/// What IDA solves its linear systems with; for ida.cpp alone.
namespace flexura::mbs {

/// The numbers of a serial vector, to be read and to be written.
inline Eigen::Map<const Eigen::VectorXd> view(N_Vector x) {
  return {NV_DATA_S(x), static_cast<Eigen::Index>(NV_LENGTH_S(x))};
}
inline Eigen::Map<Eigen::VectorXd> edit(N_Vector x) {
  return {NV_DATA_S(x), static_cast<Eigen::Index>(NV_LENGTH_S(x))};
}

/// A direct solver whose matrix is a NewtonMatrix, which the Jacobian callback builds and factorises; `matrix` must live longer.
SUNLinearSolver make_newton_solver(SUNContext context, NewtonMatrix<double>& matrix);
/// What stands for that matrix on IDA's side: nothing.
SUNMatrix make_empty_matrix(SUNContext context);

}  // namespace flexura::mbs
