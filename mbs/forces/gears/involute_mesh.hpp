// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/contacts/contact_law.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/forces/gears/involute.hpp"

namespace flexura::mbs {

/// Teeth of two wheels in mesh, wherever their shafts take them: wheel 1 turns with the marker F, wheel 2 with M, both about
/// their z axes, which point the same way.  x axes point along the middle of a tooth of wheel 1 and of a space of wheel 2.
/// With beta_1 the direction of Mo in F, beta_2 that of Fo in M, z the distance along the axes and a across them,
///
///     x = -(r_b1 beta_1 + r_b2 beta_2) + z tan(beta_b), less whole pitches       along the line of action
///     gap_+- = play(a) / 2 -+ x,    y_+- = r_b1 (half_thickness_1 -+ beta_1)
///
/// (involute.hpp).  On each flank a contact law (contact_law.hpp) of the mean stiffness times k(y) / c_gamma; forces are
/// the gradient of its energy, so that torques, radial, tangential and axial forces follow, and wheels may rattle.
class InvoluteMesh final : public ForceElement {
 public:
  InvoluteMesh(std::string name, int F, int M, Involute gears, ContactLaw law)
      : ForceElement(std::move(name)), F_(F), M_(M), gears_(std::move(gears)), law_(law) {}
  std::string_view type() const override { return "involute_mesh"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }
  int n_states() const override { return 2 * law_.n_states(); }
  bool is_held(int) const override { return true; }
  int n_switches() const override { return 2 * ContactLaw::n_switches; }
  std::string switch_name(int i) const override;
  bool jumps_at(int which) const override { return ContactLaw::jumps_at(which % ContactLaw::n_switches); }
  void start(double* c) const override;
  void rates(const Kinematics&, const double*, double* c_rate) const override;
  void switching(const Kinematics& kin, const double*, double* values) const override;
  void start_switches(const Kinematics& kin, const double*, int* root, double* c) const override;
  void change_switch(int which, const Kinematics& kin, const double*, int* root, double* c) const override;

  void apply(const Kinematics& kin, const double*, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override;
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override;
  std::vector<OutputInfo> outputs() const override;
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override;

 private:
  struct Direction;
  class Wheels;
  struct Flank;
  Flank flank(int side, const Wheels& at, const Kinematics& kin) const;

  int F_, M_;
  Involute gears_;
  ContactLaw law_;
};

}  // namespace flexura::mbs
