// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/xml.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "mbs/base/files/inputs.hpp"

namespace flexura::import::urdf {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\f\v";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

// A macro anywhere means that the file is a template still.
void refuse_xacro(const std::filesystem::path& file, const tinyxml2::XMLElement& xml) {
  for (const tinyxml2::XMLElement* e = &xml; e != nullptr; e = e->NextSiblingElement()) {
    bool macro = std::string_view(e->Name()).starts_with("xacro:");
    for (const tinyxml2::XMLAttribute* a = e->FirstAttribute(); a != nullptr; a = a->Next())
      macro = macro || std::string_view(a->Value()).find("${") != std::string_view::npos ||
              std::string_view(a->Value()).find("$(") != std::string_view::npos;
    if (macro)
      Element(file, *e).refuse(
          fmt::format("<{}> holds a xacro macro that has not been expanded; make the URDF of it first: xacro "
                      "robot.xacro > robot.urdf",
                      shown(e->Name())));
    if (e->FirstChildElement() != nullptr) refuse_xacro(file, *e->FirstChildElement());
  }
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  constexpr double most = 1e40;  // as of every input file
  if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= most)) return {};
  return value;
}

std::optional<Element> Element::child(const char* tag) const {
  const tinyxml2::XMLElement* found = xml_->FirstChildElement(tag);
  if (found == nullptr) return {};
  if (const tinyxml2::XMLElement* second = found->NextSiblingElement(tag))
    Element(*file_, *second).refuse(fmt::format("a second <{}> in <{}>; take one away", tag, xml_->Name()));
  return Element(*file_, *found);
}

std::vector<Element> Element::children(const char* tag) const {
  std::vector<Element> list;
  for (const tinyxml2::XMLElement* e = xml_->FirstChildElement(tag); e != nullptr;
       e = e->NextSiblingElement(tag))
    list.emplace_back(*file_, *e);
  return list;
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
  if (trimmed(value).empty()) refuse(fmt::format("{} of <{}> is empty; give it", attribute, shown(tag())));
  return value;
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
  for (std::string_view rest = trimmed(all); !rest.empty();) {
    const auto end = rest.find_first_of(kSpaces);
    values.push_back(read_number(attribute, std::string(rest.substr(0, end))));
    rest = end == std::string_view::npos ? std::string_view() : trimmed(rest.substr(end));
  }
  if (values.size() != 3)
    refuse(fmt::format("{} of <{}> has {} numbers, 3 are wanted", attribute, shown(tag()), values.size()));
  return {values[0], values[1], values[2]};
}

Pose Element::origin() const {
  const auto element = child("origin");
  if (!element) return {};
  const Eigen::Vector3d rpy = element->vector("rpy", Eigen::Vector3d::Zero());
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x()), cp = std::cos(rpy.y()), sp = std::sin(rpy.y()),
               cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  Pose X;
  X.R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,     //
      -sp, cp * sr, cp * cr;
  X.p = element->vector("xyz", Eigen::Vector3d::Zero());
  return X;
}

void Element::refuse(const std::string& what) const {
  throw std::invalid_argument(fmt::format("{}:{}: {}", file_->string(), line(), what));
}

Element open_robot(const std::filesystem::path& file, tinyxml2::XMLDocument& document) {
  files::note_input(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::invalid_argument(file.string() + ": cannot be read; check the name");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
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
  refuse_xacro(file, *root);
  return {file, *root};
}

}  // namespace flexura::import::urdf
