// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/html/encode.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

static_assert(std::endian::native == std::endian::little, "the pages' blocks are little-endian");

namespace flexura::view {

namespace {

/// The edges of all triangles, sorted, so that equal edges are neighbours.
struct EdgeUse {
  std::int32_t low, high, triangle;
  auto operator<=>(const EdgeUse&) const = default;
};

}  // namespace

std::string base64(std::span<const unsigned char> data) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((data.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < data.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, data.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j) bits = bits << 8 | (j < left ? data[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= left ? digits[bits >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

std::string encode_block(std::span<const std::byte> data, std::size_t item_size) {
  const std::size_t items = data.size() / item_size;
  std::vector<unsigned char> planes(data.size());
  for (std::size_t plane = 0, out = 0; plane < item_size; ++plane) {
    for (std::size_t i = 0; i < items; ++i)
      planes[out++] = static_cast<unsigned char>(data[i * item_size + plane]);
  }
  std::vector<unsigned char> packed(compressBound(planes.size()));
  uLongf size = packed.size();
  if (compress2(packed.data(), &size, planes.data(), planes.size(), 6) != Z_OK) {
    throw std::runtime_error(
        fmt::format("zlib could not compress {} bytes for the page: not enough memory", planes.size()));
  }
  return base64(std::span(packed).first(size));
}

Traversal traverse(const Triangles& triangles) {
  const auto n = static_cast<std::int32_t>(triangles.rows());
  std::vector<EdgeUse> uses;
  uses.reserve(3 * static_cast<std::size_t>(n));
  for (std::int32_t t = 0; t < n; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto [low, high] = std::minmax({triangles(t, corner), triangles(t, (corner + 1) % 3)});
      uses.push_back({low, high, t});
    }
  }
  std::sort(uses.begin(), uses.end());
  // Neighbours across each edge; of more than two triangles on an edge, each meets the next in the sorted
  // list.
  std::vector<std::vector<std::int32_t>::size_type> first(static_cast<std::size_t>(n) + 1, 0);
  std::vector<std::pair<std::int32_t, std::int32_t>> links;
  for (std::size_t i = 1; i < uses.size(); ++i) {
    if (uses[i].low == uses[i - 1].low && uses[i].high == uses[i - 1].high) {
      links.emplace_back(uses[i - 1].triangle, uses[i].triangle);
      links.emplace_back(uses[i].triangle, uses[i - 1].triangle);
    }
  }
  std::sort(links.begin(), links.end());
  for (const auto& link : links) ++first[static_cast<std::size_t>(link.first) + 1];
  for (std::size_t t = 0; t < static_cast<std::size_t>(n); ++t) first[t + 1] += first[t];

  Traversal result;
  result.order.reserve(static_cast<std::size_t>(n));
  result.parent.reserve(static_cast<std::size_t>(n));
  std::vector<char> met(static_cast<std::size_t>(n), 0);
  for (std::int32_t seed = 0; seed < n; ++seed) {
    if (met[static_cast<std::size_t>(seed)]) continue;
    met[static_cast<std::size_t>(seed)] = 1;
    result.order.push_back(seed);
    result.parent.push_back(-1);
    for (std::size_t place = result.order.size() - 1; place < result.order.size(); ++place) {
      const auto t = static_cast<std::size_t>(result.order[place]);
      for (auto k = first[t]; k < first[t + 1]; ++k) {
        const std::int32_t next = links[k].second;
        if (met[static_cast<std::size_t>(next)]) continue;
        met[static_cast<std::size_t>(next)] = 1;
        result.order.push_back(next);
        result.parent.push_back(static_cast<std::int32_t>(place));
      }
    }
  }
  return result;
}

std::vector<Prediction> predictions(const Triangles& triangles, std::span<const std::int32_t> parent,
                                    int n_vertices) {
  std::vector<Prediction> result;
  result.reserve(static_cast<std::size_t>(n_vertices));
  std::vector<char> met(static_cast<std::size_t>(n_vertices), 0);
  std::int32_t last = -1;
  const auto meet = [&](std::int32_t v, std::int32_t a, std::int32_t b, std::int32_t c) {
    if (met[static_cast<std::size_t>(v)]) return;
    met[static_cast<std::size_t>(v)] = 1;
    result.push_back({v, a, b, c});
    last = v;
  };
  for (Eigen::Index k = 0; k < triangles.rows(); ++k) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::int32_t w = triangles(k, corner);
      const std::int32_t x = triangles(k, (corner + 1) % 3), y = triangles(k, (corner + 2) % 3);
      const std::int32_t p = parent[static_cast<std::size_t>(k)];
      if (p < 0) {
        meet(w, last, -1, -1);
        continue;
      }
      // The parent holds x and y when w is the corner off the shared edge; its third corner is c.
      std::int32_t c = -1;
      int shared = 0;
      for (int j = 0; j < 3; ++j) {
        const std::int32_t v = triangles(p, j);
        if (v == x || v == y) {
          ++shared;
        } else {
          c = v;
        }
      }
      if (shared == 2 && c >= 0) meet(w, x, y, c);
    }
  }
  for (std::int32_t v = 0; v < n_vertices; ++v) meet(v, last, -1, -1);
  return result;
}

EncodedField encode_field(const Eigen::Ref<const Eigen::VectorXf>& u, int components,
                          std::span<const Prediction> predictions, int levels) {
  if (!u.allFinite()) {
    throw std::invalid_argument(
        "a mode shape or its stress holds a value that is not finite (NaN or infinity)");
  }
  const std::size_t n = predictions.size(), width = static_cast<std::size_t>(components);
  const double largest = u.size() > 0 ? static_cast<double>(u.cwiseAbs().maxCoeff()) : 0.0;
  EncodedField result;
  result.scale = largest / levels;
  std::vector<std::uint16_t> q(width * n), rest(width * n);
  if (largest > 0.0) {
    const double factor = levels / largest;
    for (std::size_t i = 0; i < width * n; ++i) {
      // Two's complement modulo 2^16: differences wrap and come back exactly.
      q[i] = static_cast<std::uint16_t>(std::lround(u[static_cast<Eigen::Index>(i)] * factor));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Prediction& p = predictions[i];
    for (std::size_t c = 0; c < width; ++c) {
      const auto at = [&](std::int32_t v) -> int {
        return v < 0 ? 0 : q[width * static_cast<std::size_t>(v) + c];
      };
      const int guess = p.b < 0 ? at(p.a) : at(p.a) + at(p.b) - at(p.c);
      const auto difference = static_cast<std::int16_t>(static_cast<std::uint16_t>(at(p.vertex) - guess));
      // Zigzag: 0, -1, 1, -2, ... become 0, 1, 2, 3, ..., so small ones of either sign have a zero high byte.
      const int twice = 2 * difference;
      rest[c * n + i] = static_cast<std::uint16_t>(difference < 0 ? -twice - 1 : twice);
    }
  }
  result.text = encode_block(std::span<const std::uint16_t>(rest));
  return result;
}

}  // namespace flexura::view
