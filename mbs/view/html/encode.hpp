// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// How numbers travel in a page (PAGE.md gives the reader's side).
///
/// A block is an array of little-endian numbers of one size: its bytes are sorted into planes (all first
/// bytes, then all second bytes, ...: neighbouring numbers share their high bytes), deflated (zlib) and
/// written in base64.
///
/// A shape (or a stress) is a field on the vertices of a surface, quantised to 16 bits:
///
///     u_a(v) = scale q_a(v),    q_a(v) an integer,  |q| <= levels,    scale = max |u| / levels
///
/// and a smooth field on a fine mesh is nearly linear from triangle to triangle.  So each vertex is predicted
/// by the parallelogram rule (Touma and Gotsman, Triangle mesh compression, 1998): when the vertex w is first
/// met in the triangle (x, y, w) which shares the edge x y with the earlier triangle (x, y, c),
///
///     q(w) ~ q(x) + q(y) - q(c)
///
/// and only the difference is kept.  It is of second order in the mesh size: few bits are left for deflate.
namespace flexura::view {

/// Bytes as base64 text.
std::string base64(std::span<const unsigned char> data);

/// Base64 text of a deflated block; item_size is the size of one number in bytes.
std::string encode_block(std::span<const std::byte> data, std::size_t item_size);

template <typename T>
std::string encode_block(std::span<const T> values) {
  return encode_block(std::as_bytes(values), sizeof(T));
}

using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// An order of triangles in which each one, but the first of every connected piece, shares an edge with an
/// earlier one.
struct Traversal {
  std::vector<std::int32_t> order;   ///< n_t: numbers of triangles
  std::vector<std::int32_t> parent;  ///< n_t: place in `order` of that earlier triangle, or -1
};
Traversal traverse(const Triangles& triangles);

/// How the reader predicts vertex `vertex` from three met before: q_a + q_b - q_c, or q_a where b < 0, or 0.
struct Prediction {
  std::int32_t vertex, a, b, c;
};

/// One prediction for each vertex, in the order in which vertices are met along `triangles` (already in
/// traversal order); vertices without a triangle follow, each predicted by the one before.
std::vector<Prediction> predictions(const Triangles& triangles, std::span<const std::int32_t> parent,
                                    int n_vertices);

/// A quantised field ready for the page.
struct EncodedField {
  double scale = 0.0;  ///< u = scale q
  std::string text;    ///< block of unsigned 16-bit numbers: component 0 of all vertices in order of meeting,
                       ///< then 1, ...
};

/// u holds `components` numbers of vertex 0, then of vertex 1, ...; levels in 1..32767.
/// Throws std::invalid_argument when u holds a NaN or an infinity.
EncodedField encode_field(const Eigen::Ref<const Eigen::VectorXf>& u, int components,
                          std::span<const Prediction> predictions, int levels);

}  // namespace flexura::view
