// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/forces/contacts/contact.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/forces/surfaces/pressure_law.hpp"
#include "mbs/kinematics/surface_patch.hpp"

namespace flexura::mbs {

/// The surface of a body, as it is deformed, touches a plane, sphere or cylinder fixed in F: every node of it (surface_patch.hpp)
/// bears the pressure at its place on its share A_j of the area,
///
///     f_j = A_j p_j (n - mu tanh(|v_t| / v_0) v_t / |v_t|),     depth = -gap(rho_j)
///
/// (pressure_law.hpp; n, v_t: Contact).  It acts on the body by the virtual work at that node, f_j . (d r_B + d theta x rho_j +
/// Phi_j d s), and back on F's body at the same place.  All of it is a function of the state, without a step where nodes come
/// and go; the first touch and the last are a switch, so that no step leaps over a short impact.
class SurfaceContact final : public ForceElement, public HasPicture {
 public:
  struct Friction {
    double mu = 0.0, v_0 = 1e-3;  ///< coefficient; speed over which it sets in [m/s]
  };
  /// `body` with its frame's marker and its surface; `F` carries the shape.
  SurfaceContact(std::string name, int body, int frame, std::shared_ptr<const SurfacePatch> patch, int F,
                 ContactSurface shape, PressureLaw law, Friction friction)
      : ForceElement(std::move(name)),
        body_(body),
        B_(frame),
        F_(F),
        patch_(std::move(patch)),
        shape_(std::move(shape)),
        law_(law),
        friction_(friction) {}
  std::string_view type() const override { return "surface_contact"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, B_}; }
  std::optional<DrawnSurface> drawn_surface() const override { return shape_.drawn(); }

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
  /// The body as F sees it.
  struct View {
    Relative rel;
    const double *s, *s_dot;
  };
  /// A node that touches, in F.
  struct Touch {
    int node;
    Vector3d r;         ///< from Bo
    Vector3d turned_v;  ///< R Phi s'
    Vector3d v;         ///< of the node, as F sees it
    Vector3d n, sliding;
    double gap_rate, area;
    PressureLaw::Value p;
    Vector3d friction;  ///< [N]
    Vector3d force() const { return area * p.p * n + friction; }
  };
  View view(const Kinematics& kin) const;
  SurfacePatch::Least nearest(const View& at) const;
  template <class Take>
  void for_touching(const View& at, const Take& take) const;
  /// Of a node's force by its place and its velocity in F.
  void slopes(const Touch& t, const Vector3d& p, Matrix3d& by_place, Matrix3d& by_velocity) const;

  int body_, B_, F_;
  std::shared_ptr<const SurfacePatch> patch_;
  ContactSurface shape_;
  PressureLaw law_;
  Friction friction_;
};

}  // namespace flexura::mbs
