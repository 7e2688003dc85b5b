// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/beam_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "reduce/beams/full_modes.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/session/session.hpp"

namespace flexura::reduce {

void print_beam_modes(const BeamPartInput& input, int count, std::ostream& out) {
  const beam::BeamMesh mesh(input.model, input.subdivision);
  const linalg::Session session;
  const Structure structure(mesh, input.solids, input.links);
  const Eigen::VectorXd without = full_beam_modes(structure, count, false),
                        with = full_beam_modes(structure, count, true);
  out << fmt::format("{} elements; free natural frequencies in Hz\n", mesh.elements().size());
  out << fmt::format("{:>6} {:>24} {:>24}\n", "mode", "without rotary inertia", "with");
  for (int k = 0; k < count && 6 + k < std::min(without.size(), with.size()); ++k)
    out << fmt::format("{:>6} {:>24.4f} {:>24.4f}\n", k + 1, frequency_hz(without[6 + k]),
                       frequency_hz(with[6 + k]));
}

}  // namespace flexura::reduce
