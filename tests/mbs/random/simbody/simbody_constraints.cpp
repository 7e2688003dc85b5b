// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/mbs/random/simbody/simbody_system.hpp"

/// What closes loops, couplings and drives, by Simbody's constraints.
namespace flexura::mbs::chance {

namespace sim = SimTK;

namespace {

/// Pivots of independent rows, squares of sines of the angles between them.
constexpr double kIndependent = 1e-8;

class LawFunction : public sim::Function {
 public:
  explicit LawFunction(const Law& law) : law_(law) {}
  sim::Real calcValue(const sim::Vector& t) const override { return law_.value(t[0]); }
  sim::Real calcDerivative(const sim::Array_<int>& along, const sim::Vector& t) const override {
    if (along.size() == 1) return law_.rate(t[0]);
    return -law_.c * law_.w * law_.w * std::sin(law_.w * t[0] + law_.phi);
  }
  int getArgumentSize() const override { return 1; }
  int getMaxDerivativeOrder() const override { return 2; }

 private:
  const Law law_;
};

}  // namespace

void SimbodySystem::add_constraints() {
  for (int j = 0; j < static_cast<int>(scene_.joints.size()); ++j) {
    const SceneJoint& joint = scene_.joints[j];
    if (!branch_of(j)) close(joint.type, joint.F, joint.M);
    for (const SceneDrive& d : joint.drives) drive(j, d);
  }
  for (const SceneConstraint& c : scene_.constraints) {
    if (!c.terms.empty())
      couple(c);
    else if (c.type == "distance")
      rows_.push_back(
          sim::Constraint::Rod(body_at(c.F), on_body(c.F).p(), body_at(c.M), on_body(c.M).p(), c.length));
    else
      close(c.type, c.F, c.M);
  }
}

// By constraints of one row each, of which those that say what others say can be left out.
void SimbodySystem::close(const std::string& type, int F, int M) {
  const sim::Transform X_AF = on_body(F), X_BM = on_body(M);
  sim::MobilizedBody &A = body_at(F), &B = body_at(M);
  const auto is = [&](auto... types) { return ((type == types) || ...); };
  const auto hold = [&](sim::CoordinateAxis along) {
    const sim::UnitVec3 normal = X_AF.R().getAxisUnitVec(along);
    rows_.push_back(sim::Constraint::PointInPlane(A, normal, sim::dot(normal, X_AF.p()), B, X_BM.p()));
  };
  const auto square = [&](sim::CoordinateAxis of_F, sim::CoordinateAxis of_M) {
    rows_.push_back(sim::Constraint::ConstantAngle(A, X_AF.R().getAxisUnitVec(of_F), B,
                                                   X_BM.R().getAxisUnitVec(of_M), 0.5 * sim::Pi));
  };
  if (is("revolute", "spherical", "universal", "fixed", "prismatic", "cylindrical", "point_on_line"))
    hold(sim::XAxis), hold(sim::YAxis);
  if (is("revolute", "spherical", "universal", "fixed", "planar", "point_on_plane")) hold(sim::ZAxis);
  if (is("revolute", "cylindrical", "planar", "parallel"))
    square(sim::XAxis, sim::ZAxis), square(sim::YAxis, sim::ZAxis);
  if (is("universal")) square(sim::XAxis, sim::YAxis);
  if (is("perpendicular")) square(sim::ZAxis, sim::ZAxis);
  if (is("prismatic", "orientation", "fixed"))
    square(sim::XAxis, sim::YAxis), square(sim::YAxis, sim::ZAxis), square(sim::ZAxis, sim::XAxis);
}

// sum factor q = offset
void SimbodySystem::couple(const SceneConstraint& c) {
  std::vector<double> factors;
  if (c.type == "gear")
    factors = {1.0, (c.internal ? -1.0 : 1.0) * c.teeth_2 / c.teeth_1};
  else if (c.type == "rack_and_pinion")
    factors = {1.0, -c.length};
  else
    for (const auto& term : c.terms) factors.push_back(term.factor);
  sim::Vector row(static_cast<int>(factors.size()) + 1);
  sim::Array_<sim::MobilizedBodyIndex> bodies;
  sim::Array_<sim::MobilizerQIndex> coordinates;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const Coordinate q = coordinate(c.terms[i].joint, c.terms[i].coordinate);
    row[static_cast<int>(i)] = factors[i];
    bodies.push_back(q.body);
    coordinates.push_back(q.q);
  }
  row[static_cast<int>(factors.size())] = -c.offset;
  rows_.push_back(
      sim::Constraint::CoordinateCoupler(matter_, new sim::Function::Linear(row), bodies, coordinates));
}

// A drive by speed or acceleration starts where its law does.
void SimbodySystem::drive(int joint, const SceneDrive& drive) {
  const Coordinate q = coordinate(joint, drive.coordinate);
  rows_.push_back(sim::Constraint::PrescribedMotion(matter_, new LawFunction(drive.law), q.body, q.q));
}

// Simbody counts redundant rows as independent where they agree only to round-off, and solves for any motion: it is given
// independent ones.  By Cholesky's factors of G M^-1 G^T with pivots, each row first made of length 1.
void SimbodySystem::choose_rows() {
  for (const sim::Constraint& row : rows_) row.enable(state_);
  system_.realize(state_, sim::Stage::Velocity);
  open_ = 0.0;
  // Angles that were counted from another turn differ by whole ones.
  for (int i = 0; i < state_.getNQErr(); ++i)
    open_ = std::max(open_, std::abs(std::remainder(state_.getQErr()[i], 2.0 * sim::Pi)));
  for (int i = 0; i < state_.getNUErr(); ++i) open_ = std::max(open_, std::abs(state_.getUErr()[i]));
  sim::Matrix W;
  matter_.calcProjectedMInv(state_, W);
  const int n = static_cast<int>(rows_.size());
  std::vector<double> scale(n, 0.0), left(n, 1.0);
  least_pivot_ = 1.0;
  largest_left_ = 0.0;
  // A row on one free body has about 1 / mass or, in rad, more: what is far below moves nothing of the tree.
  double heaviest = 0.0;
  for (const SceneBody& body : scene_.bodies) heaviest = std::max(heaviest, body.mass);
  for (int i = 0; i < n; ++i) {
    if (heaviest * W(i, i) > kIndependent) {
      scale[i] = 1.0 / std::sqrt(W(i, i));
    } else {  // the tree alone holds it, as in a plane
      left[i] = 0.0;
      largest_left_ = std::max(largest_left_, heaviest * W(i, i));
    }
  }
  std::vector<std::vector<double>> factors;  // one of each row that is kept
  std::vector<bool> is_kept(n, false);
  for (int kept = 0; kept < n; ++kept) {
    const int k = static_cast<int>(std::max_element(left.begin(), left.end()) - left.begin());
    if (left[k] < kIndependent) {
      largest_left_ = std::max(largest_left_, left[k]);
      break;
    }
    least_pivot_ = std::min(least_pivot_, left[k]);
    is_kept[k] = true;
    std::vector<double> column(n);
    for (int i = 0; i < n; ++i) {
      column[i] = W(i, k) * scale[i] * scale[k];
      for (const auto& before : factors) column[i] -= before[i] * before[k];
      column[i] /= std::sqrt(left[k]);
    }
    for (int i = 0; i < n; ++i) left[i] = is_kept[i] ? 0.0 : left[i] - column[i] * column[i];
    factors.push_back(column);
  }
  n_kept_ = static_cast<int>(factors.size());
  for (int i = 0; i < n; ++i)
    if (!is_kept[i]) rows_[i].disable(state_);
  system_.realize(state_, sim::Stage::Velocity);
}

}  // namespace flexura::mbs::chance
