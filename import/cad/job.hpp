// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// What flexura-import and its child flexura-assembly say to each other: a job as JSON on descriptor 0, the
/// answer as CBOR on descriptor 3, progress on 4 (mesh/gmsh/job.hpp, whose descriptors these are). Lengths of the answer are m.
namespace flexura::import::cad {

struct AssemblyJob {
  std::string path;
  int parent = 0;             ///< process id; the child ends when it is gone
  double deflection = 0.002;  ///< of the pictures' triangles, part of the part's size
  double overlap = 0.0;       ///< [m]; not 0: nothing but where parts overlap by more is answered
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AssemblyJob, path, parent, deflection, overlap)

struct FaceAnswer {
  int kind = 4;  ///< of mesh::FaceKind
  double area = 0, radius = 0, length = 0;
  bool turned = false;  ///< kind other, and a surface that slips along itself about an axis (slippage.hpp)
  double lead = 0;      ///< then of the screw, 0: a rotation
  bool hole = false;
  std::array<double, 3> centroid{}, normal{}, axis_point{}, axis{};
  std::vector<std::int32_t> triangles;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FaceAnswer, kind, area, radius, length, turned, lead, hole, centroid,
                                   normal, axis_point, axis, triangles)

struct PartAnswer {
  std::string name, color, brep;
  double density = 0, volume = 0;
  int solids = 0;
  std::array<double, 3> center{};
  std::array<double, 9> moments{};
  std::vector<double> vertices;
  std::vector<std::int32_t> edges;
  std::vector<FaceAnswer> faces;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PartAnswer, name, color, brep, density, volume, solids, center, moments,
                                   vertices, edges, faces)

struct InstanceAnswer {
  int part = 0;
  std::string name, path;
  std::array<double, 9> R{};
  std::array<double, 3> p{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InstanceAnswer, part, name, path, R, p)

/// Two instances, what they have in common, how thick that is and where its middle is.
struct OverlapAnswer {
  int a = 0, b = 0;
  double volume = 0, thickness = 0;
  std::array<double, 3> place{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(OverlapAnswer, a, b, volume, thickness, place)

struct AssemblyAnswer {
  std::string error;  ///< not empty: nothing else counts
  std::vector<PartAnswer> parts;
  std::vector<InstanceAnswer> instances;
  std::vector<OverlapAnswer> overlaps;
  std::vector<std::string> notes;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AssemblyAnswer, error, parts, instances, overlaps, notes)

}  // namespace flexura::import::cad
