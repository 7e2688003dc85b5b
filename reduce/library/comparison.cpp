// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "reduce/cms/shapes/full_model.hpp"

namespace flexura::reduce {

Comparison compare(const Part& part, const Reduction& reduction, int count, const std::vector<int>& struck,
                   const linalg::Progress& progress) {
  Comparison out;
  const Eigen::VectorXd reduced = reduced_free_modes(reduction);
  count = std::min<int>(count, static_cast<int>(reduced.size()) - 6);
  if (count < 1) return out;
  const auto n_struck = static_cast<int>(std::set<int>(struck.begin(), struck.end()).size());
  const linalg::EigenPairs full = full_free_modes(part, count + n_struck, reduced(6), progress);
  int k = 6;
  for (int number = 7; number <= 6 + count + n_struck && k < 6 + count; ++number) {
    if (std::find(struck.begin(), struck.end(), number) != struck.end()) continue;
    out.full_hz.push_back(std::sqrt(full.omega2(number - 1)) / (2.0 * std::numbers::pi));
    out.reduced_hz.push_back(std::sqrt(reduced(k++)) / (2.0 * std::numbers::pi));
  }
  std::vector<const ReducedInterface*> six;
  for (const ReducedInterface& interface : reduction.interfaces)
    if (interface.directions.size() == 6) six.push_back(&interface);
  if (six.size() == reduction.interfaces.size() && six.size() > 1) {
    const std::string &held = six.front()->name, &loaded = six.back()->name;
    const Eigen::MatrixXd exact = full_static_compliance(part, held, loaded, progress);
    const Eigen::MatrixXd ours = reduced_static_compliance(reduction, held, loaded);
    // Each direction of load by the work it does.
    const Eigen::Index at = six.back()->first_dof;
    double worst = 0.0;
    for (int d = 0; d < 6; ++d) worst = std::max(worst, std::abs(ours(at + d, d) / exact(at + d, d) - 1.0));
    out.static_error = worst;
  }
  return out;
}

}  // namespace flexura::reduce
