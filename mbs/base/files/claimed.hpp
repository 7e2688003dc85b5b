// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "mbs/base/files/lock.hpp"
#include "mbs/base/files/place.hpp"

/// The list behind inputs.hpp and output.hpp: what this process reads and writes.
namespace flexura::files {

struct Claimed {
  Claimed(const std::filesystem::path& output, const std::filesystem::path& place)
      : output(output), place(place), lock(place, output) {}
  std::filesystem::path output, place;  ///< as named; where it comes to lie
  Lock lock;
  bool by_command = false;
};

/// The claim on this output that there is, or a new one.
std::shared_ptr<Claimed> claim(const std::filesystem::path& output);

/// Throws std::invalid_argument where what lies at the output's place has been read.
void refuse_input(const std::filesystem::path& output, const std::filesystem::path& place);

}  // namespace flexura::files
