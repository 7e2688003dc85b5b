// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/craig_bampton.hpp"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <stdexcept>

#include "reduce/assembly/shared_modes.hpp"
#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/errors/choose_modes.hpp"
#include "reduce/cms/projection.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/cms/shapes/basis.hpp"
#include "reduce/cms/shapes/constraint_modes.hpp"
#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/cms/shapes/interface_modes.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/cms/shapes/sturm.hpp"
#include "reduce/estimate/enriched_error.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/block_lanczos.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/factor_store.hpp"
#include "reduce/linalg/petsc/log_stage.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

void require_finite(const MatrixXd& X, const char* what) {
  if (!X.allFinite()) throw std::runtime_error(std::string(what) + " hold a number that is not finite");
}

// Interface modes of elastic ties; the averaging model and its factor are gone on return.
InterfaceModes faces_of(const Part& whole, const TiedSolver& stiff, const ConstraintModes& constraint,
                        const ReductionOptions& options, ReductionReport& report) {
  linalg::Stopwatch watch;
  const TiedModel model(whole);
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
  const double vector = sizeof(double) * std::max(1.0, static_cast<double>(model.n_i()));
  const int n_vectors =
      linalg::block_lanczos_vectors(options.n_modes, 16, 0.25 * linalg::available_memory() / vector) +
      2 * model.n_b() + options.n_modes + 100;
  storage.reserve += vector * n_vectors;
  return storage;
}

// What the modes left out add to free modes of the reduced body: lambda F_rs Mhat u_b, F_rs = K_ii^-1 - Phi Omega^-2 Phi^T (mode
// acceleration: N. E. Hansteen, K. Bell, Earthq. Eng. Struct. Dyn. 7 (1979) 325), exact to (lambda / omega_dropped^2)^2.  The
// estimate of the mesh's error would take what the reduction lacks for the mesh's.
void add_dropped(const TiedModel& model, const Basis& basis, const MatrixXd& Mhat, const MatrixXd& answer,
                 const JudgedMotions& motions, MatrixXd& U) {
  const Index k = motions.n_modes;
  if (k == 0) return;
  const MatrixXd u_b =
      motions.states.Y.topLeftCorner(Mhat.cols(), k) * motions.states.lambda.head(k).asDiagonal();
  MatrixXd interior = linalg::times(answer, u_b), more;
  if (basis.Phi.cols() > 0) {
    const MatrixXd kept =
        basis.omega2.cwiseInverse().asDiagonal() * (linalg::transpose_times(basis.Phi, Mhat) * u_b);
    interior -= linalg::times(basis.Phi, kept);
  }
  model.motions().expand(interior, MatrixXd::Zero(model.n_b(), k), more);
  U.leftCols(k) += more;
}

// Between which modes the normal modes end.
struct Cut {
  double omega2_last = 0.0, omega2_next = 0.0;
  int n_modes = 0;
  bool counted = false;    // by the eigensolver's own shifts
  std::vector<int> order;  // of the factorisation
};

// All but the certificate, a stage each.  The factor is gone with it: the certificate's takes its place in memory.
class ReductionStages {
 public:
  // `part`, of which `model` is, is `whole` with its elastic ties rigid.
  ReductionStages(const Part& whole, const Part& part, const TiedModel& model,
                  const ReductionOptions& options, Reduction& reduction)
      : whole_(whole),
        part_(part),
        model_(model),
        options_(options),
        reduction_(reduction),
        fixed_modes_(options.set == ModeSet::craig_bampton),
        solver_(model, options.progress, storage_for(model, options)) {
    watch_.lap();
    report_.factor = solver_.figures();
  }

  Cut run() {
    find_constraint_modes();
    answer_acceleration();
    const linalg::EigenProblem problem = fixed_interface_problem(model_, solver_, options_.storage);
    linalg::EigenPairs pairs = find_normal_modes(problem);
    Cut cut;
    if (fixed_modes_ && pairs.omega2.size() > 0)
      cut = {pairs.omega2(pairs.omega2.size() - 1), pairs.omega2_next, static_cast<int>(pairs.omega2.size()),
             pairs.counted, solver_.order()};
    const double omega2_left_out = pairs.omega2_next;
    make_basis(problem, std::move(pairs));
    project_basis();
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
    constraint_ = constraint_modes(model_, solver_);
    require_finite(constraint_.Psi, "the constraint modes");
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
    if (!fixed_modes_ || !(options_.estimate_error || by_goal() || !options_.response_omegas.empty())) return;
    const Index n_b = model_.n_b();
    MatrixXd U, M_U, boundary;
    model_.motions().expand(constraint_.Psi, MatrixXd::Identity(n_b, n_b), U);
    model_.m().multiply_kron3(U, M_U);
    model_.motions().gather(M_U, Mhat_, boundary);
    interior_.K_bb = constraint_.K_bb;
    interior_.M_bb = linalg::transpose_times(U, M_U);
    interior_.M_bb = (0.5 * (interior_.M_bb + interior_.M_bb.transpose())).eval();
    answer_ = solver_.solve(Mhat_);
    interior_.compliance = linalg::transpose_times(Mhat_, answer_);
    MatrixXd M_answer;
    model_.matrices().multiply_M_ii(answer_, M_answer);
    interior_.growth = linalg::transpose_times(answer_, M_answer);
    report_.seconds_estimate = watch_.lap();
  }

  linalg::EigenPairs find_normal_modes(const linalg::EigenProblem& problem) {
    stage_.next("Normal modes");
    linalg::EigenPairs pairs;
    pairs.Phi.resize(model_.n_i(), 0);
    const auto solve_for = [&](int count, double omega) {
      if (problem.n_free == 0) {  // all dofs are the interfaces': a beam between two of them
        pairs.omega2_next = std::numeric_limits<double>::infinity();
        return;
      }
      const linalg::EigenRequest request{count, omega * omega, options_.tolerance};
      const bool krylov = options_.eigensolver == Eigensolver::krylov_schur;
      pairs = options_.team ? find_shared_modes(solver_, request, krylov, options_.progress)
              : krylov      ? linalg::krylov_schur(problem, request, options_.progress)
                            : linalg::block_lanczos(problem, request, options_.progress);
      if (Mhat_.size() == 0) return;
      interior_.participation = linalg::transpose_times(pairs.Phi, Mhat_);
      interior_.omega2 = pairs.omega2;
      interior_.omega2_next = pairs.omega2_next;
    };
    if (fixed_modes_ && by_goal())
      choose_modes(model_, options_, interior_, solve_for, pairs, report_);
    else if (fixed_modes_ && (options_.n_modes > 0 || options_.omega_max > 0.0))
      solve_for(options_.n_modes, options_.omega_max);
    require_finite(pairs.Phi, "the normal modes");
    report_.mode_residual = pairs.residual;
    report_.mode_round_off = pairs.round_off;
    report_.solved_right_hand_sides = pairs.n_solves;
    report_.seconds_normal_modes = watch_.lap();
    return pairs;
  }

  void make_basis(const linalg::EigenProblem& problem, linalg::EigenPairs&& pairs) {
    if (options_.set == ModeSet::craig_chang) {
      basis_ = craig_chang_basis(part_, model_, solver_, constraint_, options_, report_);
      report_.seconds_normal_modes = watch_.lap();
    } else {
      basis_ = fixed_interface_basis(part_, model_, solver_, problem, constraint_, Mhat_, std::move(pairs),
                                     options_, report_);
    }
    stage_.next("Interface modes");
    if (&whole_ == &part_) return;
    faces_ = faces_of(whole_, solver_, constraint_, options_, report_);
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

  void estimate_dropped(double omega2_left_out) {
    // F_rs = K_ii^-1 - Phi Omega^-2 Phi^T, extra shapes included: they are K- and M-orthogonal like modes.
    const MatrixXd participation = linalg::transpose_times(basis_.Phi, Mhat_);  // n_q x n_b
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

  // The estimate knows solids only: with shells or beams the mesh's share is unknown.  What it adds to nearly incompressible
  // elements is held by the bulk modulus as they are themselves.
  void estimate_mesh() {
    if (!options_.estimate_mesh || !part_.mesh.shells.empty() || !part_.frames.empty() ||
        !part_.dependent.empty() || is_nearly_incompressible(part_))
      return;
    stage_.next("Error of the mesh");
    const double before = linalg::processor_seconds();
    motions_ = judged_motions(reduction_, options_.omega_max);
    if (motions_.states.Y.cols() == 0) return;  // one interface and no modes: rigid
    MeshEnergy left;
    const bool enriched = enrichment_suits(whole_);
    if (enriched) {
      MatrixXd U = linalg::times(T_, motions_.states.Y);
      if (answer_.size() > 0 && !has_faces()) add_dropped(model_, basis_, Mhat_, answer_, motions_, U);
      left = enriched_energy(part_, U, motions_.states.lambda, motions_.states.force, options_.progress);
    } else
      left = recovered_energy(part_, T_ * motions_.states.Y, options_.progress);
    if (left.known()) {
      reduction_.mesh = mesh_share(motions_, left);
      reduction_.mesh->rough = !enriched;
      leave_out_concentrated(whole_, motions_, *reduction_.mesh);
    }
    report_.seconds_mesh_error = watch_.lap();
    report_.processor_seconds_mesh_error = linalg::processor_seconds() - before;
  }

  // Loads, stiffening and stresses on the shapes.
  void recover() {
    stage_.next("Projection");
    project_loads(part_, model_, T_, options_, reduction_);
    if (options_.stiffening) {
      reduction_.stiffening =
          stiffening_terms(part_, solver_, constraint_.Psi, constraint_.K_bb, T_, options_.progress);
      report_.seconds_stiffening = watch_.lap();
    }
    if (options_.stress_nodes.empty()) return;
    reduction_.stress_modes = stress_modes(part_, model_, basis_, T_, options_);
    report_.seconds_stress = watch_.lap();
    if (!reduction_.mesh) return;
    const double before = linalg::processor_seconds();
    add_peaks(motions_,
              peak_stresses(whole_, T_, reduction_.stress_modes, options_.stress_nodes, motions_.states.Y),
              *reduction_.mesh);
    report_.seconds_mesh_error += watch_.lap();
    report_.processor_seconds_mesh_error += linalg::processor_seconds() - before;
  }

  void finish() {
    if (has_faces())
      change_shapes(reduction_, canonical_shapes(reduction_.K_se, reduction_.M_se,
                                                 MatrixXd::Identity(model_.n_b(), T_.cols())));
    report_.n_nodes = model_.n_nodes();
    for (const auto* blocks : {&part_.mesh.solids, &part_.mesh.shells})
      for (const mesh::CellBlock& block : *blocks) report_.n_cells += static_cast<int>(block.nodes.rows());
    report_.n_i = model_.n_i();
    report_.n_b = reduction_.n_b;
    report_.n_q = reduction_.n_q;
  }

  const Part &whole_, &part_;
  const TiedModel& model_;
  const ReductionOptions& options_;
  Reduction& reduction_;
  ReductionReport& report_ = reduction_.report;
  const bool fixed_modes_;
  linalg::Stopwatch watch_;
  linalg::LogStage stage_{"Factorisation"};
  const TiedSolver solver_;
  ConstraintModes constraint_;
  InteriorDynamics interior_;
  MatrixXd Mhat_, answer_;  // M_ib + M_ii Psi, and the answer to it by stiffness alone
  Basis basis_;
  InterfaceModes faces_;
  MatrixXd T_;
  JudgedMotions motions_;
};

}  // namespace

Reduction craig_bampton(const Part& whole, const ReductionOptions& options) {
  Reduction reduction;
  std::optional<Part> stiff;
  if (has_elastic_ties(whole)) {
    if (options.set == ModeSet::craig_chang || options.accuracy > 0.0)
      throw std::invalid_argument(
          "elastic ties go with Craig and Bampton's or Guyan's modes, by number, frequency or effective "
          "mass");
    if (!whole.mesh.shells.empty() || !whole.frames.empty() || !whole.dependent.empty())
      throw std::invalid_argument(
          "elastic ties are for solids: with shells, beams or constraints tie the interfaces rigid or as "
          "averages");
    stiff = with_rigid_faces(whole);
  }
  const Part& part = stiff ? *stiff : whole;
  linalg::Stopwatch watch;
  AssemblyOptions assembly;
  assembly.progress = options.progress;
  assembly.team = options.team;
  const TiedModel model = [&] {
    const linalg::LogStage stage("Assembly");
    return TiedModel(part, assembly);
  }();
  reduction.report.seconds_assembly = watch.lap();
  if (options.team)
    reduction.report.notes.push_back(fmt::format(
        "{} processes share the elements, the factorisations and the solves", options.team->size()));
  const Cut cut = ReductionStages(whole, part, model, options, reduction).run();
  if (options.certify && cut.n_modes > 0) {
    linalg::report(options.progress, "certificate", 0.0);
    const linalg::LogStage stage("Certificate");
    watch.lap();
    if (cut.counted)
      note_count(cut.omega2_last, cut.omega2_next, cut.n_modes, reduction.report);
    else
      certify(model, cut.order, cut.omega2_last, cut.omega2_next, cut.n_modes, reduction.report,
              options.storage);
    // Courant: no Ritz value stands below the eigenvalue of its number; elastic ties are another model.
    if (!stiff) require_not_below(reduction.omega2, reduction.report);
    reduction.report.seconds_certificate = watch.lap();
  }
  reduction.report.peak_memory_bytes = linalg::peak_memory();
  if (options.team) reduction.report.peak_memory_of_others_bytes = peak_memory_of_others(*options.team);
  return reduction;
}

}  // namespace flexura::reduce
