// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/templates.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "import/urdf/xml.hpp"

namespace flexura::import::urdf {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Each "${...}" and "$(...)" of the text that is not harmless; "$${" is an escape.
void find_code(const std::string& text, int line, std::vector<Place>& code) {
  for (std::size_t at = text.find('$'); at != std::string::npos; at = text.find('$', at + 1)) {
    if (at + 1 == text.size()) return;
    const char open = text[at + 1];
    if (open == '$') {
      ++at;
      continue;
    }
    if (open != '{' && open != '(') continue;
    const std::size_t end = text.find(open == '{' ? '}' : ')', at);
    const std::string inside = text.substr(at + 2, end == std::string::npos ? end : end - at - 2);
    const bool harmless = open == '{' ? is_arithmetic(inside)
                                      : inside.starts_with("find ") || inside.starts_with("arg ") ||
                                            inside == "dirname" || inside == "cwd";
    if (!harmless || end == std::string::npos) code.push_back({line, text.substr(at, end - at + 1)});
  }
}

void look_below(const tinyxml2::XMLElement& xml, Template& out) {
  for (const tinyxml2::XMLNode* node = xml.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (const tinyxml2::XMLText* text = node->ToText())
      find_code(text->Value(), node->GetLineNum(), out.code);
    const tinyxml2::XMLElement* const e = node->ToElement();
    if (e == nullptr) continue;
    for (const tinyxml2::XMLAttribute* a = e->FirstAttribute(); a != nullptr; a = a->Next()) {
      // Conditions and properties are evaluated without "${" as well.
      const std::string_view name = e->Name();
      const bool is_formula = name == "xacro:if" || name == "xacro:unless" || name == "xacro:property";
      find_code(a->Value(), e->GetLineNum(), out.code);
      if (is_formula && std::string_view(a->Value()).find('$') == std::string_view::npos &&
          std::string_view(a->Value()).find("(") != std::string_view::npos && !is_arithmetic(a->Value()))
        out.code.push_back({e->GetLineNum(), a->Value()});
    }
    if (std::string_view(e->Name()) == "xacro:include")
      out.includes.push_back(
          {e->GetLineNum(), e->Attribute("filename") == nullptr ? "" : e->Attribute("filename")});
    look_below(*e, out);
  }
}

}  // namespace

bool is_arithmetic(const std::string& expression) {
  static constexpr std::array functions = {"abs", "acos", "asin", "atan", "atan2", "ceil", "cos", "degrees",
                                           "exp", "float", "floor", "int", "log", "max", "min", "pow",
                                           "radians", "round", "sin", "sqrt", "tan",
                                           // words of Python between values
                                           "and", "or", "not", "if", "else", "in"};
  for (std::size_t at = 0; at < expression.size();) {
    const char c = expression[at];
    std::size_t end = at + 1;
    if (is_letter(c)) {
      while (end < expression.size() && (is_letter(expression[end]) || is_digit(expression[end]))) ++end;
      const std::string word = expression.substr(at, end - at);
      const std::size_t next = expression.find_first_not_of(' ', end);
      const bool is_called = next != std::string::npos && expression[next] == '(';
      if (word.find("__") != std::string::npos || word == "lambda" || word == "for") return false;
      if (is_called && std::ranges::find(functions, word) == functions.end()) return false;
    } else if (is_digit(c) || c == '.') {
      // A number; a point behind a name would be an attribute.
      if (c == '.' && (at == 0 || !is_digit(expression[at - 1])) &&
          (end == expression.size() || !is_digit(expression[end])))
        return false;
    } else if (c == '\'' || c == '"') {
      end = expression.find(c, at + 1);
      if (end == std::string::npos) return false;
      ++end;
    } else if (std::string_view(" \t\r\n+-*/%(),<>=!").find(c) == std::string_view::npos) {
      return false;
    }
    // Powers of powers fill any memory.
    if (c == '*' && end < expression.size() && expression[end] == '*') {
      const std::size_t digit = expression.find_first_not_of(' ', end + 1);
      if (digit == std::string::npos || !is_digit(expression[digit])) return false;
      end = digit + 1;
      const std::size_t next = expression.find_first_not_of(' ', end);
      if (end < expression.size() && (is_digit(expression[end]) || expression[end] == '.')) return false;
      if (next != std::string::npos && expression.compare(next, 2, "**") == 0) return false;
    }
    // "a.b" is an attribute, "1.e" is not.
    if (is_letter(c) && end < expression.size() && expression[end] == '.') return false;
    at = end;
  }
  return true;
}

Template look_through(const std::string& text, const std::filesystem::path& file) {
  Findings none(file);
  tinyxml2::XMLDocument document;
  const Element robot = open_robot(text, none, document);
  Template out;
  if (const auto first = find_template(robot)) out.first = {first->line(), first->tag()};
  look_below(*document.RootElement(), out);
  return out;
}

}  // namespace flexura::import::urdf
