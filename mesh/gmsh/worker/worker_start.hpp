// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

namespace flexura::mesh {

/// For the start of a child process in which foreign libraries read a file (flexura-mesh, flexura-assembly): bounds its
/// memory by the machine's, so that what a damaged file asks for ends in a refusal and not in other programs, and lets it
/// end with its parent, and closes every descriptor but those of job.hpp.  False where the parent has ended already.
bool start_worker(pid_t parent);

}  // namespace flexura::mesh
