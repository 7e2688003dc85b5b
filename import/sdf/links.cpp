// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <stdexcept>

#include "import/sdf/files.hpp"
#include "import/sdf/reader.hpp"
#include "import/tree/inertia.hpp"
#include "import/urdf/mesh_file.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::sdf {
namespace {

using tree::Solid;
using xml::Node;

double number_in(const Node& element, const char* tag, double otherwise, Findings& findings) {
  const Node* const child = element.child(tag);
  if (child == nullptr || child->text.empty()) return otherwise;
  const auto value = xml::parse_number(child->text);
  if (!value)
    xml::fault(findings, *child,
               fmt::format("<{}> is \"{}\", a finite number is wanted; correct it", tag, shown(child->text)));
  return value.value_or(otherwise);
}

class LinkReader {
 public:
  LinkReader(const Source& source, const std::vector<std::string>& packages, Findings& findings)
      : source_(source), packages_(packages), findings_(findings) {}

  tree::Link read() {
    const Node& e = *source_.element;
    link_.name = source_.name;
    read_shapes(e);
    read_inertial(e.child("inertial"));
    return std::move(link_);
  }

 private:
  // A link without <inertial>, or without parts of it, has the format's own: 1 kg, 1 kg m^2.
  void read_inertial(const Node* e) {
    tree::Inertial& own = link_.inertial;
    own.mass = 1.0;
    own.inertia.setIdentity();
    if (e == nullptr) {
      if (!source_.is_static)
        xml::note(
            findings_, *source_.element, "links without <inertial>",
            fmt::format(
                "link \"{}\" has no <inertial>: it has 1 kg and 1 kg m^2 about all axes, as the format says",
                shown(source_.name)));
      return;
    }
    if (e->get("auto") == "true" || e->get("auto") == "1") {
      own = from_shapes(e->child("density"));
      return;
    }
    own.mass = number_in(*e, "mass", 1.0, findings_);
    if (own.mass < 0.0 || (own.mass == 0.0 && !source_.is_static)) {
      xml::fault(findings_, *e,
                 fmt::format("the mass of link \"{}\" is {}, it must be positive; correct it",
                             shown(source_.name), own.mass));
      own.mass = 1.0;
    }
    if (const Node* i = e->child("inertia")) {
      const auto I = [&](const char* tag, double otherwise) {
        return number_in(*i, tag, otherwise, findings_);
      };
      own.inertia << I("ixx", 1.0), I("ixy", 0.0), I("ixz", 0.0), I("ixy", 0.0), I("iyy", 1.0), I("iyz", 0.0),
          I("ixz", 0.0), I("iyz", 0.0), I("izz", 1.0);
    }
    mend(*e, own.inertia);
    own = own.in(pose_in(*e, findings_));
    if (e->child("fluid_added_mass") != nullptr)
      xml::note(findings_, *e, "added masses left out",
                fmt::format("link \"{}\": the added mass of a fluid is left out", shown(source_.name)));
  }

  void mend(const Node& e, Matrix3d& inertia) {
    if (is_inertia(inertia)) return;
    const auto moments = [](const Matrix3d& I) {
      const Vector3d m = Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
      return fmt::format("{:.6g}, {:.6g}, {:.6g}", m[0], m[1], m[2]);
    };
    if (!(inertia.trace() > 0.0)) {
      xml::fault(
          findings_, e,
          fmt::format("the inertia of link \"{}\" has the principal moments {} kg m^2, whose sum is not "
                      "positive; correct them",
                      shown(source_.name), moments(inertia)));
      return;
    }
    const Matrix3d nearest = nearest_inertia(inertia);
    xml::repair(findings_, e, "inertias of no body",
                fmt::format("link \"{}\": the principal moments {} kg m^2 are those of no body; taken are {}",
                            shown(source_.name), moments(inertia), moments(nearest)));
    inertia = nearest;
  }

  tree::Inertial from_shapes(const Node* density) {
    tree::Inertial sum;
    for (const Node* e : source_.element->all("collision")) {
      const Node* own = e->child("density") != nullptr ? e->child("density") : density;
      const double rho = own == nullptr ? 1000.0 : xml::parse_number(own->text).value_or(1000.0);
      for (const Solid& solid : solids_of(*e)) sum = tree::together(sum, tree::uniform(solid, rho));
    }
    if (!(sum.mass > 0.0) && !source_.is_static)
      xml::fault(findings_, *source_.element,
                 fmt::format("the inertia of link \"{}\" is to be that of its collisions, which have no "
                             "volume that is known; give it <inertial>",
                             shown(source_.name)));
    return sum;
  }

  // Pictures; without those the shapes for contact.
  void read_shapes(const Node& e) {
    const char* const tag = e.child("visual") != nullptr ? "visual" : "collision";
    for (const Node* shape : e.all(tag))
      for (Solid& solid : solids_of(*shape)) link_.solids.push_back(std::move(solid));
  }

  std::vector<Solid> solids_of(const Node& e) {
    const Node* const geometry = e.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) return {};
    const Node& g = geometry->children.front();
    Findings unheard(*e.file);  // a picture is worth no refusal
    Solid solid{.X_LS = pose_in(e, unheard)};
    const auto number = [&](const char* key) { return number_in(g, key, 0.0, unheard); };
    const auto three = [&](const char* key) {
      const Node* const child = g.child(key);
      const auto x = xml::parse_numbers(child == nullptr ? "" : child->text);
      return x && x->size() == 3 ? Vector3d((*x)[0], (*x)[1], (*x)[2]) : Vector3d(Vector3d::Zero());
    };
    double least = 0.0;
    if (g.tag == "box") {
      solid.kind = Solid::Kind::box;
      solid.size = 0.5 * three("size");
      least = solid.size.minCoeff();
    } else if (g.tag == "sphere") {
      solid.size = Vector3d::Constant(number("radius"));
      least = solid.size.x();
    } else if (g.tag == "cylinder" || g.tag == "capsule") {
      solid.kind = g.tag == "cylinder" ? Solid::Kind::cylinder : Solid::Kind::capsule;
      solid.size = {number("radius"), 0.5 * number("length"), 0.0};
      least = std::min(solid.size.x(), solid.size.y());
    } else if (g.tag == "ellipsoid") {
      solid.kind = Solid::Kind::ellipsoid;
      solid.size = three("radii");
      least = solid.size.minCoeff();
    } else if (g.tag == "mesh") {
      return mesh(g, solid);
    }
    if (least > 0.0) return {solid};
    if (g.tag != "plane") note_picture(g, fmt::format("<{}> has no size or no picture", shown(g.tag)));
    return {};
  }

  std::vector<Solid> mesh(const Node& g, Solid solid) {
    const Node* const uri = g.child("uri");
    const std::string name = uri == nullptr ? "" : uri->text;
    try {
      if (g.child("submesh") != nullptr)
        throw std::invalid_argument(
            "parts of meshes are not read; give the part a file of its own, or the link an <inertial>");
      const std::filesystem::path file = find_uri(name, *g.file, packages_);
      if (file.empty()) throw std::invalid_argument(fmt::format("mesh \"{}\" is not there", shown(name)));
      solid.kind = Solid::Kind::surface;
      solid.surface = urdf::read_surface(file);
      if (const Node* scale = g.child("scale"))
        if (const auto s = xml::parse_numbers(scale->text); s && s->size() == 3)
          for (Vector3d& v : solid.surface.vertices) v = v.cwiseProduct(Vector3d((*s)[0], (*s)[1], (*s)[2]));
      return {solid};
    } catch (const std::invalid_argument& why) {
      note_picture(g, why.what());
      return {};
    }
  }

  void note_picture(const Node& at, const std::string& why) {
    xml::note(findings_, at, "pictures left out",
              fmt::format("link \"{}\" without that picture: {}", shown(source_.name), why));
  }

  const Source& source_;
  const std::vector<std::string>& packages_;
  Findings& findings_;
  tree::Link link_;
};

}  // namespace

tree::Link read_link(const Source& source, const std::vector<std::string>& packages, Findings& findings) {
  return LinkReader(source, packages, findings).read();
}

}  // namespace flexura::import::sdf
