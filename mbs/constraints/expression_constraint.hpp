// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "mbs/constraints/constraint.hpp"

namespace flexura::mbs {

/// 0 = f(y_1, ..., y_n, t), any formula f of joint coordinates and of functions of the pose of one marker in another:
///
///     g' = sum f_i y_i' + f_t,   g'' by jets,   G^T x = sum x f_i grad y_i
///
/// f_i and f_ij come exactly from jets along single and pairs of arguments.
class ExpressionConstraint final : public Constraint {
 public:
  /// What the formula depends on: a coordinate, or where its joint is -1 a function of the pose of M in F.
  struct Argument {
    int place = 0;  ///< among signals
    CoordinateRef coordinate;
    int F = -1, M = -1;
    std::function<PoseFunction(const Relative&)> of_pose;
    bool is_coordinate() const { return coordinate.joint >= 0; }
  };
  /// A formula that stands between: its value goes to a place from which those below read it.
  struct Between {
    int place = 0;
    std::shared_ptr<const Expression> formula;
  };
  /// `n_signals`: so many places there are.  `dimension`: of f; what it puts on a coordinate is `force` (an output) times
  /// f's derivative by that.
  ExpressionConstraint(std::string name, std::vector<Argument> arguments, std::vector<Between> between,
                       std::shared_ptr<const Expression> value, int n_signals, input::Dimension dimension);
  int n_rows() const override { return 1; }
  std::string row_name(int) const override { return "value"; }
  GapKind gap_kind(int) const override;
  bool reads_time(int) const override { return reads_time_; }
  std::vector<CoordinateRef> coordinates() const override;
  std::vector<int> markers() const override;
  void position(const Kinematics& kin, double* g) const override;
  void velocity(const Kinematics& kin, double* g_dot) const override;
  void acceleration(const Kinematics& kin, double* g_ddot) const override;
  void rate(const Kinematics& kin, double* g_t) const override;
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override;
  std::vector<OutputInfo> outputs() const override;

 private:
  enum class Level { position, velocity, acceleration };
  /// The arguments as they move, into jets by their places; t stands first.
  void move(const Kinematics& kin, Level level, std::vector<Jet>& jets) const;
  Jet run(std::vector<Jet>& jets) const;
  /// f along the direction in which arguments i and j (n: time) change by 1, the others not at all.
  Jet along(int i, int j, std::vector<Jet>& jets) const;

  std::vector<Argument> arguments_;
  std::vector<Between> between_;
  std::shared_ptr<const Expression> value_;
  std::size_t n_signals_;
  input::Dimension dimension_;
  bool reads_time_;
};

}  // namespace flexura::mbs
