// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/full_model.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <stdexcept>

#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;

// The same part with only one interface retained (or none): the nodes of the others are free, hence interior.
Part with_retained(Part part, const std::string& name) {
  for (InterfaceSpec& interface : part.interfaces)
    if (interface.name != name) interface.directions.clear();
  return part;
}

PartShare free_share(const Part& part, const PartShare& share) {
  return share_retied(share, share.team->rank() == 0 ? with_retained(part, "") : Part{}, true);
}

template <class Interfaces>
int index_of(const Interfaces& interfaces, const std::string& name) {
  for (std::size_t k = 0; k < interfaces.size(); ++k)
    if (interfaces[k].name == name) return static_cast<int>(k);
  throw std::invalid_argument(fmt::format("the part has no interface '{}'", name));
}

}  // namespace

FreeModes free_modes_on_nodes(const Part& part, const linalg::EigenRequest& request, double omega2_scale,
                              const linalg::Progress& progress, const PartShare* share) {
  AssemblyOptions options;
  options.may_be_free = true;
  options.shift = omega2_scale;
  std::optional<PartShare> free;
  if (share) free = free_share(part, *share);
  const TiedModel model = free ? TiedModel(*free, options) : TiedModel(with_retained(part, ""), options);
  if (free) free->part = {};  // its elements are in the matrices
  const TiedSolver solver(model, progress);
  linalg::EigenProblem problem = fixed_interface_problem(model, solver);
  problem.shift = omega2_scale;
  problem.multiply_K = [&model, omega2_scale](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    MatrixXd MX;
    model.multiply_K(X, Y);
    model.multiply_M(X, MX);
    Y -= omega2_scale * MX;
  };
  // The model's K_ii has the shift in it.
  problem.shifted = [shifted = problem.shifted, omega2_scale](double sigma) {
    return shifted(sigma + omega2_scale);
  };
  FreeModes modes{linalg::block_lanczos(problem, request, progress), {}, {}, {}};
  const MatrixXd none = MatrixXd::Zero(model.n_b(), modes.pairs.Phi.cols());
  model.expand(modes.pairs.Phi, none, modes.U);
  modes.rotations = model.motions().expand_rotations(modes.pairs.Phi, none);
  for (int k = 0; k < model.n_interfaces(); ++k)
    modes.motion.push_back(model.interface_motion(k, modes.pairs.Phi));
  modes.pairs.Phi.resize(0, 0);
  return modes;
}

linalg::EigenPairs full_free_modes(const Part& part, int count, double omega2_scale,
                                   const linalg::Progress& progress, double tolerance) {
  return free_modes_on_nodes(part, {count + 6, 0.0, tolerance}, omega2_scale, progress).pairs;
}

linalg::EigenPairs full_clamped_modes(const Part& part, const std::string& clamped, int count,
                                      const linalg::Progress& progress) {
  index_of(part.interfaces, clamped);
  const TiedModel model(with_retained(part, clamped));
  const TiedSolver solver(model, progress);
  return linalg::block_lanczos(fixed_interface_problem(model, solver), {count, 0.0, 1e-9}, progress);
}

MatrixXd full_static_compliance(const Part& part, const std::string& clamped, const std::string& loaded,
                                const linalg::Progress& progress) {
  index_of(part.interfaces, clamped);
  const TiedModel model(with_retained(part, clamped));
  const TiedSolver solver(model, progress);
  const MatrixXd load =
      model.motions().interface_load(index_of(part.interfaces, loaded), MatrixXd::Identity(6, 6));
  const MatrixXd u_i = solver.solve_refined(load, MatrixXd::Zero(model.A().rows(), 6)).U;
  const MatrixXd u_b = MatrixXd::Zero(model.n_b(), 6);
  MatrixXd motions(6 * model.n_interfaces(), 6);
  for (int k = 0; k < model.n_interfaces(); ++k)
    motions.middleRows(6 * k, 6) = model.motions().interface_motion(k, u_i, u_b);
  return motions;
}

MatrixXd reduced_static_compliance(const Reduction& reduction, const std::string& clamped,
                                   const std::string& loaded) {
  const int fixed = reduction.interfaces[index_of(reduction.interfaces, clamped)].first_dof;
  const int pulled = reduction.interfaces[index_of(reduction.interfaces, loaded)].first_dof;
  std::vector<int> free;
  for (int k = 0; k < reduction.n(); ++k)
    if (k < fixed || k >= fixed + 6) free.push_back(k);
  MatrixXd load = MatrixXd::Zero(reduction.n(), 6);
  load.middleRows(pulled, 6).setIdentity();
  MatrixXd motion = MatrixXd::Zero(reduction.n(), 6);
  const MatrixXd K = reduction.K_se(free, free);
  const MatrixXd solution = K.ldlt().solve(MatrixXd(load(free, Eigen::all)));
  motion(free, Eigen::all) = solution;
  return motion.topRows(reduction.n_b);
}

Eigen::VectorXd reduced_free_modes(const Reduction& reduction) {
  return linalg::generalized_eigen(reduction.K_se, reduction.M_se).values;
}

}  // namespace flexura::reduce
