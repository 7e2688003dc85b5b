// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/solver.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace flexura::beam {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Matrix6x18 = Eigen::Matrix<double, 6, 18>;
using MatrixX6 = Eigen::Matrix<double, Eigen::Dynamic, 6>;

struct QuadraturePoint {
  double r, s, weight;
};

// Seven points, exact to degree 5 (J. Radon, Monatsh. Math. Phys. 52 (1948)): integrands of straight-sided
// triangles have degree 4.
const std::array<QuadraturePoint, 7>& quadrature() {
  static const std::array<QuadraturePoint, 7> points = [] {
    const double root = std::sqrt(15.0), a = (6 - root) / 21, b = (6 + root) / 21;
    const double w_a = (155 - root) / 2400, w_b = (155 + root) / 2400;
    return std::array<QuadraturePoint, 7>{{{1.0 / 3, 1.0 / 3, 9.0 / 80},
                                           {a, a, w_a},
                                           {1 - 2 * a, a, w_a},
                                           {a, 1 - 2 * a, w_a},
                                           {b, b, w_b},
                                           {1 - 2 * b, b, w_b},
                                           {b, 1 - 2 * b, w_b}}};
  }();
  return points;
}

// Where a triangle is looked at: shape functions, their derivatives in y and z, the place, the area measure.
struct Place {
  Eigen::Matrix<double, 6, 1> N;
  Eigen::Matrix<double, 6, 2> dN;
  double y, z, det;
};

Place place_in(const SectionMesh& mesh, int cell, double r, double s) {
  const double t = 1 - r - s;
  Place p;
  p.N << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t;
  Eigen::Matrix<double, 6, 2> local;
  local << 1 - 4 * t, 1 - 4 * t, 4 * r - 1, 0, 0, 4 * s - 1, 4 * (t - r), -4 * r, 4 * s, 4 * r, -4 * s,
      4 * (t - s);
  Eigen::Matrix<double, 6, 2> X;
  for (int k = 0; k < 6; ++k) X.row(k) = mesh.points.row(mesh.triangles(cell, k));
  const Eigen::Matrix2d J = local.transpose() * X;
  p.det = J.determinant();
  p.dN = local * J.inverse().transpose();
  p.y = p.N.dot(X.col(0));
  p.z = p.N.dot(X.col(1));
  return p;
}

struct Operators {
  Matrix6x18 B = Matrix6x18::Zero(), S = Matrix6x18::Zero();
  Matrix6d Phi = Matrix6d::Zero();
};

Operators operators_at(const Place& p) {
  Operators o;
  for (int k = 0; k < 6; ++k) {
    const double dy = p.dN(k, 0), dz = p.dN(k, 1), n = p.N(k);
    const int c = 3 * k;
    o.B(1, c + 1) = dy;  // yy
    o.B(2, c + 2) = dz;  // zz
    o.B(3, c + 1) = dz;  // yz
    o.B(3, c + 2) = dy;
    o.B(4, c) = dz;  // xz
    o.B(5, c) = dy;  // xy
    o.S(0, c) = n;
    o.S(4, c + 2) = n;
    o.S(5, c + 1) = n;
  }
  o.Phi(0, N) = 1;
  o.Phi(0, M_y) = p.z;
  o.Phi(0, M_z) = -p.y;
  o.Phi(4, V_z) = 1;
  o.Phi(4, T) = p.y;
  o.Phi(5, V_y) = 1;
  o.Phi(5, T) = -p.z;
  return o;
}

// ---- checks and outline
// -----------------------------------------------------------------------------------------------

void check(const std::string& name, const SectionMesh& mesh, const std::vector<Ply>& plies) {
  const auto fail = [&](const std::string& text) {
    throw std::invalid_argument(fmt::format("section \"{}\": {}", name, text));
  };
  const int n = static_cast<int>(mesh.points.rows()), m = static_cast<int>(mesh.triangles.rows());
  if (m == 0) fail("its mesh has no triangles");
  if (!mesh.points.allFinite()) fail("its mesh has points that are not finite");
  if (plies.empty()) fail("it has no material");
  if (!mesh.ply.empty() && static_cast<int>(mesh.ply.size()) != m)
    fail(fmt::format("{} plies are given for {} triangles", mesh.ply.size(), m));
  if (!mesh.plane_angle.empty() && static_cast<int>(mesh.plane_angle.size()) != m)
    fail(fmt::format("{} plane angles are given for {} triangles", mesh.plane_angle.size(), m));
  for (const int ply : mesh.ply)
    if (ply < 0 || ply >= static_cast<int>(plies.size()))
      fail(fmt::format("a triangle names material number {}; there are {}", ply, plies.size()));

  std::vector<int> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  std::vector<bool> used(n, false);
  for (int cell = 0; cell < m; ++cell) {
    for (int k = 0; k < 6; ++k) {
      const int node = mesh.triangles(cell, k);
      if (node < 0 || node >= n) fail(fmt::format("triangle {} names node {}; there are {}", cell, node, n));
      used[node] = true;
      parent[root(node)] = root(mesh.triangles(cell, 0));
    }
    for (const QuadraturePoint& q : quadrature())
      if (!(place_in(mesh, cell, q.r, q.s).det > 0.0))
        fail(fmt::format(
            "triangle {} of its mesh is turned inside out (corners must run counter-clockwise about x)",
            cell));
  }
  const int first = root(mesh.triangles(0, 0));
  for (int node = 0; node < n; ++node) {
    if (!used[node]) fail(fmt::format("node {} of its mesh belongs to no triangle", node));
    if (root(node) != first) fail("its mesh falls into separate pieces; a section must hang together");
  }
}

// Edges that belong to one triangle only, chained: mid-side nodes included.
std::vector<Loop> boundary_loops(const SectionMesh& mesh, std::vector<int>* nodes) {
  std::map<std::pair<int, int>, int> count;
  const auto key = [](int a, int b) { return std::pair{std::min(a, b), std::max(a, b)}; };
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 3; ++k) ++count[key(mesh.triangles(cell, k), mesh.triangles(cell, (k + 1) % 3))];
  std::multimap<int, std::pair<int, int>> next;  // corner -> (mid-side, corner), in the triangle's own sense
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles(cell, k), b = mesh.triangles(cell, (k + 1) % 3);
      if (count[key(a, b)] == 1) next.insert({a, {mesh.triangles(cell, 3 + k), b}});
    }
  std::vector<Loop> loops;
  while (!next.empty()) {
    std::vector<int> chain;
    auto it = next.begin();
    while (it != next.end()) {
      chain.push_back(it->first);
      chain.push_back(it->second.first);
      const int corner = it->second.second;
      next.erase(it);
      it = next.find(corner);
    }
    Loop loop(chain.size(), 2);
    for (std::size_t k = 0; k < chain.size(); ++k) loop.row(k) = mesh.points.row(chain[k]);
    loops.push_back(loop);
    nodes->insert(nodes->end(), chain.begin(), chain.end());
  }
  return loops;
}

// ---- the Saint-Venant problems
// ----------------------------------------------------------------------------------------

struct Matrices {
  Sparse E, C, M;
  MatrixX6 R, L;
  Matrix6d A = Matrix6d::Zero();
};

struct Solution {
  MatrixX6 X, X_1;
  Matrix6d Y, Y_1, f;
};

Matrices assemble(const SectionMesh& mesh, const std::vector<Matrix6d>& Q_of_cell) {
  const int n = 3 * static_cast<int>(mesh.points.rows());
  Matrices m;
  m.R = m.L = MatrixX6::Zero(n, 6);
  std::vector<Eigen::Triplet<double>> E, C, M;
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell) {
    Eigen::Matrix<double, 18, 18> E_c = Eigen::Matrix<double, 18, 18>::Zero(), C_c = E_c, M_c = E_c;
    for (const QuadraturePoint& q : quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const Operators o = operators_at(p);
      const Matrix6d Q = Q_of_cell[cell] * (q.weight * p.det);
      const Matrix6x18 QS = Q * o.S;
      const Matrix6d QPhi = Q * o.Phi;
      E_c += o.B.transpose() * Q * o.B;
      C_c += o.B.transpose() * QS;
      M_c += o.S.transpose() * QS;
      m.A += o.Phi.transpose() * QPhi;
      const Eigen::Matrix<double, 18, 6> R_c = o.B.transpose() * QPhi, L_c = o.S.transpose() * QPhi;
      for (int k = 0; k < 18; ++k) {
        const int row = 3 * mesh.triangles(cell, k / 3) + k % 3;
        m.R.row(row) += R_c.row(k);
        m.L.row(row) += L_c.row(k);
      }
    }
    for (int i = 0; i < 18; ++i)
      for (int j = 0; j < 18; ++j) {
        const int row = 3 * mesh.triangles(cell, i / 3) + i % 3,
                  column = 3 * mesh.triangles(cell, j / 3) + j % 3;
        E.emplace_back(row, column, E_c(i, j));
        if (C_c(i, j) != 0.0) C.emplace_back(row, column, C_c(i, j));
        if (M_c(i, j) != 0.0) M.emplace_back(row, column, M_c(i, j));
      }
  }
  for (Sparse* matrix : {&m.E, &m.C, &m.M}) matrix->resize(n, n);
  m.E.setFromTriplets(E.begin(), E.end());
  m.C.setFromTriplets(C.begin(), C.end());
  m.M.setFromTriplets(M.begin(), M.end());
  return m;
}

// The warping is free up to a rigid motion of the section (and u_x linear in y, z, which is shear): six dofs
// at three nodes are pinned.  The flexibility does not depend on which.
std::array<int, 6> pinned_dofs(const SectionMesh& mesh) {
  const int n = static_cast<int>(mesh.points.rows());
  const Eigen::RowVector2d middle = mesh.points.colwise().mean();
  int a = 0, b = 0, c = 0;
  for (int k = 0; k < n; ++k)
    if ((mesh.points.row(k) - middle).norm() < (mesh.points.row(a) - middle).norm()) a = k;
  for (int k = 0; k < n; ++k)
    if ((mesh.points.row(k) - mesh.points.row(a)).norm() > (mesh.points.row(b) - mesh.points.row(a)).norm())
      b = k;
  const Eigen::RowVector2d ab = mesh.points.row(b) - mesh.points.row(a);
  const auto off = [&](int k) {
    const Eigen::RowVector2d d = mesh.points.row(k) - mesh.points.row(a);
    return std::abs(ab(0) * d(1) - ab(1) * d(0));
  };
  for (int k = 0; k < n; ++k)
    if (off(k) > off(c)) c = k;
  const int turn = std::abs(ab(0)) > std::abs(ab(1)) ? 2 : 1;
  return {3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + turn, 3 * c};
}

Solution solve(const std::string& name, const SectionMesh& mesh, const Matrices& m) {
  const int n = static_cast<int>(m.E.rows());
  std::vector<int> index(n, 0);
  for (const int dof : pinned_dofs(mesh)) index[dof] = -1;
  int free = 0;
  for (int& i : index)
    if (i == 0) i = free++;
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(m.E.nonZeros());
  for (int column = 0; column < n; ++column)
    for (Sparse::InnerIterator it(m.E, column); it; ++it)
      if (index[it.row()] >= 0 && index[column] >= 0)
        triplets.emplace_back(index[it.row()], index[column], it.value());
  Sparse E_ff(free, free);
  E_ff.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLLT<Sparse> factor(E_ff);
  if (factor.info() != Eigen::Success)
    throw std::invalid_argument(fmt::format(
        "section \"{}\": its warping problem is singular; does the mesh hang together by edges?", name));
  const auto solve_E = [&](const MatrixX6& right) {
    MatrixX6 reduced(free, 6), full = MatrixX6::Zero(n, 6);
    for (int i = 0; i < n; ++i)
      if (index[i] >= 0) reduced.row(index[i]) = right.row(i);
    const MatrixX6 solution = factor.solve(reduced);
    for (int i = 0; i < n; ++i)
      if (index[i] >= 0) full.row(i) = solution.row(index[i]);
    return full;
  };

  const MatrixX6 U = solve_E(m.R);
  const Matrix6d schur = inverse_spd(Matrix6d(m.A - m.R.transpose() * U),
                                     fmt::format("section \"{}\": the stiffness of the free section", name));
  Matrix6d D = Matrix6d::Zero();
  D(M_y, V_z) = 1.0;
  D(M_z, V_y) = -1.0;
  Solution s;
  s.Y_1 = schur * D;
  s.X_1 = -U * s.Y_1;
  const MatrixX6 W = solve_E(m.C.transpose() * s.X_1 - m.C * s.X_1 + m.L * s.Y_1);
  s.Y = schur * (Matrix6d::Identity() - m.L.transpose() * s.X_1 - m.R.transpose() * W);
  s.X = W - U * s.Y;

  const MatrixX6 on_X = m.E * s.X + m.C * s.X_1 + m.R * s.Y;
  const MatrixX6 on_X_1 = m.C.transpose() * s.X + m.M * s.X_1 + m.L * s.Y;
  const Matrix6d on_Y = m.R.transpose() * s.X + m.L.transpose() * s.X_1 + m.A * s.Y;
  const Matrix6d f = s.X.transpose() * on_X + s.X_1.transpose() * on_X_1 + s.Y.transpose() * on_Y;
  s.f = 0.5 * (f + f.transpose());
  return s;
}

// ---- what people want to know
// -----------------------------------------------------------------------------------------

// Integrals of 1, y, z, y^2, z^2, y z with a weight for each cell.
struct Moments {
  double o = 0, y = 0, z = 0, yy = 0, zz = 0, yz = 0;
};

Moments moments(const SectionMesh& mesh, const std::vector<double>& weight) {
  Moments m;
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const double w = weight[cell] * q.weight * p.det;
      m.o += w;
      m.y += w * p.y;
      m.z += w * p.z;
      m.yy += w * p.y * p.y;
      m.zz += w * p.z * p.z;
      m.yz += w * p.y * p.z;
    }
  return m;
}

void find_principal_axes(SectionProperties& s) {
  const double mean = 0.5 * (s.I_y + s.I_z), difference = 0.5 * (s.I_y - s.I_z);
  const double radius = std::hypot(difference, s.I_yz);
  s.I_1 = mean + radius;
  s.I_2 = mean - radius;
  // Moment about the axis at phi from y: mean + difference cos 2phi + I_yz sin 2phi (I_yz = -int y z dA).
  s.principal_angle = radius > 1e-12 * mean ? 0.5 * std::atan2(s.I_yz, difference) : 0.0;
  if (s.principal_angle <= -0.5 * std::numbers::pi) s.principal_angle += std::numbers::pi;
}

void find_warping(SectionProperties& s, const SectionMesh& mesh, const Solution& solution,
                  const std::vector<double>& weight) {
  // u_x of a unit torque per unit twist rate; the part linear in (1, y, z), weighted by E, is no warping:
  // taking it out moves the pole to the shear centre (V. Z. Vlasov, Thin-walled elastic beams, 1961).
  const int n = static_cast<int>(mesh.points.rows());
  Eigen::VectorXd omega(n);
  for (int k = 0; k < n; ++k) omega(k) = solution.X(3 * k, T) / solution.f(T, T);
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto value = [&](int cell, const Place& p) {
    double sum = 0.0;
    for (int k = 0; k < 6; ++k) sum += p.N(k) * omega(mesh.triangles(cell, k));
    return sum;
  };
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const double w = weight[cell] * q.weight * p.det;
      const Eigen::Vector3d basis(1.0, p.y, p.z);
      gram += w * basis * basis.transpose();
      right += w * value(cell, p) * basis;
    }
  const Eigen::Vector3d linear = gram.ldlt().solve(right);
  for (int k = 0; k < n; ++k)
    omega(k) -= linear(0) + linear(1) * mesh.points(k, 0) + linear(2) * mesh.points(k, 1);
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      s.I_w += weight[cell] * q.weight * p.det * std::pow(value(cell, p), 2);
    }
  s.warping = omega;
}

// Stresses at the boundary nodes furthest out in eight directions, mean over the triangles that meet there.
void find_stress_points(SectionProperties& s, const SectionMesh& mesh, const std::vector<Matrix6d>& Q_of_cell,
                        const Solution& solution, const std::vector<int>& boundary) {
  static const std::array<const char*, 8> names = {"+y", "+y+z", "+z", "-y+z", "-y", "-y-z", "-z", "+y-z"};
  constexpr double corner_r[] = {0, 1, 0, 0.5, 0.5, 0}, corner_s[] = {0, 0, 1, 0, 0.5, 0.5};
  for (int direction = 0; direction < 8; ++direction) {
    const double phi = 0.25 * std::numbers::pi * direction;
    int node = boundary.front();
    double best = -std::numeric_limits<double>::infinity();
    for (const int candidate : boundary) {
      // Of a flat side its middle: a little is taken off for the distance from the ray through the centroid.
      const Eigen::RowVector2d d = mesh.points.row(candidate) - s.centroid.transpose();
      const double reach = std::cos(phi) * d(0) + std::sin(phi) * d(1) -
                           1e-6 * std::abs(std::cos(phi) * d(1) - std::sin(phi) * d(0));
      if (reach > best + 1e-9 * s.size) {
        best = reach;
        node = candidate;
      }
    }
    StressPoint point;
    point.name = names[direction];
    point.y = mesh.points(node, 0);
    point.z = mesh.points(node, 1);
    int meeting = 0;
    for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
      for (int k = 0; k < 6; ++k) {
        if (mesh.triangles(cell, k) != node) continue;
        const Operators o = operators_at(place_in(mesh, cell, corner_r[k], corner_s[k]));
        Eigen::Matrix<double, 18, 6> X, X_1;
        for (int j = 0; j < 18; ++j) {
          X.row(j) = solution.X.row(3 * mesh.triangles(cell, j / 3) + j % 3);
          X_1.row(j) = solution.X_1.row(3 * mesh.triangles(cell, j / 3) + j % 3);
        }
        const Matrix6d stress = Q_of_cell[cell] * (o.Phi * solution.Y + o.B * X + o.S * X_1);
        point.S.row(0) += stress.row(0);
        point.S.row(1) += stress.row(5);
        point.S.row(2) += stress.row(4);
        ++meeting;
      }
    point.S /= meeting;
    const bool known = std::any_of(
        s.section.points.begin(), s.section.points.end(),
        [&](const StressPoint& p) { return std::hypot(p.y - point.y, p.z - point.z) < 1e-9 * s.size; });
    if (!known) s.section.points.push_back(point);
  }
}

}  // namespace

SectionProperties solve_section(const std::string& name, const SectionMesh& mesh,
                                const std::vector<Ply>& plies) {
  check(name, mesh, plies);
  const int cells = static_cast<int>(mesh.triangles.rows());
  std::vector<Matrix6d> Q(cells);
  std::vector<double> one(cells, 1.0), density(cells), stiffness(cells);
  SectionProperties s;
  for (int cell = 0; cell < cells; ++cell) {
    const Ply& ply = plies[mesh.ply.empty() ? 0 : mesh.ply[cell]];
    Q[cell] = stiffness_of(ply, mesh.plane_angle.empty() ? 0.0 : mesh.plane_angle[cell]);
    density[cell] = ply.material.rho;
    // E along the beam with free sides: 1 / (Q^-1)_xx.
    stiffness[cell] = 1.0 / inverse_spd(Q[cell], fmt::format("material \"{}\"", ply.material.name))(0, 0);
  }
  s.E_ref = stiffness[0];
  const Matrix6d compliance =
      inverse_spd(stiffness_of(plies[mesh.ply.empty() ? 0 : mesh.ply[0]]), "the first ply");
  s.G_ref = 2.0 / (compliance(4, 4) + compliance(5, 5));
  for (double& E : stiffness) E /= s.E_ref;

  const Moments area = moments(mesh, one), mass = moments(mesh, density), elastic = moments(mesh, stiffness);
  s.area = area.o;
  s.centroid = Eigen::Vector2d(area.y, area.z) / area.o;
  s.mass_centre = mass.o > 0.0 ? Eigen::Vector2d(mass.y / mass.o, mass.z / mass.o) : s.centroid;
  s.A = elastic.o;
  s.tension_centre = Eigen::Vector2d(elastic.y, elastic.z) / elastic.o;
  s.I_y = elastic.zz - elastic.z * elastic.z / elastic.o;
  s.I_z = elastic.yy - elastic.y * elastic.y / elastic.o;
  s.I_yz = -(elastic.yz - elastic.y * elastic.z / elastic.o);
  find_principal_axes(s);
  s.size = (mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).maxCoeff();

  const Solution solution = solve(name, mesh, assemble(mesh, Q));
  const Matrix6d& f = solution.f;
  // T about the shear centre is T + V_y z_cs - V_z y_cs: f_{V_y T} = z_cs f_TT, f_{V_z T} = -y_cs f_TT.
  s.shear_centre = Eigen::Vector2d(-f(V_z, T), f(V_y, T)) / f(T, T);
  s.I_t = 1.0 / (s.G_ref * f(T, T));
  const double f_y = f(V_y, V_y) - f(V_y, T) * f(V_y, T) / f(T, T);
  const double f_z = f(V_z, V_z) - f(V_z, T) * f(V_z, T) / f(T, T);
  s.A_sy = 1.0 / (s.G_ref * f_y);
  s.A_sz = 1.0 / (s.G_ref * f_z);
  s.shear_coupling = (f(V_y, V_z) - f(V_y, T) * f(V_z, T) / f(T, T)) / std::sqrt(f_y * f_z);
  for (const int axial : {N, M_y, M_z})
    for (const int shear : {V_y, V_z, T})
      s.couples =
          s.couples || std::abs(f(axial, shear)) > 1e-6 * std::sqrt(f(axial, axial) * f(shear, shear));
  find_warping(s, mesh, solution, stiffness);
  s.decay_length = std::sqrt(s.E_ref * s.I_w / (s.G_ref * s.I_t));

  Section& section = s.section;
  section.name = name;
  section.f = f;
  section.f_shear_rigid = without_shear_flexibility(f);
  section.inertia = {mass.o, mass.y, mass.z, mass.yy, mass.zz, mass.yz};
  section.I_w = s.I_w;
  section.open_thin_walled = s.decay_length > s.size;
  section.material = Material{plies[0].material.name, s.E_ref, s.G_ref, mass.o / area.o};
  Constants constants;
  constants.A = s.A;
  constants.I_y = elastic.zz;
  constants.I_z = elastic.yy;
  constants.I_yz = -elastic.yz;
  constants.S_y = elastic.z;
  constants.S_z = elastic.y;
  constants.I_t = s.I_t;
  constants.A_sy = s.A_sy;
  constants.A_sz = s.A_sz;
  constants.y_cs = s.shear_centre.x();
  constants.z_cs = s.shear_centre.y();
  constants.y_cg = s.mass_centre.x();
  constants.z_cg = s.mass_centre.y();
  section.constants = constants;
  std::vector<int> boundary;
  section.outline = boundary_loops(mesh, &boundary);
  find_stress_points(s, mesh, Q, solution, boundary);
  return s;
}

}  // namespace flexura::beam
