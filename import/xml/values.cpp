// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/xml/values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "import/model/mechanism.hpp"

namespace flexura::import::xml {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\f\v";

void add_wrong(const Node& node, std::string_view attribute, const std::string& wanted, Findings& findings) {
  xml::fault(findings, node,
             fmt::format("{} of <{}> is \"{}\", {} wanted; correct it", attribute, shown(node.tag),
                         shown(node.get(attribute)), wanted));
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> list;
  for (std::size_t at = text.find_first_not_of(kSpaces); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpaces, at), text.size());
    list.emplace_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpaces, end);
  }
  return list;
}

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  constexpr double most = 1e40;  // as of every input file
  if (error == std::errc::result_out_of_range) return {};
  if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= most)) return {};
  return value;
}

bool is_unbounded(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return end == text.data() + text.size() && !text.empty() && !std::isnan(value) && !parse_number(text);
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> values;
  for (const std::string& word : words(text)) {
    const auto value = parse_number(word);
    if (!value) return {};
    values.push_back(*value);
  }
  return values;
}

double number(const Node& node, std::string_view attribute, double otherwise, Findings& findings) {
  const std::string* const text = node.find(attribute);
  if (text == nullptr) return otherwise;
  const auto value = parse_number(*text);
  if (!value) add_wrong(node, attribute, "a finite number is", findings);
  return value.value_or(otherwise);
}

std::vector<double> numbers(const Node& node, std::string_view attribute, Findings& findings) {
  const std::string* const text = node.find(attribute);
  if (text == nullptr) return {};
  const auto values = parse_numbers(*text);
  if (!values) add_wrong(node, attribute, "finite numbers are", findings);
  return values.value_or(std::vector<double>{});
}

Eigen::Vector3d vector(const Node& node, std::string_view attribute, const Eigen::Vector3d& otherwise,
                       Findings& findings) {
  if (!node.has(attribute)) return otherwise;
  const auto values = parse_numbers(node.get(attribute));
  if (!values || values->size() != 3) {
    add_wrong(node, attribute, "three finite numbers are", findings);
    return otherwise;
  }
  return {(*values)[0], (*values)[1], (*values)[2]};
}

bool flag(const Node& node, std::string_view attribute, bool otherwise, Findings& findings) {
  const std::string* const text = node.find(attribute);
  if (text == nullptr) return otherwise;
  const std::string_view word = trimmed(*text);
  if (word == "true" || word == "1" || word == "True") return true;
  if (word == "false" || word == "0" || word == "False") return false;
  add_wrong(node, attribute, "true or false is", findings);
  return otherwise;
}

}  // namespace flexura::import::xml
