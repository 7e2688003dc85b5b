// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/craig_bampton.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>

#include "reduce/cms/reduction_stages.hpp"
#include "reduce/cms/shapes/interface_modes.hpp"
#include "reduce/cms/shapes/ritz_check.hpp"
#include "reduce/cms/shapes/sturm.hpp"
#include "reduce/cms/team_reduction.hpp"
#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/petsc/log_stage.hpp"

namespace flexura::reduce {
namespace {

// The stages and the certificate.
void reduce_model(const Part& whole, const Part& part, const TiedModel& model,
                  const ReductionOptions& options, Reduction& reduction) {
  const bool has_elastic = model.decide(&part != &whole);
  const Cut cut = run_stages(whole, part, has_elastic, model, options, reduction);
  if (!options.certify || cut.n_modes == 0) return;
  linalg::Stopwatch watch;
  linalg::report(options.progress, "certificate", 0.0);
  const linalg::LogStage stage("Certificate");
  if (cut.counted)
    note_count(cut.omega2_last, cut.omega2_next, cut.n_modes, reduction.report);
  else
    certify(model, cut.order, cut.omega2_last, cut.omega2_next, cut.n_modes, reduction.report,
            options.storage);
  // Courant: no Ritz value stands below the eigenvalue of its number; elastic ties are another model.
  if (!has_elastic) require_not_below(reduction.omega2, reduction.report);
  reduction.report.seconds_certificate = watch.lap();
}

template <class From>
TiedModel assembled(const From& from, const ReductionOptions& options) {
  const linalg::LogStage stage("Assembly");
  AssemblyOptions assembly;
  assembly.progress = options.progress;
  return TiedModel(from, assembly);
}

}  // namespace

Reduction craig_bampton(const Part& whole, const Part& part, const PartShare& share,
                        const ReductionOptions& options) {
  Reduction reduction;
  linalg::Stopwatch watch;
  const TiedModel model = [&] {
    const linalg::SomeCores cores(share.team->cores_each());
    return assembled(share, options);
  }();
  reduction.report.seconds_assembly = watch.lap();
  reduction.report.notes.push_back(
      fmt::format("{} processes share the elements, the factorisations and the solves", share.team->size()));
  reduce_model(whole, part, model, options, reduction);
  return reduction;
}

Reduction craig_bampton(const Part& whole, const ReductionOptions& options) {
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
  if (options.team) return lead_reduction(whole, part, options);
  Reduction reduction;
  linalg::Stopwatch watch;
  const TiedModel model = assembled(part, options);
  reduction.report.seconds_assembly = watch.lap();
  reduce_model(whole, part, model, options, reduction);
  reduction.report.peak_memory_bytes = linalg::peak_memory();
  return reduction;
}

}  // namespace flexura::reduce
