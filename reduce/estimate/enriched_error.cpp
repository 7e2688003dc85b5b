// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "reduce/assembly/rigid_motion.hpp"
#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/enrichment.hpp"
#include "reduce/linalg/cell_products.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using mesh::CellType;

namespace {

// An edge by its two corners, a face by its three lowest: no two faces of a mesh share three.
using Key = std::array<mesh::Index, 3>;
constexpr mesh::Index kGained = -1, kOwn = -2;  // on an edge, in place of a third corner

Key key_of(const EnrichmentFunction& f, const mesh::CellBlock& block, Index row) {
  std::array<mesh::Index, 4> nodes{};
  int n = 0;
  for (const int corner : f.corners)
    if (corner >= 0) nodes[static_cast<std::size_t>(n++)] = block.nodes(row, corner);
  std::sort(nodes.begin(), nodes.begin() + n);
  return n == 2 ? Key{nodes[0], nodes[1], kGained} : Key{nodes[0], nodes[1], nodes[2]};
}

float sign_of(const EnrichmentFunction& f, const mesh::CellBlock& block, Index row) {
  return f.odd && block.nodes(row, f.corners[0]) > block.nodes(row, f.corners[1]) ? -1.0f : 1.0f;
}

// A cell type's own functions and those it gains, at the points of a rule.
struct Tables {
  const TabulatedRule* rule;
  std::vector<EnrichmentValues> gained;
};

Tables tables_of(const TabulatedRule& rule, CellType type) {
  Tables out{&rule, {}};
  for (const TabulatedRule::Point& point : rule.points)
    out.gained.push_back(evaluate_enrichment(type, point.xi));
  return out;
}

// What a cell needs: A (3 n x 3 n) of the gained functions and, after them, its own, in single precision; the residual of
// displacements u (3 m x k) in the gained ones.
class CellMatrices {
 public:
  void compute(const Tables& tables, const NodePositions& x, const Matrix6& U, double density) {
    const auto n_points = static_cast<Index>(tables.rule->points.size());
    const Index m = x.rows(), n = tables.gained.front().w.size();
    G_w_.resize(6 * n_points, 3 * n);
    G_v_.resize(6 * n_points, 3 * m);
    mass_.setZero(n, m);
    for (Index q = 0; q < n_points; ++q) {
      const TabulatedRule::Point& point = tables.rule->points[static_cast<std::size_t>(q)];
      const EnrichmentValues& gained = tables.gained[static_cast<std::size_t>(q)];
      const Eigen::Matrix3d J = point.dN.transpose() * x;
      const double det = std::max(J.determinant(), 0.0);
      const Eigen::Matrix3d to_space =
          det > 0.0 ? Eigen::Matrix3d(J.inverse().transpose()) : Eigen::Matrix3d::Zero();
      const Matrix6 root = std::sqrt(point.weight * det) * U;
      for (Index a = 0; a < m; ++a)
        G_v_.block<6, 3>(6 * q, 3 * a).noalias() =
            root * strain_operator(Eigen::RowVector3d(point.dN.row(a) * to_space));
      for (Index a = 0; a < n; ++a)
        G_w_.block<6, 3>(6 * q, 3 * a).noalias() =
            root * strain_operator(Eigen::RowVector3d(gained.dw.row(a) * to_space));
      mass_.noalias() += (density * point.weight * det) * gained.w * point.N.transpose();
    }
    G_.resize(G_w_.rows(), 3 * (n + m));
    G_.leftCols(3 * n) = G_w_.cast<float>();
    G_.rightCols(3 * m) = G_v_.cast<float>();
    A.setZero(G_.cols(), G_.cols());
    linalg::add_gram(G_.data(), static_cast<int>(G_.rows()), static_cast<int>(G_.cols()), A.data());
  }
  // lambda m(u, w) - a(u, w); rigid motions cancel in the strains, in double precision.
  MatrixXd residual(const MatrixXd& u, const Eigen::VectorXd& lambda) const {
    MatrixXd r = -(G_w_.transpose() * MatrixXd(G_v_ * u));
    const MatrixXd a = u * lambda.asDiagonal();
    for (Index f = 0; f < mass_.rows(); ++f)
      for (Index k = 0; k < mass_.cols(); ++k) r.middleRows<3>(3 * f) += mass_(f, k) * a.middleRows<3>(3 * k);
    return r;
  }

  Eigen::MatrixXf A;

 private:
  MatrixXd G_w_, G_v_, mass_;
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> G_;
};

}  // namespace

bool EnrichedError::suits(const Part& part) {
  if (part.matrices || part.mesh.solids.empty()) return false;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    if (enrichment_of(block.type).empty()) return false;
    const Formulation formulation = formulation_of(block, part.formulation);
    if (&solid_element(block.type, formulation) != &solid_element(block.type)) return false;
  }
  for (const InterfaceSpec& interface : part.interfaces)
    if (interface.tie == Tie::elastic) return false;
  // Two matrices for each cell; a model for which they are much beside its factor is judged by its stresses.
  constexpr double kMostBytes = 4e9;
  double bytes = 0.0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const double n = 3.0 * static_cast<double>(enrichment_of(block.type).size() + block.nodes.cols());
    bytes += 2.0 * sizeof(float) * n * n * static_cast<double>(block.nodes.rows());
  }
  return bytes < kMostBytes;
}

EnrichedError::EnrichedError(const Part& part, const MatrixXd& T, const JudgedStates& states,
                             const linalg::Progress& progress)
    : part_(part) {
  linalg::report(progress, "mesh error", 0.0);
  number_functions();
  leave_out_rigid_faces();
  compute_cells(linalg::times(T, states.Y), states.lambda, progress);
  if (states.force.size() > 0) add_tractions(states.force);
  weigh_shared_functions();
  const Index k = states.Y.cols();
  energy_.energy.setZero(k);
  energy_.by_cell.setZero(static_cast<Index>(cells_.size()), k);
  const auto n_panels = static_cast<int>((k + kWidth - 1) / kWidth);
  linalg::parallel_for(n_panels, [&](int panel) { solve(static_cast<Index>(panel) * kWidth); });
  // What the degrees after the next add (docs/mesh_error.md).
  constexpr double kBeyond = 1.2;
  const bool quadratic = std::all_of(part.mesh.solids.begin(), part.mesh.solids.end(),
                                     [](const mesh::CellBlock& block) { return is_quadratic(block.type); });
  if (quadratic) {
    energy_.energy *= kBeyond;
    energy_.by_cell *= static_cast<float>(kBeyond);
  }
  linalg::report(progress, "mesh error", 1.0);
}

void EnrichedError::number_functions() {
  std::vector<std::pair<Key, std::size_t>> keys;
  std::size_t entries = 0;
  for (std::size_t b = 0; b < part_.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = part_.mesh.solids[b];
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    const std::size_t n = functions.size() + static_cast<std::size_t>(block.nodes.cols());
    for (Index row = 0; row < block.nodes.rows(); ++row) {
      cells_.push_back({static_cast<int>(b), row, keys.size(), entries, static_cast<int>(functions.size()),
                        static_cast<int>(n)});
      entries += 9 * n * n;
      for (const EnrichmentFunction& f : functions) {
        keys.emplace_back(key_of(f, block, row), keys.size());
        sign_.push_back(sign_of(f, block, row));
      }
      for (std::size_t a = 0; a < static_cast<std::size_t>(block.nodes.cols()); ++a) {
        keys.emplace_back(Key{block.nodes(row, static_cast<Index>(a)), kOwn, kOwn}, keys.size());
        sign_.push_back(1.0f);
      }
    }
  }
  functions_.resize(keys.size());
  K_.resize(entries);
  B_.resize(entries);
  std::sort(keys.begin(), keys.end());
  // Numbers follow the cells, so that products run through memory in order.
  std::vector<int> group(keys.size());
  int n_groups = 0;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k > 0 && keys[k].first != keys[k - 1].first) ++n_groups;
    group[keys[k].second] = n_groups;
  }
  std::vector<int> number(static_cast<std::size_t>(n_groups) + 1, -1);
  for (std::size_t k = 0; k < group.size(); ++k) {
    int& of_group = number[static_cast<std::size_t>(group[k])];
    if (of_group < 0) of_group = n_functions_++;
    functions_[k] = of_group;
  }
}

// Functions all of whose corners follow a rigid interface.
void EnrichedError::leave_out_rigid_faces() {
  std::vector<int> tie_of(static_cast<std::size_t>(part_.mesh.n_nodes()), -1);
  bool any = false;
  for (std::size_t k = 0; k < part_.interfaces.size(); ++k) {
    if (part_.interfaces[k].tie != Tie::rigid) continue;
    any = true;
    for (const mesh::Index node : part_.interfaces[k].set.nodes)
      tie_of[static_cast<std::size_t>(node)] = static_cast<int>(k);
  }
  if (!any) return;
  std::vector<char> out(static_cast<std::size_t>(n_functions_), 0);
  for (const Cell& cell : cells_) {
    const mesh::CellBlock& block = part_.mesh.solids[static_cast<std::size_t>(cell.block)];
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    const auto tie = [&](Index a) { return tie_of[static_cast<std::size_t>(block.nodes(cell.row, a))]; };
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      const int first = tie(functions[f].corners[0]);
      bool follows = first >= 0;
      for (const int corner : functions[f].corners) follows = follows && (corner < 0 || tie(corner) == first);
      // The middle of an edge between two tied corners may lie off the face.
      if (follows && f < shape.edges.size() && block.nodes.cols() > shape.corners)
        follows = tie(shape.corners + static_cast<Index>(f)) == first;
      if (follows) out[static_cast<std::size_t>(functions_[cell.first_function + f])] = 1;
    }
    for (int f = cell.n_gained; f < cell.n; ++f)
      if (tie(f - cell.n_gained) >= 0)
        out[static_cast<std::size_t>(functions_[cell.first_function + static_cast<std::size_t>(f)])] = 1;
  }
  for (int& function : functions_)
    if (out[static_cast<std::size_t>(function)]) function = -1;
}

void EnrichedError::compute_cells(const MatrixXd& U, const Eigen::VectorXd& lambda,
                                  const linalg::Progress& progress) {
  const Index n = U.cols();
  R_.setZero(3 * static_cast<Index>(n_functions_), n);
  std::vector<Matrix6> roots;
  for (const Material& material : part_.materials)
    roots.emplace_back(Eigen::LLT<Matrix6>(0.5 * (material.D + material.D.transpose())).matrixU());
  std::vector<Tables> tables;
  for (const mesh::CellBlock& block : part_.mesh.solids)
    tables.push_back(tables_of(solid_element(block.type).mass, block.type));
  // Batches of cells on all cores, added up in the order of the cells: the same to the bit with any number of threads.
  constexpr int kBatch = 512, kChunks = 16;
  const auto n_cells = static_cast<int>(cells_.size());
  std::vector<MatrixXd> residual(kBatch);
  for (int first = 0; first < n_cells; first += kBatch) {
    const int count = std::min(kBatch, n_cells - first);
    linalg::parallel_for(kChunks, [&](int chunk) {
      CellMatrices matrices;
      for (int k = chunk * count / kChunks; k < (chunk + 1) * count / kChunks; ++k) {
        const Cell& cell = cells_[static_cast<std::size_t>(first + k)];
        const mesh::CellBlock& block = part_.mesh.solids[static_cast<std::size_t>(cell.block)];
        const NodePositions x = positions(part_.mesh, block, cell.row);
        const std::size_t material = material_of(block, cell.row);
        matrices.compute(tables[static_cast<std::size_t>(cell.block)], x, roots[material],
                         part_.materials[material].density);
        MatrixXd u(3 * x.rows(), n);
        for (Index a = 0; a < x.rows(); ++a)
          u.middleRows<3>(3 * a) = U.middleRows<3>(3 * static_cast<Index>(block.nodes(cell.row, a)));
        MatrixXd& r = residual[static_cast<std::size_t>(k)];
        r = matrices.residual(u, lambda);
        Eigen::MatrixXf& A = matrices.A;
        for (int f = 0; f < cell.n; ++f) {
          const auto at = cell.first_function + static_cast<std::size_t>(f);
          if (functions_[at] < 0) {
            // Stands alone and gets no load.
            A.middleRows<3>(3 * f).setZero();
            A.middleCols<3>(3 * f).setZero();
            A.block<3, 3>(3 * f, 3 * f).setIdentity();
          } else if (sign_[at] < 0.0f) {
            A.middleRows<3>(3 * f) *= -1;
            A.middleCols<3>(3 * f) *= -1;
            r.middleRows<3>(3 * f) *= -1;
          }
        }
        Eigen::Map<Eigen::MatrixXf>(K_.data() + cell.first_entry, 3 * cell.n, 3 * cell.n) = A;
      }
    });
    for (int k = 0; k < count; ++k) {
      const Cell& cell = cells_[static_cast<std::size_t>(first + k)];
      for (int f = 0; f < cell.n_gained; ++f) {
        const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
        if (function >= 0)
          R_.middleRows<3>(3 * static_cast<Index>(function)) +=
              residual[static_cast<std::size_t>(k)].middleRows<3>(3 * f).cast<float>();
      }
    }
    linalg::report(progress, "mesh error", 0.4 * (first + count) / n_cells);
  }
}

// The linear traction of an averaging tie (average.hpp) does work on the functions of its faces.
void EnrichedError::add_tractions(const MatrixXd& force_b) {
  std::map<Key, int> numbers;  // of the functions on averaged faces
  std::vector<char> averaged(static_cast<std::size_t>(part_.mesh.n_nodes()), 0);
  const auto by_faces = [](const InterfaceSpec& interface) {
    return interface.tie == Tie::average && interface.weights.empty() && !interface.set.faces.empty();
  };
  for (const InterfaceSpec& interface : part_.interfaces)
    if (by_faces(interface))
      for (const mesh::Index node : interface.set.nodes) averaged[static_cast<std::size_t>(node)] = 1;
  for (const Cell& cell : cells_) {
    const mesh::CellBlock& block = part_.mesh.solids[static_cast<std::size_t>(cell.block)];
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      bool all = true;
      for (const int corner : functions[f].corners)
        all = all && (corner < 0 || averaged[static_cast<std::size_t>(block.nodes(cell.row, corner))]);
      if (all) numbers[key_of(functions[f], block, cell.row)] = functions_[cell.first_function + f];
    }
  }
  Index first_dof = 0;
  for (const InterfaceSpec& interface : part_.interfaces) {
    const auto n_dofs = static_cast<Index>(interface.directions.size());
    const Index first = first_dof;
    first_dof += n_dofs;
    if (n_dofs == 0 || !by_faces(interface)) continue;
    // Radius and scaled rotations as in average.cpp.
    double radius = 0.0;
    for (const mesh::Index node : interface.set.nodes)
      radius = std::max(radius, (part_.mesh.points.row(node).transpose() - interface.point).norm());
    Vector6 scale;
    scale << 1, 1, 1, 1 / radius, 1 / radius, 1 / radius;
    Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
    std::map<int, Eigen::Matrix<double, 3, 6>> work;  // of each function: integral w D dA
    for (const mesh::CellBlock& block : interface.set.faces) {
      const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
      const TabulatedRule rule = tabulate(block.type, mesh::volume_quadrature(block.type));
      const Tables tables = tables_of(rule, block.type);
      for (Index row = 0; row < block.nodes.rows(); ++row) {
        const NodePositions x = positions(part_.mesh, block, row);
        for (std::size_t q = 0; q < rule.points.size(); ++q) {
          const Eigen::Matrix3d tangents = rule.points[q].dN.transpose() * x;
          const double area =
              rule.points[q].weight * tangents.row(0).transpose().cross(tangents.row(1).transpose()).norm();
          const Eigen::Vector3d off = x.transpose() * rule.points[q].N - interface.point;
          const Eigen::Matrix<double, 3, 6> D = motion_at(off) * scale.asDiagonal();
          gram += area * D.transpose() * D;
          for (std::size_t f = 0; f < functions.size(); ++f) {
            const auto number = numbers.find(key_of(functions[f], block, row));
            if (number == numbers.end() || number->second < 0) continue;
            const double w = sign_of(functions[f], block, row) * tables.gained[q].w(static_cast<Index>(f));
            auto [at, fresh] = work.try_emplace(number->second, Eigen::Matrix<double, 3, 6>::Zero());
            at->second += (w * area) * D;
          }
        }
      }
    }
    const Eigen::Matrix<double, 6, 6> to_force = gram.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity()) *
                                                 Eigen::Matrix<double, 6, 6>(scale.asDiagonal());
    MatrixXd force = MatrixXd::Zero(6, force_b.cols());
    for (Index k = 0; k < n_dofs; ++k)
      force.row(interface.directions[static_cast<std::size_t>(k)]) = force_b.row(first + k);
    for (const auto& [function, W] : work)
      R_.middleRows<3>(3 * static_cast<Index>(function)) += (W * (to_force * force)).cast<float>();
  }
}

void EnrichedError::weigh_shared_functions() {
  std::vector<float> total(3 * static_cast<std::size_t>(n_functions_), 0.0f);
  for (const Cell& cell : cells_) {
    const Eigen::Map<const Eigen::MatrixXf> A(K_.data() + cell.first_entry, 3 * cell.n, 3 * cell.n);
    for (int f = 0; f < cell.n; ++f) {
      const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
      for (int d = 0; d < 3 && function >= 0; ++d)
        total[3 * static_cast<std::size_t>(function) + static_cast<std::size_t>(d)] += A(3 * f + d, 3 * f + d);
    }
  }
  // A cell by itself is free to move; what this adds is taken away again by the steps.
  constexpr float kFooting = 0.1f;
  constexpr int kChunks = 64;
  linalg::parallel_for(kChunks, [&](int chunk) {
    for (std::size_t k = cells_.size() * chunk / kChunks; k < cells_.size() * (chunk + 1) / kChunks; ++k) {
      const Cell& cell = cells_[k];
      const Index n = 3 * cell.n;
      const Eigen::Map<const Eigen::MatrixXf> A(K_.data() + cell.first_entry, n, n);
      Eigen::Map<Eigen::MatrixXf> B(B_.data() + cell.first_entry, n, n);
      Eigen::VectorXf weight(n);
      for (int f = 0; f < cell.n; ++f) {
        const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
        for (int d = 0; d < 3; ++d)
          weight(3 * f + d) =
              function < 0
                  ? 0.0f
                  : A(3 * f + d, 3 * f + d) /
                        total[3 * static_cast<std::size_t>(function) + static_cast<std::size_t>(d)];
      }
      B = A;
      B.diagonal() *= 1.0f + kFooting;
      linalg::invert(B.data(), static_cast<int>(n));
      B = (weight.asDiagonal() * (0.5f * (B + B.transpose())).eval() * weight.asDiagonal()).eval();
    }
  });
}

void EnrichedError::multiply(const std::vector<float>& matrices, const Panel& X, Panel& Y) const {
  Y.setZero(X.rows(), kWidth);
  Panel x, y;
  for (const Cell& cell : cells_) {
    const Index n = 3 * cell.n;
    x.resize(n, kWidth);
    y.resize(n, kWidth);
    for (int f = 0; f < cell.n; ++f) {
      const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
      if (function < 0)
        x.middleRows<3>(3 * f).setZero();
      else
        x.middleRows<3>(3 * f) = X.middleRows<3>(3 * static_cast<Index>(function));
    }
    linalg::multiply_sixteen(matrices.data() + cell.first_entry, static_cast<int>(n), x.data(), y.data());
    for (int f = 0; f < cell.n; ++f) {
      const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
      if (function >= 0) Y.middleRows<3>(3 * static_cast<Index>(function)) += y.middleRows<3>(3 * f);
    }
  }
}

// Conjugate gradients on a panel of states (M. R. Hestenes, E. Stiefel 1952), until a step adds no more than 1 % to any
// energy.
void EnrichedError::solve(Index first_state) {
  constexpr int kMostSteps = 12;
  constexpr double kEnough = 0.01;
  using Numbers = Eigen::Array<double, 1, kWidth>;
  const Index width = std::min<Index>(kWidth, R_.cols() - first_state);
  const auto dots = [](const Panel& a, const Panel& b) {
    Numbers sum = Numbers::Zero();
    for (Index row = 0; row < a.rows(); ++row)
      sum += a.row(row).cast<double>().array() * b.row(row).cast<double>().array();
    return sum;
  };
  Panel r = Panel::Zero(R_.rows(), kWidth), z, d, A_d;
  for (Index c = 0; c < width; ++c) r.col(c) = R_.col(first_state + c);
  Panel e = Panel::Zero(R_.rows(), kWidth);
  multiply(B_, r, z);
  d = z;
  Numbers rz = dots(r, z), energy = Numbers::Zero();
  for (int step = 0; step < kMostSteps; ++step) {
    multiply(K_, d, A_d);
    const Numbers dAd = dots(d, A_d);
    const Numbers alpha = (dAd > 0.0).select(rz / dAd, 0.0), gain = alpha * rz;
    energy += gain;
    const Eigen::Array<float, 1, kWidth> a = alpha.cast<float>();
    for (Index row = 0; row < r.rows(); ++row) {
      e.row(row).array() += a * d.row(row).array();
      r.row(row).array() -= a * A_d.row(row).array();
    }
    if ((gain <= kEnough * energy).all()) break;
    multiply(B_, r, z);
    const Numbers next = dots(r, z), beta = (rz > 0.0).select(next / rz, 0.0);
    rz = next;
    const Eigen::Array<float, 1, kWidth> b = beta.cast<float>();
    for (Index row = 0; row < r.rows(); ++row) d.row(row) = z.row(row).array() + b * d.row(row).array();
  }
  for (Index c = 0; c < width; ++c) energy_.energy(first_state + c) = energy(c);
  Panel x, A_x;
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const Cell& cell = cells_[k];
    const Index n = 3 * cell.n;
    x.setZero(n, kWidth);
    for (int f = 0; f < cell.n; ++f) {
      const int function = functions_[cell.first_function + static_cast<std::size_t>(f)];
      if (function >= 0) x.middleRows<3>(3 * f) = e.middleRows<3>(3 * static_cast<Index>(function));
    }
    A_x.resize(n, kWidth);
    linalg::multiply_sixteen(K_.data() + cell.first_entry, static_cast<int>(n), x.data(), A_x.data());
    for (Index c = 0; c < width; ++c) energy_.by_cell(static_cast<Index>(k), first_state + c) = x.col(c).dot(A_x.col(c));
  }
}

}  // namespace flexura::reduce
