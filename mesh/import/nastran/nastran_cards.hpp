// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mesh/import/builder.hpp"

/// The bulk data of a Nastran deck as cards, whatever their format: free field ("GRID,1,,0.,0.,0."), small
/// field (columns of 8) or large field ("GRID*", columns of 16).
namespace flexura::mesh {

struct Card {
  std::string name;  ///< upper case, without the star
  std::vector<std::string>
      fields;  ///< those after the name, trimmed; continuation lines start at multiples of 8
  Where where;

  const std::string& text(std::size_t k) const;  ///< "" beyond the end
  bool blank(std::size_t k) const { return text(k).empty(); }
  std::int64_t integer(std::size_t k) const;                          ///< throws where it is none
  std::int64_t integer(std::size_t k, std::int64_t otherwise) const;  ///< `otherwise` where blank
  double real(std::size_t k, double otherwise) const;                 ///< also "1.5+5" and "1.D3"
  double real(std::size_t k) const;
  bool is_real(std::size_t k) const;  ///< a number with a point
};

/// Cards from BEGIN BULK (or the start) to ENDDATA, INCLUDE files among them.  `names` keeps file names
/// alive.
std::vector<Card> read_cards(const std::filesystem::path& path, std::set<std::string>& names);

/// The lines before BEGIN BULK in capitals, without blanks and comments; none where nothing begins.
std::vector<std::string> case_control(const std::filesystem::path& path);

}  // namespace flexura::mesh
