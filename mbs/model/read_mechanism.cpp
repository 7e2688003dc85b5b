// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/read_mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "mbs/model/constraints/types.hpp"
#include "mbs/model/controls/types.hpp"
#include "mbs/model/forces/types.hpp"
#include "mbs/model/joints/types.hpp"
#include "mbs/model/modal_basis.hpp"
#include "mbs/model/parameters.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs {
namespace {

using input::Section;

Matrix3d read_rotation(const Section& s) {
  const int given = s.has("axis") + s.has("rotation") + s.has("quaternion");
  if (given > 1) s.refuse("", "has more than one of axis, rotation, quaternion", "keep one");
  if (s.has("x_axis") && !s.has("axis")) s.refuse("x_axis", "goes with axis only", "give the z axis by axis");
  if (s.has("rotation")) return rotation_exp(s.vector3("rotation"));
  if (s.has("quaternion")) {
    const Eigen::Vector4d q = s.quaternion("quaternion");
    return rotation_of_quaternion(q.data());
  }
  if (!s.has("axis")) return Matrix3d::Identity();
  const Vector3d axis = s.vector3("axis");
  if (!(axis.norm() > 0.0)) s.refuse("axis", "has no length", "write for example [0, 0, 1]");
  Matrix3d R = frame_along(axis);
  if (s.has("x_axis")) {
    const Vector3d wanted = s.vector3("x_axis");
    const Vector3d x = wanted - wanted.dot(R.col(2)) * R.col(2);
    if (!(x.norm() > 1e-9 * wanted.norm())) s.refuse("x_axis", "is parallel to axis", "turn it away");
    R.col(0) = x.normalized();
    R.col(1) = R.col(2).cross(R.col(0));
  }
  return R;
}

Pose read_pose(const Section& s) {
  return {read_rotation(s), s.has("position") ? s.vector3("position") : Vector3d::Zero()};
}

/// The body's [[shape]] tables as mbs/view takes them.
std::string shapes_json(const Section& s) {
  nlohmann::json shapes = nlohmann::json::array();
  const auto list = [](const Vector3d& x) { return nlohmann::json{x.x(), x.y(), x.z()}; };
  for (const Section& shape : s.tables("shape")) {
    nlohmann::json j;
    const std::string type = shape.text("type");
    j["type"] = type;
    if (type == "cylinder") {
      const Vector3d from = shape.vector3("from"), to = shape.vector3("to");
      if (!((to - from).norm() > 0.0))
        shape.refuse("to", "is the same point as from", "give the cylinder a length");
      j["position"] = list(0.5 * (from + to));
      j["axis"] = list((to - from).normalized());
      j["length"] = (to - from).norm();
    } else {
      j["position"] = list(shape.vector3("center"));
    }
    if (type == "box") {
      j["size"] = list(shape.vector3("size"));
      j["rotation"] = {1.0, 0.0, 0.0, 0.0};
    } else {
      j["radius"] = shape.quantity("radius");
    }
    if (shape.has("color")) j["color"] = shape.text("color");
    shapes.push_back(std::move(j));
  }
  return shapes.empty() ? "" : shapes.dump();
}

RigidInertia read_inertia(const Section& s) {
  if (!s.has("mass")) s.refuse("", "has neither mass nor superelement", "give one of them");
  const double mass = s.quantity("mass");
  Matrix3d I = Matrix3d::Zero();
  if (s.has("inertia")) {
    const std::vector<double> x = s.quantities("inertia");
    if (x.size() != 3 && x.size() != 6)
      s.refuse("inertia", fmt::format("has {} entries", x.size()),
               "write 3 (Ixx, Iyy, Izz) or 6 (and Ixy, Iyz, Izx)");
    I.diagonal() << x[0], x[1], x[2];
    if (x.size() == 6) {
      I(0, 1) = I(1, 0) = x[3];
      I(1, 2) = I(2, 1) = x[4];
      I(2, 0) = I(0, 2) = x[5];
    }
    // All principal minors: no direction with a negative moment of inertia.
    const double round_off = 1e-12 * I.cwiseAbs().maxCoeff();
    bool possible = I.diagonal().minCoeff() >= 0.0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      possible = possible && I(i, i) * I(j, j) - I(i, j) * I(i, j) >= -round_off * round_off;
    }
    if (!possible || I.determinant() < -round_off * round_off * round_off)
      s.refuse("inertia", "has a negative principal moment", "check the signs and units");
  }
  return RigidInertia::from_center(mass, s.vector3("center"), I);
}

template <class Types>
const auto& find_type(const Types& types, const std::string& name) {
  return *std::ranges::find_if(types, [&](const auto& type) { return type.name == name; });
}

class Reader {
 public:
  Reader(const std::filesystem::path& file, const Section& root) : file_(file), root_(root) {}

  MechanismFile read() {
    MechanismDescription& d = d_;
    d.name = root_.has("name") ? root_.text("name") : file_.stem().string();
    d.gravity = root_.vector3("gravity");
    parameters_ = read_parameters(root_);
    const Section ground = root_.table("ground");
    d.bodies[0].shape_json = shapes_json(ground);
    read_markers(ground, 0, nullptr);
    for (const auto& [name, s] : root_.table_map("body")) read_body(name, s);
    read_joints();
    read_measures_and_forces();

    MechanismFile out{d.name, text_of_file(),    std::move(d_),        {},
                      {},     std::move(notes_), root_.table("solver")};
    out.outputs = root_.table("output").texts("quantities");
    for (const auto& [name, s] : root_.table_map("run")) out.runs.push_back({name, s.texts("set")});
    if (out.runs.empty()) out.runs.push_back({"run", {}});
    return out;
  }

 private:
  std::string text_of_file() const {
    std::ifstream in(file_);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

  void read_markers(const Section& s, int body, const FlexibleBody* flexible) {
    for (const auto& [name, m] : s.table_map("marker")) {
      Pose X = read_pose(m);
      int node = -1;
      for (const MarkerDescription& other : d_.markers)
        if (other.name == d_.bodies[body].name + "." + name)
          m.refuse("", "has the name of an interface of the superelement", "choose another name");
      if (m.has("on")) {
        const std::string interface = m.text("on");
        const auto& interfaces = interfaces_[body];
        const auto found =
            std::ranges::find_if(interfaces, [&](const auto& entry) { return entry.first == interface; });
        if (found == interfaces.end()) {
          std::vector<std::string> known;
          for (const auto& entry : interfaces) known.push_back(entry.first);
          m.refuse("on",
                   fmt::format("the body has no interface \"{}\"{}", interface,
                               input::suggestion(interface, known)),
                   interfaces.empty() ? "only superelements have interfaces" : "");
        }
        if (!m.has("position")) X.p = found->second;
        if (flexible) {
          node = flexible->find_node(interface);
          X.p -= found->second;  // relative to the node
        }
      } else if (flexible) {
        notes_.push_back(
            fmt::format("marker \"{}.{}\" is fixed in the body's floating frame and sees no deformation; "
                        "say on = \"INTERFACE\" to let an interface carry it",
                        d_.bodies[body].name, name));
      }
      d_.add_marker(body, name, X, node);
    }
  }

  void read_body(const std::string& name, const Section& s) {
    if (name == "ground") s.refuse("", "is the name of the world", "choose another name");
    BodyDescription body;
    body.name = name;
    std::vector<std::pair<std::string, Vector3d>> interfaces;
    if (s.has("superelement")) {
      if (s.has("mass")) s.refuse("mass", "a superelement brings its own mass", "take one of the two away");
      superelement::Superelement se;
      const std::filesystem::path path = file_.parent_path() / s.text("superelement");
      try {
        se = superelement::read(path);
      } catch (const std::runtime_error& error) {
        throw input::InputError(s.where("superelement") + ": " + error.what());
      }
      body.superelement = path.string();
      for (const superelement::Interface& i : se.interfaces) interfaces.emplace_back(i.name, i.p_BoN_B);
      if (s.text("fidelity") == "rigid") {
        body.inertia = rigid_inertia(se);
      } else {
        BasisOptions options;
        if (s.has("modes")) options.modes = s.integer("modes");
        if (s.has("max_frequency")) options.max_frequency = s.quantity("max_frequency");
        if (s.has("damping")) options.damping = s.quantity("damping");
        BasisReport report;
        try {
          body.flexible = std::make_shared<FlexibleBody>(modal_data(se, options, &report));
        } catch (const std::invalid_argument& error) {
          throw input::InputError(s.where("superelement") + ": " + error.what());
        }
        if (report.kept < report.available)
          notes_.push_back(
              fmt::format("body \"{}\" keeps {} of {} modes, up to {:.6g} Hz (the next has {:.6g} Hz): it is "
                          "stiffer under loads at "
                          "its interfaces than its superelement",
                          name, report.kept, report.available, report.highest_hz, report.first_dropped_hz));
      }
    } else {
      for (const char* key : {"modes", "max_frequency", "damping"})
        if (s.has(key))
          s.refuse(key, "a rigid body has no modes", "give a superelement or take the key away");
      body.inertia = read_inertia(s);
    }
    if (s.has("position") || s.has("axis") || s.has("rotation") || s.has("quaternion"))
      body.X_WB = read_pose(s);
    body.shape_json = shapes_json(s);
    const std::shared_ptr<const FlexibleBody> flexible = body.flexible;
    const int b = d_.add_body(std::move(body));
    sections_.emplace(b, s);
    for (std::size_t i = 0; i < interfaces.size(); ++i) {
      // The nodes of a flexible body are its interfaces, in their order.
      if (flexible)
        d_.add_marker(b, interfaces[i].first, {}, static_cast<int>(i));
      else
        d_.add_marker(b, interfaces[i].first, {Matrix3d::Identity(), interfaces[i].second});
    }
    interfaces_[b] = std::move(interfaces);
    read_markers(s, b, flexible.get());
  }

  void read_joints() {
    const ReadContext context(d_, parameters_);
    std::set<int> joined;
    for (const auto& [name, s] : root_.table_map("joint")) {
      JointDescription joint;
      joint.name = name;
      const std::string type = s.text("type");
      for (const JointType& t : joint_types())
        if (t.name == type || std::ranges::find(t.synonyms, type) != t.synonyms.end())
          joint.joint = t.make(&s);
      joint.marker_F = context.marker(s, "from");
      joint.marker_M = context.marker(s, "to");
      const int a = d_.markers[joint.marker_F].body, b = d_.markers[joint.marker_M].body;
      if (a == b)
        s.refuse("to",
                 fmt::format("\"{}\" is a marker of the same body as \"{}\"", s.text("to"), s.text("from")),
                 "a joint joins two bodies");
      joined.insert({a, b});
      joint.cut = s.flag("cut");
      const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds();
      for (std::size_t i = 0; i < coordinates.size(); ++i) {
        const int k = static_cast<int>(i);
        if (s.has(coordinates[i].name)) joint.initial_coordinates[k] = s.quantity(coordinates[i].name);
        if (joint.joint->n_p() != joint.joint->n_v()) continue;
        const std::string drive = coordinates.size() == 1 ? "drive" : "drive_" + coordinates[i].name;
        if (!s.has(drive)) continue;
        joint.drives[k] = context.time_expression(s, drive);
        for (const std::string& key : {coordinates[i].name, speeds[i].name})
          if (s.has(key)) s.refuse(key, "the coordinate is driven", "take this key away");
      }
      for (std::size_t i = 0; i < speeds.size(); ++i)
        if (s.has(speeds[i].name)) joint.initial_speeds[static_cast<int>(i)] = s.quantity(speeds[i].name);
      d_.joints.push_back(std::move(joint));
    }
    // Bodies that nothing holds float free.
    for (std::size_t i = 1; i < d_.bodies.size(); ++i) {
      const int b = static_cast<int>(i);
      const Section& s = sections_.at(b);
      const bool moves = s.has("velocity") || s.has("angular_velocity");
      if (joined.contains(b)) {
        if (moves)
          s.refuse(s.has("velocity") ? "velocity" : "angular_velocity", "the body has a joint",
                   "give the joint's speed instead");
        continue;
      }
      const int F = d_.add_marker(0, "origin_of_" + d_.bodies[i].name), M = d_.add_marker(b, "frame");
      const int j = d_.add_joint(d_.bodies[i].name, "six_dof", F, M);
      for (int k = 0; k < 3; ++k) {
        if (s.has("angular_velocity")) d_.joints[j].initial_speeds[k] = s.vector3("angular_velocity")(k);
        if (s.has("velocity")) d_.joints[j].initial_speeds[3 + k] = s.vector3("velocity")(k);
      }
    }
  }

  void read_measures_and_forces() {
    for (const JointDescription& joint : d_.joints) {
      for (const CoordinateInfo& c : joint.joint->coordinates()) d_.signals.add(joint.name + "." + c.name);
      for (const CoordinateInfo& c : joint.joint->speeds()) d_.signals.add(joint.name + "." + c.name);
    }
    const ReadContext context(d_, parameters_);
    for (const auto& [name, s] : root_.table_map("constraint"))
      d_.constraints.push_back(find_type(constraint_types(), s.text("type")).read(name, s, context));
    const auto take_name = [&](const std::string& name, const Section& s) {
      if (name == "t" || name == "pi" || parameters_.contains(name) || d_.signals.find(name) >= 0)
        s.refuse("", "the name is taken already in formulas", "choose another");
      d_.signals.add(name);
    };
    // Outputs of states alone can be read by every formula, measures by those below, the rest by forces.
    const auto controls = root_.table_map("control");
    for (const auto& [name, s] : controls)
      if (!find_type(control_types(), s.text("type")).feeds_through) take_name(name, s);
    for (const auto& [name, s] : root_.table_map("measure")) {
      d_.measures.push_back(find_type(measure_types(), s.text("type")).read(name, s, context));
      take_name(name, s);
    }
    for (const auto& [name, s] : controls) {
      const ControlType& type = find_type(control_types(), s.text("type"));
      d_.controls.push_back(type.read(name, s, context));
      if (type.feeds_through) take_name(name, s);
    }
    for (const auto& [name, s] : root_.table_map("force"))
      d_.forces.push_back(find_type(force_types(), s.text("type")).read(name, s, context));
  }

  std::filesystem::path file_;
  Section root_;
  MechanismDescription d_;
  std::map<std::string, double> parameters_;
  std::map<int, Section> sections_;
  std::map<int, std::vector<std::pair<std::string, Vector3d>>> interfaces_;
  std::vector<std::string> notes_;
};

bool fits(const char* pattern, const char* text) {
  if (*pattern == '\0') return *text == '\0';
  if (*pattern == '*') return fits(pattern + 1, text) || (*text != '\0' && fits(pattern, text + 1));
  return *text != '\0' && (*pattern == '?' || *pattern == *text) && fits(pattern + 1, text + 1);
}

}  // namespace

MechanismFile read_mechanism(const std::filesystem::path& file, const input::TableSchema& solver,
                             const std::vector<std::string>& overrides) {
  const auto formulas = [](const Section& root) { return evaluate_with(read_parameters(root)); };
  return Reader(file, input::read_document(file, mechanism_schema(solver), overrides, formulas)).read();
}

std::vector<int> select_quantities(const Mechanism& mechanism, const std::vector<std::string>& patterns) {
  if (patterns.empty()) return mechanism.usual_quantities();
  const std::vector<OutputInfo> infos = mechanism.quantities();
  std::vector<int> which;
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < infos.size(); ++i) {
      if (!fits(pattern.c_str(), infos[i].name.c_str())) continue;
      any = true;
      if (std::ranges::find(which, static_cast<int>(i)) == which.end()) which.push_back(static_cast<int>(i));
    }
    if (any) continue;
    std::vector<std::string> known;
    for (const OutputInfo& info : infos) known.push_back(info.name);
    const std::string near = input::nearest(pattern, known);
    throw std::invalid_argument(
        fmt::format("there is no quantity \"{}\"{}", pattern,
                    near.empty() ? "; flexura check lists all of them" : ", did you mean \"" + near + "\"?"));
  }
  return which;
}

std::string connections_json(const Mechanism& mechanism) {
  const MechanismDescription& d = mechanism.description();
  nlohmann::json list = nlohmann::json::array();
  const auto pose = [&](int marker) {
    const MarkerDescription& m = d.markers[marker];
    if (m.node < 0) return m.X_BP;
    return Pose{m.X_BP.R, d.bodies[m.body].flexible->data().nodes[m.node].p_BoN_B + m.X_BP.p};
  };
  const auto add = [&](const std::string& name, const std::string& kind, int marker_1, int marker_2) {
    nlohmann::json j{{"name", name}, {"kind", kind}};
    const auto side = [&](int marker, const char* body_key, const char* point_key) {
      if (marker < 0) return;
      const Pose X = pose(marker);
      j[body_key] = d.bodies[d.markers[marker].body].name;
      j[point_key] = {X.p.x(), X.p.y(), X.p.z()};
    };
    side(marker_1, "body_1", "p_1");
    side(marker_2, "body_2", "p_2");
    if (marker_1 >= 0) {
      const Vector3d z = pose(marker_1).R.col(2);
      j["axis_1"] = {z.x(), z.y(), z.z()};
    }
    list.push_back(std::move(j));
  };
  for (const JointDescription& joint : d.joints)
    add(joint.name, std::string(joint.joint->type()), joint.marker_F, joint.marker_M);
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    if (from >= 0 || to >= 0) add(force->name(), std::string(force->type()), from, to);
  }
  return list.dump();
}

}  // namespace flexura::mbs
