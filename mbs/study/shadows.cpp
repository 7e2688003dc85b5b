// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/shadows.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "mbs/input/units.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Generalised-alpha for rho_inf (Chung and Hulbert 1993), in the form of Arnold and Bruels: the equations
// hold at the rows themselves, an auxiliary acceleration carries the algorithm.
struct Alpha {
  explicit Alpha(double rho) : m((2.0 * rho - 1.0) / (rho + 1.0)), f(rho / (rho + 1.0)) {
    beta = 0.25 * (1.0 + f - m) * (1.0 + f - m);
    gamma = 0.5 + f - m;
  }
  double m, f, beta, gamma;
};

constexpr double kRhoInf = 0.4;
constexpr int kLadder[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128};
// An output counts from this part of the largest one of its unit on: below it symmetry and round-off stand,
// not motion.  What nobody asked for by name has to be larger to matter.
constexpr double kNothing = 1e-6, kNothingUnasked = 1e-3;

// Where a block of modal coordinates of the run goes among those of the full mechanism.
struct ModalBlock {
  int body = 0;
  Index p_full = -1, v_full = -1, m_full = 0;
  Index p_run = -1, v_run = -1, m_run = 0;
  MatrixXd S;  ///< m_full x m_run: s_full = S s_run
};

std::map<std::string, int> by_name(int n, const auto& name_of) {
  std::map<std::string, int> names;
  for (int i = 0; i < n; ++i) names.emplace(name_of(i), i);
  return names;
}

// Indices of the run's entries in the full mechanism; -1 for entries that only the full one has.
std::vector<int> find_all(int n, const auto& name_of, const std::map<std::string, int>& in_run) {
  std::vector<int> from(static_cast<std::size_t>(n), -1);
  for (int i = 0; i < n; ++i)
    if (const auto found = in_run.find(name_of(i)); found != in_run.end())
      from[static_cast<std::size_t>(i)] = found->second;
  return from;
}

void gather(const std::vector<int>& from, const VectorXd& x, VectorXd& out) {
  for (std::size_t i = 0; i < from.size(); ++i) out(static_cast<Index>(i)) = from[i] >= 0 ? x(from[i]) : 0.0;
}

// Deformations of the run's basis in the full one: Y_run = Y_full S + R z, where the rigid part z is another
// choice of the body's frame and no deformation.
MatrixXd basis_map(const std::string& superelement, const MatrixXd& Y_full, const MatrixXd& Y_run) {
  const superelement::Superelement se =
      superelement::read(superelement, {.matrices = true, .inertia = false});
  // Displacements and rotations weigh by their inertia.
  const VectorXd scale = se.M_se.diagonal().cwiseSqrt();
  MatrixXd basis(Y_full.rows(), Y_full.cols() + 6);
  basis << Y_full, superelement::rigid_motions(se);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(scale.asDiagonal() * basis);
  const MatrixXd scaled = scale.asDiagonal() * Y_run;
  return qr.solve(scaled).topRows(Y_full.cols());
}

}  // namespace

struct Shadows::Impl {
  std::unique_ptr<mbs::Mechanism> full;
  std::unique_ptr<mbs::Equations::Scratch> scratch;
  std::vector<ModalBlock> blocks;
  std::vector<int> p_from, v_from, c_from, lambda_from;
  VectorXd stiffness, damping;  ///< n_v, zero for joint coordinates
  std::vector<int> sources;     ///< bodies with dropped modes
  std::vector<int> outputs;     ///< quantities of the full mechanism
  std::vector<OutputEstimate> sums;
  MatrixXd source_sums;          ///< outputs x sources: integral of the error squared
  VectorXd square, square_size;  ///< integrals over time
  /// Of a source: its block and, for each number of modes tried, the integrals of the error squared.
  struct Rung {
    std::size_t block = 0;
    int modes = 0;
    std::size_t source = 0;
    VectorXd sum, last;
  };
  std::vector<Rung> rungs;
  int shadows = 0;
  bool asked = false;  ///< the user named the outputs
  double wall = 0.0;

  mbs::State s, moved;
  VectorXd v_dot, r, c_rate, b, y, y_moved, last_square, last_size;
  MatrixXd M, G, delta, rate, accel, auxiliary, last_source;
  double t = 0.0, span = 0.0;
  bool started = false;

  void embed(const mbs::State& run, const VectorXd& run_v_dot);
  void step(double h, const MatrixXd& load, MatrixXd& dlambda);
  void move(const VectorXd& d, const VectorXd& d_rate, const VectorXd& d_accel, const VectorXd& dlambda);
  void compare(double h, const MatrixXd& dlambda);
  void climb(double h, const MatrixXd& dlambda);
};

void Shadows::Impl::embed(const mbs::State& run, const VectorXd& run_v_dot) {
  s.t = run.t;
  gather(p_from, run.p, s.p);
  gather(v_from, run.v, s.v);
  gather(v_from, run_v_dot, v_dot);
  gather(c_from, run.c, s.c);
  gather(lambda_from, run.lambda, s.lambda);
  s.a = run.a;
  s.root = run.root;
  for (const ModalBlock& block : blocks) {
    if (block.m_run == 0) continue;
    s.p.segment(block.p_full, block.m_full) = block.S * run.p.segment(block.p_run, block.m_run);
    s.v.segment(block.v_full, block.m_full) = block.S * run.v.segment(block.v_run, block.m_run);
    v_dot.segment(block.v_full, block.m_full) = block.S * run_v_dot.segment(block.v_run, block.m_run);
  }
}

// From row to row with all columns (sources) at once; h = 0 only finds the accelerations at the start.
void Shadows::Impl::step(double h, const MatrixXd& load, MatrixXd& dlambda) {
  const Alpha alpha(kRhoInf);
  full->mass_matrix(s.p, *scratch, M);
  full->constraint_matrix(s.t, s.p, *scratch, G);
  MatrixXd A = M, rhs = load, predicted, predicted_rate;
  double to_accel = 0.0, to_rate = 0.0;
  if (h > 0.0) {
    // auxiliary_new = ((1 - f) accel_new + f accel - m auxiliary) / (1 - m)
    const MatrixXd carried = (alpha.f * accel - alpha.m * auxiliary) / (1.0 - alpha.m);
    predicted = delta + h * rate + h * h * ((0.5 - alpha.beta) * auxiliary + alpha.beta * carried);
    predicted_rate = rate + h * ((1.0 - alpha.gamma) * auxiliary + alpha.gamma * carried);
    const double share = (1.0 - alpha.f) / (1.0 - alpha.m);
    to_accel = h * h * alpha.beta * share;  // delta_new = predicted + to_accel accel_new
    to_rate = h * alpha.gamma * share;
    A.diagonal() += to_rate * damping + to_accel * stiffness;
    rhs -= damping.asDiagonal() * predicted_rate + stiffness.asDiagonal() * predicted;
  }
  // [A G^T; G 0] (accel, dlambda) = (rhs, 0 or what closes the loops at position level), by the Schur
  // complement; a part in 1e12 on its diagonal carries it over dead points and rows that others imply.
  const Eigen::LLT<MatrixXd> factor(A);
  MatrixXd accel_new = factor.solve(rhs);
  if (G.rows() > 0) {
    const MatrixXd B = factor.solve(G.transpose());
    MatrixXd schur = G * B;
    schur.diagonal() *= 1.0 + 1e-12;
    const double mean = schur.trace() / static_cast<double>(schur.rows());
    schur.diagonal().array() += 1e-12 * mean;
    MatrixXd gap = G * accel_new;
    if (h > 0.0) gap += G * predicted / to_accel;
    dlambda = Eigen::LLT<MatrixXd>(schur).solve(gap);
    accel_new -= B * dlambda;
  } else {
    dlambda.resize(0, load.cols());
  }
  if (h > 0.0) {
    delta = predicted + to_accel * accel_new;
    rate = predicted_rate + to_rate * accel_new;
    auxiliary = ((1.0 - alpha.f) * accel_new + alpha.f * accel - alpha.m * auxiliary) / (1.0 - alpha.m);
  } else {
    auxiliary = accel_new;
  }
  accel = std::move(accel_new);
}

// y_moved: the outputs of the corrected state.
void Shadows::Impl::move(const VectorXd& d, const VectorXd& d_rate, const VectorXd& d_accel,
                         const VectorXd& dlambda) {
  moved = s;
  full->retract(s.p, d, moved.p);
  moved.v += d_rate;
  if (dlambda.size() > 0) moved.lambda += dlambda;
  full->evaluate(outputs, moved, v_dot + d_accel, *scratch, y_moved);
}

void Shadows::Impl::compare(double h, const MatrixXd& dlambda) {
  full->evaluate(outputs, s, v_dot, *scratch, y);
  const Index n = y.size(), n_sources = static_cast<Index>(sources.size());
  VectorXd now_square(n), now_size(n);
  MatrixXd now_source = MatrixXd::Zero(n, n_sources);
  // Each source alone, then all together (which is the same where there is one).
  for (Index k = n_sources > 1 ? 0 : n_sources; k <= n_sources; ++k) {
    const bool all = k == n_sources;
    const auto part = [&](const MatrixXd& columns) {
      return all ? VectorXd(columns.rowwise().sum()) : VectorXd(columns.col(k));
    };
    move(part(delta), part(rate), part(accel), dlambda.rows() > 0 ? part(dlambda) : VectorXd());
    if (!all) now_source.col(k) = (y_moved - y).cwiseAbs2();
  }
  for (Index i = 0; i < n; ++i) {
    OutputEstimate& sum = sums[static_cast<std::size_t>(i)];
    const double error = std::abs(y_moved(i) - y(i));
    sum.max = std::max(sum.max, error);
    sum.size_max = std::max(sum.size_max, std::abs(y_moved(i)));
    sum.final = error;
    now_square(i) = error * error;
    now_size(i) = y_moved(i) * y_moved(i);
  }
  if (n_sources == 1) now_source.col(0) = now_square;
  if (h > 0.0) {
    square += 0.5 * h * (now_square + last_square);
    square_size += 0.5 * h * (now_size + last_size);
    source_sums += 0.5 * h * (now_source + last_source);
    span += h;
  }
  last_square = now_square;
  last_size = now_size;
  last_source = now_source;
  climb(h, dlambda);
}

// What is lost when only the lowest modes of a body take part in the correction.
void Shadows::Impl::climb(double h, const MatrixXd& dlambda) {
  if (rungs.empty()) return;
  const VectorXd whole = y_moved,
                 reaction = dlambda.rows() > 0 ? VectorXd(dlambda.rowwise().sum()) : VectorXd();
  for (Rung& rung : rungs) {
    const ModalBlock& block = blocks[rung.block];
    VectorXd d = delta.rowwise().sum(), d_rate = rate.rowwise().sum(), d_accel = accel.rowwise().sum();
    for (VectorXd* x : {&d, &d_rate, &d_accel})
      x->segment(block.v_full + rung.modes, block.m_full - rung.modes).setZero();
    move(d, d_rate, d_accel, reaction);
    const VectorXd now = (y_moved - whole).cwiseAbs2();
    if (h > 0.0) rung.sum += 0.5 * h * (now + rung.last);
    rung.last = now;
  }
}

Shadows::Shadows(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Shadows::~Shadows() = default;

std::unique_ptr<Shadows> Shadows::make(const mbs::PreparedMechanism& run, const std::filesystem::path& file,
                                       const std::vector<std::string>& overrides, bool with_ladder) {
  const mbs::Mechanism& mechanism = *run.mechanism;
  const auto& bodies = mechanism.description().bodies;
  std::vector<std::string> full_overrides = overrides;
  bool any = false;
  for (const mbs::BodyDescription& body : bodies) {
    if (body.superelement.empty()) continue;
    any = true;
    // Overrides cannot take a key away, so the bounds are set beyond any superelement.
    for (const char* const text : {"fidelity=modal", "modes=1000000", "max_frequency=1e15"})
      full_overrides.push_back(fmt::format("body.{}.{}", body.name, text));
  }
  if (!any) return nullptr;

  auto impl = std::make_unique<Impl>();
  Impl& in = *impl;
  mbs::MechanismFile all = mbs::read_mechanism(file, mbs::solver_schema(), full_overrides);
  in.full = std::make_unique<mbs::Mechanism>(std::move(all.description));
  const mbs::Mechanism& full = *in.full;
  const mbs::Sizes n_run = mechanism.sizes();
  const mbs::Sizes before = full.sizes();

  const auto p_run = by_name(n_run.n_p, [&](int i) { return mechanism.name_of_position(i); });
  const auto v_run = by_name(n_run.n_v, [&](int i) { return mechanism.name_of_velocity(i); });
  const auto p_names = by_name(before.n_p, [&](int i) { return full.name_of_position(i); });
  const auto v_names = by_name(before.n_v, [&](int i) { return full.name_of_velocity(i); });
  in.p_from = find_all(
      before.n_p, [&](int i) { return full.name_of_position(i); }, p_run);
  in.v_from = find_all(
      before.n_v, [&](int i) { return full.name_of_velocity(i); }, v_run);
  in.stiffness = in.damping = VectorXd::Zero(before.n_v);
  const auto& full_bodies = full.description().bodies;
  for (std::size_t i = 0; i < full_bodies.size(); ++i) {
    if (!full_bodies[i].flexible) continue;
    const mbs::ModalData& data = full_bodies[i].flexible->data();
    ModalBlock block;
    block.body = static_cast<int>(i);
    block.m_full = data.Y.cols();
    const std::string first = full_bodies[i].name + ".mode_1";
    block.p_full = p_names.at(first);
    block.v_full = v_names.at(first + "_rate");
    in.stiffness.segment(block.v_full, block.m_full) = data.stiffness;
    in.damping.segment(block.v_full, block.m_full) = data.damping;
    if (bodies[i].flexible && p_run.contains(first)) {
      const MatrixXd& Y_run = bodies[i].flexible->data().Y;
      block.p_run = p_run.at(first);
      block.v_run = v_run.at(first + "_rate");
      block.m_run = Y_run.cols();
      block.S = basis_map(full_bodies[i].superelement, data.Y, Y_run);
    }
    if (block.m_run < block.m_full) {
      in.sources.push_back(block.body);
      in.shadows += static_cast<int>(block.m_full - block.m_run);
    }
    in.blocks.push_back(std::move(block));
  }
  if (in.sources.empty()) return nullptr;

  in.s.p.resize(before.n_p);
  in.s.v.resize(before.n_v);
  in.v_dot.resize(before.n_v);
  in.s.c.resize(before.n_dyn);
  in.c_from = find_all(
      before.n_dyn, [&](int i) { return full.name_of_dynamic(i); },
      by_name(n_run.n_dyn, [&](int i) { return mechanism.name_of_dynamic(i); }));
  in.s.lambda.resize(0);
  in.embed(run.state, run.v_dot);
  in.full->drop_redundant(run.state.t, in.s.p);
  const mbs::Sizes n = full.sizes();
  in.lambda_from = find_all(
      n.n_lambda, [&](int i) { return full.name_of_constraint(i); },
      by_name(n_run.n_lambda, [&](int i) { return mechanism.name_of_constraint(i); }));
  in.s.lambda.resize(n.n_lambda);
  in.scratch = full.make_scratch();
  in.M.resize(n.n_v, n.n_v);
  in.G.resize(n.n_lambda, n.n_v);
  in.r.resize(n.n_v);
  in.c_rate.resize(n.n_dyn);
  in.b.resize(n.n_alg);
  const Index n_sources = static_cast<Index>(in.sources.size());
  in.delta = in.rate = in.accel = in.auxiliary = MatrixXd::Zero(n.n_v, n_sources);

  in.asked = !run.file.outputs.empty();
  // Outputs that both mechanisms have; modal coordinates of a body are no outputs of an engineer's.
  const auto run_infos = mechanism.quantities(), infos = full.quantities();
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < infos.size(); ++i) index.emplace(infos[i].name, static_cast<int>(i));
  for (const int i : mbs::select_quantities(mechanism, run.file.outputs)) {
    const std::string& name = run_infos[static_cast<std::size_t>(i)].name;
    const auto found = index.find(name);
    if (found == index.end() || name.find(".mode_") != std::string::npos) continue;
    // Energies are stored for the balance; strain energy is not what a rigid body is judged by.
    if (!in.asked &&
        (name.starts_with("energy.") || name.starts_with("power.") || name.ends_with(".strain_energy")))
      continue;
    in.outputs.push_back(found->second);
    OutputEstimate output;
    output.name = name;
    output.unit = input::si_unit(infos[static_cast<std::size_t>(found->second)].dimension);
    in.sums.push_back(std::move(output));
  }
  const Index n_out = static_cast<Index>(in.outputs.size());
  in.y = in.y_moved = in.square = in.square_size = in.last_square = in.last_size = VectorXd::Zero(n_out);
  in.source_sums = in.last_source = MatrixXd::Zero(n_out, n_sources);
  if (with_ladder) {
    for (std::size_t k = 0; k < in.sources.size(); ++k)
      for (std::size_t i = 0; i < in.blocks.size(); ++i)
        for (const int modes : kLadder)
          if (in.blocks[i].body == in.sources[k] && modes < in.blocks[i].m_full)
            in.rungs.push_back({i, modes, k, VectorXd::Zero(n_out), VectorXd::Zero(n_out)});
  }
  return std::unique_ptr<Shadows>(new Shadows(std::move(impl)));
}

void Shadows::take(const mbs::State& s, const VectorXd& v_dot) {
  Impl& in = *impl_;
  const auto start = std::chrono::steady_clock::now();
  const double h = in.started ? s.t - in.t : 0.0;
  if (!in.started || h > 0.0) {
    in.embed(s, v_dot);
    in.full->momentum(in.s, in.v_dot, *in.scratch, in.r, in.c_rate, in.b);
    MatrixXd load = MatrixXd::Zero(in.r.size(), static_cast<Index>(in.sources.size()));
    for (std::size_t k = 0; k < in.sources.size(); ++k)
      for (const ModalBlock& block : in.blocks)
        if (block.body == in.sources[k])
          load.col(static_cast<Index>(k)).segment(block.v_full, block.m_full) =
              -in.r.segment(block.v_full, block.m_full);
    MatrixXd dlambda;
    in.step(h, load, dlambda);
    in.compare(h, dlambda);
    in.started = true;
    in.t = s.t;
  }
  in.wall += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double OutputEstimate::relative_max() const {
  return size_max > 0.0 ? max / size_max : 0.0;
}
double OutputEstimate::relative_rms() const {
  return size_rms > 0.0 ? rms / size_rms : 0.0;
}

TruncationEstimate Shadows::estimate() const {
  const Impl& in = *impl_;
  TruncationEstimate out;
  out.shadows = in.shadows;
  out.wall = in.wall;
  out.outputs = in.sums;
  const double span = std::max(in.span, 1e-300);
  std::map<std::string, double> largest;
  for (std::size_t i = 0; i < out.outputs.size(); ++i) {
    OutputEstimate& o = out.outputs[i];
    o.rms = std::sqrt(in.square(static_cast<Index>(i)) / span);
    o.size_rms = std::sqrt(in.square_size(static_cast<Index>(i)) / span);
    double& most = largest[o.unit];
    most = std::max(most, o.size_rms);
  }
  for (std::size_t i = 0; i < out.outputs.size(); ++i) {
    OutputEstimate& o = out.outputs[i];
    o.counts = o.size_rms > (in.asked ? kNothing : kNothingUnasked) * largest[o.unit];
    if (o.counts && o.relative_rms() > out.error) {
      out.error = o.relative_rms();
      out.worst = static_cast<int>(i);
    }
  }
  // The worst output of a squared error, relative.
  const auto worst_of = [&](const auto& sums) {
    std::pair<double, int> worst{0.0, -1};
    for (std::size_t i = 0; i < out.outputs.size(); ++i) {
      const OutputEstimate& o = out.outputs[i];
      if (!o.counts) continue;
      const double error = std::sqrt(sums(static_cast<Index>(i)) / span) / o.size_rms;
      if (error > worst.first) worst = {error, static_cast<int>(i)};
    }
    return worst;
  };
  for (std::size_t k = 0; k < in.sources.size(); ++k) {
    SourceEstimate source;
    source.body = in.full->description().bodies[static_cast<std::size_t>(in.sources[k])].name;
    const auto [error, which] = worst_of(in.source_sums.col(static_cast<Index>(k)));
    source.error = error;
    if (which >= 0) source.output = out.outputs[static_cast<std::size_t>(which)].name;
    for (const ModalBlock& block : in.blocks)
      if (block.body == in.sources[k]) source.available = static_cast<int>(block.m_full);
    for (const Impl::Rung& rung : in.rungs) {
      if (rung.source != k) continue;
      const double omega2 = in.stiffness(in.blocks[rung.block].v_full + rung.modes - 1);
      source.ladder.push_back(
          {rung.modes, worst_of(rung.sum).first, std::sqrt(omega2) / (2.0 * std::numbers::pi)});
    }
    out.by_body.push_back(std::move(source));
  }
  std::ranges::stable_sort(out.by_body, std::ranges::greater(), &SourceEstimate::error);
  return out;
}

}  // namespace flexura::study
