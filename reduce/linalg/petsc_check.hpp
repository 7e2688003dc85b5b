// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Only for the .cpp files of this folder that see PETSc.
#include <petscsys.h>

namespace flexura::linalg {

/// Throws std::runtime_error("PETSc failed while `doing`: `its message`") unless the code is zero.
void petsc_check(PetscErrorCode code, const char* doing);

/// Throws std::logic_error unless a Session is alive.
void require_session();

}  // namespace flexura::linalg
