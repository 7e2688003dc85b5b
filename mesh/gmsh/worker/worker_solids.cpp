// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>

#include "mesh/gmsh/worker/worker_describe.hpp"

namespace flexura::mesh {
namespace {

double length_of(int curve, double to_m) {
  double length = 0;
  gmsh::model::occ::getMass(1, curve, length);
  return length * to_m;
}

std::string point_mm(const std::vector<double>& x, double to_m) {
  const double scale = 1e3 * to_m;
  std::string text = "(";
  for (int k = 0; k < 3; ++k) {
    char number[32];
    std::snprintf(number, sizeof number, "%.5g", std::abs(scale * x[k]) < 1e-9 ? 0.0 : scale * x[k]);
    text += (k > 0 ? ", " : "") + std::string(number);
  }
  return text + ")";
}

/// Edges that only one of the faces has, in words: how many, how long together, where the longest are; empty where
/// the faces close.  A seam is twice on its own face, a pole has no length.
std::string describe_free_edges(const gmsh::vectorpair& faces, double to_m) {
  gmsh::model::occ::synchronize();
  std::map<int, int> uses;
  for (const auto& face : faces) {
    gmsh::vectorpair curves;
    gmsh::model::getBoundary({face}, curves, false, false, false);
    for (const auto& curve : curves) ++uses[std::abs(curve.second)];
  }
  std::vector<std::pair<double, int>> open;
  double total = 0;
  for (const auto& [curve, count] : uses)
    if (count == 1)
      if (const double length = length_of(curve, to_m); length > 1e-9) {
        open.emplace_back(length, curve);
        total += length;
      }
  if (open.empty()) return "";
  std::sort(open.rbegin(), open.rend());
  char head[160];
  std::snprintf(head, sizeof head, "%zu of its %zu edges belong to one face only, %.5g mm together",
                open.size(), uses.size(), 1e3 * total);
  std::string text = head;
  for (std::size_t k = 0; k < std::min<std::size_t>(2, open.size()); ++k) {
    std::vector<double> low, high, from, to;
    gmsh::model::getParametrizationBounds(1, open[k].second, low, high);
    gmsh::model::getValue(1, open[k].second, low, from);
    gmsh::model::getValue(1, open[k].second, high, to);
    char length[64];
    std::snprintf(length, sizeof length, ", %.5g mm", 1e3 * open[k].first);
    text += (k == 0 ? ": " : "; ") + point_mm(from, to_m) + " to " + point_mm(to, to_m) + length;
  }
  return text + (open.size() > 2 ? "; ..." : "");
}

[[noreturn]] void refuse_open(const std::string& free_edges) {
  throw std::runtime_error(
      "is not closed, so that it has no inside: " + free_edges +
      " (coordinates in mm); stitch it in the CAD program and export a solid body; of sheet metal give the "
      "thickness in a table [shell]");  // longer ones are cut where the edges stand
}

/// Takes `old` shapes away that healing made `kept` ones of: they would stay beside them and be meshed as well.
void remove_but(const gmsh::vectorpair& old, const gmsh::vectorpair& kept) {
  gmsh::vectorpair gone;
  for (const auto& entity : old)
    if (std::find(kept.begin(), kept.end(), entity) == kept.end()) gone.push_back(entity);
  if (!gone.empty()) gmsh::model::occ::remove(gone, true);
}

/// Closes a file of faces.  What is not closed is refused with the places of its free edges.
void sew(const Job& job, gmsh::vectorpair& imported, gmsh::vectorpair& solids, ResultRecord& result) {
  gmsh::vectorpair faces;
  for (const auto& entity : imported)
    if (entity.first == 2) faces.push_back(entity);
  if (faces.empty()) {
    std::size_t curves = 0;
    for (const auto& entity : imported) curves += entity.first == 1;
    throw std::runtime_error(
        "holds no faces, only " + std::to_string(curves) + " curve" + (curves == 1 ? "" : "s") +
        ", and encloses nothing; export a solid body (curves make beams: [curves] in a beam part file)");
  }
  const double tolerance = 1e-3;  // mm, of gaps between edges
  gmsh::vectorpair healed;
  std::string trouble;
  try {
    gmsh::model::occ::healShapes(healed, imported, tolerance, true, true, true, true, true);
  } catch (const std::string& error) {
    trouble = error;
  }
  if (trouble.empty()) {
    remove_but(imported, healed);
    imported = healed;
  }
  faces.clear();
  solids.clear();
  for (const auto& entity : imported) {
    if (entity.first == 3) solids.push_back(entity);
    if (entity.first == 2) faces.push_back(entity);
  }
  for (const auto& solid : solids) {
    gmsh::model::occ::synchronize();
    gmsh::vectorpair of_solid;
    gmsh::model::getBoundary({solid}, of_solid, false, false, false);
    faces.insert(faces.end(), of_solid.begin(), of_solid.end());
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  if (const std::string open = describe_free_edges(faces, job.to_m); !open.empty()) refuse_open(open);
  if (solids.empty()) {  // faces in a shell, or loose: close them by hand
    std::vector<int> tags;
    for (const auto& face : faces) tags.push_back(face.second);
    try {
      const int shell = gmsh::model::occ::addSurfaceLoop(tags, -1, true);
      solids.emplace_back(3, gmsh::model::occ::addVolume({shell}));
    } catch (const std::string& error) {
      throw std::runtime_error("holds " + std::to_string(tags.size()) + " faces that make no closed shell (" +
                               error + "); export a solid body from the CAD program");
    }
  }
  double volume = 0;
  for (const auto& solid : solids) {
    double own = 0;
    gmsh::model::occ::getMass(3, solid.second, own);
    volume += own * std::pow(job.to_m, 3);
  }
  char text[160];
  if (!(volume > 0)) {
    std::snprintf(text, sizeof text, "%zu faces close a volume of %.5g mm3, which is none", faces.size(),
                  1e9 * volume);
    throw std::runtime_error(
        std::string("is no solid: its ") + text +
        ": faces that lie on one another, or turned inside out; export a solid body from the CAD program");
  }
  std::snprintf(text, sizeof text,
                "the file holds faces only; healed: %zu faces were sewn to a solid of %.6g mm3 (gaps up to "
                "%g mm were closed)",
                faces.size(), 1e9 * volume, tolerance);
  result.messages.push_back(text);
}

}  // namespace

gmsh::vectorpair import_solids(const Job& job, ResultRecord& result) {
  gmsh::vectorpair imported, solids;
  gmsh::model::occ::importShapes(job.path, imported, true, job.format);
  for (const auto& entity : imported)
    if (entity.first == 3) solids.push_back(entity);
  if (solids.empty() && !imported.empty()) sew(job, imported, solids, result);
  if (solids.empty()) throw std::runtime_error("holds no solid; export a solid body from the CAD program");
  for (const auto& solid : solids) {
    double own = 0;
    gmsh::model::occ::getMass(3, solid.second, own);
    if (own > 0) continue;
    gmsh::model::occ::synchronize();
    gmsh::vectorpair faces;
    gmsh::model::getBoundary({solid}, faces, false, false, false);
    if (const std::string open = describe_free_edges(faces, job.to_m); !open.empty()) refuse_open(open);
    char text[120];
    std::snprintf(text, sizeof text, "its solid %d has the volume %.5g mm3", solid.second,
                  1e9 * own * std::pow(job.to_m, 3));
    throw std::runtime_error(
        std::string("is no sound solid: ") + text +
        "; its faces are turned inside out or lie on one another: mend it in the CAD program");
  }
  return solids;
}

void choose_solids(const Job& job, ResultRecord& result, gmsh::vectorpair& solids) {
  for (const auto& [dimension, tag] : solids) result.solids.push_back(describe_solid(tag, job.to_m));
  for (std::size_t i = 0; i < result.solids.size(); ++i)
    for (std::size_t j = 0; j < i && result.solids[i].same_as == 0; ++j)
      if (result.solids[j].same_as == 0 && coincide(result.solids[i], result.solids[j]))
        result.solids[i].same_as = result.solids[j].number;
  gmsh::vectorpair kept, gone;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const SolidRecord& solid = result.solids[k];
    const bool wanted = job.solids.empty() ? solid.same_as == 0
                                           : std::find(job.solids.begin(), job.solids.end(), solid.number) !=
                                                 job.solids.end();
    (wanted ? kept : gone).push_back(solids[k]);
    if (wanted) result.kept.push_back(solid.number);
  }
  if (!gone.empty()) gmsh::model::occ::remove(gone, true);
  if (kept.empty())
    throw std::runtime_error("has none of the chosen solids; choose from those that --list-faces prints");
  solids = kept;
}

void fuse_solids(ResultRecord& result, gmsh::vectorpair& solids) {
  if (solids.size() < 2) return;
  gmsh::vectorpair fused;
  std::vector<gmsh::vectorpair> map;
  gmsh::model::occ::fuse({solids.front()}, {solids.begin() + 1, solids.end()}, fused, map);
  solids.clear();
  for (const auto& entity : fused)
    if (entity.first == 3) solids.push_back(entity);
  if (solids.size() != 1)
    throw std::runtime_error("its solids do not fuse to one: " + std::to_string(solids.size()) +
                             " pieces are left that share no face; choose one solid, or solids that touch");
  result.messages.push_back(std::to_string(result.kept.size()) + " solids were fused to one");
}

void heal_solids(ResultRecord& result, gmsh::vectorpair& solids) {
  const auto volume_of = [&] {
    double sum = 0;
    for (const auto& solid : solids) {
      double own = 0;
      gmsh::model::occ::getMass(3, solid.second, own);
      sum += own;
    }
    return sum;
  };
  const double before = volume_of();
  gmsh::vectorpair healed;
  gmsh::model::occ::healShapes(healed, solids, 1e-5, true, true, true, false, true);
  remove_but(solids, healed);
  solids.clear();
  for (const auto& entity : healed)
    if (entity.first == 3) solids.push_back(entity);
  if (solids.empty()) throw std::runtime_error("is no solid any more after healing");
  char text[120];
  std::snprintf(text, sizeof text, "the shape was healed; its volume changed by %+.2g %%",
                100 * (volume_of() / before - 1));
  result.messages.push_back(text);
}

void describe_kept(const Job& job, const gmsh::vectorpair& solids, ResultRecord& result) {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  std::set<int> seen;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const SolidRecord solid = describe_solid(solids[s].second, job.to_m);
    result.volume += solid.volume;
    moment += solid.volume * Eigen::Vector3d(solid.centroid[0], solid.centroid[1], solid.centroid[2]);
    gmsh::vectorpair faces;
    gmsh::model::getBoundary({solids[s]}, faces, false, false, false);
    for (const auto& face : faces) {
      if (!seen.insert(std::abs(face.second)).second) continue;
      // Fusing gives the solid a number of its own: it stands for the first that went into it.
      const int number = job.fuse ? result.kept.front() : result.kept.at(std::min(s, result.kept.size() - 1));
      result.faces.push_back(describe_face(std::abs(face.second), number, job.to_m));
      result.area += result.faces.back().area;
    }
  }
  result.centroid = as_array(result.volume != 0 ? Eigen::Vector3d(moment / result.volume) : moment);
  for (SolidRecord& solid : result.solids)
    if (std::find(result.kept.begin(), result.kept.end(), solid.number) != result.kept.end() && !job.fuse)
      solid.name = label_of(3, solid.number);
}

}  // namespace flexura::mesh
