// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/unv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <stdexcept>

#include "mbs/base/files/inputs.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {
namespace {

const CellRecord* solid_of(int descriptor) {
  const auto found = std::ranges::find_if(
      cell_records(), [&](const CellRecord& record) { return record.foreign.unv == descriptor; });
  return found == cell_records().end() ? nullptr : &*found;
}

bool is_surface(int descriptor) {
  return (descriptor >= 41 && descriptor <= 96);
}
bool is_beam(int descriptor) {
  return descriptor >= 11 && descriptor <= 32;
}

class Reader {
 public:
  ImportedModel read(const std::filesystem::path& path) {
    name_ = path.string();
    require_file(path);
    files::note_input(path);
    file_.open(path);
    if (!file_) throw std::invalid_argument(name_ + ": no such file, or it cannot be read");
    while (next()) {
      if (words() != std::vector<std::string>{"-1"})
        throw std::invalid_argument(
            fmt::format("{}: a dataset's opening -1 is wanted; not a universal file?", here().text()));
      if (!next()) break;
      const Where where = here();
      const std::int64_t dataset = words().empty() ? 0 : integer(0);
      if (dataset == 2411)
        read_nodes();
      else if (dataset == 2412)
        read_elements();
      else if (dataset == 2435 || dataset == 2452 || dataset == 2467 || dataset == 2477)
        read_groups();
      else {
        if (dataset != 151 && dataset != 164 && dataset != 2420) unused_.add(std::to_string(dataset), where);
        while (next() && !at_end()) {
        }
      }
    }
    if (builder_.cells().empty())
      throw std::invalid_argument(name_ + ": holds no solid elements (datasets 2411 and 2412)");
    for (const auto& [set, entities] : groups_) make_set(set, entities);
    for (const std::string& message : unused_.messages("dataset")) model_.messages.push_back(message);
    builder_.finish(model_);
    return std::move(model_);
  }

 private:
  bool next() {
    words_.clear();
    while (words_.empty()) {
      if (!std::getline(file_, line_)) return false;
      ++number_;
      line_ = plain_line(std::move(line_), here());
      for (std::size_t k = 0; k < line_.size();) {
        const std::size_t begin = line_.find_first_not_of(" \t\r", k);
        if (begin == std::string::npos) break;
        k = std::min(line_.find_first_of(" \t\r", begin), line_.size());
        words_.push_back(line_.substr(begin, k - begin));
      }
    }
    return true;
  }
  /// The next line of a record that must be there.
  void want() {
    if (!next()) throw std::invalid_argument(name_ + ": ends within a dataset; cut short?");
  }
  const std::vector<std::string>& words() const { return words_; }
  bool at_end() const { return words_.size() == 1 && words_[0] == "-1"; }
  Where here() const { return {&name_, number_}; }

  std::int64_t integer(std::size_t k) const {
    std::int64_t value = 0;
    if (k >= words_.size())
      throw std::invalid_argument(fmt::format("{}: {} whole numbers are wanted", here().text(), k + 1));
    const std::string& word = words_[k];
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      throw std::invalid_argument(
          fmt::format("{}: \"{}\" is not a whole number", here().text(), word.substr(0, 40)));
    return value;
  }

  double real(std::size_t k) const {
    if (k >= words_.size())
      throw std::invalid_argument(fmt::format("{}: {} numbers are wanted", here().text(), k + 1));
    std::string word = words_[k];
    std::replace_if(
        word.begin(), word.end(), [](char c) { return c == 'D' || c == 'd'; }, 'e');
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      throw std::invalid_argument(
          fmt::format("{}: \"{}\" is not a number", here().text(), words_[k].substr(0, 40)));
    return value;
  }

  void read_nodes() {
    while (next() && !at_end()) {
      const std::int64_t label = integer(0);
      want();
      builder_.add_node(0, label, {real(0), real(1), real(2)}, here());
    }
  }

  void read_elements() {
    while (next() && !at_end()) {
      const Where where = here();
      const std::int64_t label = integer(0);
      const int descriptor = static_cast<int>(integer(1));
      const auto n = static_cast<std::size_t>(integer(5));
      if (is_beam(descriptor)) want();  // orientation and sections
      std::vector<Index> nodes;
      while (nodes.size() < n) {
        want();
        for (std::size_t k = 0; k < words_.size() && nodes.size() < n; ++k)
          nodes.push_back(builder_.node(0, integer(k), here()));
      }
      element_nodes_[label] = nodes;
      const CellRecord* const solid = solid_of(descriptor);
      if (!solid) {
        if (!is_surface(descriptor))
          unused_.add(fmt::format("2412 elements of descriptor {}", descriptor), where);
        continue;
      }
      const std::vector<int>& order = solid->foreign.unv_order;
      const auto n_wanted = static_cast<std::size_t>(solid->nodes.rows());
      if (n_wanted != n)
        throw std::invalid_argument(fmt::format("{}: element {} of descriptor {} has {} nodes instead of {}",
                                                where.text(), label, descriptor, n, n_wanted));
      std::vector<Index> ordered;
      for (std::size_t k = 0; k < n; ++k)
        ordered.push_back(nodes[order.empty() ? k : static_cast<std::size_t>(order[k])]);
      builder_.add_cell(0, solid->type, label, std::move(ordered), where);
    }
  }

  /// Header of eight numbers (the last counts members), name, members as (type, tag, leaf, component), two a
  /// line.
  void read_groups() {
    while (next() && !at_end()) {
      const std::int64_t number = integer(0), count = integer(7);
      want();
      std::string name = line_.substr(0, line_.find_last_not_of(" \t\r") + 1);
      name.erase(0, name.find_first_not_of(" \t"));
      if (name.empty()) name = "group " + std::to_string(number);
      auto& entities = groups_[name];
      for (std::int64_t left = count; left > 0;) {
        want();
        for (std::size_t k = 0; k + 1 < words_.size() && left > 0; k += 4, --left)
          entities.emplace_back(integer(k), integer(k + 1));
      }
    }
  }

  void make_set(const std::string& name, const std::vector<std::pair<std::int64_t, std::int64_t>>& entities) {
    std::vector<Index> nodes;
    for (const auto& [type, tag] : entities) {
      if (type == 7 && builder_.has_node(0, tag)) nodes.push_back(builder_.node(0, tag, {}));
      if (type != 8) continue;
      if (const auto found = element_nodes_.find(tag); found != element_nodes_.end())
        nodes.insert(nodes.end(), found->second.begin(), found->second.end());
    }
    builder_.add_to_set(name, nodes);
  }

  ImportedModel model_;
  ModelBuilder builder_;
  Unused unused_;
  std::string name_, line_;
  std::ifstream file_;
  std::vector<std::string> words_;
  int number_ = 0;
  std::map<std::int64_t, std::vector<Index>> element_nodes_;
  std::map<std::string, std::vector<std::pair<std::int64_t, std::int64_t>>> groups_;
};

}  // namespace

ImportedModel read_unv(const std::filesystem::path& path) {
  return Reader().read(path);
}

}  // namespace flexura::mesh
