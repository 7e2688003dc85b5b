// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/cad.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/cad_file.hpp"
#include "mesh/gmsh/cad_job.hpp"

namespace flexura::mesh {
namespace {

namespace fs = std::filesystem;

constexpr double kVolumeGoal = 0.005;  // of the CAD volume
constexpr double kSizeRange = 3;       // greatest over least size: small fillets are not resolved by default
constexpr double kSliver = 1e-3;       // of the scaled Jacobian
constexpr double kVolumeRefusal = 0.05;  // beyond, the mesh is not this part

std::string list_solids(const std::vector<CadSolid>& solids) {
  std::string text;
  for (const CadSolid& solid : solids) {
    text += fmt::format("\n  solid {}{}: {:.6g} mm^3, centre {}", solid.number,
                        solid.name.empty() ? "" : " \"" + solid.name + "\"", 1e9 * solid.volume,
                        describe_point_mm(solid.centroid));
    if (solid.same_as != 0) text += fmt::format(", the same as solid {}", solid.same_as);
  }
  return text;
}

void check_options(const CadOptions& options) {
  const auto refuse = [](const std::string& text) { throw std::invalid_argument(text); };
  if (options.order != 1 && options.order != 2)
    refuse(fmt::format("element order {} is not possible; take 1 (tet4) or 2 (tet10)", options.order));
  if (!(options.size >= 0))
    refuse(fmt::format("mesh size {} m is negative; give a length, or 0 for automatic", options.size));
  if (!(options.size_min >= 0) || (options.size > 0 && options.size_min > options.size))
    refuse(fmt::format("least mesh size {} m must lie between 0 and the mesh size {} m", options.size_min,
                       options.size));
  if (!(options.elements_per_circle >= 0) || options.elements_per_circle > 1000)
    refuse(fmt::format("{} elements for each circle are not possible; take 0 to 1000",
                       options.elements_per_circle));
  if (!(options.time_limit_s > 0)) refuse("the time limit must be greater than zero");
}

/// Lists, and checks the choice of solids.  The time spent counts.
CadReport list_and_choose(const CadOptions& options, bool must_be_one, Job& job, const Progress& progress,
                          ResultRecord* record) {
  check_options(options);
  const CadFile file = inspect_cad_file(options.path);
  if (file.format == "stl" && (options.fuse || options.heal))
    throw std::invalid_argument(fmt::format(
        "{}: is a surface of triangles, which cannot be {}; take the key {} out of the table [geometry]",
        options.path.string(), options.fuse ? "fused" : "healed", options.fuse ? "fuse" : "heal"));
  CadReport report;
  job = first_job(options, file, report);
  job.task = "list";
  const std::string name = options.path.string();
  Job all = job;
  all.fuse = false;
  all.heal = false;
  all.solids.clear();
  const auto list = [&](const Job& which) {
    try {
      return ask_worker(options.worker, which, std::min(options.time_limit_s, listing_limit_s(options.path)),
                        progress);
    } catch (const PartRefused& e) {  // what the file holds, not what failed
      throw std::invalid_argument(name + ": " + e.what());
    } catch (const WorkerCrashed& e) {
      throw std::invalid_argument(name + ": is not read: it " + e.what() +
                                  "; the file is damaged, save it again from the CAD program");
    } catch (const TryFailed& e) {
      throw std::runtime_error(name + ": reading the CAD file failed: it " + e.what() +
                               "; save it again from the CAD program");
    }
  };
  Answer answer = list(all);
  fill_report(answer.record, report);
  for (const CadSolid& solid : report.solids)
    if (solid.same_as != 0)
      report.messages.push_back(fmt::format(
          "solid {} is solid {} given twice in the same place; it is left out", solid.number, solid.same_as));
  for (const int number : options.solids)
    if (std::none_of(report.solids.begin(), report.solids.end(),
                     [&](const CadSolid& s) { return s.number == number; }))
      throw std::invalid_argument(
          fmt::format("{}: there is no solid {}; it has{}", name, number, list_solids(report.solids)));
  const std::size_t left = options.solids.empty() ? answer.record.kept.size() : options.solids.size();
  if (must_be_one && left > 1 && !options.fuse)
    throw std::invalid_argument(
        fmt::format("{}: {} solids to mesh; choose one by its number (solid = 1 in the table [geometry]), or "
                    "join those that touch "
                    "(fuse = true there):{}",
                    name, left, list_solids(report.solids)));
  job.solids = options.solids.empty() ? answer.record.kept : options.solids;
  if (job.fuse || job.heal || !options.solids.empty()) {
    answer = list(job);
    fill_report(answer.record, report);
  }
  report.messages.insert(report.messages.end(), answer.record.messages.begin(), answer.record.messages.end());
  if (record) *record = answer.record;
  return report;
}

double diagonal_of(const CadReport& report) {
  Eigen::AlignedBox3d box;
  for (const Face& face : report.faces) {
    box.extend(face.box.row(0).transpose());
    box.extend(face.box.row(1).transpose());
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

Mesh build_mesh(const Answer& answer, int order) {
  const ResultRecord& record = answer.record;
  const Arrays& arrays = answer.arrays;
  Mesh mesh;
  mesh.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      arrays.points.data(), static_cast<Eigen::Index>(record.n_points), 3);
  CellBlock block;
  block.type = order == 2 ? CellType::tet10 : CellType::tet4;
  block.nodes = Eigen::Map<const decltype(block.nodes)>(
      arrays.tetrahedra.data(), static_cast<Eigen::Index>(record.n_tetrahedra), order == 2 ? 10 : 4);
  mesh.solids.push_back(std::move(block));
  extract_boundary(mesh);

  std::map<std::array<Index, 3>, Index> face_of;
  for (std::size_t k = 0; k < record.n_triangles; ++k) {
    std::array<Index, 3> key{arrays.triangles[3 * k], arrays.triangles[3 * k + 1],
                             arrays.triangles[3 * k + 2]};
    std::sort(key.begin(), key.end());
    face_of[key] = arrays.face[k];
  }
  for (const CellBlock& surface : mesh.boundary)
    for (Index cell = 0; cell < surface.nodes.rows(); ++cell) {
      std::array<Index, 3> key{surface.nodes(cell, 0), surface.nodes(cell, 1), surface.nodes(cell, 2)};
      std::sort(key.begin(), key.end());
      const auto found = face_of.find(key);
      if (found == face_of.end()) throw TryFailed("the mesh has an outer triangle that lies on no CAD face");
      mesh.boundary_face.push_back(found->second);
    }
  return mesh;
}

/// Builds, mends and judges; throws TryFailed when the mesh cannot be used.
CadMesh accept(const Answer& answer, const CadOptions& options) {
  CadMesh out;
  out.mesh = build_mesh(answer, options.order);
  MeshReport& report = out.report;
  report.quality = measure_quality(out.mesh);
  if (options.order == 2 && report.quality.n_below > 0) {
    const Index n_below = report.quality.n_below, n_inverted = report.quality.n_inverted;
    report.n_straightened = straighten_poor_cells(out.mesh);
    report.quality = measure_quality(out.mesh);
    report.messages.push_back(
        fmt::format("{} curved elements were nearly or wholly turned ({} wholly): {} mid-edge nodes "
                    "were put on straight edges",
                    n_below, n_inverted, report.n_straightened));
  }
  if (report.quality.n_inverted > 0)
    throw TryFailed(
        fmt::format("{} elements are turned inside out and cannot be mended", report.quality.n_inverted));
  const Volumes volumes = measure_volume(out.mesh);
  report.n_nodes = out.mesh.n_nodes();
  report.n_cells = out.mesh.n_solid_cells();
  report.cad_volume = answer.record.volume;
  report.cad_centroid = vector_of(answer.record.centroid);
  report.volume = volumes.volume;
  report.centroid = volumes.centroid;
  report.volume_error = volumes.volume / report.cad_volume - 1;
  const double bound = options.order == 2 ? kVolumeRefusal : 5 * kVolumeRefusal;
  if (!(std::abs(report.volume_error) < bound))
    throw TryFailed(
        fmt::format("the mesh has {:+.1f} % of the CAD volume too much", 100 * report.volume_error));
  if (const Pieces pieces = find_pieces(out.mesh); pieces.count != 1)
    throw TryFailed(fmt::format("the mesh falls into {} pieces", pieces.count));
  return out;
}

struct Attempt {
  std::string what;
  int surface_algorithm;
  double size_min_factor;
  bool heal;
};

}  // namespace

void require_few_cells(double size, double volume, double area) {
  // Of regular tetrahedra, and of triangles on the surface: a mesh for which days of work and all memory would not do.
  constexpr double kMostTetrahedra = 2e7, kMostTriangles = 1e7;
  const double tetrahedra = 6.0 * std::sqrt(2.0) * volume / (size * size * size),
               triangles = 4.0 / std::sqrt(3.0) * area / (size * size);
  if (tetrahedra <= kMostTetrahedra && triangles <= kMostTriangles) return;
  const double least =
      std::max(size * std::cbrt(tetrahedra / kMostTetrahedra), size * std::sqrt(triangles / kMostTriangles));
  throw std::invalid_argument(fmt::format(
      "mesh.size is {:.3g} m, which takes about {:.1g} elements for this part, more than the {:.0g} "
      "that are tried; choose {:.2g} m or more",
      size, std::max(tetrahedra, triangles), kMostTetrahedra, 1.05 * least));
}

double automatic_size(double volume, double area, double diagonal) {
  return std::clamp(area > 0 ? 2 * volume / area : diagonal, diagonal / 80, diagonal / 20);
}

CadReport list_faces(const CadOptions& options, const Progress& progress) {
  Job job;
  return list_and_choose(options, false, job, progress, nullptr);
}

CadMesh mesh_cad(const CadOptions& options, const Progress& progress) {
  Allowance time(options.time_limit_s);
  Job job;
  ResultRecord listed;
  CadReport report = list_and_choose(options, true, job, progress, &listed);
  job.task = "mesh";
  double size =
      options.size > 0 ? options.size : automatic_size(listed.volume, listed.area, diagonal_of(report));
  double size_min = options.size_min > 0 ? std::min(options.size_min, size) : size / kSizeRange;
  if (options.size > 0) require_few_cells(options.size, listed.volume, listed.area);
  if (options.size == 0 && options.sizes.empty()) {
    job.most_triangles = options.most_triangles;
    job.most_tetrahedra = options.most_tetrahedra;
  }
  job.sizes = options.sizes;
  if (!job.sizes.empty()) {
    size = 0.0, size_min = job.sizes[3];
    for (std::size_t k = 3; k < job.sizes.size(); k += 4) {
      size = std::max(size, job.sizes[k]);
      size_min = std::min(size_min, job.sizes[k]);
    }
  }
  job.size = size;

  std::vector<Attempt> attempts = {{"as asked", 6, 1, options.heal},
                                   {"with the MeshAdapt surface mesher", 1, 1, options.heal},
                                   {"with a greater least size", 6, 3, options.heal}};
  if (!options.heal && job.format != "stl") attempts.push_back({"after healing the shape", 6, 1, true});

  std::vector<std::string> messages, reasons;
  int refinements = 0;
  for (std::size_t k = 0; k < attempts.size();) {
    const Attempt& attempt = attempts[k];
    job.surface_algorithm = attempt.surface_algorithm;
    job.size_min = std::min(size, attempt.size_min_factor * size_min);
    job.heal = attempt.heal;
    const double left = time.left();
    // The first try may take most of the time; what hangs must leave some for the others.
    const double limit = k + 1 < attempts.size() ? 0.6 * left : left;
    if (left <= 0) {
      reasons.push_back(fmt::format("no time is left of {:.3g} s", options.time_limit_s));
      break;
    }
    try {
      const Answer answer = ask_worker(options.worker, job, limit, progress, &time);
      if (progress) progress("checking the mesh", 0.97);
      CadMesh out = accept(answer, options);
      if (std::abs(out.report.volume_error) > kVolumeGoal && refinements < 2 && job.elements_per_circle > 0) {
        ++refinements;
        job.elements_per_circle *= 2;
        messages.push_back(fmt::format(
            "volume {:+.2f} % off the CAD volume: meshed again with {:.0f} elements for each circle",
            100 * out.report.volume_error, job.elements_per_circle));
        continue;
      }
      if (k > 0) messages.push_back("meshed " + attempt.what);
      if (answer.record.graded)
        messages.push_back(
            "short edges would fill the part with small elements: to bound the mesh, sizes grow away from "
            "them; state a mesh "
            "size for a finer one");
      if (answer.record.size != job.size)
        messages.push_back(fmt::format(
            "the part has many small features: sizes were raised to {:.4g} mm, at least {:.4g} mm, "
            "{:.0f} elements for each circle, to bound the mesh; state a mesh size for a finer one",
            1e3 * answer.record.size, 1e3 * answer.record.size_min, answer.record.elements_per_circle));
      if (job.heal && !options.heal) {
        fill_report(answer.record, report);
        messages.push_back(
            "healing may have renumbered faces: the list of faces is that of the healed shape");
        // Volumes are held against the shape as the file has it.
        out.report.cad_volume = listed.volume;
        out.report.cad_centroid = vector_of(listed.centroid);
        out.report.volume_error = out.report.volume / listed.volume - 1;
      }
      if (std::abs(out.report.volume_error) > kVolumeGoal)
        messages.push_back(
            fmt::format("warning: the volume is {:+.2f} % off the CAD volume; a smaller mesh size mends that",
                        100 * out.report.volume_error));
      if (out.report.quality.min_scaled_jacobian < kSliver)
        messages.push_back(fmt::format(
            "warning: the worst element is a sliver (scaled Jacobian {:.1g}); stresses near it mean little",
            out.report.quality.min_scaled_jacobian));
      out.report.messages.insert(out.report.messages.begin(), messages.begin(), messages.end());
      out.report.messages.insert(out.report.messages.begin(), report.messages.begin(), report.messages.end());
      out.report.size = answer.record.size;
      out.report.seconds = time.spent();
      out.cad = std::move(report);
      add_named_sets(out.cad.faces, out.mesh);
      return out;
    } catch (const TryFailed& e) {
      messages.push_back(fmt::format("meshing {} failed: {}", attempt.what, e.what()));
      // Each once: a shape that cuts through itself fails in every way alike.
      if (std::ranges::find(reasons, e.what()) == reasons.end()) reasons.emplace_back(e.what());
      ++k;
      if (k < attempts.size()) job.note = fmt::format(" {} ({})", attempts[k].what, messages.back());
    }
  }
  const bool crossed = std::ranges::any_of(reasons, [](const std::string& reason) {
    return reason.find("PLC Error") != std::string::npos || reason.find("intersect") != std::string::npos;
  });
  throw std::runtime_error(fmt::format(
      "{}: cannot be meshed at size {:.4g} mm{} ({}); {}", options.path.string(), 1e3 * size,
      crossed ? ": its faces cut through one another, or the mesh is too coarse for a thin place" : "",
      fmt::join(reasons, "; "),
      crossed ? "mend the shape in the CAD program, or choose a smaller mesh.size"
              : "another mesh size or a repaired CAD file may help"));
}

}  // namespace flexura::mesh
