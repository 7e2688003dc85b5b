// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/mechanism/description/mechanism_description.hpp"

/// A mechanism: bodies on a tree of joints in relative coordinates, loops closed by constraints, forces.
///
/// Inverse dynamics is the recursive Newton-Euler sweep (Featherstone, Rigid Body Dynamics Algorithms, ch. 5)
/// with flexible bodies in floating frames: outwards poses, velocities and accelerations of the bodies, where
/// a joint may sit on markers that move with the deformation of either body; inwards the wrenches.  Every
/// body's twist is (w_WB, v_WBo) expressed in W.  The mass matrix comes from composite bodies that keep their
/// modal coordinates.
/// What it is joined of stands in parts.hpp: topology, coordinates, kinematics, dynamics, elements, constraint rows,
/// tangents and quantities, each with a scratch of its own.
namespace flexura::mbs {

struct MechanismScratch;
struct RowPlace;

/// A redundant constraint row that was left out.
struct RedundantRow {
  std::string name;                       ///< "slider.rotation_x"
  std::vector<std::string> follows_from;  ///< rows it is a combination of: their multipliers are not unique
};

/// A mechanism as it is without weight and given loads, in one state: what a force's load is there
/// (ForceElement::without_load).  Springs, bushings, contacts and friction stay.
struct Unloaded {
  MechanismDescription description;
  std::vector<std::string> loads;    ///< what was taken away
  std::vector<std::string> unknown;  ///< forces that do not say what they are, and act: they stay
};

class Mechanism final : public Equations {
 public:
  /// Throws std::invalid_argument with one sentence for a description that cannot move or stand: a joint
  /// between two markers of one body, driven joints that form a loop, a negative mass, ...
  explicit Mechanism(MechanismDescription description);
  ~Mechanism() override;

  const MechanismDescription& description() const;

  // ---- Equations
  // -------------------------------------------------------------------------------------------------
  Sizes sizes() const override;
  std::unique_ptr<Scratch> make_scratch() const override;
  void kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const override;
  void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const override;
  void momentum(const State& s, ConstVectorRef v_dot, Scratch& scratch, VectorRef r, VectorRef c_rate,
                VectorRef b) const override;
  void residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, Scratch& scratch, VectorRef r,
                 VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g, VectorRef GT_mu) const override;
  bool elastic_coordinate(int i_v, int& i_p, double& k, double& d) const override;
  void add_elastic_tangents(const State& s, MatrixRef r_p, MatrixRef r_v) const override;
  bool tangents(const State& s, ConstVectorRef v_dot, TangentScope scope, Scratch& scratch,
                TangentMatrices& out) const override;
  void position_constraints(When when, ConstVectorRef p, Scratch& scratch, VectorRef g) const override;
  void velocity_constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch,
                            VectorRef g_dot) const override;
  void constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                   VectorRef g_dot) const override;
  void acceleration_constraints(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                Scratch& scratch, VectorRef g_ddot) const override;
  void apply_GT(When when, ConstVectorRef p, ConstVectorRef x, Scratch& scratch,
                VectorRef f_c) const override;
  void constraint_matrix(When when, ConstVectorRef p, Scratch& scratch, MatrixRef G) const override;
  ConstraintSizes constraint_sizes(When when, ConstVectorRef p, Scratch& scratch) const override;
  bool follows_states() const override;
  bool algebraic_is_coupled() const override;
  int n_left_out() const override;
  void left_out_constraints(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                            Scratch& scratch, VectorRef g, VectorRef g_dot, VectorRef g_ddot) const override;
  ConstraintSizes left_out_sizes(When when, ConstVectorRef p, Scratch& scratch) const override;
  std::vector<std::string> names_of_left_out(int i) const override;
  std::unique_ptr<Equations> copy_for_rows() const override;
  bool choose_rows(const State& s, const std::function<bool()>& accepts) override;
  void mass_matrix(ConstVectorRef p, Scratch& scratch, MatrixRef M) const override;
  bool factor_mass(ConstVectorRef p, Scratch& scratch) const override;
  void solve_mass(Scratch& scratch, VectorRef x) const override;
  EnergyReport energy(const State& s, ConstVectorRef v_dot, Scratch& scratch) const override;
  void roots(const State& s, Scratch& scratch, VectorRef values) const override;
  bool on_root(int which, State& s, Scratch& scratch) const override;
  bool is_holonomic(int row) const override;
  double position_scale(int i) const override;
  double velocity_scale(int i) const override;
  double rate_scale(int i) const override;
  std::string name_of_position(int i) const override;
  std::string name_of_velocity(int i) const override;
  std::string name_of_dynamic(int i) const override;
  /// Whether entry i of c is a held value (Sizes::n_held).
  bool is_held(int i) const;
  std::string name_of_constraint(int i) const override;
  std::string name_of_algebraic(int i) const override;
  std::string name_of_root(int i) const override;
  std::string describe_root(int i) const override;
  bool is_condition(int root) const override;
  bool is_kink(int root) const override;
  bool jumps_at(int root) const override;
  void hold_conditions(State& s, Scratch& scratch) const override;
  std::vector<std::shared_ptr<const TimeFunction>> functions_of_time() const override;
  std::vector<std::shared_ptr<const MotionFunction>> functions_of_motion() const override;
  void arguments_of_motion(const State& s, Scratch& scratch, Eigen::VectorXd& x) const override;
  int n_inputs() const override;
  std::string name_of_input(int i) const override;
  double input_value(int i, double t) const override;

  // ---- beyond it
  // -------------------------------------------------------------------------------------------------
  /// Initial values as the file gives them: a guess, to be assembled.
  State initial_state(double t = 0.0) const;
  /// Entries of p and v that the user gave: an assembly should rather move the others.
  const std::vector<bool>& given_positions() const;
  const std::vector<bool>& given_velocities() const;

  /// Puts all switches, and the states that go with them, where the assembled state s wants them.
  void start_switches(State& s, Scratch& scratch) const;
  /// Puts the contacts of constraints that travel along curves, algebraic states, where the positions of s
  /// are.
  void start_contacts(State& s, Scratch& scratch) const;

  /// Finds rows that follow from others at the assembled configuration p and near it (a rank that drops at an
  /// instant is not redundancy), leaves them out of all later evaluations and says which. Near means where the
  /// mechanism gets when drives are elsewhere, too. Whether the rows agree, in the rates of drives for one, is
  /// not asked here: see row_watch.hpp.
  std::vector<RedundantRow> drop_redundant(When when, ConstVectorRef p);

  Unloaded without_loads(const State& s, Scratch& scratch) const;
  /// The largest number of what each of description().forces does in a state (N, N m, or modal): zero where it does not act.
  std::vector<double> sizes_of_forces(const State& s, Scratch& scratch) const;

  /// Pose of every body (0 = ground) for pictures.
  void body_poses(const State& s, Scratch& scratch, std::vector<Pose>& poses) const;
  /// What a unit force on a coordinate of a joint puts on the velocity coordinates (n_v), of one that closes a loop, too.
  Eigen::VectorXd force_along(CoordinateRef c, const State& s, Scratch& scratch) const;
  /// Poses, twists and accelerations of the bodies' frames, all in W.
  void body_motions(const State& s, ConstVectorRef v_dot, Scratch& scratch,
                    std::vector<MarkerState>& bodies) const;

  /// W (n_v x n_v): in axes that turn with the angular velocity Omega_W, expressed in W, the velocity
  /// coordinates of a motion that is steady there obey v' = W v.  Zero for joints whose coordinates refer to
  /// no such axes: see turning_axes.hpp.
  Eigen::MatrixXd turning_axes(const State& s, const Vector3d& Omega_W, Scratch& scratch) const;
  /// The same with every joint's coordinates in axes of the body that it moves.
  Eigen::MatrixXd turning_with_bodies(const State& s, Scratch& scratch) const;
  /// First entry of a body's deformation in p, -1 where it has none or one that does not act back.
  int modal_position(int body) const;
  /// nullptr for a rigid body.
  const FlexibleBody* deforming(int body) const;
  /// The coordinates of its deformation; nullptr for a rigid body.
  const double* modal_coordinates(int body, const State& s) const;

  /// What row i of the constraints belongs to.
  RowPlace row_place(int i) const;
  bool in_tree(int joint) const;
  /// True where the tree runs through the joint from M's body to F's.
  bool is_reversed(int joint) const;
  const std::vector<JointPlace>& joint_places() const;

  /// Everything that can be stored by name: coordinates, reactions, forces, measures, energies, ...
  std::vector<OutputInfo> quantities() const;
  /// Those that are stored when the user does not say which.
  std::vector<int> usual_quantities() const;
  /// Which of quantities(), forces of joints, drives and constraints, redundant constraints leave open at the
  /// configuration p: values of them are those without the rows that were left out.
  std::vector<bool> not_unique(When when, ConstVectorRef p) const;
  /// Values of the quantities with these indices; lambda and v_dot must belong to the state.
  void evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot, Scratch& scratch,
                VectorRef values) const;

 private:
  struct Joined;
  MechanismScratch& scratch_of(Scratch& scratch) const;
  /// After its positions and velocities: states and signals.
  MechanismScratch& observe(const State& s, Scratch& scratch) const;
  /// Positions alone.
  MechanismScratch& move(double t, ConstVectorRef p, Scratch& scratch) const;

  std::unique_ptr<Joined> m_;
};

}  // namespace flexura::mbs
