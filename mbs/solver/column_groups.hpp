// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

/// Columns of a sparse Jacobian that one difference finds together, because no row depends on two of them (A.
/// R. Curtis, M. J. D. Powell, J. K. Reid, J. Inst. Maths Applics 13 (1974) 117-119).
namespace flexura::mbs {

class ColumnGroups {
 public:
  /// Entries that are not 0 may depend on their column; columns where `skip` is true are left out.
  void find(const Eigen::MatrixXd& pattern, const std::vector<bool>& skip);

  int size() const { return static_cast<int>(groups_.size()); }
  const std::vector<int>& group(int k) const { return groups_[k]; }
  const std::vector<int>& rows(int column) const { return rows_[column]; }

 private:
  std::vector<std::vector<int>> groups_, rows_;
};

}  // namespace flexura::mbs
