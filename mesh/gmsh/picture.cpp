// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/cad_file.hpp"
#include "mesh/gmsh/cad_job.hpp"

namespace flexura::mesh {

FacesPicture draw_faces(const CadOptions& options, const Progress& progress) {
  const std::string name = options.path.string();
  const CadFile file = inspect_cad_file(options.path);
  CadReport report;
  Job job = first_job(options, file, report);
  job.task = "picture";
  Answer answer;
  try {
    answer = ask_worker(options.worker, job, options.time_limit_s, progress);
  } catch (const PartRefused& e) {
    throw std::invalid_argument(name + ": " + e.what());
  } catch (const TryFailed& e) {
    throw std::runtime_error(name + ": its faces are not drawn: it " + e.what());
  }
  const Arrays& arrays = answer.arrays;
  FacesPicture picture;
  for (std::size_t k = 0; k + 2 < arrays.points.size(); k += 3)
    picture.vertices.emplace_back(arrays.points[k], arrays.points[k + 1], arrays.points[k + 2]);
  for (std::size_t k = 0; k < arrays.face.size(); ++k) {
    picture.triangles.emplace_back(arrays.triangles[3 * k], arrays.triangles[3 * k + 1],
                                   arrays.triangles[3 * k + 2]);
    picture.face.push_back(arrays.face[k]);
  }
  const auto inside = [&](std::int64_t v) {
    return v >= 0 && v < static_cast<std::int64_t>(picture.vertices.size());
  };
  for (std::size_t k = 0; k + 1 < arrays.integers.size(); k += 2)
    if (inside(arrays.integers[k]) && inside(arrays.integers[k + 1]))
      picture.edges.emplace_back(static_cast<int>(arrays.integers[k]),
                                 static_cast<int>(arrays.integers[k + 1]));
  if (picture.triangles.empty())
    throw std::runtime_error(
        name + ": gmsh makes no triangles of its faces; --list-faces without --html lists them");
  return picture;
}

}  // namespace flexura::mesh
