// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <utility>

namespace flexura::linalg {

/// Where and how the numbers of a factor are to be kept.
struct FactorStorage {
  enum class Place {
    automatic,  ///< in memory if it has room for all, else in a file
    memory,
    file,
  };
  Place place = Place::automatic;
  double reserve = 0.0;          ///< [bytes] that other work will need beside the factor
  std::filesystem::path folder;  ///< of the file; empty: the folder for temporary files (TMPDIR)
  /// In single precision, which takes half the time and memory, where refinement with such a factor converges; in
  /// double precision where it does not.
  bool single = false;
  /// For its pivots' signs only, nothing is solved: a team's factor is not kept at all.
  bool to_count = false;
};

/// [bytes] that this process can still take without swapping: what the system has and what its group of
/// processes (cgroup) may have.  Infinite where the system does not say.
double available_memory();

/// An array of bytes, zero at first: in memory, or in a temporary file that has no name any more, which the
/// system reads and writes page by page as they are used.  A multifrontal factor is written once from
/// its first number to its last and read from end to end, forwards and backwards: what a disk does best.
class FactorStore {
 public:
  FactorStore() = default;
  static FactorStore in_memory(std::size_t n_bytes);
  /// std::runtime_error, with what is needed and what there is, where the folder has no room.
  static FactorStore in_file(std::size_t n_bytes, const std::filesystem::path& folder);

  FactorStore(FactorStore&& other) noexcept { swap(other); }
  FactorStore& operator=(FactorStore&& other) noexcept {
    swap(other);
    return *this;
  }
  ~FactorStore();

  void* data() const { return data_; }
  bool is_file() const { return is_file_; }
  /// Bytes first ... first + count will be read soon: begins to fetch them from a file, does nothing else.
  void will_need(std::size_t first, std::size_t count) const;

 private:
  void swap(FactorStore& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(n_, other.n_);
    std::swap(is_file_, other.is_file_);
  }
  char* data_ = nullptr;
  std::size_t n_ = 0;
  bool is_file_ = false;
};

}  // namespace flexura::linalg
