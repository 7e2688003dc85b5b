// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/input/content_hash.hpp"

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace flexura::input {

namespace fs = std::filesystem;

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
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::ostringstream whole;
  whole << in.rdbuf();
  const std::string text = whole.str();
  add(text);
  for (std::size_t at = 0; (at = text.find_first_of("\"'", at)) != std::string::npos;) {
    const std::size_t end = text.find_first_of(std::string(1, text[at]) + "\n", at + 1);
    if (end == std::string::npos) break;
    const std::string word = text.substr(at + 1, end - at - 1);
    std::error_code none;
    // A path is short and holds no wildcard; what names no file is no reference.
    if (!word.empty() && word.size() < 1024) {
      const fs::path named = file.parent_path() / word;
      if (fs::is_regular_file(named, none)) add(word).add_file(named);
    }
    at = end + 1;
  }
  return *this;
}

std::string ContentHash::hex() const {
  const XXH128_hash_t h = XXH3_128bits_digest(impl_->state);
  return fmt::format("{:016x}{:016x}", h.high64, h.low64);
}

}  // namespace flexura::input
