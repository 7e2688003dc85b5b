// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/joined.hpp"

/// Which constraint rows a mechanism keeps, and what they are called.
namespace flexura::mbs {

int Mechanism::n_left_out() const {
  return static_cast<int>(m_->rows.left_out().size());
}
std::vector<std::string> Mechanism::names_of_left_out(int i) const {
  return m_->rows.names_of_left_out(i);
}

std::unique_ptr<Equations> Mechanism::copy_for_rows() const {
  for (int i = 0; i < n_left_out(); ++i) {
    if (m_->rows.names_of_left_out(i).size() < 2) continue;
    auto copy = std::make_unique<Mechanism>(description());
    copy->m_->rows.take_choice(m_->rows.choice());
    return copy;
  }
  return nullptr;
}

bool Mechanism::choose_rows(const State& s, const std::function<bool()>& accepts) {
  ConstraintRows& rows = m_->rows;
  ConstraintRows::Choice before = rows.choice();
  rows.keep_all();
  const auto scratch = make_scratch();
  Eigen::MatrixXd G(rows.n_all(), m_->tree.n_v);
  constraint_matrix(s, s.p, *scratch, G);
  const ConstraintSizes sizes = constraint_sizes(s, s.p, *scratch);
  const Eigen::VectorXd unit =
      m_->coordinates.kinematic_scale(m_->kinematics.extent(scratch_of(*scratch).motion));
  G = (sizes.size.cwiseMax(1e-300).cwiseInverse().asDiagonal() * G * unit.asDiagonal()).eval();
  // Rows of speeds say nothing of where the mechanism may be, and take the place of none that does.
  std::vector<int> candidates = before.kept;
  for (const int row : before.left_out)
    if (rows.is_holonomic(row)) candidates.push_back(row);
  std::vector<int> kept = most_independent(G, candidates, static_cast<int>(before.kept.size()));
  if (kept.size() == before.kept.size() && kept != before.kept) {
    Redundancy found = with_kept(G, std::move(kept));
    rows.take_choice({std::move(found.kept), std::move(found.left_out), std::move(found.follows_from)});
    if (accepts()) return true;
  }
  rows.take_choice(std::move(before));
  return false;
}

std::vector<RedundantRow> Mechanism::drop_redundant(When when, ConstVectorRef p) {
  ConstraintRows& rows = m_->rows;
  rows.keep_all();
  if (rows.n_all() == 0) return {};
  const auto scratch = make_scratch();
  Redundancy found = m_->constraints.redundant(*this, when, p, scratch_of(*scratch));
  std::vector<RedundantRow> redundant;
  for (std::size_t i = 0; i < found.left_out.size(); ++i) {
    redundant.push_back({rows.name_of_row(found.left_out[i]), {}});
    for (const int k : found.follows_from[i]) redundant.back().follows_from.push_back(rows.name_of_row(k));
  }
  rows.take_choice({std::move(found.kept), std::move(found.left_out), std::move(found.follows_from)});
  return redundant;
}

bool Mechanism::is_holonomic(int row) const {
  return m_->rows.is_holonomic(row);
}
RowPlace Mechanism::row_place(int i) const {
  return m_->rows.place_of_row(m_->rows.kept()[i]);
}
std::string Mechanism::name_of_constraint(int i) const {
  return m_->rows.name_of_row(m_->rows.kept()[i]);
}

}  // namespace flexura::mbs
