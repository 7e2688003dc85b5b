// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_deck.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mesh {

using Eigen::Vector3d;

std::array<bool, 6> components(const std::string& digits, const Card& card) {
  std::array<bool, 6> dofs{};
  for (const char c : digits) {
    if (c == '0') continue;
    if (c < '1' || c > '6')
      throw std::invalid_argument(
          fmt::format("{}: \"{}\" on {} names directions; only the digits 1 to 6 may stand there",
                      card.where.text(), digits, card.name));
    dofs[static_cast<std::size_t>(c - '1')] = true;
  }
  return dofs;
}

NastranDeck::NastranDeck(const std::filesystem::path& path) {
  cards_ = read_cards(path, names_);
  for (const Card& card : cards_) {
    by_name_[card.name].push_back(&card);
    systems.add(card);
  }
  refuse_repeated();
}

void NastranDeck::refuse_repeated() const {
  static const std::set<std::string> kNumbered = {
      "CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "PTUBE",  "CBUSH", "CELAS1", "CELAS2", "CONM2", "RBE2",
      "RBE3", "RBAR",  "PBAR", "PBARL",  "PBEAM", "PBEAML", "PROD",  "PSHELL", "PCOMP",  "PSOLID"};
  std::map<std::pair<std::string, std::int64_t>, const Card*> seen;
  for (const Card& card : cards_) {
    if (!kNumbered.contains(card.name)) continue;
    const auto [at, fresh] = seen.emplace(std::pair{card.name, card.integer(0)}, &card);
    const bool property = card.name[0] == 'P';  // the same one once more does no harm
    if (!fresh && !(property && card.fields == at->second->fields))
      throw std::invalid_argument(fmt::format("{}: {} {} is given twice, first in {}", card.where.text(),
                                              card.name, card.integer(0), at->second->where.text()));
  }
}

const std::vector<const Card*>& NastranDeck::all(const std::string& name) {
  read_.insert(name);
  return by_name_[name];
}

const std::vector<const Card*>& NastranDeck::given(const std::string& name) const {
  static const std::vector<const Card*> kNone;
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? kNone : found->second;
}

void NastranDeck::add_material(std::int64_t id, bool lamina, ImportedMaterial material, const Where& where) {
  const bool is_new = !material_.contains(id) && !lamina_.contains(id);
  if (!is_new) throw std::invalid_argument(fmt::format("{}: material {} is given twice", where.text(), id));
  (lamina ? lamina_ : material_).emplace(id, static_cast<Index>(model.materials.size()));
  model.materials.push_back(std::move(material));
}

Index NastranDeck::material(std::int64_t id, const Where& where) const {
  const auto found = material_.find(id);
  if (found == material_.end()) {
    for (const char* name : {"MAT2", "MAT3", "MAT8", "MAT10", "MATORT"})
      if (const auto cards = by_name_.find(name); cards != by_name_.end())
        for (const Card* card : cards->second)
          if (card->integer(0) == id)
            throw std::invalid_argument(fmt::format(
                "{}: material {} is a {}, which is {}: give it as MAT1, or a table [material.{}] of a mesh "
                "without "
                "materials",
                where.text(), id, name,
                std::string(name) == "MAT8" || std::string(name) == "MAT2" ? "of shells (PSHELL, PCOMP) alone"
                                                                           : "not read",
                id));
    throw std::invalid_argument(fmt::format("{}: material {} is not defined", where.text(), id));
  }
  return found->second;
}

Index NastranDeck::shell_material(std::int64_t id, const Where& where) const {
  const auto lamina = lamina_.find(id);
  return lamina != lamina_.end() ? lamina->second : material(id, where);
}

Index NastranDeck::material_along(Index material, const Eigen::Matrix3d& axes) {
  if (!model.materials[static_cast<std::size_t>(material)].orthotropic) return material;
  std::string key;
  for (const double c : axes.reshaped()) key += fmt::format("{:.0f} ", std::round(1e12 * c) + 0.0);
  const auto [at, fresh] =
      turned_.emplace(std::pair{material, key}, static_cast<Index>(model.materials.size()));
  if (fresh) {
    ImportedMaterial copy = model.materials[static_cast<std::size_t>(material)];
    copy.R = axes;
    model.materials.push_back(std::move(copy));
  }
  return at->second;
}

bool NastranDeck::is_fluid(std::int64_t material) const {
  return std::ranges::any_of(given("MAT10"), [&](const Card* card) { return card->integer(0) == material; });
}

Eigen::Matrix3d NastranDeck::axes_at(std::int64_t grid, const Where& where) {
  const auto found = systems.grids().find(grid);
  if (found == systems.grids().end()) return Eigen::Matrix3d::Identity();
  const Card* grdset = systems.grdset();
  const std::int64_t cd = found->second->integer(5, grdset ? grdset->integer(5, 0) : 0);
  if (cd <= 0) return Eigen::Matrix3d::Identity();
  return systems.system(cd, where).axes_at(systems.grid_place(grid, where));
}

std::vector<std::int64_t> NastranDeck::grid_list(const Card& card, std::size_t first) {
  std::vector<std::int64_t> ids;
  for (std::size_t k = first; k < card.fields.size(); ++k) {
    if (card.blank(k)) continue;
    if (card.text(k) == "THRU") {
      const std::int64_t last = card.integer(++k);
      for (auto at = systems.grids().upper_bound(ids.empty() ? 0 : ids.back());
           at != systems.grids().end() && at->first <= last; ++at) {
        implied_.add(1, card.where);
        ids.push_back(at->first);
      }
    } else {
      ids.push_back(card.integer(k));
    }
  }
  return ids;
}

// Components are in the displacement axes of the element's first node, or, where OFFT says so, in the basic system.
Vector3d NastranDeck::orientation(const Card& card, const Vector3d& from, const Eigen::Matrix3d& axes) {
  if (!card.blank(4) && card.blank(5) && card.blank(6) && !card.is_real(4))
    return systems.grid_place(card.integer(4), card.where) - from;
  return axes * Vector3d(card.real(4, 0), card.real(5, 0), card.real(6, 0));
}

}  // namespace flexura::mesh
