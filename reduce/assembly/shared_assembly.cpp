// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/shared_assembly.hpp"

// A model whose elements a team of processes computes.  Rank 0 numbers the dofs, cuts the mesh by METIS and
// sends each rank its cells with the numbering; each rank adds up its own elements, K = sum of K_r, keeps K_r
// and m_r for factorisations over all ranks, and sends them to rank 0, which has them all for products.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "mesh/partition/cell_parts.hpp"

namespace flexura::reduce {
namespace {

using linalg::Message;
using Task = linalg::Team::Task;

// The cells of one part with what their matrices need.
void put_cells(Message& message, const Part& part, const std::vector<int>& part_of, int rank) {
  message.put_all(part.mesh.points.reshaped<Eigen::RowMajor>().eval());
  message.put(part.mass);
  message.put(part.formulation);
  message.put(part.materials.size());
  for (const Material& material : part.materials) {
    message.put_array(material.D.data(), static_cast<std::size_t>(material.D.size()));
    message.put(material.density);
  }
  message.put(part.mesh.solids.size());
  std::size_t number = 0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    std::vector<mesh::Index> nodes, materials;
    std::vector<std::int64_t> labels;
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell, ++number) {
      if (part_of[number] != rank) continue;
      nodes.insert(nodes.end(), block.nodes.row(cell).begin(), block.nodes.row(cell).end());
      materials.push_back(block.material.empty() ? 0 : block.material[cell]);
      labels.push_back(block.label.empty() ? static_cast<std::int64_t>(number) : block.label[cell]);
    }
    message.put(block.type);
    message.put(block.variant);
    message.put_all(nodes);
    message.put_all(materials);
    message.put_all(labels);
  }
}

Part take_cells(Message& message) {
  Part part;
  const auto points = message.take_all<double>();
  part.mesh.points = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      points.data(), static_cast<Eigen::Index>(points.size() / 3), 3);
  part.mass = message.take<MassKind>();
  part.formulation = message.take<Formulation>();
  part.materials.resize(message.take<std::size_t>());
  for (Material& material : part.materials) {
    message.take_array(material.D.data(), static_cast<std::size_t>(material.D.size()));
    material.density = message.take<double>();
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
  return part;
}

// How a rank's share has ended: 0 well, 1 with what the user can mend, 2 otherwise.
enum class Outcome : int { well, bad_input, failed };

// A row belongs to the first part that has an element at its node.
linalg::RowShares share_rows(const Part& part, const TiedNumbering& numbering,
                             const std::vector<int>& part_of, int n_parts) {
  const std::vector<int>& group_begin = numbering.group_begin();
  std::vector<int> owner(group_begin.size() - 1, n_parts);
  std::size_t cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index c = 0; c < block.nodes.rows(); ++c, ++cell)
      for (const mesh::Index node : block.nodes.row(c)) {
        const int group = numbering.group_of(node);
        if (group >= 0) owner[group] = std::min(owner[group], part_of[cell]);
      }
  linalg::RowShares rows;
  rows.begin.assign(n_parts + 1, 0);
  for (std::size_t g = 0; g < owner.size(); ++g) {
    if (owner[g] == n_parts) owner[g] = 0;  // no element: held by masses or links
    rows.begin[owner[g] + 1] += group_begin[g + 1] - group_begin[g];
  }
  std::partial_sum(rows.begin.begin(), rows.begin.end(), rows.begin.begin());
  std::vector<int> next(rows.begin.begin(), rows.begin.end() - 1);
  rows.number.resize(numbering.n_i());
  for (std::size_t g = 0; g < owner.size(); ++g)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) rows.number[i] = next[owner[g]]++;
  return rows;
}

}  // namespace

ModelShare::ModelShare(Message& numbering, const Part& part, const AssemblyOptions& options)
    : numbering_(numbering, part.mesh.points), matrices_(part, numbering_) {
  matrices_.assemble(part, options);
}

ModelShares assemble_together(const Part& part, const AssemblyOptions& options,
                              const TiedNumbering& numbering, TiedMatrices& sum) {
  const linalg::Team& team = *options.team;
  if (!part.mesh.shells.empty() || !part.frames.empty())
    throw std::invalid_argument(
        "shells and beams are computed by one process: start the program without mpirun");
  if (!part.dependent.empty())
    throw std::invalid_argument(
        "parts with constraints (*EQUATION, MPC, *TIE between nodes) are computed by one process: start the "
        "program without "
        "mpirun");
  const std::vector<int> part_of = mesh::cell_parts(part.mesh, team.size());
  ModelShares shares{&team, share_rows(part, numbering, part_of, team.size()), nullptr};
  Message numbers;
  numbering.put(numbers);
  team.call(Task::take_share);
  team.together([&] {
    for (int rank = 1; rank < team.size(); ++rank) {
      Message message;
      put_cells(message, part, part_of, rank);
      message.put(options.shift);
      message.put_all(shares.rows.number);
      message.put_all(shares.rows.begin);
      message.put_array(numbers.bytes().data(), numbers.bytes().size());
      team.send(message, rank);
    }
  });
  // What is no cell is rank 0's.  Whatever goes wrong here, the others' answers are taken first.
  Outcome outcome = Outcome::well;
  std::string text;
  try {
    Message cells;
    put_cells(cells, part, part_of, 0);
    Part own = take_cells(cells);
    own.matrices = part.matrices;
    own.masses = part.masses;
    own.links = part.links;
    AssemblyOptions alone = options;
    alone.team = nullptr;
    shares.own = std::make_unique<ModelShare>(numbers, own, alone);
  } catch (const std::invalid_argument& error) {
    outcome = Outcome::bad_input;
    text = error.what();
  } catch (const std::exception& error) {
    outcome = Outcome::failed;
    text = error.what();
  }
  sum.begin_sum();
  for (int rank = 0; rank < team.size(); ++rank) {
    Message answer;
    if (rank == 0) {
      if (!shares.own) continue;
      shares.own->matrices().put(answer);
    } else {
      answer = team.receive(rank);
      const auto theirs = answer.take<Outcome>();
      if (theirs != Outcome::well) {
        outcome = theirs;
        text = answer.take_text();
      }
    }
    if (outcome == Outcome::well) sum.add(answer);
  }
  if (outcome == Outcome::bad_input) throw std::invalid_argument(text);
  if (outcome == Outcome::failed) throw std::runtime_error(text);
  return shares;
}

std::unique_ptr<ModelShare> take_share(const linalg::Team& team, linalg::RowShares& rows) {
  Message message = team.receive(0), answer;
  std::unique_ptr<ModelShare> share;
  const auto failed = [&](Outcome outcome, const char* what) {
    share.reset();
    answer = {};
    answer.put(outcome);
    answer.put_all(std::string_view(what));
  };
  try {
    const Part part = take_cells(message);
    AssemblyOptions options;
    options.shift = message.take<double>();
    rows.number = message.take_all<int>();
    rows.begin = message.take_all<int>();
    share = std::make_unique<ModelShare>(message, part, options);
    answer.put(Outcome::well);
    share->matrices().put(answer);
  } catch (const std::invalid_argument& error) {
    failed(Outcome::bad_input, error.what());
  } catch (const std::exception& error) {
    failed(Outcome::failed, error.what());
  }
  team.send(answer, 0);
  return share;
}

}  // namespace flexura::reduce
