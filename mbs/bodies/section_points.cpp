// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/section_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/base/math/rotation.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Weights of places evenly along a member, from `first` on, for what lies between them: Lagrange's cubic.
struct Between {
  Index first;
  VectorXd weights;
};

Between cubic(double share, Index places) {
  const double at = share * static_cast<double>(places - 1);
  const Index first = std::clamp<Index>(static_cast<Index>(at) - 1, 0, places - 4);
  VectorXd weights = VectorXd::Ones(4);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (j != i) weights(i) *= (at - static_cast<double>(first + j)) / (i - j);
  return {first, weights};
}

}  // namespace

SectionPoints::SectionPoints(const superelement::SectionForces& forces, const ModalData& body,
                             std::optional<LeftOutModes> left_out, StiffeningLoads stiffening)
    : forces_(forces),
      Y_(body.Y),
      coupling_(body.coupling),
      is_stiffened_(body.second.has_value()),
      left_out_(std::move(left_out)),
      stiffening_(std::move(stiffening)) {
  Eigen::MatrixXd D = body.damping_matrix();
  for (Index i = 0; i < D.rows(); ++i) D.row(i) *= body.stiffness(i) > 0.0 ? 1.0 / body.stiffness(i) : 0.0;
  of_damping_ = Y_ * D;
}

std::pair<Index, Index> SectionPoints::places_of(int member) const {
  const auto [first, end] = std::ranges::equal_range(forces_.member, member);
  return {first - forces_.member.begin(), end - first};
}

double SectionPoints::length(int member) const {
  const auto [first, places] = places_of(member);
  return (forces_.positions.row(first + places - 1) - forces_.positions.row(first)).norm();
}

std::vector<SectionPoints::Near> SectionPoints::nearest(const Eigen::Vector3d& wanted, int member) const {
  std::vector<Near> all;
  double least = INFINITY;
  for (int m = 0; m < static_cast<int>(forces_.members.size()); ++m) {
    if (member >= 0 && m != member) continue;
    const auto [first, places] = places_of(m);
    const Eigen::Vector3d start = forces_.positions.row(first),
                          along = forces_.positions.row(first + places - 1).transpose() - start;
    const double square = along.squaredNorm(),
                 share = square > 0.0 ? std::clamp(along.dot(wanted - start) / square, 0.0, 1.0) : 0.0;
    all.push_back({m, share, (start + share * along - wanted).norm()});
    least = std::min(least, all.back().distance);
  }
  // As near: but for the digits that a file's numbers have.
  const double size = forces_.positions.cwiseAbs().maxCoeff();
  std::erase_if(all, [&](const Near& near) { return near.distance > least + 1e-6 * size; });
  return all;
}

void SectionPoints::add_point(const Wanted& wanted) {
  const auto [start, places] = places_of(wanted.member);
  Point point{wanted};
  Between between = is_whole() ? cubic(wanted.share, places) : Between{0, VectorXd::Ones(1)};
  if (!is_whole()) {
    const double at = wanted.share * static_cast<double>(places - 1);
    between.first = static_cast<Index>(std::lround(at));
    point.distance = std::abs(at - static_cast<double>(between.first)) /
                     static_cast<double>(std::max<Index>(1, places - 1)) * length(wanted.member);
  }
  const Index p = start + between.first, n = between.weights.size();
  const auto mix = [&](const auto& rows, Index height) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(height, rows.cols());
    for (Index i = 0; i < n; ++i)
      sum += between.weights(i) * rows.middleRows(height * (p + i), height).template cast<double>();
    return sum;
  };
  Maps maps;
  maps.R_BS = forces_.axes.row(p).reshaped<Eigen::RowMajor>(3, 3);
  const Eigen::MatrixXd S = mix(forces_.S, 6);
  maps.of_s = S * Y_;
  maps.of_rates = S * of_damping_;
  if (forces_.of_loads.size() > 0) maps.of_loads = mix(forces_.of_loads, 6);
  if (is_whole()) {
    maps.of_acceleration = mix(forces_.of_acceleration, 6);
    maps.turning = mix(forces_.turning, 3) * Y_;
    const Eigen::MatrixXd of_shapes = mix(forces_.of_deformation, 6);
    maps.of_deformation.setZero(6, 9 * Y_.cols());
    for (Index k = 0; k < Y_.rows(); ++k)
      for (Index i = 0; i < Y_.cols(); ++i)
        maps.of_deformation.middleCols<9>(9 * i) += Y_(k, i) * of_shapes.middleCols<9>(9 * k);
  }
  if (is_whole() && is_stiffened_) {
    const Index m = Y_.cols(), n_l = stiffening_.size();
    maps.of_stiffening.setZero(6, n_l * m);
    if (forces_.of_stiffening.size() > 0) {
      const Eigen::MatrixXd of_shapes = mix(forces_.of_stiffening, 6);
      for (Index k = 0; k < n_l; ++k)
        maps.of_stiffening.middleCols(k * m, m) = of_shapes.middleCols(k * Y_.rows(), Y_.rows()) * Y_;
    }
    if (left_out_)
      for (Index k = 0; k < n_l; ++k)
        maps.of_stiffening.middleCols(k * m, m) += S * left_out_->of_stiffening[static_cast<std::size_t>(k)];
  }
  if (is_whole() && left_out_) {
    maps.of_nodes = S * left_out_->of_nodes;
    maps.of_acceleration += S * left_out_->of_acceleration;
    if (left_out_->dropped_acceleration.size() > 0) {
      maps.dropped_acceleration = S * left_out_->dropped_acceleration;
      maps.dropped_deformation = S * left_out_->dropped_deformation;
    }
    maps.of_deformation += S * left_out_->of_deformation;
    if (maps.of_loads.size() > 0) maps.of_loads += S * left_out_->of_loads;
  }
  points_.push_back(std::move(point));
  maps_.push_back(std::move(maps));
}

std::string SectionPoints::describe(int point) const {
  const Wanted& wanted = points_[static_cast<std::size_t>(point)].wanted;
  return fmt::format("section force at {:.5g} m of member \"{}\", in the {}'s axes",
                     wanted.share * length(wanted.member),
                     forces_.members[static_cast<std::size_t>(wanted.member)],
                     is_whole() && wanted.axes == Axes::section ? "section" : "member");
}

SectionForce SectionPoints::at(int point, const BodyMotion& motion, const double* factors) const {
  const Maps& maps = maps_[static_cast<std::size_t>(point)];
  const Index m = Y_.cols();
  const Eigen::Map<const VectorXd> s(motion.s, m);
  SectionForce out = maps.of_s * s;
  if (factors && maps.of_loads.size() > 0)
    out += maps.of_loads * Eigen::Map<const VectorXd>(factors, maps.of_loads.cols());
  if (!is_whole()) return out;
  out += maps.of_rates * Eigen::Map<const VectorXd>(motion.s_dot, m);
  const ParticleAcceleration by(motion, static_cast<int>(m));
  out += maps.of_acceleration * by.c + maps.of_deformation * by.B;
  if (maps.dropped_acceleration.size() > 0) {
    const ParticleAcceleration dropped = dropped_inertia(motion, static_cast<int>(m), coupling_);
    out += maps.dropped_acceleration * dropped.c + maps.dropped_deformation * dropped.B;
  }
  if (motion.on_nodes.size() > 0 && maps.of_nodes.size() > 0) out += maps.of_nodes * motion.on_nodes;
  if (maps.of_stiffening.cols() > 0) {
    const VectorXd loads = stiffening_.at(motion, factors);
    for (Index k = 0; k < loads.size(); ++k)
      if (loads(k) != 0.0) out += loads(k) * (maps.of_stiffening.middleCols(k * m, m) * s);
  }
  const bool given_by_section = !knows_stiffening(),
             wanted_by_section = points_[static_cast<std::size_t>(point)].wanted.axes == Axes::section;
  if (given_by_section == wanted_by_section) return out;
  // From the section's axes to the member's; back by the transpose.
  const Eigen::Matrix3d R = maps.R_BS.transpose() * rotation_exp(maps.turning * s) * maps.R_BS;
  const Eigen::Matrix3d Q = wanted_by_section ? Eigen::Matrix3d(R.transpose()) : R;
  out.head<3>() = (Q * out.head<3>()).eval();
  out.tail<3>() = (Q * out.tail<3>()).eval();
  return out;
}

}  // namespace flexura::mbs
