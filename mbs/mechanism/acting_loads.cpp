// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/acting_loads.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <set>
#include <utility>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;

/// Unit wrenches (torque, force) about the marker in its own axes, as loads on the superelement.
MatrixXd marker_loads(const BodyNodes& nodes, const MarkerDescription& marker) {
  const Matrix3d& R = marker.X_BP.R;
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = R;
  axes.bottomRightCorner<3, 3>() = R;
  const BodyNode& node = nodes[marker.node];
  return node_loads(node, marker.X_BP.p) * axes;
}

/// Columns of free motion (rotations first, as in a twist) at the origin of F or of M, in its axes.
MatrixXd free_motion(const Joint& joint, const std::vector<double>& q, bool in_M) {
  MotionMatrix S(6, joint.n_v());
  joint.motion(q.data(), S);
  const Pose X = joint.pose(q.data());
  for (Eigen::Index k = 0; k < S.cols(); ++k) {
    const Vector3d w = S.col(k).head<3>(), u = S.col(k).tail<3>();
    if (in_M)
      S.col(k) << X.R.transpose() * w, X.R.transpose() * u;
    else
      S.col(k).tail<3>() = u - w.cross(X.p);  // of the point that is at Fo now
  }
  return S;
}

/// What is orthogonal to the free motions: directions of the frame's axes first, then the combinations by which the joint
/// ties others (a thread: z and the turn about it).
MatrixXd locked_by(const MatrixXd& S) {
  MatrixXd locked(6, 0);
  const auto add = [&](const Eigen::VectorXd& direction) {
    locked.conservativeResize(Eigen::NoChange, locked.cols() + 1);
    locked.rightCols<1>() = direction;
  };
  std::vector<int> moving;
  for (int k = 0; k < 6; ++k) {
    if (S.row(k).isZero(1e-12))
      add(Eigen::VectorXd::Unit(6, k));
    else
      moving.push_back(k);
  }
  if (moving.empty()) return locked;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(S(moving, Eigen::all));
  const MatrixXd Q = qr.householderQ();
  for (Eigen::Index k = qr.rank(); k < Q.cols(); ++k) {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(6);
    direction(moving) = Q.col(k);
    add(direction);
  }
  return locked;
}

/// Rotations that the motions let free by themselves.
std::vector<int> released_by(const MatrixXd& S) {
  std::vector<int> out;
  if (S.cols() == 0) return out;
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> span(S);
  for (int k = 0; k < 3; ++k) {
    const Eigen::VectorXd e = Eigen::VectorXd::Unit(6, k);
    if ((S * span.solve(e) - e).norm() < 1e-9) out.push_back(k);
  }
  return out;
}

/// Coordinates where the joint's frames coincide, and two others.
std::vector<std::vector<double>> some_configurations(const Joint& joint) {
  std::vector<double> q(std::max(joint.n_p(), 1)), d(std::max(joint.n_v(), 1));
  joint.reference(q.data());
  std::vector<std::vector<double>> out(3, q);
  for (int k = 1; k < 3; ++k) {
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = 0.3 + 0.17 * static_cast<double>(i) - 0.9 * (k - 1);
    if (joint.n_v() > 0) joint.retract(q.data(), d.data(), out[k].data());
  }
  return out;
}

/// 6 x k, where its frames coincide.
MatrixXd locked_directions(const Joint& joint) {
  return locked_by(free_motion(joint, some_configurations(joint).front(), false));
}

/// Rotations about axes that stand still in the frame and that it lets free wherever it is.
std::vector<int> released_rotations(const Joint& joint, bool in_M) {
  std::vector<int> out = {0, 1, 2};
  for (const auto& q : some_configurations(joint)) {
    const std::vector<int> here = released_by(free_motion(joint, q, in_M));
    std::erase_if(out, [&](int k) { return std::ranges::find(here, k) == here.end(); });
  }
  return out;
}

}  // namespace

int marker_on(const MechanismDescription& d, const JointDescription& joint, int body) {
  for (const int marker : {joint.marker_F, joint.marker_M})
    if (d.markers[marker].body == body) return marker;
  return -1;
}

bool locks_the_same_wherever_it_is(const MechanismDescription& d, const JointDescription& joint, int body) {
  const bool in_M = marker_on(d, joint, body) == joint.marker_M;
  const MatrixXd at_first = locked_directions(*joint.joint);
  return std::ranges::all_of(some_configurations(*joint.joint), [&](const std::vector<double>& q) {
    const MatrixXd S = free_motion(*joint.joint, q, in_M);
    return (at_first.transpose() * S).isZero(1e-9) && locked_by(S).cols() == at_first.cols();
  });
}

const JointDescription* frame_joint(const MechanismDescription& d, int body) {
  for (const bool cut : {false, true})
    for (const JointDescription& joint : d.joints)
      if (joint.cut == cut)
        if (const int marker = marker_on(d, joint, body); marker >= 0 && d.markers[marker].node >= 0)
          return &joint;
  return nullptr;
}

const JointDescription* joint_to_payload(const MechanismDescription& d, int body) {
  const auto on = [&](int marker) { return d.markers[static_cast<std::size_t>(marker)].body; };
  std::vector<std::pair<int, int>> links;
  for (const JointDescription& joint : d.joints) links.emplace_back(on(joint.marker_F), on(joint.marker_M));
  for (const auto& constraint : d.constraints)
    for (const int marker : constraint->markers())
      links.emplace_back(on(constraint->markers().front()), on(marker));
  std::vector<bool> is_held(d.bodies.size(), false);
  const auto spread = [&](int seed) {
    is_held[static_cast<std::size_t>(seed)] = true;
    for (bool grows = true; grows;) {
      grows = false;
      for (const auto& [a, b] : links) {
        const bool from = is_held[static_cast<std::size_t>(a)], to = is_held[static_cast<std::size_t>(b)];
        if (a == body || b == body || from == to) continue;
        is_held[static_cast<std::size_t>(from ? b : a)] = grows = true;
      }
    }
  };
  const auto beyond = [&](const JointDescription&
                              joint) {  // the body at the joint's other end; -1 where it is not one of its
    const int F = on(joint.marker_F), M = on(joint.marker_M);
    return F == body ? M : M == body ? F : -1;
  };
  const auto is_supported = [&](const JointDescription& joint) {
    const int other = beyond(joint);
    return other >= 0 && is_held[static_cast<std::size_t>(other)];
  };
  spread(0);
  // Where nothing leads to the ground, what the first joint comes from carries it: a boom on a free hub.
  if (std::ranges::none_of(d.joints, is_supported))
    for (const JointDescription& joint : d.joints)
      if (on(joint.marker_M) == body) {
        spread(on(joint.marker_F));
        break;
      }
  for (const JointDescription& joint : d.joints)
    if (beyond(joint) >= 0 && !is_supported(joint)) return &joint;
  return nullptr;
}

MatrixXd held_directions(const BodyNodes& nodes, const MechanismDescription& d, const JointDescription& joint,
                         int body) {
  const MarkerDescription& marker = d.markers[marker_on(d, joint, body)];
  return marker_loads(nodes, marker) * locked_directions(*joint.joint);
}

bool keeps(const superelement::Superelement& se, const BodyNodes& nodes, const MechanismDescription& d,
           const JointDescription& joint, int body) {
  const MarkerDescription& marker = d.markers[marker_on(d, joint, body)];
  BodyNode rigid;  // in the coordinates of rigid motions
  rigid.rows = MatrixXd::Identity(6, 6);
  rigid.rows.topRightCorner<3, 3>() = -skew(nodes[marker.node].p_BoN_B);
  const MatrixXd whole = held_directions(BodyNodes(nodes.size(), rigid), d, joint, body),
                 kept = superelement::rigid_motions(se).transpose() * held_directions(nodes, d, joint, body);
  return (kept - whole).norm() <= 1e-6 * whole.norm();
}

MatrixXd held_by_joints(const superelement::Superelement& se, const BodyNodes& nodes,
                        const MechanismDescription& d, int body) {
  const MatrixXd R = superelement::rigid_motions(se);
  // As a rigid body of about its own size sees them: lengths count like radians.
  double size = 0.0;
  for (const superelement::Interface& a : se.interfaces)
    for (const superelement::Interface& b : se.interfaces)
      size = std::max(size, (a.p_BoN_B - b.p_BoN_B).norm());
  if (!(size > 0.0)) size = 1.0;
  MatrixXd held(se.n(), 0), basis(6, 0);
  for (const bool displacements : {true, false})
    for (const JointDescription& joint : d.joints) {
      const int marker = marker_on(d, joint, body);
      if (marker < 0 || d.markers[marker].node < 0) continue;
      const MatrixXd all = locked_directions(*joint.joint);
      std::vector<int> locked;
      for (int k = 0; k < static_cast<int>(all.cols()); ++k)
        if (!all.col(k).tail<3>().isZero(0.0) == displacements) locked.push_back(k);
      if (locked.empty()) continue;
      const MatrixXd loads = marker_loads(nodes, d.markers[marker]) * all(Eigen::all, locked);
      MatrixXd rows = loads.transpose() * R;  // columns of R: translations, then rotations
      if (displacements) rows.rightCols<3>() /= size;
      for (int pass = 0; pass < 2; ++pass) rows -= (rows * basis * basis.transpose()).eval();
      // What these hold that is not held yet, by principal directions: of two pins the line between them, whatever their axes.
      const Eigen::JacobiSVD<MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
      for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i) {
        // A frame must not hang on nearly parallel directions.
        if (svd.singularValues()(i) < 1e-3 || basis.cols() == 6) break;
        basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
        basis.rightCols<1>() = svd.matrixV().col(i);
        held.conservativeResize(Eigen::NoChange, held.cols() + 1);
        held.rightCols<1>() = loads * svd.matrixU().col(i);
      }
    }
  return held;
}

MatrixXd loads_on(const BodyNodes& nodes, const MechanismDescription& d, int body, int node) {
  const auto is_here = [&](int marker) {
    return marker >= 0 && d.markers[marker].body == body && d.markers[marker].node == node;
  };
  const JointDescription* only = nullptr;
  int acting = 0;
  std::vector<CoordinateRef> acted_on;  // joint coordinates: what acts there goes through the joint
  bool may_act_anywhere = false;
  for (const JointDescription& joint : d.joints) {
    if (!is_here(marker_on(d, joint, body))) continue;
    ++acting;
    only = &joint;
  }
  const auto note = [&](const std::vector<int>& markers, const std::vector<CoordinateRef>& coordinates) {
    acted_on.insert(acted_on.end(), coordinates.begin(), coordinates.end());
    acting += 2 * static_cast<int>(std::ranges::count_if(markers, is_here));
    may_act_anywhere = may_act_anywhere ||
                       (coordinates.empty() && std::ranges::all_of(markers, [](int m) { return m < 0; }));
  };
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    note({from, to}, force->coordinates());
  }
  for (const auto& constraint : d.constraints) note(constraint->markers(), constraint->coordinates());
  const bool turns_freely =
      acting == 1 && only && !only->is_driven() && !may_act_anywhere &&
      std::ranges::none_of(acted_on, [&](const CoordinateRef& c) { return &d.joints[c.joint] == only; });
  if (!turns_freely) return node_loads(nodes[node]);
  const int marker = marker_on(d, *only, body);
  const std::vector<int> released = released_rotations(*only->joint, marker == only->marker_M);
  if (released.empty()) return node_loads(nodes[node]);
  const MatrixXd all = marker_loads(nodes, d.markers[marker]);
  MatrixXd loads(all.rows(), 0);
  for (int k = 0; k < 6; ++k) {
    if (std::ranges::find(released, k) != released.end()) continue;
    loads.conservativeResize(Eigen::NoChange, loads.cols() + 1);
    loads.rightCols<1>() = all.col(k);
  }
  return loads;
}

std::array<bool, 6> loaded_directions(const BodyNodes& nodes, const MechanismDescription& d, int body,
                                      int node) {
  const auto is_here = [&](int marker) {
    return marker >= 0 && d.markers[marker].body == body && d.markers[marker].node == node;
  };
  for (const auto& force : d.forces)
    if (const auto [from, to] = force->markers(); is_here(from) || is_here(to))
      return {true, true, true, true, true, true};
  for (const auto& constraint : d.constraints)
    if (std::ranges::any_of(constraint->markers(), is_here)) return {true, true, true, true, true, true};
  BodyNode six;  // whose six motions are coordinates
  six.rows = MatrixXd::Identity(6, 6);
  std::array<bool, 6> out{};
  for (const JointDescription& joint : d.joints) {
    const int marker = marker_on(d, joint, body);
    if (!is_here(marker)) continue;
    BodyNodes alone(nodes.size(), six);
    const MatrixXd loads = marker_loads(alone, d.markers[marker]) *
                           (joint.is_driven() ? Matrix6d::Identity() : locked_directions(*joint.joint));
    constexpr double kParallel = 1e-9;
    for (Eigen::Index k = 0; k < loads.cols(); ++k)
      for (int row = 0; row < 6; ++row)
        out[row] = out[row] || std::abs(loads(row, k)) > kParallel * loads.col(k).norm();
  }
  return out;
}

std::vector<int> loaded_nodes(const MechanismDescription& d, int body) {
  std::set<int> found;
  const auto take = [&](int marker) {
    if (marker >= 0 && d.markers[marker].body == body && d.markers[marker].node >= 0)
      found.insert(d.markers[marker].node);
  };
  for (const JointDescription& joint : d.joints) {
    if (joint.joint->n_rows() == 0 && !joint.is_driven()) continue;  // carries no load
    take(joint.marker_F);
    take(joint.marker_M);
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    take(from);
    take(to);
  }
  for (const auto& constraint : d.constraints)
    for (const int marker : constraint->markers()) take(marker);
  return {found.begin(), found.end()};
}

}  // namespace flexura::mbs
