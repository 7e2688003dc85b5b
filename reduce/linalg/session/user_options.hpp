// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reduce/linalg/petsc/team.hpp"

/// Options of PETSc and SLEPc that a user gives as one text, "-eps_type krylovschur -eps_view" (docs/petsc.md).
namespace flexura::linalg {

struct UserOption {
  std::string name, value;  ///< the name with its dash, in small letters; an empty value where none is given
};

/// Takes the text apart.  std::invalid_argument, naming the option, for what a reduction does not take: options of
/// other things than solvers, options that decide what is computed (how many modes, which ones), and whatever reads
/// or writes files or runs programs, in every spelling that PETSc takes.
std::vector<UserOption> parse_options(const std::string& text);

/// In force from construction to destruction; one at a time.  Needs a Session.
class UserOptions {
 public:
  /// The options are tried on a small problem first: one that PETSc refuses, or that nothing asks for, is
  /// std::invalid_argument before the work begins.
  /// `team`, on rank 0: whose other ranks get them, too (take_options).  Options of solvers that a team does not use are
  /// refused.
  explicit UserOptions(std::vector<UserOption> options, const Team* team = nullptr);
  ~UserOptions();
  UserOptions(const UserOptions&) = delete;
  UserOptions& operator=(const UserOptions&) = delete;

  bool empty() const { return options_.empty(); }
  /// Reports that were asked for (-eps_view_..., -ksp_monitor...) and that nothing so far has given.
  std::vector<std::string> unused() const;
  bool has_log() const { return log_; }
  /// PETSc's table of where time went, if -log_view is among the options.
  void print_log() const;

 private:
  void rehearse() const;
  void share() const;
  void clear() const;
  std::vector<UserOption> options_;
  const Team* team_ = nullptr;
  bool log_ = false;
};

/// On the ranks that do not lead, when they are called to take_options: those of rank 0, in force until they are destroyed.
std::unique_ptr<UserOptions> take_options(const Team& team);

}  // namespace flexura::linalg
