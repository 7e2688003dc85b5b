// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/joints/contact_text.hpp"

#include <fmt/format.h>

#include "import/cad/evidence.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {
namespace {

using mesh::FaceKind;

// A layer of steel of some 2 m would be as soft: what a run of rigid bodies takes without microseconds of steps.
constexpr double kStiffness = 1e11;  // Pa per m
constexpr double kDamping = 1.0;     // s/m

struct Side {
  int instance = 0;
  const Face* face = nullptr;
  const mesh::Face& shape() const { return face->shape; }
};

bool can_be_touched(const mesh::Face& f) {
  return f.kind == FaceKind::plane || f.kind == FaceKind::cylinder || f.kind == FaceKind::sphere;
}

// A plane before round faces, the larger of two planes: what touches it stays within it.
bool is_better(const mesh::Face& f, const mesh::Face& g) {
  if (!can_be_touched(f) || !can_be_touched(g)) return can_be_touched(f);
  const bool f_flat = f.kind == FaceKind::plane, g_flat = g.kind == FaceKind::plane;
  return f_flat != g_flat ? f_flat : f.area >= g.area;
}

std::string box_of(const Surface& surface, const Face& face) {
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  for (const Eigen::Vector3i& t : face.triangles)
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(surface.vertices[static_cast<std::size_t>(t[k])]);
      high = high.cwiseMax(surface.vertices[static_cast<std::size_t>(t[k])]);
    }
  const double slack = 1e-6 * (high - low).norm() + 1e-9;
  return fmt::format("[{}, {}]", toml(Vector3d(low.array() - slack)), toml(Vector3d(high.array() + slack)));
}

}  // namespace

ContactText contact_text(const Assembly& assembly, const std::vector<std::string>& names,
                         const ContactCandidate& candidate, const std::string& name) {
  const auto part_of = [&](int i) -> const Part& {
    return assembly.parts[static_cast<std::size_t>(assembly.instances[static_cast<std::size_t>(i)].part)];
  };
  const auto side = [&](int i, int number) {
    return Side{i, &part_of(i).faces[static_cast<std::size_t>(number - 1)]};
  };
  const auto body = [&](const Side& s) { return names[static_cast<std::size_t>(s.instance)]; };
  Side touched = side(candidate.a, candidate.face_a), touching = side(candidate.b, candidate.face_b);
  if (!is_better(touched.shape(), touching.shape())) std::swap(touched, touching);
  ContactText text;
  text.says =
      fmt::format("{} and {}: {} apart at {} (faces {} and {})", names[static_cast<std::size_t>(candidate.a)],
                  names[static_cast<std::size_t>(candidate.b)], mm(candidate.distance),
                  mesh::describe_point_mm(candidate.place), candidate.face_a, candidate.face_b);
  const mesh::Face& f = touched.shape();
  if (!can_be_touched(f)) return text;
  const bool flat = f.kind == FaceKind::plane;
  const Pose X_BF{mbs::frame_along(flat                           ? f.normal
                                   : f.kind == FaceKind::cylinder ? f.axis
                                                                  : Vector3d(Vector3d::UnitZ())),
                  flat ? f.centroid : f.axis_point};
  std::string& out = text.lines;
  out += fmt::format("[body.{}.marker.{}]\n", body(touched), name);
  for (const auto& [key, value] : pose_lines(X_BF)) out += key + " = " + value + "\n";
  out += fmt::format(
      "\n[force.{}]\ntype = \"surface_contact\"\nbody = {}\nbox = {}\nfrom = {}\nsurface = \"{}\"\n", name,
      toml(body(touching)), box_of(part_of(touching.instance).surface, *touching.face),
      toml(body(touched) + "." + name), mesh::name_of(f.kind));
  if (!flat) out += fmt::format("surface_radius = {}\n", toml(f.radius));
  if (f.hole) out += "inside = true\n";
  out += fmt::format("stiffness = {}\ndamping = {}\n", toml(kStiffness), toml(kDamping));
  return text;
}

}  // namespace flexura::import::cad
