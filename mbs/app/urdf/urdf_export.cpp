// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/urdf/urdf_export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "mbs/app/urdf/urdf_words.hpp"
#include "mbs/base/math/rotation.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/body_shapes.hpp"

namespace flexura::app {
namespace {

using mbs::Matrix3d;
using mbs::Pose;
using mbs::Vector3d;
using mbs::Vector6d;

std::string numbers(const Vector3d& v) {
  // No -0, and what is round-off of a turn is nothing.
  const auto one = [](double x) { return fmt::format("{}", std::abs(x) < 1e-16 ? 0.0 : x); };
  return fmt::format("{} {} {}", one(v.x()), one(v.y()), one(v.z()));
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

// R = R_z(yaw) R_y(pitch) R_x(roll).  Roll is taken of what is left of R after the yaw: right near pitch = 90 degrees too.
Vector3d roll_pitch_yaw(const Matrix3d& R) {
  const double yaw = std::hypot(R(0, 0), R(1, 0)) > 1e-12 ? std::atan2(R(1, 0), R(0, 0)) : 0.0;
  const double s = std::sin(yaw), c = std::cos(yaw);
  return {std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1)),
          std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0)), yaw};
}

std::string origin(const Pose& X) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers(X.p), numbers(roll_pitch_yaw(X.R)));
}

/// A turn about an axis or a slide along it.
struct Step {
  Vector3d axis;
  bool turns = false;
  std::string coordinate;
  int index = 0;  ///< of the coordinate in the joint
};

Pose moved(const Step& step, double q) {
  if (step.turns) return {Eigen::AngleAxisd(q, step.axis).toRotationMatrix(), Vector3d::Zero()};
  return {Matrix3d::Identity(), q * step.axis};
}

/// The joint as turns and slides one after the other from the pose X_FM(0); nothing where it is none.
std::optional<std::vector<Step>> steps_of(const mbs::Joint& joint, const Pose& X_0) {
  const auto n = static_cast<std::size_t>(joint.n_v());
  if (joint.n_p() != joint.n_v()) return std::nullopt;
  std::vector<double> q(n, 0.0);
  mbs::MotionMatrix S(6, joint.n_v());
  joint.motion(q.data(), S);
  std::vector<Step> steps;
  for (std::size_t k = 0; k < n; ++k) {
    // Velocities of M's origin, expressed in F; the steps move M in its own frame at the start.
    const Vector6d s = S.col(static_cast<Eigen::Index>(k));
    const Vector3d w = X_0.R.transpose() * s.head<3>(), v = X_0.R.transpose() * s.tail<3>();
    const bool turns = v.norm() < 1e-12;
    if (!turns && w.norm() > 1e-12) return std::nullopt;
    const Vector3d axis = turns ? w : v;
    if (std::abs(axis.norm() - 1.0) > 1e-9) return std::nullopt;
    steps.push_back({axis, turns, joint.coordinates()[k].name, static_cast<int>(k)});
  }
  // The order in which they give the joint's pose at coordinates of no special kind.
  constexpr std::array samples = {0.3, -0.7, 0.45};
  if (n > samples.size()) return std::nullopt;
  for (std::size_t k = 0; k < n; ++k) q[k] = samples[k];
  const Pose wanted = joint.pose(q.data());
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  do {
    Pose X = X_0;
    for (const std::size_t k : order) X = X * moved(steps[k], q[k]);
    if ((X.R - wanted.R).norm() + (X.p - wanted.p).norm() > 1e-12) continue;
    std::vector<Step> sorted;
    for (const std::size_t k : order) sorted.push_back(steps[k]);
    return sorted;
  } while (std::ranges::next_permutation(order).found);
  return std::nullopt;
}

std::string stl_of(const superelement::Surface& surface, const Pose& X_LB) {
  std::string out(80, ' ');
  const auto put = [&](const auto& value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    out.append(bytes, sizeof value);
  };
  put(static_cast<std::uint32_t>(surface.triangles.rows()));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Vector3d, 3> x;
    for (Eigen::Index k = 0; k < 3; ++k)
      x[static_cast<std::size_t>(k)] =
          X_LB * Vector3d(surface.vertices.row(surface.triangles(t, k)).transpose().cast<double>());
    const Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]).stableNormalized();
    for (const Vector3d& v : {normal, x[0], x[1], x[2]})
      for (const double value : v) put(static_cast<float>(value));
    put(std::uint16_t{0});
  }
  return out;
}

class Writer {
 public:
  Writer(const mbs::Mechanism& mechanism, std::string meshes)
      : m_(mechanism), d_(mechanism.description()), folder_(std::move(meshes)), words_(d_) {}

  Urdf write() {
    refuse_what_has_no_word();
    frames_.resize(d_.bodies.size());
    const auto n = static_cast<int>(d_.joints.size());
    for (int j = 0; j < n; ++j) {
      const mbs::JointDescription& joint = d_.joints[static_cast<std::size_t>(j)];
      const int child = child_marker(j);
      frames_[static_cast<std::size_t>(d_.markers[static_cast<std::size_t>(child)].body)] =
          d_.undeformed(child);
      if (!joint.initial_coordinates.empty()) starts_.push_back(joint.name);
    }
    result_.text = fmt::format(
        "<?xml version=\"1.0\"?>\n<!-- written by flexura export; SI units -->\n<robot name=\"{}\">\n",
        escaped(d_.name.empty() ? "mechanism" : d_.name));
    for (std::size_t body = 0; body < d_.bodies.size(); ++body) add_link(body);
    for (int j = 0; j < n; ++j) add_joint(j);
    result_.text += "</robot>\n";
    add_notes();
    return std::move(result_);
  }

 private:
  void refuse_what_has_no_word() const {
    for (std::size_t j = 0; j < d_.joints.size(); ++j)
      if (!m_.in_tree(static_cast<int>(j)))
        throw std::invalid_argument(
            fmt::format("joint \"{}\" closes a loop, and a URDF is a tree: take a joint of the loop away",
                        d_.joints[j].name));
  }

  int child_marker(int j) const {
    const mbs::JointDescription& joint = d_.joints[static_cast<std::size_t>(j)];
    return m_.is_reversed(j) ? joint.marker_F : joint.marker_M;
  }
  int parent_marker(int j) const {
    const mbs::JointDescription& joint = d_.joints[static_cast<std::size_t>(j)];
    return m_.is_reversed(j) ? joint.marker_M : joint.marker_F;
  }
  std::string link_name(int body) const {
    return body == 0 ? "world" : escaped(d_.bodies[static_cast<std::size_t>(body)].name);
  }

  void add_link(std::size_t i) {
    const mbs::BodyDescription& body = d_.bodies[i];
    if (i > 0 && body.name == "world")
      throw std::invalid_argument(
          "a body is called \"world\", which is the ground's name in a URDF: give it another");
    const Pose X_LB = frames_[i].inverse();
    result_.text += fmt::format("  <link name=\"{}\">\n", link_name(static_cast<int>(i)));
    const mbs::RigidInertia inertia = body.flexible ? body.flexible->undeformed_inertia() : body.inertia;
    if (i > 0 && inertia.mass > 0.0) {
      const Vector3d c = inertia.mass_center / inertia.mass;
      const Matrix3d about_c =
          inertia.inertia - inertia.mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
      const Matrix3d I = X_LB.R * about_c * X_LB.R.transpose();
      result_.text += fmt::format(
          "    <inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" "
          "ixy=\"{}\" ixz=\"{}\" "
          "iyz=\"{}\"/></inertial>\n",
          numbers(X_LB * c), inertia.mass, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    }
    if (body.flexible && body.flexible->m() > 0) rigid_.push_back(body.name);
    for (const auto& shape : view::parse_body_shapes(body.name, body.shape_json)) add_shape(shape, X_LB);
    if (!body.superelement.empty()) add_mesh(body, X_LB);
    result_.text += "  </link>\n";
  }

  static Vector3d vector(const nlohmann::json& list) {
    return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
  }

  void add_shape(const nlohmann::json& shape, const Pose& X_LB) {
    const std::string type = shape.at("type");
    Pose X;
    std::string geometry;
    if (type == "cylinder") {
      X = {mbs::frame_along(vector(shape.at("axis"))), vector(shape.at("position"))};
      geometry = fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", shape.at("radius").get<double>(),
                             shape.at("length").get<double>());
    } else if (type == "sphere") {
      X.p = vector(shape.at("position"));
      geometry = fmt::format("<sphere radius=\"{}\"/>", shape.at("radius").get<double>());
    } else if (type == "box") {
      const auto& q = shape.at("rotation");
      X = {Eigen::Quaterniond(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>())
               .normalized()
               .toRotationMatrix(),
           vector(shape.at("position"))};
      geometry = fmt::format("<box size=\"{}\"/>", numbers(vector(shape.at("size"))));
    } else {
      shapes_.push_back(type);
      return;
    }
    result_.text +=
        fmt::format("    <visual>{}<geometry>{}</geometry></visual>\n", origin(X_LB * X), geometry);
  }

  void add_mesh(const mbs::BodyDescription& body, const Pose& X_LB) {
    superelement::Parts parts;
    parts.matrices = parts.inertia = false;
    parts.surface = true;
    const superelement::Superelement se = superelement::read(body.superelement, parts);
    if (se.surface.triangles.rows() == 0) return;
    const std::string name = body.name + ".stl";
    result_.meshes.emplace_back(name, stl_of(se.surface, X_LB));
    result_.text += fmt::format("    <visual><geometry><mesh filename=\"{}/{}\"/></geometry></visual>\n",
                                escaped(folder_), escaped(name));
  }

  void add_joint(int j) {
    const mbs::JointDescription& joint = d_.joints[static_cast<std::size_t>(j)];
    joint_ = j;
    const auto& from = d_.markers[static_cast<std::size_t>(parent_marker(j))];
    const auto& to = d_.markers[static_cast<std::size_t>(child_marker(j))];
    const bool reversed = m_.is_reversed(j);
    Pose X = frames_[static_cast<std::size_t>(from.body)].inverse() * d_.undeformed(parent_marker(j));
    if (joint.joint->n_v() == 6) {
      put_joint(joint.name, "floating", link_name(from.body), link_name(to.body), X, nullptr);
      return;
    }
    std::vector<double> q(static_cast<std::size_t>(joint.joint->n_p()), 0.0);
    joint.joint->reference(q.data());
    const Pose X_0 = joint.joint->pose(q.data());
    auto steps = steps_of(*joint.joint, X_0);
    if (!steps)
      throw std::invalid_argument(fmt::format(
          "joint \"{}\" ({}): a URDF turns about one axis or slides along one; make it of such joints",
          joint.name, joint.joint->type()));
    if (reversed) {
      // (X_0 E_1 ... E_n)^-1 = E_n(-q) ... E_1(-q) X_0^-1, and E(-q) is the step along -axis; X_0 to the left of all: in its axes.
      std::ranges::reverse(*steps);
      for (Step& step : *steps) step.axis = -(X_0.R * step.axis);
    }
    X = X * (reversed ? X_0.inverse() : X_0);
    if (steps->empty()) {
      put_joint(joint.name, "fixed", link_name(from.body), link_name(to.body), X, nullptr);
      return;
    }
    std::string parent = link_name(from.body);
    for (std::size_t k = 0; k < steps->size(); ++k) {
      const Step& step = (*steps)[k];
      const bool last = k + 1 == steps->size();
      const std::string name = name_of(j, step.index);
      const std::string child = last ? link_name(to.body) : escaped(name) + "_moved";
      if (!last) result_.text += fmt::format("  <link name=\"{}\"/>\n", child);
      put_joint(name, step.turns ? (is_limited(step) ? "revolute" : "continuous") : "prismatic", parent,
                child, X, &step);
      X = {};
      parent = child;
    }
  }

  void put_joint(const std::string& name, const char* type, const std::string& parent,
                 const std::string& child, const Pose& X, const Step* step) {
    result_.text += fmt::format(
        "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>\n    {}\n",
        escaped(name), type, parent, child, origin(X));
    if (step != nullptr) {
      result_.text += fmt::format("    <axis xyz=\"{}\"/>\n", numbers(step->axis));
      add_limit(*step, name);
      add_dynamics(*step);
    }
    result_.text += "  </joint>\n";
  }

  std::string name_of(int j, int coordinate) const {
    const mbs::JointDescription& joint = d_.joints[static_cast<std::size_t>(j)];
    return joint.joint->n_v() == 1
               ? joint.name
               : joint.name + "_" + joint.joint->coordinates()[static_cast<std::size_t>(coordinate)].name;
  }

  static bool is_end(double x) { return std::abs(x) < kNoEnd; }
  bool is_limited(const Step& step) const {
    const mbs::JointWords* const words = words_.of({joint_, step.index});
    return words && (is_end(words->lower) || is_end(words->upper));
  }

  void add_limit(const Step& step, const std::string& name) {
    if (!is_limited(step)) {
      // A slide needs limits in a URDF; these are none.
      if (step.turns) return;
      slides_.push_back(name);
      result_.text += "    <limit lower=\"-1000\" upper=\"1000\" effort=\"1e9\" velocity=\"1e6\"/>\n";
      return;
    }
    const mbs::JointWords& words = *words_.of({joint_, step.index});
    const double lower = is_end(words.lower) ? words.lower : -1000.0,
                 upper = is_end(words.upper) ? words.upper : 1000.0;
    // An import gives the stop the stiffness that yields by a hundredth of the travel under the effort: its inverse.
    result_.text += fmt::format("    <limit lower=\"{}\" upper=\"{}\" effort=\"{}\" velocity=\"1e6\"/>\n",
                                lower, upper, 0.01 * (upper - lower) * words.stiffness);
    limited_.push_back(name);
  }

  void add_dynamics(const Step& step) {
    const mbs::JointWords* const words = words_.of({joint_, step.index});
    if (words && (words->damping != 0.0 || words->friction != 0.0))
      result_.text +=
          fmt::format("    <dynamics damping=\"{}\" friction=\"{}\"/>\n", words->damping, words->friction);
    if (const mbs::MimicWords* const mimic = words_.mimic({joint_, step.index}))
      result_.text +=
          fmt::format("    <mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                      escaped(name_of(mimic->of.joint, mimic->of.index)), mimic->multiplier, mimic->offset);
  }

  void add_notes() {
    const auto say = [&](const std::vector<std::string>& names, const char* what) {
      if (!names.empty()) result_.notes.push_back(fmt::format("{}: {}", fmt::join(names, ", "), what));
    };
    say(rigid_, "written as rigid, a URDF has no deformation");
    say(words_.left_out(), "a URDF has no word for these forces, and they are not written");
    say(words_.driven(), "the drive is not written, joints of a URDF move freely");
    say(limited_,
        "a URDF has no stiffness of limits: their effort is what presses the stop by 1 % of the travel, "
        "their "
        "velocity (1e6) stands for none");
    say(starts_, "the start is not written, a URDF starts where coordinates are 0");
    say(slides_, "limits of 1000 m stand for none, which a URDF has not");
    say(shapes_, "shapes without a like in a URDF are left out");
  }

  const mbs::Mechanism& m_;
  const mbs::MechanismDescription& d_;
  // Ends of travel beyond this are none (a bump stop with one end).
  static constexpr double kNoEnd = 1e11;

  const std::string folder_;
  const UrdfWords words_;
  int joint_ = -1;            ///< that is being written
  std::vector<Pose> frames_;  ///< X_BL of every link in its body
  std::vector<std::string> rigid_, starts_, slides_, limited_, shapes_;
  Urdf result_;
};

}  // namespace

Urdf to_urdf(const mbs::Mechanism& mechanism, const std::string& meshes) {
  return Writer(mechanism, meshes).write();
}

}  // namespace flexura::app
