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

}  // namespace flexura::linalg
