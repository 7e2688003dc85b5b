// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/ask.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "mesh/gmsh/job_text.hpp"

namespace flexura::mesh {
namespace {

namespace fs = std::filesystem;

// Where the shell would find the program; as given where it would not.
fs::path in_path(const fs::path& program) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  std::error_code error;
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path found = fs::path(folder) / program.filename();
        !folder.empty() && fs::exists(found, error))
      return found;
  return program;
}

fs::path find_worker(fs::path worker) {
  if (worker.empty()) {
    std::error_code error;
    worker = fs::read_symlink("/proc/self/exe", error).parent_path() / "flexura-mesh";
    if (!fs::exists(worker, error)) worker = in_path(worker);  // a program of others that uses the library
  }
  if (!fs::exists(worker))
    throw std::runtime_error("the meshing program " + worker.string() + " is missing; build it, or name it");
  return worker;
}

}  // namespace

Answer read_answer(const std::string& bytes, int nodes_per_tetrahedron) {
  const auto cut = [] { return TryFailed("handed over an incomplete result"); };
  std::uint64_t length = 0;
  if (bytes.size() < sizeof length) throw cut();
  std::memcpy(&length, bytes.data(), sizeof length);
  std::size_t at = sizeof length;
  if (bytes.size() - at < length) throw cut();
  Answer answer;
  try {
    answer.record = read_result(bytes.substr(at, length));
  } catch (const std::invalid_argument&) {
    throw cut();
  }
  at += length;
  for (const std::uint64_t n :
       {answer.record.n_points, answer.record.n_tetrahedra, answer.record.n_triangles})
    if (n > bytes.size()) throw cut();
  const auto take = [&](auto& values, std::uint64_t n) {
    if (n > bytes.size() || n > bytes.size() / sizeof values[0] || bytes.size() - at < n * sizeof values[0])
      throw cut();
    const std::size_t size = n * sizeof values[0];
    values.resize(n);
    if (size > 0) std::memcpy(values.data(), bytes.data() + at, size);
    at += size;
  };
  take(answer.arrays.points, 3 * answer.record.n_points);
  take(answer.arrays.tetrahedra,
       static_cast<std::uint64_t>(nodes_per_tetrahedron) * answer.record.n_tetrahedra);
  take(answer.arrays.triangles, 3 * answer.record.n_triangles);
  take(answer.arrays.face, answer.record.n_triangles);
  take(answer.arrays.integers, answer.record.n_integers);
  for (const auto* nodes : {&answer.arrays.tetrahedra, &answer.arrays.triangles})
    for (const std::int32_t node : *nodes)
      if (node < 0 || static_cast<std::uint64_t>(node) >= answer.record.n_points) throw cut();
  return answer;
}

namespace {

/// The last thing that gmsh called an error, for the user's ears.
std::string last_error(const std::string& log) {
  const std::size_t at = log.rfind("Error   : ");
  if (at == std::string::npos) return "";
  const std::size_t begin = at + 10, end = log.find('\n', begin);
  constexpr std::size_t longest = 120;
  return " (gmsh: " + log.substr(begin, std::min(longest, end == std::string::npos ? longest : end - begin)) +
         ")";
}

/// gmsh knows the file by its descriptor.
std::string with_its_name(std::string text, const Job& job) {
  const std::string known = kFileOfDescriptor, name = fs::path(job.path).filename().string();
  for (std::size_t at = 0; (at = text.find(known, at)) != std::string::npos;) {
    text.replace(at, known.size(), name);
    at += name.size();
  }
  return text;
}

}  // namespace

Answer ask_worker(const fs::path& worker, const Job& job, double limit_s, const Progress& progress,
                  Allowance* allowance) {
  const ChildOutcome outcome = run_child(find_worker(worker), text_of(job), limit_s, progress);
  if (allowance) allowance->give_back(outcome.waited_s);
  const std::string stage = outcome.stage.empty() ? "" : " while " + outcome.stage;
  if (outcome.end == ChildEnd::out_of_time)
    throw TryFailed(fmt::format("was not done within {:.3g} s{}", limit_s,
                                outcome.stage.empty() ? "" : " (it was " + outcome.stage + ")"));
  if (outcome.end == ChildEnd::crashed)
    throw WorkerCrashed("made the mesher fail" + stage + ": it " + outcome.reason +
                        last_error(with_its_name(outcome.log, job)));
  Answer answer = read_answer(outcome.result, job.order == 2 ? 10 : 4);
  if (!answer.record.error.empty()) {
    answer.record.error = with_its_name(answer.record.error, job);
    const std::string detail = last_error(with_its_name(outcome.log, job));
    const bool said = answer.record.error.find(detail.empty() ? "" : detail.substr(8, detail.size() - 9)) !=
                      std::string::npos;
    throw PartRefused(answer.record.error + (said ? "" : detail));
  }
  return answer;
}

}  // namespace flexura::mesh
