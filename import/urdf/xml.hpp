// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "import/model/findings.hpp"
#include "import/model/mechanism.hpp"

/// Checked access to the XML of a URDF: every refusal names file, line, element and attribute.
namespace flexura::import::urdf {

class Element {
 public:
  Element(Findings& findings, const tinyxml2::XMLElement& xml) : findings_(&findings), xml_(&xml) {}

  std::string tag() const { return xml_->Name(); }
  int line() const { return xml_->GetLineNum(); }
  /// The first of this tag, as every reader takes it; that there are others is a repair.
  std::optional<Element> child(const char* tag) const;
  std::vector<Element> children(const char* tag) const;
  std::vector<Element> children() const;

  bool has(const char* attribute) const;  ///< with something in it
  std::string text() const;               ///< the element's own, without spaces around it
  std::string text(
      const char* attribute) const;            ///< must be there and not be empty; without spaces around it
  double number(const char* attribute) const;  ///< must be there, finite
  double number(const char* attribute, double otherwise) const;
  /// Three numbers with blanks or commas between them.
  Eigen::Vector3d vector(const char* attribute, const Eigen::Vector3d& otherwise) const;
  /// xyz and rpy of the child "origin", R = R_z(yaw) R_y(pitch) R_x(roll); the identity without it.
  Pose origin() const;
  /// The element with all in it, to be compared.
  std::string whole() const;

  /// Throws std::invalid_argument "FILE:LINE: what".
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  friend std::optional<Element> find_template(const Element& robot);
  double read_number(const char* attribute, const std::string& text) const;

  Findings* findings_;
  const tinyxml2::XMLElement* xml_;
};

/// Parses `text`, the content of the file; `document` and `findings` must live as long as the elements.  Throws
/// std::invalid_argument (not XML, no <robot>).
Element open_robot(const std::string& text, Findings& findings, tinyxml2::XMLDocument& document);

/// The first element that only xacro understands: a call of a macro that the file defines, a condition, or a link, joint or shape with
/// "${" or "$(" in it.  Calls of macros that nothing in the file defines are what an expansion left behind and do not count, nor do
/// definitions by themselves.
std::optional<Element> find_template(const Element& robot);

/// A number of C's syntax in the "C" locale, at most 1e40 in size; nothing where the text is anything else.
std::optional<double> parse_number(std::string_view text);

}  // namespace flexura::import::urdf
