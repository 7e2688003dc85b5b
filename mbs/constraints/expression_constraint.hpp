// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "mbs/constraints/constraint.hpp"

namespace flexura::mbs {

/// 0 = f(y_1, ..., y_n, t), any formula f of joint coordinates, of functions of the pose of one marker in another, and of
/// signals that are known in time (inputs, states of controls, algebraic states of these), which it follows:
///
///     g' = sum f_i y_i' + f_t,   g'' by jets,   G^T x = sum x f_i grad y_i
///
/// f_i and f_ij come exactly from jets along single and pairs of arguments.
class ExpressionConstraint final : public Constraint {
 public:
  /// What the formula depends on: a coordinate, a function of the pose of M in F, or a signal that is followed.
  struct Argument {
    int place = 0;  ///< among signals
    CoordinateRef coordinate;
    int F = -1, M = -1;
    std::function<PoseFunction(const Relative&)> of_pose;
    std::shared_ptr<const Expression> followed = nullptr;  ///< this signal alone
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
  bool reads_time(int) const override { return reads_time_ || !followed_.empty(); }
  int n_followed() const override { return static_cast<int>(followed_.size()); }
  Following following(int i) const override;
  void by_followed(const Kinematics& kin, int i, double* g_y, double* h_y, double* h_y_dot) const override;
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
  /// f_i, f_ij by arguments, of which t is the last, and the rates of these.
  struct Tangent {
    Eigen::VectorXd f, rate;
    Eigen::MatrixXd F;
  };
  Tangent tangent(const Kinematics& kin) const;
  /// The arguments as they move, into jets by their places; t stands first.
  void move(const Kinematics& kin, Level level, std::vector<Jet>& jets) const;
  /// The angle of a joint that closes a loop by the whole turns that make the formula vanish next.
  void count_turns(const Kinematics& kin, std::vector<Jet>& jets) const;
  Jet run(std::vector<Jet>& jets) const;
  /// f along the direction in which arguments i and j (n: time) change by 1, the others not at all.
  Jet along(int i, int j, std::vector<Jet>& jets) const;

  std::vector<Argument> arguments_;
  std::vector<std::size_t> followed_;  ///< among arguments
  std::vector<Between> between_;
  std::shared_ptr<const Expression> value_;
  std::size_t n_signals_;
  input::Dimension dimension_;
  bool reads_time_;
};

}  // namespace flexura::mbs
