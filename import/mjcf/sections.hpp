// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/mjcf/scene.hpp"
#include "import/tree/writer.hpp"

namespace flexura::import::mjcf {

/// A tendon in formulas.
struct TendonNames {
  std::string length, rate;  ///< measures
  double start_length = 0.0;
  tree::StartMass::Row row;                    ///< of the length by the coordinates, at the start
  std::vector<std::pair<int, double>> joints;  ///< of a fixed one: (joint, factor)
  struct Segment {
    std::string from, to;  ///< markers
    double factor;         ///< of its share of the length
    std::string length;    ///< measure
  };
  std::vector<Segment> segments;  ///< of a spatial one
};
using Tendons = std::map<std::string, TendonNames>;

/// What the sections add to the mechanism; they go through the file's own and the attached models.
Tendons add_tendons(const Scene& scene, tree::Writer& writer, Findings& findings);
void add_actuators(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings);
void add_equalities(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings);
void add_keyframes(const Scene& scene, tree::Writer& writer, Findings& findings);

/// Drag and lift of a fluid at rest or in wind, by MuJoCo's model of an inertia box.
void add_fluid(const Scene& scene, tree::Writer& writer, Findings& findings);

/// Puts the force given by a formula on the tendon: positive where it would lengthen it.
void add_tendon_force(const TendonNames& tendon, const std::string& wanted, const std::string& formula,
                      tree::Writer& writer);

/// "a + b" of "factor * name" terms, "0.0" of none.
std::string sum_of(const std::vector<std::pair<double, std::string>>& terms);

}  // namespace flexura::import::mjcf
