// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

#include "import/urdf/read_elements.hpp"
#include "import/urdf/tree.hpp"
#include "import/urdf/xml.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::import::urdf {
namespace {

class Reader {
 public:
  Reader(const std::string& text, Findings& findings)
      : findings_(findings), root_(open_robot(text, findings, document_)) {
    robot_.file = findings.file();
    robot_.name = root_.has("name") ? root_.text("name") : robot_.file.stem().string();
  }

  Robot read() {
    if (const auto macro = find_template(root_))
      macro->refuse(
          fmt::format("<{}> holds a xacro macro that has not been expanded; make the URDF of it "
                      "first: xacro robot.xacro > robot.urdf",
                      shown(macro->tag())));
    for (const Element& material : root_.children("material")) note_color(material, colors_, findings_);
    read_named("link", [&](const Element& e) { add_link(e); });
    if (root_.children("link").empty()) root_.refuse("<robot> has no <link>; a mechanism needs one at least");
    read_named("joint", [&](const Element& e) { add_joint(e); });
    for (const auto& [joint, e] : with_mimic_) findings_.kept([&] { return read_mimic(joint, e); });
    for (const Element& transmission : root_.children("transmission")) read_transmission(transmission);
    for (const Element& gazebo : root_.children("gazebo")) read_gazebo(gazebo);
    note_passed_over();
    findings_.require_no_fault();
    require_size();
    order_tree(robot_, findings_);
    findings_.require_no_fault();
    return robot_;
  }

 private:
  // Of equal names the first; what stands in the file twice, alike, is one.
  template <class Add>
  void read_named(const char* tag, Add&& add) {
    std::map<std::string, std::string> seen;
    for (const Element& e : root_.children(tag)) {
      const std::string name = e.has("name") ? e.text("name") : "";
      const auto [first, is_new] = seen.emplace(name, e.whole());
      if (is_new || name.empty())
        add(e);
      else if (first->second == e.whole())
        findings_.note("elements given twice",
                       fmt::format("{} \"{}\" stands there twice, alike: once it is taken", tag, shown(name)),
                       e.line());
      else
        findings_.fault(fmt::format("a second {} \"{}\"; names must differ", tag, shown(name)), e.line());
    }
  }

  void add_link(const Element& e) {
    Link link = read_link(e, colors_, findings_);
    link_index_.emplace(link.name, static_cast<int>(robot_.links.size()));
    robot_.links.push_back(std::move(link));
  }

  // The ground is called "world" by Gazebo and MoveIt; many files have no link of this name.
  int link_of(const Element& joint, const char* tag, const std::string& name) {
    const auto end = joint.child(tag);
    if (!end) joint.refuse(fmt::format("joint \"{}\" has no <{}>; give it", name, tag));
    const std::string link = end->text("link");
    auto found = link_index_.find(link);
    if (found == link_index_.end() && link == "world" && std::string_view(tag) == "parent") {
      findings_.repair("links that are the ground",
                       fmt::format("the parent of joint \"{}\" is \"world\", which the file does not have: "
                                   "taken as the ground",
                                   name),
                       end->line());
      found = link_index_.emplace(link, static_cast<int>(robot_.links.size())).first;
      robot_.links.push_back({.name = link, .line = end->line()});
    }
    if (found == link_index_.end())
      end->refuse(
          fmt::format("the {} of joint \"{}\" is link \"{}\", which the file does not have; correct the name",
                      tag, name, shown(link)));
    return found->second;
  }

  void add_joint(const Element& e) {
    const std::string written = findings_.kept([&] { return e.text("name"); }), name = shown(written);
    Joint joint = read_joint(e, name, findings_);
    joint.name = written;
    joint.parent = findings_.kept([&] { return link_of(e, "parent", name); }, -1);
    joint.child = findings_.kept([&] { return link_of(e, "child", name); }, -1);
    for (const char* other : {"safety_controller", "calibration"})
      if (!e.children(other).empty()) passed_over_.insert(fmt::format("<{}>", other));
    const int index = static_cast<int>(robot_.joints.size());
    joint_index_.emplace(joint.name, index);
    if (const auto mimic = e.child("mimic")) with_mimic_.emplace_back(index, *mimic);
    robot_.joints.push_back(std::move(joint));
  }

  bool read_mimic(int self, const Element& mimic) {
    Joint& joint = robot_.joints[static_cast<std::size_t>(self)];
    if (joint.kind == JointKind::fixed) {
      findings_.note("fixed joints that mimic",
                     fmt::format("joint \"{}\" is fixed and mimics nothing", shown(joint.name)),
                     mimic.line());
      return false;
    }
    const std::string other = mimic.text("joint");
    const auto found = joint_index_.find(other);
    if (found == joint_index_.end())
      mimic.refuse(fmt::format("joint \"{}\" mimics \"{}\", which the file does not have; correct the name",
                               shown(joint.name), shown(other)));
    const Joint& leader = robot_.joints[static_cast<std::size_t>(found->second)];
    if (!has_one_coordinate(joint) || (!has_one_coordinate(leader) && leader.kind != JointKind::fixed))
      mimic.refuse(fmt::format("joint \"{}\" mimics \"{}\": both must be revolute, continuous or prismatic",
                               shown(joint.name), shown(other)));
    joint.mimic = Mimic{found->second, mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)};
    // Round and round?
    int at = found->second;
    for (std::size_t i = 0; i <= robot_.joints.size() && at >= 0; ++i) {
      if (at == self) {
        joint.mimic.reset();
        mimic.refuse(
            fmt::format("joint \"{}\" mimics itself, directly or by way of others; one of them must be free",
                        shown(joint.name)));
      }
      const auto& next = robot_.joints[static_cast<std::size_t>(at)].mimic;
      at = next ? next->joint : -1;
    }
    return true;
  }

  // It moves nothing by itself: one that cannot be followed is left out.
  void read_transmission(const Element& e) {
    const std::string name = e.has("name") ? e.text("name") : "transmission";
    const auto joints = e.children("joint"), actuators = e.children("actuator");
    const auto pass_over = [&](const std::string& why) {
      findings_.note("transmissions passed over",
                     fmt::format("transmission \"{}\" {}: it is passed over", shown(name), why), e.line());
    };
    if (joints.size() != 1 || actuators.size() > 1)
      return pass_over(fmt::format("joins {} joints with {} actuators, one of each is taken over",
                                   joints.size(), actuators.size()));
    const std::string joint = joints.front().has("name") ? joints.front().text("name") : "";
    const auto found = joint_index_.find(joint);
    if (found == joint_index_.end())
      return pass_over(fmt::format("drives joint \"{}\", which the file does not have", shown(joint)));
    if (!has_one_coordinate(robot_.joints[static_cast<std::size_t>(found->second)]))
      return pass_over(fmt::format("drives joint \"{}\", which has no single coordinate", shown(joint)));
    Transmission transmission{.name = name, .actuator = name, .joint = found->second};
    if (!actuators.empty() && actuators.front().has("name"))
      transmission.actuator = actuators.front().text("name");
    std::vector<Element> reductions = e.children("mechanicalReduction");
    for (const Element& actuator : actuators)
      for (const Element& r : actuator.children("mechanicalReduction")) reductions.push_back(r);
    for (const Element& r : joints.front().children("mechanicalReduction")) reductions.push_back(r);
    if (!reductions.empty()) {
      const auto value = parse_number(reductions.front().text());
      if (!value || *value == 0.0)
        return pass_over(fmt::format("has the mechanicalReduction \"{}\", a number other than 0 is wanted",
                                     shown(reductions.front().text())));
      transmission.reduction = *value;
    }
    robot_.transmissions.push_back(std::move(transmission));
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

  // Contacts of a link, and what Gazebo does beside the URDF.
  void read_gazebo(const Element& gazebo) {
    for (const Element& joint : gazebo.children("joint")) note_if_joins(joint);
    const auto link = link_index_.find(gazebo.has("reference") ? gazebo.text("reference") : "");
    if (link == link_index_.end()) return;
    read_touch(gazebo, robot_.links[static_cast<std::size_t>(link->second)].touch);
    const auto says = [&](const char* tag, std::string_view value, std::string_view other) {
      const auto list = gazebo.children(tag);
      return !list.empty() && (list.front().text() == value || list.front().text() == other);
    };
    if (says("turnGravityOff", "true", "1") || says("gravity", "false", "0"))
      findings_.note("links without weight in Gazebo",
                     fmt::format("link \"{}\" has no weight in Gazebo, but here", shown(link->first)),
                     gazebo.line());
  }

  // Loops and springs of extensions: what joins two links and is not taken over is said, and refused by --strict.
  void note_if_joins(const Element& e) {
    const auto both = [&](const char* one, const char* other) {
      return !e.children(one).empty() && !e.children(other).empty();
    };
    if (both("link1", "link2") || both("parent", "child") ||
        both("drake:bushing_frameA", "drake:bushing_frameC"))
      findings_.repair(
          "joints and springs of extensions that are left out",
          fmt::format("<{}> \"{}\" joins two links and is no joint of a URDF: left out, a loop stays "
                      "open; add it to the mechanism file",
                      shown(e.tag()), e.has("name") ? shown(e.text("name")) : ""),
          e.line());
  }

  void note_passed_over() {
    for (const Element& e : root_.children()) {
      const std::string tag = e.tag();
      if (tag == "link" || tag == "joint" || tag == "material" || tag == "transmission") continue;
      if (tag == "xacro:include")
        findings_.repair("included files that are left out",
                         fmt::format("\"{}\" is left out: xacro would include it, and it may hold links",
                                     e.has("filename") ? shown(e.text("filename")) : ""),
                         e.line());
      else
        passed_over_.insert("<" + shown(tag) + ">");
      note_if_joins(e);
    }
    for (const std::string& what : passed_over_)
      findings_.note("kinds of elements passed over", "passed over: " + what);
  }

  Findings& findings_;
  tinyxml2::XMLDocument document_;
  Element root_;
  Robot robot_;
  std::map<std::string, int> link_index_, joint_index_;
  std::vector<std::pair<int, Element>> with_mimic_;
  Colors colors_;
  std::set<std::string> passed_over_;
};

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  files::note_input(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::invalid_argument(file.string() + ": cannot be read; check the name");
  return {std::istreambuf_iterator<char>(in), {}};
}

Robot read_robot(const std::string& text, Findings& findings) {
  return Reader(text, findings).read();
}

}  // namespace flexura::import::urdf
