// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/read_mechanism.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mbs {

/// Mechanism files written in the test and read without their [solver].
class MechanismFileTest : public test::TestFolder {
 protected:
  MechanismFile read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    input::TableSchema no_solver;
    no_solver.name = "solver";
    return read_mechanism(file(text), no_solver, overrides);
  }
  std::string refusal(const std::string& text) const {
    return test::refusal_of([&] { read(text); });
  }
};

}  // namespace flexura::mbs
