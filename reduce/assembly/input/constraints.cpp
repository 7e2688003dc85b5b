// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/input/constraints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "reduce/assembly/input/rigid_motion.hpp"

namespace flexura::reduce {
namespace {

using Row = std::map<NodalDof, double>;
// Coefficients smaller than this share of the largest are round-off of a substitution.
constexpr double kNothing = 1e-12;
// A dependent dof's coefficient must not be so small that others are blown up.
constexpr double kLeastPivot = 1e-3;
// Less is round-off of coordinates; more strains the body in rigid motions by more than a superelement may (1e-8).
constexpr double kRoundOff = 1e-9;

class Elimination {
 public:
  explicit Elimination(const std::function<bool(const NodalDof&)>& may_depend) : may_depend_(may_depend) {}

  Row substituted(const LinearEquation& equation) const {
    Row row;
    for (const auto& [dof, c] : equation.terms) add(row, dof, c);
    clean(row);
    return row;
  }

  void take(const LinearEquation& equation, const Row& row) {
    const std::optional<NodalDof> pivot = choose(equation, row);
    if (!pivot)
      throw std::invalid_argument(
          fmt::format("{} binds only dofs that follow something else already (nodes of rigid interfaces and "
                      "spiders; of rotations, equal "
                      "ones of two nodes alone can be bound): leave one of its nodes out of the interfaces",
                      equation.of));
    Row& own = dependent_[*pivot];
    const double c = row.at(*pivot);
    for (const auto& [dof, value] : row)
      if (dof != *pivot) own[dof] = -value / c;
    for (const auto& [dof, value] : own) users_[dof].insert(*pivot);
    // Who follows it follows now what it follows.
    const auto found = users_.find(*pivot);
    if (found == users_.end()) return;
    const std::set<NodalDof> users = std::move(found->second);
    users_.erase(found);
    for (const NodalDof& user : users) {
      Row& other = dependent_.at(user);
      const double factor = other.at(*pivot);
      other.erase(*pivot);
      for (const auto& [dof, value] : own) {
        other[dof] += factor * value;
        users_[dof].insert(user);
      }
    }
  }

  std::vector<DependentDof> result() const {
    std::vector<DependentDof> out;
    for (const auto& [dof, row] : dependent_) {
      DependentDof& to = out.emplace_back(DependentDof{.dof = dof, .from = {}});
      for (const auto& [from, value] : row)
        if (std::abs(value) > kNothing) to.from.emplace_back(from, value);
    }
    return out;
  }

 private:
  void add(Row& row, const NodalDof& dof, double c) const {
    const auto found = dependent_.find(dof);
    if (found == dependent_.end()) {
      row[dof] += c;
      return;
    }
    for (const auto& [from, value] : found->second) row[from] += c * value;
  }

  static void clean(Row& row) {
    double largest = 0;
    for (const auto& [dof, c] : row) largest = std::max(largest, std::abs(c));
    std::erase_if(row, [&](const auto& term) { return std::abs(term.second) <= kNothing * largest; });
  }

  bool can(const NodalDof& dof, const Row& row) const {
    if (!may_depend_(dof)) return false;
    if (dof.direction < 3) return true;
    // A rotation can be another one, not a combination.
    if (row.size() != 2) return false;
    const auto& other = row.begin()->first == dof ? *row.rbegin() : *row.begin();
    return other.first.direction >= 3 &&
           std::abs(other.second + row.at(dof)) <= kNothing * std::abs(other.second);
  }

  std::optional<NodalDof> choose(const LinearEquation& equation, const Row& row) const {
    double largest = 0;
    for (const auto& [dof, c] : row) largest = std::max(largest, std::abs(c));
    const NodalDof& first = equation.terms.front().first;
    if (const auto at = row.find(first);
        at != row.end() && std::abs(at->second) >= kLeastPivot * largest && can(first, row))
      return first;
    std::optional<NodalDof> best;
    double size = kLeastPivot * largest;
    for (const auto& [dof, c] : row)
      if (std::abs(c) > size && can(dof, row)) best = dof, size = std::abs(c);
    return best;
  }

  const std::function<bool(const NodalDof&)>& may_depend_;
  std::map<NodalDof, Row> dependent_;
  std::map<NodalDof, std::set<NodalDof>> users_;
};

}  // namespace

// What a rigid motion about the middle of the nodes, of size one at the body's reach, does to the equation.
std::string resisted_motion(const LinearEquation& equation, const NodePoints& points) {
  static constexpr const char* kMotions[] = {"a shift along x", "a shift along y", "a shift along z",
                                             "a turn about x",  "a turn about y",  "a turn about z"};
  const Eigen::Vector3d middle = 0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff());
  const double reach =
      std::max(0.5 * (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm(), 1e-300);
  Eigen::Matrix<double, 1, 6> violation = Eigen::Matrix<double, 1, 6>::Zero();
  double size = 0;
  for (const auto& [dof, c] : equation.terms) {
    Eigen::Matrix<double, 6, 6> motion = node_motion_at(Eigen::Vector3d(points.row(dof.node)) - middle);
    motion.rightCols<3>() /= reach;
    violation += c * motion.row(dof.direction);
    size += std::abs(c) * (dof.direction < 3 ? 1.0 : 1.0 / reach);
  }
  Eigen::Index worst = 0;
  return violation.cwiseAbs().maxCoeff(&worst) <= kRoundOff * size ? "" : kMotions[worst];
}

std::vector<DependentDof> eliminate(const std::vector<LinearEquation>& equations, const NodePoints& points,
                                    const std::function<bool(const NodalDof&)>& may_depend) {
  Elimination elimination(may_depend);
  for (const LinearEquation& equation : equations) {
    if (const std::string motion = resisted_motion(equation, points); !motion.empty())
      throw std::invalid_argument(fmt::format(
          "{} resists {} of the whole body: it binds the body to the ground, which is for joints at "
          "run time; take it out of the deck, or write it so that rigid motions fulfil it",
          equation.of, motion));
    const Row row = elimination.substituted(equation);
    if (!row.empty()) elimination.take(equation, row);
  }
  return elimination.result();
}

}  // namespace flexura::reduce
