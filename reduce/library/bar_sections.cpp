// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/bar_sections.hpp"

#include "reduce/assembly/input/rigid_motion.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Matrix12Xd = Eigen::Matrix<double, 12, Eigen::Dynamic>;

constexpr int kPlaces = 4;
constexpr int kMy = 4, kMz = 5, kVy = 1, kVz = 2;

// 6 x k: the resultants at the share t of the bar by forces f on its ends.
MatrixXd cut_at(double t, double length, const Matrix12Xd& f) {
  const MatrixXd s_1 = -f.topRows<6>(), s_2 = f.bottomRows<6>();
  MatrixXd s = (1.0 - t) * s_1 + t * s_2;
  const double h_2 = length * t * (1.0 - t) * (1.0 - t), h_4 = -length * t * t * (1.0 - t),
               h_3 = t * t * (3.0 - 2.0 * t);
  s.row(kMy) = (1.0 - h_3) * s_1.row(kMy) + h_3 * s_2.row(kMy) + h_2 * s_1.row(kVz) + h_4 * s_2.row(kVz);
  s.row(kMz) = (1.0 - h_3) * s_1.row(kMz) + h_3 * s_2.row(kMz) - h_2 * s_1.row(kVy) - h_4 * s_2.row(kVy);
  return s;
}

// The part's rigid motions in its interface dofs, n_b x 6.
MatrixXd rigid_motions(const Reduction& reduction) {
  MatrixXd R(reduction.n_b, 6);
  for (const ReducedInterface& interface : reduction.interfaces)
    R.middleRows(interface.first_dof, std::ssize(interface.directions)) =
        node_motion_at(interface.point)(interface.directions, Eigen::all);
  return R;
}

// Columns of BarMotions::lacks as those of e_b, then of x_a e_b in 3 + 3 a + b.  The antisymmetric half of a field x_a e_b is a
// rotation, and rigid motions are interface shapes.
MatrixXd lacks_of_position(const Reduction& reduction) {
  const MatrixXd& lacks = reduction.bars->lacks;
  const MatrixXd rigid = lacks.middleCols(6, reduction.n_b) * rigid_motions(reduction);
  constexpr int pair[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  MatrixXd out(lacks.rows(), 12);
  out.leftCols<3>() = rigid.leftCols<3>();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      auto column = out.col(3 + 3 * a + b);
      column = lacks.col(pair[a][b]);
      if (a == b) continue;
      const double way = b == (a + 1) % 3 ? 1.0 : -1.0;  // e_z x x = x e_y - y e_x
      column = 0.5 * (column + way * rigid.col(3 + (3 - a - b)));
    }
  return out;
}

}  // namespace

std::optional<superelement::SectionForces> bar_sections(const Part& part, const Reduction& reduction,
                                                        const std::vector<LoadField>& loads) {
  if (!reduction.bars || part.bars.empty()) return {};
  const BarMotions& motions = *reduction.bars;
  const Index n = motions.nodes.cols(), n_p = kPlaces * std::ssize(part.bars), n_b = reduction.n_b;
  const auto n_loads = static_cast<Index>(loads.size());
  const bool whole = motions.lacks.cols() > 0;
  superelement::SectionForces out;
  out.positions.resize(n_p, 3);
  out.axes.resize(n_p, 9);
  out.S.resize(6 * n_p, n);
  MatrixXd of_position;
  if (whole) {
    of_position = lacks_of_position(reduction);
    out.of_acceleration.resize(6 * n_p, 12);
    out.of_deformation.resize(6 * n_p, 9 * n);
    out.turning.resize(3 * n_p, n);
    if (n_loads > 0) out.of_loads.resize(6 * n_p, n_loads);
  }
  Index p = 0, first_point = 0;
  for (std::size_t i = 0; i < part.bars.size(); ++i) {
    const CutBar& bar = part.bars[i];
    const Index row = 12 * static_cast<Index>(i);
    const MatrixXd q = motions.nodes.middleRows<12>(row);
    const Matrix12Xd f = bar.ends * q;
    Matrix12Xd f_position, f_deformation, f_loads;
    if (whole) {
      const auto lacks = motions.lacks.middleRows<12>(row);
      f_position = bar.ends * of_position.middleRows<12>(row);
      f_loads = bar.ends * lacks.rightCols(n_loads);
      f_deformation.setZero(12, 9 * n);
      // Of accelerated shapes: their inertia deforms the interior as one field, whose three directions share it.  Normal modes
      // are answered by themselves, so that the shapes lack nothing.
      const Matrix12Xd f_shapes = bar.ends * lacks.middleCols(6, n_b) / 3.0;
      for (Index k = 0; k < n_b; ++k)
        for (Index a = 0; a < 3; ++a) f_deformation.col(9 * k + 4 * a) = f_shapes.col(k);
      for (std::size_t g = 0; g < bar.masses.size(); ++g) {
        const CutBar::Mass& mass = bar.masses[g];
        const Eigen::Matrix<double, 12, 3> on_ends = mass.mass * mass.on_ends;
        const Eigen::Vector3d x = part.mesh.points.row(mass.point);
        const auto phi = motions.points.middleRows<3>(3 * (first_point + static_cast<Index>(g)));
        f_position.leftCols<3>() += on_ends;
        for (Index a = 0; a < 3; ++a) f_position.middleCols<3>(3 + 3 * a) += x(a) * on_ends;
        for (Index k = 0; k < n; ++k)
          for (Index a = 0; a < 3; ++a) f_deformation.middleCols<3>(9 * k + 3 * a) += phi(a, k) * on_ends;
        for (Index l = 0; l < n_loads; ++l)
          if (const auto& field = loads[static_cast<std::size_t>(l)].acceleration; field.rows() > 0)
            f_loads.col(l) -= on_ends * field.row(mass.point).transpose();
      }
    }
    first_point += std::ssize(bar.masses);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_BE = bar.R_BE;
    for (std::size_t place = 0; place < kPlaces; ++place, ++p) {
      const double t = static_cast<double>(place) / (kPlaces - 1);
      out.member.push_back(static_cast<std::int32_t>(i));
      out.positions.row(p) = (bar.p_Bo1_B + t * bar.length * bar.R_BE.col(0)).transpose();
      out.axes.row(p) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(R_BE.data());
      out.S.middleRows<6>(6 * p) = cut_at(t, bar.length, f);
      if (!whole) continue;
      out.of_acceleration.middleRows<6>(6 * p) = cut_at(t, bar.length, f_position);
      out.of_deformation.middleRows<6>(6 * p) = cut_at(t, bar.length, f_deformation).cast<float>();
      out.turning.middleRows<3>(3 * p) = bar.turning[place] * q;
      if (n_loads > 0) out.of_loads.middleRows<6>(6 * p) = cut_at(t, bar.length, f_loads);
    }
    out.members.push_back(bar.name);
  }
  return out;
}

}  // namespace flexura::reduce
