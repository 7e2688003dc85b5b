// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/document.hpp"
#include "mbs/file/elements/element_types.hpp"
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

/// Joints in a mechanism file.
namespace flexura::mbs {
namespace {

template <class J>
std::unique_ptr<Joint> plain(const input::Section*) {
  return std::make_unique<J>();
}

JointType fixed() {
  return {"fixed", "No relative motion.", {"weld", "rigid"}, {}, plain<Fixed>};
}

JointType revolute() {
  return {"revolute",
          "Rotation about the common z axis of the two markers.",
          {"hinge", "pin", "torsion"},
          {},
          plain<Revolute>};
}

JointType prismatic() {
  return {"prismatic",
          "Translation along the common z axis of the two markers.",
          {"slider", "translational"},
          {},
          plain<Prismatic>};
}

JointType cylindrical() {
  return {"cylindrical",
          "Rotation about and translation along the common z axis of the two markers.",
          {},
          {},
          plain<Cylindrical>};
}

JointType screw() {
  return {"screw",
          "Rotation about the common z axis with a translation in proportion.",
          {"helical"},
          {input::quantity("pitch", input::dim::length,
                           "translation in one full turn, negative for a left-hand thread; "
                           "not 0")
               .required()},
          [](const input::Section* s) -> std::unique_ptr<Joint> {
            const double pitch = s ? s->quantity("pitch") : 0.5;
            if (s && pitch == 0.0) s->refuse("pitch", "must not be 0", "use a revolute joint");
            return std::make_unique<Screw>(pitch);
          }};
}

JointType spherical() {
  return {"spherical",
          "Free rotation about the common origin of the two markers.",
          {"ball"},
          {},
          plain<Spherical>};
}

JointType universal() {
  return {"universal",
          "Two rotations about perpendicular axes through the common origin.",
          {"hooke", "cardan"},
          {input::choice("axes", {"al-be", "be-ga", "al-ga"},
                         "first axis fixed in from's marker, second in to's: x and y, y and z, or x and z")
               .or_default("al-be")},
          [](const input::Section* s) -> std::unique_ptr<Joint> {
            const std::string axes = s ? s->text("axes") : "al-be";
            return std::make_unique<Universal>(axes == "be-ga" ? 1 : 0, axes == "al-be" ? 1 : 2);
          }};
}

JointType planar() {
  return {"planar",
          "Motion in the xy plane of the first marker with the z axes parallel.",
          {},
          {},
          plain<Planar>};
}

JointType constant_velocity() {
  return {
      "constant_velocity",
      "Bends in any direction about the common origin but does not twist: both shafts turn at one rate. Also "
      "called homokinetic joint.",
      {"homokinetic"},
      {},
      plain<ConstantVelocity>};
}

JointType point_on_line() {
  return {"point_on_line",
          "The origin of M slides along the z axis of F, M turns freely about it.",
          {},
          {},
          [](const input::Section*) { return point_on_line_joint(); }};
}

JointType point_on_plane() {
  return {"point_on_plane",
          "The origin of M slides in the xy plane of F, M turns freely about it.",
          {},
          {},
          [](const input::Section*) { return point_on_plane_joint(); }};
}

JointType orientation() {
  return {
      "orientation", "M moves anywhere but keeps the orientation of F.", {}, {}, [](const input::Section*) {
        return orientation_joint();
      }};
}

JointType parallel() {
  return {"parallel",
          "M moves anywhere and turns about z; the z axes stay parallel.",
          {},
          {},
          [](const input::Section*) { return parallel_joint(); }};
}

JointType six_dof() {
  return {"six_dof", "All six freedoms: no restraint, a choice of coordinates.", {"free"}, {}, plain<SixDof>};
}

}  // namespace

const std::vector<JointType>& joint_types() {
  static const std::vector<JointType> types = {
      fixed(),     revolute(), prismatic(),         cylindrical(),   screw(),          spherical(),
      universal(), planar(),   constant_velocity(), point_on_line(), point_on_plane(), orientation(),
      parallel(),  six_dof()};
  return types;
}

}  // namespace flexura::mbs
