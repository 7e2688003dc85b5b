// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/model/model.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "beam/model/mechanism.hpp"

namespace flexura::beam {
namespace {

void require_index(const std::string& what, const char* kind, int index, std::size_t size) {
  if (index < 0 || index >= static_cast<int>(size))
    throw std::invalid_argument(
        fmt::format("{}: there is no {} number {}; there are {}", what, kind, index, size));
}

void check_indices(const Model& model) {
  if (model.members.empty()) throw std::invalid_argument("the beam model has no members; give at least one");
  for (const Member& member : model.members) {
    const std::string what = fmt::format("member \"{}\"", member.name);
    for (const MemberEnd& end : member.end) require_index(what, "node", end.node, model.nodes.size());
    require_index(what, "section", member.section, model.sections.size());
    if (member.section_at_end >= 0)
      require_index(what, "section", member.section_at_end, model.sections.size());
    if (member.direction_node >= 0) require_index(what, "node", member.direction_node, model.nodes.size());
    if (member.elements < 0)
      throw std::invalid_argument(
          fmt::format("{}: {} elements is not a number of elements; give 1 or more", what, member.elements));
  }
  for (const PointMass& mass : model.point_masses)
    require_index("a point mass", "node", mass.node, model.nodes.size());
  for (const int anchor : model.anchors) require_index("an anchor", "node", anchor, model.nodes.size());
  for (const Node& node : model.nodes)
    if (!node.p_BoN_B.allFinite())
      throw std::invalid_argument(fmt::format("node \"{}\": its position is not finite", node.name));
}

void check_tapers(const Model& model) {
  for (const Member& member : model.members) {
    if (member.section_at_end < 0) continue;
    const SectionEntry &first = model.sections[member.section],
                       &second = model.sections[member.section_at_end];
    if (!first.shape || !second.shape)
      throw std::invalid_argument(
          fmt::format("member \"{}\" tapers between \"{}\" and \"{}\", which are not both standard shapes; "
                      "tapers need two standard "
                      "shapes of the same kind (or several members, each uniform)",
                      member.name, first.section.name, second.section.name));
    try {
      interpolate(*first.shape, *second.shape, 0.5);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("member \"{}\": {}", member.name, error.what()));
    }
  }
}

void check_masses(const Model& model) {
  for (const PointMass& mass : model.point_masses) {
    const std::string what = fmt::format("point mass at node \"{}\"", model.nodes[mass.node].name);
    if (!(mass.mass >= 0.0) || !std::isfinite(mass.mass))
      throw std::invalid_argument(fmt::format("{}: mass = {:g} must not be negative", what, mass.mass));
    const Eigen::Matrix3d& I = mass.I_C_B;
    const double size = I.trace();
    // Of any body: int x^2 dm = tr/2 - I_xx >= 0 in every direction, that is tr/2 1 - I positive
    // semi-definite.
    const Eigen::Matrix3d second = 0.5 * size * Eigen::Matrix3d::Identity() - I;
    const double tolerance = 1e-9 * std::max(size, 0.0);
    const bool symmetric = (I - I.transpose()).cwiseAbs().maxCoeff() <= tolerance;
    const double minor_xy = second(0, 0) * second(1, 1) - second(0, 1) * second(0, 1);
    const double minor_yz = second(1, 1) * second(2, 2) - second(1, 2) * second(1, 2);
    const double minor_xz = second(0, 0) * second(2, 2) - second(0, 2) * second(0, 2);
    if (!I.allFinite() || !symmetric || second.diagonal().minCoeff() < -tolerance ||
        std::min({minor_xy, minor_yz, minor_xz}) < -tolerance * size ||
        second.determinant() < -tolerance * size * size)
      throw std::invalid_argument(fmt::format(
          "{}: no body has the inertia ({:g}, {:g}, {:g}; {:g}, {:g}, {:g}): each principal moment may be at "
          "most the sum of the other two",
          what, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(1, 2), I(2, 0)));
  }
}

// Parts joined by members; every part but one needs an anchor.
void check_connection(const Model& model) {
  std::vector<int> parent(model.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  std::vector<bool> used(model.nodes.size(), false);
  for (const Member& member : model.members) {
    parent[root(member.end[0].node)] = root(member.end[1].node);
    used[member.end[0].node] = used[member.end[1].node] = true;
  }
  for (const Member& member : model.members)  // a node that only shows a direction needs no member of its own
    if (member.direction_node >= 0) used[member.direction_node] = true;
  std::vector<bool> joined(model.nodes.size(), false);
  for (const int anchor : model.anchors) used[anchor] = joined[anchor] = true;
  for (const Member& member : model.members) joined[member.end[0].node] = joined[member.end[1].node] = true;
  for (const PointMass& mass : model.point_masses)
    if (!joined[mass.node]) used[mass.node] = false;
  for (std::size_t node = 0; node < model.nodes.size(); ++node)
    if (!used[node])
      throw std::invalid_argument(fmt::format(
          "node \"{}\" is not connected to any member; connect it or take it out", model.nodes[node].name));
  std::vector<bool> anchored(model.nodes.size(), false);
  for (const int anchor : model.anchors) anchored[root(anchor)] = true;
  const int first = root(model.members.front().end[0].node);
  for (const Member& member : model.members) {
    const int part = root(member.end[0].node);
    if (part != first && !anchored[part])
      throw std::invalid_argument(fmt::format(
          "member \"{}\" is not connected to member \"{}\": the beam model falls into separate parts; let "
          "them share a node",
          member.name, model.members.front().name));
  }
}

}  // namespace

Placement placement_of(const Model& model, const Member& member) {
  const Eigen::Vector3d& p_1 = model.nodes[member.end[0].node].p_BoN_B;
  const Eigen::Vector3d& p_2 = model.nodes[member.end[1].node].p_BoN_B;
  const Eigen::Vector3d end_1 = p_1 + member.end[0].offset_B, end_2 = p_2 + member.end[1].offset_B;
  Eigen::Vector3d direction;
  if (member.direction_B)
    direction = *member.direction_B;
  else if (member.direction_node >= 0)
    direction = model.nodes[member.direction_node].p_BoN_B - end_1;
  else
    direction = default_direction(end_2 - end_1);
  return place(fmt::format("member \"{}\"", member.name), p_1, p_2, direction, member.end[0].offset_B,
               member.end[1].offset_B);
}

void check(const Model& model) {
  check_indices(model);
  for (const Member& member : model.members) placement_of(model, member);
  check_tapers(model);
  check_masses(model);
  check_connection(model);
  mechanism_of(model);  // refuses members that are loose by themselves
}

std::vector<std::string> warnings(const Model& model, const std::vector<int>& fixed) {
  std::vector<int> members_at(model.nodes.size(), 0);
  for (const Member& member : model.members)
    for (const MemberEnd& end : member.end) ++members_at[end.node];
  for (const int node : fixed) members_at[node] += 2;
  std::vector<std::string> texts;
  if (const std::string mechanism = mechanism_of(model); !mechanism.empty()) texts.push_back(mechanism);
  for (const Member& member : model.members) {
    const Section& section = model.sections[member.section].section;
    if (!section.open_thin_walled) continue;
    int held = 0;
    for (const MemberEnd& end : member.end) held += !end.warping_free && members_at[end.node] > 1;
    if (held == 0) continue;
    const double length = placement_of(model, member).length;
    if (!(section.I_w > 0.0) || !section.material || !section.constants) {
      texts.push_back(
          fmt::format("member \"{}\": its section \"{}\" is open and thin-walled and its warping is held at "
                      "{} end(s), which a beam element of 12 dofs cannot carry; it will twist too much "
                      "(warping constant unknown, no estimate)",
                      member.name, section.name, held));
      continue;
    }
    // Twist of a bar with one end held against warping, other free: theta' length (1 - tanh(a)/a) of
    // Saint-Venant's; both ends held: 1 - tanh(a/2)/(a/2) (Vlasov, Thin-walled elastic beams, 1961).
    const double decay =
        std::sqrt(section.material->E * section.I_w / (section.material->G * section.constants->I_t));
    const double a = length / decay / held;
    const double share = std::tanh(a) / a;
    if (share < 0.02) continue;
    texts.push_back(fmt::format(
        "member \"{}\": its section \"{}\" is open and thin-walled and its warping is held at {} end(s); a "
        "beam element of 12 dofs cannot carry that: at {:.3g} m, {:.2g} times the decay length {:.3g} m, it "
        "twists {:.0f} % too much",
        member.name, section.name, held, length, length / decay, decay, 100.0 * share / (1.0 - share)));
  }
  return texts;
}

// Of a member, and of all together: at 24 numbers each, a row of them already loses half of the digits.
constexpr int most_elements = 100'000;

int elements_of(const Model& model, const Member& member, const Subdivision& rule) {
  if (member.elements > most_elements)
    throw std::invalid_argument(
        fmt::format("member \"{}\": {} elements; at most {} are taken, since static "
                    "displacements lose digits with each",
                    member.name, member.elements, most_elements));
  if (member.elements > 0) return member.elements;
  const double length = placement_of(model, member).length;
  double h = std::min(rule.max_length, length / std::max(1, rule.elements_per_member));
  if (rule.max_frequency_hz > 0.0) {
    const double omega = 2.0 * std::numbers::pi * rule.max_frequency_hz, e = rule.frequency_error;
    std::vector<int> sections = {member.section};
    if (member.section_at_end >= 0) sections.push_back(member.section_at_end);
    for (const int index : sections) {
      const SectionMatrices s = matrices_of(model.sections[index].section, member.theory);
      const double polar = s.inertia.m_yy + s.inertia.m_zz;
      const double k_stretch = omega * std::sqrt(s.inertia.m * s.f(N, N));
      const double k_torsion = omega * std::sqrt(polar * s.f(T, T));
      for (const double k : {k_stretch, k_torsion})
        if (k > 0.0) h = std::min(h, std::sqrt(24.0 * e) / k);
      for (const auto& [moment, shear] : {std::pair{M_y, V_z}, std::pair{M_z, V_y}}) {
        // Shear makes waves shorter: k^4 = (m omega^2 / EI) (1 + k^2 EI / (G A_s)), a quadratic in k^2.
        const double b = s.inertia.m * omega * omega * s.f(moment, moment);
        const double ratio = s.f(shear, shear) / s.f(moment, moment);
        const double k2 = 0.5 * (b * ratio + std::sqrt(b * b * ratio * ratio + 4.0 * b));
        if (!(k2 > 0.0)) continue;
        const double k = std::sqrt(k2);
        h = std::min(h, std::pow(720.0 * e, 0.25) / k);
        if (ratio > 0.0) h = std::min(h, std::sqrt(24.0 * e / (k2 * ratio)) / k);
      }
    }
  }
  if (!(h > 0.0))
    throw std::invalid_argument(
        fmt::format("member \"{}\": the element length {:g} wanted must be positive", member.name, h));
  const double n = std::ceil(length / h * (1.0 - 1e-12));
  if (!(n <= most_elements))
    throw std::invalid_argument(fmt::format(
        "member \"{}\": elements of {:.3g} m make {:.3g} of its {:.6g} m; at most {} are taken, "
        "since static displacements lose digits with each; give a greater size, a lower frequency "
        "or a greater frequency_error",
        member.name, h, n, length, most_elements));
  return std::max(1, static_cast<int>(n));
}

}  // namespace flexura::beam
