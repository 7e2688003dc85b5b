// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <tuple>
#include <type_traits>

#include "beam/ancf/element/ancf_element.hpp"
#include "beam/ancf/element/axis_strain.hpp"
#include "beam/ancf/element/hermite.hpp"
#include "beam/ancf/element/point_set.hpp"

/// What the makers of ANCF elements share.  Each maker has a .cpp of its own: the templates below take long
/// to compile.
namespace flexura::beam::ancf {

inline void require_positive(const char* what, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} is {:g}, but it must be positive.", what, value));
}

inline void require_not_negative(const char* what, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} is {:g}, but it must not be negative.", what, value));
}

using ResultantVector = Eigen::Matrix<double, 6, 1>;
inline ResultantVector six(const PlanarStrain::Z& s) {
  return ResultantVector{{s[0], 0, 0, 0, 0, s[1]}};
}
inline ResultantVector six(const CableStrain::Z& s) {
  return ResultantVector{{s[0], 0, 0, s[1], s[2], s[3]}};
}
inline ResultantVector six(const AxisStrain::Z& s) {
  return s;
}

/// Sum of several point sets over the same coordinates.
template <class... Sets>
class ElementOf final : public Element {
 public:
  ElementOf(int dim, int vectors, double length, Sets... sets)
      : Element(dim, vectors, length), sets_(std::move(sets)...) {}

  void set_inertia(Eigen::MatrixXd mass, Eigen::VectorXd weight) {
    mass_ = std::move(mass);
    weight_ = std::move(weight);
  }

  int resultant_points() const override { return kHasAxis ? std::get<0>(sets_).size() : 0; }
  ResultantVector resultants(const double* e, const double* e_dot, int k) const override {
    if (k < 0 || k >= resultant_points())
      throw std::invalid_argument(
          fmt::format("section forces asked for at point {} of an element that has {} such points; a solid "
                      "beam has none.",
                      k, resultant_points()));
    return six(std::get<0>(sets_).stress(k, e, e_dot));
  }

  double strain_energy(const double* e) const override {
    return std::apply([&](const Sets&... set) { return (set.energy(e) + ...); }, sets_);
  }
  double dissipation(const double* e, const double* e_dot) const override {
    return std::apply([&](const Sets&... set) { return (set.dissipation(e, e_dot) + ...); }, sets_);
  }
  void add_force(const double* e, const double* e_dot, const double* e_before, double* f, double* K,
                 double* D) const override {
    std::apply([&](const Sets&... set) { (set.add_force(e, e_dot, e_before, f, K, D), ...); }, sets_);
  }

 private:
  using Measure = typename std::tuple_element_t<0, std::tuple<Sets...>>::Measure;
  static constexpr bool kHasAxis = !std::is_same_v<Measure, GreenStrain>;

  std::tuple<Sets...> sets_;
};

/// The consistent mass is of degree 6 in xi: four Gauss points.
inline constexpr int kMassPoints = 4;

/// Shape rows of a fully parametrised beam over (r, r_x, r_y, r_z)_A, (...)_B.
using BeamRow = Eigen::Matrix<double, 1, 8>;
inline BeamRow axis_row(const Shapes& S) {
  return BeamRow{{S[0], S[1], 0, 0, S[2], S[3], 0, 0}};
}
inline BeamRow y_row(double at_A, double at_B) {
  return BeamRow{{0, 0, at_A, 0, 0, 0, at_B, 0}};
}
inline BeamRow z_row(double at_A, double at_B) {
  return BeamRow{{0, 0, 0, at_A, 0, 0, 0, at_B}};
}

/// Consistent mass (8 x 8, compact) and weight (8) of a fully parametrised beam of length l.
void beam_inertia(const BeamSection& section, double l, Eigen::MatrixXd& mass, Eigen::VectorXd& weight);

}  // namespace flexura::beam::ancf
