// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/freedom.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

namespace flexura::import::cad {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// CAD faces agree to 1e-7 m or better, on parts of centimetres: 1e-5 of their size. What truly restrains does so at
// the size of the part's faces, some percent of it.
constexpr double kTolerance = 1e-4;

MatrixXd null_space(const MatrixXd& rows) {
  if (rows.rows() == 0) return MatrixXd::Identity(6, 6);
  // 6 x 6 normal form keeps the work independent of the number of contacts; its singular values are squares.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(rows.transpose() * rows /
                                                       static_cast<double>(rows.rows()));
  Index dimension = 0;
  while (dimension < 6 && solver.eigenvalues()(dimension) < kTolerance * kTolerance) ++dimension;
  return solver.eigenvectors().leftCols(dimension);
}

}  // namespace

VectorXd nonnegative_least_squares(const MatrixXd& A, const VectorXd& b) {
  const Index n = A.cols();
  VectorXd x = VectorXd::Zero(n);
  std::vector<char> passive(static_cast<std::size_t>(n), 0);
  const double zero = 1e-12 * std::max(1.0, A.cwiseAbs().maxCoeff()) * std::max(1.0, b.norm());
  for (Index round = 0; round < 3 * n + 10; ++round) {
    const VectorXd w = A.transpose() * (b - A * x);
    Index best = -1;
    for (Index i = 0; i < n; ++i)
      if (!passive[static_cast<std::size_t>(i)] && w(i) > zero && (best < 0 || w(i) > w(best))) best = i;
    if (best < 0) break;
    passive[static_cast<std::size_t>(best)] = 1;
    for (;;) {
      std::vector<Index> in;
      for (Index i = 0; i < n; ++i)
        if (passive[static_cast<std::size_t>(i)]) in.push_back(i);
      const VectorXd s = A(Eigen::all, in).completeOrthogonalDecomposition().solve(b);
      double step = 1.0;
      for (Index k = 0; k < s.size(); ++k)
        if (s(k) <= 0.0)
          step = std::min(step, x(in[static_cast<std::size_t>(k)]) /
                                    std::max(1e-300, x(in[static_cast<std::size_t>(k)]) - s(k)));
      for (Index k = 0; k < s.size(); ++k) {
        double& value = x(in[static_cast<std::size_t>(k)]);
        value += step * (s(k) - value);
      }
      if (step == 1.0) break;
      bool left = false;
      for (const Index i : in)
        if (x(i) <= 1e-14) {
          x(i) = 0.0;
          passive[static_cast<std::size_t>(i)] = 0;
          left = true;
        }
      if (!left) break;
    }
  }
  return x;
}

namespace {

MatrixXd rows_of(const std::vector<Contact>& contacts, const Vector3d& centre, double size) {
  MatrixXd rows(static_cast<Index>(contacts.size()), 6);
  for (Index i = 0; i < rows.rows(); ++i) {
    const Contact& c = contacts[static_cast<std::size_t>(i)];
    rows.row(i).head<3>() = ((c.p - centre) / size).cross(c.n).transpose();
    rows.row(i).tail<3>() = c.n.transpose();
  }
  return rows;
}

}  // namespace

MatrixXd kept_freedom(const std::vector<Contact>& contacts, const Vector3d& centre, double size) {
  return null_space(rows_of(contacts, centre, size));
}

MatrixXd open_freedom(const std::vector<Contact>& contacts, const Vector3d& centre, double size) {
  const MatrixXd rows = rows_of(contacts, centre, size);
  // Rows that every twist of the cone keeps: those with a place in some lambda >= 0 with rows^T lambda = 0.
  std::vector<char> held(contacts.size(), 0);
  for (Index i = 0; i < rows.rows(); ++i) {
    if (held[static_cast<std::size_t>(i)]) continue;
    const VectorXd target = -rows.row(i).transpose();
    const VectorXd lambda = nonnegative_least_squares(rows.transpose(), target);
    if ((rows.transpose() * lambda - target).norm() > kTolerance) continue;
    held[static_cast<std::size_t>(i)] = 1;
    for (Index k = 0; k < lambda.size(); ++k)
      if (lambda(k) > kTolerance) held[static_cast<std::size_t>(k)] = 1;
  }
  std::vector<Index> closed;
  for (Index i = 0; i < rows.rows(); ++i)
    if (held[static_cast<std::size_t>(i)]) closed.push_back(i);
  return null_space(rows(closed, Eigen::all));
}

JointForm form_of(const MatrixXd& twists, const Vector3d& centre, double size) {
  using Type = JointForm::Type;
  JointForm form;
  form.point = centre;
  const Index k = twists.cols();
  const MatrixXd omega = twists.topRows(3);
  // Of the rotations: how many, and which twists are translations alone.
  const auto rank_and_kernel = [&](const MatrixXd& A, MatrixXd& kernel) {
    const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeFullV | Eigen::ComputeThinU);
    Index rank = 0;
    while (rank < svd.singularValues().size() && svd.singularValues()(rank) > kTolerance) ++rank;
    kernel = svd.matrixV().rightCols(A.cols() - rank);
    return rank;
  };
  if (k == 0) {
    form.type = Type::fixed;
    return form;
  }
  MatrixXd kernel;
  const Index turns = rank_and_kernel(omega, kernel);
  const MatrixXd slides = twists.bottomRows(3) * kernel;  // directions of pure translations, scaled by size
  const Index n_slides = k - turns;
  // A twist with a rotation: axis, point nearest to the centre, pitch.
  const auto screw_of = [&](const Vector6d& t, double& pitch) {
    const Vector3d w = t.head<3>(), v = size * t.tail<3>() / size;  // v is over size, w x (p / size)
    form.axis = w.normalized();
    form.point = centre + size * w.cross(v) / w.squaredNorm();
    pitch = w.dot(v) / w.squaredNorm();
  };
  double pitch = 0.0;
  if (k == 1 && turns == 1) {
    screw_of(twists.col(0), pitch);
    form.type = std::abs(pitch) < kTolerance ? Type::revolute : Type::screw;
    if (form.type == Type::screw) form.lead = 2.0 * std::numbers::pi * size * pitch;
  } else if (k == 1) {
    form.axis = slides.col(0).normalized();
    form.type = Type::prismatic;
  } else if (k == 2 && turns == 1) {
    // One translation; the rotation is known up to it: cylindrical where they are parallel.
    Eigen::JacobiSVD<MatrixXd> svd(omega, Eigen::ComputeFullV | Eigen::ComputeThinU);
    screw_of(twists * svd.matrixV().col(0), pitch);
    const Vector3d along = slides.col(0).normalized();
    if (along.cross(form.axis).norm() < kTolerance) form.type = Type::cylindrical;
  } else if (k == 3 && turns == 1 && n_slides == 2) {
    Eigen::JacobiSVD<MatrixXd> svd(omega, Eigen::ComputeFullV | Eigen::ComputeThinU);
    screw_of(twists * svd.matrixV().col(0), pitch);
    if ((slides.transpose() * form.axis).norm() < kTolerance) form.type = Type::planar;
    form.point = centre;
  } else if (k == 3 && turns == 3) {
    // v = -w x c for all: [v] = [c]x [w] ... solve the centre from the three twists.
    MatrixXd A(9, 3);
    VectorXd b(9);
    for (Index i = 0; i < 3; ++i) {
      const Vector3d w = twists.col(i).head<3>(), v = twists.col(i).tail<3>();
      Eigen::Matrix3d W;
      W << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
      A.middleRows<3>(3 * i) = -W;  // v + w x c = 0
      b.segment<3>(3 * i) = v;
    }
    const Vector3d c = A.completeOrthogonalDecomposition().solve(b);
    if ((A * c - b).norm() < kTolerance) {
      form.type = Type::spherical;
      form.point = centre + size * c;
    }
  }
  return form;
}

const char* name_of(JointForm::Type type) {
  using Type = JointForm::Type;
  switch (type) {
    case Type::fixed:
      return "fixed";
    case Type::revolute:
      return "revolute";
    case Type::prismatic:
      return "prismatic";
    case Type::screw:
      return "screw";
    case Type::cylindrical:
      return "cylindrical";
    case Type::planar:
      return "planar";
    case Type::spherical:
      return "spherical";
    default:
      return "";
  }
}

}  // namespace flexura::import::cad
