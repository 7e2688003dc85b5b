// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/ask.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <istream>
#include <optional>
#include <ostream>
#include <stdexcept>

#include "import/cad/joints/decide.hpp"

namespace flexura::import {
namespace {

using Type = cad::JointForm::Type;

constexpr std::array kTypes = {Type::fixed,       Type::revolute, Type::prismatic, Type::screw,
                               Type::cylindrical, Type::planar,   Type::spherical};

std::string type_names() {
  std::vector<std::string> names;
  for (const Type type : kTypes) names.emplace_back(cad::name_of(type));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::optional<Type> type_called(const std::string& name) {
  const auto found = std::ranges::find_if(kTypes, [&](Type type) { return name == cad::name_of(type); });
  return found == kTypes.end() ? std::nullopt : std::optional(*found);
}

std::string word_of(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : line.substr(first, last - first + 1);
}

}  // namespace

void ask_about_joints(const cad::Assembly& assembly, cad::Proposal& proposal,
                      const std::vector<std::string>& names, std::istream& in, std::ostream& out) {
  std::vector<cad::ProposedJoint> kept;
  const std::size_t n = proposal.joints.size();
  bool all = false;
  for (std::size_t i = 0; i < n; ++i) {
    cad::ProposedJoint& joint = proposal.joints[i];
    const std::string between =
        names[static_cast<std::size_t>(joint.a)] + " and " + names[static_cast<std::size_t>(joint.b)];
    if (!all) {
      out << fmt::format("\njoint {} of {}: {}, {}, confidence {}{}\n", i + 1, n, between,
                         cad::name_of(joint.form.type), cad::name_of(joint.confidence),
                         joint.doubt.empty() ? "" : ": " + joint.doubt);
      for (const std::string& line : joint.evidence) out << "  " << line << '\n';
    }
    while (!all) {
      out << fmt::format("[y]es, [n]o, another type ({}), [a]ll from here as proposed, [q]uit? ",
                         type_names())
          << std::flush;
      std::string line;
      if (!std::getline(in, line))
        throw std::invalid_argument(
            fmt::format("the answers end before joint {} of {} ({}); answer all, or \"a\" for the "
                        "others, or take --joints propose",
                        i + 1, n, between));
      const std::string word = word_of(line);
      if (word == "q" || word == "quit")
        throw std::invalid_argument(fmt::format(
            "stopped at joint {} of {}, nothing is written; start again, or take --joints propose", i + 1,
            n));
      if (word == "a" || word == "all") {
        all = true;
      } else if (word == "n" || word == "no") {
        break;
      } else if (const auto type = type_called(word); type) {
        if (*type != joint.form.type)
          joint.evidence.push_back(fmt::format("proposed was {}", cad::name_of(joint.form.type)));
        cad::change_type(assembly, joint, *type);
        kept.push_back(joint);
        break;
      } else if (word.empty() || word == "y" || word == "yes") {
        kept.push_back(joint);
        break;
      } else {
        out << fmt::format("\"{}\" is no answer\n", shown(word));
      }
    }
    if (all) kept.push_back(joint);
  }
  out << '\n';
  proposal.joints = std::move(kept);
}

}  // namespace flexura::import
