// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/convert.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <stdexcept>

#include "import/model/folder.hpp"
#include "import/urdf/mesh_file.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::urdf {
namespace {

// A stop that the joint, with all that it carries, bounces on with this frequency and damping ratio; at its greatest effort it
// gives way by this part of its travel at most.
constexpr double kStopFrequency_hz = 20.0, kStopDampingRatio = 0.3, kStopYield = 0.01;

// Of all pictures: many links can show one file.
constexpr std::size_t kMostTriangles = 10'000'000;

bool has_one_coordinate(const Joint& joint) {
  return joint.kind == JointKind::revolute || joint.kind == JointKind::continuous ||
         joint.kind == JointKind::prismatic;
}

bool turns(const Joint& joint) {
  return joint.kind == JointKind::revolute || joint.kind == JointKind::continuous;
}

bool is_step(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".step" || ending == ".stp";
}

class Converter {
 public:
  Converter(const Robot& robot, const Choices& choices) : robot_(robot), choices_(choices) {}

  Mechanism convert() {
    q_ = start_coordinates(robot_);
    H_ = start_mass_matrix(robot_, q_, joint_of_);
    require_inertia();
    result_.name = robot_.name;
    result_.notes = robot_.notes;
    result_.comments = {
        "imported by flexura import from " + shown(robot_.file.filename().string()),
        "Bodies have the frames of the links; the coordinates of the joints are those of the URDF."};
    for (const Link& link : robot_.links) add_body(link);
    add_base();
    // Names of bodies and joints are kept apart: both stand in the names of results.
    for (const Joint& joint : robot_.joints) joint_names_.push_back(names_.add(joint.name));
    for (const int j : robot_.order) add_joint(static_cast<std::size_t>(j));
    for (const int j : robot_.order) add_forces(static_cast<std::size_t>(j));
    for (const Transmission& transmission : robot_.transmissions) add_actuator(transmission);
    return std::move(result_);
  }

 private:
  // The coordinates that mimic others are not free: H in those that are must be positive definite.  Scaled to
  // a unit diagonal; a rank that is missing leaves a pivot of round-off, n 1e-16, against which 1e-10 is wide:
  // a robot's lightest link turns with 1e-6 or more of what hangs on its joint.
  void require_inertia() const {
    std::vector<Eigen::Index> free;
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(H_.rows(), H_.cols());
    for (Eigen::Index i = 0; i < H_.rows(); ++i) {
      double factor = 1.0;
      int joint = joint_of_[static_cast<std::size_t>(i)];
      while (robot_.joints[static_cast<std::size_t>(joint)].mimic) {
        const Mimic& mimic = *robot_.joints[static_cast<std::size_t>(joint)].mimic;
        factor *= mimic.multiplier;
        joint = mimic.joint;
      }
      if (joint == joint_of_[static_cast<std::size_t>(i)]) {
        free.push_back(i);
        T(i, i) = 1.0;
      } else {
        const auto leader = std::ranges::find(joint_of_, joint) - joint_of_.begin();
        T(i, leader) = factor;
      }
    }
    const Eigen::MatrixXd reduced = (T.transpose() * H_ * T)(free, free);
    const auto refuse = [&](Eigen::Index i, const char* what) {
      const Joint& joint = robot_.joints[static_cast<std::size_t>(
          joint_of_[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])])];
      throw std::invalid_argument(
          fmt::format("{}:{}: joint \"{}\" {}, so its acceleration would be anything; give the links behind "
                      "it <inertial>, or make the joint fixed",
                      robot_.file.string(), joint.line, shown(joint.name), what));
    };
    Eigen::MatrixXd L = reduced;
    for (Eigen::Index i = 0; i < L.rows(); ++i)
      if (!(reduced(i, i) > 0.0)) refuse(i, "moves links without inertia");
    const Eigen::VectorXd scale = reduced.diagonal().cwiseSqrt().cwiseInverse();
    L = scale.asDiagonal() * reduced * scale.asDiagonal();
    for (Eigen::Index k = 0; k < L.rows(); ++k) {  // Cholesky, column by column
      if (!(L(k, k) > 1e-10))
        refuse(k, "moves links that have no inertia apart from the joints before it, at the start position");
      L.col(k).tail(L.rows() - k) /= std::sqrt(L(k, k));
      for (Eigen::Index j = k + 1; j < L.rows(); ++j)
        L.col(j).tail(L.rows() - j) -= L(j, k) * L.col(k).tail(L.rows() - j);
    }
  }

  void add_body(const Link& link) {
    Body body;
    body.name = names_.add(link.name);
    if (body.name != link.name) body.comments.push_back("link \"" + shown(link.name) + "\"");
    if (link.inertial) {
      body.mass = link.inertial->mass;
      body.center = link.inertial->center;
      body.inertia = link.inertial->inertia;
    }
    draw(link, body);
    result_.bodies.push_back(std::move(body));
  }

  // Boxes that are turned in the link, meshes: triangles, which a rigid superelement carries.  Without those,
  // the mechanism file's own solids.
  void draw(const Link& link, Body& body) {
    const auto is_plain = [](const Visual& v) {
      return v.kind == Visual::Kind::cylinder || v.kind == Visual::Kind::sphere ||
             (v.kind == Visual::Kind::box && (v.X_LV.R - Matrix3d::Identity()).isZero(0.0));
    };
    for (const Visual& visual : link.visuals) {
      if (is_plain(visual)) {
        body.shapes.push_back(shape_lines(visual));
        continue;
      }
      if (!(body.mass > 0.0)) {
        result_.notes.push_back(
            fmt::format("link \"{}\" has no mass and its mesh no picture: only bodies with mass carry one",
                        shown(link.name)));
        continue;
      }
      if (visual.kind == Visual::Kind::box) {
        body.surface.append(box_surface(visual.size), visual.X_LV);
        continue;
      }
      try {
        // Before another one is read.
        if (n_triangles_ > kMostTriangles)
          throw std::invalid_argument(fmt::format(
              "the pictures before it hold {} triangles, the most that are taken", kMostTriangles));
        const std::filesystem::path file = find_mesh(visual.mesh, robot_.file, choices_.packages);
        Surface mesh = is_step(file) && choices_.read_cad ? choices_.read_cad(file) : read_surface(file);
        for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(visual.size);
        if (visual.size.prod() < 0.0)  // mirrored
          for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
        n_triangles_ += mesh.triangles.size();
        body.surface.append(mesh, visual.X_LV);
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& why) {  // of the file, or of the child that reads CAD files
        result_.notes.push_back(
            fmt::format("link \"{}\" without that picture: {}", shown(link.name), why.what()));
      }
    }
  }

  static std::vector<Line> shape_lines(const Visual& visual) {
    std::vector<Line> lines;
    switch (visual.kind) {
      case Visual::Kind::box:
        lines = {
            {"type", toml(std::string("box"))}, {"center", toml(visual.X_LV.p)}, {"size", toml(visual.size)}};
        break;
      case Visual::Kind::cylinder: {
        const Vector3d half = visual.X_LV.R.col(2) * (0.5 * visual.length);
        lines = {{"type", toml(std::string("cylinder"))},
                 {"from", toml(Vector3d(visual.X_LV.p - half))},
                 {"to", toml(Vector3d(visual.X_LV.p + half))},
                 {"radius", toml(visual.radius)}};
        break;
      }
      default:
        lines = {{"type", toml(std::string("sphere"))},
                 {"center", toml(visual.X_LV.p)},
                 {"radius", toml(visual.radius)}};
    }
    if (!visual.color.empty()) lines.emplace_back("color", toml(visual.color));
    return lines;
  }

  static Surface box_surface(const Vector3d& size) {
    Surface box;
    for (int i = 0; i < 8; ++i)
      box.vertices.emplace_back(size.x() * ((i & 1) - 0.5), size.y() * ((i >> 1 & 1) - 0.5),
                                size.z() * ((i >> 2 & 1) - 0.5));
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
      box.triangles.emplace_back(f[0], f[1], f[2]);
      box.triangles.emplace_back(f[0], f[2], f[3]);
    }
    for (int i = 0; i < 8; ++i)
      for (const int bit : {1, 2, 4})
        if ((i & bit) == 0) box.edges.emplace_back(i, i | bit);
    return box;
  }

  std::string body_name(int link) const { return result_.bodies[static_cast<std::size_t>(link)].name; }

  void add_base() {
    const std::string root = body_name(robot_.root);
    result_.ground.push_back({"base", {}});
    result_.bodies[static_cast<std::size_t>(robot_.root)].markers.push_back({"base", {}});
    result_.elements.push_back(
        {"joint",
         names_.add("base"),
         {choices_.floating_base ? "the root floats free"
                                 : "the root stands on the ground (--base floating frees it)"},
         {{"type", toml(std::string(choices_.floating_base ? "free" : "fixed"))},
          {"from", toml(std::string("ground.base"))},
          {"to", toml(root + ".base")}}});
  }

  void add_joint(std::size_t j) {
    const Joint& joint = robot_.joints[j];
    const std::string& name = joint_names_[j];
    const char* const types[] = {"revolute", "revolute", "prismatic", "fixed", "free", "planar"};
    // The coordinate's axis is the markers' z axis.
    const bool along_axis = joint.kind != JointKind::fixed && joint.kind != JointKind::floating;
    const Pose X_JM{along_axis ? mbs::frame_along(joint.axis) : Matrix3d::Identity(), Vector3d::Zero()};
    result_.bodies[static_cast<std::size_t>(joint.parent)].markers.push_back({name, joint.X_PJ * X_JM});
    result_.bodies[static_cast<std::size_t>(joint.child)].markers.push_back({name, X_JM});
    Element element{"joint", name};
    if (name != joint.name) element.comments.push_back("joint \"" + shown(joint.name) + "\"");
    if (joint.limit && joint.limit->velocity > 0.0)
      element.comments.push_back(
          fmt::format("the URDF's greatest speed, {} {}, is no physical law and not enforced",
                      joint.limit->velocity, turns(joint) ? "rad/s" : "m/s"));
    element.lines = {{"type", toml(std::string(types[static_cast<int>(joint.kind)]))},
                     {"from", toml(body_name(joint.parent) + "." + name)},
                     {"to", toml(body_name(joint.child) + "." + name)}};
    if (q_[j] != 0.0) {
      element.lines.emplace_back(turns(joint) ? "angle" : "position", toml(q_[j]));
      if (!joint.mimic)
        result_.notes.push_back(
            fmt::format("joint \"{}\" starts at its limit {}: 0 is outside", shown(joint.name), q_[j]));
    }
    result_.elements.push_back(std::move(element));
    if (joint.mimic)
      result_.elements.push_back(
          {"constraint",
           names_.add(name + "_mimic"),
           {fmt::format("mimic: {} = {} * {} + {}", name, joint.mimic->multiplier,
                        joint_names_[static_cast<std::size_t>(joint.mimic->joint)], joint.mimic->offset)},
           {{"type", toml(std::string("coupler"))},
            {"joints", fmt::format("[{}, {}]", toml(name),
                                   toml(joint_names_[static_cast<std::size_t>(joint.mimic->joint)]))},
            {"factors", fmt::format("[1.0, {}]", toml(-joint.mimic->multiplier))},
            {"offset", toml(joint.mimic->offset)}}});
  }

  // What is carried along the joint's coordinate at the start, mimicking joints aside [kg or kg m^2].
  double carried(std::size_t j) const {
    const auto at = std::ranges::find(joint_of_, static_cast<int>(j)) - joint_of_.begin();
    return H_(at, at);
  }

  void add_forces(std::size_t j) {
    const Joint& joint = robot_.joints[j];
    if (!has_one_coordinate(joint)) return;
    const std::string& name = joint_names_[j];
    const Line of_joint = {"joint", toml(name)};
    if (joint.friction > 0.0)
      result_.elements.push_back({"force",
                                  names_.add(name + "_friction"),
                                  {},
                                  {{"type", toml(std::string("joint_friction"))},
                                   of_joint,
                                   {"coulomb", toml(joint.friction)},
                                   {"viscous", toml(joint.damping)}}});
    else if (joint.damping > 0.0)
      result_.elements.push_back(
          {"force",
           names_.add(name + "_damping"),
           {},
           {{"type", toml(std::string("joint_spring_damper"))}, of_joint, {"damping", toml(joint.damping)}}});
    // A joint that mimics is held by the one that it mimics.
    if (!choices_.stops || !joint.limit || joint.kind == JointKind::continuous || joint.mimic) return;
    if (joint.limit->lower == joint.limit->upper)
      result_.notes.push_back(
          fmt::format("joint \"{}\" has no travel, lower and upper are both {}: its stops hold it there; "
                      "make it fixed, or "
                      "give its limits",
                      shown(joint.name), joint.limit->lower));
    const double travel = std::max(joint.limit->upper - joint.limit->lower, turns(joint) ? 0.01 : 0.001);
    const double omega = 2.0 * std::numbers::pi * kStopFrequency_hz, inertia = carried(j);
    const double k = std::max(inertia * omega * omega, joint.limit->effort / (kStopYield * travel));
    result_.elements.push_back({"force",
                                names_.add(name + "_stop"),
                                {"stiffness and damping are chosen, the URDF has none: 20 Hz with what the "
                                 "joint carries, damping ratio 0.3, "
                                 "at most 1 % of the travel under its effort"},
                                {{"type", toml(std::string("bump_stop"))},
                                 of_joint,
                                 {"lower", toml(joint.limit->lower)},
                                 {"upper", toml(joint.limit->upper)},
                                 {"stiffness", toml(k)},
                                 {"damping", toml(2.0 * kStopDampingRatio * std::sqrt(k * inertia))}}});
  }

  void add_actuator(const Transmission& transmission) {
    const auto j = static_cast<std::size_t>(transmission.joint);
    const Joint& joint = robot_.joints[j];
    const std::string input = names_.add("u_" + transmission.actuator);
    result_.elements.push_back({"input",
                                input,
                                {fmt::format("effort of actuator \"{}\" [{}]", shown(transmission.actuator),
                                             turns(joint) ? "N m" : "N")},
                                {{"value", "0.0"}}});
    std::string effort = fmt::format("{} * {}", toml(transmission.reduction), input);
    if (joint.limit && joint.limit->effort > 0.0)
      effort =
          fmt::format("max({}, min({}, {}))", toml(-joint.limit->effort), toml(joint.limit->effort), effort);
    result_.elements.push_back({"force",
                                names_.add(joint_names_[j] + "_motor"),
                                {fmt::format("transmission \"{}\"", shown(transmission.name))},
                                {{"type", toml(std::string("joint_force"))},
                                 {"joint", toml(joint_names_[j])},
                                 {"value", toml(effort)}}});
  }

  const Robot& robot_;
  const Choices& choices_;
  Names names_;
  std::vector<std::string> joint_names_;
  std::vector<double> q_;
  Eigen::MatrixXd H_;
  std::size_t n_triangles_ = 0;
  std::vector<int> joint_of_;
  Mechanism result_;
};

}  // namespace

Mechanism to_mechanism(const Robot& robot, const Choices& choices) {
  return Converter(robot, choices).convert();
}

}  // namespace flexura::import::urdf
