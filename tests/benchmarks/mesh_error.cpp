// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "mesh/model/geometry.hpp"
#include "reduce/app/make_part.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/mesh_share.hpp"
#include "reduce/cms/verification.hpp"
#include "reduce/linalg/session.hpp"
#include "tests/reduce/parts.hpp"

/// What the estimate of the mesh's error is worth: parts on coarse meshes against meshes refined until they are known.
/// mesh_error [NAME ...] prints docs/mesh_error.md.
namespace flexura::reduce {
namespace {

using mesh::CellType;
using testing::beam;
using Eigen::Vector3d;

constexpr int kModes = 4;

/// What is compared: the first elastic frequencies of the free body [Hz] and the compliance of each interface in each
/// direction while the others are held.
struct Answer {
  std::vector<double> hz, compliance;
  int dofs = 0;
};

struct Subject {
  std::string name, kind;
  std::function<Part()> coarse;
  bool held_out = false;  ///< not seen when the estimate was made
  /// Finer and finer, each twice as fine as the one before; the last two are extrapolated.
  std::vector<std::function<Part()>> fine;
};

std::vector<double> compliance_of(const Reduction& r) {
  std::vector<double> out;
  if (r.interfaces.size() < 2) return out;
  for (const ReducedInterface& interface : r.interfaces) {
    const auto n = static_cast<Eigen::Index>(interface.directions.size());
    if (n == 0) continue;
    const Eigen::MatrixXd C =
        r.K_se.block(interface.first_dof, interface.first_dof, n, n).inverse();
    for (Eigen::Index d = 0; d < n; ++d) out.push_back(C(d, d));
  }
  return out;
}

struct Run {
  Answer answer;
  MeshShare share;
  double seconds_factor = 0.0, seconds_estimate = 0.0;
};

Run run(const Part& part) {
  ReductionOptions options;
  options.n_modes = 40;
  options.estimate_mesh = true;
  const Reduction r = craig_bampton(part, options);
  Run out;
  const Eigen::VectorXd first = reduced_free_modes(r);
  const linalg::EigenPairs full = full_free_modes(part, kModes, first(6), {}, 1e-7);
  for (int k = 0; k < kModes; ++k) out.answer.hz.push_back(std::sqrt(full.omega2(6 + k)) / (2 * std::numbers::pi));
  out.answer.compliance = compliance_of(r);
  out.answer.dofs = r.report.n_i;
  out.share = r.mesh.value();
  out.seconds_factor = r.report.factor.processor_seconds;
  out.seconds_estimate = r.report.processor_seconds_mesh_error;
  return out;
}

// Richardson: three answers with spacings h, h/2, h/4; the order is what they show, at least 1 (corners).
double limit_of(double a, double b, double c) {
  const double ratio = (a - b) / (b - c);
  if (!(ratio > 1.5) || !std::isfinite(ratio)) return c;
  return c - (b - c) / (std::min(ratio, 32.0) - 1.0);
}

const Answer& truth_of(const Subject& subject) {
  static std::map<std::string, Answer> known;
  if (const auto found = known.find(subject.kind); found != known.end()) return found->second;

  std::vector<Answer> answers;
  for (const auto& make : subject.fine) {
    const Part part = make();
    ReductionOptions options;
    options.n_modes = 10;
    const Reduction r = craig_bampton(part, options);
    const linalg::EigenPairs full = full_free_modes(part, kModes, reduced_free_modes(r)(6), {}, 1e-7);
    Answer a;
    for (int k = 0; k < kModes; ++k) a.hz.push_back(std::sqrt(full.omega2(6 + k)) / (2 * std::numbers::pi));
    a.compliance = compliance_of(r);
    a.dofs = r.report.n_i;
    answers.push_back(a);
    std::cerr << fmt::format("{}: {} dofs\n", subject.kind, a.dofs);
  }
  Answer out = answers.back();
  if (answers.size() >= 3) {
    const std::size_t n = answers.size();
    for (std::size_t k = 0; k < out.hz.size(); ++k)
      out.hz[k] = limit_of(answers[n - 3].hz[k], answers[n - 2].hz[k], answers[n - 1].hz[k]);
    for (std::size_t k = 0; k < out.compliance.size(); ++k)
      out.compliance[k] =
          limit_of(answers[n - 3].compliance[k], answers[n - 2].compliance[k], answers[n - 1].compliance[k]);
  }
  return known[subject.kind] = out;
}

// The cells of a mesh whose centre is inside.
mesh::Mesh carved(mesh::Mesh mesh, const std::function<bool(const Vector3d&)>& inside) {
  for (mesh::CellBlock& block : mesh.solids) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      Vector3d centre = Vector3d::Zero();
      const int corners = mesh::shape_of(block.type).corners;
      for (int a = 0; a < corners; ++a) centre += mesh.points.row(block.nodes(cell, a)).transpose() / corners;
      if (inside(centre)) kept.push_back(cell);
    }
    block.nodes = block.nodes(kept, Eigen::all).eval();
  }
  mesh.boundary.clear();
  mesh::drop_unused_nodes(mesh);
  mesh::extract_boundary(mesh);
  return mesh;
}

Part part_of(mesh::Mesh mesh, const Vector3d& left_normal, double left, const Vector3d& right_normal, double right,
             Tie tie) {
  Part part;
  part.mesh = std::move(mesh);
  part.materials = {testing::steel()};
  const double size = part.mesh.points.cwiseAbs().maxCoeff();
  for (const auto& [name, normal, at] : {std::tuple{"left", left_normal, left}, std::tuple{"right", right_normal, right}}) {
    const Vector3d n = normal;
    const double d = at;
    InterfaceSpec spec{name, tie, Vector3d::Zero(), testing::nodes_where(part.mesh, [&](const Vector3d& x) {
                         return std::abs(x.dot(n) - d) < 1e-9 * size;
                       })};
    spec.point = mesh::measure_surface(part.mesh, spec.set.faces).centroid;
    part.interfaces.push_back(spec);
  }
  return part;
}

Part block(std::array<int, 3> n, CellType type) {
  return beam({1.0, 0.23, 0.17}, n, type, Tie::average, Tie::average);
}

Part plate(std::array<int, 3> n, CellType type) {
  return beam({0.3, 0.2, 0.004}, n, type, Tie::average, Tie::average);
}

// A block of 0.4 x 0.12 x 0.12 m with a step to half of it in both directions, sharp inside.
Part stepped(int n, CellType type) {
  mesh::Mesh mesh = testing::box({0.4, 0.12, 0.12}, {4 * n, 2 * n, 2 * n}, type);
  return part_of(carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.2 || (x(1) < 0.06 && x(2) < 0.06); }),
                 {1, 0, 0}, 0.0, {1, 0, 0}, 0.4, Tie::average);
}

// An angle: legs of 0.3 m, 0.05 x 0.05 m.
Part angle(int n, CellType type, Tie tie = Tie::average) {
  mesh::Mesh mesh = testing::box({0.3, 0.3, 0.05}, {6 * n, 6 * n, n}, type);
  return part_of(carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.05 || x(1) < 0.05; }), {1, 0, 0}, 0.3,
                 {0, 1, 0}, 0.3, tie);
}

// A round shaft with a sharp shoulder, by the map of a square on a disc: 0.4 m, radii 0.05 and 0.025 m.
Part shaft(int n, CellType type, Tie tie = Tie::average) {
  mesh::Mesh mesh = testing::box({0.4, 2.0, 2.0}, {8 * n, 4 * n, 4 * n}, type);
  mesh = carved(std::move(mesh), [](const Vector3d& x) {
    return x(0) < 0.2 || (std::abs(x(1) - 1.0) < 0.5 && std::abs(x(2) - 1.0) < 0.5);
  });
  testing::deform(mesh, [](const Vector3d& x) {
    const double y = x(1) - 1.0, z = x(2) - 1.0;
    const double greatest = std::max(std::abs(y), std::abs(z)), length = std::hypot(y, z);
    const double f = length > 0.0 ? 0.05 * greatest / length : 0.0;
    return Vector3d(x(0), f * y, f * z);
  });
  return part_of(std::move(mesh), {1, 0, 0}, 0.0, {1, 0, 0}, 0.4, tie);
}

// A frame like a U: 0.3 x 0.2 x 0.04 m, 0.05 m wide.
Part fork(int n, CellType type) {
  mesh::Mesh mesh = testing::box({0.3, 0.2, 0.04}, {6 * n, 4 * n, n}, type);
  return part_of(carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.05 || x(1) < 0.05 || x(1) > 0.15; }),
                 {1, 0, 0}, 0.3, {1, 0, 0}, 0.0, Tie::average);
}

// A bar of 0.4 x 0.04 x 0.02 m, twisted by a quarter turn.
Part twisted(int n, CellType type) {
  mesh::Mesh mesh = testing::box({0.4, 0.04, 0.02}, {6 * n, 2 * n, n}, type);
  testing::deform(mesh, [](const Vector3d& x) {
    const double angle = std::numbers::pi / 2 * x(0) / 0.4, y = x(1) - 0.02, z = x(2) - 0.01;
    return Vector3d(x(0), y * std::cos(angle) - z * std::sin(angle), y * std::sin(angle) + z * std::cos(angle));
  });
  return part_of(std::move(mesh), {1, 0, 0}, 0.0, {1, 0, 0}, 0.4, Tie::average);
}

// A square tube of 0.3 x 0.1 x 0.1 m with walls of 0.02 m.
Part tube(int n, CellType type) {
  mesh::Mesh mesh = testing::box({0.3, 0.1, 0.1}, {3 * n, 5 * n, 5 * n}, type);
  return part_of(carved(std::move(mesh),
                        [](const Vector3d& x) {
                          return x(1) < 0.02 || x(1) > 0.08 || x(2) < 0.02 || x(2) > 0.08;
                        }),
                 {1, 0, 0}, 0.0, {1, 0, 0}, 0.3, Tie::average);
}

Part cad(const std::string& file, double size, int order = 2) {
  PartInput input = read_part(file);
  input.cad.size = size;
  input.cad.order = order;
  input.cad.worker = std::filesystem::path(FLEXURA_BIN_DIR) / "flexura-mesh";
  input.cad.elements_per_circle = 16;
  input.cad.size_min = size / 3;
  Part part = make_part(input, load_part_mesh(input, {})).part;
  return part;
}

template <class Make>
std::vector<std::function<Part()>> three_of(Make make) {
  return {[=] { return make(1); }, [=] { return make(2); }, [=] { return make(4); }};
}

std::vector<Subject> subjects() {
  std::vector<Subject> out;
  const auto add = [&](const std::string& name, const std::string& kind, std::function<Part()> coarse,
                       std::vector<std::function<Part()>> fine, bool held_out = false) {
    out.push_back({name, kind, std::move(coarse), held_out, std::move(fine)});
  };
  const std::vector<std::function<Part()>> fine_block = {[] { return block({24, 6, 4}, CellType::hex20); }};
  add("block tet10 6x2x2", "block", [] { return block({6, 2, 2}, CellType::tet10); }, fine_block);
  add("block tet10 4x1x1", "block", [] { return block({4, 1, 1}, CellType::tet10); }, fine_block);
  add("block hex20 8x2x2", "block", [] { return block({8, 2, 2}, CellType::hex20); }, fine_block);
  add("block hex20 4x1x1", "block", [] { return block({4, 1, 1}, CellType::hex20); }, fine_block);
  add("block wedge15 5x1x1", "block", [] { return block({5, 1, 1}, CellType::wedge15); }, fine_block);
  add("block wedge15 10x2x2", "block", [] { return block({10, 2, 2}, CellType::wedge15); }, fine_block);
  add("block hex8 16x4x4", "block", [] { return block({16, 4, 4}, CellType::hex8); }, fine_block);
  add("block hex8 8x2x2", "block", [] { return block({8, 2, 2}, CellType::hex8); }, fine_block);
  add("block tet4 24x6x4", "block", [] { return block({24, 6, 4}, CellType::tet4); }, fine_block);
  add("block wedge6 16x4x4", "block", [] { return block({16, 4, 4}, CellType::wedge6); }, fine_block);
  const std::vector<std::function<Part()>> fine_plate = {[] { return plate({36, 24, 1}, CellType::hex20); }};
  add("plate hex20 6x4x1", "plate", [] { return plate({6, 4, 1}, CellType::hex20); }, fine_plate);
  add("plate tet10 12x8x1", "plate", [] { return plate({12, 8, 1}, CellType::tet10); }, fine_plate);
  add("plate hex8 60x40x2", "plate", [] { return plate({60, 40, 2}, CellType::hex8); }, fine_plate);
  const auto three = [](auto make) {
    return std::vector<std::function<Part()>>{[=] { return make(2); }, [=] { return make(4); }, [=] { return make(8); }};
  };
  const auto fine_stepped = three([](int n) { return stepped(n, CellType::hex20); });
  add("stepped block tet10", "stepped", [] { return stepped(2, CellType::tet10); }, fine_stepped);
  add("stepped block hex20", "stepped", [] { return stepped(1, CellType::hex20); }, fine_stepped);
  add("stepped block hex8", "stepped", [] { return stepped(4, CellType::hex8); }, fine_stepped);
  const std::vector<std::function<Part()>> fine_angle = {[] { return angle(1, CellType::hex20); },
                                                         [] { return angle(2, CellType::hex20); },
                                                         [] { return angle(4, CellType::hex20); }};
  add("angle tet10 1 across", "angle", [] { return angle(1, CellType::tet10); }, fine_angle);
  add("angle hex20 2 across", "angle", [] { return angle(2, CellType::hex20); }, fine_angle);
  add("angle tet4 3 across", "angle", [] { return angle(3, CellType::tet4); }, fine_angle);
  const std::vector<std::function<Part()>> fine_rigid = {[] { return angle(1, CellType::hex20, Tie::rigid); },
                                                         [] { return angle(2, CellType::hex20, Tie::rigid); },
                                                         [] { return angle(4, CellType::hex20, Tie::rigid); }};
  add("angle, rigid ends tet10", "angle rigid", [] { return angle(1, CellType::tet10, Tie::rigid); }, fine_rigid);
  const std::vector<std::function<Part()>> fine_shaft = {[] { return shaft(1, CellType::hex20); },
                                                         [] { return shaft(2, CellType::hex20); },
                                                         [] { return shaft(4, CellType::hex20); }};
  add("shouldered shaft hex20", "shaft", [] { return shaft(1, CellType::hex20); }, fine_shaft);
  const std::string root = FLEXURA_SOURCE_DIR;
  const auto add_cad = [&](const std::string& name, const std::string& file, double size, std::vector<double> sizes,
                           int order = 2, bool held_out = false) {
    std::vector<std::function<Part()>> fine;
    for (const double s : sizes) fine.push_back([=] { return cad(file, s); });
    add(name, file.substr(file.rfind('/') + 1), [=] { return cad(file, size, order); }, fine, held_out);
  };
  add_cad("rod", root + "/tests/found/user/rod.toml", 0.012, {0.012, 0.006, 0.003});
  add_cad("crank arm", root + "/tests/found/user/crank_arm.toml", 0.01, {0.010, 0.005, 0.0025});
  add_cad("bracket", root + "/tests/found/user/bracket.toml", 0.02, {0.018, 0.009, 0.0045});
  constexpr bool kHeldOut = true;
  add("fork tet10", "fork", [] { return fork(1, CellType::tet10); }, three_of([](int n) { return fork(n, CellType::hex20); }), kHeldOut);
  add("fork hex20", "fork", [] { return fork(1, CellType::hex20); }, three_of([](int n) { return fork(n, CellType::hex20); }), kHeldOut);
  add("twisted bar tet10", "twisted", [] { return twisted(1, CellType::tet10); }, three_of([](int n) { return twisted(n, CellType::hex20); }), kHeldOut);
  add("twisted bar hex8", "twisted", [] { return twisted(3, CellType::hex8); }, three_of([](int n) { return twisted(n, CellType::hex20); }), kHeldOut);
  add("square tube tet10", "tube", [] { return tube(1, CellType::tet10); }, three_of([](int n) { return tube(n, CellType::hex20); }), kHeldOut);
  add("square tube wedge15", "tube", [] { return tube(1, CellType::wedge15); }, three_of([](int n) { return tube(n, CellType::hex20); }), kHeldOut);
  add_cad("shaft with shoulders", root + "/tests/found/reduce/shaft_seats.toml", 0.02, {0.016, 0.008, 0.004}, 2, kHeldOut);

  return out;
}

struct Tally {
  double least = 1e9, most = 0.0;
  int rows = 0, outside = 0;
} tally, held_out;

void report(const Subject& subject) {
  const Run coarse = run(subject.coarse());
  const Answer& truth = truth_of(subject);
  const std::string cost = fmt::format("{} dofs, {:.2f} s, {:.2f} s", coarse.answer.dofs, coarse.seconds_factor,
                                       coarse.seconds_estimate);
  const auto row = [&](const std::string& what, double error, double estimate, const std::string& end) {
    const double effectivity = estimate / error;
    // Below a thousandth the truth is not known well enough; there the estimate has to be small, too.
    const bool tiny = error < 1e-3 && estimate < 3e-3;
    Tally& to = subject.held_out ? held_out : tally;
    if (!tiny) {
      to.least = std::min(to.least, effectivity);
      to.most = std::max(to.most, effectivity);
      to.outside += effectivity < 0.5 || effectivity > 2.0;
    }
    ++to.rows;
    fmt::print("| {} | {} | {:.3f} % | {:.3f} % | {} | {} |\n", subject.name + (subject.held_out ? " (held out)" : ""), what, 100 * error, 100 * estimate,
               tiny ? std::string("both small") : fmt::format("{:.2f}", effectivity), end);
  };
  for (int k = 0; k < kModes; ++k)
    row(fmt::format("{:.5g} Hz", truth.hz[k]), coarse.answer.hz[k] / truth.hz[k] - 1,
        coarse.share.modes[static_cast<std::size_t>(k)].error, k == 0 ? cost : "");
  // Both interfaces tell the same: the first, in its worst direction.
  if (!truth.compliance.empty() && !coarse.share.interfaces.empty()) {
    double worst = 0.0;
    for (std::size_t d = 0; d < 6; ++d) worst = std::max(worst, 1 - coarse.answer.compliance[d] / truth.compliance[d]);
    row("compliance at " + coarse.share.interfaces[0].name, worst, coarse.share.interfaces[0].error, "");
  }
  std::fflush(stdout);
}

void head() {
  fmt::print(R"(# The mesh's error and its estimate

Written by `tests/run mesh_error` (tests/benchmarks/mesh_error.cpp); do not edit by hand.

A mesh makes a part too stiff. By how much, in each frequency and in the static compliance of the interfaces, is estimated by
what elements of the next higher degree would add (reduce/estimate/enriched_error.hpp): the residual of the shape is answered by
their functions, in a few steps of conjugate gradients; on a large mesh only on pieces of it, some where most of the error is,
some at random places, from which the rest is told by an indicator that is cheap everywhere. Cells of second degree get a fifth
more for the degrees after that, which was measured on the parts of this table except those that are held out.
Meshes of pyramids, hex27, elements with reduced integration or incompatible modes and parts with elastic ties are judged by
recovered stresses instead (reduce/estimate/mesh_error.hpp), which where few cells lie across are off by up to five; the report
says so.

The truth is that of 20-node bricks and 10-node tetrahedra on fine meshes. Where edges and corners make frequencies converge
slowly, three meshes are extrapolated, by 0.5 % at most (the stepped block). Frequencies are paired by their order: meshes so
coarse that modes change places are left out, but not among the held-out parts, which stand as they came: the square tube's third
and fourth mode change places from mesh to mesh (their limits are out of order), so that its row at 4678.8 Hz is no truth; the
fourth of the twisted bar of hex8, whose bending is 20 % off, may be its fifth. Effectivity is the estimate over the true error;
below 0.1 % both are called small where the estimate is below 0.3 %. Cost: dofs, processor seconds of the factorisation and of the estimate on the machine that
made the table; small parts say little. The crank arm in finer meshes of tet10, two interfaces and ten modes: the estimate takes
0.55 of the factorisation with 51,000 dofs, 0.21 with 90,000 and 0.13 with 181,000 (processor time, one run each).

| part | quantity | true error | estimate | effectivity | cost |
|---|---|---|---|---|---|
)");
}

}  // namespace
}  // namespace flexura::reduce

int main(int argc, char** argv) {
  using namespace flexura;
  const linalg::Session session;
  reduce::head();
  for (const reduce::Subject& subject : reduce::subjects()) {
    bool wanted = argc < 2;
    for (int k = 1; k < argc; ++k) wanted |= subject.name.find(argv[k]) != std::string::npos;
    if (!wanted) continue;
    try {
      reduce::report(subject);
    } catch (const std::exception& error) {
      fmt::print(stderr, "error: {}: {}\n", subject.name, error.what());
      return 1;
    }
  }
  for (const auto& [name, t] : {std::pair{"", reduce::tally}, std::pair{"held out: ", reduce::held_out}})
    if (t.rows > 0)
      fmt::print("\n{}{} quantities; effectivity {:.2f} to {:.2f}, {} outside 0.5 to 2.\n", name, t.rows, t.least, t.most,
                 t.outside);
}
