// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>

namespace flexura::superelement::exchange {

/// VTK XML PolyData (docs.vtk.org, "VTK XML file formats"), one piece, with inline base64 data:
/// points, triangles, lines and arrays on points and cells.  Cells are numbered lines first, then triangles.
class PolyData {
 public:
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  /// `triangles` n x 3 and `lines` n x 2, by rows; either may be empty.
  PolyData(const Points& points,
           const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>& triangles,
           const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>& lines = {});

  /// `values`: `components` numbers for each point, point after point.
  void add_point_array(const std::string& name, int components,
                       const Eigen::Ref<const Eigen::VectorXf>& values);
  /// One number for each cell.
  void add_cell_array(const std::string& name, const Eigen::VectorXi& values);
  /// A number that belongs to the whole file, like the time.
  void add_field(const std::string& name, double value);

  /// Writes beside and renames.  Throws std::runtime_error when the file system refuses.
  void write(const std::filesystem::path& path) const;

 private:
  std::size_t n_points_, n_triangles_, n_lines_;
  std::string geometry_, point_data_, cell_data_, field_data_;
};

/// Text as it may stand in an XML attribute.
std::string escape_xml(const std::string& text);

}  // namespace flexura::superelement::exchange
