// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/craig_bampton.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "reduce/cms/choose_modes.hpp"
#include "reduce/cms/constraint_modes.hpp"
#include "reduce/cms/craig_chang.hpp"
#include "reduce/cms/mesh_share.hpp"
#include "reduce/cms/response_modes.hpp"
#include "reduce/cms/ritz_check.hpp"
#include "reduce/cms/shape_change.hpp"
#include "reduce/cms/sturm.hpp"
#include "reduce/estimate/enriched_error.hpp"
#include "reduce/linalg/block_lanczos.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/eigensolver.hpp"
#include "reduce/linalg/log_stage.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Shapes with one for each interface dof (U_b in the interior, 1 on the boundary) and others with none.
struct Basis {
  MatrixXd U_b, Phi;
  Eigen::VectorXd omega2;
  MatrixXd K_bb;
};

// Free-free modes and attachment modes (craig_chang.hpp) as a basis.
Basis craig_chang_basis(const Part& part, const TiedModel& model, const TiedSolver& solver,
                        const MatrixXd& Psi, const MatrixXd& K_bb, const ReductionOptions& options,
                        ReductionReport& report) {
  const CraigChangSpan span = craig_chang_span(part, model, solver, Psi, K_bb, options);
  const CanonicalShapes shapes = canonical_shapes(span.K, span.M, span.C_b);
  if (!shapes.dropped.empty()) {
    int n_rigid = 0;
    std::string others;
    for (const int j : shapes.dropped) {
      if (j >= span.first_attachment)
        ++n_rigid;
      else
        others += fmt::format("{}free mode {}", others.empty() ? "" : ", ", j + 1);
    }
    report.notes.push_back(
        fmt::format("{} of {} attachment modes depend on the other shapes and are dropped{}{}", n_rigid,
                    K_bb.rows(), others.empty() ? "" : ", so are ", others));
  }
  const Index n_b = K_bb.rows(), n_q = shapes.omega2.size();
  Basis basis;
  basis.U_b = Psi + linalg::times(span.W, shapes.Y.leftCols(n_b));
  basis.Phi = linalg::times(span.W, shapes.Y.rightCols(n_q));
  basis.omega2 = shapes.omega2;
  basis.K_bb = shapes.Y.leftCols(n_b).transpose() * span.K * shapes.Y.leftCols(n_b);
  basis.K_bb = (0.5 * (basis.K_bb + basis.K_bb.transpose())).eval();
  report.mode_residual = span.residual;
  return basis;
}

// Response and load shapes join the normal modes.
void add_shapes(const Part& part, const TiedModel& model, const TiedSolver& solver,
                const linalg::EigenProblem& problem, const MatrixXd& Mhat, const ReductionOptions& options,
                linalg::EigenPairs& pairs, std::vector<StaticAnswer>& answers, ReductionReport& report) {
  const Index n_normal = pairs.omega2.size();
  ExtraShapes all;
  const auto add = [&all, n = model.n_i()](const ExtraShapes& some) {
    const Index before = all.X.cols();
    all.X.conservativeResize(n, before + some.X.cols());
    all.X.rightCols(some.X.cols()) = some.X;
    all.names.insert(all.names.end(), some.names.begin(), some.names.end());
  };
  if (!options.response_omegas.empty()) {
    constexpr const char* kDirections[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
    std::vector<std::string> names;
    for (int k = 0; k < model.n_interfaces(); ++k)
      for (const int d : model.directions(k)) names.push_back(part.interfaces[k].name + "." + kDirections[d]);
    for (const double omega : options.response_omegas)
      add(response_shapes(problem, pairs, Mhat, omega, names));
  }
  for (const LoadField& load : options.loads) {
    if (!load.keep_shape) continue;
    MatrixXd f_i, f_b;
    model.gather(nodal_forces(model.m(), model.n_nodes(), load), f_i, f_b);
    const MatrixXd u_i = solver.solve(f_i);
    add({u_i, {"static answer to load " + load.name}});
    answers.push_back({load.name, f_i, f_i.col(0).dot(u_i.col(0))});
  }
  if (all.names.empty()) return;
  for (const std::string& name : append_shapes(problem, pairs, all))
    report.notes.push_back(name + " is dropped: it depends on the other shapes");
  report.n_extra = static_cast<int>(pairs.omega2.size() - n_normal);
  report.notes.push_back(
      fmt::format("{} response and load shapes beside {} normal modes", report.n_extra, n_normal));
}

// T^T D T of the dampers; empty where there are none.
MatrixXd damper_matrix(const Part& part, const TiedModel& model, const MatrixXd& T) {
  MatrixXd D;
  for (const Link& link : part.links) {
    if (link.damping == 0.0) continue;
    if (D.size() == 0) D.setZero(T.cols(), T.cols());
    const MatrixXd rate =
        T.middleRows<3>(3 * static_cast<Index>(link.to)) - T.middleRows<3>(3 * static_cast<Index>(link.from));
    D += link.damping * rate.transpose() * model.direction_projector(link) * rate;
  }
  return 0.5 * (D + D.transpose());
}

void require_finite(const MatrixXd& X, const char* what) {
  if (!X.allFinite()) throw std::runtime_error(std::string(what) + " hold a number that is not finite");
}

// Between which modes the normal modes end.
struct Cut {
  double omega2_last = 0.0, omega2_next = 0.0;
  int n_modes = 0;
  std::vector<int> order;  // of the factorisation
};

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
  const int n_vectors = linalg::block_lanczos_vectors(options.n_modes) + 2 * model.n_b() + 100;
  storage.reserve += sizeof(double) * static_cast<double>(model.n_i()) * n_vectors;
  return storage;
}

// What the modes left out add to free modes of the reduced body: lambda F_rs Mhat u_b, F_rs = K_ii^-1 - Phi Omega^-2 Phi^T (mode
// acceleration: N. E. Hansteen, K. Bell, Earthq. Eng. Struct. Dyn. 7 (1979) 325), exact to (lambda / omega_dropped^2)^2.  The
// estimate of the mesh's error would take what the reduction lacks for the mesh's.
void add_dropped(const TiedModel& model, const Basis& basis, const MatrixXd& Mhat, const MatrixXd& answer,
                 const JudgedMotions& motions, MatrixXd& U) {
  const Index k = motions.n_modes;
  if (k == 0) return;
  const MatrixXd u_b = motions.states.Y.topLeftCorner(Mhat.cols(), k) * motions.states.lambda.head(k).asDiagonal();
  MatrixXd interior = linalg::times(answer, u_b), more;
  if (basis.Phi.cols() > 0) {
    const MatrixXd kept = basis.omega2.cwiseInverse().asDiagonal() * (linalg::transpose_times(basis.Phi, Mhat) * u_b);
    interior -= linalg::times(basis.Phi, kept);
  }
  model.expand(interior, MatrixXd::Zero(model.n_b(), k), more);
  U.leftCols(k) += more;
}

// All but the certificate.  The factor is gone on return: the certificate's takes its place in memory.
// `part`, of which `model` is, is `whole` with its elastic ties rigid.
Cut reduce(const Part& whole, const Part& part, const TiedModel& model, const ReductionOptions& options,
           Reduction& reduction) {
  ReductionReport& report = reduction.report;
  linalg::Stopwatch watch;
  linalg::LogStage stage("Factorisation");
  const TiedSolver solver(model, options.progress, storage_for(model, options));
  watch.lap();
  report.factor = solver.figures();

  stage.next("Constraint modes");
  linalg::report(options.progress, "constraint modes", 0.0);
  const ConstraintModes constraint = constraint_modes(model, solver);
  require_finite(constraint.Psi, "the constraint modes");
  report.constraint_residual = constraint.residual;
  report.seconds_constraint_modes = watch.lap();
  linalg::report(options.progress, "constraint modes", 1.0);

  const Index n_b = model.n_b();
  const bool by_goal = options.accuracy > 0.0 || options.effective_mass > 0.0;
  const bool fixed_modes = options.set == ModeSet::craig_bampton;
  // The interior's answer to acceleration of the interface, wanted by estimates and response modes.
  InteriorDynamics interior;
  MatrixXd Mhat, answer;  // to acceleration of the interface, by stiffness alone
  if (fixed_modes && (options.estimate_error || by_goal || !options.response_omegas.empty())) {
    MatrixXd U, M_U, boundary;
    model.expand(constraint.Psi, MatrixXd::Identity(n_b, n_b), U);
    model.m().multiply_kron3(U, M_U);
    model.gather(M_U, Mhat, boundary);
    interior.K_bb = constraint.K_bb;
    interior.M_bb = linalg::transpose_times(U, M_U);
    interior.M_bb = (0.5 * (interior.M_bb + interior.M_bb.transpose())).eval();
    answer = solver.solve(Mhat);
    interior.compliance = linalg::transpose_times(Mhat, answer);
    MatrixXd M_answer;
    model.multiply_M_ii(answer, M_answer);
    interior.growth = linalg::transpose_times(answer, M_answer);
    report.seconds_estimate = watch.lap();
  }

  stage.next("Normal modes");
  const linalg::EigenProblem problem = fixed_interface_problem(model, solver);
  linalg::EigenPairs pairs;
  pairs.Phi.resize(model.n_i(), 0);
  const auto solve_for = [&](int count, double omega) {
    if (problem.n_free == 0) {  // all dofs are the interfaces': a beam between two of them
      pairs.omega2_next = std::numeric_limits<double>::infinity();
      return;
    }
    const linalg::EigenRequest request{count, omega * omega, options.tolerance};
    pairs = options.eigensolver == Eigensolver::krylov_schur
                ? linalg::krylov_schur(problem, request, options.progress)
                : linalg::block_lanczos(problem, request, options.progress);
    if (Mhat.size() > 0) {
      interior.participation = linalg::transpose_times(pairs.Phi, Mhat);
      interior.omega2 = pairs.omega2;
      interior.omega2_next = pairs.omega2_next;
    }
  };
  if (fixed_modes && by_goal) {
    choose_modes(model, options, interior, solve_for, pairs, report);
  } else if (fixed_modes && (options.n_modes > 0 || options.omega_max > 0.0)) {
    solve_for(options.n_modes, options.omega_max);
  }
  require_finite(pairs.Phi, "the normal modes");
  report.mode_residual = pairs.residual;
  report.solved_right_hand_sides = pairs.n_solves;
  report.seconds_normal_modes = watch.lap();

  Basis basis{constraint.Psi, {}, {}, constraint.K_bb};
  const double omega2_left_out = pairs.omega2_next;
  Cut cut;
  if (fixed_modes && pairs.omega2.size() > 0)
    cut = {pairs.omega2(pairs.omega2.size() - 1), pairs.omega2_next, static_cast<int>(pairs.omega2.size()),
           solver.order()};
  if (options.set == ModeSet::craig_chang) {
    basis = craig_chang_basis(part, model, solver, constraint.Psi, constraint.K_bb, options, report);
    report.seconds_normal_modes = watch.lap();
  } else {
    std::vector<StaticAnswer> answers;
    add_shapes(part, model, solver, problem, Mhat, options, pairs, answers, report);
    basis.Phi = std::move(pairs.Phi);
    basis.omega2 = std::move(pairs.omega2);
    require_ritz(problem, basis.Phi, basis.omega2, answers);
  }

  InterfaceModes faces;
  stage.next("Interface modes");
  if (&whole != &part) {
    faces = faces_of(whole, solver, constraint, options, report);
    watch.lap();
  }

  // T on all nodes, n_nodes * 3 * n: the one dense array of that size.
  stage.next("Projection");
  linalg::report(options.progress, "projection", 0.0);
  const Index n_w = faces.omega2.size(), n_phi = basis.Phi.cols(), n_q = n_phi + n_w, n = n_b + n_q;
  MatrixXd T(3 * static_cast<Index>(model.n_nodes()), n);
  {
    MatrixXd U;
    model.expand(basis.U_b, MatrixXd::Identity(n_b, n_b), U);
    T.leftCols(n_b) = U;
    for (Index q = 0; q < n_phi; q += 16) {
      const Index width = std::min<Index>(16, n_phi - q);
      model.expand(basis.Phi.middleCols(q, width), MatrixXd::Zero(n_b, width), U);
      T.middleCols(n_b + q, width) = U;
    }
    if (n_w > 0) T.rightCols(n_w) = faces.U;
  }
  reduction.inertia = inertia_integrals(model.m(), part.mesh.points, T);
  const auto& S = reduction.inertia.S_phiphi;
  reduction.M_se = S[0] + S[1] + S[2];
  reduction.K_se = MatrixXd::Zero(n, n);
  reduction.K_se.topLeftCorner(n_b, n_b) = basis.K_bb;
  reduction.K_se.diagonal().segment(n_b, n_phi) = basis.omega2;
  if (n_w > 0) {
    reduction.K_se.topRightCorner(n_b, n_w) = faces.K_bw;
    reduction.K_se.bottomLeftCorner(n_w, n_b) = faces.K_bw.transpose();
    reduction.K_se.bottomRightCorner(n_w, n_w) = faces.K_ww;
  }
  reduction.omega2 = basis.omega2;
  reduction.n_b = static_cast<int>(n_b);
  reduction.n_q = static_cast<int>(n_q);
  for (int k = 0; k < model.n_interfaces(); ++k)
    reduction.interfaces.push_back({part.interfaces[k].name, whole.interfaces[k].tie, model.point(k),
                                    model.directions(k), model.first_dof(k)});
  reduction.shapes.resize(3 * static_cast<Index>(options.shape_nodes.size()), n);
  for (std::size_t v = 0; v < options.shape_nodes.size(); ++v)
    reduction.shapes.middleRows<3>(3 * static_cast<Index>(v)) =
        T.middleRows<3>(3 * static_cast<Index>(options.shape_nodes[v])).cast<float>();
  report.rigid_strain = constraint.rigid_strain;
  report.rigid_error = constraint.rigid_error;
  report.seconds_projection = watch.lap();
  linalg::report(options.progress, "projection", 1.0);

  if (options.estimate_error && fixed_modes && n_w == 0) {
    // F_rs = K_ii^-1 - Phi Omega^-2 Phi^T, extra shapes included: they are K- and M-orthogonal like modes.
    const MatrixXd participation = linalg::transpose_times(basis.Phi, Mhat);  // n_q x n_b
    DroppedModes dropped = dropped_modes(interior, participation, basis.omega2);
    reduction.dropped = std::move(dropped.share);
    reduction.dropped_growth = std::move(dropped.growth);
    reduction.omega2_dropped = omega2_left_out;
    if (options.accuracy > 0.0) {
      const BandError error = band_error(reduction, options.omega_max);
      report.band_frequency_error = error.frequency;
      report.band_interface_error = error.interface;
    }
    report.seconds_estimate += watch.lap();
  }
  // The estimate knows solids only: with shells or beams the mesh's share is unknown.  What it adds to nearly incompressible
  // elements is held by the bulk modulus as they are themselves.
  JudgedMotions motions;
  if (options.estimate_mesh && part.mesh.shells.empty() && part.frames.empty() && part.dependent.empty() &&
      !is_nearly_incompressible(part)) {
    stage.next("Error of the mesh");
    const double before = linalg::processor_seconds();
    motions = judged_motions(reduction, options.omega_max);
    MeshEnergy left;
    const bool enriched = enrichment_suits(whole);
    if (enriched) {
      MatrixXd U = linalg::times(T, motions.states.Y);
      if (answer.size() > 0 && n_w == 0) add_dropped(model, basis, Mhat, answer, motions, U);
      left = enriched_energy(part, U, motions.states.lambda, motions.states.force, options.progress);
    } else
      left = recovered_energy(part, T * motions.states.Y, options.progress);
    if (left.known()) {
      reduction.mesh = mesh_share(motions, left);
      reduction.mesh->rough = !enriched;
      leave_out_concentrated(whole, motions, *reduction.mesh);
    }
    report.seconds_mesh_error = watch.lap();
    report.processor_seconds_mesh_error = linalg::processor_seconds() - before;
  }
  stage.next("Projection");
  for (const LoadField& load : options.loads) {
    reduction.loads.push_back(reduced_load(load, T, model.m()));
  }
  reduction.D_se = damper_matrix(part, model, T);
  if (options.stiffening) {
    reduction.stiffening =
        stiffening_terms(part, solver, constraint.Psi, constraint.K_bb, T, options.progress);
    report.seconds_stiffening = watch.lap();
  }
  if (!options.stress_nodes.empty()) {
    MatrixXd rotations;
    std::vector<int> rotation_of;
    if (!part.mesh.shells.empty()) {
      MatrixXd shapes_i = MatrixXd::Zero(model.n_i(), n), shapes_b = MatrixXd::Zero(n_b, n);
      shapes_i.leftCols(n_b) = basis.U_b;
      shapes_i.middleCols(n_b, n_phi) = basis.Phi;
      shapes_b.leftCols(n_b).setIdentity();
      rotations = model.expand_rotations(shapes_i, shapes_b);
      for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) rotation_of.push_back(model.rotation_of(node));
    }
    reduction.stress_modes = nodal_stress_modes(part, T, options.stress_nodes, rotations, rotation_of);
    report.seconds_stress = watch.lap();
    if (reduction.mesh) {
      const double before = linalg::processor_seconds();
      add_peaks(motions, peak_stresses(whole, T, reduction.stress_modes, options.stress_nodes, motions.states.Y), *reduction.mesh);
      report.seconds_mesh_error += watch.lap();
      report.processor_seconds_mesh_error += linalg::processor_seconds() - before;
    }
  }
  if (n_w > 0)
    change_shapes(reduction, canonical_shapes(reduction.K_se, reduction.M_se, MatrixXd::Identity(n_b, n)));
  report.n_nodes = model.n_nodes();
  for (const auto* blocks : {&part.mesh.solids, &part.mesh.shells})
   for (const mesh::CellBlock& block : *blocks)
    report.n_cells += static_cast<int>(block.nodes.rows());
  report.n_i = model.n_i();
  report.n_b = reduction.n_b;
  report.n_q = reduction.n_q;
  return cut;
}

}  // namespace

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver) {
  linalg::EigenProblem problem;
  problem.n = model.n_i();
  problem.n_free = model.n_i() - static_cast<int>(model.A().rows());
  problem.solve = [&solver](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = solver.solve(X); };
  problem.multiply_K = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.K_ii().multiply(X, Y);
  };
  problem.multiply_magnitudes = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.K_ii().multiply_magnitudes(X, Y);
  };
  problem.multiply_M = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.multiply_M_ii(X, Y);
  };
  problem.project = [&solver](MatrixXd& R) { solver.remove_reactions(R); };
  problem.view = [&solver](_p_PetscViewer* viewer) { solver.view(viewer); };
  return problem;
}

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
          "elastic ties are for solids: with shells, beams or constraints tie the interfaces rigid or as averages");
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
  const Cut cut = reduce(whole, part, model, options, reduction);
  if (options.certify && cut.n_modes > 0) {
    linalg::report(options.progress, "certificate", 0.0);
    const linalg::LogStage stage("Certificate");
    watch.lap();
    certify(model, cut.order, cut.omega2_last, cut.omega2_next, cut.n_modes, reduction.report,
            options.storage);
    // Courant: no Ritz value stands below the eigenvalue of its number; elastic ties are another model.
    if (!stiff) require_not_below(reduction.omega2, reduction.report);
    reduction.report.seconds_certificate = watch.lap();
  }
  reduction.report.peak_memory_bytes = peak_memory();
  return reduction;
}

}  // namespace flexura::reduce
