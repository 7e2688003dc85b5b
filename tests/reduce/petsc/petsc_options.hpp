// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <petscsys.h>

#include <string>
#include <utility>
#include <vector>

#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg::testing {

inline void ok(PetscErrorCode code) {
  petsc_check(code, "testing");
}

/// PETSc's options for as long as this lives.
class Options {
 public:
  explicit Options(const std::vector<std::pair<std::string, std::string>>& options) {
    for (const auto& [name, value] : options) {
      names_.push_back(name);
      ok(PetscOptionsSetValue(nullptr, name.c_str(), value.c_str()));
    }
  }
  Options(const char* name, const char* value)
      : Options(std::vector{std::pair<std::string, std::string>{name, value}}) {}
  ~Options() {
    for (const std::string& name : names_) PetscOptionsClearValue(nullptr, name.c_str());
  }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

 private:
  std::vector<std::string> names_;
};

}  // namespace flexura::linalg::testing
