// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/joints/propose.hpp"

#include <algorithm>

#include "import/cad/evidence.hpp"
#include "import/cad/ground.hpp"
#include "import/cad/joints/joint_freedom.hpp"
#include "import/cad/joints/proposer.hpp"
#include "import/cad/threads.hpp"

namespace flexura::import::cad {

Proposer::Proposer(const Assembly& assembly, const std::vector<std::string>& names,
                   const ProposeOptions& options)
    : assembly_(assembly), names_(names), options_(options), n_(static_cast<int>(assembly.instances.size())) {
  for (const Instance& i : assembly.instances)
    parts_.push_back(place(assembly.parts[static_cast<std::size_t>(i.part)], i.X_WP));
  low_ = parts_.front().low;
  high_ = parts_.front().high;
  for (const PlacedPart& part : parts_) {
    low_ = low_.cwiseMin(part.low);
    high_ = high_.cwiseMax(part.high);
  }
  group_.resize(static_cast<std::size_t>(n_));
  touching_.resize(static_cast<std::size_t>(n_));
  std::iota(group_.begin(), group_.end(), 0);
}

Proposal Proposer::run() {
  result_.ground = find_ground(assembly_, parts_, names_, options_.ground);
  near_each_other(options_.clearance, [&](int a, int b) {
    auto pairs = find_pairs(at(a), at(b), options_.clearance);
    for (FacePair& thread :
         find_threads(at(a), at(b), assembly_.instances[static_cast<std::size_t>(a)].name,
                      assembly_.instances[static_cast<std::size_t>(b)].name, options_.clearance))
      pairs.push_back(std::move(thread));
    if (!pairs.empty()) pairs_[{a, b}] = std::move(pairs);
  });
  for (const auto& entry : pairs_)
    for (const int i : {entry.first.first, entry.first.second})
      touching_[static_cast<std::size_t>(i)].push_back(&entry);
  fix_bolted();
  do {
    fix_what_is_held();
  } while (fix_a_fastener() || fix_a_tightened() || fix_a_pin());
  join_groups();
  doubt_what_is_near();
  list_candidates();
  result_.freedom = count_freedom(result_.joints, group_, group(result_.ground), 0.5 * (low_ + high_),
                                  std::max(1e-9, 0.5 * (high_ - low_).norm()));
  return std::move(result_);
}

std::map<Proposer::Key, Proposer::Entries> Proposer::between_groups() const {
  std::map<Key, Entries> between;
  for (const auto& entry : pairs_)
    if (group(entry.first.first) != group(entry.first.second))
      between[groups_of(entry.first.first, entry.first.second)].push_back(&entry);
  return between;
}

std::vector<std::string> Proposer::evidence_for(const Entries& entries) const {
  std::vector<std::string> lines;
  for (const Entry* entry : entries)
    for (const FacePair& pair : entry->second)
      lines.push_back(evidence_of(pair, name(entry->first.first), name(entry->first.second)));
  return lines;
}

Proposer::Joined Proposer::joined(const Key& groups, const Entries& entries) const {
  Joined result;
  std::vector<Contact>& contacts = result.contacts;
  for (const Entry* entry : entries) {
    const double sign = group(entry->first.first) == groups.first ? 1.0 : -1.0;
    for (const FacePair& pair : entry->second) {
      for (const Contact& c : pair.contacts) contacts.push_back({c.p, sign * c.n});
      result.overlap = result.overlap || pair.gap < -kSameGap;
    }
  }
  result.centre.setZero();
  for (const Contact& c : contacts) result.centre += c.p / static_cast<double>(contacts.size());
  result.size = 1e-9;
  for (const Contact& c : contacts) result.size = std::max(result.size, (c.p - result.centre).norm());
  result.kept = kept_freedom(contacts, result.centre, result.size);
  return result;
}

const char* name_of(Confidence confidence) {
  return confidence == Confidence::high ? "high" : confidence == Confidence::medium ? "medium" : "low";
}

Proposal propose(const Assembly& assembly, const std::vector<std::string>& names,
                 const ProposeOptions& options) {
  return Proposer(assembly, names, options).run();
}

}  // namespace flexura::import::cad
