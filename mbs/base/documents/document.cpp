// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/document.hpp"

#include <initializer_list>

#include "mbs/base/documents/section_data.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::input {
namespace {

void require_kind(const Section::Data& data, const std::string& key, std::initializer_list<Kind> kinds) {
  const auto found = data.kinds.find(key);
  if (found == data.kinds.end()) throw std::logic_error("the schema of " + data.path + " has no key " + key);
  for (const Kind kind : kinds) {
    if (found->second == kind) return;
  }
  throw std::logic_error("key " + join_path(data.path, key) +
                         " is asked for as another kind than its schema says");
}

const Value* find(const Section::Data& data, const std::string& key, std::initializer_list<Kind> kinds) {
  require_kind(data, key, kinds);
  const auto found = data.values.find(key);
  return found == data.values.end() ? nullptr : &found->second;
}

const Value& get(const Section::Data& data, const std::string& key, std::initializer_list<Kind> kinds) {
  if (const Value* value = find(data, key, kinds)) return *value;
  throw InputError(location(*data.document, data.line, data.overridden, join_path(data.path, key)) +
                   ": is missing; it is needed here");
}

}  // namespace

std::string location(const std::filesystem::path& document, int line, bool overridden,
                     const std::string& path) {
  std::string text = overridden ? "command line" : document.string();
  if (!overridden && line > 0) text += ":" + std::to_string(line);
  return path.empty() ? text : text + ": " + shown_text(path, 120);
}

void refuse_value(const std::string& location, const std::string& shown, const std::string& rule,
                  const std::string& remedy) {
  std::string message = location;
  if (!shown.empty()) message += " = " + shown;
  message += ": " + rule;
  // A suggestion brings its own punctuation.
  if (!remedy.empty()) message += (remedy.starts_with(",") || remedy.starts_with(";") ? "" : "; ") + remedy;
  throw InputError(message);
}

Section::Section(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

bool Section::has(const std::string& key) const {
  const auto found = data_->values.find(key);
  return found != data_->values.end() && found->second.in_file;
}

bool Section::is_from_command_line(const std::string& key) const {
  const auto found = data_->values.find(key);
  return found != data_->values.end() && found->second.overridden;
}

std::string Section::text(const std::string& key) const {
  return get(*data_, key, {Kind::text, Kind::choice, Kind::expression}).text;
}
std::string Section::title() const {
  constexpr std::size_t longest = 200;  // as names
  return shown_text(has("name") ? text("name") : document().stem().string(), longest);
}
bool Section::flag(const std::string& key) const {
  return get(*data_, key, {Kind::flag}).flag;
}
int Section::integer(const std::string& key) const {
  return get(*data_, key, {Kind::integer}).integers.front();
}
double Section::quantity(const std::string& key) const {
  return get(*data_, key, {Kind::quantity}).numbers.front();
}

Eigen::Vector3d Section::vector3(const std::string& key) const {
  return Eigen::Map<const Eigen::Vector3d>(get(*data_, key, {Kind::vector3}).numbers.data());
}

Eigen::Vector4d Section::quaternion(const std::string& key) const {
  return Eigen::Map<const Eigen::Vector4d>(get(*data_, key, {Kind::quaternion}).numbers.data());
}

std::vector<std::string> Section::texts(const std::string& key) const {
  const Value* value = find(*data_, key, {Kind::texts});
  return value ? value->texts : std::vector<std::string>{};
}

std::vector<int> Section::integers(const std::string& key) const {
  const Value* value = find(*data_, key, {Kind::integers});
  return value ? value->integers : std::vector<int>{};
}

Selection Section::selection(const std::string& key) const {
  const Value* value = find(*data_, key, {Kind::selection});
  if (value == nullptr) return {};
  if (value->flag) return {.numbers = value->integers};
  return {.first = value->integers.front()};
}

std::vector<double> Section::quantities(const std::string& key) const {
  const Value* value = find(*data_, key, {Kind::quantities});
  return value ? value->numbers : std::vector<double>{};
}

std::vector<Eigen::Vector3d> Section::vectors3(const std::string& key) const {
  std::vector<Eigen::Vector3d> vectors;
  if (const Value* value = find(*data_, key, {Kind::vectors3})) {
    for (std::size_t i = 0; i + 2 < value->numbers.size(); i += 3) {
      vectors.emplace_back(value->numbers[i], value->numbers[i + 1], value->numbers[i + 2]);
    }
  }
  return vectors;
}

Eigen::MatrixXd Section::matrix(const std::string& key) const {
  const Value& value = get(*data_, key, {Kind::matrix});
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Index n_columns = value.n_columns;
  const Eigen::Index n_rows = n_columns ? static_cast<Eigen::Index>(value.numbers.size()) / n_columns : 0;
  return Eigen::Map<const RowMajor>(value.numbers.data(), n_rows, n_columns);
}

Section Section::table(const std::string& key) const {
  return Section(get(*data_, key, {Kind::table}).tables.front().second);
}

std::vector<Section> Section::tables(const std::string& key) const {
  std::vector<Section> sections;
  if (const Value* value = find(*data_, key, {Kind::tables})) {
    for (const auto& [name, data] : value->tables) sections.emplace_back(data);
  }
  return sections;
}

std::vector<std::pair<std::string, std::string>> Section::formulas(const std::string& key) const {
  std::vector<std::pair<std::string, std::string>> formulas;
  if (const Value* value = find(*data_, key, {Kind::formulas})) {
    for (std::size_t i = 0; i + 1 < value->texts.size(); i += 2)
      formulas.emplace_back(value->texts[i], value->texts[i + 1]);
  }
  return formulas;
}

std::vector<std::pair<std::string, Section>> Section::table_map(const std::string& key) const {
  std::vector<std::pair<std::string, Section>> sections;
  if (const Value* value = find(*data_, key, {Kind::table_map})) {
    for (const auto& [name, data] : value->tables) sections.emplace_back(name, Section(data));
  }
  return sections;
}

const std::vector<std::string>& Section::remarks() const {
  return *data_->remarks;
}

const std::string& Section::path() const {
  return data_->path;
}
const std::filesystem::path& Section::document() const {
  return *data_->document;
}

std::filesystem::path Section::file(const std::string& key) const {
  const std::filesystem::path named =
      document().parent_path() / text(key);  // an absolute path replaces the folder
  files::note_input(named);
  return named;
}

std::string Section::where(const std::string& key) const {
  const auto found = data_->values.find(key);
  const bool here = found != data_->values.end() && found->second.in_file;
  return location(*data_->document, here ? found->second.line : data_->line,
                  here ? found->second.overridden : data_->overridden, join_path(data_->path, key));
}

void Section::refuse(const std::string& key, const std::string& rule, const std::string& remedy) const {
  const auto found = data_->values.find(key);
  refuse_value(where(key), found == data_->values.end() ? "" : found->second.shown, rule, remedy);
}

}  // namespace flexura::input
