// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/exchange/polydata.hpp"

#include <fmt/format.h>

#include <cstring>
#include <stdexcept>
#include <vector>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

namespace flexura::superelement::exchange {
namespace {

// The number of bytes as UInt64, then the bytes.
template <typename T>
std::string data_block(const T* values, std::size_t count) {
  const std::uint64_t size = count * sizeof(T);
  std::string bytes(sizeof size + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values, size);
  return base64(bytes);
}

template <typename T>
void data_array(std::string& out, const char* type, const std::string& name, int components, const T* values,
                std::size_t count) {
  out += fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n{}\n</DataArray>\n",
      type, escape_xml(name), components, data_block(values, count));
}

void cells(std::string& out, const char* name, const std::int32_t* connectivity, std::size_t n,
           std::int32_t corners) {
  out += fmt::format("<{}>\n", name);
  data_array(out, "Int32", "connectivity", 1, connectivity, static_cast<std::size_t>(corners) * n);
  std::vector<std::int32_t> offsets(n);
  for (std::size_t i = 0; i < n; ++i) offsets[i] = corners * static_cast<std::int32_t>(i + 1);
  data_array(out, "Int32", "offsets", 1, offsets.data(), n);
  out += fmt::format("</{}>\n", name);
}

void require_size(Eigen::Index found, std::size_t expected, const std::string& name) {
  if (found != static_cast<Eigen::Index>(expected)) {
    throw std::invalid_argument(
        fmt::format("the array \"{}\" for VTK has {} numbers, it must have {}", name, found, expected));
  }
}

}  // namespace

std::string escape_xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

PolyData::PolyData(const Points& points,
                   const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>& triangles,
                   const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>& lines)
    : n_points_(static_cast<std::size_t>(points.rows())),
      n_triangles_(static_cast<std::size_t>(triangles.rows())),
      n_lines_(static_cast<std::size_t>(lines.rows())) {
  geometry_ = "<Points>\n";
  data_array(geometry_, "Float64", "Points", 3, points.data(), 3 * n_points_);
  geometry_ += "</Points>\n";
  cells(geometry_, "Lines", lines.data(), n_lines_, 2);
  cells(geometry_, "Polys", triangles.data(), n_triangles_, 3);
}

void PolyData::add_point_array(const std::string& name, int components,
                               const Eigen::Ref<const Eigen::VectorXf>& values) {
  require_size(values.size(), static_cast<std::size_t>(components) * n_points_, name);
  data_array(point_data_, "Float32", name, components, values.data(),
             static_cast<std::size_t>(values.size()));
}

void PolyData::add_cell_array(const std::string& name, const Eigen::VectorXi& values) {
  require_size(values.size(), n_lines_ + n_triangles_, name);
  data_array(cell_data_, "Int32", name, 1, values.data(), static_cast<std::size_t>(values.size()));
}

void PolyData::add_field(const std::string& name, double value) {
  field_data_ += fmt::format(
      "<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"1\" format=\"binary\">\n{}\n</DataArray>\n",
      escape_xml(name), data_block(&value, 1));
}

void PolyData::write(const std::filesystem::path& path) const {
  write_whole(
      path, fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
                        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n"
                        "<FieldData>\n{}</FieldData>\n"
                        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" "
                        "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<PointData>\n{}</PointData>\n"
                        "<CellData>\n{}</CellData>\n{}</Piece>\n</PolyData>\n</VTKFile>\n",
                        field_data_, n_points_, n_lines_, n_triangles_, point_data_, cell_data_, geometry_));
}

}  // namespace flexura::superelement::exchange
