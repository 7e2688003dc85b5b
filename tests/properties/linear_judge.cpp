// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/properties/linear_scenes.hpp"

namespace flexura::properties {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEnd = 1.0, kRow = 0.05;
constexpr Index kRows = 21;

// The inputs' parts of a motion [m, rad]: the odd part of two runs lacks kMotion^2 of itself, times what the third derivatives of the
// mechanism are in its units.
constexpr double kMotion = 3e-4, kPart = 1e-4;

// What a run leaves of motions; what vibrates at 16 Hz makes of it 1e4 times as much acceleration, and load on 1 kg.
constexpr double kTolerance = 1e-10, kFloor = 10.0 * kTolerance, kOfRates = 1e4;

/// u = size (1 - e^(-at) (1 + at + (at)^2 / 2 + (at)^3 / 6) + (1 - cos wt)^2): the last of four lags behind a step, and two sines.
/// u, u' and u'' begin at 0, as a position that follows it must.
struct Signal {
  double a = 0.0, w = 0.0;
  std::string formula(double size) const {
    return fmt::format(
        "{0:.17g}*(1 - exp(-{1:.17g}*t)*(1 + {1:.17g}*t + ({1:.17g}*t)^2/2 + ({1:.17g}*t)^3/6) + (1 - "
        "cos({2:.17g}*t))^2)",
        size, a, w);
  }
  /// g' = S g with u / size = first row: four lags, one, and sines of w and 2 w with their rates.
  MatrixXd generator() const {
    MatrixXd S = MatrixXd::Zero(9, 9);
    for (int i = 0; i < 4; ++i) {
      S(i, i) = -a;
      S(i, i + 1) = a;  // the fourth follows the one
    }
    for (int k = 0; k < 2; ++k) {
      S(5 + 2 * k, 6 + 2 * k) = (k + 1) * w;
      S(6 + 2 * k, 5 + 2 * k) = -(k + 1) * w;
    }
    return S;
  }
  static VectorXd start() {
    VectorXd g = VectorXd::Zero(9);
    g(4) = g(5) = g(7) = 1.0;
    return g;
  }
  static Eigen::RowVectorXd reads() {
    Eigen::RowVectorXd u = Eigen::RowVectorXd::Zero(9);
    u(0) = 1.0;
    u(4) = 1.5;
    u(5) = -2.0;
    u(7) = 0.5;
    return u;
  }
};

struct Outputs {
  mbs::LineariseOptions options;
  explicit Outputs(const mbs::PreparedMechanism& p) {
    const mbs::Mechanism& m = *p.mechanism;
    const auto which = mbs::select_quantities(m, p.file.y);
    const auto infos = m.quantities();
    for (const int i : which) options.output_names.push_back(infos[static_cast<std::size_t>(i)].name);
    options.outputs = [&m, which](const mbs::State& s, const VectorXd& v_dot) {
      VectorXd values(static_cast<Index>(which.size()));
      m.evaluate(which, s, v_dot, *m.make_scratch(), values);
      return values;
    };
    for (int i = 0; i < m.n_inputs(); ++i) options.signals.push_back(i);
  }
};

/// Rows of the outputs of the run from the state of `still`, which is one of `p`, too.
MatrixXd rows_of_run(const mbs::PreparedMechanism& p, const mbs::PreparedMechanism& still) {
  const Outputs outputs(p);
  MatrixXd rows(kRows, static_cast<Index>(p.file.y.size()));
  Index k = 0;
  mbs::SolverOptions options;
  options.method = "radau";
  options.end_time = kEnd;
  options.output_step = kRow;
  options.tolerance = kTolerance;
  const mbs::RunResult result =
      mbs::run(*p.mechanism, still.state, still.v_dot, options,
               {.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
                 if (k < kRows) rows.row(k++) = outputs.options.outputs(s, v_dot).transpose();
               }});
  EXPECT_TRUE(result.complete) << result.stopped_because;
  return rows;
}

/// The same by the linear system, exactly: the signal's generator and the system as one.
MatrixXd rows_of_system(const mbs::LinearSystem& d, Index input, const Signal& signal) {
  const MatrixXd S = signal.generator();
  const Eigen::RowVectorXd u = Signal::reads();
  const Index n = d.A.rows();
  MatrixXd all = MatrixXd::Zero(n + 9, n + 9);
  all << d.A, d.B.col(input) * u, MatrixXd::Zero(9, n), S;
  MatrixXd reads(d.C.rows(), n + 9);
  reads << d.C, d.D.col(input) * u;
  if (d.D_1.size() > 0) reads.rightCols(9) += d.D_1.col(input) * u * S;
  if (d.D_2.size() > 0) reads.rightCols(9) += d.D_2.col(input) * u * S * S;
  const MatrixXd step = MatrixXd(kRow * all).exp();
  VectorXd x = VectorXd::Zero(n + 9);  // all of x is 0 where u, u' and u'' are
  x.tail(9) = Signal::start();
  MatrixXd rows(kRows, d.C.rows());
  for (Index k = 0; k < kRows; ++k) {
    rows.row(k) = (reads * x).transpose();
    x = (step * x).eval();
  }
  return rows;
}

}  // namespace

bool expect_predicted(const Scene& scene, mbs::chance::Chance& chance, const test::Folder& folder) try {
  const auto prepare = [&](const std::vector<std::string>& inputs) {
    std::string text = scene.head;
    for (std::size_t i = 0; i < inputs.size(); ++i)
      text += fmt::format("[input.u{}]\nvalue = \"{}{}\"\n", i + 1, scene.u, inputs[i]);
    return mbs::prepare(folder.write("m.toml", text + scene.text));
  };
  std::vector<std::string> none(static_cast<std::size_t>(scene.n_inputs)), up = none, down = none;
  mbs::PreparedMechanism still = prepare(none);
  if (scene.from_equilibrium) {
    mbs::find_equilibrium(*still.mechanism, still.state);
    still.v_dot.setZero();
  }
  const mbs::LinearSystem system = mbs::linearise(*still.mechanism, still.state, Outputs(still).options);
  MatrixXd expected = MatrixXd::Zero(kRows, static_cast<Index>(system.outputs.size()));
  for (std::size_t i = 0; i < none.size(); ++i) {
    const double lag = chance.between(4.0, 12.0), w = chance.between(2.0, 10.0);
    const Signal signal{lag, w};
    const MatrixXd rows = rows_of_system(system, static_cast<Index>(i), signal);
    // What grows moves as far as what does not.
    const double size = kMotion / std::max(1.0, rows.leftCols(scene.n_motions).lpNorm<Eigen::Infinity>());
    expected += size * rows;
    up[i] = " + " + signal.formula(size);
    down[i] = " - " + signal.formula(size);
  }
  const MatrixXd moved = 0.5 * (rows_of_run(prepare(up), still) - rows_of_run(prepare(down), still));
  for (Index j = 0; j < moved.cols(); ++j) {
    const double floor = j < scene.n_motions ? kFloor : kOfRates * kFloor;
    EXPECT_LT((moved.col(j) - expected.col(j)).lpNorm<Eigen::Infinity>(),
              kPart * expected.col(j).lpNorm<Eigen::Infinity>() + floor)
        << system.outputs[static_cast<std::size_t>(j)];
  }
  if (system.A.rows() == 0) return false;
  return Eigen::EigenSolver<MatrixXd>(system.A, false).eigenvalues().real().maxCoeff() > 1.0 / kEnd;
} catch (const std::exception& error) {
  ADD_FAILURE() << error.what();  // with the scene, which an exception that gets out is told without
  return false;
}

}  // namespace flexura::properties
