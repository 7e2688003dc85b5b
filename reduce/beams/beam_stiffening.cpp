// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/beam_stiffening.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <stdexcept>

#include "beam/element/slopes.hpp"

namespace flexura::reduce {
namespace {

using beam::Matrix12d;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

using beam::InertiaLoads;

constexpr int kInertiaLoads = UnitTensions::kInertiaLoads;

struct SectionHere {
  beam::SectionInertia inertia;
  double r2 = 0.0;  // (I_y + I_z) / A
};

SectionHere section_at(const beam::Model& model, const beam::Member& member, double t) {
  const auto here = [](const beam::Section& section) {
    const beam::SectionInertia& i = section.inertia;
    SectionHere out{i, i.m > 0.0 ? (i.m_yy + i.m_zz) / i.m : 0.0};
    if (section.constants && section.constants->A > 0.0)
      out.r2 = (section.constants->I_y + section.constants->I_z) / section.constants->A;
    return out;
  };
  const beam::SectionEntry& first = model.sections[member.section];
  if (member.section_at_end < 0) return here(first.section);
  const beam::Material& material = *first.section.material;
  const beam::Shape shape = interpolate(*first.shape, *model.sections[member.section_at_end].shape, t);
  return here(make_section(first.section.name, constants_of(shape, material.nu(), first.formula), material));
}

}  // namespace

UnitTensions::UnitTensions(const Structure& structure, const std::vector<BeamInterface>& interfaces,
                           const std::vector<LoadCase>& cases)
    : mesh_(structure.mesh()), cases_(cases), lines_(mesh_.elements().size()) {
  if (!structure.solids().empty())
    throw std::invalid_argument(
        "geometric stiffening is asked for of a beam part with solids, of which only the beams would "
        "stiffen; take `stiffening` away or reduce the solid as a part of its own");
  const auto holds = std::find_if(interfaces.begin(), interfaces.end(),
                                  [](const BeamInterface& i) { return i.directions.size() == 6; });
  if (holds == interfaces.end())
    throw std::invalid_argument(
        "geometric stiffening of a beam part needs an interface that keeps all six directions, to balance "
        "unit loads; let one keep them or take `stiffening` away");
  const beam::Model& model = mesh_.model();
  for (const BeamInterface& interface : interfaces)
    for (const int direction : interface.directions)
      dof_of_load_.push_back(&interface == &*holds ? -1 : 6 * interface.node + direction);

  const Index n_loads = loads();
  MatrixXd P = MatrixXd::Zero(structure.n_dofs(), n_loads);
  for (std::size_t e = 0; e < mesh_.elements().size(); ++e) {
    const beam::MeshElement& record = mesh_.elements()[e];
    const beam::Member& member = model.members[record.member];
    const beam::Element element = mesh_.element(record);
    const std::array<InertiaLoads, 2> ends = {
        beam::line_loads(record.placement, 0.0, section_at(model, member, record.t_1).inertia),
        beam::line_loads(record.placement, element.length(), section_at(model, member, record.t_2).inertia)};
    const Matrix12d to_nodes = record.placement.transform().transpose();
    for (int k = 0; k < kInertiaLoads; ++k) {
      lines_[e][k] = {ends[0].col(k), ends[1].col(k)};
      const beam::Vector12d p = to_nodes * element.load(lines_[e][k]);
      P.col(k).segment<6>(6 * record.node[0]) += p.head<6>();
      P.col(k).segment<6>(6 * record.node[1]) += p.tail<6>();
    }
  }
  for (const beam::PointMass& mass : model.point_masses) {
    const Vector3d& c = mass.p_NC_B;
    const Matrix3d about_C = 0.5 * mass.I_C_B.trace() * Matrix3d::Identity() - mass.I_C_B;
    P.block<6, kInertiaLoads>(6 * mass.node, 0) += beam::inertia_loads(
        mesh_.points()[mass.node], mass.mass, mass.mass * c, about_C + mass.mass * c * c.transpose());
  }
  for (std::size_t b = 0; b < dof_of_load_.size(); ++b)
    if (dof_of_load_[b] >= 0) P(dof_of_load_[b], kInertiaLoads + static_cast<Index>(b)) = 1.0;
  for (Index k = first_case(); k < n_loads; ++k)
    P.col(k) = load_vector(structure, cases[static_cast<std::size_t>(k - first_case())]);

  const Numbering numbering(structure, {*holds});
  const SplitMatrix K(structure.stiffness(), numbering);
  const linalg::CholeskyFactor factor = factorise(structure, numbering, K);
  U_ = MatrixXd::Zero(structure.n_dofs(), n_loads);
  U_(numbering.dof_of, Eigen::all) = solve_refined(factor, *K.ii, P(numbering.dof_of, Eigen::all));
}

VectorXd UnitTensions::at(int e, const beam::Element& element, double x) const {
  const beam::MeshElement& record = mesh_.elements()[static_cast<std::size_t>(e)];
  MatrixXd q(12, U_.cols());
  q << U_.middleRows<6>(6 * record.node[0]), U_.middleRows<6>(6 * record.node[1]);
  q = (record.placement.transform() * q).eval();
  VectorXd N = VectorXd::Zero(loads());
  for (Index k = 0; k < loads(); ++k) {
    const bool is_case = k >= first_case();
    if (k >= kInertiaLoads && !is_case && dof_of_load_[static_cast<std::size_t>(k - kInertiaLoads)] < 0)
      continue;
    const LoadCase* load = is_case ? &cases_[static_cast<std::size_t>(k - first_case())] : nullptr;
    const beam::LineLoad along = k < kInertiaLoads
                                     ? lines_[static_cast<std::size_t>(e)][static_cast<std::size_t>(k)]
                                 : load ? beam::load_on(record, load->members)
                                        : beam::LineLoad{};
    N(k) = element.section_forces(x, q.col(k), along)(beam::N);
    if (load) N(k) += preload_of(*load, record.member);
  }
  return N;
}

double UnitTensions::radius2(int e, double x) const {
  const beam::MeshElement& record = mesh_.elements()[static_cast<std::size_t>(e)];
  return section_at(mesh_.model(), mesh_.model().members[record.member],
                    record.t_1 + x / record.placement.length * (record.t_2 - record.t_1))
      .r2;
}

StiffeningTerms beam_stiffening_terms(const Structure& structure,
                                      const std::vector<BeamInterface>& interfaces, const MatrixXd& T,
                                      const std::vector<LoadCase>& cases) {
  const UnitTensions tensions(structure, interfaces, cases);
  const beam::BeamMesh& mesh = structure.mesh();
  const Index n = T.cols();
  StiffeningTerms terms;
  for (std::size_t b = 0; b < tensions.dof_of_load().size(); ++b)
    if (tensions.dof_of_load()[b] < 0) terms.held.push_back(static_cast<int>(b));

  std::vector<MatrixXd> K_0(static_cast<std::size_t>(tensions.loads()), MatrixXd::Zero(n, n));
  for (std::size_t e = 0; e < mesh.elements().size(); ++e) {
    const beam::MeshElement& record = mesh.elements()[e];
    const beam::Element element = mesh.element(record);
    MatrixXd shapes(12, n);
    shapes << T.middleRows<6>(6 * record.node[0]), T.middleRows<6>(6 * record.node[1]);
    shapes = (record.placement.transform() * shapes).eval();
    for (const beam::SlopeStation& at : beam::slope_stations(element, element.length())) {
      MatrixXd slopes = at.slopes * shapes;  // 3 x n
      slopes.row(2) *= std::sqrt(tensions.radius2(static_cast<int>(e), at.x));
      const MatrixXd unit = at.weight * (slopes.transpose() * slopes);
      const VectorXd N = tensions.at(static_cast<int>(e), element, at.x);
      for (Index k = 0; k < N.size(); ++k)
        if (N(k) != 0.0) K_0[static_cast<std::size_t>(k)] += N(k) * unit;
    }
  }
  for (int a = 0; a < 3; ++a) terms.K0t[a] = std::move(K_0[a]);
  for (int a = 0; a < 3; ++a) terms.K0r[a] = std::move(K_0[3 + a]);
  for (int k = 0; k < 6; ++k) terms.K0omega[k] = std::move(K_0[6 + k]);
  for (Index k = kInertiaLoads; k < tensions.loads(); ++k)
    (k < tensions.first_case() ? terms.K0F : terms.K0p)
        .push_back(std::move(K_0[static_cast<std::size_t>(k)]));
  return terms;
}

}  // namespace flexura::reduce
