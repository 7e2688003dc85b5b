// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::mesh {

/// From here on this process may read files, compute, and write to the descriptors that it has: it starts no program, makes,
/// changes and removes no file, opens no connection, signals no other process (a seccomp filter of the calls that are
/// allowed; all others fail with EPERM).  It holds for every thread and until the end.  False where the kernel has no such
/// filters: then nothing has changed.
bool enter_sandbox();

}  // namespace flexura::mesh
