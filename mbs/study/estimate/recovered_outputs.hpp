// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"

namespace flexura::study {

/// Section forces and stresses of a run among its judged outputs: in these what is left out of a body follows its loads at once
/// (mbs/bodies/left_out_modes.hpp), so that the full model does not tell them from the run's deformation.
class RecoveredOutputs {
 public:
  /// `run` outlives it.
  RecoveredOutputs(const mbs::Mechanism& run, const std::vector<OutputEstimate>& outputs)
      : run_(run), scratch_(run.make_scratch()), owner_(outputs.size()) {
    const std::vector<mbs::OutputInfo> infos = run.quantities();
    for (std::size_t i = 0; i < outputs.size(); ++i)
      for (const mbs::BodyDescription& body : run.description().bodies) {
        if (!is_of(body, outputs[i].name)) continue;
        const auto found = std::ranges::find(infos, outputs[i].name, &mbs::OutputInfo::name);
        if (found == infos.end()) continue;
        owner_[i] = body.name;
        which_.push_back(static_cast<int>(found - infos.begin()));
        break;
      }
    values_.resize(static_cast<Eigen::Index>(which_.size()));
  }

  /// The body of output i; empty where it is none of these.
  const std::string& owner(Eigen::Index i) const { return owner_[static_cast<std::size_t>(i)]; }

  /// What the run says at this state of it beyond y, which the full model makes of the run's deformation; zero of other outputs.
  Eigen::VectorXd beyond(const mbs::State& at, const Eigen::VectorXd& v_dot, const Eigen::VectorXd& y) {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(y.size());
    if (which_.empty()) return out;
    run_.evaluate(which_, at, v_dot, *scratch_, values_);
    Eigen::Index k = 0;
    for (Eigen::Index i = 0; i < y.size(); ++i)
      if (!owner(i).empty()) out(i) = values_(k++) - y(i);
    return out;
  }

 private:
  static bool is_of(const mbs::BodyDescription& body, const std::string& name) {
    const auto opens = [&](const std::string& point) { return name.starts_with(body.name + "." + point); };
    return (body.sections &&
            std::ranges::any_of(body.sections->points(),
                                [&](const auto& point) { return opens(point.wanted.name + "."); })) ||
           (body.stress && (opens("von_mises") || opens("strain_at") || name == body.name + ".strain" ||
                            std::ranges::any_of(body.stress->points(),
                                                [&](const auto& point) { return opens(point.name + "."); })));
  }

  const mbs::Mechanism& run_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<int> which_;  // quantities of the run
  std::vector<std::string> owner_;
  Eigen::VectorXd values_;
};

}  // namespace flexura::study
