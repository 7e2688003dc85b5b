// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/mesh_error_file.hpp"

#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"
#include "mbs/superelement/recovery_file.hpp"

namespace flexura::superelement {

using hdf5::Group;
using hdf5::Shape;

namespace {

constexpr const char* by_enrichment = "enrichment";
constexpr Eigen::Index kMostVertices = Eigen::Index{1} << 28;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

Eigen::RowVector4d row_of(const MeshError::Stress& stress) {
  return {stress.mean, stress.peak, static_cast<double>(stress.vertex), stress.singular ? 1.0 : 0.0};
}

MeshError::Stress stress_of(const Eigen::RowVector4d& row) {
  const bool is_place = row(2) >= -1.0 && row(2) < 2147483647.0;
  return {.mean = row(0),
          .peak = row(1),
          .vertex = is_place ? static_cast<int>(row(2)) : -2,
          .singular = row(3) > 0.5};
}

Eigen::Index length_of(const Group& group, const std::string& name) {
  const Shape shape = group.shape(name);
  if (shape.size() != 1 || shape[0] > static_cast<std::size_t>(kMostVertices))
    throw hdf5::BadFile(group.label() + "/" + name +
                        ": has the wrong shape; the file is damaged, make it again");
  return static_cast<Eigen::Index>(shape[0]);
}

}  // namespace

void write_mesh_error(Group root, const MeshError& error) {
  Group group = root.create_group("mesh_error");
  group.set("by", error.rough ? "recovered stresses" : by_enrichment);
  const auto n_modes = static_cast<Eigen::Index>(error.modes.size()),
             n_loads = static_cast<Eigen::Index>(error.interfaces.size());
  Eigen::VectorXd frequency(n_modes), of_frequency(n_modes), of_compliance(n_loads);
  Rows modes(n_modes, 4), loads(n_loads, 4);
  nlohmann::json names = nlohmann::json::array();
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    const MeshError::Mode& mode = error.modes[static_cast<std::size_t>(k)];
    frequency(k) = mode.frequency_hz;
    of_frequency(k) = mode.error;
    modes.row(k) = row_of(mode.stress);
  }
  for (Eigen::Index k = 0; k < n_loads; ++k) {
    const MeshError::Interface& interface = error.interfaces[static_cast<std::size_t>(k)];
    names.push_back(interface.name);
    of_compliance(k) = interface.compliance_error;
    loads.row(k) = row_of(interface.stress);
  }
  const std::string columns =
      "root mean square over the part, of the greatest; its vertex or -1; 1: greatest where it is unbounded";
  hdf5::write_vector(group, "frequency", frequency, "Hz",
                     "(m): elastic modes of the free body that were judged");
  hdf5::write_vector(group, "frequency_error", of_frequency, "",
                     "(m): relative; 1 not resolved, -1 not known");
  write_rows(group, "modes", modes, "", "(m, 4): error of their stress: " + columns);
  group.write_text("interfaces", names.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                   "JSON: names of the interfaces that were judged");
  hdf5::write_vector(group, "compliance_error", of_compliance, "",
                     "(i): relative, worst direction; 1 not resolved, -1 not known");
  write_rows(group, "loads", loads, "", "(i, 4): error of stress under the worst load there: " + columns);
  if (error.at_vertices.size() > 0)
    group.write("vertices", {static_cast<std::size_t>(error.at_vertices.size())}, error.at_vertices.data(),
                "",
                "(v): error of stress at each vertex of the surface over the root mean square of the stress");
}

void read_mesh_error(const Group& root, Superelement& se) {
  if (!root.has("mesh_error")) return;
  const Group group = root.group("mesh_error");
  MeshError error;
  error.rough = group.text("by") != by_enrichment;
  const Eigen::Index n_modes = length_of(group, "frequency"), n_loads = length_of(group, "compliance_error");
  const Eigen::VectorXd frequency = hdf5::read_vector(group, "frequency", n_modes),
                        of_frequency = hdf5::read_vector(group, "frequency_error", n_modes),
                        of_compliance = hdf5::read_vector(group, "compliance_error", n_loads);
  const Eigen::MatrixXd modes = hdf5::read_matrix(group, "modes", n_modes, 4),
                        loads = hdf5::read_matrix(group, "loads", n_loads, 4);
  for (Eigen::Index k = 0; k < n_modes; ++k)
    error.modes.push_back(
        {.frequency_hz = frequency(k), .error = of_frequency(k), .stress = stress_of(modes.row(k))});
  std::vector<std::string> names;
  try {
    names = files::read_json(group.read_text("interfaces")).get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {
  }
  if (static_cast<Eigen::Index>(names.size()) != n_loads)
    throw hdf5::BadFile(group.label() +
                        "/interfaces: is no list of names that fits; the file is damaged, make it again");
  for (Eigen::Index k = 0; k < n_loads; ++k)
    error.interfaces.push_back({.name = names[static_cast<std::size_t>(k)],
                                .compliance_error = of_compliance(k),
                                .stress = stress_of(loads.row(k))});
  if (group.has("vertices")) {
    const Eigen::Index n = length_of(group, "vertices");
    error.at_vertices.resize(n);
    group.read("vertices", {static_cast<std::size_t>(n)}, error.at_vertices.data());
  }
  se.mesh_error = std::move(error);
}

}  // namespace flexura::superelement
