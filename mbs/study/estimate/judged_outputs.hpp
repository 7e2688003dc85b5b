// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mbs/base/documents/units.hpp"
#include "mbs/solver/start/prepare.hpp"

/// By which outputs the error of a run is judged, and how.
///
/// An error is relative to the rms of its output.  Where that is zero or noise the error is judged against the
/// output's family: what the same joint or body has of the same unit (the greatest force in that joint), what
/// the whole mechanism has of it (a coordinate: the largest motion), and where that is nothing either, what its
/// forces, lengths and speeds make of it.
///
/// What noise is depends on where an error comes from.  A run knows the forces and accelerations of one joint or
/// body to 1e-3 of the greatest, which is what reactions are good for at usual tolerances, and so those of the
/// whole mechanism; other quantities to 1e-6, or a tenth of the integrator's tolerance.  What is smaller is noise,
/// unless its error is well below itself: a bar that bends by a millimetre on a carriage that travels sixty metres
/// is no noise.  What left out deformations change is a solution of linear equations, and hardly noisy: of it the
/// least part of a mechanism counts by itself, however large the others are.  Where a whole family of forces,
/// accelerations or powers is below the tolerance beside what the others make of it, all of it is noise.
namespace flexura::study {

struct OutputEstimate {
  std::string name;
  input::Dimension dimension;
  double max = 0.0, rms = 0.0, final = 0.0;  ///< of the error, in the output's unit
  double size_max = 0.0, size_rms = 0.0;     ///< of the corrected output
  double rest = 0.0;   ///< of it a linear correction knows nothing: what cancels in it leaves so much (rms)
  double scale = 0.0;  ///< what an rms error is relative to: size_rms, or the rms of the family
  bool counts = true;  ///< false where nobody asked for it and it is nothing beside others of its unit
  double relative_max() const;
  double relative_rms() const;
};

/// Sets `rest` of the forces and torques of joints of the tree from what is left of the equations on each velocity coordinate (n_v).
void set_rests(const mbs::Mechanism& mechanism, const Eigen::VectorXd& rests,
               std::vector<OutputEstimate>& outputs);

/// Relative rms, of the worst output that counts, of squared errors integrated over `span`; and which.
std::pair<double, int> worst_output(const Eigen::VectorXd& squares, double span,
                                    const std::vector<OutputEstimate>& outputs);

/// The quantities of `full` by which a run is judged, each with its name and dimension in `outputs`: outputs that
/// both mechanisms have, and what is asked for by a name that only the full model knows (stress of a body that
/// is rigid in the run, where it is zero); modal coordinates of a body, and places of the largest stress, are no outputs of an
/// engineer's.
std::vector<int> judged_outputs(const mbs::PreparedMechanism& run, const mbs::Mechanism& full,
                                std::vector<OutputEstimate>& outputs);

/// By which tolerance an output is noise beside its family: where an accuracy is asked for a thousandth of it at most, however
/// loosely the run begins.
double tolerance_of_noise(const mbs::PreparedMechanism& run);

/// Of a run's rows one in so many is looked at, 400 to 800 in all.
long rows_between(const mbs::PreparedMechanism& run);

/// Across the mechanism [m].
double length_of(const mbs::PreparedMechanism& run);

/// How large motion, forces and energies of a mechanism are: their rms over the rows taken, of lengths and
/// angles about their mean.
class Families {
 public:
  /// `length` [m] across the mechanism.
  Families(const mbs::Mechanism& mechanism, double length);

  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  /// Where errors come from: deformations that are left out, by a linear correction; or the steps of a run and its elements.
  enum class Of { deformation, run };
  /// Sets `scale` and `counts` of the outputs from their size_rms, of a run also from the rms of their errors; `asked`: the
  /// user named them.
  void judge(std::vector<OutputEstimate>& outputs, bool asked, double tolerance, Of of) const;

 private:
  const mbs::Mechanism& mechanism_;
  double length_, lever_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<int> which_;
  std::vector<std::string> owner_;  // empty: in no family
  std::set<std::string> alone_;     // judged by themselves
  std::vector<input::Dimension> dimension_;
  Eigen::VectorXd y_, sum_, squares_;
  long rows_ = 0;
};

}  // namespace flexura::study
