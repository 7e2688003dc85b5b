// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/QR>
#include <algorithm>

#include "mbs/mechanism/work.hpp"

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

std::vector<bool> Mechanism::not_unique(double t, ConstVectorRef p) const {
  std::vector<bool> open(quantities_.size(), false);
  const int n_rows = first_row_.back();
  if (static_cast<int>(kept_rows_.size()) == n_rows) return open;
  const auto scratch = make_scratch();
  Work& work = work_of(*scratch);
  forward(Level::position, t, p.data(), nullptr, nullptr, work);

  // -G^T x through the tree.
  BodyLoads loads(*this, work, -1.0);
  const auto load = [&](const VectorXd& x) {
    clear_loads(work);
    work.on_closure.assign(places_.size(), Vector6d::Zero());
    work.rows_x = x;
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
      own_contact(k, work);
      constraints_[k]->apply_GT(work.kin, work.rows_x.data() + first_row_[k], loads);
    }
    backward(work, work.r.data());
  };
  MatrixXd G(n_rows, n_v_);
  for (int i = 0; i < n_rows; ++i) {
    load(VectorXd::Unit(n_rows, i));
    G.row(i) = work.r.head(n_v_).transpose();
  }
  // Rows of unit length: metres and radians meet.
  VectorXd length = G.rowwise().norm();
  for (double& x : length)
    if (x == 0.0) x = 1.0;
  MatrixXd kept(n_v_, kept_rows_.size());
  for (std::size_t i = 0; i < kept_rows_.size(); ++i)
    kept.col(i) = G.row(kept_rows_[i]).transpose() / length(kept_rows_[i]);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> combine;
  if (kept.cols() > 0) combine.compute(kept);

  // Forces count by the torque that they make over the mechanism's length.
  double span = 0.0;
  for (const MarkerState& marker : work.kin.markers)
    span = std::max(span, (marker.X_WP.p - work.kin.markers.front().X_WP.p).norm());
  if (span == 0.0) span = 1.0;

  VectorXd values(quantities_.size());
  std::vector<double> outputs;
  for (int i = 0; i < n_rows; ++i) {
    if (std::ranges::binary_search(kept_rows_, i)) continue;
    VectorXd x = VectorXd::Unit(n_rows, i) / length(i);
    if (kept.cols() > 0) {
      const VectorXd y = combine.solve(VectorXd(G.row(i).transpose() / length(i)));
      for (std::size_t k = 0; k < kept_rows_.size(); ++k) x(kept_rows_[k]) = -y(k) / length(kept_rows_[k]);
    }
    load(x);
    values.setZero();
    for (std::size_t q = 0; q < quantities_.size(); ++q) {
      const QuantityPlace& place = quantities_[q];
      if (place.kind == QuantityKind::reaction) {
        outputs.assign(8, 0.0);
        put_wrench(joint_reaction(place.index, work), true, true, outputs.data());
        values(q) = outputs[place.component];
      } else if (place.kind == QuantityKind::drive) {
        values(q) = drive_force(place.index, place.component, work);
      } else if (place.kind == QuantityKind::constraint) {
        outputs.assign(constraints_[place.index]->outputs().size(), 0.0);
        own_contact(place.index, work);
        constraints_[place.index]->evaluate_outputs(work.kin, x.data() + first_row_[place.index],
                                                    outputs.data());
        values(q) = outputs[place.component];
      }
      if (place.info.dimension == input::dim::force) values(q) *= span;
    }
    const double largest = values.cwiseAbs().maxCoeff();
    for (std::size_t q = 0; q < quantities_.size(); ++q)
      if (std::abs(values(q)) > nothing * largest) open[q] = true;
  }
  return open;
}

}  // namespace flexura::mbs
