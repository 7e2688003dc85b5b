// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

/// The page on which faces are numbered and joints are decided: an assembly with the joints proposed for it, or one part.
/// All lengths in m.
namespace flexura::view {

struct NumberedFace {
  int number = 0;                                   ///< ascending in a part
  std::string text;                                 ///< "bore, radius 12 mm, ..."
  std::string kind;                                 ///< plane, cylinder, cone, sphere, free-form
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the part: on the axis, or the centroid
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();   ///< axis or normal; zero where it has none
  std::string lines;  ///< of the [interface.NAME] that chooses it, each with its end
};

struct DrawnPart {
  std::string name, file, color;           ///< file: the part file's name as shown; color: "#rrggbb" or empty
  std::vector<Eigen::Vector3d> vertices;   ///< of its triangles
  std::vector<Eigen::Vector3i> triangles;  ///< counter-clockwise from outside
  std::vector<std::int32_t> face;          ///< of each triangle: index in `faces`
  std::vector<std::pair<int, int>> edges;  ///< drawn as lines
  std::vector<NumberedFace> faces;
};

struct PlacedBody {
  std::string name, text;  ///< text: one line about it
  int part = 0;
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
};

struct ProposedJoint {
  std::string name, type;  ///< fixed, revolute, prismatic, screw, cylindrical, planar, universal, spherical
  double lead = 0.0;       ///< of a screw [m]
  int a = 0, b = 0;        ///< bodies
  Eigen::Matrix3d R_WJ = Eigen::Matrix3d::Identity();  ///< z along its axis
  Eigen::Vector3d p_WJ = Eigen::Vector3d::Zero();
  std::string confidence, doubt;
  std::vector<std::string> evidence;
  std::vector<std::pair<int, int>> faces;  ///< (body, number of its face) that it sits on
  std::array<int, 2> on = {};              ///< the face of A and of B that carries its markers; 0: none
};

struct OverlappingPair {
  int a = 0, b = 0;                                 ///< bodies
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< in the world
  std::string text;
};

struct ContactCandidate {
  int a = 0, b = 0;                                 ///< bodies
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< in the world
  std::string text;                                 ///< "crank and yoke: 0.1 mm apart ..."
  std::string lines;                                ///< of the mechanism file, may be empty
};

struct PartsPage {
  std::string title, created_by;
  std::vector<DrawnPart> parts;
  std::vector<PlacedBody> bodies;
  int ground = -1;  ///< the body that stands; -1: a part alone, on which faces are chosen
  std::vector<ProposedJoint> joints;
  std::vector<std::string> doubts;  ///< sentences about pairs that are to be looked at
  std::vector<OverlappingPair> overlaps;
  std::vector<ContactCandidate> contacts;
  std::string head;  ///< the mechanism file but for what stands on the ground and the joints
};

/// Throws std::invalid_argument where an index leads nowhere, a number is not finite or there is nothing to draw, and
/// std::runtime_error when the file cannot be written; then no file of this name is left behind.
void write_parts_page(const std::filesystem::path& html, const PartsPage& page);

}  // namespace flexura::view
