// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "beam/ancf/problem.hpp"

/// One element of each kind, with a curved stress-free shape where the kind allows one, all damped.
namespace flexura::beam::ancf {

struct Sample {
  std::string name;
  std::unique_ptr<Element> element;
  Eigen::VectorXd rest;  ///< a configuration without strain
};

inline Problem held(const AncfBody& body, std::vector<int> fixed) {
  Problem problem;
  problem.body = &body;
  problem.fixed = std::move(fixed);
  return problem;
}

/// Cantilever along x of a line: the tangent keeps its direction, not its length (the root may stretch).
inline std::vector<int> clamp_of_line(int dim) {
  std::vector<int> fixed;
  for (int c = 0; c < dim; ++c) fixed.push_back(c);
  for (int c = 1; c < dim; ++c) fixed.push_back(dim + c);
  return fixed;
}

/// Cantilever of a beam: position and section; r_x stays free for stretch and shear.
inline const std::vector<int> kBeamClamp = {0, 1, 2, 6, 7, 8, 9, 10, 11};

// A quarter of a circle of radius 1 in the x-y plane.
inline ReferenceCurve quarter_circle(int n_elements) {
  ReferenceCurve curve;
  curve.s = Eigen::VectorXd::LinSpaced(n_elements + 1, 0.0, M_PI / 2);
  curve.position.setZero(3, n_elements + 1);
  curve.tangent = curve.y_axis = curve.position;
  for (int i = 0; i <= n_elements; ++i) {
    const double s = curve.s[i];
    curve.position.col(i) = Eigen::Vector3d(std::sin(s), 1 - std::cos(s), 0);
    curve.tangent.col(i) = Eigen::Vector3d(std::cos(s), std::sin(s), 0);
    curve.y_axis.col(i) = Eigen::Vector3d(-std::sin(s), std::cos(s), 0);
  }
  return curve;
}

inline Eigen::VectorXd line_coordinates(int dim, double l, double turn) {
  // Two nodes a chord of about l apart, tangents turned by -turn and +turn from it.
  Eigen::VectorXd e = Eigen::VectorXd::Zero(4 * dim);
  e[dim] = std::cos(turn);
  e[dim + 1] = -std::sin(turn);
  e[2 * dim] = l * (turn == 0.0 ? 1.0 : std::sin(turn) / turn);
  e[3 * dim] = std::cos(turn);
  e[3 * dim + 1] = std::sin(turn);
  return e;
}

inline Eigen::VectorXd beam_coordinates(double l, double turn) {
  Eigen::VectorXd e = Eigen::VectorXd::Zero(24);
  const Eigen::VectorXd line = line_coordinates(3, l, turn);
  for (int node = 0; node < 2; ++node) {
    e.segment(12 * node, 6) = line.segment(6 * node, 6);
    const Eigen::Vector3d t = line.segment(6 * node + 3, 3);
    e.segment(12 * node + 6, 3) = Eigen::Vector3d(-t[1], t[0], 0);
    e[12 * node + 11] = 1.0;
  }
  return e;
}

inline std::vector<Sample> all_elements() {
  // Stiffnesses of the same order, so that no term hides behind another.
  const LineSection line{
      .EA = 50.0, .EI = 3.0, .mass_per_length = 2.0, .damping_time_axial = 0.1, .damping_time_bending = 0.2};
  BeamSection beam = uncoupled_section(50.0, 20.0, 15.0, 2.0, 3.0, 4.0, 2.0, 0.05, 0.07);
  beam.C(0, 4) = beam.C(4, 0) = 1.5;
  beam.C(1, 3) = beam.C(3, 1) = -0.8;
  beam.m_y = 0.02;
  beam.m_z = -0.03;
  beam.m_yz = 0.01;
  beam.damping_time = 0.15;
  const SolidSection solid{.E = 100.0,
                           .nu = 0.3,
                           .rho = 2.0,
                           .width = 0.3,
                           .height = 0.4,
                           .k_y = 0.8,
                           .k_z = 0.9,
                           .damping_time = 0.1};
  const double l = 0.8;
  std::vector<Sample> samples;
  const auto planar = line_coordinates(2, l, 0.3), cable = line_coordinates(3, l, 0.0);
  const auto curved = beam_coordinates(l, 0.3), straight = beam_coordinates(l, 0.0);
  samples.push_back({"planar line", make_planar_line(line, l, planar.data()), planar});
  samples.push_back({"spatial line", make_spatial_line(line, l), cable});
  samples.push_back({"spatial beam", make_spatial_beam(beam, l, curved.data()), curved});
  samples.push_back({"solid beam", make_solid_beam(solid, l, straight.data()), straight});
  return samples;
}

}  // namespace flexura::beam::ancf
