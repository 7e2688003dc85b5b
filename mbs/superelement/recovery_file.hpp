// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/superelement.hpp"

/// The groups `stress` and `sections` of the file (FORMAT.md), and tables of any number of rows; for
/// file.cpp.
namespace flexura::superelement {

template <typename Matrix>
void write_rows(hdf5::Group& group, const std::string& name, const Matrix& rows, const std::string& unit,
                const std::string& doc) {
  group.write(name, {static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols())},
              rows.data(), unit, doc);
}

template <typename Matrix>
void read_rows(const hdf5::Group& group, const std::string& name, Matrix& rows) {
  const hdf5::Shape shape = group.shape(name);
  constexpr std::size_t most_rows = std::size_t{1} << 31;
  if (shape.size() != 2 || shape[0] > most_rows || static_cast<Eigen::Index>(shape[1]) != rows.cols()) {
    throw hdf5::BadFile(group.label() + "/" + name +
                        ": has the wrong shape; the file is damaged, make it again");
  }
  rows.resize(static_cast<Eigen::Index>(shape[0]), rows.cols());
  group.read(name, shape, rows.data());
}

void write_stress(hdf5::Group root, const StressModes& stress);
/// Leaves se.stress empty where the file has none.
void read_stress(const hdf5::Group& root, Superelement& se);

void write_sections(hdf5::Group root, const SectionForces& sections);
/// Leaves se.sections empty where the file has none.
void read_sections(const hdf5::Group& root, Superelement& se);

}  // namespace flexura::superelement
