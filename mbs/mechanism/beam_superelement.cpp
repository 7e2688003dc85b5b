// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/beam_superelement.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "beam/element/slopes.hpp"
#include "mbs/bodies/preparation_cache.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using superelement::Superelement;

constexpr int kLeastElements = 16, kMostElements = 64;
constexpr double kSamePlace = 1e-9;  // of the length

struct Mesh {
  std::vector<double> x;     // of the nodes, from the root
  std::vector<int> station;  // node of each station of the part
  std::vector<beam::Element> element;
  std::vector<beam::Placement> placement;
};

Mesh divided(const BeamPart& part) {
  const double L = part.length(), h = L / std::clamp(part.elements, kLeastElements, kMostElements);
  std::vector<double> places = {0.0, L};
  for (const auto& [name, x] : part.points) places.push_back(std::clamp(x, 0.0, L));
  Mesh mesh;
  std::vector<double> ordered = places;
  std::ranges::sort(ordered);
  mesh.x = {0.0};
  for (const double to : ordered) {
    const double from = mesh.x.back();
    if (to - from <= kSamePlace * L) continue;
    const int n = std::max(1, static_cast<int>(std::ceil((to - from) / h * (1.0 - 1e-9))));
    for (int i = 1; i <= n; ++i) mesh.x.push_back(from + (to - from) * i / n);
  }
  for (const double at : places)
    mesh.station.push_back(static_cast<int>(
        std::ranges::min_element(mesh.x, {}, [&](double x) { return std::abs(x - at); }) - mesh.x.begin()));
  beam::SectionMatrices section;
  section.f = part.C.inverse();
  section.inertia = part.section_inertia();
  beam::Placement placement;
  placement.R_BE = part.R_BE();
  for (std::size_t e = 0; e + 1 < mesh.x.size(); ++e) {
    placement.p_Bo1_B = part.from_B + mesh.x[e] * placement.R_BE.col(0);
    placement.length = mesh.x[e + 1] - mesh.x[e];
    mesh.element.emplace_back(placement.length, section);
    mesh.placement.push_back(placement);
  }
  return mesh;
}

MatrixXd symmetric(const MatrixXd& A) {
  return 0.5 * (A + A.transpose());
}

// Dofs 6 node + k of the mesh by the superelement's coordinates: n_dofs x n.
// Eigenvalues of the modes kept, and the first one left out (0: none).
MatrixXd craig_bampton(const MatrixXd& K, const MatrixXd& M, const std::vector<int>& kept, Index modes,
                       VectorXd& omega2, double& next) {
  std::vector<int> boundary, interior;
  for (Index n = 0; n < K.rows() / 6; ++n)
    for (int k = 0; k < 6; ++k)
      (std::ranges::find(kept, static_cast<int>(n)) != kept.end() ? boundary : interior)
          .push_back(static_cast<int>(6 * n + k));
  // Boundary nodes in the order of `kept`.
  boundary.clear();
  for (const int n : kept)
    for (int k = 0; k < 6; ++k) boundary.push_back(6 * n + k);
  const auto n_b = static_cast<Index>(boundary.size()), n_i = static_cast<Index>(interior.size());
  const Index n_q = std::min(n_i, modes);
  MatrixXd T = MatrixXd::Zero(K.rows(), n_b + n_q);
  for (Index b = 0; b < n_b; ++b) T(boundary[static_cast<std::size_t>(b)], b) = 1.0;
  omega2.resize(n_q);
  next = 0.0;
  if (n_i == 0) return T;
  // Displacements against rotations: by sizes of their own the factor keeps its digits.
  const VectorXd scale = K(interior, interior).diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd K_ii = scale.asDiagonal() * MatrixXd(K(interior, interior)) * scale.asDiagonal(),
                 M_ii = scale.asDiagonal() * MatrixXd(M(interior, interior)) * scale.asDiagonal();
  const Eigen::LLT<MatrixXd> factor(K_ii);
  const MatrixXd Psi =
      -(scale.asDiagonal() * factor.solve(scale.asDiagonal() * MatrixXd(K(interior, boundary))));
  for (Index b = 0; b < n_b; ++b)
    for (Index i = 0; i < n_i; ++i) T(interior[static_cast<std::size_t>(i)], b) = Psi(i, b);
  // The largest of M phi = K phi / omega^2 come out best.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(symmetric(M_ii), symmetric(K_ii));
  for (Index q = 0; q < n_q; ++q) {
    const Index at = n_i - 1 - q;
    const double inverse = solver.eigenvalues()(at);
    if (!(inverse > 0.0)) throw std::invalid_argument("the beam has no mass; give it a density above 0");
    omega2(q) = 1.0 / inverse;
    const VectorXd phi = scale.asDiagonal() * solver.eigenvectors().col(at) / std::sqrt(inverse);
    for (Index i = 0; i < n_i; ++i) T(interior[static_cast<std::size_t>(i)], n_b + q) = phi(i);
  }
  next = n_q < n_i ? 1.0 / solver.eigenvalues()(n_i - 1 - n_q) : 0.0;
  return T;
}

// Tension under unit accelerations and turning of B and unit loads on the stations, held at the root.
superelement::StiffeningTerms stiffening_terms(const BeamPart& part, const Mesh& mesh, const MatrixXd& T,
                                               const std::vector<int>& kept) {
  const Index n = T.cols();
  const Vector3d axis = part.R_BE().col(0);
  const double r2 = (part.rho_I_y + part.rho_I_z) / part.mass_per_length;
  const beam::SectionInertia section = part.section_inertia();
  // Per length along the axis at a place: linear in it, so that its integral to the tip is exact by the middle.
  const double L = part.length();
  const auto tension = [&](double x) {
    beam::Placement root = mesh.placement.front();
    return Eigen::Matrix<double, 12, 1>((L - x) *
                                        beam::line_loads(root, 0.5 * (x + L), section).row(0).transpose());
  };
  superelement::StiffeningTerms terms;
  std::array<MatrixXd, 12> K;
  K.fill(MatrixXd::Zero(n, n));
  terms.K0F.assign(6 * kept.size(), MatrixXd::Zero(n, n));
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    const MatrixXd shapes = mesh.placement[e].transform() * T.middleRows(6 * static_cast<Index>(e), 12);
    MatrixXd of_element = MatrixXd::Zero(n, n);
    for (const beam::SlopeStation& at : beam::slope_stations(mesh.element[e], mesh.element[e].length())) {
      MatrixXd slopes = at.slopes * shapes;
      slopes.row(2) *= std::sqrt(r2);
      const MatrixXd unit = at.weight * (slopes.transpose() * slopes);
      of_element += unit;
      const auto N = tension(mesh.x[e] + at.x);
      for (int k = 0; k < 12; ++k)
        if (N(k) != 0.0) K[static_cast<std::size_t>(k)] += N(k) * unit;
    }
    for (std::size_t s = 1; s < kept.size(); ++s)
      if (kept[s] > static_cast<int>(e))
        for (int k = 0; k < 3; ++k) terms.K0F[6 * s + static_cast<std::size_t>(k)] += axis(k) * of_element;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    terms.K0t[k] = K[k];
    terms.K0r[k] = K[3 + k];
  }
  for (std::size_t k = 0; k < 6; ++k) terms.K0omega[k] = K[6 + k];
  return terms;
}

// Of each elastic frequency of the free beam, the largest of what bending, stretch and torsion lose at it.
superelement::MeshError mesh_error(const BeamPart& part, const Mesh& mesh, const Superelement& se) {
  double h = 0.0;
  for (const beam::Placement& placement : mesh.placement) h = std::max(h, placement.length);
  const Matrix6d& C = part.C;
  const double m = part.mass_per_length;
  superelement::MeshError out;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> free(se.K_se, se.M_se,
                                                                Eigen::EigenvaluesOnly | Eigen::Ax_lBx);
  for (Index i = 6; i < free.eigenvalues().size(); ++i) {
    const double omega = std::sqrt(std::max(0.0, free.eigenvalues()(i)));
    double worst =
        omega * omega * h * h / 48.0 * std::max(m / C(0, 0), (part.rho_I_y + part.rho_I_z) / C(3, 3));
    for (const auto& [EI, GA] : {std::pair{C(4, 4), C(2, 2)}, std::pair{C(5, 5), C(1, 1)}}) {
      const double k2 = omega * std::sqrt(m / EI), kh2 = k2 * h * h;
      worst = std::max(worst, kh2 * kh2 / 1440.0 + kh2 / 48.0 * EI * k2 / GA);
    }
    out.modes.push_back(
        {.frequency_hz = omega / (2.0 * std::numbers::pi), .error = std::min(1.0, worst), .stress = {}});
  }
  for (const superelement::Interface& interface : se.interfaces)
    out.interfaces.push_back({.name = interface.name, .compliance_error = 0.0, .stress = {}});
  return out;
}

}  // namespace

std::string key_of(const BeamPart& part) {
  input::ContentHash hash;
  add_to(hash, part.from_B);
  add_to(hash, part.to_B);
  add_to(hash, part.R_BE());
  add_to(hash, part.C);
  for (const double x : {static_cast<double>(part.elements), part.is_planar ? 1.0 : 0.0, part.mass_per_length,
                         part.rho_I_y, part.rho_I_z, part.m_y, part.m_z, part.m_yz, part.damping_time})
    hash.add(fmt::format("{:.17g}", x));
  for (const auto& [name, x] : part.points) hash.add(name).add(fmt::format("{:.17g}", x));
  return "beam " + hash.hex();
}

std::shared_ptr<const Superelement> beam_superelement(const BeamPart& given, int modes) {
  // Across its plane a planar beam is rigid: a hundred times its frequencies in the plane.
  constexpr double kAcross = 1e4;
  BeamPart part = given;
  if (part.is_planar) {
    part.C = Vector6d(given.C(0, 0), given.C(1, 1), given.C(1, 1), 1.0, 1.0, given.C(5, 5)).asDiagonal();
    part.C(3, 3) = part.C(4, 4) = kAcross * given.C(5, 5);
  }
  const Mesh mesh = divided(part);
  const auto n_dofs = static_cast<Index>(6 * mesh.x.size());
  MatrixXd K = MatrixXd::Zero(n_dofs, n_dofs);
  auto out = std::make_shared<Superelement>();
  Superelement& se = *out;
  superelement::InertiaIntegrals sums;
  sums.S_phi = MatrixXd::Zero(3, n_dofs);
  sums.S_xphi = MatrixXd::Zero(9, n_dofs);
  sums.S_phiphi.fill(MatrixXd::Zero(n_dofs, n_dofs));
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    const Index at = 6 * static_cast<Index>(e);
    const beam::Matrix12d to_element = mesh.placement[e].transform();
    K.block<12, 12>(at, at) += to_element.transpose() * mesh.element[e].stiffness() * to_element;
    const beam::InertiaBlocks blocks = mesh.element[e].inertia_blocks(mesh.placement[e]);
    sums.mass += blocks.mass;
    sums.S_x += blocks.S_x;
    sums.S_xx += blocks.S_xx;
    sums.S_phi.middleCols<12>(at) += blocks.S_phi;
    sums.S_xphi.middleCols<12>(at) += blocks.S_xphi;
    for (std::size_t k = 0; k < 6; ++k) sums.S_phiphi[k].block<12, 12>(at, at) += blocks.S_phiphi[k];
  }
  const MatrixXd M = symmetric(sums.S_phiphi[0] + sums.S_phiphi[1] + sums.S_phiphi[2]);

  const auto stations = part.stations();
  std::vector<int> kept;  // nodes, in the order of the stations
  for (std::size_t s = 0; s < stations.size(); ++s) {
    superelement::Interface interface {
      .name = stations[s].first, .tie = "node", .p_BoN_B = stations[s].second
    };
    if (std::ranges::find(kept, mesh.station[s]) == kept.end()) kept.push_back(mesh.station[s]);
    se.interfaces.push_back(std::move(interface));
  }
  double next = 0.0;
  const MatrixXd T = craig_bampton(K, M, kept, modes, se.omega2, next);
  se.n_b = 6 * static_cast<int>(kept.size());
  se.n_q = static_cast<int>(se.omega2.size());
  int dofs = 0;
  for (std::size_t s = 0; s < se.interfaces.size(); ++s) {
    superelement::Interface& interface = se.interfaces[s];
    const auto own = static_cast<int>(6 * (std::ranges::find(kept, mesh.station[s]) - kept.begin()));
    const bool follows = own < dofs;
    auto& directions = follows ? interface.following : interface.directions;
    for (int k = 0; k < 6; ++k) directions.push_back(static_cast<superelement::Direction>(k));
    interface.first_dof = dofs;
    if (follows) {
      interface.follow = MatrixXd::Zero(6, se.n());
      interface.follow.middleCols<6>(own).setIdentity();
    } else {
      dofs += 6;
    }
  }
  // Bending's digits come from the stretch of each element; K has only those of its largest entries.
  se.K_se = MatrixXd::Zero(se.n(), se.n());
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    const MatrixXd stretch = mesh.element[e].stretch_map() * mesh.placement[e].transform() *
                             T.middleRows(6 * static_cast<Index>(e), 12);
    se.K_se += stretch.transpose() * mesh.element[e].stretch_stiffness() * stretch;
  }
  se.K_se = symmetric(se.K_se);
  se.inertia.mass = sums.mass;
  se.inertia.S_x = sums.S_x;
  se.inertia.S_xx = sums.S_xx;
  se.inertia.S_phi = sums.S_phi * T;
  se.inertia.S_xphi = sums.S_xphi * T;
  for (std::size_t k = 0; k < 6; ++k) se.inertia.S_phiphi[k] = T.transpose() * sums.S_phiphi[k] * T;
  se.M_se = symmetric(se.inertia.S_phiphi[0] + se.inertia.S_phiphi[1] + se.inertia.S_phiphi[2]);
  if (part.damping_time > 0.0) se.D_se = part.damping_time * se.K_se;
  se.stiffening = stiffening_terms(part, mesh, T, kept);
  se.mesh_error = mesh_error(part, mesh, se);
  // A mode left out takes at most the ratio of the eigenvalues.
  const double first_hz = se.mesh_error->modes.front().frequency_hz,
               omega_1 = 2.0 * std::numbers::pi * first_hz;
  se.report_json = fmt::format(
      R"({{"mesh":{{"members":1}},"estimate":[{{"frequency_hz":{:.17g},"frequency_error":{:.3g}}}]}})",
      first_hz, next > 0.0 ? omega_1 * omega_1 / next : 0.0);
  // The axis, for pictures and probes.
  const auto n_nodes = static_cast<Index>(mesh.x.size());
  se.surface.vertices.resize(n_nodes, 3);
  se.surface.edges.resize(n_nodes - 1, 2);
  se.shapes.resize(3 * n_nodes, se.n());
  const Vector3d axis = part.R_BE().col(0);
  for (Index k = 0; k < n_nodes; ++k) {
    se.surface.vertices.row(k) = (part.from_B + mesh.x[static_cast<std::size_t>(k)] * axis).transpose();
    se.shapes.middleRows<3>(3 * k) = T.middleRows<3>(6 * k).cast<float>();
    if (k > 0) se.surface.edges.row(k - 1) << static_cast<int>(k - 1), static_cast<int>(k);
  }
  return out;
}

}  // namespace flexura::mbs
