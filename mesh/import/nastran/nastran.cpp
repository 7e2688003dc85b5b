// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include "mesh/import/nastran/nastran_bars.hpp"
#include "mesh/import/nastran/nastran_constraints.hpp"
#include "mesh/import/nastran/nastran_deck.hpp"
#include "mesh/import/nastran/nastran_shells.hpp"
#include "mesh/import/nastran/nastran_solids.hpp"
#include "mesh/import/nastran/nastran_springs.hpp"

namespace flexura::mesh {

using Eigen::Vector3d;

namespace {

/// Reads a deck in stages, each of which adds to the same model; materials, nodes, masses and supports are its own.
class NastranReader {
 public:
  explicit NastranReader(const std::filesystem::path& path) : path_(path), deck_(path) {}
  ImportedModel read();

 private:
  /// PARAM,WTMASS: all masses times it.  Read in the bulk data and in the case control.
  void read_parameters();
  void read_materials();
  void read_anisotropic();
  void read_grids();
  void read_masses();
  void read_dofs();
  /// What was passed over, in the model's messages and warnings.
  void report();
  void require_elements() const;
  void finish();

  const std::filesystem::path& path_;
  NastranDeck deck_;
  double mass_factor_ = 1;                  // WTMASS
  double loss_ = 0, alpha_ = 0, beta_ = 0;  // PARAM G, ALPHA1, ALPHA2: of all elements
};

ImportedModel NastranReader::read() {
  deck_.mark_read("GRDSET");
  Faults& faults = deck_.faults;
  faults.guard([&] { read_parameters(); });
  faults.guard([&] { read_materials(); });
  faults.guard([&] { read_grids(); });
  faults.raise();
  faults.guard([&] { NastranSolids(deck_).read(); });
  faults.guard([&] { NastranShells(deck_).read(); });
  faults.guard([&] { NastranBars(deck_).read(); });
  faults.guard([&] { NastranSprings(deck_).read(); });
  NastranConstraints constraints(deck_);
  faults.guard([&] { constraints.read(path_); });
  faults.guard([&] { read_masses(); });
  faults.guard([&] { read_dofs(); });
  faults.raise();
  constraints.note_turning_weights();
  report();
  require_elements();
  finish();
  return std::move(deck_.model);
}

void NastranReader::report() {
  static const std::set<std::string> kSilent = {"CORD2R", "CORD2C", "CORD2S", "CORD1R", "CORD1C",
                                                "CORD1S", "PSOLID", "PSHELL", "PCOMP",  "PBAR",
                                                "PBEAM",  "PBARL",  "PBEAML"};
  for (const Card& card : deck_.cards())
    if (!deck_.is_read(card) && !kSilent.contains(card.name)) deck_.unused.add(card.name, card.where);
  for (const std::string& message : deck_.unused.messages("card")) deck_.model.messages.push_back(message);
  // Elements with stiffness, mass or damping that are not read; gaps and plot elements have none.
  static const std::set<std::string> kElements = {
      "CQUAD", "CQUADX",  "CTRIAX", "CTRIAX6", "CSHEAR", "CBEND",  "CBEAM3", "CWELD",
      "CFAST", "CSEAM",   "CELAS3", "CELAS4",  "CMASS1", "CMASS2", "CMASS3", "CMASS4",
      "CONM1", "CCONEAX", "GENEL",  "CDAMP3",  "CDAMP4", "CDAMP5"};
  Unused left_out;
  for (const Card& card : deck_.cards())
    if (!deck_.is_read(card) && kElements.contains(card.name)) left_out.add(card.name, card.where);
  for (const std::string& message : left_out.messages("element")) deck_.model.warnings.push_back(message);
  // Rigid elements and contacts that are not read.
  static const std::set<std::string> kBinds = {"RTRPLT",  "RSPLINE", "RSSCON", "RJOINT", "MPCAX",
                                               "BCTABLE", "BCTSET",  "BGSET",  "BCONP",  "BSURF",
                                               "TIE",     "CGAP",    "SUPER"};
  Unused unbound;
  for (const Card& card : deck_.cards())
    if (!deck_.is_read(card) && kBinds.contains(card.name)) unbound.add(card.name, card.where);
  for (const std::string& message : unbound.messages("card"))
    deck_.model.warnings.push_back(message + ": what it binds stays apart");
  static const std::set<std::string> kMass = {"NSM", "NSM1", "NSML", "NSML1", "DMIG"};
  for (const Card& card : deck_.cards())
    if (kMass.contains(card.name) && !card.blank(1))
      deck_.approximated.add(card.name + ": the mass or stiffness that it adds is missing", card.where);
  for (const std::string& message : deck_.approximated.remarks()) deck_.model.warnings.push_back(message);
}

void NastranReader::require_elements() const {
  if (deck_.builder.cells().empty() && deck_.model.bars.empty() && !deck_.model.springs.empty())
    throw std::invalid_argument(path_.string() +
                                ": holds springs and dampers alone (CBUSH, CELAS, CDAMP, CVISC), which make "
                                "no body: give them as [bushing.NAME] or "
                                "[spring_damper.NAME] of the mechanism");
  if (deck_.builder.cells().empty() && deck_.model.bars.empty())
    throw std::invalid_argument(path_.string() +
                                ": holds no solid, shell or beam elements (CTETRA, CHEXA, CPENTA, CPYRAM, "
                                "CQUAD4, CTRIA3, CQUAD8, CTRIA6, CBAR, CBEAM, CROD); not Nastran bulk data?");
}

void NastranReader::read_materials() {
  for (const Card* card : deck_.all("MAT1")) {
    ImportedMaterial material;
    const std::int64_t id = card->integer(0);
    material.name = std::to_string(id);
    material.rho = card->real(4, 0);
    const bool has_E = !card->blank(1), has_G = !card->blank(2), has_nu = !card->blank(3);
    // Of E alone Nastran takes G = NU = 0: a shell or solid without any stiffness in shear, a bar that twists freely.
    const bool has_E_alone = has_E && !has_G && !has_nu;
    if (has_E + has_G + has_nu < 2 && !has_E_alone)
      throw std::invalid_argument(fmt::format("{}: MAT1 {} needs E, or G and NU", card->where.text(), id));
    if (has_E_alone)
      deck_.approximated.add("MAT1 of E alone (Nastran: G = NU = 0): NU = 0 and G = E / 2 are used",
                             card->where);
    material.loss = card->real(7, 0);
    require_not_negative(material.loss, fmt::format("MAT1 {}", id), "damping GE", card->where);
    const double G = card->real(2, 0);
    material.nu = has_nu ? card->real(3) : has_E_alone ? 0.0 : card->real(1) / (2 * G) - 1;
    material.E = has_E ? card->real(1) : 2 * G * (1 + material.nu);
    if (has_E && has_G && has_nu && std::abs(G * 2 * (1 + material.nu) / material.E - 1) > 1e-12) {
      material.G = G;
      if (std::abs(G * 2 * (1 + material.nu) / material.E - 1) > 1e-3)
        deck_.model.messages.push_back(fmt::format(
            "{}: MAT1 {} has a G that is not E / (2 (1 + NU)): beams and rods have that G, solids and "
            "shells have E and NU",
            card->where.text(), id));
    }
    deck_.add_material(id, false, material, card->where);
  }
  read_anisotropic();
  for (const Card* card :
       deck_.all("MAT8")) {  // plane stress: what a shell has across its plane plays no part
    const std::int64_t id = card->integer(0);
    ImportedMaterial material{.name = std::to_string(id), .rho = card->real(7, 0), .orthotropic = true};
    const double G12 = card->real(4);
    for (const std::size_t k : {5u, 6u})
      if (card->blank(k))
        deck_.approximated.add("MAT8 without G1Z or G2Z (no shear deformation): G12 is used", card->where);
    material.engineering =
        Eigen::Vector<double, 9>{{card->real(1), card->real(2), card->real(2), card->real(3), 0, 0, G12,
                                  card->real(5, G12), card->real(6, G12)}};
    material.loss = card->real(16, 0);
    require_not_negative(material.loss, fmt::format("MAT8 {}", id), "damping GE", card->where);
    deck_.add_material(id, true, material, card->where);
  }
}

// MAT9 and MAT11 of solids, MAT2 of shells.
void NastranReader::read_anisotropic() {
  for (const Card* card : deck_.all("MAT9")) {
    const std::int64_t id = card->integer(0);
    ImportedMaterial material{.name = std::to_string(id), .rho = card->real(22, 0), .orthotropic = true};
    std::size_t at = 1;  // the upper triangle by rows, xx, yy, zz, xy, yz, zx as here
    for (Eigen::Index row = 0; row < 6; ++row)
      for (Eigen::Index column = row; column < 6; ++column)
        material.stiffness(row, column) = material.stiffness(column, row) = card->real(at++, 0);
    material.loss = card->real(30, 0);
    require_not_negative(material.loss, fmt::format("MAT9 {}", id), "damping GE", card->where);
    deck_.add_material(id, false, material, card->where);
  }
  for (const Card* card : deck_.all("MAT11")) {
    const std::int64_t id = card->integer(0);
    ImportedMaterial material{.name = std::to_string(id), .rho = card->real(10, 0), .orthotropic = true};
    for (std::size_t k = 0; k < 9; ++k)
      material.engineering[static_cast<Eigen::Index>(k)] = card->real(1 + k);
    material.loss = card->real(15, 0);
    require_not_negative(material.loss, fmt::format("MAT11 {}", id), "damping GE", card->where);
    deck_.add_material(id, false, material, card->where);
  }
  for (const Card* card : deck_.all("MAT2")) {
    const std::int64_t id = card->integer(0);
    ImportedMaterial material{.name = std::to_string(id), .rho = card->real(7, 0), .orthotropic = true};
    static constexpr std::array<Eigen::Index, 3> kPlane = {0, 1, 3};
    std::size_t at = 1;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = row; column < 3; ++column)
        material.stiffness(kPlane[row], kPlane[column]) = material.stiffness(kPlane[column], kPlane[row]) =
            card->real(at++, 0);
    // Across the plane, which plays no part in plane stress; shear there is that of the plane.
    material.stiffness(2, 2) = material.stiffness(0, 0);
    material.stiffness(4, 4) = material.stiffness(5, 5) = material.stiffness(3, 3);
    deck_.approximated.add("MAT2: shear deformation across the shell is that of G33", card->where);
    deck_.add_material(id, true, material, card->where);
  }
}

void NastranReader::read_parameters() {
  const std::string file = path_.string();
  for (const std::string& line : case_control(path_))
    if (const std::string start = "PARAM,WTMASS,"; line.rfind(start, 0) == 0) {
      const Card card{.name = "PARAM", .fields = {line.substr(start.size())}, .where = {&file, 1}};
      mass_factor_ = card.real(0);
      require_positive(mass_factor_, "PARAM", "WTMASS", card.where);
    }
  for (const Card* card : deck_.all("PARAM"))
    if (card->text(0) == "WTMASS") {
      mass_factor_ = card->real(1);
      require_positive(mass_factor_, "PARAM", "WTMASS", card->where);
    } else if (card->text(0) == "COUPMASS") {
      if (card->integer(1, -1) <= 0)
        deck_.model.messages.push_back(fmt::format(
            "{}: PARAM COUPMASS {}: masses of elements are consistent here, not lumped, so that few "
            "elements tell the frequencies better",
            card->where.text(), card->integer(1, -1)));
    } else if (double* const damping = card->text(0) == "G"        ? &loss_
                                       : card->text(0) == "ALPHA1" ? &alpha_
                                       : card->text(0) == "ALPHA2" ? &beta_
                                                                   : nullptr) {
      *damping = card->real(1, 0);
      require_not_negative(*damping, "PARAM", card->text(0).c_str(), card->where);
    } else {
      deck_.unused.add("PARAM " + card->text(0), card->where);
    }
  if (mass_factor_ != 1)
    deck_.model.messages.push_back(fmt::format(
        "PARAM WTMASS: all densities and masses of the deck are multiplied by {:g}", mass_factor_));
}

void NastranReader::read_grids() {
  int turned = 0;
  const Card* grdset = deck_.systems.grdset();
  for (const Card* card : deck_.all("GRID")) {
    const std::int64_t id = card->integer(0);
    const Index node = deck_.builder.add_node(0, id, deck_.systems.grid_place(id, card->where), card->where);
    const std::string fixed = !card->blank(6) ? card->text(6) : grdset ? grdset->text(6) : "";
    if (!fixed.empty()) deck_.model.fixed.push_back({node, components(fixed, *card)});
    turned += card->integer(5, grdset ? grdset->integer(5, 0) : 0) > 0;
  }
  if (turned > 0)
    deck_.model.messages.push_back(
        fmt::format("{} GRID have displacement axes of their own (CD): RBE2, MPC, CBAR, CBEAM, CBUSH and "
                    "CELAS follow them, "
                    "directions of SPC and ASET are taken in the basic system",
                    turned));
}

void NastranReader::read_masses() {
  for (const Card* card : deck_.all("CONM2")) {
    ImportedMass mass;
    mass.label = card->integer(0);
    mass.node = deck_.node(card->integer(1), card->where);
    mass.mass = card->real(3, 0);
    const std::int64_t cid = card->integer(2, 0);
    const Vector3d x(card->real(4, 0), card->real(5, 0), card->real(6, 0));
    const NastranSystem& s = deck_.systems.system(std::max<std::int64_t>(cid, 0), card->where);
    mass.offset = cid == -1 ? Vector3d(x - deck_.systems.grid_place(card->integer(1), card->where))
                            : Vector3d(s.R * s.rectangular(x));
    // The card holds the products of inertia with a plus sign.
    const Eigen::Matrix3d I{{card->real(8, 0), -card->real(9, 0), -card->real(11, 0)},
                            {-card->real(9, 0), card->real(10, 0), -card->real(12, 0)},
                            {-card->real(11, 0), -card->real(12, 0), card->real(13, 0)}};
    mass.inertia = s.R * I * s.R.transpose();
    require_mass(mass, fmt::format("CONM2 {}", mass.label), card->where);
    deck_.model.masses.push_back(mass);
  }
}

void NastranReader::read_dofs() {
  for (const Card* card : deck_.all("SPC"))
    for (const std::size_t k : {1u, 4u})
      if (!card->blank(k))
        deck_.model.fixed.push_back(
            {deck_.node(card->integer(k), card->where), components(card->text(k + 1), *card)});
  for (const Card* card : deck_.all("SPC1"))
    for (const std::int64_t id : deck_.grid_list(*card, 2))
      deck_.model.fixed.push_back({deck_.node(id, card->where), components(card->text(1), *card)});
  for (const Card* card : deck_.all("ASET"))
    for (std::size_t k = 0; k + 1 < card->fields.size(); k += 2)
      if (!card->blank(k))
        deck_.model.kept.push_back(
            {deck_.node(card->integer(k), card->where), components(card->text(k + 1), *card)});
  for (const Card* card : deck_.all("ASET1"))
    for (const std::int64_t id : deck_.grid_list(*card, 1))
      deck_.model.kept.push_back({deck_.node(id, card->where), components(card->text(0), *card)});
}

void NastranReader::finish() {
  for (ImportedMaterial& material : deck_.model.materials) {
    material.rho *= mass_factor_;
    material.loss += loss_, material.alpha += alpha_, material.beta += beta_;
  }
  for (ImportedSpring& spring : deck_.model.springs) {
    spring.loss += loss_;
    for (std::size_t d = 0; d < 6; ++d) spring.damping[d] += beta_ * spring.stiffness[d];
  }
  for (ImportedBar& bar : deck_.model.bars) bar.extra_mass_per_length *= mass_factor_;
  for (ImportedMass& mass : deck_.model.masses) {
    mass.mass *= mass_factor_, mass.inertia *= mass_factor_;
    mass.alpha = alpha_;
  }
  deck_.builder.finish(deck_.model);
}

}  // namespace

ImportedModel read_nastran(const std::filesystem::path& path) {
  return NastranReader(path).read();
}

}  // namespace flexura::mesh
