// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/properties/parts.hpp"

/// Eigenvalues of a mechanism of one body beside those of the quadratic problem s^2 M + s D + K.
namespace flexura::properties {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;
using superelement::Superelement;

struct JointCase {
  const char* type;
  std::vector<int> locked;  ///< of translations 0-2 and rotations 3-5 in the axes of its frame, z the joint's
  double pitch = 0.0;       ///< of a screw: z follows the turn about it
};
inline const JointCase kJoints[] = {{"fixed", {0, 1, 2, 3, 4, 5}},
                                    {"revolute", {0, 1, 2, 3, 4}},
                                    {"prismatic", {0, 1, 3, 4, 5}},
                                    {"cylindrical", {0, 1, 3, 4}},
                                    {"spherical", {0, 1, 2}},
                                    {"planar", {2, 3, 4}},
                                    {"six_dof", {}}};

// (u, theta) of an interface in the axes of E.
inline MatrixXd motion_in(const Superelement& se, const superelement::Interface& i, const Matrix3d& E) {
  MatrixXd rows = MatrixXd::Zero(6, se.n());
  for (std::size_t k = 0; k < i.directions.size(); ++k)
    rows(static_cast<int>(i.directions[k]), i.first_dof + static_cast<int>(k)) = 1.0;
  MatrixXd out(6, se.n());
  out << E.transpose() * rows.topRows(3), E.transpose() * rows.bottomRows(3);
  return out;
}

// Those of x' = A x with an imaginary part from 0 on.
template <class Values>
std::vector<std::complex<double>> upper(const Values& values) {
  std::vector<std::complex<double>> out;
  for (const auto& value : values)
    if (value.imag() >= 0.0)
      out.emplace_back(static_cast<double>(value.real()), static_cast<double>(value.imag()));
  return out;
}

// K, D, M where G u = 0: eigenvalues s of s^2 M + s D + K, in extended precision: double leaves 1e-16 of the largest s^2 in
// every other, which is 1e-6 of the lowest.
inline std::vector<std::complex<double>> eigenvalues(const MatrixXd& K_se, const MatrixXd& D,
                                                     const MatrixXd& M_se, const MatrixXd& G) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix N = Matrix::Identity(K_se.rows(), K_se.rows());
  if (G.rows() > 0) N = G.cast<long double>().fullPivLu().kernel();
  const auto reduced = [&](const MatrixXd& X) -> Matrix { return N.transpose() * X.cast<long double>() * N; };
  const Matrix M = reduced(M_se), K = reduced(K_se);
  const Index n = N.cols();
  const Eigen::LLT<Matrix> llt(M);
  const Matrix squares = llt.solve(K);
  const long double rate = std::sqrt(squares.norm());  // displacements and speeds of one size
  Matrix A = Matrix::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).diagonal().setConstant(rate);
  A.bottomLeftCorner(n, n) = -squares / rate;
  A.bottomRightCorner(n, n) = -llt.solve(reduced(D));
  return upper(Eigen::EigenSolver<Matrix>(A, false).eigenvalues());
}
inline std::vector<std::complex<double>> right(const Superelement& se, const MatrixXd& D, const MatrixXd& G) {
  return eigenvalues(se.K_se, D, se.M_se, G);
}

struct Case {
  Superelement se;
  const JointCase* joint = nullptr;
  MatrixXd G;  // of the joint
  std::string text;
  std::vector<std::complex<double>> found;
};

// A body on a joint from the ground to one of its interfaces, or from there to the ground.
inline Case make_case(Chance& chance, const test::Folder& folder, Superelement se, const std::string& keys,
                      const JointCase& joint, bool to_ground = false) {
  Case out;
  const superelement::Interface& at =
      se.interfaces[static_cast<std::size_t>(chance.below(static_cast<int>(se.interfaces.size())))];
  const Matrix3d E = chance.rotation();
  const auto list = [](const Vector3d& v) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
  };
  const std::string axes = fmt::format("axis = {}\nx_axis = {}\n", list(E.col(2)), list(E.col(0)));
  out.text = fmt::format(
      "gravity = [0, 0, 0]\n[ground.marker.o]\nposition = {}\n{}[body.b]\nsuperelement = "
      "\"part.se.h5\"\n{}[body.b.marker.o]\non = "
      "\"{}\"\n{}[joint.j]\ntype = \"{}\"\nfrom = \"{}\"\nto = \"{}\"\n",
      list(at.p_BoN_B), axes, keys, at.name, axes, joint.type, to_ground ? "b.o" : "ground.o",
      to_ground ? "ground.o" : "b.o");
  if (joint.pitch != 0.0) out.text += fmt::format("pitch = {:.17g}\n", joint.pitch);
  out.joint = &joint;
  const MatrixXd motion = motion_in(se, at, E);
  out.G = motion(joint.locked, Eigen::all);
  if (joint.pitch != 0.0) {
    out.G.conservativeResize(out.G.rows() + 1, Eigen::NoChange);
    out.G.bottomRows<1>() = motion.row(2) - joint.pitch / (2.0 * std::numbers::pi) * motion.row(5);
  }
  superelement::write(folder / "part.se.h5", se);
  const mbs::PreparedMechanism p = mbs::prepare(folder.write("m.toml", out.text));
  const mbs::LinearSystem system = mbs::linearise(*p.mechanism, p.state);
  for (const mbs::NaturalMode& mode : mbs::natural_modes(system)) out.found.push_back(mode.eigenvalue);
  out.se = std::move(se);
  return out;
}

// Another superelement whose entries round to the same last digits.
inline Superelement rounded(Superelement se) {
  Chance chance(1);
  constexpr double kHalfDigit = 1.1e-16;
  for (MatrixXd* X : {&se.K_se, &se.M_se, &se.D_se})
    for (Index i = 0; i < X->rows(); ++i)
      for (Index j = 0; j <= i; ++j)
        (*X)(j, i) = (*X)(i, j) = (*X)(i, j) * (1.0 + kHalfDigit * (chance.below(2) == 0 ? -1.0 : 1.0));
  return se;
}

using Values = std::vector<std::complex<double>>;

inline double distance(const Values& values, const std::complex<double>& s) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& value : values) least = std::min(least, std::abs(value - s));
  return least;
}

// Each of the right values of `se`, but those that are zero, has one of `found`.
template <class Right>
void expect_same(Values found, const Superelement& se, const Right& right_of) {
  const Values right = right_of(se);
  Values beside;
  double largest = 0.0;
  for (const auto& s : right) largest = std::max(largest, std::abs(s));
  for (const auto& s : right) {
    // A double zero of rigid motion is known to the root of round-off; vibrations to round-off of the largest eigenvalue's square.
    if (std::abs(s) < 1e-6 * largest) continue;
    const auto nearest =
        std::ranges::min_element(found, {}, [&](const auto& other) { return std::abs(other - s); });
    ASSERT_NE(nearest, found.end());
    double tolerance = 1e-7 * std::abs(s) + 1e-13 * largest * largest / std::abs(s);
    if (std::abs(*nearest - s) > tolerance) {
      // Where M_se is nearly singular its last digits decide on more; some operations each leave that much.
      if (beside.empty()) beside = right_of(rounded(se));
      tolerance += 10.0 * distance(beside, s);
    }
    EXPECT_LT(std::abs(*nearest - s), tolerance)
        << fmt::format("{} {:+}i is found as {} {:+}i", s.real(), s.imag(), nearest->real(), nearest->imag());
    found.erase(nearest);
  }
}

}  // namespace flexura::properties
