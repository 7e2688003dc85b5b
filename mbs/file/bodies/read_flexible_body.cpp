// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_flexible_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mbs/bodies/modal_basis.hpp"
#include "mbs/bodies/modal_problem.hpp"
#include "mbs/file/bodies/choose_frame.hpp"
#include "mbs/file/bodies/read_section_points.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/mechanism/acting_loads.hpp"
#include "mbs/superelement/known_errors.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using input::Section;
namespace dim = input::dim;

DampingLaw damping_law(const Section& s) {
  DampingLaw law;
  if (s.has("damping")) law.ratio = s.quantity("damping");
  for (const char* key : {"damping_by_mode", "damping_ratios", "damping_frequencies"}) {
    if (!s.has(key)) continue;
    const std::vector<double> values = s.quantities(key);
    if (values.empty()) s.refuse(key, "is empty", "give one entry at least, or take the key away");
    for (const double value : values)
      if (!(value >= 0.0))
        s.refuse(key, fmt::format("holds {:.6g}, which is negative", value),
                 "dampers take energy out: give ratios and frequencies of 0 or more");
  }
  if (s.has("damping_by_mode")) law.by_mode = s.quantities("damping_by_mode");
  if (s.has("damping_frequencies") != s.has("damping_ratios"))
    s.refuse(s.has("damping_ratios") ? "damping_ratios" : "damping_frequencies",
             "damping_frequencies and damping_ratios make a table together", "give both");
  if (s.has("damping_ratios")) {
    law.table_hz = s.quantities("damping_frequencies");
    law.table = s.quantities("damping_ratios");
    if (law.table.size() != law.table_hz.size() || law.table.empty())
      s.refuse("damping_ratios",
               fmt::format("has {} entries for {} frequencies", law.table.size(), law.table_hz.size()),
               "give one ratio for each frequency");
    for (std::size_t k = 1; k < law.table_hz.size(); ++k)
      if (!(law.table_hz[k] > law.table_hz[k - 1]))
        s.refuse("damping_frequencies",
                 fmt::format("{:.6g} Hz does not lie above the one before it, {:.6g} Hz", law.table_hz[k],
                             law.table_hz[k - 1]),
                 "sort the table");
  }
  if (s.has("rayleigh_alpha") || s.has("rayleigh_beta"))
    law.rayleigh = Eigen::Vector2d(s.has("rayleigh_alpha") ? s.quantity("rayleigh_alpha") : 0.0,
                                   s.has("rayleigh_beta") ? s.quantity("rayleigh_beta") : 0.0);
  const int laws =
      law.ratio.has_value() + !law.by_mode.empty() + !law.table.empty() + law.rayleigh.has_value();
  if (laws > 1)
    s.refuse("", "has more than one damping law",
             "keep one of damping, damping_by_mode, damping_frequencies, rayleigh_*");
  if (s.has("critical_above")) law.critical_above = s.quantity("critical_above");
  return law;
}

/// Loads where an interface does not keep the direction: the reduction has no constraint mode for them.
void note_free_directions(const superelement::Superelement& se, const BodyNodes& nodes,
                          const MechanismDescription& d, int body, std::vector<std::string>& notes) {
  static constexpr const char* kNames[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
  for (const int node : loaded_nodes(d, body)) {
    if (node >= static_cast<int>(se.interfaces.size())) continue;
    const superelement::Interface& interface = se.interfaces[static_cast<std::size_t>(node)];
    const std::array<bool, 6> loaded = loaded_directions(nodes, d, body, node);
    std::vector<std::string> by_modes, not_at_all;
    for (int k = 0; k < 6; ++k) {
      const auto direction = static_cast<superelement::Direction>(k);
      const auto has = [&](const std::vector<superelement::Direction>& list) {
        return std::ranges::find(list, direction) != list.end();
      };
      if (!loaded[static_cast<std::size_t>(k)] || has(interface.directions) || has(interface.following))
        continue;
      (has(interface.free) ? by_modes : not_at_all).push_back(kNames[k]);
    }
    const auto tell = [&](const std::vector<std::string>& directions, const char* how) {
      if (directions.empty()) return;
      notes.push_back(
          fmt::format("body \"{}\": what acts on interface \"{}\" may load it along {}, which it does not "
                      "keep: {}; keep all six "
                      "directions and reduce again where there is load",
                      d.bodies[body].name, interface.name, fmt::join(directions, ", "), how));
    };
    tell(by_modes, "there the part gives way by its kept modes alone, too little");
    tell(not_at_all, "there the part does not give way at all");
  }
}

}  // namespace

std::vector<input::Key> flexible_body_keys() {
  using namespace input;
  TableSchema point;
  point.name = "stress_point";
  point.doc = "A place whose stresses and strains are stored: the nearest one with stress modes.";
  point.keys = {vector3("position", dim::length, "in the body's frame, undeformed").required()};
  TableSchema surface_point = point;
  surface_point.name = "surface_point";
  surface_point.doc =
      "A place whose displacement by deformation, in the body's axes, and position in the world are stored: "
      "the "
      "nearest node of the superelement's surface.";
  return {
      text("superelement", "file made by flexura reduce, beside this one"),
      fidelity_key(),
      selection(
          "modes",
          "eigenmodes to keep: at most so many, lowest first, or those with these numbers, counted from 1 "
          "under the body's `boundary`, without rigid motions (`flexura modes` lists and draws them); "
          "without "
          "it all"),
      quantity(
          "effective_mass", dim::none,
          "keep eigenmodes, lowest first, until they hold this share of the mass and inertia that all have "
          "in each direction that the joint holds")
          .above(0.0)
          .at_most(1.0),
      quantity("max_frequency", dim::frequency, "keep no eigenmode above").above(0.0),
      choice("coupling", {"full", "partial", "constant"},
             "inertia coupling of deformation and motion: all terms; without second-order terms of the "
             "deformation; mass matrix of the undeformed body, no centrifugal loads")
          .or_default("full"),
      choice("attachments", {"used", "all", "none"},
             "response modes beside truncated eigenmodes: for the interfaces that joints, constraints and "
             "forces act on, for all, or none; without it none, for fidelity static used"),
      quantity("response_frequency", dim::frequency, "at which the response modes are taken; 0: static")
          .or_default("0")
          .at_least(0.0),
      choice("frame", {"mean_axis", "joint_fixed", "joints"},
             "the body's frame: without momentum of the deformation; fixed to the interface of the first "
             "joint that leads to the body; or where its joints hold it (six independent ones of the "
             "directions that "
             "they lock, displacements first: the line between two pins). Without it mean_axis, of a body "
             "with a "
             "rigid link (a marker's link) fixed to that, for a one-way body joint_fixed on a single joint "
             "and joints on several"),
      choice("boundary", {"free", "joint"},
             "eigenmodes of the free body, or held as the first joint that leads to the body holds it. "
             "Without it joint, "
             "which is right with fewer modes, where that joint's marker is one interface or node and the "
             "directions that it "
             "locks (a screw's slide with its turn among them; drives and couplers aside) stand still in the "
             "body (not with exactly two rotations free, nor of a point on a line or plane); free otherwise. "
             "Of frame = \"joints\" those "
             "of all joints, as the frame"),
      quantity("damping", dim::none,
               "damping ratio of the body's eigenmodes under their `boundary`, and of its response modes: "
               "where the joints "
               "leave other modes than that, these have other ratios (`flexura eigen` prints both); without "
               "any law the "
               "superelement's")
          .at_least(0.0),
      quantities("damping_by_mode", dim::none, "ratios of mode 1, 2, ...; the last one also of all above"),
      quantities("damping_frequencies", dim::frequency, "of a table of damping ratios, linear between"),
      quantities("damping_ratios", dim::none, "at these frequencies"),
      quantity("rayleigh_alpha", dim::frequency, "Rayleigh damping alpha M + beta K: alpha [1/s]")
          .at_least(0.0),
      quantity("rayleigh_beta", dim::time, "beta [s]").at_least(0.0),
      quantity("critical_above", dim::frequency,
               "modes from here on are damped critically: they follow their loads without ringing")
          .above(0.0),
      flag("stress", "von Mises stress on the surface at every output step; needs stress modes")
          .or_default("false"),
      table_map("stress_point", point, "places whose stresses and strains are stored"),
      flag("displacement", "largest displacement by deformation on the surface at every output step")
          .or_default("false"),
      table_map("surface_point", surface_point, "nodes of the surface whose displacements are stored"),
      table_map("section_point", section_point_table(),
                "places whose section forces are stored, of a beam part"),
  };
}

bool wants_surface_points(const Section& s) {
  return s.flag("displacement") || !s.table_map("surface_point").empty();
}

std::shared_ptr<const SurfacePoints> read_surface_points(const Section& s,
                                                         const superelement::Superelement& se,
                                                         const ModalData* body) {
  const auto n_v = se.surface.vertices.rows();
  if (n_v == 0 || (body && se.shapes.rows() != 3 * n_v))
    s.refuse(s.flag("displacement") ? "displacement" : "surface_point",
             "the superelement has no shapes on its surface",
             "reduce the part from its CAD file, mesh or beams (foreign matrices bring none), or name an "
             "interface");
  auto out = std::make_shared<SurfacePoints>();
  if (s.flag("displacement"))
    out->set_everywhere(se.surface.vertices.transpose(),
                        body ? MatrixXd(se.shapes.cast<double>() * body->Y) : MatrixXd(3 * n_v, 0));
  for (const auto& [name, point] : s.table_map("surface_point")) {
    Eigen::Index v = 0;
    (se.surface.vertices.rowwise() - point.vector3("position").transpose())
        .rowwise()
        .squaredNorm()
        .minCoeff(&v);
    MatrixXd Phi(3, 0);
    if (body) Phi = se.shapes.middleRows(3 * v, 3).cast<double>() * body->Y;
    out->add({name, se.surface.vertices.row(v).transpose(), std::move(Phi)});
  }
  return out;
}

bool wants_stress(const Section& s) {
  return s.flag("stress") || !s.table_map("stress_point").empty();
}

std::shared_ptr<const StressField> read_stress_field(
    const Section& s, const std::shared_ptr<const superelement::Superelement>& of, const ModalData& body,
    const std::vector<BodyNode>& nodes) {
  const superelement::Superelement& se = *of;
  if (!se.stress && superelement::is_of_beams(se))
    s.refuse(s.has("stress") ? "stress" : "stress_point",
             "the superelement is of beams, which have section forces and no stress modes",
             "store those by [" + s.path() + ".section_point.NAME], or take the key away");
  if (!se.stress || se.surface.vertices.rows() == 0)
    s.refuse(s.has("stress") ? "stress" : "stress_point", "the superelement has no stress modes",
             "reduce the part again with [recovery] stress = true");
  const std::vector<std::int32_t>& vertices = se.stress->vertices;
  Eigen::Matrix3Xd x(3, vertices.size());
  for (std::size_t k = 0; k < vertices.size(); ++k)
    x.col(k) = se.surface.vertices.row(vertices[k]).transpose();
  auto field = std::make_shared<StressField>(std::shared_ptr<const MatrixXd>(of, &se.stress->S), std::move(x),
                                             std::vector<int>(vertices.begin(), vertices.end()), body.Y);
  field->set_loads(se.stress->of_loads);
  field->set_inertia(se.stress->of_acceleration, superelement::rigid_motions(se), body.coupling,
                     left_out_modes(se, body, nodes), StiffeningLoads(se, nodes));
  if (!se.stress->compliance.empty())
    field->set_compliance(se.stress->compliance, {se.stress->material.begin(), se.stress->material.end()});
  for (const auto& [name, point] : s.table_map("stress_point"))
    field->add_point(name, point.vector3("position"));
  return field;
}

std::shared_ptr<const FlexibleBody> prepare_flexible_body(
    const Section& s, const superelement::Superelement& se, const std::vector<BodyNode>& linked,
    const MatrixXd& on_surface, const MechanismDescription& d, int body, std::vector<std::string>& notes,
    PreparationCache& cache) {
  BodyNodes nodes = interface_nodes(se);
  nodes.insert(nodes.end(), linked.begin(), linked.end());
  const std::string& name = d.bodies[body].name;
  const Fidelity::OfSuperelement& fidelity = *fidelity_of(s).of_superelement;
  BasisOptions options;
  options.nodes = linked;
  options.damping_law = damping_law(s);
  options.stiffening = fidelity.is_stiffened;
  const std::string coupling = s.text("coupling");
  options.coupling = coupling == "full"      ? Coupling::full
                     : coupling == "partial" ? Coupling::partial
                                             : Coupling::constant;
  if (options.stiffening && options.coupling != Coupling::full)
    s.refuse("coupling", "geometric stiffening needs all inertia coupling",
             "write coupling = \"full\" or fidelity = \"modal\"");
  note_free_directions(se, nodes, d, body, notes);
  if (options.stiffening)
    for (const int node : loaded_nodes(d, body))
      if (!nodes[node].is_on_interfaces)
        s.refuse("fidelity",
                 fmt::format("marker \"{}\" loads nodes of the surface, and a superelement has geometric "
                             "stiffening by loads on its interfaces only: all of it or none",
                             nodes[node].name),
                 "make that place an interface when the part is reduced, or use fidelity = \"modal\"");
  if (options.stiffening && d.bodies[body].is_loaded_by_case && se.stiffening && se.stiffening->K0p.empty())
    s.refuse("fidelity",
             "a force puts a load case on the body, and its superelement does not know what that adds to the "
             "stiffness: all of it or none",
             "reduce the part again (with stiffening = true), use fidelity = \"modal\", or let forces act on "
             "interfaces");
  for (const auto& force : d.forces) {
    const auto [on, load] = force->load_case();
    if (on != body || !d.bodies[body].loads[static_cast<std::size_t>(load)].is_preload) continue;
    if (!options.stiffening && !fidelity.by_loads_alone)
      notes.push_back(
          fmt::format("body \"{}\": preload \"{}\" deforms it; what it adds to the stiffness only fidelity = "
                      "\"modal-stiffened\" has",
                      name, force->name()));
    if (wants_stress(s) || wants_sections(s))
      notes.push_back(
          fmt::format("body \"{}\": stresses and section forces in the results hold those of preload \"{}\"; "
                      "the page does not draw them",
                      name, force->name()));
  }
  if (options.stiffening && on_surface.cols() > 0)
    s.refuse("fidelity",
             "a force acts on the body's surface, and a superelement has geometric stiffening by gravity, "
             "motion and loads on its interfaces only: all of it or none",
             "use fidelity = \"modal\"");
  const input::Selection modes = s.selection("modes");
  options.modes = modes.first;
  options.numbers = modes.numbers;
  if (s.has("effective_mass")) options.effective_mass = s.quantity("effective_mass");
  if (s.has("effective_mass") && !modes.numbers.empty())
    s.refuse("effective_mass", "`modes` says by their numbers which eigenmodes are kept",
             "let modes be the most that are kept, a number alone, or take one of the two keys away");
  if (s.has("max_frequency")) options.max_frequency = s.quantity("max_frequency");
  options.response_frequency = s.quantity("response_frequency");

  if (!fidelity.acts_back)
    if (const JointDescription* const joint = joint_to_payload(d, body)) {
      const int other = joint->marker_F == marker_on(d, *joint, body) ? joint->marker_M : joint->marker_F;
      s.refuse(
          "fidelity",
          fmt::format(
              "body \"{}\" hangs on it by joint \"{}\": it would neither move with a deformation that does "
              "not act back, nor weigh on it",
              d.bodies[d.markers[static_cast<std::size_t>(other)].body].name, joint->name),
          "use \"modal\" or \"static\"");
    }
  const std::string of_the_boundary = choose_frame(s, se, nodes, linked, d, body, options, notes);

  const std::string attachments = s.has("attachments")      ? s.text("attachments")
                                  : fidelity.by_loads_alone ? "used"
                                                            : "none";
  std::vector<int> loaded;
  if (attachments == "all")
    for (std::size_t i = 0; i < nodes.size(); ++i) loaded.push_back(static_cast<int>(i));
  if (attachments == "used") loaded = loaded_nodes(d, body);
  options.loads.resize(se.n(), 0);
  for (const int node : loaded) {
    const MatrixXd more = attachments == "all" ? node_loads(nodes[node]) : loads_on(nodes, d, body, node);
    options.loads.conservativeResize(Eigen::NoChange, options.loads.cols() + more.cols());
    options.loads.rightCols(more.cols()) = more;
  }
  if (attachments == "used")
    for (const auto& force : d.forces) {
      const auto [on, load] = force->load_case();
      if (on != body) continue;
      options.loads.conservativeResize(Eigen::NoChange, options.loads.cols() + 1);
      options.loads.rightCols<1>() = se.load_cases[static_cast<std::size_t>(load)].p_se;
    }

  if (attachments != "none" && on_surface.cols() > 0) {
    options.loads.conservativeResize(Eigen::NoChange, options.loads.cols() + on_surface.cols());
    options.loads.rightCols(on_surface.cols()) = on_surface;
  }

  if (fidelity.by_loads_alone) {
    for (const char* key : {"modes", "max_frequency", "effective_mass"})
      if (s.has(key))
        notes.push_back(
            fmt::format("body \"{}\" is static and takes no eigenmodes: {} is of no account", name, key));
    if (s.has("coupling") && options.coupling != Coupling::constant)
      notes.push_back(
          fmt::format("body \"{}\" is static: its equations have the inertia of the undeformed body, "
                      "coupling = \"{}\" is of no "
                      "account; its section forces and stresses have the whole",
                      name, coupling));
    if (options.loads.cols() == 0)
      s.refuse(
          "fidelity",
          "nothing acts on an interface of this body and no force puts a load case on it, so nothing deforms "
          "it statically",
          "use fidelity = \"rigid\"");
    options.modes = 0;
    options.numbers.clear();
    options.effective_mass = 0.0;
    options.coupling = Coupling::constant;
    options.damping_law.critical_above = std::min(options.damping_law.critical_above, 0.0);
  }

  BasisReport report;
  std::shared_ptr<const FlexibleBody> flexible;
  try {
    ModalData data = modal_data(se, options, &report, &cache);
    flexible = fidelity.make(std::move(data));
  } catch (const BasisError& error) {
    throw input::InputError(s.where(s.has(error.key()) ? error.key() : "superelement") + ": " + error.what());
  } catch (const std::invalid_argument& error) {
    throw input::InputError(s.where("superelement") + ": " + error.what());
  }
  if (fidelity.by_loads_alone) {
    notes.push_back(
        fmt::format("body \"{}\" follows its loads by {} static response modes", name, report.responses));
  } else if (report.kept < report.available) {
    std::string note = fmt::format("body \"{}\" keeps {} of {} modes", name, report.kept, report.available);
    const double highest = report.eigen_hz.empty() ? 0.0 : report.eigen_hz.back();
    if (highest > 0.0) note += fmt::format(", up to {:.6g} Hz", highest);
    note += fmt::format(" (the {} has {:.6g} Hz)",
                        highest == 0.0                      ? "first"
                        : report.first_dropped_hz < highest ? "lowest left out"
                                                            : "next",
                        report.first_dropped_hz);
    if (report.responses > 0)
      note += fmt::format(", and {} response modes up to {:.6g} Hz for the interfaces in use",
                          report.responses, report.highest_hz);
    else
      note +=
          ": it is stiffer under loads at its interfaces than its superelement (attachments = \"used\" "
          "mends that)";
    if (!of_the_boundary.empty()) notes.push_back(of_the_boundary);
    notes.push_back(note);
  }
  return flexible;
}

}  // namespace flexura::mbs
