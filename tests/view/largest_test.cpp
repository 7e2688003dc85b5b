// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The largest displacement and stress that a page states, against a plain loop over every stored row and every vertex.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "mbs/view/pages.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using nlohmann::json;
using testing::PageReader;
using testing::scratch;
using testing::slurp;

struct Random {
  std::mt19937 engine;
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine); }
  int integer(int low, int high) { return std::uniform_int_distribution(low, high)(engine); }
  template <typename Matrix>
  void fill(Matrix& m, double size) {
    for (Index i = 0; i < m.size(); ++i)
      m.data()[i] = static_cast<typename Matrix::Scalar>(uniform(-size, size));
  }
};

/// A tube whose shapes, stresses and interface motions are random numbers: nothing of them is smooth.
superelement::Superelement random_part(Random& random) {
  superelement::Superelement se =
      synthetic::tube(random.integer(3, 8), random.integer(2, 5), random.integer(1, 5));
  synthetic::add_stress(se);
  random.fill(se.shapes, 1.0);
  random.fill(se.stress->S, 1e8);
  return se;
}

/// One pulse in a quiet run, swinging, turning on and on, or noise.
double course(Random& random, int kind, double phase, double t) {
  constexpr double pi = std::numbers::pi;
  return kind == 0   ? 1e-3 * std::sin(2 * pi * t) + std::exp(-std::pow((t - 0.4 - 0.2 * phase) / 0.003, 2))
         : kind == 1 ? std::sin(2 * pi * (7.3 * t + phase))
         : kind == 2 ? t
                     : random.uniform(-1.0, 1.0);
}

struct Sample {
  Pictures pictures;
  results::Results results;
};

/// The bodies "a" (flexible) and "b" (rigid) in random motion.
Sample random_results(Random& random) {
  Sample sample;
  const auto se = std::make_shared<superelement::Superelement>(random_part(random));
  sample.pictures["a"] = se;
  sample.results.model.name = "random";
  sample.results.model.bodies = {{"a", "flexible", "", ""}, {"b", "rigid", "", ""}};
  results::Run run;
  run.name = "run";
  run.complete = true;
  const Index n_t = random.integer(1, 4) == 1 ? random.integer(1, 3) : random.integer(50, 300);
  run.time = Eigen::VectorXd::LinSpaced(n_t, 0.0, 1.0);
  run.values.resize(n_t, 1);
  run.quantities = {{"pulse", "m", ""}};
  const int kind = random.integer(0, 3);
  for (const char* const name : {"a", "b"}) {
    results::BodyHistory body;
    body.name = name;
    body.pose.resize(n_t, 7);
    const Vector3d axis =
        Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.1, 1)).normalized();
    const double turn = random.uniform(0.0, 9.0), way = random.uniform(0.0, 1.0),
                 phase = random.uniform(0, 1);
    for (Index i = 0; i < n_t; ++i) {
      const Eigen::Quaterniond q(Eigen::AngleAxisd(turn * course(random, kind, phase, run.time[i]), axis));
      const Vector3d p =
          way * course(random, kind, 0.5 * phase, run.time[i]) * axis + Vector3d(0.2, 0.0, -0.1);
      body.pose.row(i) << p.transpose(), q.w(), q.x(), q.y(), q.z();
    }
    run.bodies.push_back(body);
  }
  results::BodyHistory& a = run.bodies[0];
  const int m = random.integer(1, 4);
  a.basis.resize(se->n(), m);
  random.fill(a.basis, 1.0);
  a.modal.resize(n_t, m);
  for (int j = 0; j < m; ++j) {
    const double size = std::pow(10.0, random.uniform(-6, 0)), phase = random.uniform(0, 1);
    for (Index i = 0; i < n_t; ++i) a.modal(i, j) = size * course(random, kind, phase, run.time[i]);
  }
  for (Index i = 0; i < n_t; ++i) run.values(i, 0) = course(random, kind, 0.3, run.time[i]);
  sample.results.runs = {run};
  return sample;
}

Eigen::Isometry3d pose_of(const results::BodyHistory& body, Index row) {
  const auto x = body.pose.row(row);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(x[3], x[4], x[5], x[6]).toRotationMatrix();
  X.translation() = x.head<3>().transpose();
  return X;
}

struct Found {
  double value = -1.0;
  Index row = 0, vertex = 0;
};

/// The size of `of(row, vertex)`, largest over everything.
template <typename Function>
Found everywhere(Index rows, Index vertices, const Function& of) {
  Found found;
  for (Index i = 0; i < rows; ++i)
    for (Index v = 0; v < vertices; ++v)
      if (const double value = of(i, v); value > found.value) found = {value, i, v};
  return found;
}

class Largest : public ::testing::TestWithParam<int> {};

TEST_P(Largest, IsThatOfAllStoredRowsAndAllVertices) {
  for (int seed = GetParam(); seed < GetParam() + 50; ++seed) {
    SCOPED_TRACE(seed);
    Random random{std::mt19937(static_cast<unsigned>(seed))};
    const Sample sample = random_results(random);
    const auto& se = *sample.pictures.at("a");
    const results::Run& run = sample.results.runs[0];
    const results::BodyHistory &a = run.bodies[0], &b = run.bodies[1];
    const auto path = scratch(fmt::format("largest_{}.html", seed));
    // Few frames and values: what is drawn has no say in what is largest.
    write_motion_page(path, sample.results, sample.pictures,
                      {.plots = {}, .most_frames = 10, .most_values = 20.0});
    const PageReader page(slurp(path));
    const json& largest = page.header["runs"][0]["bodies"][0]["largest"];
    const auto frames = page.block<double>("run0/frame_time");

    const MatrixXd u = se.shapes.cast<double>() * a.basis * a.modal.transpose(),
                   s = se.stress->S * a.basis * a.modal.transpose();
    const Index n_t = run.time.size(), n_v = se.surface.vertices.rows();
    const auto displaced = [&](Index i, Index v) -> Vector3d { return u.block<3, 1>(3 * v, i); };
    const auto place = [&](Index v) -> Vector3d { return se.surface.vertices.row(v).transpose(); };
    const auto check = [&](const json& stated, const auto& of, Index vertices) {
      const Found expected = everywhere(n_t, vertices, of);
      // Sums of tens of products in another order; positions of 1 m take 1e-16 m away.
      EXPECT_NEAR(stated["value"].get<double>(), expected.value, 1e-12 * expected.value + 1e-15);
      // There and then the field has that value; another place may have the same.
      const double t = stated["time"];
      const Index row = std::lround(t * static_cast<double>(n_t - 1));
      EXPECT_EQ(run.time[row], t);
      EXPECT_NEAR(of(row, stated["vertex"].get<Index>()), expected.value, 1e-12 * expected.value + 1e-15);
      EXPECT_TRUE(std::ranges::find(frames, t) != frames.end()) << "the page has no picture of it";
    };
    const json& from = largest["displacement"];
    check(
        from["own"], [&](Index i, Index v) { return displaced(i, v).norm(); }, n_v);
    for (const superelement::Interface& interface : se.interfaces) {
      const MatrixXd moved = superelement::interface_motion(se, interface) * a.basis * a.modal.transpose();
      check(
          from["interface:" + interface.name],
          [&](Index i, Index v) {
            const Vector3d arm = place(v) - interface.p_BoN_B, turn = moved.block<3, 1>(3, i);
            return (displaced(i, v) - moved.block<3, 1>(0, i) - turn.cross(arm)).norm();
          },
          n_v);
    }
    const auto way = [&](const results::BodyHistory* observer) {
      return [&, observer](Index i, Index v) {
        const auto seen = [&](Index row) {
          return observer ? pose_of(*observer, row).inverse() * pose_of(a, row) : pose_of(a, row);
        };
        return Vector3d(seen(i) * (place(v) + displaced(i, v)) - seen(0) * place(v)).norm();
      };
    };
    check(from["ground"], way(nullptr), n_v);
    check(from["body:b"], way(&b), n_v);
    check(
        largest["stress"],
        [&](Index i, Index v) {
          // sqrt(3/2 s:s) of the deviator, the definition.
          const auto c = s.block<6, 1>(6 * v, i);
          Eigen::Matrix3d sigma;
          sigma << c[0], c[3], c[5], c[3], c[1], c[4], c[5], c[4], c[2];
          return std::sqrt(1.5) * (sigma - sigma.trace() / 3.0 * Eigen::Matrix3d::Identity()).norm();
        },
        static_cast<Index>(se.stress->vertices.size()));

    // The curve of a quantity keeps its ends as well, however few values the page holds.
    const auto values = page.block<double>("run0/quantity/0");
    EXPECT_EQ(std::ranges::max(values), run.values.col(0).maxCoeff());
    EXPECT_EQ(std::ranges::min(values), run.values.col(0).minCoeff());
  }
}

// Five times fifty random results.
INSTANTIATE_TEST_SUITE_P(Random, Largest, ::testing::Values(0, 50, 100, 150, 200));

}  // namespace
}  // namespace flexura::view
