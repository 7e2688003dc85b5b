// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>

#include "mbs/forces/force.hpp"
#include "mbs/forces/surfaces/pressure_law.hpp"
#include "mbs/kinematics/surface_patch.hpp"
#include "mbs/kinematics/touched_surface.hpp"

namespace flexura::mbs {

/// The surface of a body, as it is deformed, touches a surface in the axes of F: a plane, sphere or cylinder, or the deformed surface
/// of F's body.  Every node of it (surface_patch.hpp) bears the pressure at its place on its share A_j of the area.  What is touched
/// says of z_j = (the node's place, its own vertices around) how deep the node is and how far it is covered (touched_surface.hpp);
/// the forces on z_j are
///
///     X_j = A_j (chi p gap_z - E chi_z) + (f_j, - share f_j),     f_j = - mu A_j chi p tanh(|v_t| / v_0) v_t / |v_t|
///
/// with p of the depth -gap and its rate (pressure_law.hpp), E the energy that p stores and v_t the velocity of the node against what
/// it touches, across the gap's gradient.  Without damping and friction they are the gradient of sum A_j chi E.
///
/// The node's part acts on the body by the virtual work at that node, f . (d r_B + d theta x rho_j + Phi_j d s), and back on
/// F's body at the same place; the vertices' parts act on the modal coordinates of F's body.  All of it is a function of
/// the state, without a step where nodes come and go; the first touch and the last are a switch, so that no step leaps over a
/// short impact.
class SurfaceContact final : public ForceElement, public HasPicture {
 public:
  struct Friction {
    double mu = 0.0, v_0 = 1e-3;  ///< coefficient; speed over which it sets in [m/s]
  };
  /// A body's surface and the marker of the body's frame.
  struct Side {
    int body = 0, frame = -1;
  };
  /// `touching` with its nodes, of which the outputs may give every pressure; F `touched` carries what is touched, in its axes: the frame of its body where that deforms.
  SurfaceContact(std::string name, Side touching, std::shared_ptr<const SurfacePatch> patch, Side touched,
                 std::shared_ptr<const TouchedSurface> surface, PressureLaw law, Friction friction,
                 bool gives_pressures = false)
      : ForceElement(std::move(name)),
        body_(touching.body),
        B_(touching.frame),
        other_(touched.body),
        F_(touched.frame),
        patch_(std::move(patch)),
        touched_(std::move(surface)),
        law_(law),
        friction_(friction),
        gives_pressures_(gives_pressures) {}
  std::string_view type() const override { return "surface_contact"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, B_}; }
  std::optional<DrawnSurface> drawn_surface() const override { return touched_->drawn(); }

  int n_switches() const override { return 1; }
  std::string switch_name(int) const override { return "gap"; }
  void switching(const Kinematics& kin, const double*, double* values) const override;
  void start_switches(const Kinematics& kin, const double*, int* root, double*) const override;
  void change_switch(int, const Kinematics&, const double*, int* root, double*) const override {
    root[0] = 1 - root[0];
  }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override;
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override;
  std::vector<OutputInfo> outputs() const override;
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override;

 private:
  /// The body as F sees it, and how what it touches is deformed.
  struct View {
    Relative rel;
    const double *s, *s_dot, *o, *o_dot;
    int m_o;  ///< coordinates o that what it touches follows
  };
  /// A node that touches, in F.
  struct Touch {
    int node;
    Vector3d r;         ///< from Bo
    Vector3d turned_v;  ///< R Phi s'
    const TouchedSurface::Foot& foot;
    const Eigen::VectorXd& z_dot;
    Vector3d n, v, sliding;  ///< v: against what it touches
    double gap_rate, area, p;
    PressureLaw::Value law;
    Vector3d friction;             ///< [N]
    const Eigen::VectorXd& force;  ///< X
  };
  View view(const Kinematics& kin) const;
  SurfacePatch::Least nearest(const View& at) const;
  void for_touching(const View& at, bool second, const std::function<void(const Touch&)>& take) const;
  /// Of a node's forces X by z and z'.
  void slopes(const Touch& t, Eigen::MatrixXd& by_place, Eigen::MatrixXd& by_velocity) const;

  int body_, B_, other_, F_;
  std::shared_ptr<const SurfacePatch> patch_;
  std::shared_ptr<const TouchedSurface> touched_;
  PressureLaw law_;
  Friction friction_;
  bool gives_pressures_;  ///< of every node, among its outputs
};

}  // namespace flexura::mbs
