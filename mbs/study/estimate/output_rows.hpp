// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

/// Outputs of a run at some of its rows, to be held against those of another run of the same length and output step.
namespace flexura::study {

class OutputRows {
 public:
  /// `which` are Mechanism's numbers of quantities; one row in `every` is taken.  The mechanism outlives it.
  OutputRows(const mbs::Mechanism& mechanism, std::vector<int> which, long every);

  /// The next row of the run.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  /// Keeps the values alone, where the mechanism does not outlive them; take() must not be called any more.
  void forget_mechanism();

  std::size_t size() const { return times_.size(); }
  std::size_t outputs() const { return which_.size(); }
  /// At row i, each output in its SI unit.
  const Eigen::VectorXd& values(std::size_t i) const { return values_[i]; }

  struct Difference {
    Eigen::VectorXd squares;  ///< sums over the rows of (y - y_other)^2, for each output
    Eigen::VectorXd sizes;    ///< of y^2
    long rows = 0;            ///< that both have
  };
  /// Against as many outputs of another run, at the rows that stand at the same times (a run may have ended before); `span` [s]
  /// is the length of the runs.
  Difference against(const OutputRows& other, double span) const;

 private:
  const mbs::Mechanism* mechanism_;
  std::vector<int> which_;
  std::shared_ptr<mbs::Equations::Scratch> scratch_;
  long every_ = 1, rows_ = 0;
  std::vector<double> times_;
  std::vector<Eigen::VectorXd> values_;
};

}  // namespace flexura::study
