// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Statements on random robots: those that are untidy move as the tidy ones do by KDL; inertias that no body has become the nearest that
// one has; every fault of a file is told.
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "import/model/inertia.hpp"
#include "import/urdf/convert.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/import/kdl_tree.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution<>(low, high)(engine_); }
  int whole(int below) { return std::uniform_int_distribution<>(0, below - 1)(engine_); }
  bool chance(double p) { return real(0.0, 1.0) < p; }
  Vector3d direction() { return Vector3d(real(-1, 1), real(-1, 1), real(-1, 1) + 1e-3).normalized(); }
  Matrix3d axes() { return Eigen::AngleAxisd(real(-3, 3), direction()).toRotationMatrix(); }
  /// Of some masses in a box: a body has it.
  Matrix3d inertia(double mass, double size) {
    const Vector3d p = Vector3d(real(0.1, 1), real(0.1, 1), real(0.1, 1)) * (mass * size * size / 12.0);
    const Matrix3d R = axes();
    return R * Vector3d(p.sum() - p.array()).asDiagonal() * R.transpose();
  }
  template <class T>
  const T& one_of(const std::vector<T>& list) {
    return list[static_cast<std::size_t>(whole(static_cast<int>(list.size())))];
  }

 private:
  std::mt19937 engine_;
};

std::string numbers(const Vector3d& v, const std::string& between = " ") {
  return fmt::format("{:.17g}{}{:.17g}{}{:.17g}", v.x(), between, v.y(), between, v.z());
}

// Two texts of one robot: as the standard has it, and as files are.
struct Pair {
  std::string tidy, untidy;
  std::map<std::string, double> masses;
};

Pair draw_pair(Random& random) {
  Pair pair;
  const int n = 2 + random.whole(7);
  std::vector<std::string> tidy, untidy;
  const std::vector<std::string> junk = {
      "<material name=\"\"><color rgba=\"1 0 0\"/></material>",
      "<material/>",
      "<gazebo><plugin name=\"p\" filename=\"$(find x)/p.so\"/></gazebo>",
      "<gazebo reference=\"l0\"><mu1>0.5</mu1><kp value=\"1e6\"/></gazebo>",
      "<transmission name=\"nowhere\"><joint name=\"lost\"/><actuator name=\"m\"/></transmission>",
      "<transmission name=\"two\"><joint name=\"j1\"/><joint name=\"j2\"/></transmission>",
      "<transmission><type>x</type></transmission>",
      "<drake:collision_filter_group name=\"g\"/>",
      "<xacro:left_over a=\"1\"/>",
      "<!-- <link name=\"l0\"/> -->",
      "<link name=\"frame_that_nobody_joins\"/>",
      "<sensor name=\"s\" type=\"camera\"><parent link=\"lost\"/></sensor>"};
  const std::vector<std::string> pictures = {
      "<visual/>",
      "<visual><geometry/></visual>",
      "<visual><geometry><box size=\"0 0 0\"/></geometry></visual>",
      "<visual><geometry><box size=\"1 2\"/></geometry></visual>",
      "<visual><geometry><cylinder radius=\"-1\" length=\"nan\"/></geometry></visual>",
      "<visual><geometry><capsule radius=\"0.1\" length=\"0.2\"/></geometry></visual>",
      "<visual><geometry><mesh filename=\"package://lost/a.dae\" scale=\"0.001 0.001 "
      "0.001\"/></geometry></visual>",
      "<collision><geometry><mesh filename=\"lost.stl\"/><sphere radius=\"1\"/></geometry></collision>",
      "<visual><geometry><sphere radius=\"0.1\"/></geometry><material name=\"x\"/><material "
      "name=\"y\"><color "
      "rgba=\"red\"/></material></visual>"};
  for (int l = 0; l < n; ++l) {
    const double mass = std::pow(10.0, random.real(-2, 1));
    const Vector3d c(random.real(-0.3, 0.3), random.real(-0.3, 0.3), random.real(-0.3, 0.3)),
        rpy(random.real(-3, 3), random.real(-1.5, 1.5), random.real(-3, 3));
    const Matrix3d I = random.inertia(mass, random.real(0.05, 0.5));
    const std::string
        name = fmt::format("l{}", l),
        moments = fmt::format(
            R"(ixx="{:.17g}" iyy="{:.17g}" izz="{:.17g}" ixy="{:.17g}" ixz="{:.17g}" iyz="{:.17g}")", I(0, 0),
            I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    pair.masses[name] = mass;
    tidy.push_back(link(
        name,
        fmt::format(R"(<inertial><origin xyz="{}" rpy="{}"/><mass value="{:.17g}"/><inertia {}/></inertial>)",
                    numbers(c), numbers(rpy), mass, moments)));
    // Attributes and elements in another order, commas, signs, blanks, upper E, equal elements twice.
    std::string body = fmt::format("<mass value=\"  {}{:.17E} \"/>", random.chance(0.5) ? "+" : "", mass);
    if (random.chance(0.3)) body += body;
    const std::string place = fmt::format(R"(<origin rpy="{}" xyz="{}"/>)",
                                          numbers(rpy, random.one_of<std::string>({" ", "\n\t", ", "})),
                                          numbers(c, random.one_of<std::string>({"  ", ",", " , "})));
    body = random.chance(0.5) ? body + place : place + body;
    std::string content = fmt::format("<inertial>{}<inertia {}/></inertial>", body, moments);
    for (int k = random.whole(3); k > 0; --k)
      content = random.chance(0.5) ? content + random.one_of(pictures) : random.one_of(pictures) + content;
    untidy.push_back(link(random.chance(0.3) ? " " + name + " " : name, content));
    if (random.chance(0.1)) untidy.push_back(untidy.back());
    if (l == 0) continue;
    const std::string kind = random.one_of<std::string>({"revolute", "continuous", "prismatic", "fixed"});
    const Vector3d p(random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)),
        turn(random.real(-3, 3), random.real(-1.5, 1.5), random.real(-3, 3)), axis = random.direction();
    const std::string parent = fmt::format("l{}", random.whole(l)), joint_name = fmt::format("j{}", l),
                      origin = fmt::format(R"(<origin xyz="{}" rpy="{}"/>)", numbers(p), numbers(turn));
    tidy.push_back(joint(joint_name, kind, parent, name,
                         origin + fmt::format("<axis xyz=\"{}\"/>", numbers(axis)) +
                             R"(<limit lower="-3" upper="3" effort="10" velocity="1"/>)"));
    std::string odd = origin;
    if (kind == "fixed")
      odd += random.one_of<std::string>({"", "<axis xyz=\"0 0 0\"/>", "<limit lower=\"2\" upper=\"1\"/>",
                                         "<mimic joint=\"lost\"/>", "<dynamics damping=\"-1\"/>"});
    else
      odd += fmt::format("<axis xyz=\"{}\"/>", numbers(std::pow(10.0, random.real(-6, 6)) * axis,
                                                       random.one_of<std::string>({" ", ","}))) +
             random.one_of<std::string>({R"(<limit lower="-3" upper="3" effort="-1" velocity="-1"/>)",
                                         R"(<limit upper="3" lower="-3" effort="inf" velocity=""/>)",
                                         R"(<limit lower="-inf" upper="inf"/>)",
                                         R"(<limit lower="3" upper="-3" effort="0"/>)"});
    if (random.chance(0.3)) odd += R"(<safety_controller k_velocity="1"/><calibration rising="0"/>)";
    std::string type = kind;
    if (random.chance(0.2)) type[0] = static_cast<char>(type[0] - 'a' + 'A');
    if (random.chance(0.2)) type = " " + type;
    untidy.push_back(joint(joint_name, type, parent + (random.chance(0.2) ? "\t" : ""), name, odd));
    if (random.chance(0.3))
      untidy.push_back(fmt::format(
          R"(<transmission name="t"><joint name="{}"/><actuator name="m{}"><mechanicalReduction>{}</mechanicalReduction></actuator></transmission>)",
          joint_name, l, random.one_of<std::string>({"3", "0", "x"})));
  }
  for (int k = random.whole(6); k > 0; --k) {
    const std::string& one = random.one_of(junk);
    // A link of its own is once there.
    if (std::ranges::find(untidy, one) == untidy.end()) untidy.push_back(one);
  }
  // A file is read as a whole: links and joints in any order.
  for (std::size_t i = untidy.size(); i > 1; --i)
    std::swap(untidy[i - 1], untidy[static_cast<std::size_t>(random.whole(static_cast<int>(i)))]);
  std::string all;
  for (const std::string& one : tidy) all += one;
  pair.tidy = robot(all);
  all = random.one_of<std::string>(
            {"", "\xEF\xBB\xBF", "\n  ", "<?xml version=\"1.0\"?>\n<!-- made by hand -->\n"}) +
        "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">";
  for (const std::string& one : untidy) all += one;
  pair.untidy = all + "</robot>";
  return pair;
}

import::Mechanism imported(const std::string& text,
                           const Folder& folder){import::Findings findings(folder / "r.urdf");
return import::urdf::to_mechanism(import::urdf::read_robot(text, findings), {}, findings);
}  // namespace

// Both solve with H, whose condition stays below 1e6 (masses of 0.01 to 10 kg, reaches of 0.05 to 3 m): 1e-10 of the largest.
TEST(UrdfProperties, UntidyFilesMoveAsTidyOnes) {
  const Folder folder;
  for (unsigned seed = 0; seed < 250; ++seed) {
    Random random(seed);
    const Pair pair = draw_pair(random);
    const auto reference = kdl_accelerations(urdf::parseURDF(pair.tidy));
    import::Mechanism mechanism;
    ASSERT_NO_THROW(mechanism = imported(pair.untidy, folder)) << "seed " << seed << "\n" << pair.untidy;
    std::map<std::string, double> masses;
    for (const import::Body& body : mechanism.bodies) masses[body.name] = body.mass;
    EXPECT_EQ(masses, pair.masses) << "seed " << seed;
    const auto prepared = mbs::prepare(folder.write("m.toml", import::mechanism_text(mechanism)));
    ASSERT_EQ(prepared.mechanism->sizes().n_v, static_cast<int>(reference.size())) << "seed " << seed;
    double largest = 1.0;
    for (const auto& [name, a] : reference) largest = std::max(largest, std::abs(a));
    for (int i = 0; i < prepared.mechanism->sizes().n_v; ++i) {
      const std::string name = prepared.mechanism->name_of_velocity(i);
      EXPECT_NEAR(prepared.v_dot[i], reference.at(name.substr(0, name.find('.'))), 1e-10 * largest)
          << "seed " << seed << ", " << name << "\n"
          << pair.untidy;
    }
  }
}

// The tensors of bodies with the trace 2 s are the hull of those of rods, s (1 - n n^T).  N is the nearest to I where it is one of them
// and none lies on I's side of the plane through N: (I - N) : (V - N) <= 0 for all V, and the rods suffice, of which the
// worst has for n the eigenvector of I - N with the least eigenvalue.  Random bodies besides, by distance alone.
TEST(UrdfProperties, RepairedInertiasAreTheNearest) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    Random random(seed);
    const double size = std::pow(10.0, random.real(-9, 4));
    Matrix3d I = Matrix3d::NullaryExpr([&] { return size * random.real(-1, 1); });
    I = (I + I.transpose()).eval();
    const double s = 0.5 * I.trace();
    if (s <= 0.0) {
      EXPECT_THROW(import::nearest_inertia(I), std::invalid_argument);
      continue;
    }
    const Matrix3d N = import::nearest_inertia(I), off = I - N;
    EXPECT_NEAR(N.trace(), 2.0 * s, 1e-14 * size) << "seed " << seed;
    const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(N).eigenvalues();
    EXPECT_GE(moments[0], -1e-14 * size) << "seed " << seed;
    EXPECT_GE(moments[0] + moments[1] - moments[2], -1e-14 * size) << "seed " << seed;
    // Sums of nine products, each known to 1e-16 of size^2.
    const double least = Eigen::SelfAdjointEigenSolver<Matrix3d>(off).eigenvalues()[0];
    EXPECT_LE(s * (off.trace() - least) - off.cwiseProduct(N).sum(), 1e-13 * size * size) << "seed " << seed;
    for (int k = 0; k < 50; ++k) {
      Matrix3d V = random.inertia(1.0, 1.0);
      V *= 2.0 * s / V.trace();
      EXPECT_GE((I - V).norm(), off.norm() - 1e-14 * size) << "seed " << seed;
    }
  }
}

// What every seed draws leaves the motion open; each is told, with its line, whatever stands beside it.
TEST(UrdfProperties, AllFaultsAreTold) {
  const std::vector<std::pair<std::string, std::string>> faults = {
      {R"(<link name="{0}" ><inertial><mass value="-1"/></inertial></link>)",
       "the mass of link \"{0}\" is -1"},
      {R"(<link name="{0}"><inertial><mass value="1,5"/></inertial></link>)", "value of <mass> is \"1,5\""},
      {R"(<link name="{0}"><inertial><mass value="1"/><inertia ixx="-1" iyy="-1" izz="-1"/></inertial></link>)",
       "the inertia of link \"{0}\""},
      {R"(<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" izz="1"/></inertial></link>)",
       "<inertia> has no iyy"},
      {R"(<link name="{0}"><inertial><origin xyz="1 2"/><mass value="1"/></inertial></link>)",
       "xyz of <origin> has 2 numbers"},
      {R"(<joint name="{0}" type="hinge"><parent link="a"/><child link="b"/></joint>)",
       "joint \"{0}\" is of type \"hinge\""},
      {R"(<joint name="{0}" type="fixed"><parent link="lost"/><child link="b"/></joint>)",
       "the parent of joint \"{0}\""},
      {R"(<joint name="{0}" type="fixed"><parent link="a"/></joint>)", "joint \"{0}\" has no <child>"},
      {R"(<joint name="{0}" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 0"/></joint>)",
       "the axis of joint \"{0}\""},
      {R"(<joint name="{0}" type="continuous"><parent link="a"/><child link="b"/><mimic joint="lost"/></joint>)",
       "joint \"{0}\" mimics"},
      {R"(<joint name="{0}" type="continuous"><parent link="a"/><child link="b"/><dynamics damping="-2"/></joint>)",
       "damping -2"}};
  for (unsigned seed = 0; seed < 200; ++seed) {
    Random random(seed);
    std::string text = "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>\n";
    std::vector<std::string> expected;
    const int n = 2 + random.whole(6);
    for (int k = 0; k < n; ++k) {
      const auto& [element, says] = random.one_of(faults);
      const std::string name = fmt::format("x{}", k);
      text += fmt::format(fmt::runtime(element), name) + "\n";
      expected.push_back(fmt::format(":{}: ", k + 2) + fmt::format(fmt::runtime(says), name));
    }
    import::Findings findings("r.urdf");
    try {
      import::urdf::read_robot(text + "</robot>", findings);
      ADD_FAILURE() << "seed " << seed << "\n" << text;
    } catch (const import::Faults& told) {
      EXPECT_EQ(told.all().size(), expected.size()) << "seed " << seed;
      for (const std::string& one : expected)
        EXPECT_THAT(told.all(), testing::Contains(testing::HasSubstr(one))) << "seed " << seed;
    }
  }
}

}  // namespace flexura::test
}  // namespace flexura::test
