// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// `flexura examples`: the cases that come with the programs, listed and copied.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>

#include "mbs/app/commands.hpp"
#include "mbs/base/documents/document.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace flexura::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string name, output;
};

/// Where the cases are: beside an installed program, in /usr/share, or in the source tree that the program was built in.
fs::path cases_folder() {
  for (const char* const place : {"../share/flexura/cases", "../../../cases"}) {
    const fs::path folder = fs::weakly_canonical(program_folder() / place);
    if (fs::exists(folder / "README.md")) return folder;
  }
  throw std::runtime_error(
      "the examples are not beside this program (share/flexura/cases); install the package flexura, or take "
      "them "
      "from the folder cases of the sources");
}

/// The first line of prose of a case's README, up to its full stop: the question.
std::string question_of(const fs::path& folder) {
  std::ifstream in(folder / "README.md");
  std::string text;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() && !text.empty()) break;
    if (line.empty() || line.starts_with('#') || line.starts_with('!') || line.starts_with('|')) continue;
    text += (text.empty() ? "" : " ") + line;
  }
  const std::size_t question = text.find("? "), stop = text.find(". ");
  const std::size_t end = std::min(question, stop);
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

std::vector<std::string> names_in(const fs::path& cases) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(cases))
    if (fs::exists(entry.path() / "run")) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

int list(const fs::path& cases) {
  const int width = terminal::width(stdout);
  fmt::print("Each is a folder: files, a README, and a script `run` of commands to copy.\n\n");
  for (const std::string& name : names_in(cases))
    fmt::print("{}\n", terminal::folded(fmt::format("{:<16}{}", name, question_of(cases / name)), width, 16));
  fmt::print("\n\"flexura examples NAME\" copies one to ./NAME.\n");
  return 0;
}

// Whole or not at all: copied beside, then renamed.
void copy_whole(const fs::path& from, const fs::path& to) {
  const fs::path folder = fs::absolute(to).parent_path();
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error(fmt::format(
        "{}: cannot be written: {}; check the folder, its permissions and the disk", to.string(), why));
  };
  std::string part = (folder / (to.filename().string() + ".XXXXXX")).string();
  if (::mkdtemp(part.data()) == nullptr)
    throw std::invalid_argument(fmt::format("{}: cannot be written in {}: {}; name another folder by -o",
                                            to.string(), folder.string(), std::strerror(errno)));
  std::error_code failure, none;
  fs::copy(from, part, fs::copy_options::recursive, failure);
  if (!failure) fs::permissions(part, fs::status(from, none).permissions(), none);
  if (!failure) fs::rename(part, to, failure);
  if (failure) {
    fs::remove_all(part, none);
    fail(failure.message());
  }
}

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  const fs::path cases = cases_folder();
  if (arguments.name.empty()) {
    if (!arguments.output.empty())
      throw std::invalid_argument(
          fmt::format("-o {} is for a copy; name the example, as in \"flexura examples steam_engine -o {}\"",
                      arguments.output, arguments.output));
    return list(cases);
  }
  const std::vector<std::string> names = names_in(cases);
  if (std::ranges::find(names, arguments.name) == names.end())
    throw std::invalid_argument(fmt::format("there is no example \"{}\"{}", arguments.name,
                                            input::suggestion(arguments.name, names)));
  const fs::path output = arguments.output.empty() ? fs::path(arguments.name) : fs::path(arguments.output);
  if (fs::exists(output))
    throw std::invalid_argument(
        fmt::format("{}: is there already; give another folder with -o, or remove it", output.string()));
  copy_whole(cases / arguments.name, output);
  if (!verbosity.quiet)
    fmt::print(
        "wrote {}/\nnext: read {}/README.md; the commands are in {}/run, and all of them at once:\n"
        "  (cd {} && CASE=$PWD OUT=$PWD ./run)\n",
        output.string(), output.string(), output.string(), output.string());
  return 0;
}

}  // namespace

terminal::Command examples_command() {
  return {"examples", "list the examples that come with the programs, or copy one",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options
                .optional_argument("NAME", arguments->name, "the example to copy (otherwise they are listed)")
                .option("-o,--output", arguments->output, "FOLDER", "where to (otherwise ./NAME)")
                .example("flexura examples", "what there is, and what each asks")
                .example("flexura examples steam_engine", "a copy in ./steam_engine");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
