// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_codes.hpp"
#include "reduce/assembly/tied_spread.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

const char* name_of(Tie tie) {
  switch (tie) {
    case Tie::rigid:
      return "rigid";
    case Tie::average:
      return "average";
    case Tie::node:
      return "node";
    case Tie::elastic:
      return "elastic";
  }
  return "unknown";
}

TiedModel::TiedModel(const Part& part, const AssemblyOptions& options) : TiedMotions(part) {
  if (part.interfaces.empty() && !options.may_be_free)
    throw std::invalid_argument(
        "the part has no interface: name at least one face, cylinder or node set by which joints can hold "
        "the body");
  check_interfaces(part, options.may_be_free);
  check_pieces(part);
  if (options.shift == 0.0) choose_pins();
  build_patterns(part);
  if (options.team)
    assemble_together(part, options);
  else
    assemble(part, options);
  average(part);
}

linalg::SymmetricMatrix TiedModel::shifted_stiffness(double shift) const {
  linalg::SymmetricMatrix K = K_ii_->copy();
  // The interior dofs that a node follows, and its motion for a unit of each.
  struct Follows {
    std::vector<int> dof;
    std::vector<Eigen::Vector3d> C;
  };
  const auto follows = [&](int node, Follows& out) {
    out.dof.clear(), out.C.clear();
    each_dof(node, [&](int code, const Eigen::Vector3d& motion) {
      if (code < 0) return;
      out.dof.push_back(code);
      out.C.push_back(motion);
    });
  };
  const linalg::UpperCsr m = m_->csr();
  Follows of_p, of_q;
  for (int p = 0; p < m.n; ++p) {
    follows(p, of_p);
    for (int k = m.row_begin[p]; !of_p.dof.empty() && k < m.row_begin[p + 1]; ++k) {
      const int q = m.columns[k];
      follows(q, of_q);
      for (std::size_t a = 0; a < of_p.dof.size(); ++a)
        for (std::size_t b = p == q ? a : 0; b < of_q.dof.size(); ++b) {
          double value = shift * m.values[k] * of_p.C[a].dot(of_q.C[b]);
          if (p != q && of_p.dof[a] == of_q.dof[b]) value *= 2.0;  // (p, q) and (q, p)
          if (value != 0.0) K.add_to_entry(of_p.dof[a], of_q.dof[b], value);
        }
    }
  }
  return K;
}

// C_i^T (m (x) I_3) C_i X by panels of eight columns, one panel per core at a time.
void TiedModel::multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  constexpr Eigen::Index kWidth = linalg::RowPanel::ColsAtCompileTime;
  Y.setZero(n_i_, X.cols());
  linalg::parallel_for(static_cast<int>((X.cols() + kWidth - 1) / kWidth), [&](int panel) {
    const Eigen::Index first = panel * kWidth, width = std::min(kWidth, X.cols() - first);
    linalg::RowPanel U = linalg::RowPanel::Zero(static_cast<Eigen::Index>(code_.size()), kWidth), MU;
    spread(
        [&](int code, auto&& row) {
          for (Eigen::Index c = 0; c < kWidth; ++c)
            row(c) = code >= 0 && c < width ? X(code, first + c) : 0.0;
        },
        U);
    m_->multiply_kron3(U, MU);
    collect(MU, [&](int code, const auto& row) {
      if (code < 0) return;
      for (Eigen::Index c = 0; c < width; ++c) Y(code, first + c) += row(c);
    });
  });
}

Eigen::Matrix3d TiedModel::direction_projector(const Link& link) const {
  const Eigen::Vector3d line = (points_.row(link.to) - points_.row(link.from)).transpose();
  const double size = (points_.colwise().maxCoeff() - points_.colwise().minCoeff()).norm();
  // Closer than round-off of coordinates tells no direction.
  if (line.norm() < 1e-9 * size) return Eigen::Matrix3d::Identity();
  return line * line.transpose() / line.squaredNorm();
}

}  // namespace flexura::reduce
