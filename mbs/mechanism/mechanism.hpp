// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/bodies/flexible_body.hpp"
#include "mbs/bodies/modal_data.hpp"
#include "mbs/bodies/section_points.hpp"
#include "mbs/bodies/stress_field.hpp"
#include "mbs/bodies/surface_points.hpp"
#include "mbs/constraints/constraint.hpp"
#include "mbs/controls/control.hpp"
#include "mbs/equations/equations.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/joints/joint.hpp"
#include "mbs/measures/measure.hpp"

/// A mechanism: bodies on a tree of joints in relative coordinates, loops closed by constraints, forces.
///
/// Inverse dynamics is the recursive Newton-Euler sweep (Featherstone, Rigid Body Dynamics Algorithms, ch. 5)
/// with flexible bodies in floating frames: outwards poses, velocities and accelerations of the bodies, where
/// a joint may sit on markers that move with the deformation of either body; inwards the wrenches.  Every
/// body's twist is (w_WB, v_WBo) expressed in W.  The mass matrix comes from composite bodies that keep their
/// modal coordinates.
namespace flexura::mbs {

struct MarkerDescription {
  std::string name;   ///< "crank.pin"
  int body = 0;       ///< 0 is ground
  Pose X_BP;          ///< in the undeformed body; on a node: relative to the node
  int node = -1;      ///< of a flexible body: loads here deform it, and where the deformation acts back it moves the marker
};

struct BodyDescription {
  std::string name;
  RigidInertia inertia = {};                           ///< of a rigid body
  std::shared_ptr<const FlexibleBody> flexible = {};   ///< or this
  std::shared_ptr<const StressField> stress = {};      ///< of a deforming body
  std::shared_ptr<const SectionPoints> sections = {};  ///< of a deforming beam part
  std::shared_ptr<const SurfacePoints> surface_points = {};
  std::optional<Pose> X_WB = {};                       ///< guess for the assembly, in [m]
  std::string superelement = {};                       ///< file, for pictures
  bool follows_surface = false;                        ///< markers follow nodes of the superelement's surface
  std::vector<BodyLoad> loads = {};                    ///< load cases of its superelement
  bool is_loaded_by_case = false;                      ///< a force puts one of them on it
  std::string shape_json = {};                         ///< primitive shapes, for pictures
};

struct JointDescription {
  std::string name;
  std::shared_ptr<const Joint> joint;
  int marker_F = -1, marker_M = -1;
  bool cut = false;           ///< keep out of the tree
  bool keep_in_tree = false;  ///< even in a long branch, see split_branches.cpp
  bool splits = false;        ///< the program cut it there
  bool bends = false;         ///< between pieces of a beam: its coordinates are deformations
  /// The program decides what it becomes: a joint of the tree where one is needed, the one with the fewest
  /// freedoms first, else a constraint; its initial values are then of no account.
  bool is_connection = false;
  std::map<int, double> initial_coordinates;  ///< by index
  std::map<int, double> initial_speeds;
  std::map<int, std::shared_ptr<const Expression>> drives;  ///< coordinate = formula of time
  std::map<int, std::shared_ptr<const Expression>> speed_drives,
      acceleration_drives;  ///< the same of its rates
  bool is_driven() const { return !drives.empty() || !speed_drives.empty() || !acceleration_drives.empty(); }
};

/// A formula of the motion.
struct FormulaDescription {
  std::shared_ptr<const Expression> expression;
  bool drives = false;  ///< prescribes a motion, by t alone
};

/// An input u of the mechanism: a function of time that formulas read by its name.
struct InputDescription {
  std::string name;
  std::shared_ptr<const Expression> value;
};

struct MechanismDescription {
  std::string name;
  Vector3d gravity = Vector3d::Zero();  ///< in W [m/s^2]
  std::vector<BodyDescription> bodies{{.name = "ground"}};
  std::vector<MarkerDescription> markers;
  std::vector<JointDescription> joints;
  std::vector<std::shared_ptr<const Constraint>> constraints;
  std::vector<std::shared_ptr<const ForceElement>> forces;
  std::vector<std::shared_ptr<const Measure>> measures;
  std::vector<std::shared_ptr<const Control>> controls;
  std::vector<InputDescription> inputs;
  /// Formulas that forces, controls, measures and drives are made of.
  std::vector<FormulaDescription> formulas;
  /// What formulas may read: "t", then any "joint.coordinate", "joint.speed", "measure" they name.
  SignalNames signals;

  int add_body(BodyDescription body);
  int add_marker(int body, const std::string& name, const Pose& X_BP = {}, int node = -1);
  int add_joint(const std::string& name, const std::string& type, int marker_F, int marker_M);

  /// Where a marker stands in its undeformed body.
  Pose undeformed(int marker) const;
  /// Takes a body's deformation away: what is left moves as a rigid body.
  void make_rigid(int body);
};

/// A redundant constraint row that was left out.
struct RedundantRow {
  std::string name;                       ///< "slider.rotation_x"
  std::vector<std::string> follows_from;  ///< rows it is a combination of: their multipliers are not unique
};

class Mechanism final : public Equations {
 public:
  /// Throws std::invalid_argument with one sentence for a description that cannot move or stand: a joint
  /// between two markers of one body, driven joints that form a loop, a negative mass, ...
  explicit Mechanism(MechanismDescription description);
  ~Mechanism() override;

  const MechanismDescription& description() const { return d_; }

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
  void position_constraints(double t, ConstVectorRef p, Scratch& scratch, VectorRef g) const override;
  void velocity_constraints(double t, ConstVectorRef p, ConstVectorRef v, Scratch& scratch,
                            VectorRef g_dot) const override;
  void constraints(double t, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                   VectorRef g_dot) const override;
  void acceleration_constraints(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                Scratch& scratch, VectorRef g_ddot) const override;
  void apply_GT(double t, ConstVectorRef p, ConstVectorRef x, Scratch& scratch, VectorRef f_c) const override;
  void constraint_matrix(double t, ConstVectorRef p, Scratch& scratch, MatrixRef G) const override;
  ConstraintSizes constraint_sizes(double t, ConstVectorRef p, Scratch& scratch) const override;
  int n_left_out() const override { return static_cast<int>(left_out_.size()); }
  void left_out_constraints(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                            Scratch& scratch, VectorRef g, VectorRef g_dot, VectorRef g_ddot) const override;
  ConstraintSizes left_out_sizes(double t, ConstVectorRef p, Scratch& scratch) const override;
  std::vector<std::string> names_of_left_out(int i) const override;
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
  std::string name_of_constraint(int i) const override;
  std::string name_of_algebraic(int i) const override;
  std::string name_of_root(int i) const override;
  std::string describe_root(int i) const override;
  bool is_condition(int root) const override { return root >= first_switch_.back(); }
  bool is_kink(int root) const override;
  void hold_conditions(State& s, Scratch& scratch) const override;
  std::vector<std::shared_ptr<const TimeFunction>> functions_of_time() const override {
    return functions_of_time_;
  }
  int n_inputs() const override { return static_cast<int>(d_.inputs.size()); }
  std::string name_of_input(int i) const override { return d_.inputs[i].name; }
  double input_value(int i, double t) const override { return d_.inputs[i].value->evaluate(&t); }

  // ---- beyond it
  // -------------------------------------------------------------------------------------------------
  /// Initial values as the file gives them: a guess, to be assembled.
  State initial_state() const;
  /// Entries of p and v that the user gave: an assembly should rather move the others.
  const std::vector<bool>& given_positions() const { return given_p_; }
  const std::vector<bool>& given_velocities() const { return given_v_; }

  /// Puts all switches, and the states that go with them, where the assembled state s wants them.
  void start_switches(State& s, Scratch& scratch) const;
  /// Puts the contacts of constraints that travel along curves, algebraic states, where the positions of s
  /// are.
  void start_contacts(State& s, Scratch& scratch) const;

  /// Finds rows that follow from others at the assembled configuration p and near it (a rank that drops at an
  /// instant is not redundancy), leaves them out of all later evaluations and says which. Near means where the
  /// mechanism gets when drives are elsewhere, too. Whether the rows agree, in the rates of drives for one, is
  /// not asked here: see row_watch.hpp.
  std::vector<RedundantRow> drop_redundant(double t, ConstVectorRef p);

  /// The mechanism as it is without weight and given loads, in the state s: what a force's load is there
  /// (ForceElement::without_load).  Springs, bushings, contacts and friction stay.
  struct Unloaded {
    MechanismDescription description;
    std::vector<std::string> loads;    ///< what was taken away
    std::vector<std::string> unknown;  ///< forces that do not say what they are, and act: they stay
  };
  Unloaded without_loads(const State& s, Scratch& scratch) const;

  /// Pose of every body (0 = ground) for pictures.
  void body_poses(const State& s, Scratch& scratch, std::vector<Pose>& poses) const;
  /// Poses, twists and accelerations of the bodies' frames, all in W.
  void body_motions(const State& s, ConstVectorRef v_dot, Scratch& scratch,
                    std::vector<MarkerState>& bodies) const;

  /// W (n_v x n_v): in axes that turn with the angular velocity Omega_W, expressed in W, the velocity
  /// coordinates of a motion that is steady there obey v' = W v.  Zero for joints whose coordinates refer to
  /// no such axes: see turning_axes.cpp.
  Eigen::MatrixXd turning_axes(const State& s, const Vector3d& Omega_W, Scratch& scratch) const;
  /// The same with every joint's coordinates in axes of the body that it moves.
  Eigen::MatrixXd turning_with_bodies(const State& s, Scratch& scratch) const;
  /// First entry of a body's deformation in p, -1 where it has none or one that does not act back.
  int modal_position(int body) const { return bodies_[body].m > 0 ? bodies_[body].i_p : -1; }
  /// nullptr for a rigid body.
  const FlexibleBody* deforming(int body) const { return d_.bodies[body].flexible.get(); }
  /// The coordinates of its deformation; nullptr for a rigid body.
  const double* modal_coordinates(int body, const State& s) const;

  bool in_tree(int joint) const { return places_[joint].in_tree(); }
  /// True where the tree runs through the joint from M's body to F's.
  bool is_reversed(int joint) const;
  const std::vector<JointPlace>& joint_places() const { return places_; }

  /// Everything that can be stored by name: coordinates, reactions, forces, measures, energies, ...
  std::vector<OutputInfo> quantities() const;
  /// Those that are stored when the user does not say which.
  std::vector<int> usual_quantities() const;
  /// Which of quantities(), forces of joints, drives and constraints, redundant constraints leave open at the
  /// configuration p: values of them are those without the rows that were left out.
  std::vector<bool> not_unique(double t, ConstVectorRef p) const;
  /// Values of the quantities with these indices; lambda and v_dot must belong to the state.
  void evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot, Scratch& scratch,
                VectorRef values) const;

 private:
  struct Work;
  class BodyLoads;
  class RowLoads;
  class ElementDerivatives;

  struct TreeBody {
    int parent = -1;
    int joint = -1;         ///< index in description().joints
    bool reversed = false;  ///< the parent carries the joint's M
    int marker_in = -1;     ///< the joint's marker on the parent
    int marker_out = -1;    ///< the joint's marker on this body
    int i_p = 0, i_v = 0;   ///< coordinates of its deformation (after those of the joint)
    int m = 0;              ///< their number; 0 where it is rigid or the deformation does not act back
    int i_c = -1;           ///< of a deformation that does not act back: its coordinates, then their rates, in c
    /// What the deformation needs in Work::r: m numbers at i_v, or of one that does not act back behind those of all
    /// velocities.
    int i_need = 0, n_need = 0;
  };

  enum class Level { position, velocity, acceleration };

  void build_tree();
  void grow_tree();
  bool split_branches();
  void follow_split_joints();
  void place_joint(int body, int joint, bool reversed);
  void number_states();
  void list_conditions(const std::vector<bool>& is_used);
  int n_switches() const { return first_switch_.back() + static_cast<int>(conditions_.size()); }
  void build_constraints();
  void find_initial_values();
  void stand_at(int b, const Pose& X_WB, const Work& work);
  void check_inertia() const;

  Work& work_of(Scratch& scratch) const;
  void forward(Level level, double t, const double* p, const double* v, const double* v_dot,
               Work& work) const;
  void place_markers(int body, Level level, Work& work) const;
  void move_through_joint(int body, Level level, Work& work) const;
  void place_on_node(int marker, const double* s, const double* s_dot, const double* s_ddot, Work& work) const;
  void deform_inertia(Work& work) const;
  void body_forces(bool with_gravity, Work& work) const;
  void evaluate_signals(Work& work) const;
  void applied_forces(const State& s, VectorRef c_rate, VectorRef b, Work& work) const;
  enum class Which { all, with_derivatives, without_derivatives };
  void element_loads(const State& s, Which which, VectorRef c_rate, VectorRef b, Work& work) const;
  ForceNature nature_by_trial(std::size_t force, const State& s, Scratch& scratch) const;
  void own_inertia(Work& work) const;
  void size_tangents(Work& work) const;
  void vary_joints(Work& work) const;
  void vary_inertia(Work& work) const;
  void inertia_tangents(bool with_modes, Work& work, Eigen::MatrixXd& z_q, Eigen::MatrixXd& z_v) const;
  void mode_tangents(Work& work, Eigen::MatrixXd& z_q, Eigen::MatrixXd& z_v) const;
  void vary_nodes(int body, Work& work, Eigen::MatrixXd& z_q) const;
  void difference_elements(const State& s, TangentScope scope, Work& work, TangentMatrices& out) const;
  void take_to_coordinates(const double* p, const Eigen::MatrixXd& by_tangent, Eigen::MatrixXd& by_p) const;
  void constraint_rows(VectorRef g, VectorRef g_dot, Work& work) const;
  /// Which constraint a row, among all rows, belongs to.
  std::size_t constraint_of_row(int row) const;
  std::string name_of_row(int row) const;
  double extent(const Work& work) const;
  ConstraintSizes sizes_of_rows(const std::vector<int>& rows, double t, ConstVectorRef p, Work& work) const;
  Eigen::VectorXd kinematic_scale(double extent) const;
  void take_states(const State& s, Work& work) const;
  void own_states(std::size_t force, Work& work) const;
  double control_output(int control, const Work& work) const;
  double input_now(int input, const Work& work) const;
  void algebraic_equations(const Work& work, VectorRef b) const;
  void own_contact(std::size_t constraint, Work& work) const;
  std::string name_of_force_state(int i) const;
  void clear_loads(Work& work) const;
  void following_need(int body, const Spatial& V, const Spatial& A, Work& work) const;
  void following_rates(const Work& work, double* c_rate) const;
  void following_tangents(Work& work, Eigen::MatrixXd& z_c) const;
  void difference_following(const State& s, ConstVectorRef v_dot, Work& work, TangentMatrices& out) const;
  void deform_following_markers(Work& work) const;
  void backward(Work& work, double* r) const;
  void add_constraint_loads(const double* lambda, double factor, Work& work, Which which = Which::all) const;
  EnergyReport energies(const double* lambda, Work& work) const;
  void list_quantities();
  Vector6d joint_reaction(int joint, Work& work) const;
  double drive_force(int joint, int coordinate, const Work& work) const;
  Vector6d total_momentum(const Work& work) const;

  MechanismDescription d_;
  std::vector<TreeBody> bodies_;
  std::vector<int> order_;        ///< bodies outwards, without ground
  std::vector<int> whole_order_;  ///< the same before long branches were split; empty where none was
  std::vector<int> split_joint_;  ///< of a body whose branch begins there: the joint that led to it, or -1
  std::vector<JointPlace> places_;
  std::vector<std::vector<int>> markers_of_body_;
  std::vector<char> on_node_;      ///< of each marker: it stands on a node of a deformation,
  std::vector<char> is_carried_;   ///< which moves it
  std::vector<std::shared_ptr<const Constraint>> constraints_;  ///< closures, drives, then the description's
  std::vector<int> first_row_;     ///< of each constraint among all rows, and their number at the end
  std::vector<int> kept_rows_;     ///< all rows -> without redundant ones
  std::vector<int> left_out_;      ///< these
  std::vector<std::vector<int>> follows_from_;  ///< of each row left out: kept ones, among all rows
  std::vector<int> used_signals_;  ///< in the order in which they can be evaluated
  std::vector<int> first_state_;   ///< of each control in c, and their number at the end
  std::vector<int>
      first_force_state_;  ///< of each force in c, after the controls; the number of all at the end
  std::vector<int> first_control_switch_;  ///< of each control, and their number at the end
  std::vector<int> algebraic_;             ///< controls with an algebraic state, the first of all
  std::vector<int> contacts_;              ///< constraints with a contact on a curve, whose states come next
  std::vector<int> first_switch_;          ///< of each force among the switches, and their number at the end
  struct Condition {
    std::shared_ptr<const Expression> formula;
    int node = 0, place = 0, number = 1;  ///< place: of the signal that holds it
  };
  std::vector<Condition> conditions_;  ///< the last of the switches
  std::vector<std::shared_ptr<const TimeFunction>> functions_of_time_;
  struct SignalSource {
    enum class Kind { time, coordinate, speed, measure, control, input } kind = Kind::time;
    CoordinateRef coordinate;
    int element = -1;  ///< measure, control or input
  };
  std::vector<SignalSource> sources_;  ///< of each signal
  enum class QuantityKind {
    coordinate,
    speed,
    acceleration,
    reaction,
    drive,
    body_position,
    body_velocity,
    body_acceleration,
    mode,
    strain_energy,
    largest_stress,
    point_stress,
    section_force,
    surface_point,
    measure,
    contact,
    input,
    control,
    force,
    constraint,
    momentum,
    energy
  };
  static constexpr int kOfPoint = 13;  ///< of point_stress: six stresses, von Mises', six strains
  struct QuantityPlace {
    OutputInfo info;
    QuantityKind kind;
    int index, component;
    bool usual;
  };
  std::vector<QuantityPlace> quantities_;
  int n_p_ = 0, n_v_ = 0, n_flx_ = 0, n_dyn_ = 0, n_need_ = 0;
  Eigen::VectorXd p_0_, v_0_;
  std::vector<bool> given_p_, given_v_;
};

}  // namespace flexura::mbs
