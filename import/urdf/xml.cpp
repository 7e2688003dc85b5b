// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/xml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>

namespace flexura::import::urdf {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\f\v";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

bool holds_macro(const tinyxml2::XMLElement& e) {
  for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a != nullptr; a = a->Next())
    if (const std::string_view value = a->Value();
        value.find("${") != std::string_view::npos || value.find("$(") != std::string_view::npos)
      return true;
  return false;
}

// Calls of macros that the file defines, conditions, and what stands in links and joints (`inside`).  Definitions that nothing uses
// change nothing.
const tinyxml2::XMLElement* template_in(const tinyxml2::XMLElement& xml, bool inside,
                                        const std::set<std::string>& macros) {
  constexpr std::string_view words[] = {"if", "unless", "insert_block", "attribute", "element", "call"};
  for (const tinyxml2::XMLElement* e = xml.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string_view name = e->Name();
    const bool is_xacro = name.starts_with("xacro:");
    const std::string word(is_xacro ? name.substr(6) : "");
    if (is_xacro && (inside || macros.contains(word) || std::ranges::find(words, word) != std::end(words)))
      return e;
    if (is_xacro || name == "gazebo" || name == "transmission") continue;
    const bool part = inside || name == "link" || name == "joint";
    if (part && holds_macro(*e) && name != "mesh" && name != "texture") return e;
    if (const auto* found = template_in(*e, part, macros)) return found;
  }
  return nullptr;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  constexpr double most = 1e40;  // as of every input file
  if (error == std::errc::result_out_of_range && text.find("e-") != std::string_view::npos) return 0.0;
  if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= most)) return {};
  return value;
}

std::optional<Element> Element::child(const char* tag) const {
  const tinyxml2::XMLElement* found = xml_->FirstChildElement(tag);
  if (found == nullptr) return {};
  const Element first(*findings_, *found);
  if (const tinyxml2::XMLElement* second = found->NextSiblingElement(tag);
      second != nullptr && Element(*findings_, *second).whole() != first.whole())
    findings_->repair("elements given twice",
                      fmt::format("a second <{}> in <{}>: the first, of line {}, is taken; take one away",
                                  tag, xml_->Name(), first.line()),
                      second->GetLineNum());
  return first;
}

std::vector<Element> Element::children(const char* tag) const {
  std::vector<Element> list;
  for (const tinyxml2::XMLElement* e = xml_->FirstChildElement(tag); e != nullptr;
       e = e->NextSiblingElement(tag))
    list.emplace_back(*findings_, *e);
  return list;
}

bool Element::has(const char* attribute) const {
  const char* const value = xml_->Attribute(attribute);
  return value != nullptr && !trimmed(value).empty();
}

std::vector<Element> Element::children() const {
  return children(nullptr);
}

std::string Element::text() const {
  return std::string(trimmed(xml_->GetText() == nullptr ? "" : xml_->GetText()));
}

std::string Element::text(const char* attribute) const {
  const char* const value = xml_->Attribute(attribute);
  if (value == nullptr) refuse(fmt::format("<{}> has no {}; give it", shown(tag()), attribute));
  const std::string_view text = trimmed(value);
  if (text.empty()) refuse(fmt::format("{} of <{}> is empty; give it", attribute, shown(tag())));
  return std::string(text);
}

double Element::read_number(const char* attribute, const std::string& text) const {
  const auto value = parse_number(text);
  if (!value)
    refuse(
        fmt::format("{} of <{}> is \"{}\", a finite number is wanted", attribute, shown(tag()), shown(text)));
  return *value;
}

double Element::number(const char* attribute) const {
  return read_number(attribute, text(attribute));
}

double Element::number(const char* attribute, double otherwise) const {
  return has(attribute) ? number(attribute) : otherwise;
}

Eigen::Vector3d Element::vector(const char* attribute, const Eigen::Vector3d& otherwise) const {
  if (!has(attribute)) return otherwise;
  const std::string all = text(attribute);
  std::vector<double> values;
  // Commas stand between all of them or between none: "0,5 1" may be two numbers of another country.
  const bool commas = std::ranges::count(all, ',') == 2;
  const auto part = [&](char c) { return (commas && c == ',') || kSpaces.find(c) != std::string_view::npos; };
  for (auto at = all.begin(); at != all.end();) {
    const auto end = std::find_if(at, all.end(), part);
    if (at != end) values.push_back(read_number(attribute, std::string(at, end)));
    at = std::find_if_not(end, all.end(), part);
  }
  if (values.size() != 3)
    refuse(fmt::format("{} of <{}> has {} numbers, 3 are wanted", attribute, shown(tag()), values.size()));
  return {values[0], values[1], values[2]};
}

Pose Element::origin() const {
  const auto element = child("origin");
  if (!element) return {};
  const Eigen::Vector3d rpy = element->vector("rpy", Eigen::Vector3d::Zero());
  if (constexpr double turn = 6.2832; rpy.cwiseAbs().maxCoeff() > turn)
    findings_->note("angles of more than a turn",
                    fmt::format("rpy of <origin> is {} {} {}: taken as radians, as a URDF has them", rpy.x(),
                                rpy.y(), rpy.z()),
                    element->line());
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x()), cp = std::cos(rpy.y()), sp = std::sin(rpy.y()),
               cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  Pose X;
  X.R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,     //
      -sp, cp * sr, cp * cr;
  X.p = element->vector("xyz", Eigen::Vector3d::Zero());
  return X;
}

std::string Element::whole() const {
  tinyxml2::XMLPrinter printer(nullptr, true);
  xml_->Accept(&printer);
  return printer.CStr();
}

void Element::refuse(const std::string& what) const {
  throw std::invalid_argument(fmt::format("{}:{}: {}", findings_->file().string(), line(), what));
}

std::optional<Element> find_template(const Element& robot) {
  std::set<std::string> macros;
  for (const Element& macro : robot.children("xacro:macro"))
    if (macro.has("name")) macros.insert(macro.text("name"));
  if (const auto* found = template_in(*robot.xml_, false, macros)) return Element(*robot.findings_, *found);
  return {};
}

Element open_robot(const std::string& text, Findings& findings, tinyxml2::XMLDocument& document) {
  const std::filesystem::path& file = findings.file();
  if (text.find('\0') != std::string::npos)
    throw std::invalid_argument(file.string() + ": is no URDF: it holds zero bytes, XML text is wanted");
  // Attributes are compared with all before them while they are read.
  constexpr std::ptrdiff_t kMostAttributes = 1000;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1))
    if (const std::string_view tag(text.data() + at, std::min(text.find('>', at), text.size()) - at);
        std::ranges::count(tag, '=') > kMostAttributes)
      throw std::invalid_argument(fmt::format("{}: is no URDF: an element has more than {} attributes",
                                              file.string(), kMostAttributes));
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    const char* const why =
        document.ErrorID() == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED
            ? "its elements are nested too deep"
            : "it is not well-formed XML (an element that is not closed, a stray character)";
    throw std::invalid_argument(
        fmt::format("{}:{}: is no URDF: {}", file.string(), std::max(1, document.ErrorLineNum()), why));
  }
  const tinyxml2::XMLElement* const root = document.RootElement();
  if (root == nullptr || std::string_view(root->Name()) != "robot")
    throw std::invalid_argument(
        fmt::format("{}:{}: is no URDF: its outermost element is <{}>, <robot> is wanted", file.string(),
                    root == nullptr ? 1 : root->GetLineNum(), root == nullptr ? "" : shown(root->Name())));
  return {findings, *root};
}

}  // namespace flexura::import::urdf
