// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/recovery_file.hpp"

#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"

namespace flexura::superelement {

using hdf5::Group;
using hdf5::Shape;
using RowMajorXf = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

namespace {

void write_of_loads(Group& group, const Eigen::MatrixXd& of_loads, const std::string& unit) {
  if (of_loads.size() > 0)
    hdf5::write_matrix(group, "of_loads", of_loads.transpose(), unit,
                       "row i: what load case i adds to the shapes', places and components as above");
}

Eigen::MatrixXd read_of_loads(const Group& group, const Superelement& se, Eigen::Index rows) {
  if (!group.has("of_loads")) return {};
  return hdf5::read_matrix(group, "of_loads", static_cast<Eigen::Index>(se.load_cases.size()), rows)
      .transpose();
}

}  // namespace

void write_stress(Group root, const StressModes& stress) {
  Group group = root.create_group("stress");
  group.write("vertices", {stress.vertices.size()}, stress.vertices.data(), "",
              "(s): vertex of the surface at which the stresses are given");
  const std::string doc = "(k, 6 s + c): stress of shape k at place s, c = xx, yy, zz, xy, yz, zx";
  if (stress.double_precision) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_shape =
        stress.S.transpose();
    write_rows(group, "modes", by_shape, "Pa per dof", doc);
  } else {
    const RowMajorXf by_shape = stress.S.transpose().cast<float>();
    write_rows(group, "modes", by_shape, "Pa per dof", doc + ", float32");
  }
  group.set("precision", stress.double_precision ? "float64" : "float32");
  write_of_loads(group, stress.of_loads, "Pa");
  if (stress.of_acceleration.size() > 0) {
    const RowMajorXf of_acceleration = stress.of_acceleration.transpose().cast<float>();
    write_rows(group, "of_acceleration", of_acceleration, "Pa s^2, Pa s^2 per dof",
               "(j, 6 s + c): what inertia adds, j = 6 fields e_a x_b, then the interface shapes, float32");
  }
  if (stress.compliance.empty()) return;
  Eigen::MatrixXd compliance(6 * static_cast<Eigen::Index>(stress.compliance.size()), 6);
  for (std::size_t k = 0; k < stress.compliance.size(); ++k)
    compliance.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = stress.compliance[k];
  hdf5::write_matrix(
      group, "compliance", compliance, "1/Pa",
      "row 6 k + c: strain c = xx, yy, zz, xy, yz, zx (shears as angles) of material k by stress");
  group.write("material", {stress.material.size()}, stress.material.data(), "", "(s): material of the place");
}

namespace {

void read_compliance(const Group& group, StressModes& stress) {
  if (!group.has("compliance")) return;
  const Shape rows = group.shape("compliance");
  constexpr std::size_t most_materials = 100'000;
  if (rows.size() != 2 || rows[0] % 6 != 0 || rows[0] > 6 * most_materials)
    throw hdf5::BadFile(group.label() +
                        "/compliance: has the wrong shape; the file is damaged, make it again");
  const Eigen::MatrixXd compliance =
      hdf5::read_matrix(group, "compliance", static_cast<Eigen::Index>(rows[0]), 6);
  for (Eigen::Index k = 0; k < compliance.rows(); k += 6)
    stress.compliance.push_back(compliance.middleRows<6>(k));
  stress.material.resize(stress.vertices.size());
  group.read("material", {stress.material.size()}, stress.material.data());
}

}  // namespace

void read_stress(const Group& root, Superelement& se) {
  if (!root.has("stress")) return;
  const Group group = root.group("stress");
  StressModes& stress = se.stress.emplace();
  stress.double_precision = group.text("precision") == "float64";
  const Shape places = group.shape("vertices");
  constexpr std::size_t most_places = std::size_t{1} << 28;
  if (places.size() != 1 || places[0] > most_places) {
    throw hdf5::BadFile(group.label() + "/vertices: has the wrong shape; the file is damaged, make it again");
  }
  stress.vertices.resize(places[0]);
  group.read("vertices", places, stress.vertices.data());
  read_compliance(group, stress);
  const Eigen::Index width = 6 * static_cast<Eigen::Index>(places[0]);
  stress.of_loads = read_of_loads(group, se, width);
  if (group.has("of_acceleration")) {
    RowMajorXf of_acceleration(6 + se.n_b, width);
    group.read("of_acceleration", {static_cast<std::size_t>(6 + se.n_b), static_cast<std::size_t>(width)},
               of_acceleration.data());
    stress.of_acceleration = of_acceleration.transpose().cast<double>();
  }
  if (stress.double_precision) {
    stress.S = hdf5::read_matrix(group, "modes", se.n(), width).transpose();
    return;
  }
  RowMajorXf by_shape(se.n(), width);
  group.read("modes", {static_cast<std::size_t>(se.n()), static_cast<std::size_t>(width)}, by_shape.data());
  stress.S = by_shape.transpose().cast<double>();
}

void write_sections(Group root, const SectionForces& sections) {
  Group group = root.create_group("sections");
  const nlohmann::json names = sections.members;
  group.write_text("members", names.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                   "JSON: names of the members");
  group.write("member", {sections.member.size()}, sections.member.data(), "",
              "(p): number of the member of each place, from 0");
  write_rows(group, "positions", sections.positions, "m", "(p, a): place on the member's axis, frame B");
  write_rows(group, "axes", sections.axes, "",
             "(p, 3 a + c): component a in B of the member's axis c = x, y, z");
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_shape =
      sections.S.transpose();
  write_rows(group, "forces", by_shape, "N, N m per dof",
             "(k, 6 p + c): section force of shape k at place p, c = N, V_y, V_z, T, M_y, M_z");
  write_of_loads(group, sections.of_loads, "N, N m");
  if (sections.of_acceleration.size() == 0) return;
  hdf5::write_matrix(group, "of_acceleration", sections.of_acceleration.transpose(),
                     "N, N m per m/s^2, 1/s^2",
                     "(j, 6 p + c): what inertia adds, j = e_b, then x_a e_b in row 3 + 3 a + b");
  const RowMajorXf of_deformation = sections.of_deformation.transpose();
  write_rows(group, "of_deformation", of_deformation, "N, N m per shape/s^2",
             "(9 k + 3 a + b, 6 p + c): what the inertia of phi_k,a e_b adds, float32");
  hdf5::write_matrix(group, "turning", sections.turning.transpose(), "rad per dof",
                     "(k, 3 p + a): rotation of the section by shape k, in B");
  if (sections.of_stiffening.size() == 0) return;
  const RowMajorXf of_stiffening = sections.of_stiffening.transpose();
  write_rows(
      group, "of_stiffening", of_stiffening, "N, N m per dof, per unit load",
      "(k n + j, 6 p + c): what shape j adds under unit load k, in the order K0t, K0r, K0omega, K0F, K0p, "
      "float32");
}

void read_sections(const Group& root, Superelement& se) {
  if (!root.has("sections")) return;
  const Group group = root.group("sections");
  SectionForces& sections = se.sections.emplace();
  try {
    sections.members = files::read_json(group.read_text("members")).get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {
    throw hdf5::BadFile(group.label() + "/members: is no list of names; the file is damaged, make it again");
  }
  read_rows(group, "positions", sections.positions);
  read_rows(group, "axes", sections.axes);
  const auto n_places = static_cast<std::size_t>(sections.positions.rows());
  sections.member.resize(n_places);
  group.read("member", {n_places}, sections.member.data());
  sections.S = hdf5::read_matrix(group, "forces", se.n(), 6 * sections.positions.rows()).transpose();
  const Eigen::Index n_p = sections.positions.rows();
  sections.of_loads = read_of_loads(group, se, 6 * n_p);
  if (!group.has("of_acceleration")) return;
  sections.of_acceleration = hdf5::read_matrix(group, "of_acceleration", 12, 6 * n_p).transpose();
  sections.turning = hdf5::read_matrix(group, "turning", se.n(), 3 * n_p).transpose();
  RowMajorXf of_deformation(9 * se.n(), 6 * n_p);
  group.read("of_deformation", {static_cast<std::size_t>(9 * se.n()), static_cast<std::size_t>(6 * n_p)},
             of_deformation.data());
  sections.of_deformation = of_deformation.transpose();
  if (!group.has("of_stiffening")) return;
  const auto loads = static_cast<Eigen::Index>(12 + static_cast<std::size_t>(se.n_b) + se.load_cases.size());
  RowMajorXf of_stiffening(loads * se.n(), 6 * n_p);
  group.read("of_stiffening", {static_cast<std::size_t>(loads * se.n()), static_cast<std::size_t>(6 * n_p)},
             of_stiffening.data());
  sections.of_stiffening = of_stiffening.transpose();
}

}  // namespace flexura::superelement
