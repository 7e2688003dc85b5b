// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <memory>
#include <vector>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/integrators/newton_matrix.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"
#include "mbs/solver/run/energy.hpp"
#include "mbs/study/estimate/span_path.hpp"

/// How far a run is from the exact motion, followed along its steps, whatever the integrator.
///
/// Over a span of one or several steps a run is taken to be the polynomial w(t) of degree five that has the positions,
/// velocities and accelerations of its ends (span_path.hpp).  The error e = w - y_exact obeys F(t, w - e, w' - e') = 0, F
/// the stabilised index-2 form (stabilised_index2.hpp; P. E. Zadunaisky, Numer. Math. 27 (1976) 21-39; J. Lang, J. G.
/// Verwer, Appl. Numer. Math. 57 (2007) 1-15).  It is solved for by one step of Newton's method from a prediction e*,
///
///     J e = d(t),      d = F(t, w - e*, w' - e*') + J e*,      J e* = 0 (what the error so far becomes by itself)
///
/// J = dF/dy + dF/dy' d/dt being held over many spans: what it has changed since, and what is not linear in e, is in d.
/// Of d integrals over the span are wanted, by Lobatto's four points.  What w itself lacks of the motion between the ends,
/// of order six, drops out of them, as it would not of those of the integrator's own polynomial.  One step of Radau IIA,
/// of order five, then carries e on: in up to eight pieces where it would damp what the error vibrates by; what even those
/// damp is carried on by steps of Gauss, which damp nothing.
///
/// Errors of poses are turns of the moving body, p_exact = p - T(p) theta, which the motion carries along: of a body that
/// spins evenly their equation has constant coefficients (KinematicBlocks::carry_along).
namespace flexura::study {

class ErrorEquation {
 public:
  /// `eq` outlives it.
  ErrorEquation(const mbs::Equations& eq, const mbs::State& start, const mbs::SolverOptions& options);

  /// The integrator starts there (the error stays what it is), and at most so many of its steps are one span.  Steps that
  /// wait must have been solved for.
  void restart(const mbs::State& s, const Eigen::VectorXd& v_dot, int longest_span);
  /// The integrator's next step: its begin, and the rest of Lobatto's points.
  void step(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  /// Solves for the next span of the steps that wait; false where there is none, or, but at the `end`, too few.
  bool advance(bool end);

  /// Until then the error is known; steps behind it are waiting [s].
  double known_until() const { return t_end_; }
  /// y - y_exact of a state within the last span: of p (n_p), v (n_v) and c (n_dyn), behind one another.
  void at(const mbs::State& s, Eigen::VectorXd& e);

  bool is_lost() const { return is_lost_; }        ///< it left all numbers
  long linearised() const { return linearised_; }  ///< how often
  long spans() const { return spans_; }

 private:
  // Derivatives serve as long as Newton's method is near with them: what a third step would move the error by, all spans
  // together, is less than this part of it, or the second step less than that part of the first.  Where the second one
  // alone is small it is left out in ever more spans.  Of many velocities derivatives cost far more than residuals: they
  // are held for longer, and a prediction is what the error was.
  struct Hold {
    double far, near, contracts;
    int most_unchecked;
  };
  static constexpr Hold kClose = {0.1, 0.03, 0.1, 8}, kRough = {3.0, 3.0, 0.5, 16};
  static constexpr int kCheap = 12;
  // Steps are one span where it leaves the states between them by less than the tolerance, of the largest motion so far, or
  // by less than this part of the error itself.
  static constexpr double kOfError = 0.003;
  // Errors up to this part of the mechanism and its speed are taken off as they are; of larger ones, which one step of
  // Newton's method does not follow, what is linear.
  static constexpr double kFollowed = 0.02;
  // A span is solved for in pieces where its own steps would damp what the error vibrates by: so much of that energy may be
  // lost in the whole run, and so many pieces there are at most.
  static constexpr double kLost = 0.6;
  static constexpr std::size_t kMostPieces = 8;

  struct Step {
    mbs::Instant begin;
    std::array<mbs::Instant, 3> nodes;
  };
  // The run at one of Lobatto's points, and how far it is off its constraints there.
  struct Node {
    mbs::Instant w;
    Eigen::VectorXd gaps;
  };
  using Stages = std::array<Eigen::VectorXd, 3>;
  using Piece = std::array<Eigen::VectorXd, 4>;  // its stages and its end
  // A collocation method, and its matrices for pieces of h seconds.
  struct Method {
    const mbs::ThreeStages& k;
    mbs::NewtonMatrix<double> real;
    mbs::NewtonMatrix<std::complex<double>> complex;
    double h = 0.0;
    Method(const mbs::ThreeStages& tableau, const mbs::StabilisedIndex2& form)
        : k(tableau), real(form), complex(form) {}
  };
  // The error with its rates: y in the order of the form, of p as a turn at the pose of the derivatives; v'.
  struct Error {
    Eigen::VectorXd y, v_dot;
  };

  std::size_t choose_span();
  void state_at(std::size_t steps, double t, mbs::Instant& out) const;
  void linearise(std::size_t steps);
  void to_turns(Eigen::VectorXd& e);
  void from_turns(Eigen::VectorXd& e);
  void error_at(double x, double h, Error& out) const;
  double size_of(const Eigen::VectorXd& y);
  void look(const mbs::Instant& at, const Eigen::VectorXd& gaps, const Error& e, Eigen::VectorXd& out);
  void gaps(const mbs::Instant& at, Eigen::VectorXd& out);
  void lay_nodes(std::size_t steps);
  void residual(const mbs::Instant& at, const Error& e, Eigen::VectorXd& out);
  void add_linear(const Error& e, Eigen::VectorXd& out);
  void moved_rates(const Error& e, const mbs::Instant& at, Eigen::VectorXd& out);
  void integrals(double h);
  void solve(double h);
  void solve_pieces(Method& method, double h, std::vector<Piece>& e);
  void defect_at(double x, double h, Eigen::VectorXd& d) const;
  void add_defects(double x, double h, Eigen::VectorXd& R) const;
  void look_half_way(double h);
  std::size_t piece_at(double x) const;
  double parabola(std::size_t i, double x) const;
  void value_at(double x, Eigen::VectorXd& y) const;
  const Eigen::VectorXd& begin_of(std::size_t piece) const {
    return piece == 0 ? e_begin_ : e_[piece - 1][3];
  }
  void keep_ringing(double h);
  void to_rates(const Eigen::VectorXd& e, Eigen::VectorXd& theta) const;
  double size_of_rates(const std::vector<Piece>& e) const;
  double distance_of_rates(const std::vector<Piece>& e) const;
  void acceleration_at(std::size_t piece, double x, double h, Eigen::VectorXd& a) const;
  bool keeps_vibration(double h);
  void momentum_at(std::size_t piece, double x, double h, Eigen::VectorXd& rest, Eigen::VectorXd& force);
  void improve(double h);
  void carry(std::size_t steps);
  void add_within(double x, Eigen::VectorXd& y);

  const mbs::Equations& eq_;
  mbs::Sizes n_;
  mbs::RadauTableau k_;
  mbs::GaussTableau gauss_k_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  mbs::StabilisedIndex2 form_;
  Method radau_, gauss_;
  mbs::NewtonMatrix<double> at_once_;
  bool has_at_once_ = false;
  mbs::ErrorWeights weights_;
  Eigen::Index n_rates_;  // p, v, c
  double duration_;

  // What spans are solved with.
  bool is_stale_ = true, has_start_ = false;
  bool has_cheap_matrices_ = true;
  Hold holds_ = kClose;
  int unchecked_ = 0, most_unchecked_ = 1;
  long linearised_ = 0, spans_ = 0;

  // Steps that wait, and how many are a span.
  std::vector<Step> waiting_;
  std::size_t count_ = 0, span_ = 1, longest_span_ = 1;
  SpanPath path_;
  std::vector<Eigen::VectorXd> turns_;

  // The greatest accelerations of the run so far [m/s^2], forces of its error [N] and what a span loses of their squares (n_v).
  Eigen::VectorXd greatest_run_, greatest_, lost_, a_;

  Eigen::VectorXd v_dot_end_;  // that the equations were met with at the end of the last span

  // The last span.
  double t_begin_ = 0.0, t_end_ = 0.0;
  Eigen::VectorXd e_begin_, e_end_;
  std::vector<Piece> e_, predicted_;  // of its pieces
  std::size_t pieces_ = 1, next_pieces_ = 1;
  // What the smallest pieces lose, at their ends; of the span before, whether there was any.
  bool rings_ = false, rang_ = false;
  std::vector<Piece> gauss_e_;
  std::array<Eigen::VectorXd, kMostPieces> ringing_;
  Stages R_;  // integrals of d, d itself of rows without rates
  bool is_lost_ = false;

  std::array<Node, 4> nodes_;
  Node middle_;
  bool has_middle_ = false, is_one_step_ = false;  // d_middle_ is that of the last span; it is one step
  mbs::Instant between_, moved_;
  Error error_, none_, error_part_;
  double off_p_ = 0.0, off_v_ = 0.0;
  double part_ = 1.0, speed_ = 1e-300, tolerance_ = 0.0, length_ = 1.0;
  Eigen::VectorXd reach_p_, reach_v_, out_, theta_;
  std::array<Eigen::VectorXd, 4> d_;
  Eigen::VectorXd d_middle_, d_there_;
  Eigen::VectorXd y_, yp_, rhs_, x_, rates_, b_, c_rate_, g_, g_dot_, zero_, p_, p_rate_, v_, dp_, dv_;
  Eigen::VectorXcd rhs_c_, x_c_;
};

}  // namespace flexura::study
