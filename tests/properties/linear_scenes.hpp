// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

/// Random mechanisms with inputs, and the judge of their linear systems: the runs that the inputs make.
namespace flexura::properties {

struct Scene {
  std::string head;  ///< top-level keys
  std::string text;  ///< all tables but those of the inputs u1 .. un
  int n_inputs = 0;
  double u = 0.0;                 ///< of every input in that state
  int n_motions = 0;              ///< outputs in m and rad, the first ones
  bool from_equilibrium = false;  ///< its state is the static equilibrium near the initial one
};

/// What random mechanisms have in common: inputs, what stands behind them, bodies, outputs.
class SceneMaker {
 public:
  explicit SceneMaker(mbs::chance::Chance& chance) : chance_(chance) {}

 protected:
  /// The name of an input, of a new one or of one that is there.
  std::string input();
  double number(double a, double b) { return chance_.between(a, b); }
  /// A signal that a position may follow: an input, a function of it, or a control behind it.
  std::string followed();
  /// A state that a place or a speed may follow: fed back from where it leads to, and from what is beside it.
  std::string led(const std::string& position, const std::string& beside);
  /// The key of a joint's drive by an input, most of them fed back from the joint's motion and what is beside it.
  std::string drive(const std::string& position, const std::string& speed, const std::string& beside);
  /// A force's value that reads a joint's motion, an input, and a control between.
  std::string feedback(const std::string& position, const std::string& speed);
  void body(const std::string& name, double length);
  void marker(const std::string& on, const std::string& name, double z, const char* axis);
  void joint(const std::string& name, const char* type, const std::string& from, const std::string& to,
             const std::string& keys = "");
  /// Cranks l and r along z on the ground, `width` apart, and their joints with the markers l and r of a body c, which is turned by
  /// `tilt` about y.
  void cranks(double width, double crank, double rocker, double tilt, const std::string& keys_of_crank);
  /// Ties joints' coordinates; its offset follows an input.
  void coupler(const std::string& a, const std::string& b);
  void joint_force(const std::string& name, const std::string& joint, const std::string& value);
  /// Outputs: a coordinate in m or rad; the place of a marker in the ground's marker o, with its acceleration.
  void motion(const std::string& name);
  void place(const std::string& marker, const char* direction);
  /// Outputs that are no motions: speeds, and what a joint holds.
  void further(const std::string& name);
  void load(const std::string& joint, const char* direction);
  Scene done(bool from_equilibrium = false);

  mbs::chance::Chance& chance_;
  std::string head_, text_;

 private:
  std::string motions_, further_;
  int n_inputs_ = 0, n_controls_ = 0, n_motions_ = 0, n_measures_ = 0;
};

/// Compares the linear system about the scene's state with runs in which its inputs move.  True where the system grows, by e at least
/// within a run.
bool expect_predicted(const Scene& scene, mbs::chance::Chance& chance, const test::Folder& folder);

}  // namespace flexura::properties
