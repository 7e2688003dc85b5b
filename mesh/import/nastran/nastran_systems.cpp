// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_systems.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

namespace flexura::mesh {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

Vector3d NastranSystem::rectangular(const Vector3d& x) const {
  if (kind == 'C') return {x[0] * std::cos(kDegree * x[1]), x[0] * std::sin(kDegree * x[1]), x[2]};
  if (kind == 'S') {
    const double s = std::sin(kDegree * x[1]);
    return {x[0] * s * std::cos(kDegree * x[2]), x[0] * s * std::sin(kDegree * x[2]),
            x[0] * std::cos(kDegree * x[1])};
  }
  return x;
}

Eigen::Matrix3d NastranSystem::axes_at(const Vector3d& x) const {
  if (kind == 'R') return R;
  const Vector3d from = x - origin, z = R.col(2), around = z.cross(from);
  if (!(around.norm() > 1e-12 * from.norm())) return R;  // on the axis
  const Vector3d t = around.normalized();
  Eigen::Matrix3d axes;
  if (kind == 'C') {
    axes << t.cross(z), t, z;
  } else {  // r, theta from the axis, phi
    const Vector3d r = from.normalized();
    axes << r, t.cross(r), t;
  }
  return axes;
}

void NastranSystems::add(const Card& card) {
  static const std::set<std::string> kSystems = {"CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"};
  if (kSystems.contains(card.name)) {
    system_cards_[card.integer(0)] = &card;
    if (card.name[4] == '1' && !card.blank(4)) system_cards_[card.integer(4)] = &card;  // two on one card
  }
  if (card.name == "GRID") grid_cards_.emplace(card.integer(0), &card);
  if (card.name == "GRDSET") grdset_ = &card;
}

const NastranSystem& NastranSystems::system(std::int64_t id, const Where& where, int depth) {
  if (const auto found = systems_.find(id); found != systems_.end()) return found->second;
  if (id == 0) return systems_[0] = NastranSystem();
  const auto found = system_cards_.find(id);
  if (found == system_cards_.end())
    throw std::invalid_argument(fmt::format("{}: coordinate system {} is not defined", where.text(), id));
  if (depth > 50)
    throw std::invalid_argument(fmt::format(
        "{}: coordinate system {} stands on more than 50 others, or on itself", where.text(), id));
  const Card& card = *found->second;
  NastranSystem s;
  s.kind = card.name[5];
  std::array<Vector3d, 3> p;
  if (card.name[4] == '2') {
    const NastranSystem& reference = system(card.integer(1, 0), card.where, depth + 1);
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = reference.place({card.real(2 + 3 * k, 0), card.real(3 + 3 * k, 0), card.real(4 + 3 * k, 0)});
  } else {
    const std::size_t first = card.integer(0) == id ? 0 : 4;
    for (std::size_t k = 0; k < 3; ++k) p[k] = grid_place(card.integer(first + 1 + k), card.where, depth + 1);
  }
  const Vector3d z = (p[1] - p[0]).normalized();
  const Vector3d y = z.cross(p[2] - p[0]);
  if (!z.allFinite() || !(y.norm() > 1e-12 * (p[2] - p[0]).norm()))
    throw std::invalid_argument(
        fmt::format("{}: the three points of coordinate system {} lie on a line", card.where.text(), id));
  s.R.col(2) = z;
  s.R.col(1) = y.normalized();
  s.R.col(0) = s.R.col(1).cross(z);
  s.origin = p[0];
  return systems_[id] = s;
}

Vector3d NastranSystems::grid_place(std::int64_t id, const Where& where, int depth) {
  const auto found = grid_cards_.find(id);
  if (found == grid_cards_.end())
    throw std::invalid_argument(fmt::format("{}: GRID {} is not defined", where.text(), id));
  const Card& card = *found->second;
  const std::int64_t cp = card.integer(1, grdset_ ? grdset_->integer(1, 0) : 0);
  return system(cp, card.where, depth).place({card.real(2, 0), card.real(3, 0), card.real(4, 0)});
}

}  // namespace flexura::mesh
