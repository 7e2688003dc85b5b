// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

/// The threads of a program: started when they are first wanted, asleep between uses, so that small pieces of work can be
/// shared.
namespace flexura::threads {

/// How many share work: what set_count() said, else the machine's cores.
int count();
/// n >= 1, from then on.  What is computed does not depend on it but for round-off where sums are shared.
void set_count(int n);

/// Calls work(0) ... work(n - 1), each once, on at most `most` threads (0: count()), this one among them.  The first exception
/// is thrown again here and ends the rest.  Called from within such work, or while another thread shares work, it runs on this
/// thread alone.  Where the system gives no more threads, those that there are do the work.
void parallel_for(int n, const std::function<void(int)>& work, int most = 0);

}  // namespace flexura::threads
