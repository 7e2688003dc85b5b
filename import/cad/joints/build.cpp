// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/joints/build.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <tuple>

#include "import/cad/joints/contact_text.hpp"
#include "import/cad/joints/decide.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {
namespace {

using Type = JointForm::Type;

std::string text(const char* word) {
  return toml(std::string(word));
}

class Builder {
 public:
  Builder(const Assembly& assembly, const BuildOptions& options) : assembly_(assembly), options_(options) {
    Names parts;
    for (const Part& part : assembly.parts) part_names_.push_back(parts.add(part.name));
    for (const Instance& instance : assembly.instances) body_names_.push_back(names_.add(instance.name));
    faces_.resize(assembly.parts.size());
  }

  Built build(const std::string& name) {
    ProposeOptions propose_options = options_.propose;
    built_.proposal = propose(assembly_, body_names_, propose_options);
    if (options_.joints && options_.decide) {
      options_.decide(assembly_, built_.proposal, body_names_);
      count_again(assembly_, built_.proposal);
    }
    Mechanism& m = built_.mechanism;
    m.name = name;
    m.comments = {"imported by flexura import; bodies have the frames of their parts, lengths in m",
                  "Joints are proposed from the geometry: see their evidence, and change what is not so."};
    m.notes = assembly_.notes;
    add_bodies();
    const int ground = built_.proposal.ground;
    m.elements.push_back(fixed_to_ground(ground));
    if (options_.joints) {
      for (std::size_t j = 0; j < built_.proposal.joints.size(); ++j) add_joint(j);
      for (const std::string& doubt : built_.proposal.doubts) {
        m.notes.push_back(doubt);
        m.comments.push_back("doubtful: " + doubt);
      }
      add_contacts();
      if (built_.proposal.freedom)
        m.comments.push_back(fmt::format("degrees of freedom: {}", *built_.proposal.freedom));
    }
    add_part_files();
    return std::move(built_);
  }

 private:
  double density_of(const Part& part) const { return part.density > 0.0 ? part.density : options_.density; }

  void add_bodies() {
    std::set<std::string> assumed;
    for (std::size_t i = 0; i < assembly_.instances.size(); ++i) {
      const Instance& instance = assembly_.instances[i];
      const auto p = static_cast<std::size_t>(instance.part);
      const Part& part = assembly_.parts[p];
      Body body;
      body.name = body_names_[i];
      body.part = part_names_[p];
      body.comments.push_back("\"" + shown(instance.name) + "\", part \"" + shown(part.name) + "\"" +
                              (instance.path.empty() ? "" : " of " + shown(instance.path)) +
                              (part.color.empty() ? "" : ", colour " + shown(part.color)));
      const double rho = density_of(part);
      body.mass = rho * part.volume;
      body.center = part.center;
      body.inertia = rho * part.moments;
      body.surface = part.surface;
      body.X_WB = instance.X_WP;
      body.comments.push_back(fmt::format("{:.6g} kg, {:.6g} cm^3 of {:.6g} kg/m^3{}", body.mass,
                                          1e6 * part.volume, rho,
                                          part.density > 0.0 ? "" : " (assumed: the file gives no density)"));
      if (part.density <= 0.0) assumed.insert(part_names_[p]);
      built_.mechanism.bodies.push_back(std::move(body));
    }
    if (!assumed.empty())
      built_.mechanism.notes.push_back(
          fmt::format("{} of {} parts have no density in the file: {:.6g} kg/m^3 is taken (--density)",
                      assumed.size(), assembly_.parts.size(), options_.density));
  }

  Element fixed_to_ground(int ground) {
    Body& body = built_.mechanism.bodies[static_cast<std::size_t>(ground)];
    built_.mechanism.ground.push_back({"frame", body.X_WB});
    body.markers.push_back({"ground", {}});
    return {
        "joint",
        names_.add("to_ground"),
        {options_.propose.ground.empty() ? "the largest body stands on the ground (--ground names another)"
                                         : "as --ground says"},
        {{"type", text("fixed")}, {"from", text("ground.frame")}, {"to", toml(body.name + ".ground")}}};
  }

  void add_joint(std::size_t number) {
    const ProposedJoint& joint = built_.proposal.joints[number];
    const std::string &a = body_names_[static_cast<std::size_t>(joint.a)],
                      &b = body_names_[static_cast<std::size_t>(joint.b)];
    Element element{"joint", names_.add(a + "_" + b)};
    element.comments.push_back(fmt::format("confidence {}{}", name_of(joint.confidence),
                                           joint.doubt.empty() ? "" : ": " + joint.doubt));
    for (const std::string& line : joint.evidence) element.comments.push_back(line);
    if (joint.redundant > 0)
      element.comments.push_back(
          fmt::format("{} of its rows follow from those of the joints before it", joint.redundant));
    const Pose X_WJ{mbs::frame_along(joint.form.axis), joint.form.point};
    element.lines = {{"type", text(name_of(joint.form.type))}};
    if (joint.form.type == Type::screw) element.lines.emplace_back("pitch", toml(joint.form.lead));
    const std::array<int, 2> on = {interface_for(joint, joint.a), interface_for(joint, joint.b)};
    built_.joints.push_back({.name = element.name, .proposed = number, .on = on});
    for (const auto& [key, i, face] : {std::tuple{"from", joint.a, on[0]}, {"to", joint.b, on[1]}}) {
      Body& body = built_.mechanism.bodies[static_cast<std::size_t>(i)];
      body.markers.push_back(
          {element.name, body.X_WB.inverse() * X_WJ, face == 0 ? "" : fmt::format("face{}", face)});
      element.lines.emplace_back(key, toml(body.name + "." + element.name));
    }
    if (joint.confidence == Confidence::low)
      built_.mechanism.notes.push_back(
          fmt::format("joint {} ({}) is doubtful: {}", element.name, name_of(joint.form.type), joint.doubt));
    built_.mechanism.elements.push_back(std::move(element));
  }

  // Pairs that may touch, for those who want them to: tables for the end of the mechanism file.
  void add_contacts() {
    if (built_.proposal.candidates.empty()) return;
    std::string file =
        "# Pairs of bodies without a joint between them that come near each other, by flexura import. What "
        "is to touch goes to the\n"
        "# end of mechanism.toml: a table of the marker and one of the contact each. Stiffness and damping "
        "are chosen.\n";
    int ready = 0;
    for (const ContactCandidate& c : built_.proposal.candidates) {
      const std::string &a = body_names_[static_cast<std::size_t>(c.a)],
                        &b = body_names_[static_cast<std::size_t>(c.b)];
      ContactText text = contact_text(assembly_, body_names_, c, names_.add("contact_" + a + "_" + b));
      file += "\n# " + text.says + "\n" +
              (text.lines.empty() ? "# neither face is a plane, a sphere or a cylinder: a gear, a mesh of "
                                    "teeth or a joint must do\n"
                                  : text.lines);
      ready += text.lines.empty() ? 0 : 1;
      built_.contacts.push_back({c.a, c.b, c.place, std::move(text)});
    }
    built_.texts.push_back({"contacts.toml", file});
    built_.mechanism.notes.push_back(
        fmt::format("{} {} of bodies without a joint come near each other: contacts.toml lists them, {} with "
                    "a contact to be copied",
                    built_.contacts.size(), built_.contacts.size() == 1 ? "pair" : "pairs", ready));
  }

  const mesh::Face& face_of(std::size_t part, int number) const {
    return assembly_.parts[part].faces[static_cast<std::size_t>(number - 1)].shape;
  }

  static bool is_same_surface(const mesh::Face& f, const mesh::Face& g) {
    const Vector3d off = f.axis_point - g.axis_point;
    if (g.kind != f.kind) return false;
    if (f.kind == mesh::FaceKind::cylinder)
      return std::abs(g.radius - f.radius) < 1e-7 && g.axis.cross(f.axis).norm() < 1e-6 &&
             (off - f.axis * f.axis.dot(off)).norm() < 1e-7;
    return f.kind == mesh::FaceKind::plane && (g.normal - f.normal).norm() < 1e-6 &&
           std::abs(f.normal.dot(f.centroid - g.centroid)) < 1e-7;
  }

  // The interface of the body's part that carries the joint: a cylinder before a plane, one for all faces of one surface.
  // 0 where the joint sits on no face of this body.
  int interface_for(const ProposedJoint& joint, int instance) {
    const auto p = static_cast<std::size_t>(assembly_.instances[static_cast<std::size_t>(instance)].part);
    int best = 0;
    for (const auto& [i, face] : joint.faces)
      if (i == instance && (best == 0 || (face_of(p, best).kind == mesh::FaceKind::plane &&
                                          face_of(p, face).kind != mesh::FaceKind::plane)))
        best = face;
    if (best == 0) return 0;
    for (const int known : faces_[p])
      if (is_same_surface(face_of(p, known), face_of(p, best))) best = known;
    faces_[p].insert(best);
    return best;
  }

  // Where `flexura reduce` puts the node: the middle of a cylinder's axis, the centre of others.
  static Vector3d place_of(const mesh::Face& f) {
    return f.kind == mesh::FaceKind::cylinder ? f.axis_point : f.centroid;
  }

  // Which of the part's interfaces each triangle is of: an interface holds all faces of one surface.
  std::vector<int> triangle_interfaces(std::size_t p) const {
    std::vector<int> of_triangle;
    for (const Face& face : assembly_.parts[p].faces) {
      int found = -1, k = 0;
      for (const int number : faces_[p]) {
        if (face.shape.number == number || is_same_surface(face.shape, face_of(p, number))) found = k;
        ++k;
      }
      of_triangle.insert(of_triangle.end(), face.triangles.size(), found);
    }
    return of_triangle;
  }

  std::string interfaces_of(std::size_t p) const {
    std::string out;
    for (const int number : faces_[p])
      out += fmt::format("\n[interface.face{}]\n{}", number, mesh::selection_lines(face_of(p, number)));
    return out;
  }

  void add_part_files() {
    for (std::size_t i = 0; i < assembly_.instances.size(); ++i) {
      const auto p = static_cast<std::size_t>(assembly_.instances[i].part);
      Body& body = built_.mechanism.bodies[i];
      for (const int number : faces_[p])
        body.interfaces.emplace_back(fmt::format("face{}", number), place_of(face_of(p, number)));
      body.triangle_interface = triangle_interfaces(p);
    }
    for (std::size_t p = 0; p < assembly_.parts.size(); ++p) {
      const Part& part = assembly_.parts[p];
      const std::filesystem::path stem = std::filesystem::path("parts") / part_names_[p];
      built_.texts.push_back({stem.string() + ".brep", part.brep});
      std::string file = fmt::format(
          "# part \"{}\", imported by flexura import: for flexura reduce, which makes it flexible\n"
          "name = {}\n\n[geometry]\nfile = {}\nunit = \"mm\"\n{}\n"
          "# Young's modulus and Poisson's ratio are those of steel, the file gives none{}\n"
          "[material.steel]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = {}\n",
          shown(part.name), toml(part_names_[p]), toml(part_names_[p] + ".brep"),
          part.solids > 1 ? "fuse = true\n" : "", part.density > 0.0 ? "" : ", nor a density",
          toml(density_of(part)));
      file += interfaces_of(p);
      built_.texts.push_back({stem.string() + ".toml", file});
    }
  }

  const Assembly& assembly_;
  const BuildOptions& options_;
  Names names_;
  std::vector<std::string> part_names_, body_names_;
  std::vector<std::set<int>> faces_;  // of each part, that joints sit on
  Built built_;
};

}  // namespace

Built build(const Assembly& assembly, const std::string& name, const BuildOptions& options) {
  return Builder(assembly, options).build(name);
}

}  // namespace flexura::import::cad
