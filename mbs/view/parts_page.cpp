// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/parts_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/view/html/page_file.hpp"

namespace flexura::view {
namespace {

using nlohmann::json;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument(what);
}

json point_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

// Row by row.
json rotation_json(const Eigen::Matrix3d& R) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rows.push_back(R(r, c));
  return rows;
}

void check(const DrawnPart& part) {
  const auto n = static_cast<int>(part.vertices.size());
  require(!part.triangles.empty(), fmt::format("part \"{}\" has no surface to draw", part.name));
  require(part.face.size() == part.triangles.size(),
          fmt::format("part \"{}\" has {} triangles and {} numbers of faces", part.name,
                      part.triangles.size(), part.face.size()));
  for (const Eigen::Vector3d& v : part.vertices)
    require(v.allFinite(), fmt::format("part \"{}\" has a vertex that is not finite", part.name));
  const auto inside = [&](int v) { return v >= 0 && v < n; };
  for (const Eigen::Vector3i& t : part.triangles)
    require(inside(t[0]) && inside(t[1]) && inside(t[2]),
            fmt::format("part \"{}\" has a triangle of vertices that it does not have", part.name));
  for (const auto& [p, q] : part.edges)
    require(inside(p) && inside(q),
            fmt::format("part \"{}\" has an edge of vertices that it does not have", part.name));
  for (const std::int32_t f : part.face)
    require(f >= 0 && f < static_cast<int>(part.faces.size()),
            fmt::format("part \"{}\" has a triangle on a face that it does not have", part.name));
  for (std::size_t i = 1; i < part.faces.size(); ++i)
    require(part.faces[i].number > part.faces[i - 1].number,
            fmt::format("part \"{}\" lists its faces out of order", part.name));
}

void check(const PartsPage& page) {
  require(!page.bodies.empty(), "there is no body to draw");
  for (const DrawnPart& part : page.parts) check(part);
  const auto n = static_cast<int>(page.bodies.size());
  const auto has_face = [&](int body, int face) {
    const auto part = static_cast<std::size_t>(page.bodies[static_cast<std::size_t>(body)].part);
    return std::ranges::find(page.parts[part].faces, face, &NumberedFace::number) !=
           page.parts[part].faces.end();
  };
  for (const PlacedBody& body : page.bodies) {
    require(body.part >= 0 && body.part < static_cast<int>(page.parts.size()),
            fmt::format("body \"{}\" is of a part that is not there", body.name));
    require(body.R_WB.allFinite() && body.p_WB.allFinite(),
            fmt::format("body \"{}\" has a pose that is not finite", body.name));
  }
  require(page.ground < n, "the body on the ground is not there");
  for (const OverlappingPair& o : page.overlaps)
    require(o.a >= 0 && o.a < n && o.b >= 0 && o.b < n && o.place.allFinite(),
            "an overlap is of a body that is not there");
  for (const ContactCandidate& c : page.contacts)
    require(c.a >= 0 && c.a < n && c.b >= 0 && c.b < n && c.place.allFinite(),
            "a contact is of a body that is not there");
  for (const ProposedJoint& j : page.joints) {
    require(j.a >= 0 && j.a < n && j.b >= 0 && j.b < n,
            fmt::format("joint \"{}\" is of a body that is not there", j.name));
    for (const auto& [body, face] : j.faces)
      require(body >= 0 && body < n && has_face(body, face),
              fmt::format("joint \"{}\" is on a face that is not there", j.name));
    require((j.on[0] == 0 || has_face(j.a, j.on[0])) && (j.on[1] == 0 || has_face(j.b, j.on[1])),
            fmt::format("joint \"{}\" is on a face that is not there", j.name));
    require(j.R_WJ.allFinite() && j.p_WJ.allFinite(),
            fmt::format("joint \"{}\" has a frame that is not finite", j.name));
  }
}

json part_json(PageFile& file, const DrawnPart& part, const std::string& key) {
  std::vector<float> vertices;
  for (const Eigen::Vector3d& v : part.vertices)
    for (const double x : v) vertices.push_back(static_cast<float>(x));
  std::vector<std::int32_t> triangles, edges;
  for (const Eigen::Vector3i& t : part.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const auto& [p, q] : part.edges) {
    edges.push_back(p);
    edges.push_back(q);
  }
  file.add<float>(key + "/vertices", vertices);
  file.add<std::int32_t>(key + "/triangles", triangles);
  file.add<std::int32_t>(key + "/face", part.face);
  file.add<std::int32_t>(key + "/edges", edges);
  json faces = json::array();
  for (const NumberedFace& f : part.faces)
    faces.push_back({{"number", f.number},
                     {"text", f.text},
                     {"kind", f.kind},
                     {"point", point_json(f.point)},
                     {"axis", f.axis.isZero(0.0) ? json() : point_json(f.axis)},
                     {"lines", f.lines}});
  return {{"key", key}, {"name", part.name}, {"file", part.file}, {"color", part.color}, {"faces", faces}};
}

}  // namespace

void write_parts_page(const std::filesystem::path& html, const PartsPage& page) {
  check(page);
  PageFile file(html, page.title + (page.ground < 0 ? " · faces" : " · assembly"));
  json parts = json::array(), bodies = json::array(), joints = json::array();
  for (std::size_t i = 0; i < page.parts.size(); ++i)
    parts.push_back(part_json(file, page.parts[i], fmt::format("part{}", i)));
  for (const PlacedBody& b : page.bodies)
    bodies.push_back({{"name", b.name},
                      {"part", b.part},
                      {"text", b.text},
                      {"position", point_json(b.p_WB)},
                      {"rotation", rotation_json(b.R_WB)}});
  for (const ProposedJoint& j : page.joints)
    joints.push_back({{"name", j.name},
                      {"type", j.type},
                      {"lead", j.lead},
                      {"a", j.a},
                      {"b", j.b},
                      {"position", point_json(j.p_WJ)},
                      {"rotation", rotation_json(j.R_WJ)},
                      {"confidence", j.confidence},
                      {"doubt", j.doubt},
                      {"evidence", j.evidence},
                      {"faces", j.faces},
                      {"on", j.on}});
  json overlaps = json::array();
  for (const OverlappingPair& o : page.overlaps)
    overlaps.push_back({{"a", o.a}, {"b", o.b}, {"place", point_json(o.place)}, {"text", o.text}});
  json contacts = json::array();
  for (const ContactCandidate& c : page.contacts)
    contacts.push_back(
        {{"a", c.a}, {"b", c.b}, {"place", point_json(c.place)}, {"text", c.text}, {"lines", c.lines}});
  file.finish({{"format", 1},
               {"page", "parts"},
               {"title", page.title},
               {"created_by", page.created_by},
               {"parts", parts},
               {"bodies", bodies},
               {"ground", page.ground},
               {"joints", joints},
               {"doubts", page.doubts},
               {"overlaps", overlaps},
               {"contacts", contacts},
               {"head", page.head}});
}

}  // namespace flexura::view
