// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/json_text.hpp"

#include <string>
#include <vector>

#include "mbs/base/files/plain_text.hpp"

namespace flexura::files {

template <class Json>
void make_plain(Json& value) {
  if (value.is_string()) {
    auto& text = value.template get_ref<std::string&>();
    if (!is_plain_text(text)) text = plain_text(text);
  } else if (value.is_object()) {
    std::vector<std::string> odd;
    for (auto& [key, member] : value.items()) {
      make_plain(member);
      if (!is_plain_text(key)) odd.push_back(key);
    }
    for (const std::string& key : odd) {
      Json member = std::move(value[key]);
      value.erase(key);
      value[plain_text(key)] = std::move(member);
    }
  } else if (value.is_array()) {
    for (Json& entry : value) make_plain(entry);
  }
}

namespace {

bool is_shallow(std::string_view text) {
  constexpr int kDeepest = 60;  // as of TOML files
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text && c == '\\')
      ++i;
    else if (c == '"')
      in_text = !in_text;
    else if (!in_text && (c == '[' || c == '{') && ++depth > kDeepest)
      return false;
    else if (!in_text && (c == ']' || c == '}'))
      --depth;
  }
  return true;
}

template <class Json>
Json read(std::string_view text, bool throws) {
  Json value = Json::parse(is_shallow(text) ? text : std::string_view(), nullptr, throws);
  make_plain(value);
  return value;
}

}  // namespace

template <class Json>
Json read_json(std::string_view text) {
  return read<Json>(text, true);
}

template <class Json>
Json try_read_json(std::string_view text) {
  return read<Json>(text, false);
}

template void make_plain(nlohmann::json&);
template nlohmann::json read_json(std::string_view);
template nlohmann::json try_read_json(std::string_view);
template nlohmann::ordered_json read_json(std::string_view);
template nlohmann::ordered_json try_read_json(std::string_view);

}  // namespace flexura::files
