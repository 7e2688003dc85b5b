// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "mbs/model/ancf_part.hpp"
#include "mbs/model/constraints/types.hpp"
#include "mbs/model/controls/types.hpp"
#include "mbs/model/forces/types.hpp"
#include "mbs/model/joints/types.hpp"
#include "mbs/model/modal_basis.hpp"
#include "mbs/solver/tangents.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

/// The derivatives that Newton's method and the linearisation use, against central differences of fourth
/// order, for every registered type of joint, constraint, force, measure and control.  A type without an
/// example here fails.
namespace flexura::mbs {
namespace {

using checks::Random;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// [r; c_rate; b; G v + g_t] of a state.
VectorXd everything(const Mechanism& m, const State& s, const VectorXd& v_dot, Equations::Scratch& scratch) {
  const Sizes n = m.sizes();
  VectorXd y(n.n_v + n.n_dyn + n.n_alg + n.n_lambda);
  m.momentum(s, v_dot, scratch, y.head(n.n_v), y.segment(n.n_v, n.n_dyn),
             y.segment(n.n_v + n.n_dyn, n.n_alg));
  m.velocity_constraints(s.t, s.p, s.v, scratch, y.tail(n.n_lambda));
  return y;
}

// Central differences of fourth order, D(h) = f' - h^4 f^(5) / 30 + ..., round-off 1.5 eps |f| / h.
// Beside that a derivative may err by `own_error` of the scale, where it comes from differences itself.
void derivatives_agree(const Mechanism& m, State s, unsigned seed, TangentScope scope, double own_error) {
  const Sizes n = m.sizes();
  Random random(seed);
  VectorXd v_dot = random.vector(n.n_v);
  Tangents tangents(m);
  tangents.evaluate(s, v_dot, scope);
  const auto scratch = m.make_scratch();
  const VectorXd here = everything(m, s, v_dot, *scratch);
  const int n_z = n.n_v + n.n_dyn + n.n_alg;
  const auto compare = [&](VectorXd& x, const MatrixXd& columns, const MatrixXd* rows_h,
                           const std::vector<bool>& skips, const char* what) {
    for (int j = 0; j < x.size(); ++j) {
      if (!skips.empty() && skips[j]) continue;
      const double x_j = x(j);
      const auto at = [&](double step) {
        x(j) = x_j + step;
        VectorXd y = everything(m, s, v_dot, *scratch);
        x(j) = x_j;
        return y;
      };
      const auto difference = [&](double h) {
        return VectorXd((8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h));
      };
      const double h = 2.5e-4;
      const VectorXd D = difference(h), coarse = difference(2.0 * h);
      VectorXd own(here.size());
      own.head(n_z) = columns.col(j);
      own.tail(n.n_lambda) = rows_h ? VectorXd(rows_h->col(j)) : VectorXd(D.tail(n.n_lambda));
      // Truncation is a fifteenth of what halving the step changed; the terms beyond it may be as large
      // again. Round-off: 1.5 eps / h = 1.3e-12 of the largest numbers met on the way to f, some ten times f
      // itself.
      const double scale = 1.0 + here.cwiseAbs().maxCoeff() + D.cwiseAbs().maxCoeff();
      const double tolerance = (D - coarse).cwiseAbs().maxCoeff() / 7.0 + (2e-11 + own_error) * scale;
      EXPECT_LT((own - D).cwiseAbs().maxCoeff(), tolerance) << what << " " << j << ", scale " << scale;
      // The comparison must not become empty by differences that say nothing.
      EXPECT_LT(tolerance, (1e-7 + own_error) * scale) << what << " " << j;
    }
  };
  std::vector<bool> elastic_p, elastic_v;
  if (scope == TangentScope::newton) {
    elastic_p.assign(n.n_p, false);
    elastic_v.assign(n.n_v, false);
    for (int i = 0; i < n.n_v; ++i) {
      int i_p;
      double k, d;
      if (m.elastic_coordinate(i, i_p, k, d)) elastic_p[i_p] = elastic_v[i] = true;
    }
  }
  compare(s.p, tangents.z_p, n.n_lambda > 0 ? &tangents.h_p : nullptr, elastic_p, "by position");
  compare(s.v, tangents.z_v, n.n_lambda > 0 ? &tangents.G : nullptr, elastic_v, "by velocity");
  compare(s.c, tangents.z_c, nullptr, {}, "by dynamic state");
  compare(s.a, tangents.z_a, nullptr, {}, "by algebraic state");
  // M and G^T, and what dynamic states say to accelerations and reactions.
  MatrixXd by_v_dot = MatrixXd::Zero(n_z, n.n_v), by_lambda = MatrixXd::Zero(n_z, n.n_lambda);
  by_v_dot.topRows(n.n_v) = tangents.M;
  by_lambda.topRows(n.n_v) = tangents.G.transpose();
  if (tangents.c_v_dot.size() > 0) by_v_dot.middleRows(n.n_v, n.n_dyn) = tangents.c_v_dot;
  if (tangents.c_lambda.size() > 0) by_lambda.middleRows(n.n_v, n.n_dyn) = tangents.c_lambda;
  compare(v_dot, by_v_dot, nullptr, {}, "by acceleration");
  compare(s.lambda, by_lambda, nullptr, {}, "by multiplier");
}

void derivatives_agree(const Mechanism& m, double own_error = 0.0) {
  for (unsigned seed : {3u, 4u}) {
    State s = checks::random_state(m, seed, 0.3);
    Random random(seed + 50);
    s.c += random.vector(static_cast<int>(s.c.size()), 0.2);
    s.a += random.vector(static_cast<int>(s.a.size()), 0.2);
    const auto scratch = m.make_scratch();
    m.start_contacts(s, *scratch);
    m.start_switches(s, *scratch);
    derivatives_agree(m, s, seed + 100, TangentScope::everything, own_error);
    if (m.sizes().n_flx > 0) derivatives_agree(m, s, seed + 100, TangentScope::newton, own_error);
  }
}

// The body deforms, and its markers of these names sit on its two nodes.
void make_flexible(MechanismDescription& d, const std::string& body, const std::string& left,
                   const std::string& right) {
  static const auto flexible = [] {
    BasisOptions options;
    options.modes = 3;
    return std::make_shared<FlexibleBody>(modal_data(lattice::make_lattice(4, 40.0).se, options));
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

using Examples = std::map<std::string, std::string>;

class ElementDerivatives : public MechanismFileTest {
 protected:
  template <class Types>
  void check_all(const std::string& kind, const Types& types, const Examples& examples) const {
    std::set<std::string> known;
    for (const auto& type : types) {
      SCOPED_TRACE(kind + " " + std::string(type.name));
      known.insert(std::string(type.name));
      // An element of the user's own brings its derivatives' checks along with its library.
      if (type.name == std::string("user")) continue;
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

constexpr const char* kEnds = "from = \"a.out\"\nto = \"b.in\"\n";

TEST_F(ElementDerivatives, OfConstraints) {
  const std::string ends = kEnds;
  check_all(
      "constraint", constraint_types(),
      {{"point_on_line", ends},
       {"point_on_plane", ends},
       {"point_on_curve", ends + "points = [[1, 0, 0], [0.8, 0.9, 0.3], [-0.2, 1.4, 0.5], [-1.2, 0.3, 0.1], "
                                 "[-0.5, -1, -0.4], [0.6, -0.8, -0.2]]\nclosed = true"},
       {"orientation", ends},
       {"parallel", ends},
       {"perpendicular", ends},
       {"distance", ends + "length = \"700 mm\""},
       {"coupler",
        "joints = [\"second.angle\", \"second.position\", \"third\"]\nfactors = [1, 2, 0.5]\noffset = "
        "\"sin(2*t)\""},
       {"gear", "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nteeth_1 = 17\nteeth_2 = 40"},
       {"rack_and_pinion", "rack = \"third\"\npinion = \"second.angle\"\nradius = \"30 mm\""},
       {"rolling_disc", "from = \"ground.track\"\nto = \"b.in\"\nradius = \"300 mm\""}});
}

TEST_F(ElementDerivatives, OfForces) {
  const std::string ends = kEnds, sliding = "joint = \"third\"\n";
  check_all(
      "force", force_types(),
      {{"spring_damper", ends + "stiffness = \"30 N/m\"\ndamping = \"4 N*s/m\"\nfree_length = \"200 mm\""},
       {"force",
        "marker = \"b.in\"\naxes = \"a.out\"\nreaction = \"a.out\"\nx = \"3*third.position^2 + t\"\ny = "
        "\"sin(third.speed)\""},
       {"torque", "marker = \"b.in\"\nz = \"2*third.position\"\nx = 3"},
       {"joint_force", sliding + "value = \"-3*third.position^3 + second.speed\""},
       {"joint_spring_damper", sliding + "stiffness = 20\ndamping = 3\nrest = 0.1"},
       {"joint_friction",
        sliding + "coulomb = 3\nstatic = 4\nstribeck_speed = 0.8\ntransition_speed = 0.5\nviscous = 0.2"},
       {"bushing", ends + "stiffness = [30, 40, 50]\nrotational_stiffness = [3, 4, 5]\ndamping = [1, 2, 3]\n"
                          "rotational_damping = [0.1, 0.2, 0.3]"},
       {"contact",
        ends + "radius = 3\nsurface = \"sphere\"\nsurface_radius = 4\nstiffness = 20\nexponent = 1.5\n"
               "damping = 2\nfriction = 0.3\ntransition_speed = 0.5"},
       {"bump_stop", sliding + "upper = -5\nstiffness = 10\nexponent = 1.5\ndamping = 1"},
       {"gear_mesh",
        "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nradius_1 = 0.3\nradius_2 = 0.5\nstiffness = 50\n"
        "teeth_1 = 3\nripple = 0.2"},
       {"stick_slip", sliding + "coulomb = 3\nstatic = 4\nstribeck_speed = 0.8\nstick_stiffness = 20"},
       {"actuator", ends + "command = \"3*third.position\"\ntime_constant = 0.1"}});
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

// Differences of their own: 4e-11 of a scale that may be some ten times that of the sum.
constexpr double kByDifferences = 1e-9;

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
  derivatives_agree(Mechanism(std::move(d)), kByDifferences);
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

// Two bodies of one kind on a chain, held at nodes on either side of a joint, loaded there by a closure.
void derivatives_agree_on(std::shared_ptr<const FlexibleBody> body, double own_error = 0.0) {
  MechanismDescription d = checks::chain_of(body, body, "universal");
  Random random(21);
  const int last = d.add_marker(checks::chain_second, "last", random.pose(0.2), 0);
  d.joints[d.add_joint("closure", "spherical", d.add_marker(0, "end", random.pose()), last)].cut = true;
  derivatives_agree(Mechanism(std::move(d)), own_error);
}

TEST(FlexibleDerivatives, OfEveryLevelOfCoupling) {
  BasisOptions options;
  options.modes = 4;
  ModalData data = modal_data(lattice::make_lattice(4, 40.0).se, options);
  data.damping.setConstant(0.3);
  for (const Coupling coupling : {Coupling::constant, Coupling::partial, Coupling::full}) {
    SCOPED_TRACE(static_cast<int>(coupling));
    data.coupling = coupling;
    derivatives_agree_on(std::make_shared<FlexibleBody>(data));
  }
}

// A joint, a closure and what they carry at a marker that follows three places of the surface.
TEST(FlexibleDerivatives, AtAnInterpolatedNode) {
  lattice::Lattice l = lattice::make_lattice(4, 40.0);
  l.se.surface.vertices = l.x.transpose();
  l.se.shapes = l.T.cast<float>();
  BasisOptions options;
  options.modes = 4;
  options.nodes = {interpolated_node(l.se, "a", {{}, {7, 10, 14}, {}}),
                   interpolated_node(l.se, "b", {{1}, {16, 20, 23}, {1, 2, 3, 4}})};
  ModalData data = modal_data(l.se, options);
  data.nodes.erase(data.nodes.begin(), data.nodes.begin() + 2);  // the chain sits on the first two
  derivatives_agree_on(std::make_shared<FlexibleBody>(data));
}

// One-way: its deformation answers to the motion, to accelerations and reactions, and to the states of
// others.
TEST_F(ElementDerivatives, OfAOneWayBody) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(4, 40.0).se);
  derivatives_agree(Mechanism(read(R"toml(
[ground.marker.far]
position = [1, 0.2, 0.3]
[body.beam]
superelement = "beam.se.h5"
fidelity = "ked"
modes = 4
[body.bob]
mass = 1
inertia = [0.1, 0.1, 0.1]
[body.bob.marker.end]
position = [0.3, -0.2, 0.1]
[joint.pivot]
type = "universal"
from = "ground"
to = "beam.left"
[joint.neck]
type = "revolute"
from = "beam.right"
to = "bob"
[joint.closure]
type = "spherical"
from = "ground.far"
to = "bob.end"
cut = true
[control.lag]
type = "state"
rate = "-2*lag + neck.speed"
[control.root]
type = "algebraic"
equation = "root + 0.3*root^3 - neck.angle"
[force.gust]
type = "force"
marker = "beam.right"
x = "3*lag"
y = "2*root"
)toml")
                                  .description),
                    kByDifferences);
}

// Any symmetric second-order displacement will do.
TEST(FlexibleDerivatives, OfAStiffenedBody) {
  BasisOptions options;
  options.modes = 4;
  ModalData data = modal_data(lattice::make_lattice(4, 40.0).se, options);
  Random random(31);
  const auto blocks = [&](int n) {
    MatrixXd x(4 * n, 4);
    for (int k = 0; k < n; ++k) {
      MatrixXd block(4, 4);
      for (int j = 0; j < 4; ++j) block.col(j) = random.vector(4, 0.2);
      x.middleRows(4 * k, 4) = block + block.transpose();
    }
    return x;
  };
  data.second = SecondOrderIntegrals{blocks(3), blocks(9)};
  for (FlexibleNode& node : data.nodes) node.second = blocks(6);
  derivatives_agree_on(std::make_shared<FlexibleBody>(data));
}

TEST(FlexibleDerivatives, OfAnAncfBeam) {
  derivatives_agree_on(straight_ancf_part(beam::ancf::uncoupled_section(50, 20, 20, 3, 4, 5, 1, 0.05, 0.05),
                                          {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1),
                       kByDifferences);
}

}  // namespace
}  // namespace flexura::mbs
