// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/make_integrator.hpp"

#include <fmt/format.h>

#include "mbs/solver/integrators/elastodynamics.hpp"
#include "mbs/solver/integrators/generalised_alpha.hpp"
#include "mbs/solver/integrators/ida/ida.hpp"
#include "mbs/solver/integrators/radau/radau.hpp"
#include "mbs/solver/integrators/runge_kutta.hpp"
#include "mbs/solver/integrators/sequence.hpp"

namespace flexura::mbs {

namespace {

// One line for each; what else is known of them stands in integrator_kind.cpp.
struct Maker {
  const char* name;
  std::unique_ptr<Integrator> (*make)(const Equations&, const SolverOptions&);
};
constexpr Maker kMakers[] = {
    {"ida", make_ida},
    {"radau", make_radau},
    {"generalised_alpha", make_generalised_alpha},
    {"runge_kutta", make_runge_kutta},
    {"kinematics", make_kinematics},
    {"ked", make_elastodynamics},
    {"quasi_statics", make_quasi_statics},
};

}  // namespace

std::unique_ptr<Integrator> make_integrator(const Equations& eq, const SolverOptions& options) {
  const Sizes n = eq.sizes();
  if (n.n_p + n.n_v + n.n_dyn + n.n_alg + n.n_lambda + n.n_root == 0) return make_rest();
  for (const Maker& maker : kMakers)
    if (options.method == maker.name) return maker.make(eq, options);
  throw std::invalid_argument(fmt::format("unknown integrator \"{}\"", options.method));
}

}  // namespace flexura::mbs
