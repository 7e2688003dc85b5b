// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/part.hpp"
#include "reduce/estimate/mesh_error.hpp"
#include "reduce/linalg/progress.hpp"

/// The mesh's error by what the next degree would add.
///
/// A shape u that vibrates with omega^2 = lambda under forces F on the interfaces leaves, tested with functions w that the
/// mesh lacks (enrichment.hpp),
///
///     r(w) = lambda m(u, w) - a(u, w) + F(w),
///
/// F(w) the work of the traction that an averaging tie makes of F.  The answer e, a(e, w) = r(w), has the energy that
/// the enriched space gains over the mesh's own, which is nearly all that is missing where the exact solution is smooth
/// (R. E. Bank, A. Weiser, Math. Comp. 44 (1985), 283; M. Ainsworth, J. T. Oden, A Posteriori Error Estimation in Finite
/// Element Analysis, chapter 5).  e is sought among all functions of the enriched mesh: r does not load the mesh's own
/// (the shape is in equilibrium there), but without them thin elements could not bend.  A few steps of conjugate
/// gradients, preconditioned by the cells' own inverses with shared functions weighted by their stiffness, come from
/// below to within a few per cent: r is rough, so that no coarse problem is needed.  The degrees after the next add
/// about a fifth more to cells of second degree (measured, docs/mesh_error.md).  Functions on faces of rigid ties are
/// left out.
namespace flexura::reduce {

/// Displacements that are judged.
struct JudgedStates {
  Eigen::MatrixXd Y;       ///< n x k: combinations of the shapes
  Eigen::VectorXd lambda;  ///< k: omega^2 [rad^2/s^2], 0 for statics
  Eigen::MatrixXd force;   ///< n_b x k: on the interface dofs, in the order of the part's interfaces and directions
};

class EnrichedError {
 public:
  /// Whether the cells' enrichments are known and the elements are displacement elements with full integration.
  static bool suits(const Part& part);

  /// Shapes T: 3 n_nodes x n.
  EnrichedError(const Part& part, const Eigen::MatrixXd& T, const JudgedStates& states,
                const linalg::Progress& progress);

  /// a(e, e) of each state.
  const MeshEnergy& energy() const { return energy_; }

 private:
  /// States together: those of a part with two interfaces.  Cells' matrices come from memory once for all of them.
  static constexpr int kWidth = 16;
  using Panel = Eigen::Matrix<float, Eigen::Dynamic, kWidth, Eigen::RowMajor>;
  struct Cell {
    int block;
    Eigen::Index row;
    std::size_t first_function;  ///< in functions_
    std::size_t first_entry;     ///< in K_ and B_
    int n_gained, n;             ///< functions; after the gained ones come the cell's own
  };

  void number_functions();
  void leave_out_rigid_faces();
  void compute_cells(const Eigen::MatrixXd& U, const Eigen::VectorXd& lambda, const linalg::Progress& progress);
  void add_tractions(const Eigen::MatrixXd& force);
  void weigh_shared_functions();
  void multiply(const std::vector<float>& matrices, const Panel& X, Panel& Y) const;
  void solve(Eigen::Index first_state);

  const Part& part_;
  std::vector<Cell> cells_;
  std::vector<int> functions_;  ///< of the cells: number, or -1 where it is left out
  std::vector<float> sign_;     ///< of the cells' functions: direction of the edge
  int n_functions_ = 0;
  std::vector<float> K_, B_;  ///< of the cells: stiffness, weighted inverse (3 n x 3 n)
  Eigen::MatrixXf R_;         ///< 3 n_functions x k
  MeshEnergy energy_;
};

}  // namespace flexura::reduce
