// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/assembly.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "import/cad/job.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/plain_text.hpp"
#include "mesh/gmsh/child.hpp"

namespace flexura::import::cad {
namespace {

namespace fs = std::filesystem;

Vector3d vector_of(const std::array<double, 3>& x) {
  return {x[0], x[1], x[2]};
}

Matrix3d matrix_of(const std::array<double, 9>& x) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x.data());
}

// The child may have written anything: every index is held against what there is.
class Unpacker {
 public:
  explicit Unpacker(const fs::path& file) : file_(file) {}

  Assembly unpack(const AssemblyAnswer& answer) const {
    Assembly assembly;
    for (const PartAnswer& part : answer.parts) assembly.parts.push_back(part_of(part));
    for (const InstanceAnswer& i : answer.instances) {
      require(i.part >= 0 && i.part < static_cast<int>(assembly.parts.size()));
      const Matrix3d R = matrix_of(i.R);
      require((R.transpose() * R - Matrix3d::Identity()).norm() < 1e-6);
      assembly.instances.push_back(
          {i.part, files::plain_text(i.name), files::plain_text(i.path), {R, vector_of(i.p)}});
    }
    for (const std::string& note : answer.notes) assembly.notes.push_back(files::plain_text(note));
    return assembly;
  }

 private:
  void require(bool holds) const {
    if (!holds)
      throw std::invalid_argument(file_.string() +
                                  ": was answered with nonsense by flexura-assembly: it is damaged; save it "
                                  "again in the CAD program");
  }

  Part part_of(const PartAnswer& from) const {
    Part part{.name = files::plain_text(from.name),
              .color = files::plain_text(from.color),
              .density = from.density,
              .solids = from.solids,
              .volume = from.volume};
    part.center = vector_of(from.center);
    part.moments = matrix_of(from.moments);
    part.brep = from.brep;
    require(part.volume > 0.0 && part.center.allFinite() && part.moments.allFinite() &&
            from.vertices.size() % 3 == 0);
    const auto n = static_cast<int>(from.vertices.size() / 3);
    for (int v = 0; v < n; ++v) {
      part.surface.vertices.emplace_back(from.vertices[3 * v], from.vertices[3 * v + 1],
                                         from.vertices[3 * v + 2]);
      require(part.surface.vertices.back().allFinite());
    }
    const auto inside = [&](std::int32_t i) { return i >= 0 && i < n; };
    for (std::size_t e = 0; e + 1 < from.edges.size(); e += 2) {
      require(inside(from.edges[e]) && inside(from.edges[e + 1]));
      part.surface.edges.emplace_back(from.edges[e], from.edges[e + 1]);
    }
    for (const FaceAnswer& f : from.faces) {
      Face face;
      face.shape.number = static_cast<mesh::Index>(part.faces.size() + 1);
      require(f.kind >= 0 && f.kind <= static_cast<int>(mesh::FaceKind::other));
      face.shape.kind = static_cast<mesh::FaceKind>(f.kind);
      face.shape.area = f.area;
      face.shape.radius = f.radius;
      face.shape.length = f.length;
      face.shape.hole = f.hole;
      face.shape.centroid = vector_of(f.centroid);
      face.shape.normal = vector_of(f.normal);
      face.shape.axis_point = vector_of(f.axis_point);
      face.shape.axis = vector_of(f.axis);
      face.is_turned = f.turned;
      face.lead = f.lead;
      require(std::isfinite(f.lead) && (!f.turned || std::abs(face.shape.axis.norm() - 1.0) < 1e-6));
      if (face.shape.kind == mesh::FaceKind::cylinder && f.radius > 0.0 && f.length > 0.0)
        face.shape.sweep = std::min(2.0 * std::numbers::pi, f.area / (f.radius * f.length));
      for (std::size_t t = 0; t + 2 < f.triangles.size(); t += 3) {
        require(inside(f.triangles[t]) && inside(f.triangles[t + 1]) && inside(f.triangles[t + 2]));
        face.triangles.emplace_back(f.triangles[t], f.triangles[t + 1], f.triangles[t + 2]);
        part.surface.triangles.push_back(face.triangles.back());
      }
      part.faces.push_back(std::move(face));
    }
    return part;
  }

  const fs::path& file_;
};

fs::path worker_program() {
  std::error_code failure;
  const fs::path worker = fs::read_symlink("/proc/self/exe", failure).parent_path() / "flexura-assembly";
  if (!fs::exists(worker))
    throw std::runtime_error("the program " + worker.string() +
                             " is missing; build it, or copy it beside flexura");
  return worker;
}

}  // namespace

Assembly read_assembly(const fs::path& file, double time_limit_s) {
  files::note_input(file);
  std::string head(64, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file))
    throw std::invalid_argument(file.string() + ": cannot be read; check the name");
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.find("ISO-10303-21") == std::string::npos)
    throw std::invalid_argument(
        file.string() +
        ": is no STEP file, which begins with ISO-10303-21; save it as STEP in the CAD program");
  const fs::path worker = worker_program();
  const AssemblyJob job{.path = fs::absolute(file).string(), .parent = getpid()};
  const mesh::ChildOutcome outcome = mesh::run_child(worker, nlohmann::json(job).dump(), time_limit_s, {});
  const std::string stage = outcome.stage.empty() ? "" : " while " + outcome.stage;
  if (outcome.end == mesh::ChildEnd::out_of_time)
    throw std::invalid_argument(
        fmt::format("{}: was not read within {:.3g} s{}; give it more by --time-limit", file.string(),
                    time_limit_s, stage));
  if (outcome.end == mesh::ChildEnd::crashed)
    throw std::invalid_argument(
        fmt::format("{}: made OpenCASCADE fail{}: it {}; save the file again in the CAD program",
                    file.string(), stage, outcome.reason));
  AssemblyAnswer answer;
  try {
    answer = nlohmann::json::from_cbor(outcome.result).get<AssemblyAnswer>();
  } catch (const nlohmann::json::exception&) {
    throw std::invalid_argument(
        file.string() +
        ": was answered incompletely by flexura-assembly: it is damaged; save it again in the CAD program");
  }
  if (!answer.error.empty())
    throw std::invalid_argument(fmt::format("{}: {}", file.string(), shown(answer.error)));
  return Unpacker(file).unpack(answer);
}

std::vector<Overlap> find_overlaps(const fs::path& file, const Assembly& assembly, double more_than,
                                   double time_limit_s) {
  const AssemblyJob job{.path = fs::absolute(file).string(), .parent = getpid(), .overlap = more_than};
  const mesh::ChildOutcome outcome =
      mesh::run_child(worker_program(), nlohmann::json(job).dump(), time_limit_s, {});
  if (outcome.end == mesh::ChildEnd::out_of_time)
    throw std::runtime_error(fmt::format(
        "parts that overlap were not found within {:.3g} s; give it more by --time-limit", time_limit_s));
  AssemblyAnswer answer;
  try {
    if (outcome.end != mesh::ChildEnd::crashed)
      answer = nlohmann::json::from_cbor(outcome.result).get<AssemblyAnswer>();
  } catch (const nlohmann::json::exception&) {
    answer.error = "incomplete";
  }
  if (outcome.end == mesh::ChildEnd::crashed || !answer.error.empty())
    throw std::runtime_error(
        "OpenCASCADE failed on the search for parts that overlap, so it is unknown whether there are any; "
        "save the file again in the CAD program");
  std::vector<Overlap> overlaps;
  const auto n = static_cast<int>(assembly.instances.size());
  for (const OverlapAnswer& o : answer.overlaps)
    if (o.a >= 0 && o.a < n && o.b >= 0 && o.b < n && std::isfinite(o.volume) && std::isfinite(o.thickness))
      overlaps.push_back({o.a, o.b, o.volume, o.thickness, vector_of(o.place)});
  return overlaps;
}

}  // namespace flexura::import::cad
