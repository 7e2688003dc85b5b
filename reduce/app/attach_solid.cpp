// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/attach_solid.hpp"

#include <fmt/format.h>

#include "mbs/base/files/output.hpp"
#include "mbs/superelement/file.hpp"
#include "reduce/file/part_file.hpp"

namespace flexura::reduce {

AttachedSolid attach_solid(const SolidInput& solid, const std::filesystem::path& output,
                           const OutputOptions& options) {
  std::filesystem::path file = solid.superelement;
  if (file.empty()) {
    std::vector<std::string> overrides;
    if (solid.modes >= 0) overrides.push_back(fmt::format("modes.count={}", solid.modes));
    std::string stem = output.filename().string();
    if (const std::size_t dot = stem.find(".se.h5"); dot != std::string::npos) stem.erase(dot);
    file = output.parent_path() / fmt::format("{}.{}.se.h5", stem, solid.name);
    files::Claims claims;
    claims.add(file);
    reduce_to_file(read_part(solid.part, overrides), file, {.report = {}, .quiet = options.quiet});
  }
  superelement::Superelement se = superelement::read(file, {.surface = true, .shapes = true});

  AttachedSolid attached;
  attached.name = solid.name;
  Reduction& r = attached.reduction;
  int n_b = 0;
  for (const superelement::Interface& interface : se.interfaces) {
    if (interface.directions.size() != 6 || interface.first_dof != n_b)
      throw input::InputError(
          fmt::format("{}: interface \"{}\" of {} has {} directions; a beam needs all six, keep them in the "
                      "solid's part file",
                      solid.where, interface.name, file.string(), interface.directions.size()));
    r.interfaces.push_back({interface.name, Tie::rigid, interface.p_BoN_B, {0, 1, 2, 3, 4, 5}, n_b});
    n_b += 6;
  }
  if (n_b != se.n_b)
    throw input::InputError(
        fmt::format("{}: {} has {} boundary dofs, its interfaces {}; only superelements whose "
                    "boundary dofs are those of the interfaces can be joined to beams",
                    solid.where, file.string(), se.n_b, n_b));
  r.n_b = se.n_b;
  r.n_q = se.n_q;
  r.K_se = std::move(se.K_se);
  r.M_se = std::move(se.M_se);
  r.D_se = std::move(se.D_se);
  r.omega2 = std::move(se.omega2);
  r.inertia.mass = se.inertia.mass;
  r.inertia.S_x = se.inertia.S_x;
  r.inertia.S_xx = se.inertia.S_xx;
  r.inertia.S_phi = std::move(se.inertia.S_phi);
  r.inertia.S_xphi = std::move(se.inertia.S_xphi);
  r.inertia.S_phiphi = std::move(se.inertia.S_phiphi);
  r.shapes = std::move(se.shapes);
  if (r.shapes.rows() == 3 * se.surface.vertices.rows())  // a superelement may come without pictures
    attached.picture = {se.surface.vertices, se.surface.triangles, se.surface.edges};
  return attached;
}

}  // namespace flexura::reduce
