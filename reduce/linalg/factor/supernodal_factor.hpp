// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/dense/trapezoid.hpp"
#include "reduce/linalg/factor/factor_store.hpp"
#include "reduce/linalg/factor/subtrees.hpp"

namespace flexura::linalg {

/// Nested dissection (METIS) of the matrix's graph: row order[k] is eliminated as number k.  `group_begin`
/// cuts the rows into groups of consecutive rows with the same pattern (the directions of one node),
/// ascending, first 0, last n; the graph is that of the groups.  Empty: each row its own group.
std::vector<int> nested_dissection(const UpperCsr& A, std::span<const int> group_begin = {});

/// Who does what in a solve.
struct SolvePlan {
  Subtrees subtrees;
  std::vector<int> first_descendant;
  std::vector<std::ptrdiff_t> longest;  ///< rows of the longest supernode of each subtree
  /// Beside `rows`, for those above a subtree: which of its root's rows below it is.
  std::vector<int> place;
};

/// A supernodal factor of a sparse symmetric matrix,
///
///     P A P^T = L S L^T,    S = diag(+1, -1),
///
/// L lower triangular with positive diagonal, S the identity where A is positive definite (Cholesky).
/// Supernode s holds the columns first_column[s] to first_column[s + 1] of L as one Trapezoid, whose rows are
/// rows[first_row[s]] to rows[first_row[s + 1]]; its own columns come first among them.
///
/// The numbers come by the multifrontal method: a front holds a supernode's columns and what they leave to
/// the rows below, F_22 = sum of children's - L_21 S L_21^T, which goes to the parent in the elimination
/// tree (fronts.hpp).  Subtrees run on all cores side by side, the few large fronts at the top one after the
/// other, each on all cores.  I. S. Duff, J. K. Reid, ACM TOMS 9 (1983), 302; J. W. H. Liu, SIAM Review 34
/// (1992), 82.  The symbolic analysis is CHOLMOD's.  A factor that is too large for memory is kept in a file
/// (factor_store.hpp): each number is written once, and solves read them in order.
class SupernodalFactor {
 public:
  /// How wide the analysis' indices are: 32 bits count 2.1 thousand million entries of L, which is enough to
  /// a million unknowns of a solid part, in half the memory.
  enum class Indices { automatic, wide };
  /// Orders nothing: `order` is used as it is, but for a postordering of the elimination tree.
  SupernodalFactor(const UpperCsr& A, std::vector<int> order, Indices indices = Indices::automatic);

  /// The numbers of L and S for a matrix of the analysed pattern.  There is no pivoting: a definite matrix
  /// needs none, an indefinite one's solves must be tested.  Returns the row of A at which a pivot of a
  /// matrix that must be definite is not positive, or a pivot of an indefinite one is zero; -1 where all is
  /// well. std::runtime_error where neither memory nor disk has room.  `storage` says in which precision; refinement is
  /// the caller's.
  int factorise(const UpperCsr& A, bool must_be_definite, const FactorStorage& storage = {});

  /// X = A^-1 B for n x k right-hand sides, by panels of eight columns on all cores.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const;
  /// Likewise where X has its size; X may be B.
  void solve_into(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> X) const;

  /// The smallest L_jj^2 / |A_jj| and its row.
  struct Pivot {
    double ratio = 1.0;
    int row = 0;
  };
  Pivot smallest_pivot(const UpperCsr& A) const;
  int n_negative() const;  ///< of S: the number of negative eigenvalues of A (Sylvester)

  int size() const { return n_; }
  const std::vector<int>& order() const { return order_; }
  double nonzeros() const { return nonzeros_; }
  double flops() const { return flops_; }
  double bytes() const { return static_cast<double>(n_bytes()); }  ///< of L's numbers
  bool is_single() const { return single_; }
  bool is_in_file() const { return values_.is_file(); }

 private:
  template <class Real>
  friend class Fronts;
  void plan_solves();
  template <class Real>
  int run(const UpperCsr& A, bool must_be_definite, const FactorStorage& storage);
  template <class Real>
  Real* values() const {
    return static_cast<Real*>(values_.data());
  }
  std::size_t n_bytes() const {
    return (single_ ? sizeof(float) : sizeof(double)) * static_cast<std::size_t>(first_value_.back());
  }
  int n_supernodes() const { return static_cast<int>(first_column_.size()) - 1; }
  int width(int s) const { return first_column_[s + 1] - first_column_[s]; }
  int height(int s) const { return first_row_[s + 1] - first_row_[s]; }
  Trapezoid shape(int s) const { return {height(s), width(s)}; }

  int n_ = 0;
  double nonzeros_ = 0.0, flops_ = 0.0;
  std::vector<int> order_;
  std::vector<int> first_column_, first_row_, rows_;
  std::vector<std::int64_t> first_value_;
  SolvePlan plan_;
  FactorStore values_;
  bool single_ = false;
  std::vector<double> signs_, diagonal_;  // of the columns of L
};

}  // namespace flexura::linalg
