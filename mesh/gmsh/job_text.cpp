// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/job_text.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/base/files/json_text.hpp"

namespace flexura::mesh {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Job, task, path, format, to_m, solids, fuse, heal, order, size, size_min,
                                   sizes, elements_per_circle, most_triangles, most_tetrahedra,
                                   surface_algorithm, turn, note, parent, regions)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SolidRecord, number, same_as, name, volume, centroid, inertia, box)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(BlockRecord, type, n)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GroupRecord, name, n)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FaceRecord, number, solid, kind, name, area, radius, length, sweep, hole,
                                   centroid, normal, axis_point, axis, box)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ResultRecord, error, solids, kept, volume, area, outline, centroid, faces,
                                   messages, size, size_min, elements_per_circle, graded, n_points,
                                   n_tetrahedra, n_triangles, n_integers, blocks, groups)

std::string text_of(const Job& job) {
  return nlohmann::json(job).dump();
}
std::string text_of(const ResultRecord& result) {
  return nlohmann::json(result).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

namespace {

template <class T>
T read(const std::string& text, void (*prepare)(nlohmann::json&)) {
  try {
    auto value = nlohmann::json::parse(text);
    prepare(value);
    return value.get<T>();
  } catch (const nlohmann::json::exception& e) {
    throw std::invalid_argument(e.what());
  }
}

}  // namespace

Job read_job(const std::string& text) {
  return read<Job>(text, [](nlohmann::json&) {});
}
ResultRecord read_result(const std::string& text) {
  return read<ResultRecord>(text, files::make_plain<nlohmann::json>);  // names of the file
}

}  // namespace flexura::mesh
