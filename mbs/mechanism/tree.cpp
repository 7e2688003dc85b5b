// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/mechanism/work.hpp"

/// Building a mechanism: which joints span the tree, where their coordinates stand, what they start from.
namespace flexura::mbs {

int MechanismDescription::add_body(BodyDescription body) {
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}

int MechanismDescription::add_marker(int body, const std::string& marker_name, const Pose& X_BP, int node) {
  markers.push_back({bodies.at(body).name + "." + marker_name, body, X_BP, node});
  return static_cast<int>(markers.size()) - 1;
}

int MechanismDescription::add_joint(const std::string& joint_name, const std::string& type, int marker_F,
                                    int marker_M) {
  JointDescription joint;
  joint.name = joint_name;
  joint.joint = make_joint(type);
  joint.marker_F = marker_F;
  joint.marker_M = marker_M;
  joints.push_back(std::move(joint));
  return static_cast<int>(joints.size()) - 1;
}

Pose MechanismDescription::undeformed(int marker) const {
  const MarkerDescription& m = markers[static_cast<std::size_t>(marker)];
  const FlexibleBody* const flexible = bodies[static_cast<std::size_t>(m.body)].flexible.get();
  if (m.node < 0 || !flexible) return m.X_BP;
  return {m.X_BP.R, flexible->nodes()[static_cast<std::size_t>(m.node)].p_BoN_B + m.X_BP.p};
}

void MechanismDescription::make_rigid(int body) {
  BodyDescription& b = bodies[static_cast<std::size_t>(body)];
  if (!b.flexible) return;
  for (std::size_t i = 0; i < markers.size(); ++i)
    if (markers[i].body == body) {
      markers[i].X_BP = undeformed(static_cast<int>(i));
      markers[i].node = -1;
    }
  b.inertia = b.flexible->undeformed_inertia();
  b.flexible = nullptr;
  b.stress = nullptr;
  b.sections = nullptr;
}

Mechanism::~Mechanism() = default;

Mechanism::Mechanism(MechanismDescription description) : d_(std::move(description)) {
  build_tree();
  number_states();
  build_constraints();
  find_initial_values();
  list_quantities();
  check_inertia();
}

void Mechanism::check_inertia() const {
  const auto scratch = make_scratch();
  // The dense factors cost n^3 and find the name; a large mechanism asks for them only where something is
  // wrong.
  if (n_v_ > 300 && factor_mass(p_0_, *scratch)) return;
  Eigen::MatrixXd M(n_v_, n_v_);
  mass_matrix(p_0_, *scratch, M);
  // Cholesky's method; a pivot at round-off of its diagonal entry means no inertia beside the coordinates
  // before it.
  for (int i = 0; i < n_v_; ++i) {
    const double diagonal = M(i, i);
    for (int k = 0; k < i; ++k) M(i, i) -= M(i, k) * M(i, k);
    if (!(M(i, i) > 1e-14 * diagonal)) {
      std::string body;
      for (int b : order_)
        if (places_[bodies_[b].joint].i_v <= i) body = d_.bodies[b].name;
      throw std::invalid_argument(
          fmt::format("nothing with inertia moves along \"{}\" alone; give body \"{}\", or what hangs on it, "
                      "mass or inertia",
                      name_of_velocity(i), body));
    }
    M(i, i) = std::sqrt(M(i, i));
    for (int j = i + 1; j < n_v_; ++j) {
      for (int k = 0; k < i; ++k) M(j, i) -= M(j, k) * M(i, k);
      M(j, i) /= M(i, i);
    }
  }
}

void Mechanism::build_tree() {
  const int n_bodies = static_cast<int>(d_.bodies.size());
  for (int b = 1; b < n_bodies; ++b) {
    BodyDescription& body = d_.bodies[b];
    if (body.flexible && (!body.flexible->acts_back() || body.flexible->m() == 0))
      body.inertia = body.flexible->undeformed_inertia();  // as it moves
    const double mass = body.flexible ? body.flexible->mass() : body.inertia.mass;
    if (mass < 0.0)
      throw std::invalid_argument(
          fmt::format("body \"{}\" has the mass {} kg; a mass must not be negative", body.name, mass));
  }
  for (const JointDescription& joint : d_.joints) {
    const int a = d_.markers.at(joint.marker_F).body, b = d_.markers.at(joint.marker_M).body;
    if (a == b)
      throw std::invalid_argument(fmt::format(
          "joint \"{}\" goes from \"{}\" to \"{}\", two markers of one body; a joint joins two bodies",
          joint.name, d_.markers[joint.marker_F].name, d_.markers[joint.marker_M].name));
  }
  grow_tree();
  if (split_branches()) grow_tree();
  on_node_.assign(d_.markers.size(), false);
  is_carried_ = on_node_;
  for (std::size_t i = 0; i < d_.markers.size(); ++i) {
    const FlexibleBody* const flexible = d_.bodies[d_.markers[i].body].flexible.get();
    on_node_[i] = d_.markers[i].node >= 0 && flexible;
    is_carried_[i] = on_node_[i] && flexible->acts_back();
  }
  markers_of_body_.assign(n_bodies, {});
  for (std::size_t i = 0; i < d_.markers.size(); ++i)
    markers_of_body_[d_.markers[i].body].push_back(static_cast<int>(i));
}

void Mechanism::grow_tree() {
  const int n_bodies = static_cast<int>(d_.bodies.size());
  order_.clear();
  bodies_.assign(n_bodies, {});
  std::vector<bool> reached(n_bodies, false), used(d_.joints.size(), false);
  reached[0] = true;
  std::vector<int> queue{0};

  // Breadth first in the order of the file, except that a driven or coupled joint is taken as soon as one of
  // its bodies is reached, since its coordinate must be a state, then one whose coordinate the user set or that
  // must not be cut, then one along which forces act: angles of joints that close loops are known within +-pi only.
  enum Priority { ordinary, loaded, set, wanted };
  std::vector<Priority> priority(d_.joints.size(), ordinary);
  for (const auto& force : d_.forces)
    for (const CoordinateRef& c : force->coordinates()) priority[c.joint] = loaded;
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    if (!d_.joints[j].initial_coordinates.empty() || d_.joints[j].keep_in_tree) priority[j] = set;
    if (d_.joints[j].is_driven()) priority[j] = wanted;
  }
  for (const auto& constraint : d_.constraints)
    for (const CoordinateRef& c : constraint->coordinates()) priority[c.joint] = wanted;
  const auto next_joint = [&](Priority level, int body) {
    for (std::size_t j = 0; j < d_.joints.size(); ++j) {
      const JointDescription& joint = d_.joints[j];
      if (used[j] || joint.cut || joint.is_connection || priority[j] != level) continue;
      const int f = d_.markers[joint.marker_F].body, m = d_.markers[joint.marker_M].body;
      if (reached[f] == reached[m]) continue;
      if (body >= 0 && f != body && m != body) continue;
      return static_cast<int>(j);
    }
    return -1;
  };
  const auto take = [&](int j) {
    const int f = d_.markers[d_.joints[j].marker_F].body, m = d_.markers[d_.joints[j].marker_M].body;
    const bool reversed = !reached[f];
    const int outer = reversed ? f : m;
    used[j] = reached[outer] = true;
    place_joint(outer, j, reversed);
    queue.push_back(outer);
  };
  // Joints lead where they can; where they end, the connection with the fewest freedoms leads on.
  const auto next_connection = [&] {
    int best = -1;
    for (std::size_t j = 0; j < d_.joints.size(); ++j) {
      const JointDescription& joint = d_.joints[j];
      if (used[j] || !joint.is_connection) continue;
      if (reached[d_.markers[joint.marker_F].body] == reached[d_.markers[joint.marker_M].body]) continue;
      if (best < 0 || joint.joint->n_v() < d_.joints[best].joint->n_v()) best = static_cast<int>(j);
    }
    return best;
  };
  const auto follow_joints = [&] {
    for (std::size_t k = 0; k < queue.size(); ++k) {
      while (true) {
        int j = next_joint(wanted, -1);
        if (j < 0) j = next_joint(set, -1);
        if (j < 0) j = next_joint(loaded, -1);
        if (j < 0) j = next_joint(ordinary, queue[k]);
        if (j < 0) break;
        take(j);
      }
    }
  };
  const auto sweep = [&] {
    follow_joints();
    for (int j = next_connection(); j >= 0; j = next_connection()) {
      take(j);
      follow_joints();
    }
  };
  sweep();
  // Bodies that no joint leads to float free: the first of each such group gets six freedoms to ground.
  for (int b = 1; b < n_bodies; ++b) {
    if (reached[b]) continue;
    const int F = d_.add_marker(0, "origin_of_" + d_.bodies[b].name, {});
    const int M = d_.add_marker(b, "frame", {});
    const int j = d_.add_joint(d_.bodies[b].name, "six_dof", F, M);
    used.push_back(false);
    priority.push_back(ordinary);
    take(j);
    sweep();
  }
  // The joints of the tree between the two bodies of another one.
  const auto loop_of = [&](int j) {
    std::vector<std::string> names;
    std::vector<bool> is_on_way(n_bodies, false);
    int f = d_.markers[d_.joints[j].marker_F].body, m = d_.markers[d_.joints[j].marker_M].body;
    for (int b = f; b >= 0; b = b == 0 ? -1 : bodies_[b].parent) is_on_way[b] = true;
    for (; !is_on_way[m]; m = bodies_[m].parent) names.push_back("\"" + d_.joints[bodies_[m].joint].name + "\"");
    for (; f != m; f = bodies_[f].parent) names.push_back("\"" + d_.joints[bodies_[f].joint].name + "\"");
    return fmt::format("{}", fmt::join(names, ", "));
  };
  // A driven joint that closes a loop of driven ones repeats what these say or contradicts them, and is told so when
  // the loops close; couplings count turns, which no closure does.
  std::vector<bool> coupled(d_.joints.size(), false);
  for (const auto& constraint : d_.constraints)
    for (const CoordinateRef& c : constraint->coordinates()) coupled[c.joint] = true;
  for (std::size_t j = 0; j < d_.joints.size(); ++j)
    if (!used[j] && coupled[j])
      throw std::invalid_argument(
          d_.joints[j].cut
              ? fmt::format("joint \"{}\" is coupled but closes a loop; take away its cut = true and cut "
                            "another joint of the loop",
                            d_.joints[j].name)
              : fmt::format("joint \"{}\" is coupled but closes a loop of joints that are all coupled or driven ({}): "
                            "where one of them is prescribed by the others its coupling can only say the same or "
                            "contradict them; take away one of the couplings or drives",
                            d_.joints[j].name, loop_of(static_cast<int>(j))));

  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    const JointDescription& joint = d_.joints[j];
    if (used[j] || joint.is_connection || (joint.initial_coordinates.empty() && joint.initial_speeds.empty()))
      continue;
    throw std::invalid_argument(fmt::format(
        "joint \"{}\" closes a loop, so its coordinate and speed follow from those of the other joints; take "
        "its initial values away, or {}",
        joint.name, joint.cut ? "its cut = true" : "cut another joint of the loop with cut = true"));
  }
}

void Mechanism::place_joint(int body, int joint, bool reversed) {
  const JointDescription& j = d_.joints[joint];
  TreeBody& t = bodies_[body];
  t.joint = joint;
  t.reversed = reversed;
  t.marker_in = reversed ? j.marker_M : j.marker_F;
  t.marker_out = reversed ? j.marker_F : j.marker_M;
  t.parent = d_.markers[t.marker_in].body;
  order_.push_back(body);
}

void Mechanism::number_states() {
  places_.resize(d_.joints.size());
  for (std::size_t j = 0; j < d_.joints.size(); ++j)
    places_[j] = {d_.joints[j].joint.get(), d_.joints[j].marker_F, d_.joints[j].marker_M};
  for (int b : order_) {
    TreeBody& body = bodies_[b];
    JointPlace& place = places_[body.joint];
    place.i_p = n_p_;
    place.i_v = n_v_;
    n_p_ += place.joint->n_p();
    n_v_ += place.joint->n_v();
    body.i_p = n_p_;
    body.i_v = n_v_;
    const FlexibleBody* const flexible = d_.bodies[b].flexible.get();
    body.n_need = flexible ? flexible->m() : 0;
    body.m = flexible && flexible->acts_back() ? body.n_need : 0;
    body.i_need = body.i_v;
    n_p_ += body.m;
    n_v_ += body.m;
    n_flx_ += body.m;
  }
  n_need_ = n_v_;
  for (int b : order_)
    if (TreeBody& body = bodies_[b]; body.n_need > body.m) {
      body.i_need = n_need_;
      n_need_ += body.n_need;
    }
}

void Mechanism::build_constraints() {
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    const JointDescription& joint = d_.joints[j];
    if (!places_[j].in_tree() && joint.joint->n_rows() > 0)
      constraints_.push_back(
          std::make_shared<RelativeConstraint>(joint.name, joint.marker_F, joint.marker_M, joint.joint));
    for (const auto& [index, motion] : joint.drives)
      constraints_.push_back(
          std::make_shared<DriveConstraint>(joint.name, CoordinateRef{static_cast<int>(j), index}, motion));
    for (const auto& [index, motion] : joint.speed_drives)
      constraints_.push_back(std::make_shared<DriveConstraint>(
          joint.name, CoordinateRef{static_cast<int>(j), index}, motion, DriveLevel::speed));
    for (const auto& [index, motion] : joint.acceleration_drives) {
      const auto given = joint.initial_speeds.find(index);
      constraints_.push_back(std::make_shared<DriveConstraint>(
          joint.name, CoordinateRef{static_cast<int>(j), index}, motion, DriveLevel::acceleration,
          given == joint.initial_speeds.end() ? 0.0 : given->second));
    }
  }
  constraints_.insert(constraints_.end(), d_.constraints.begin(), d_.constraints.end());
  int row = 0;
  for (const auto& constraint : constraints_) {
    if (constraint->has_contact()) contacts_.push_back(static_cast<int>(first_row_.size()));
    first_row_.push_back(row);
    row += constraint->n_rows();
  }
  first_row_.push_back(row);
  for (int i = 0; i < row; ++i) kept_rows_.push_back(i);

  // Where the signals come from, and which of them anything reads.
  sources_.resize(d_.signals.size());
  std::vector<bool> is_used(d_.signals.size(), false);
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    const std::string prefix = d_.joints[j].name + ".";
    const auto link = [&](const std::vector<CoordinateInfo>& infos, SignalSource::Kind kind) {
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (const int k = d_.signals.find(prefix + infos[i].name); k >= 0)
          sources_[k] = {kind, {static_cast<int>(j), static_cast<int>(i)}, -1};
    };
    link(d_.joints[j].joint->coordinates(), SignalSource::Kind::coordinate);
    link(d_.joints[j].joint->speeds(), SignalSource::Kind::speed);
  }
  for (std::size_t i = 0; i < d_.measures.size(); ++i)
    if (const int k = d_.signals.find(d_.measures[i]->name()); k >= 0)
      sources_[k] = {SignalSource::Kind::measure, {}, static_cast<int>(i)};
  for (std::size_t i = 0; i < d_.inputs.size(); ++i)
    if (const int k = d_.signals.find(d_.inputs[i].name); k >= 0)
      sources_[k] = {SignalSource::Kind::input, {}, static_cast<int>(i)};
  first_state_ = {0};
  for (std::size_t i = 0; i < d_.controls.size(); ++i) {
    first_state_.push_back(first_state_.back() + d_.controls[i]->n_states());
    if (const int k = d_.signals.find(d_.controls[i]->name()); k >= 0)
      sources_[k] = {SignalSource::Kind::control, {}, static_cast<int>(i)};
  }
  first_force_state_ = {first_state_.back()};
  first_control_switch_ = {0};
  for (std::size_t i = 0; i < d_.controls.size(); ++i) {
    first_control_switch_.push_back(first_control_switch_.back() + d_.controls[i]->n_switches());
    if (d_.controls[i]->is_algebraic()) algebraic_.push_back(static_cast<int>(i));
  }
  first_switch_ = {first_control_switch_.back()};
  for (const auto& force : d_.forces) {
    first_force_state_.push_back(first_force_state_.back() + force->n_states());
    first_switch_.push_back(first_switch_.back() + force->n_switches());
  }
  // Deformations that do not act back come last among the dynamic states.
  n_dyn_ = first_force_state_.back();
  for (int b : order_)
    if (TreeBody& body = bodies_[b]; body.n_need > body.m) {
      body.i_c = n_dyn_;
      n_dyn_ += 2 * body.n_need;
    }
  const auto mark = [&](const std::vector<int>& reads) {
    for (int k : reads) is_used[k] = true;
  };
  for (const auto& force : d_.forces) mark(force->reads());
  for (const auto& control : d_.controls) mark(control->reads());
  // A measure reads only measures before it: backwards, so that what a used one needs is used too.
  for (std::size_t i = d_.measures.size(); i-- > 0;)
    if (const int k = d_.signals.find(d_.measures[i]->name()); k >= 0 && is_used[k])
      mark(d_.measures[i]->reads());
  list_conditions(is_used);
  // Coordinates, outputs that depend on states alone, measures in their order, then what feeds through.
  const auto append = [&](auto&& wanted) {
    for (int k = 1; k < d_.signals.size(); ++k)
      if (is_used[k] && wanted(sources_[k])) used_signals_.push_back(k);
  };
  using Kind = SignalSource::Kind;
  append([](const SignalSource& s) {
    return s.kind == Kind::coordinate || s.kind == Kind::speed || s.kind == Kind::input;
  });
  append([&](const SignalSource& s) {
    return s.kind == Kind::control && !d_.controls[s.element]->feeds_through();
  });
  append([](const SignalSource& s) { return s.kind == Kind::measure; });
  append([&](const SignalSource& s) {
    return s.kind == Kind::control && d_.controls[s.element]->feeds_through();
  });
}

/// Sets the coordinates of b's joint in p_0_ so that the body stands at X_WB; `work` knows the markers of the
/// body before it.
void Mechanism::stand_at(int b, const Pose& X_WB, const Work& work) {
  const TreeBody& body = bodies_[b];
  const JointPlace& place = places_[body.joint];
  const Pose X = work.kin.markers[body.marker_in].X_WP.inverse() * X_WB * work.local[body.marker_out].X_BP;
  place.joint->coordinates_of(body.reversed ? X.inverse() : X, p_0_.data() + place.i_p);
}

void Mechanism::find_initial_values() {
  p_0_ = Eigen::VectorXd::Zero(n_p_);
  v_0_ = Eigen::VectorXd::Zero(n_v_);
  given_p_.assign(n_p_, false);
  given_v_.assign(n_v_, false);
  for (const JointPlace& place : places_)
    if (place.in_tree()) place.joint->reference(p_0_.data() + place.i_p);

  const auto scratch = make_scratch();
  Work& work = work_of(*scratch);
  const double t_0 = 0.0;
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    const JointDescription& joint = d_.joints[body.joint];
    const JointPlace& place = places_[body.joint];
    if (d_.bodies[b].X_WB) {
      forward(Level::position, 0.0, p_0_.data(), nullptr, nullptr, work);
      stand_at(b, *d_.bodies[b].X_WB, work);
    }
    for (const auto& [index, motion] : joint.drives) {
      const Jet f = motion->time_derivatives(0.0);
      p_0_[place.i_p + index] = f.value;
      v_0_[place.i_v + index] = f.first;
    }
    for (const auto& [index, motion] : joint.speed_drives) v_0_[place.i_v + index] = motion->evaluate(&t_0);
    for (const auto& [index, value] : joint.initial_coordinates) {
      p_0_[place.i_p + index] = value;
      given_p_[place.i_p + index] = true;
    }
    for (const auto& [index, value] : joint.initial_speeds) {
      v_0_[place.i_v + index] = value;
      given_v_[place.i_v + index] = true;
    }
  }
  follow_split_joints();
  // Initial coordinates may hold quaternions of any length.
  const Eigen::VectorXd p = p_0_;
  retract(p, Eigen::VectorXd::Zero(n_v_), p_0_);
}

}  // namespace flexura::mbs
