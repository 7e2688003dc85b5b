// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A model whose elements a team of processes computes.  Rank 0 numbers the dofs, cuts the mesh by METIS and
// sends each rank its cells with the numbering; each rank adds up its own elements, K = sum of K_r, keeps K_r
// and m_r for factorisations over all ranks, and sends them to rank 0, which has them all for products.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "mesh/partition/cell_parts.hpp"
#include "reduce/assembly/tied_codes.hpp"
#include "reduce/assembly/tied_model.hpp"

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

void put_matrix(Message& message, const linalg::UpperCsr& A) {
  message.put_all(A.row_begin);
  message.put_all(A.columns);
  message.put_all(A.values);
}

void add_matrix(Message& message, linalg::SymmetricMatrix& A) {
  const auto row_begin = message.take_all<int>(), columns = message.take_all<int>();
  const auto values = message.take_all<double>();
  A.add({static_cast<int>(row_begin.size()) - 1, row_begin, columns, values});
}

// How a rank's share has ended: 0 well, 1 with what the user can mend, 2 otherwise.
enum class Outcome : int { well, bad_input, failed };

}  // namespace

void TiedModel::put_numbering(Message& message) const {
  for (const int number : {n_nodes_, n_i_, n_b_}) message.put(number);
  for (const std::vector<int>* numbers : {&code_, &tie_of_, &group_begin_, &group_of_, &tie_group_,
                                          &rotation_of_, &slave_of_, &slave_begin_, &slave_code_})
    message.put_all(*numbers);
  message.put(slave_C_.size());
  for (const Eigen::Vector3d& C : slave_C_) message.put_array(C.data(), 3);
  message.put(interfaces_.size());
  for (const InterfaceDofs& interface : interfaces_) {
    message.put(interface.tie);
    message.put_array(interface.point.data(), 3);
    message.put(interface.code);
  }
}

TiedModel::TiedModel(Message& numbering, const Part& share, const AssemblyOptions& options) {
  points_ = share.mesh.points;
  for (int* number : {&n_nodes_, &n_i_, &n_b_}) *number = numbering.take<int>();
  for (std::vector<int>* numbers : {&code_, &tie_of_, &group_begin_, &group_of_, &tie_group_, &rotation_of_,
                                    &slave_of_, &slave_begin_, &slave_code_})
    *numbers = numbering.take_all<int>();
  slave_C_.resize(numbering.take<std::size_t>());
  for (Eigen::Vector3d& C : slave_C_) numbering.take_array(C.data(), 3);
  interfaces_.resize(numbering.take<std::size_t>());
  for (InterfaceDofs& interface : interfaces_) {
    interface.tie = numbering.take<Tie>();
    numbering.take_array(interface.point.data(), 3);
    interface.code = numbering.take<std::array<int, 6>>();
  }
  build_patterns(share);
  assemble(share, options);
}

void TiedModel::put_matrices(Message& message) const {
  put_matrix(message, K_ii_->csr());
  put_matrix(message, m_->csr());
  std::vector<int> rows, columns;
  std::vector<double> values;
  for (int column = 0; column < K_ib_.outerSize(); ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(K_ib_, column); entry; ++entry) {
      rows.push_back(static_cast<int>(entry.row()));
      columns.push_back(column);
      values.push_back(entry.value());
    }
  message.put_all(rows);
  message.put_all(columns);
  message.put_all(values);
  message.put_all(K_bb_.reshaped().eval());
}

void TiedModel::add_matrices(Message& message) {
  add_matrix(message, *K_ii_);
  add_matrix(message, *m_);
  const auto rows = message.take_all<int>(), columns = message.take_all<int>();
  const auto values = message.take_all<double>();
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t k = 0; k < rows.size(); ++k) triplets.emplace_back(rows[k], columns[k], values[k]);
  Eigen::SparseMatrix<double> K_ib(n_i_, n_b_);
  K_ib.setFromTriplets(triplets.begin(), triplets.end());
  K_ib_ += K_ib;
  const auto K_bb = message.take_all<double>();
  K_bb_ += Eigen::Map<const Eigen::MatrixXd>(K_bb.data(), n_b_, n_b_);
}

// A row belongs to the first part that has an element at its node.
linalg::RowShares TiedModel::share_rows(const Part& part, const std::vector<int>& part_of,
                                        int n_parts) const {
  std::vector<int> owner(group_begin_.size() - 1, n_parts);
  std::size_t cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index c = 0; c < block.nodes.rows(); ++c, ++cell)
      for (const mesh::Index node : block.nodes.row(c)) {
        const int group = tie_of_[node] >= 0 ? tie_group_[tie_of_[node]] : group_of_[node];
        if (group >= 0) owner[group] = std::min(owner[group], part_of[cell]);
      }
  linalg::RowShares rows;
  rows.begin.assign(n_parts + 1, 0);
  for (std::size_t g = 0; g < owner.size(); ++g) {
    if (owner[g] == n_parts) owner[g] = 0;  // no element: held by masses or links
    rows.begin[owner[g] + 1] += group_begin_[g + 1] - group_begin_[g];
  }
  std::partial_sum(rows.begin.begin(), rows.begin.end(), rows.begin.begin());
  std::vector<int> next(rows.begin.begin(), rows.begin.end() - 1);
  rows.number.resize(n_i_);
  for (std::size_t g = 0; g < owner.size(); ++g)
    for (int i = group_begin_[g]; i < group_begin_[g + 1]; ++i) rows.number[i] = next[owner[g]]++;
  return rows;
}

void TiedModel::assemble_together(const Part& part, const AssemblyOptions& options) {
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
  shares_ = {&team, share_rows(part, part_of, team.size()), nullptr};
  Message numbering;
  put_numbering(numbering);
  team.call(Task::take_share);
  team.together([&] {
    for (int rank = 1; rank < team.size(); ++rank) {
      Message message;
      put_cells(message, part, part_of, rank);
      message.put(options.shift);
      message.put_all(shares_.rows.number);
      message.put_all(shares_.rows.begin);
      message.put_array(numbering.bytes().data(), numbering.bytes().size());
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
    shares_.own.reset(new TiedModel(numbering, own, alone));
  } catch (const std::invalid_argument& error) {
    outcome = Outcome::bad_input;
    text = error.what();
  } catch (const std::exception& error) {
    outcome = Outcome::failed;
    text = error.what();
  }
  K_ii_->finish();
  m_->finish();
  K_ib_.resize(n_i_, n_b_);
  K_bb_.setZero(n_b_, n_b_);
  for (int rank = 0; rank < team.size(); ++rank) {
    Message answer;
    if (rank == 0) {
      if (!shares_.own) continue;
      shares_.own->put_matrices(answer);
    } else {
      answer = team.receive(rank);
      const auto theirs = answer.take<Outcome>();
      if (theirs != Outcome::well) {
        outcome = theirs;
        text = answer.take_text();
      }
    }
    if (outcome == Outcome::well) add_matrices(answer);
  }
  if (outcome == Outcome::bad_input) throw std::invalid_argument(text);
  if (outcome == Outcome::failed) throw std::runtime_error(text);
}

std::unique_ptr<TiedModel> TiedModel::take_share(const linalg::Team& team, linalg::RowShares& rows) {
  Message message = team.receive(0), answer;
  std::unique_ptr<TiedModel> share;
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
    share.reset(new TiedModel(message, part, options));
    answer.put(Outcome::well);
    share->put_matrices(answer);
  } catch (const std::invalid_argument& error) {
    failed(Outcome::bad_input, error.what());
  } catch (const std::exception& error) {
    failed(Outcome::failed, error.what());
  }
  team.send(answer, 0);
  return share;
}

}  // namespace flexura::reduce
