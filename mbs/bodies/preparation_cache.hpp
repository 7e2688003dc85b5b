// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/superelement/file.hpp"

/// What the preparation of flexible bodies has computed, kept by what it depends on.
///
///     superelement --> eigenmodes --> basis --> inertia integrals
///         held, ties --^   ^--        ^ ^ ^---> stiffening, loads' stiffening
///                     responses ------' | '---- how many modes, up to which frequency
///                         ^-- loads     '------ frame
///
/// Each stage has for its key a hash of its inputs' content (input::ContentHash) and of nothing else, so that
/// a change of one choice redoes only what follows from it, and a body that is placed many times, or
/// simulated many times with other parameters, is prepared once.  An entry that comes from the cache is the
/// one that was computed, to the bit.
namespace flexura::mbs {

/// Adds matrices and numbers to a hash, sizes included.
input::ContentHash& add_to(input::ContentHash& hash, const Eigen::Ref<const Eigen::MatrixXd>& x);

class PreparationCache {
 public:
  using Matrices = std::vector<Eigen::MatrixXd>;
  struct Counts {
    int computed = 0, reused = 0;
  };

  /// With a folder the entries are also written there, and found by later programs; it is made where it is
  /// missing.  A file that cannot be written is done without, a damaged one is made again.
  explicit PreparationCache(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}

  /// The entry of a stage ("eigenmodes") with this key (hexadecimal), made where there is none.
  std::shared_ptr<const Matrices> get(const std::string& stage, const std::string& key,
                                      const std::function<Matrices()>& make);
  /// A superelement file's parts, read again when the file has changed (its time or size).  In memory alone.
  std::shared_ptr<const superelement::Superelement> read(const std::filesystem::path& file,
                                                         const superelement::Parts& parts);

  /// What `make` makes of content with this key, kept in memory alone.
  std::shared_ptr<const superelement::Superelement> made(
      const std::string& key, const std::function<std::shared_ptr<const superelement::Superelement>()>& make);

  std::map<std::string, Counts> counts() const;  ///< of each stage that was asked for, and of "superelement"

 private:
  mutable std::mutex mutex_;
  std::filesystem::path folder_;
  std::map<std::string, std::shared_ptr<const Matrices>> entries_;
  std::map<std::string, std::shared_ptr<const superelement::Superelement>> superelements_;
  std::map<std::string, Counts> counts_;
};

}  // namespace flexura::mbs
