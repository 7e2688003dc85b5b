// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "reduce/linalg/session/session.hpp"

namespace flexura::beam::testing {

/// Keeps PETSc alive: once for the whole program, MPI cannot be started twice.
class WithSession : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { static const linalg::Session session; }
};

}  // namespace flexura::beam::testing
