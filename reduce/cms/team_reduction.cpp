// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/team_reduction.hpp"

#include <exception>
#include <memory>
#include <optional>

#include "reduce/assembly/shared_assembly.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/projection.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/session/user_options.hpp"

namespace flexura::reduce {
namespace {

using linalg::Message;
using Task = linalg::Team::Task;

// Of the loads what a rank has: accelerations of its nodes, which its mass matrix turns into forces, forces once, strains of
// its cells.
std::vector<LoadField> loads_of(const std::vector<LoadField>& loads, const SharedPart& shared, int rank) {
  std::vector<LoadField> out;
  for (const LoadField& load : loads)
    out.push_back({.name = load.name,
                   .forces = shared.nodes().rows(load.forces, rank, true),
                   .acceleration = shared.nodes().rows(load.acceleration, rank, false),
                   .keep_shape = load.keep_shape,
                   .strain = shared.cell_rows(load.strain, rank)});
  return out;
}

void put_options(Message& message, const ReductionOptions& options, const std::vector<LoadField>& loads) {
  message.put(options.set);
  for (const int number : {options.n_modes, options.most_modes}) message.put(number);
  for (const double number : {options.omega_max, options.accuracy, options.effective_mass, options.tolerance})
    message.put(number);
  message.put(options.interface_modes);
  message.put(options.eigensolver);
  for (const bool flag : {options.certify, options.estimate_error, options.estimate_mesh, options.stiffening})
    message.put(flag);
  message.put_all(options.response_omegas);
  message.put(loads.size());
  for (const LoadField& load : loads) {
    message.put_all(load.name);
    message.put(load.keep_shape);
    for (const Eigen::MatrixX3d* field : {&load.acceleration, &load.forces})
      message.put_all(field->reshaped().eval());
    message.put_all(load.strain.reshaped<Eigen::RowMajor>().eval());
  }
}

ReductionOptions take_options(Message& message) {
  ReductionOptions options;
  options.set = message.take<ModeSet>();
  for (int* number : {&options.n_modes, &options.most_modes}) *number = message.take<int>();
  for (double* number : {&options.omega_max, &options.accuracy, &options.effective_mass, &options.tolerance})
    *number = message.take<double>();
  options.interface_modes = message.take<InterfaceModesRequest>();
  options.eigensolver = message.take<Eigensolver>();
  for (bool* flag : {&options.certify, &options.estimate_error, &options.estimate_mesh, &options.stiffening})
    *flag = message.take<bool>();
  options.response_omegas = message.take_all<double>();
  options.loads.resize(message.take<std::size_t>());
  for (LoadField& load : options.loads) {
    load.name = message.take_text();
    load.keep_shape = message.take<bool>();
    for (Eigen::MatrixX3d* field : {&load.acceleration, &load.forces}) {
      const auto numbers = message.take_all<double>();
      *field = Eigen::Map<const Eigen::MatrixX3d>(numbers.data(),
                                                  static_cast<Eigen::Index>(numbers.size() / 3), 3);
    }
    const auto strains = message.take_all<double>();
    load.strain =
        Eigen::Map<const CellStrains>(strains.data(), static_cast<Eigen::Index>(strains.size() / 6), 6);
  }
  return options;
}

void join_reduction(const linalg::Team& team) {
  const PartShare share = take_share(team);
  Message message = team.receive(0);
  const ReductionOptions options = take_options(message);
  craig_bampton(share.part, share.part, share, options);
}

double peak_memory_of_others(const linalg::Team& team) {
  double greatest = 0.0;
  team.call(Task::tell_memory);
  team.together([&] { greatest = team.greatest(0.0); });
  return greatest;
}

}  // namespace

Reduction lead_reduction(const Part& whole, const Part& part, const ReductionOptions& options) {
  const linalg::Team& team = *options.team;
  Reduction reduction;
  std::optional<SharedPart> shared(std::in_place, team, part);
  team.call(Task::reduce);
  team.in_step([&] {
    const PartShare share = shared->hand_out();
    for (int rank = 1; rank < team.size(); ++rank) {
      Message message;
      put_options(message, options, loads_of(options.loads, *shared, rank));
      team.send(message, rank);
    }
    ReductionOptions own = options;
    own.loads = loads_of(options.loads, *shared, 0);
    shared.reset();
    reduction = craig_bampton(whole, part, share, own);
  });
  // Strains of all cells are here alone.
  if (!options.stress_nodes.empty()) reduction.stress_of_loads = stress_of_preloads(whole, options);
  reduction.report.peak_memory_bytes = linalg::peak_memory();
  reduction.report.peak_memory_of_others_bytes = peak_memory_of_others(team);
  return reduction;
}

void serve(const linalg::Team& team) {
  std::unique_ptr<linalg::UserOptions> options;
  for (;;) {
    switch (team.wait()) {
      case Task::stop:
        return;
      case Task::reduce:
        try {
          team.in_step([&] { join_reduction(team); });
        } catch (const std::exception&) {
          // Rank 0 has the same to say.
        }
        break;
      case Task::take_options:
        options.reset();
        options = linalg::take_options(team);
        break;
      case Task::tell_memory:
        team.together([&] { team.greatest(linalg::peak_memory()); });
        break;
      case Task::print_log:
        if (options) options->print_log();
        break;
    }
  }
}

}  // namespace flexura::reduce
