// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/QR>
#include <algorithm>

#include "mbs/mechanism/outputs/quantities.hpp"

/// Which reactions redundant constraints leave open.
///
/// A redundant row i is a combination of those kept, G_i = x^T G, so that the multipliers (1, -x) hold
/// themselves in balance: a self-stress, of which any amount may be in the mechanism.  What it puts into a
/// joint or a constraint is not determined by the equations; what it leaves at 0 is, whichever row was left
/// out.
namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Part of the largest force of a self-stress that counts as round-off: closed loops leave angles of 1e-10.
constexpr double nothing = 1e-6;

}  // namespace

std::vector<bool> Quantities::not_unique(const InverseDynamics& dynamics, Motion& motion, Wrenches& wrenches,
                                         RowValues& rows) const {
  std::vector<bool> open(all_.size(), false);
  const int n_rows = rows_.n_all();
  if (static_cast<int>(rows_.kept().size()) == n_rows) return open;
  // -G^T x through the tree.
  BodyLoads loads(tree_, motion, wrenches, -1.0);
  const auto load = [&](const VectorXd& x) {
    dynamics.clear_loads(wrenches);
    wrenches.on_closure.assign(tree_.places.size(), Vector6d::Zero());
    rows.x = x;
    rows_.apply_all(motion, rows, loads);
    dynamics.backward(motion, wrenches, wrenches.r.data());
  };
  MatrixXd G(n_rows, tree_.n_v);
  for (int i = 0; i < n_rows; ++i) {
    load(VectorXd::Unit(n_rows, i));
    G.row(i) = wrenches.r.head(tree_.n_v).transpose();
  }
  // Rows of unit length: metres and radians meet.
  VectorXd length = G.rowwise().norm();
  for (double& x : length)
    if (x == 0.0) x = 1.0;
  MatrixXd kept(tree_.n_v, rows_.kept().size());
  for (std::size_t i = 0; i < rows_.kept().size(); ++i)
    kept.col(i) = G.row(rows_.kept()[i]).transpose() / length(rows_.kept()[i]);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> combine;
  if (kept.cols() > 0) combine.compute(kept);

  // Forces count by the torque that they make over the mechanism's length.
  double span = 0.0;
  for (const MarkerState& marker : motion.kin.markers)
    span = std::max(span, (marker.X_WP.p - motion.kin.markers.front().X_WP.p).norm());
  if (span == 0.0) span = 1.0;

  VectorXd values(all_.size());
  std::vector<double> outputs;
  for (int i = 0; i < n_rows; ++i) {
    if (std::ranges::binary_search(rows_.kept(), i)) continue;
    VectorXd x = VectorXd::Unit(n_rows, i) / length(i);
    if (kept.cols() > 0) {
      const VectorXd y = combine.solve(VectorXd(G.row(i).transpose() / length(i)));
      for (std::size_t k = 0; k < rows_.kept().size(); ++k)
        x(rows_.kept()[k]) = -y(k) / length(rows_.kept()[k]);
    }
    load(x);
    values.setZero();
    for (std::size_t q = 0; q < all_.size(); ++q) {
      const Quantity& place = all_[q];
      if (place.kind == Kind::reaction) {
        outputs.assign(8, 0.0);
        put_wrench(joint_reaction(place.index, motion, wrenches, rows), true, true, outputs.data());
        values(q) = outputs[place.component];
      } else if (place.kind == Kind::measure) {
        values(q) =
            value_of_multipliers(tree_, rows_, *tree_.d.measures[place.index], motion, wrenches, rows);
      } else if (place.kind == Kind::drive) {
        values(q) = drive_force(place.index, place.component, rows);
      } else if (place.kind == Kind::constraint) {
        outputs.assign(rows_.constraints()[place.index]->outputs().size(), 0.0);
        rows_.own_contact(place.index, motion, rows);
        rows_.constraints()[place.index]->evaluate_outputs(
            motion.kin, x.data() + rows_.first_row(place.index), outputs.data());
        values(q) = outputs[place.component];
      }
      if (place.info.dimension == input::dim::force) values(q) *= span;
    }
    const double largest = values.cwiseAbs().maxCoeff();
    for (std::size_t q = 0; q < all_.size(); ++q)
      if (std::abs(values(q)) > nothing * largest) open[q] = true;
  }
  return open;
}

}  // namespace flexura::mbs
