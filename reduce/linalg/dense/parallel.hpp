// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/threads/pool.hpp"

namespace flexura::linalg {

using threads::parallel_for;

inline int n_cores() {
  return threads::count();
}

}  // namespace flexura::linalg
