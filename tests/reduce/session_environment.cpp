// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <optional>

#include "reduce/linalg/session/session.hpp"

// PETSc starts once for the whole program.
namespace {

class PetscEnvironment : public testing::Environment {
 public:
  void SetUp() override { session_.emplace(); }
  void TearDown() override { session_.reset(); }

 private:
  std::optional<flexura::linalg::Session> session_;
};

[[maybe_unused]] const auto* const environment = testing::AddGlobalTestEnvironment(new PetscEnvironment);

}  // namespace
