// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Beams, rods and cables so soft that they hang, fold and coil, in equilibrium and where a run starts quasi-statically.  Their
/// judges: the forces on the whole, by hand, and the energy, which has to be least.
namespace flexura::mbs::beams {
namespace {

using Eigen::VectorXd;

class Draw {
 public:
  explicit Draw(unsigned seed) : source_(seed) {}
  double in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(source_); }
  double log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }
  Vector3d vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return *(all.begin() + std::uniform_int_distribution<std::size_t>(0, all.size() - 1)(source_));
  }

 private:
  std::mt19937 source_;
};

std::string written(const Vector3d& v) {
  return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", v.x(), v.y(), v.z());
}

struct Soft {
  std::string text;
  Vector3d weight, F = Vector3d::Zero();  // F: the given force at the tip
  bool is_closed = false;                 // held at both ends
};

/// A round beam of 1500 kg/m^3 along x, held at its root, with nothing but its weight, or a force, a spring or a body at its
/// tip, or the tip held nearer than its length. Its weight bends it by 1e-3 to 1e4 times its length in theory.
Soft soft_beam(Draw& draw, bool starts) {
  const double L = draw.in(0.3, 3.0), d = L * draw.log_in(6e-3, 0.1), E = draw.log_in(1e5, 3e9),
               m = 1500.0 * std::numbers::pi / 4.0 * d * d * L, w = 9.81 * m,
               EI = E * std::numbers::pi / 64.0 * std::pow(d, 4);
  const Vector3d g = draw.vector(9.81);
  const char kind = draw.one_of({'A', 'B', 'C', 'D'});
  const std::string root =
      starts || kind == 'A' || kind == 'D' ? "fixed" : draw.one_of<std::string>({"fixed", "spherical"});
  Soft out;
  out.weight = m * g;
  out.text = fmt::format(
      "gravity = {}\n[ground.marker.g]\n[body.b]\nfidelity = \"{}\"\n[body.b.beam]\nto = [{}, 0, "
      "0]\nelements = {}\n"
      "young = {}\ndensity = 1500\ndiameter = {}\n[joint.j]\ntype = \"{}\"\nfrom = \"ground.g\"\nto = "
      "\"b.root\"\n"
      "[measure.X]\ntype = \"position\"\nfrom = \"ground\"\nto = \"b.tip\"\ndirection = [1, 0, 0]\n"
      "[measure.Y]\ntype = \"position\"\nfrom = \"ground\"\nto = \"b.tip\"\ndirection = [0, 1, 0]\n"
      "[measure.Z]\ntype = \"position\"\nfrom = \"ground\"\nto = \"b.tip\"\ndirection = [0, 0, 1]\n",
      written(g), draw.one_of<std::string>({"beam", "rod", "cable"}), L, draw.one_of({3, 4, 5}), E, d, root);
  if (kind == 'A') {
    out.F = draw.vector(std::min(w, 20.0 * EI / (L * L)) * draw.in(0.0, 3.0));
    out.text += fmt::format(
        "[force.f]\ntype = \"force\"\nmarker = \"b.tip\"\nx = {:.17g}\ny = {:.17g}\nz = {:.17g}\n", out.F.x(),
        out.F.y(), out.F.z());
  } else if (kind == 'B') {
    out.text += fmt::format(
        "[ground.marker.p]\nposition = {}\n[force.s]\ntype = \"spring_damper\"\nfrom = \"ground.p\"\nto = "
        "\"b.tip\"\n"
        "stiffness = {}\nfree_length = {}\n",
        written(draw.vector(L)), w / L * draw.log_in(0.1, 100.0), 0.2 * L);
  } else if (kind == 'C') {
    out.is_closed = true;
    out.text += fmt::format(
        "[ground.marker.e]\nposition = {}\n[joint.e]\ntype = \"spherical\"\nfrom = \"ground.e\"\nto = "
        "\"b.tip\"\n",
        written({draw.in(0.5, 0.98) * L, draw.in(-0.1, 0.1) * L, 0.0}));
  } else {
    const double at_tip = m * draw.in(0.1, 5.0), J = 1e-3 * at_tip * L * L;
    out.weight += at_tip * g;
    out.text += fmt::format(
        "[body.m]\nposition = [{}, 0, 0]\nmass = {}\ninertia = [{}, {}, {}]\n[joint.m]\ntype = "
        "\"fixed\"\nfrom = "
        "\"b.tip\"\nto = \"m\"\n",
        L, at_tip, J, J, J);
  }
  return out;
}

class SoftBeams : public cases::TextCase {
 protected:
  // Of a state at rest: what the ground exerts carries all loads, and no coordinate leads to less energy.
  static void judge(const Soft& soft, PreparedMechanism& p) {
    const double size = soft.weight.norm() + soft.F.norm();
    const VectorXd at_root = cases::now(p, {"j.force_x", "j.force_y", "j.force_z"});
    Vector3d held = at_root.head<3>();
    if (soft.is_closed) held += cases::now(p, {"e.force_x", "e.force_y", "e.force_z"}).head<3>();
    const bool has_spring = soft.text.find("[force.s]") != std::string::npos;
    // The joint's axes are the ground's.
    if (!has_spring) EXPECT_LT((held + soft.weight + soft.F).norm(), 1e-7 * size);
    if (soft.is_closed) return;
    const Mechanism& mechanism = *p.mechanism;
    const VectorXd rest = p.state.p;
    const auto energy = [&](const VectorXd& p_moved) {
      p.state.p = p_moved;
      const VectorXd y = cases::now(p, {"energy.total", "X", "Y", "Z"});
      return y(0) - soft.F.dot(y.segment<3>(1));
    };
    const double E = energy(rest);
    VectorXd there(rest.size()), d = VectorXd::Zero(p.state.v.size());
    for (Eigen::Index i = 0; i < d.size(); ++i) {
      const double h = 1e-4 * mechanism.velocity_scale(static_cast<int>(i));
      double E_at[2];
      for (const int k : {0, 1}) {
        d(i) = k == 0 ? -h : h;
        mechanism.retract(rest, d, there);
        E_at[k] = energy(there);
      }
      d(i) = 0.0;
      const double across = E_at[0] + E_at[1] - 2.0 * E, round_off = 1e-14 * std::abs(E) + 1e-15 * size;
      // Its slope by differences errs by a part h^2 of the stiffness across it, which weighs the second difference.
      EXPECT_LT(std::abs(E_at[1] - E_at[0]), 1e-2 * std::abs(across) + 10.0 * round_off) << i;
      EXPECT_GT(across, -10.0 * round_off) << i;
    }
  }
};

// 200 of them, most of which no equilibrium was found of within 500 steps, or an unstable one.
TEST_F(SoftBeams, ComeToRestWhereTheirEnergyIsLeast) {
  int found = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Draw draw(seed);
    const Soft soft = soft_beam(draw, false);
    SCOPED_TRACE(fmt::format("seed {}:\n{}", seed, soft.text));
    PreparedMechanism p = prepared(soft.text);
    try {
      find_equilibrium(*p.mechanism, p.state);
      p.v_dot.setZero();
    } catch (const std::runtime_error& error) {
      // What is not found says what it has come to.
      EXPECT_NE(std::string(error.what()).find("unbalanced"), std::string::npos) << error.what();
      continue;
    }
    ++found;
    judge(soft, p);
    if (HasFailure()) return;
  }
  EXPECT_GE(found, 196);
}

TEST_F(SoftBeams, StartQuasiStaticallyWhereTheyStayAtRest) {
  int found = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Draw draw(seed);
    const Soft soft = soft_beam(draw, true);
    SCOPED_TRACE(fmt::format("seed {}:\n{}", seed, soft.text));
    try {
      PreparedMechanism p = prepared(soft.text + "[solver]\ninitial_deformation = \"quasi_static\"\n");
      judge(soft, p);
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("start undeformed"), std::string::npos) << error.what();
      continue;
    }
    ++found;
    if (HasFailure()) return;
  }
  EXPECT_GE(found, 196);
}

}  // namespace
}  // namespace flexura::mbs::beams
