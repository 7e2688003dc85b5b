// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

/// The text of a FlexData file, cut into the Reference_FlexData of its bodies.  XML as programs and people write it: quotes of both
/// kinds or none, tabs, comments and CDATA anywhere, names in any case; and the example of MotionSolve's guide, which is no XML (tags that do not
/// match in case, "< ! -- -->" as a comment).
namespace flexura::superelement::flexdata {

struct Block {
  std::size_t begin = 0, end = 0;
};

struct Text {
  std::string file, text;
  /// "file:line: what".
  [[noreturn]] void fail(std::size_t at, const std::string& what) const;
};

/// A ModeLoad block.
struct LoadBlock {
  Block numbers;
  std::optional<int> id;  ///< loadcase_id
};

/// A body's element; places are those in the text.
struct Element {
  std::size_t begin = 0, end = 0;
  std::map<std::string, std::pair<std::string, std::size_t>>
      attributes;  ///< by name in small letters: value, place
  Block modes, nodes;
  std::vector<LoadBlock> loads;
  /// A whole number from 0 on; nothing where it is not given.  Throws for any other value.
  std::optional<int> whole(const Text& text, const std::string& name) const;
  int required(const Text& text, const std::string& name) const;
};

/// The same with comments and the marks of CDATA blank, so that places stay.
std::string without_comments(std::string text);

/// All bodies of a text without comments.  Throws std::invalid_argument where one is cut short, or there is none.
std::vector<Element> elements_of(const Text& text);

/// The one of this id, or the only one.  Throws std::invalid_argument with the ids that there are.
const Element& chosen(const Text& text, const std::vector<Element>& elements, std::optional<int> id);

}  // namespace flexura::superelement::flexdata
