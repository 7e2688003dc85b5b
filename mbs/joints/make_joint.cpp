// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>

#include "mbs/joints/constant_velocity.hpp"
#include "mbs/joints/cylindrical.hpp"
#include "mbs/joints/fixed.hpp"
#include "mbs/joints/partial.hpp"
#include "mbs/joints/planar.hpp"
#include "mbs/joints/prismatic.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/joints/screw.hpp"
#include "mbs/joints/six_dof.hpp"
#include "mbs/joints/spherical.hpp"
#include "mbs/joints/universal.hpp"

namespace flexura::mbs {
namespace {

template <class J>
std::unique_ptr<Joint> plain() {
  return std::make_unique<J>();
}

// One line for each; what the mechanism file says of them stands in mbs/file/elements/joints.cpp.
struct Maker {
  const char* name;
  std::unique_ptr<Joint> (*make)();
};
constexpr Maker kMakers[] = {
    {"fixed", plain<Fixed>},
    {"revolute", plain<Revolute>},
    {"prismatic", plain<Prismatic>},
    {"cylindrical", plain<Cylindrical>},
    {"screw", plain<Screw>},
    {"spherical", plain<Spherical>},
    {"universal", plain<Universal>},
    {"planar", plain<Planar>},
    {"constant_velocity", plain<ConstantVelocity>},
    {"point_on_line", point_on_line_joint},
    {"point_on_plane", point_on_plane_joint},
    {"orientation", orientation_joint},
    {"parallel", parallel_joint},
    {"six_dof", plain<SixDof>},
};

}  // namespace

std::unique_ptr<Joint> make_joint(const std::string& type) {
  for (const Maker& maker : kMakers)
    if (type == maker.name) return maker.make();
  throw std::invalid_argument("there is no joint type \"" + type + "\"");
}

}  // namespace flexura::mbs
