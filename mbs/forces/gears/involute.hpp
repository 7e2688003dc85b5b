// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace flexura::mbs {

/// Two external cylindrical wheels with involute teeth [m], [rad] (ISO 21771-1:2024).
struct InvoluteData {
  double module = 0.0;                  ///< normal, m_n
  int teeth_1 = 0, teeth_2 = 0;         ///< z
  double pressure_angle = 0.0;          ///< normal, alpha_n
  double helix_angle = 0.0;             ///< beta of wheel 1; positive: right-handed
  double shift_1 = 0.0, shift_2 = 0.0;  ///< profile shift over m_n
  double addendum = 1.0;                ///< over m_n
  double width = 0.0;                   ///< common face width b
  double backlash =
      0.0;  ///< along the line of action, at the centre distance that has none by the shifts alone
  double tooth_stiffness = 0.0;  ///< c' [N/m per m of width]; 0: of ISO 6336
  int harmonics = 5;             ///< of the stiffness, as teeth come and go
};

/// What follows of them.  Lengths and stiffnesses in the transverse plane, along the line of action.
///
///     r_b = m_t z cos(alpha_t) / 2,  inv(alpha_w) = inv(alpha_t) + 2 tan(alpha_n) (x_1 + x_2) / (z_1 + z_2),
///     a = (r_b1 + r_b2) / cos(alpha_w),  eps_alpha p_bt = sqrt(r_a1^2 - r_b1^2) + sqrt(r_a2^2 - r_b2^2) - a sin(alpha_w)
///
/// Stiffness after ISO 6336-1:2019, 9.3 (method B, steel, solid wheels, standard basic rack):
///
///     c' = 0.8 cos(beta) / q',  c_gamma = c' (0.75 eps_alpha + 0.25) b,   in the mean
///
/// with q' a polynomial of virtual teeth and shifts.  Over the path of contact each pair of teeth is as stiff as any other
/// while it touches, for eps_alpha pitches; its beginning runs across the width over eps_beta pitches.  The sum of pairs is
/// a Fourier series of the position y (from the pitch point, of the flank that touches), the first `harmonics` of it:
///
///     k(y) = c_gamma (1 + sum 2 sin(n pi eps_alpha) / (n pi eps_alpha) sinc(n eps_beta) cos(2 pi n (y - y_0) / p_bt))
class Involute {
 public:
  /// Throws std::invalid_argument where such wheels cannot be.
  explicit Involute(const InvoluteData& data);

  double base_1, base_2;   ///< r_b
  double pitch;            ///< p_bt
  double tan_base_helix;   ///< tan(beta_b), with the sign of the helix
  double working_angle;    ///< alpha_w
  double centre_distance;  ///< a, without backlash
  double contact_ratio, overlap_ratio;
  double half_thickness_1;  ///< of a tooth of wheel 1 at its working pitch circle, an angle
  double tooth_stiffness;   ///< c'
  double mean_stiffness;    ///< c_gamma [N/m]
  double reach;             ///< r_a1 + r_a2: from this distance of the axes on no teeth meet
  double transverse_angle;  ///< alpha_t

  /// Half of the play along the line of action at a distance of the axes, and its derivatives.  Throws std::runtime_error
  /// where the base circles overlap and where the tips do not.
  struct Play {
    double half, first, second;
  };
  Play play(double distance) const;
  /// k(y) / c_gamma and its derivatives.
  struct Ripple {
    double value, first, second;
  };
  Ripple ripple(double y) const;

 private:
  double half_backlash_, middle_;  ///< y_0, of the path of contact
  std::vector<double> harmonics_;
};

}  // namespace flexura::mbs
