// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Triangles of a robot's pictures: the same bytes as STL and as OBJ.
#include "import/urdf/mesh_file.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  const std::string text = fuzz::text_of(data, size);
  fuzz::judged([&] { import::urdf::read_surface(fuzz::file_of("s.stl", text)); });
  return fuzz::judged([&] { import::urdf::read_surface(fuzz::file_of("s.obj", text)); });
}
