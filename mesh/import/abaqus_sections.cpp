// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "mesh/import/abaqus_placer.hpp"
#include "mesh/import/bar_sections.hpp"

namespace flexura::mesh::abaqus {
namespace {

const std::vector<std::int64_t>& labels_of(const std::string& name, const Part& part, const Where& where) {
  const auto set = part.element_sets.find(name);
  if (set == part.element_sets.end())
    throw std::invalid_argument(fmt::format("{}: element set \"{}\" is not defined", where.text(), name));
  return set->second;
}

void assign_bar(const Section& section, ImportedBar& bar, const std::string& type, Index material,
                       const Instance* instance) {
  bar.material = material;
  if (type[0] == 'T') {
    bar.A = section.area;
    if (section.bar)
      throw std::invalid_argument(
          fmt::format("{}: truss element {} has a section of beams; *SOLID SECTION with an area "
                      "is wanted",
                      section.where.text(), bar.label));
    require_positive(bar.A, fmt::format("truss element {}", bar.label), "area", section.where);
    return;
  }
  if (!section.bar)
    throw std::invalid_argument(fmt::format("{}: beam element {} has a section that is none of beams",
                                            section.where.text(), bar.label));
  const BarSection& s = *section.bar;
  bar.centroid << -s.node_y, -s.node_z;
  bar.A = s.A, bar.I_yy = s.I_yy, bar.I_zz = s.I_zz, bar.I_yz = s.I_yz, bar.J = s.J;
  if (type.rfind("B31", 0) == 0) bar.kappa_y = s.kappa_y, bar.kappa_z = s.kappa_z;  // B33 knows no shear
  require_section(bar, fmt::format("beam element {}", bar.label), section.where);
  if (bar.orientation.norm() > 0) return;
  bar.orientation = instance ? Eigen::Vector3d(instance->R * section.n1) : section.n1;
}

}  // namespace

void Placer::assign(const Section& section, const Part& part, int scope, const Instance* instance) {
  const auto material = std::find_if(model_.materials.begin(), model_.materials.end(),
                                     [&](const ImportedMaterial& m) { return m.name == section.material; });
  if (material == model_.materials.end())
    throw std::invalid_argument(
        fmt::format("{}: material \"{}\" is not defined", section.where.text(), section.material));
  const auto set = part.element_sets.find(section.set);
  if (set == part.element_sets.end())
    throw std::invalid_argument(
        fmt::format("{}: element set \"{}\" is not defined", section.where.text(), section.set));
  if (material->orthotropic && (section.oriented || (instance && !instance->R.isIdentity(1e-12))))
    throw std::invalid_argument(fmt::format(
        "{}: the material {} has directions, which {}: not read; those along the model's axes are",
        section.where.text(), section.material, section.oriented ? "an ORIENTATION turns" : "the instance turns"));
  for (const std::int64_t label : set->second)
    if (const auto bar = bar_of_.find({scope, label}); bar != bar_of_.end())
      assign_bar(section, model_.bars[bar->second.first], bar->second.second,
                 static_cast<Index>(material - model_.materials.begin()), instance);
    else if (const auto found = cell_of_.find({scope, label}); found != cell_of_.end()) {
      ModelBuilder::Cell& cell = builder_.cells()[found->second];
      cell.material = static_cast<Index>(material - model_.materials.begin());
      cell.thickness = section.thickness;
      cell.offset = section.offset;
    }
}

void Placer::assign(const ElementData& data, const Part& part, int scope, const Instance* instance) {
  const Eigen::Matrix3d R = instance ? instance->R : Eigen::Matrix3d::Identity();
  if (data.values.empty() || (data.kind == "ROTARY INERTIA" && data.values.size() < 3))
    throw std::invalid_argument(fmt::format("{}: *{} has no numbers", data.where.text(), data.kind));
  for (const std::int64_t label : labels_of(data.set, part, data.where)) {
    const std::pair<int, std::int64_t> key{scope, label};
    if (const auto spring = spring_of_.find(key); data.kind == "SPRING" && spring != spring_of_.end()) {
      ImportedSpring& to = model_.springs[spring->second];
      require_not_negative(data.values[0], "*" + data.kind, "stiffness", data.where);
      to.stiffness[0] = data.values[0];
      spring_set_.insert(spring->second);
    }
    const auto mass = mass_of_.find(key);
    if (mass == mass_of_.end()) continue;
    ImportedMass& to = model_.masses[mass->second];
    if (data.kind == "MASS") to.mass = data.values[0];
    if (data.kind != "ROTARY INERTIA") continue;
    std::vector<double> I = data.values;  // I11, I22, I33, I12, I13, I23: of the inertia tensor
    I.resize(6, 0.0);
    Eigen::Matrix3d J;
    J << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    to.inertia = R * J * R.transpose();
  }
}

void Placer::finish_others() {
  std::map<Index, std::size_t> at;
  std::vector<ImportedMass> merged;
  for (const ImportedMass& mass : model_.masses) {
    const auto [place, fresh] = at.emplace(mass.node, merged.size());
    if (fresh) {
      merged.push_back(mass);
    } else {
      merged[place->second].mass += mass.mass;
      merged[place->second].inertia += mass.inertia;
    }
  }
  model_.masses = std::move(merged);
  for (const ImportedBar& bar : model_.bars)
    if (!(bar.A > 0))
      throw std::invalid_argument(
          fmt::format("beam element {} has no section (*BEAM SECTION, *BEAM GENERAL SECTION; trusses: "
                      "*SOLID SECTION with an area)",
                      bar.label));
  for (std::size_t k = 0; k < model_.springs.size(); ++k)
    if (!spring_set_.contains(k))
      throw std::invalid_argument(
          fmt::format("spring element {} has no stiffness (*SPRING)", model_.springs[k].label));
  for (ImportedSpring& spring : model_.springs) {  // along their line
    const Eigen::Vector3d line = builder_.place(spring.nodes[1]) - builder_.place(spring.nodes[0]);
    if (!(line.norm() > 0))
      throw std::invalid_argument(
          fmt::format("spring element {} (SPRINGA) has no length, hence no direction", spring.label));
    const Eigen::Vector3d x = line.normalized(), y = x.unitOrthogonal();
    spring.R << x, y, x.cross(y);
  }
}

}  // namespace flexura::mesh::abaqus
