// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/accuracy_goal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "reduce/cms/errors/error_estimate.hpp"
#include "reduce/library/mesh_sizes.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// The estimate of the mesh is worth half to twice the truth (docs/mesh_error.md): half of what is asked is aimed at, and
// modes left out may take a quarter.
constexpr double kMeshShare = 0.5, kModesShare = 0.25;
constexpr std::size_t kFrequencies = 6;  // without up_to
constexpr double kWorthSaying = 1.05;    // digits of an estimate
constexpr double kRoundOff = 1e-12;      // response shapes can hold all that interfaces ask for
constexpr double kMostDofs = 5e5;        // some minutes and about ten gigabytes
constexpr double kMostRaised = 3.0;      // docs/mesh_error.md: no estimate is less than a third of the truth
// cells_for() counts walls of one cell as if they were cubes; meshes had up to a quarter more dofs than it said.
constexpr double kUncounted = 1.25;

std::string percent(double x) {
  return std::isfinite(x) && x < 0.5 ? fmt::format("{:.3g} %", 100.0 * x) : std::string("50 % or more");
}

}  // namespace

double said_of_frequency(const std::vector<MeshShare::Mode>& modes, std::size_t k, double raised) {
  const auto lowest = [&](const MeshShare::Mode& mode) {
    return std::sqrt(mode.omega2) * (1.0 - std::min(raised * mode.error, 1.0));
  };
  double said = modes[k].error;
  for (const MeshShare::Mode& other : modes) {
    if (!std::isfinite(other.error)) continue;
    const bool above = other.omega2 > modes[k].omega2;
    const MeshShare::Mode &lower = above ? modes[k] : other, &upper = above ? other : modes[k];
    if (lowest(upper) <= std::sqrt(lower.omega2)) said = std::max(said, other.error);
  }
  return said;
}

AccuracyGoal::AccuracyGoal(const ModesInput& modes)
    : frequencies_(modes.accuracy),
      compliance_(modes.compliance_accuracy),
      up_to_(2.0 * std::numbers::pi * modes.up_to) {}

Judgement AccuracyGoal::judge(const Reduction& reduction) {
  Judgement out;
  if (!reduction.mesh || reduction.mesh->modes.empty()) return out;
  out.known = true;
  before_ = share_.modes;
  share_ = *reduction.mesh;
  n_judged_ = 0;
  for (const MeshShare::Mode& mode : share_.modes)
    n_judged_ += up_to_ > 0.0 ? mode.omega2 <= up_to_ * up_to_ : n_judged_ < kFrequencies;
  n_judged_ = std::max<std::size_t>(n_judged_, 1);
  for (std::size_t k = 0; k < n_judged_; ++k)
    out.frequencies = std::max(out.frequencies, share_.modes[k].error);
  raised_ = 1.0;
  // More modes move frequencies as well, by what those left out before had cost at most.
  const double of_modes = n_shapes_ == reduction.n() ? 0.0 : modes_before_;
  n_shapes_ = reduction.n();
  for (std::size_t k = 0; std::isfinite(of_modes) && k < std::min(n_judged_, before_.size()); ++k) {
    const double moved = std::sqrt(before_[k].omega2 / share_.modes[k].omega2) - 1.0 - of_modes,
                 said = said_of_frequency(before_, k, kMostRaised);
    if (std::isfinite(said) && said > 0.2 * frequencies_)
      raised_ = std::max(raised_, (moved + share_.modes[k].error) / said);
  }
  raised_ = std::min(raised_, kMostRaised);
  out.frequencies *= raised_;
  for (const MeshShare::Interface& interface : share_.interfaces)
    if (interface.error > out.compliance) {
      out.compliance = interface.error;
      out.interface = interface.name;
    }
  if (reduction.dropped.size() > 0) {
    const std::vector<ModeError> errors = mode_errors(reduction);
    for (std::size_t k = 0; k < std::min(n_judged_, errors.size()); ++k)
      out.modes = std::max(out.modes, 0.5 * errors[k].safe_estimate);
    if (out.modes < kRoundOff) out.modes = 0.0;
  }
  modes_before_ = out.modes;
  return out;
}

bool AccuracyGoal::mesh_reached(const Judgement& j) const {
  return j.frequencies <= kWorthSaying * kMeshShare * frequencies_ &&
         j.compliance <= kWorthSaying * kMeshShare * compliance_;
}

bool AccuracyGoal::modes_reached(const Judgement& j) const {
  return j.modes <= kModesShare * frequencies_;
}

std::vector<double> AccuracyGoal::next_sizes(const Part& part, int dofs) {
  constexpr double kAim =
      0.7;  // of what a motion may have: a little less, so that the next mesh is not just above
  const Eigen::MatrixXf& by_cell = share_.by_cell;
  std::vector<std::pair<Index, double>> judged;
  for (Index k = 0; k < by_cell.cols(); ++k) {
    const bool mode = k < static_cast<Index>(share_.modes.size());
    if (!mode || k < static_cast<Index>(n_judged_))
      judged.emplace_back(k, mode ? 2.0 * kMeshShare * frequencies_ / raised_ : kMeshShare * compliance_);
  }
  Eigen::MatrixXd share(by_cell.rows(), static_cast<Index>(judged.size()));
  for (std::size_t k = 0; k < judged.size(); ++k)
    share.col(static_cast<Index>(k)) = by_cell.col(judged[k].first).cast<double>() / judged[k].second;
  const double worst = share.size() > 0 ? share.colwise().sum().maxCoeff() : 0.0;
  const std::vector<char> sharp = nodes_at_sharp_edges(part);
  // One mesh tells the errors of one six times as good, not of any: asked for more at once, the interior would make up for
  // edges at which nothing finer may be asked.
  // Where the last sizes left more than they were to (edges at which stresses grow faster than those of mesh_sizes.hpp), more is
  // asked for: not by as much, as the first graded mesh tells little of the next.
  const double missed = expected_ > 0.0 ? std::clamp(std::sqrt(worst / expected_), 1.0, 2.0) : 1.0;
  expected_ = std::max(kAim, worst / 6.0);
  // A mesh far from the goal is made coarser where it need not be as fine as it is.  One that is near it is only made finer:
  // made coarser for one motion, it would miss the other by as much, to and fro.
  const double coarsest = worst > 4.0 ? 1.5 : 1.0;
  const auto factors = [&](double aim) { return cell_factors(part.mesh, share, sharp, aim, coarsest); };
  const auto cells = [&](const VectorXd& factor) {
    return kUncounted * cells_for(part.mesh, factor, sharp) * dofs;
  };
  VectorXd factor = factors(expected_ / missed);
  if (const double wanted = cells(factor); kUncounted * wanted > kMostDofs) {
    if (wanted > kMostDofs && (1.5 * dofs > kMostDofs || wanted > 2.0 * kMostDofs))
      throw std::runtime_error(fmt::format(
          "a mesh that may reach it would have about {:.2g} dofs, more than the {:.2g} that are tried: ask "
          "for less, for compliance separately (modes.compliance_accuracy), or choose mesh.size yourself",
          wanted, kMostDofs));
    double low = expected_ / missed, high = worst;  // the most that is tried, for what it may reach
    for (int k = 0; k < 6; ++k) {
      const double middle = std::sqrt(low * high);
      (kUncounted * cells(factors(middle)) > kMostDofs ? low : high) = middle;
    }
    factor = factors(high);
    expected_ = 0.0;
  }
  return size_points(part.mesh, factor, sharp);
}

std::string AccuracyGoal::describe(const Judgement& j) const {
  std::string text =
      fmt::format("frequencies: {} asked, half of it for the mesh, which leaves {}{}, dropped modes {}",
                  percent(frequencies_), percent(j.frequencies),
                  raised_ > kWorthSaying
                      ? fmt::format(" (its estimate times {:.2g}, for what the mesh before missed)", raised_)
                      : "",
                  percent(j.modes));
  if (!j.interface.empty())
    text += fmt::format("; static compliance: {} asked, the mesh leaves {} (interface {})",
                        percent(compliance_), percent(j.compliance), j.interface);
  return text;
}

}  // namespace flexura::reduce
