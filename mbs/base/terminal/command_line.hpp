// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Command lines of both programs: options declared next to the variables they fill, help with examples,
/// refusals with "did you mean ...?", exit codes.  CLI11 stays inside command_line.cpp.
///
/// Exit codes: 0 done, 1 failed (a step that would not converge, a full disk), 2 bad input (command line,
/// files).
namespace flexura::terminal {

/// How much a program says.
struct Verbosity {
  bool quiet = false;    ///< errors only
  bool verbose = false;  ///< every detail
};

/// Declares the options of one command.  The variables must live until the command has run.
class Options {
 public:
  Options& argument(const std::string& name, std::string& value, const std::string& doc);  ///< must be given
  Options& optional_argument(const std::string& name, std::string& value, const std::string& doc);
  Options& arguments(const std::string& name, std::vector<std::string>& values,
                     const std::string& doc);  ///< 1 or more
  /// names: "-o,--output"; `what` names the value in the help: "FILE".
  Options& option(const std::string& names, std::string& value, const std::string& what,
                  const std::string& doc);
  Options& option(const std::string& names, int& value, const std::string& what, const std::string& doc);
  Options& option(const std::string& names, double& value, const std::string& what, const std::string& doc);
  /// May be given several times and takes several values each time.
  Options& option(const std::string& names, std::vector<std::string>& values, const std::string& what,
                  const std::string& doc);
  /// May stand without a value, and then has the value `bare`.
  Options& optional_value(const std::string& names, std::string& value, const std::string& bare,
                          const std::string& what, const std::string& doc);
  Options& choice(const std::string& names, std::string& value, const std::vector<std::string>& choices,
                  const std::string& doc);
  Options& flag(const std::string& names, bool& value, const std::string& doc);
  Options& required();  ///< the option declared last must be given
  /// An example for the end of the help.
  Options& example(const std::string& command, const std::string& what);

  struct Impl;
  explicit Options(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

 private:
  std::shared_ptr<Impl> impl_;
};

/// A command, or a program that has no commands.
struct Command {
  std::string name;
  std::string summary;
  /// Declares the options and returns what runs once they are read; its result is the exit code.
  std::function<std::function<int()>(Options&, const Verbosity&)> declare;
  /// A program beside this one (with its first word, if any) that reads the command's options itself; it is
  /// not asked to declare any here.
  std::string helper{};
};

struct Program {
  std::string name;
  std::string version;
  std::string summary;
  std::vector<Command> commands;
  std::vector<std::pair<std::string, std::string>> examples;  ///< command and what it does
  std::function<std::string()> details{};  ///< lines below the version: libraries, features
};

/// Reads the command line, runs the command and turns whatever is thrown into "error: ..." and an exit code.
/// Prepares the process for it: unfinished files go with every end (mbs/files), and standard output that
/// cannot be written is a failure. Every program also knows "completion" (a script for bash, zsh or fish) and
/// "man" (its manual page, or a command's), made of the same declarations.
int run(const Program& program, int argc, const char* const* argv);

/// The same for a program with a single purpose; "--list-options" prints its options for completion
/// scripts, "--manual-section" its part of the manual.
int run(const Command& command, const std::string& version, int argc, const char* const* argv);

/// What run() does with exceptions: input::InputError and std::invalid_argument are bad input (2), others
/// failures (1).
int guarded(const std::function<int()>& work);

}  // namespace flexura::terminal
