// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_solids.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {

namespace {

struct SolidCard {
  CellType linear, quadratic;
  std::vector<int> order;  ///< place on the card of each node of the quadratic cell
};

std::map<std::string, SolidCard> make_solid_cards() {
  std::map<std::string, SolidCard> cards;
  for (const CellRecord& record : cell_records()) {
    if (record.foreign.nastran.empty()) continue;
    SolidCard& card = cards[record.foreign.nastran];
    (record.is_linear() ? card.linear : card.quadratic) = record.type;
    if (record.is_linear()) continue;
    card.order = record.foreign.nastran_order;
    if (card.order.empty())
      for (int k = 0; k < static_cast<int>(record.nodes.rows()); ++k) card.order.push_back(k);
  }
  return cards;
}
const std::map<std::string, SolidCard>& solid_cards() {
  static const std::map<std::string, SolidCard> kCards = make_solid_cards();
  return kCards;
}

}  // namespace

void NastranSolids::read_properties() {
  for (const Card* card : deck_.all("PSOLID")) {
    const std::int64_t id = card->integer(0);
    if (card->text(6) == "PFLUID" || deck_.is_fluid(card->integer(1))) {
      fluids_.insert(id);
      continue;
    }
    faulty_.insert(id);
    deck_.faults.guard([&] {
      property_.emplace(
          id, Property{deck_.material(card->integer(1), card->where), card->integer(2, 0), card->where});
      faulty_.erase(id);
    });
    if (card->text(3) == "BUBBLE" || card->text(3) == "0") bubbles_.insert(card->integer(0));
    if (card->text(3).empty()) no_scheme_.insert(card->integer(0));
  }
}

Index NastranSolids::material_of(const Property& property, const std::vector<Index>& nodes) {
  if (!deck_.model.materials[static_cast<std::size_t>(property.material)].orthotropic)
    return property.material;
  if (property.system < 0)
    throw std::invalid_argument(
        property.where.text() +
        ": PSOLID with CORDM -1 (the element's own axes) of a material with directions is "
        "not read; name a coordinate system");
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Index node : nodes) middle += deck_.builder.place(node) / static_cast<double>(nodes.size());
  return deck_.material_along(property.material,
                              deck_.systems.system(property.system, property.where).axes_at(middle));
}

void NastranSolids::read() {
  read_properties();
  int plain_wedges = 0, plain_bricks = 0;
  for (const Card& card : deck_.cards()) {
    const auto found = solid_cards().find(card.name);
    if (found == solid_cards().end()) continue;
    deck_.mark_read(card.name);
    const SolidCard& solid = found->second;
    const auto n_linear = static_cast<std::size_t>(nodes_per_cell(solid.linear)),
               n_quadratic = static_cast<std::size_t>(nodes_per_cell(solid.quadratic));
    const std::int64_t id = card.integer(0), property = card.integer(1, id);
    if (fluids_.contains(property)) {
      deck_.approximated.add(card.name + " of a fluid (MAT10, PFLUID): left out", card.where);
      continue;
    }
    if (faulty_.contains(property)) continue;
    deck_.faults.guard([&] {
      std::size_t middle = 0;
      for (std::size_t k = n_linear; k < n_quadratic; ++k)
        middle += !card.blank(2 + k) && card.integer(2 + k) != 0;
      if (middle != 0 && middle != n_quadratic - n_linear)
        throw std::invalid_argument(
            fmt::format("{}: {} {} has {} of its {} mid-side nodes; all or none are wanted",
                        card.where.text(), card.name, id, middle, n_quadratic - n_linear));
      const std::size_t n = middle ? n_quadratic : n_linear;
      std::vector<Index> nodes(n);
      for (std::size_t k = 0; k < n; ++k)
        nodes[k] = deck_.node(
            card.integer(2 + static_cast<std::size_t>(middle ? solid.order[k] : static_cast<int>(k))),
            card.where);
      deck_.builder.add_to_set("property " + std::to_string(property), nodes);
      const auto p = property_.find(property);
      const Index material = p == property_.end() ? -1 : material_of(p->second, nodes);
      const std::size_t cell = deck_.builder.add_cell(0, middle ? solid.quadratic : solid.linear, id,
                                                      std::move(nodes), card.where);
      if (!middle && solid.linear == CellType::hex8) {
        if (bubbles_.contains(property)) deck_.builder.cells()[cell].variant = CellVariant::bubbles;
        plain_bricks += no_scheme_.contains(property);
      }
      plain_wedges += !middle && solid.linear == CellType::wedge6;
      deck_.builder.cells()[cell].material = material;
      if (material < 0 && !deck_.given("PSOLID").empty())
        throw std::invalid_argument(
            fmt::format("{}: PSOLID {} of {} {} is not defined", card.where.text(), property, card.name, id));
    });
  }
  if (plain_bricks > 0)  // programs that read these decks differ in what a blank IN means
    deck_.model.messages.push_back(
        fmt::format("{} CHEXA of eight nodes, whose PSOLID leaves IN blank: integrated in full, stiffer in "
                    "bending by far than with the bubble "
                    "functions that MSC Nastran gives them; mesh.formulation = \"enhanced\" does so here",
                    plain_bricks));
  if (plain_wedges > 0)
    deck_.model.messages.push_back(
        fmt::format("{} CPENTA of six nodes: without the bubble functions that MSC Nastran gives them: "
                    "stiffer in bending",
                    plain_wedges));
}

}  // namespace flexura::mesh
