// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_sections.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesh/import/bar_sections.hpp"
#include "mesh/model/cells/cell.hpp"

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
  bar.outline = s.outline;
  bar.A = s.A, bar.I_yy = s.I_yy, bar.I_zz = s.I_zz, bar.I_yz = s.I_yz, bar.J = s.J;
  if (type.rfind("B33", 0) != 0) bar.kappa_y = s.kappa_y, bar.kappa_z = s.kappa_z;  // B33 knows no shear
  require_section(bar, fmt::format("beam element {}", bar.label), section.where);
  if (bar.orientation.norm() > 0) return;
  bar.orientation = instance ? Eigen::Vector3d(instance->R * section.n1) : section.n1;
}

}  // namespace

Index SectionPlacer::found_material(const std::string& name, const Where& where) const {
  const auto material = std::ranges::find(placed_.model.materials, name, &ImportedMaterial::name);
  if (material == placed_.model.materials.end())
    throw std::invalid_argument(fmt::format("{}: material \"{}\" is not defined", where.text(), name));
  return static_cast<Index>(material - placed_.model.materials.begin());
}

Index SectionPlacer::laminate_along(const Section& section, const Eigen::Matrix3d& axes,
                                    const LayerAxes& of_layer) {
  ImportedMaterial whole;
  whole.name = "layers of " + section.set;
  whole.R = axes;
  for (const Layer& layer : section.layers) {
    const Index material = found_material(layer.material, section.where);
    const bool orthotropic = placed_.model.materials[static_cast<std::size_t>(material)].orthotropic;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(layer.angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d& own = layer.orientation.empty() ? axes : of_layer(layer.orientation);
    whole.plies.push_back({orthotropic ? material_along(material, own * turn) : material, layer.thickness});
  }
  std::string key = section.where.text();
  for (const double c : axes.reshaped()) key += fmt::format(" {:.0f}", std::round(1e12 * c) + 0.0);
  for (const ImportedPly& ply : whole.plies) key += fmt::format(" {}", ply.material);
  const auto [found, fresh] =
      turned_.emplace(std::pair{whole.name, key}, static_cast<Index>(placed_.model.materials.size()));
  if (fresh) placed_.model.materials.push_back(std::move(whole));
  return found->second;
}

void SectionPlacer::assign(const Section& section, const Part& part, int scope, const Instance* instance) {
  const Index index = found_material(section.material, section.where);
  const auto set = part.element_sets.find(section.set);
  if (set == part.element_sets.end())
    throw std::invalid_argument(
        fmt::format("{}: element set \"{}\" is not defined", section.where.text(), section.set));
  const bool orthotropic = placed_.model.materials[static_cast<std::size_t>(index)].orthotropic,
             layered = !section.layers.empty(), lamina = placed_.deck.laminae.contains(section.material);
  const Orientation* axes = (orthotropic || layered) && !section.orientation.empty()
                                ? &placed_.found_orientation(section.orientation, part.name, section.where)
                                : nullptr;
  for (const std::int64_t label : set->second) {
    if (const auto [first, is_new] = section_of_.emplace(std::pair{scope, label}, section.where);
        !is_new && first->second.text() != section.where.text()) {
      placed_.deck.otherwise.add(
          fmt::format("the section of set \"{}\" is taken for elements that have one of {} already",
                      section.set, first->second.text()),
          section.where);
      first->second = section.where;
    }
    for (auto [bar, end] = placed_.bar_of.equal_range({scope, label}); bar != end; ++bar)
      assign_bar(section, placed_.model.bars[bar->second.first], bar->second.second, index, instance);
    if (const auto found = placed_.cell_of.find({scope, label}); found != placed_.cell_of.end()) {
      ModelBuilder::Cell& cell = placed_.builder.cells()[found->second];
      if (lamina && dimension_of(cell.type) == 3)
        throw std::invalid_argument(
            fmt::format("{}: the material {} of solids is a LAMINA, which tells nothing across its plane; "
                        "give ENGINEERING CONSTANTS",
                        section.where.text(), section.material));
      if (layered && dimension_of(cell.type) == 3)
        throw std::invalid_argument(
            fmt::format("{}: solid element {} has the section of a shell", section.where.text(), label));
      const LayerAxes of_layer = [&](const std::string& name) {
        return material_axes(cell, &placed_.found_orientation(name, part.name, section.where), instance);
      };
      cell.material = layered       ? laminate_along(section, material_axes(cell, axes, instance), of_layer)
                      : orthotropic ? material_along(index, material_axes(cell, axes, instance))
                                    : index;
      cell.thickness = section.thickness;
      cell.offset = section.offset;
    }
  }
}

Eigen::Matrix3d SectionPlacer::material_axes(const ModelBuilder::Cell& cell, const Orientation* orientation,
                                             const Instance* instance) const {
  const int corners = shape_of(cell.type).corners;
  const auto at = [&](int a) { return placed_.builder.place(cell.nodes[static_cast<std::size_t>(a)]); };
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int a = 0; a < corners; ++a) middle += at(a) / corners;
  const Eigen::Matrix3d turn = instance ? instance->R : Eigen::Matrix3d::Identity();
  if (instance) middle = turn.transpose() * (middle - instance->t);  // the part's own place
  if (dimension_of(cell.type) == 3)
    return orientation ? Eigen::Matrix3d(turn * orientation->axes_at(middle)) : turn;
  const Eigen::Vector3d normal =
      corners == 3 ? (at(1) - at(0)).cross(at(2) - at(0)) : (at(2) - at(0)).cross(at(3) - at(1));
  if (!orientation) return laid_on(normal, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ());
  return turn * orientation->shell_axes_at(middle, turn.transpose() * normal);
}

Index SectionPlacer::material_along(Index material, const Eigen::Matrix3d& axes) {
  if (axes.isIdentity(1e-14)) return material;
  std::string key;
  for (const double c : axes.reshaped()) key += fmt::format("{:.0f} ", std::round(1e12 * c) + 0.0);
  const std::string name = placed_.model.materials[static_cast<std::size_t>(material)].name;
  const auto [at, fresh] =
      turned_.emplace(std::pair{name, key}, static_cast<Index>(placed_.model.materials.size()));
  if (fresh) {
    ImportedMaterial copy = placed_.model.materials[static_cast<std::size_t>(material)];
    copy.R = axes;
    placed_.model.materials.push_back(std::move(copy));
  }
  return at->second;
}

// SPRINGA and DASHPOTA along their line; SPRING2 and DASHPOT2 in one direction of both nodes.
void SectionPlacer::assign_spring(const ElementData& data, ImportedSpring& to, const Eigen::Matrix3d& axes) {
  const bool damps = data.kind == "DASHPOT";
  require_not_negative(data.values[0], "*" + data.kind, damps ? "coefficient" : "stiffness", data.where);
  const auto place = static_cast<std::size_t>(&to - placed_.model.springs.data());
  spring_set_.insert(place);
  std::array<double, 6>& numbers = damps ? to.damping : to.stiffness;
  if (placed_.along.contains(place)) {
    numbers[0] = data.values[0];
    return;
  }
  const double dof = data.dofs.empty() ? 0 : data.dofs[0];
  if (!(dof >= 1 && dof <= 6) || (data.dofs.size() > 1 && data.dofs[1] != dof))
    throw std::invalid_argument(
        fmt::format("{}: *{} of {}2 joins dof {:g} to dof {:g}; equal ones from 1 to 6 are read",
                    data.where.text(), data.kind, data.kind, dof, data.dofs.size() > 1 ? data.dofs[1] : dof));
  to.R = axes;
  numbers[static_cast<std::size_t>(dof) - 1] = data.values[0];
  const Eigen::Vector3d line = placed_.builder.place(to.nodes[1]) - placed_.builder.place(to.nodes[0]);
  if (dof < 4 && line.cross(axes.col(static_cast<Eigen::Index>(dof) - 1)).norm() > 1e-9 * line.norm())
    throw std::invalid_argument(
        fmt::format("{}: {} element {} acts in direction {:g} between nodes that do not lie one behind "
                    "the other in it, so that a turn of "
                    "the whole body would strain it; put both nodes in one place",
                    data.where.text(), damps ? "dashpot" : "spring", to.label, dof));
}

void SectionPlacer::assign(const ElementData& data, const Part& part, int scope, const Instance* instance) {
  const Eigen::Matrix3d turn = instance ? instance->R : Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d R =
      data.kind == "MASS"
          ? turn
          : Eigen::Matrix3d(turn * placed_.orientation(data.orientation, part.name, data.where));
  if (data.values.empty() || (data.kind == "ROTARY INERTIA" && data.values.size() < 3))
    throw std::invalid_argument(fmt::format("{}: *{} has no numbers", data.where.text(), data.kind));
  for (const std::int64_t label : labels_of(data.set, part, data.where)) {
    const std::pair<int, std::int64_t> key{scope, label};
    if (const auto spring = placed_.spring_of.find(key);
        (data.kind == "SPRING" || data.kind == "DASHPOT") && spring != placed_.spring_of.end())
      assign_spring(data, placed_.model.springs[spring->second], R);
    const auto mass = placed_.mass_of.find(key);
    if (mass == placed_.mass_of.end()) continue;
    ImportedMass& to = placed_.model.masses[mass->second];
    to.alpha = data.alpha;
    if (data.kind == "MASS") to.mass = data.values[0];
    if (data.kind != "ROTARY INERTIA") continue;
    std::vector<double> I = data.values;  // I11, I22, I33, I12, I13, I23: of the inertia tensor
    I.resize(6, 0.0);
    Eigen::Matrix3d J;
    J << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    to.inertia = R * J * R.transpose();
  }
}

void SectionPlacer::finish_others() {
  std::map<std::pair<Index, double>, std::size_t> at;  // by node and damping
  std::vector<ImportedMass> merged;
  for (const ImportedMass& mass : placed_.model.masses) {
    const auto [place, fresh] = at.emplace(std::pair{mass.node, mass.alpha}, merged.size());
    if (fresh) {
      merged.push_back(mass);
    } else {
      merged[place->second].mass += mass.mass;
      merged[place->second].inertia += mass.inertia;
    }
  }
  placed_.model.masses = std::move(merged);
  for (const ImportedBar& bar : placed_.model.bars)
    if (!(bar.A > 0))
      throw std::invalid_argument(
          fmt::format("beam element {} has no section (*BEAM SECTION, *BEAM GENERAL SECTION; trusses: "
                      "*SOLID SECTION with an area)",
                      bar.label));
  for (std::size_t k = 0; k < placed_.model.springs.size(); ++k)
    if (!spring_set_.contains(k))
      throw std::invalid_argument(fmt::format(
          "spring or dashpot element {} has no number (*SPRING, *DASHPOT)", placed_.model.springs[k].label));
  for (const std::size_t k : placed_.along) {
    ImportedSpring& spring = placed_.model.springs[k];
    const Eigen::Vector3d line =
        placed_.builder.place(spring.nodes[1]) - placed_.builder.place(spring.nodes[0]);
    if (!(line.norm() > 0))
      throw std::invalid_argument(
          fmt::format("element {} (SPRINGA or DASHPOTA) has no length, hence no direction", spring.label));
    const Eigen::Vector3d x = line.normalized(), y = x.unitOrthogonal();
    spring.R << x, y, x.cross(y);
  }
}

}  // namespace flexura::mesh::abaqus
