// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the meshing child hands over: 8 bytes of length, JSON, arrays.
#include "mesh/gmsh/ask.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  // The length in front is ours, so that mutations reach what stands behind it.
  if (size < 1) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  const std::size_t end = std::min(text.find('\0'), text.size());
  const std::uint64_t length = data[0] < 250 ? end : data[0] * 1000000000000ull;
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof length);
  bytes += text;
  return fuzz::judged([&] { mesh::read_answer(bytes, data[0] % 2 ? 10 : 4); });
}
