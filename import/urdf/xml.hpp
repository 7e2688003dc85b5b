// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"

/// Checked access to the XML of a URDF: every refusal names file, line, element and attribute.
namespace flexura::import::urdf {

class Element {
 public:
  Element(const std::filesystem::path& file, const tinyxml2::XMLElement& xml) : file_(&file), xml_(&xml) {}

  std::string tag() const { return xml_->Name(); }
  int line() const { return xml_->GetLineNum(); }
  std::optional<Element> child(const char* tag) const;
  std::vector<Element> children(const char* tag) const;
  std::vector<Element> children() const;

  bool has(const char* attribute) const { return xml_->Attribute(attribute) != nullptr; }
  std::string text() const;                       ///< the element's own, without spaces around it
  std::string text(const char* attribute) const;  ///< must be there and not be empty
  double number(const char* attribute) const;     ///< must be there, finite
  double number(const char* attribute, double otherwise) const;
  Eigen::Vector3d vector(const char* attribute, const Eigen::Vector3d& otherwise) const;
  /// xyz and rpy of the child "origin", R = R_z(yaw) R_y(pitch) R_x(roll); the identity without it.
  Pose origin() const;

  /// Throws std::invalid_argument "FILE:LINE: what".
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  double read_number(const char* attribute, const std::string& text) const;

  const std::filesystem::path* file_;
  const tinyxml2::XMLElement* xml_;
};

/// Reads and parses; `document` must live as long as the elements.  Throws std::invalid_argument (not XML, no <robot>, xacro
/// that was not expanded) and std::runtime_error (cannot be read).
Element open_robot(const std::filesystem::path& file, tinyxml2::XMLDocument& document);

/// A number of C's syntax in the "C" locale, at most 1e40 in size; nothing where the text is anything else.
std::optional<double> parse_number(std::string_view text);

}  // namespace flexura::import::urdf
