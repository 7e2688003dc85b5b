// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/threads.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {
namespace {

using mesh::FaceKind;

// ISO 261, coarse: diameter and pitch in mm.
constexpr std::array<std::array<double, 2>, 27> kCoarse = {
    {{1.6, 0.35}, {2, 0.4},   {2.5, 0.45}, {3, 0.5}, {3.5, 0.6}, {4, 0.7},  {5, 0.8},  {6, 1},    {8, 1.25},
     {10, 1.5},   {12, 1.75}, {14, 2},     {16, 2},  {18, 2.5},  {20, 2.5}, {22, 2.5}, {24, 3},   {27, 3},
     {30, 3.5},   {33, 3.5},  {36, 4},     {39, 4},  {42, 4.5},  {45, 4.5}, {48, 5},   {56, 5.5}, {64, 6}}};

// What a face of revolution or a screw reaches, along an axis and away from it.
struct Reach {
  double low = std::numeric_limits<double>::infinity(), high = -low, inner = low, outer = 0.0;
};

Reach reach_of(const PlacedPart& part, const PlacedFace& face, const Vector3d& point, const Vector3d& axis) {
  Reach reach;
  for (const Eigen::Vector3i& t : face.face->triangles)
    for (int k = 0; k < 3; ++k) {
      const Vector3d x = part.vertices[static_cast<std::size_t>(t[k])] - point;
      const double z = axis.dot(x), r = (x - z * axis).norm();
      reach.low = std::min(reach.low, z);
      reach.high = std::max(reach.high, z);
      reach.inner = std::min(reach.inner, r);
      reach.outer = std::max(reach.outer, r);
    }
  return reach;
}

bool on_one_axis(const PlacedFace& f, const PlacedFace& g, double clearance) {
  const Vector3d between = g.point - f.point;
  return f.axis.cross(g.axis).norm() < kSameDirection &&
         (between - f.axis * f.axis.dot(between)).norm() <= clearance;
}

bool is_cylinder(const PlacedFace& f) {
  return f.kind == FaceKind::cylinder;
}

// The common part along the axis of f.
bool take_common(const Reach& f, const Reach& g, const PlacedFace& on, FacePair& pair) {
  const double low = std::max(f.low, g.low), high = std::min(f.high, g.high);
  if (!(high - low > 1e-3 * f.outer)) return false;
  pair.extent = high - low;
  pair.axis = on.axis;
  pair.point = on.point + 0.5 * (low + high) * on.axis;
  return true;
}

bool flanks_meet(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                 double clearance, FacePair& pair) {
  const bool both = fa.lead != 0.0 && fb.lead != 0.0;
  if (fa.lead == 0.0 && fb.lead == 0.0) return false;
  if ((fa.lead == 0.0 && !is_cylinder(fa)) || (fb.lead == 0.0 && !is_cylinder(fb))) return false;
  // The sense of a thread does not depend on which way its axis points.
  if (both && std::abs(fa.lead - fb.lead) > 1e-2 * std::abs(fa.lead)) return false;
  if (!on_one_axis(fa, fb, clearance)) return false;
  const PlacedFace& on = fa.lead != 0.0 ? fa : fb;
  const Reach ra = reach_of(a, fa, on.point, on.axis), rb = reach_of(b, fb, on.point, on.axis);
  if (std::max(ra.inner, rb.inner) > std::min(ra.outer, rb.outer) + clearance) return false;
  if (!take_common(ra, rb, on, pair)) return false;
  if (both) {
    pair.shaft_in_a = ra.inner + ra.outer < rb.inner + rb.outer;
  } else {
    pair.shaft_in_a = is_cylinder(fa) ? !fa.hole : fb.hole;
  }
  pair.sign = both ? ThreadSign::flanks : ThreadSign::flanks_of_one;
  pair.lead = on.lead;
  pair.radius = 0.5 * (std::max(ra.inner, rb.inner) + std::min(ra.outer, rb.outer));
  return true;
}

// The lead that a hole drilled for the tap tells: its diameter is the thread's less the pitch (ISO 2306), or the minor diameter's,
// 1.0825 pitches less (ISO 724); the nearest that a coarse thread of this diameter has, where that is near.
double lead_of_overlap(double radius, double overlap) {
  const double coarse = coarse_lead(2.0 * radius), drawn = 2.0 * overlap;
  return std::abs(drawn - coarse) < 0.25 * coarse ? coarse : drawn;
}

bool cylinders_overlap(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                       const std::string& name_a, const std::string& name_b, double clearance,
                       FacePair& pair) {
  if (!is_cylinder(fa) || !is_cylinder(fb) || fa.hole == fb.hole) return false;
  const PlacedFace &shaft = fa.hole ? fb : fa, &bore = fa.hole ? fa : fb;
  const double overlap = shaft.radius - bore.radius;
  // A thread's depth is 0.54 pitches, which are at most a quarter of its diameter; with the root of the bolt 0.61.
  if (overlap <= 0.02 * shaft.radius || overlap > 0.3 * shaft.radius) return false;
  if (!on_one_axis(shaft, bore, clearance)) return false;
  const Reach rs = reach_of(fa.hole ? b : a, shaft, shaft.point, shaft.axis),
              rb = reach_of(fa.hole ? a : b, bore, shaft.point, shaft.axis);
  if (!take_common(rs, rb, shaft, pair)) return false;
  pair.shaft_in_a = !fa.hole;
  pair.sign = ThreadSign::overlap;
  pair.radius = shaft.radius;
  pair.lead = lead_of_overlap(shaft.radius, overlap);
  for (const std::string* name : {&name_a, &name_b})
    if (const auto named = thread_named(*name); named && named->lead > 0.0) pair.lead = named->lead;
  return true;
}

}  // namespace

double coarse_lead(double diameter) {
  const auto nearest = std::ranges::min_element(
      kCoarse, {}, [&](const auto& row) { return std::abs(std::log(row[0] / (1e3 * diameter))); });
  return 1e-3 * (*nearest)[1];
}

std::optional<NamedThread> thread_named(const std::string& name) {
  std::string low;
  for (const char c : name) low += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  NamedThread found;
  bool is_one = false;
  for (const char* const word : {"spindle", "spindel", "lead screw", "leadscrew", "lead_screw", "ball screw",
                                 "ballscrew", "power screw", "jack screw", "jackscrew", "gewindestange"})
    if (low.find(word) != std::string::npos) is_one = found.drives = true;
  for (const char* const word : {"screw", "thread", "gewinde", "schraube"})
    if (low.find(word) != std::string::npos) is_one = true;
  // M8, Tr16: a letter's word and its diameter, nothing before it in the word; then x and the lead, or the length.
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  for (std::size_t i = 0; i + 1 < low.size(); ++i) {
    if (i > 0 && is_letter(low[i - 1])) continue;
    const bool is_trapezoidal = low.compare(i, 2, "tr") == 0;
    const std::size_t digits = low[i] == 'm' ? i + 1 : is_trapezoidal ? i + 2 : low.size();
    if (digits >= low.size() || low[digits] < '1' || low[digits] > '9') continue;
    is_one = true;
    found.drives = found.drives || is_trapezoidal;
    const char* const end = low.data() + low.size();
    double diameter = 0.0, second = 0.0;
    auto read = std::from_chars(low.data() + digits, end, diameter, std::chars_format::fixed);
    if (read.ec != std::errc() || diameter > 1000.0) break;
    found.diameter = 1e-3 * diameter;
    const char* at = read.ptr;
    while (at != end && *at == ' ') ++at;
    if (at == end || *at != 'x') break;
    for (++at; at != end && *at == ' ';) ++at;
    read = std::from_chars(at, end, second, std::chars_format::fixed);
    // "M8x40" is 40 long; pitches are at most a quarter of the diameter, of trapezoidal threads with several starts a half.
    if (read.ec == std::errc() && second > 0.0 && second <= (is_trapezoidal ? 0.5 : 0.26) * diameter)
      found.lead = 1e-3 * second;
    break;
  }
  return is_one ? std::optional(found) : std::nullopt;
}

std::vector<FacePair> find_threads(const PlacedPart& a, const PlacedPart& b, const std::string& name_a,
                                   const std::string& name_b, double clearance) {
  std::vector<FacePair> threads;
  const auto apart = [&](const PlacedFace& f, const PlacedFace& g) {
    return ((f.low.array() - clearance) > g.high.array()).any() ||
           ((g.low.array() - clearance) > f.high.array()).any();
  };
  const auto take = [&](FacePair pair) {
    // The better sign first; what is longer among equals.
    for (FacePair& known : threads) {
      const Vector3d between = known.point - pair.point;
      if (known.axis.cross(pair.axis).norm() > kSameDirection ||
          (between - pair.axis * pair.axis.dot(between)).norm() > clearance)
        continue;
      if (pair.sign < known.sign || (pair.sign == known.sign && pair.extent > known.extent))
        known = std::move(pair);
      return;
    }
    threads.push_back(std::move(pair));
  };
  for (const PlacedFace& fa : a.faces)
    for (const PlacedFace& fb : b.faces) {
      if (apart(fa, fb)) continue;
      FacePair pair{.face_a = fa.number, .face_b = fb.number};
      if (flanks_meet(a, fa, b, fb, clearance, pair) ||
          cylinders_overlap(a, fa, b, fb, name_a, name_b, clearance, pair))
        take(std::move(pair));
    }
  for (FacePair& pair : threads) pair.contacts = screw_contacts(pair);
  return threads;
}

std::vector<Contact> screw_contacts(const FacePair& pair) {
  std::vector<Contact> contacts;
  const Matrix3d R = mbs::frame_along(pair.axis);
  const double advance = pair.lead / (2.0 * std::numbers::pi), r = pair.radius;
  constexpr int around = 12;
  for (int k = 0; k < around; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / around;
    const Vector3d radial = R * Vector3d(std::cos(angle), std::sin(angle), 0.0),
                   tangent = pair.axis.cross(radial);
    // Across the screw's velocity r tangent + advance axis, and across the radius.
    const Vector3d flank = (r * pair.axis - advance * tangent).normalized();
    for (const double end : {-0.5, 0.5}) {
      const Vector3d p = pair.point + r * radial + end * pair.extent * pair.axis;
      contacts.push_back({p, pair.shaft_in_a ? radial : Vector3d(-radial)});
      contacts.push_back({p, flank});
      contacts.push_back({p, -flank});
    }
  }
  return contacts;
}

}  // namespace flexura::import::cad
