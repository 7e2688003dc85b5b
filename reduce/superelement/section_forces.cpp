// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/section_forces.hpp"

namespace flexura::reduce {

superelement::SectionForces section_forces(const beam::BeamMesh& mesh, const Eigen::MatrixXd& T, int places) {
  superelement::SectionForces out;
  const auto& members = mesh.model().members;
  const Eigen::Index n_places = places * static_cast<Eigen::Index>(members.size());
  out.positions.resize(n_places, 3);
  out.axes.resize(n_places, 9);
  out.S.resize(6 * n_places, T.cols());
  Eigen::Index first = 0;
  for (int m = 0; m < static_cast<int>(members.size()); ++m, first += places) {
    out.members.push_back(members[m].name);
    out.member.insert(out.member.end(), static_cast<std::size_t>(places), m);
    const beam::Placement whole = beam::placement_of(mesh.model(), members[m]);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_BE = whole.R_BE;
    for (Eigen::Index k = 0; k < T.cols(); ++k) {
      const auto results = beam::member_results(mesh, m, T.col(k).head(mesh.n_dofs()), places);
      for (int p = 0; p < places; ++p) {
        out.S.block<6, 1>(6 * (first + p), k) = results[p].resultants;
        if (k > 0) continue;
        out.positions.row(first + p) = (whole.p_Bo1_B + results[p].x * whole.R_BE.col(0)).transpose();
        out.axes.row(first + p) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(R_BE.data());
      }
    }
  }
  return out;
}

}  // namespace flexura::reduce
