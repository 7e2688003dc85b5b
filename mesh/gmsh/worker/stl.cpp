// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/stl.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace flexura::mesh {
namespace {

constexpr std::size_t kHead = 84, kTriangle = 50;  // bytes of a binary file

void require_few(std::size_t n, std::size_t most) {
  if (n > most)
    throw std::runtime_error("has more than " + std::to_string(most) +
                             " triangles, the most that are taken: save it coarser");
}

std::vector<double> read_binary(const std::string& bytes) {
  std::vector<double> corners;
  for (std::size_t at = kHead; at < bytes.size(); at += kTriangle) {
    float x[12];  // the normal first
    std::memcpy(x, bytes.data() + at, sizeof x);
    corners.insert(corners.end(), x + 3, x + 12);
  }
  return corners;
}

double number_in(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0')
    throw std::runtime_error("has a vertex whose coordinates are no numbers; save it again");
  return value;
}

std::vector<double> read_text(const std::string& text, std::size_t most) {
  std::vector<double> corners;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "vertex" || word == "VERTEX")
      for (int i = 0; i < 3; ++i) {
        word.clear();
        words >> word;
        corners.push_back(number_in(word));
      }
    if ((word == "endfacet" || word == "ENDFACET") && corners.size() % 9 != 0)
      throw std::runtime_error("has a facet that does not have three vertices; save it again");
    require_few(corners.size() / 9, most);
  }
  if (corners.size() % 9 != 0) throw std::runtime_error("ends within a facet; save it again");
  return corners;
}

}  // namespace

std::vector<double> read_stl(const std::string& path, std::size_t most) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::uint32_t n = 0;
  if (bytes.size() >= kHead) std::memcpy(&n, bytes.data() + kHead - sizeof n, sizeof n);
  // A text that begins with "solid" can be binary: the length tells.
  const bool is_binary =
      bytes.size() >= kHead && bytes.size() == kHead + kTriangle * static_cast<std::size_t>(n);
  if (is_binary) require_few(n, most);
  return is_binary ? read_binary(bytes) : read_text(bytes, most);
}

}  // namespace flexura::mesh
