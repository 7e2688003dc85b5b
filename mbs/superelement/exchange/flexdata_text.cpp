// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/exchange/flexdata_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace flexura::superelement::flexdata {
namespace {

bool is_space(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

void blank(std::string& text, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k)
    if (text[k] != '\n') text[k] = ' ';
}

// "<tag" with nothing of a name behind it.
std::size_t find_tag(const std::string& lowered, const std::string& tag, std::size_t from) {
  for (std::size_t at = from; (at = lowered.find(tag, at)) != std::string::npos; ++at) {
    const std::size_t behind = at + tag.size();
    if (behind >= lowered.size() || is_space(lowered[behind]) || lowered[behind] == '>' ||
        lowered[behind] == '/')
      return at;
  }
  return std::string::npos;
}

std::optional<Block> find_block(const Text& text, const std::string& lowered, const std::string& tag,
                                const Element& in) {
  const std::size_t open = find_tag(lowered, "<" + tag, in.begin);
  if (open >= in.end) return std::nullopt;
  const std::size_t close = find_tag(lowered, "</" + tag, open);
  if (close >= in.end) text.fail(open, "<" + tag + "> is not closed; the file is cut short");
  return Block{open + tag.size() + 1, close};
}

void read_attributes(const Text& text, std::size_t at, Element& element) {
  const std::string& s = text.text;
  const auto skip = [&] {
    while (at < s.size() && is_space(s[at])) ++at;
  };
  const auto ends = [&] { return at >= s.size() || s[at] == '<' || s[at] == '>' || s[at] == '/'; };
  for (skip(); !ends(); skip()) {
    const std::size_t begin = at;
    while (!ends() && !is_space(s[at]) && s[at] != '=') ++at;
    const std::string name = lower(s.substr(begin, at - begin));
    skip();
    if (ends() || s[at] != '=')
      text.fail(begin, fmt::format("the attribute {} has no value; write {} = \"number\"", name.substr(0, 40),
                                   name.substr(0, 40)));
    ++at;
    skip();
    std::string value;
    if (!ends() && (s[at] == '"' || s[at] == '\'')) {
      const std::size_t close = s.find(s[at], at + 1);
      if (close == std::string::npos)
        text.fail(at, fmt::format("the value of {} is not closed by a quote", name.substr(0, 40)));
      value = s.substr(at + 1, close - at - 1);
      at = close + 1;
    } else {
      const std::size_t first = at;
      while (!ends() && !is_space(s[at])) ++at;
      value = s.substr(first, at - first);
    }
    if (!element.attributes.emplace(name, std::pair{value, begin}).second)
      text.fail(begin, fmt::format("the attribute {} is given twice", name.substr(0, 40)));
  }
}

// All ModeLoad blocks, with their loadcase_id.
void find_loads(const Text& text, const std::string& lowered, Element& element) {
  const std::string name = "modeload";
  for (std::size_t at = element.begin; (at = find_tag(lowered, "<" + name, at)) < element.end;) {
    const std::size_t close = lowered.find('>', at), end = find_tag(lowered, "</" + name, at);
    if (close == std::string::npos || end == std::string::npos || end > element.end)
      text.fail(at, "the ModeLoad block is not closed; the file is cut short");
    Element own{.begin = at};
    read_attributes(text, at + 1 + name.size(), own);
    element.loads.push_back({{close + 1, end}, own.whole(text, "loadcase_id")});
    at = end;
  }
}

}  // namespace

void Text::fail(std::size_t at, const std::string& what) const {
  const auto place = text.begin() + static_cast<std::ptrdiff_t>(std::min(at, text.size()));
  throw std::invalid_argument(
      fmt::format("{}:{}: {}", file, 1 + std::count(text.begin(), place, '\n'), what));
}

std::optional<int> Element::whole(const Text& text, const std::string& name) const {
  const auto found = attributes.find(name);
  if (found == attributes.end()) return std::nullopt;
  const auto& [value, at] = found->second;
  const auto first = value.find_first_not_of(" \t\r\n"), last = value.find_last_not_of(" \t\r\n");
  int number = -1;
  if (first != std::string::npos) {
    const char* const stop = value.data() + last + 1;
    const auto [at_stop, failure] = std::from_chars(value.data() + first, stop, number);
    if (failure != std::errc() || at_stop != stop) number = -1;
  }
  if (number < 0)
    text.fail(at, fmt::format("{} = \"{}\" is no whole number from 0 on", name, value.substr(0, 20)));
  return number;
}

int Element::required(const Text& text, const std::string& name) const {
  const std::optional<int> number = whole(text, name);
  if (!number) text.fail(begin, fmt::format("the attribute {} = \"number\" is missing", name));
  if (*number > 10'000'000)
    text.fail(attributes.at(name).second, fmt::format("{} = {} cannot be", name, *number));
  return *number;
}

std::string without_comments(std::string text) {
  for (std::size_t at = 0; (at = text.find("<!--", at)) != std::string::npos; at += 4) {
    std::size_t close = at + 4;
    for (; (close = text.find("--", close)) != std::string::npos; ++close) {
      std::size_t end = close + 2;
      while (end < text.size() && is_space(text[end])) ++end;
      if (end < text.size() && text[end] == '>') break;
    }
    // One that is not closed as XML wants it ends at its ">", as a tag does.
    if (close == std::string::npos || text.find("<!--", at + 4) < close) continue;
    blank(text, at, text.find('>', close) + 1);
  }
  for (const std::string mark : {"<![CDATA[", "]]>"})
    for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos;)
      blank(text, at, at + mark.size());
  return text;
}

std::vector<Element> elements_of(const Text& text) {
  const std::string lowered = lower(text.text), name = "reference_flexdata";
  std::vector<Element> out;
  for (std::size_t at = 0; (at = find_tag(lowered, "<" + name, at)) != std::string::npos;) {
    Element element{.begin = at, .end = find_tag(lowered, "</" + name, at)};
    const std::size_t next = find_tag(lowered, "<" + name, at + 1);
    if (element.end == std::string::npos || next < element.end)
      text.fail(at, "Reference_FlexData is not closed; the file is cut short");
    read_attributes(text, at + 1 + name.size(), element);
    out.push_back(std::move(element));
    at = out.back().end;
  }
  if (out.empty()) {
    const std::string_view begin = std::string_view(text.text).substr(0, 4);
    if (begin.starts_with("\xff\xfe") || begin.starts_with("\xfe\xff") ||
        begin.find('\0') != std::string_view::npos)
      text.fail(0, "is written in UTF-16 or UTF-32; save it as UTF-8");
    text.fail(0, "holds no Reference_FlexData");
  }
  for (Element& element : out) {
    const auto modes = find_block(text, lowered, "modedata", element),
               nodes = find_block(text, lowered, "nodedata", element);
    if (!modes) text.fail(element.begin, "has no ModeData block");
    if (!nodes) text.fail(element.begin, "has no NodeData block");
    element.modes = *modes, element.nodes = *nodes;
    find_loads(text, lowered, element);
  }
  return out;
}

const Element& chosen(const Text& text, const std::vector<Element>& elements, std::optional<int> id) {
  std::vector<int> ids;
  for (const Element& element : elements) ids.push_back(element.required(text, "id"));
  if (!id) {
    if (elements.size() == 1) return elements.front();
    text.fail(elements[1].begin,
              fmt::format("holds {} bodies (id {}); choose one by a part file with [flexdata], file = \"{}\" "
                          "and id = {}",
                          elements.size(), fmt::join(ids, ", "),
                          std::filesystem::path(text.file).filename().string(), ids.front()));
  }
  const auto n = std::ranges::count(ids, *id);
  if (n != 1)
    text.fail(elements.front().begin,
              n == 0 ? fmt::format("holds no body of id {}; it has {}", *id, fmt::join(ids, ", "))
                     : fmt::format("holds {} bodies of id {}; give them ids that differ", n, *id));
  return elements[static_cast<std::size_t>(std::ranges::find(ids, *id) - ids.begin())];
}

}  // namespace flexura::superelement::flexdata
