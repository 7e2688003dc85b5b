// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <stdexcept>
#include <string>

#include "reduce/linalg/petsc/message.hpp"

namespace flexura::linalg {

/// The processes that MPI's launcher has started together: rank 0 leads, the others wait for what it calls
/// and do their share of it.  All of them must call the functions marked collective in the same order.  Needs
/// a Session on every rank for as long as it lives.
class Team {
 public:
  Team();
  /// On rank 0: sends the others home.
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// How many cores of its machine are a process's own while all of them work.
  int cores_each() const { return cores_each_; }

  /// What rank 0 calls the others to.
  enum class Task : int { stop, reduce, take_options, print_log, tell_memory };
  void call(Task task) const;  ///< on rank 0
  Task wait() const;           ///< on the others; sleeps meanwhile

  void send(const Message& message, int to) const;
  Message receive(int from) const;  ///< sleeps until it comes

  /// Does work in which the ranks wait for one another.  What goes wrong on one of them only would leave the
  /// others waiting for ever: it is printed, and all processes end with exit code 1.
  void together(const std::function<void()>& work) const;

  /// Does a long work of which all ranks do their parts, in step: each calls the same collectives.  What goes wrong on all of
  /// them, or is met by all at meet(), is thrown on all, by the rank that it happened to first as it was and by the others as
  /// std::invalid_argument or std::runtime_error with its text.  What goes wrong on one alone, which the others wait for
  /// within a collective, is printed, and all processes end with exit code 1; memory that runs out always is such.
  void in_step(const std::function<void()>& work) const;
  /// Collective, within in_step(): waits for the others without taking a core from them.
  void meet() const;

  /// Collective, within together(): a number of rank 0's to all.
  void share(int& number) const;
  void share(double& number) const;
  void share(std::span<double> numbers) const;  ///< of the same length on all
  /// Collective, within together(): adds up, for all.
  void sum(std::span<double> numbers) const;
  /// Collective, within together(): the greatest of all, for all.
  double greatest(double number) const;
  /// Collective, within together(): numbers (counts[r] of them for rank r, one after the other) from rank 0
  /// to all, and from all to rank 0.
  void scatter(const double* all, std::span<const int> counts, double* own) const;
  void gather(const double* own, std::span<const int> counts, double* all) const;

 private:
  /// Something has gone wrong on another rank.
  struct Elsewhere : std::runtime_error {
    bool bad_input;
    Elsewhere(const std::string& text, bool bad) : std::runtime_error(text), bad_input(bad) {}
  };
  void agree(const std::exception* failed) const;
  [[noreturn]] void end_all(const char* text) const;

  int rank_ = 0, size_ = 1, cores_each_ = 1;
};

}  // namespace flexura::linalg
