// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ida/ida_impl.h>

#include "mbs/solver/algebra/history.hpp"

namespace flexura::mbs {

/// Of IDA's own record all that a step leaves for the next: the divided differences of n states and what belongs to them
/// (SUNDIALS 6, ida_impl.h), the Newton iteration's memory.  Throws where what is read cannot be.
void remember_ida(History& history, IDAMemRec& record, long n);

}  // namespace flexura::mbs
