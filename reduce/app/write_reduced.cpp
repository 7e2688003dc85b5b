// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/write_reduced.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/known_errors.hpp"
#include "mbs/superelement/modes.hpp"
#include "mbs/superelement/text_file.hpp"
#include "reduce/app/stage_lines.hpp"
#include "reduce/part/write_mesh.hpp"

namespace flexura::reduce {
namespace {

/// Why what lies at the output's place is to stay there, where the new superelement does not resolve its part: it does, or what it is
/// cannot be told.  Empty where it may go.
std::string reason_to_keep(const std::filesystem::path& output) {
  std::error_code error;
  if (!std::filesystem::exists(output, error)) return "";
  files::note_own(output);
  try {
    const auto mesh =
        superelement::read(output, {.matrices = false, .inertia = false, .mesh_error = true}).mesh_error;
    return mesh && superelement::is_resolved(*mesh) ? "which resolves it" : "";
  } catch (const std::exception& why) {
    return fmt::format("of which nobody knows whether it does ({})", why.what());
  }
}

/// Hinges and releases that the interfaces do not reach, which a mechanism finds free.  Of larger ones `flexura check` tells.
std::string hinges_within(const superelement::Superelement& se) {
  constexpr int kMost = 200;
  if (se.n() > kMost) return "";
  const int n = superelement::natural_modes(se, {}, 1).n_mechanisms;
  return n == 0 ? ""
                : fmt::format(
                      "{} motion{} within the body that nothing resists (hinges, releases): {} free in "
                      "a mechanism unless its joints hold {}",
                      n, n == 1 ? "" : "s", n == 1 ? "it is" : "they are", n == 1 ? "it" : "them");
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
  if (!reduced.too_coarse.empty())
    if (const std::string why = reason_to_keep(output); !why.empty())
      throw std::runtime_error(fmt::format("{}; {}, {}, is kept: name another file by -o to write this one",
                                           reduced.too_coarse, output.string(), why));
  progress("write", 0.0);
  if (!options.mesh.empty()) write_mesh(options.mesh, reduced.mesh, reduced.materials);
  superelement::write(output, reduced.superelement);
  if (!options.report.empty()) superelement::write_whole(options.report, reduced.json.dump(2) + "\n");
  line.finish();
  log.finish();
  if (const std::string hinges = hinges_within(reduced.superelement); !hinges.empty()) say(hinges);
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
