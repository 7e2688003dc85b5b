// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/shell_section.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <vector>

#include "reduce/elements/shell_cell.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Layer {
  Matrix3d Q;
  Matrix2d G;
  double from, to;  // heights
};

double factor_of(const Material& material, double t) {
  double whole = 0.0;
  for (const Ply& ply : material.plies) whole += ply.thickness;
  return t / whole;
}

std::vector<Layer> layers_of(const Material& material, double t, const Matrix3d& R) {
  const double factor = factor_of(material, t);
  std::vector<Layer> layers;
  double z = -0.5 * t;
  for (const Ply& ply : material.plies) {
    const shell::PlaneStress plane = shell::plane_stress(ply.D, R);
    layers.push_back({plane.D, 6.0 / 5.0 * plane.shear, z, z + factor * ply.thickness});
    z = layers.back().to;
  }
  return layers;
}

void add_stiffness(const std::vector<Layer>& layers, ShellSection& out) {
  out.A.setZero(), out.B.setZero(), out.D.setZero();
  double size = 0.0;
  for (const Layer& layer : layers) {
    const double a = layer.from, b = layer.to;
    out.A += (b - a) * layer.Q;
    out.B += 0.5 * (b * b - a * a) * layer.Q;
    out.D += (b * b * b - a * a * a) / 3.0 * layer.Q;
    size += 0.5 * std::abs(b * b - a * a) * layer.Q.cwiseAbs().maxCoeff();
  }
  out.coupled = out.B.cwiseAbs().maxCoeff() > 1e-13 * size;
  if (!out.coupled) out.B.setZero();
}

// S in the axes of the layers.
Matrix2d shear_of(const std::vector<Layer>& layers) {
  ShellSection of;
  add_stiffness(layers, of);
  Eigen::Matrix<double, 6, 6> whole;
  whole << of.A, of.B, of.B, of.D;
  const Eigen::Matrix<double, 6, 6> inverse = whole.inverse();
  constexpr double kPlace[3] = {-0.7745966692414834, 0.0, 0.7745966692414834},
                   kWeight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};  // tau^2 is of degree four
  Matrix2d flexibility = Matrix2d::Zero();
  Vector2d below = Vector2d::Zero();  // tau at the lower side of the layer
  for (const Layer& layer : layers) {
    Vector2d constant, linear;  // of the stress for a moment of 1 about the other axis
    for (Eigen::Index d = 0; d < 2; ++d) {
      constant(d) = layer.Q.row(d).dot(inverse.block<3, 1>(0, 3 + d));
      linear(d) = layer.Q.row(d).dot(inverse.block<3, 1>(3, 3 + d));
    }
    const auto tau = [&](double z) {
      return Vector2d(below - (z - layer.from) * constant - 0.5 * (z * z - layer.from * layer.from) * linear);
    };
    const Matrix2d soft = layer.G.inverse();
    for (int g = 0; g < 3; ++g) {
      const double half = 0.5 * (layer.to - layer.from);
      const Vector2d at = tau(layer.from + half * (1.0 + kPlace[g]));
      flexibility += half * kWeight[g] * at.asDiagonal() * soft * at.asDiagonal();
    }
    below = tau(layer.to);
  }
  return flexibility.inverse();
}

}  // namespace

ShellSection shell_section(const Material& material, double t, const Matrix3d& R) {
  ShellSection out;
  if (material.plies.empty()) {
    const shell::PlaneStress plane = shell::plane_stress(material.D, R);
    out.A = t * plane.D;
    out.B.setZero();
    out.D = t * t * t / 12.0 * plane.D;
    out.S = t * plane.shear;
    out.top = out.bottom = plane.D;
    return out;
  }
  const std::vector<Layer> layers = layers_of(material, t, R);
  add_stiffness(layers, out);
  out.bottom = layers.front().Q, out.top = layers.back().Q;
  const Vector3d normal = R.col(2);
  Vector3d axis = material.ply_axis - normal * normal.dot(material.ply_axis);
  if (!(axis.norm() > 1e-6)) axis = R.col(0);
  Matrix3d own;
  own << axis.normalized(), normal.cross(axis.normalized()), normal;
  const Matrix2d turn = (R.transpose() * own).topLeftCorner<2, 2>();
  out.S = turn * shear_of(layers_of(material, t, own)) * turn.transpose();
  return out;
}

ShellMass shell_mass_per_area(const Material& material, double t) {
  if (material.plies.empty()) return {material.density * t, 0.0, material.density * t * t * t / 12.0};
  ShellMass out;
  const double factor = factor_of(material, t);
  double a = -0.5 * t;
  for (const Ply& ply : material.plies) {
    const double b = a + factor * ply.thickness;
    out.mass += ply.density * (b - a);
    out.first += 0.5 * ply.density * (b * b - a * a);
    out.second += ply.density * (b * b * b - a * a * a) / 3.0;
    a = b;
  }
  return out;
}

}  // namespace flexura::reduce
