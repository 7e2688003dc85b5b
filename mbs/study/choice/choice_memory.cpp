// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <set>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/study/choice/chooser.hpp"

/// What an earlier run chose, kept in the cache of prepared bodies (preparation_cache.hpp) for runs that differ in values
/// of [parameters] alone, as those of a sweep do.  A run with a choice of another one's is judged by its own shadows like
/// any other, and goes on with more where it has to.
namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;

std::string Chooser::key_of_choice() const {
  input::ContentHash hash;
  as_given_.source->add_to(hash);
  hash.add(fmt::format("choice 7 {:.17g}", accuracy_));
  for (const std::string& word : mbs::words_of(of_integrator())) hash.add(word);
  std::set<std::string> files;
  for (const mbs::BodyDescription& body : as_given_.mechanism->description().bodies)
    if (!body.superelement.empty()) files.insert(body.superelement);
  for (const std::string& file : files) hash.add_file(file);
  return hash.hex();
}

// Bodies, outputs and the time of the run, in the order of their names or as they are judged.
mbs::PreparationCache::Matrices Chooser::packed() const {
  MatrixXd bodies(static_cast<Index>(choices_.size()), 14),
      outputs(static_cast<Index>(sizes_.outputs.size()), 3);
  Index i = 0;
  for (const auto& [name, c] : choices_)
    bodies.row(i++) << c.rigid, c.stiffened, c.candidate.modes, c.candidate.responses, c.candidate.all,
        c.candidate.plain, c.candidate.loss, c.candidate.highest_hz, c.available,
        without_influence_.contains(name), c.candidate.held, c.stiffening_counts, c.exact, c.elements;
  for (i = 0; i < outputs.rows(); ++i) {
    const OutputEstimate& o = sizes_.outputs[static_cast<std::size_t>(i)];
    outputs.row(i) << o.scale, o.counts, o.size_rms;
  }
  return {bodies, outputs, MatrixXd{{span_, lost_at_}}};
}

bool Chooser::recall(const mbs::PreparationCache::Matrices& kept, const mbs::PreparedMechanism& rigid) {
  if (kept.size() != 3 || kept[0].rows() != static_cast<Index>(choices_.size()) || kept[0].cols() != 14 ||
      kept[1].cols() != 3 || kept[2].size() != 2)
    return false;
  Index i = 0;
  const auto is = [](double x) { return x != 0.0; };
  for (auto& [name, c] : choices_) {
    const Eigen::RowVectorXd row = kept[0].row(i++);
    c.rigid = is(row(0));
    c.stiffened = is(row(1));
    c.candidate = {.modes = static_cast<int>(row(2)),
                   .responses = static_cast<int>(row(3)),
                   .all = is(row(4)),
                   .plain = is(row(5)),
                   .held = is(row(10)),
                   .loss = row(6),
                   .highest_hz = row(7)};
    c.available = static_cast<int>(row(8));
    c.stiffening_counts = is(row(11));
    c.exact = is(row(12));
    c.elements = static_cast<int>(row(13));
    c.reason = "as an earlier run with other parameters has chosen (kept in the cache)";
    if (is(row(9))) without_influence_.insert(name);
  }
  full_ = FullModel::make(rigid, {.stiffened = {}, .rigid = without_influence_, .own_frames = true});
  if (!full_) return kept[1].rows() == 0;
  sizes_.outputs.clear();
  judged_outputs(rigid, full_->mechanism(), sizes_.outputs);
  if (kept[1].rows() != static_cast<Index>(sizes_.outputs.size())) return false;
  for (i = 0; i < kept[1].rows(); ++i) {
    OutputEstimate& o = sizes_.outputs[static_cast<std::size_t>(i)];
    o.scale = kept[1](i, 0);
    o.counts = is(kept[1](i, 1));
    o.size_rms = kept[1](i, 2);
  }
  span_ = kept[2](0, 0);
  lost_at_ = kept[2](0, 1);
  return true;
}

}  // namespace flexura::study
