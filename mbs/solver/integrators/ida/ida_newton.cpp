// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/ida/ida_newton.hpp"

namespace flexura::mbs {
namespace {

SUNLinearSolver_Type direct(SUNLinearSolver) {
  return SUNLINEARSOLVER_DIRECT;
}
SUNLinearSolver_ID custom_solver(SUNLinearSolver) {
  return SUNLINEARSOLVER_CUSTOM;
}
int nothing(SUNLinearSolver) {
  return 0;
}
int nothing_to_set_up(SUNLinearSolver, SUNMatrix) {
  return 0;
}
int free_solver(SUNLinearSolver s) {
  SUNLinSolFreeEmpty(s);
  return 0;
}
int solve_with_newton_matrix(SUNLinearSolver s, SUNMatrix, N_Vector x, N_Vector b, double) {
  static_cast<NewtonMatrix<double>*>(s->content)->solve(view(b), edit(x));
  return view(x).allFinite() ? 0 : 1;
}
SUNMatrix_ID custom_matrix(SUNMatrix) {
  return SUNMATRIX_CUSTOM;
}
int zero_matrix(SUNMatrix) {
  return 0;
}
void destroy_matrix(SUNMatrix m) {
  SUNMatFreeEmpty(m);
}

}  // namespace

SUNLinearSolver make_newton_solver(SUNContext context, NewtonMatrix<double>& matrix) {
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  solver->content = &matrix;
  solver->ops->gettype = direct;
  solver->ops->getid = custom_solver;
  solver->ops->initialize = nothing;
  solver->ops->setup = nothing_to_set_up;
  solver->ops->solve = solve_with_newton_matrix;
  solver->ops->free = free_solver;
  return solver;
}

SUNMatrix make_empty_matrix(SUNContext context) {
  SUNMatrix matrix = SUNMatNewEmpty(context);
  matrix->ops->getid = custom_matrix;
  matrix->ops->zero = zero_matrix;
  matrix->ops->destroy = destroy_matrix;
  return matrix;
}

}  // namespace flexura::mbs
