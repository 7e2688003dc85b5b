// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace flexura::linalg {

/// Memory in which MUMPS keeps its fronts and its factor (its WK_USER), of which it is given back what the factor does not fill.
///
/// MUMPS' own workspace is as large as its estimate and some per cent beyond: too small, the factorisation fails and begins
/// anew; and it stays as large when the fronts are gone, 1.5 to 2 times the factor.  This one is address space, twice the
/// estimate: memory is what has been written to, the factor from the left and the fronts' updates from the right, and
/// what is right of the factor goes back to the system.
///
/// PETSc, which calls MUMPS, knows nothing of WK_USER: the call goes through a function of MUMPS' name in this program
/// (mumps_workspace.cpp), which gives the workspace to the factorisation that runs while one is lent().  Where calls do
/// not come by here (a library within another program) MUMPS has its own.
class MumpsWorkspace {
 public:
  MumpsWorkspace() = default;
  ~MumpsWorkspace();
  MumpsWorkspace(const MumpsWorkspace&) = delete;
  MumpsWorkspace& operator=(const MumpsWorkspace&) = delete;

  /// To the factorisations of this process for as long as it lives; the workspace itself must outlive their factors.
  class Lent {
   public:
    explicit Lent(MumpsWorkspace& workspace);
    ~Lent();
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;
  };

  /// Address space for so many numbers, all of it unwritten; null where the system has none.
  double* reserve(std::size_t numbers);
  /// The first ones are kept, memory of the others is given back.
  void keep(std::size_t numbers);
  std::size_t kept() const { return kept_; }

 private:
  double* begin_ = nullptr;
  std::size_t bytes_ = 0, kept_ = 0;
};

}  // namespace flexura::linalg
