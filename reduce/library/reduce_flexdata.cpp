// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/documents/document.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/library/modal_integrals.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/superelement/to_superelement.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using superelement::Direction;
using superelement::FlexData;
using superelement::FlexDataBody;

// The file's numbers in SI.  Modes are of unit modal mass in the file's units: displacements per sqrt(mass) * length.
void to_si(FlexData& data, double length, double mass) {
  for (FlexData::NodeLine& node : data.nodes) node.position *= length;
  const double scale = 1.0 / std::sqrt(mass);
  for (Index row = 0; row < data.shapes.rows(); ++row)
    data.shapes.row(row) *= row % 6 < 3 ? scale : scale / length;
  for (FlexData::LoadLine& load : data.loads) load.on_modes *= std::sqrt(mass) * length;
}

// The body as the part file gives it, for a file without integrals.
FlexDataBody rigid_body(const FlexDataInput& input, const FlexData& data) {
  if (!input.mass || !input.centre || !input.inertia)
    throw input::InputError(fmt::format(
        "{}: {} holds modes at the interface nodes, but no mass; give the body's mass, centre and inertia in "
        "a table [flexdata] of "
        "a part file (flexura reduce --schema-flexdata), as the program prints them that made the file",
        input.where, input.file.string()));
  const auto m = static_cast<Index>(data.modes.size());
  FlexDataBody body;
  body.mass = *input.mass;
  body.S_x = body.mass * *input.centre;
  body.S_xx = 0.5 * input.inertia->trace() * Matrix3d::Identity() - *input.inertia +
              body.mass * *input.centre * input.centre->transpose();
  for (const FlexData::NodeLine& node : data.nodes) {
    body.names.push_back(fmt::format("node {}", node.id));
    body.directions.push_back({Direction::u_x, Direction::u_y, Direction::u_z, Direction::theta_x,
                               Direction::theta_y, Direction::theta_z});
  }
  body.S_phi.setZero(3, m);
  body.S_xphi.setZero(9, m);
  for (std::size_t k = 0; k < 6; ++k)
    body.S_phiphi[k] = k < 3 ? MatrixXd(MatrixXd::Identity(m, m) / 3.0) : MatrixXd(MatrixXd::Zero(m, m));
  return body;
}

}  // namespace

Reduced reduce(const FlexDataInput& input, const ReduceOptions&) {
  FlexData data = superelement::read_flexdata(input.file, input.id);
  if (data.nodes.empty())
    throw std::invalid_argument(
        input.file.string() +
        ": has no interface nodes to which anything could be joined; at least one is needed");
  if (data.modes.empty())
    throw std::invalid_argument(input.file.string() +
                                ": has no modes; a body that does not deform needs no superelement, "
                                "only its mass and inertia in the mechanism");
  std::vector<std::string> notes, warnings;
  const bool has_integrals = data.body.has_value();
  if (data.body) {
    if (input.mass || input.centre || input.inertia || input.has_units)
      throw input::InputError(input.where + ": " + input.file.string() +
                              " brings its mass and inertia along, in kg and m; leave mass, centre, inertia, "
                              "unit and mass_unit out");
  } else {
    to_si(data, input.unit_length, input.unit_mass);
    data.body = rigid_body(input, data);
    warnings.push_back(
        "the file has no inertia integrals: that centrifugal and Coriolis forces deform the body is left "
        "out, so that results "
        "hold while it turns slowly against its lowest frequency");
  }
  FlexDataBody& body = *data.body;
  check_body(body, input.file.string());
  if (!input.names.empty()) {
    if (input.names.size() != data.nodes.size())
      throw input::InputError(fmt::format("{}.names: {} names for {} interface nodes; give each node one",
                                          input.where, input.names.size(), data.nodes.size()));
    body.names = input.names;
  }
  const auto m = static_cast<Index>(data.modes.size());
  const Vector3d centre = body.S_x / body.mass;

  Reduction r;
  r.inertia = integrals_of(body);
  r.M_se = r.inertia.S_phiphi[0] + r.inertia.S_phiphi[1] + r.inertia.S_phiphi[2];
  r.K_se = MatrixXd::Zero(6 + m, 6 + m);
  MatrixXd B(0, 6 + m), places(3 * static_cast<Index>(data.nodes.size()), 6 + m);
  for (std::size_t k = 0; k < data.nodes.size(); ++k) {
    const auto first = static_cast<Index>(6 * k);
    MatrixXd motion(6, 6 + m);
    motion << node_motion_at(data.nodes[k].position - centre), data.shapes.middleRows<6>(first);
    places.middleRows<3>(3 * static_cast<Index>(k)) = motion.topRows<3>();
    ReducedInterface interface { .name = body.names[k], .tie = Tie::rigid, .point = data.nodes[k].position };
    interface.first_dof = static_cast<int>(B.rows());
    for (const Direction d : body.directions[k]) interface.directions.push_back(static_cast<int>(d));
    B.conservativeResize(B.rows() + static_cast<Index>(interface.directions.size()), Eigen::NoChange);
    B.bottomRows(static_cast<Index>(interface.directions.size())) = motion(interface.directions, Eigen::all);
    r.interfaces.push_back(std::move(interface));
  }
  r.n_b = static_cast<int>(B.rows());
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(6 + m);
  bool differs = false;
  for (Index j = 0; j < m; ++j) {
    const FlexData::ModeLine& mode = data.modes[static_cast<std::size_t>(j)];
    r.K_se(6 + j, 6 + j) = mode.eigenvalue;
    damping(6 + j) = 2.0 * mode.damping * std::sqrt(mode.eigenvalue);
    differs = differs || std::abs(mode.damping - body.modal_damping) > 1e-9 * mode.damping;
    // Printed digits of the shapes.
    if (std::abs(r.M_se(6 + j, 6 + j) - 1.0) > 1e-6)
      throw std::invalid_argument(fmt::format("{}: mode {} has the modal mass {:g}, 1 is wanted",
                                              input.file.string(), mode.id, r.M_se(6 + j, 6 + j)));
  }
  // Alike but for printed digits, it is the body's ratio.
  if (differs) r.D_se = damping.asDiagonal();
  r.shapes = places.cast<float>();
  for (const FlexData::LoadLine& load : data.loads) {
    if (load.has_rigid && !load.resultant)
      warnings.push_back(
          fmt::format("load case {}: what it does to rigid motion is left out, as the file does not tell the "
                      "axes of its rigid modes; the load "
                      "deforms the body alone",
                      load.name));
    ReducedLoad& reduced = r.loads.emplace_back();
    reduced.name = load.name;
    reduced.is_preload = load.is_preload;
    reduced.p_se = Eigen::VectorXd::Zero(6 + m);
    reduced.p_se.tail(m) = load.on_modes;
    if (!load.resultant) continue;
    const Vector3d force = load.resultant->head<3>();
    reduced.p_se.head<3>() = force;
    reduced.p_se.segment<3>(3) = load.resultant->tail<3>() - centre.cross(force);
  }
  const std::vector<int> own = independent_dofs(r.M_se, B);
  const std::vector<std::string> following = let_others_follow(r, B, own);
  if (!following.empty())
    notes.push_back(fmt::format(
        "the modes and the rigid motions move {} of the {} interface dofs independently; {} {} these: the "
        "body gives way to "
        "loads as far as its modes do, and what joints hold beyond that is held twice",
        own.size(), B.rows(), fmt::join(following, ", "), following.size() == 1 ? "follows" : "follow"));
  CanonicalShapes shapes;
  try {
    shapes = canonical_shapes(r.K_se, r.M_se, B(own, Eigen::all));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", input.file.string(), error.what()));
  }
  change_shapes(r, shapes);
  notes.insert(notes.begin(),
               fmt::format("{} modes of {} with the six rigid motions: {} interface dofs + {} modes", m,
                           input.file.filename().string(), r.n_b, r.n_q));
  const nlohmann::json json = {
      {"flexdata",
       {{"file", input.file.filename().string()},
        {"id", data.id},
        {"num_nodes", data.num_nodes},
        {"modes", m},
        {"has_integrals", has_integrals}}},
      {"notes", notes},
      {"warnings", warnings},
      {"verdict", "as good as the modes of the file; what its mesh and its choice of modes cost is unknown"}};
  PartInput named;  // what the superelement takes of a part's input
  named.name = input.name;
  named.source = input.source;
  named.modes.damping = body.modal_damping;
  superelement::Surface surface;  // its interface nodes, as points
  surface.vertices.resize(static_cast<Index>(data.nodes.size()), 3);
  for (std::size_t k = 0; k < data.nodes.size(); ++k)
    surface.vertices.row(static_cast<Index>(k)) = data.nodes[k].position;
  Reduced out;
  out.text = fmt::format("  {}\n  mass {:.6g} kg, centre ({:.5g}, {:.5g}, {:.5g}) m\n  {}\n",
                         fmt::join(notes, "\n  "), body.mass, centre.x(), centre.y(), centre.z(),
                         json["verdict"].get<std::string>());
  out.superelement = to_superelement(named, std::move(r), std::move(surface), json.dump(1));
  out.json = json;
  out.warnings = std::move(warnings);
  return out;
}

}  // namespace flexura::reduce
