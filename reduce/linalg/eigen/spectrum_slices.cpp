// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/spectrum_slices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/lanczos_space.hpp"
#include "reduce/linalg/eigen/slice.hpp"

namespace flexura::linalg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr const char* kStage = "modes (block Lanczos in slices)";

double hertz(double omega2) {
  return std::sqrt(std::max(omega2, 0.0)) / (2.0 * std::numbers::pi);
}

// Counts and what is found do not agree.
struct Miscounted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The vectors of a slice do not become accurate.
struct Stuck : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Slices {
 public:
  Slices(const EigenProblem& problem, const EigenRequest& request, const SliceSettings& settings,
         const Progress& progress, int& n_solves)
      : problem_(problem),
        n_solves_(n_solves),
        request_(request),
        settings_(settings.lanczos),
        progress_(progress),
        block_(std::min<Index>(std::max(1, settings_.block), problem.n_free)),
        radius_(std::max<Index>(settings.modes / 2, 1)),
        goal_(std::min<Index>(std::max(request.count, 1) + 1, problem.n_free)) {
    pairs_.Phi.resize(problem.n, goal_ + radius_);
  }

  EigenPairs run() {
    extend({-problem_.shift, problem_.solve, 0, std::min(radius_, goal_)});
    while (!is_enough()) shift();
    const Index n = found();
    pairs_.Phi.conservativeResize(Eigen::NoChange, n);
    trim(pairs_, request_);
    pairs_.residual.conservativeResize(pairs_.omega2.size());
    pairs_.round_off.conservativeResize(pairs_.omega2.size());
    // Where all there is was found the last shift need not lie beyond it.
    pairs_.counted = counted_ > 0 && sigma_ > last_found();
    report(progress_, kStage, 1.0);
    return std::move(pairs_);
  }

 private:
  Index found() const { return pairs_.omega2.size(); }
  double last_found() const { return pairs_.omega2(found() - 1); }

  // All that is asked for lies below the last shift; a cluster at the cut may make it more.
  bool is_enough() {
    if (found() == problem_.n_free) return true;
    if (counted_ < goal_ || !(sigma_ > request_.omega2_max)) return false;
    EigenPairs cut;
    cut.omega2 = pairs_.omega2.head(counted_);
    cut.Phi.resize(0, counted_);
    trim(cut, request_);
    if (cut.omega2.size() < counted_) return true;
    goal_ = std::min<Index>(counted_ + block_, problem_.n_free);
    return false;
  }

  // The next slice, from another shift where the first lies too near to an eigenvalue.
  void shift() {
    constexpr double kAway[] = {0.0, -0.037, 0.023};  // of the step
    for (const double away : kAway) try {
        return shift(away);
      } catch (const Stuck&) {
        if (away == std::end(kAway)[-1]) throw;
      }
  }

  // The next shift, the factor there, and what is nearest to it.
  void shift(double away) {
    const Index asked = sought();
    double place = static_cast<double>(std::min(found() + radius_, asked));
    EigenProblem::Shifted factor;
    double sigma = 0.0;
    for (int attempt = 0;; ++attempt) {
      sigma = where(place);
      sigma += away * (sigma - std::max(sigma_, last_found()));
      factor = {};  // one beside the problem's own at a time
      factor = factorise(sigma);
      const Index between = factor.n_below - found();
      if (between <= 2 * radius_ + block_ || attempt == 4) break;
      // Eigenvalues lie closer than those before: what was counted says how much.
      place = static_cast<double>(found()) + (place - static_cast<double>(found())) *
                                                 static_cast<double>(radius_) / static_cast<double>(between);
    }
    if (factor.n_below < found()) refuse(factor.n_below, found(), sigma);
    const bool is_last = factor.n_below >= goal_ && sigma > request_.omega2_max;
    const Slice slice{sigma, std::move(factor.solve), factor.n_below - found(),
                      is_last ? 0 : std::clamp<Index>(asked - factor.n_below, 1, radius_)};
    if (slice.n_left + slice.least_right > 0) extend(slice);
    sigma_ = sigma;
    counted_ = factor.n_below;
  }

  // Up to which number shifts must rise: a little beyond what is asked for, as densities are estimates.
  Index sought() const {
    double last = static_cast<double>(goal_);
    if (request_.omega2_max > 0.0)
      last = std::max(last, expected_below(pairs_.omega2, request_.omega2_max) + 1.0);
    const double rest = std::clamp(last - static_cast<double>(found()), 0.0, static_cast<double>(radius_));
    return static_cast<Index>(
        std::min(last + 2.0 + std::ceil(0.04 * rest), static_cast<double>(problem_.n_free)));
  }

  // Where the eigenvalue of this number may be.
  double where(double number) const {
    const double least = std::max(sigma_, last_found()), base = std::min(pairs_.omega2(0), 0.0);
    // Rigid motions alone tell no distance; the shift of a free body does.
    const double reach = std::max(last_found() - base, 0.05 * problem_.shift);
    const double there = reach * std::pow((number + 0.5) / static_cast<double>(found()),
                                          1.0 / growth_of_number(pairs_.omega2));
    return std::max(least + 1e-5 * std::abs(least), base + there);
  }

  // Where sigma is all but an eigenvalue, or one of a piece of the structure, it moves a little; sigma says where to.
  EigenProblem::Shifted factorise(double& sigma) const {
    constexpr double kMoves[] = {0.0, 0.011, -0.013, 0.029, -0.031, 0.053};
    const double from = sigma, step = from - std::max(sigma_, last_found());
    for (const double move : kMoves) {
      report(progress_, kStage, fraction(0));
      sigma = from + move * step;
      try {
        return problem_.shifted(sigma);
      } catch (const std::runtime_error&) {
        if (move == std::end(kMoves)[-1]) throw;
      }
    }
    return {};
  }

  double fraction(Index more) const {
    const auto n = static_cast<double>(found() + more);
    return std::min(0.99, n / std::max(n, static_cast<double>(goal_)));
  }

  [[noreturn]] void refuse(Index counted, Index found, double sigma) const {
    throw Miscounted(fmt::format(
        "spectrum slices: below {:.6g} Hz there are {} modes by Sylvester's law, but {} were found; take "
        "wider blocks (-eps_blocklanczos_block {}) or one basis (-eps_blocklanczos_slice 0)",
        hertz(sigma), counted, found, 2 * block_));
  }

  // Block Lanczos from one shift; what it finds joins the pairs.
  void extend(const Slice& slice) {
    EigenProblem shifted = problem_;
    shifted.solve = [this, &slice](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
      n_solves_ += static_cast<int>(X.cols());
      slice.solve(X, Y);
    };
    const Index target = slice.n_left + slice.least_right;
    const Index suggested = std::max<Index>(settings_.most_vectors, target + 5 * block_);
    LanczosSpace space(shifted, settings_.storage, block_,
                       std::min<Index>(problem_.n_free + 2 * block_, suggested));
    double accurate = std::max(0.1 * request_.tolerance, 1e-14);
    int rounds_without_gain = 0, settled = 0;  // blocks before which nothing is taken for found
    Index best = -1;                           // accurate pairs at a restart
    // The projected matrix is small: a look at it costs about what a block does.
    constexpr Index kBlocksBetweenLooks = 4;
    const Index expected = 2 * target + 10 * block_;
    Index next_look = target + std::max(target / 2, block_);
    for (int step = 0;; ++step) {
      space.expand();
      const Index size = space.size();
      report(progress_, kStage, fraction(target * std::min(size, expected) / (expected + block_)));
      if (!space.exhausted() && size < next_look && step > 0 && !space.is_full()) continue;
      const LanczosSpace::RitzPairs ritz = space.ritz_pairs();
      Known known = known_pairs(ritz, accurate);
      Index right = right_of(slice, ritz, known);
      // As in one basis: a cluster of as many members as vectors that the space has come from may have more.
      if (largest_cluster(slice, ritz, known) >= space.n_starting() && space.begin_anew(space.n_starting())) {
        settled = space.n_blocks() + std::max(4, space.n_blocks() / 2);
        next_look = space.size_with_newest();
        continue;
      }
      if (!space.exhausted() && space.n_blocks() < settled) right = -1;
      if (space.exhausted() && right < 0) {
        if (space.begin_anew()) {
          next_look = space.size_with_newest();
          continue;
        }
        // The whole space is spanned: everything there is has been found.
        known.right = (ritz.theta.array() > 0.0).count();
        known.left = size - known.right;
        right = slice.least_right > 0 ? known.right : 0;
      }
      if (right >= 0) {
        check_neighbour(slice, ritz);
        EigenPairs some = take(shifted, space, ritz, std::min(known.left, slice.n_left), right);
        if (some.Phi.cols() == 0 || is_accurate(some, request_.tolerance)) {
          some.n_blocks += space.n_blocks();
          return add(slice, some);
        }
        if (space.exhausted() || ++rounds_without_gain > 8)
          throw Stuck(
              fmt::format("block Lanczos: the worst residual of {} modes near {:.6g} Hz stays at {:.1e}, "
                          "above {:.1e}: the "
                          "stiffness matrix is too badly conditioned for this accuracy",
                          some.Phi.cols(), hertz(slice.sigma), some.residual.maxCoeff(), request_.tolerance));
        accurate = std::max(0.1 * accurate, 1e-16);
      }
      next_look = size + kBlocksBetweenLooks * block_;
      if (space.is_full()) {
        // Restarts that gain nothing have come to round-off, which a shift beside an eigenvalue magnifies: what is there is
        // measured with K and M, and polished.
        const Index gained =
            std::min(known.left, slice.n_left) + std::min(known.right, slice.least_right + 1);
        if (gained <= best) accurate = std::min(10.0 * accurate, request_.tolerance);
        best = std::max(best, gained);
        restart(space, ritz, slice);
      }
      if (step > settings_.most_blocks)
        throw Stuck(fmt::format("block Lanczos: no convergence in {} blocks near {:.6g} Hz",
                                settings_.most_blocks, hertz(slice.sigma)));
    }
  }

  // How many on the right; -1: not decided yet.  On the left the next one is looked at, too: it must be the last that was
  // found before.
  Index right_of(const Slice& slice, const LanczosSpace::RitzPairs& ritz, const Known& known) const {
    if (known.left < slice.n_left) return -1;
    if (takes_again(slice, ritz)) return 0;
    if (found() > 0 && !(neighbour(slice, ritz).error < 1e-3 * (first_of(slice, ritz) - last_found())))
      return -1;
    if (slice.least_right == 0) return 0;
    if (found() + slice.n_left + known.right == problem_.n_free) return known.right;  // there are no others
    if (known.right <= slice.least_right) return -1;
    const VectorXd omega2 = slice.sigma + ritz.theta.head(known.right).array().inverse();
    const Index end = end_of(omega2, slice.least_right);
    return end > 0 ? end : -1;
  }

  bool takes_again(const Slice& slice, const LanczosSpace::RitzPairs& ritz) const {
    return found() > 0 && first_of(slice, ritz) - last_found() <= 1e-8 * std::abs(last_found());
  }

  // No eigenvalue lies between the last that was found and the first that the slice takes.
  void check_neighbour(const Slice& slice, const LanczosSpace::RitzPairs& ritz) const {
    if (found() == 0) return;
    if (takes_again(slice, ritz)) refuse(found() + slice.n_left, found() + slice.n_left - 1, slice.sigma);
    const auto [omega2, error] = neighbour(slice, ritz);
    // Rigid motions are round-off themselves.
    const double scale = std::max(std::abs(last_found()), first_of(slice, ritz) - last_found());
    if (omega2 - last_found() > error + 1e-8 * scale)
      refuse(found() + slice.n_left, found() + slice.n_left + 1, slice.sigma);
  }

  // The pairs that a slice brings, ascending, vectors orthogonal to those there are.
  EigenPairs take(const EigenProblem& shifted, const LanczosSpace& space, const LanczosSpace::RitzPairs& ritz,
                  Index left, Index right) const {
    MatrixXd Y(ritz.theta.size(), left + right);
    VectorXd theta(left + right);
    Y << ritz.Y.rightCols(left), ritz.Y.leftCols(right);
    theta << ritz.theta.tail(left), ritz.theta.head(right);
    EigenPairs some;
    some.Phi = space.vectors(Y, theta);
    if (some.Phi.cols() == 0) return some;
    separate(some.Phi);
    orthonormalise(problem_, some.Phi);
    measure_residuals(problem_, some);
    polish_until_accurate(shifted, request_.tolerance, some);
    return some;
  }

  // Takes the vectors found before out of new ones.  What they share is round-off unless one was found twice.
  void separate(MatrixXd& Phi) const {
    if (found() == 0) return;
    MatrixXd M_Phi;
    problem_.multiply_M(Phi, M_Phi);
    VectorXd sizes = Phi.cwiseProduct(M_Phi).colwise().sum();
    if (problem_.sum) problem_.sum(sizes.data(), sizes.size());
    const MatrixXd shared = problem_.inner(pairs_.Phi.leftCols(found()), M_Phi);
    const double most = (shared * sizes.cwiseSqrt().cwiseInverse().asDiagonal()).cwiseAbs().maxCoeff();
    if (most > 1e-2)
      throw Miscounted(
          fmt::format("spectrum slices: two of them have found the same mode (their vectors share {:.2g}), "
                      "so a count is wrong; take "
                      "wider blocks (-eps_blocklanczos_block {}) or one basis (-eps_blocklanczos_slice 0)",
                      most, 2 * block_));
    add_product(-1.0, pairs_.Phi.leftCols(found()), shared, Phi);
  }

  void add(const Slice& slice, const EigenPairs& some) {
    const Index n = found(), more = some.Phi.cols();
    // The count says that so many lie between what is known and sigma.
    const Index left = (some.omega2.array() < slice.sigma).count();
    if (left != slice.n_left || (n > 0 && more > 0 && some.omega2(0) <= last_found()))
      refuse(n + slice.n_left, n + left, slice.sigma);
    if (n + more > pairs_.Phi.cols()) pairs_.Phi.conservativeResize(Eigen::NoChange, n + more + radius_);
    pairs_.Phi.middleCols(n, more) = some.Phi;
    const auto append = [more](VectorXd& all, const VectorXd& part) {
      all.conservativeResize(all.size() + more);
      all.tail(more) = part;
    };
    append(pairs_.omega2, some.omega2);
    append(pairs_.residual, some.residual);
    append(pairs_.round_off, some.round_off);
    pairs_.n_blocks += some.n_blocks;
    if (settings_.look) settings_.look(pairs_.omega2, pairs_.residual, found(), pairs_.n_blocks);
  }

  // Thick restart with the pairs wanted and a block on each side.
  void restart(LanczosSpace& space, const LanczosSpace::RitzPairs& ritz, const Slice& slice) const {
    const Index n = ritz.theta.size(), positive = (ritz.theta.array() > 0.0).count();
    const VectorXd omega2 = slice.sigma + ritz.theta.array().inverse();
    // Of a cluster all: they take turns in being accurate.
    const auto together = [&](Index k) {
      return std::abs(omega2(k) - omega2(k + 1)) < kMultiple * std::abs(omega2(k));
    };
    Index left = std::min(n - positive, slice.n_left), right = std::min(positive, slice.least_right);
    while (left > 0 && left < n - positive && together(n - left - 1)) ++left;
    while (right > 0 && right < positive && together(right - 1)) ++right;
    left = std::min(n - positive, left + block_);
    right = std::min(positive, right + block_);
    if (4 * (left + right) > 3 * space.capacity())
      space.reserve(std::min<Index>(problem_.n_free, 2 * space.capacity()) + 2 * block_);
    MatrixXd Y(n, left + right);
    VectorXd theta(left + right);
    Y << ritz.Y.leftCols(right), ritz.Y.rightCols(left);
    theta << ritz.theta.head(right), ritz.theta.tail(left);
    space.restart(Y, theta);
  }

  const EigenProblem& problem_;
  int& n_solves_;
  const EigenRequest& request_;
  const BlockLanczosSettings& settings_;
  const Progress& progress_;
  const Index block_, radius_;  // of right-hand sides; pairs wanted on each side of a shift
  Index goal_;                  // pairs wanted, the first that is left out with them
  EigenPairs pairs_;            // ascending, without a gap; Phi has room for more
  double sigma_ = -std::numeric_limits<double>::infinity();  // the last shift within the spectrum
  Index counted_ = 0;                                        // eigenvalues below it
};

}  // namespace

EigenPairs iterate_slices(const EigenProblem& problem, const EigenRequest& request,
                          const SliceSettings& settings, const Progress& progress) {
  // Of a multiple eigenvalue one vector may come so late that all about it is taken for found; wider blocks bring it earlier.
  constexpr int kWider = 4;
  int n_solves = 0;  // in vain or not
  for (SliceSettings now = settings;; now.lanczos.block *= 2) try {
      EigenPairs pairs = Slices(problem, request, now, progress, n_solves).run();
      pairs.n_solves = n_solves;
      return pairs;
    } catch (const Miscounted&) {
      if (now.lanczos.block >= kWider * settings.lanczos.block) throw;
    }
}

}  // namespace flexura::linalg
