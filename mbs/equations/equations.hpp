// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace flexura::mbs {
class MotionFunction;
class TimeFunction;
}  // namespace flexura::mbs

/// The equations of motion as the solvers see them (Simpack's form):
///
///     p' = T(p) v                                    kinematic
///     M(p) v' = f(p, v, c, a, t) - G(p)^T lambda      momentum
///     c' = f_c(p, v, c, a, t)                        dynamic states
///     0  = g(p, c, t)                                constraints, G = dg/dp T,  dg/dt = G v + g_t
///     0  = b(p, v, c, a, t, v', lambda)              algebraic states
///
/// Rows that follow dynamic states have g_c c' and what follows from it in g_t; their reactions do not act on the
/// controls, so that G^T lambda stays that of g at fixed c.
///
/// p holds joint and modal positions (in tree order of the bodies; a rotation of three freedoms takes four
/// numbers), v their velocities.  A rotation is read from its quaternion after normalisation, so the norm is
/// a gauge without influence and needs no constraint.
///
/// The object is constant; what changes is passed in.  Every method may write only to its outputs and the
/// scratch.
namespace flexura::mbs {

using VectorRef = Eigen::Ref<Eigen::VectorXd>;
using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;
using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;

struct Sizes {
  int n_p = 0;       ///< position coordinates, quaternion components counted
  int n_v = 0;       ///< velocity coordinates = n_jnt + n_flx
  int n_flx = 0;     ///< modal coordinates among them
  int n_dyn = 0;     ///< dynamic states c, held values among them
  int n_held = 0;    ///< entries of c that change at events alone: no dynamic states
  int n_lambda = 0;  ///< constraint equations (all that are kept: redundant ones already left out)
  int n_alg = 0;     ///< algebraic states a
  int n_root = 0;    ///< switching functions
};

/// Values of all states at one time.
struct State {
  double t = 0.0;
  Eigen::VectorXd p, v, c, lambda, a;
  std::vector<int> root;  ///< switch positions
  /// How far below 0 the functions of switches must fall to count (n_root), for those that graze; empty: nowhere.
  Eigen::VectorXd hysteresis;
  Eigen::VectorXd u;  ///< added to the inputs, u', u'' (n_inputs each), to linearise; empty: nothing
};

/// The time of constraint rows.  Rows that follow dynamic states (a joint driven by a control) also take c, a, the
/// switches and inputs of the state; its p and v are not looked at.
struct When {
  When(double time) : t(time) {}                       // NOLINT: a time is all that most rows ask for
  When(const State& state) : t(state.t), s(&state) {}  // NOLINT
  double t;
  const State* s = nullptr;
};

/// Energies [J] and powers [W] at one state; their balance is
///     kinetic + strain + potential = start + integral (input_power - dissipated_power) dt.
struct EnergyReport {
  double kinetic = 0.0;
  double strain = 0.0;            ///< of flexible bodies
  double potential = 0.0;         ///< gravity and springs
  double input_power = 0.0;       ///< of applied forces, drives and moving constraints
  double dissipated_power = 0.0;  ///< taken out by dampers and modal damping, >= 0
};

/// How large the numbers are that constraint rows are made of: closing tolerances are parts of them, whether
/// or not anything can move that changes the rows.
struct ConstraintSizes {
  Eigen::VectorXd size;         ///< what a turn of 1 rad, or a way as long as the mechanism, changes in g
  Eigen::VectorXd round_off;    ///< what is left of g when its positions are right to double precision
  std::vector<bool> is_length;  ///< g is in m; else in rad, or a number
};

/// The derivatives that Newton matrices and linearisation are made of.  With z = (r, c_rate, b),
/// r = M v_dot - f + G^T lambda, stacked (n_z = n_v + n_dyn + n_alg), at fixed v_dot and lambda:
struct TangentMatrices {
  Eigen::MatrixXd z_p, z_v, z_c, z_a;  ///< dz/dp, dz/dv, dz/dc, dz/da
  Eigen::MatrixXd h_p;                 ///< d(G v + g_t)/dp
  /// dg/dc and d(G v + g_t)/dc (n_lambda x n_dyn), both empty where no row follows dynamic states.
  Eigen::MatrixXd g_c, h_c;
  /// dc_rate/dv_dot (n_dyn x n_v) and dc_rate/dlambda (n_dyn x n_lambda), of dynamic states that answer to
  /// accelerations and reactions (one-way deformation); both empty where none does.
  Eigen::MatrixXd c_v_dot, c_lambda;
  /// db/dv_dot (n_alg x n_v) and db/dlambda (n_alg x n_lambda), of algebraic states that are accelerations or reactions;
  /// both empty where none is.
  Eigen::MatrixXd b_v_dot, b_lambda;
};

/// What derivatives are taken for.
enum class TangentScope {
  everything,  ///< all columns
  newton,      ///< the columns of elastic coordinates hold their stiffness and damping alone, see
               ///< Equations::elastic_coordinate: the cost is then that of the rigid mechanism
};

class Equations {
 public:
  /// Work space of one thread.
  class Scratch {
   public:
    virtual ~Scratch() = default;
  };

  virtual ~Equations() = default;
  virtual Sizes sizes() const = 0;
  virtual std::unique_ptr<Scratch> make_scratch() const = 0;

  /// p_dot = T(p) w for any tangent vector w (n_v).
  virtual void kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const = 0;

  /// p moved by the tangent vector d (n_v), exactly on the manifold; quaternions come out normalised.
  virtual void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const = 0;

  /// r = M v_dot - f + G^T lambda (n_v), by inverse dynamics in O(n).  Also c_rate = f_c (n_dyn), b (n_alg).
  virtual void momentum(const State& s, ConstVectorRef v_dot, Scratch& scratch, VectorRef r, VectorRef c_rate,
                        VectorRef b) const = 0;

  /// momentum(), velocity_constraints(), position_constraints() and apply_GT(mu) at one state and at once:
  /// what the residual of a stabilised form needs.  An implementation that shares their common part is
  /// faster.
  virtual void residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, Scratch& scratch,
                         VectorRef r, VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g,
                         VectorRef GT_mu) const;

  /// The stiffness k and damping d of a coordinate that one body owns as its modal amplitude:
  /// the momentum's own row holds k p + d v, and whatever else depends on this coordinate changes slowly.
  /// A Newton matrix may then do without differences for it.  Zero k and false for all others.
  virtual bool elastic_coordinate(int /*i_v*/, int& /*i_p*/, double& /*k*/, double& /*d*/) const {
    return false;
  }
  /// Elastic coordinates with k = 0 belong to a body whose stiffness is a matrix: adds the derivatives of all
  /// such bodies' internal forces by p to r_p (n_v rows, n_p) and by v to r_v (n_v rows, n_v).
  virtual void add_elastic_tangents(const State& /*s*/, MatrixRef /*r_p*/, MatrixRef /*r_v*/) const {}

  /// The tangent matrices at one state, exactly; of scope `newton` without the elastic coordinates' columns,
  /// which it leaves at 0.  False where an implementation knows no way but differences of the functions
  /// above and below.
  virtual bool tangents(const State& /*s*/, ConstVectorRef /*v_dot*/, TangentScope /*scope*/,
                        Scratch& /*scratch*/, TangentMatrices& /*out*/) const {
    return false;
  }

  /// g (n_lambda), constraints on position level; nonholonomic rows give 0.
  virtual void position_constraints(When when, ConstVectorRef p, Scratch& scratch, VectorRef g) const = 0;

  /// G v + g_t (n_lambda).
  virtual void velocity_constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch,
                                    VectorRef g_dot) const = 0;

  /// Both at once.
  virtual void constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                           VectorRef g_dot) const;

  /// True where rows follow dynamic states.
  virtual bool follows_states() const { return false; }
  /// True where b depends on v_dot or lambda: accelerations, reactions and algebraic states are then solved for together.
  virtual bool algebraic_is_coupled() const { return false; }

  /// G v_dot + gamma(t, p, v) (n_lambda): the second time derivative of g.
  virtual void acceleration_constraints(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                        Scratch& scratch, VectorRef g_ddot) const = 0;

  /// f_c = G(p)^T x (n_v) for any x (n_lambda), in O(n).
  virtual void apply_GT(When when, ConstVectorRef p, ConstVectorRef x, Scratch& scratch,
                        VectorRef f_c) const = 0;

  /// G (n_lambda x n_v), dense.
  virtual void constraint_matrix(When when, ConstVectorRef p, Scratch& scratch, MatrixRef G) const = 0;

  /// Sizes of the rows of g (n_lambda). This default knows them by what the coordinates change in them alone;
  /// a row that nothing changes takes the largest of the others.
  virtual ConstraintSizes constraint_sizes(When when, ConstVectorRef p, Scratch& scratch) const;

  /// Rows that were left out because they follow from the others: while the kept ones hold, so must they.
  virtual int n_left_out() const { return 0; }
  /// Their g, G v + g_t and, unless v_dot is empty, G v_dot + gamma (n_left_out each).
  virtual void left_out_constraints(When /*when*/, ConstVectorRef /*p*/, ConstVectorRef /*v*/,
                                    ConstVectorRef /*v_dot*/, Scratch& /*scratch*/, VectorRef /*g*/,
                                    VectorRef /*g_dot*/, VectorRef /*g_ddot*/) const {}
  virtual ConstraintSizes left_out_sizes(When /*when*/, ConstVectorRef /*p*/, Scratch& /*scratch*/) const {
    return {};
  }
  /// The row itself, then those that it followed from when it was left out.
  virtual std::vector<std::string> names_of_left_out(int /*i*/) const { return {}; }
  /// The same equations for one run, which may choose among rows that follow from each other anew on its way; null where
  /// there are none to choose from.
  virtual std::unique_ptr<Equations> copy_for_rows() const { return nullptr; }
  /// Keeps those that are most independent at s, as many as before.  False, with the old choice, where there are
  /// other numbers of them there, or `accepts`, called with the new choice, says no.
  virtual bool choose_rows(const State& /*s*/, const std::function<bool()>& /*accepts*/) { return false; }

  /// M (n_v x n_v), symmetric positive definite, dense.
  virtual void mass_matrix(ConstVectorRef p, Scratch& scratch, MatrixRef M) const = 0;

  /// Prepares solve_mass() at p, in O(n); false where the equations know no way but through mass_matrix().
  virtual bool factor_mass(ConstVectorRef /*p*/, Scratch& /*scratch*/) const { return false; }
  /// x <- M^-1 x (n_v), in O(n), with the factors that the last factor_mass() left in the scratch.
  virtual void solve_mass(Scratch& /*scratch*/, VectorRef /*x*/) const {}

  /// Energies and powers; v_dot (n_v) is needed only where reactions of drives do work.
  virtual EnergyReport energy(const State& s, ConstVectorRef v_dot, Scratch& scratch) const = 0;

  /// Switching functions (n_root), raised by the state's hysteresis: a solver stops where one falls below 0, calls on_root
  /// and restarts.
  virtual void roots(const State& s, Scratch& scratch, VectorRef values) const = 0;
  /// Takes the switch `which` into its new position; returns true when velocities jump (an impact changed
  /// s.v).
  virtual bool on_root(int which, State& s, Scratch& scratch) const = 0;

  /// False for a row that restrains velocities only (a rolling disc): its entry of position_constraints is
  /// always 0.
  virtual bool is_holonomic(int /*row*/) const { return true; }

  /// Typical sizes for the absolute part of error tolerances: 1 for metres, radians and their rates; for a
  /// modal coordinate the amplitude at which the body's largest displacement is about 1 m.
  virtual double position_scale(int /*i*/) const { return 1.0; }
  virtual double velocity_scale(int /*i*/) const { return 1.0; }
  /// Typical rates for the error tolerances of velocities: an oscillation of circular frequency omega whose
  /// amplitude is right to delta has a velocity right to omega delta.
  virtual double rate_scale(int i) const { return velocity_scale(i); }

  /// "rod.joint.angle", ... one name for each entry, for messages and files.
  virtual std::string name_of_position(int i) const = 0;
  virtual std::string name_of_velocity(int i) const = 0;
  virtual std::string name_of_dynamic(int i) const = 0;
  virtual std::string name_of_constraint(int i) const = 0;
  virtual std::string name_of_algebraic(int i) const = 0;
  /// Inputs u of the mechanism: functions of time that its forces and controls read.
  virtual int n_inputs() const { return 0; }
  virtual std::string name_of_input(int /*i*/) const { return {}; }
  virtual double input_value(int /*i*/, double /*t*/) const { return 0.0; }

  virtual std::string name_of_root(int i) const { return "switch " + std::to_string(i); }
  /// The same for a message.
  virtual std::string describe_root(int i) const { return "\"" + name_of_root(i) + "\""; }
  /// True for a condition in a formula.  Its position may be 0: the formula is then always as it is written,
  /// also within a step; else it is held until its switching function falls below 0.
  virtual bool is_condition(int /*root*/) const { return false; }
  /// True for a condition at which the formula bends but does not jump (abs, min, max, a table's points): nothing
  /// goes wrong where it is left at 0.
  virtual bool is_kink(int /*root*/) const { return false; }
  /// False for the switch of a force that is the same on both sides of it; it must be in its right position, though.
  virtual bool jumps_at(int root) const { return !is_kink(root); }
  /// Holds all conditions at what they are in this state.
  virtual void hold_conditions(State& /*s*/, Scratch& /*scratch*/) const {}

  /// What moves or loads the mechanism and is known before the run.
  virtual std::vector<std::shared_ptr<const TimeFunction>> functions_of_time() const { return {}; }

  /// Forces, controls and measures that read the motion in a way that may have peaks.
  virtual std::vector<std::shared_ptr<const MotionFunction>> functions_of_motion() const { return {}; }
  /// What these read, by its places.
  virtual void arguments_of_motion(const State& /*s*/, Scratch& /*scratch*/, Eigen::VectorXd& /*x*/) const {}
};

}  // namespace flexura::mbs
