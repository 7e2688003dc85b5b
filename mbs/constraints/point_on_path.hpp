// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mbs/constraints/constraint.hpp"
#include "mbs/formulas/expression.hpp"
#include "mbs/kinematics/body_path.hpp"
#include "mbs/kinematics/picture.hpp"

namespace flexura::mbs {

/// The point P of M travels along a line r(s) of a body that deforms (body_path.hpp): a slide whose axis bends.
///
/// With tau = r'(s), d = P - r(s) and e_side, e_up the path's directions at s, which the markers carry,
///
///     0 = e_side . d,   0 = e_up . d                                   free:   a ball on a rail
///     0 = tau . y_M,    0 = tau . z_M                                  along:  the x axis of M keeps along the path
///     0 = e_side . z_M                                                 fixed:  nor does M turn about it
///
/// The place s is a function of positions, the foot of P on the line, 0 = tau . d, or given by a formula of time or of
/// controls, for which one row more, "along", holds d.
///
/// Every row, and that of the foot, is h = a . b of two sums of vectors y_j that markers carry, a = sum a_j(s) y_j and
/// b alike.  With h_s, h_t the derivatives by s at the vectors' places and by time at a fixed s,
///
///     h'  = h_t + h_s s',     h'' = h_tt + 2 h_st s' + h_ss s'^2 + h_s s''
///
/// where h_tt holds the accelerations of the y_j.  Of a foot s' = -f_t / f_s, so that mu = -h_s / f_s takes s' and s''
/// out: rows h + mu f have G and gamma at a fixed s, with all convective terms (h_st: Coriolis' on the moving line,
/// h_ss: the centripetal one on the bent line).
enum class PathOrientation { free, along, fixed };

class PointOnPath final : public Constraint, public HasPicture {
 public:
  struct Law {
    PathOrientation orientation = PathOrientation::free;
    Prescribed place = {};  ///< s; without it free
    bool goes_on = false;   ///< straight beyond the ends, where a run else stops
    double near =
        std::numeric_limits<double>::quiet_NaN();  ///< where s starts, of a line that comes near itself
  };
  PointOnPath(std::string name, std::shared_ptr<const BodyPath> path, int marker_M, Law law);

  int n_rows() const override;
  std::string row_name(int i) const override;
  bool reads_time(int) const override { return law_.place.moves(); }
  int n_followed() const override { return law_.place.follows() ? 1 : 0; }
  Following following(int) const override { return {law_.place.formula().get(), DriveLevel::position}; }
  void by_followed(const Kinematics& kin, int i, double* g_y, double* h_y, double* h_y_dot) const override;
  std::vector<int> markers() const override;
  const BodyPath* drawn_path() const override { return path_.get(); }
  void position(const Kinematics& kin, double* g) const override;
  void velocity(const Kinematics& kin, double* g_dot) const override;
  void acceleration(const Kinematics& kin, double* g_ddot) const override;
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override;
  /// What a place that follows signals does to the loads is differenced.
  bool has_derivatives() const override { return !law_.place.follows(); }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override;
  void differentiate_contact(const Kinematics& kin, double a, Derivatives& d) const override;
  void rate(const Kinematics& kin, double* g_t) const override;
  bool has_contact() const override { return !law_.place; }
  double contact_residual(const Kinematics& kin, double a) const override;
  double start_contact(const Kinematics& kin) const override;
  std::vector<OutputInfo> outputs() const override;
  void evaluate_outputs(const Kinematics& kin, const double* x, double* values) const override;
  double path_length() const override {
    return law_.goes_on ? std::numeric_limits<double>::infinity() : path_->length();
  }

 private:
  struct Instant;
  Jet place(const Kinematics& kin) const;

  std::shared_ptr<const BodyPath> path_;
  int marker_M_;
  Law law_;
};

}  // namespace flexura::mbs
