// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/session/user_options.hpp"

#include <fmt/format.h>
#include <petscviewer.h>

#include <algorithm>
#include <cctype>
#include <cstdarg>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

constexpr const char* kPage = "docs/petsc.md says which options make sense";

// What a reduction's solvers read.
constexpr std::string_view kFamilies[] = {"-eps_", "-st_",        "-ksp_",         "-pc_",
                                          "-bv_",  "-mat_mumps_", "-mat_cholmod_", "-mat_fronts_"};

// What follows from the part file, by the beginning of the name.
constexpr std::string_view kDecided[] = {
    "-eps_nev",      "-eps_target",    "-eps_interval", "-eps_all",           "-eps_largest",
    "-eps_smallest", "-eps_hermitian", "-eps_gen_",     "-eps_non_hermitian", "-eps_pos_gen",
    "-st_shift",     "-st_type",       "-st_matmode",   "-st_matstructure",   "-st_transform",
    "-eps_twosided", "-eps_two_sided"};

// Parts of names behind which files, other programs or windows are.
constexpr std::string_view kForbidden[] = {"file", "python",  "saws",   "matlab", "tmpdir",
                                           "save", "load",    "dump",   "draw",   "plot",
                                           "_lg",  "library", "plugin", "socket", "mat_mumps_icntl_22"};

bool begins(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}
bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

// Options that ask for a report: their value would say where it goes.
bool reports(std::string_view name) {
  for (const std::string_view part : {"view", "monitor", "reason", "error"})
    if (contains(name, part)) return true;
  return false;
}

void require_allowed(const UserOption& option) {
  const std::string& name = option.name;
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("PETSc option {}{}{}: {}; {}", name,
                                            option.value.empty() ? "" : " ", option.value, why, kPage));
  };
  if (name == "-log_view") {
    if (!option.value.empty()) refuse("takes no value here, the table is printed");
    return;
  }
  if (std::none_of(std::begin(kFamilies), std::end(kFamilies), [&](std::string_view family) {
        return begins(name, family) && name.size() > family.size();
      }))
    refuse(
        "is none of those of a reduction's solvers (-eps_..., -st_..., -ksp_..., -pc_..., -bv_..., "
        "-mat_mumps_..., -mat_cholmod_..., -mat_fronts_..., -log_view)");
  for (const std::string_view decided : kDecided)
    if (begins(name, decided))
      refuse("what is computed follows from the part file ([modes]), not from PETSc's options");
  if (begins(name, "-st_pc_"))
    refuse(
        "the spectral transformation solves by the reduction's own solver, which -pc_... and -ksp_... "
        "choose");
  for (const std::string_view part : kForbidden)
    if (contains(name, part))
      refuse("reads or writes files, opens windows or runs other programs, which options may not");
  if (reports(name)) {
    // [type][:file[:format]] of PETSc's viewers: no file, and no other type than text.
    std::string_view value = option.value;
    if (begins(value, "ascii") && !begins(value, "ascii_")) value.remove_prefix(5);
    const bool on_terminal = value.empty() || (begins(value, "::ascii_") && !contains(value.substr(2), ":"));
    if (!on_terminal && !(contains(name, "error") || contains(name, "reason")))
      refuse("reports go to the terminal: give no value, or a format like ::ascii_info_detail");
    if (!on_terminal && contains(value, ":")) refuse("reports go to the terminal: give no value");
  } else if (contains(option.value, ":")) {
    refuse("has a value with a colon, as files have");
  }
}

// The processes of a team factorise by MUMPS and solve by nothing else.
void require_for_team(const std::vector<UserOption>& options) {
  for (const auto& [name, value] : options) {
    const bool mumps = name == "-pc_factor_mat_solver_type" && value == "mumps";
    for (const std::string_view family : {"-ksp_", "-pc_", "-mat_cholmod_", "-mat_fronts_"})
      if (begins(name, family) && !mumps)
        throw std::invalid_argument(fmt::format(
            "PETSc option {}{}{}: the processes of mpirun factorise by MUMPS, which takes -mat_mumps_...; {}",
            name, value.empty() ? "" : " ", value, kPage));
  }
}

// Printed to nowhere.
PetscErrorCode print_nothing(FILE*, const char*, va_list) {
  return 0;
}

class Silence {
 public:
  Silence() : before_(PetscVFPrintf) { PetscVFPrintf = print_nothing; }
  ~Silence() { PetscVFPrintf = before_; }

 private:
  PetscErrorCode (*before_)(FILE*, const char*, va_list);
};

bool is_used(const UserOption& option) {
  PetscBool used = PETSC_FALSE;
  petsc_check(PetscOptionsUsed(nullptr, option.name.c_str() + 1, &used), "reading options");
  return used;
}

// A chain of springs, held at both ends: eigenvalues 2 - 2 cos(k pi / (n + 1)).
SymmetricMatrix chain(int n) {
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < n; ++i) {
    columns.push_back(i);
    if (i + 1 < n) columns.push_back(i + 1);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  for (int i = 0; i < n; ++i) {
    A.add_to_diagonal(i, 2.0);
    if (i + 1 < n) A.add_to_entry(i, i + 1, -1.0);
  }
  A.finish();
  return A;
}

}  // namespace

std::vector<UserOption> parse_options(const std::string& text) {
  std::vector<UserOption> options;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    for (const char c : word)
      if (!(std::isalnum(static_cast<unsigned char>(c)) || contains("_-+.,:", std::string_view(&c, 1))))
        throw std::invalid_argument(fmt::format(
            "PETSc option \"{}\": names and values are of letters, digits and _ - + . , : only; {}", word,
            kPage));
    const bool is_name =
        word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
    if (is_name) {
      std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
      if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_", 1) != std::string::npos)
        throw std::invalid_argument(
            fmt::format("PETSc option {}: a name is of letters, digits and _; {}", word, kPage));
      options.push_back({word, ""});
    } else if (options.empty() || !options.back().value.empty()) {
      throw std::invalid_argument(
          fmt::format("PETSc options \"{}\": \"{}\" stands where a name with its dash is expected (-eps_type "
                      "krylovschur)",
                      text, word));
    } else {
      options.back().value = word;
    }
  }
  for (const UserOption& option : options) require_allowed(option);
  return options;
}

UserOptions::UserOptions(std::vector<UserOption> options, const Team* team)
    : options_(std::move(options)), team_(team) {
  if (options_.empty()) return;
  require_session();
  if (team_) require_for_team(options_);
  try {
    for (const auto& [name, value] : options_) {
      if (name == "-log_view") {
        log_ = true;
        continue;
      }
      petsc_check(PetscOptionsSetValue(nullptr, name.c_str(), value.empty() ? nullptr : value.c_str()),
                  "reading options");
    }
    rehearse();
    if (log_) petsc_check(PetscLogDefaultBegin(), "starting the log");
  } catch (...) {
    clear();
    throw;
  }
  if (team_) share();
}

// To the other ranks; none takes theirs away.
void UserOptions::share() const {
  team_->call(Team::Task::take_options);
  Message message;
  message.put(options_.size());
  for (const auto& [name, value] : options_) {
    message.put_all(name);
    message.put_all(value);
  }
  for (int rank = 1; rank < team_->size(); ++rank) team_->send(message, rank);
}

UserOptions::~UserOptions() {
  clear();
  if (!team_ || options_.empty()) return;
  options_.clear();
  share();
}

std::unique_ptr<UserOptions> take_options(const Team& team) {
  Message message = team.receive(0);
  std::vector<UserOption> options(message.take<std::size_t>());
  for (UserOption& option : options) {
    option.name = message.take_text();
    option.value = message.take_text();
  }
  return std::make_unique<UserOptions>(std::move(options));
}

void UserOptions::clear() const {
  for (const UserOption& option : options_)
    if (option.name != "-log_view") PetscOptionsClearValue(nullptr, option.name.c_str());
}

void UserOptions::rehearse() const {
  const Silence silence;
  try {
    const SymmetricMatrix A = chain(40);
    const CholeskyFactor factor(A);
    EigenProblem problem;
    problem.n = problem.n_free = A.size();
    problem.solve = [&](const auto& X, auto& Y) { Y = factor.solve(X); };
    problem.multiply_K = [&](const auto& X, auto& Y) { A.multiply(X, Y); };
    problem.multiply_M = [&](const auto& X, auto& Y) { Y = X; };
    read_options(problem);
  } catch (const std::exception& error) {
    throw std::invalid_argument(
        fmt::format("the PETSc options do not go together: {}; {}", error.what(), kPage));
  }
  for (const UserOption& option : options_)
    if (option.name != "-log_view" && !reports(option.name) && !is_used(option))
      throw std::invalid_argument(fmt::format(
          "PETSc option {}: nothing in this reduction asks for it; is it misspelt, or does it belong to a "
          "solver that is not chosen? {}",
          option.name, kPage));
}

std::vector<std::string> UserOptions::unused() const {
  std::vector<std::string> names;
  for (const UserOption& option : options_)
    if (option.name != "-log_view" && !is_used(option)) names.push_back(option.name);
  return names;
}

void UserOptions::print_log() const {
  if (!log_) return;
  if (team_) team_->call(Team::Task::print_log);
  petsc_check(PetscLogView(PETSC_VIEWER_STDOUT_WORLD), "printing the log");
  std::fflush(stdout);
}

}  // namespace flexura::linalg
