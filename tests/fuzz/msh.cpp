// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of gmsh's, read in the child: whatever becomes of that one, a mesh or a sentence comes back.
#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/mesh_file.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    mesh::read_mesh_file(fuzz::file_of("m.msh", fuzz::text_of(data, size)), FLEXURA_MESH_PROGRAM, 8.0);
  });
}
