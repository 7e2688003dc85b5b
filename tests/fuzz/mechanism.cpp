// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A mechanism file, and behind a zero byte the table t.csv that it may name.
#include "mbs/mechanism/mechanism.hpp"

#include "mbs/file/read_mechanism.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  const std::string text = fuzz::text_of(data, size);
  const std::size_t end = text.find('\0');
  if (end != std::string::npos) fuzz::file_of("t.csv", text.substr(end + 1));
  return fuzz::judged([&] {
    mbs::MechanismFile file = mbs::read_mechanism(fuzz::file_of("m.toml", text.substr(0, end)), {});
    const mbs::Mechanism mechanism(std::move(file.description));
  });
}
