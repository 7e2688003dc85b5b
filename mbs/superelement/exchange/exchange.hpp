// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/superelement/modes.hpp"

/// A superelement in the formats of other programs.  Every writer writes beside and renames, and throws
/// std::runtime_error when the file system refuses.  All numbers are SI.
namespace flexura::superelement {

/// STEM.K.mtx, STEM.M.mtx (and STEM.D.mtx): Matrix Market "array real symmetric", 17 digits, dofs in the
/// order of the superelement, named in the comment lines.  Where `nodes` are read, STEM.T.mtx, "array real general", has their
/// six motions each.  Returns the files.
std::vector<std::filesystem::path> write_matrix_market(const std::filesystem::path& stem,
                                                       const Superelement& se);

/// Nastran bulk data: GRID for each interface, SPOINT for each mode, K and M as symmetric DMIG (KFLEX, MFLEX,
/// lower triangle, large field, 10 digits).  Interface i is grid i + 1, mode j is scalar point 1000001 + j.
void write_dmig(const std::filesystem::path& path, const Superelement& se);

/// Standard input data of Wallrapp (1993) as text, the layout of FEMBS: `modes` (elastic ones) as shapes, the
/// inertia terms mdCM, J, Ct, Cr, Me, Gr, Ge, Oe from the integrals, Ke, De, and the interfaces as nodes.
/// With stiffening terms K0t, K0r, K0omega go into the first-order parts of Ct, Cr, Oe, K0F into those of the
/// nodes' phi and psi.
void write_sid(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes);

/// The standard-input-data terms themselves, about Bo, for m shapes phi_j = sum_k phi_k Y_kj.
struct StandardInputData {
  Eigen::Vector3d mdCM_0;                   ///< [kg m]
  Eigen::Matrix3Xd mdCM_1;                  ///< 3 x m
  Eigen::Matrix3d J_0;                      ///< [kg m^2]
  std::vector<Eigen::Matrix3d> J_1;         ///< m
  Eigen::MatrixXd Ct_0, Cr_0;               ///< m x 3
  std::vector<Eigen::MatrixXd> Ct_1, Cr_1;  ///< m of m x 3: derivative by s_k
  Eigen::MatrixXd Me, Ke, De;               ///< m x m
  std::vector<Eigen::Matrix3d> Gr_0;        ///< m: coefficient of s_j'
  std::vector<Eigen::MatrixXd> Ge_0;        ///< m of m x 3: coefficient of s_j'
  Eigen::MatrixXd Oe_0;                     ///< m x 6, omega_a omega_b = xx, yy, zz, xy, yz, xz
  std::vector<Eigen::MatrixXd> Oe_1;        ///< m of m x 6: derivative by s_k
};
StandardInputData standard_input_data(const Superelement& se, const Eigen::MatrixXd& Y);

/// ParaView: XML PolyData (.vtp) of the surface, binary, with one displacement array for each elastic mode,
/// scaled so that the largest displacement is a tenth of the part's size.  Needs surface and shapes.
void write_vtp(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes);

/// gmsh .msh 2.2 of the surface with one view ($NodeData, 3 components) for each mode, scaled as in
/// write_vtp.
void write_gmsh_views(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes);

/// glTF 2.0 (.glb): the surface with one morph target and one animation for each mode, scaled as in
/// write_vtp; opens in browsers' viewers, Blender, PowerPoint.  Animation j swings target j once in 1.5 s.
void write_gltf(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes);

/// The rigid body and the integrals of the modes, as superelement::InertiaIntegrals.
struct FlexDataBody {
  double mass = 0.0;
  Eigen::Vector3d S_x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();
  std::vector<std::string> names;                  ///< of the interfaces, as `nodes`
  std::vector<std::vector<Direction>> directions;  ///< that each of them retains
  double modal_damping = 0.0;                      ///< share of the modes' damping that is the body's default
  Eigen::Matrix3Xd S_phi;                          ///< 3 x m
  Eigen::MatrixXd S_xphi;                          ///< 9 x m
  std::array<Eigen::MatrixXd, 6> S_phiphi;         ///< each m x m
};

/// MotionSolve's Reference_FlexData: frequencies, damping and mode shapes at the interface nodes.  The format has no
/// inertia invariants; they go into a comment, which other programs pass over, so that the body can be read back.
///
/// ModeLoad has a number for each mode: of the modes written, or of these after the six rigid ones, or by the modes' numbers, the
/// rigid ones being 1 to 6 (so in the example of MotionSolve's guide); all are read, the second is written.  What is written on rigid
/// modes is that on modes of unit modal mass: translations, then rotations about the principal axes through the centre of mass.
struct FlexData {
  struct ModeLine {
    int id = 0;
    double frequency = 0.0;   ///< [Hz]
    double eigenvalue = 0.0;  ///< [rad^2/s^2]
    double damping = 0.0;     ///< ratio to critical
  };
  struct NodeLine {
    int id = 0;
    Eigen::Vector3d position;
  };
  /// A load case (ModeLoad): forces on the modes, and what it does to the body as a rigid one.
  struct LoadLine {
    int id = 0;
    std::string name;          ///< "load_ID" in the files of other programs
    Eigen::VectorXd on_modes;  ///< m [N m per unit of the mode]
    /// Force and torque about Bo [N, N m]; not known in the files of other programs.
    std::optional<Eigen::Matrix<double, 6, 1>> resultant;
    bool is_preload = false;
    bool has_rigid = false;  ///< the file has numbers on rigid modes, whose axes it does not tell
  };
  std::optional<FlexDataBody> body;  ///< none in the files of other programs
  int id = 1;
  int num_nodes = 0;  ///< of the finite element model, or 0
  std::vector<ModeLine> modes;
  std::vector<NodeLine> nodes;
  std::vector<LoadLine> loads;
  Eigen::MatrixXd shapes;  ///< 6 n_nodes x n_modes: x, y, z, rx, ry, rz of node 0, then of node 1, ...
};
/// `modes` without its rigid ones, numbered as they stand in the analysis.
FlexData make_flexdata(const Superelement& se, const ModeAnalysis& modes);
void write_flexdata(const std::filesystem::path& path, const FlexData& data);
/// Reads what write_flexdata writes and MotionSolve's own files.  Throws std::invalid_argument naming file
/// and line, also for more numbers than the counts say, what is not finite, rigid modes, and for a file of several bodies
/// of which `id` names none.
FlexData read_flexdata(const std::filesystem::path& path, std::optional<int> id = {});

namespace exchange {
/// The elastic modes as columns, n x m.
Eigen::MatrixXd elastic_shapes(const Superelement& se, const ModeAnalysis& modes);
/// The largest displacement of a mode on the surface.
double largest_displacement(const Eigen::VectorXf& surface_shape);
/// The factor that makes a mode's largest displacement a tenth of the surface's box.
double display_scale(const Superelement& se, const Eigen::VectorXf& surface_shape);
/// Throws std::invalid_argument, naming the superelement, unless it holds a surface with shapes.
void require_surface(const Superelement& se);
/// "mode 7 (478.86 Hz)"
std::string mode_name(const ModeAnalysis& modes, std::size_t j);
/// A mode's displacement on the surface, 3 n_v, at the size it is drawn.
Eigen::VectorXf drawn_shape(const Superelement& se, const Mode& mode);
std::string base64(const std::string& bytes);
}  // namespace exchange

}  // namespace flexura::superelement
