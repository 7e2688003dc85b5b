// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Dense>

/// Eigen's heavy templates for matrices of doubles, compiled once (eigen_instances_*.cpp) in place of in
/// every file that multiplies or factors: part of the precompiled header, and so of no source file.  A third
/// less to compile.
#define FLEXURA_EIGEN_DECOMPOSITIONS(instance)                            \
  instance class Eigen::PartialPivLU<Eigen::MatrixXd>;                    \
  instance class Eigen::FullPivLU<Eigen::MatrixXd>;                       \
  instance class Eigen::HouseholderQR<Eigen::MatrixXd>;                   \
  instance class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;             \
  instance class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>; \
  instance class Eigen::LLT<Eigen::MatrixXd>;                             \
  instance class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;          \
  instance class Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>;

#define FLEXURA_EIGEN_PRODUCT(instance, left, right)                                                        \
  instance struct general_matrix_matrix_product<Index, double, left, false, double, right, false, ColMajor, \
                                                1>;

#define FLEXURA_EIGEN_VECTOR_PRODUCT(instance, left)                                              \
  instance struct general_matrix_vector_product<Index, double, Mapper<left>, left, false, double, \
                                                Mapper<ColMajor>, false>;                         \
  instance struct general_matrix_vector_product<Index, double, Mapper<left>, left, false, double, \
                                                Mapper<RowMajor>, false>;

#define FLEXURA_EIGEN_TRIANGULAR(instance, mode)                                                         \
  instance struct triangular_solve_matrix<double, Index, OnTheLeft, mode, false, ColMajor, ColMajor, 1>; \
  instance struct triangular_solve_matrix<double, Index, OnTheLeft, mode, false, RowMajor, ColMajor, 1>; \
  instance struct product_triangular_matrix_matrix<double, Index, mode, true, ColMajor, false, ColMajor, \
                                                   false, ColMajor, 1>;                                  \
  instance struct product_triangular_matrix_matrix<double, Index, mode, true, RowMajor, false, ColMajor, \
                                                   false, ColMajor, 1>;                                  \
  instance struct triangular_matrix_vector_product<Index, mode, double, false, double, false, ColMajor>; \
  instance struct triangular_matrix_vector_product<Index, mode, double, false, double, false, RowMajor>;

#define FLEXURA_EIGEN_KERNELS(instance)                                                                   \
  instance struct gebp_kernel<double, double, Index, ResultMapper, Traits::mr, Traits::nr, false, false>; \
  instance struct gemm_pack_lhs<double, Index, Mapper<ColMajor>, Traits::mr, Traits::LhsProgress,         \
                                Traits::LhsPacket4Packing, ColMajor>;                                     \
  instance struct gemm_pack_lhs<double, Index, Mapper<RowMajor>, Traits::mr, Traits::LhsProgress,         \
                                Traits::LhsPacket4Packing, RowMajor>;                                     \
  instance struct gemm_pack_rhs<double, Index, Mapper<ColMajor>, Traits::nr, ColMajor>;                   \
  instance struct gemm_pack_rhs<double, Index, Mapper<RowMajor>, Traits::nr, RowMajor>;                   \
  FLEXURA_EIGEN_PRODUCT(instance, ColMajor, ColMajor)                                                     \
  FLEXURA_EIGEN_PRODUCT(instance, ColMajor, RowMajor)                                                     \
  FLEXURA_EIGEN_PRODUCT(instance, RowMajor, ColMajor)                                                     \
  FLEXURA_EIGEN_PRODUCT(instance, RowMajor, RowMajor)                                                     \
  FLEXURA_EIGEN_VECTOR_PRODUCT(instance, ColMajor)                                                        \
  FLEXURA_EIGEN_VECTOR_PRODUCT(instance, RowMajor)                                                        \
  FLEXURA_EIGEN_TRIANGULAR(instance, Lower)                                                               \
  FLEXURA_EIGEN_TRIANGULAR(instance, Upper)                                                               \
  FLEXURA_EIGEN_TRIANGULAR(instance, UnitLower)                                                           \
  FLEXURA_EIGEN_TRIANGULAR(instance, UnitUpper)

namespace Eigen::internal {
using Traits = gebp_traits<double, double>;
using ResultMapper = blas_data_mapper<double, Index, ColMajor>;
template <int order>
using Mapper = const_blas_data_mapper<double, Index, order>;
}  // namespace Eigen::internal

#ifndef FLEXURA_EIGEN_INSTANCES
namespace Eigen::internal {
FLEXURA_EIGEN_KERNELS(extern template)
}
FLEXURA_EIGEN_DECOMPOSITIONS(extern template)
#endif
