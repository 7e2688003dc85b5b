// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "import/model/findings.hpp"

namespace flexura::import::xml {

/// An element with all below it, free of the document that it was read from: readers may move, copy and extend it.
struct Node {
  std::string tag, text;  ///< text: the element's own, without spaces around it
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Node> children;
  std::shared_ptr<const std::filesystem::path> file;
  int line = 0;

  const std::string* find(std::string_view attribute) const;  ///< null where it is not there
  bool has(std::string_view attribute) const { return find(attribute) != nullptr; }
  std::string get(std::string_view attribute, const std::string& otherwise = {}) const;
  void set(const std::string& attribute, const std::string& value);
  const Node* child(std::string_view wanted) const;  ///< the first with this tag
  std::vector<const Node*> all(std::string_view wanted) const;
  std::string place() const;  ///< "FILE:LINE"
};

/// The outermost element of the file.  Nothing that it names is opened, no entity but XML's own five and characters by number
/// is expanded.  Throws std::invalid_argument "FILE:LINE: is no KIND: why": not there, not XML, nested too deep, too large.
Node read(const std::filesystem::path& file, const std::string& kind);

/// The same, with what older readers took mended and said: values of attributes without quotes, a declaration behind a comment.
Node read(const std::filesystem::path& file, const std::string& kind, Findings& findings);

/// The findings with the place of the element: a line of the file itself, or file and line of one that it includes.
void fault(Findings& findings, const Node& at, const std::string& text);
void repair(Findings& findings, const Node& at, const std::string& kind, const std::string& text);
void note(Findings& findings, const Node& at, const std::string& kind, const std::string& text);

}  // namespace flexura::import::xml
