// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mesh/import/abaqus.hpp"
#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/bar_sections.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"

/// What the keywords of an Abaqus deck say, by labels and names, before anything is placed in a model.
namespace flexura::mesh::abaqus {

struct ElementLine {
  CellType type;
  CellVariant variant;
  std::int64_t label;
  std::vector<std::int64_t> nodes;
  Where where;
};
struct NodeLine {
  std::int64_t label;
  Eigen::Vector3d x;
  Where where;
};
/// Of *SHELL SECTION, COMPOSITE.
struct Layer {
  std::string material;
  double thickness, angle;       // [rad]
  std::string orientation = {};  // instead of the section's
};
struct Section {
  std::string set, material;
  Where where;
  double thickness = 0, offset = 0;  // of shells
  double area = 0;                   // of trusses
  std::string orientation = {};      // of solids
  std::vector<Layer> layers = {};    // unlike ones, from the side against the normal
  std::optional<BarSection> bar = {};
  Eigen::Vector3d n1 = -Eigen::Vector3d::UnitZ();  // of beams: their direction 1
};
/// Elements that are no cells: beams, trusses, point masses, springs; of three nodes the first, the middle, the last, and
/// then the node that gives the direction 1.
struct OtherElement {
  std::string type;
  std::int64_t label;
  std::vector<std::int64_t> nodes;
  Where where;
};
/// *MASS, *ROTARY INERTIA, *SPRING, *DASHPOT: numbers for the elements of a set.
struct ElementData {
  std::string kind, set;
  std::vector<double> values;
  Where where;
  std::string orientation = {};
  std::vector<double> dofs = {};  ///< *SPRING of SPRING2
  double alpha = 0;               ///< of *MASS and *ROTARY INERTIA: damping in proportion to the mass
};
/// *COUPLING, *RIGID BODY, *MPC.
struct TieKeyword {
  std::string what, reference,
      set = {};  // what: COUPLING (of a surface), RIGID BODY (of a node set), MPC (of a node or set)
  ImportedTie::Kind kind = ImportedTie::Kind::rigid;
  std::array<bool, 6> dofs{true, true, true, true, true, true};
  Where where = {};
  std::string orientation = {};                  ///< of `dofs`
  std::optional<std::string> joins_places = {};  ///< *MPC TIE, PIN: what it says of nodes in one place alone
};
/// *TIE: a line of it.
struct SurfaceTie {
  std::string slave, master;
  double tolerance = 0;  ///< 0: a twentieth of the master's cells
  Where where;
  bool adjust = true;  ///< nodes are put onto the master; otherwise they follow it from where they stand
};
/// *EQUATION: sum of coefficient times dof (1 to 6) of a node or of each node of a set = 0.
struct EquationLine {
  struct Term {
    std::string of;
    int dof = 1;
    double coefficient = 0;
  };
  std::vector<Term> terms;
  Where where;
};
/// Axes by *TRANSFORM (of the dofs of a set) or *SYSTEM (of coordinates): rectangular, cylindrical or spherical.
struct Transform {
  std::string set;
  char kind = 'R';
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< columns: the axes
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Where where;
  /// Columns: the directions 1, 2, 3 at a place.
  Eigen::Matrix3d axes_at(const Eigen::Vector3d& x) const;
};
/// *ORIENTATION: axes, turned about one of them, or why they are not read.
struct Orientation {
  Transform system = {};  ///< rectangular, cylindrical or spherical
  int about = 1;          ///< 1 to 3
  double angle = 0;       ///< about it
  std::string not_read = {};
  Where where;
  /// Columns: the axes at a place.
  Eigen::Matrix3d axes_at(const Eigen::Vector3d& x) const;
  /// Columns: those of a shell there, the third along its normal: the first is the axis after `about`, laid into the shell,
  /// turned by the angle.
  Eigen::Matrix3d shell_axes_at(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const;
};
/// Columns: `along` laid into the plane of a normal, the third axis; where it stands upright, `otherwise` is laid there.
Eigen::Matrix3d laid_on(const Eigen::Vector3d& normal, const Eigen::Vector3d& along,
                        const Eigen::Vector3d& otherwise);
struct Surface {
  Where where;
  bool of_nodes = false, used = false;
  std::vector<std::pair<std::string, std::string>> entries;  // set or label, face
};

/// What a part (or the model level) holds, by label.
struct Part {
  std::string name;
  std::vector<NodeLine> nodes;
  std::vector<ElementLine> elements;
  std::map<std::string, std::vector<std::int64_t>> node_sets, element_sets;
  std::vector<Section> sections;
  std::vector<OtherElement> others;
  std::vector<ElementData> data;
};

struct Instance {
  std::string name;
  int part = -1;
  Part own;  // nodes and elements given in the instance itself
  Where where = {};
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

struct AssemblySet {
  std::string name, instance;
  bool of_nodes;
  std::vector<std::int64_t> labels;
  std::vector<std::string> names;
  Where where;
};

struct Deck {
  std::set<std::string> file_names;  ///< of all Where
  std::vector<Part> parts;           ///< 0: the model level of a flat file
  std::vector<std::unique_ptr<Instance>> instances;
  std::vector<AssemblySet> assembly_sets;
  std::vector<TieKeyword> ties;
  std::vector<SurfaceTie> surface_ties;
  std::vector<EquationLine> equations;
  std::vector<Transform> transforms;
  std::map<std::string, Surface> surfaces;
  std::map<std::string, Orientation> orientations;  ///< by "PART.NAME", or "NAME" at the model level
  std::vector<ImportedMaterial> materials;
  std::set<std::string> laminae;     ///< those of *ELASTIC, TYPE=LAMINA, which shells alone have
  Unused unused, left_out, unbound;  ///< keywords; elements; keywords that bind what stays apart
  Unused otherwise;                  ///< what makes another body than the deck describes
  std::map<std::string, std::pair<std::size_t, std::string>> replaced;  ///< type: how many, what it becomes
};

/// *TRANSFORM: its axes, in the deck's unit of length; `set` in capitals.  Throws std::invalid_argument, naming file and
/// line, as the next.
Transform transform_of(const Keyword& k);
/// *ORIENTATION: its axes; what is not read (other definitions) is told by `not_read`.
Orientation orientation_of(const Keyword& k);
/// *SYSTEM: origin, a point on x and one in the x-y plane; without a line the global system.
Transform system_of(const Keyword& k);

/// Throws std::invalid_argument, naming file and line.
Deck read_deck(const std::filesystem::path& path, DeckProgram program);

}  // namespace flexura::mesh::abaqus
