// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/session/session.hpp"

#include <slepcsys.h>

#include <cctype>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/eigen/block_lanczos_type.hpp"
#include "reduce/linalg/factor/fronts_package.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"
#include "reduce/linalg/session/freed_memory.hpp"

namespace flexura::linalg {
namespace {

int open_sessions = 0;  // of this process: MPI itself is a process-wide thing
bool ended = false;
std::string first_message;  // of the error on its way up through PETSc's call stack
std::exception_ptr thrown;  // in a callback, likewise
bool is_sound = true;

PetscErrorCode remember_error(MPI_Comm, int, const char*, const char*, PetscErrorCode code,
                              PetscErrorType type, const char* message, void*) {
  if (code == PETSC_ERR_MEM) is_sound = false;
  if (type == PETSC_ERROR_INITIAL || first_message.empty()) {
    first_message = message && *message ? message : "no message";
    // Some of its messages are of several lines.
    std::string line;
    for (const char c : first_message)
      if (!std::isspace(static_cast<unsigned char>(c)))
        line += c;
      else if (!line.empty() && line.back() != ' ')
        line += ' ';
    first_message = line;
    while (!first_message.empty() && (first_message.back() == ' ' || first_message.back() == '.'))
      first_message.pop_back();
  }
  return code;
}

// PETSc tells of its errors at length on the terminal; ours is the one sentence made of what it hands over.
PetscErrorCode say_nothing(const char*, ...) {
  return 0;
}

}  // namespace

bool petsc_is_sound() {
  return is_sound;
}

void doubt_petsc() {
  is_sound = false;
}

void keep_exception(std::exception_ptr error) {
  if (!thrown) thrown = std::move(error);
}

void petsc_check(PetscErrorCode code, const char* doing) {
  if (code == 0) return;
  std::string text = first_message;
  first_message.clear();
  if (thrown) std::rethrow_exception(std::exchange(thrown, nullptr));
  if (text.empty()) {
    const char* general = nullptr;
    PetscErrorMessage(code, &general, nullptr);
    text = general ? general : "error " + std::to_string(static_cast<int>(code));
  }
  throw PetscFailure("PETSc failed while " + std::string(doing) + ": " + text);
}

void require_session() {
  if (open_sessions == 0) throw std::logic_error("no linalg::Session is alive: create one in main() first");
}

Launch launch() {
  const auto number = [](const char* name) {
    const char* text = std::getenv(name);
    return text ? std::atoi(text) : -1;
  };
  for (const auto& [rank, size] :
       {std::pair{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"}, std::pair{"PMI_RANK", "PMI_SIZE"}})
    if (number(rank) >= 0 && number(size) > 1) return {number(rank), number(size)};
  return {};
}

Session::Session() {
  if (open_sessions == 0) {
    if (ended)
      throw std::runtime_error("MPI cannot be started a second time: keep one linalg::Session in main()");
    // On one machine the ob1 messaging layer starts in a fifth of the time of the default; the user's choice
    // counts.
    setenv("OMPI_MCA_pml", "ob1", 0);
    // A process alone needs no daemon of MPI's, which would want ssh, nor files for others to meet it by.
    if (launch().size == 1) {
      setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
      setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
    }
    setenv("PETSC_OPTIONS", "", 1);
    setenv("HWLOC_HIDE_ERRORS", "2", 0);  // no remarks on machines without /sys: they are not ours to mend
    PetscErrorPrintf = say_nothing;
    // Whether files of options (.petscrc) are read is asked of the command line only, before all else.
    // Its options come first: without memory for them its own messages fall over.
    if (PetscOptionsSetValue(nullptr, "-no_signal_handler", "true") != 0)
      throw std::runtime_error("PETSc and SLEPc could not be started");
    static char words[][24] = {"flexura-reduce", "-skip_petscrc", "-no_signal_handler"};
    static char* pointers[] = {words[0], words[1], words[2], nullptr};
    static char** arguments = pointers;
    static int n_arguments = 3;
    if (SlepcInitialize(&n_arguments, &arguments, nullptr, nullptr) != 0)
      throw std::runtime_error("PETSc and SLEPc could not be started");
    PetscPushErrorHandler(remember_error, nullptr);
    register_fronts();
    register_block_lanczos();
    require_blas_memory(1);
    give_back_freed_memory();  // MPI has told the allocator to keep all it ever had, for the sake of network cards
  }
  ++open_sessions;
}

Session::~Session() {
  if (--open_sessions == 0) {
    PetscPopErrorHandler();
    // Where an error ends this, or memory was wanting within PETSc, its objects may be half built, a stage of its log for one, and
    // crash where they are destroyed.
    const bool whole = is_sound && std::uncaught_exceptions() == 0;
    if (whole || launch().size > 1) SlepcFinalize();
    ended = true;
  }
}

}  // namespace flexura::linalg
