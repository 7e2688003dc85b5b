// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_cells.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "reduce/estimate/enrichment.hpp"
#include "reduce/linalg/cell_products.hpp"

namespace flexura::reduce {

using linalg::Eight;

namespace {

// Of the diagonal; what this adds to a cell's stiffness is taken away again by conjugate gradients.
constexpr float kFooting = 0.1f;
// Strains (xx, yy, zz, xy, yz, zx) of displacement a by direction c.
constexpr int kStrain[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

FLEXURA_INLINE Eight* eights(std::vector<float>& v) {
  return reinterpret_cast<Eight*>(v.data());
}

// integral g_i g_j^T dV (3 x 3) of functions i and j; g is n_points x n x 3, the weights are the last of ten in `map`.
FLEXURA_INLINE void gradient_products(const Eight* g, const Eight* map, int n_points, int n, int i, int j, Eight* H) {
  Eight h00{}, h01{}, h02{}, h10{}, h11{}, h12{}, h20{}, h21{}, h22{};
  for (int q = 0; q < n_points; ++q) {
    const Eight *gi = g + 3L * (q * n + i), *gj = g + 3L * (q * n + j);
    const Eight w = map[10 * q + 9], x = w * gi[0], y = w * gi[1], z = w * gi[2];
    h00 += x * gj[0];
    h01 += x * gj[1];
    h02 += x * gj[2];
    h10 += y * gj[0];
    h11 += y * gj[1];
    h12 += y * gj[2];
    h20 += z * gj[0];
    h21 += z * gj[1];
    h22 += z * gj[2];
  }
  const Eight all[9] = {h00, h01, h02, h10, h11, h12, h20, h21, h22};
  for (int k = 0; k < 9; ++k) H[k] = all[k];
}

// The inverse of a symmetric positive definite matrix in its place, by Gauss and Jordan.
FLEXURA_INLINE void invert(Eight* A, int n) {
  for (int k = 0; k < n; ++k) {
    Eight* pivot = A + static_cast<long>(k) * n;
    const Eight over = 1.0f / pivot[k];
    pivot[k] = Eight{} + 1.0f;
    for (int j = 0; j < n; ++j) pivot[j] *= over;
    for (int i = 0; i < n; ++i) {
      if (i == k) continue;
      Eight* row = A + static_cast<long>(i) * n;
      const Eight a = row[k];
      row[k] = Eight{};
      for (int j = 0; j < n; ++j) row[j] -= a * pivot[j];
    }
  }
}

void copy_lane(const std::vector<float>& from, int lane, long n, float* to) {
  for (long k = 0; k < n; ++k) to[k] = from[static_cast<std::size_t>(k * EnrichedCells::kLanes + lane)];
}

}  // namespace

EnrichedCells::EnrichedCells(mesh::CellType type, const std::vector<Material>& materials)
    : g_(static_cast<int>(enrichment_of(type).size())),
      m_(mesh::nodes_per_cell(type)),
      rule_(solid_element(type).mass),
      materials_(materials) {
  for (const TabulatedRule::Point& point : rule_.points) {
    const EnrichmentValues gained = evaluate_enrichment(type, point.xi);
    for (int i = 0; i < g_; ++i) functions_.push_back(static_cast<float>(gained.w(i)));
    for (int i = 0; i < m_; ++i) functions_.push_back(static_cast<float>(point.N(i)));
    for (int i = 0; i < g_; ++i)
      for (int d = 0; d < 3; ++d) functions_.push_back(static_cast<float>(gained.dw(i, d)));
    for (int i = 0; i < m_; ++i)
      for (int d = 0; d < 3; ++d) functions_.push_back(static_cast<float>(point.dN(i, d)));
  }
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) {
          const int i = kStrain[a][c], j = kStrain[b][d];
          if (std::any_of(materials.begin(), materials.end(), [&](const Material& m) { return m.D(i, j) != 0.0; }))
            terms_.push_back({a, b, 3 * c + d, 6 * i + j});
        }
  const auto lanes = [](std::size_t count) { return std::vector<float>(count * kLanes, 0.0f); };
  const auto N = static_cast<std::size_t>(3 * n()), n_points = rule_.points.size();
  map_ = lanes(10 * n_points);
  D_ = lanes(36);
  density_ = lanes(1);
  sign_ = lanes(static_cast<std::size_t>(n()));
  gradients_ = lanes(N * n_points);
  coupling_ = lanes(static_cast<std::size_t>(9 * g_ * m_));
  mass_ = lanes(static_cast<std::size_t>(g_ * m_));
  diagonal_ = lanes(static_cast<std::size_t>(3 * g_));
}

void EnrichedCells::take(const Cell (&cells)[kLanes]) {
  const auto n_points = static_cast<int>(rule_.points.size());
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto put = [lane](std::vector<float>& v, int k, double value) {
      v[static_cast<std::size_t>(k * kLanes + lane)] = static_cast<float>(value);
    };
    const Cell& cell = cells[lane].x.rows() == 0 ? cells[0] : cells[lane];
    const Material& material = materials_[cell.material];
    put(density_, 0, material.density);
    for (int q = 0; q < n_points; ++q) {
      const TabulatedRule::Point& point = rule_.points[static_cast<std::size_t>(q)];
      const Eigen::Matrix3d J = point.dN.transpose() * cell.x;
      const double det = J.determinant();
      const Eigen::Matrix3d to_space = det > 0.0 ? Eigen::Matrix3d(J.inverse().transpose()) : Eigen::Matrix3d::Zero();
      for (int k = 0; k < 9; ++k) put(map_, 10 * q + k, to_space(k / 3, k % 3));
      put(map_, 10 * q + 9, point.weight * std::max(det, 0.0));
    }
    for (int k = 0; k < 36; ++k) put(D_, k, material.D(k / 6, k % 6));
    for (int i = 0; i < n(); ++i) put(sign_, i, cell.sign[static_cast<std::size_t>(i)]);
  }
  on_this_machine([&]() __attribute__((always_inline)) {
    const Eight *map = eights(map_), *sign = eights(sign_);
    Eight* g = eights(gradients_);
    for (int q = 0; q < n_points; ++q, map += 10) {
      const float* dw = functions_.data() + n() * (4 * q + 1);
      for (int i = 0; i < n(); ++i, g += 3) {
        // All of a cell's own functions load the gained ones.
        const Eight s = i < g_ ? sign[i] : Eight{} + 1.0f;
        for (int c = 0; c < 3; ++c)
          g[c] = s * (dw[3 * i] * map[c] + dw[3 * i + 1] * map[3 + c] + dw[3 * i + 2] * map[6 + c]);
      }
    }
  });
}

void EnrichedCells::compute_coupling() {
  const auto n_points = static_cast<int>(rule_.points.size());
  on_this_machine([&]() __attribute__((always_inline)) {
    const Eight *map = eights(map_), *D = eights(D_), *sign = eights(sign_), *g = eights(gradients_);
    Eight *mass = eights(mass_), *coupling = eights(coupling_), *diagonal = eights(diagonal_);
    const Eight rho = *eights(density_);
    Eight H[9];
    for (int i = 0; i < g_; ++i) {
      for (int j = 0; j < m_; ++j) {
        gradient_products(g, map, n_points, n(), i, g_ + j, H);
        Eight* at = coupling + 9L * i * m_ + 3 * j;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) at[3L * a * m_ + b] = Eight{};
        for (const Term& t : terms_) at[3L * t.a * m_ + t.b] += D[t.entry] * H[t.from];
        Eight sum{};
        for (int q = 0; q < n_points; ++q) {
          const float* w = functions_.data() + 4 * n() * q;
          sum += map[10 * q + 9] * (w[i] * w[g_ + j]);
        }
        mass[i * m_ + j] = rho * sign[i] * sum;
      }
      gradient_products(g, map, n_points, n(), i, i, H);
      for (int a = 0; a < 3; ++a) diagonal[3 * i + a] = Eight{};
      for (const Term& t : terms_)
        if (t.a == t.b) diagonal[3 * i + t.a] += D[t.entry] * H[t.from];
    }
  });
}

void EnrichedCells::compute_stiffness() {
  const auto n_points = static_cast<int>(rule_.points.size());
  const int N = 3 * n();
  K_.resize(static_cast<std::size_t>(N * N * kLanes));
  inverse_.resize(K_.size());
  on_this_machine([&]() __attribute__((always_inline)) {
    const Eight *map = eights(map_), *D = eights(D_), *sign = eights(sign_), *g = eights(gradients_);
    Eight *K = eights(K_), *inverse = eights(inverse_);
    Eight H[9], block[9];
    for (int i = 0; i < n(); ++i)
      for (int j = i; j < n(); ++j) {
        gradient_products(g, map, n_points, n(), i, j, H);
        for (Eight& k : block) k = Eight{};
        for (const Term& t : terms_) block[3 * t.a + t.b] += D[t.entry] * H[t.from];
        // Gained functions have their sign already; of the own ones those are zero that are left out.
        const Eight one = Eight{} + 1.0f, keep = (i < g_ ? one : sign[i]) * (j < g_ ? one : sign[j]);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            Eight k = keep * block[3 * a + b];
            if (i == j && a == b) k += one - sign[i] * sign[i];
            K[(3L * i + a) * N + 3 * j + b] = k;
            K[(3L * j + b) * N + 3 * i + a] = k;
          }
      }
    for (long k = 0; k < static_cast<long>(N) * N; ++k) inverse[k] = K[k];
    for (int k = 0; k < N; ++k) inverse[static_cast<long>(k) * (N + 1)] *= 1.0f + kFooting;
    invert(inverse, N);
  });
}

void EnrichedCells::copy_coupling(int lane, float* K_wv) const {
  copy_lane(coupling_, lane, 9L * g_ * m_, K_wv);
}
void EnrichedCells::copy_mass(int lane, float* m_wv) const {
  copy_lane(mass_, lane, static_cast<long>(g_) * m_, m_wv);
}
void EnrichedCells::copy_diagonal(int lane, float* K_ww) const {
  copy_lane(diagonal_, lane, 3L * g_, K_ww);
}
void EnrichedCells::copy_stiffness(int lane, float* K) const {
  copy_lane(K_, lane, 9L * n() * n(), K);
}
void EnrichedCells::copy_inverse(int lane, float* B) const {
  copy_lane(inverse_, lane, 9L * n() * n(), B);
}

}  // namespace flexura::reduce
