// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/cms/craig_bampton.hpp"

/// What is known of a part from meshes that become finer by the same factor: limits with their uncertainty.
namespace flexura::reduce {

/// The first elastic frequencies of the free body [Hz] and the compliance of each interface in each direction while all
/// others are held [m/N, rad/(N m), ...].
struct Answer {
  std::vector<double> hz, compliance;
  Eigen::MatrixXd shapes;  ///< 3 n_points x n_modes: the modes at points of the part, to tell them apart
  int dofs = 0;
};

/// Points by which modes are told apart: nodes of the mesh near those of a grid of its box.
Eigen::Matrix3Xd points_of(const Part& part);

/// Nothing is reduced for the frequencies; the compliance is that of constraint modes, which are exact.
Answer answer_of(const Part& part, const Reduction& reduction, int n_modes, const Eigen::Matrix3Xd& points);

/// In the order of the interfaces and their directions; empty with one interface.
std::vector<double> compliance_of(const Reduction& reduction);

/// Three meshes or more, each `ratio` times as fine as the one before everywhere, gradings kept.
struct Sequence {
  std::string kind;  ///< of the part; names of parts that are the same share a truth
  double ratio = 1.5;
  double least_order = 2.0;  ///< at which energies converge at worst, by the theory of the mesh's edges
  std::vector<std::function<Part()>> meshes;
};

/// With the last three values a, b, c: an error like h^p leaves (a - b) / (b - c) = ratio^p and  c - (b - c) / (ratio^p - 1)
/// is the limit (L. F. Richardson, Phil. Trans. A 210 (1911) 307).  p is what they show, from the least that theory allows to
/// 4.  Uncertainty: the limits by the least order and by what is shown are that far apart, and at least half of what was
/// extrapolated.  Values that do not fall monotonely are not extrapolated: uncertain by all that they move.
struct Known {
  double value = 0.0, uncertainty = 0.0;  ///< relative to the value
  bool settled() const { return uncertainty <= 1e-3; }
};
Known limit_of(double a, double b, double c, double ratio, double least_order);

struct Truth {
  std::vector<Known> hz, compliance;
  Eigen::Matrix3Xd points;
  Eigen::MatrixXd shapes;  ///< of the finest mesh
  std::vector<int> dofs;
};
/// The answers are kept in, and taken from, the folder FLEXURA_TRUTHS where it is set: they take an hour.
Truth truth_of(const Sequence& sequence, int n_modes);

/// The partner of each column of `shapes` among those of `known`: the pairs most alike first, each once (modal assurance
/// criterion); -1 where none is alike.
std::vector<int> partners(const Eigen::MatrixXd& shapes, const Eigen::MatrixXd& known);

}  // namespace flexura::reduce
