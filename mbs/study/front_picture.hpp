// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace flexura::study {

struct PicturePoint {
  double cost = 0.0, error = 0.0;
  bool on_front = false;
  std::string label;
};

struct FrontPicture {
  std::string title, cost_name;
  std::vector<PicturePoint> points;
  double uncertainty = 0.0;  ///< of the reference, relative
};

/// The trade as a picture that stands alone (SVG, for documentation): error over wall time, both logarithmic,
/// each choice a dot, the front a line through its dots with their names, the reference's uncertainty a grey
/// band from below.  Points whose error is zero or not finite are left out.
std::string front_picture(const FrontPicture& picture);

}  // namespace flexura::study
