// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/model/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace flexura::import {
namespace {

// Of one kind on a terminal.
constexpr std::size_t kMostTold = 3;

}  // namespace

std::string Findings::at(const std::string& text, int line) const {
  return line > 0 ? fmt::format("{}:{}: {}", file_.string(), line, text)
                  : fmt::format("{}: {}", file_.string(), text);
}

void Findings::note(const std::string& kind, const std::string& text, int line) {
  auto found = std::ranges::find(kinds_, kind, &Kind::first);
  if (found == kinds_.end()) found = kinds_.insert(kinds_.end(), {kind, {}});
  found->second.push_back(line > 0 ? fmt::format("line {}: {}", line, text) : text);
}

void Findings::repair(const std::string& kind, const std::string& text, int line) {
  if (strict_)
    fault(text + " (repaired without --strict)", line);
  else
    note(kind, text, line);
}

void Findings::fault(const std::string& text, int line) {
  faults_.push_back(at(text, line));
}

void Findings::require_no_fault() const {
  if (faults_.size() == 1) throw Faults(faults_.front(), {});
  if (!faults_.empty())
    throw Faults(
        fmt::format("{}: {} faults leave open how it moves; correct them", file_.string(), faults_.size()),
        faults_);
}

std::vector<std::string> Findings::told() const {
  std::vector<std::string> out;
  for (const auto& [kind, texts] : kinds_) {
    for (std::size_t i = 0; i < std::min(kMostTold, texts.size()); ++i) out.push_back(texts[i]);
    if (texts.size() > kMostTold)
      out.push_back(fmt::format("... and {} more {}", texts.size() - kMostTold, kind));
  }
  return out;
}

std::vector<std::string> Findings::all() const {
  std::vector<std::string> out;
  for (const auto& [kind, texts] : kinds_) out.insert(out.end(), texts.begin(), texts.end());
  return out;
}

std::string Findings::count() const {
  std::size_t n = 0;
  std::vector<std::pair<std::size_t, std::string>> kinds;
  for (const auto& [kind, texts] : kinds_) {
    n += texts.size();
    kinds.emplace_back(texts.size(), kind);
  }
  if (n == 0) return {};
  std::ranges::stable_sort(kinds, std::greater<>(), &std::pair<std::size_t, std::string>::first);
  std::vector<std::string> words;
  for (const auto& [k, kind] : kinds) words.push_back(fmt::format("{} {}", k, kind));
  return fmt::format("{} note{}: {}", n, n == 1 ? "" : "s", fmt::join(words, ", "));
}

void tell(const Findings& findings, Mechanism& mechanism) {
  const auto told = findings.told(), all = findings.all();
  mechanism.notes.insert(mechanism.notes.end(), told.begin(), told.end());
  mechanism.note_count = findings.count();
  for (const std::string& note : all) mechanism.comments.push_back("note: " + note);
  for (const auto& [theirs, ours] : mechanism.renamed)
    mechanism.comments.push_back(fmt::format("name: {} is {} here", theirs, ours));
}

}  // namespace flexura::import
