// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_motions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_codes.hpp"
#include "reduce/assembly/tied_spread.hpp"

namespace flexura::reduce {

void TiedMotions::expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
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

void TiedMotions::gather(const Eigen::Ref<const Eigen::MatrixXd>& F, Eigen::MatrixXd& f_i,
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

Eigen::MatrixXd TiedMotions::interior_part(const Eigen::Ref<const Eigen::MatrixXd>& U,
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

std::vector<int> TiedMotions::interior_in(const TiedMotions& other) const {
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

Eigen::MatrixXd TiedMotions::rigid_b() const {
  Eigen::MatrixXd R(n_b_, 6);
  for (const InterfaceDofs& interface : interfaces_) {
    const Eigen::Matrix<double, 6, 6> motion = node_motion_at(interface.point);
    int b = interface.first_b;
    for (int direction : interface.directions) R.row(b++) = motion.row(direction);
  }
  return R;
}

Eigen::MatrixXd TiedMotions::rigid_i() const {
  std::vector<Eigen::MatrixXd> motions;
  for (const InterfaceDofs& interface : interfaces_) motions.push_back(node_motion_at(interface.point));
  return interior_part(rigid_nodes(), rigid_rotations(), motions);
}

Eigen::MatrixXd TiedMotions::rigid_rotations() const {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * n_rotations(), 6);
  for (int r = 0; r < n_rotations(); ++r) R.block<3, 3>(3 * r, 3).setIdentity();
  return R;
}

Eigen::MatrixXd TiedMotions::expand_rotations(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
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

Eigen::MatrixXd TiedMotions::rigid_nodes() const {
  Eigen::MatrixXd R(3 * static_cast<Eigen::Index>(n_nodes_), 6);
  for (int node = 0; node < n_nodes_; ++node)
    R.middleRows<3>(3 * static_cast<Eigen::Index>(node)) = motion_at(points_.row(node));
  return R;
}

// Where a direction of a rigid tie's or a single node's interface is.
int TiedMotions::code_of(const InterfaceDofs& interface, int d) const {
  if (interface.tie != Tie::node) return interface.code[d];
  const mesh::Index node = interface.nodes[0];
  if (d < 3) return code_[3 * static_cast<std::size_t>(node) + d];
  return rotation_of_[node] >= 0 ? rotation_code_[rotation_of_[node]][d - 3] : kUnused;
}

Eigen::MatrixXd TiedMotions::interface_motion(int k, const Eigen::Ref<const Eigen::MatrixXd>& u_i,
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

Eigen::MatrixXd TiedMotions::interface_load(int k, const Eigen::Ref<const Eigen::MatrixXd>& load) const {
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

std::string TiedMotions::describe_dof(int i) const {
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
