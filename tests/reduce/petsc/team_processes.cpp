// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Under mpirun: what the second process does not survive, or all do not.  Rank 0 prints what it is told.
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "reduce/linalg/petsc/team.hpp"
#include "reduce/linalg/session/session.hpp"

namespace {

using flexura::linalg::Team;

void work(const Team& team, const std::string& what) {
  if (what == "everywhere")
    throw std::runtime_error("no convergence, number " + std::to_string(team.rank() + 1));
  if (team.rank() == 1) {
    if (what == "input") throw std::invalid_argument("cell 7 is flat");
    if (what == "failure") throw std::runtime_error("the disk is gone");
    if (what == "memory") throw std::bad_alloc();
    if (what == "killed") std::raise(SIGKILL);
  }
  team.meet();
}

}  // namespace

int main(int argc, char** argv) {
  const flexura::linalg::Session session;
  const Team team;
  if (team.rank() > 0) {
    while (team.wait() != Team::Task::stop) try {
        team.in_step([&] { work(team, argv[1]); });
      } catch (const std::exception&) {
        // Rank 0 says it.
      }
    return 0;
  }
  // Twice: what has gone wrong leaves a team that works.
  for (int round = 0; round < 2; ++round) {
    team.call(Team::Task::reduce);
    try {
      team.in_step([&] { work(team, argc > 1 ? argv[1] : ""); });
      std::puts("well");
    } catch (const std::invalid_argument& error) {
      std::printf("bad input: %s\n", error.what());
    } catch (const std::exception& error) {
      std::printf("failed: %s\n", error.what());
    }
  }
}
