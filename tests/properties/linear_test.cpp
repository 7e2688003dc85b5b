// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A linear system predicts the run: for random mechanisms with drives, couplers, paths, controls and forces that follow inputs,
// (A, B, C, D, D_1, D_2) driven by a smooth step and a sine says what the nonlinear run does, growth included.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using mbs::chance::Chance;

constexpr double kEnd = 1.0, kRow = 0.05, kSize = 1e-3;

/// u = size (1 - e^(-at) (1 + at + (at)^2 / 2 + (at)^3 / 6) + (1 - cos wt)^2): the last of four lags behind a step, and two sines.
/// u, u' and u'' begin at 0, as a position that follows it must.
struct Signal {
  double a = 0.0, w = 0.0;
  std::string formula(double size) const {
    return fmt::format(
        "{0:.17g}*(1 - exp(-{1:.17g}*t)*(1 + {1:.17g}*t + ({1:.17g}*t)^2/2 + ({1:.17g}*t)^3/6) + (1 - "
        "cos({2:.17g}*t))^2)",
        size, a, w);
  }
  /// g' = S g with u / size = first row: four lags, one, and sines of w and 2 w with their rates.
  MatrixXd generator() const {
    MatrixXd S = MatrixXd::Zero(9, 9);
    for (int i = 0; i < 4; ++i) {
      S(i, i) = -a;
      S(i, i + 1) = a;  // the fourth follows the one
    }
    for (int k = 0; k < 2; ++k) {
      S(5 + 2 * k, 6 + 2 * k) = (k + 1) * w;
      S(6 + 2 * k, 5 + 2 * k) = -(k + 1) * w;
    }
    return S;
  }
  static VectorXd start() {
    VectorXd g = VectorXd::Zero(9);
    g(4) = g(5) = g(7) = 1.0;
    return g;
  }
  static Eigen::RowVectorXd reads() {
    Eigen::RowVectorXd u = Eigen::RowVectorXd::Zero(9);
    u(0) = 1.0;
    u(4) = 1.5;
    u(5) = -2.0;
    u(7) = 0.5;
    return u;
  }
};

struct Scene {
  std::string text;  ///< with {INPUTS} to be put in front
  int n_inputs = 0;
};

class Maker {
 public:
  explicit Maker(Chance& chance) : chance_(chance) {}
  Scene chain();
  Scene rotor();
  Scene disc();

 private:
  std::string input() {
    if (n_inputs_ == 0 || (n_inputs_ < 3 && chance_.flip(0.6))) ++n_inputs_;
    return fmt::format("u{}", 1 + chance_.below(n_inputs_));
  }
  double number(double a, double b) { return chance_.between(a, b); }
  /// A signal that a position may follow: an input itself, a function of it, or a control behind it.
  std::string followed() {
    const std::string u = input(), name = fmt::format("c{}", ++n_controls_);
    switch (chance_.below(5)) {
      case 0:
        return u;
      case 1:
        return fmt::format("sin({} + 0.3) - {:.17g}", u, std::sin(0.3));
      case 2:
        text_ += fmt::format("[control.{}]\ntype = \"filter\"\ninput = \"{}\"\ntime_constant = {}\n", name, u,
                             number(0.05, 0.5));
        return name;
      case 3:
        text_ += fmt::format(
            "[control.{}]\ntype = \"transfer_function\"\ninput = \"{}\"\nnumerator = [{}]\ndenominator = [1, "
            "{}, {}]\n",
            name, u, number(0.5, 2.0), number(0.1, 0.5), number(0.01, 0.1));
        return name;
      default:
        text_ += fmt::format("[control.{}]\ntype = \"state\"\nrate = \"{} - {}*{}\"\n", name, u,
                             number(0.5, 5.0), name);
        return fmt::format("{} + 0.3*{}", name, u);
    }
  }
  void body(const std::string& name, double length) {
    text_ +=
        fmt::format("[body.{}]\nmass = {}\ncenter = [0, 0, {}]\ninertia = [{}, {}, {}]\n", name,
                    number(0.5, 2.0), 0.5 * length, number(0.05, 0.1), number(0.05, 0.1), number(0.05, 0.09));
  }
  void marker(const std::string& on, const std::string& name, double z, const char* axis) {
    text_ += fmt::format("[{}.marker.{}]\nposition = [0, 0, {:.17g}]\naxis = {}\n", on, name, z, axis);
  }
  std::string feedback(const std::string& joint, const std::string& position, const std::string& speed);
  Scene done(const std::string& outputs) {
    return {text_ + fmt::format("[output]\ny = [{}]\n", outputs), n_inputs_};
  }

  Chance& chance_;
  std::string text_;
  int n_inputs_ = 0, n_controls_ = 0;
};

// What a force reads: the motion, inputs, and controls between.
std::string Maker::feedback(const std::string& joint, const std::string& position, const std::string& speed) {
  const std::string name = fmt::format("c{}", ++n_controls_), u = input();
  const double k = number(5.0, 40.0), d = number(0.0, 2.0);
  const std::string error = fmt::format("{} - {}.{}", u, joint, position);
  switch (chance_.below(5)) {
    case 0:
      text_ += fmt::format(
          "[control.{}]\ntype = \"pid\"\nerror = \"{}\"\nproportional = {}\nintegral = {}\nderivative = {}\n"
          "filter_time = 0.05\n",
          name, error, k, number(0.0, 10.0), number(0.0, 2.0));
      return name;
    case 1:
      text_ += fmt::format("[control.{}]\ntype = \"delay\"\ninput = \"{}\"\ntime = {}\n", name, error,
                           number(0.01, 0.1));
      return fmt::format("{:.17g}*{}", k, name);
    case 2:
      text_ += fmt::format("[control.{0}]\ntype = \"algebraic\"\nequation = \"{0} + 0.2*sin({0}) - ({1})\"\n",
                           name, error);
      return fmt::format("{:.17g}*{}", k, name);
    case 3:
      text_ += fmt::format("[control.{}]\ntype = \"filter\"\ninput = \"{}\"\ntime_constant = {}\n", name,
                           error, number(0.02, 0.3));
      return fmt::format("{:.17g}*{}", k, name);
    default:
      return fmt::format("{:.17g}*({}) - {:.17g}*{}.{}", k, error, d, joint, speed);
  }
}

// A cart with a chain of pendulums that hangs or stands, both of which are equilibria.
Scene Maker::chain() {
  static constexpr const char* kAxes[] = {"[0, 1, 0]", "[1, 0, 0]", "[0.6, 0.8, 0]"};
  text_ = fmt::format(
      "gravity = [0, 0, {:.17g}]\n[ground.marker.o]\naxis = [1, 0, 0]\n[body.b0]\nmass = 1\n"
      "inertia = [0.1, 0.1, 0.1]\n[body.b0.marker.o]\naxis = [1, 0, 0]\n",
      number(-9.81, 9.81));
  const int links = 1 + chance_.below(3);
  std::string outputs = "\"h.position\"";
  std::vector<const char*> axes;
  double end = 0.0;
  for (int i = 1; i <= links; ++i) {
    const double length = number(0.3, 1.0);
    const char* axis = chance_.one_of(kAxes);
    axes.push_back(axis);
    marker(fmt::format("body.b{}", i - 1), "p", end, axis);
    body(fmt::format("b{}", i), length);
    marker(fmt::format("body.b{}", i), "o", 0.0, axis);
    end = length;
    text_ += fmt::format("[joint.r{0}]\ntype = \"revolute\"\nfrom = \"b{1}.p\"\nto = \"b{0}.o\"\n", i, i - 1);
    outputs += fmt::format(", \"r{}.angle\"", i);
  }
  std::string joint = "[joint.h]\ntype = \"prismatic\"\nfrom = \"ground.o\"\nto = \"b0.o\"\n";
  const int kind = chance_.below(5);
  if (kind == 0) joint += fmt::format("drive = \"{}\"\n", followed());
  if (kind == 1) joint += fmt::format("drive_speed = \"{}\"\n", followed());
  if (kind == 2)
    joint += fmt::format("drive_acceleration = \"{} - {}*h.speed + {}*h.position\"\n", input(),
                         number(0.0, 3.0), number(-2.0, 2.0));
  if (kind == 3) {
    // A speed that follows where it leads to.
    const std::string name = fmt::format("c{}", ++n_controls_);
    text_ +=
        fmt::format("[control.{0}]\ntype = \"state\"\nrate = \"{1} - {2}*{0} + {3}*h.position + r1.angle\"\n",
                    name, input(), number(0.5, 4.0), number(-3.0, 3.0));
    joint += fmt::format("drive_speed = \"{}\"\n", name);
  }
  text_ += joint;
  if (kind == 4) {
    const std::string value = feedback("h", "position", "speed");
    text_ += fmt::format("[force.fh]\ntype = \"joint_force\"\njoint = \"h\"\nvalue = \"{}\"\n", value);
  }
  if (links > 1 && chance_.flip(0.5)) {
    const std::string offset = followed();
    text_ += fmt::format(
        "[constraint.k]\ntype = \"coupler\"\njoints = [\"r1\", \"r2\"]\nfactors = [1, {:.17g}]\noffset = "
        "\"{}\"\n",
        chance_.either_sign(0.3, 2.0), offset);
  }
  if (chance_.flip(0.6)) {
    const std::string value = feedback(fmt::format("r{}", links), "angle", "speed");
    text_ +=
        fmt::format("[force.t]\ntype = \"joint_force\"\njoint = \"r{}\"\nvalue = \"{}\"\n", links, value);
  }
  if (n_inputs_ == 0)
    text_ += fmt::format("[force.e]\ntype = \"joint_force\"\njoint = \"r1\"\nvalue = \"{}\"\n", input());
  // Held values are no states.
  if (chance_.flip(0.3)) {
    text_ +=
        "[control.held]\ntype = \"relay\"\ninput = \"r1.angle\"\non_above = 10\noff_below = 5\non = 1\noff = "
        "0\n"
        "[force.held]\ntype = \"joint_force\"\njoint = \"r1\"\nvalue = \"held\"\n";
  }
  return done(outputs + ", \"r1.speed\"");
}

// A disc off the axis of a shaft that is driven in speed, on springs along two axes that turn with it.
Scene Maker::rotor() {
  const double w = number(2.0, 10.0), k = number(50.0, 200.0);
  text_ = fmt::format(
      "gravity = [0, 0, 0]\n[body.s]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n[body.d]\nmass = {}\ninertia = "
      "[0.1, "
      "0.1, 0.15]\n[body.x]\nmass = 0.3\ninertia = [0.01, 0.01, 0.01]\n[body.s.marker.x]\naxis = [1, 0, 0]\n"
      "[body.x.marker.x]\naxis = [1, 0, 0]\n[body.x.marker.y]\naxis = [0, 1, 0]\n[body.d.marker.y]\naxis = "
      "[0, 1, 0]\n"
      "[joint.x]\ntype = \"prismatic\"\nfrom = \"s.x\"\nto = \"x.x\"\n[joint.y]\ntype = \"prismatic\"\nfrom "
      "= \"x.y\"\nto = "
      "\"d.y\"\n[force.kx]\ntype = \"joint_spring_damper\"\njoint = \"x\"\nstiffness = {}\ndamping = "
      "{}\n[force.ky]\ntype = "
      "\"joint_spring_damper\"\njoint = \"y\"\nstiffness = {}\ndamping = {}\n",
      number(0.5, 2.0), k, number(0.0, 2.0), k * number(0.5, 3.0), number(0.0, 2.0));
  const std::string u = followed();
  text_ += fmt::format(
      "[joint.r]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"s\"\ndrive_speed = "
      "\"{0:.17g} + {1}\"\n",
      w, u);
  text_ += fmt::format("[force.f]\ntype = \"joint_force\"\njoint = \"y\"\nvalue = \"{}\"\n", input());
  return done("\"x.position\", \"y.position\", \"r.speed\"");
}

// A disc that rolls straight on; below a critical speed it falls.
Scene Maker::disc() {
  const double v = number(0.3, 3.0), radius = number(0.2, 0.5);
  text_ = fmt::format(
      "[ground.marker.o]\n[body.d]\nmass = {}\ninertia = [0.05, {}, 0.05]\nposition = [0, 0, "
      "{:.17g}]\nvelocity = [{:.17g}, 0, "
      "0]\nangular_velocity = [0, {:.17g}, 0]\n[body.d.marker.c]\naxis = [0, 1, 0]\n[constraint.r]\ntype = "
      "\"rolling_disc\"\nfrom = \"ground.o\"\nto = \"d.c\"\nradius = {:.17g}\n",
      number(1.0, 3.0), number(0.07, 0.1), radius, v, v / radius, radius);
  text_ += fmt::format("[force.f]\ntype = \"force\"\nmarker = \"d.c\"\ny = \"{}\"\n", input());
  text_ +=
      "[measure.y]\ntype = \"position\"\nfrom = \"ground.o\"\nto = \"d.c\"\ndirection = [0, 1, "
      "0]\n[measure.lean]\n"
      "type = \"axis\"\nfrom = \"ground.o\"\nto = \"d.c\"\ndirection = [0, 0, 1]\n[measure.head]\ntype = "
      "\"axis\"\nfrom = "
      "\"ground.o\"\nto = \"d.c\"\ndirection = [1, 0, 0]\n";
  return done("\"y\", \"lean\", \"head\"");
}

struct Outputs {
  mbs::LineariseOptions options;
  Outputs(const mbs::PreparedMechanism& p) {
    const mbs::Mechanism& m = *p.mechanism;
    const auto which = mbs::select_quantities(m, p.file.y);
    const auto infos = m.quantities();
    for (const int i : which) options.output_names.push_back(infos[static_cast<std::size_t>(i)].name);
    options.outputs = [&m, which](const mbs::State& s, const VectorXd& v_dot) {
      VectorXd values(static_cast<Index>(which.size()));
      m.evaluate(which, s, v_dot, *m.make_scratch(), values);
      return values;
    };
    for (int i = 0; i < m.n_inputs(); ++i) options.signals.push_back(i);
  }
};

/// Rows of outputs of the run from the state `from`.
MatrixXd rows_of_run(const mbs::PreparedMechanism& p, const mbs::State& from) {
  const Outputs outputs(p);
  MatrixXd rows(static_cast<Index>(std::lround(kEnd / kRow)) + 1, static_cast<Index>(p.file.y.size()));
  Index k = 0;
  mbs::SolverOptions options;
  options.method = "radau";
  options.end_time = kEnd;
  options.output_step = kRow;
  options.tolerance = 1e-10;
  const mbs::RunResult result =
      mbs::run(*p.mechanism, from, p.v_dot, options,
               {.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
                 if (k < rows.rows()) rows.row(k++) = outputs.options.outputs(s, v_dot).transpose();
               }});
  EXPECT_TRUE(result.complete) << result.stopped_because;
  return rows;
}

/// The same by the linear system, exactly: the signal's generator and the system as one.
MatrixXd rows_of_system(const mbs::LinearSystem& d, int input, const Signal& signal) {
  const MatrixXd S = signal.generator();
  const Eigen::RowVectorXd u = Signal::reads();
  const Index n = d.A.rows();
  MatrixXd all = MatrixXd::Zero(n + 9, n + 9);
  all << d.A, d.B.col(input) * u, MatrixXd::Zero(9, n), S;
  MatrixXd reads(d.C.rows(), n + 9);
  reads << d.C, d.D.col(input) * u;
  if (d.D_1.size() > 0) reads.rightCols(9) += d.D_1.col(input) * u * S;
  if (d.D_2.size() > 0) reads.rightCols(9) += d.D_2.col(input) * u * S * S;
  const MatrixXd step = MatrixXd(kRow * all).exp();
  VectorXd x = VectorXd::Zero(n + 9);  // all of x is 0 where u, u' and u'' are
  x.tail(9) = Signal::start();
  MatrixXd rows(static_cast<Index>(std::lround(kEnd / kRow)) + 1, d.C.rows());
  for (Index k = 0; k < rows.rows(); ++k) {
    rows.row(k) = (reads * x).transpose();
    x = (step * x).eval();
  }
  return rows;
}

TEST(Linear, SystemsPredictTheRunThatAnInputMakes) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    Maker maker(chance);
    const int kind = chance.below(10);
    const Scene scene = kind < 7 ? maker.chain() : kind < 9 ? maker.rotor() : maker.disc();
    const auto prepare = [&](int moved, const std::string& formula) {
      std::string text;
      for (int i = 0; i < scene.n_inputs; ++i)
        text += fmt::format("[input.u{}]\nvalue = \"{}\"\n", i + 1, i == moved ? formula : "0");
      // Top-level keys stand before tables.
      const auto at = scene.text.find('[', scene.text.find('\n'));
      const std::string head = scene.text.starts_with("gravity") ? scene.text.substr(0, at) : "";
      return mbs::prepare(folder.write("m.toml", head + text + scene.text.substr(head.empty() ? 0 : at)));
    };
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, scene.text));
    const mbs::PreparedMechanism still = prepare(-1, "");
    const mbs::LinearSystem system = mbs::linearise(*still.mechanism, still.state, Outputs(still).options);
    for (int i = 0; i < scene.n_inputs; ++i) {
      const Signal signal{chance.between(4.0, 12.0), chance.between(2.0, 10.0)};
      const mbs::PreparedMechanism p = prepare(i, signal.formula(kSize)),
                                   q = prepare(i, signal.formula(-kSize));
      const MatrixXd moved = (rows_of_run(p, p.state) - rows_of_run(q, q.state)) / (2.0 * kSize);
      const MatrixXd expected = rows_of_system(system, i, signal);
      for (Index j = 0; j < moved.cols(); ++j) {
        // Terms of third order are kSize^2 of the first, for motions of some units; the run leaves 1e-10 / kSize.
        const double size =
            std::max(moved.col(j).lpNorm<Eigen::Infinity>(), 1e-2 * expected.lpNorm<Eigen::Infinity>());
        const double largest = expected.lpNorm<Eigen::Infinity>();
        EXPECT_LT((moved.col(j) - expected.col(j)).lpNorm<Eigen::Infinity>(),
                  2e-5 * size * (1.0 + largest * largest) + 1e-6)
            << fmt::format("input u{}, output {}", i + 1, system.outputs[static_cast<std::size_t>(j)]);
      }
    }
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
