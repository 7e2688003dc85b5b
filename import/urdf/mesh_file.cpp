// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "import/model/folder.hpp"
#include "import/urdf/collada.hpp"
#include "import/urdf/surface_builder.hpp"
#include "import/urdf/xml.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::import::urdf {
namespace {

namespace fs = std::filesystem;

void read_binary_stl(const std::string& bytes, SurfaceBuilder& builder) {
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, sizeof n);
  for (std::uint32_t t = 0; t < n; ++t) {
    float x[12];
    std::memcpy(x, bytes.data() + 84 + 50 * static_cast<std::size_t>(t), sizeof x);
    int corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = builder.vertex({x[3 + 3 * k], x[4 + 3 * k], x[5 + 3 * k]});
    builder.triangle(corner[0], corner[1], corner[2]);
  }
}

Vector3d read_point(std::istringstream& words, const SurfaceBuilder& builder) {
  Vector3d x;
  for (int k = 0; k < 3; ++k) {
    std::string word;
    words >> word;
    const auto value = parse_number(word);
    if (!value)
      builder.refuse(
          fmt::format("a vertex has \"{}\" where a number is wanted; is the file damaged?", shown(word)));
    x[k] = *value;
  }
  return x;
}

void read_text_stl(const std::string& text, SurfaceBuilder& builder) {
  std::istringstream lines(text);
  std::vector<int> corners;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "vertex") corners.push_back(builder.vertex(read_point(words, builder)));
    if (word == "endfacet") {
      if (corners.size() != 3)
        builder.refuse(fmt::format("a facet has {} vertices, 3 are wanted", corners.size()));
      builder.triangle(corners[0], corners[1], corners[2]);
      corners.clear();
    }
  }
}

void read_obj(const std::string& text, SurfaceBuilder& builder) {
  std::istringstream lines(text);
  std::vector<int> numbered;  // of the file's vertices, those that coincide are one
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      numbered.push_back(builder.vertex(read_point(words, builder)));
    } else if (word == "f") {
      std::vector<int> polygon;
      while (words >> word) {
        const auto number = parse_number(std::string_view(word).substr(0, word.find('/')));
        const double n = static_cast<double>(numbered.size());
        const double at = !number         ? -1.0
                          : *number < 0.0 ? n + *number
                                          : *number - 1.0;  // from 1, or from the end
        if (!(at >= 0.0) || !(at < n) || at != std::floor(at))
          builder.refuse(fmt::format("a face names vertex \"{}\" of {}", shown(word), numbered.size()));
        polygon.push_back(numbered[static_cast<std::size_t>(at)]);
      }
      for (std::size_t i = 2; i < polygon.size(); ++i)
        builder.triangle(polygon[0], polygon[i - 1], polygon[i]);
    }
  }
}

}  // namespace

Surface read_surface(const fs::path& file) {
  SurfaceBuilder builder(file);
  const std::string ending = ending_of(file);
  if (ending != ".stl" && ending != ".obj" && ending != ".dae")
    builder.refuse("is a mesh of a kind that is not read; save it as STL, OBJ, COLLADA (.dae) or STEP");
  files::note_input(file);
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in && bytes.empty()) builder.refuse("cannot be read; check the name");
  std::uint32_t n = 0;
  if (bytes.size() >= 84) std::memcpy(&n, bytes.data() + 80, sizeof n);
  // A text that begins with "solid" can be binary: the length tells.
  const bool is_binary =
      ending == ".stl" && bytes.size() >= 84 && bytes.size() == 84 + 50 * static_cast<std::size_t>(n);
  if (is_binary)
    read_binary_stl(bytes, builder);
  else if (ending == ".stl" && !bytes.starts_with("solid"))
    builder.refuse(
        "is neither a text STL (which begins with \"solid\") nor a binary one of the length that it states; "
        "save it again");
  else if (ending == ".stl")
    read_text_stl(bytes, builder);
  else if (ending == ".dae")
    read_collada(file, bytes, builder);
  else
    read_obj(bytes, builder);
  if (builder.surface.triangles.empty())
    builder.refuse("holds no triangle; save it again, or take the picture away");
  return builder.surface;
}

namespace {

// "NAME/PATH" of a package's or model's file, of any spelling that exporters have.
std::optional<std::string> in_package(const std::string& uri) {
  for (const std::string_view scheme : {"package://", "model://"})
    if (uri.starts_with(scheme)) return uri.substr(scheme.size());
  const auto find = uri.find("$(find "), end = uri.find(')');
  if (find == std::string::npos || end == std::string::npos || end < find) return {};
  return uri.substr(find + 7, end - find - 7) + uri.substr(end + 1);
}

}  // namespace

fs::path find_mesh(const std::string& written, const fs::path& urdf,
                   const std::vector<std::string>& packages) {
  std::string uri = written;
  std::ranges::replace(uri, '\\', '/');
  const fs::path folder = fs::absolute(urdf).parent_path();
  std::error_code failure;
  const auto found = [&](const fs::path& file) {
    if (!fs::is_regular_file(file, failure))
      throw std::invalid_argument(
          fmt::format("mesh \"{}\" is not there ({} is missing)", shown(uri), shown(file.string())));
    return file;
  };
  const auto rest = in_package(uri);
  if (!rest) {
    if (uri.starts_with("file://")) return found(uri.substr(7));
    if (uri.find("://") != std::string::npos)
      throw std::invalid_argument(
          fmt::format("mesh \"{}\" is not a file; package://, file:// and paths are", shown(uri)));
    return found(folder / uri);
  }
  const auto slash = rest->find('/');
  const std::string package = rest->substr(0, slash),
                    path = slash == std::string::npos ? "" : rest->substr(slash + 1);
  for (const std::string& given : packages)
    if (given.starts_with(package + "=")) return found(fs::path(given.substr(package.size() + 1)) / path);
  // The package beside the file or above it; else the file alone, where the package has another name here.
  fs::path missing, neighbour;
  for (fs::path at = folder;; at = at.parent_path()) {
    for (const fs::path& base : {at.filename() == package ? at : fs::path(), at / package}) {
      if (base.empty()) continue;
      if (fs::is_regular_file(base / path, failure)) return base / path;
      if (missing.empty() && fs::is_directory(base, failure)) missing = base / path;
    }
    if (neighbour.empty() && fs::is_regular_file(at / path, failure)) neighbour = at / path;
    if (at == at.parent_path()) break;
  }
  if (!neighbour.empty() && missing.empty()) return neighbour;
  return found(missing.empty() ? folder / package / path : missing);
}

}  // namespace flexura::import::urdf
