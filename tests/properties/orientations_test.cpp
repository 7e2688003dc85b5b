// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Where a file gives an orientation, a rotation vector, a quaternion, three angles of any sequence, direction cosines and two axes
// say the same.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "mbs/solver/start/prepare.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using mbs::chance::Chance;

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

TEST(Orientations, AreTheSameInEveryForm) {
  static constexpr const char* kSequences[] = {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx",
                                               "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"};
  const test::Folder folder;
  for (int seed = 0; seed < 240; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const std::string sequence = kSequences[seed % 12];
    const Vector3d angles(chance.between(-3, 3), chance.between(-3, 3), chance.between(-3, 3));
    Matrix3d R = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i)
      R *= Eigen::AngleAxisd(angles(i), Vector3d::Unit(sequence[static_cast<std::size_t>(i)] - 'x'))
               .toRotationMatrix();
    const Eigen::AngleAxisd turn(R);
    const Eigen::Quaterniond q(R);
    const std::string forms[] = {
        fmt::format(
            "angles = {}\n{}", list(angles),
            sequence == "xyz" && chance.flip(0.5) ? "" : fmt::format("sequence = \"{}\"\n", sequence)),
        fmt::format("rotation = {}\n", list(turn.angle() * turn.axis())),
        fmt::format("quaternion = [{:.17g}, {:.17g}, {:.17g}, {:.17g}]\n", q.w(), q.x(), q.y(), q.z()),
        fmt::format("direction_cosines = [{}, {}, {}]\n", list(R.col(0)), list(R.col(1)), list(R.col(2))),
        // To the digits of a hand: the rotation nearest to them is as near as they are.
        fmt::format("direction_cosines = [[{:.5f}, {:.5f}, {:.5f}], [{:.5f}, {:.5f}, {:.5f}], [{:.5f}, "
                    "{:.5f}, {:.5f}]]\n",
                    R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), R(0, 2), R(1, 2), R(2, 2)),
        fmt::format("axis = {}\nx_axis = {}\n", list(2.0 * R.col(2)), list(R.col(0) + 0.3 * R.col(2)))};
    std::string text =
        "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n" + forms[static_cast<std::size_t>(chance.below(4))];
    for (std::size_t k = 0; k < 6; ++k) text += fmt::format("[body.b.marker.m{}]\n{}", k, forms[k]);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("b.toml", text));
    const auto& markers = p.mechanism->description().markers;
    for (std::size_t k = 0; k < 6; ++k)
      for (const auto& marker : markers)
        if (marker.name == fmt::format("b.m{}", k))
          EXPECT_LT((marker.X_BP.R - R).cwiseAbs().maxCoeff(), k == 4 ? 2e-5 : 1e-14) << k;
    std::vector<mbs::Pose> poses;
    p.mechanism->body_poses(p.state, *p.mechanism->make_scratch(), poses);
    EXPECT_LT((poses[1].R - R).cwiseAbs().maxCoeff(), 1e-14);
    if (HasFailure()) return;
  }
}

TEST(Orientations, ThatAreNoneAreRefusedByTheirKeys) {
  const test::Folder folder;
  const auto refusal = [&](const std::string& keys) {
    try {
      mbs::prepare(folder.write("b.toml", "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n" + keys));
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_THAT(refusal("angles = [1, 0, 0]\nrotation = [1, 0, 0]\n"),
              testing::HasSubstr("has both rotation and angles"));
  EXPECT_THAT(refusal("sequence = \"zxz\"\n"), testing::HasSubstr("goes with angles only"));
  EXPECT_THAT(refusal("angles = [1, 0, 0]\nsequence = \"xxy\"\n"), testing::HasSubstr("sequence"));
  EXPECT_THAT(refusal("direction_cosines = [[1, 0, 0], [0, 1, 0]]\n"),
              testing::HasSubstr("not three vectors"));
  EXPECT_THAT(refusal("direction_cosines = [[1, 0, 0], [0.1, 1, 0], [0, 0, 1]]\n"),
              testing::HasSubstr("right angles"));
  EXPECT_THAT(refusal("direction_cosines = [[0, 1, 0], [1, 0, 0], [0, 0, 1]]\n"),
              testing::HasSubstr("left-handed"));
}

}  // namespace
}  // namespace flexura::properties
