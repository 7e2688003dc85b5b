// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/mbs/random/scene/scene.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

namespace flexura::mbs::chance {

class SimbodySystem;

/// A scene as a Simbody system (Sherman, Seth, Delp, Simbody: multibody dynamics for biomedical research, Procedia IUTAM 2,
/// 2011), by Simbody's own mobilizers along a tree of the joints and its own constraints for what closes loops.  Forces that it
/// has no element for are put on its bodies by their law.
class SimbodyScene {
 public:
  /// `scene` has to outlive it.  Throws std::invalid_argument where lacks() says something.
  explicit SimbodyScene(const Scene& scene);
  ~SimbodyScene();

  /// What of the scene Simbody has no element for, or nothing.
  static std::string lacks(const Scene& scene);

  /// Bodies stand and move so at t.  Mobilizers take of it what they can; of redundant constraints as many hold as are
  /// independent there.
  void place(double t, const std::vector<BodyMotion>& motion);
  /// Runs on to t, each step with errors of `accuracy`, constraints closed to a tenth of it; returns the number of steps.
  /// Speeds are changed by `disturbance` first.
  long run(double t, double accuracy, double disturbance = 0.0);
  /// Places, speeds and accelerations of all bodies, (alpha, a) of Bo in W.
  std::vector<BodyMotion> motion() const;

  struct Rows {
    int kept = 0;
    double least_pivot = 1.0;   ///< of those kept, the square of a sine
    double largest_left = 0.0;  ///< of those left out
    double open = 0.0;          ///< largest of all, left out or not [m] or [rad]
    bool is_clear() const { return least_pivot > 1e-5 && largest_left < 1e-10; }
  };
  /// Of the constraints at the last place().
  Rows rows() const;

 private:
  std::unique_ptr<SimbodySystem> system_;  // Simbody's headers are C++17's
};

}  // namespace flexura::mbs::chance
