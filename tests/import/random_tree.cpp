// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/import/random_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <map>

#include "import/model/folder.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/library/simulation.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

KDL::Vector to_kdl(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

KDL::Frame to_kdl(const Eigen::Isometry3d& X) {
  const Matrix3d R = X.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          to_kdl(X.translation())};
}

KDL::RigidBodyInertia to_kdl(const DrawnBody& b) {
  const Matrix3d& I = b.inertia;
  return KDL::RigidBodyInertia(b.mass, to_kdl(b.center),
                               KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
}

// KDL's constructor takes the inertia about the centre, in the axes of the body.
KDL::Tree tree_of(const DrawnTree& tree) {
  KDL::Tree out("ground");
  std::vector<std::string> last;
  for (const DrawnBody& b : tree.bodies) {
    std::string before = b.parent < 0 ? "ground" : last[static_cast<std::size_t>(b.parent)];
    Eigen::Isometry3d X = b.X_PB;
    if (b.joints.empty())
      out.addSegment(
          KDL::Segment(b.name, KDL::Joint(b.name + "_fixed", KDL::Joint::Fixed), to_kdl(X), to_kdl(b)),
          before);
    for (std::size_t k = 0; k < b.joints.size(); ++k) {
      const DrawnJoint& j = b.joints[k];
      const bool is_last = k + 1 == b.joints.size();
      const std::string name = is_last ? b.name : fmt::format("{}_{}", b.name, k);
      out.addSegment(KDL::Segment(name,
                                  KDL::Joint(j.name, to_kdl(Vector3d(X * j.point)),
                                             to_kdl(Vector3d(X.linear() * j.axis)),
                                             j.slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis),
                                  to_kdl(X), is_last ? to_kdl(b) : KDL::RigidBodyInertia::Zero()),
                     before);
      before = name;
      X.setIdentity();
    }
    last.push_back(b.name);
  }
  return out;
}

}  // namespace

double DrawnTree::mass() const {
  double sum = 0.0;
  for (const DrawnBody& b : bodies) sum += b.mass;
  return sum;
}

int DrawnTree::freedoms() const {
  int n = 0;
  for (const DrawnBody& b : bodies) n += static_cast<int>(b.joints.size());
  return n;
}

DrawnTree draw_tree(Dice& dice, int most_joints) {
  DrawnTree tree;
  const int n = 1 + dice.whole(6);
  for (int i = 0; i < n; ++i) {
    DrawnBody b;
    b.name = fmt::format("b{}", i);
    b.parent = i == 0 ? -1 : dice.whole(i + 1) - 1;
    b.X_PB.linear() = dice.axes();
    b.X_PB.translation() = dice.point(0.5);
    const int joints = i == 0 ? 1 + dice.whole(most_joints) : dice.whole(most_joints + 1);
    for (int k = 0; k < joints; ++k) {
      DrawnJoint j;
      j.name = fmt::format("j{}_{}", i, k);
      j.slides = dice.chance(0.3);
      j.point = dice.point(0.3);
      j.axis = dice.direction();
      if (dice.chance(0.5)) j.damping = dice.real(0.0, 1.0);
      if (dice.chance(0.4)) {
        j.stiffness = dice.real(0.0, 20.0);
        j.rest = dice.real(-0.5, 0.5);
      }
      j.q = dice.real(-1.0, 1.0);
      j.v = dice.real(-1.0, 1.0);
      b.joints.push_back(j);
    }
    b.mass = dice.real(0.2, 3.0);
    b.center = dice.point(0.2);
    const Vector3d p = b.mass * Vector3d(dice.real(0.1, 1), dice.real(0.1, 1), dice.real(0.1, 1)) * 0.02;
    const Matrix3d R = dice.axes();
    b.inertia = R * Vector3d(p.sum() - p.array()).asDiagonal() * R.transpose();
    tree.bodies.push_back(b);
  }
  return tree;
}

std::string numbers(const std::vector<double>& v) {
  std::string out;
  for (const double x : v) out += fmt::format("{}{:.17g}", out.empty() ? "" : " ", x);
  return out;
}

std::string numbers(const Vector3d& v) {
  return numbers(std::vector<double>(v.begin(), v.end()));
}

Vector3d roll_pitch_yaw(const Matrix3d& R) {
  const Vector3d zyx = R.eulerAngles(2, 1, 0);
  return {zyx[2], zyx[1], zyx[0]};
}

std::string judge(const import::Mechanism& mechanism, const DrawnTree& tree,
                  const std::vector<double>& others) {
  const Folder folder;
  import::write_folder(folder / "m", mechanism, {}, false);
  std::vector<std::string> set;
  for (const DrawnBody& b : tree.bodies)
    for (const DrawnJoint& j : b.joints) {
      set.push_back(fmt::format("joint.{}.{}={:.17g}", j.name, j.slides ? "position" : "angle", j.q));
      set.push_back(fmt::format("joint.{}.speed={:.17g}", j.name, j.v));
    }
  const mbs::MechanismFile file = mbs::read_mechanism(folder / "m/mechanism.toml", mbs::solver_schema(), set);
  double mass = 0.0;
  for (const import::Body& b : mechanism.bodies) mass += b.mass;
  if (std::abs(mass - tree.mass()) > 1e-12 * tree.mass())
    return fmt::format("mass {} instead of {}", mass, tree.mass());
  const mbs::Simulation run{mbs::Mechanism(file.description)};
  const auto sizes = run.mechanism().sizes();
  if (sizes.n_v - sizes.n_lambda != tree.freedoms())
    return fmt::format("{} degrees of freedom instead of {}", sizes.n_v - sizes.n_lambda, tree.freedoms());
  KDL::Tree kdl = tree_of(tree);
  const unsigned n = kdl.getNrOfJoints();
  KDL::TreeIdSolver_RNE solver(kdl, to_kdl(tree.gravity));
  KDL::JntArray q(n), v(n), a(n), torques(n);
  std::map<std::string, unsigned> place;
  for (const auto& [name, element] : kdl.getSegments())
    if (element.segment.getJoint().getType() != KDL::Joint::Fixed)
      place[element.segment.getJoint().getName()] = element.q_nr;
  for (const DrawnBody& b : tree.bodies)
    for (const DrawnJoint& j : b.joints) {
      const unsigned k = place.at(j.name);
      q(k) = j.q - j.zero;
      v(k) = j.v;
      a(k) = run.output(j.name + ".acceleration");
    }
  if (solver.CartToJnt(q, v, a, {}, torques) < 0) return "KDL fails";
  // Residuals of forces, of accelerations up to some 1e3 and inertias up to 1e1, are sums of numbers up to `size`, with some 1e-14 of it; the
  // state is closed onto rotors to 1e-9 of the mechanism's size at most, and springs take that as force.
  double worst = 0.0, size = 1.0;
  std::string who;
  std::size_t i = 0;
  for (const DrawnBody& b : tree.bodies)
    for (const DrawnJoint& j : b.joints) {
      const unsigned k = place.at(j.name);
      const double force =
          -j.stiffness * (j.q - j.rest) - j.damping * j.v + (i < others.size() ? others[i] : 0.0);
      const double inertia_force = torques(k) + j.armature * a(k);
      size = std::max({size, std::abs(force), std::abs(inertia_force), std::abs(j.armature * a(k))});
      if (const double off = std::abs(inertia_force - force); off > worst) {
        worst = off;
        who = fmt::format("{}: {} N or N m for {}", j.name, inertia_force, force);
      }
      ++i;
    }
  return worst > 1e-8 * size ? fmt::format("{}, off by {:.2g} of {:.3g}", who, worst, size) : "";
}

}  // namespace flexura::test
