// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"

/// Runs of the mechanisms in cases/ and what they store.
namespace flexura::mbs::cases {

inline PreparedMechanism prepare_case(const std::string& file,
                                      const std::vector<std::string>& overrides = {}) {
  return prepare(std::string(FLEXURA_SOURCE_DIR) + "/cases/" + file, overrides);
}

/// Values of the named quantities at the rows of a run.
struct Series {
  std::vector<double> t;
  std::vector<Eigen::VectorXd> values;
  RunResult result;

  /// The row nearest to a time, which must be one.
  const Eigen::VectorXd& at(double time) const {
    for (std::size_t i = 0; i < t.size(); ++i)
      if (std::abs(t[i] - time) < 1e-9) return values[i];
    throw std::out_of_range("no row at this time");
  }
};

inline Eigen::VectorXd now(const PreparedMechanism& p, const std::vector<std::string>& names) {
  const auto which = select_quantities(*p.mechanism, names);
  Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
  auto scratch = p.mechanism->make_scratch();
  p.mechanism->evaluate(which, p.state, p.v_dot, *scratch, values);
  return values;
}

inline Series simulate(const PreparedMechanism& p, const std::vector<std::string>& names) {
  Series series;
  const auto which = select_quantities(*p.mechanism, names);
  auto scratch = p.mechanism->make_scratch();
  RunCallbacks callbacks;
  callbacks.row = [&](const State& s, const Eigen::VectorXd& v_dot, const EnergyAccount&) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
    p.mechanism->evaluate(which, s, v_dot, *scratch, values);
    series.t.push_back(s.t);
    series.values.push_back(values);
  };
  series.result = run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(series.result.complete) << series.result.stopped_because;
  return series;
}

}  // namespace flexura::mbs::cases
