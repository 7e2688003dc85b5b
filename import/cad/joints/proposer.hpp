// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "import/cad/joints/propose.hpp"

/// The search for joints (propose.hpp), step by step.
namespace flexura::import::cad {

/// Gaps that differ by less are one and the same: CAD's own tolerance.
constexpr double kSameGap = 1e-6;

class Proposer {
 public:
  Proposer(const Assembly& assembly, const std::vector<std::string>& names, const ProposeOptions& options);
  Proposal run();

 private:
  using Key = std::pair<int, int>;
  using Entry = std::pair<const Key, std::vector<FacePair>>;
  using Entries = std::vector<const Entry*>;

  const PlacedPart& at(int i) const { return parts_[static_cast<std::size_t>(i)]; }
  const std::string& name(int i) const { return names_[static_cast<std::size_t>(i)]; }
  int group(int i) const { return group_[static_cast<std::size_t>(i)]; }
  Key groups_of(int a, int b) const { return {std::min(group(a), group(b)), std::max(group(a), group(b))}; }
  bool is_alone(int i) const { return std::ranges::count(group_, group(i)) == 1 && i != result_.ground; }
  static int other_of(const Entry& entry, int i) {
    return entry.first.first == i ? entry.first.second : entry.first.first;
  }

  // Pairs a < b whose reaches along x come within `slack`.
  template <class Visit>
  void near_each_other(double slack, const Visit& visit) const {
    std::vector<int> order(static_cast<std::size_t>(n_));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int i) { return at(i).low.x(); });
    for (std::size_t i = 0; i < order.size(); ++i)
      for (std::size_t j = i + 1; j < order.size() && at(order[j]).low.x() <= at(order[i]).high.x() + slack;
           ++j)
        visit(std::min(order[i], order[j]), std::max(order[i], order[j]));
  }
  /// What their triangles may be off, beside the clearance.
  double within(int a, int b) const {
    return options_.clearance +
           0.002 * std::min((at(a).high - at(a).low).norm(), (at(b).high - at(b).low).norm());
  }

  // --- contacts of groups ------------------------------------------------------------------------------------------
  struct Joined {
    std::vector<Contact> contacts;  ///< of the first group with the second
    Eigen::MatrixXd kept;
    Vector3d centre;
    double size;
    bool overlap = false;
    Eigen::MatrixXd open() const { return open_freedom(contacts, centre, size); }
  };
  /// The groups' contacts, first to second; of both orders of instances.
  std::map<Key, Entries> between_groups() const;
  std::vector<std::string> evidence_for(const Entries& entries) const;
  Joined joined(const Key& groups, const Entries& entries) const;

  // --- what is fixed: propose_fixed.cpp ----------------------------------------------------------------------------
  struct Seat {
    int other = -1;
    double gap = 1e300, length = 0.0;
    const std::vector<FacePair>* pairs = nullptr;
    Eigen::Index open = 0;  ///< freedoms that the other's group leaves it from both sides
  };
  void merge(int a, int b);
  void fix(int a, int b, Confidence confidence, std::vector<std::string> evidence, std::string doubt,
           const std::vector<FacePair>& pairs);
  void fix_bolted();
  void fix_what_is_held();
  Eigen::Index open_to(int i, int other) const;
  std::vector<Seat> seats_on_one_axis(int i, bool& has_shoulder) const;
  bool fix_a_fastener();
  bool fix_a_tightened();
  bool fix_a_pin();
  void fix_seat(int i, const Seat& seat, Confidence confidence, const std::string& rule,
                const std::string& doubt);
  /// A thread with another body than a nut: its spin moves something.
  bool drives(int i) const;
  bool is_tightened(int i, int& mate, bool& on_mates_group) const;

  // --- joints, and what is doubtful: propose_joints.cpp ------------------------------------------------------------
  void join_groups();
  ProposedJoint joint_between(const Key& groups, const Entries& entries, const Joined& contacts,
                              Eigen::Index open) const;
  void take_thread(const Entries& entries, ProposedJoint& joint) const;
  void doubt_thread_by_name(const Entries& entries, ProposedJoint& joint) const;
  void doubt_what_binds(const Key& groups, const Joined& contacts, ProposedJoint& joint) const;
  void doubt_what_floats(const std::vector<int>& island);
  void doubt_what_is_near();
  void list_candidates();

  const Assembly& assembly_;
  const std::vector<std::string>& names_;
  const ProposeOptions& options_;
  const int n_;
  std::vector<PlacedPart> parts_;
  std::map<Key, std::vector<FacePair>> pairs_;
  std::vector<Entries> touching_;  // pairs_ by instance
  std::vector<int> group_;
  std::set<Key> joined_;  // groups with a joint between them
  Vector3d low_, high_;
  Proposal result_;
};

}  // namespace flexura::import::cad
