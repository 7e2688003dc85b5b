// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What is fixed to what: bolted, held from all sides, fasteners, what is tightened, pins.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "import/cad/evidence.hpp"
#include "import/cad/joints/proposer.hpp"
#include "import/cad/threads.hpp"

namespace flexura::import::cad {

using mesh::FaceKind;

namespace {

bool has_thread(const std::vector<FacePair>& pairs) {
  return std::ranges::any_of(pairs, &FacePair::is_thread);
}

}  // namespace

void Proposer::merge(int a, int b) {
  const int from = group(b), to = group(a);
  for (int& g : group_)
    if (g == from) g = to;
}

void Proposer::fix(int a, int b, Confidence confidence, std::vector<std::string> evidence, std::string doubt,
                   const std::vector<FacePair>& pairs) {
  ProposedJoint joint{
      .a = a, .b = b, .confidence = confidence, .evidence = std::move(evidence), .doubt = std::move(doubt)};
  joint.form.type = JointForm::Type::fixed;
  joint.form.point = pairs.empty() ? Vector3d(0.5 * (at(b).low + at(b).high)) : pairs.front().point;
  for (const FacePair& p : pairs) {
    joint.faces.emplace_back(a, p.face_a);
    joint.faces.emplace_back(b, p.face_b);
  }
  result_.joints.push_back(std::move(joint));
  merge(a, b);
}

void Proposer::fix_bolted() {
  for (const auto& [key, pairs] : pairs_) {
    const auto [a, b] = key;
    if (group(a) == group(b)) continue;
    for (const FacePair& p : pairs) {
      if (p.kind != FaceKind::plane) continue;
      const auto axes = common_hole_axes(at(a), at(b), p.axis, options_.clearance);
      if (axes.size() < 2) continue;
      fix(a, b, Confidence::high,
          {fmt::format("{} holes in common across one plane: bolted", axes.size()),
           evidence_of(p, name(a), name(b))},
          "", {p});
      break;
    }
  }
}

void Proposer::fix_what_is_held() {
  for (bool again = true; again;) {
    again = false;
    for (const auto& [groups, entries] : between_groups()) {
      const Joined j = joined(groups, entries);
      if (j.kept.cols() > 0) continue;
      const bool closed = j.open().cols() == 0,
                 tightened =
                     std::ranges::any_of(entries, [](const Entry*e) { return has_thread(e->second); });
      const auto [a, b] = entries.front()->first;
      fix(a, b,
          closed      ? Confidence::high
          : tightened ? Confidence::medium
                      : Confidence::low,
          evidence_for(entries),
          closed      ? ""
          : tightened ? "a screw, tightened against its head or shoulder"
                      : "nothing drawn presses them together: they could come apart",
          entries.front()->second);
      again = true;
      break;
    }
  }
}

Eigen::Index Proposer::open_to(int i, int other) const {
  const Key groups = groups_of(i, other);
  return joined(groups, between_groups().at(groups)).open().cols();
}

// The one axis on which a body alone in its group runs in others, and where; nothing where there is none. Threads are no seats: what
// they do is judged by itself.
std::vector<Proposer::Seat> Proposer::seats_on_one_axis(int i, bool& has_shoulder) const {
  if (!is_alone(i)) return {};
  std::vector<Seat> seats;
  const FacePair* first = nullptr;
  has_shoulder = false;
  bool is_screw = false;
  for (const Entry* entry : touching_[static_cast<std::size_t>(i)]) {
    const auto& [key, pairs] = *entry;
    Seat seat{.other = other_of(*entry, i), .pairs = &pairs};
    const bool screwed = has_thread(pairs);
    is_screw = is_screw || screwed;
    for (const FacePair& p : pairs) {
      if (p.kind == FaceKind::sphere || p.kind == FaceKind::cone) return {};
      if (p.kind == FaceKind::plane) {
        has_shoulder = true;
        continue;
      }
      if (p.shaft_in_a != (key.first == i)) return {};  // it is the bore
      if (screwed) continue;
      if (first == nullptr) first = &p;
      const Vector3d off = p.point - first->point;
      if (p.axis.cross(first->axis).norm() > 1e-3 ||
          (off - first->axis * first->axis.dot(off)).norm() > options_.clearance)
        return {};
      seat.gap = std::min(seat.gap, p.gap);
      seat.length += p.extent;
    }
    if (seat.length > 0.0) seats.push_back(seat);
  }
  // The head of a screw may have edges.
  if (first == nullptr ||
      (!is_screw && !is_of_revolution(at(i), first->point, first->axis, options_.clearance)))
    return {};
  return seats;
}

bool Proposer::fix_a_fastener() {
  for (int i = 0; i < n_; ++i) {
    bool has_shoulder = false;
    const auto seats = seats_on_one_axis(i, has_shoulder);
    if (seats.size() < 2 || !has_shoulder) continue;
    std::set<int> groups;
    for (const Seat& seat : seats) groups.insert(group(seat.other));
    if (groups.size() != 1) continue;
    const auto touch = [&](int a, int b) { return pairs_.contains({std::min(a, b), std::max(a, b)}); };
    if (!touch(seats[0].other, seats[1].other)) continue;  // a shaft through two bearings
    fix_seat(i, seats[0], Confidence::medium,
             "a body of revolution through parts that are fixed to one another: a fastener", "it could turn");
    return true;
  }
  return false;
}

// A body in a thread that touches others besides only from one side of its axis: a nut, a bolt by its head. `mate` has the other
// thread; whether all that it presses on is of the mate's group.
bool Proposer::is_tightened(int i, int& mate, bool& on_mates_group) const {
  if (!is_alone(i)) return false;
  const FacePair* thread = nullptr;
  mate = -1;
  for (const Entry* entry : touching_[static_cast<std::size_t>(i)])
    for (const FacePair& p : entry->second)
      if (p.is_thread()) {
        if (mate >= 0) return false;
        mate = other_of(*entry, i);
        thread = &p;
      }
  if (mate < 0) return false;
  int sides = 0;  // 1: against the axis, 2: along it
  on_mates_group = true;
  for (const Entry* entry : touching_[static_cast<std::size_t>(i)])
    for (const FacePair& p : entry->second) {
      if (p.is_thread()) continue;
      if (p.axis.cross(thread->axis).norm() > 1e-3) return false;
      if (p.kind == FaceKind::cylinder) {
        const Vector3d off = p.point - thread->point;
        if ((off - thread->axis * thread->axis.dot(off)).norm() > options_.clearance) return false;
        continue;
      }
      if (p.kind != FaceKind::plane) return false;
      const double out = (entry->first.first == i ? 1.0 : -1.0) * p.axis.dot(thread->axis);
      sides |= out > 0.0 ? 2 : 1;
      on_mates_group = on_mates_group && group(other_of(*entry, i)) == group(mate);
    }
  return sides == 1 || sides == 2;
}

bool Proposer::fix_a_tightened() {
  for (int i = 0; i < n_; ++i) {
    int mate = -1;
    bool on_mates_group = false;
    if (!is_tightened(i, mate, on_mates_group)) continue;
    const auto drives = [&](int b) {
      const auto named = thread_named(assembly_.instances[static_cast<std::size_t>(b)].name);
      return named && named->drives;
    };
    if (drives(i) || drives(mate)) continue;
    const Seat seat{.other = mate, .pairs = &pairs_.at({std::min(i, mate), std::max(i, mate)})};
    fix_seat(i, seat, on_mates_group ? Confidence::medium : Confidence::low,
             "a nut or a screw, tightened against what it touches from one side",
             on_mates_group ? "it could turn in its thread"
                            : "it could turn in its thread, and move what it presses on: then it is a screw");
    return true;
  }
  return false;
}

bool Proposer::drives(int i) const {
  for (const Entry* entry : touching_[static_cast<std::size_t>(i)]) {
    if (!has_thread(entry->second)) continue;
    const int other = other_of(*entry, i);
    int mate = -1;
    bool on_mates_group = false;
    if (group(other) != group(i) && !is_tightened(other, mate, on_mates_group)) return true;
  }
  const auto named = thread_named(assembly_.instances[static_cast<std::size_t>(i)].name);
  return named && named->drives;
}

bool Proposer::fix_a_pin() {
  for (int i = 0; i < n_; ++i) {
    bool has_shoulder = false;
    auto seats = seats_on_one_axis(i, has_shoulder);
    std::set<int> groups;
    for (const Seat& seat : seats) groups.insert(group(seat.other));
    if (groups.size() < 2 || drives(i)) continue;
    for (Seat& seat : seats) seat.open = open_to(i, seat.other);
    // Where shoulders hold it on both sides it may not be taken away: the others could not slide along it any more.
    std::ranges::stable_sort(seats, [](const Seat& x, const Seat& y) {
      return std::abs(x.gap - y.gap) > kSameGap ? x.gap < y.gap
             : x.open != y.open                 ? x.open < y.open
                                                : x.length > y.length + kSameGap;
    });
    const auto next =
        std::ranges::find_if(seats, [&](const Seat& s) { return group(s.other) != group(seats[0].other); });
    const bool tighter = next->gap - seats[0].gap > kSameGap, held = next->open > seats[0].open;
    fix_seat(i, seats[0], tighter ? Confidence::high : Confidence::medium,
             fmt::format("a pin: its own spin moves nothing, so it is fixed where it {}",
                         tighter ? "fits tightest"
                         : held  ? "is held between shoulders"
                                 : "sits longest"),
             tighter ? ""
                     : fmt::format("it fits {} as tightly; where it turns changes no motion of the others",
                                   name(next->other)));
    const auto named = [&](int b) {
      return thread_named(assembly_.instances[static_cast<std::size_t>(b)].name).has_value();
    };
    for (const Seat& seat : seats)
      if (&seat != &seats[0] && (named(i) || named(seat.other)))
        result_.doubts.push_back(fmt::format(
            "{} runs in {} on a cylinder, and by its name that may be a thread: taken is that "
            "it slides there; make a joint of type screw of it, with the thread's pitch, where it drives",
            name(i), name(seat.other)));
    return true;
  }
  return false;
}

void Proposer::fix_seat(int i, const Seat& seat, Confidence confidence, const std::string& rule,
                        const std::string& doubt) {
  std::vector<std::string> evidence = {rule};
  const int a = std::min(i, seat.other), b = std::max(i, seat.other);
  for (const FacePair& p : *seat.pairs) evidence.push_back(evidence_of(p, name(a), name(b)));
  fix(a, b, confidence, std::move(evidence), doubt, *seat.pairs);
}

}  // namespace flexura::import::cad
