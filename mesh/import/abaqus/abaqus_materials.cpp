// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

#include "mesh/import/builder.hpp"

namespace flexura::mesh::abaqus {
namespace {

/// Options that may stand below *MATERIAL, of Abaqus and of CalculiX.
bool is_option(const std::string& name) {
  static const std::set<std::string> kNames = {
      "ACOUSTIC MEDIUM",
      "ANISOTROPIC HYPERELASTIC",
      "ANNEAL TEMPERATURE",
      "BIAXIAL TEST DATA",
      "BRITTLE CRACKING",
      "BRITTLE FAILURE",
      "BRITTLE SHEAR",
      "BULK VISCOSITY",
      "CAP CREEP",
      "CAP HARDENING",
      "CAP PLASTICITY",
      "CAST IRON COMPRESSION HARDENING",
      "CAST IRON PLASTICITY",
      "CAST IRON TENSION HARDENING",
      "CLAY HARDENING",
      "CLAY PLASTICITY",
      "COMBINED TEST DATA",
      "COMPRESSION ONLY",
      "CONCRETE",
      "CONCRETE COMPRESSION DAMAGE",
      "CONCRETE COMPRESSION HARDENING",
      "CONCRETE DAMAGED PLASTICITY",
      "CONCRETE FAILURE",
      "CONCRETE TENSION DAMAGE",
      "CONCRETE TENSION STIFFENING",
      "CONDUCTIVITY",
      "CREEP",
      "CRUSHABLE FOAM",
      "CRUSHABLE FOAM HARDENING",
      "CYCLED PLASTIC",
      "CYCLIC HARDENING",
      "DAMAGE EVOLUTION",
      "DAMAGE INITIATION",
      "DAMAGE STABILIZATION",
      "DAMPING",
      "DEFORMATION PLASTICITY",
      "DENSITY",
      "DEPVAR",
      "DIELECTRIC",
      "DIFFUSIVITY",
      "DRUCKER PRAGER",
      "DRUCKER PRAGER CREEP",
      "DRUCKER PRAGER HARDENING",
      "ELASTIC",
      "ELECTRICAL CONDUCTIVITY",
      "EOS",
      "EOS COMPACTION",
      "EQUIBIAXIAL TEST DATA",
      "EXPANSION",
      "EXTREME VALUE",
      "FABRIC",
      "FAIL STRAIN",
      "FAIL STRESS",
      "FLUID BULK MODULUS",
      "FLUID CONSTANTS",
      "FLUID DENSITY",
      "FLUID EXPANSION",
      "FLUID LEAKOFF",
      "GAP FLOW",
      "GAS SPECIFIC HEAT",
      "GASKET CONTACT AREA",
      "GASKET ELASTICITY",
      "GASKET THICKNESS BEHAVIOR",
      "GEL",
      "HEAT GENERATION",
      "HYPERELASTIC",
      "HYPERFOAM",
      "HYPOELASTIC",
      "HYSTERESIS",
      "INELASTIC HEAT FRACTION",
      "JOINTED MATERIAL",
      "JOULE HEAT FRACTION",
      "LATENT HEAT",
      "LOADING DATA",
      "LOW DENSITY FOAM",
      "MAGNETIC PERMEABILITY",
      "MOHR COULOMB",
      "MOHR COULOMB HARDENING",
      "MOISTURE SWELLING",
      "MULLINS EFFECT",
      "NO COMPRESSION",
      "NO TENSION",
      "NONLINEAR BH",
      "ORNL",
      "PERMANENT MAGNETIZATION",
      "PERMEABILITY",
      "PIEZOELECTRIC",
      "PLANAR TEST DATA",
      "PLASTIC",
      "POROUS BULK MODULI",
      "POROUS ELASTIC",
      "POROUS FAILURE CRITERIA",
      "POROUS METAL PLASTICITY",
      "POTENTIAL",
      "RATE DEPENDENT",
      "REGULARIZE",
      "SHEAR FAILURE",
      "SHEAR RETENTION",
      "SHEAR TEST DATA",
      "SIMPLE SHEAR TEST DATA",
      "SOLUBILITY",
      "SORPTION",
      "SPECIFIC GAS CONSTANT",
      "SPECIFIC HEAT",
      "SUPERELASTIC",
      "SUPERELASTIC HARDENING",
      "SUPERELASTIC HARDENING MODIFICATIONS",
      "SWELLING",
      "TENSILE FAILURE",
      "TENSION CUTOFF",
      "TENSION STIFFENING",
      "TRIAXIAL TEST DATA",
      "TRS",
      "UNIAXIAL TEST DATA",
      "UNLOADING DATA",
      "USER DEFINED FIELD",
      "USER MATERIAL",
      "USER OUTPUT VARIABLES",
      "VISCOELASTIC",
      "VISCOUS",
      "VOID NUCLEATION",
      "VOLUMETRIC TEST DATA",
  };
  return kNames.contains(name);
}

std::size_t filled(const DataLine& line) {
  std::size_t n = line.fields.size();
  while (n > 0 && line.fields[n - 1].empty()) --n;
  return n;
}

/// Rows of n constants, a temperature and field variables, at most eight numbers on a line: the first row is taken.
void note_other_rows(const Keyword& k, std::size_t n, Deck& deck) {
  const std::size_t fields = k.has("DEPENDENCIES") ? static_cast<std::size_t>(std::clamp<std::int64_t>(
                                                         to_integer(k.get("DEPENDENCIES"), k.where), 0, 1000))
                                                   : 0;
  const std::size_t most = n + 1 + fields, lines = (most + 7) / 8;
  std::size_t given = 0, of_first_row = 0;
  for (const DataLine& line : k.data) {
    if (filled(line) == 0) continue;
    if (given++ < lines) of_first_row += filled(line);
  }
  if (given > lines)
    deck.otherwise.add(
        fmt::format("*{} has {} rows, for as many temperatures or field values: the first is taken", k.name,
                    (given + lines - 1) / lines),
        k.where);
  if (of_first_row > most)
    deck.otherwise.add(
        fmt::format("*{} has {} numbers in its first row; the first {} are its constants, the rest is "
                    "not used",
                    k.name, of_first_row, n),
        k.where);
}

/// ORTHOTROPIC and ANISOTROPIC: the upper triangle of the stiffness by columns, in the order 11, 22, 33, 12, 13, 23; the
/// first has no entries between directions and shear, and none between shears.
void take_stiffness(const Keyword& k, bool orthotropic, ImportedMaterial& material, Deck& deck) {
  static constexpr std::array<Eigen::Index, 6> kOurs = {0, 1, 2, 3, 5, 4};
  note_other_rows(k, orthotropic ? 9 : 21, deck);
  material.orthotropic = true;
  material.stiffness.setZero();
  std::size_t at = 0;
  for (std::size_t column = 0; column < 6; ++column)
    for (std::size_t row = 0; row <= column; ++row) {
      if (orthotropic && column > 2 && row < column) continue;
      const double value = to_real(field(k, at / 8, at % 8), k.where);
      ++at;
      material.stiffness(kOurs[row], kOurs[column]) = material.stiffness(kOurs[column], kOurs[row]) = value;
    }
}

void take_elastic(const Keyword& k, ImportedMaterial& material, Deck& deck) {
  material.orthotropic = false;
  material.stiffness.setZero();
  deck.laminae.erase(material.name);
  const std::string type = upper(k.has("TYPE") ? k.get("TYPE") : "ISOTROPIC");
  if (type == "ISOTROPIC" || type == "ISO") {
    note_other_rows(k, 2, deck);
    material.E = to_real(field(k, 0, 0), k.where);
    material.nu = to_real(field(k, 0, 1), k.where);
  } else if (type == "ENGINEERING CONSTANTS") {
    note_other_rows(k, 9, deck);
    material.orthotropic = true;
    for (int i = 0; i < 9; ++i)
      material.engineering[i] =
          to_real(field(k, static_cast<std::size_t>(i / 8), static_cast<std::size_t>(i % 8)), k.where);
  } else if (type == "LAMINA") {  // plane stress: what a shell has across its plane plays no part
    note_other_rows(k, 6, deck);
    std::vector<double> c;
    for (int i = 0; i < 6; ++i) c.push_back(to_real(field(k, 0, static_cast<std::size_t>(i)), k.where));
    material.orthotropic = true;
    material.engineering << c[0], c[1], c[1], c[2], 0, 0, c[3], c[4], c[5];
    deck.laminae.insert(material.name);
  } else if (type == "ORTHOTROPIC" || type == "ORTHO" || type == "ANISOTROPIC" || type == "ANISO") {
    take_stiffness(k, type[0] == 'O', material, deck);
  } else {
    throw std::invalid_argument(fmt::format(
        "{}: *ELASTIC, TYPE={} is not read; isotropic, engineering constants, orthotropic, anisotropic and "
        "LAMINA are",
        k.where.text(), type));
  }
}

void take_damping(const Keyword& k, ImportedMaterial& material, Deck& deck) {
  const auto number = [&](const char* word, double& to) {
    if (!k.has(word)) return;
    to = to_real(k.get(word), k.where);
    require_not_negative(to, "*DAMPING of material " + material.name, word, k.where);
  };
  number("ALPHA", material.alpha);
  number("BETA", material.beta);
  number("STRUCTURAL", material.loss);
  for (const std::string word : {"COMPOSITE", "ALPHA FUNCTION", "BETA FUNCTION"})
    if (k.has(word)) deck.unused.add("*DAMPING's " + word, k.where);
}

}  // namespace

void MaterialReader::start(const Keyword& k, const std::string& name, Deck& deck) {
  if (const auto [first, is_new] = started_.emplace(upper(name), k.where); !is_new)
    deck.otherwise.add(
        fmt::format("*MATERIAL, NAME={} is given twice: the one of {} is taken", name, first->second.text()),
        k.where);
  at_ = static_cast<int>(deck.materials.size());
  deck.materials.emplace_back();
  deck.materials.back().name = name;
  given_.clear();
}

void MaterialReader::note_twice(const Keyword& k, Deck& deck) {
  const auto [first, is_new] = given_.emplace(k.name, k.where);
  if (is_new) return;
  deck.otherwise.add(
      fmt::format("*{} is given twice in the material {}: this one is taken, not that of {}", k.name,
                  deck.materials[static_cast<std::size_t>(at_)].name, first->second.text()),
      k.where);
}

bool MaterialReader::take(const Keyword& k, Deck& deck) {
  if (!is_option(k.name)) at_ = -1;
  if (at_ < 0 || (k.name != "DENSITY" && k.name != "ELASTIC" && k.name != "DAMPING")) return false;
  note_twice(k, deck);
  ImportedMaterial& material = deck.materials[static_cast<std::size_t>(at_)];
  if (k.name == "DENSITY") {
    note_other_rows(k, 1, deck);
    material.rho = to_real(field(k, 0, 0), k.where);
  } else if (k.name == "DAMPING") {
    take_damping(k, material, deck);
  } else {
    take_elastic(k, material, deck);
  }
  return true;
}

}  // namespace flexura::mesh::abaqus
