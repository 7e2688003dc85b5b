// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/ancf_kinematics.hpp"

#include <Eigen/Geometry>
#include <stdexcept>

#include "beam/ancf/element/hermite.hpp"
#include "beam/ancf/element/strain.hpp"

namespace flexura::beam::ancf {

namespace {

// The slopes that fix a frame: r_x for lines (one column), r_y and r_z for beams (two).
using Slopes = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 2>;
using SpinMatrix = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6>;

// The shortest turn that takes the x axis to the unit vector e; about z where e is its opposite.
Eigen::Matrix3d shortest_turn_of_x(const Eigen::Vector3d& e) {
  constexpr double kOpposite = 1e-12;
  if (e.x() < -1.0 + kOpposite) return Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
  const Eigen::Matrix3d v = cross_matrix(Eigen::Vector3d::UnitX().cross(e));
  return Eigen::Matrix3d::Identity() + v + v * v / (1.0 + e.x());
}

// A section frame and its spin matrix A, w = A x_dot, with the directional derivative of A.
class Frame {
 public:
  Frame(const Slopes& x, const Slopes& x_rest, bool planar) : x_(x), planar_(planar) {
    if (x.cols() == 2)
      set_beam();
    else
      set_line(x_rest.col(0).normalized());
  }

  const Eigen::Matrix3d& R() const { return R_; }
  const SpinMatrix& A() const { return A_; }

  SpinMatrix rate(const Slopes& x_dot) const { return x_.cols() == 2 ? beam_rate(x_dot) : line_rate(x_dot); }

 private:
  void set_beam() {
    const Eigen::Vector3d y = x_.col(0), z = x_.col(1), n = y.cross(z);
    const Eigen::Vector3d e_x = n.normalized(), e_y = y.normalized(), e_z = e_x.cross(e_y);
    R_ << e_x, e_y, e_z;
    A_.resize(3, 6);
    A_.leftCols<3>() = (e_x * e_z.transpose() - e_z * e_x.transpose()) / y.norm() -
                       e_y * z.cross(e_z).transpose() / n.norm();
    A_.rightCols<3>() = -e_y * e_z.cross(y).transpose() / n.norm();
  }

  SpinMatrix beam_rate(const Slopes& x_dot) const {
    const Eigen::Vector3d y = x_.col(0), z = x_.col(1), n = y.cross(z);
    const Eigen::Vector3d y_dot = x_dot.col(0), z_dot = x_dot.col(1), n_dot = y_dot.cross(z) + y.cross(z_dot);
    const Eigen::Vector3d w = A_ * x_dot.reshaped();
    const Eigen::Vector3d e_x = R_.col(0), e_y = R_.col(1), e_z = R_.col(2);
    const Eigen::Vector3d d_x = w.cross(e_x), d_y = w.cross(e_y), d_z = w.cross(e_z);
    const double ly = y.norm(), ln = n.norm(), ly_dot = e_y.dot(y_dot), ln_dot = e_x.dot(n_dot);
    SpinMatrix out(3, 6);
    out.leftCols<3>() =
        (d_x * e_z.transpose() + e_x * d_z.transpose() - d_z * e_x.transpose() - e_z * d_x.transpose()) / ly -
        (e_x * e_z.transpose() - e_z * e_x.transpose()) * (ly_dot / (ly * ly)) -
        (d_y * z.cross(e_z).transpose() + e_y * (z_dot.cross(e_z) + z.cross(d_z)).transpose()) / ln +
        e_y * z.cross(e_z).transpose() * (ln_dot / (ln * ln));
    out.rightCols<3>() =
        -(d_y * e_z.cross(y).transpose() + e_y * (d_z.cross(y) + e_z.cross(y_dot)).transpose()) / ln +
        e_y * e_z.cross(y).transpose() * (ln_dot / (ln * ln));
    return out;
  }

  // Shortest rotation from the rest tangent e to t: w = t x t_dot - t (e x t) . t_dot / (1 + e.t).  In the
  // plane e x t is normal to it, so the second term vanishes for every t and is left out: no direction is
  // singular.
  void set_line(const Eigen::Vector3d& e) {
    const Eigen::Vector3d a = x_.col(0), t = a.normalized();
    e_ = e;
    A_ = cross_matrix(t) / a.norm();
    if (planar_) {
      R_ << t, Eigen::Vector3d(-t[1], t[0], 0), Eigen::Vector3d::UnitZ();
      return;
    }
    const double c = 1 + e.dot(t);
    if (c < 1e-8)
      throw std::runtime_error(
          "the section frame of a spatial line is undefined where its tangent has turned by 180 degrees; use "
          "a beam.");
    A_ -= t * e.cross(t).transpose() / (c * a.norm());
    const Eigen::Matrix3d v = cross_matrix(e.cross(t));
    const Eigen::Matrix3d turn = Eigen::Matrix3d::Identity() + v + v * v / c;
    R_ = turn * shortest_turn_of_x(e);
  }

  SpinMatrix line_rate(const Slopes& x_dot) const {
    const Eigen::Vector3d a = x_.col(0), t = a.normalized(), a_dot = x_dot.col(0);
    const double length = a.norm(), length_dot = t.dot(a_dot);
    const Eigen::Vector3d t_dot = (a_dot - t * length_dot) / length;
    Eigen::Matrix3d out = cross_matrix(t_dot);
    if (!planar_) {
      const Eigen::Vector3d h = e_.cross(t), h_dot = e_.cross(t_dot);
      const double c = 1 + e_.dot(t), c_dot = e_.dot(t_dot);
      out += -(t_dot * h.transpose() + t * h_dot.transpose()) / c + t * h.transpose() * (c_dot / (c * c));
    }
    return (out - A_ * length_dot) / length;
  }

  Slopes x_;
  bool planar_;
  Eigen::Vector3d e_ = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d R_;
  SpinMatrix A_;
};

// Shape functions of position and of the frame's slopes at a point.
struct PointShapes {
  Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 8> position;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2, 8> slopes;

  PointShapes(const AncfBody& body, const MaterialPoint& point) {
    const double xi = point.xi, l = body.element(point.element).length();
    const int m = body.vectors();
    const Shapes S = hermite(xi, l);
    position.setZero(2 * m);
    position[0] = S[0];
    position[1] = S[1];
    position[m] = S[2];
    position[m + 1] = S[3];
    slopes.setZero(m / 2, 2 * m);
    if (m == 2) {
      slopes.row(0) = hermite_x(xi, l);
    } else {
      slopes(0, 2) = slopes(1, 3) = 1 - xi;
      slopes(0, 6) = slopes(1, 7) = xi;
    }
  }

  Slopes slopes_of(const AncfBody& body, const double* e) const {
    const int d = body.dim();
    Slopes x = Slopes::Zero(3, slopes.rows());
    for (int i = 0; i < slopes.rows(); ++i)
      for (int s = 0; s < slopes.cols(); ++s)
        x.col(i).head(d) += slopes(i, s) * Eigen::Map<const Eigen::VectorXd>(e + d * s, d);
    return x;
  }
};

}  // namespace

PointKinematics evaluate_point(const AncfBody& body, const MaterialPoint& point, const Eigen::VectorXd& q,
                               const Eigen::VectorXd& v) {
  PointKinematics out;
  out.first = point.element * body.node_coordinates();
  const double *e = q.data() + out.first, *e_dot = v.data() + out.first;
  const int d = body.dim(), n_s = 2 * body.vectors();
  const PointShapes shapes(body, point);
  const Slopes x = shapes.slopes_of(body, e), x_dot = shapes.slopes_of(body, e_dot);
  const Frame frame(x, shapes.slopes_of(body, body.rest().data() + out.first), d == 2);
  out.R_WS = frame.R();
  out.w_WS_W = frame.A() * x_dot.reshaped();
  out.w_bias_W = frame.rate(x_dot) * x_dot.reshaped();
  out.J_v.setZero(3, d * n_s);
  out.J_w.setZero(3, d * n_s);
  for (int s = 0; s < n_s; ++s) {
    for (int c = 0; c < d; ++c) {
      const double S = shapes.position[s];
      out.J_v(c, d * s + c) = S;
      out.p_WoP_W[c] += S * e[d * s + c];
      out.v_WP_W[c] += S * e_dot[d * s + c];
      for (int i = 0; i < x.cols(); ++i)
        out.J_w.col(d * s + c) += shapes.slopes(i, s) * frame.A().col(3 * i + c);
    }
  }
  return out;
}

SectionForces section_forces(const AncfBody& body, int element, int k, const Eigen::VectorXd& q,
                             const Eigen::VectorXd& v) {
  const int first = element * body.node_coordinates();
  SectionForces out;
  out.s = body.element(element).resultants(q.data() + first, v.data() + first, k);
  out.at = {element, lobatto_rule()[k].xi};
  if (body.dim() == 3 && body.vectors() == 2)
    out.s.tail<3>() = evaluate_point(body, out.at, q, v).R_WS.transpose() * out.s.tail<3>().eval();
  return out;
}

void add_point_force(const AncfBody& body, const MaterialPoint& point, const Eigen::Vector3d& F_W,
                     VectorRef f) {
  const PointShapes shapes(body, point);
  const int d = body.dim(), first = point.element * body.node_coordinates();
  for (int s = 0; s < 2 * body.vectors(); ++s)
    f.segment(first + d * s, d) += shapes.position[s] * F_W.head(d);
}

void add_point_moment(const AncfBody& body, const MaterialPoint& point, const Eigen::VectorXd& q,
                      const Eigen::Vector3d& M_W, VectorRef f, Triplets* df_dq) {
  const PointShapes shapes(body, point);
  const int d = body.dim(), first = point.element * body.node_coordinates(), n_s = 2 * body.vectors();
  const Slopes x = shapes.slopes_of(body, q.data() + first);
  const Frame frame(x, shapes.slopes_of(body, body.rest().data() + first), d == 2);
  const Eigen::VectorXd f_x = frame.A().transpose() * M_W;
  for (int s = 0; s < n_s; ++s)
    for (int i = 0; i < x.cols(); ++i)
      f.segment(first + d * s, d) += shapes.slopes(i, s) * f_x.segment(3 * i, d);
  if (!df_dq) return;
  for (int j = 0; j < x.cols(); ++j)
    for (int c = 0; c < d; ++c) {
      Slopes direction = Slopes::Zero(3, x.cols());
      direction(c, j) = 1.0;
      const Eigen::VectorXd df_x = frame.rate(direction).transpose() * M_W;
      for (int t = 0; t < n_s; ++t)
        for (int s = 0; s < n_s; ++s)
          for (int i = 0; i < x.cols(); ++i)
            for (int r = 0; r < d; ++r) {
              const double value = shapes.slopes(i, s) * shapes.slopes(j, t) * df_x[3 * i + r];
              if (value != 0.0) df_dq->emplace_back(first + d * s + r, first + d * t + c, value);
            }
    }
}

}  // namespace flexura::beam::ancf
