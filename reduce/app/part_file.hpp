// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mbs/input/document.hpp"
#include "mbs/input/schema.hpp"

/// The part file: what `flexura reduce PART.toml` takes.  Its reference page is cases/PART_FILE.md, printed
/// from the schema below by `flexura reduce --schema`.
namespace flexura::reduce {

struct GeometryInput {
  std::filesystem::path file;  ///< STEP, IGES, BREP; relative names are relative to the part file
  std::string unit;            ///< "" = as the file says
  std::optional<int> solid;    ///< counted from 1; none = the only one
  bool fuse = false;
  bool heal = false;
};

struct MeshInput {
  std::filesystem::path file;  ///< a finished mesh instead of geometry; empty = mesh the geometry
  int order = 2;
  double size = 0.0;  ///< [m], 0 = chosen from the part's features
  double elements_per_circle = 0.0;
  double time_limit = 0.0;  ///< [s]
};

struct MaterialInput {
  std::string name;
  double young = 0.0;  ///< [Pa]
  double poisson = 0.0;
  double density = 0.0;  ///< [kg/m^3]
};

/// How an interface is found on the part; the fields that count depend on `by`.
struct InterfaceInput {
  std::string name;
  std::string by;   ///< "cylinder", "plane", "near", "faces", "group", "nodes"
  std::string tie;  ///< "rigid" or "average"
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< axis of a cylinder or normal of a plane
  double radius = 0.0;                              ///< [m]
  std::vector<int> faces;
  std::string group;
  std::vector<int> nodes;
  std::optional<Eigen::Vector3d> reference;  ///< [m], none = the centre of the chosen faces
  std::string where;                         ///< "part.toml:12: interface.bore", for messages
};

struct ModesInput {
  int count = 0;
  double up_to = 0.0;  ///< [Hz], 0 = by count
  double damping = 0.0;
};

struct PartInput {
  std::string name;
  std::string source;  ///< the file's text
  GeometryInput geometry;
  MeshInput mesh;
  std::vector<MaterialInput> materials;
  std::string mass;  ///< "consistent" or "lumped"
  std::vector<InterfaceInput> interfaces;
  ModesInput modes;
};

const input::TableSchema& part_schema();

/// Reads and checks a part file.  Throws input::InputError.
PartInput read_part(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace flexura::reduce
