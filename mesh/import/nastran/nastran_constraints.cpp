// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_constraints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

namespace flexura::mesh {

using Eigen::Vector3d;

namespace {

// "MPC = 7" of the case control.
std::optional<std::int64_t> chosen_mpc(const std::filesystem::path& path) {
  std::optional<std::int64_t> chosen;
  for (const std::string& text : case_control(path))
    if (text.rfind("MPC=", 0) == 0 && text.size() > 4 && std::isdigit(static_cast<unsigned char>(text[4])))
      chosen = std::stoll(text.substr(4, 12));
  return chosen;
}

}  // namespace

void NastranConstraints::read(const std::filesystem::path& path) {
  read_ties();
  read_rigid_bars();
  read_rbe1();
  read_equations(path);
}

void NastranConstraints::read_ties() {
  for (const Card* card : deck_.all("RBE2")) {
    ImportedTie tie;
    tie.label = card->integer(0);
    tie.reference = deck_.node(card->integer(1), card->where);
    tie.dofs = components(card->text(2), *card);
    if (std::ranges::count(tie.dofs, true) == 0)
      throw std::invalid_argument(fmt::format(
          "{}: RBE2 {} names no directions; give them in CM, 123456 for all", card->where.text(), tie.label));
    for (std::size_t k = 3; k < card->fields.size(); ++k)
      if (!card->blank(k) && !card->is_real(k)) {
        tie.nodes.push_back(deck_.node(card->integer(k), card->where));
        tie.axes.push_back(deck_.axes_at(card->integer(k), card->where));
      }
    deck_.model.ties.push_back(std::move(tie));
  }
  for (const Card* card : deck_.all("RBE3")) {
    ImportedTie tie;
    tie.kind = ImportedTie::Kind::average;
    tie.label = card->integer(0);
    tie.reference = deck_.node(card->integer(2), card->where);
    tie.dofs = components(card->text(3), *card);
    double weight = 1;
    bool turning = false;
    for (std::size_t k = 4; k < card->fields.size(); ++k) {
      if (card->blank(k)) continue;
      if (card->text(k) == "UM" || card->text(k) == "ALPHA") {
        deck_.unused.add("RBE3's " + card->text(k), card->where);
        break;
      }
      if (card->is_real(k)) {
        weight = card->real(k);
        const auto dofs = components(card->text(++k), *card);
        if (!(dofs[0] && dofs[1] && dofs[2]))
          deck_.approximated.add(
              "RBE3's weights that leave out one of the directions 1 to 3: all three are used", card->where);
        turning = dofs[3] || dofs[4] || dofs[5];
        continue;
      }
      tie.nodes.push_back(deck_.node(card->integer(k), card->where));
      tie.weights.push_back(weight);
      if (turning) turning_weights_.emplace_back(tie.nodes.back(), card->where);
    }
    deck_.model.ties.push_back(std::move(tie));
  }
  for (const ImportedTie& tie : deck_.model.ties)
    if (tie.nodes.empty())
      throw std::invalid_argument(fmt::format("RBE2 or RBE3 {} ties no nodes", tie.label));
}

void NastranConstraints::read_equations(const std::filesystem::path& path) {
  const std::vector<const Card*>& cards = deck_.all("MPC");
  const std::vector<const Card*>& sums = deck_.all("MPCADD");
  if (cards.empty()) return;
  std::set<std::int64_t> chosen, known;
  for (const Card* card : cards) known.insert(card->integer(0));
  if (const auto number = chosen_mpc(path)) {
    chosen = {*number};
  } else if (sums.size() == 1) {
    chosen = {sums[0]->integer(0)};
  } else if (known.size() == 1) {
    chosen = known;
  } else {
    throw std::invalid_argument(fmt::format(
        "{}: MPC of {} sets, and no case control says which holds; write \"MPC = {}\" before BEGIN BULK",
        cards[0]->where.text(), known.size(), *known.begin()));
  }
  for (const Card* sum : sums)
    if (chosen.contains(sum->integer(0)))
      for (std::size_t k = 1; k < sum->fields.size(); ++k)
        if (!sum->blank(k)) chosen.insert(sum->integer(k));
  int count = 0;
  for (const Card* card : cards) {
    if (!chosen.contains(card->integer(0))) {
      deck_.unused.add("MPC of a set that is not chosen", card->where);
      continue;
    }
    ++count;
    ImportedEquation equation{.terms = {},
                              .of = fmt::format("MPC {} in {}", card->integer(0), card->where.text())};
    // G, C, A twice on each line of eight fields, the first line with the set before them, others with a blank.
    for (std::size_t line = 0; line < card->fields.size(); line += 8)
      for (const std::size_t k : {line + 1, line + 4}) {
        if (card->blank(k)) continue;
        const std::int64_t grid = card->integer(k), c = card->integer(k + 1, 0);
        if (c < 1 || c > 6)
          throw std::invalid_argument(
              fmt::format("{}: MPC names component {} of grid {}; 1 to 6 are read (no scalar points)",
                          card->where.text(), c, grid));
        ImportedEquation::Term term{.node = deck_.node(grid, card->where)};
        const Eigen::Index d = c - 1;
        term.row.segment<3>(d < 3 ? 0 : 3) =
            card->real(k + 2, 0) * deck_.axes_at(grid, card->where).col(d % 3);
        equation.terms.push_back(term);
      }
    if (equation.terms.empty())
      throw std::invalid_argument(
          fmt::format("{}: MPC {} names no grid", card->where.text(), card->integer(0)));
    deck_.model.equations.push_back(std::move(equation));
  }
  deck_.model.messages.push_back(
      fmt::format("{} equation{} between dofs (MPC)", count, count == 1 ? "" : "s"));
}

// RBE1 whose independent dofs are all six of one node: others follow it in the directions after UM.
void NastranConstraints::read_rbe1() {
  for (const Card* card : deck_.all("RBE1")) {
    std::size_t um = 1;
    while (um < card->fields.size() && card->text(um) != "UM") ++um;
    std::vector<std::size_t> leaders;
    for (std::size_t k = 1; k < um; ++k)
      if (!card->blank(k)) leaders.push_back(k);
    const auto all_six = [&](std::size_t k) {
      const auto dofs = components(card->text(k), *card);
      return std::ranges::count(dofs, true) == 6;
    };
    if (leaders.size() != 2 || !all_six(leaders[1])) {
      deck_.approximated.add(
          "RBE1 whose independent dofs are not all six of one node: what it binds stays apart", card->where);
      continue;
    }
    for (std::size_t k = um + 1; k < card->fields.size(); ++k) {
      if (card->blank(k) || card->is_real(k)) continue;  // ALPHA
      ImportedTie tie;
      tie.label = card->integer(0);
      tie.reference = deck_.node(card->integer(leaders[0]), card->where);
      tie.nodes = {deck_.node(card->integer(k), card->where)};
      tie.axes = {deck_.axes_at(card->integer(k), card->where)};
      tie.dofs = components(card->text(++k), *card);
      deck_.model.ties.push_back(std::move(tie));
    }
  }
}

// RBAR: two nodes that move as one piece, or in some directions; RROD: two that keep their distance.
void NastranConstraints::read_rigid_bars() {
  for (const Card* card : deck_.all("RBAR")) {
    const auto of_a = components(card->text(3), *card), of_b = components(card->text(4), *card);
    const auto count = [](const std::array<bool, 6>& dofs) { return std::ranges::count(dofs, true); };
    const bool a_leads = count(of_a) == 6 && count(of_b) == 0, b_leads = count(of_b) == 6 && count(of_a) == 0;
    const auto bound = components(card->text(a_leads ? 6 : 5), *card);
    if (!(a_leads || b_leads)) {
      deck_.approximated.add(
          "RBAR whose independent dofs (CNA, CNB) are not all six of one node: what it binds stays apart",
          card->where);
      continue;
    }
    ImportedTie tie;
    tie.label = card->integer(0);
    if (count(bound) != 0) tie.dofs = bound;
    tie.reference = deck_.node(card->integer(a_leads ? 1 : 2), card->where);
    tie.nodes = {deck_.node(card->integer(a_leads ? 2 : 1), card->where)};
    tie.axes = {deck_.axes_at(card->integer(a_leads ? 2 : 1), card->where)};
    deck_.model.ties.push_back(std::move(tie));
  }
  for (const Card* card : deck_.all("RROD")) {
    const Vector3d line = deck_.systems.grid_place(card->integer(2), card->where) -
                          deck_.systems.grid_place(card->integer(1), card->where);
    if (!(line.norm() > 0))
      throw std::invalid_argument(
          fmt::format("{}: the nodes of RROD {} lie in one place", card->where.text(), card->integer(0)));
    ImportedEquation equation{.terms = {},
                              .of = fmt::format("RROD {} in {}", card->integer(0), card->where.text())};
    for (const std::size_t k : {2u, 1u}) {  // the dependent one first
      ImportedEquation::Term term{.node = deck_.node(card->integer(k), card->where)};
      term.row.head<3>() = (k == 2 ? 1 : -1) * line.normalized();
      for (double& c : term.row)  // round-off of places
        if (std::abs(c) < 1e-12) c = 0;
      equation.terms.push_back(term);
    }
    if (!card->blank(3)) std::swap(equation.terms[0], equation.terms[1]);
    deck_.model.equations.push_back(std::move(equation));
  }
}

void NastranConstraints::note_turning_weights() {
  if (turning_weights_.empty()) return;
  std::set<Index> turns;
  for (const ModelBuilder::Cell& cell : deck_.builder.cells())
    if (dimension_of(cell.type) == 2) turns.insert(cell.nodes.begin(), cell.nodes.end());
  for (const ImportedBar& bar : deck_.model.bars) turns.insert(bar.nodes.begin(), bar.nodes.end());
  for (const auto& [node, where] : turning_weights_)
    if (turns.contains(node))
      deck_.approximated.add("RBE3's weights on rotations: the displacements' mean alone is taken", where);
}

}  // namespace flexura::mesh
