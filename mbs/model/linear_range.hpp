// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/model/mechanism.hpp"

/// Watches whether flexible bodies stay in the linear range of their deformation.
///
/// The measure is the rotation theta of one interface against another, which does not depend on the frame:
/// displacements linear in the modal coordinates miss the shortening theta^2 / 2 of a line that turns by
/// theta, relative to its length.
namespace flexura::mbs {

class LinearRange {
 public:
  /// Sentences are given for bodies that leave `limit` [rad]; 0.2 means an error of 2 %.
  explicit LinearRange(const Mechanism& mechanism, double limit = 0.2);

  void observe(const State& s);

  /// One for each body that left the range, with where, when and by how much.
  std::vector<std::string> sentences() const;
  /// Largest rotation of one interface against another so far [rad]; 0 for a rigid body.
  double largest(int body) const { return worst_[body].angle; }

 private:
  struct Worst {
    double angle = 0.0, t = 0.0;
    int from = 0, to = 0;
  };
  const Mechanism& mechanism_;
  double limit_;
  std::vector<Worst> worst_;
  std::vector<Matrix3d> R_;
};

}  // namespace flexura::mbs
