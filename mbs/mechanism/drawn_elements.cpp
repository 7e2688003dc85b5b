// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/drawn_elements.hpp"

#include <fmt/format.h>

#include "mbs/bodies/beams/planar_beam.hpp"

namespace flexura::mbs {
namespace {

const PlanarBeam* planar(const Mechanism& mechanism, int body) {
  return dynamic_cast<const PlanarBeam*>(mechanism.deforming(body));
}

}  // namespace

std::vector<DrawnElement> drawn_elements(const Mechanism& mechanism) {
  std::vector<DrawnElement> out;
  const auto& bodies = mechanism.description().bodies;
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b)
    if (const PlanarBeam* const beam = planar(mechanism, b))
      for (int k = 1; k <= beam->elements(); ++k)
        out.push_back({fmt::format("{}.element_{}", bodies[static_cast<std::size_t>(b)].name, k), b,
                       beam->element_length()});
  return out;
}

std::vector<Pose> drawn_chords(const Mechanism& mechanism, int body, const State& s) {
  const PlanarBeam* const beam = planar(mechanism, body);
  return beam ? beam->chords(mechanism.modal_coordinates(body, s)) : std::vector<Pose>();
}

}  // namespace flexura::mbs
