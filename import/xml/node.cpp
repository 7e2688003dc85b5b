// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/xml/node.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "import/xml/values.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::import::xml {
namespace {

Node copied(const tinyxml2::XMLElement& xml, const std::shared_ptr<const std::filesystem::path>& file) {
  Node node;
  node.tag = xml.Name();
  node.text = trimmed(xml.GetText() == nullptr ? "" : xml.GetText());
  node.file = file;
  node.line = xml.GetLineNum();
  for (const tinyxml2::XMLAttribute* a = xml.FirstAttribute(); a != nullptr; a = a->Next())
    node.attributes.emplace_back(a->Name(), a->Value());
  for (const tinyxml2::XMLElement* e = xml.FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
    node.children.push_back(copied(*e, file));
  return node;
}

bool is_in(const Node& node, const std::filesystem::path& file) {
  return !node.file || *node.file == file || *node.file == file.lexically_normal();
}

// Findings know the lines of one file.
std::string in_another_file(const Node& node, const std::string& text) {
  return fmt::format("{} ({})", text, node.place());
}

// Attributes are compared with all before them while they are read.
bool has_crowded_element(const std::string& text) {
  constexpr std::ptrdiff_t most_attributes = 1000;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::string_view tag(text.data() + at, std::min(text.find('>', at), text.size()) - at);
    if (std::ranges::count(tag, '=') > most_attributes) return true;
  }
  return false;
}

}  // namespace

const std::string* Node::find(std::string_view attribute) const {
  const auto found = std::ranges::find(attributes, attribute, &std::pair<std::string, std::string>::first);
  return found == attributes.end() ? nullptr : &found->second;
}

std::string Node::get(std::string_view attribute, const std::string& otherwise) const {
  const std::string* const value = find(attribute);
  return value == nullptr ? otherwise : *value;
}

void Node::set(const std::string& attribute, const std::string& value) {
  const auto found = std::ranges::find(attributes, attribute, &std::pair<std::string, std::string>::first);
  if (found == attributes.end())
    attributes.emplace_back(attribute, value);
  else
    found->second = value;
}

const Node* Node::child(std::string_view wanted) const {
  const auto found = std::ranges::find(children, wanted, &Node::tag);
  return found == children.end() ? nullptr : &*found;
}

std::vector<const Node*> Node::all(std::string_view wanted) const {
  std::vector<const Node*> list;
  for (const Node& c : children)
    if (c.tag == wanted) list.push_back(&c);
  return list;
}

std::string Node::place() const {
  return fmt::format("{}:{}", file ? file->string() : "", line);
}

void fault(Findings& findings, const Node& at, const std::string& text) {
  if (is_in(at, findings.file()))
    findings.fault(text, at.line);
  else
    findings.fault(in_another_file(at, text));
}

void repair(Findings& findings, const Node& at, const std::string& kind, const std::string& text) {
  if (is_in(at, findings.file()))
    findings.repair(kind, text, at.line);
  else
    findings.repair(kind, in_another_file(at, text));
}

void note(Findings& findings, const Node& at, const std::string& kind, const std::string& text) {
  if (is_in(at, findings.file()))
    findings.note(kind, text, at.line);
  else
    findings.note(kind, in_another_file(at, text));
}

namespace {

// What TinyXML 1 took and XML has not: <visual name=blade>, and <?xml ...?> behind a comment.
std::string mended(const std::string& text, bool& any) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto copy_to = [&](const char* end) {
      const std::size_t found = text.find(end, at);
      const std::size_t next =
          found == std::string::npos ? text.size() : found + std::string_view(end).size();
      out.append(text, at, next - at);
      at = next;
    };
    if (text.compare(at, 4, "<!--") == 0) {
      copy_to("-->");
    } else if (text.compare(at, 9, "<![CDATA[") == 0) {
      copy_to("]]>");
    } else if (text.compare(at, 5, "<?xml") == 0 && out.find('<') != std::string::npos) {
      at = std::min(text.find("?>", at), text.size() - 2) + 2;
      any = true;
    } else if (text[at] == '<') {
      for (char quote = 0; at < text.size(); ++at) {
        const char c = text[at];
        out += c;
        if (quote != 0) {
          if (c == quote) quote = 0;
        } else if (c == '"' || c == '\'') {
          quote = c;
        } else if (c == '>') {
          ++at;
          break;
        } else if (c == '=' && at + 1 < text.size() &&
                   std::string_view("\"' \t\r\n>").find(text[at + 1]) == std::string_view::npos) {
          const std::size_t end = std::min(text.find_first_of(" \t\r\n/>\"'", at + 1), text.size());
          out += '"' + text.substr(at + 1, end - at - 1) + '"';
          at = end - 1;
          any = true;
        }
      }
    } else {
      out += text[at++];
    }
  }
  return out;
}

Node read(const std::filesystem::path& file, const std::string& kind, Findings* findings) {
  const auto refuse = [&](const std::string& where, const std::string& why) {
    throw std::invalid_argument(fmt::format("{}: is no {}: {}", where, kind, why));
  };
  files::note_input(file);
  std::error_code none;
  std::ifstream in(file, std::ios::binary);
  if (!in || !std::filesystem::is_regular_file(file, none))
    throw std::invalid_argument(file.string() + ": cannot be read; check the name");
  constexpr std::uintmax_t most_bytes = 256U << 20U;
  if (std::filesystem::file_size(file, none) > most_bytes)
    refuse(file.string(), "it is larger than 256 MiB; take out what is no mechanism");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.find('\0') != std::string::npos) refuse(file.string(), "it holds zero bytes, XML text is wanted");
  if (has_crowded_element(text)) refuse(file.string(), "an element has more than 1000 attributes");
  tinyxml2::XMLDocument document;
  bool mends = false;
  if (findings != nullptr && document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    const int line = document.ErrorLineNum();
    const std::string again = mended(text, mends);
    if (mends) {
      text = again;
      findings->repair("texts that are not XML",
                       "values of attributes without quotes get them, <?xml ...?> behind a comment goes",
                       line);
    }
  }
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    refuse(fmt::format("{}:{}", file.string(), std::max(1, document.ErrorLineNum())),
           document.ErrorID() == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED
               ? "its elements are nested too deep; no robot's are"
               : "it is not well-formed XML (an element that is not closed, a stray character); close it or "
                 "take it out");
  if (document.RootElement() == nullptr)
    refuse(file.string() + ":1", "it has no element; give the root of a robot");
  return copied(*document.RootElement(), std::make_shared<const std::filesystem::path>(file));
}

}  // namespace

Node read(const std::filesystem::path& file, const std::string& kind) {
  return read(file, kind, nullptr);
}

Node read(const std::filesystem::path& file, const std::string& kind, Findings& findings) {
  return read(file, kind, &findings);
}

}  // namespace flexura::import::xml
