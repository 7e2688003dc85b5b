// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_bindings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace flexura::mesh::abaqus {
namespace {

void take_coupling(const Keyword& k, Deck& deck) {
  TieKeyword tie{.what = k.name, .reference = k.get("REF NODE"), .where = k.where};
  if (k.name == "COUPLING") {
    tie.set = upper(k.get("SURFACE"));
    tie.orientation = upper(k.get("ORIENTATION"));
  } else {
    for (const char* word : {"TIE NSET", "PIN NSET", "ELSET"})
      if (k.has(word)) {
        tie.set = upper(k.get(word));
        if (std::string(word) == "PIN NSET") tie.dofs = {true, true, true, false, false, false};
      }
    if (k.has("ANALYTICAL SURFACE") || tie.set.empty()) {
      deck.unbound.add("*RIGID BODY without TIE NSET, PIN NSET or ELSET", k.where);
      return;
    }
  }
  deck.ties.push_back(std::move(tie));
}

// The lines "first dof, last dof" after *KINEMATIC and *DISTRIBUTING.
void take_coupled_dofs(const Keyword& k, Deck& deck) {
  if (deck.ties.empty() || deck.ties.back().what != "COUPLING")
    throw std::invalid_argument(fmt::format("{}: *{} without *COUPLING before it", k.where.text(), k.name));
  TieKeyword& tie = deck.ties.back();
  if (k.name == "DISTRIBUTING") tie.kind = ImportedTie::Kind::average;
  if (k.has("WEIGHTING METHOD") && upper(k.get("WEIGHTING METHOD")) != "UNIFORM")
    deck.unused.add("*DISTRIBUTING's WEIGHTING METHOD", k.where);
  if (k.data.empty()) return;
  tie.dofs.fill(false);
  for (const DataLine& line : k.data) {
    if (line.fields.empty() || line.fields[0].empty()) continue;
    const std::int64_t first = to_integer(line.fields[0], line.where),
                       last = line.fields.size() > 1 && !line.fields[1].empty()
                                  ? to_integer(line.fields[1], line.where)
                                  : first;
    for (std::int64_t d = std::max<std::int64_t>(first, 1); d <= std::min<std::int64_t>(last, 6); ++d)
      tie.dofs[static_cast<std::size_t>(d - 1)] = true;
  }
}

void take_mpc(const Keyword& k, Deck& deck) {
  for (const DataLine& line : k.data) {
    if (line.fields.size() < 3) continue;
    const std::string type = upper(line.fields[0]);
    if (type != "BEAM" && type != "TIE" && type != "PIN") {
      deck.unbound.add("*MPC of type " + type, line.where);
      continue;
    }
    TieKeyword tie{.what = "MPC", .reference = line.fields[2], .set = line.fields[1], .where = line.where};
    if (type == "PIN") tie.dofs = {true, true, true, false, false, false};
    if (type != "BEAM") tie.joins_places = type;
    deck.ties.push_back(std::move(tie));
  }
}

void take_surface_tie(const Keyword& k, Deck& deck) {
  if (k.has("CYCLIC SYMMETRY") || k.has("MULTISTAGE")) {
    deck.otherwise.add(
        fmt::format(
            "*TIE, {}: left out; the superelement is that of the sector that the deck holds, with its "
            "sides free",
            k.has("MULTISTAGE") ? "MULTISTAGE" : "CYCLIC SYMMETRY"),
        k.where);
    return;
  }
  static const std::set<std::string> kKnown = {"NAME",        "POSITION TOLERANCE", "ADJUST",   "TYPE",
                                               "NO ROTATION", "NO THICKNESS",       "TIED NSET"};
  for (const auto& [name, value] : k.parameters)
    if (!kKnown.contains(name))
      deck.otherwise.add(fmt::format("*TIE's {} is not known: the tie is read without it", name), k.where);
  const double tolerance = k.has("POSITION TOLERANCE") ? to_real(k.get("POSITION TOLERANCE"), k.where) : 0;
  if (!(tolerance >= 0))
    throw std::invalid_argument(fmt::format("{}: *TIE has the POSITION TOLERANCE {:g}; it must be at least 0",
                                            k.where.text(), tolerance));
  const bool adjust = upper(k.get("ADJUST")) != "NO";
  for (const DataLine& line : k.data)
    if (line.fields.size() > 1)
      deck.surface_ties.push_back(
          {upper(line.fields[0]), upper(line.fields[1]), tolerance, line.where, adjust});
}

void take_equations(const Keyword& k, Deck& deck) {
  if (k.has("INPUT")) {
    deck.unbound.add("*EQUATION, INPUT", k.where);
    return;
  }
  for (std::size_t line = 0; line < k.data.size();) {
    const DataLine& head = k.data[line];
    if (head.fields.empty() || head.fields[0].empty()) {
      ++line;
      continue;
    }
    const std::int64_t n = to_integer(head.fields[0], head.where);
    EquationLine equation{.terms = {}, .where = head.where};
    std::vector<std::string> words(head.fields.begin() + 1, head.fields.end());
    while (!words.empty() && words.back().empty()) words.pop_back();
    for (++line; words.size() < static_cast<std::size_t>(3 * std::clamp<std::int64_t>(n, 0, 100000)) &&
                 line < k.data.size();
         ++line) {
      words.insert(words.end(), k.data[line].fields.begin(), k.data[line].fields.end());
      while (!words.empty() && words.back().empty()) words.pop_back();
    }
    if (n < 1 || words.size() != static_cast<std::size_t>(3 * n))
      throw std::invalid_argument(
          fmt::format("{}: *EQUATION of {} terms has {} entries instead of {} (node or set, dof, "
                      "coefficient for each)",
                      head.where.text(), n, words.size(), 3 * n));
    for (std::size_t t = 0; t < words.size(); t += 3) {
      const std::int64_t dof = to_integer(words[t + 1], head.where);
      if (dof < 1 || dof > 6)
        throw std::invalid_argument(fmt::format(
            "{}: *EQUATION names dof {}; 1 to 6 are displacements and rotations", head.where.text(), dof));
      equation.terms.push_back({words[t], static_cast<int>(dof), to_real(words[t + 2], head.where)});
    }
    deck.equations.push_back(std::move(equation));
  }
}

}  // namespace

bool take_binding(const Keyword& k, Deck& deck) {
  if (k.name == "COUPLING" || k.name == "RIGID BODY")
    take_coupling(k, deck);
  else if (k.name == "KINEMATIC" || k.name == "DISTRIBUTING")
    take_coupled_dofs(k, deck);
  else if (k.name == "MPC")
    take_mpc(k, deck);
  else if (k.name == "TIE")
    take_surface_tie(k, deck);
  else if (k.name == "EQUATION")
    take_equations(k, deck);
  else
    return false;
  return true;
}

}  // namespace flexura::mesh::abaqus
