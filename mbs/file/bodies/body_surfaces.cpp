// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/body_surfaces.hpp"

#include <fmt/format.h>

#include "mbs/kinematics/smoothed_surface.hpp"

namespace flexura::mbs {

using input::Section;

std::shared_ptr<const SurfacePatch> touching_surface(ReadModel& model, const std::string& prefix,
                                                     const Section& s, int body) {
  const auto se = model.with_surface.find(body);
  if (se == model.with_surface.end())
    s.refuse(
        "body", fmt::format("\"{}\" has no superelement, whose surface has nodes", s.text("body")),
        "make the body of one (fidelity = \"rigid\" will do), or let markers touch (type = \"contact\")");
  PatchOfSurface part = read_surface_patch(s, *se->second, model.deforms(body));
  model.notes.push_back(fmt::format("{}: {} nodes of the surface of \"{}\" may touch, {:.4g} mm^2 in all",
                                    s.path(), part.vertices.size(), s.text("body"),
                                    1e6 * part.patch->total_area()));
  model.blind_spots.push_back({"surface_contact", prefix + s.path().substr(s.path().find('.') + 1),
                               "runs with a finer mesh and with a higher stiffness tell"});
  const std::shared_ptr<const SurfacePatch> patch = part.patch;
  model.patches.emplace(body, std::move(part));
  return patch;
}

std::shared_ptr<const TouchedSurface> touched_surface(ReadModel& model, const Section& s,
                                                      const SurfaceKeys& keys, int body) {
  const auto se = model.with_surface.find(body);
  if (se == model.with_surface.end())
    s.refuse(
        keys.body, fmt::format("\"{}\" has no superelement, whose surface has facets", s.text(keys.body)),
        "make the body of one (fidelity = \"rigid\" will do), or let a plane, sphere or cylinder at a marker "
        "of it be touched (from)");
  PatchOfSurface part = read_touched_surface(s, *se->second, model.deforms(body), keys);
  const auto smoothed = std::make_shared<SmoothedSurface>(part.mesh);
  if (const auto [one, other] = smoothed->opposed(); one >= 0) {
    const Vector3d at = part.mesh->vertex(part.mesh->triangle(one)[0], nullptr);
    s.refuse(
        keys.body,
        fmt::format(
            "its facets near [{:.4g}, {:.4g}, {:.4g}] m look into opposite directions, nearer to each "
            "other than they are long",
            at.x(), at.y(), at.z()),
        fmt::format("choose the side that is touched by {0}facing, {0}interfaces or {0}box, or reduce the "
                    "part with a finer mesh",
                    keys.prefix));
  }
  model.notes.push_back(
      fmt::format("{}: {} facets of the surface of \"{}\" may be touched, {:.4g} mm^2 in all", s.path(),
                  part.mesh->n_triangles(), s.text(keys.body), 1e6 * part.area.sum()));
  model.patches.emplace(body, std::move(part));
  return smoothed;
}

std::shared_ptr<const SurfaceMesh> measured_surface(ReadModel& model, const Section& s,
                                                    const std::string& key, int body) {
  const auto known = model.with_surface.find(body);
  if (known == model.with_surface.end())
    s.refuse(key, fmt::format("\"{}\" has no superelement, whose surface it is", s.text(key)),
             "make the body of one (fidelity = \"rigid\" will do), or measure the distance of two markers");
  const superelement::Superelement& se = *known->second;
  const auto n = se.surface.vertices.rows();
  if (n == 0 || se.surface.triangles.rows() == 0 || (model.deforms(body) && se.shapes.rows() != 3 * n))
    s.refuse(key, "its superelement has no surface with shapes on it",
             "reduce the part from its CAD file or mesh (foreign matrices bring none)");
  auto mesh = std::make_shared<SurfaceMesh>(se.surface.vertices.transpose().cast<double>(),
                                            se.surface.triangles.transpose().cast<int>());
  model.meshes.emplace(body, mesh);
  return mesh;
}

}  // namespace flexura::mbs
