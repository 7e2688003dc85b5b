// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <set>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/examples.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/solver/derivatives.hpp"

/// Derivatives of every registered type of joint, constraint, force, measure and control, on rigid and on
/// flexible bodies.  A type without an example here fails.
namespace flexura::mbs {
namespace {

using checks::derivatives_agree;
using checks::Random;

// The body deforms, and its markers of these names sit on its two nodes.
void make_flexible(MechanismDescription& d, const std::string& body, const std::string& left,
                   const std::string& right) {
  static const auto flexible = [] {
    BasisOptions options;
    options.modes = 3;
    return std::make_shared<ModalBody>(modal_data(lattice::make_lattice(4, 40.0).se, options));
  }();
  for (std::size_t b = 0; b < d.bodies.size(); ++b) {
    if (d.bodies[b].name != body) continue;
    d.bodies[b].inertia = {};
    d.bodies[b].flexible = flexible;
    for (MarkerDescription& marker : d.markers)
      if (marker.body == static_cast<int>(b) &&
          (marker.name == body + "." + left || marker.name == body + "." + right))
        marker.node = marker.name == body + "." + left ? 0 : 1;
  }
}

class ElementDerivatives : public MechanismFileTest {
 protected:
  template <class Types>
  void check_all(const std::string& kind, const Types& types, const Examples& examples) const {
    std::set<std::string> known;
    for (const auto& type : types) {
      SCOPED_TRACE(kind + " " + std::string(type.name));
      known.insert(std::string(type.name));
      // An element of the user's own brings its derivatives' checks along with its library; load cases and
      // surfaces need a superelement (flexible_derivatives.cpp, tests/mbs/surfaces).
      if (std::set<std::string>{"user", "distributed_load", "surface_contact", "surface_distance"}.contains(
              std::string(type.name)))
        continue;
      const auto example = examples.find(std::string(type.name));
      if (example == examples.end()) {
        ADD_FAILURE() << "has no example in this test: give it one, so that its derivatives are checked";
        continue;
      }
      for (const bool flexible : {false, true}) {
        SCOPED_TRACE(flexible ? "on flexible bodies" : "on rigid bodies");
        MechanismDescription d = read(std::string(kThreeBodies) + "[" + kind + ".x]\ntype = \"" +
                                      std::string(type.name) + "\"\n" + example->second)
                                     .description;
        if (flexible) {
          make_flexible(d, "a", "", "out");
          make_flexible(d, "b", "in", "hub");
        }
        derivatives_agree(Mechanism(std::move(d)));
      }
    }
    for (const auto& [name, text] : examples) EXPECT_TRUE(known.contains(name)) << name << " is no " << kind;
  }
};

TEST_F(ElementDerivatives, OfConstraints) {
  check_all("constraint", constraint_types(), constraint_examples());
}

TEST_F(ElementDerivatives, OfWhatTravelsAlongAPath) {
  for (const char* keys : {"orientation = \"free\"", "orientation = \"along\"", "place = \"1 + 0.3*t\"",
                           "orientation = \"fixed\"\nplace = \"1 + sin(t)\""})
    for (const bool flexible : {false, true}) {
      SCOPED_TRACE(keys);
      MechanismDescription d =
          read(std::string(kThreeBodies) + "[constraint.x]\ntype = \"point_on_path\"\nto = \"b.in\"\n" +
               on_rail(keys))
              .description;
      if (flexible) {
        make_flexible(d, "a", "", "out");
        make_flexible(d, "b", "in", "hub");
      }
      derivatives_agree(Mechanism(std::move(d)));
    }
}

TEST_F(ElementDerivatives, OfForces) {
  check_all("force", force_types(), force_examples());
}

TEST_F(ElementDerivatives, OfBearingsOfOtherKinds) {
  const std::string rolling = std::string(kEnds) + "elements = 9\ndiameter = 1\npitch_diameter = 5\n",
                    film = std::string(kEnds) +
                           "radius = 4\nlength = 1\nclearance = 3\nviscosity = 100\nfilm = \"full\"";
  for (const auto& [type, keys] :
       {std::pair<std::string, std::string>{
            "rolling_bearing", rolling + "kind = \"roller\"\nlength = 1e-9\ncontact_angle = \"15 deg\""},
        {"rolling_bearing", rolling + "groove_inner = 0.9\ngroove_outer = 0.8\n"
                                      "clearance = 0.1\nyoungs_modulus = 30"},
        {"journal_bearing", film}}) {
    SCOPED_TRACE(keys);
    derivatives_agree(Mechanism(
        read(std::string(kThreeBodies) + "[force.x]\ntype = \"" + type + "\"\n" + keys).description));
  }
}

TEST_F(ElementDerivatives, OfMeasures) {
  const std::string ends = kEnds, along = ends + "direction = [1, 2, 2]\n",
                    force = "[force.f]\ntype = \"joint_force\"\njoint = \"third\"\nvalue = \"3*x + x^2\"\n";
  check_all("measure", measure_types(),
            {{"distance", ends + force},
             {"distance_rate", ends + force},
             {"position", along + force},
             {"axis", along + force},
             {"velocity", along + force},
             {"angle", ends + force},
             {"angular_velocity", along + force},
             {"rotation_angle", ends + "sequence = \"zxz\"\nangle = 3\n" + force},
             // No force may read these: they have no derivatives.
             {"acceleration", along},
             {"angular_acceleration", along},
             {"load_cell", "joint = \"second\"\ndirection = [1, 2, 2]"},
             {"reaction", "quantity = \"second.force_x\""},
             {"expression", "value = \"third.position^2 + second.speed\"\n" + force}});
}

TEST_F(ElementDerivatives, OfControls) {
  const std::string input = "input = \"third.position^2 + third.speed\"\n",
                    force = "[force.f]\ntype = \"joint_force\"\njoint = \"third\"\nvalue = \"3*x + x^2\"\n";
  check_all(
      "control", control_types(),
      {{"state", "rate = \"-2*x + third.position^2\"\n" + force},
       {"filter", input + "time_constant = 0.1\n" + force},
       {"pid",
        "error = \"1 - third.position\"\nproportional = 3\nintegral = 2\nderivative = 0.5\nfilter_time = "
        "0.1\n" +
            force},
       {"transfer_function", input + "numerator = [2, 1]\ndenominator = [5, 3, 4]\n" + force},
       {"delay", input + "time = 0.5\n" + force},
       {"relay", input + "on_above = 0.2\noff_below = -0.1\n" + force},
       {"algebraic", "equation = \"x + 0.3*x^3 - third.position\"\n" + force},
       {"sample", input + "period = 0.1\n" + force}});
}

// Each in the tree, between bodies that move, and as the closure of a loop.
TEST(JointDerivatives, OfEveryType) {
  for (const JointType& type : joint_types()) {
    if (type.name == "user") continue;  // as for other elements
    for (const bool closes : {false, true}) {
      SCOPED_TRACE(type.name + (closes ? ", closing a loop" : ", in the tree"));
      Random random(7);
      MechanismDescription d;
      d.gravity = {1.0, 2.0, -9.81};
      const int a = d.add_body({.name = "a", .inertia = random.inertia()});
      const int b = d.add_body({.name = "b", .inertia = random.inertia()});
      const int end = d.add_body({.name = "end", .inertia = random.inertia()});
      d.add_joint("base", "six_dof", d.add_marker(0, "base"), d.add_marker(a, "base", random.pose()));
      const int out = d.add_marker(a, "out", random.pose()), in = d.add_marker(b, "in", random.pose());
      if (closes) {
        d.add_joint("free", "six_dof", d.add_marker(a, "free"), d.add_marker(b, "free"));
        d.joints[d.add_joint("x", type.name, out, in)].cut = true;
      } else {
        d.add_joint("x", type.name, out, in);
      }
      d.add_joint("last", "revolute", d.add_marker(b, "last", random.pose()), d.add_marker(end, "last"));
      derivatives_agree(Mechanism(std::move(d)));
    }
  }
}

// A spring between two points that knows nothing of derivatives, as a user's own may.
class PlainSpring final : public ForceElement {
 public:
  PlainSpring(int P, int Q) : ForceElement("plain"), P_(P), Q_(Q) {}
  std::string_view type() const override { return "plain"; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const Vector3d r = kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p;
    const Vector3d f = 3.0 * r.norm() * r + 2.0 * (kin.markers[Q_].V.linear - kin.markers[P_].V.linear);
    loads.apply(P_, Spatial{Vector3d::Zero(), f});
    loads.apply(Q_, Spatial{Vector3d::Zero(), -f});
  }
  void add_powers(const Kinematics&, const double*, Powers&) const override {}

 private:
  int P_, Q_;
};

/// The origin of M stays on a sphere about F.
class PlainSphere final : public Constraint {
 public:
  PlainSphere(int F, int M) : Constraint("sphere"), F_(F), M_(M) {}
  int n_rows() const override { return 1; }
  std::string row_name(int) const override { return "radius"; }
  void position(const Kinematics& kin, double* g) const override { g[0] = 0.5 * r(kin).squaredNorm() - 1.0; }
  void velocity(const Kinematics& kin, double* g_dot) const override { g_dot[0] = r(kin).dot(u(kin)); }
  void acceleration(const Kinematics& kin, double* g_ddot) const override {
    g_ddot[0] = r(kin).dot(kin.markers[M_].A.linear - kin.markers[F_].A.linear) + u(kin).squaredNorm();
  }
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override {
    loads.apply(M_, Spatial{Vector3d::Zero(), x[0] * r(kin)});
    loads.apply(F_, Spatial{Vector3d::Zero(), -x[0] * r(kin)});
  }

 private:
  Vector3d r(const Kinematics& kin) const { return kin.markers[M_].X_WP.p - kin.markers[F_].X_WP.p; }
  Vector3d u(const Kinematics& kin) const { return kin.markers[M_].V.linear - kin.markers[F_].V.linear; }
  int F_, M_;
};

TEST_F(ElementDerivatives, OfElementsThatHaveNone) {
  MechanismDescription d = read(kThreeBodies).description;
  make_flexible(d, "a", "", "out");
  make_flexible(d, "b", "in", "hub");
  const auto marker = [&](const std::string& name) {
    for (std::size_t i = 0; i < d.markers.size(); ++i)
      if (d.markers[i].name == name) return static_cast<int>(i);
    throw std::invalid_argument(name);
  };
  d.forces.push_back(std::make_shared<PlainSpring>(marker("a.out"), marker("b.in")));
  d.constraints.push_back(std::make_shared<PlainSphere>(marker("ground.track"), marker("b.in")));
  derivatives_agree(Mechanism(std::move(d)), checks::kByDifferences);
}

TEST(JointDerivatives, OfAMotionThatIsDifferenced) {
  for (const char* type : {"universal", "constant_velocity"}) {
    const auto joint = make_joint(type);
    const double q[] = {0.7, -0.4}, v[] = {1.3, 0.6};
    MotionDerivatives exact, differenced;
    joint->motion_derivatives(q, v, exact);
    joint->Joint::motion_derivatives(q, v, differenced);
    // Entries of order one.
    for (int j = 0; j < 2; ++j) EXPECT_LT((exact.S_q[j] - differenced.S_q[j]).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((exact.bias_q - differenced.bias_q).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((exact.bias_v - differenced.bias_v).cwiseAbs().maxCoeff(), 1e-12);
  }
}

}  // namespace
}  // namespace flexura::mbs
