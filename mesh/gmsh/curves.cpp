// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/curves.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/cad_file.hpp"
#include "mesh/gmsh/msh_file.hpp"

namespace flexura::mesh {
namespace {

/// Number of each point among those that lie apart.
std::vector<int> merge(const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points,
                       double tolerance, std::vector<int>& kept) {
  // What coincides has nearly the same height along any direction; along an oblique one little else has.
  const Eigen::RowVector3d oblique = Eigen::RowVector3d(0.53, 0.61, 0.59).normalized();
  std::multimap<double, int> by_height;
  std::vector<int> number(points.rows(), -1);
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    const double height = oblique.dot(points.row(k));
    for (auto it = by_height.lower_bound(height - tolerance);
         it != by_height.end() && it->first <= height + tolerance; ++it)
      if ((points.row(kept[it->second]) - points.row(k)).norm() <= tolerance) number[k] = it->second;
    if (number[k] >= 0) continue;
    number[k] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(k));
    by_height.insert({height, number[k]});
  }
  return number;
}

void inspect_script(const CurveOptions& options) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(options.path, none) || !std::ifstream(options.path))
    throw std::invalid_argument(options.path.string() + ": cannot be opened as a file");
  if (!options.run_scripts)
    throw std::invalid_argument(
        options.path.string() +
        ": is a script, which gmsh runs: look through it and give --run-scripts, or save its curves as "
        ".msh or STEP");
}

}  // namespace

CurveSet read_curves(const CurveOptions& options) {
  const std::string name = options.path.string();
  Job job;
  job.task = "curves";
  job.parent = getpid();
  job.path = std::filesystem::absolute(options.path).string();
  job.turn = options.turn;
  std::string extension = options.path.extension().string();
  if (extension == ".msh" || extension == ".geo" || extension == ".geo_unrolled") {
    job.format = extension == ".msh" ? "msh" : "geo";
    if (job.format == "msh") inspect_msh_file(options.path);
    if (job.format == "geo") inspect_script(options);
    job.to_m = metres_in(options.unit.empty() ? "m" : options.unit);
  } else {
    const CadFile file = inspect_cad_file(options.path);
    job.format = file.format;
    if (!options.unit.empty())  // OpenCASCADE converts from the declared unit to mm; BREP declares none
      job.to_m = file.format == "brep"
                     ? metres_in(options.unit)
                     : 1e-3 * metres_in(options.unit) / metres_in(file.unit.empty() ? "mm" : file.unit);
  }
  Answer answer;
  try {
    answer = ask_worker(options.worker, job, options.time_limit_s, {});
  } catch (const TryFailed& error) {
    throw std::invalid_argument(name + ": " + error.what());
  }
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>> points(
      answer.arrays.points.data(), static_cast<Eigen::Index>(answer.record.n_points), 3);
  const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  std::vector<int> kept;
  const std::vector<int> number = merge(points, 1e-6 * size, kept);
  CurveSet set;
  set.points = points(kept, Eigen::all);
  const std::vector<std::int64_t>& integers =
      answer.arrays.integers;  // two points and the curve of each piece
  const std::size_t n = 3 * answer.record.blocks.at(0).n;
  for (std::size_t k = 0; k < n; k += 3) {
    const CurvePiece piece{number[integers[k]], number[integers[k + 1]], static_cast<int>(integers[k + 2])};
    if (piece.first != piece.second) set.pieces.push_back(piece);
  }
  std::size_t at = n;  // then the curves of each group
  for (const GroupRecord& record : answer.record.groups) {
    CurveGroup group{record.name, {}};
    for (std::uint64_t k = 0; k < record.n; ++k) group.curves.push_back(static_cast<int>(integers[at++]));
    set.groups.push_back(std::move(group));
  }
  return set;
}

}  // namespace flexura::mesh
