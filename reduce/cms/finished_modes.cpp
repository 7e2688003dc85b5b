// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/finished_modes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <stdexcept>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/dampers.hpp"
#include "reduce/cms/shapes/free_directions.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// What printed digits (six and more) leave of vectors and matrices that belong together.
constexpr double kPrinted = 1e-3;

linalg::SymmetricMatrix scalar_mass(const NodalMatrices& given, int n_nodes) {
  std::vector<std::vector<int>> rows(n_nodes);
  for (int a = 0; a < n_nodes; ++a) rows[a].push_back(a);
  for (std::size_t k = 0; k < given.pairs.size(); ++k)
    if (const auto& [a, b] = given.pairs[k]; a != b) rows[a].push_back(b);
  std::vector<int> begin{0}, columns;
  for (std::vector<int>& row : rows) {
    std::sort(row.begin(), row.end());
    columns.insert(columns.end(), row.begin(), row.end());
    begin.push_back(static_cast<int>(columns.size()));
  }
  linalg::SymmetricMatrix m(std::move(begin), std::move(columns));
  MatrixXd pair(2, 2);
  for (std::size_t k = 0; k < given.pairs.size(); ++k) {
    const auto& [a, b] = given.pairs[k];
    if (a == b) {
      m.add_to_diagonal(a, given.m[k]);
    } else {
      pair << 0.0, given.m[k], given.m[k], 0.0;
      const int nodes[] = {a, b};
      m.add(nodes, pair);
    }
  }
  m.finish();
  return m;
}

// Columns: the rigid motions, then the vectors.
struct Motions {
  MatrixXd u;      // 3 n_nodes, points that follow among them
  MatrixXd theta;  // 3 n_nodes, zero where a node has no rotations
  std::vector<char> turns;
};

Motions all_motions(const Part& part, const FinishedModes& modes) {
  const Index n_nodes = part.mesh.n_nodes(), n_v = modes.V.cols(), n_own = modes.V.rows() / 3;
  Motions W{MatrixXd::Zero(3 * n_nodes, 6 + n_v), MatrixXd::Zero(3 * n_nodes, 6 + n_v),
            std::vector<char>(static_cast<std::size_t>(n_nodes), 0)};
  for (Index node = 0; node < n_nodes; ++node)
    W.u.block<3, 6>(3 * node, 0) = motion_at(part.mesh.points.row(node));
  W.u.block(0, 6, modes.V.rows(), n_v) = modes.V;
  for (Index node = 0; node < n_own && modes.rotations.size() > 0; ++node) {
    const auto theta = modes.rotations.middleRows<3>(3 * node);
    if (theta.isZero(0.0)) continue;
    W.turns[static_cast<std::size_t>(node)] = 1;
    W.theta.block<3, 3>(3 * node, 3).setIdentity();
    W.theta.block(3 * node, 6, 3, n_v) = theta;
  }
  for (const Follower& follower : part.followers) {
    auto to = W.u.block(3 * static_cast<Index>(follower.point), 6, 3, n_v);
    for (const auto& [node, C] : follower.from) {
      const Index row = 3 * static_cast<Index>(node);
      if (W.turns[static_cast<std::size_t>(node)] == 0 && !C.rightCols<3>().isZero(0.0))
        throw std::invalid_argument(fmt::format(
            "the mass matrix has rotary inertia at node {}, which does not turn in the vectors: give them "
            "with six "
            "rows a node (u, theta), or the mass of displacements alone",
            part.mesh.node_label.empty() ? node + 1 : part.mesh.node_label[static_cast<std::size_t>(node)]));
      to += C.leftCols<3>() * W.u.block(row, 6, 3, n_v) + C.rightCols<3>() * W.theta.block(row, 6, 3, n_v);
    }
  }
  return W;
}

void refuse_bending(const InterfaceSpec& spec, double share) {
  if (share > kPrinted)
    throw std::invalid_argument(
        fmt::format("the vectors bend interface '{}' by {:.2g} of its motion, so it was no rigid piece when "
                    "they were computed: tie it as an average",
                    spec.name, share));
}

// Of nodes that turn and are one piece: theta is their mean, u that of what each says of the interface's point.
MatrixXd turning_motion(const Part& part, const InterfaceSpec& spec, const Motions& W,
                        const std::vector<mesh::Index>& turning) {
  MatrixXd motion = MatrixXd::Zero(6, W.u.cols());
  for (const mesh::Index node : turning)
    motion.bottomRows<3>() +=
        W.theta.middleRows<3>(3 * static_cast<Index>(node)) / static_cast<double>(turning.size());
  const auto arm = [&](mesh::Index node) {
    return motion_at(part.mesh.points.row(node).transpose() - spec.point);
  };
  for (const mesh::Index node : spec.set.nodes)
    motion.topRows<3>() += (W.u.middleRows<3>(3 * static_cast<Index>(node)) -
                            arm(node).rightCols<3>() * motion.bottomRows<3>()) /
                           static_cast<double>(spec.set.nodes.size());
  double turned = 0.0, all = 0.0;
  for (const mesh::Index node : turning) {
    const auto theta = W.theta.middleRows<3>(3 * static_cast<Index>(node));
    turned += (theta - motion.bottomRows<3>()).squaredNorm();
    all += theta.squaredNorm();
  }
  refuse_bending(spec, std::sqrt(turned / all));
  return motion;
}

// Motion (u, theta) of the interface's node in each vector; zero where a single node has no rotation.
MatrixXd interface_motion(const Part& part, const InterfaceSpec& spec, const Motions& W) {
  if (spec.directions.empty()) return MatrixXd::Zero(6, W.u.cols());  // a rigid piece of the part
  const std::vector<mesh::Index>& nodes = spec.set.nodes;
  MatrixXd set(3 * static_cast<Index>(nodes.size()), W.u.cols());
  for (std::size_t a = 0; a < nodes.size(); ++a)
    set.middleRows<3>(3 * static_cast<Index>(a)) = W.u.middleRows<3>(3 * static_cast<Index>(nodes[a]));
  std::vector<mesh::Index> turning;
  std::ranges::copy_if(nodes, std::back_inserter(turning),
                       [&](mesh::Index node) { return W.turns[static_cast<std::size_t>(node)] != 0; });
  if (spec.tie == Tie::node) {
    if (nodes.size() != 1 || (spec.directions.back() > 2 && turning.empty()))
      throw std::invalid_argument(fmt::format(
          "interface '{}' is tied as a node: it takes a single node, and displacements only where the "
          "vectors have no rotations of it",
          spec.name));
    MatrixXd motion = MatrixXd::Zero(6, W.u.cols());
    motion.topRows<3>() = set;
    motion.bottomRows<3>() = W.theta.middleRows<3>(3 * static_cast<Index>(nodes.front()));
    return motion;
  }
  const bool by_rotations = spec.tie == Tie::rigid && spec.rotations && !turning.empty();
  if (nodes.size() == 1 && !by_rotations && spec.directions.back() > 2)
    throw std::invalid_argument(fmt::format(
        "interface '{}' is a single node, whose rotations the vectors do not have: give them with six "
        "rows a node, retain displacements only, or choose more nodes",
        spec.name));
  const MatrixXd motion =
      by_rotations ? turning_motion(part, spec, W, turning) : MatrixXd(averaging_map(part.mesh, spec) * set);
  if (spec.tie == Tie::rigid) {
    MatrixXd bent = set;
    for (std::size_t a = 0; a < nodes.size(); ++a)
      bent.middleRows<3>(3 * static_cast<Index>(a)) -=
          motion_at(part.mesh.points.row(nodes[a]).transpose() - spec.point) * motion;
    refuse_bending(spec, bent.norm() / set.norm());
  }
  return motion;
}

// K must be that of the vectors: what is left of it when they are written in the new basis.
void check_stiffness(const MatrixXd& K_W, const MatrixXd& M_W, const CanonicalShapes& shapes) {
  const MatrixXd& Y = shapes.Y;
  const MatrixXd M_Y = Y.transpose() * M_W * Y, K_Y = Y.transpose() * K_W * Y;
  const MatrixXd C = M_Y.partialPivLu().solve(Y.transpose() * M_W);  // W = (W Y) C
  const MatrixXd rest = C.transpose() * K_Y * C - K_W;
  const double omega2 = shapes.omega2.size() > 0 ? shapes.omega2(0) : 0.0;
  for (Index j = 6; j < K_W.cols(); ++j) {
    const double scale = K_W(j, j) + omega2 * M_W(j, j);
    if (!(std::abs(rest(j, j)) > kPrinted * scale)) continue;
    throw std::invalid_argument(fmt::format(
        "the reduced stiffness contradicts the vectors: vector {} is, with others, a rigid motion "
        "or none at all, but that would cost energy ({:.2g} of its own); look for springs to the "
        "ground, supports, or columns in another order",
        j - 5, std::abs(rest(j, j)) / scale));
  }
}

// V^T D V less what resists rigid motion, where the vectors span it: R = V C.  Free modes do not, and are orthogonal to it.
MatrixXd elastic_damping(const MatrixXd& D, const MatrixXd& M_W, ReductionReport& report) {
  const Index n_v = D.rows();
  const MatrixXd M = M_W.bottomRightCorner(n_v, n_v), M_R = M_W.bottomLeftCorner(n_v, 6);
  const MatrixXd C = M.completeOrthogonalDecomposition().solve(M_R);
  const MatrixXd rest = M_W.topLeftCorner(6, 6) - C.transpose() * M_R;
  for (Index k = 0; k < 6; ++k)
    if (!(std::abs(rest(k, k)) <= kPrinted * kPrinted * M_W(k, k))) return D;
  return without_rigid_damping(D, C, M, report);
}

}  // namespace

Reduction reduce_finished_modes(const Part& part, const FinishedModes& modes,
                                const ReductionOptions& options) {
  if (!part.matrices) throw std::logic_error("finished modes want the part's mass matrix");
  const Index n_nodes = part.mesh.n_nodes(), n_v = modes.V.cols(),
              n_own = n_nodes - static_cast<Index>(part.followers.size());
  if (modes.V.rows() != 3 * n_own ||
      (modes.rotations.size() > 0 && (modes.rotations.rows() != 3 * n_own || modes.rotations.cols() != n_v)))
    throw std::invalid_argument(
        fmt::format("the vectors have {} rows, {} or {} are wanted: three or six for each of the {} nodes",
                    modes.V.rows() + modes.rotations.rows(), 3 * n_own, 6 * n_own, n_own));
  for (const MatrixXd* matrix : {&modes.K, &modes.M, &modes.D})
    if (matrix->size() > 0 && (matrix->rows() != n_v || matrix->cols() != n_v))
      throw std::invalid_argument(
          fmt::format("a reduced matrix of the {} vectors is {} x {}", n_v, matrix->rows(), matrix->cols()));
  if (modes.stress.size() > 0 && (modes.stress.rows() != 6 * n_own || modes.stress.cols() != n_v))
    throw std::invalid_argument(
        fmt::format("the stress modes are {} x {}, {} x {} are wanted: six for each node",
                    modes.stress.rows(), modes.stress.cols(), 6 * n_own, n_v));
  linalg::Stopwatch watch;
  const linalg::SymmetricMatrix m = scalar_mass(*part.matrices, static_cast<int>(n_nodes));
  const Motions motions = all_motions(part, modes);
  const MatrixXd& W = motions.u;

  Reduction r;
  r.inertia = inertia_integrals(m, part.mesh.points, W);
  r.M_se = r.inertia.S_phiphi[0] + r.inertia.S_phiphi[1] + r.inertia.S_phiphi[2];
  r.K_se = MatrixXd::Zero(6 + n_v, 6 + n_v);
  r.K_se.bottomRightCorner(n_v, n_v) = 0.5 * (modes.K + modes.K.transpose());
  for (Index j = 0; j < n_v; ++j)
    if (!(r.M_se(6 + j, 6 + j) > 0.0))
      throw std::invalid_argument(fmt::format("vector {} moves no mass; leave it out", j + 1));
  if (modes.M.size() > 0) {
    double worst = 0.0;
    for (Index j = 0; j < n_v; ++j)
      worst = std::max(worst, std::abs(modes.M(j, j) / r.M_se(6 + j, 6 + j) - 1.0));
    r.report.notes.push_back(fmt::format(
        "the reduced mass as given differs from that of the nodes' mass by at most {:.2g} %", 100.0 * worst));
    // A lumped mass is within a few per cent for waves that the mesh resolves; a unit is off by far more.
    if (worst > 0.5)
      throw std::invalid_argument(fmt::format(
          "the reduced mass as given and that of the nodes' mass differ by {:.2g} %: they are not "
          "in one unit, or not of the same vectors",
          100.0 * worst));
  }

  MatrixXd B(0, 6 + n_v), R_b(0, 6);
  for (const InterfaceSpec& spec : part.interfaces) {
    const Eigen::Vector3d point =
        spec.tie == Tie::node ? Eigen::Vector3d(part.mesh.points.row(spec.set.nodes.at(0))) : spec.point;
    InterfaceSpec used = spec;
    used.point = point;
    const MatrixXd motion = interface_motion(part, used, motions), rows = motion(spec.directions, Eigen::all);
    const Index first = B.rows();
    B.conservativeResize(first + rows.rows(), Eigen::NoChange);
    B.bottomRows(rows.rows()) = rows;
    R_b.conservativeResize(first + rows.rows(), Eigen::NoChange);
    R_b.bottomRows(rows.rows()) = node_motion_at(point)(spec.directions, Eigen::all);
    r.interfaces.push_back({spec.name, spec.tie, point, spec.directions, static_cast<int>(first)});
    // The first six vectors are the rigid motions.
    set_free_motion(r.interfaces.back(), motion, MatrixXd::Identity(6, 6));
  }
  require_held(R_b, part.mesh.points);
  B.leftCols(6) = R_b;
  const MatrixXd B_all = B;
  const std::vector<int> own = independent_dofs(r.M_se, B_all);
  const std::vector<std::string> following = let_others_follow(r, B_all, own);
  B = B_all(own, Eigen::all);
  R_b = R_b(own, Eigen::all).eval();
  if (!following.empty())
    r.report.notes.push_back(fmt::format(
        "the vectors move only {} of the {} interface dofs independently; {} {} the others: loads there "
        "deform the body as "
        "far as the vectors can",
        r.n_b, B_all.rows(), fmt::join(following, ", "), following.size() == 1 ? "follows" : "follow"));

  for (const LoadField& load : options.loads) r.loads.push_back(reduced_load(load, W, m));
  r.shapes.resize(3 * static_cast<Index>(options.shape_nodes.size()), 6 + n_v);
  for (std::size_t v = 0; v < options.shape_nodes.size(); ++v)
    r.shapes.middleRows<3>(3 * static_cast<Index>(v)) =
        W.middleRows<3>(3 * static_cast<Index>(options.shape_nodes[v])).cast<float>();
  if (options.all_nodes) {
    std::vector<int> rotation_of;
    for (Index node = 0; node < n_nodes; ++node)
      rotation_of.push_back(motions.turns[static_cast<std::size_t>(node)] != 0 ? static_cast<int>(node) : -1);
    r.nodes = node_motions(part, W, motions.theta, rotation_of);
  }
  if (modes.stress.size() > 0) {
    r.stress_modes = MatrixXd::Zero(6 * static_cast<Index>(options.stress_nodes.size()), 6 + n_v);
    for (std::size_t s = 0; s < options.stress_nodes.size(); ++s)
      r.stress_modes.block(6 * static_cast<Index>(s), 6, 6, n_v) =
          modes.stress.middleRows<6>(6 * static_cast<Index>(options.stress_nodes[s]));
  }

  if (modes.D.size() > 0) {
    r.D_se = MatrixXd::Zero(6 + n_v, 6 + n_v);
    r.D_se.bottomRightCorner(n_v, n_v) =
        elastic_damping(0.5 * (modes.D + modes.D.transpose()), r.M_se, r.report);
  }

  const CanonicalShapes shapes = canonical_shapes(r.K_se, r.M_se, B);
  check_stiffness(r.K_se, r.M_se, shapes);
  change_shapes(r, shapes);
  r.report.notes.push_back(
      fmt::format("{} vectors of another program with the six rigid motions: {} shapes", n_v, r.n()));
  if (!shapes.dropped.empty())
    r.report.notes.push_back(fmt::format(
        "{} of them are combinations of the others (the rigid motions among them)", shapes.dropped.size()));
  r.report.n_nodes = static_cast<int>(n_own);
  r.report.n_i = static_cast<int>(3 * (n_own + std::ranges::count(motions.turns, 1))) - r.n_b;
  r.report.n_b = r.n_b;
  r.report.n_q = r.n_q;
  r.report.rigid_strain = (r.K_se.topLeftCorner(r.n_b, r.n_b) * R_b).norm() / (r.K_se.norm() * R_b.norm());
  r.report.seconds_projection = watch.lap();
  r.report.peak_memory_bytes = linalg::peak_memory();
  return r;
}

}  // namespace flexura::reduce
