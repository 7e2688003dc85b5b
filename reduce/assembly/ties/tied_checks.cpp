// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/ties/tied_checks.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "mesh/model/coincident.hpp"
#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/ties/pieces.hpp"
#include "reduce/assembly/ties/tied_codes.hpp"
#include "reduce/assembly/ties/tied_motions.hpp"

namespace flexura::reduce {
namespace {

struct Extent {
  Eigen::Vector3d centre;
  double length;  // half the diagonal of the bounding box, 1 for a point
};

Extent extent_of(const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points) {
  const Eigen::Vector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  const double length = 0.5 * (high - low).norm();
  return {0.5 * (low + high), length > 0.0 ? length : 1.0};
}

// Whether motions that the nodes do not hold (6 x p) leave a node at `point` where it is in the directions asked for.
bool none_moves(const Eigen::Matrix<double, 6, Eigen::Dynamic>& free, const std::vector<int>& directions,
                const Eigen::Vector3d& point, const Extent& extent) {
  constexpr double kHeld = 1e-6;  // as free_motions has it
  Eigen::Matrix<double, 6, 1> unit;
  unit << 1, 1, 1, extent.length, extent.length, extent.length;
  const Eigen::Matrix<double, 6, Eigen::Dynamic> there = unit.asDiagonal() * (node_motion_at(point) * free),
                                                 all = unit.asDiagonal() *
                                                       (node_motion_at(extent.centre) * free);
  return std::all_of(directions.begin(), directions.end(),
                     [&](int direction) { return there.row(direction).norm() <= kHeld * all.norm(); });
}

}  // namespace

void check_interfaces(const Part& part, const TiedNumbering& numbering, bool may_be_free) {
  std::map<std::pair<int, int>, int> shared;
  std::vector<int> owner(numbering.n_nodes(), -1);
  for (int k = 0; k < numbering.n_interfaces(); ++k) {
    const InterfaceDofs& interface = numbering.interfaces()[k];
    const std::string& name = part.interfaces[k].name;
    if (interface.nodes.empty())
      throw std::invalid_argument(
          fmt::format("interface '{}' has no node that belongs to a cell of the mesh", name));
    for (mesh::Index node : interface.nodes) {
      if (owner[node] >= 0) ++shared[{owner[node], k}];
      owner[node] = k;
    }
    const int largest = interface.directions.empty() ? 0 : interface.directions.back();
    const int smallest = interface.directions.empty() ? 0 : interface.directions.front();
    if (smallest < 0 || largest > 5)
      throw std::invalid_argument(fmt::format("interface '{}': directions are 0 to 5", name));
    if (interface.tie == Tie::node) {
      if (interface.nodes.size() != 1)
        throw std::invalid_argument(
            fmt::format("interface '{}' is tied as a node, but its set has {} nodes: give one "
                        "node, or tie it rigid or as an average",
                        name, interface.nodes.size()));
      if (largest > 2 && numbering.rotation_of(interface.nodes[0]) < 0)
        throw std::invalid_argument(
            fmt::format("interface '{}' is a single node of solid elements, which has no rotations: retain "
                        "displacements only, or choose a face",
                        name));
      continue;
    }
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> set(interface.nodes.size(), 3);
    Eigen::Matrix<double, Eigen::Dynamic, 6> H = Eigen::MatrixXd::Zero(3 * set.rows() + 3, 6);
    bool turns = false;
    for (Eigen::Index a = 0; a < set.rows(); ++a) {
      const mesh::Index node = interface.nodes[a];
      set.row(a) = numbering.points().row(node);
      H.middleRows<3>(3 * a) = motion_at(set.row(a));
      turns = turns || (interface.tie == Tie::rigid && numbering.rotation_of(node) >= 0 &&
                        (part.interfaces[k].rotations || node == part.interfaces[k].turning_node));
    }
    const Extent extent = extent_of(set);
    if (turns) H.bottomRightCorner<3, 3>().diagonal().setConstant(extent.length);
    const auto free = free_motions(H, extent.centre, extent.length);
    if (free.cols() > 0 &&
        !(interface.tie == Tie::average && none_moves(free, interface.directions, interface.point, extent)))
      throw std::invalid_argument(fmt::format(
          "interface '{}' has {} node{}, {}, and cannot hold a {}: choose a face or more nodes{}", name,
          set.rows(), set.rows() == 1 ? "" : "s", set.rows() == 1 ? "a point" : "all on one line",
          describe_motion(free, extent.centre, extent.length),
          set.rows() == 1 ? ", or tie it as a node (displacements only)"
                          : ", or tie = \"average\" with the directions alone that they hold"));
  }
  if (!shared.empty()) {
    const auto& [pair, count] = *shared.begin();
    throw std::invalid_argument(fmt::format(
        "interfaces '{}' and '{}' share {} node{}: choose faces that do not touch, or join them into one "
        "interface",
        part.interfaces[pair.first].name, part.interfaces[pair.second].name, count, count == 1 ? "" : "s"));
  }
  if (may_be_free) return;
  require_held(rigid_boundary(numbering), numbering.points());
}

void check_pieces(const Part& part, const TiedNumbering& numbering) {
  const Pieces pieces = pieces_of(part);
  if (pieces.sizes.empty()) throw std::invalid_argument("the mesh has no cells that stiffness comes from");
  if (pieces.sizes.size() == 1) return;
  if (std::ranges::all_of(free_motions_of(part, pieces), [](int free) { return free == 0; })) return;
  const auto smallest = std::ranges::min_element(pieces.sizes);
  const auto node =
      static_cast<int>(std::ranges::find(pieces.of_node, static_cast<int>(smallest - pieces.sizes.begin())) -
                       pieces.of_node.begin());
  // Decks whose parts were meshed one by one and never merged.
  std::vector<mesh::Index> used;
  for (int n = 0; n < numbering.n_nodes(); ++n)
    if (pieces.of_node[static_cast<std::size_t>(n)] >= 0) used.push_back(n);
  std::string apart;
  int n_apart = 0;
  for (const auto& [a, b] : mesh::coincident_nodes(part.mesh.points, std::move(used)))
    if (pieces.of_node[static_cast<std::size_t>(a)] != pieces.of_node[static_cast<std::size_t>(b)] &&
        n_apart++ == 0)
      apart = fmt::format(" {} and {}", numbering.label_of(a), numbering.label_of(b));
  throw std::invalid_argument(fmt::format(
      "the mesh falls into {} pieces that nothing joins; the smallest has {} nodes, one of them node {} at "
      "({:.5g}, {:.5g}, {:.5g}) m: {}",
      pieces.sizes.size(), *smallest, numbering.label_of(node), numbering.points()(node, 0),
      numbering.points()(node, 1), numbering.points()(node, 2),
      n_apart > 0
          ? fmt::format("merge the nodes that lie in one place ({} pairs, such as{}), or take one piece",
                        n_apart, apart)
          : std::string("fuse the solids, or take one of them")));
}

// Greedily, each the one that moves most in what the former pins leave.
std::vector<int> choose_pins(const TiedNumbering& numbering) {
  std::vector<int> pins;
  const std::vector<int>& codes = numbering.codes();
  std::vector<char> averaged(numbering.n_b(), 0);
  for (const InterfaceDofs& interface : numbering.interfaces())
    if (interface.tie == Tie::average)
      std::fill_n(averaged.begin() + interface.first_b, interface.directions.size(), 1);
  Eigen::MatrixXd H = rigid_boundary(numbering);
  for (int b = 0; b < numbering.n_b(); ++b)
    if (averaged[b]) H.row(b).setZero();
  const Extent extent = extent_of(numbering.points());
  Eigen::MatrixXd free = free_motions(H, extent.centre, extent.length);
  while (free.cols() > 0) {
    int best = -1;
    double best_size = 0.0;
    for (std::size_t d = 0; d < codes.size(); ++d) {
      if (codes[d] < 0) continue;
      const double size =
          (motion_at(numbering.points().row(static_cast<Eigen::Index>(d / 3))).row(d % 3) * free)
              .squaredNorm();
      if (size > best_size) best_size = size, best = static_cast<int>(d);
    }
    if (best < 0) throw std::logic_error("no interior dof can pin the body");
    pins.push_back(codes[best]);
    // Keep what the new pin does not hold.
    const Eigen::VectorXd row =
        (motion_at(numbering.points().row(best / 3)).row(best % 3) * free).transpose();
    const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(row).householderQ();
    free = (free * Q.rightCols(free.cols() - 1)).eval();
  }
  return pins;
}

TiedNumbering checked_numbering(const Part& part, bool may_be_free) {
  TiedNumbering numbering(part);
  if (part.interfaces.empty() && !may_be_free)
    throw std::invalid_argument(
        "the part has no interface: name at least one face, cylinder or node set by which joints can hold "
        "the body");
  check_interfaces(part, numbering, may_be_free);
  check_pieces(part, numbering);
  return numbering;
}

}  // namespace flexura::reduce
