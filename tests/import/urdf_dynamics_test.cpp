// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// An arm of seven axes in prescribed motion: its positions against the product of its transforms, the torques of its
// drives against KDL's recursive Newton-Euler solver; both from the URDF as urdfdom reads it.
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "tests/import/kdl_tree.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

constexpr int kJoints = 7;
constexpr double kAmplitude[kJoints] = {1.1, 0.9, 1.3, 2.0, 1.2, 0.04, 3.0},
                 kRate[kJoints] = {1.7, 2.3, 1.9, 3.1, 2.9, 4.1, 1.3},
                 kPhase[kJoints] = {0.1, 1.2, 2.1, 0.4, -0.8, 0.6, 0.3};

double q(int j, double t) {
  return kAmplitude[j] * std::sin(kRate[j] * t + kPhase[j]);
}
double v(int j, double t) {
  return kAmplitude[j] * kRate[j] * std::cos(kRate[j] * t + kPhase[j]);
}
double a(int j, double t) {
  return -kRate[j] * kRate[j] * q(j, t);
}

class ArmInPrescribedMotion : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Folder folder;  // without stops: kinematics locates no switches
    std::vector<std::string> words = {"--set", "solver.method=kinematics", "solver.end_time=1",
                                      "solver.output_step=0.05", "output.quantities=[\"*\"]"};
    for (int j = 0; j < kJoints; ++j)
      words.push_back(
          fmt::format("joint.j{}.drive={}*sin({}*t+({}))", j + 1, kAmplitude[j], kRate[j], kPhase[j]));
    run_ = new results::Run(run_robot(folder, sample("arm.urdf"), words, {"--no-stops"}));
    model_ = urdf::parseURDF(read_text(sample("arm.urdf")));
  }
  static void TearDownTestSuite() {
    delete run_;
    model_.reset();
  }
  static std::vector<urdf::JointConstSharedPtr> joints() {
    std::vector<urdf::JointConstSharedPtr> list;
    for (int j = 0; j < kJoints; ++j) list.push_back(model_->getJoint(fmt::format("j{}", j + 1)));
    list.push_back(model_->getJoint("tool_fixed"));
    return list;
  }

  static results::Run* run_;
  static urdf::ModelInterfaceSharedPtr model_;
};

results::Run* ArmInPrescribedMotion::run_ = nullptr;
urdf::ModelInterfaceSharedPtr ArmInPrescribedMotion::model_;

// urdfdom keeps rotations as quaternions, right to some 1e-16; eight transforms and half a metre of lever leave
// a few 1e-16 each.
TEST_F(ArmInPrescribedMotion, LinksStandWhereTheProductOfTransformsPutsThem) {
  ASSERT_EQ(run_->time.size(), 21);
  const char* const bodies[] = {"shoulder", "upper_arm", "forearm", "wrist_1",
                                "wrist_2",  "slide",     "flange",  "tool0"};
  for (Eigen::Index row = 0; row < run_->time.size(); ++row) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    int j = 0;
    for (const auto& joint : joints()) {
      const urdf::Pose& origin = joint->parent_to_joint_origin_transform;
      double w = 0, x = 0, y = 0, z = 0;
      origin.rotation.getQuaternion(x, y, z, w);
      X.translate(Eigen::Vector3d(origin.position.x, origin.position.y, origin.position.z));
      X.rotate(Eigen::Quaterniond(w, x, y, z).normalized());
      const Eigen::Vector3d axis = Eigen::Vector3d(joint->axis.x, joint->axis.y, joint->axis.z).normalized();
      if (joint->type == urdf::Joint::PRISMATIC)
        X.translate(q(j, run_->time[row]) * axis);
      else if (joint->type != urdf::Joint::FIXED)
        X.rotate(Eigen::AngleAxisd(q(j, run_->time[row]), axis));
      const auto pose = body(*run_, bodies[j]).pose.row(row);
      EXPECT_LT((X.translation() - pose.head<3>().transpose()).norm(), 1e-12)
          << bodies[j] << " at " << run_->time[row];
      const Eigen::Quaterniond R(pose[3], pose[4], pose[5], pose[6]);
      EXPECT_LT((X.linear() - R.toRotationMatrix()).norm(), 1e-12) << bodies[j] << " at " << run_->time[row];
      ++j;
    }
  }
}

// Drive forces solve a system with the mass matrix, whose condition is below 1e6 here (from 13 kg m^2 to 4e-4):
// 1e-10 of the largest torque; 1e-9 is asked.  The motor also moves the damper, d q'.
TEST_F(ArmInPrescribedMotion, DrivesTakeTheTorquesOfKdl) {
  KDL::Chain chain;
  std::vector<double> damping;
  for (const auto& joint : joints()) {
    const auto& inertial = model_->getLink(joint->child_link_name)->inertial;
    chain.addSegment(KDL::Segment(joint->child_link_name, to_kdl(*joint),
                                  to_kdl(joint->parent_to_joint_origin_transform),
                                  inertial ? to_kdl(*inertial) : KDL::RigidBodyInertia::Zero()));
    damping.push_back(joint->dynamics ? joint->dynamics->damping : 0.0);
  }
  ASSERT_EQ(chain.getNrOfJoints(), static_cast<unsigned>(kJoints));
  KDL::ChainIdSolver_RNE solver(chain, KDL::Vector(0, 0, -9.81));
  for (Eigen::Index row = 0; row < run_->time.size(); ++row) {
    const double t = run_->time[row];
    KDL::JntArray positions(kJoints), speeds(kJoints), accelerations(kJoints), torques(kJoints);
    for (int j = 0; j < kJoints; ++j) {
      positions(j) = q(j, t);
      speeds(j) = v(j, t);
      accelerations(j) = a(j, t);
    }
    ASSERT_GE(
        solver.CartToJnt(positions, speeds, accelerations, KDL::Wrenches(chain.getNrOfSegments()), torques),
        0);
    const double largest = torques.data.cwiseAbs().maxCoeff();
    for (int j = 0; j < kJoints; ++j)
      EXPECT_NEAR(column(*run_, fmt::format("j{}.drive_force", j + 1))[row],
                  torques(j) + damping[static_cast<std::size_t>(j)] * speeds(j), 1e-9 * largest)
          << "j" << j + 1 << " at " << t;
  }
}

}  // namespace
}  // namespace flexura::test
