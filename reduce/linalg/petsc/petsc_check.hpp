// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Only for the .cpp files of this folder that see PETSc.
#include <petscsys.h>

#include <exception>
#include <stdexcept>

namespace flexura::linalg {

/// C++ exceptions do not travel through PETSc's C: what is thrown within one of its callbacks waits for the
/// petsc_check of the call that led there.  The first one counts.
void keep_exception(std::exception_ptr error);

/// The body of a callback.
template <class Work>
PetscErrorCode guarded(const Work& work) {
  try {
    work();
    return 0;
  } catch (...) {
    keep_exception(std::current_exception());
    return PETSC_ERR_LIB;
  }
}

/// An error of PETSc or SLEPc itself, not of one of our callbacks.
struct PetscFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Unless the code is zero: throws what a callback has thrown, or else PetscFailure("PETSc failed while
/// `doing`: `its message`").
void petsc_check(PetscErrorCode code, const char* doing);

/// False once memory has run out within PETSc: its objects may be half built, and destroying them may crash.
bool petsc_is_sound();
/// Something of PETSc's own is half built.
void doubt_petsc();

/// Throws std::logic_error unless a Session is alive.
void require_session();

}  // namespace flexura::linalg
