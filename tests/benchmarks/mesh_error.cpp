// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/session/session.hpp"
#include "tests/benchmarks/mesh_error_parts.hpp"
#include "tests/benchmarks/mesh_truth.hpp"

/// What the estimate of the mesh's error is worth: parts on coarse meshes against meshes refined until they are known.
/// mesh_error [cost] [NAME ...] prints docs/mesh_error.md.
namespace flexura::reduce {
namespace {

constexpr int kModes = 6,
              kCandidates = 10;  // compared; of the refined mesh, among which each has its partner

struct Run {
  Answer answer;
  MeshShare share;
  double seconds_factor = 0.0, seconds_estimate = 0.0;
};

Run run(const Part& part, const Eigen::Matrix3Xd& points) {
  ReductionOptions options;
  options.n_modes = 40;
  options.estimate_mesh = true;
  const Reduction r = craig_bampton(part, options);
  return {answer_of(part, r, kModes, points), r.mesh.value(), r.report.factor.processor_seconds,
          r.report.processor_seconds_mesh_error};
}

struct Tally {
  double least = 1e9, most = 0.0;
  int rows = 0, outside = 0, missed = 0, unknown = 0;
} tally, held_out;

std::map<std::string, Truth> truths;

const Truth& known_of(const Sequence& sequence) {
  const auto found = truths.find(sequence.kind);
  return found != truths.end() ? found->second
                               : truths.emplace(sequence.kind, truth_of(sequence, kCandidates)).first->second;
}

// truth: none where the refined meshes do not agree on what is compared.
void row(const Subject& subject, const std::string& what, const std::optional<Known>& truth, double error,
         double estimate, const std::string& cost) {
  Tally& to = subject.held_out ? held_out : tally;
  const std::string name = subject.name + (subject.held_out ? " (held out)" : "");
  if (!truth) {
    ++to.unknown;
    fmt::print("| {} | {} | not known | | {:.3f} % | | {} |\n", name, what, 100 * estimate, cost);
    return;
  }
  const double effectivity = estimate / error;
  // Below a thousandth the truth is not known well enough; there the estimate has to be small, too.
  const bool tiny = error < 1e-3 && estimate < 3e-3;
  if (!tiny) {
    to.least = std::min(to.least, effectivity);
    to.most = std::max(to.most, effectivity);
    to.outside += effectivity < 0.5 || effectivity > 2.0;
    to.missed += effectivity < 0.3;
  }
  ++to.rows;
  fmt::print("| {} | {} | {:.3f} % | {:.3f} % | {:.3f} % | {} | {} |\n", name, what, 100 * truth->uncertainty,
             100 * error, 100 * estimate,
             tiny ? std::string("both small") : fmt::format("{:.2f}", effectivity), cost);
}

void report(const Subject& subject) {
  const Truth& truth = known_of(subject.fine);
  const Run coarse = run(subject.coarse(), truth.points);
  std::string cost = fmt::format("{} dofs, {:.2f} s, {:.2f} s", coarse.answer.dofs, coarse.seconds_factor,
                                 coarse.seconds_estimate);
  const std::vector<int> partner = partners(coarse.answer.shapes, truth.shapes);
  for (std::size_t k = 0; k < kModes; ++k, cost.clear()) {
    const double estimate = coarse.share.modes[k].error;
    const int of = partner[k];
    if (of < 0) {
      row(subject, fmt::format("mode {} of the mesh, {:.5g} Hz, has no partner", k + 1, coarse.answer.hz[k]),
          {}, 0.0, estimate, cost);
      continue;
    }
    const Known& known = truth.hz[static_cast<std::size_t>(of)];
    row(subject, fmt::format("{:.5g} Hz", known.value), known.settled() ? std::optional(known) : std::nullopt,
        coarse.answer.hz[k] / known.value - 1.0, estimate, cost);
  }
  // Of each interface its worst direction.
  for (std::size_t k = 0, n = coarse.share.interfaces.size(); k < n; ++k) {
    const std::size_t directions = truth.compliance.size() / n;
    // Two that hold each other tell the same.
    if (n == 2 && k == 1) break;
    double worst = -1.0;
    Known of{};
    bool settled = true;
    for (std::size_t d = k * directions; d < (k + 1) * directions; ++d) {
      settled = settled && truth.compliance[d].settled();
      const double error = 1.0 - coarse.answer.compliance[d] / truth.compliance[d].value;
      if (error > worst) worst = error, of = truth.compliance[d];
    }
    row(subject, "compliance at " + coarse.share.interfaces[k].name,
        settled ? std::optional(of) : std::nullopt, worst, coarse.share.interfaces[k].error, "");
  }
  std::fflush(stdout);
}

void head() {
  fmt::print(R"(# The mesh's error and its estimate

Written by `tests/run mesh_error` (tests/benchmarks/mesh_error.cpp); do not edit by hand.

A mesh makes a part too stiff. By how much, in each frequency and in the static compliance of the interfaces, is estimated by
what elements of the next higher degree would add (reduce/estimate/enriched_error.hpp): the residual of the shape is answered by
their functions, in a few steps of conjugate gradients; on a mesh of more than 768 cells only on pieces of it, some where most of the
error is, some at random places, from which the rest is told by an indicator that is cheap everywhere. Cells of second degree get a fifth
more for the degrees after that, which was measured on the parts of this table except those that are held out; cells at re-entrant
edges and at edges of rigid interfaces get what theory says that all higher degrees gain there. A mode is judged with the static
answer of the modes that the reduction drops, so that what the reduction lacks is not taken for the mesh's.
Meshes of pyramids, hex27, elements with reduced integration or incompatible modes and parts with elastic ties are judged by
recovered stresses instead (reduce/estimate/mesh_error.hpp), which where few cells lie across are off by up to five; the report
says so.

The truth is the limit of three meshes of second degree, each finer than the one before by the same factor everywhere: bricks
whose rows become finer towards edges, re-entrant corners and ties, and tetrahedra that along re-entrant edges and around
rigid interfaces have a tenth of their size elsewhere (their numbers of dofs stand below). The limit is extrapolated by the order
that the three show, between the least that theory allows and four; its uncertainty is how far the limit by the least order is
away, and at least half of what was extrapolated (tests/benchmarks/mesh_truth.hpp). A quantity that is not known to 0.1 % so is no
truth: its row says "not known". Frequencies are paired by their shapes, compliances are those of the interface's worst direction
while all others are held. Effectivity is the estimate over the true error; below 0.1 % both are called small where the estimate
is below 0.3 %. Cost: dofs, processor seconds of the factorisation and of the estimate on the machine that made the table.

| part | quantity | truth known to | true error | estimate | effectivity | cost |
|---|---|---|---|---|---|---|
)");
}

void references() {
  fmt::print(
      "\n| part | dofs of the three meshes | quantities known to 0.1 % | the least known "
      "|\n|---|---|---|---|\n");
  for (const auto& [kind, truth] : truths) {
    int settled = 0, all = 0;
    double worst = 0.0;
    for (const std::vector<Known>* list : {&truth.hz, &truth.compliance})
      for (const Known& known : *list) {
        // Of the frequencies beyond those compared nothing is asked.
        if (list == &truth.hz && &known - list->data() >= kModes) continue;
        ++all;
        settled += known.settled();
        worst = std::max(worst, known.uncertainty);
      }
    fmt::print("| {} | {}, {}, {} | {} of {} | {:.3f} % |\n", kind, truth.dofs[0], truth.dofs[1],
               truth.dofs[2], settled, all, 100 * worst);
  }
}

// What the estimate costs beside the factorisation, on ever finer meshes of one part.
void costs() {
  fmt::print(
      "\nCost: the crank arm, two interfaces and ten modes, in ten-node tetrahedra; processor seconds of one "
      "run each, of the numeric "
      "factorisation, of the estimate and of the whole reduction without meshing.\n\n"
      "| dofs | factorisation | estimate | estimate / factorisation | reduction | estimate / reduction | "
      "first frequency, estimate | "
      "compliance, estimate |\n|---|---|---|---|---|---|---|---|\n");
  for (const double size : {0.010, 0.006, 0.0045, 0.0035, 0.0028, 0.0022, 0.0018}) {
    const Part part = crank_arm(size);
    ReductionOptions options;
    options.n_modes = 10;
    options.estimate_mesh = true;
    const double before = linalg::processor_seconds();
    const Reduction r = craig_bampton(part, options);
    const double whole = linalg::processor_seconds() - before, factor = r.report.factor.processor_seconds,
                 estimate = r.report.processor_seconds_mesh_error;
    fmt::print("| {} | {:.2f} s | {:.3f} s | {:.2f} | {:.2f} s | {:.3f} | {:.3f} % | {:.3f} % |\n",
               r.report.n_i + r.report.n_b, factor, estimate, estimate / factor, whole, estimate / whole,
               100 * r.mesh->modes[0].error, 100 * r.mesh->interfaces[0].error);
    std::fflush(stdout);
  }
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
  reduce::references();
  if (argc < 2 || std::string(argv[1]) == "cost") reduce::costs();
  for (const auto& [name, t] : {std::pair{"", reduce::tally}, std::pair{"held out: ", reduce::held_out}})
    if (t.rows > 0)
      fmt::print(
          "\n{}{} quantities; effectivity {:.2f} to {:.2f}, {} outside 0.5 to 2, {} below 0.3; {} not known "
          "to 0.1 %.\n",
          name, t.rows, t.least, t.most, t.outside, t.missed, t.unknown);
}
