// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/scene/scene.hpp"

/// Scenes as files.
namespace flexura::mbs::chance {

namespace {

std::string list(const Vector3d& x, int digits) {
  return fmt::format("[{:.{}g}, {:.{}g}, {:.{}g}]", x.x(), digits, x.y(), digits, x.z(), digits);
}

class Writer {
 public:
  Writer(const Scene& scene, const std::filesystem::path& folder, const Writing& how)
      : s_(scene), folder_(folder), how_(how), places_(scene.places()) {
    for (std::size_t b = 0; s_.start == Start::guess && b < places_.size(); ++b)
      places_[b].X_WB = s_.guess[b];
  }

  std::string text() {
    say("# {}\n", s_.what);
    say("gravity = {}\n", list(how_.length * s_.gravity, 17));
    say("[solver]\nend_time = {:.17g}\noutput_step = {:.17g}\n{}", s_.end_time, s_.output_step, how_.solver);
    for (const int b : order(s_.bodies.size(), how_.bodies_backwards)) write_body(b);
    for (const int j : order(s_.joints.size(), how_.joints_backwards)) write_joint(j);
    for (const int c : order(s_.constraints.size(), how_.bodies_backwards)) write_constraint(c);
    for (const int f : order(s_.forces.size(), how_.bodies_backwards)) write_force(f);
    return out_;
  }

 private:
  template <class... Args>
  void say(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...);
  }
  static std::vector<int> order(std::size_t n, bool backwards) {
    std::vector<int> list(n);
    std::iota(list.begin(), list.end(), 0);
    if (backwards) std::ranges::reverse(list);
    return list;
  }
  std::string body_name(int b) const { return b == 0 ? "ground" : fmt::format("b{}", b); }
  std::string marker_name(int m) const { return fmt::format("{}.m{}", body_name(s_.markers[m].body), m); }
  std::string coordinate_name(int joint, int coordinate) const {
    return fmt::format("j{}.{}", joint, coordinates_of(s_.joints[joint].type)[coordinate].name);
  }
  void write_pose(const Pose& X, int digits) {
    const Eigen::Vector4d q = quaternion_of_rotation(X.R);
    say("position = {}\n", list(how_.length * X.p, digits));
    if (!X.R.isIdentity(0.0))
      say("quaternion = [{:.{}g}, {:.{}g}, {:.{}g}, {:.{}g}]\n", q(0), digits, q(1), digits, q(2), digits,
          q(3), digits);
  }
  bool is_alone(int body) const {
    return std::ranges::none_of(s_.joints, [&](const SceneJoint& j) {
      return s_.markers[j.F].body == body || s_.markers[j.M].body == body;
    });
  }

  void write_inertia(const SceneBody& body) {
    const double J = how_.mass * how_.length * how_.length;
    const Matrix3d& I = body.inertia;
    say("mass = {:.17g}\ncenter = {}\n", how_.mass * body.mass, list(how_.length * body.center, 17));
    say("inertia = [{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}]\n", J * I(0, 0), J * I(1, 1),
        J * I(2, 2), J * I(0, 1), J * I(1, 2), J * I(2, 0));
  }

  void write_beam(const SceneBeam& beam) {
    const double N = how_.mass * how_.length, EI = beam.bending, EA = 12.0 * EI / (beam.side * beam.side),
                 GA = EA / 3.0;
    const double J = beam.mass / beam.length * beam.side * beam.side / 12.0 * how_.mass * how_.length;
    say("fidelity = \"{}\"\nbeam = {{to = {}, elements = {}, damping_time = {:.17g}, ", beam.fidelity,
        list({how_.length * beam.length, 0, 0}, 17), beam.elements, beam.damping_time);
    say("EA = {:.17g}, GA_y = {:.17g}, GA_z = {:.17g}, ", N * EA, N * GA, N * GA);
    const double NL2 = N * how_.length * how_.length;
    say("GI_t = {:.17g}, EI_y = {:.17g}, EI_z = {:.17g}, ", 0.7 * NL2 * EI, NL2 * EI, NL2 * EI);
    say("mass_per_length = {:.17g}, rho_I_y = {:.17g}, rho_I_z = {:.17g}}}\n",
        beam.mass / beam.length * how_.mass / how_.length, J, J);
  }

  void write_part(const SceneBody& body) {
    say("superelement = \"{}\"\n", body.part->file(folder_, how_.length, how_.mass));
    say("boundary = \"free\"\n");  // the modes that the judge has
    if (body.modes < body.part->n_modes()) say("modes = {}\n", body.modes);
    if (body.damping > 0.0) say("damping = {:.17g}\n", body.damping);
  }

  void write_body(int b) {
    const std::string table = b == 0 ? "ground" : "body.b" + std::to_string(b);
    say("[{}]\n", table);
    if (b > 0) {
      const SceneBody& body = s_.bodies[b];
      if (body.beam)
        write_beam(*body.beam);
      else if (body.part)
        write_part(body);
      else
        write_inertia(body);
      if (is_alone(b) || s_.start == Start::poses || s_.start == Start::guess)
        write_pose(places_[b].X_WB, 17);
      if (is_alone(b))
        say("velocity = {}\nangular_velocity = {}\n", list(how_.length * body.velocity, 17),
            list(body.angular_velocity, 17));
    }
    for (const int m : order(s_.markers.size(), how_.bodies_backwards))
      if (s_.markers[m].body == b) {
        say("[{}.marker.m{}]\n", table, m);
        write_pose(s_.markers[m].X_BP, 17);
        if (s_.bodies[b].part)
          say("on = \"{}\"\n", s_.bodies[b].part->interface_name(s_.markers[m].interface));
      }
  }

  void write_joint(int j) {
    const SceneJoint& joint = s_.joints[j];
    say("[{}.j{}]\ntype = \"{}\"\nfrom = \"{}\"\nto = \"{}\"\n", joint.is_connection ? "connection" : "joint",
        j, joint.type, marker_name(joint.F), marker_name(joint.M));
    if (joint.type == "screw") say("pitch = {:.17g}\n", how_.length * joint.pitch);
    if (joint.cut) say("cut = true\n");
    const Pose X = s_.marker(joint.F, places_).inverse() * s_.marker(joint.M, places_);
    const auto& coordinates = coordinates_of(joint.type);
    const bool given = s_.start == Start::joints && !joint.closes;
    const bool turns = joint.type == "spherical" || joint.type == "free" || joint.type == "point_on_line" ||
                       joint.type == "point_on_plane";
    if (given && turns) {
      const Eigen::Vector4d q = quaternion_of_rotation(X.R);
      say("qw = {:.17g}\nqx = {:.17g}\nqy = {:.17g}\nqz = {:.17g}\n", q(0), q(1), q(2), q(3));
    }
    if (given && joint.type == "free") {
      const char* names[] = {"x", "y", "z"};
      for (int i = 0; i < 3; ++i) say("{} = {:.17g}\n", names[i], how_.length * X.p(i));
    }
    if (joint.type == "free") {
      const SceneBody& body = s_.bodies[s_.markers[joint.M].body];
      for (int i = 0; i < 3 && !body.velocity.isZero(0.0); ++i)
        say("omega_{0} = {1:.17g}\nv_{0} = {2:.17g}\n", "xyz"[i], body.angular_velocity(i),
            how_.length * body.velocity(i));
    }
    if (given && joint.type == "constant_velocity") {
      const Vector3d bend = rotation_log(X.R);
      say("bend_x = {:.17g}\nbend_y = {:.17g}\n", bend.x(), bend.y());
    }
    for (int i = 0; i < static_cast<int>(coordinates.size()); ++i) {
      const auto drive =
          std::ranges::find_if(joint.drives, [&](const SceneDrive& d) { return d.coordinate == i; });
      const bool is_driven = drive != joint.drives.end();
      const double size = coordinates[i].is_angle() ? 1.0 : how_.length;
      if (is_driven) {
        const NamedCoordinate& c = coordinates[i];
        const std::string& key = drive->derivative == 0   ? c.drive
                                 : drive->derivative == 1 ? c.drive_speed
                                                          : c.drive_acceleration;
        say("{} = \"{}\"\n", key, drive->law.text(drive->derivative, size));
        if (drive->derivative >= 1) say("{} = {:.17g}\n", c.name, size * drive->law.value(0.0));
        if (drive->derivative == 2) say("{} = {:.17g}\n", c.speed, size * drive->law.rate(0.0));
      } else if (given) {
        say("{} = {:.17g}\n", coordinates[i].name, size * coordinate_value(joint, coordinates[i], X));
      }
    }
    for (const auto& [i, speed] : joint.speeds)
      say("{} = {:.17g}\n", coordinates[i].speed, (coordinates[i].is_angle() ? 1.0 : how_.length) * speed);
  }

  void write_constraint(int c) {
    const SceneConstraint& constraint = s_.constraints[c];
    say("[constraint.c{}]\ntype = \"{}\"\n", c, constraint.type);
    const auto& terms = constraint.terms;
    if (constraint.type == "gear") {
      say("joint_1 = \"{}\"\njoint_2 = \"{}\"\nteeth_1 = {:.17g}\nteeth_2 = {:.17g}\n",
          coordinate_name(terms[0].joint, terms[0].coordinate),
          coordinate_name(terms[1].joint, terms[1].coordinate), constraint.teeth_1, constraint.teeth_2);
      if (constraint.internal) say("internal = true\n");
      say("offset = {:.17g}\n", constraint.offset);
    } else if (constraint.type == "rack_and_pinion") {
      say("rack = \"{}\"\npinion = \"{}\"\nradius = {:.17g}\noffset = {:.17g}\n",
          coordinate_name(terms[0].joint, terms[0].coordinate),
          coordinate_name(terms[1].joint, terms[1].coordinate), how_.length * constraint.length,
          how_.length * constraint.offset);
    } else if (constraint.type == "coupler") {
      std::string joints, factors;
      for (const auto& term : terms) {
        joints +=
            fmt::format("{}\"{}\"", joints.empty() ? "" : ", ", coordinate_name(term.joint, term.coordinate));
        factors += fmt::format("{}{:.17g}", factors.empty() ? "" : ", ", term.factor);
      }
      say("joints = [{}]\nfactors = [{}]\noffset = {:.17g}\n", joints, factors, constraint.offset);
    } else {
      say("from = \"{}\"\nto = \"{}\"\n", marker_name(constraint.F), marker_name(constraint.M));
      if (constraint.type == "rolling_disc") say("radius = {:.17g}\n", how_.length * constraint.length);
      if (constraint.type == "point_on_curve") {
        std::string points;
        for (const Vector3d& p : constraint.points)
          points += fmt::format("{}{}", points.empty() ? "" : ", ", list(how_.length * p, 17));
        say("points = [{}]\n", points);
      }
      if (constraint.type == "distance") say("length = {:.17g}\n", how_.length * constraint.length);
    }
  }

  void write_force(int f) {
    const SceneForce& force = s_.forces[f];
    const double N = how_.mass * how_.length, Nm = N * how_.length;
    say("[force.f{}]\ntype = \"{}\"\n", f, force.type);
    if (force.type == "spring_damper") {
      say("from = \"{}\"\nto = \"{}\"\nstiffness = {:.17g}\ndamping = {:.17g}\nfree_length = {:.17g}\n",
          marker_name(force.F), marker_name(force.M), how_.mass * force.stiffness, how_.mass * force.damping,
          how_.length * force.rest);
    } else if (force.type == "bushing") {
      const auto three = [](double x) { return fmt::format("[{0:.17g}, {0:.17g}, {0:.17g}]", x); };
      say("from = \"{}\"\nto = \"{}\"\nstiffness = {}\ndamping = {}\n", marker_name(force.F),
          marker_name(force.M), three(how_.mass * force.stiffness), three(how_.mass * force.damping));
      say("rotational_stiffness = {}\nrotational_damping = {}\n", three(Nm * force.turn_stiffness),
          three(Nm * force.turn_damping));
    } else if (force.type == "contact") {
      say("from = \"{}\"\nto = \"{}\"\nradius = {:.17g}\nstiffness = {:.17g}\nexponent = {:.17g}\ndamping = "
          "{:.17g}\n",
          marker_name(force.F), marker_name(force.M), how_.length * force.radius,
          force.stiffness * N / std::pow(how_.length, force.exponent), force.exponent,
          how_.mass * force.damping);
    } else if (force.is_along_joint() && force.type != "joint_spring_damper") {
      const NamedCoordinate& c = coordinates_of(s_.joints[force.joint].type)[force.coordinate];
      const double unit = c.is_angle() ? 1.0 : how_.length, size = N * how_.length / unit;
      say("joint = \"j{}\"\n", force.joint);
      if (coordinates_of(s_.joints[force.joint].type).size() > 1) say("coordinate = \"{}\"\n", c.name);
      if (force.type == "joint_friction")
        say("coulomb = {:.17g}\nviscous = {:.17g}\ntransition_speed = {:.17g}\n", size * force.coulomb,
            size / unit * force.damping, unit * force.transition);
      else if (force.type == "actuator")
        say("command = \"t > {:.17g} ? {:.17g} : {:.17g}\"\ntime_constant = {:.17g}\nstart = {:.17g}\n",
            force.at, size * force.level[1], size * force.level[0], force.time_constant, size * force.start);
      else
        say("value = \"{} > {:.17g} ? {:.17g} : {:.17g}\"\n", coordinate_name(force.joint, force.coordinate),
            unit * force.at, size * force.level[1], size * force.level[0]);
    } else if (force.type == "joint_spring_damper") {
      const NamedCoordinate& c = coordinates_of(s_.joints[force.joint].type)[force.coordinate];
      const double k = how_.mass * (c.is_angle() ? how_.length * how_.length : 1.0);
      say("joint = \"j{}\"\n", force.joint);
      if (coordinates_of(s_.joints[force.joint].type).size() > 1) say("coordinate = \"{}\"\n", c.name);
      say("stiffness = {:.17g}\ndamping = {:.17g}\nrest = {:.17g}\n", k * force.stiffness, k * force.damping,
          (c.is_angle() ? 1.0 : how_.length) * force.rest);
    } else {
      const char* axes[] = {"x", "y", "z"};
      say("marker = \"{}\"\n", marker_name(force.M));
      for (int i = 0; i < 3; ++i)
        say("{} = \"{}\"\n", axes[i], force.law[i].text(0, force.type == "torque" ? Nm : N));
    }
  }

  const Scene& s_;
  const std::filesystem::path& folder_;
  const Writing& how_;
  Places places_;
  std::string out_;
};

}  // namespace

std::string to_toml(const Scene& scene, const std::filesystem::path& folder, const Writing& writing) {
  return Writer(scene, folder, writing).text();
}

}  // namespace flexura::mbs::chance
