// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/joints/joint_freedom.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <map>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {

using Type = JointForm::Type;
using Eigen::MatrixXd;

MatrixXd twists_of(const JointForm& form, const Vector3d& centre, double size) {
  const auto turn = [&](const Vector3d& w) {
    Vector6d t;
    t << w, (form.point - centre).cross(w) / size;
    return t;
  };
  const auto slide = [](const Vector3d& v) {
    Vector6d t;
    t << Vector3d::Zero(), v;
    return t;
  };
  std::vector<Vector6d> columns;
  const Matrix3d R = mbs::frame_along(form.axis);
  switch (form.type) {
    case Type::revolute:
      columns = {turn(form.axis)};
      break;
    case Type::prismatic:
      columns = {slide(form.axis)};
      break;
    case Type::screw:
      columns = {turn(form.axis) + form.lead / (2.0 * std::numbers::pi * size) * slide(form.axis)};
      break;
    case Type::cylindrical:
      columns = {turn(form.axis), slide(form.axis)};
      break;
    case Type::planar:
      columns = {turn(form.axis), slide(R.col(0)), slide(R.col(1))};
      break;
    case Type::spherical:
      columns = {turn(Vector3d::UnitX()), turn(Vector3d::UnitY()), turn(Vector3d::UnitZ())};
      break;
    default:
      break;
  }
  MatrixXd twists(6, static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index k = 0; k < twists.cols(); ++k) twists.col(k) = columns[static_cast<std::size_t>(k)];
  return twists;
}

std::optional<int> count_freedom(std::vector<ProposedJoint>& joints, const std::vector<int>& group,
                                 int ground, const Vector3d& centre, double size) {
  std::map<int, int> column;
  for (const int g : group)
    if (g != ground) column.emplace(g, 0);
  int next = 0;
  for (auto& [g, c] : column) c = 6 * next++;
  constexpr int most = 400;  // the work grows with the third power
  if (next > most) return std::nullopt;
  std::vector<Eigen::VectorXd> basis;  // of the rows so far, orthonormal
  for (ProposedJoint& joint : joints) {
    if (joint.form.type == Type::fixed) continue;
    const MatrixXd S = twists_of(joint.form, centre, size);
    const Eigen::HouseholderQR<MatrixXd> qr(S);
    const MatrixXd N = (qr.householderQ() * MatrixXd::Identity(6, 6)).rightCols(6 - S.cols()).transpose();
    for (Eigen::Index r = 0; r < N.rows(); ++r) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(6 * next);
      if (const auto c = column.find(group[static_cast<std::size_t>(joint.b)]); c != column.end())
        row.segment<6>(c->second) += N.row(r).transpose();
      if (const auto c = column.find(group[static_cast<std::size_t>(joint.a)]); c != column.end())
        row.segment<6>(c->second) -= N.row(r).transpose();
      for (int round = 0; round < 2; ++round)  // twice is enough (Parlett)
        for (const Eigen::VectorXd& q : basis) row -= q * q.dot(row);
      // Unit rows; STEP's placements are right to 1e-7 of the size, what is independent is so at a part of it.
      if (row.norm() > 1e-5)
        basis.push_back(row.normalized());
      else
        ++joint.redundant;
    }
  }
  const int rank = static_cast<int>(basis.size());
  return 6 * next - rank;
}

}  // namespace flexura::import::cad
