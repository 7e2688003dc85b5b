// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every body: a mechanism file and MechanismBuilder take the same masses, inertias and stiffnesses and refuse the same, in the same words.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "mbs/forces/spring_damper.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/library/builder.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::mbs {
namespace {

using chance::Chance;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string of_builder(const RigidBody& body, const std::optional<Pose>& X = {}) {
  return test::refusal_of([&] {
    MechanismBuilder b;
    b.add("b", body, X);
  });
}

TEST_F(MechanismFileTest, BodiesAreJudgedAlikeInFilesAndInBuilders) {
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    // Of point masses, then made worse: what is possible is known from how it was made, not from the tensor.
    RigidBody body{.mass = chance.between(0.1, 5.0), .center = chance.vector(1.0)};
    for (int k = 0; k < 4; ++k) {
      const Vector3d r = chance.vector(0.5);
      body.inertia += chance.between(0.1, 1.0) * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(body.inertia);
    const int worse = chance.below(4);
    const Vector3d I = axes.eigenvalues(), u = axes.eigenvectors().col(2), w = axes.eigenvectors().col(0);
    // Beyond what the rounding of printed digits explains (1 % of the largest moment).
    if (worse == 1) body.inertia += 1.05 * (I[0] + I[1]) * u * u.transpose();
    if (worse == 2) body.inertia -= 1.05 * I[0] * w * w.transpose();
    if (worse == 3) body.mass = -body.mass;
    const Matrix3d& J = body.inertia;
    const std::string file_says =
        refusal(fmt::format("[body.b]\nmass = {:.17g}\ncenter = [{:.17g}, {:.17g}, {:.17g}]\ninertia = "
                            "[{:.17g}, {:.17g}, {:.17g}, "
                            "{:.17g}, {:.17g}, {:.17g}]\n",
                            body.mass, body.center.x(), body.center.y(), body.center.z(), J(0, 0), J(1, 1),
                            J(2, 2), J(0, 1), J(1, 2), J(2, 0)));
    const std::string builder_says = of_builder(body);
    EXPECT_EQ(builder_says == "accepted", worse == 0) << builder_says;
    EXPECT_EQ(file_says == "accepted", worse == 0) << file_says;
    if (worse == 1 || worse == 2) {
      const auto rule = builder_says.find("has the principal moments");
      ASSERT_NE(rule, std::string::npos);
      EXPECT_THAT(file_says, HasSubstr(builder_says.substr(rule)));
    }
    refused += worse != 0;
  }
  EXPECT_GT(refused, 150);
}

TEST_F(MechanismFileTest, BuildersRefuseWhatIsNoNumberNoRotationAndOfNobody) {
  EXPECT_THAT(of_builder({.mass = kNaN}), HasSubstr("body \"b\": mass is nan kg"));
  EXPECT_THAT(of_builder({.mass = 1.0, .center = {0, kNaN, 0}}), HasSubstr("center is not finite"));
  Matrix3d skew = Matrix3d::Identity();
  skew(0, 1) = 0.5;
  EXPECT_THAT(of_builder({.mass = 1.0, .inertia = skew}), HasSubstr("inertia is not symmetric"));
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    MechanismBuilder b, other;
    const auto body = b.add("b", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
    const auto foreign = other.add("b", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
    const auto ground = b.ground();
    const Vector3d p = chance.vector(2.0);
    const Matrix3d R = chance.rotation();
    EXPECT_EQ(test::refusal_of([&] { body.marker({R, p}); }), "accepted");
    // Scaled, mirrored, sheared by more than six digits round.
    const double factor = 1.0 + chance.either_sign(1e-4, 0.9);
    EXPECT_THAT(test::refusal_of([&] { body.marker({factor * R, p}); }), HasSubstr("is no rotation"));
    EXPECT_THAT(test::refusal_of([&] { body.marker({-R, p}); }), HasSubstr("is no rotation"));
    EXPECT_THAT(test::refusal_of([&] { body.marker({kNaN, 0.0, 1.0}); }), HasSubstr("not finite"));
    EXPECT_THAT(of_builder({.mass = 1.0}, Pose{factor * R, p}), HasSubstr("is no rotation"));
    // {x, y, z} is a place, as a vector is.
    const auto by_numbers = body.marker({p.x(), p.y(), p.z()}), by_vector = body.marker(p);
    EXPECT_EQ(b.description().markers[by_numbers.index].X_BP.p, p);
    EXPECT_EQ(b.description().markers[by_vector.index].X_BP.p, p);
    EXPECT_EQ(b.description().markers[body.marker({0, 0, 1}).index].X_BP.p, Vector3d::UnitZ());
    EXPECT_THAT(test::refusal_of([&] { body.marker({0, 1}); }), HasSubstr("give x, y and z"));
    EXPECT_THAT(test::refusal_of([&] { body.marker("tip"); }), HasSubstr("has no interface \"tip\""));
    EXPECT_THAT(test::refusal_of([&] { b.add<Revolute>("j", ground.marker(), foreign.marker()); }),
                HasSubstr("is none of mechanism"));
    const double k = chance.between(0.0, 1e6), d = chance.between(0.0, 1e3);
    const auto spring = [&](const std::string& name, double stiffness, double damping) {
      return test::refusal_of([&] {
        b.add<SpringDamper>(name, ground.marker(), body.marker(),
                            {.stiffness = stiffness, .damping = damping});
      });
    };
    EXPECT_EQ(spring("good", k, d), "accepted");
    EXPECT_THAT(spring("s", -1.0 - k, d), HasSubstr("element \"s\": stiffness is"));
    EXPECT_THAT(spring("s", k, -1.0 - d), HasSubstr("damping is"));
    EXPECT_THAT(spring("s", kNaN, d), HasSubstr("must be finite and not negative"));
    auto joint = b.add<Revolute>("j2", ground.marker(), body.marker());
    EXPECT_THAT(test::refusal_of([&] { joint.start(kNaN); }), HasSubstr("give a finite number"));
    EXPECT_THAT(test::refusal_of([&] { joint.speed(kNaN); }), HasSubstr("give a finite number"));
  }
}

}  // namespace
}  // namespace flexura::mbs
