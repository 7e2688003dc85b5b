// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::linalg {

/// PETSc, SLEPc and MPI are alive as long as a Session is.  They read no command line and no options file,
/// install no signal handlers, and their errors come out as std::runtime_error with one sentence.  Sessions
/// nest; MPI cannot be started again after the last one has ended (std::runtime_error), so keep one in
/// main().
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

/// How many processes an MPI launcher (mpirun, srun with PMI) started together, and which of them this is;
/// one process otherwise.  Read from the launcher's environment: needs no Session.
struct Launch {
  int rank = 0, size = 1;
};
Launch launch();

}  // namespace flexura::linalg
