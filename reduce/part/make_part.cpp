// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/make_part.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "mbs/base/documents/document.hpp"
#include "mesh/model/shell_sides.hpp"
#include "reduce/assembly/input/shell_skins.hpp"
#include "reduce/assembly/point_mass.hpp"
#include "reduce/assembly/ties/pieces.hpp"
#include "reduce/assembly/whole_body.hpp"
#include "reduce/elements/surface.hpp"
#include "reduce/part/deck_averages.hpp"
#include "reduce/part/deck_equations.hpp"
#include "reduce/part/deck_frames.hpp"
#include "reduce/part/force_field.hpp"
#include "reduce/part/idle_moves.hpp"
#include "reduce/part/idle_turns.hpp"
#include "reduce/part/preload.hpp"

namespace flexura::reduce {
namespace {

using input::InputError;

/// Calls and puts the table's place before what a library refuses.
template <class Work>
auto at(const std::string& where, const Work& work) {
  try {
    return work();
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(where + ": " + error.what());
  }
}

int interface_number(const Part& part, const std::string& name, const std::string& where) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < part.interfaces.size(); ++k) {
    if (part.interfaces[k].name == name) return static_cast<int>(k);
    names.push_back(part.interfaces[k].name);
  }
  throw InputError(
      fmt::format("{}: there is no interface \"{}\"{}", where, name, input::suggestion(name, names)));
}

mesh::Index node_number(const mesh::Mesh& mesh, int label, const std::string& where) {
  const mesh::Rule rule = mesh::NodesRule{.labels = {label}};
  return at(where, [&] { return mesh::select_nodes(mesh, {}, rule).set.nodes.front(); });
}

/// A tie of the deck, or one that is joined to it, by the number in the deck or by its reference node.
struct ChosenTie {
  const DeckTie* tie;
  DeckTie::Joined as;
};

std::optional<ChosenTie> find_tie(const PartMesh& from,
                                  const std::function<bool(const DeckTie::Joined&)>& is_wanted) {
  for (const DeckTie& tie : from.ties) {
    if (const DeckTie::Joined own{tie.label, tie.node, tie.spec.point}; is_wanted(own))
      return ChosenTie{&tie, own};
    const auto found = std::ranges::find_if(tie.joined, is_wanted);
    if (found != tie.joined.end()) return ChosenTie{&tie, *found};
  }
  return {};
}

ChosenTie tie_of(const PartMesh& from, int label, const std::string& where) {
  if (const auto found = find_tie(from, [&](const auto& tie) { return tie.label == label; })) return *found;
  if (from.ties.empty())
    throw InputError(where +
                     ": the file has no ties (RBE2, RBE3); choose the interface by its nodes or faces");
  std::string known;
  for (const DeckTie& tie : from.ties) {
    known += fmt::format("{}{}", known.empty() ? "" : ", ", tie.label);
    for (const DeckTie::Joined& joined : tie.joined) known += fmt::format(", {}", joined.label);
  }
  throw InputError(fmt::format("{}: there is no tie {}; there are {}", where, label, known));
}

// The reference node of a tie, chosen by its number, moves as the tie does; so does each node that a rigid tie holds.
std::optional<ChosenTie> tie_at(const PartMesh& from, const mesh::Mesh& mesh, const InterfaceInput& wanted) {
  const auto* nodes = std::get_if<mesh::NodesRule>(&wanted.rule);
  if (!nodes || nodes->labels.size() != 1) return {};
  const std::int64_t label = nodes->labels.front();
  // Not known which, where instances of an assembly have a node of this number each: the rule refuses it.
  const bool repeated = std::ranges::count(mesh.node_label, label) > 1;
  if (repeated && std::ranges::count(from.ties, label, &DeckTie::node) > 1) return {};
  if (const auto tie = find_tie(from, [&](const auto& t) { return t.node == label; })) return tie;
  if (wanted.tie != Tie::rigid || repeated) return {};
  for (const DeckTie& tie : from.ties) {
    if (tie.spec.tie != Tie::rigid || !tie.spec.rotations) continue;
    for (const mesh::Index node : tie.spec.set.nodes)
      if ((mesh.node_label.empty() ? node + 1 : mesh.node_label[node]) == label)
        return ChosenTie{&tie, {tie.label, label, mesh.points.row(node)}};
  }
  return {};
}

void add_interfaces(const PartInput& input, const PartMesh& from, ModelledPart& out) {
  std::vector<char> taken(from.ties.size(), 0);
  for (const InterfaceInput& wanted : input.interfaces) {
    if (const std::optional<ChosenTie> chosen = wanted.deck_tie ? tie_of(from, *wanted.deck_tie, wanted.where)
                                                                : tie_at(from, out.part.mesh, wanted)) {
      taken[chosen->tie - from.ties.data()] = 1;
      InterfaceSpec spec = chosen->tie->spec;
      spec.name = wanted.name;
      spec.directions = wanted.directions;
      spec.point = chosen->as.point;
      out.notes.push_back(fmt::format("interface {}: tie {} of the deck at node {}, {} nodes, {}",
                                      wanted.name, chosen->as.label, chosen->as.node, spec.set.nodes.size(),
                                      name_of(spec.tie)));
      out.part.interfaces.push_back(std::move(spec));
      continue;
    }
    mesh::Selection chosen =
        at(wanted.where, [&] { return mesh::select_nodes(out.part.mesh, from.faces, wanted.rule); });
    InterfaceSpec spec{.name = wanted.name,
                       .tie = wanted.tie,
                       .point = wanted.reference.value_or(chosen.reference),
                       .directions = wanted.directions};
    spec.set = std::move(chosen.set);
    // One node has no rotation to follow rigidly; asked for displacements alone it is tied as what it is.
    const bool no_rotation = wanted.directions.empty() || wanted.directions.back() < 3;
    if (wanted.tie == Tie::rigid && spec.set.nodes.size() == 1 && no_rotation) spec.tie = Tie::node;
    std::string tie = name_of(spec.tie);
    if (wanted.tie == Tie::average || wanted.tie == Tie::elastic) {
      const bool equal = wanted.equal_weights || spec.set.faces.empty();
      if (equal) spec.weights.assign(spec.set.nodes.size(), 1.0);
      tie += equal ? " (every node alike)" : " (weighted by area)";
    }
    // A set chosen by its nodes says how many.
    const std::string count =
        fmt::format("{} node{}", spec.set.nodes.size(), spec.set.nodes.size() == 1 ? "" : "s");
    out.notes.push_back(fmt::format("interface {}: {}{}, {}", wanted.name, chosen.description,
                                    chosen.description.ends_with(count) ? "" : ", " + count, tie));
    out.part.interfaces.push_back(std::move(spec));
  }
  if (input.interfaces.empty()) {
    for (std::size_t t = 0; t < from.ties.size(); ++t) {
      taken[t] = 1;
      out.part.interfaces.push_back(from.ties[t].spec);
      out.notes.push_back(fmt::format("interface {}: at node {}, {} nodes, {}", from.ties[t].spec.name,
                                      from.ties[t].node, from.ties[t].spec.set.nodes.size(),
                                      name_of(from.ties[t].spec.tie)));
    }
  }
  out.n_interfaces = static_cast<int>(out.part.interfaces.size());
  // The deck's other rigid ties still are rigid pieces of the part; a mean of nodes that nobody asks for is
  // not.
  for (std::size_t t = 0; t < from.ties.size(); ++t) {
    if (taken[t]) continue;
    InterfaceSpec spec = from.ties[t].spec;
    if (spec.tie == Tie::average) {
      const mesh::Index node = spec.turning_node;
      const auto hangs = [&](const auto& element) {
        return std::ranges::find(element.nodes, node) != element.nodes.end();
      };
      const bool carries = std::ranges::any_of(from.bars, hangs) ||
                           std::ranges::any_of(from.springs, hangs) ||
                           std::ranges::any_of(from.tied_masses, [&](const PointMass& mass) {
                             return static_cast<std::size_t>(mass.node) == t;
                           });
      if (!carries)
        out.notes.push_back(
            fmt::format("{} (RBE3) is no interface, carries nothing and is left out", spec.name));
      continue;
    }
    spec.directions.clear();
    out.notes.push_back(fmt::format("{} (RBE2) is a rigid piece of the part, no interface", spec.name));
    out.part.interfaces.push_back(std::move(spec));
  }
}

// What the interfaces do not hold (all of it where there are none) is held by the body's own mean motion.
void complete_interfaces(const PartInput& input, ModelledPart& out) {
  const bool is_deck = input.format == PartFormat::abaqus || input.format == PartFormat::nastran ||
                       input.format == PartFormat::unv;
  if (is_deck && input.finished.vectors.empty()) {
    const Pieces pieces = pieces_of(out.part);
    if (pieces.sizes.size() > 1 && input.strict)
      throw std::invalid_argument(
          fmt::format("{}: the mesh falls into {} pieces that nothing joins; the smallest has {} nodes: tie "
                      "or merge them, or "
                      "take --strict away to have each move on its own",
                      input.where, pieces.sizes.size(), std::ranges::min(pieces.sizes)));
    if (pieces.sizes.size() > 1) {
      const std::vector<std::string> names = at(input.where, [&] { return hold_pieces(out.part, pieces); });
      out.warnings.push_back(
          fmt::format("the mesh falls into {} pieces that nothing joins, of {} to {} nodes: each moves on "
                      "its own{}; tie or "
                      "merge them in the deck, or take the largest alone by geometry.keep = \"largest\"",
                      pieces.sizes.size(), std::ranges::min(pieces.sizes), std::ranges::max(pieces.sizes),
                      names.empty() ? "" : fmt::format(", by the interfaces {}", fmt::join(names, ", "))));
      return;
    }
  }
  const int n_free = free_rigid_motions(out.part);
  if (n_free == 0 || !input.finished.vectors.empty()) return;
  const std::string name = at(input.where, [&] { return hold_whole_body(out.part); });
  out.notes.push_back(
      fmt::format("{} {} of the six rigid motions free; interface \"{}\", the mean motion of the body, takes "
                  "them: add an "
                  "[interface.NAME] for each place where joints or forces act (flexura reduce --list-faces "
                  "shows what can be "
                  "chosen)",
                  out.n_interfaces == 0 ? "the part has no interface, which leaves" : "the interfaces leave",
                  n_free, name));
}

void add_masses(const PartInput& input, const PartMesh& from, ModelledPart& out) {
  Part& part = out.part;
  double total = 0.0;
  for (const PointMass& mass : from.masses) {
    add_mass_to_node(part, mass);
    total += mass.mass;
  }
  for (const PointMass& mass : from.tied_masses) {
    const InterfaceSpec& tie = from.ties[mass.node].spec;
    if (tie.tie == Tie::average) {
      at(tie.name, [&] { add_mass_to_average(part, tie, mass); });
      total += mass.mass;
      continue;
    }
    // A tie keeps its reference node under whatever name.
    const auto found =
        std::find_if(part.interfaces.begin(), part.interfaces.end(), [&](const InterfaceSpec& spec) {
          return spec.tie == tie.tie && spec.turning_node == tie.turning_node;
        });
    if (found == part.interfaces.end())
      throw std::invalid_argument(fmt::format(
          "{} carries a point mass but is left out; take it as an interface (by = \"tie\")", tie.name));
    PointMass there = mass;
    there.offset += tie.point - found->point;
    add_mass_to_interface(part, static_cast<int>(found - part.interfaces.begin()), there);
    total += mass.mass;
  }
  for (const MassInput& wanted : input.masses) {
    at(wanted.where, [&] {
      if (wanted.node) {
        PointMass mass = wanted.mass;
        mass.node = node_number(part.mesh, *wanted.node, wanted.where);
        add_mass_to_node(part, mass);
      } else {
        add_mass_to_interface(part, interface_number(part, wanted.interface, wanted.where), wanted.mass);
      }
    });
    total += wanted.mass.mass;
  }
  const std::size_t count = from.masses.size() + from.tied_masses.size() + input.masses.size();
  if (count > 0)
    out.notes.push_back(fmt::format("{} point mass{}, {:.6g} kg", count, count == 1 ? "" : "es", total));
}

void add_links(const PartInput& input, ModelledPart& out) {
  for (const LinkInput& wanted : input.links) {
    const auto end = [&](int k) {
      if (!wanted.nodes.empty()) return node_number(out.part.mesh, wanted.nodes[k], wanted.where);
      const int interface = interface_number(out.part, wanted.interfaces[k], wanted.where);
      return at(wanted.where,
                [&] { return add_tied_node(out.part, interface, out.part.interfaces[interface].point); });
    };
    const mesh::Index from = end(0), to = end(1);
    out.part.links.push_back({wanted.name, from, to, wanted.stiffness, wanted.damping});
    out.notes.push_back(fmt::format("link {}: stiffness {:.5g} N/m, damping {:.5g} N s/m", wanted.name,
                                    wanted.stiffness, wanted.damping));
  }
}

// Which side of a shell is pushed stands in no picture of it.
void say_push(const LoadInput& wanted, const mesh::ShellSides& sides, const Eigen::RowVector3d& sum,
              ModelledPart& out) {
  if (sides.n_shells == 0) return;
  const auto shown = [&](int k) { return std::abs(sum(k)) > 1e-12 * sum.norm() ? sum(k) : 0.0; };
  out.notes.push_back(fmt::format("load {}: its pressure on {} shells adds up to ({:.5g}, {:.5g}, {:.5g}) N",
                                  wanted.name, sides.n_shells, shown(0), shown(1), shown(2)));
  if (sides.n_turned > 0 && !wanted.side)
    out.warnings.push_back(fmt::format(
        "load {}: {} of {} shells are numbered the other way round; they are pushed from the same "
        "side as their neighbours (side = [x, y, z] names it)",
        wanted.name, sides.n_turned, sides.n_shells));
}

/// `surface` is the mesh in which faces are chosen: before shells have got their skins.
void add_loads(const PartInput& input, const PartMesh& from, const mesh::Mesh& surface, ModelledPart& out) {
  const mesh::Mesh& mesh = out.part.mesh;
  for (const LoadInput& wanted : input.loads) {
    LoadField load{.name = wanted.name, .keep_shape = wanted.keep_shape};
    at(wanted.where, [&] {
      if (wanted.type == LoadType::gravity) {
        load.acceleration = wanted.vector.transpose().replicate(mesh.n_nodes(), 1);
      } else if (wanted.type == LoadType::rotation) {
        load.acceleration.resize(mesh.n_nodes(), 3);
        for (mesh::Index node = 0; node < mesh.n_nodes(); ++node) {
          const Eigen::Vector3d r = mesh.points.row(node).transpose() - wanted.point;
          load.acceleration.row(node) =
              wanted.value * wanted.value * (r - wanted.vector * wanted.vector.dot(r)).transpose();
        }
      } else if (wanted.type == LoadType::pressure) {
        const mesh::Selection chosen = mesh::select_nodes(surface, from.faces, wanted.faces);
        if (chosen.set.faces.empty())
          throw std::invalid_argument(
              "the set has no faces of the part's surface to push on; name a set of whole faces");
        load.forces = Eigen::MatrixX3d::Zero(mesh.n_nodes(), 3);
        const std::vector<mesh::CellBlock>& faces = chosen.set.faces;
        const mesh::ShellSides sides = mesh::shells_of_one_side(surface, faces, wanted.side);
        if (wanted.side && sides.n_shells == 0)
          throw std::invalid_argument(
              "side is for shells, and the faces are of solids, on which a pressure acts from outside; take "
              "the "
              "key away");
        const auto push = [&](bool turned) {
          return pressure_load(surface, mesh::cells_where(faces, sides, turned));
        };
        load.forces.topRows(surface.n_nodes()) = wanted.value * (push(true) - push(false));
        say_push(wanted, sides, load.forces.colwise().sum(), out);
      } else if (wanted.type == LoadType::preload) {
        load.strain = preload_strain(wanted, out.part);
        load.forces = initial_strain_forces(out.part, load.strain);
      } else {
        load.acceleration = evaluate_field(wanted.formulas, mesh);
      }
    });
    out.loads.push_back(std::move(load));
  }
}

// What stress modes know of the deck's beams.
void say_beam_stresses(const PartInput& input, const PartMesh& from, ModelledPart& out) {
  if (from.bars.empty()) return;
  const auto unknown = std::ranges::count_if(from.bars, [](const mesh::ImportedBar& bar) {
    return bar.outline.size() < 3 && (bar.I_yy > 0.0 || bar.I_zz > 0.0);
  });
  const std::string many = fmt::format("{} beam{}", unknown, unknown == 1 ? "" : "s");
  constexpr const char* kRemedy =
      "give their cross-section a shape (PBARL, PBEAML, *BEAM SECTION) or stress points (C1 to F2 of PBAR, "
      "PBEAM)";
  if (unknown == std::ssize(from.bars) && out.part.mesh.solids.empty() && out.part.mesh.shells.empty())
    throw InputError(
        fmt::format("{}: recovery.stress: the stresses of {} are not known, and the part has "
                    "nothing else; {}, or leave the key out",
                    input.where, many, kRemedy));
  if (unknown > 0) out.warnings.push_back(fmt::format("the stresses of {} are not known; {}", many, kRemedy));
  if (unknown < std::ssize(from.bars))
    out.notes.push_back(
        "stresses of beams are those of axial force and bending at the corners of their cross-sections; "
        "those "
        "of torsion and shear are not in them");
}

}  // namespace

ModelledPart make_part(const PartInput& input, PartMesh&& from) {
  ModelledPart out;
  out.notes = from.messages;
  out.warnings = from.warnings;
  out.part.mesh = std::move(from.mesh);
  out.part.materials = from.materials;
  out.part.mass = input.mass;
  out.part.formulation = input.formulation;
  add_interfaces(input, from, out);
  add_equations(input, from, out);
  // Faces are chosen in the mesh as it came: before shells and beams get the points around them.
  const bool has_points = !out.part.mesh.shells.empty() || !from.bars.empty();
  const mesh::Mesh middle = has_points ? out.part.mesh : mesh::Mesh();
  if (input.recovery.stress) {
    say_beam_stresses(input, from, out);
    if (std::ranges::any_of(out.part.materials, [](const Material& m) { return !m.plies.empty(); }))
      out.notes.push_back(
          "stresses of shells of unlike layers are those of their outermost layers; those inside are not "
          "given");
  }
  if (from.matrices) take_in(std::move(*from.matrices), out.part);
  add_shell_skins(out.part);
  add_bars(from.bars, out.part);
  add_springs(from.springs, out.part);
  if (!from.matrices) spread_averages(from.ties, out.part, out.notes);
  if (!from.matrices) hold_idle_moves(out.part, out.warnings);
  complete_interfaces(input, out);
  add_masses(input, from, out);
  add_links(input, out);
  hold_idle_turns(out.part, out.warnings);
  add_loads(input, from, has_points ? middle : out.part.mesh, out);
  return out;
}

}  // namespace flexura::reduce
