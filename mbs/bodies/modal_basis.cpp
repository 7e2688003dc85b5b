// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/modal_basis.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mbs/bodies/modal_problem.hpp"
#include "mbs/bodies/mode_choice.hpp"
#include "mbs/bodies/preparation_cache.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// `K0F` in the modes Y, of every interface dof; empty without stiffening.
FlexibleNode node_of(const BodyNode& at, const MatrixXd& Y, const std::vector<MatrixXd>& K0F) {
  const Index m = Y.cols();
  FlexibleNode node;
  node.name = at.name;
  node.p_BoN_B = at.p_BoN_B;
  node.Phi_t = at.rows.topRows<3>() * Y;
  node.Phi_r = at.rows.bottomRows<3>() * Y;
  if (K0F.empty() || !at.is_on_interfaces) return node;
  MatrixXd second = MatrixXd::Zero(6 * m, m);
  for (std::size_t dof = 0; dof < K0F.size(); ++dof)
    for (int k = 0; k < 6; ++k)
      if (const double share = at.rows(k, static_cast<Index>(dof)); share != 0.0)
        second.middleRows(k * m, m) -= share * K0F[dof];
  if (!second.isZero(0.0)) node.second = std::move(second);
  return node;
}

/// All of the nodes' ties side by side.
MatrixXd ties_of(const superelement::Superelement& se, const std::vector<BodyNode>& nodes) {
  MatrixXd ties(se.n(), 0);
  for (const BodyNode& node : nodes) {
    if (node.ties.cols() == 0) continue;
    ties.conservativeResize(Eigen::NoChange, ties.cols() + node.ties.cols());
    ties.rightCols(node.ties.cols()) = node.ties;
  }
  return ties;
}

}  // namespace

superelement::InertiaIntegrals transform(const superelement::InertiaIntegrals& in, const MatrixXd& Y) {
  superelement::InertiaIntegrals out;
  out.mass = in.mass;
  out.S_x = in.S_x;
  out.S_xx = in.S_xx;
  out.S_phi = in.S_phi * Y;
  out.S_xphi = in.S_xphi * Y;
  for (int k = 0; k < 6; ++k) out.S_phiphi[k] = Y.transpose() * in.S_phiphi[k] * Y;
  return out;
}

SecondOrderIntegrals second_order_integrals(const superelement::StiffeningTerms& terms, const MatrixXd& Y) {
  const Index m = Y.cols();
  const auto in_modes = [&](const MatrixXd& K0) { return MatrixXd(Y.transpose() * K0 * Y); };
  SecondOrderIntegrals out;
  out.t.resize(3 * m, m);
  out.x.resize(9 * m, m);
  MatrixXd trace = MatrixXd::Zero(m, m);
  for (int a = 0; a < 3; ++a) {
    out.t.middleRows(a * m, m) = in_modes(terms.K0t[a]);
    out.x.middleRows(4 * a * m, m) = in_modes(terms.K0omega[a]);
    trace -= 0.5 * out.x.middleRows(4 * a * m, m);
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;  // K0omega holds xy, yz, zx behind xx, yy, zz
    out.x.middleRows(4 * a * m, m) += trace;
    const MatrixXd sum = in_modes(terms.K0omega[3 + a]), difference = in_modes(terms.K0r[c]);
    out.x.middleRows((3 * a + b) * m, m) = 0.5 * (sum + difference);
    out.x.middleRows((3 * b + a) * m, m) = 0.5 * (sum - difference);
  }
  return out;
}

MatrixXd interface_loads(const superelement::Superelement& se, int interface, const Vector3d& offset) {
  return node_loads(interface_node(se, interface), offset);
}

MatrixXd interface_loads(const superelement::Superelement& se, const std::vector<int>& interfaces) {
  MatrixXd P(se.n(), 6 * interfaces.size());
  for (std::size_t k = 0; k < interfaces.size(); ++k)
    P.middleCols<6>(6 * static_cast<Index>(k)) = interface_loads(se, interfaces[k]);
  return P;
}

namespace {

/// The steps of modal_data(), each kept in the cache by what it depends on.
class Preparation {
 public:
  Preparation(const superelement::Superelement& se, const BasisOptions& options, PreparationCache& cache)
      : se_(se), options_(options), cache_(cache), ties_(ties_of(se, options.nodes)) {
    input::ContentHash hash;
    add_to(add_to(add_to(hash, se.K_se), se.M_se), ties_);
    for (const superelement::Interface& i : se.interfaces) {
      add_to(hash, i.p_BoN_B).add(fmt::format("{}", i.first_dof));
      for (const superelement::Direction d : i.directions) hash.add(fmt::format("{}", static_cast<int>(d)));
      add_to(hash, i.follow);
      for (const superelement::Direction d : i.following) hash.add(fmt::format("{}", static_cast<int>(d)));
      add_to(hash, i.free_motion);
      for (const superelement::Direction d : i.free) hash.add(fmt::format("{}", static_cast<int>(d)));
    }
    problem_key_ = hash.hex();
  }

  ModeSet eigenmodes() {
    input::ContentHash hash;
    add_to(hash.add(problem_key_), options_.held);
    eigenmodes_key_ = hash.hex();
    return modes_of(cache_.get("eigenmodes", eigenmodes_key_,
                               [&] { return matrices_of(problem().eigenmodes(options_.held)); }));
  }

  struct Basis {
    ModeSet modes;       ///< in superelement coordinates
    ModesWithin damped;  ///< whose ratios a damping law gives; C empty: the basis itself
  };

  /// Modes that eigenmodes() gave, in superelement coordinates.
  MatrixXd in_coordinates(const ModeSet& eigenmodes) { return problem().to_coordinates(eigenmodes.Y); }

  /// These of the eigenmodes, with response modes or without.
  Basis basis(const ModeSet& eigenmodes, const std::vector<int>& kept, bool responses) {
    input::ContentHash hash;
    hash.add(eigenmodes_key_).add(fmt::format("{} {}", fmt::join(kept, ","), options_.fixed_interface));
    add_to(hash, options_.frame);
    if (responses) hash.add(responses_key());
    basis_key_ = hash.hex();
    const auto entry = cache_.get("basis", basis_key_, [&] {
      Basis made = make_basis(eigenmodes, kept, responses);
      PreparationCache::Matrices out = matrices_of(std::move(made.modes));
      out.push_back(std::move(made.damped.C));
      out.push_back(std::move(made.damped.omega2));
      return out;
    });
    return {modes_of(entry), {(*entry)[2], (*entry)[3].col(0)}};
  }

  superelement::InertiaIntegrals inertia(const MatrixXd& Y) {
    const superelement::InertiaIntegrals& in = se_.inertia;
    input::ContentHash hash;
    add_to(add_to(hash.add(basis_key_), in.S_phi), in.S_xphi);
    for (const MatrixXd& S : in.S_phiphi) add_to(hash, S);
    const auto entry = cache_.get("integrals", hash.hex(), [&] {
      const superelement::InertiaIntegrals of_modes = transform(in, Y);
      PreparationCache::Matrices out = {of_modes.S_phi, of_modes.S_xphi};
      out.insert(out.end(), of_modes.S_phiphi.begin(), of_modes.S_phiphi.end());
      return out;
    });
    superelement::InertiaIntegrals out{in.mass, in.S_x, in.S_xx, (*entry)[0], (*entry)[1], {}};
    std::copy(entry->begin() + 2, entry->end(), out.S_phiphi.begin());
    return out;
  }

  SecondOrderIntegrals second(const MatrixXd& Y) {
    const superelement::StiffeningTerms& terms = *se_.stiffening;
    input::ContentHash hash;
    hash.add(basis_key_);
    for (const MatrixXd& K0 : terms.K0t) add_to(hash, K0);
    for (const MatrixXd& K0 : terms.K0r) add_to(hash, K0);
    for (const MatrixXd& K0 : terms.K0omega) add_to(hash, K0);
    const auto entry = cache_.get("stiffening", hash.hex(), [&] {
      SecondOrderIntegrals of_modes = second_order_integrals(terms, Y);
      return PreparationCache::Matrices{std::move(of_modes.t), std::move(of_modes.x)};
    });
    return {(*entry)[0], (*entry)[1]};
  }

  std::vector<MatrixXd> loads_stiffening(const MatrixXd& Y) {
    input::ContentHash hash;
    hash.add(basis_key_);
    for (const MatrixXd& K0F : se_.stiffening->K0F) add_to(hash, K0F);
    return *cache_.get("loads_stiffening", hash.hex(), [&] {
      PreparationCache::Matrices out;
      for (const MatrixXd& K0F : se_.stiffening->K0F) out.push_back(Y.transpose() * K0F * Y);
      return out;
    });
  }

 private:
  const ModalProblem& problem() {
    if (!problem_) problem_.emplace(se_, ties_);
    return *problem_;
  }
  static PreparationCache::Matrices matrices_of(ModeSet modes) { return {std::move(modes.Y), modes.omega2}; }
  static ModeSet modes_of(const std::shared_ptr<const PreparationCache::Matrices>& entry) {
    return {(*entry)[0], (*entry)[1].col(0)};
  }
  std::string responses_key() const {
    input::ContentHash hash;
    hash.add(problem_key_).add(fmt::format("{:.17g}", options_.response_frequency));
    return add_to(hash, options_.loads).hex();
  }

  Basis make_basis(const ModeSet& eigenmodes, const std::vector<int>& kept, bool responses) {
    const Index n_loads = responses ? options_.loads.cols() : 0;
    const bool free_eigenmodes_alone =
        options_.held.cols() == 0 && !responses && options_.fixed_interface < 0 && options_.frame.cols() == 0;
    Basis out;
    ModeSet& modes = out.modes;
    if (free_eigenmodes_alone) {
      modes = {eigenmodes.Y(Eigen::all, kept), eigenmodes.omega2(kept)};
      out.damped.omega2 = modes.omega2;
    } else {
      const auto n_kept = static_cast<Index>(kept.size());
      MatrixXd S(se_.n(), n_kept + n_loads);
      S.leftCols(n_kept) = eigenmodes.Y(Eigen::all, kept);
      if (responses)
        S.rightCols(n_loads) =
            cache_
                .get("responses", responses_key(),
                     [&] {
                       return PreparationCache::Matrices{problem().responses(
                           options_.loads, 2.0 * std::numbers::pi * options_.response_frequency)};
                     })
                ->front();
      // Mean axes first: what is dependent there is, whatever frame follows.
      problem().to_mean_axes(S);
      modes = problem().orthonormalised(std::move(S));
      const bool other_frame = options_.fixed_interface >= 0 || options_.frame.cols() > 0;
      if (options_.fixed_interface >= 0)
        problem().to_fixed_interface(options_.fixed_interface, modes.Y);
      else if (options_.frame.cols() > 0)
        problem().to_held_frame(options_.frame, modes.Y);
      if (other_frame) modes = problem().orthonormalised(std::move(modes.Y));
      if (other_frame || options_.held.cols() > 0)
        out.damped = problem().eigenmodes_within(modes, options_.held);
      else
        out.damped.omega2 = modes.omega2;
    }
    modes.Y = problem().to_coordinates(modes.Y);
    return out;
  }

  const superelement::Superelement& se_;
  const BasisOptions& options_;
  PreparationCache& cache_;
  MatrixXd ties_;
  std::optional<ModalProblem> problem_;  // where something is to be computed
  std::string problem_key_, eigenmodes_key_, basis_key_;
};

// D_e = Y^T D_se Y where the superelement has it and no law is given; else of the ratios of the modes X = Y C,
// C^-T diag(2 zeta omega) C^-1.
void set_damping(const superelement::Superelement& se, const DampingLaw& law, const ModesWithin& modes,
                 ModalData& data) {
  VectorXd own = 2.0 * se.modal_damping * modes.omega2.cwiseSqrt(), of_matrix = VectorXd::Zero(own.size());
  MatrixXd D;
  if (se.D_se.size() > 0 && !law.given()) {
    D = data.Y.transpose() * se.D_se * data.Y;
    of_matrix = (modes.C.size() > 0 ? MatrixXd(modes.C.transpose() * D * modes.C) : D).diagonal();
    own = of_matrix;
  }
  const VectorXd of_ratios = modal_damping(law, modes.omega2, own) - of_matrix;
  // d_k = 2 zeta_k omega_k.
  const bool asks = D.size() == 0;
  if (asks)
    data.asked_damping = (0.5 * of_ratios.array() * modes.omega2.array().sqrt()).matrix().asDiagonal();
  if (modes.C.size() == 0 && asks) {
    data.damping = of_ratios;
    return;
  }
  if (asks) D.setZero(own.size(), own.size());
  if (modes.C.size() == 0) {
    D.diagonal() += of_ratios;
  } else {
    const MatrixXd inverse = modes.C.partialPivLu().inverse();
    D += inverse.transpose() * of_ratios.asDiagonal() * inverse;
    if (asks) data.asked_damping = inverse.transpose() * data.asked_damping * inverse;
  }
  D = (0.5 * (D + D.transpose())).eval();
  data.damping = D.diagonal();
  D.diagonal().setZero();
  // Nothing beside the diagonal is round-off of sums, of a change of basis in parts of what two modes can share.
  constexpr double kOfLargest = 1e-14, kOfShare = 1e-10;
  const VectorXd size = data.damping.cwiseMax(0.0).cwiseSqrt();
  const bool couples = (D.array().abs() > kOfLargest * data.damping.cwiseAbs().maxCoeff() &&
                        D.array().abs() > kOfShare * (size * size.transpose()).array())
                           .any();
  if (couples) data.damping_coupling = std::move(D);
}

}  // namespace

ModalData modal_data(const superelement::Superelement& se, const BasisOptions& options, BasisReport* report,
                     PreparationCache* cache) {
  if (options.stiffening && !se.stiffening)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\" has no geometric stiffening terms; reduce the part again with "
                    "stiffening = true, or "
                    "use fidelity = \"modal\"",
                    se.name));
  PreparationCache own;
  Preparation steps(se, options, cache ? *cache : own);
  const ModeSet eigenmodes = steps.eigenmodes();
  const int available = static_cast<int>(eigenmodes.omega2.size());
  const std::vector<int> chosen =
      chosen_modes(se, options, eigenmodes.omega2, [&] { return steps.in_coordinates(eigenmodes); });
  const int kept = static_cast<int>(chosen.size());
  // Up to six directions leave all deformations, each up to a rigid motion.
  const bool responses = options.loads.cols() > 0 && (kept < available || options.held.cols() > 6);
  if (kept == 0 && !responses)
    throw BasisError(
        options.max_frequency < std::numeric_limits<double>::infinity() ? "max_frequency" : "modes",
        fmt::format(
            "superelement \"{}\": no mode is left (the first one of {} has {:.6g} Hz); keep one or use "
            "fidelity = \"rigid\"",
            se.name, available, available > 0 ? frequency_of(eigenmodes.omega2(0)) : 0.0));
  double first_dropped = 0.0;
  for (int i = available - 1; i >= 0; --i)
    if (!std::ranges::binary_search(chosen, i)) first_dropped = frequency_of(eigenmodes.omega2(i));
  std::vector<double> eigen_hz;
  for (const int i : chosen) eigen_hz.push_back(frequency_of(eigenmodes.omega2(i)));
  const auto [modes, damped] = steps.basis(eigenmodes, chosen, responses);
  const int m = static_cast<int>(modes.omega2.size());
  if (report)
    *report = {
        available,     kept,    m - kept, frequency_of(modes.omega2(0)), frequency_of(modes.omega2(m - 1)),
        first_dropped, eigen_hz};

  ModalData data;
  data.Y = modes.Y;
  data.stiffness = modes.omega2;
  data.inertia = steps.inertia(data.Y);
  data.frame = options.fixed_interface >= 0 ? interface_loads(se, options.fixed_interface) : options.frame;
  data.coupling = options.coupling;
  DampingLaw law = options.damping_law;
  if (options.damping) law.ratio = options.damping;
  set_damping(se, law, damped, data);
  std::vector<MatrixXd> K0F;
  if (options.stiffening) {
    data.second = steps.second(data.Y);
    K0F = steps.loads_stiffening(data.Y);
  }
  for (const BodyNode& node : interface_nodes(se)) data.nodes.push_back(node_of(node, data.Y, K0F));
  for (const BodyNode& node : options.nodes) data.nodes.push_back(node_of(node, data.Y, K0F));
  return data;
}

std::vector<BodyLoad> body_loads(const superelement::Superelement& se, const MatrixXd& Y) {
  const MatrixXd R = superelement::rigid_motions(se);
  std::vector<BodyLoad> out;
  const bool stiffens = Y.size() > 0 && se.stiffening && !se.stiffening->K0p.empty();
  for (const superelement::LoadCase& load : se.load_cases) {
    const Eigen::Matrix<double, 6, 1> p = R.transpose() * load.p_se;  // translations, then rotations
    BodyLoad body{.name = load.name, .wrench = {p.tail<3>(), p.head<3>()}, .modal = {}, .moment = {}};
    body.is_preload = load.is_preload;
    if (load.is_preload) body.wrench = {};  // but for round-off
    if (Y.size() > 0) {
      body.modal = Y.transpose() * load.p_se;
      if (load.moment.size() > 0) body.moment = load.moment * Y;
      if (stiffens) body.K0 = Y.transpose() * se.stiffening->K0p[out.size()] * Y;
    }
    out.push_back(std::move(body));
  }
  return out;
}

RigidInertia rigid_inertia(const superelement::Superelement& se) {
  const superelement::InertiaIntegrals& in = se.inertia;
  return {in.mass, in.S_x, in.S_xx.trace() * Matrix3d::Identity() - in.S_xx};
}

}  // namespace flexura::mbs
