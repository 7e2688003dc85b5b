// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/largest.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mbs/view/stress_picture.hpp"

namespace flexura::view {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Poses = Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>;

/// Places worked on together, so that memory does not grow with the part.
constexpr Index kChunk = 4096;

double norm_of(const Vector3d& u) {
  return u.norm();
}

/// sqrt(3 J2) of xx, yy, zz, xy, yz, zx: a seminorm, as the search below needs it.
double norm_of(const Eigen::Matrix<double, 6, 1>& s) {
  const Vector3d d(s[0] - s[1], s[1] - s[2], s[2] - s[0]);
  return std::sqrt(0.5 * d.squaredNorm() + 3.0 * s.tail<3>().squaredNorm());
}

/// A field of N components at every place, linear in coordinates q(t): f(p, t) = |C_p q(t)|.  Its largest value over rows and
/// places is found without computing all of them: within the rows a..b,
///
///     f(p, t) <= f(p, c) + sum_k max_t |q_k(t) - q_k(c)| |C_p,k|
///
/// with a row c among them, so that places whose bound does not reach the largest value found are left out, and the rows are
/// halved for the others.
template <int N>
class Search {
 public:
  /// `columns`: N n_p x K, N rows for each place; places count from `first`.
  Search(RowMajor columns, Index first, Largest& best)
      : C_(std::move(columns)), size_(C_.rows() / N, C_.cols()), first_(first), best_(best) {
    for (Index p = 0; p < size_.rows(); ++p)
      for (Index k = 0; k < size_.cols(); ++k)
        size_(p, k) = norm_of(C_.template block<N, 1>(N * p, k).eval());
  }

  /// `q`: n_t x K.
  void rows(const RowMajor& q) {
    std::vector<Index> places(static_cast<std::size_t>(size_.rows()));
    std::iota(places.begin(), places.end(), Index{0});
    if (places.empty() || q.rows() == 0) return;
    // The likeliest row first: the sooner a large value is known, the more is left out.
    Index likeliest = 0;
    (q.cwiseAbs() * size_.colwise().maxCoeff().transpose()).maxCoeff(&likeliest);
    for (const Index p : places) at(p, q.row(likeliest).transpose(), likeliest);
    halve(q, 0, q.rows(), places);
  }

 private:
  double at(Index p, const Eigen::VectorXd& q, Index row) {
    const double value = norm_of((C_.template middleRows<N>(N * p) * q).eval());
    if (value > best_.value) best_ = {value, row, first_ + p};
    return value;
  }

  void halve(const RowMajor& q, Index a, Index b, const std::vector<Index>& places) {
    if (a >= b || places.empty()) return;
    const Index c = (a + b) / 2;
    const Eigen::VectorXd middle = q.row(c).transpose();
    const Eigen::VectorXd reach =
        (q.middleRows(a, b - a).rowwise() - middle.transpose()).cwiseAbs().colwise().maxCoeff().transpose();
    std::vector<std::pair<double, Index>> bounds;
    for (const Index p : places) bounds.emplace_back(at(p, middle, c) + size_.row(p).dot(reach), p);
    std::vector<Index> left;
    // What exceeds by round-off alone is the same value again.
    for (const auto& [bound, p] : bounds)
      if (bound > best_.value * (1.0 + 1e-12)) left.push_back(p);
    halve(q, a, c, left);
    halve(q, c + 1, b, left);
  }

  RowMajor C_, size_;
  Index first_;
  Largest& best_;
};

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

struct Pose {
  Matrix3d R;
  Vector3d p;
};

/// Of the body at a row, seen from `observer` (null: the world).
Pose seen(const Poses& body, const Poses* observer, Index row) {
  const auto pose = [&](const Poses& poses) {
    const auto x = poses.row(row);
    return Pose{Eigen::Quaterniond(x[3], x[4], x[5], x[6]).normalized().toRotationMatrix(),
                Vector3d(x[0], x[1], x[2])};
  };
  const Pose B = pose(body);
  if (!observer) return B;
  const Pose O = pose(*observer);
  return {O.R.transpose() * B.R, O.R.transpose() * (B.p - O.p)};
}

/// What is measured is u + W (x - centre) + d in the body's frame, at every row: the modal coordinates, W row by row, d.
class Coordinates {
 public:
  Coordinates(const results::BodyHistory& body, const Vector3d& centre)
      : q(RowMajor::Zero(body.modal.rows(), body.modal.cols() + 12)), m_(body.modal.cols()), centre_(centre) {
    q.leftCols(m_) = body.modal;
  }

  /// W and d of W x + d.
  void set(Index row, const Matrix3d& W, const Vector3d& d) {
    for (int i = 0; i < 3; ++i) q.block<1, 3>(row, m_ + 3 * i) = W.row(i);
    q.block<1, 3>(row, m_ + 9) = (W * centre_ + d).transpose();
  }

  RowMajor q;

 private:
  Index m_;
  Vector3d centre_;
};

}  // namespace

std::vector<ReferenceFrame> reference_frames(const superelement::Superelement& se, const MatrixXd& basis) {
  std::vector<ReferenceFrame> frames;
  for (const superelement::Interface& interface : se.interfaces)
    if (interface.directions.size() + interface.following.size() + interface.free.size() == 6)
      frames.push_back(
          {interface.name, interface.p_BoN_B, superelement::interface_motion(se, interface) * basis});
  return frames;
}

std::map<std::string, Largest> largest_displacements(
    const superelement::Superelement& se, const results::BodyHistory& body,
    const std::vector<ReferenceFrame>& frames, const std::vector<const results::BodyHistory*>& observers) {
  const auto& vertices = se.surface.vertices;
  const Index n_t = body.modal.rows(), m = body.basis.cols();
  const Vector3d centre = 0.5 * (vertices.colwise().minCoeff() + vertices.colwise().maxCoeff()).transpose();
  std::map<std::string, Coordinates> wanted;
  wanted.emplace("own", Coordinates(body, centre));
  for (const ReferenceFrame& frame : frames) {
    Coordinates& at = wanted.emplace("interface:" + frame.name, Coordinates(body, centre)).first->second;
    for (Index i = 0; i < n_t; ++i) {
      // u less what the frame carries along.
      const Eigen::Matrix<double, 6, 1> moved = frame.motion * body.modal.row(i).transpose();
      const Matrix3d W = -cross(moved.tail<3>());
      at.set(i, W, -moved.head<3>() - W * frame.p);
    }
  }
  const auto since_start = [&](const std::string& name, const Poses* observer) {
    Coordinates& at = wanted.emplace(name, Coordinates(body, centre)).first->second;
    if (body.pose.rows() != n_t || n_t == 0 || (observer && observer->rows() != n_t)) return;
    const Pose then = seen(body.pose, observer, 0);
    for (Index i = 0; i < n_t; ++i) {
      // R (x + u) + p - R_0 x - p_0, turned into the body's frame.
      const Pose now = seen(body.pose, observer, i);
      at.set(i, Matrix3d::Identity() - now.R.transpose() * then.R, now.R.transpose() * (now.p - then.p));
    }
  };
  since_start("ground", nullptr);
  for (const results::BodyHistory* observer : observers)
    since_start("body:" + observer->name, &observer->pose);

  std::map<std::string, Largest> best;
  for (Index first = 0; first < vertices.rows(); first += kChunk) {
    const Index n = std::min(kChunk, vertices.rows() - first);
    RowMajor columns = RowMajor::Zero(3 * n, m + 12);
    columns.leftCols(m) = se.shapes.middleRows(3 * first, 3 * n).cast<double>() * body.basis;
    for (Index v = 0; v < n; ++v) {
      const Eigen::RowVector3d x = vertices.row(first + v).cast<double>() - centre.transpose();
      for (int i = 0; i < 3; ++i) columns.block<1, 3>(3 * v + i, m + 3 * i) = x;
      columns.block<3, 3>(3 * v, m + 9).setIdentity();
    }
    for (const auto& [name, at] : wanted) Search<3>(columns, first, best[name]).rows(at.q);
  }
  return best;
}

namespace {

/// The largest one of the sums of shapes.
Largest largest_of_shapes(const superelement::Superelement& se, const results::BodyHistory& body) {
  const auto n_places = static_cast<Index>(se.stress->vertices.size());
  Largest best;
  for (Index first = 0; first < n_places; first += kChunk) {
    const Index n = std::min(kChunk, n_places - first);
    Search<6>(RowMajor(se.stress->S.middleRows(6 * first, 6 * n) * body.basis), first, best).rows(body.modal);
  }
  best.vertex = static_cast<Index>(se.stress->vertices[static_cast<std::size_t>(best.vertex)]);
  // What StressField::components takes for round-off is drawn as none.
  if (StressField(se).components(body.basis * body.modal.row(best.row).transpose()).isZero(0.0f))
    best.value = 0.0;
  return best;
}

/// The place of a stored quantity; -1 where there is none.
Index column_of(const results::Run& run, const std::string& name) {
  const auto found = std::ranges::find(run.quantities, name, &results::Quantity::name);
  return found == run.quantities.end() ? Index{-1} : static_cast<Index>(found - run.quantities.begin());
}

}  // namespace

std::optional<Largest> largest_stress(const superelement::Superelement& se, const results::BodyHistory& body,
                                      const results::Run& run) {
  if (!se.stress || se.stress->vertices.empty() || body.modal.rows() == 0) return std::nullopt;
  const Index stored = column_of(run, body.name + ".von_mises");
  if (stored < 0 || run.values.rows() != body.modal.rows()) return largest_of_shapes(se, body);
  Largest best;
  best.value = run.values.col(stored).maxCoeff(&best.row);
  Vector3d place;
  bool has_place = true;
  for (int i = 0; i < 3; ++i) {
    const Index column = column_of(run, body.name + ".von_mises_" + "xyz"[i]);
    has_place = has_place && column >= 0;
    if (has_place) place[i] = run.values(best.row, column);
  }
  const Eigen::VectorXf drawn = StressField(se).von_mises(body.basis * body.modal.row(best.row).transpose());
  double nearest = HUGE_VAL;
  for (const auto number : se.stress->vertices) {
    const auto v = static_cast<Index>(number);
    const double distance = has_place ? (se.surface.vertices.row(v).cast<double>().transpose() - place).norm()
                                      : -static_cast<double>(drawn[v]);
    if (distance < nearest) nearest = distance, best.vertex = v;
  }
  return best;
}

double drawn_stress(const superelement::Superelement& se, const results::BodyHistory& body,
                    const Largest& most) {
  return StressField(se).von_mises(body.basis * body.modal.row(most.row).transpose())[most.vertex];
}

}  // namespace flexura::view
