// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "mesh/import/builder.hpp"
#include "mesh/import/nastran/nastran_cards.hpp"
#include "mesh/import/nastran/nastran_reader.hpp"
#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {

using Eigen::Vector3d;

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

ImportedModel NastranReader::read(const std::filesystem::path& path) {
  cards_ = read_cards(path, names_);
  for (const Card& card : cards_) {
    by_name_[card.name].push_back(&card);
    systems_.add(card);
  }
  refuse_repeated();
  used_ = {"GRDSET"};
  read_parameters(path);
  read_materials();
  read_grids();
  read_solids();
  read_shells();
  read_bars();
  read_rods();
  read_springs();
  read_ties();
  read_constraints(path);
  read_masses();
  read_dofs();
  static const std::set<std::string> kSilent = {"CORD2R", "CORD2C", "CORD2S", "CORD1R", "CORD1C",
                                                "CORD1S", "PSOLID", "PSHELL", "PCOMP",  "PBAR",
                                                "PBEAM",  "PBARL",  "PBEAML"};
  for (const Card& card : cards_)
    if (!used_.contains(card.name) && !kSilent.contains(card.name)) unused_.add(card.name, card.where);
  for (const std::string& message : unused_.messages("card")) model_.messages.push_back(message);
  // Elements with stiffness or mass that are not read; dampers, gaps and plot elements have none of either.
  static const std::set<std::string> kElements = {
      "CQUAD",  "CQUADX", "CTRIAX", "CTRIAX6", "CSHEAR", "CBEND",  "CBEAM3", "CWELD",   "CFAST",   "CSEAM",
      "CELAS3", "CELAS4", "CMASS1", "CMASS2",  "CMASS3", "CMASS4", "CONM1",  "CBUSH1D", "CCONEAX", "GENEL"};
  Unused left_out;
  for (const Card& card : cards_)
    if (!used_.contains(card.name) && kElements.contains(card.name)) left_out.add(card.name, card.where);
  for (const std::string& message : left_out.messages("element")) model_.warnings.push_back(message);
  // Rigid elements and contacts that are not read.
  static const std::set<std::string> kBinds = {"RTRPLT",  "RSPLINE", "RSSCON", "RJOINT", "MPCAX",
                                               "BCTABLE", "BCTSET",  "BGSET",  "BCONP",  "BSURF",
                                               "TIE",     "CGAP",    "SUPER"};
  Unused unbound;
  for (const Card& card : cards_)
    if (!used_.contains(card.name) && kBinds.contains(card.name)) unbound.add(card.name, card.where);
  for (const std::string& message : unbound.messages("card"))
    model_.warnings.push_back(message + ": what it binds stays apart");
  static const std::set<std::string> kMass = {"NSM", "NSM1", "NSML", "NSML1", "DMIG"};
  for (const Card& card : cards_)
    if (kMass.contains(card.name) && !card.blank(1))
      approximated_.add(card.name + ": the mass or stiffness that it adds is missing", card.where);
  note_turning_weights();
  for (const std::string& message : approximated_.remarks()) model_.warnings.push_back(message);
  if (builder_.cells().empty() && model_.bars.empty() && !model_.springs.empty())
    throw std::invalid_argument(
        path.string() +
        ": holds springs alone (CBUSH, CELAS), which make no body: give them as [bushing.NAME] or "
        "[spring_damper.NAME] of the mechanism");
  if (builder_.cells().empty() && model_.bars.empty())
    throw std::invalid_argument(path.string() +
                                ": holds no solid, shell or beam elements (CTETRA, CHEXA, CPENTA, CPYRAM, "
                                "CQUAD4, CTRIA3, CQUAD8, CTRIA6, CBAR, CBEAM, CROD); not Nastran bulk data?");
  finish();
  return std::move(model_);
}

void NastranReader::refuse_repeated() const {
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

const std::vector<const Card*>& NastranReader::all(const std::string& name) {
  used_.insert(name);
  return by_name_[name];
}

void NastranReader::read_materials() {
  for (const Card* card : all("MAT1")) {
    ImportedMaterial material;
    const std::int64_t id = card->integer(0);
    material.name = std::to_string(id);
    material.rho = card->real(4, 0);
    const bool has_E = !card->blank(1), has_G = !card->blank(2), has_nu = !card->blank(3);
    if (has_E + has_G + has_nu < 2)
      throw std::invalid_argument(
          fmt::format("{}: MAT1 {} needs two of E, G and NU", card->where.text(), id));
    const double G = card->real(2, 0);
    material.nu = has_nu ? card->real(3) : card->real(1) / (2 * G) - 1;
    material.E = has_E ? card->real(1) : 2 * G * (1 + material.nu);
    if (has_E && has_G && has_nu && std::abs(G * 2 * (1 + material.nu) / material.E - 1) > 1e-12) {
      material.G = G;
      if (std::abs(G * 2 * (1 + material.nu) / material.E - 1) > 1e-3)
        model_.messages.push_back(fmt::format(
            "{}: MAT1 {} has a G that is not E / (2 (1 + NU)): beams and rods have that G, solids and "
            "shells have E and NU",
            card->where.text(), id));
    }
    if (!material_.emplace(id, static_cast<Index>(model_.materials.size())).second)
      throw std::invalid_argument(fmt::format("{}: material {} is given twice", card->where.text(), id));
    model_.materials.push_back(material);
  }
  for (const Card* card : all("MAT8")) {  // plane stress: what a shell has across its plane plays no part
    const std::int64_t id = card->integer(0);
    ImportedMaterial material{.name = std::to_string(id), .rho = card->real(7, 0), .orthotropic = true};
    const double G12 = card->real(4);
    for (const std::size_t k : {5u, 6u})
      if (card->blank(k))
        approximated_.add("MAT8 without G1Z or G2Z (no shear deformation): G12 is used", card->where);
    material.engineering =
        Eigen::Vector<double, 9>{{card->real(1), card->real(2), card->real(2), card->real(3), 0, 0, G12,
                                  card->real(5, G12), card->real(6, G12)}};
    if (material_.contains(id) || !lamina_.emplace(id, static_cast<Index>(model_.materials.size())).second)
      throw std::invalid_argument(fmt::format("{}: material {} is given twice", card->where.text(), id));
    model_.materials.push_back(material);
  }
  for (const Card* card : all("PSOLID")) {
    property_[card->integer(0)] = material(card->integer(1), card->where);
    if (card->text(6) == "PFLUID")
      throw std::invalid_argument(fmt::format("{}: PSOLID {} is a fluid (PFLUID); structures are read",
                                              card->where.text(), card->integer(0)));
    if (card->text(3) == "BUBBLE" || card->text(3) == "0") bubbles_.insert(card->integer(0));
    if (card->text(3).empty()) no_scheme_.insert(card->integer(0));
  }
}

void NastranReader::read_parameters(const std::filesystem::path& path) {
  const std::string file = path.string();
  for (const std::string& line : case_control(path))
    if (const std::string start = "PARAM,WTMASS,"; line.rfind(start, 0) == 0) {
      const Card card{.name = "PARAM", .fields = {line.substr(start.size())}, .where = {&file, 1}};
      mass_factor_ = card.real(0);
      require_positive(mass_factor_, "PARAM", "WTMASS", card.where);
    }
  for (const Card* card : all("PARAM"))
    if (card->text(0) == "WTMASS") {
      mass_factor_ = card->real(1);
      require_positive(mass_factor_, "PARAM", "WTMASS", card->where);
    } else {
      unused_.add("PARAM " + card->text(0), card->where);
    }
  if (mass_factor_ != 1)
    model_.messages.push_back(fmt::format(
        "PARAM WTMASS: all densities and masses of the deck are multiplied by {:g}", mass_factor_));
}

Index NastranReader::material(std::int64_t id, const Where& where) const {
  const auto found = material_.find(id);
  if (found == material_.end()) {
    for (const char* name : {"MAT2", "MAT3", "MAT8", "MAT9", "MAT10", "MAT11", "MATORT"})
      if (const auto cards = by_name_.find(name); cards != by_name_.end())
        for (const Card* card : cards->second)
          if (card->integer(0) == id)
            throw std::invalid_argument(fmt::format(
                "{}: material {} is a {}, which is {}: give it as MAT1, or a table [material.{}] of a mesh "
                "without "
                "materials",
                where.text(), id, name,
                std::string(name) == "MAT8" ? "of shells (PSHELL, PCOMP) alone" : "not read", id));
    throw std::invalid_argument(fmt::format("{}: material {} is not defined", where.text(), id));
  }
  return found->second;
}

void NastranReader::read_grids() {
  int turned = 0;
  const Card* grdset = systems_.grdset();
  for (const Card* card : all("GRID")) {
    const std::int64_t id = card->integer(0);
    const Index node = builder_.add_node(0, id, systems_.grid_place(id, card->where), card->where);
    const std::string fixed = !card->blank(6) ? card->text(6) : grdset ? grdset->text(6) : "";
    if (!fixed.empty()) model_.fixed.push_back({node, components(fixed, *card)});
    turned += card->integer(5, grdset ? grdset->integer(5, 0) : 0) > 0;
  }
  if (turned > 0)
    model_.messages.push_back(
        fmt::format("{} GRID have displacement axes of their own (CD): RBE2, MPC, CBAR, CBEAM, CBUSH and "
                    "CELAS follow them, "
                    "directions of SPC and ASET are taken in the basic system",
                    turned));
}

std::array<bool, 6> NastranReader::components(const std::string& digits, const Card& card) {
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

void NastranReader::read_solids() {
  int plain_wedges = 0, plain_bricks = 0;
  for (const Card& card : cards_) {
    const auto found = solid_cards().find(card.name);
    if (found == solid_cards().end()) continue;
    used_.insert(card.name);
    const SolidCard& solid = found->second;
    const auto n_linear = static_cast<std::size_t>(nodes_per_cell(solid.linear)),
               n_quadratic = static_cast<std::size_t>(nodes_per_cell(solid.quadratic));
    const std::int64_t id = card.integer(0), property = card.integer(1, id);
    std::size_t middle = 0;
    for (std::size_t k = n_linear; k < n_quadratic; ++k)
      middle += !card.blank(2 + k) && card.integer(2 + k) != 0;
    if (middle != 0 && middle != n_quadratic - n_linear)
      throw std::invalid_argument(
          fmt::format("{}: {} {} has {} of its {} mid-side nodes; all or none are wanted", card.where.text(),
                      card.name, id, middle, n_quadratic - n_linear));
    const std::size_t n = middle ? n_quadratic : n_linear;
    std::vector<Index> nodes(n);
    for (std::size_t k = 0; k < n; ++k)
      nodes[k] = builder_.node(
          0, card.integer(2 + static_cast<std::size_t>(middle ? solid.order[k] : static_cast<int>(k))),
          card.where);
    builder_.add_to_set("property " + std::to_string(property), nodes);
    const std::size_t cell =
        builder_.add_cell(0, middle ? solid.quadratic : solid.linear, id, std::move(nodes), card.where);
    if (!middle && solid.linear == CellType::hex8) {
      if (bubbles_.contains(property)) builder_.cells()[cell].variant = CellVariant::bubbles;
      plain_bricks += no_scheme_.contains(property);
    }
    plain_wedges += !middle && solid.linear == CellType::wedge6;
    if (const auto p = property_.find(property); p != property_.end())
      builder_.cells()[cell].material = p->second;
    else if (!by_name_["PSOLID"].empty())
      throw std::invalid_argument(
          fmt::format("{}: PSOLID {} of {} {} is not defined", card.where.text(), property, card.name, id));
  }
  if (plain_bricks > 0)  // programs that read these decks differ in what a blank IN means
    model_.messages.push_back(
        fmt::format("{} CHEXA of eight nodes, whose PSOLID leaves IN blank: integrated in full, stiffer in "
                    "bending by far than with the bubble "
                    "functions that MSC Nastran gives them; mesh.formulation = \"enhanced\" does so here",
                    plain_bricks));
  if (plain_wedges > 0)
    model_.messages.push_back(
        fmt::format("{} CPENTA of six nodes: without the bubble functions that MSC Nastran gives them: "
                    "stiffer in bending",
                    plain_wedges));
}

void NastranReader::read_masses() {
  for (const Card* card : all("CONM2")) {
    ImportedMass mass;
    mass.label = card->integer(0);
    mass.node = builder_.node(0, card->integer(1), card->where);
    mass.mass = card->real(3, 0);
    const std::int64_t cid = card->integer(2, 0);
    const Vector3d x(card->real(4, 0), card->real(5, 0), card->real(6, 0));
    const NastranSystem& s = systems_.system(std::max<std::int64_t>(cid, 0), card->where);
    mass.offset = cid == -1 ? Vector3d(x - systems_.grid_place(card->integer(1), card->where))
                            : Vector3d(s.R * s.rectangular(x));
    // The card holds the products of inertia with a plus sign.
    const Eigen::Matrix3d I{{card->real(8, 0), -card->real(9, 0), -card->real(11, 0)},
                            {-card->real(9, 0), card->real(10, 0), -card->real(12, 0)},
                            {-card->real(11, 0), -card->real(12, 0), card->real(13, 0)}};
    mass.inertia = s.R * I * s.R.transpose();
    model_.masses.push_back(mass);
  }
}

std::vector<std::int64_t> NastranReader::grid_list(const Card& card, std::size_t first) {
  std::vector<std::int64_t> ids;
  for (std::size_t k = first; k < card.fields.size(); ++k) {
    if (card.blank(k)) continue;
    if (card.text(k) == "THRU") {
      const std::int64_t last = card.integer(++k);
      for (auto at = systems_.grids().upper_bound(ids.empty() ? 0 : ids.back());
           at != systems_.grids().end() && at->first <= last; ++at)
        ids.push_back(at->first);
    } else {
      ids.push_back(card.integer(k));
    }
  }
  return ids;
}

void NastranReader::read_dofs() {
  for (const Card* card : all("SPC"))
    for (const std::size_t k : {1u, 4u})
      if (!card->blank(k))
        model_.fixed.push_back(
            {builder_.node(0, card->integer(k), card->where), components(card->text(k + 1), *card)});
  for (const Card* card : all("SPC1"))
    for (const std::int64_t id : grid_list(*card, 2))
      model_.fixed.push_back({builder_.node(0, id, card->where), components(card->text(1), *card)});
  for (const Card* card : all("ASET"))
    for (std::size_t k = 0; k + 1 < card->fields.size(); k += 2)
      if (!card->blank(k))
        model_.kept.push_back(
            {builder_.node(0, card->integer(k), card->where), components(card->text(k + 1), *card)});
  for (const Card* card : all("ASET1"))
    for (const std::int64_t id : grid_list(*card, 1))
      model_.kept.push_back({builder_.node(0, id, card->where), components(card->text(0), *card)});
}

void NastranReader::note_turning_weights() {
  if (turning_weights_.empty()) return;
  std::set<Index> turns;
  for (const ModelBuilder::Cell& cell : builder_.cells())
    if (dimension_of(cell.type) == 2) turns.insert(cell.nodes.begin(), cell.nodes.end());
  for (const ImportedBar& bar : model_.bars) turns.insert(bar.nodes.begin(), bar.nodes.end());
  for (const auto& [node, where] : turning_weights_)
    if (turns.contains(node))
      approximated_.add("RBE3's weights on rotations: the displacements' mean alone is taken", where);
}

void NastranReader::finish() {
  for (const auto& [node, mass] : extra_mass_)
    model_.masses.push_back({.label = 0, .node = node, .mass = mass});
  for (ImportedMaterial& material : model_.materials) material.rho *= mass_factor_;
  for (ImportedBar& bar : model_.bars) bar.extra_mass_per_length *= mass_factor_;
  for (ImportedMass& mass : model_.masses) mass.mass *= mass_factor_, mass.inertia *= mass_factor_;
  builder_.finish(model_);
}

ImportedModel read_nastran(const std::filesystem::path& path) {
  return NastranReader().read(path);
}

}  // namespace flexura::mesh
