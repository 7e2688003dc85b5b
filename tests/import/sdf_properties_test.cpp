// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Random SDF models move as KDL says, in the spelling of every version: poses in the model or in frames, axes in the model, the joint or any frame.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "import/sdf/convert.hpp"
#include "tests/app/command.hpp"
#include "tests/import/random_tree.hpp"

namespace flexura::test {
namespace {

std::string pose(const Eigen::Isometry3d& X) {
  return numbers(Vector3d(X.translation())) + " " + numbers(roll_pitch_yaw(X.linear()));
}

class Speller {
 public:
  Speller(Dice& dice, const DrawnTree& tree) : dice_(dice), tree_(tree), version_(dice.whole(3)) {}

  std::string spell() {
    for (const DrawnBody& b : tree_.bodies)
      X_M_.push_back(b.parent < 0 ? b.X_PB : X_M_[static_cast<std::size_t>(b.parent)] * b.X_PB);
    std::string text;
    if (version_ == 2) {  // 1.7 and later: a frame to give others in
      F_.linear() = dice_.axes();
      F_.translation() = dice_.point(1.0);
      text += fmt::format("<frame name=\"f\"><pose>{}</pose></frame>\n", pose(F_));
    }
    for (std::size_t i = 0; i < tree_.bodies.size(); ++i) text += link(i);
    for (std::size_t i = 0; i < tree_.bodies.size(); ++i) text += joint(i);
    const char* const versions[] = {"1.4", "1.6", "1.9"};
    return fmt::format(
        "<?xml version=\"1.0\"?>\n<sdf version=\"{}\"><world name=\"w\"><gravity>{}</gravity><model "
        "name=\"m\"><pose>{}</pose>\n{}</model></world></sdf>\n",
        versions[version_], numbers(tree_.gravity), pose(model_), text);
  }
  /// Of the model in the world: the tree hangs on it.
  void place_model(const Eigen::Isometry3d& X) { model_ = X; }

 private:
  std::string link(std::size_t i) {
    const DrawnBody& b = tree_.bodies[i];
    const Eigen::Quaterniond q(dice_.axes());
    const Matrix3d I = q.toRotationMatrix().transpose() * b.inertia * q.toRotationMatrix();
    Eigen::Isometry3d C = Eigen::Isometry3d::Identity();
    C.linear() = q.toRotationMatrix();
    C.translation() = b.center;
    std::string where = fmt::format("<pose>{}</pose>", pose(X_M_[i]));
    if (version_ == 2 && dice_.chance(0.5))
      where = fmt::format("<pose relative_to=\"f\">{}</pose>", pose(F_.inverse() * X_M_[i]));
    if (version_ == 2 && b.parent >= 0 && dice_.chance(0.3))
      where = fmt::format("<pose relative_to=\"b{}\">{}</pose>", b.parent, pose(b.X_PB));
    return fmt::format(
        "<link "
        "name=\"{}\">{}<inertial><pose>{}</pose><mass>{:.17g}</mass><inertia><ixx>{:.17g}</ixx><ixy>{:.17g}</"
        "ixy><ixz>{:.17g}</ixz>"
        "<iyy>{:.17g}</iyy><iyz>{:.17g}</iyz><izz>{:.17g}</izz></inertia></inertial>"
        "<collision name=\"c\"><geometry><box><size>0.1 0.2 0.3</size></box></geometry></collision></link>\n",
        b.name, where, pose(C), b.mass, I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2));
  }

  std::string axis(const DrawnJoint& j, const Matrix3d& R_MB, const Matrix3d& R_BJ, const char* tag) {
    const Vector3d in_model = R_MB * j.axis;
    std::string xyz, by_model;
    if (version_ == 0) {  // in the model's axes always
      xyz = numbers(in_model);
    } else if (dice_.chance(0.4)) {
      xyz = numbers(in_model);
      by_model = version_ == 1 ? "<use_parent_model_frame>true</use_parent_model_frame>" : "";
    } else {
      xyz = numbers(Vector3d(R_BJ.transpose() * j.axis));
    }
    std::string in;
    if (version_ == 2 && xyz == numbers(in_model)) in = " expressed_in=\"__model__\"";
    if (version_ == 2 && dice_.chance(0.3)) {
      xyz = numbers(Vector3d(F_.linear().transpose() * in_model));
      in = " expressed_in=\"f\"";
    }
    return fmt::format(
        "<{0}><xyz{1}>{2}</xyz>{3}<dynamics><damping>{4:.17g}</damping><spring_stiffness>{5:.17g}</"
        "spring_stiffness>"
        "<spring_reference>{6:.17g}</spring_reference></dynamics><limit><lower>-1e16</lower><upper>1e16</"
        "upper></limit></{0}>",
        tag, in, xyz, by_model, j.damping, j.stiffness, j.rest);
  }

  std::string joint(std::size_t i) {
    const DrawnBody& b = tree_.bodies[i];
    const std::string parent = b.parent < 0 ? "world" : tree_.bodies[static_cast<std::size_t>(b.parent)].name;
    if (b.joints.empty())
      return fmt::format(
          "<joint name=\"{0}_fixed\" type=\"fixed\"><parent>{1}</parent><child>{0}</child></joint>\n", b.name,
          parent);
    const DrawnJoint& j = b.joints.front();
    Eigen::Isometry3d J = Eigen::Isometry3d::Identity();
    J.linear() = dice_.axes();
    J.translation() = j.point;
    const bool two = b.joints.size() == 2;
    std::string axes = axis(j, X_M_[i].linear(), J.linear(), "axis");
    if (two) axes += axis(b.joints[1], X_M_[i].linear(), J.linear(), "axis2");
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\"><pose>{}</pose><parent>{}</parent><child>{}</child>{}</joint>\n",
        two ? "u" + std::to_string(i) : j.name,
        two        ? (dice_.chance(0.5) ? "universal" : "revolute2")
        : j.slides ? "prismatic"
                   : "revolute",
        pose(J), parent, b.name, axes);
  }

  Dice& dice_;
  const DrawnTree& tree_;
  int version_;
  std::vector<Eigen::Isometry3d> X_M_;
  Eigen::Isometry3d F_ = Eigen::Isometry3d::Identity(), model_ = Eigen::Isometry3d::Identity();
};

import::Mechanism read_sdf(const Folder& folder,
                           const std::string& text){const auto file = folder.write("m.sdf", text);
import::Findings findings(file);
return import::sdf::to_mechanism(file, {}, findings);
}  // namespace

TEST(RandomSdf, MovesAsKdlSays) {
  const Folder folder;
  for (unsigned seed = 1; seed <= 250; ++seed) {
    Dice dice(seed);
    DrawnTree tree = draw_tree(dice, 2);
    tree.gravity = dice.point(10.0);
    for (std::size_t i = 0; i < tree.bodies.size(); ++i)
      if (auto& joints = tree.bodies[i].joints; joints.size() == 2)  // one point, two turns
        for (std::size_t k = 0; k < 2; ++k) {
          joints[k].slides = false;
          joints[k].point = joints[0].point;
        }
    Speller speller(dice, tree);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = dice.axes();
    X.translation() = dice.point(2.0);
    speller.place_model(X);
    const std::string text = speller.spell();
    DrawnTree judged = tree;  // names as the mechanism has them
    for (std::size_t i = 0; i < judged.bodies.size(); ++i) {
      DrawnBody& b = judged.bodies[i];
      if (b.parent < 0) b.X_PB = X * b.X_PB;
      for (std::size_t k = 0; k < b.joints.size(); ++k)
        b.joints[k].name = b.joints.size() == 2 ? fmt::format("m_u{}_{}", i, k + 1) : "m_" + b.joints[k].name;
    }
    const std::string wrong = judge(read_sdf(folder, text), judged);
    ASSERT_EQ(wrong, "") << "seed " << seed << "\n" << text;
  }
}

}  // namespace flexura::test
}  // namespace flexura::test
