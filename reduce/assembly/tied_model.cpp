// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/assembly/average.hpp"
#include "reduce/assembly/rigid_motion.hpp"
#include "reduce/assembly/tied_codes.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

const char* name_of(Tie tie) {
  switch (tie) {
    case Tie::rigid:
      return "rigid";
    case Tie::average:
      return "average";
    case Tie::node:
      return "node";
    case Tie::elastic:
      return "elastic";
  }
  return "unknown";
}

TiedModel::TiedModel(const Part& part, const AssemblyOptions& options)
    : n_nodes_(part.mesh.n_nodes()), points_(part.mesh.points), node_label_(part.mesh.node_label) {
  if (part.interfaces.empty() && !options.may_be_free)
    throw std::invalid_argument(
        "the part has no interface: name at least one face, cylinder or node set by which joints can hold "
        "the body");
  number_dofs(part);
  check_interfaces(part, options.may_be_free);
  check_pieces(part);
  if (options.shift == 0.0) choose_pins();
  build_patterns(part);
  if (options.team)
    assemble_together(part, options);
  else
    assemble(part, options);
  average(part);
}

// Interior dofs run by nodes in the mesh's order, then come those of interface nodes whose directions are not
// retained.
void TiedModel::number_dofs(const Part& part) {
  code_.assign(3 * static_cast<std::size_t>(n_nodes_), kUnused);
  tie_of_.assign(n_nodes_, -1);
  rotation_of_.assign(n_nodes_, -1);
  slave_of_.assign(n_nodes_, -1);
  group_of_.assign(n_nodes_, -1);
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) {
      const mesh::Index node = block.nodes.data()[k];
      if (node < 0 || node >= n_nodes_)
        throw std::invalid_argument(
            fmt::format("a cell refers to node {}, but the mesh has nodes 0 to {}", node, n_nodes_ - 1));
      std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
    }
  mark_rotations(part);
  for (const Follower& follower : part.followers)
    std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(follower.point), 3, kSlave);
  if (part.matrices) {
    std::fill(code_.begin(), code_.end(), kUnused);
    for (const auto& pair : part.matrices->pairs)
      for (const mesh::Index node : pair)
        std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  }
  // Nodes that carry only a mass or a link's end follow their rigid tie.
  std::vector<char> carries(n_nodes_, 0);
  for (const NodalMass& mass : part.masses) carries[mass.node] = 1;
  for (const Link& link : part.links) carries[link.from] = carries[link.to] = 1;
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::rigid)
      for (const mesh::Index node : spec.set.nodes)
        if (node >= 0 && node < n_nodes_ && carries[node])
          std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  for (int node = 0; node < n_nodes_; ++node)
    if (carries[node] && code_[3 * static_cast<std::size_t>(node)] == kUnused)
      throw std::invalid_argument(fmt::format(
          "a point mass, spring or damper is at node {}, which belongs to no cell of the mesh and "
          "to no rigid tie",
          node_label_.empty() ? node : node_label_[node]));
  for (const InterfaceSpec& spec : part.interfaces) {
    // Nothing said of its modes, an elastic tie is an average.
    InterfaceDofs dofs{
        spec.tie == Tie::elastic ? Tie::average : spec.tie, spec.point, spec.directions, {}, n_b_, {}, {}};
    for (mesh::Index node : spec.set.nodes) {
      if (node < 0 || node >= n_nodes_)
        throw std::invalid_argument(
            fmt::format("interface '{}' refers to node {}, but the mesh has nodes 0 to {}", spec.name, node,
                        n_nodes_ - 1));
      if (code_[3 * static_cast<std::size_t>(node)] != kUnused) dofs.nodes.push_back(node);
    }
    if (!std::is_sorted(dofs.directions.begin(), dofs.directions.end()) ||
        std::adjacent_find(dofs.directions.begin(), dofs.directions.end()) != dofs.directions.end())
      throw std::invalid_argument(
          fmt::format("interface '{}': list each direction once, in ascending order", spec.name));
    n_b_ += static_cast<int>(dofs.directions.size());
    interfaces_.push_back(std::move(dofs));
  }
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    InterfaceDofs& interface = interfaces_[k];
    if (interface.tie == Tie::rigid)
      for (mesh::Index node : interface.nodes) {
        tie_of_[node] = static_cast<int>(k);
        std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kSlave);
        if (const int r = rotation_of_[node];
            r >= 0 && (part.interfaces[k].rotations || node == part.interfaces[k].turning_node))
          rotation_code_[r].fill(kSlave);
      }
    if (interface.tie == Tie::node && interface.nodes.size() == 1) {
      const mesh::Index node = interface.nodes[0];
      interface.point = points_.row(node);
      int b = interface.first_b;
      for (int direction : interface.directions)
        if (direction < 3)
          code_[3 * static_cast<std::size_t>(node) + direction] = boundary_code(b++);
        else if (const int r = rotation_of_[node]; r >= 0)
          rotation_code_[r][direction - 3] = boundary_code(b++);
    }
  }
  for (const DependentDof& constraint : part.dependent) {
    const auto [node, direction] = constraint.dof;
    const int r = rotation_of_[node];
    int* code = direction < 3 ? &code_[3 * static_cast<std::size_t>(node) + direction]
                : r >= 0      ? &rotation_code_[r][direction - 3]
                              : nullptr;
    if (!code || (*code != kPending && *code != kUnused))
      throw std::invalid_argument(fmt::format("a constraint binds direction {} of node {}, which {}",
                                              direction + 1, node_label_.empty() ? node : node_label_[node],
                                              code ? "follows something else" : "has no rotations"));
    *code = kSlave;
    for (const auto& [from, coefficient] :
         constraint.from)  // a node of constraints alone has the dofs that they name
      if (from.direction < 3)
        if (int& own = code_[3 * static_cast<std::size_t>(from.node) + from.direction]; own == kUnused)
          own = kPending;
  }
  group_begin_ = {0};
  const auto close_group = [this]() -> int {
    if (n_i_ == group_begin_.back()) return -1;
    group_begin_.push_back(n_i_);
    return static_cast<int>(group_begin_.size()) - 2;
  };
  for (int node = 0; node < n_nodes_; ++node) {
    for (int a = 0; a < 3; ++a)
      if (int& code = code_[3 * static_cast<std::size_t>(node) + a]; code == kPending) code = n_i_++;
    if (const int r = rotation_of_[node]; r >= 0)
      for (int& code : rotation_code_[r])
        if (code == kPending) code = n_i_++;
    group_of_[node] = close_group();
  }
  for (InterfaceDofs& interface : interfaces_) {
    interface.code.fill(kUnused);
    int b = interface.first_b;
    for (int direction : interface.directions) interface.code[direction] = boundary_code(b++);
    if (interface.tie == Tie::rigid)
      for (int& code : interface.code)
        if (code == kUnused) code = n_i_++;
    tie_group_.push_back(close_group());
  }
  for (const InterfaceDofs& interface : interfaces_)
    for (const mesh::Index node : interface.nodes)
      if (const int r = rotation_of_[node];
          interface.tie == Tie::rigid && r >= 0 && rotation_code_[r][0] == kSlave)
        std::copy_n(interface.code.begin() + 3, 3, rotation_code_[r].begin());
  for (const DependentDof& constraint : part.dependent) {
    if (constraint.dof.direction < 3) continue;
    const NodalDof& from = constraint.from.at(0).first;
    const int r = rotation_of_[from.node];
    if (r < 0 || from.direction < 3)
      throw std::invalid_argument(fmt::format("a constraint names the rotation of node {}, which has none",
                                              node_label_.empty() ? from.node : node_label_[from.node]));
    rotation_code_[rotation_of_[constraint.dof.node]][constraint.dof.direction - 3] =
        rotation_code_[r][from.direction - 3];
  }
  follow(part);
}

std::vector<char> nodes_with_rotations(const Part& part) {
  std::vector<char> turns(part.mesh.n_nodes(), 0);
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) turns[block.nodes.data()[k]] = 1;
  for (const FrameElement& frame : part.frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a)
      if (!frame.K.middleRows<3>(6 * static_cast<Eigen::Index>(a) + 3).isZero(0.0)) turns[frame.nodes[a]] = 1;
  return turns;
}

void TiedModel::mark_rotations(const Part& part) {
  const auto check = [this](mesh::Index node) {
    if (node < 0 || node >= n_nodes_)
      throw std::invalid_argument(
          fmt::format("an element refers to node {}, but the mesh has nodes 0 to {}", node, n_nodes_ - 1));
    std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  };
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) check(block.nodes.data()[k]);
  for (const FrameElement& frame : part.frames)
    for (const mesh::Index node : frame.nodes) check(node);
  const std::vector<char> turns = nodes_with_rotations(part);
  for (int node = 0; node < n_nodes_; ++node) {
    if (!turns[node]) continue;
    rotation_of_[node] = static_cast<int>(rotation_code_.size());
    rotation_code_.push_back({kPending, kPending, kPending});
  }
}

// The points without dofs, by what they follow.
void TiedModel::follow(const Part& part) {
  slave_begin_ = {0};
  const auto add = [this](int code, const Eigen::Vector3d& C) {
    for (std::size_t k = slave_begin_.back(); k < slave_code_.size(); ++k)
      if (slave_code_[k] == code) {
        slave_C_[k] += C;
        return;
      }
    slave_code_.push_back(code);
    slave_C_.push_back(C);
  };
  // Of a node's own displacement and rotation by C.
  const auto add_node = [&](mesh::Index node, const Eigen::Matrix<double, 3, 6>& C) {
    if (const int tie = tie_of_[node], slave = slave_of_[node]; tie < 0 && slave >= 0) {
      for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k)
        add(slave_code_[k], Eigen::Vector3d(C.leftCols<3>() * slave_C_[k]));
    } else if (tie >= 0) {
      const Eigen::Matrix<double, 3, 6> motion =
          C.leftCols<3>() * motion_at(points_.row(node).transpose() - interfaces_[tie].point);
      for (int d = 0; d < 6; ++d) add(interfaces_[tie].code[d], motion.col(d));
    } else {
      for (int d = 0; d < 3; ++d) add(code_[3 * static_cast<std::size_t>(node) + d], C.col(d));
    }
    const int r = rotation_of_[node];
    for (int d = 0; d < 3 && r >= 0; ++d) add(rotation_code_[r][d], C.col(3 + d));
  };
  const auto close = [this](mesh::Index point) {
    slave_of_[point] = static_cast<int>(slave_begin_.size()) - 1;
    slave_begin_.push_back(static_cast<int>(slave_code_.size()));
  };
  for (int node = 0; node < n_nodes_; ++node) {
    if (tie_of_[node] < 0) continue;
    const InterfaceDofs& interface = interfaces_[tie_of_[node]];
    const Eigen::Matrix<double, 3, 6> motion = motion_at(points_.row(node).transpose() - interface.point);
    for (int d = 0; d < 6; ++d) add(interface.code[d], motion.col(d));
    close(node);
  }
  // Nodes of which constraints bind a displacement; the others are their own.
  for (std::size_t k = 0; k < part.dependent.size();) {
    const mesh::Index node = part.dependent[k].dof.node;
    for (int d = 0; d < 3; ++d)
      if (const int code = code_[3 * static_cast<std::size_t>(node) + d]; is_dof(code))
        add(code, Eigen::Vector3d::Unit(d));
    bool binds = false;
    for (; k < part.dependent.size() && part.dependent[k].dof.node == node; ++k) {
      const DependentDof& constraint = part.dependent[k];
      if (constraint.dof.direction > 2) continue;
      binds = true;
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(constraint.dof.direction);
      for (const auto& [from, c] : constraint.from) {
        const int tie = tie_of_[from.node], r = rotation_of_[from.node];
        if (from.direction < 3 && tie >= 0) {
          const Eigen::Matrix<double, 3, 6> motion =
              motion_at(points_.row(from.node).transpose() - interfaces_[tie].point);
          for (int e = 0; e < 6; ++e) add(interfaces_[tie].code[e], c * motion(from.direction, e) * unit);
          continue;
        }
        if (from.direction > 2 && r < 0)
          throw std::invalid_argument(
              fmt::format("a constraint names the rotation of node {}, which has none",
                          node_label_.empty() ? from.node : node_label_[from.node]));
        add(from.direction < 3 ? code_[3 * static_cast<std::size_t>(from.node) + from.direction]
                               : rotation_code_[r][from.direction - 3],
            c * unit);
      }
    }
    if (!binds) {  // only rotations: it has its own displacements
      slave_code_.resize(static_cast<std::size_t>(slave_begin_.back()));
      slave_C_.resize(static_cast<std::size_t>(slave_begin_.back()));
      continue;
    }
    close(node);
  }
  for (const Follower& follower : part.followers) {
    if (slave_of_[follower.point] >= 0)
      throw std::invalid_argument(fmt::format("point {} follows two things", follower.point));
    for (const auto& [node, C] : follower.from) {
      const bool moves = slave_of_[node] >= 0 || is_dof(code_[3 * static_cast<std::size_t>(node)]);
      if (!moves || (rotation_of_[node] < 0 && !C.rightCols<3>().isZero(0.0)))
        throw std::invalid_argument(fmt::format("a point follows node {}, which has no {}",
                                                node_label_.empty() ? node : node_label_[node],
                                                moves ? "rotation: no shell and no beam holds it" : "dofs"));
      add_node(node, C);
    }
    close(follower.point);
  }
}

template <class Read, class Rows>
void TiedModel::spread(const Read& read, Rows& U) const {
  for (Eigen::Index d = 0; d < U.rows(); ++d)
    if (is_dof(code_[d])) read(code_[d], U.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> q(U.cols());
  for (int node = 0; node < n_nodes_; ++node) {
    const int slave = slave_of_[node];
    if (slave < 0) continue;
    auto u = U.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
    u.setZero();
    for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k) {
      read(slave_code_[k], q);
      u.noalias() += slave_C_[k] * q;
    }
  }
}

template <class Rows, class Add>
void TiedModel::collect(const Rows& F, const Add& add) const {
  for (Eigen::Index d = 0; d < F.rows(); ++d)
    if (is_dof(code_[d]) && slave_of_[d / 3] < 0) add(code_[d], F.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> share(F.cols());
  for (int node = 0; node < n_nodes_; ++node) {
    const int slave = slave_of_[node];
    if (slave < 0) continue;
    for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k) {
      share.noalias() =
          slave_C_[k].transpose() * F.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
      add(slave_code_[k], share);
    }
  }
}

void TiedModel::expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                       const Eigen::Ref<const Eigen::MatrixXd>& u_b, Eigen::MatrixXd& U) const {
  U.setZero(3 * static_cast<Eigen::Index>(n_nodes_), u_i.cols());
  spread(
      [&](int code, auto&& row) {
        if (code >= 0)
          row = u_i.row(code);
        else
          row = u_b.row(boundary_of(code));
      },
      U);
}

void TiedModel::gather(const Eigen::Ref<const Eigen::MatrixXd>& F, Eigen::MatrixXd& f_i,
                       Eigen::MatrixXd& f_b) const {
  f_i.setZero(n_i_, F.cols());
  f_b.setZero(n_b_, F.cols());
  collect(F, [&](int code, const auto& row) {
    if (code >= 0)
      f_i.row(code) += row;
    else
      f_b.row(boundary_of(code)) += row;
  });
}

linalg::SymmetricMatrix TiedModel::shifted_stiffness(double shift) const {
  linalg::SymmetricMatrix K = K_ii_->copy();
  // The interior dofs that a node follows, and its motion for a unit of each.
  struct Follows {
    std::vector<int> dof;
    std::vector<Eigen::Vector3d> C;
  };
  const auto follows = [&](int node, Follows& out) {
    out.dof.clear(), out.C.clear();
    each_dof(node, [&](int code, const Eigen::Vector3d& motion) {
      if (code < 0) return;
      out.dof.push_back(code);
      out.C.push_back(motion);
    });
  };
  const linalg::UpperCsr m = m_->csr();
  Follows of_p, of_q;
  for (int p = 0; p < m.n; ++p) {
    follows(p, of_p);
    for (int k = m.row_begin[p]; !of_p.dof.empty() && k < m.row_begin[p + 1]; ++k) {
      const int q = m.columns[k];
      follows(q, of_q);
      for (std::size_t a = 0; a < of_p.dof.size(); ++a)
        for (std::size_t b = p == q ? a : 0; b < of_q.dof.size(); ++b) {
          double value = shift * m.values[k] * of_p.C[a].dot(of_q.C[b]);
          if (p != q && of_p.dof[a] == of_q.dof[b]) value *= 2.0;  // (p, q) and (q, p)
          if (value != 0.0) K.add_to_entry(of_p.dof[a], of_q.dof[b], value);
        }
    }
  }
  return K;
}

// C_i^T (m (x) I_3) C_i X by panels of eight columns, one panel per core at a time.
void TiedModel::multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  constexpr Eigen::Index kWidth = linalg::RowPanel::ColsAtCompileTime;
  Y.setZero(n_i_, X.cols());
  linalg::parallel_for(static_cast<int>((X.cols() + kWidth - 1) / kWidth), [&](int panel) {
    const Eigen::Index first = panel * kWidth, width = std::min(kWidth, X.cols() - first);
    linalg::RowPanel U = linalg::RowPanel::Zero(static_cast<Eigen::Index>(code_.size()), kWidth), MU;
    spread(
        [&](int code, auto&& row) {
          for (Eigen::Index c = 0; c < kWidth; ++c)
            row(c) = code >= 0 && c < width ? X(code, first + c) : 0.0;
        },
        U);
    m_->multiply_kron3(U, MU);
    collect(MU, [&](int code, const auto& row) {
      if (code < 0) return;
      for (Eigen::Index c = 0; c < width; ++c) Y(code, first + c) += row(c);
    });
  });
}

Eigen::Matrix3d TiedModel::direction_projector(const Link& link) const {
  const Eigen::Vector3d line = (points_.row(link.to) - points_.row(link.from)).transpose();
  const double size = (points_.colwise().maxCoeff() - points_.colwise().minCoeff()).norm();
  // Closer than round-off of coordinates tells no direction.
  if (line.norm() < 1e-9 * size) return Eigen::Matrix3d::Identity();
  return line * line.transpose() / line.squaredNorm();
}

Eigen::MatrixXd TiedModel::interior_part(const Eigen::Ref<const Eigen::MatrixXd>& U,
                                         const Eigen::Ref<const Eigen::MatrixXd>& rotations,
                                         const std::vector<Eigen::MatrixXd>& interface_motions) const {
  Eigen::MatrixXd u_i(n_i_, U.cols());
  for (std::size_t d = 0; d < code_.size(); ++d)
    if (code_[d] >= 0) u_i.row(code_[d]) = U.row(static_cast<Eigen::Index>(d));
  for (std::size_t r = 0; r < rotation_code_.size(); ++r)
    for (int d = 0; d < 3; ++d)
      if (const int code = rotation_code_[r][d]; code >= 0)
        u_i.row(code) = rotations.row(3 * static_cast<Eigen::Index>(r) + d);
  for (std::size_t k = 0; k < interfaces_.size(); ++k)
    if (interfaces_[k].tie == Tie::rigid)
      for (int direction = 0; direction < 6; ++direction)
        if (const int code = interfaces_[k].code[direction]; code >= 0)
          u_i.row(code) = interface_motions[k].row(direction);
  return u_i;
}

std::vector<int> TiedModel::interior_in(const TiedModel& other) const {
  std::vector<int> place(n_i_, -1);
  const auto match = [&](int code, int there) {
    if (code >= 0 && there >= 0) place[code] = there;
  };
  for (std::size_t d = 0; d < code_.size(); ++d) match(code_[d], other.code_[d]);
  for (std::size_t r = 0; r < rotation_code_.size(); ++r)
    for (int d = 0; d < 3; ++d) match(rotation_code_[r][d], other.rotation_code_[r][d]);
  for (std::size_t k = 0; k < interfaces_.size(); ++k)
    if (interfaces_[k].tie == Tie::rigid && other.interfaces_[k].tie == Tie::rigid)
      for (int direction = 0; direction < 6; ++direction)
        match(interfaces_[k].code[direction], other.interfaces_[k].code[direction]);
  return place;
}

Eigen::MatrixXd TiedModel::rigid_b() const {
  Eigen::MatrixXd R(n_b_, 6);
  for (const InterfaceDofs& interface : interfaces_) {
    const Eigen::Matrix<double, 6, 6> motion = node_motion_at(interface.point);
    int b = interface.first_b;
    for (int direction : interface.directions) R.row(b++) = motion.row(direction);
  }
  return R;
}

Eigen::MatrixXd TiedModel::rigid_i() const {
  std::vector<Eigen::MatrixXd> motions;
  for (const InterfaceDofs& interface : interfaces_) motions.push_back(node_motion_at(interface.point));
  return interior_part(rigid_nodes(), rigid_rotations(), motions);
}

Eigen::MatrixXd TiedModel::rigid_rotations() const {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * n_rotations(), 6);
  for (int r = 0; r < n_rotations(); ++r) R.block<3, 3>(3 * r, 3).setIdentity();
  return R;
}

Eigen::MatrixXd TiedModel::expand_rotations(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                            const Eigen::Ref<const Eigen::MatrixXd>& u_b) const {
  Eigen::MatrixXd rotations(3 * n_rotations(), u_i.cols());
  for (int r = 0; r < n_rotations(); ++r)
    for (int d = 0; d < 3; ++d) {
      const int code = rotation_code_[r][d];
      if (code >= 0)
        rotations.row(3 * r + d) = u_i.row(code);
      else
        rotations.row(3 * r + d) = u_b.row(boundary_of(code));
    }
  return rotations;
}

Eigen::MatrixXd TiedModel::rigid_nodes() const {
  Eigen::MatrixXd R(3 * static_cast<Eigen::Index>(n_nodes_), 6);
  for (int node = 0; node < n_nodes_; ++node)
    R.middleRows<3>(3 * static_cast<Eigen::Index>(node)) = motion_at(points_.row(node));
  return R;
}

// Where a direction of a rigid tie's or a single node's interface is.
int TiedModel::code_of(const InterfaceDofs& interface, int d) const {
  if (interface.tie != Tie::node) return interface.code[d];
  const mesh::Index node = interface.nodes[0];
  if (d < 3) return code_[3 * static_cast<std::size_t>(node) + d];
  return rotation_of_[node] >= 0 ? rotation_code_[rotation_of_[node]][d - 3] : kUnused;
}

Eigen::MatrixXd TiedModel::interface_motion(int k, const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                            const Eigen::Ref<const Eigen::MatrixXd>& u_b) const {
  const InterfaceDofs& interface = interfaces_[k];
  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(6, u_i.cols());
  if (interface.tie == Tie::average) {
    for (std::size_t a = 0; a < interface.nodes.size(); ++a)
      each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
        q += interface.average.middleCols<3>(3 * static_cast<Eigen::Index>(a)) * C * u_i.row(code);
      });
    return q;
  }
  for (int d = 0; d < 6; ++d) {
    const int code = code_of(interface, d);
    if (is_dof(code)) q.row(d) = code >= 0 ? u_i.row(code) : u_b.row(boundary_of(code));
  }
  return q;
}

Eigen::MatrixXd TiedModel::interface_load(int k, const Eigen::Ref<const Eigen::MatrixXd>& load) const {
  const InterfaceDofs& interface = interfaces_[k];
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(n_i_, load.cols());
  if (interface.tie == Tie::average) {
    for (std::size_t a = 0; a < interface.nodes.size(); ++a)
      each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
        f.row(code) +=
            (interface.average.middleCols<3>(3 * static_cast<Eigen::Index>(a)) * C).transpose() * load;
      });
    return f;
  }
  for (int d = 0; d < 6; ++d) {
    const int code = code_of(interface, d);
    if (code >= 0) f.row(code) += load.row(d);
  }
  return f;
}

std::string TiedModel::describe_dof(int i) const {
  const auto describe = [&](int node, const char* how, int axis) {
    const std::int64_t label = node_label_.empty() ? static_cast<std::int64_t>(node) : node_label_[node];
    return fmt::format("node {} at ({:.5g}, {:.5g}, {:.5g}) m {} {}", label, points_(node, 0),
                       points_(node, 1), points_(node, 2), how, "xyz"[axis]);
  };
  const auto found = std::find(code_.begin(), code_.end(), i);
  if (found != code_.end()) {
    const auto place = static_cast<int>(found - code_.begin());
    return describe(place / 3, "in", place % 3);
  }
  for (int node = 0; node < n_nodes_; ++node)
    for (int d = 0; d < 3 && rotation_of_[node] >= 0; ++d)
      if (rotation_code_[rotation_of_[node]][d] == i) return describe(node, "in its rotation about", d);
  return "an interface node";
}

}  // namespace flexura::reduce
