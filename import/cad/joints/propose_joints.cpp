// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Joints between groups, and what is to be looked at.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "import/cad/evidence.hpp"
#include "import/cad/joints/joint_freedom.hpp"
#include "import/cad/joints/proposer.hpp"
#include "import/cad/near.hpp"
#include "import/cad/threads.hpp"

namespace flexura::import::cad {

using mesh::FaceKind;
using Type = JointForm::Type;

namespace {

void add_doubt(ProposedJoint& joint, Confidence at_most, const std::string& why) {
  joint.confidence = std::max(joint.confidence, at_most);
  joint.doubt += (joint.doubt.empty() ? "" : "; ") + why;
}

}  // namespace

ProposedJoint Proposer::joint_between(const Key& groups, const Entries& entries, const Joined& j,
                                      Eigen::Index open) const {
  const auto [a, b] = entries.front()->first;
  ProposedJoint joint{.a = a, .b = b, .evidence = evidence_for(entries)};
  joint.form = form_of(j.kept, j.centre, j.size);
  if (const auto more = open - j.kept.cols(); more > 0)
    add_doubt(joint, Confidence::medium,
              fmt::format("held from one side only: {} {} more if it lifts off", more,
                          more == 1 ? "freedom" : "freedoms"));
  if (j.overlap)
    add_doubt(joint, Confidence::low, "the faces overlap: a press fit, or a thread, would hold it");
  for (const Entry* entry : entries)
    for (const FacePair& p : entry->second) {
      joint.faces.emplace_back(entry->first.first, p.face_a);
      joint.faces.emplace_back(entry->first.second, p.face_b);
    }
  if (joint.form.type == Type::screw) take_thread(entries, joint);
  if (joint.form.type == Type::cylindrical) doubt_thread_by_name(entries, joint);
  doubt_what_binds(groups, j, joint);
  return joint;
}

void Proposer::take_thread(const Entries& entries, ProposedJoint& joint) const {
  for (const Entry* entry : entries)
    for (const FacePair& p : entry->second) {
      if (!p.is_thread()) continue;
      joint.form.lead = p.lead;
      if (p.sign == ThreadSign::flanks_of_one)
        add_doubt(joint, Confidence::medium, "only one of the two has its thread drawn");
      if (p.sign == ThreadSign::overlap)
        add_doubt(
            joint, Confidence::low,
            fmt::format("a thread by the overlap of two cylinders, right-hand and of lead {} by the depth "
                        "that is drawn or the name; a press fit would be fixed",
                        mm(p.lead)));
      return;
    }
}

// A spindle in its nut, drawn as a shaft in a bore of the same radius.
void Proposer::doubt_thread_by_name(const Entries& entries, ProposedJoint& joint) const {
  for (const Entry* entry : entries)
    for (const int i : {entry->first.first, entry->first.second}) {
      const auto named = thread_named(assembly_.instances[static_cast<std::size_t>(i)].name);
      if (!named) continue;
      const auto seat = std::ranges::find(entry->second, FaceKind::cylinder, &FacePair::kind);
      if (seat == entry->second.end()) continue;
      joint.form.type = Type::screw;
      joint.form.lead = named->lead > 0.0
                            ? named->lead
                            : coarse_lead(named->diameter > 0.0 ? named->diameter : 2.0 * seat->radius);
      add_doubt(joint, Confidence::low,
                fmt::format(
                    "drawn as a shaft in a bore, a thread by the name of {}, right-hand and of lead {}{}; "
                    "without a thread it is cylindrical",
                    name(i), mm(joint.form.lead), named->lead > 0.0 ? "" : ", that of ISO's coarse threads"));
      return;
    }
}

// Splines, keys, teeth: faces that no pair explains hold the joint's own motion from both sides.
void Proposer::doubt_what_binds(const Key& groups, const Joined& j, ProposedJoint& joint) const {
  const Eigen::MatrixXd twists = twists_of(joint.form, j.centre, j.size);
  // A screw's flanks are more faces than one pair.
  if (twists.cols() == 0 || joint.form.type == Type::fixed || joint.form.type == Type::screw) return;
  // How much of a point's velocity goes into the face: half of it is more than facets are off.
  constexpr double binds = 0.5;
  for (int a = 0; a < n_; ++a) {
    if (group(a) != groups.first && group(a) != groups.second) continue;
    for (int b = a + 1; b < n_; ++b) {
      if (groups_of(a, b) != groups || group(a) == group(b)) continue;
      const auto judged = pairs_.find({a, b});
      const auto list = unjudged(
          at(a), at(b), judged == pairs_.end() ? std::vector<FacePair>{} : judged->second, within(a, b));
      for (Eigen::Index k = 0; k < twists.cols(); ++k) {
        const Near *forth = nullptr, *back = nullptr;
        for (const Near& near : list) {
          const Vector3d omega = twists.col(k).head<3>(), v = twists.col(k).tail<3>();
          const Vector3d velocity = v + omega.cross((near.contact.p - j.centre) / j.size);
          const double into = near.contact.n.dot(velocity);
          if (std::abs(into) < binds * velocity.norm()) continue;
          (into > 0.0 ? forth : back) = &near;
        }
        if (forth == nullptr || back == nullptr) continue;
        add_doubt(
            joint, Confidence::low,
            fmt::format(
                "other faces of {} and {} hold that motion from both sides (faces {} and {}, {} and {}), "
                "as splines, keys and teeth do: then it is not free",
                name(a), name(b), forth->face_a, forth->face_b, back->face_a, back->face_b));
        return;
      }
    }
  }
}

void Proposer::join_groups() {
  std::vector<std::pair<ProposedJoint, Key>> loose;
  std::vector<Key> bound;
  for (const auto& [groups, entries] : between_groups()) {
    const Joined j = joined(groups, entries);
    const Eigen::Index open = j.open().cols();
    ProposedJoint joint = joint_between(groups, entries, j, open);
    if (twists_of(joint.form, j.centre, j.size).cols() == 0) {
      result_.doubts.push_back(
          fmt::format("{} and {} touch and keep {} freedoms that no joint has: none is proposed ({})",
                      name(joint.a), name(joint.b), j.kept.cols(), fmt::join(joint.evidence, "; ")));
      continue;
    }
    if (open == 6) {
      loose.emplace_back(std::move(joint), groups);
      continue;
    }
    joined_.insert(groups);
    bound.push_back(groups);
    result_.joints.push_back(std::move(joint));
  }
  // Islands of groups with joints between them: a contact is the joint that binds two of them, where one would float.
  std::vector<int> island(group_.begin(), group_.end());
  const auto bind = [&](const Key& groups) {
    const int from = island[static_cast<std::size_t>(groups.second)],
              to = island[static_cast<std::size_t>(groups.first)];
    std::ranges::replace(island, from, to);
  };
  for (const Key& groups : bound) bind(groups);
  for (auto& [joint, groups] : loose) {
    if (island[static_cast<std::size_t>(groups.first)] == island[static_cast<std::size_t>(groups.second)]) {
      result_.doubts.push_back(fmt::format("{} and {} touch from one side only: a contact, not a joint ({})",
                                           name(joint.a), name(joint.b), fmt::join(joint.evidence, "; ")));
      continue;
    }
    joint.confidence = Confidence::low;
    joint.doubt = "nothing but this contact holds it: it could lift off";
    bind(groups);
    joined_.insert(groups);
    result_.joints.push_back(std::move(joint));
  }
  doubt_what_floats(island);
}

void Proposer::doubt_what_floats(const std::vector<int>& island) {
  const int stands = island[static_cast<std::size_t>(group(result_.ground))];
  std::set<int> told;
  for (int i = 0; i < n_; ++i) {
    const int own = island[static_cast<std::size_t>(group(i))];
    if (own == stands || !told.insert(own).second) continue;
    int others = -1;
    bool touches = false;
    for (int k = 0; k < n_; ++k) {
      if (island[static_cast<std::size_t>(group(k))] != own) continue;
      ++others;
      for (const Entry* entry : touching_[static_cast<std::size_t>(k)])
        touches = touches || island[static_cast<std::size_t>(group(other_of(*entry, k)))] != own;
    }
    const std::string what = others == 0 ? name(i)
                                         : fmt::format("{}, with {} more {} joined to it,", name(i), others,
                                                       others == 1 ? "body" : "bodies");
    result_.doubts.push_back(
        touches
            ? fmt::format("{} touches others, but no joint is proposed, and floats free", what)
            : fmt::format(
                  "{} touches nothing within {} and floats free; a larger --clearance may find what holds it",
                  what, mm(options_.clearance)));
  }
}

// Surfaces that meet without faces that make a contact here: teeth, cams.  The pictures' triangles
// deviate by 0.2 % of a part's size.
void Proposer::doubt_what_is_near() {
  std::set<Key> known;
  for (const auto& [groups, entries] : between_groups()) known.insert(groups);
  const double largest = 0.002 * (high_ - low_).norm();
  near_each_other(options_.clearance + largest, [&](int a, int b) {
    const Key groups = groups_of(a, b);
    if (groups.first == groups.second || known.contains(groups)) return;
    if (!(nearest(at(a), at(b), within(a, b)) < within(a, b))) return;
    known.insert(groups);
    result_.doubts.push_back(
        fmt::format("{} and {} come within {} of each other and have no faces that make a joint (teeth, cams "
                    "and pins in slots "
                    "are not judged): what binds them is missing",
                    name(a), name(b), mm(within(a, b))));
  });
}

// Bodies without a joint between them that are as near as a twentieth of the smaller.
void Proposer::list_candidates() {
  constexpr double reach = 0.05;
  std::map<Key, ContactCandidate> nearest_of;  // by groups
  const auto sight = [&](int a, int b) {
    return reach * std::min((at(a).high - at(a).low).norm(), (at(b).high - at(b).low).norm());
  };
  near_each_other(reach * (high_ - low_).norm(), [&](int a, int b) {
    const Key groups = groups_of(a, b);
    if (groups.first == groups.second || joined_.contains(groups)) return;
    const auto known = nearest_of.find(groups);
    const double within = std::min(sight(a, b), known == nearest_of.end() ? 1e300 : known->second.distance);
    const std::vector<Near> list = unjudged(at(a), at(b), {}, within);
    const auto best = std::ranges::min_element(list, {}, &Near::distance);
    if (best == list.end() || !(best->distance < within)) return;
    nearest_of[groups] = {a, b, best->face_a, best->face_b, best->distance, best->contact.p};
  });
  for (const auto& [groups, candidate] : nearest_of) result_.candidates.push_back(candidate);
  std::ranges::stable_sort(result_.candidates, {}, &ContactCandidate::distance);
}

}  // namespace flexura::import::cad
