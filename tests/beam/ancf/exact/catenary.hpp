// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Elastic catenary between two supports at equal height (H. M. Irvine, Cable Structures, 1981, ch. 1):
/// unstretched length L_0, weight W, stiffness EA, horizontal tension H, at arc length s from the left
/// support
///
///     x = H s/EA + H L_0/W [asinh(W/2H) - asinh((W/2 - W s/L_0)/H)]
///     y = -W s/EA (1/2 - s/(2 L_0)) - H L_0/W [sqrt(1 + (W/2H)^2) - sqrt(1 + ((W/2 - W s/L_0)/H)^2)]
namespace flexura::beam::exact {

class Catenary {
 public:
  /// Solves H for the span.
  Catenary(double L_0, double W, double EA, double span);
  double H() const { return H_; }
  double x(double s) const;
  double y(double s) const;

 private:
  double L_0_, W_, EA_, H_ = 0.0;
};

}  // namespace flexura::beam::exact
