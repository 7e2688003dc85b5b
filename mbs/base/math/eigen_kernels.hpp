// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

/// Eigen's products, triangular solves and decompositions of matrices of any size, compiled once, in eigen_kernels.cpp: every
/// file that multiplies two matrices would compile its own copies, a fifth of the time of a build.  None of these is
/// inlined by Eigen; what they compute does not change.  Part of the precompiled headers, not to be included.
#ifndef FLEXURA_EIGEN_KERNEL
#define FLEXURA_EIGEN_KERNEL extern template
#endif

namespace Eigen {
namespace internal {
using FlexuraColMapper = const_blas_data_mapper<double, Index, ColMajor>;
using FlexuraRowMapper = const_blas_data_mapper<double, Index, RowMajor>;
using FlexuraOut = blas_data_mapper<double, Index, ColMajor, 0, 1>;
using FlexuraTraits = gebp_traits<double, double>;
using FlexuraPacket = FlexuraTraits::LhsPacket4Packing;
FLEXURA_EIGEN_KERNEL struct gebp_kernel<double, double, Index, FlexuraOut, FlexuraTraits::mr,
                                        FlexuraTraits::nr, false, false>;
FLEXURA_EIGEN_KERNEL struct gemm_pack_lhs<double, Index, FlexuraColMapper, FlexuraTraits::mr,
                                          FlexuraTraits::LhsProgress, FlexuraPacket, ColMajor, false, false>;
FLEXURA_EIGEN_KERNEL struct gemm_pack_lhs<double, Index, FlexuraRowMapper, FlexuraTraits::mr,
                                          FlexuraTraits::LhsProgress, FlexuraPacket, RowMajor, false, false>;
FLEXURA_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, FlexuraColMapper, FlexuraTraits::nr, ColMajor, false,
                                          false>;
FLEXURA_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, FlexuraRowMapper, FlexuraTraits::nr, RowMajor, false,
                                          false>;
FLEXURA_EIGEN_KERNEL struct gemm_pack_rhs<double, Index, FlexuraOut, FlexuraTraits::nr, ColMajor, false,
                                          true>;
FLEXURA_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, FlexuraRowMapper, RowMajor, false,
                                                          double, FlexuraColMapper, false, 0>;
FLEXURA_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, FlexuraColMapper, ColMajor, false,
                                                          double, FlexuraRowMapper, false, 0>;
FLEXURA_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, FlexuraRowMapper, RowMajor, false,
                                                          double, FlexuraRowMapper, false, 1>;
FLEXURA_EIGEN_KERNEL struct general_matrix_vector_product<Index, double, FlexuraColMapper, ColMajor, false,
                                                          double, FlexuraColMapper, false, 0>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheLeft, UnitUpper, false, RowMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, ColMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, RowMajor,
                                                    ColMajor, 1>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, ColMajor>;
FLEXURA_EIGEN_KERNEL struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitLower, false,
                                                    ColMajor>;
FLEXURA_EIGEN_KERNEL struct partial_lu_impl<double, ColMajor, int, Dynamic>;
FLEXURA_EIGEN_KERNEL void
apply_block_householder_on_the_left<Block<MatrixXd>, Block<MatrixXd>, VectorBlock<const VectorXd>>(
    Block<MatrixXd>&, const Block<MatrixXd>&, const VectorBlock<const VectorXd>&, bool);
}  // namespace internal
FLEXURA_EIGEN_KERNEL class PartialPivLU<MatrixXd>;
FLEXURA_EIGEN_KERNEL class FullPivLU<MatrixXd>;
FLEXURA_EIGEN_KERNEL class ColPivHouseholderQR<MatrixXd>;
FLEXURA_EIGEN_KERNEL class HouseholderQR<MatrixXd>;
FLEXURA_EIGEN_KERNEL class CompleteOrthogonalDecomposition<MatrixXd>;
FLEXURA_EIGEN_KERNEL class FullPivLU<Matrix<double, 6, 6>>;
FLEXURA_EIGEN_KERNEL class LDLT<MatrixXd, Lower>;
FLEXURA_EIGEN_KERNEL class LLT<MatrixXd, Lower>;
FLEXURA_EIGEN_KERNEL LDLT<MatrixXd, Lower>& LDLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
FLEXURA_EIGEN_KERNEL LLT<MatrixXd, Lower>& LLT<MatrixXd, Lower>::compute(const EigenBase<MatrixXd>&);
FLEXURA_EIGEN_KERNEL SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
FLEXURA_EIGEN_KERNEL class GeneralizedSelfAdjointEigenSolver<MatrixXd>;
FLEXURA_EIGEN_KERNEL class SelfAdjointEigenSolver<MatrixXd>;
FLEXURA_EIGEN_KERNEL SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(
    const EigenBase<Matrix3d>&, int);
FLEXURA_EIGEN_KERNEL class BDCSVD<MatrixXd>;
FLEXURA_EIGEN_KERNEL class JacobiSVD<MatrixXd>;
FLEXURA_EIGEN_KERNEL RealSchur<MatrixXd>& RealSchur<MatrixXd>::compute(const EigenBase<MatrixXd>&, bool);
FLEXURA_EIGEN_KERNEL EigenSolver<MatrixXd>& EigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, bool);
FLEXURA_EIGEN_KERNEL class EigenSolver<MatrixXd>;
FLEXURA_EIGEN_KERNEL class PartialPivLU<Matrix<double, 6, 6>>;
FLEXURA_EIGEN_KERNEL class PartialPivLU<MatrixXcd>;
FLEXURA_EIGEN_KERNEL class FullPivLU<MatrixXcd>;
FLEXURA_EIGEN_KERNEL void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const VectorXd&,
                                                                                 VectorXd&) const;
}  // namespace Eigen

/// What nearly every file multiplies: made into functions here, once, in place of in each of them.
namespace flexura::precompiled {
inline void common_products(const Eigen::MatrixXd& A, const Eigen::Matrix3Xd& B, const Eigen::Matrix3d& R,
                            const Eigen::Map<const Eigen::VectorXd>& x, Eigen::VectorXd& y,
                            Eigen::MatrixXd& C, Eigen::Vector3d& u) {
  u = A * x;
  u += B * x;
  u = R * u + R.transpose() * u;
  y = A * y;
  y = A.transpose() * y;
  y.noalias() = A * x;
  y.noalias() += A * x;
  C = A * C;
  C = A.transpose() * C;
  C.noalias() = A * C;
  C.noalias() += A * C;
  C.noalias() = A.transpose() * C;
  C = 0.5 * (A + A.transpose());
}
}  // namespace flexura::precompiled
