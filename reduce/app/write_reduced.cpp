// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/write_reduced.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <system_error>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/text_file.hpp"
#include "reduce/app/stage_lines.hpp"
#include "reduce/part/write_mesh.hpp"

namespace flexura::reduce {
namespace {

/// Whether a superelement is there whose mesh resolves its part.
bool is_better(const std::filesystem::path& output) {
  std::error_code error;
  if (!std::filesystem::exists(output, error)) return false;
  // What is going to be written is not read as an input: a copy is.
  const std::filesystem::path copy = std::filesystem::temp_directory_path() /
                                     fmt::format("flexura-{}-{}", getpid(), output.filename().string());
  const auto remove = [](const std::filesystem::path* file) {
    std::error_code ignored;
    std::filesystem::remove(*file, ignored);
  };
  const std::unique_ptr<const std::filesystem::path, decltype(remove)> removed(&copy, remove);
  try {
    std::filesystem::copy_file(output, copy);
    const auto mesh =
        superelement::read(copy, {.matrices = false, .inertia = false, .mesh_error = true}).mesh_error;
    return mesh && !mesh->modes.empty() && mesh->modes.front().error >= 0.0 &&
           mesh->modes.front().error < 0.2;
  } catch (const std::exception&) {
    return false;  // no superelement, or one without an estimate
  }
}

template <class Input>
void reduce_and_write(const Input& input, const std::filesystem::path& output, const OutputOptions& options) {
  terminal::Progress line(stderr, options.quiet);
  StageLines log(stderr, options.quiet);
  const auto progress = [&](std::string_view stage, double fraction) {
    line(stage, fraction);
    log(stage, fraction);
  };
  const auto say = [&](const std::string& text) {
    if (options.quiet) return;
    line.finish();
    fmt::print("  {}\n", text);
    std::fflush(stdout);
  };
  const Reduced reduced = reduce(input, {.progress = progress,
                                         .say = say,
                                         .output = output,
                                         .compare = options.compare,
                                         .team = options.team,
                                         .petsc = options.petsc,
                                         .factor_in_file = options.factor_in_file});
  if (!reduced.too_coarse.empty() && is_better(output))
    throw std::runtime_error(
        fmt::format("{}; {}, which resolves it, is kept: name another file by -o to write this one",
                    reduced.too_coarse, output.string()));
  progress("write", 0.0);
  if (!options.mesh.empty()) write_mesh(options.mesh, reduced.mesh, reduced.materials);
  superelement::write(output, reduced.superelement);
  if (!options.report.empty()) superelement::write_whole(options.report, reduced.json.dump(2) + "\n");
  line.finish();
  log.finish();
  for (const std::string& warning : reduced.warnings) terminal::say(stderr, "warning: " + warning);
  if (!options.quiet) fmt::print("{}wrote {}\n", reduced.text, output.string());
}

}  // namespace

void reduce_to_file(const PartInput& part, const std::filesystem::path& output,
                    const OutputOptions& options) {
  reduce_and_write(part, output, options);
}
void reduce_to_file(const BeamPartInput& part, const std::filesystem::path& output,
                    const OutputOptions& options) {
  reduce_and_write(part, output, options);
}
void reduce_to_file(const FlexDataInput& part, const std::filesystem::path& output,
                    const OutputOptions& options) {
  reduce_and_write(part, output, options);
}

}  // namespace flexura::reduce
