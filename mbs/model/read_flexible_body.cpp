// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/read_flexible_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mbs/model/modal_basis.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using input::Section;
namespace dim = input::dim;

/// Marker of a joint on the body, or -1.
int marker_on(const MechanismDescription& d, const JointDescription& joint, int body) {
  for (const int marker : {joint.marker_F, joint.marker_M})
    if (d.markers[marker].body == body) return marker;
  return -1;
}

using Nodes = std::vector<BodyNode>;

/// The node of its body that a marker stands on, or -1; on a one-way body markers do not move with it.
int node_of(const MarkerDescription& marker) {
  return std::max(marker.node, marker.ked_node);
}

/// The joint that a joint-fixed frame sits on: the first one (not cut) that leads to the body.
const JointDescription* frame_joint(const MechanismDescription& d, int body) {
  for (const bool cut : {false, true})
    for (const JointDescription& joint : d.joints)
      if (joint.cut == cut)
        if (const int marker = marker_on(d, joint, body); marker >= 0 && node_of(d.markers[marker]) >= 0)
          return &joint;
  return nullptr;
}

/// Unit wrenches (torque, force) about the marker in its own axes, as loads on the superelement.
MatrixXd marker_loads(const Nodes& nodes, const MarkerDescription& marker) {
  const Matrix3d& R = marker.X_BP.R;
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = R;
  axes.bottomRightCorner<3, 3>() = R;
  const BodyNode& node = nodes[node_of(marker)];
  const Vector3d offset = marker.node >= 0 ? marker.X_BP.p : Vector3d(marker.X_BP.p - node.p_BoN_B);
  return node_loads(node, offset) * axes;
}

/// The directions a joint locks, in its frame F.  Rotations first, as in a twist.
std::vector<int> locked_directions(const Joint& joint) {
  std::vector<double> q(std::max(joint.n_p(), 1));
  joint.reference(q.data());
  MotionMatrix S(6, joint.n_v());
  joint.motion(q.data(), S);
  std::vector<int> locked;
  for (int k = 0; k < 6; ++k)
    if (S.row(k).isZero(1e-12)) locked.push_back(k);
  return locked;
}

MatrixXd held_directions(const Nodes& nodes, const MechanismDescription& d, const JointDescription& joint,
                         int body) {
  const MarkerDescription& marker = d.markers[marker_on(d, joint, body)];
  const MatrixXd all = marker_loads(nodes, marker);
  const std::vector<int> locked = locked_directions(*joint.joint);
  MatrixXd held(all.rows(), locked.size());
  for (std::size_t k = 0; k < locked.size(); ++k) held.col(k) = all.col(locked[k]);
  return held;
}

/// Where the joints hold a body: at most six of the directions that they lock, independent for a rigid body,
/// displacements before rotations, in the order of the file.
MatrixXd held_by_joints(const superelement::Superelement& se, const Nodes& nodes,
                        const MechanismDescription& d, int body) {
  const MatrixXd R = superelement::rigid_motions(se);
  // As a rigid body of about its own size sees them: lengths count like radians.
  double size = 0.0;
  for (const superelement::Interface& a : se.interfaces)
    for (const superelement::Interface& b : se.interfaces)
      size = std::max(size, (a.p_BoN_B - b.p_BoN_B).norm());
  if (!(size > 0.0)) size = 1.0;
  MatrixXd held(se.n(), 0);
  std::vector<Vector6d> basis;
  for (const bool displacements : {true, false})
    for (const JointDescription& joint : d.joints) {
      const int marker = marker_on(d, joint, body);
      if (marker < 0 || node_of(d.markers[marker]) < 0) continue;
      const MatrixXd all = marker_loads(nodes, d.markers[marker]);
      for (const int k : locked_directions(*joint.joint)) {
        if ((k >= 3) != displacements) continue;
        Vector6d row = R.transpose() * all.col(k);
        row.tail<3>() /= size;  // columns of R: translations, then rotations
        row.normalize();
        for (int pass = 0; pass < 2; ++pass)
          for (const Vector6d& q : basis) row -= q.dot(row) * q;
        if (row.norm() < 1e-3) continue;  // a frame must not hang on nearly parallel directions
        basis.push_back(row.normalized());
        held.conservativeResize(Eigen::NoChange, held.cols() + 1);
        held.rightCols<1>() = all.col(k);
      }
    }
  return held;
}

/// Loads that what acts on the node can put on it: all six, less the torques of a joint that turns freely
/// there, where nothing else acts.
MatrixXd loads_on(const Nodes& nodes, const MechanismDescription& d, int body, int node) {
  const JointDescription* only = nullptr;
  int acting = 0;
  bool drives_or_joint_forces = false;
  for (const JointDescription& joint : d.joints) {
    const int marker = marker_on(d, joint, body);
    if (marker < 0 || node_of(d.markers[marker]) != node) continue;
    ++acting;
    only = &joint;
    drives_or_joint_forces = !joint.drives.empty();
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    // Forces without markers act on joint coordinates.
    if (from < 0 && to < 0) drives_or_joint_forces = true;
    for (const int marker : {from, to})
      if (marker >= 0 && d.markers[marker].body == body && node_of(d.markers[marker]) == node) acting += 2;
  }
  for (const auto& constraint : d.constraints)
    if (const auto* relative = dynamic_cast<const RelativeConstraint*>(constraint.get()))
      for (const int marker : {relative->marker_F(), relative->marker_M()})
        if (d.markers[marker].body == body && node_of(d.markers[marker]) == node) acting += 2;
  const std::set<std::string_view> turning = {"revolute", "cylindrical", "spherical"};
  if (acting != 1 || drives_or_joint_forces || !only || !turning.contains(only->joint->type()))
    return node_loads(nodes[node]);
  const MatrixXd all = marker_loads(nodes, d.markers[marker_on(d, *only, body)]);
  if (only->joint->type() == "spherical") return all.rightCols(3);
  MatrixXd loads(all.rows(), 5);  // z is the axis; along it a cylindrical joint slides, perhaps with friction
  loads << all.leftCols(2), all.rightCols(3);
  return loads;
}

DampingLaw damping_law(const Section& s) {
  DampingLaw law;
  if (s.has("damping")) law.ratio = s.quantity("damping");
  if (s.has("damping_by_mode")) law.by_mode = s.quantities("damping_by_mode");
  if (s.has("damping_frequencies") != s.has("damping_ratios"))
    s.refuse(s.has("damping_ratios") ? "damping_ratios" : "damping_frequencies",
             "damping_frequencies and damping_ratios make a table together", "give both");
  if (s.has("damping_ratios")) {
    law.table_hz = s.quantities("damping_frequencies");
    law.table = s.quantities("damping_ratios");
    if (law.table.size() != law.table_hz.size() || law.table.empty())
      s.refuse("damping_ratios",
               fmt::format("has {} entries for {} frequencies", law.table.size(), law.table_hz.size()),
               "give one ratio for each frequency");
  }
  if (s.has("rayleigh_alpha") || s.has("rayleigh_beta"))
    law.rayleigh = Eigen::Vector2d(s.has("rayleigh_alpha") ? s.quantity("rayleigh_alpha") : 0.0,
                                   s.has("rayleigh_beta") ? s.quantity("rayleigh_beta") : 0.0);
  const int laws =
      law.ratio.has_value() + !law.by_mode.empty() + !law.table.empty() + law.rayleigh.has_value();
  if (laws > 1)
    s.refuse("", "has more than one damping law",
             "keep one of damping, damping_by_mode, damping_frequencies, rayleigh_*");
  if (s.has("critical_above")) law.critical_above = s.quantity("critical_above");
  return law;
}

}  // namespace

std::vector<input::Key> flexible_body_keys() {
  using namespace input;
  TableSchema point;
  point.name = "stress_point";
  point.doc = "A place whose stresses are stored: the nearest one with stress modes.";
  point.keys = {vector3("position", dim::length, "in the undeformed body").required()};
  return {
      text("superelement", "file made by flexura reduce, beside this one"),
      choice(
          "fidelity", {"modal", "modal-stiffened", "ked", "static", "rigid", "ancf", "segments", "auto"},
          "of a superelement: modal, with geometric stiffening, one-way (the motion is that of the rigid "
          "body), quasi-static, or without deformation; of a beam: absolute nodal coordinates for any "
          "bending, rigid segments joined by its stiffness, or rigid; auto: flexura simulate chooses among "
          "rigid, static, modal and modal-stiffened, and the number of modes, of a beam between rigid and "
          "ancf, for the run's accuracy (see solver.accuracy; 1 % without it)")
          .or_default("modal"),
      integer("modes", "keep at most so many eigenmodes, lowest first; without it all").at_least(1),
      quantity("max_frequency", dim::frequency, "keep no eigenmode above").above(0.0),
      choice("coupling", {"full", "partial", "constant"},
             "inertia coupling of deformation and motion: all terms; without second-order terms of the "
             "deformation; mass matrix of the undeformed body, no centrifugal loads")
          .or_default("full"),
      choice("attachments", {"used", "all", "none"},
             "response modes beside truncated eigenmodes: for the interfaces that joints, constraints and "
             "forces act on, for all, or none; without it none, for fidelity static used"),
      quantity("response_frequency", dim::frequency, "at which the response modes are taken; 0: static")
          .or_default("0")
          .at_least(0.0),
      choice(
          "frame", {"mean_axis", "joint_fixed", "joints"},
          "the body's frame: without momentum of the deformation; fixed to the interface of the first joint "
          "that leads to the body; or where its joints hold it (six of the directions that they lock, "
          "displacements first: the line between two pins). Without it mean_axis, for a one-way body "
          "joint_fixed on a single joint and joints on several"),
      choice(
          "boundary", {"free", "joint"},
          "eigenmodes of the free body, or held as that joint holds it; without it joint for a joint_fixed "
          "frame (modes of a frame held by the joints are held there)"),
      quantity("damping", dim::none, "damping ratio of all modes; without any law the superelement's")
          .at_least(0.0),
      quantities("damping_by_mode", dim::none, "ratios of mode 1, 2, ...; the last one also of all above"),
      quantities("damping_frequencies", dim::frequency, "of a table of damping ratios, linear between"),
      quantities("damping_ratios", dim::none, "at these frequencies"),
      quantity("rayleigh_alpha", dim::frequency, "Rayleigh damping alpha M + beta K: alpha [1/s]")
          .at_least(0.0),
      quantity("rayleigh_beta", dim::time, "beta [s]").at_least(0.0),
      quantity(
          "critical_above", dim::frequency,
          "modes from here on are damped critically: they follow their loads without ringing; without it "
          "the response modes above the eigenmodes")
          .above(0.0),
      flag("stress", "von Mises stress on the surface at every output step; needs stress modes")
          .or_default("false"),
      table_map("stress_point", point, "places whose stresses are stored"),
  };
}

std::string fidelity_of(const Section& s) {
  const std::string word = s.text("fidelity");
  if (word != "auto") return word;
  return s.has("beam") && !s.has("superelement") ? "ancf" : "modal";
}

bool wants_stress(const Section& s) {
  return s.flag("stress") || !s.table_map("stress_point").empty();
}

std::shared_ptr<const StressField> read_stress_field(const Section& s, const superelement::Superelement& se,
                                                     const FlexibleBody& body) {
  if (!se.stress || se.surface.vertices.rows() == 0)
    s.refuse("stress", "the superelement has no stress modes",
             "reduce the part again with [recovery] stress = true");
  const std::vector<std::int32_t>& vertices = se.stress->vertices;
  Eigen::Matrix3Xd x(3, vertices.size());
  for (std::size_t k = 0; k < vertices.size(); ++k)
    x.col(k) = se.surface.vertices.row(vertices[k]).transpose();
  auto field = std::make_shared<StressField>(
      se.stress->S, std::move(x), std::vector<int>(vertices.begin(), vertices.end()), body.data().Y);
  for (const auto& [name, point] : s.table_map("stress_point"))
    field->add_point(name, point.vector3("position"));
  return field;
}

std::vector<int> loaded_nodes(const MechanismDescription& d, int body) {
  std::set<int> found;
  const auto take = [&](int marker) {
    if (marker >= 0 && d.markers[marker].body == body && node_of(d.markers[marker]) >= 0)
      found.insert(node_of(d.markers[marker]));
  };
  for (const JointDescription& joint : d.joints) {
    if (joint.joint->type() == "six_dof") continue;  // carries no load
    take(joint.marker_F);
    take(joint.marker_M);
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    take(from);
    take(to);
  }
  for (const auto& constraint : d.constraints)
    if (const auto* relative = dynamic_cast<const RelativeConstraint*>(constraint.get())) {
      take(relative->marker_F());
      take(relative->marker_M());
    }
  return {found.begin(), found.end()};
}

std::shared_ptr<const FlexibleBody> prepare_flexible_body(const Section& s,
                                                          const superelement::Superelement& se,
                                                          const std::vector<BodyNode>& linked,
                                                          const MechanismDescription& d, int body,
                                                          std::vector<std::string>& notes) {
  Nodes nodes = interface_nodes(se);
  nodes.insert(nodes.end(), linked.begin(), linked.end());
  const std::string &name = d.bodies[body].name, fidelity = fidelity_of(s);
  BasisOptions options;
  options.nodes = linked;
  options.damping_law = damping_law(s);
  options.stiffening = fidelity == "modal-stiffened";
  const std::string coupling = s.text("coupling");
  options.coupling = coupling == "full"      ? Coupling::full
                     : coupling == "partial" ? Coupling::partial
                                             : Coupling::constant;
  if (options.stiffening && options.coupling != Coupling::full)
    s.refuse("coupling", "geometric stiffening needs all inertia coupling",
             "write coupling = \"full\" or fidelity = \"modal\"");
  if (s.has("modes")) options.modes = s.integer("modes");
  if (s.has("max_frequency")) options.max_frequency = s.quantity("max_frequency");
  options.response_frequency = s.quantity("response_frequency");

  // What a single joint holds vibrates as held there; the rigid motion cannot tell a one-way body so.
  const auto joints = std::ranges::count_if(
      d.joints, [&](const JointDescription& joint) { return marker_on(d, joint, body) >= 0; });
  const bool held_by_one = fidelity == "ked" && joints == 1 && frame_joint(d, body) != nullptr;
  const std::string frame = s.has("frame")                    ? s.text("frame")
                            : held_by_one                     ? "joint_fixed"
                            : fidelity == "ked" && joints > 1 ? "joints"
                                                              : "mean_axis";
  const bool joint_fixed = frame == "joint_fixed";
  if (frame == "joints") {
    if (s.has("boundary"))
      s.refuse("boundary", "a frame held by the joints holds the eigenmodes too", "take this key away");
    options.frame = options.held = held_by_joints(se, nodes, d, body);
    const bool is_held = options.held.cols() > 0;
    if (!is_held && s.has("frame"))
      s.refuse("frame", "no joint of this body sits on an interface and locks a direction",
               "let joints' markers stand on interfaces (on = \"INTERFACE\"), or take this key away");
    if (is_held)
      notes.push_back(
          fmt::format("body \"{}\": its joints hold the frame and the eigenmodes in {} directions", name,
                      options.held.cols()));
  }
  const std::string boundary = s.has("boundary") ? s.text("boundary") : joint_fixed ? "joint" : "free";
  if (joint_fixed || boundary == "joint") {
    const JointDescription* joint = frame_joint(d, body);
    const std::string key = joint_fixed ? "frame" : "boundary";
    if (!joint)
      s.refuse(key, "no joint sits on an interface of this body",
               "let a joint's marker stand on an interface (on = \"INTERFACE\"), or take this key away");
    const MarkerDescription& marker = d.markers[marker_on(d, *joint, body)];
    const int node = node_of(marker);
    if (joint_fixed && node < static_cast<int>(se.interfaces.size()))
      options.fixed_interface = node;
    else if (joint_fixed)
      options.frame = node_loads(nodes[node]);
    if (boundary == "joint") options.held = held_directions(nodes, d, *joint, body);
    notes.push_back(
        fmt::format("body \"{}\": joint \"{}\" on {} \"{}\" gives {}", name, joint->name,
                    node < static_cast<int>(se.interfaces.size()) ? "interface" : "marker", nodes[node].name,
                    joint_fixed && boundary == "joint" ? "the frame and the eigenmodes' boundary condition"
                    : joint_fixed                      ? "the frame"
                                                       : "the eigenmodes' boundary condition"));
  }

  const std::string attachments = s.has("attachments")   ? s.text("attachments")
                                  : fidelity == "static" ? "used"
                                                         : "none";
  std::vector<int> loaded;
  if (attachments == "all")
    for (std::size_t i = 0; i < nodes.size(); ++i) loaded.push_back(static_cast<int>(i));
  if (attachments == "used") loaded = loaded_nodes(d, body);
  options.loads.resize(se.n(), 0);
  for (const int node : loaded) {
    const MatrixXd more = attachments == "all" ? node_loads(nodes[node]) : loads_on(nodes, d, body, node);
    options.loads.conservativeResize(Eigen::NoChange, options.loads.cols() + more.cols());
    options.loads.rightCols(more.cols()) = more;
  }

  if (fidelity == "static") {
    for (const char* key : {"modes", "max_frequency"})
      if (s.has(key)) s.refuse(key, "fidelity \"static\" takes no eigenmodes", "take the key away");
    if (options.loads.cols() == 0)
      s.refuse("fidelity", "nothing acts on an interface of this body, so nothing deforms it statically",
               "use fidelity = \"rigid\"");
    options.modes = 0;
    options.coupling = Coupling::constant;
    options.damping_law.critical_above = std::min(options.damping_law.critical_above, 0.0);
  }

  BasisReport report;
  std::shared_ptr<const FlexibleBody> flexible;
  try {
    ModalData data = modal_data(se, options, &report);
    if (report.responses > 0 && !s.has("critical_above") && fidelity != "static") {
      options.damping_law.critical_above = report.eigen_hz.back() * (1.0 + 1e-6);
      data.damping = modal_damping(options.damping_law, data.stiffness, data.damping);
    }
    flexible = std::make_shared<FlexibleBody>(std::move(data));
  } catch (const std::invalid_argument& error) {
    throw input::InputError(s.where("superelement") + ": " + error.what());
  }
  if (fidelity == "static") {
    notes.push_back(
        fmt::format("body \"{}\" follows its loads by {} static response modes", name, report.responses));
  } else if (report.kept < report.available) {
    std::string note =
        fmt::format("body \"{}\" keeps {} of {} modes, up to {:.6g} Hz (the next has {:.6g} Hz)", name,
                    report.kept, report.available, report.eigen_hz.back(), report.first_dropped_hz);
    if (report.responses > 0)
      note += fmt::format(", and {} response modes up to {:.6g} Hz for the interfaces in use",
                          report.responses, report.highest_hz);
    else
      note +=
          ": it is stiffer under loads at its interfaces than its superelement (attachments = \"used\" "
          "mends that)";
    notes.push_back(note);
  }
  return flexible;
}

}  // namespace flexura::mbs
