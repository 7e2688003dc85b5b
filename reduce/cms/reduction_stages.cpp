// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/reduction_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/errors/choose_modes.hpp"
#include "reduce/cms/errors/judged_states.hpp"
#include "reduce/cms/projection.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/cms/shapes/basis.hpp"
#include "reduce/cms/shapes/constraint_modes.hpp"
#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/cms/shapes/interface_modes.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/estimate/enriched_error.hpp"
#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/block_lanczos.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/factor_store.hpp"
#include "reduce/linalg/petsc/log_stage.hpp"
#include "reduce/linalg/session/freed_memory.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// On all ranks alike.
void require_finite(const TiedModel& model, const MatrixXd& X, const char* what) {
  if (model.sum(MatrixXd::Constant(1, 1, X.allFinite() ? 0.0 : 1.0))(0, 0) > 0.0)
    throw std::runtime_error(std::string(what) + " hold a number that is not finite");
}

// Interface modes of elastic ties; the averaging model and its factor are gone on return.  `whole` is read on rank 0 alone.
InterfaceModes faces_of(const Part& whole, const TiedSolver& stiff, const ConstraintModes& constraint,
                        const ReductionOptions& options, ReductionReport& report) {
  linalg::Stopwatch watch;
  std::optional<PartShare> share;
  if (stiff.model().share()) share = share_retied(*stiff.model().share(), whole);
  const TiedModel model = share ? TiedModel(*share) : TiedModel(whole);
  if (share) share->part = {};  // its elements are in the matrices
  const TiedSolver soft(model, options.progress);
  InterfaceModes modes = interface_modes(soft, stiff, constraint.Psi, constraint.K_bb,
                                         options.interface_modes, options.progress);
  const Index count = modes.omega2.size();
  std::string note = fmt::format("interface reduction: {} dofs of the elastic ties become {} interface modes",
                                 modes.n_face, count);
  if (count > 0) note += fmt::format(" up to {:.5g} Hz", frequency_hz(modes.omega2(count - 1)));
  if (modes.stiffness_error >= 0.0)
    note += fmt::format("; the static stiffness between the interfaces is within {:.2g} %",
                        100.0 * modes.stiffness_error);
  report.notes.push_back(note);
  report.n_interface_modes = static_cast<int>(count);
  report.interface_stiffness_error = modes.stiffness_error;
  report.seconds_interface_modes = watch.lap();
  return modes;
}

// Beside the factor stand the eigensolver's basis and blocks and the retained shapes.
linalg::FactorStorage storage_for(const TiedModel& model, const ReductionOptions& options) {
  linalg::FactorStorage storage = options.storage;
  const double vector = sizeof(double) * std::max(1.0, static_cast<double>(model.n_rows()));
  const int n_vectors =
      linalg::block_lanczos_vectors(options.n_modes, linalg::block_lanczos_width(options.n_modes),
                                    0.25 * linalg::available_memory() / vector) +
      2 * model.n_b() + options.n_modes + 100;
  storage.reserve += vector * n_vectors;
  return storage;
}

class ReductionStages {
 public:
  ReductionStages(const Part& whole, const Part& part, bool has_elastic, const TiedModel& model,
                  const ReductionOptions& options, Reduction& reduction)
      : whole_(whole),
        part_(part),
        here_(model.share() ? model.share()->part : part),
        model_(model),
        options_(options),
        reduction_(reduction),
        has_elastic_(has_elastic),
        fixed_modes_(options.set == ModeSet::craig_bampton),
        wants_stress_(model.decide(!options.stress_nodes.empty())),
        solver_(std::in_place, model, options.progress, storage_for(model, options)) {
    watch_.lap();
    report_.factor = solver_->figures();
    take_cores();
  }

  Cut run() {
    kept_.emplace();
    find_constraint_modes();
    answer_acceleration();
    const linalg::EigenProblem problem = fixed_interface_problem(model_, *solver_, options_.storage);
    linalg::EigenPairs pairs = find_normal_modes(problem);
    Cut cut;
    if (fixed_modes_ && pairs.omega2.size() > 0)
      cut = {pairs.omega2(pairs.omega2.size() - 1), pairs.omega2_next, static_cast<int>(pairs.omega2.size()),
             pairs.counted, solver_->order()};
    const double omega2_left_out = pairs.omega2_next;
    make_basis(problem, std::move(pairs));
    project_basis();
    find_left_out();
    stiffen();
    solver_.reset();  // what follows takes memory of its own
    kept_.reset();
    if (options_.estimate_error && fixed_modes_ && !has_faces()) estimate_dropped(omega2_left_out);
    estimate_mesh();
    recover();
    finish();
    return cut;
  }

 private:
  void find_constraint_modes() {
    stage_.next("Constraint modes");
    linalg::report(options_.progress, "constraint modes", 0.0);
    constraint_ = constraint_modes(model_, *solver_);
    part_by_pieces(part_, model_, constraint_.K_bb);
    require_finite(model_, constraint_.Psi, "the constraint modes");
    report_.constraint_residual = constraint_.residual;
    report_.rigid_strain = constraint_.rigid_strain;
    report_.rigid_error = constraint_.rigid_error;
    report_.seconds_constraint_modes = watch_.lap();
    linalg::report(options_.progress, "constraint modes", 1.0);
  }

  bool by_goal() const { return options_.accuracy > 0.0 || options_.effective_mass > 0.0; }
  bool has_faces() const { return faces_.omega2.size() > 0; }

  // The interior's answer to acceleration of the interface, wanted by estimates and response modes.
  void answer_acceleration() {
    if (!fixed_modes_ ||
        !(options_.estimate_error || by_goal() || !options_.response_omegas.empty() || knows_left_out()))
      return;
    const Index n_b = model_.n_b();
    MatrixXd U, M_U, boundary;
    model_.expand(constraint_.Psi, MatrixXd::Identity(n_b, n_b), U);
    model_.m().multiply_kron3(U, M_U);
    model_.gather(M_U, Mhat_, boundary);
    interior_.K_bb = constraint_.K_bb;
    interior_.M_bb = model_.inner(U, M_U);
    interior_.M_bb = (0.5 * (interior_.M_bb + interior_.M_bb.transpose())).eval();
    answer_ = solver_->solve(Mhat_);
    interior_.compliance = model_.inner(Mhat_, answer_);
    MatrixXd M_answer;
    model_.multiply_M(answer_, M_answer);
    interior_.growth = model_.inner(answer_, M_answer);
    report_.seconds_estimate = watch_.lap();
  }

  linalg::EigenPairs find_normal_modes(const linalg::EigenProblem& problem) {
    stage_.next("Normal modes");
    linalg::EigenPairs pairs;
    pairs.Phi.resize(model_.n_rows(), 0);
    const auto solve_for = [&](int count, double omega) {
      if (problem.n_free == 0) {  // all dofs are the interfaces': a beam between two of them
        pairs.omega2_next = std::numeric_limits<double>::infinity();
        return;
      }
      const linalg::EigenRequest request{count, omega * omega, options_.tolerance};
      const bool krylov = options_.eigensolver == Eigensolver::krylov_schur;
      pairs = krylov ? linalg::krylov_schur(problem, request, options_.progress)
                     : linalg::block_lanczos(problem, request, options_.progress);
      if (Mhat_.cols() == 0) return;
      interior_.participation = model_.inner(pairs.Phi, Mhat_);
      interior_.omega2 = pairs.omega2;
      interior_.omega2_next = pairs.omega2_next;
    };
    if (fixed_modes_ && by_goal())
      choose_modes(
          options_, interior_, [&] { return interior_mass(model_); }, solve_for, pairs, report_);
    else if (fixed_modes_ && (options_.n_modes > 0 || options_.omega_max > 0.0))
      solve_for(options_.n_modes, options_.omega_max);
    require_finite(model_, pairs.Phi, "the normal modes");
    report_.mode_residual = pairs.residual;
    report_.mode_round_off = pairs.round_off;
    report_.solved_right_hand_sides = pairs.n_solves;
    report_.seconds_normal_modes = watch_.lap();
    return pairs;
  }

  void make_basis(const linalg::EigenProblem& problem, linalg::EigenPairs&& pairs) {
    if (options_.set == ModeSet::craig_chang) {
      const HeldAnswers held = held_answers(model_, *solver_, options_.progress);
      if (!options_.stiffening) solver_.reset();  // the free body's factor takes its place in memory
      basis_ = craig_chang_basis(part_, model_, held, constraint_, options_, report_);
      report_.seconds_normal_modes = watch_.lap();
    } else {
      basis_ = fixed_interface_basis(part_, model_, *solver_, problem, constraint_, Mhat_, std::move(pairs),
                                     options_, report_);
    }
    stage_.next("Interface modes");
    if (!has_elastic_) return;
    faces_ = faces_of(whole_, *solver_, constraint_, options_, report_);
    watch_.lap();
  }

  void project_basis() {
    stage_.next("Projection");
    linalg::report(options_.progress, "projection", 0.0);
    T_ = shapes_on_nodes(model_, basis_, faces_);
    project(whole_, part_, model_, basis_, faces_, T_, options_, reduction_);
    report_.seconds_projection = watch_.lap();
    linalg::report(options_.progress, "projection", 1.0);
  }

  // What the modes left out give way, for stresses and section forces.  Elastic ties, modes of the free body and a team's shares
  // leave it unknown.
  bool knows_left_out() const {
    return (wants_stress_ || !part_.bars.empty()) && fixed_modes_ && !has_elastic_ && !model_.share();
  }

  // What the body's own acceleration and the load cases deform beyond the shapes: F_rs p, p = -M a.  The fields are those
  // of StressModes::of_acceleration; preloads have their answers among the shapes.
  void find_left_out() {
    if (!knows_left_out() || model_.n_i() == 0) return;
    const auto& points = model_.numbering().points();
    const Index n_nodes = model_.n_nodes(), n_b = model_.n_b();
    constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
    MatrixXd field = MatrixXd::Zero(3 * n_nodes, 6), F, f_i, f_b;
    for (Index node = 0; node < n_nodes; ++node)
      for (int k = 0; k < 6; ++k) {
        const auto [a, b] = pairs[k];
        field(3 * node + a, k) += points(node, b);
        if (a != b) field(3 * node + b, k) += points(node, a);
      }
    model_.m().multiply_kron3(field, F);
    const auto n_loads = static_cast<Index>(options_.loads.size());
    F.conservativeResize(Eigen::NoChange, 6 + n_loads);
    F.leftCols(6) *= -1.0;
    for (Index k = 0; k < n_loads; ++k)
      F.col(6 + k) = nodal_forces(model_.m(), n_nodes, options_.loads[static_cast<std::size_t>(k)]);
    model_.gather(F, f_i, f_b);
    const MatrixXd answer = solver_->solve(f_i);
    left_out_.resize(f_i.rows(), 6 + n_b + n_loads);
    left_out_ << answer.leftCols(6), -answer_, answer.rightCols(n_loads);
    if (basis_.Phi.cols() == 0) return;
    MatrixXd participation(basis_.Phi.cols(), left_out_.cols());
    participation << linalg::transpose_times(basis_.Phi, f_i.leftCols(6)),
        -linalg::transpose_times(basis_.Phi, Mhat_),
        linalg::transpose_times(basis_.Phi, f_i.rightCols(n_loads));
    left_out_ -= basis_.Phi * (basis_.omega2.cwiseInverse().asDiagonal() * participation);
  }

  void put_left_out_stress() {
    if (left_out_.cols() == 0) return;
    const Index n_loads = static_cast<Index>(options_.loads.size()), n_fields = left_out_.cols() - n_loads;
    const MatrixXd stress = stress_of_interior(part_, model_, left_out_, options_);
    left_out_.resize(0, 0);
    reduction_.stress_of_acceleration = stress.leftCols(n_fields);
    if (n_loads == 0) return;
    if (reduction_.stress_of_loads.size() == 0) reduction_.stress_of_loads.setZero(stress.rows(), n_loads);
    reduction_.stress_of_loads += stress.rightCols(n_loads);
  }

  void estimate_dropped(double omega2_left_out) {
    // F_rs = K_ii^-1 - Phi Omega^-2 Phi^T, extra shapes included: they are K- and M-orthogonal like modes.
    const MatrixXd participation = model_.inner(basis_.Phi, Mhat_);  // n_q x n_b
    DroppedModes dropped = dropped_modes(interior_, participation, basis_.omega2);
    reduction_.dropped = std::move(dropped.share);
    reduction_.dropped_growth = std::move(dropped.growth);
    reduction_.omega2_dropped = omega2_left_out;
    if (options_.accuracy > 0.0) {
      const BandError error = band_error(reduction_, options_.omega_max);
      report_.band_frequency_error = error.frequency;
      report_.band_interface_error = error.interface;
    }
    report_.seconds_estimate += watch_.lap();
  }

  void stiffen() {
    if (!options_.stiffening) return;
    std::vector<StressingLoad> loads;
    for (const LoadField& load : options_.loads)
      loads.push_back({nodal_forces(model_.m(), model_.n_nodes(), load), load.strain});
    reduction_.stiffening =
        stiffening_terms(here_, *solver_, constraint_.Psi, constraint_.K_bb, T_, loads, options_.progress);
    report_.seconds_stiffening = watch_.lap();
  }

  // The estimate knows solids only: with shells or beams the mesh's share is unknown.  What it adds to nearly incompressible
  // elements is held by the bulk modulus as they are themselves.
  void estimate_mesh() {
    if (!options_.estimate_mesh || !part_.mesh.shells.empty() || !part_.frames.empty() ||
        !part_.dependent.empty() || is_nearly_incompressible(part_))
      return;
    stage_.next("Error of the mesh");
    const double before = linalg::processor_seconds();
    if (model_.leads()) motions_ = judged_motions(reduction_, options_.omega_max);
    share_motions(model_, motions_);
    if (motions_.states.Y.cols() == 0) return;  // one interface and no modes: rigid
    // From here on the states on all nodes of the whole part, on rank 0 of a team.
    MatrixXd U = linalg::times(T_, motions_.states.Y);
    const bool enriched = model_.decide(enrichment_suits(whole_));
    if (wants_stress_ || !enriched) states_ = on_all_nodes(model_, U);
    if (enriched) {
      if (answer_.cols() > 0 && !has_faces()) add_dropped(model_, basis_, Mhat_, answer_, motions_, U);
      U = on_all_nodes(model_, std::move(U));
    }
    if (!model_.leads()) return;
    cores_.reset();  // the other ranks sleep
    const MeshEnergy left =
        enriched ? enriched_energy(part_, U, motions_.states.lambda, motions_.states.force, options_.progress)
                 : recovered_energy(part_, states_, options_.progress);
    if (left.known()) {
      reduction_.mesh = mesh_share(motions_, left);
      reduction_.mesh->rough = !enriched;
      leave_out_concentrated(whole_, motions_, *reduction_.mesh);
    }
    report_.seconds_mesh_error = watch_.lap();
    report_.processor_seconds_mesh_error = linalg::processor_seconds() - before;
    take_cores();
  }

  void take_cores() {
    if (const PartShare* share = model_.share()) cores_.emplace(share->team->cores_each());
  }

  // Loads and stresses on the shapes.
  void recover() {
    if (const PartShare* share = model_.share()) share->team->meet();
    stage_.next("Projection");
    project_loads(model_, T_, options_, reduction_);
    project_damping(here_, model_, basis_, T_, reduction_);
    if (model_.decide(options_.all_nodes)) {
      NodeMotions nodes = all_node_motions(whole_, model_, basis_, T_);
      if (model_.leads()) reduction_.nodes = std::move(nodes);
    }
    if (!part_.bars.empty() && !model_.share())
      reduction_.bars = bar_motions(part_, model_, basis_, T_, left_out_);
    if (!wants_stress_) return;
    reduction_.stress_modes = stress_modes(whole_, part_, model_, basis_, T_, options_);
    if (!model_.share()) reduction_.stress_of_loads = stress_of_preloads(part_, options_);
    put_left_out_stress();
    report_.seconds_stress = watch_.lap();
    if (!reduction_.mesh) return;
    const double before = linalg::processor_seconds();
    add_peaks(
        motions_,
        peak_stresses(whole_, states_, reduction_.stress_modes, options_.stress_nodes, motions_.states.Y),
        *reduction_.mesh);
    report_.seconds_mesh_error += watch_.lap();
    report_.processor_seconds_mesh_error += linalg::processor_seconds() - before;
  }

  void finish() {
    if (has_faces())
      change_shapes(reduction_, canonical_shapes(reduction_.K_se, reduction_.M_se,
                                                 MatrixXd::Identity(model_.n_b(), T_.cols())));
    report_.n_nodes = part_.mesh.n_nodes();
    for (const auto* blocks : {&part_.mesh.solids, &part_.mesh.shells})
      for (const mesh::CellBlock& block : *blocks) report_.n_cells += static_cast<int>(block.nodes.rows());
    report_.n_i = model_.n_i();
    report_.n_b = reduction_.n_b;
    report_.n_q = reduction_.n_q;
  }

  const Part &whole_, &part_, &here_;  // here: what this process has of it
  const TiedModel& model_;
  const ReductionOptions& options_;
  Reduction& reduction_;
  ReductionReport& report_ = reduction_.report;
  const bool has_elastic_, fixed_modes_, wants_stress_;
  linalg::Stopwatch watch_;
  linalg::LogStage stage_{"Factorisation"};
  std::optional<TiedSolver> solver_;
  std::optional<linalg::SomeCores> cores_;  // of a team's rank
  std::optional<linalg::KeepFreedMemory> kept_;
  ConstraintModes constraint_;
  InteriorDynamics interior_;
  MatrixXd Mhat_, answer_;  // M_ib + M_ii Psi, and the answer to it by stiffness alone
  MatrixXd left_out_;  // n_i x (6 + n_b + loads): what the shapes lack of the answers to inertia and loads
  Basis basis_;
  InterfaceModes faces_;
  MatrixXd T_, states_;  // of the nodes here, and T Y of the judged motions on all nodes
  JudgedMotions motions_;
};

}  // namespace

Cut run_stages(const Part& whole, const Part& part, bool has_elastic, const TiedModel& model,
               const ReductionOptions& options, Reduction& reduction) {
  return ReductionStages(whole, part, has_elastic, model, options, reduction).run();
}

}  // namespace flexura::reduce
