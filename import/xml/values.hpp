// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/model/findings.hpp"
#include "import/xml/node.hpp"

/// Values of attributes and texts.  What is not what it should be is a fault, and `otherwise` goes on in its place.
namespace flexura::import::xml {

std::string_view trimmed(std::string_view text);
std::vector<std::string> words(std::string_view text);

/// Of C's syntax in the "C" locale, at most 1e40 in size; nothing where the text is anything else.
std::optional<double> parse_number(std::string_view text);

/// "inf", or a number too large for a quantity: what programs write for none.
bool is_unbounded(std::string_view text);

/// All numbers of a text between spaces; nothing where a word is none.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

double number(const Node& node, std::string_view attribute, double otherwise, Findings& findings);
/// Empty without the attribute.
std::vector<double> numbers(const Node& node, std::string_view attribute, Findings& findings);
Eigen::Vector3d vector(const Node& node, std::string_view attribute, const Eigen::Vector3d& otherwise,
                       Findings& findings);
/// "true" and "1", "false" and "0".
bool flag(const Node& node, std::string_view attribute, bool otherwise, Findings& findings);

}  // namespace flexura::import::xml
