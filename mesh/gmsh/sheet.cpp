// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/sheet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/cad_file.hpp"
#include "mesh/gmsh/cad_job.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;

Job sheet_job(const CadOptions& options, CadReport& report) {
  for (const auto& [given, key] :
       {std::pair{options.fuse, "fuse"}, {options.heal, "heal"}, {!options.solids.empty(), "solid"}})
    if (given)
      throw std::invalid_argument(fmt::format(
          "{}: geometry.{} is for solids, [shell] takes faces; leave it out", options.path.string(), key));
  Job job = first_job(options, inspect_cad_file(options.path), report);
  job.task = "sheet";
  job.order = 1;
  return job;
}

Answer ask(const CadOptions& options, const Job& job, double limit_s, const Progress& progress,
           Allowance* time = nullptr) {
  try {
    return ask_worker(options.worker, job, limit_s, progress, time);
  } catch (const PartRefused& e) {
    throw std::invalid_argument(options.path.string() + ": " + e.what());
  }
}

void check_thickness(const CadOptions& options, double thickness, const ResultRecord& listed) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(
        fmt::format("{}: the thickness of {:.6g} mm {}", options.path.string(), 1e3 * thickness, why));
  };
  if (!(thickness > 0.0 && std::isfinite(thickness))) refuse("must be above 0");
  const double width =
      std::min(std::sqrt(listed.area), listed.outline > 0 ? 2.0 * listed.area / listed.outline : HUGE_VAL);
  if (thickness > 0.5 * width)
    refuse(
        fmt::format("is more than half the width of its faces, {:.4g} mm on the mean: that is no sheet; is "
                    "the unit right? Else "
                    "mesh it as a solid",
                    1e3 * width));
  for (const FaceRecord& face : listed.faces) {
    const auto kind = static_cast<FaceKind>(face.kind);
    if ((kind == FaceKind::cylinder || kind == FaceKind::sphere) && thickness > 2.0 * face.radius)
      refuse(fmt::format(
          "is more than the diameter of face {}, {:.4g} mm, about which it would overlap with itself",
          face.number, 2e3 * face.radius));
  }
}

// Cells of one block, and their faces; std::runtime_error for what is cut short.
void take_block(const BlockRecord& record, const std::vector<std::int64_t>& integers, std::size_t& at,
                Index n_points, double thickness, CadMesh& out) {
  const auto type = static_cast<CellType>(record.type);
  if (type != CellType::quad4 && type != CellType::tri3)
    throw TryFailed("handed over cells that are none of shells");
  const auto n = static_cast<std::size_t>(nodes_per_cell(type));
  if (integers.size() - at < record.n * (n + 1)) throw TryFailed("handed over an incomplete result");
  CellBlock block;
  block.type = type;
  block.nodes.resize(static_cast<Eigen::Index>(record.n), static_cast<Eigen::Index>(n));
  for (std::size_t k = 0; k < record.n; ++k)
    out.mesh.boundary_face.push_back(static_cast<Index>(integers[at + k]));
  at += record.n;
  for (std::size_t k = 0; k < record.n * n; ++k) {
    const std::int64_t node = integers[at + k];
    if (node < 0 || node >= n_points) throw TryFailed("handed over an incomplete result");
    block.nodes.data()[k] = static_cast<Index>(node);
  }
  at += record.n * n;
  out.mesh.boundary.push_back(block);
  block.thickness.assign(record.n, thickness);
  out.mesh.shells.push_back(std::move(block));
}

CadMesh accept(const Answer& answer, double thickness) {
  CadMesh out;
  Mesh& mesh = out.mesh;
  mesh.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      answer.arrays.points.data(), static_cast<Eigen::Index>(answer.record.n_points), 3);
  std::size_t at = 0;
  for (const BlockRecord& record : answer.record.blocks)
    take_block(record, answer.arrays.integers, at, mesh.n_nodes(), thickness, out);
  double area = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (const CellBlock& block : mesh.shells)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell, ++out.report.n_cells) {
      const Eigen::Index n = block.nodes.cols();
      const auto x = [&](Eigen::Index a) -> Vector3d {
        return mesh.points.row(block.nodes(cell, (a + n) % n));
      };
      const Vector3d across =
          n == 3 ? Vector3d((x(1) - x(0)).cross(x(2) - x(0))) : Vector3d((x(2) - x(0)).cross(x(3) - x(1)));
      // A corner that turns in, or is nearly straight: the map of the cell folds there.
      for (Eigen::Index a = 0; a < n; ++a)
        if (!((x(a + 1) - x(a)).cross(x(a - 1) - x(a)).dot(across) > 0.05 * across.squaredNorm()))
          throw TryFailed("gave cells that are folded or flat");
      Vector3d middle = Vector3d::Zero();
      for (Eigen::Index a = 0; a < n; ++a) middle += x(a) / static_cast<double>(n);
      area += 0.5 * across.norm();
      moment += 0.5 * across.norm() * middle;
    }
  MeshReport& report = out.report;
  report.n_nodes = mesh.n_nodes();
  report.cad_volume = answer.record.area * thickness;
  report.volume = area * thickness;
  report.volume_error = report.volume / report.cad_volume - 1.0;
  report.centroid = moment / area;
  for (const FaceRecord& face : answer.record.faces)
    report.cad_centroid +=
        face.area / answer.record.area * Vector3d(face.centroid[0], face.centroid[1], face.centroid[2]);
  if (!(std::abs(report.volume_error) < 0.25)) throw TryFailed("gave a mesh that is not this surface");
  return out;
}

}  // namespace

CadReport list_sheet(const CadOptions& options, const Progress& progress) {
  CadReport report;
  const Job job = sheet_job(options, report);
  try {
    fill_report(
        ask(options, job, std::min(options.time_limit_s, listing_limit_s(options.path)), progress).record,
        report);
  } catch (const TryFailed& e) {
    throw std::runtime_error(options.path.string() + ": reading the CAD file failed: it " + e.what());
  }
  return report;
}

CadMesh mesh_sheet(const CadOptions& options, double thickness, const Progress& progress) {
  Allowance time(options.time_limit_s);
  CadReport report;
  Job job = sheet_job(options, report);
  std::vector<std::string> reasons;
  try {
    const ResultRecord listed =
        ask(options, job, std::min(time.left(), listing_limit_s(options.path)), progress, &time).record;
    check_thickness(options, thickness, listed);
    fill_report(listed, report);
    if (options.size > 0) require_few_cells(options.size, 0.0, listed.area);
    job.size = options.size > 0 ? options.size : std::sqrt(listed.area) / 20.0;
    job.size_min = options.size_min > 0 ? std::min(options.size_min, job.size) : job.size / 5.0;
  } catch (const TryFailed& e) {
    throw std::runtime_error(options.path.string() + ": reading the CAD file failed: it " + e.what());
  }
  // gmsh's algorithms: frontal and Delaunay triangles joined to quadrilaterals, triangles alone.  (The one made for
  // quadrilaterals, 8, has been seen to crash where three faces meet.)
  for (const int algorithm : {6, 5, 1}) {
    job.surface_algorithm = algorithm;
    try {
      if (!(time.left() > 0)) throw TryFailed("had no time left");
      CadMesh out = accept(ask(options, job, time.left(), progress, &time), thickness);
      out.report.messages = report.messages;
      out.report.messages.push_back(fmt::format("a sheet of {} face{}, {:.6g} mm thick, {:.6g} mm2",
                                                report.faces.size(), report.faces.size() == 1 ? "" : "s",
                                                1e3 * thickness, 1e6 * report.area));
      for (const std::string& reason : reasons)
        out.report.messages.push_back("meshed anew, since a try " + reason);
      out.report.size = job.size;
      out.report.seconds = time.spent();
      out.cad = std::move(report);
      add_named_sets(out.cad.faces, out.mesh);
      return out;
    } catch (const TryFailed& e) {
      reasons.emplace_back(e.what());
    }
  }
  throw std::runtime_error(
      fmt::format("{}: its faces cannot be meshed at size {:.4g} mm (it {}); another mesh.size or a repaired "
                  "CAD file may help",
                  options.path.string(), 1e3 * job.size, fmt::join(reasons, "; ")));
}

}  // namespace flexura::mesh
