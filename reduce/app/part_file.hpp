// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mbs/input/document.hpp"
#include "mbs/input/schema.hpp"
#include "mesh/gmsh/cad.hpp"
#include "mesh/model/select.hpp"
#include "reduce/assembly/part.hpp"

/// The part file: what `flexura reduce PART.toml` takes.  Its reference page is cases/PART_FILE.md, printed
/// from the schema below by `flexura reduce --schema`.
namespace flexura::reduce {

/// An interface as the part file names it.
struct InterfaceInput {
  std::string name;
  mesh::Rule rule;  ///< which faces
  Tie tie = Tie::rigid;
  std::optional<Eigen::Vector3d> reference;  ///< [m], none = the centre of the chosen faces
  std::string where;                         ///< "part.toml:12: interface.bore", for messages
};

struct ModesInput {
  int count = 0;
  double up_to = 0.0;  ///< [Hz], 0 = by count
  double damping = 0.0;
};

/// The table [modes], the same in every kind of part file.
input::TableSchema modes_schema();
ModesInput read_modes(const input::Section& in);

/// The table [recovery].
struct RecoveryInput {
  bool stress = false;
  std::vector<std::string> groups;  ///< only at the nodes of these sets; empty: the whole surface
  bool double_precision = false;
  std::string where;  ///< for messages
};

struct PartInput {
  std::string name;
  std::string source;    ///< the file's text
  mesh::CadOptions cad;  ///< geometry and meshing
  std::vector<Material> materials;
  MassKind mass = MassKind::consistent;
  std::vector<InterfaceInput> interfaces;
  ModesInput modes;
  RecoveryInput recovery;
  bool stiffening = false;  ///< geometric stiffening terms
};

const input::TableSchema& part_schema();

/// Reads and checks a part file.  Throws input::InputError.
PartInput read_part(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace flexura::reduce
