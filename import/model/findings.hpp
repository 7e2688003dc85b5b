// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "import/model/mechanism.hpp"

/// What a reader finds in a file of others that is not as it should be.
namespace flexura::import {

/// All faults of a file; what() is the only one, or how many there are.
class Faults : public std::invalid_argument {
 public:
  Faults(const std::string& what, std::vector<std::string> all)
      : std::invalid_argument(what), all_(std::move(all)) {}
  const std::vector<std::string>& all() const { return all_; }  ///< with their places; empty of a single one

 private:
  std::vector<std::string> all_;
};

/// Three kinds, by what they do to the motion: what changes nothing is a note, what everybody would mend alike a repair
/// (which --strict makes a fault), what leaves the motion open a fault.  Faults are collected and told together.
class Findings {
 public:
  explicit Findings(std::filesystem::path file, bool strict = false)
      : file_(std::move(file)), strict_(strict) {}

  const std::filesystem::path& file() const { return file_; }

  /// `kind` is what is counted, in the plural: "colours without a name".  `line` 0: of no single line.
  void note(const std::string& kind, const std::string& text, int line = 0);
  /// `text` gives the values before and after.
  void repair(const std::string& kind, const std::string& text, int line = 0);
  void fault(const std::string& text, int line = 0);

  /// What `read` gives; where it throws std::invalid_argument (with its place) the fault is kept, and `otherwise` given.
  template <class Read>
  auto kept(Read&& read, decltype(read()) otherwise = {}) {
    try {
      return read();
    } catch (const std::invalid_argument& why) {
      faults_.emplace_back(why.what());
      return otherwise;
    }
  }

  /// Throws Faults where there are any.
  void require_no_fault() const;

  using Kind = std::pair<std::string, std::vector<std::string>>;
  const std::vector<Kind>& kinds() const { return kinds_; }  ///< in the order of their first
  /// Sentences for the terminal: of each kind the first ones, and how many more.
  std::vector<std::string> told() const;
  /// All of them, for the file.
  std::vector<std::string> all() const;
  /// "212 notes: 104 colours without a name, ..."; empty without any.
  std::string count() const;

 private:
  std::string at(const std::string& text, int line) const;

  std::filesystem::path file_;
  bool strict_;
  std::vector<std::string> faults_;
  std::vector<Kind> kinds_;
};

/// The mechanism tells what was found: as sentences for the terminal and as comments at its head, with the table of names that
/// were changed.
void tell(const Findings& findings, Mechanism& mechanism);

}  // namespace flexura::import
