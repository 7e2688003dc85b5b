// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/model/mesh.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace flexura::beam {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

int dof_of(const MeshElement& record, int local) {
  return 6 * record.node[local / 6] + local % 6;
}

void scatter(Triplets& triplets, const MeshElement& record, const Matrix12d& block) {
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      if (block(i, j) != 0.0) triplets.emplace_back(dof_of(record, i), dof_of(record, j), block(i, j));
}

SparseMatrix gather(const Triplets& triplets, int n) {
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// A point mass as moments of its distribution: u(c + r) = u + theta x (c + r); int r r^T dm = tr(I)/2 1 - I.
Eigen::Matrix3d second_moment(const PointMass& mass) {
  return 0.5 * mass.I_C_B.trace() * Eigen::Matrix3d::Identity() - mass.I_C_B;
}

Matrix6d mass_of(const PointMass& mass) {
  const Eigen::Matrix3d c = cross_matrix(mass.p_NC_B);
  Matrix6d M;
  M << mass.mass * Eigen::Matrix3d::Identity(), -mass.mass * c, mass.mass * c, mass.I_C_B - mass.mass * c * c;
  return 0.5 * (M + M.transpose());
}

}  // namespace

BeamMesh::BeamMesh(Model model, const Subdivision& rule) : model_(std::move(model)) {
  check(model_);
  for (const Node& node : model_.nodes) points_.push_back(node.p_BoN_B);
  for (std::size_t m = 0; m < model_.members.size(); ++m) {
    const Member& member = model_.members[m];
    const Placement whole = placement_of(model_, member);
    const int n = elements_of(model_, member, rule);
    constexpr int most = 500'000;  // a matrix of 3 million rows
    if (n > most - static_cast<int>(elements_.size()))
      throw std::invalid_argument(
          fmt::format("member \"{}\" makes it more than {} elements in all; give its "
                      "members fewer",
                      member.name, most));
    int previous = member.end[0].node;
    for (int k = 0; k < n; ++k) {
      MeshElement record;
      record.member = static_cast<int>(m);
      record.t_1 = static_cast<double>(k) / n;
      record.t_2 = static_cast<double>(k + 1) / n;
      record.placement = whole;
      record.placement.length = whole.length / n;
      record.placement.p_Bo1_B = whole.p_Bo1_B + record.t_1 * whole.length * whole.R_BE.col(0);
      if (k > 0) record.placement.offset_B[0].setZero();
      if (k < n - 1) record.placement.offset_B[1].setZero();
      record.node[0] = previous;
      if (k < n - 1) {
        record.node[1] = static_cast<int>(points_.size());
        points_.push_back(whole.p_Bo1_B + record.t_2 * whole.length * whole.R_BE.col(0));
      } else {
        record.node[1] = member.end[1].node;
      }
      previous = record.node[1];
      for (int dof = 0; dof < 6; ++dof) {
        if (k == 0) record.releases[dof] = member.end[0].released[dof];
        if (k == n - 1) record.releases[6 + dof] = member.end[1].released[dof];
      }
      elements_.push_back(record);
    }
  }
}

Element BeamMesh::element(const MeshElement& record) const {
  const Member& member = model_.members[record.member];
  const SectionEntry& first = model_.sections[member.section];
  try {
    if (member.section_at_end < 0)
      return Element(record.placement.length, matrices_of(first.section, member.theory), record.releases);
    const SectionEntry& second = model_.sections[member.section_at_end];
    const auto along = [&first, &second, &record, theory = member.theory](double t) {
      const Shape shape =
          interpolate(*first.shape, *second.shape, record.t_1 + t * (record.t_2 - record.t_1));
      const Material& material = *first.section.material;
      return matrices_of(
          make_section(first.section.name, constants_of(shape, material.nu(), first.formula), material),
          theory);
    };
    return Element(record.placement.length, along, record.releases);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("member \"{}\": {}", member.name, error.what()));
  }
}

SparseMatrix stiffness_matrix(const BeamMesh& mesh) {
  Triplets triplets;
  triplets.reserve(144 * mesh.elements().size());
  for (const MeshElement& record : mesh.elements()) {
    const Matrix12d T = record.placement.transform();
    const Matrix12d K = T.transpose() * mesh.element(record).stiffness() * T;
    scatter(triplets, record, 0.5 * (K + K.transpose()));
  }
  return gather(triplets, mesh.n_dofs());
}

Eigen::MatrixXd strain_energy(const BeamMesh& mesh, const Eigen::MatrixXd& U) {
  if (U.rows() != mesh.n_dofs())
    throw std::invalid_argument(
        fmt::format("{} displacements given, the beam mesh has {} dofs", U.rows(), mesh.n_dofs()));
  Eigen::MatrixXd energy = Eigen::MatrixXd::Zero(U.cols(), U.cols());
  for (const MeshElement& record : mesh.elements()) {
    const Element element = mesh.element(record);
    const Matrix6x12d map = element.stretch_map() * record.placement.transform();
    const Eigen::MatrixXd stretch = map.leftCols<6>() * U.middleRows<6>(6 * record.node[0]) +
                                    map.rightCols<6>() * U.middleRows<6>(6 * record.node[1]);
    const Eigen::MatrixXd resultants = element.stretch_stiffness() * stretch;
    energy.noalias() += stretch.transpose() * resultants;
  }
  return 0.5 * (energy + energy.transpose());
}

std::vector<std::string> accuracy_warnings(const BeamMesh& mesh) {
  std::vector<std::string> texts;
  std::vector<int> count(mesh.model().members.size(), 0);
  struct Extremes {
    double soft = std::numeric_limits<double>::infinity(), stiff = 0.0;
    int soft_member = -1, stiff_member = -1;
  };
  std::vector<Extremes> at_node(mesh.points().size());
  for (const MeshElement& record : mesh.elements()) {
    ++count[record.member];
    const Matrix12d K = mesh.element(record).stiffness();
    // Bending compares: stretch is always stiffer and does not spoil it.
    const double stiffness = std::max(std::max(K(4, 4), K(5, 5)), std::max(K(10, 10), K(11, 11)));
    if (!(stiffness > 0.0)) continue;
    for (const int node : record.node) {
      Extremes& e = at_node[node];
      if (stiffness < e.soft) e.soft = stiffness, e.soft_member = record.member;
      if (stiffness > e.stiff) e.stiff = stiffness, e.stiff_member = record.member;
    }
  }
  for (std::size_t m = 0; m < count.size(); ++m)
    if (count[m] >= 1000)
      texts.push_back(
          fmt::format("member \"{}\" has {} elements in a row: static displacements keep about {} digits; "
                      "fewer elements are more "
                      "accurate",
                      mesh.model().members[m].name, count[m],
                      count[m] < 3000    ? 5
                      : count[m] < 10000 ? 4
                                         : 1));
  for (const Extremes& e : at_node)
    if (e.stiff > 1e8 * e.soft) {
      texts.push_back(fmt::format(
          "members \"{}\" and \"{}\" meet with bending stiffnesses {:.0e} times apart: displacements keep "
          "about {} digits; "
          "a rigid end offset does what an almost rigid member is meant to do",
          mesh.model().members[e.stiff_member].name, mesh.model().members[e.soft_member].name,
          e.stiff / e.soft, std::max(0, 15 - static_cast<int>(std::ceil(std::log10(e.stiff / e.soft))))));
      break;  // the first says it
    }
  return texts;
}

SparseMatrix mass_matrix(const BeamMesh& mesh, bool rotary_inertia) {
  Triplets triplets;
  triplets.reserve(144 * mesh.elements().size());
  for (const MeshElement& record : mesh.elements()) {
    const Matrix12d T = record.placement.transform();
    const Matrix12d M = T.transpose() * mesh.element(record).mass(rotary_inertia) * T;
    scatter(triplets, record, 0.5 * (M + M.transpose()));
  }
  for (const PointMass& mass : mesh.model().point_masses) {
    const Matrix6d M = mass_of(mass);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) triplets.emplace_back(6 * mass.node + i, 6 * mass.node + j, M(i, j));
  }
  return gather(triplets, mesh.n_dofs());
}

InertiaSums inertia_sums(const BeamMesh& mesh) {
  constexpr std::array<std::array<int, 2>, 6> pairs = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};
  InertiaSums sums;
  sums.S_u = Eigen::Matrix3Xd::Zero(3, mesh.n_dofs());
  sums.S_xu = Eigen::MatrixXd::Zero(9, mesh.n_dofs());
  std::array<Triplets, 6> triplets;
  for (const MeshElement& record : mesh.elements()) {
    const InertiaBlocks blocks = mesh.element(record).inertia_blocks(record.placement);
    sums.mass += blocks.mass;
    sums.S_x += blocks.S_x;
    sums.S_xx += blocks.S_xx;
    for (int i = 0; i < 12; ++i) {
      sums.S_u.col(dof_of(record, i)) += blocks.S_phi.col(i);
      sums.S_xu.col(dof_of(record, i)) += blocks.S_xphi.col(i);
    }
    for (int k = 0; k < 6; ++k) scatter(triplets[k], record, blocks.S_phiphi[k]);
  }
  for (const PointMass& mass : mesh.model().point_masses) {
    const Eigen::Vector3d p = mesh.points()[mass.node] + mass.p_NC_B;
    const Eigen::Matrix3d second = second_moment(mass);
    sums.mass += mass.mass;
    sums.S_x += mass.mass * p;
    sums.S_xx += mass.mass * p * p.transpose() + second;
    // u = V_0 q + sum_j r_j V_j q with r the place in the body, V_0 at its centre: theta x c = -[c] theta.
    std::array<Eigen::Matrix<double, 3, 6>, 4> V;
    V[0] << Eigen::Matrix3d::Identity(), -cross_matrix(mass.p_NC_B);
    for (int j = 0; j < 3; ++j) V[j + 1] << Eigen::Matrix3d::Zero(), -cross_matrix(Eigen::Vector3d::Unit(j));
    const auto columns = Eigen::seqN(6 * mass.node, 6);
    sums.S_u(Eigen::all, columns) += mass.mass * V[0];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        sums.S_xu(3 * a + b, columns) += mass.mass * p(a) * V[0].row(b);
        for (int j = 0; j < 3; ++j) sums.S_xu(3 * a + b, columns) += second(a, j) * V[j + 1].row(b);
      }
    for (int k = 0; k < 6; ++k) {
      const auto [a, b] = pairs[k];
      Matrix6d block = mass.mass * V[0].row(a).transpose() * V[0].row(b);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) block += second(i, j) * V[i + 1].row(a).transpose() * V[j + 1].row(b);
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
          if (block(i, j) != 0.0) triplets[k].emplace_back(6 * mass.node + i, 6 * mass.node + j, block(i, j));
    }
  }
  for (int k = 0; k < 6; ++k) sums.S_uu[k] = gather(triplets[k], mesh.n_dofs());
  return sums;
}

}  // namespace flexura::beam
