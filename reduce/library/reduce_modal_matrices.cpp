// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/reduce_modal_matrices.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "mbs/base/documents/document.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/library/modal_integrals.hpp"
#include "reduce/library/request.hpp"
#include "reduce/linalg/session/session.hpp"
#include "reduce/part/nastran_matrices.hpp"
#include "reduce/part/op4.hpp"
#include "reduce/part/part_mesh.hpp"
#include "reduce/superelement/to_superelement.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Dof = std::pair<std::int64_t, int>;  // point, component (0: scalar)

// What ten printed digits leave of matrices that belong together.
constexpr double kPrinted = 1e-6;

using Entries = std::map<std::pair<Dof, Dof>, double>;

Entries read_entries(const std::filesystem::path& path, char letter) {
  Entries entries;
  read_dmig(path, letter, [&](const DmigEntry& e) {
    const Dof row{e.point[0], e.component[0]}, column{e.point[1], e.component[1]};
    entries[{row, column}] = entries[{column, row}] = e.value;
  });
  return entries;
}

// Grid points first, each with its components, then scalar points.
std::vector<Dof> dofs_of(const std::vector<const Entries*>& matrices) {
  std::set<Dof> all;
  for (const Entries* entries : matrices)
    for (const auto& [at, value] : *entries) all.insert(at.first);
  std::vector<Dof> dofs(all.begin(), all.end());
  std::ranges::stable_partition(dofs, [](const Dof& dof) { return dof.second != 0; });
  return dofs;
}

// In SI: work is that of coordinates in m and rad; modal coordinates keep their unit.
MatrixXd dense(const Entries& entries, const std::vector<Dof>& dofs, const PartInput& input) {
  std::map<Dof, Index> place;
  for (const Dof& dof : dofs) place.emplace(dof, static_cast<Index>(place.size()));
  const auto unit = [&](const Dof& dof) {
    return dof.second >= 1 && dof.second <= 3 ? input.unit_length : 1.0;
  };
  MatrixXd A = MatrixXd::Zero(std::ssize(dofs), std::ssize(dofs));
  for (const auto& [at, value] : entries)
    A(place.at(at.first), place.at(at.second)) =
        value * input.unit_mass * input.unit_length * input.unit_length / (unit(at.first) * unit(at.second));
  return A;
}

struct Grid {
  std::int64_t label;
  Vector3d x;
  std::vector<int> directions;  // 0 to 5
  Index first;                  // its first dof
  std::string name;
};

std::vector<Grid> grids_of(const PartInput& input, const std::vector<Dof>& dofs) {
  const mesh::Mesh mesh = load_nodes(input);
  std::map<std::int64_t, Vector3d> at;
  for (Index node = 0; node < mesh.n_nodes(); ++node)
    at.emplace(mesh.node_label.empty() ? node + 1 : mesh.node_label[static_cast<std::size_t>(node)],
               mesh.points.row(node).transpose());
  std::map<std::int64_t, std::string> names;
  for (const InterfaceInput& interface : input.interfaces) {
    const auto* const rule = std::get_if<mesh::NodesRule>(&interface.rule);
    if (!rule || rule->labels.size() != 1 || !rule->points.empty())
      throw input::InputError(
          interface.where +
          ": the interfaces of a reduced body are its grid points: give by = \"nodes\" and "
          "one number");
    names.emplace(rule->labels.front(), interface.name);
  }
  std::vector<Grid> grids;
  for (std::size_t k = 0; k < dofs.size() && dofs[k].second != 0; ++k) {
    const auto& [label, component] = dofs[k];
    if (grids.empty() || grids.back().label != label) {
      const auto x = at.find(label);
      if (x == at.end())
        throw std::invalid_argument(
            fmt::format("{}: has no node {}, at which {} has a matrix; give the file with the grid points",
                        input.cad.path.string(), label, input.stiffness.string()));
      const auto name = names.find(label);
      grids.push_back({label,
                       x->second,
                       {},
                       static_cast<Index>(k),
                       name == names.end() ? fmt::format("node {}", label) : name->second});
      if (name != names.end()) names.erase(name);
    }
    grids.back().directions.push_back(component - 1);
  }
  if (!names.empty())
    throw std::invalid_argument(fmt::format("interface \"{}\": node {} has no row in {}; name one that has",
                                            names.begin()->second, names.begin()->first,
                                            input.stiffness.string()));
  return grids;
}

// n x 6, about `centre`.
MatrixXd rigid_motions(const std::vector<Grid>& grids, Index n, const Vector3d& centre) {
  MatrixXd R = MatrixXd::Zero(n, 6);
  for (const Grid& grid : grids)
    R.middleRows(grid.first, std::ssize(grid.directions)) =
        node_motion_at(grid.x - centre)(grid.directions, Eigen::all);
  return R;
}

superelement::FlexDataBody body_of(const MatrixXd& M_R, const std::string& file) {
  superelement::FlexDataBody body;
  body.mass = M_R.topLeftCorner<3, 3>().trace() / 3.0;
  if (!(body.mass > 0.0) ||
      (M_R.topLeftCorner<3, 3>() - body.mass * Eigen::Matrix3d::Identity()).norm() > 1e-3 * body.mass)
    throw std::invalid_argument(
        fmt::format("{}: rigid motions of the grid points have the masses {:g}, {:g} and {:g}, which must be "
                    "one: the body's",
                    file, M_R(0, 0), M_R(1, 1), M_R(2, 2)));
  // int u . (w x x) dm: the translation along b and the rotation about c.
  const Eigen::Matrix3d C = M_R.topRightCorner<3, 3>();
  body.S_x = 0.5 * Vector3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
  body.S_x = -body.S_x;
  const Eigen::Matrix3d J = M_R.bottomRightCorner<3, 3>();
  body.S_xx = 0.5 * J.trace() * Eigen::Matrix3d::Identity() - 0.5 * (J + J.transpose());
  return body;
}

// Of the shapes T Y.
InertiaIntegrals transformed(const InertiaIntegrals& from, const MatrixXd& Y) {
  InertiaIntegrals to = from;
  to.S_phi = from.S_phi * Y;
  to.S_xphi = from.S_xphi * Y;
  for (std::size_t p = 0; p < 6; ++p) to.S_phiphi[p] = Y.transpose() * from.S_phiphi[p] * Y;
  return to;
}

}  // namespace

bool is_reduced_body(const PartInput& input) {
  if (input.stiffness.empty() || is_op4(input.stiffness) || !is_nastran_text(input.stiffness)) return false;
  bool scalar = false;
  read_dmig(input.stiffness, 'K',
            [&](const DmigEntry& e) { scalar = scalar || e.component[0] == 0 || e.component[1] == 0; });
  return scalar;
}

Reduced reduce_reduced_body(const PartInput& input) {
  const linalg::Session session;
  const std::string file = input.stiffness.string();
  if (input.recovery.stress || input.recovery.all_nodes || input.stiffening || !input.loads.empty() ||
      !input.masses.empty() || !input.links.empty())
    throw input::InputError(
        input.where +
        ": the body of these matrices is reduced already: [recovery], stiffening, [load], "
        "[mass] and [link] need its elements; leave them out");
  const Entries K_file = read_entries(input.stiffness, 'K'), M_file = read_entries(input.mass_matrix, 'M');
  // A body that one interface holds has no stiffness there, but mass.
  const auto is_of_grid = [](const auto& entry) { return entry.first.first.second != 0; };
  if (std::ranges::none_of(K_file, is_of_grid) && std::ranges::none_of(M_file, is_of_grid))
    throw std::invalid_argument(file +
                                ": has scalar points alone (component 0); give grid points, to which "
                                "something could be joined");
  Entries D_file;
  if (!input.damping_matrix.empty()) D_file = read_entries(input.damping_matrix, 'B');
  const std::vector<Dof> dofs = dofs_of({&K_file, &M_file, &D_file});
  const std::vector<Grid> grids = grids_of(input, dofs);
  const auto n = static_cast<Index>(dofs.size());
  const MatrixXd K = dense(K_file, dofs, input), M = dense(M_file, dofs, input);

  // Mass, centre and moments are those of rigid motions.
  const MatrixXd R_o = rigid_motions(grids, n, Vector3d::Zero());
  superelement::FlexDataBody body = body_of(R_o.transpose() * M * R_o, file);
  check_body(body, file);
  const Vector3d centre = body.S_x / body.mass;
  const MatrixXd R = rigid_motions(grids, n, centre), M_R = R.transpose() * M;
  // Each dof's shape as a rigid motion R C and the rest E, which is elastic.
  const MatrixXd C = MatrixXd(M_R * R).lu().solve(M_R), E = MatrixXd::Identity(n, n) - R * C;
  for (Index k = 0; k < 6; ++k) {
    const double size = R.col(k).cwiseAbs().dot(K.cwiseAbs() * R.col(k).cwiseAbs());
    if (std::abs(R.col(k).dot(K * R.col(k))) > kPrinted * size)
      throw std::invalid_argument(fmt::format(
          "{}: rigid motion of the grid points is resisted, by {:.2g} of what the terms of K have: the body "
          "is held, or its "
          "modal coordinates move rigidly, too; reduce it free, with all interface directions kept",
          file, std::abs(R.col(k).dot(K * R.col(k))) / size));
  }
  body.S_phi.setZero(3, n);
  body.S_xphi.setZero(9, n);
  for (std::size_t p = 0; p < 6; ++p)
    body.S_phiphi[p] = p < 3 ? MatrixXd(E.transpose() * M * E / 3.0) : MatrixXd(MatrixXd::Zero(n, n));
  MatrixXd Y(6 + n, n);
  Y << C, MatrixXd::Identity(n, n);

  Reduction r;
  r.inertia = transformed(integrals_of(body), Y);
  r.M_se = r.inertia.S_phiphi[0] + r.inertia.S_phiphi[1] + r.inertia.S_phiphi[2];
  // What printed digits leave of rigid motion is taken out of the grid points' rows alone: modal coordinates, soft beside them, would
  // feel it.
  MatrixXd hold = MatrixXd::Identity(n, n);
  const Index n_g = grids.back().first + std::ssize(grids.back().directions);
  const MatrixXd R_g = R.topRows(n_g);
  const MatrixXd W = R_g.transpose() * M.topLeftCorner(n_g, n_g);
  hold.topLeftCorner(n_g, n_g) -= R_g * MatrixXd(W * R_g).lu().solve(W);
  r.K_se = hold.transpose() * K * hold;
  if (!D_file.empty()) r.D_se = hold.transpose() * dense(D_file, dofs, input) * hold;
  MatrixXd B = MatrixXd::Zero(0, n), places(3 * std::ssize(grids), n);
  places.setZero();
  for (std::size_t k = 0; k < grids.size(); ++k) {
    const Grid& grid = grids[k];
    ReducedInterface interface { .name = grid.name, .tie = Tie::node, .point = grid.x };
    interface.first_dof = static_cast<int>(B.rows());
    interface.directions = grid.directions;
    const auto width = std::ssize(grid.directions);
    B.conservativeResize(B.rows() + width, n);
    B.bottomRows(width).setZero();
    B.bottomRows(width).middleCols(grid.first, width).setIdentity();
    for (Index d = 0; d < width; ++d)
      if (const int direction = grid.directions[static_cast<std::size_t>(d)]; direction < 3)
        places(3 * static_cast<Index>(k) + direction, grid.first + d) = 1.0;
    r.interfaces.push_back(std::move(interface));
  }
  r.n_b = static_cast<int>(B.rows());
  r.shapes = places.cast<float>();
  CanonicalShapes shapes;
  try {
    shapes = canonical_shapes(r.K_se, r.M_se, B);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", file, error.what()));
  }
  change_shapes(r, shapes);

  std::vector<std::string> notes{
      fmt::format("a body reduced by another program: {} interface dofs at {} grid points + {} modes", r.n_b,
                  grids.size(), r.n_q)},
      warnings{
          "the matrices do not tell how centrifugal and Coriolis forces deform the body, which is left out: "
          "results "
          "hold while it turns slowly against its lowest frequency"};
  strike_out(input, r, notes, warnings);
  const double ratio = put_damping(input, r.D_se.size() > 0, r);
  const nlohmann::json json = {
      {"reduction", {{"n_b", r.n_b}, {"n_q", r.n_q}}},
      {"notes", notes},
      {"warnings", warnings},
      {"verdict", "as good as the matrices; what their mesh and choice of modes cost is unknown"}};
  superelement::Surface surface;  // its grid points
  surface.vertices.resize(std::ssize(grids), 3);
  for (std::size_t k = 0; k < grids.size(); ++k)
    surface.vertices.row(static_cast<Index>(k)) = grids[k].x.transpose();
  Reduced out;
  out.text = fmt::format("  {}\n  mass {:.6g} kg, centre ({:.5g}, {:.5g}, {:.5g}) m\n  {}\n", notes.front(),
                         body.mass, centre.x(), centre.y(), centre.z(), json["verdict"].get<std::string>());
  out.superelement = to_superelement(input, std::move(r), std::move(surface), json.dump(1));
  out.superelement.modal_damping = ratio;
  out.json = json;
  out.warnings = std::move(warnings);
  return out;
}

}  // namespace flexura::reduce
