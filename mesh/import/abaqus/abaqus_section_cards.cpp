// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_section_cards.hpp"

#include <fmt/format.h>

#include <cctype>
#include <numbers>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_beam_sections.hpp"

namespace flexura::mesh::abaqus {
namespace {

using Known = std::function<std::string(const std::string&)>;

Section solid_section(const Keyword& k, const Known& known) {
  Section section{known(k.get("ELSET")), known(k.get("MATERIAL")), k.where};
  if (const std::vector<double> area = numbers_of(k, 0); !area.empty()) section.area = area[0];
  section.orientation = upper(k.get("ORIENTATION"));
  if (k.has("COMPOSITE"))
    throw std::invalid_argument(k.where.text() + ": *SOLID SECTION, COMPOSITE is not read");
  return section;
}

// A line for each layer: thickness, points of integration, material, angle.
void take_layers(const Keyword& k, const Known& known, Section& section) {
  for (const DataLine& line : k.data) {
    if (line.fields.empty() || line.fields[0].empty()) continue;
    Layer layer{.material = line.fields.size() > 2 ? known(line.fields[2]) : "",
                .thickness = to_real(line.fields[0], line.where),
                .angle = 0.0};
    require_positive(layer.thickness, "*" + k.name, "layer thickness", line.where);
    if (layer.material.empty())
      throw std::invalid_argument(line.where.text() + ": a layer of *" + k.name + " names no material");
    if (line.fields.size() > 3 && !line.fields[3].empty()) {
      const char first = line.fields[3][0];
      if (std::isalpha(static_cast<unsigned char>(first)) || first == '_')
        layer.orientation = upper(line.fields[3]);
      else
        layer.angle = to_real(line.fields[3], line.where) * std::numbers::pi / 180;
    }
    section.layers.push_back(layer);
  }
  if (section.layers.empty())
    throw std::invalid_argument(fmt::format("{}: *{}, COMPOSITE has no layers", k.where.text(), k.name));
  if (k.has("SYMMETRIC"))
    section.layers.insert(section.layers.end(), section.layers.rbegin(), section.layers.rend());
  section.material = section.layers.front().material;
  for (const Layer& layer : section.layers) section.thickness += layer.thickness;
}

Section shell_section(const Keyword& k, const Known& known, Deck& deck) {
  const bool layered = k.has("COMPOSITE");
  if (!layered && !k.has("MATERIAL"))
    throw std::invalid_argument(k.where.text() + ": *" + k.name + " without MATERIAL is not read");
  Section section{known(k.get("ELSET")), layered ? "" : known(k.get("MATERIAL")), k.where};
  if (layered) {
    take_layers(k, known, section);
  } else {
    section.thickness = to_real(field(k, 0, 0), k.where);
    require_positive(section.thickness, "*" + k.name, "thickness", k.where);
  }
  if (k.has(
          "OFFSET")) {  // of the reference surface (the nodes) from the middle, in thicknesses along the normal
    const std::string offset = upper(k.get("OFFSET"));
    const double fraction = offset == "SPOS" ? 0.5 : offset == "SNEG" ? -0.5 : to_real(offset, k.where);
    section.offset = -fraction * section.thickness;
  }
  section.orientation = upper(k.get("ORIENTATION"));  // no matter where the material has no directions
  for (const char* word : {"NODAL THICKNESS", "SHELL THICKNESS"})
    if (k.has(word))
      deck.otherwise.add(fmt::format("*{}'s {}: the section's thickness is used", k.name, word), k.where);
  if (k.has("STACK DIRECTION")) deck.unused.add("*" + k.name + "'s STACK DIRECTION", k.where);
  return section;
}

Section beam_section(const Keyword& k, DeckProgram program, const Known& known, Deck& deck) {
  Section section{known(k.get("ELSET")), known(k.get("MATERIAL")), k.where};
  const std::string type = upper(k.has("SECTION") ? k.get("SECTION") : "GENERAL");
  const std::vector<double> dim = numbers_of(k, 0), n1 = numbers_of(k, 1);
  try {
    if (k.name == "BEAM SECTION" && type == "GENERAL") {  // CalculiX' beam U1: A, I11, I12, I22, shear factor
      if (dim.size() < 4) throw std::invalid_argument("A, I11, I12 and I22 are wanted");
      const double shear = dim.size() > 4 ? dim[4] : 0.0;
      section.bar =
          BarSection{.A = dim[0], .I_yy = dim[1], .I_zz = dim[3], .I_yz = dim[2], .J = dim[1] + dim[3]};
      section.bar->kappa_y = section.bar->kappa_z = shear;
      deck.otherwise.add("*BEAM SECTION, SECTION=GENERAL has no torsion constant: I11 + I22 is taken",
                         k.where);
    } else if (k.name == "BEAM GENERAL SECTION" && type == "GENERAL") {
      if (dim.size() < 5) throw std::invalid_argument("A, I11, I12, I22 and J are wanted");
      section.bar = BarSection{.A = dim[0], .I_yy = dim[1], .I_zz = dim[3], .I_yz = dim[2], .J = dim[4]};
    } else {
      section.bar = shaped_section(k, program, deck.otherwise);
    }
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: *{}: {}", k.where.text(), k.name, error.what()));
  }
  if (n1.size() >= 3) section.n1 = Eigen::Vector3d(n1[0], n1[1], n1[2]);
  if (k.name == "BEAM GENERAL SECTION") {  // brings its own material
    const std::vector<double> moduli = numbers_of(k, 2);
    if (moduli.size() < 2 || !(moduli[0] > 0) || !(moduli[1] > 0))
      throw std::invalid_argument(k.where.text() + ": *BEAM GENERAL SECTION without E and G is not read");
    section.material = known("section of " + section.set);
    ImportedMaterial material;
    material.name = section.material;
    material.E = moduli[0], material.nu = moduli[0] / (2 * moduli[1]) - 1;
    material.rho = k.has("DENSITY") ? to_real(k.get("DENSITY"), k.where) : 0;
    deck.materials.push_back(material);
  }
  return section;
}

}  // namespace

bool gives_section(const std::string& name) {
  return name == "SOLID SECTION" || name == "SHELL SECTION" || name == "SHELL GENERAL SECTION" ||
         name == "MEMBRANE SECTION" || name == "USER SECTION" || name == "BEAM SECTION" ||
         name == "BEAM GENERAL SECTION";
}

Section section_of(const Keyword& k, DeckProgram program,
                   const std::function<std::string(const std::string&)>& known, Deck& deck) {
  if (k.name == "SOLID SECTION") return solid_section(k, known);
  // Of *USER SECTION (CalculiX' shell US3) the first constant is the thickness.
  return k.name.starts_with("SHELL") || k.name == "MEMBRANE SECTION" || k.name == "USER SECTION"
             ? shell_section(k, known, deck)
             : beam_section(k, program, known, deck);
}

}  // namespace flexura::mesh::abaqus
