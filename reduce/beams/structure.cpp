// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/structure.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Triplets = std::vector<Eigen::Triplet<double>>;

void add_entries(Triplets& triplets, const beam::SparseMatrix& A) {
  for (int column = 0; column < A.outerSize(); ++column)
    for (beam::SparseMatrix::InnerIterator it(A, column); it; ++it)
      triplets.emplace_back(it.row(), column, it.value());
}

void add_entries(Triplets& triplets, const MatrixXd& block, const std::vector<int>& dofs) {
  for (std::size_t i = 0; i < dofs.size(); ++i)
    for (std::size_t j = 0; j < dofs.size(); ++j)
      if (block(i, j) != 0.0) triplets.emplace_back(dofs[i], dofs[j], block(i, j));
}

// A beam matrix with the solids' blocks added; block(solid) is n x n.
template <class Block>
beam::SparseMatrix with_solids(const Structure& structure, const beam::SparseMatrix& beams, Block&& block) {
  Triplets triplets;
  triplets.reserve(beams.nonZeros());
  add_entries(triplets, beams);
  for (std::size_t k = 0; k < structure.solids().size(); ++k)
    add_entries(triplets, block(structure.solids()[k].reduction),
                structure.dofs_of_solid(static_cast<int>(k)));
  beam::SparseMatrix sum(structure.n_dofs(), structure.n_dofs());
  sum.setFromTriplets(triplets.begin(), triplets.end());
  return sum;
}

}  // namespace

Structure::Structure(beam::BeamMesh mesh, std::vector<AttachedSolid> solids, std::vector<NodeLink> links,
                     bool fine_outlines)
    : mesh_(std::move(mesh)),
      solids_(std::move(solids)),
      links_(std::move(links)),
      n_dofs_(mesh_.n_dofs()),
      beams_(beam::extruded_surface(mesh_, 8, 40000, fine_outlines)) {
  used_.assign(mesh_.n_dofs(), false);
  const auto use = [this](int node) { std::fill_n(used_.begin() + 6 * node, 6, true); };
  for (const beam::MeshElement& element : mesh_.elements())
    for (const int node : element.node) use(node);
  for (const AttachedSolid& solid : solids_) {
    std::vector<int> dofs;
    for (std::size_t k = 0; k < solid.reduction.interfaces.size(); ++k) {
      const ReducedInterface& interface = solid.reduction.interfaces[k];
      const int node = solid.node.at(k);
      if (interface.directions.size() != 6)
        throw std::invalid_argument(
            fmt::format("solid \"{}\", interface \"{}\": a beam needs all six directions there", solid.name,
                        interface.name));
      if ((mesh_.points().at(node) - interface.point).norm() > 1e-9 * (1.0 + interface.point.norm()))
        throw std::invalid_argument(fmt::format("solid \"{}\", interface \"{}\" does not lie at node \"{}\"",
                                                solid.name, interface.name,
                                                mesh_.model().nodes.at(node).name));
      use(node);
      for (int direction = 0; direction < 6; ++direction) dofs.push_back(6 * node + direction);
    }
    for (int q = 0; q < solid.reduction.n_q; ++q) dofs.push_back(n_dofs_++);
    dofs_.push_back(std::move(dofs));
  }
  used_.resize(n_dofs_, true);
  for (const NodeLink& link : links_)
    for (const int node : link.node)
      if (!used_.at(6 * node))
        throw std::invalid_argument(fmt::format("link \"{}\": node \"{}\" belongs to no member and no solid",
                                                link.name, mesh_.model().nodes.at(node).name));

  picture_ = {beams_.vertices, beams_.triangles, beams_.edges};
  for (const AttachedSolid& solid : solids_) {
    if (solid.picture.vertices.rows() != 0 &&
        solid.reduction.shapes.rows() != 3 * solid.picture.vertices.rows())
      throw std::invalid_argument(fmt::format("solid \"{}\" has shapes at {} places for {} vertices",
                                              solid.name, solid.reduction.shapes.rows() / 3,
                                              solid.picture.vertices.rows()));
    const auto append = [](auto& to, const auto& from, int shift) {
      const Index n = to.rows();
      to.conservativeResize(n + from.rows(), Eigen::NoChange);
      to.bottomRows(from.rows()) = from.array() + shift;
    };
    const int first = static_cast<int>(picture_.vertices.rows());
    append(picture_.vertices, solid.picture.vertices, 0);
    append(picture_.triangles, solid.picture.triangles, first);
    append(picture_.edges, solid.picture.edges, first);
  }
}

beam::SparseMatrix Structure::stiffness() const {
  beam::SparseMatrix K =
      with_solids(*this, beam::stiffness_matrix(mesh_), [](const Reduction& r) { return r.K_se; });
  if (links_.empty()) return K;
  Triplets triplets;
  add_entries(triplets, K);
  for (const NodeLink& link : links_) {
    std::vector<int> dofs;
    for (const int node : link.node)
      for (int d = 0; d < 3; ++d) dofs.push_back(6 * node + d);
    Eigen::Matrix<double, 3, 6> relative;
    const Eigen::Matrix3d along = directions(link);
    relative << -along, along;
    add_entries(triplets, link.stiffness * relative.transpose() * relative, dofs);
  }
  K.setFromTriplets(triplets.begin(), triplets.end());
  return K;
}

Eigen::Matrix3d Structure::directions(const NodeLink& link) const {
  const Eigen::Vector3d &a = mesh_.points()[link.node[0]], &b = mesh_.points()[link.node[1]];
  const Eigen::Vector3d line = b - a;
  // Closer than round-off of coordinates tells no direction.
  if (line.norm() <= 1e-12 * (a.norm() + b.norm())) return Eigen::Matrix3d::Identity();
  return line * line.transpose() / line.squaredNorm();
}

MatrixXd Structure::stretch(const NodeLink& link, const MatrixXd& U) const {
  return directions(link) * (U.middleRows<3>(6 * link.node[1]) - U.middleRows<3>(6 * link.node[0]));
}

MatrixXd Structure::damping(const MatrixXd& U) const {
  MatrixXd D;
  const auto add = [&](const MatrixXd& some) {
    if (D.size() == 0) D.setZero(U.cols(), U.cols());
    D += 0.5 * (some + some.transpose());
  };
  for (const NodeLink& link : links_) {
    const MatrixXd rate = stretch(link, U);
    if (link.damping > 0.0) add(link.damping * rate.transpose() * rate);
  }
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    const MatrixXd& D_se = solids_[s].reduction.D_se;
    if (D_se.size() == 0) continue;
    const MatrixXd part = U(dofs_[s], Eigen::all);
    add(part.transpose() * (D_se * part));
  }
  return D;
}

beam::SparseMatrix Structure::mass(bool rotary_inertia) const {
  return with_solids(*this, beam::mass_matrix(mesh_, rotary_inertia),
                     [](const Reduction& r) { return r.M_se; });
}

beam::InertiaSums Structure::inertia() const {
  beam::InertiaSums sums = beam::inertia_sums(mesh_);
  if (solids_.empty()) return sums;
  const Index n_beams = mesh_.n_dofs(), n_modes = n_dofs_ - n_beams;
  const auto widen = [&](auto& matrix) {
    matrix.conservativeResize(Eigen::NoChange, n_dofs_);
    matrix.rightCols(n_modes).setZero();
  };
  widen(sums.S_u);
  widen(sums.S_xu);
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    const InertiaIntegrals& solid = solids_[s].reduction.inertia;
    sums.mass += solid.mass;
    sums.S_x += solid.S_x;
    sums.S_xx += solid.S_xx;
    for (std::size_t k = 0; k < dofs_[s].size(); ++k) {
      sums.S_u.col(dofs_[s][k]) += solid.S_phi.col(k);
      sums.S_xu.col(dofs_[s][k]) += solid.S_xphi.col(k);
    }
  }
  for (int pair = 0; pair < 6; ++pair)
    sums.S_uu[pair] =
        with_solids(*this, sums.S_uu[pair], [pair](const Reduction& r) { return r.inertia.S_phiphi[pair]; });
  return sums;
}

MatrixXd Structure::strain_energy(const MatrixXd& U) const {
  MatrixXd energy = beam::strain_energy(mesh_, U.topRows(mesh_.n_dofs()));
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    const MatrixXd part = U(dofs_[s], Eigen::all);
    energy += part.transpose() * (solids_[s].reduction.K_se * part);
  }
  for (const NodeLink& link : links_) {
    const MatrixXd part = stretch(link, U);
    energy += link.stiffness * part.transpose() * part;
  }
  return 0.5 * (energy + energy.transpose());
}

std::string Structure::describe(int dof) const {
  static const std::array<const char*, 6> names = {"x", "y", "z", "about x", "about y", "about z"};
  for (std::size_t s = 0; s < solids_.size(); ++s)
    if (dof >= mesh_.n_dofs() && dof <= dofs_[s].back())
      return fmt::format("a mode of the solid \"{}\"", solids_[s].name);
  const int node = dof / 6, named = static_cast<int>(mesh_.model().nodes.size());
  const std::string place = node < named
                                ? fmt::format("node \"{}\"", mesh_.model().nodes[node].name)
                                : fmt::format("the beam at ({:g}, {:g}, {:g})", mesh_.points()[node].x(),
                                              mesh_.points()[node].y(), mesh_.points()[node].z());
  return fmt::format("{}, {}", place, names[dof % 6]);
}

Eigen::MatrixXf Structure::shapes(const MatrixXd& U) const {
  Eigen::MatrixXf shapes(3 * picture_.vertices.rows(), U.cols());
  const Index n_v = beams_.vertices.rows();
  for (Index v = 0; v < n_v; ++v) {
    const beam::MeshElement& element = mesh_.elements()[beams_.element[v]];
    const MatrixXd rows = beams_.at[v].leftCols<6>() * U.middleRows<6>(6 * element.node[0]) +
                          beams_.at[v].rightCols<6>() * U.middleRows<6>(6 * element.node[1]);
    shapes.middleRows<3>(3 * v) = rows.cast<float>();
  }
  Index row = 3 * n_v;
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (solids_[s].picture.vertices.rows() == 0) continue;
    const Eigen::MatrixXf part = MatrixXd(U(dofs_[s], Eigen::all)).cast<float>();
    shapes.middleRows(row, solids_[s].reduction.shapes.rows()) = solids_[s].reduction.shapes * part;
    row += solids_[s].reduction.shapes.rows();
  }
  return shapes;
}

}  // namespace flexura::reduce
