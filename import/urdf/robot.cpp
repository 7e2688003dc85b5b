// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/robot.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <set>

#include "import/urdf/xml.hpp"

namespace flexura::import::urdf {
namespace {

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : root_(open_robot(file, document_)) {
    robot_.file = file;
    robot_.name = root_.has("name") ? root_.text("name") : file.stem().string();
  }

  Robot read() {
    for (const Element& material : root_.children("material")) note_color(material);
    for (const Element& link : root_.children("link")) read_link(link);
    if (robot_.links.empty()) root_.refuse("<robot> has no <link>; a mechanism needs one at least");
    for (const Element& joint : root_.children("joint")) read_joint(joint);
    for (const Element& joint : root_.children("joint")) read_mimic(joint);
    for (const Element& transmission : root_.children("transmission")) read_transmission(transmission);
    find_tree();
    require_size();
    note_passed_over();
    return robot_;
  }

 private:
  void note_color(const Element& material) {
    const auto color = material.child("color");
    if (!color || !material.has("name") || !color->has("rgba")) return;
    const std::string rgba = color->text("rgba");
    // Four numbers of 0 .. 1; a colour is worth no refusal.
    double c[3] = {};
    std::size_t at = 0;
    for (double& x : c) {
      at = rgba.find_first_not_of(" \t\r\n", at);
      if (at == std::string::npos) return;
      const std::size_t end = rgba.find_first_of(" \t\r\n", at);
      const auto value = parse_number(std::string_view(rgba).substr(at, end - at));
      if (!value) return;
      x = std::clamp(*value, 0.0, 1.0);
      at = end;
    }
    colors_[material.text("name")] = fmt::format("#{:02x}{:02x}{:02x}", int(255 * c[0] + 0.5),
                                                 int(255 * c[1] + 0.5), int(255 * c[2] + 0.5));
  }

  Inertial read_inertial(const Element& e, const std::string& link) {
    const auto mass = e.child("mass"), inertia = e.child("inertia");
    if (!mass)
      e.refuse(
          fmt::format("<inertial> of link \"{}\" has no <mass>; give it, or take <inertial> away", link));
    if (!inertia)
      e.refuse(
          fmt::format("<inertial> of link \"{}\" has no <inertia>; give it, or take <inertial> away", link));
    const Pose X = e.origin();
    Inertial result;
    result.mass = mass->number("value");
    if (result.mass < 0.0)
      mass->refuse(
          fmt::format("the mass of link \"{}\" is {}, it cannot be negative; correct it", link, result.mass));
    result.center = X.p;
    const double xx = inertia->number("ixx"), yy = inertia->number("iyy"), zz = inertia->number("izz"),
                 xy = inertia->number("ixy", 0.0), xz = inertia->number("ixz", 0.0),
                 yz = inertia->number("iyz", 0.0);
    if (!inertia->has("ixy") || !inertia->has("ixz") || !inertia->has("iyz"))
      robot_.notes.push_back(
          fmt::format("link \"{}\": products of inertia that are not given are taken as 0", link));
    Matrix3d I;
    I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    // The rule of the mechanism file, told here with the link's line.
    const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
    if (moments[0] < -1e-12 * moments.cwiseAbs().maxCoeff() || moments[0] + moments[1] < 0.99 * moments[2])
      inertia->refuse(fmt::format(
          "the inertia of link \"{}\" has the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2, which no "
          "body has: none is negative, the two smaller ones are together at least the largest; "
          "check signs, units and that it is about the centre of mass",
          link, moments[0], moments[1], moments[2]));
    if (result.mass == 0.0 && moments[2] > 0.0)
      mass->refuse(fmt::format("link \"{}\" has moments of inertia but no mass; give it one", link));
    result.inertia = X.R * I * X.R.transpose();
    return result;
  }

  Visual read_visual(const Element& e, const std::string& link) {
    Visual visual;
    visual.X_LV = e.origin();
    if (const auto material = e.child("material")) {
      note_color(*material);
      if (material->has("name"))
        if (const auto known = colors_.find(material->text("name")); known != colors_.end())
          visual.color = known->second;
    }
    const auto geometry = e.child("geometry");
    const std::vector<Element> kinds = geometry ? geometry->children() : std::vector<Element>{};
    if (kinds.size() != 1)
      e.refuse(fmt::format("<visual> of link \"{}\" must have a <geometry> of one shape", link));
    const Element& g = kinds.front();
    const auto positive = [&](const char* attribute) {
      const double x = g.number(attribute);
      if (!(x > 0.0)) g.refuse(fmt::format("{} of <{}> is {}, it must be positive", attribute, g.tag(), x));
      return x;
    };
    if (g.tag() == "box") {
      if (!g.has("size")) g.refuse("<box> has no size; give it");
      visual.size = g.vector("size", Vector3d::Ones());
      if (!(visual.size.minCoeff() > 0.0)) g.refuse("size of <box> must be three positive numbers");
    } else if (g.tag() == "cylinder") {
      visual.kind = Visual::Kind::cylinder;
      visual.radius = positive("radius");
      visual.length = positive("length");
    } else if (g.tag() == "sphere") {
      visual.kind = Visual::Kind::sphere;
      visual.radius = positive("radius");
    } else if (g.tag() == "mesh") {
      visual.kind = Visual::Kind::mesh;
      visual.mesh = g.text("filename");
      visual.size = g.vector("scale", Vector3d::Ones());
    } else {
      g.refuse(fmt::format("<{}> is no shape of a URDF; box, cylinder, sphere and mesh are", shown(g.tag())));
    }
    return visual;
  }

  void read_link(const Element& e) {
    Link link;
    link.name = e.text("name");
    link.line = e.line();
    if (!link_index_.emplace(link.name, static_cast<int>(robot_.links.size())).second)
      e.refuse(fmt::format("a second link \"{}\"; names must differ", shown(link.name)));
    if (const auto inertial = e.child("inertial")) link.inertial = read_inertial(*inertial, shown(link.name));
    for (const Element& visual : e.children("visual"))
      link.visuals.push_back(read_visual(visual, shown(link.name)));
    if (!e.children("collision").empty())
      passed_over_.insert("<collision> (contact is a force of the mechanism file)");
    robot_.links.push_back(std::move(link));
  }

  int link_of(const Element& joint, const char* tag, const std::string& name) const {
    const auto end = joint.child(tag);
    if (!end) joint.refuse(fmt::format("joint \"{}\" has no <{}>; give it", name, tag));
    const std::string link = end->text("link");
    const auto found = link_index_.find(link);
    if (found == link_index_.end())
      end->refuse(
          fmt::format("the {} of joint \"{}\" is link \"{}\", which the file does not have; correct the name",
                      tag, name, shown(link)));
    return found->second;
  }

  void read_joint(const Element& e) {
    static const std::map<std::string, JointKind> kinds = {
        {"revolute", JointKind::revolute},   {"continuous", JointKind::continuous},
        {"prismatic", JointKind::prismatic}, {"fixed", JointKind::fixed},
        {"floating", JointKind::floating},   {"planar", JointKind::planar}};
    Joint joint;
    joint.name = e.text("name");
    joint.line = e.line();
    const std::string name = shown(joint.name);
    if (!joint_index_.emplace(joint.name, static_cast<int>(robot_.joints.size())).second)
      e.refuse(fmt::format("a second joint \"{}\"; names must differ", name));
    const auto kind = kinds.find(e.text("type"));
    if (kind == kinds.end())
      e.refuse(fmt::format(
          "joint \"{}\" is of type \"{}\"; write revolute, continuous, prismatic, fixed, floating or planar",
          name, shown(e.text("type"))));
    joint.kind = kind->second;
    joint.parent = link_of(e, "parent", name);
    joint.child = link_of(e, "child", name);
    joint.X_PJ = e.origin();
    const bool has_axis = joint.kind != JointKind::fixed && joint.kind != JointKind::floating;
    const bool one_way = has_axis && joint.kind != JointKind::planar;
    if (const auto axis = e.child("axis"); axis && has_axis) {
      const Vector3d a = axis->vector("xyz", Vector3d::UnitX());
      if (!(a.norm() > 0.0))
        axis->refuse(fmt::format("the axis of joint \"{}\" has no length; give its direction", name));
      joint.axis = a.normalized();
    }
    if (const auto dynamics = e.child("dynamics")) {
      joint.damping = dynamics->number("damping", 0.0);
      joint.friction = dynamics->number("friction", 0.0);
      if (joint.damping < 0.0 || joint.friction < 0.0)
        dynamics->refuse(
            fmt::format("damping {} and friction {} of joint \"{}\" cannot be negative; correct them",
                        joint.damping, joint.friction, name));
      if (!one_way && (joint.damping > 0.0 || joint.friction > 0.0))
        robot_.notes.push_back(fmt::format(
            "joint \"{}\": damping and friction are taken over for joints of one coordinate only; "
            "this one runs without",
            name));
    }
    const auto limit = e.child("limit");
    const bool bounded = joint.kind == JointKind::revolute || joint.kind == JointKind::prismatic;
    if (!limit && bounded)
      e.refuse(fmt::format("joint \"{}\" has no <limit>, which a {} joint needs; give lower and upper{}",
                           name, e.text("type"),
                           joint.kind == JointKind::revolute ? ", or make it continuous" : ""));
    if (limit && one_way) {
      joint.limit = Limit{.lower = limit->number("lower", 0.0),
                          .upper = limit->number("upper", 0.0),
                          .effort = limit->number("effort", 0.0),
                          .velocity = limit->number("velocity", 0.0)};
      if (bounded && joint.limit->lower > joint.limit->upper)
        limit->refuse(fmt::format("lower {} of joint \"{}\" is above upper {}; exchange them",
                                  joint.limit->lower, name, joint.limit->upper));
      if (joint.limit->effort < 0.0 || joint.limit->velocity < 0.0)
        limit->refuse(
            fmt::format("effort and velocity of joint \"{}\" cannot be negative; correct them", name));
    }
    for (const char* other : {"safety_controller", "calibration"})
      if (!e.children(other).empty()) passed_over_.insert(fmt::format("<{}>", other));
    robot_.joints.push_back(std::move(joint));
  }

  void read_mimic(const Element& e) {
    const auto mimic = e.child("mimic");
    if (!mimic) return;
    const int self = joint_index_.at(e.text("name"));
    Joint& joint = robot_.joints[static_cast<std::size_t>(self)];
    const std::string other = mimic->text("joint");
    const auto found = joint_index_.find(other);
    if (found == joint_index_.end())
      mimic->refuse(fmt::format("joint \"{}\" mimics \"{}\", which the file does not have; correct the name",
                                shown(joint.name), shown(other)));
    const auto has_one = [](const Joint& j) {
      return j.kind == JointKind::revolute || j.kind == JointKind::continuous ||
             j.kind == JointKind::prismatic;
    };
    if (!has_one(joint) || !has_one(robot_.joints[static_cast<std::size_t>(found->second)]))
      mimic->refuse(fmt::format("joint \"{}\" mimics \"{}\": both must be revolute, continuous or prismatic",
                                shown(joint.name), shown(other)));
    joint.mimic = Mimic{found->second, mimic->number("multiplier", 1.0), mimic->number("offset", 0.0)};
    // Round and round?
    int at = found->second;
    for (std::size_t i = 0; i <= robot_.joints.size() && at >= 0; ++i) {
      if (at == self)
        mimic->refuse(
            fmt::format("joint \"{}\" mimics itself, directly or by way of others; one of them must be free",
                        shown(joint.name)));
      const auto& next = robot_.joints[static_cast<std::size_t>(at)].mimic;
      at = next ? next->joint : -1;
    }
  }

  void read_transmission(const Element& e) {
    const std::string name = e.has("name") ? e.text("name") : "transmission";
    const auto joints = e.children("joint"), actuators = e.children("actuator");
    if (joints.size() != 1 || actuators.size() > 1) {
      robot_.notes.push_back(fmt::format(
          "transmission \"{}\" joins {} joints with {} actuators and is passed over: one of each is "
          "taken over",
          shown(name), joints.size(), actuators.size()));
      return;
    }
    const std::string joint = joints.front().text("name");
    const auto found = joint_index_.find(joint);
    if (found == joint_index_.end())
      joints.front().refuse(fmt::format(
          "transmission \"{}\" drives joint \"{}\", which the file does not have; correct the name",
          shown(name), shown(joint)));
    const JointKind kind = robot_.joints[static_cast<std::size_t>(found->second)].kind;
    if (kind == JointKind::fixed || kind == JointKind::floating || kind == JointKind::planar)
      joints.front().refuse(
          fmt::format("transmission \"{}\" drives joint \"{}\", which has no single coordinate; name a "
                      "revolute, continuous or prismatic one",
                      shown(name), shown(joint)));
    Transmission transmission{.name = name, .actuator = name, .joint = found->second};
    if (!actuators.empty() && actuators.front().has("name"))
      transmission.actuator = actuators.front().text("name");
    std::vector<Element> reductions = e.children("mechanicalReduction");
    for (const Element& actuator : actuators)
      for (const Element& r : actuator.children("mechanicalReduction")) reductions.push_back(r);
    if (!reductions.empty()) {
      const auto value = parse_number(reductions.front().text());
      if (!value || *value == 0.0)
        reductions.front().refuse(
            fmt::format("the mechanicalReduction of \"{}\" is \"{}\", a number other than 0 is wanted",
                        shown(name), shown(reductions.front().text())));
      transmission.reduction = *value;
    }
    robot_.transmissions.push_back(std::move(transmission));
  }

  // One root, every other link with one parent, no ring.
  void find_tree() {
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      Link& child = robot_.links[static_cast<std::size_t>(joint.child)];
      if (child.parent_joint >= 0)
        refuse(joint.line,
               fmt::format("link \"{}\" is the child of joint \"{}\" and of joint \"{}\": a URDF is a tree, "
                           "each link has "
                           "one parent; close loops by a joint in the mechanism file",
                           shown(child.name),
                           shown(robot_.joints[static_cast<std::size_t>(child.parent_joint)].name),
                           shown(joint.name)));
      child.parent_joint = static_cast<int>(j);
    }
    std::vector<int> roots;
    for (std::size_t l = 0; l < robot_.links.size(); ++l)
      if (robot_.links[l].parent_joint < 0) roots.push_back(static_cast<int>(l));
    if (roots.empty())
      refuse(robot_.joints.front().line,
             "the joints form a ring and no link is the root; take one of them away");
    if (roots.size() > 1) {
      std::string names;
      for (std::size_t i = 0; i < std::min<std::size_t>(roots.size(), 5); ++i)
        names +=
            (i > 0 ? ", " : "") + ('"' + shown(robot_.links[static_cast<std::size_t>(roots[i])].name) + '"');
      refuse(robot_.links[static_cast<std::size_t>(roots[1])].line,
             fmt::format("{} links have no parent ({}{}); a URDF has one root: join the others to it",
                         roots.size(), names, roots.size() > 5 ? ", ..." : ""));
    }
    robot_.root = roots.front();
    std::vector<std::vector<int>> below(robot_.links.size());
    for (std::size_t j = 0; j < robot_.joints.size(); ++j)
      below[static_cast<std::size_t>(robot_.joints[j].parent)].push_back(static_cast<int>(j));
    std::vector<int> links = {robot_.root};
    for (std::size_t i = 0; i < links.size(); ++i)
      for (const int j : below[static_cast<std::size_t>(links[i])]) {
        robot_.order.push_back(j);
        links.push_back(robot_.joints[static_cast<std::size_t>(j)].child);
      }
    if (links.size() < robot_.links.size())
      for (const Joint& joint : robot_.joints)
        if (std::ranges::find(links, joint.child) == links.end())
          refuse(
              joint.line,
              fmt::format(
                  "joint \"{}\" belongs to a ring of joints that the root \"{}\" does not reach; take one of "
                  "the ring's joints away",
                  shown(joint.name), shown(robot_.links[static_cast<std::size_t>(robot_.root)].name)));
  }

  // The check of the mass matrix at the start takes the third power of the coordinates.
  void require_size() const {
    constexpr std::size_t most_links = 20'000, most_movable = 1000;
    std::size_t movable = 0;
    for (const Joint& joint : robot_.joints) movable += joint.kind == JointKind::fixed ? 0 : 1;
    if (robot_.links.size() > most_links || movable > most_movable)
      root_.refuse(fmt::format("<robot> has {} links and {} movable joints; {} and {} are taken",
                               robot_.links.size(), movable, most_links, most_movable));
  }

  void note_passed_over() {
    for (const Element& e : root_.children()) {
      const std::string tag = e.tag();
      if (tag != "link" && tag != "joint" && tag != "material" && tag != "transmission")
        passed_over_.insert("<" + shown(tag) + ">");
    }
    if (passed_over_.empty()) return;
    std::string list;
    for (const std::string& what : passed_over_) list += (list.empty() ? "" : ", ") + what;
    robot_.notes.push_back("passed over: " + list);
  }

  [[noreturn]] void refuse(int line, const std::string& what) const {
    throw std::invalid_argument(fmt::format("{}:{}: {}", robot_.file.string(), line, what));
  }

  tinyxml2::XMLDocument document_;
  std::filesystem::path file_;
  Element root_;
  Robot robot_;
  std::map<std::string, int> link_index_, joint_index_;
  std::map<std::string, std::string> colors_;
  std::set<std::string> passed_over_;
};

}  // namespace

Robot read_robot(const std::filesystem::path& file) {
  Reader reader(file);
  return reader.read();
}

}  // namespace flexura::import::urdf
