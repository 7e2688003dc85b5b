// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/preparation_cache.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "mbs/superelement/text_file.hpp"

namespace flexura::mbs {
namespace {

namespace fs = std::filesystem;
using Matrices = PreparationCache::Matrices;

constexpr std::string_view kOpening = "flexura prepared body 1\n";
constexpr std::size_t kHashLength = 32;

std::string_view bytes_of(const void* x, std::size_t n) {
  return {static_cast<const char*>(x), n};
}

std::string packed(const Matrices& matrices) {
  std::string out(kOpening);
  for (const Eigen::MatrixXd& x : matrices) {
    const std::int64_t size[2] = {x.rows(), x.cols()};
    out += bytes_of(size, sizeof size);
    out += bytes_of(x.data(), sizeof(double) * static_cast<std::size_t>(x.size()));
  }
  return out + input::ContentHash().add(out).hex();
}

/// Nothing where the text is not whole.
std::optional<Matrices> unpacked(const std::string& text) {
  if (text.size() < kOpening.size() + kHashLength || !text.starts_with(kOpening)) return std::nullopt;
  const std::string_view content(text.data(), text.size() - kHashLength);
  if (!text.ends_with(input::ContentHash().add(content).hex())) return std::nullopt;
  Matrices out;
  for (std::size_t at = kOpening.size(); at < content.size();) {
    std::int64_t size[2];
    content.copy(reinterpret_cast<char*>(size), sizeof size, at);
    at += sizeof size;
    Eigen::MatrixXd x(size[0], size[1]);
    const std::size_t n = sizeof(double) * static_cast<std::size_t>(x.size());
    content.copy(reinterpret_cast<char*>(x.data()), n, at);
    at += n;
    out.push_back(std::move(x));
  }
  return out;
}

std::optional<Matrices> read_entry(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  std::ostringstream text;
  text << in.rdbuf();
  return unpacked(text.str());
}

// A folder that takes no files costs time only.  Where two programs have the same entry to write, it holds the
// same numbers, and one of them suffices; a half of them is not taken for whole.
void write_entry(const fs::path& file, const Matrices& matrices) {
  std::error_code none;
  fs::create_directories(file.parent_path(), none);
  try {
    superelement::write_whole(file, packed(matrices));
  } catch (const std::exception&) {
  }
}

}  // namespace

input::ContentHash& add_to(input::ContentHash& hash, const Eigen::Ref<const Eigen::MatrixXd>& x) {
  const std::int64_t size[2] = {x.rows(), x.cols()};
  hash.add(bytes_of(size, sizeof size));
  if (x.outerStride() == x.rows() || x.cols() == 1)
    return hash.add(bytes_of(x.data(), sizeof(double) * static_cast<std::size_t>(x.size())));
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    hash.add(bytes_of(x.col(j).data(), sizeof(double) * static_cast<std::size_t>(x.rows())));
  return hash;
}

std::shared_ptr<const Matrices> PreparationCache::get(const std::string& stage, const std::string& key,
                                                      const std::function<Matrices()>& make) {
  const std::string name = stage + "-" + key;
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = entries_.find(name); found != entries_.end()) {
      ++counts_[stage].reused;
      return found->second;
    }
  }
  const fs::path file = folder_ / (name + ".prepared");
  std::optional<Matrices> matrices = folder_.empty() ? std::nullopt : read_entry(file);
  const bool is_new = !matrices;
  if (is_new) matrices = make();
  if (is_new && !folder_.empty()) write_entry(file, *matrices);
  const std::scoped_lock lock(mutex_);
  ++(is_new ? counts_[stage].computed : counts_[stage].reused);
  return entries_.emplace(name, std::make_shared<const Matrices>(std::move(*matrices))).first->second;
}

std::shared_ptr<const superelement::Superelement> PreparationCache::read(const fs::path& file,
                                                                         const superelement::Parts& parts) {
  std::error_code none;
  const fs::path path = fs::weakly_canonical(file, none);
  const std::string of_file = fmt::format("{}|{}|{}", path.string(), fs::file_size(path, none),
                                          fs::last_write_time(path, none).time_since_epoch().count());
  const auto key_with = [&](bool matrices) {
    return fmt::format("{}|{}{}{}{}{}{}{}", of_file, matrices, parts.inertia, parts.stiffening, parts.surface,
                       parts.shapes, parts.stress, parts.sections);
  };
  const std::string key = key_with(parts.matrices);
  {
    const std::scoped_lock lock(mutex_);
    auto found = superelements_.find(key);
    // A rigid body's needs no matrices, and is not disturbed by them.
    if (found == superelements_.end()) found = superelements_.find(key_with(true));
    if (found != superelements_.end()) {
      ++counts_["superelement"].reused;
      return found->second;
    }
  }
  auto se = std::make_shared<const superelement::Superelement>(superelement::read(file, parts));
  const std::scoped_lock lock(mutex_);
  ++counts_["superelement"].computed;
  return superelements_.emplace(key, std::move(se)).first->second;
}

std::shared_ptr<const superelement::Superelement> PreparationCache::made(
    const std::string& key, const std::function<std::shared_ptr<const superelement::Superelement>()>& make) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = superelements_.find(key); found != superelements_.end()) return found->second;
  }
  auto se = make();
  const std::scoped_lock lock(mutex_);
  return superelements_.emplace(key, std::move(se)).first->second;
}

std::map<std::string, PreparationCache::Counts> PreparationCache::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

}  // namespace flexura::mbs
