// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/petsc/log_stage.hpp"

#include <petscsys.h>

#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

// What goes wrong with a log is no reason to end a computation.
void push(const char* name) {
  PetscBool runs = PETSC_FALSE;
  if (PetscInitialized(&runs) != 0 || !runs) return;
  PetscLogStage stage = -1;
  if (PetscLogStageGetId(name, &stage) != 0) return;
  if (stage < 0 && PetscLogStageRegister(name, &stage) != 0) return doubt_petsc();
  PetscLogStagePush(stage);
}

void pop() {
  PetscBool runs = PETSC_FALSE;
  if (PetscInitialized(&runs) == 0 && runs) PetscLogStagePop();
}

}  // namespace

LogStage::LogStage(const char* name) {
  push(name);
}
LogStage::~LogStage() {
  pop();
}
void LogStage::next(const char* name) {
  pop();
  push(name);
}

}  // namespace flexura::linalg
