// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/mesh_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/msh_file.hpp"
#include "mesh/model/cells/record.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/patches.hpp"

namespace flexura::mesh {
MeshFile read_mesh_file(const std::filesystem::path& path, const std::filesystem::path& worker,
                        double time_limit_s, MeshFileCells cells) {
  inspect_msh_file(path);
  Job job;
  job.task = cells == MeshFileCells::shells ? "read shells" : "read";
  job.path = std::filesystem::absolute(path).string();
  job.parent = getpid();
  Answer answer;
  try {
    answer = ask_worker(worker, job, time_limit_s, {});
  } catch (const PartRefused& e) {
    throw std::invalid_argument(path.string() + ": " + e.what());
  } catch (const WorkerCrashed& e) {
    throw std::invalid_argument(path.string() + ": is not read: it " + e.what() +
                                "; the file is damaged, write it again");
  } catch (const TryFailed& e) {
    throw std::runtime_error(path.string() + ": reading the mesh failed: it " + e.what());
  }

  MeshFile out;
  out.messages = answer.record.messages;
  Mesh& mesh = out.mesh;
  mesh.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      answer.arrays.points.data(), static_cast<Eigen::Index>(answer.record.n_points), 3);
  const std::vector<std::int64_t>& integers = answer.arrays.integers;
  std::size_t at = 0;
  const auto take = [&](std::uint64_t n) {
    if (integers.size() - at < n)
      throw std::runtime_error(path.string() + ": reading the mesh gave an incomplete result");
    at += n;
    return integers.begin() + static_cast<std::ptrdiff_t>(at - n);
  };
  auto from = take(answer.record.n_points);
  mesh.node_label.assign(from, from + static_cast<std::ptrdiff_t>(answer.record.n_points));
  const auto incomplete = [&] {
    return std::runtime_error(path.string() + ": reading the mesh gave an incomplete result");
  };
  const auto is_node = [&](std::int64_t k) {
    return k >= 0 && static_cast<std::uint64_t>(k) < answer.record.n_points;
  };
  for (const BlockRecord& record : answer.record.blocks) {
    const auto known = std::ranges::find_if(cell_records(), [&](const CellRecord& cell) {
      return static_cast<int>(cell.type) == record.type && cell.dimension > 1;
    });
    if (known == cell_records().end()) throw incomplete();
    CellBlock block;
    block.type = known->type;
    from = take(record.n);
    block.label.assign(from, from + static_cast<std::ptrdiff_t>(record.n));
    const auto n = static_cast<Eigen::Index>(nodes_per_cell(block.type));
    block.nodes.resize(static_cast<Eigen::Index>(record.n), n);
    from = take(record.n * static_cast<std::uint64_t>(n));
    if (!std::all_of(from, from + block.nodes.size(), is_node)) throw incomplete();
    std::transform(from, from + block.nodes.size(), block.nodes.data(),
                   [](std::int64_t k) { return static_cast<Index>(k); });
    (dimension_of(block.type) == 2 ? mesh.shells : mesh.solids).push_back(std::move(block));
  }
  for (const GroupRecord& group : answer.record.groups) {
    from = take(group.n);
    if (!std::all_of(from, from + static_cast<std::ptrdiff_t>(group.n), is_node)) throw incomplete();
    NodeSet set;
    set.nodes.assign(from, from + static_cast<std::ptrdiff_t>(group.n));
    std::sort(set.nodes.begin(), set.nodes.end());
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
    if (!set.nodes.empty()) mesh.sets[group.name] = std::move(set);
  }
  if (const Quality quality = measure_quality(mesh); quality.n_inverted > 0)
    throw std::invalid_argument(
        fmt::format("{}: {} of {} cells are turned inside out (det J <= 0 at an integration point)",
                    path.string(), quality.n_inverted, quality.n_cells));
  extract_boundary(mesh);
  attach_faces_to_sets(mesh);
  return out;
}

}  // namespace flexura::mesh
