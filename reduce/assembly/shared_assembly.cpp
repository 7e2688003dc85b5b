// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/shared_assembly.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "mesh/partition/cell_parts.hpp"
#include "reduce/assembly/ties/tied_averages.hpp"
#include "reduce/assembly/ties/tied_checks.hpp"
#include "reduce/assembly/ties/tied_motions.hpp"

namespace flexura::reduce {
namespace {

using linalg::Message;

// The cells of one piece with what their matrices need; nodes by their numbers there.
void put_cells(Message& message, const Part& part, const std::vector<int>& part_of, int rank,
               const std::vector<int>& node_there) {
  message.put(part.mass);
  message.put(part.formulation);
  message.put(part.materials.size());
  for (const Material& material : part.materials) {
    message.put_array(material.D.data(), static_cast<std::size_t>(material.D.size()));
    message.put(material.density);
    message.put(material.damping);
  }
  message.put(part.mesh.solids.size());
  std::size_t number = 0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    std::vector<mesh::Index> nodes, materials;
    std::vector<std::int64_t> labels;
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell, ++number) {
      if (part_of[number] != rank) continue;
      for (const mesh::Index node : block.nodes.row(cell))
        nodes.push_back(node_there[static_cast<std::size_t>(node)]);
      materials.push_back(block.material.empty() ? 0 : block.material[cell]);
      labels.push_back(block.label.empty() ? static_cast<std::int64_t>(number) : block.label[cell]);
    }
    message.put(block.type);
    message.put(block.variant);
    message.put_all(nodes);
    message.put_all(materials);
    message.put_all(labels);
  }
  message.put(part.interfaces.size());
  for (const InterfaceSpec& interface : part.interfaces) {
    message.put_all(interface.name);
    message.put(interface.tie);
    message.put_array(interface.point.data(), 3);
    message.put_all(interface.directions);
  }
}

Part take_cells(Message& message) {
  Part part;
  part.mass = message.take<MassKind>();
  part.formulation = message.take<Formulation>();
  part.materials.resize(message.take<std::size_t>());
  for (Material& material : part.materials) {
    message.take_array(material.D.data(), static_cast<std::size_t>(material.D.size()));
    material.density = message.take<double>();
    material.damping = message.take<MaterialDamping>();
  }
  part.mesh.solids.resize(message.take<std::size_t>());
  for (mesh::CellBlock& block : part.mesh.solids) {
    block.type = message.take<mesh::CellType>();
    block.variant = message.take<mesh::CellVariant>();
    const auto nodes = message.take_all<mesh::Index>();
    block.material = message.take_all<mesh::Index>();
    block.label = message.take_all<std::int64_t>();
    const auto n_cells = static_cast<Eigen::Index>(block.label.size());
    block.nodes.resize(n_cells, mesh::nodes_per_cell(block.type));
    std::copy(nodes.begin(), nodes.end(), block.nodes.data());
  }
  part.interfaces.resize(message.take<std::size_t>());
  for (InterfaceSpec& interface : part.interfaces) {
    interface.name = message.take_text();
    interface.tie = message.take<Tie>();
    message.take_array(interface.point.data(), 3);
    interface.directions = message.take_all<int>();
  }
  return part;
}

// Of each group of interior dofs the rank that owns its rows: the first that has an element there.
std::vector<int> owners_of_groups(const Part& part, const TiedNumbering& numbering,
                                  const std::vector<int>& part_of, int n_parts) {
  std::vector<int> owner(numbering.group_begin().size() - 1, n_parts);
  std::size_t cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index c = 0; c < block.nodes.rows(); ++c, ++cell)
      for (const mesh::Index node : block.nodes.row(c)) {
        const int group = numbering.group_of(node);
        if (group >= 0) owner[group] = std::min(owner[group], part_of[cell]);
      }
  std::replace(owner.begin(), owner.end(), n_parts, 0);  // no element: held by masses, links or matrices
  return owner;
}

linalg::RowShares share_rows(const TiedNumbering& numbering, const std::vector<int>& owner, int n_parts) {
  const std::vector<int>& group_begin = numbering.group_begin();
  linalg::RowShares rows;
  rows.begin.assign(n_parts + 1, 0);
  for (std::size_t g = 0; g < owner.size(); ++g)
    rows.begin[owner[g] + 1] += group_begin[g + 1] - group_begin[g];
  std::partial_sum(rows.begin.begin(), rows.begin.end(), rows.begin.begin());
  std::vector<int> next(rows.begin.begin(), rows.begin.end() - 1);
  rows.number.resize(numbering.n_i());
  for (std::size_t g = 0; g < owner.size(); ++g)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) rows.number[i] = next[owner[g]]++;
  return rows;
}

PartShare read_share(const linalg::Team& team, Message& message) {
  Part part = take_cells(message);
  PartShare share{.team = &team, .part = std::move(part), .numbering = TiedNumbering(message)};
  share.part.mesh.points = share.numbering.points();
  share.rows.number = message.take_all<int>();
  share.rows.begin = message.take_all<int>();
  share.n_i = share.rows.n();
  share.n_nodes = message.take<int>();
  share.pins = message.take_all<int>();
  share.averaged_dofs = message.take_all<int>();
  share.Jt.resize(message.take<std::size_t>());
  return share;
}

// A^T and J^T by the rows of each rank; rank 0 gives those of the whole part.
void share_averages(PartShare& share, const linalg::RowShares* all, const TiedNumbering* numbering,
                    const TiedAverages* averages) {
  const linalg::RowShares rows = all ? *all : linalg::RowShares{{}, share.rows.begin};
  Eigen::MatrixXd columns;
  if (averages) columns = averages->A().transpose();
  share.At = linalg::scatter_rows(*share.team, rows, columns);
  for (std::size_t k = 0; k < share.Jt.size(); ++k) {
    if (averages)
      columns = TiedMotions(*numbering, *averages)
                    .interface_load(static_cast<int>(k), Eigen::MatrixXd::Identity(6, 6));
    share.Jt[k] = linalg::scatter_rows(*share.team, rows, columns).sparseView();
  }
}

}  // namespace

NodeShares::NodeShares(const Part& part, const std::vector<int>& part_of, int n_ranks)
    : nodes_(static_cast<std::size_t>(n_ranks)), places_(part.mesh.n_nodes(), {n_ranks, -1}) {
  std::vector<std::vector<char>> has(nodes_.size(), std::vector<char>(part.mesh.n_nodes(), 0));
  std::size_t cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index c = 0; c < block.nodes.rows(); ++c, ++cell)
      for (const mesh::Index node : block.nodes.row(c)) {
        has[static_cast<std::size_t>(part_of[cell])][node] = 1;
        places_[node].first = std::min(places_[node].first, part_of[cell]);
      }
  // What is no cell is rank 0's, and so are nodes of none.
  for (const NodalMass& mass : part.masses) has[0][mass.node] = 1;
  for (const Link& link : part.links) has[0][link.from] = has[0][link.to] = 1;
  for (const Follower& follower : part.followers) {
    has[0][follower.point] = 1;
    for (const auto& [node, C] : follower.from) has[0][node] = 1;
  }
  if (part.matrices)
    for (const auto& pair : part.matrices->pairs)
      for (const mesh::Index node : pair) has[0][node] = 1;
  for (std::size_t node = 0; node < places_.size(); ++node)
    if (places_[node].first == n_ranks) has[0][node] = 1, places_[node].first = 0;
  for (std::size_t r = 0; r < nodes_.size(); ++r)
    for (std::size_t node = 0; node < places_.size(); ++node) {
      if (!has[r][node]) continue;
      if (places_[node].first == static_cast<int>(r))
        places_[node].second = static_cast<int>(nodes_[r].size());
      nodes_[r].push_back(static_cast<mesh::Index>(node));
    }
}

Eigen::MatrixX3d NodeShares::rows(const Eigen::MatrixX3d& field, int rank, bool once) const {
  const std::vector<mesh::Index>& here = nodes(rank);
  if (field.rows() == 0) return field;
  Eigen::MatrixX3d out = Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(here.size()), 3);
  for (std::size_t k = 0; k < here.size(); ++k)
    if (!once || places_[here[k]].first == rank) out.row(static_cast<Eigen::Index>(k)) = field.row(here[k]);
  return out;
}

struct SharedPart::Impl {
  const linalg::Team& team;
  const Part& part;
  TiedNumbering numbering;
  TiedAverages averages;
  std::vector<int> part_of;
  NodeShares nodes;
  bool may_be_free;
};

SharedPart::SharedPart(const linalg::Team& team, const Part& part) : SharedPart(team, part, {}, false) {}

SharedPart::SharedPart(const linalg::Team& team, const Part& part, std::vector<int> part_of,
                       bool may_be_free) {
  if (!part.mesh.shells.empty() || !part.frames.empty())
    throw std::invalid_argument(
        "shells and beams are computed by one process: start the program without mpirun");
  if (!part.dependent.empty())
    throw std::invalid_argument(
        "parts with constraints (*EQUATION, MPC, *TIE between nodes) are computed by one process: start the "
        "program without "
        "mpirun");
  TiedNumbering numbering = checked_numbering(part, may_be_free);
  TiedAverages averages(part, numbering);
  if (part_of.empty()) part_of = mesh::cell_parts(part.mesh, team.size());
  NodeShares nodes(part, part_of, team.size());
  impl_.reset(new Impl{team, part, std::move(numbering), std::move(averages), std::move(part_of),
                       std::move(nodes), may_be_free});
}

SharedPart::~SharedPart() = default;

const NodeShares& SharedPart::nodes() const {
  return impl_->nodes;
}

CellStrains SharedPart::cell_rows(const CellStrains& all, int rank) const {
  if (all.rows() == 0) return all;
  std::vector<Eigen::Index> cells;
  for (std::size_t cell = 0; cell < impl_->part_of.size(); ++cell)
    if (impl_->part_of[cell] == rank) cells.push_back(static_cast<Eigen::Index>(cell));
  return all(cells, Eigen::all);
}

PartShare SharedPart::hand_out() const {
  const auto& [team, part, numbering, averages, part_of, nodes, may_be_free] = *impl_;
  const std::vector<int> owner = owners_of_groups(part, numbering, part_of, team.size());
  const linalg::RowShares all = share_rows(numbering, owner, team.size());
  std::vector<int> pins;  // what may be free is held by its mass, and the springs of pins would be in the way
  if (!may_be_free) pins = choose_pins(numbering);
  for (int& pin : pins) pin = all.number[pin];
  std::vector<int> node_there(part.mesh.n_nodes(), -1);
  const auto put_share = [&](Message& message, int rank) {
    const std::vector<mesh::Index>& here = nodes.nodes(rank);
    for (std::size_t k = 0; k < here.size(); ++k) node_there[here[k]] = static_cast<int>(k);
    put_cells(message, part, part_of, rank, node_there);
    std::vector<int> groups;
    for (std::size_t g = 0; g < owner.size(); ++g)
      if (owner[g] == rank) groups.push_back(static_cast<int>(g));
    const TiedNumbering::Share share = numbering.share(here, groups);
    share.numbering.put(message);
    std::vector<int> numbers;
    for (const int dof : share.dofs) numbers.push_back(all.number[dof]);
    message.put_all(numbers);
    message.put_all(all.begin);
    message.put(numbering.n_nodes());
    message.put_all(pins);
    message.put_all(averages.dofs());
    message.put(may_be_free ? part.interfaces.size() : std::size_t{0});
  };
  for (int rank = 1; rank < team.size(); ++rank) {
    Message message;
    put_share(message, rank);
    team.send(message, rank);
  }
  Message message;
  put_share(message, 0);
  PartShare own = read_share(team, message);
  own.place_of_node = nodes.places();
  own.part_of = part_of;
  own.part.matrices = part.matrices;
  own.part.masses = part.masses;
  own.part.links = part.links;
  own.part.followers = part.followers;
  if (own.part.matrices)
    for (auto& pair : own.part.matrices->pairs)
      for (mesh::Index& node : pair) node = node_there[node];
  for (NodalMass& mass : own.part.masses) mass.node = node_there[mass.node];
  for (Link& link : own.part.links)
    for (mesh::Index* node : {&link.from, &link.to}) *node = node_there[*node];
  for (Follower& follower : own.part.followers) {
    follower.point = node_there[follower.point];
    for (auto& from : follower.from) from.first = node_there[from.first];
  }
  share_averages(own, &all, &numbering, &averages);
  return own;
}

PartShare take_share(const linalg::Team& team) {
  Message message = team.receive(0);
  PartShare share = read_share(team, message);
  share_averages(share, nullptr, nullptr, nullptr);
  return share;
}

PartShare share_retied(const PartShare& share, const Part& part, bool may_be_free) {
  std::optional<SharedPart> shared;
  if (share.team->rank() == 0) shared.emplace(*share.team, part, share.part_of, may_be_free);
  share.team->meet();
  return shared ? shared->hand_out() : take_share(*share.team);
}

Eigen::MatrixXd collect_nodes(const PartShare& share, const Eigen::Ref<const Eigen::MatrixXd>& U,
                              const std::vector<mesh::Index>& nodes) {
  using Eigen::Index;
  constexpr Index kColumns = 32;  // together, to bound the memory of what is packed
  const linalg::Team& team = *share.team;
  const bool leads = team.rank() == 0;
  const auto n_ranks = static_cast<std::size_t>(team.size());
  // Of each rank the nodes there that are wanted, and where they go.
  std::vector<std::vector<int>> there(n_ranks), wanted(n_ranks);
  if (leads)
    for (std::size_t v = 0; v < nodes.size(); ++v) {
      const auto [rank, place] = share.place_of_node[nodes[v]];
      there[static_cast<std::size_t>(rank)].push_back(place);
      wanted[static_cast<std::size_t>(rank)].push_back(static_cast<int>(v));
    }
  for (int rank = 1; leads && rank < team.size(); ++rank) {
    Message message;
    message.put_all(there[static_cast<std::size_t>(rank)]);
    team.send(message, rank);
  }
  const std::vector<int> mine = leads ? there[0] : team.receive(0).take_all<int>();
  Eigen::MatrixXd all(leads ? 3 * static_cast<Index>(nodes.size()) : 0, leads ? U.cols() : 0);
  Eigen::MatrixXd own, packed;
  for (Index first = 0; first < U.cols(); first += kColumns) {
    const Index width = std::min(kColumns, U.cols() - first);
    own.resize(3 * width, static_cast<Index>(mine.size()));  // a node's numbers together
    for (std::size_t k = 0; k < mine.size(); ++k)
      own.col(static_cast<Index>(k)) = U.block(3 * static_cast<Index>(mine[k]), first, 3, width).reshaped();
    std::vector<int> counts;
    for (const auto& list : wanted)
      counts.push_back(static_cast<int>(list.size()) * 3 * static_cast<int>(width));
    counts[static_cast<std::size_t>(team.rank())] = static_cast<int>(own.size());
    if (leads) packed.resize(3 * width, static_cast<Index>(nodes.size()));
    team.gather(own.data(), counts, packed.data());
    Index at = 0;
    for (const auto& list : wanted)
      for (const int v : list)
        all.block(3 * static_cast<Index>(v), first, 3, width) = packed.col(at++).reshaped(3, width);
  }
  return all;
}

}  // namespace flexura::reduce
