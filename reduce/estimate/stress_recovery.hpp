// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/elements/strain.hpp"

/// Superconvergent patch recovery (O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Eng. 33 (1992), 1331).
///
/// Stresses of finite elements jump between cells; at some points of a cell they are an order better than elsewhere.
/// Around each corner of the mesh a polynomial of the displacements' degree is fitted to the stresses at these points
/// of the cells that meet there,
///
///     s*(x) = P(x) a,   a = argmin sum_k |P(x_k) a - s_h(x_k)|^2,
///
/// in coordinates along the principal axes of the points, each in units of their spread, so that thin plates keep
/// what varies through them.  s* at the corner is that of its patch, at other nodes the mean of the patches of the
/// corners of the edge or cell it lies on.  Patches with too few points (edges of the part) take in the neighbours of
/// their cells.  A patch never crosses from one material to another.
namespace flexura::reduce {

class StressRecovery {
 public:
  explicit StressRecovery(const Part& part);

  /// Recovered stresses of displacements T (3 n_nodes x k) at the places of nodes (places() of them): row
  /// 6 place + c [Pa per unit], c in the order of Material::D.
  Eigen::MatrixXf recover(const Eigen::Ref<const Eigen::MatrixXd>& T) const;

  /// The place of each node of a cell: a node has one for each material that meets there.
  const Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& places(std::size_t block) const {
    return places_[block];
  }
  int n_places() const { return n_places_; }

 private:
  struct Cell {
    int block;
    Eigen::Index row;
    int first_sample;
  };
  struct Patch {
    std::vector<int> cells;
    int degree;
    Eigen::Vector3d centre;
    Eigen::Matrix3d to_local;   ///< rows: principal axes over the spread along them
    std::vector<int> at;        ///< places that take its polynomial
    std::vector<double> share;  ///< with this weight
  };

  void number_places();
  void make_patches();
  void shape_patch(Patch& patch) const;

  const Part& part_;
  std::vector<Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> places_;
  int n_places_ = 0, n_samples_ = 0;
  std::vector<Cell> cells_;
  std::vector<mesh::Index> node_of_place_;
  std::vector<TabulatedRule> sampling_;  ///< of each block
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> sample_points_;
  std::vector<Patch> patches_;
};

/// Stress of displacements u (3 n x k of a cell's nodes) at a point of a solid cell, 6 x k: as its element makes it.
class CellStress {
 public:
  CellStress(const Part& part, const mesh::CellBlock& block, Eigen::Index row);
  Eigen::MatrixXd at(const TabulatedRule::Point& point, const Eigen::Ref<const Eigen::MatrixXd>& u,
                     double* det = nullptr) const;

 private:
  const Matrix6& D_;
  StrainField strains_;
};

}  // namespace flexura::reduce
