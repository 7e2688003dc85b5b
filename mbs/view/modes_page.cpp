// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "mbs/view/html/page_file.hpp"
#include "mbs/view/pages.hpp"
#include "mbs/view/stress_picture.hpp"
#include "mbs/view/surface_blocks.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;

constexpr const char* direction_names[] = {"u_x", "u_y", "u_z", "θ_x", "θ_y", "θ_z"};

json interfaces_json(const superelement::Superelement& se) {
  json list = json::array();
  for (const auto& item : se.interfaces) {
    json directions = json::array();
    for (const auto direction : item.directions)
      directions.push_back(direction_names[static_cast<int>(direction)]);
    for (const auto direction : item.following)
      directions.push_back(std::string(direction_names[static_cast<int>(direction)]) + " (follows)");
    list.push_back({{"name", item.name},
                    {"tie", item.tie},
                    {"position", {item.p_BoN_B.x(), item.p_BoN_B.y(), item.p_BoN_B.z()}},
                    {"directions", directions}});
  }
  return list;
}

/// MAC_ij = |u_i . u_j|^2 / (|u_i|^2 |u_j|^2) over the vertices, through the Gram matrix of the shape
/// functions.
json mac_json(const superelement::Superelement& se, const Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd gram = (se.shapes.transpose() * se.shapes).cast<double>();
  const Eigen::MatrixXd products = columns.transpose() * gram * columns;
  json rows = json::array();
  for (Eigen::Index i = 0; i < products.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < products.cols(); ++j) {
      const double both = products(i, i) * products(j, j);
      const double mac = both > 0.0 ? products(i, j) * products(i, j) / both : 0.0;
      row.push_back(std::round(1e4 * mac) / 1e4);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

void require_sizes(const superelement::Superelement& se, const ModesPage& page) {
  require_pictures(se);
  if (page.columns.cols() != static_cast<Eigen::Index>(page.modes.size()) ||
      (!page.modes.empty() && page.columns.rows() != se.n())) {
    throw std::invalid_argument(
        fmt::format("superelement '{}' has {} shape functions and the list {} modes, so the modes' columns "
                    "must be {} x {}, but "
                    "they are {} x {}",
                    se.name, se.n(), page.modes.size(), se.n(), page.modes.size(), page.columns.rows(),
                    page.columns.cols()));
  }
  for (std::size_t j = 0; j < page.modes.size(); ++j) {
    if (!page.columns.col(static_cast<Eigen::Index>(j)).allFinite() ||
        !std::isfinite(page.modes[j].frequency_hz)) {
      throw std::invalid_argument(fmt::format("mode {} of superelement '{}' holds a value that is not finite",
                                              page.modes[j].number, se.name));
    }
  }
}

}  // namespace

void write_modes_page(const std::filesystem::path& html, const superelement::Superelement& se,
                      const ModesPage& page) {
  require_sizes(se, page);
  PageFile file(html, se.name + " · modes");
  SurfaceBlocks surface(file, "part", se.surface, fmt::format("superelement '{}'", se.name),
                        static_cast<int>(page.modes.size()));
  std::optional<StressField> stress;
  if (se.stress) stress.emplace(se);
  json modes = json::array();
  for (std::size_t j = 0; j < page.modes.size(); ++j) {
    const PageMode& mode = page.modes[j];
    surface.add_shape(se.shapes * page.columns.col(static_cast<Eigen::Index>(j)).cast<float>());
    // One mode is shown at a time, so its von Mises stress is enough: it grows with the amplitude.
    if (stress) surface.add_stress(stress->von_mises(page.columns.col(static_cast<Eigen::Index>(j))), 1);
    modes.push_back({{"set", mode.set},
                     {"number", mode.number},
                     {"kind", mode.kind},
                     {"detail", mode.detail},
                     {"can_strike", mode.can_strike}});
    if (mode.vibrates)
      modes.back().update({{"frequency", mode.frequency_hz},
                           {"damping", mode.damping},
                           {"effective_mass", mode.effective_mass}});
  }
  const bool has_error = se.mesh_error && se.mesh_error->at_vertices.size() == se.surface.vertices.rows();
  if (has_error)
    file.add<float>("mesh_error", {se.mesh_error->at_vertices.data(),
                                   static_cast<std::size_t>(se.mesh_error->at_vertices.size())});
  const double mass = se.inertia.mass;
  const Eigen::Vector3d centre =
      mass > 0.0 ? Eigen::Vector3d(se.inertia.S_x / mass) : Eigen::Vector3d::Zero();
  // Moments of inertia about axes through the mass centre: J_aa = S_bb + S_cc, with S about the centre.
  const Eigen::Vector3d S = (se.inertia.S_xx - mass * centre * centre.transpose()).diagonal();
  const std::array<double, 6> whole = {mass, mass, mass, S.y() + S.z(), S.z() + S.x(), S.x() + S.y()};
  file.finish({{"format", 1},
               {"page", "modes"},
               {"title", se.name},
               {"created_by", se.created_by},
               {"body",
                {{"mass", mass},
                 {"centre", {centre.x(), centre.y(), centre.z()}},
                 {"whole", whole},
                 {"n_b", se.n_b},
                 {"n_q", se.n_q}}},
               {"interfaces", interfaces_json(se)},
               {"surface", surface.header()},
               {"modes", modes},
               {"mesh_error", has_error},
               {"mac", mac_json(se, page.columns)}});
}

}  // namespace flexura::view
