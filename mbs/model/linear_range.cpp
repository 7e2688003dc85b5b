// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/linear_range.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace flexura::mbs {

LinearRange::LinearRange(const Mechanism& mechanism, double limit)
    : mechanism_(mechanism), limit_(limit), worst_(mechanism.description().bodies.size()) {}

void LinearRange::observe(const State& s) {
  for (std::size_t b = 0; b < worst_.size(); ++b) {
    const FlexibleBody* body = mechanism_.deforming(static_cast<int>(b));
    if (!body || !body->is_modal()) continue;
    const double* modal = mechanism_.modal_coordinates(static_cast<int>(b), s);
    const int n = static_cast<int>(body->data().nodes.size());
    R_.resize(n);
    for (int i = 0; i < n; ++i) R_[i] = body->node_pose(i, modal).R;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) {
        const double angle = rotation_log(R_[i].transpose() * R_[j]).norm();
        if (angle > worst_[b].angle) worst_[b] = {angle, s.t, i, j};
      }
  }
}

std::vector<std::string> LinearRange::sentences() const {
  std::vector<std::string> out;
  for (std::size_t b = 0; b < worst_.size(); ++b) {
    const Worst& w = worst_[b];
    if (!(w.angle > limit_)) continue;
    const auto& nodes = mechanism_.deforming(static_cast<int>(b))->data().nodes;
    out.push_back(
        fmt::format("body \"{}\" leaves the linear range of its deformation: at t = {:.6g} s its interface "
                    "\"{}\" is turned by "
                    "{:.3g} deg against \"{}\", and displacements linear in the modes are wrong by about "
                    "{:.2g} % of its length",
                    mechanism_.description().bodies[b].name, w.t, nodes[w.to].name,
                    w.angle * 180.0 / std::numbers::pi, nodes[w.from].name, 50.0 * w.angle * w.angle));
  }
  return out;
}

}  // namespace flexura::mbs
