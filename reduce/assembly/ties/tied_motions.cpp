// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/ties/tied_motions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/ties/tied_codes.hpp"
#include "reduce/assembly/ties/tied_spread.hpp"

namespace flexura::reduce {

void TiedMotions::expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                         const Eigen::Ref<const Eigen::MatrixXd>& u_b, Eigen::MatrixXd& U) const {
  U.setZero(3 * static_cast<Eigen::Index>(numbering_.n_nodes()), u_i.cols());
  spread(
      numbering_,
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
  f_i.setZero(numbering_.n_i(), F.cols());
  f_b.setZero(numbering_.n_b(), F.cols());
  collect(numbering_, F, [&](int code, const auto& row) {
    if (code >= 0)
      f_i.row(code) += row;
    else
      f_b.row(boundary_of(code)) += row;
  });
}

Eigen::MatrixXd TiedMotions::interior_part(const Eigen::Ref<const Eigen::MatrixXd>& U,
                                           const Eigen::Ref<const Eigen::MatrixXd>& rotations,
                                           const std::vector<Eigen::MatrixXd>& interface_motions) const {
  const std::vector<int>& codes = numbering_.codes();
  const std::vector<InterfaceDofs>& interfaces = numbering_.interfaces();
  Eigen::MatrixXd u_i(numbering_.n_i(), U.cols());
  for (std::size_t d = 0; d < codes.size(); ++d)
    if (codes[d] >= 0) u_i.row(codes[d]) = U.row(static_cast<Eigen::Index>(d));
  for (int r = 0; r < numbering_.n_rotations(); ++r)
    for (int d = 0; d < 3; ++d)
      if (const int code = numbering_.rotation_code(r)[d]; code >= 0)
        u_i.row(code) = rotations.row(3 * static_cast<Eigen::Index>(r) + d);
  for (std::size_t k = 0; k < interfaces.size(); ++k)
    if (interfaces[k].tie == Tie::rigid)
      for (int direction = 0; direction < 6; ++direction)
        if (const int code = interfaces[k].code[direction]; code >= 0)
          u_i.row(code) = interface_motions[k].row(direction);
  return u_i;
}

std::vector<int> TiedMotions::interior_in(const TiedMotions& other) const {
  const TiedNumbering& there = other.numbering_;
  const std::vector<int>& codes = numbering_.codes();
  const std::vector<InterfaceDofs>& interfaces = numbering_.interfaces();
  std::vector<int> place(numbering_.n_i(), -1);
  const auto match = [&](int code, int code_there) {
    if (code >= 0 && code_there >= 0) place[code] = code_there;
  };
  for (std::size_t d = 0; d < codes.size(); ++d) match(codes[d], there.codes()[d]);
  for (int r = 0; r < numbering_.n_rotations(); ++r)
    for (int d = 0; d < 3; ++d) match(numbering_.rotation_code(r)[d], there.rotation_code(r)[d]);
  for (std::size_t k = 0; k < interfaces.size(); ++k)
    if (interfaces[k].tie == Tie::rigid && there.interfaces()[k].tie == Tie::rigid)
      for (int direction = 0; direction < 6; ++direction)
        match(interfaces[k].code[direction], there.interfaces()[k].code[direction]);
  return place;
}

Eigen::MatrixXd rigid_boundary(const TiedNumbering& numbering) {
  Eigen::MatrixXd R(numbering.n_b(), 6);
  for (const InterfaceDofs& interface : numbering.interfaces()) {
    const Eigen::Matrix<double, 6, 6> motion = node_motion_at(interface.point);
    int b = interface.first_b;
    for (int direction : interface.directions) R.row(b++) = motion.row(direction);
  }
  return R;
}

Eigen::MatrixXd TiedMotions::rigid_b() const {
  return rigid_boundary(numbering_);
}

Eigen::MatrixXd TiedMotions::rigid_i() const {
  std::vector<Eigen::MatrixXd> motions;
  for (const InterfaceDofs& interface : numbering_.interfaces())
    motions.push_back(node_motion_at(interface.point));
  return interior_part(rigid_nodes(), rigid_rotations(), motions);
}

Eigen::MatrixXd TiedMotions::rigid_rotations() const {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * numbering_.n_rotations(), 6);
  for (int r = 0; r < numbering_.n_rotations(); ++r) R.block<3, 3>(3 * r, 3).setIdentity();
  return R;
}

Eigen::MatrixXd TiedMotions::expand_rotations(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                              const Eigen::Ref<const Eigen::MatrixXd>& u_b) const {
  Eigen::MatrixXd rotations(3 * numbering_.n_rotations(), u_i.cols());
  for (int r = 0; r < numbering_.n_rotations(); ++r)
    for (int d = 0; d < 3; ++d) {
      const int code = numbering_.rotation_code(r)[d];
      if (code >= 0)
        rotations.row(3 * r + d) = u_i.row(code);
      else
        rotations.row(3 * r + d) = u_b.row(boundary_of(code));
    }
  return rotations;
}

Eigen::MatrixXd TiedMotions::rigid_nodes() const {
  Eigen::MatrixXd R(3 * static_cast<Eigen::Index>(numbering_.n_nodes()), 6);
  for (int node = 0; node < numbering_.n_nodes(); ++node)
    R.middleRows<3>(3 * static_cast<Eigen::Index>(node)) = motion_at(numbering_.points().row(node));
  return R;
}

Eigen::MatrixXd TiedMotions::interface_motion(int k, const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                              const Eigen::Ref<const Eigen::MatrixXd>& u_b) const {
  const InterfaceDofs& interface = numbering_.interfaces()[k];
  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(6, u_i.cols());
  if (interface.tie == Tie::average) {
    for (std::size_t a = 0; a < interface.nodes.size(); ++a)
      numbering_.each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
        q += averages_.of(k).middleCols<3>(3 * static_cast<Eigen::Index>(a)) * C * u_i.row(code);
      });
    return q;
  }
  for (int d = 0; d < 6; ++d) {
    const int code = numbering_.code_of(interface, d);
    if (is_dof(code)) q.row(d) = code >= 0 ? u_i.row(code) : u_b.row(boundary_of(code));
  }
  return q;
}

Eigen::MatrixXd TiedMotions::interface_load(int k, const Eigen::Ref<const Eigen::MatrixXd>& load) const {
  const InterfaceDofs& interface = numbering_.interfaces()[k];
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(numbering_.n_i(), load.cols());
  if (interface.tie == Tie::average) {
    for (std::size_t a = 0; a < interface.nodes.size(); ++a)
      numbering_.each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
        f.row(code) +=
            (averages_.of(k).middleCols<3>(3 * static_cast<Eigen::Index>(a)) * C).transpose() * load;
      });
    return f;
  }
  for (int d = 0; d < 6; ++d) {
    const int code = numbering_.code_of(interface, d);
    if (code >= 0) f.row(code) += load.row(d);
  }
  return f;
}

std::string TiedMotions::describe_dof(int i) const {
  const std::vector<int>& codes = numbering_.codes();
  const auto describe = [&](int node, const char* how, int axis) {
    const std::int64_t label = numbering_.label_of(node);
    return fmt::format("node {} at ({:.5g}, {:.5g}, {:.5g}) m {} {}", label, numbering_.points()(node, 0),
                       numbering_.points()(node, 1), numbering_.points()(node, 2), how, "xyz"[axis]);
  };
  const auto found = std::find(codes.begin(), codes.end(), i);
  if (found != codes.end()) {
    const auto place = static_cast<int>(found - codes.begin());
    return describe(place / 3, "in", place % 3);
  }
  for (int node = 0; node < numbering_.n_nodes(); ++node)
    for (int d = 0; d < 3 && numbering_.rotation_of(node) >= 0; ++d)
      if (numbering_.rotation_code(numbering_.rotation_of(node))[d] == i)
        return describe(node, "in its rotation about", d);
  return "an interface node";
}

}  // namespace flexura::reduce
