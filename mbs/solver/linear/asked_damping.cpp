// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/asked_damping.hpp"

#include "mbs/bodies/flexible_body.hpp"
#include "mbs/bodies/modal_data.hpp"

namespace flexura::mbs {

AskedDamping::AskedDamping(const Mechanism& mechanism, const State& s) {
  const Sizes n = mechanism.sizes();
  std::vector<int> row_of(static_cast<std::size_t>(n.n_p), -1);
  for (int i = 0; i < n.n_v; ++i) {
    int i_p = -1;
    double k = 0.0, d = 0.0;
    if (mechanism.elastic_coordinate(i, i_p, k, d)) row_of[static_cast<std::size_t>(i_p)] = i;
  }
  const auto& bodies = mechanism.description().bodies;
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    const FlexibleBody* body = mechanism.deforming(static_cast<int>(b));
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (!body || !body->modal() || first < 0) continue;
    const ModalData& data = *body->modal();
    Part part{Eigen::VectorXi(body->m()), data.stiffness, data.asked_damping};
    for (int i = 0; i < body->m(); ++i) part.rows(i) = row_of[static_cast<std::size_t>(first + i)];
    if (part.rows.size() == 0 || part.rows.minCoeff() < 0) continue;
    any_ |= part.asked.size() > 0 && !part.asked.isZero(0.0);
    parts_.push_back(std::move(part));
  }
  if (!any_) return;
  M_.resize(n.n_v, n.n_v);
  mechanism.mass_matrix(s.p, *mechanism.make_scratch(), M_);
}

std::optional<double> AskedDamping::of(const NaturalMode& mode) const {
  if (!any_ || mode.eigenvalue.imag() == 0.0) return {};
  // Twice the energies, at the amplitude of the shape: E as the largest kinetic energy.
  const double total = std::norm(mode.eigenvalue) * mode.shape.dot(M_ * mode.shape).real();
  constexpr double kTakesPart = 1e-3;  // of the energy: less changes no ratio in its third digit
  double asked = 0.0;
  for (const Part& part : parts_) {
    const Eigen::VectorXcd x = mode.shape(part.rows);
    if (part.asked.size() > 0)
      asked += x.dot(part.asked * x).real();
    else if (part.omega2.dot(x.cwiseAbs2()) > kTakesPart * total)
      return {};
  }
  // What is no more than round-off of the shape is none.
  return asked < 1e-12 * total ? 0.0 : asked / total;
}

}  // namespace flexura::mbs
