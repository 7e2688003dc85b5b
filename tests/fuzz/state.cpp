// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A state file, with and without a history, for a mechanism with a joint, a control and a switch.
#include "mbs/file/read_mechanism.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/start/continuation_file.hpp"
#include "mbs/solver/start/state_file.hpp"
#include "tests/fuzz/judge.hpp"

namespace {

const flexura::mbs::Mechanism& mechanism() {
  using namespace flexura;
  static const mbs::Mechanism made(
      mbs::read_mechanism(FLEXURA_SOURCE_DIR "/tests/fuzz/ball.toml", {}).description);
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  const auto file = fuzz::file_of("s.json", fuzz::text_of(data, size));
  fuzz::judged([&] { mbs::require_whole_continuation(file); });
  return fuzz::judged([&] {
    mbs::State s = mechanism().initial_state();
    mbs::read_state(file, mechanism(), s);
    if (!s.p.allFinite() || !s.v.allFinite()) fuzz::found("a state that is not finite", "");
  });
}
