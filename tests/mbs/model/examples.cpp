// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/model/examples.hpp"

namespace flexura::mbs {
namespace {

// A path on a, given after an element's own keys.
constexpr const char* kRail = R"toml(
path = ["a.rail_1", "a.rail_2", "a.out", "a.rail_3", "a.rail_4"]
%s
[body.a.marker.rail_1]
position = [-0.9, -0.2, 0]
[body.a.marker.rail_2]
position = [-0.3, 0.3, 0.1]
rotation = [0.3, 0.2, 1]
[body.a.marker.rail_3]
position = [0.7, 0.4, -0.2]
[body.a.marker.rail_4]
position = [1.3, 0.2, -0.3]
)toml";

const std::string ends = kEnds, sliding = "joint = \"third\"\n";

}  // namespace

std::string on_rail(const std::string& keys) {
  std::string text = kRail;
  return text.replace(text.find("%s"), 2, keys);
}

const Examples& constraint_examples() {
  static const Examples examples = {
      {"point_on_line", ends},
      {"point_on_plane", ends},
      {"point_on_curve", ends + "points = [[1, 0, 0], [0.8, 0.9, 0.3], [-0.2, 1.4, 0.5], [-1.2, 0.3, 0.1], "
                                "[-0.5, -1, -0.4], [0.6, -0.8, -0.2]]\nclosed = true"},
      {"point_on_path", on_rail("to = \"b.in\"\norientation = \"fixed\"")},
      // On the joint between a.out and b.in some turns of these keep their angle to the other's z axis.
      {"orientation", "from = \"ground.track\"\nto = \"b.in\""},
      {"parallel", ends},
      {"perpendicular", "from = \"ground.track\"\nto = \"b.in\""},
      {"distance", ends + "length = \"700 mm\""},
      {"coupler",
       "joints = [\"second.angle\", \"second.position\", \"third\"]\nfactors = [1, 2, 0.5]\noffset = "
       "\"sin(2*t)\""},
      {"expression",
       "value = \"dip*third.position + 0.3*sin(turn)*far^2 + 0.1*second.angle*z*t\"\nunit = \"m\"\n"
       "[measure.far]\ntype = \"distance\"\n" +
           ends + "[measure.turn]\ntype = \"rotation_angle\"\nsequence = \"zxy\"\nangle = 2\n" + ends +
           "[measure.z]\ntype = \"axis\"\ndirection = [1, 2, 2]\n" + ends +
           "[measure.angle]\ntype = \"angle\"\n" + ends +
           "[measure.dip]\ntype = \"expression\"\nvalue = \"z^2 + far + angle*t\""},
      {"gear", "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nteeth_1 = 17\nteeth_2 = 40"},
      {"rack_and_pinion", "rack = \"third\"\npinion = \"second.angle\"\nradius = \"30 mm\""},
      {"rolling_disc", "from = \"ground.track\"\nto = \"b.in\"\nradius = \"300 mm\""}};
  return examples;
}

const Examples& force_examples() {
  static const Examples examples = {
      {"spring_damper", ends + "stiffness = \"30 N/m\"\ndamping = \"4 N*s/m\"\nfree_length = \"200 mm\""},
      {"force",
       "marker = \"b.in\"\naxes = \"a.out\"\nreaction = \"a.out\"\nx = \"3*third.position^2 + t\"\ny = "
       "\"sin(third.speed)\""},
      {"moving_load", on_rail("axes = \"b.in\"\nplace = \"1 + 0.5*sin(third.position)\"\nx = "
                              "\"3*third.position^2 + t\"\nz = \"sin(third.speed)\"")},
      {"torque", "marker = \"b.in\"\nz = \"2*third.position\"\nx = 3"},
      {"joint_force", sliding + "value = \"-3*third.position^3 + second.speed\""},
      {"joint_spring_damper", sliding + "stiffness = 20\ndamping = 3\nrest = 0.1"},
      {"joint_friction",
       sliding + "coulomb = 3\nstatic = 4\nstribeck_speed = 0.8\ntransition_speed = 0.5\nviscous = 0.2"},
      {"bushing", ends + "stiffness = [30, 40, 50]\nrotational_stiffness = [3, 4, 5]\ndamping = [1, 2, 3]\n"
                         "rotational_damping = [0.1, 0.2, 0.3]"},
      {"contact", ends +
                      "radius = 3\nsurface = \"sphere\"\nsurface_radius = 4\nstiffness = 20\nexponent = 1.5\n"
                      "damping = 2\nfriction = 0.3\ntransition_speed = 0.5"},
      {"bump_stop", sliding + "upper = -5\nstiffness = 10\nexponent = 1.5\ndamping = 1"},
      {"gear_mesh",
       "joint_1 = \"second.angle\"\njoint_2 = \"third\"\nradius_1 = 0.3\nradius_2 = 0.5\nstiffness = 50\n"
       "teeth_1 = 3\nripple = 0.2"},
      {"stick_slip", sliding + "coulomb = 3\nstatic = 4\nstribeck_speed = 0.8\nstick_stiffness = 20"},
      {"line_force", ends + "value = \"-30*(x.length - 0.2) - 4*x.rate + third.position\""},
      {"bearing",
       ends + "stiffness_matrix = [[30, 5, 0, 1, 2], [-5, 40, 0, 0, 3], [0, 0, 20, 0, 0], [1, 0, 0, 4, 1], "
              "[2, 3, 0, 1, 5]]\ndamping_matrix = [[3, 1, 0, 0, 0], [-1, 3, 0, 0, 0], [0, 0, 2, 0, 0], "
              "[0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]"},
      {"rolling_bearing", ends +
                              "elements = 9\ndiameter = 1\npitch_diameter = 5\ncontact_angle = \"30 deg\"\n"
                              "groove_inner = 0.8\ngroove_outer = 0.7\nyoungs_modulus = 30\ndamping = 2\n"
                              "tilt_damping = 1"},
      {"journal_bearing", ends + "radius = 4\nlength = 1\nclearance = 3\nviscosity = 100"},
      // Profile shifts that let the teeth overlap at any distance of these markers.
      {"involute_mesh",
       ends + "module = 0.0258\nteeth_1 = 10\nteeth_2 = 14\nwidth = 0.05\nhelix_angle = \"15 deg\"\n"
              "shift_1 = 26\nshift_2 = 26\ntooth_stiffness = 200\nharmonics = 2\ndamping = 1"},
      {"actuator", ends + "command = \"3*third.position\"\ntime_constant = 0.1"}};
  return examples;
}

}  // namespace flexura::mbs
