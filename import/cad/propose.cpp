// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/propose.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "import/cad/evidence.hpp"
#include "import/cad/ground.hpp"
#include "import/cad/joint_freedom.hpp"

namespace flexura::import::cad {
namespace {

using Eigen::MatrixXd;
using mesh::FaceKind;

// Gaps that differ by less are one and the same: CAD's own tolerance.
constexpr double kSameGap = 1e-6;

class Proposer {
 public:
  Proposer(const Assembly& assembly, const std::vector<std::string>& names, const ProposeOptions& options)
      : assembly_(assembly),
        names_(names),
        options_(options),
        n_(static_cast<int>(assembly.instances.size())) {
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

  Proposal run() {
    result_.ground = find_ground(assembly_, parts_, names_, options_.ground);
    near_each_other(options_.clearance, [&](int a, int b) {
      if (auto pairs = find_pairs(at(a), at(b), options_.clearance); !pairs.empty())
        pairs_[{a, b}] = std::move(pairs);
    });
    for (const auto& entry : pairs_)
      for (const int i : {entry.first.first, entry.first.second})
        touching_[static_cast<std::size_t>(i)].push_back(&entry);
    fix_bolted();
    do {
      fix_what_is_held();
    } while (fix_a_fastener() || fix_a_pin());
    join_groups();
    doubt_what_is_near();
    result_.freedom = count_freedom(result_.joints, group_, group(result_.ground), 0.5 * (low_ + high_),
                                    std::max(1e-9, 0.5 * (high_ - low_).norm()));
    return std::move(result_);
  }

 private:
  using Key = std::pair<int, int>;

  const PlacedPart& at(int i) const { return parts_[static_cast<std::size_t>(i)]; }
  const std::string& name(int i) const { return names_[static_cast<std::size_t>(i)]; }
  int group(int i) const { return group_[static_cast<std::size_t>(i)]; }

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

  void merge(int a, int b) {
    const int from = group(b), to = group(a);
    for (int& g : group_)
      if (g == from) g = to;
  }

  void fix(int a, int b, Confidence confidence, std::vector<std::string> evidence, std::string doubt,
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

  void fix_bolted() {
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

  // The groups' contacts, first to second; of both orders of instances.
  std::map<Key, std::vector<const std::pair<const Key, std::vector<FacePair>>*>> between_groups() const {
    std::map<Key, std::vector<const std::pair<const Key, std::vector<FacePair>>*>> between;
    for (const auto& entry : pairs_) {
      const int ga = group(entry.first.first), gb = group(entry.first.second);
      if (ga != gb) between[{std::min(ga, gb), std::max(ga, gb)}].push_back(&entry);
    }
    return between;
  }

  struct Joined {
    std::vector<Contact> contacts;  // of the first group with the second
    MatrixXd kept;
    Vector3d centre;
    double size;
    bool overlap = false;
    MatrixXd open() const { return open_freedom(contacts, centre, size); }
  };

  template <class Entries>
  std::vector<std::string> evidence_for(const Entries& entries) const {
    std::vector<std::string> lines;
    for (const auto* entry : entries)
      for (const FacePair& pair : entry->second)
        lines.push_back(evidence_of(pair, name(entry->first.first), name(entry->first.second)));
    return lines;
  }

  template <class Entries>
  Joined joined(const Key& groups, const Entries& entries) const {
    Joined result;
    std::vector<Contact>& contacts = result.contacts;
    for (const auto* entry : entries) {
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

  void fix_what_is_held() {
    for (bool again = true; again;) {
      again = false;
      for (const auto& [groups, entries] : between_groups()) {
        const Joined j = joined(groups, entries);
        if (j.kept.cols() > 0) continue;
        const bool closed = j.open().cols() == 0;
        const auto [a, b] = entries.front()->first;
        fix(a, b, closed ? Confidence::high : Confidence::low, evidence_for(entries),
            closed ? "" : "nothing drawn presses them together: they could come apart",
            entries.front()->second);
        again = true;
        break;
      }
    }
  }

  struct Seat {
    int other = -1;
    double gap = 1e300, length = 0.0;
    const std::vector<FacePair>* pairs = nullptr;
    Eigen::Index open = 0;  // freedoms that the other's group leaves it from both sides
  };

  Eigen::Index open_to(int i, int other) const {
    const Key groups{std::min(group(i), group(other)), std::max(group(i), group(other))};
    return joined(groups, between_groups().at(groups)).open().cols();
  }

  // The one axis on which a body alone in its group runs in others, and where; nothing where there is none.
  std::vector<Seat> seats_on_one_axis(int i, bool& has_shoulder) const {
    if (std::ranges::count(group_, group(i)) != 1 || i == result_.ground) return {};
    std::vector<Seat> seats;
    const FacePair* first = nullptr;
    has_shoulder = false;
    for (const auto* entry : touching_[static_cast<std::size_t>(i)]) {
      const auto& [key, pairs] = *entry;
      Seat seat{.other = key.first == i ? key.second : key.first, .pairs = &pairs};
      for (const FacePair& p : pairs) {
        if (p.kind == FaceKind::sphere) return {};
        if (p.kind == FaceKind::plane) {
          has_shoulder = true;
          continue;
        }
        if (p.shaft_in_a != (key.first == i)) return {};  // it is the bore
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
    if (first == nullptr || !is_of_revolution(at(i), first->point, first->axis, options_.clearance))
      return {};
    return seats;
  }

  bool fix_a_fastener() {
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
               "a body of revolution through parts that are fixed to one another: a fastener",
               "it could turn");
      return true;
    }
    return false;
  }

  bool fix_a_pin() {
    for (int i = 0; i < n_; ++i) {
      bool has_shoulder = false;
      auto seats = seats_on_one_axis(i, has_shoulder);
      std::set<int> groups;
      for (const Seat& seat : seats) groups.insert(group(seat.other));
      if (groups.size() < 2) continue;
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
      for (const Seat& seat : seats)
        if (&seat != &seats[0] && (names_a_thread(name(i)) || names_a_thread(name(seat.other))))
          result_.doubts.push_back(
              fmt::format("{} runs in {} on a cylinder, and by its name that may be a thread: taken is that "
                          "it slides there; make a "
                          "joint of type screw of it, with the thread's pitch, where it drives",
                          name(i), name(seat.other)));
      return true;
    }
    return false;
  }

  void fix_seat(int i, const Seat& seat, Confidence confidence, const std::string& rule,
                const std::string& doubt) {
    std::vector<std::string> evidence = {rule};
    const int a = std::min(i, seat.other), b = std::max(i, seat.other);
    for (const FacePair& p : *seat.pairs) evidence.push_back(evidence_of(p, name(a), name(b)));
    fix(a, b, confidence, std::move(evidence), doubt, *seat.pairs);
  }

  void join_groups() {
    std::vector<std::pair<ProposedJoint, Key>> loose;
    std::set<int> has_joint;
    std::vector<Key> bound;
    for (const auto& [groups, entries] : between_groups()) {
      const Joined j = joined(groups, entries);
      const auto [a, b] = entries.front()->first;
      ProposedJoint joint{.a = a, .b = b, .evidence = evidence_for(entries)};
      joint.form = form_of(j.kept, j.centre, j.size);
      const MatrixXd open = j.open();
      const auto more = open.cols() - j.kept.cols();
      joint.confidence = more == 0 ? Confidence::high : Confidence::medium;
      if (more > 0)
        joint.doubt = fmt::format("held from one side only: {} {} more if it lifts off", more,
                                  more == 1 ? "freedom" : "freedoms");
      if (j.overlap) {
        joint.confidence = Confidence::low;
        joint.doubt += std::string(joint.doubt.empty() ? "" : "; ") +
                       "the faces overlap: a press fit, or a thread, would hold it";
      }
      for (const auto* entry : entries)
        for (const FacePair& p : entry->second) {
          joint.faces.emplace_back(entry->first.first, p.face_a);
          joint.faces.emplace_back(entry->first.second, p.face_b);
        }
      if (twists_of(joint.form, j.centre, j.size).cols() == 0) {
        result_.doubts.push_back(
            fmt::format("{} and {} touch and keep {} freedoms that no joint has: none is proposed ({})",
                        name(a), name(b), j.kept.cols(), fmt::join(joint.evidence, "; ")));
        continue;
      }
      if (open.cols() == 6) {
        loose.emplace_back(std::move(joint), groups);
        continue;
      }
      has_joint.insert({groups.first, groups.second});
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
        result_.doubts.push_back(
            fmt::format("{} and {} touch from one side only: a contact, not a joint ({})", name(joint.a),
                        name(joint.b), fmt::join(joint.evidence, "; ")));
        continue;
      }
      joint.confidence = Confidence::low;
      joint.doubt = "nothing but this contact holds it: it could lift off";
      bind(groups);
      has_joint.insert({groups.first, groups.second});
      result_.joints.push_back(std::move(joint));
    }
    std::set<int> alone;
    for (int i = 0; i < n_; ++i)
      if (group(i) != group(result_.ground) && !has_joint.contains(group(i)) && alone.insert(group(i)).second)
        result_.doubts.push_back(fmt::format(
            "{} touches nothing within {} and floats free; a larger --clearance may find what holds it",
            name(i), mm(options_.clearance)));
  }

  // Surfaces that meet without faces that make a contact here: teeth, cams, threads, cones.  The pictures' triangles
  // deviate by 0.2 % of a part's size.
  void doubt_what_is_near() {
    std::set<Key> known;
    for (const auto& [groups, entries] : between_groups()) known.insert(groups);
    const double largest = 0.002 * (high_ - low_).norm();
    near_each_other(options_.clearance + largest, [&](int a, int b) {
      const Key groups{std::min(group(a), group(b)), std::max(group(a), group(b))};
      if (groups.first == groups.second || known.contains(groups)) return;
      const double smaller = std::min((at(a).high - at(a).low).norm(), (at(b).high - at(b).low).norm());
      const double within = options_.clearance + 0.002 * smaller;
      if (!(nearest(at(a), at(b), within) < within)) return;
      known.insert(groups);
      result_.doubts.push_back(fmt::format(
          "{} and {} come within {} of each other and have no faces that make a joint (teeth, cams, "
          "threads and cones are not judged): what binds them is missing",
          name(a), name(b), mm(within)));
    });
  }

  const Assembly& assembly_;
  const std::vector<std::string>& names_;
  const ProposeOptions& options_;
  const int n_;
  std::vector<PlacedPart> parts_;
  std::map<Key, std::vector<FacePair>> pairs_;
  std::vector<std::vector<const std::pair<const Key, std::vector<FacePair>>*>>
      touching_;  // pairs_ by instance
  std::vector<int> group_;
  Vector3d low_, high_;
  Proposal result_;
};

}  // namespace

const char* name_of(Confidence confidence) {
  return confidence == Confidence::high ? "high" : confidence == Confidence::medium ? "medium" : "low";
}

Proposal propose(const Assembly& assembly, const std::vector<std::string>& names,
                 const ProposeOptions& options) {
  return Proposer(assembly, names, options).run();
}

}  // namespace flexura::import::cad
