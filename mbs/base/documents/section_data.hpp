// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"

// What a Section holds: the checked values of one table.  Shared by check.cpp (fills it) and document.cpp
// (reads it).
namespace flexura::input {

struct Value {
  int line = 0;             // 0: from the command line or a default
  bool in_file = false;     // false: the default
  bool overridden = false;  // from the command line
  std::string shown;        // as it stands in the file, shortened, for messages

  std::string text;
  bool flag = false;
  std::vector<int> integers;
  std::vector<double> numbers;  // SI; a matrix by rows
  std::vector<std::string> texts;
  int n_columns = 0;
  std::vector<std::pair<std::string, std::shared_ptr<const Section::Data>>>
      tables;  // name (table_map) and content
};

struct Section::Data {
  std::shared_ptr<const std::filesystem::path> document;
  std::shared_ptr<const std::vector<std::string>> remarks;  // of the document
  std::string path;
  int line = 0;
  bool overridden = false;
  std::map<std::string, Kind> kinds;  // all keys of the schema, with those of the chosen variant
  std::map<std::string, Value> values;
};

// "engine.toml:12: joint[2].from", or "command line: joint[2].from" for an override.
std::string location(const std::filesystem::path& document, int line, bool overridden,
                     const std::string& path);

inline std::string join_path(const std::string& path, const std::string& key) {
  return path.empty() ? key : key.empty() ? path : path + "." + key;
}

// "<location> = <shown>: <rule>; <remedy>"
[[noreturn]] void refuse_value(const std::string& location, const std::string& shown, const std::string& rule,
                               const std::string& remedy);

}  // namespace flexura::input
