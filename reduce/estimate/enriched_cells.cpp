// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_cells.hpp"

#include <algorithm>

#include "reduce/estimate/enrichment.hpp"
#include "reduce/linalg/dense/cell_products.hpp"

namespace flexura::reduce {

using linalg::Eight;

namespace {

// Of the diagonal; what this adds to a cell's stiffness is taken away again by conjugate gradients.
constexpr float kFooting = 0.1f;
// Of the cells that gain functions.
constexpr int kMostNodes = 20;
// Strains (xx, yy, zz, xy, yz, zx) of displacement a by direction c.
constexpr int kStrain[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

FLEXURA_INLINE Eight* eights(std::vector<float>& v) {
  return reinterpret_cast<Eight*>(v.data());
}

// By the derivatives dN (m x 3) of a cell's functions and the places X (m x 3) of its nodes: J^-T (3 x 3), then det J; both are
// zero where it is not positive.
FLEXURA_INLINE void map_to_space(const float* dN, const Eight* X, int m, Eight* out) {
  Eight J[9] = {};
  for (int a = 0; a < m; ++a)
    for (int d = 0; d < 3; ++d)
      for (int c = 0; c < 3; ++c) J[3 * d + c] += dN[3 * a + d] * X[3 * a + c];
  for (int d = 0; d < 3; ++d)
    for (int c = 0; c < 3; ++c) {
      const int e = (d + 1) % 3, f = (d + 2) % 3, g = (c + 1) % 3, h = (c + 2) % 3;
      out[3 * d + c] = J[3 * e + g] * J[3 * f + h] - J[3 * e + h] * J[3 * f + g];
    }
  Eight det = J[0] * out[0] + J[1] * out[1] + J[2] * out[2], over{};
  for (int lane = 0; lane < EnrichedCells::kLanes; ++lane) {
    over[lane] = det[lane] > 0.0f ? 1.0f / det[lane] : 0.0f;
    det[lane] = std::max(det[lane], 0.0f);
  }
  for (int k = 0; k < 9; ++k) out[k] *= over;
  out[9] = det;
}

// integral g_i g_j^T dV (3 x 3) of functions i and j; g is n_points x n x 3, the weights are the last of ten in `map`.
FLEXURA_INLINE void gradient_products(const Eight* g, const Eight* map, int n_points, int n, int i, int j,
                                      Eight* H) {
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
          if (std::any_of(materials.begin(), materials.end(),
                          [&](const Material& m) { return m.D(i, j) != 0.0; }))
            terms_.push_back({a, b, 3 * c + d, 6 * i + j});
        }
  const auto lanes = [](std::size_t count) { return std::vector<float>(count * kLanes, 0.0f); };
  const int N = 3 * n();
  const std::size_t n_points = rule_.points.size();
  const auto& centre = solid_element(type).centre.points.front();
  for (int i = 0; i < m_; ++i)
    for (int d = 0; d < 3; ++d) centre_.push_back(static_cast<float>(centre.dN(i, d)));
  place_ = lanes(3 * m_);
  turn_ = lanes(3 * m_);
  map_ = lanes(10 * n_points);
  D_ = lanes(36);
  density_ = lanes(1);
  sign_ = lanes(static_cast<std::size_t>(n()));
  gradients_ = lanes(N * n_points);
  coupling_ = lanes(9 * g_ * m_);
  mass_ = lanes(g_ * m_);
  diagonal_ = lanes(3 * g_);
}

void EnrichedCells::take(const Cell (&cells)[kLanes]) {
  const auto n_points = static_cast<int>(rule_.points.size());
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto put = [lane](std::vector<float>& v, int k, double value) {
      v[k * kLanes + lane] = static_cast<float>(value);
    };
    const Cell& cell = cells[lane].x.rows() == 0 ? cells[0] : cells[lane];
    const Material& material = materials_[cell.material];
    put(density_, 0, material.density);
    const Eigen::RowVector3d middle = cell.x.colwise().mean();
    for (int a = 0; a < m_; ++a)
      for (int c = 0; c < 3; ++c) put(place_, 3 * a + c, cell.x(a, c) - middle(c));
    for (int k = 0; k < 36; ++k) put(D_, k, material.D(k / 6, k % 6));
    for (int i = 0; i < n(); ++i) put(sign_, i, cell.sign[static_cast<std::size_t>(i)]);
  }
  on_this_machine([&]() __attribute__((always_inline)) {
    const Eight *place = eights(place_), *sign = eights(sign_);
    Eight *map = eights(map_), *g = eights(gradients_), *turn = eights(turn_);
    Eight at_centre[10];
    map_to_space(centre_.data(), place, m_, at_centre);
    for (int a = 0; a < m_; ++a)
      for (int c = 0; c < 3; ++c)
        turn[3 * a + c] = 0.5f * (centre_[3 * a] * at_centre[c] + centre_[3 * a + 1] * at_centre[3 + c] +
                                  centre_[3 * a + 2] * at_centre[6 + c]);
    for (int q = 0; q < n_points; ++q, map += 10) {
      const float* dw = functions_.data() + n() * (4 * q + 1);
      map_to_space(dw + 3 * g_, place, m_, map);
      map[9] *= static_cast<float>(rule_.points[static_cast<std::size_t>(q)].weight);
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
  K_.resize(N * N * kLanes);
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

void EnrichedCells::residual(int lane, const double* u, const double* lambda, float* r) const {
  using Half = Lanes<kLanes>::Row;  // of 16 states
  on_this_machine([&]() __attribute__((always_inline)) {
    alignas(32) float strains[3 * kMostNodes * 16], inertia[3 * kMostNodes * 16];
    const float *place = place_.data() + lane, *turn = turn_.data() + lane;
    for (int half = 0; half < 16; half += kLanes) {
      const Half *U = reinterpret_cast<const Half*>(u + half),
                 *lambdas = reinterpret_cast<const Half*>(lambda + half);
      Half mean[3] = {}, c[3] = {};
      for (int a = 0; a < m_; ++a)
        for (int d = 0; d < 3; ++d) mean[d] += U[2 * (3 * a + d)];
      for (int d = 0; d < 3; ++d) mean[d] *= 1.0 / m_;
      for (int a = 0; a < m_; ++a) {  // half the curl at the centre
        const double g[3] = {turn[8 * (3 * a)], turn[8 * (3 * a + 1)], turn[8 * (3 * a + 2)]};
        const Half v[3] = {U[6 * a] - mean[0], U[6 * a + 2] - mean[1], U[6 * a + 4] - mean[2]};
        c[0] += g[1] * v[2] - g[2] * v[1];
        c[1] += g[2] * v[0] - g[0] * v[2];
        c[2] += g[0] * v[1] - g[1] * v[0];
      }
      for (int a = 0; a < m_; ++a) {
        const double x[3] = {place[8 * (3 * a)], place[8 * (3 * a + 1)], place[8 * (3 * a + 2)]};
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, f = (d + 2) % 3;
          const Half all = U[2 * (3 * a + d)], left = all - mean[d] - (c[e] * x[f] - c[f] * x[e]);
          *reinterpret_cast<Eight*>(strains + 16 * (3 * a + d) + half) = __builtin_convertvector(left, Eight);
          *reinterpret_cast<Eight*>(inertia + 16 * (3 * a + d) + half) =
              __builtin_convertvector(*lambdas * all, Eight);
        }
      }
    }
    const float *K = coupling_.data() + lane, *mass = mass_.data() + lane;
    for (int i = 0; i < g_; ++i) {
      Eight y[6] = {};
      const float *k0 = K + 8L * 9 * i * m_, *k1 = k0 + 8L * 3 * m_, *k2 = k1 + 8L * 3 * m_;
      for (int j = 0; j < 3 * m_; ++j) {
        const Eight* x = reinterpret_cast<const Eight*>(strains + 16 * j);
        y[0] -= k0[8 * j] * x[0];
        y[1] -= k0[8 * j] * x[1];
        y[2] -= k1[8 * j] * x[0];
        y[3] -= k1[8 * j] * x[1];
        y[4] -= k2[8 * j] * x[0];
        y[5] -= k2[8 * j] * x[1];
      }
      for (int a = 0; a < m_; ++a) {
        const Eight* x = reinterpret_cast<const Eight*>(inertia + 16 * 3 * a);
        const float density = mass[8L * (i * m_ + a)];
        for (int k = 0; k < 6; ++k) y[k] += density * x[k];
      }
      for (int k = 0; k < 6; ++k) *reinterpret_cast<Eight*>(r + 16 * 3 * i + 8 * k) = y[k];
    }
  });
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
