// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrator.hpp"

#include <fmt/format.h>

#include "mbs/solver/generalised_alpha.hpp"
#include "mbs/solver/ida.hpp"
#include "mbs/solver/radau.hpp"
#include "mbs/solver/runge_kutta.hpp"
#include "mbs/solver/sequence.hpp"

namespace flexura::mbs {

std::unique_ptr<Integrator> make_integrator(const Equations& eq, const SolverOptions& options) {
  const Sizes n = eq.sizes();
  if (n.n_p + n.n_v + n.n_dyn + n.n_alg + n.n_lambda + n.n_root == 0) return make_rest();
  // One line for each integrator; the same names stand in solver_schema().
  if (options.method == "ida") return make_ida(eq, options);
  if (options.method == "radau") return make_radau(eq, options);
  if (options.method == "runge_kutta") return make_runge_kutta(eq, options);
  if (options.method == "generalised_alpha") return make_generalised_alpha(eq, options);
  if (options.method == "kinematics") return make_kinematics(eq, options);
  if (options.method == "quasi_statics") return make_quasi_statics(eq, options);
  throw std::invalid_argument(fmt::format("unknown integrator \"{}\"", options.method));
}

}  // namespace flexura::mbs
