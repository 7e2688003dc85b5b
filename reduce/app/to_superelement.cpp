// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/to_superelement.hpp"

#include <Eigen/LU>
#include <map>
#include <stdexcept>

#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

superelement::Superelement to_superelement(const PartInput& input, Reduction&& reduction,
                                           superelement::Surface&& surface, std::string report_json,
                                           std::vector<std::int32_t> stress_vertices) {
  superelement::Superelement se;
  se.name = input.name;
  se.created_by = "flexura-reduce " FLEXURA_VERSION;
  se.source = input.source;
  se.report_json = std::move(report_json);
  for (const ReducedInterface& from : reduction.interfaces) {
    if (from.directions.empty() && from.following.empty()) continue;  // a rigid piece of the part
    superelement::Interface to{.name = from.name, .tie = name_of(from.tie), .p_BoN_B = from.point};
    for (const int d : from.directions) to.directions.push_back(static_cast<superelement::Direction>(d));
    to.first_dof = from.first_dof;
    for (const int d : from.following) to.following.push_back(static_cast<superelement::Direction>(d));
    to.follow = from.follow;
    se.interfaces.push_back(std::move(to));
  }
  se.n_b = reduction.n_b;
  se.n_q = reduction.n_q;
  se.K_se = std::move(reduction.K_se);
  se.M_se = std::move(reduction.M_se);
  se.omega2 = std::move(reduction.omega2);
  se.D_se = std::move(reduction.D_se);
  for (ReducedLoad& load : reduction.loads)
    se.load_cases.push_back({load.name, std::move(load.p_se), std::move(load.moment)});
  se.modal_damping = input.modes.damping;
  se.inertia.mass = reduction.inertia.mass;
  se.inertia.S_x = reduction.inertia.S_x;
  se.inertia.S_xx = reduction.inertia.S_xx;
  se.inertia.S_phi = std::move(reduction.inertia.S_phi);
  se.inertia.S_xphi = std::move(reduction.inertia.S_xphi);
  se.inertia.S_phiphi = std::move(reduction.inertia.S_phiphi);
  if (reduction.stiffening) {
    StiffeningTerms& terms = *reduction.stiffening;
    se.stiffening = superelement::StiffeningTerms{.K0t = std::move(terms.K0t),
                                                  .K0r = std::move(terms.K0r),
                                                  .K0omega = std::move(terms.K0omega),
                                                  .K0F = std::move(terms.K0F)};
  }
  if (!stress_vertices.empty())
    se.stress = superelement::StressModes{.vertices = std::move(stress_vertices),
                                          .S = std::move(reduction.stress_modes),
                                          .double_precision = input.recovery.double_precision};
  se.surface = std::move(surface);
  se.shapes = std::move(reduction.shapes);
  return se;
}

void add_compliance(const Part& part, const std::vector<mesh::Index>& nodes,
                    superelement::StressModes& stress) {
  std::map<int, std::int32_t> numbers;
  for (const auto& [material, cells] : nodal_materials(part, nodes)) {
    if (material < 0) throw std::logic_error("stresses are wanted at a node of no solid");
    const auto [found, is_new] = numbers.emplace(material, static_cast<std::int32_t>(numbers.size()));
    if (is_new) stress.compliance.push_back(part.materials[static_cast<std::size_t>(material)].D.inverse());
    stress.material.push_back(found->second);
  }
}

}  // namespace flexura::reduce
