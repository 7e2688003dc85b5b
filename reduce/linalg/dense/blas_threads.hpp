// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::linalg {

/// BLAS runs on one thread for as long as this lives (where BLAS is OpenBLAS): small products cost less than
/// waking its threads, which then wait by spinning in the way of others.
class OneBlasThread {
 public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int before_;
};

/// So many threads at most share work, BLAS' among them, for as long as this lives: where other processes work on the
/// machine's other cores.
class SomeCores {
 public:
  explicit SomeCores(int n);
  ~SomeCores();
  SomeCores(const SomeCores&) = delete;
  SomeCores& operator=(const SomeCores&) = delete;

 private:
  int before_, blas_before_;
};

/// So many threads from now on.
void set_blas_threads(int n);

/// Refuses (std::runtime_error) where the system would not give BLAS its work space for so many threads: OpenBLAS asks
/// again for ever then (its blas_memory_alloc, 128 MB of address space for each thread that is in BLAS at a time).
void require_blas_memory(int n_threads);

}  // namespace flexura::linalg
