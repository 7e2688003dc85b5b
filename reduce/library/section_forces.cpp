// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/section_forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "beam/element/slopes.hpp"

namespace flexura::reduce {
namespace {

using beam::Matrix12d;
using beam::Matrix6d;
using Eigen::Index;
using Eigen::MatrixXd;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// S_uu or S_phiphi of (a, b): (b, a) is the transpose of what is kept.
template <class Products>
auto products(const Products& kept, int a, int b) {
  constexpr int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  const bool direct = a == b || b == (a + 1) % 3;
  using Matrix = std::decay_t<decltype(kept[0])>;
  return direct ? kept[at[a][b]] : Matrix(kept[at[a][b]].transpose());
}

// The resultants at x of a force and moment on end 1: s = -(1 + x D) f.
Matrix6Xd from_end_1(const Matrix6Xd& f, double x) {
  Matrix6Xd s = -f;
  s.row(beam::M_y) += x * s.row(beam::V_z);
  s.row(beam::M_z) -= x * s.row(beam::V_y);
  return s;
}

Matrix12d rotated(const Eigen::Matrix3d& R) {
  Matrix12d out = Matrix12d::Zero();
  for (int k = 0; k < 4; ++k) out.block<3, 3>(3 * k, 3 * k) = R;
  return out;
}

// An element, with what its own inertia asks of end 1.
struct CutElement {
  CutElement(const beam::BeamMesh& mesh, const beam::MeshElement& of)
      : record(of), element(mesh.element(of)), transform(of.placement.transform()), ends(of.placement) {
    ends.offset_B = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    blocks = element.inertia_blocks(ends);
  }

  // End displacements in the element's axes, 12 x columns.
  MatrixXd end_motion(const MatrixXd& U) const {
    MatrixXd nodal(12, U.cols());
    nodal << U.middleRows<6>(6 * record.node[0]), U.middleRows<6>(6 * record.node[1]);
    return transform * nodal;
  }
  // Resultants at x by end displacements: 6 x 12.
  MatrixXd elastic(double x) const {
    MatrixXd map(6, 12);
    for (int k = 0; k < 12; ++k) map.col(k) = element.section_forces(x, beam::Vector12d::Unit(k));
    return map;
  }
  // What an inertia load on end 1 (axes of B) and on the piece up to x (element axes) bears on the cut.
  Matrix6Xd inertial(const MatrixXd& on_end_1, const MatrixXd& on_piece, double x) const {
    const MatrixXd f = rotated(ends.R_BE.transpose()).topLeftCorner<6, 6>() * on_end_1;
    return from_end_1(f, x) + on_piece;
  }

  const beam::MeshElement& record;
  beam::Element element;
  Matrix12d transform;
  beam::Placement ends;
  beam::InertiaBlocks blocks;
};

using Place = CutPlace;

std::vector<Place> places_along(const beam::BeamMesh& mesh, int member, int places) {
  std::vector<Place> out;
  for (std::size_t e = 0; e < mesh.elements().size(); ++e) {
    const beam::MeshElement& record = mesh.elements()[e];
    if (record.member != member) continue;
    for (auto k = static_cast<int>(out.size()); k < places; ++k) {
      const double t = static_cast<double>(k) / (places - 1);
      if (t > record.t_2 * (1.0 + 1e-12)) break;
      const double share = (t - record.t_1) / (record.t_2 - record.t_1);
      out.push_back({static_cast<int>(e), record.placement.length * std::clamp(share, 0.0, 1.0)});
    }
  }
  return out;
}

// Calls visit(cut, p, x) for the places p, at x of the element cut.
template <class Visit>
void visit_places(const beam::BeamMesh& mesh, const std::vector<Place>& places, const Visit& visit) {
  std::optional<CutElement> cut;
  int of = -1;
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (places[p].element != of) {
      of = places[p].element;
      cut.emplace(mesh, mesh.elements()[static_cast<std::size_t>(of)]);
    }
    visit(*cut, static_cast<Index>(p), places[p].x);
  }
}

void put_deformation(const Structure& structure, const beam::InertiaSums& sums, const BeamReduction& beams,
                     const std::vector<Place>& places, superelement::SectionForces& out) {
  // So many shapes at once that what they lack stays within 100 MB.
  const Index n = beams.T.cols(), width = std::max<Index>(1, 1'400'000 / structure.n_dofs());
  out.of_deformation.resize(6 * static_cast<Index>(places.size()), 9 * n);
  for (Index first = 0; first < n; first += width) {
    const MatrixXd T = beams.T.middleCols(first, std::min(width, n - first));
    std::array<MatrixXd, 9> lack;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) lack[3 * a + b] = beams.left_out(-(products(sums.S_uu, b, a) * T));
    visit_places(structure.mesh(), places, [&](const CutElement& cut, Index p, double x) {
      const MatrixXd q_B = rotated(cut.ends.R_BE) * cut.end_motion(T), elastic = cut.elastic(x);
      const beam::CutInertia inertia = cut.element.cut_inertia(cut.ends, x);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const MatrixXd on_end = products(cut.blocks.S_phiphi, b, a).topRows<6>() * q_B;
          const MatrixXd F = elastic * cut.end_motion(lack[3 * a + b]) +
                             cut.inertial(on_end, inertia.of_ends[3 * a + b] * q_B, x);
          for (Index k = 0; k < T.cols(); ++k)
            out.of_deformation.block<6, 1>(6 * p, 9 * (first + k) + 3 * a + b) = F.col(k).cast<float>();
        }
    });
  }
}

// The load on the ends of each element, in its axes, of the shapes' slopes under tension of each unit load.
std::vector<Matrix12d> slope_stiffness(const UnitTensions& tensions, int e, const beam::Element& element) {
  std::vector<Matrix12d> out(static_cast<std::size_t>(tensions.loads()), Matrix12d::Zero());
  for (const beam::SlopeStation& at : beam::slope_stations(element, element.length())) {
    auto slopes = at.slopes;
    slopes.row(2) *= std::sqrt(tensions.radius2(e, at.x));
    const Matrix12d unit = at.weight * (slopes.transpose() * slopes);
    const Eigen::VectorXd N = tensions.at(e, element, at.x);
    for (Index k = 0; k < N.size(); ++k) out[static_cast<std::size_t>(k)] += N(k) * unit;
  }
  return out;
}

void put_stiffening(const Structure& structure, const UnitTensions& tensions, const BeamReduction& beams,
                    const std::vector<Place>& places, superelement::SectionForces& out) {
  const beam::BeamMesh& mesh = structure.mesh();
  const Index n = beams.T.cols(), n_loads = tensions.loads();
  std::vector<std::vector<Matrix12d>> stiffness;
  for (std::size_t e = 0; e < mesh.elements().size(); ++e)
    stiffness.push_back(slope_stiffness(tensions, static_cast<int>(e), mesh.element(mesh.elements()[e])));

  // By the displacements of the element's ends, in its axes: 6 x 12 for each place and load.
  std::vector<MatrixXd> elastic(places.size()), own(places.size());
  visit_places(mesh, places, [&](const CutElement& cut, Index at, double x) {
    const auto p = static_cast<std::size_t>(at);
    elastic[p] = cut.elastic(x);
    own[p].resize(6, 12 * n_loads);
    for (Index k = 0; k < n_loads; ++k)
      own[p].middleCols<12>(12 * k) = from_end_1(
          stiffness[static_cast<std::size_t>(places[p].element)][static_cast<std::size_t>(k)].topRows<6>(),
          x);
    for (const beam::SlopeStation& station : beam::slope_stations(cut.element, x)) {
      const Eigen::VectorXd N = tensions.at(places[p].element, cut.element, station.x);
      for (Index k = 0; k < n_loads; ++k) {
        own[p].row(beam::M_y).segment<12>(12 * k) -= station.weight * N(k) * station.slopes.row(1);
        own[p].row(beam::M_z).segment<12>(12 * k) += station.weight * N(k) * station.slopes.row(0);
      }
    }
  });

  out.of_stiffening.resize(6 * static_cast<Index>(places.size()), n_loads * n);
  for (Index k = 0; k < n_loads; ++k) {
    MatrixXd P = MatrixXd::Zero(structure.n_dofs(), n);
    for (std::size_t e = 0; e < mesh.elements().size(); ++e) {
      const CutElement cut(mesh, mesh.elements()[e]);
      const MatrixXd p =
          cut.transform.transpose() * (stiffness[e][static_cast<std::size_t>(k)] * cut.end_motion(beams.T));
      P.middleRows<6>(6 * cut.record.node[0]) -= p.topRows<6>();
      P.middleRows<6>(6 * cut.record.node[1]) -= p.bottomRows<6>();
    }
    const MatrixXd lack = beams.left_out(P);
    visit_places(mesh, places, [&](const CutElement& cut, Index at, double) {
      const auto p = static_cast<std::size_t>(at);
      const MatrixXd F =
          elastic[p] * cut.end_motion(lack) + own[p].middleCols<12>(12 * k) * cut.end_motion(beams.T);
      out.of_stiffening.block(6 * at, k * n, 6, n) = F.cast<float>();
    });
  }
}

}  // namespace

superelement::SectionForces section_forces(const Structure& structure, const BeamReduction& beams,
                                           const std::vector<LoadCase>& cases, int most,
                                           const UnitTensions* tensions) {
  const beam::BeamMesh& mesh = structure.mesh();
  const auto& members = mesh.model().members;
  std::vector<Place> places;
  std::vector<std::string> names;
  std::vector<std::int32_t> member;
  std::vector<int> elements(members.size(), 0);
  for (const beam::MeshElement& record : mesh.elements()) ++elements[record.member];
  for (std::size_t m = 0; m < members.size(); ++m) {
    // Nine or more, each element's ends among them.
    const int share = std::max(4, most / static_cast<int>(members.size())),
              wanted = elements[m] * ((7 + elements[m]) / elements[m]) + 1;
    const std::vector<Place> along = places_along(mesh, static_cast<int>(m), std::min(share, wanted));
    places.insert(places.end(), along.begin(), along.end());
    names.push_back(members[m].name);
    member.insert(member.end(), along.size(), static_cast<int>(m));
  }
  superelement::SectionForces out = section_forces_at(structure, beams, cases, places, true, tensions);
  out.members = std::move(names);
  out.member = std::move(member);
  return out;
}

superelement::SectionForces section_forces_at(const Structure& structure, const BeamReduction& beams,
                                              const std::vector<LoadCase>& cases,
                                              const std::vector<CutPlace>& places, bool with_inertia,
                                              const UnitTensions* tensions) {
  const beam::BeamMesh& mesh = structure.mesh();
  superelement::SectionForces out;
  const auto n_p = static_cast<Index>(places.size());
  const Index n = beams.T.cols();
  const beam::InertiaSums sums = structure.inertia();
  MatrixXd P(structure.n_dofs(), with_inertia ? 12 : 0);
  if (with_inertia) {
    put_deformation(structure, sums, beams, places, out);
    P << -sums.S_u.transpose(), -sums.S_xu.transpose();
  }
  const MatrixXd lack_position = beams.left_out(P);
  P.resize(structure.n_dofs(), static_cast<Index>(cases.size()));
  for (std::size_t k = 0; k < cases.size(); ++k)
    P.col(static_cast<Index>(k)) = load_vector(structure, cases[k]);
  const MatrixXd lack_cases = beams.left_out(P);

  out.positions.resize(n_p, 3);
  out.axes.resize(n_p, 9);
  out.S.resize(6 * n_p, n);
  if (with_inertia) {
    out.of_acceleration.resize(6 * n_p, 12);
    out.turning.resize(3 * n_p, n);
  }
  if (!cases.empty()) out.of_loads.resize(6 * n_p, static_cast<Index>(cases.size()));
  visit_places(mesh, places, [&](const CutElement& cut, Index p, double x) {
    const MatrixXd q = cut.end_motion(beams.T), elastic = cut.elastic(x);
    out.S.middleRows<6>(6 * p) = elastic * q;
    if (with_inertia) {
      MatrixXd on_end(6, 12);
      on_end << cut.blocks.S_phi.leftCols<6>().transpose(), cut.blocks.S_xphi.leftCols<6>().transpose();
      out.of_acceleration.middleRows<6>(6 * p) =
          elastic * cut.end_motion(lack_position) +
          cut.inertial(on_end, cut.element.cut_inertia(cut.ends, x).of_position, x);
      out.turning.middleRows<3>(3 * p) = cut.ends.R_BE * (cut.element.shape(x) * q).bottomRows<3>();
    }
    const MatrixXd q_cases = cut.end_motion(lack_cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const auto k = static_cast<Index>(i);
      beam::Vector6d F =
          cut.element.section_forces(x, q_cases.col(k), beam::load_on(cut.record, cases[i].members));
      F(beam::N) += preload_of(cases[i], cut.record.member);
      out.of_loads.block<6, 1>(6 * p, k) = F;
    }
    out.positions.row(p) = (cut.ends.p_Bo1_B + x * cut.ends.R_BE.col(0)).transpose();
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_BE = cut.ends.R_BE;
    out.axes.row(p) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(R_BE.data());
  });
  if (tensions) put_stiffening(structure, *tensions, beams, places, out);
  return out;
}

}  // namespace flexura::reduce
