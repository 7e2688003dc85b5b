// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/content_hash.hpp"

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "mbs/base/files/inputs.hpp"

namespace flexura::input {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  files::require_no_device(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::ostringstream whole;
  whole << in.rdbuf();
  return whole.str();
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// What stands in quotes on one line: names of files in our own formats and in Nastran's INCLUDE.
std::vector<std::string> quoted_words(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = text.find_first_of("\"'", at)) != std::string::npos;) {
    const std::size_t end = text.find_first_of(std::string(1, text[at]) + "\n", at + 1);
    if (end == std::string::npos) break;
    words.push_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return words;
}

// "*INCLUDE, INPUT=FILE" of Abaqus, "INCLUDE FILE" of Nastran.
std::vector<std::string> included_words(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string small = lower(line.substr(0, 200));
    const std::size_t first = small.find_first_not_of(" \t*");
    if (first == std::string::npos || small.compare(first, 7, "include") != 0) continue;
    const std::size_t input = small.find("input");
    std::string word = line.substr(input != std::string::npos ? input + 5 : first + 7);
    for (const char c : {'=', '\'', '"', '\r', ' ', '\t', ','}) std::erase(word, c);
    words.push_back(word);
  }
  return words;
}

void gather(const std::string& named, const fs::path& file, std::vector<InputFile>& all) {
  if (std::ranges::any_of(all, [&](const InputFile& known) { return known.path == file; })) return;
  all.push_back({named, file});
  const std::string ending = lower(file.extension().string());
  const bool is_deck =
      ending == ".inp" || ending == ".inc" || ending == ".nas" || ending == ".bdf" || ending == ".dat";
  if (all.size() > 1 && ending != ".toml" && !is_deck) return;  // a CAD file, a superelement, a table
  const std::string text = text_of(file);
  std::vector<std::string> words = is_deck ? included_words(text) : quoted_words(text);
  for (const std::string& word : words) {
    std::error_code none;
    // A path is short and holds no wildcard; what names no file is no reference.
    if (word.empty() || word.size() >= 1024) continue;
    const fs::path at = file.parent_path() / word;
    if (fs::is_regular_file(at, none)) gather(word, at, all);
  }
}

}  // namespace

std::vector<InputFile> input_files(const fs::path& file) {
  std::vector<InputFile> all;
  gather("", file, all);
  return all;
}

struct ContentHash::Impl {
  XXH3_state_t* state = XXH3_createState();
  Impl() { XXH3_128bits_reset(state); }
  ~Impl() { XXH3_freeState(state); }
};

ContentHash::ContentHash() : impl_(std::make_unique<Impl>()) {}
ContentHash::~ContentHash() = default;

ContentHash& ContentHash::add(std::string_view text) {
  const std::uint64_t length = text.size();
  XXH3_128bits_update(impl_->state, &length, sizeof length);
  XXH3_128bits_update(impl_->state, text.data(), text.size());
  return *this;
}

ContentHash& ContentHash::add_file(const fs::path& file) {
  files::require_no_device(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::array<char, 1 << 16> block;
  std::uint64_t length = 0;
  while (in) {
    in.read(block.data(), block.size());
    XXH3_128bits_update(impl_->state, block.data(), static_cast<std::size_t>(in.gcount()));
    length += static_cast<std::uint64_t>(in.gcount());
  }
  XXH3_128bits_update(impl_->state, &length, sizeof length);
  return *this;
}

ContentHash& ContentHash::add_input_file(const fs::path& file) {
  for (const InputFile& input : input_files(file)) {
    add(input.named);
    add_file(input.path);
  }
  return *this;
}

std::string ContentHash::hex() const {
  const XXH128_hash_t h = XXH3_128bits_digest(impl_->state);
  return fmt::format("{:016x}{:016x}", h.high64, h.low64);
}

}  // namespace flexura::input
