// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/deck_materials.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>

#include "mbs/base/documents/document.hpp"
#include "mesh/import/builder.hpp"

namespace flexura::reduce {
namespace {

using input::InputError;

// Stresses by strains (xx, yy, zz, xy, yz, zx).
Material anisotropic(const mesh::ImportedMaterial& from) {
  if (Eigen::LLT<Eigen::Matrix<double, 6, 6>>(from.stiffness).info() != Eigen::Success)
    throw std::invalid_argument(
        fmt::format("material \"{}\": its constants are not those of a positive definite stiffness; check "
                    "their order and signs",
                    from.name));
  return {.name = from.name, .D = from.stiffness, .density = from.rho};
}

/// The deck's material as ours; what it lacks is refused with the way out.
Material material_of(const mesh::ImportedMaterial& from, const std::string& deck) {
  const auto lacks = [&](const char* what, const char* card, const char* key) {
    throw std::invalid_argument(fmt::format(
        "{}: material \"{}\" has no {} ({}); give it a table [material.\"{}\"] with {} in the part file",
        deck, from.name, what, card, from.name, key));
  };
  if (!(from.rho > 0.0))
    throw std::invalid_argument(fmt::format(
        "{}: material \"{}\" has no density above zero (*DENSITY, or RHO of MAT1); give --density \"7800 "
        "kg/m^3\" (density in [geometry]) for all that have none, or a table [material.\"{}\"] with its "
        "density",
        deck, from.name, from.name));
  if (!from.stiffness.isZero(0.0)) return turned(anisotropic(from), from.R);
  if (from.orthotropic) {
    // E1 E2 E3 nu12 nu13 nu23 G12 G13 G23; nu31 = nu13 E3 / E1.
    const auto& c = from.engineering;
    return turned(orthotropic(from.name,
                              {.E_x = c[0],
                               .E_y = c[1],
                               .E_z = c[2],
                               .nu_xy = c[3],
                               .nu_yz = c[5],
                               .nu_zx = c[4] * c[2] / c[0],
                               .G_xy = c[6],
                               .G_yz = c[8],
                               .G_zx = c[7]},
                              from.rho),
                  from.R);
  }
  if (!(from.E > 0.0))
    lacks("Young's modulus above zero", "*ELASTIC, or E of MAT1", "young, poisson and density");
  return isotropic(from.name, from.E, from.nu, from.rho);
}

// The layers' means, by mass and by stiffness in the plane.
MaterialDamping damping_of_plies(const mesh::ImportedMaterial& of, const std::vector<Material>& materials) {
  MaterialDamping sum;
  double mass = 0.0, stiffness = 0.0;
  for (const mesh::ImportedPly& ply : of.plies) {
    const Material& material = materials.at(static_cast<std::size_t>(ply.material));
    const double m = ply.thickness * material.density,
                 k = ply.thickness * (material.D(0, 0) + material.D(1, 1));
    mass += m, stiffness += k;
    sum.alpha += m * material.damping.alpha;
    sum.beta += k * material.damping.beta;
    sum.loss += k * material.damping.loss;
  }
  if (mass > 0.0) sum.alpha /= mass;
  if (stiffness > 0.0) sum.beta /= stiffness, sum.loss /= stiffness;
  return sum;
}

}  // namespace

void choose_materials(const PartInput& input, const mesh::ImportedModel& model, PartMesh& part) {
  const std::string deck = input.cad.path.filename().string();
  if (model.materials.empty()) {
    if (input.materials.size() != 1)
      throw InputError(fmt::format(
          "{}: {} names no material; give exactly one table [material.NAME] for all of it ({} {} there)",
          input.where, deck, input.materials.size(), input.materials.size() == 1 ? "is" : "are"));
    if (input.materials[0].D.isZero(0.0))
      throw InputError(fmt::format(
          "{}: {} names no material whose density [material.{}] could give; add young and poisson",
          input.where, deck, input.materials[0].name));
    part.materials = input.materials;
    return;
  }
  if (!input.mass_unit_known)
    throw InputError(fmt::format(
        "{}: {} has materials in a system of units whose mass unit is not clear; add geometry.mass_unit",
        input.where, deck));
  std::vector<std::string> known;
  std::set<std::string> without_density;
  mesh::Faults faults;
  for (const mesh::ImportedMaterial& from : model.materials) {
    known.push_back(from.name);
    const auto ours = std::find_if(input.materials.begin(), input.materials.end(),
                                   [&](const Material& m) { return m.name == from.name; });
    if (!from.plies.empty() && faults.any()) break;
    if (!from.plies.empty()) {  // its materials stand before it
      std::vector<Ply> plies;
      for (const mesh::ImportedPly& ply : from.plies) {
        const Material& of = part.materials.at(static_cast<std::size_t>(ply.material));
        plies.push_back({of.D, of.density, ply.thickness});
      }
      part.materials.push_back(laminate(from.name, std::move(plies), from.R.col(0)));
      part.materials.back().damping = damping_of_plies(from, part.materials);
      continue;
    }
    const MaterialDamping damping{from.alpha, from.beta, from.loss};
    if (ours != input.materials.end() && !ours->D.isZero(0.0)) {
      part.materials.push_back(*ours);
      part.materials.back().damping = damping;
      continue;
    }
    mesh::ImportedMaterial whole = from;
    if (ours != input.materials.end()) whole.rho = ours->density;
    if (!(whole.rho > 0.0) && input.density > 0.0) {
      whole.rho = input.density;
      if (without_density.insert(whole.name).second)
        part.messages.push_back(fmt::format("material {} has no density in the deck: {:g} kg/m^3, as asked",
                                            whole.name, whole.rho));
    }
    faults.guard([&] { part.materials.push_back(material_of(whole, deck)); });
    if (faults.any()) part.materials.resize(known.size());  // layers find theirs by place
    part.materials.back().damping = damping;
  }
  faults.raise();
  for (const Material& ours : input.materials)
    if (std::find(known.begin(), known.end(), ours.name) == known.end())
      throw InputError(fmt::format("{}: {} has no material \"{}\"{}", input.where, deck, ours.name,
                                   input::suggestion(ours.name, known)));
  const bool assigned = std::all_of(part.mesh.solids.begin(), part.mesh.solids.end(),
                                    [](const mesh::CellBlock& block) { return !block.material.empty(); });
  if (!assigned && part.materials.size() > 1)
    throw std::invalid_argument(
        fmt::format("{}: {} materials are defined, but no section assigns them to the elements; add one to "
                    "the deck, or [material.NAME] here",
                    deck, part.materials.size()));
}

void say_damping(PartMesh& part) {
  for (const Material& material : part.materials) {
    const MaterialDamping& d = material.damping;
    if (!d.any() || !material.plies.empty()) continue;
    std::string text = fmt::format("material {} damps:", material.name);
    if (d.alpha != 0.0) text += fmt::format(" {:g} 1/s times its mass", d.alpha);
    if (d.beta != 0.0)
      text += fmt::format("{} {:g} s times its stiffness", d.alpha != 0.0 ? "," : "", d.beta);
    if (d.loss != 0.0)
      text += fmt::format(
          "{} loss factor {:g}, as viscous damping at the frequency of each mode of the free part",
          d.alpha != 0.0 || d.beta != 0.0 ? "," : "", d.loss);
    if (std::ranges::find(part.messages, text) == part.messages.end()) part.messages.push_back(text);
  }
}

}  // namespace flexura::reduce
