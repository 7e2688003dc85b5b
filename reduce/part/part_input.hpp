// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "mesh/import/abaqus.hpp"
#include "mesh/model/select.hpp"
#include "reduce/assembly/input/part.hpp"
#include "reduce/cms/damping.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/linalg/session/user_options.hpp"

/// What is asked of a part, SI units, whoever asks: a part file (reduce/file) or a program (reduce/library).
namespace flexura::reduce {

/// Where the mesh comes from.
enum class PartFormat { cad, gmsh, abaqus, nastran, unv, nodes };

/// An interface: which faces or nodes, tied how.
struct InterfaceInput {
  std::string name;
  mesh::Rule rule = {};              ///< which faces
  std::optional<int> deck_tie = {};  ///< or which tie of the deck
  Tie tie = Tie::rigid;
  bool equal_weights = false;  ///< of averages: nodes count alike, not by the faces' area
  std::vector<int> directions = {0, 1, 2, 3, 4, 5};
  std::optional<Eigen::Vector3d> reference;  ///< [m], none = the centre of the chosen faces
  std::string where;                         ///< "part.toml:12: interface.bore", for messages
};

struct ModesInput {
  int count = 0;
  double up_to = 0.0;  ///< [Hz], 0 = by count
  double damping = 0.0;
  bool damping_given = false;  ///< by the user
  ModeSet set = ModeSet::craig_bampton;
  double accuracy = 0.0, compliance_accuracy = 0.0, effective_mass = 0.0;  ///< 0: not asked for
  std::vector<double> response_omegas = {};                                ///< [rad/s]
  std::vector<int> struck = {};
  // Solid parts only.
  InterfaceModesRequest interface_modes = {};
  bool certify = true;
  std::string where = {};
};

struct MassInput {
  std::string name;
  std::string interface = {};    ///< or
  std::optional<int> node = {};  ///< number in the mesh file
  PointMass mass = {};
  std::string where;
};

struct LinkInput {
  std::string name;
  std::vector<std::string> interfaces = {};  ///< two, or
  std::vector<int> nodes = {};               ///< two numbers of the mesh file
  double stiffness = 0.0, damping = 0.0;
  std::string where;
};

enum class LoadType { gravity, rotation, pressure, field, preload };

struct LoadInput {
  std::string name;
  LoadType type = LoadType::gravity;
  bool keep_shape = false;
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();  ///< gravity: acceleration; rotation: axis
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double value = 0.0;  ///< speed or pressure
  mesh::Rule faces = {};
  std::optional<Eigen::Vector3d> side = {};  ///< pressure on shells: the pushed side looks this way
  std::array<std::string, 3> formulas = {};
  std::string strain = {};    ///< preload: a formula of x, y, z; `vector` its direction, zero: all
  std::string material = {};  ///< of its cells; empty: all
  std::string where;
};

/// The table [recovery].
struct RecoveryInput {
  bool stress = false;
  std::vector<std::string> groups;  ///< only at the nodes of these sets; empty: the whole surface
  bool all_nodes = false;           ///< the motions of all nodes, not the surface alone
  bool double_precision = false;
  std::string where;  ///< for messages
};

/// What is kept of a part of any kind.
struct ReductionRequest {
  std::string name;
  std::string source;  ///< the file's text
  ModesInput modes;
  DampingRule damping;
  bool has_damping = false;
  RecoveryInput recovery;
  bool stiffening = false;  ///< geometric stiffening terms
};

/// Where another program gives stresses.
enum class StressPlace { nodes, elements, corners };

struct PartInput : ReductionRequest {
  std::string where;  ///< the file, for messages
  PartFormat format = PartFormat::cad;
  mesh::CadOptions cad;                       ///< path of any format; geometry and meshing of CAD parts
  double unit_length = 1.0, unit_mass = 1.0;  ///< of a mesh file, in SI
  mesh::DeckProgram program = mesh::DeckProgram::unknown;  ///< that a deck was written for
  bool mass_unit_known = true;                             ///< given, or going with the length unit
  double density = 0.0;  ///< [kg/m^3] of a deck's materials that have none; 0: not given
  bool strict = false;   ///< what of a deck is repaired or left out is refused
  bool keep_largest = false, keep_all = false;  ///< of several pieces that nothing joins; neither: refused
  double sheet_thickness = 0.0;                 ///< [m] of a CAD part of faces; 0: solids
  Formulation formulation = Formulation::standard;
  std::filesystem::path stiffness, mass_matrix, damping_matrix;  ///< finished matrices; empty: none
  struct {
    std::filesystem::path vectors, stiffness, mass, damping, reduced_mass, stress;  ///< empty: not given
    StressPlace stress_at = StressPlace::nodes;
  } finished;  ///< finished modes of another program
  std::vector<Material> materials;
  MassKind mass = MassKind::consistent;
  std::vector<InterfaceInput> interfaces;
  std::vector<MassInput> masses;
  std::vector<LinkInput> links;
  std::vector<LoadInput> loads;
  std::vector<linalg::UserOption> petsc;  ///< options of PETSc and SLEPc
};

}  // namespace flexura::reduce
