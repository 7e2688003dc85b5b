// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <sstream>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/signals.hpp"
#include "mbs/base/hdf5/file.hpp"
#include "mbs/base/terminal/description.hpp"
#include "mbs/base/terminal/harmless_stream.hpp"
#include "mbs/base/terminal/libraries.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace flexura::terminal {

struct Options::Impl {
  CLI::App* app = nullptr;
  CLI::Option* last = nullptr;
  Description description;

  // Remembers what was declared last.
  void note(const std::string& names, const std::string& what, const std::string& doc,
            bool is_argument = false) {
    description.entries.push_back(
        {names, what, doc, {}, last->get_default_str(), is_argument, last->get_required()});
  }
};

namespace {

constexpr int bad_input = 2;

void print_error(const std::string& message) {
  // Nothing more can be done where this cannot be written either.
  std::string line = folded("error: " + input::shown_message(message), takes_columns(stderr));
  if (takes_colour(stderr)) line.replace(0, 6, red("error:", true));
  std::fputs((line + "\n").c_str(), stderr);
}

std::string examples_text(const std::vector<std::pair<std::string, std::string>>& examples) {
  if (examples.empty()) return "";
  std::string text = "Examples:\n";
  for (const auto& [command, what] : examples) text += fmt::format("  {}\n      {}\n", command, what);
  return text;
}

// All option names of a command, for "did you mean".
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// CLI11's own words name the option, but not the one that was meant.
std::string refusal(const CLI::App& app, const CLI::ParseError& failure) {
  std::string message = failure.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&failure) != nullptr) {
    for (const std::string& word : app.remaining()) {
      if (!word.starts_with("-"))
        return fmt::format("\"{}\" is one argument too many; see {} --help", word, app.get_name());
      const std::string name = word.substr(0, word.find('='));
      const std::string near = input::nearest(name, option_names(app));
      return fmt::format("unknown option {}{}", name,
                         near.empty() ? fmt::format("; see {} --help", app.get_name())
                                      : fmt::format(", did you mean {}?", near));
    }
  }
  return message + (message.ends_with('.') ? " See " : "; see ") + app.get_name() + " --help";
}

constexpr int doc_column = 30;

// CLI11 leaves long lines as they are: they go on below, where their text began.
std::string wrapped(const std::string& help, std::size_t width, std::size_t column = doc_column) {
  std::string out;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    // Examples may be copied: they stay in one line.
    const std::size_t indent = line.find_first_not_of(' ') == 2 ? column : 6;
    while (line.size() > width && !line.starts_with("  flexura")) {
      const std::size_t cut = line.rfind(' ', width);
      if (cut == std::string::npos || cut <= indent) break;
      out += line.substr(0, cut) + '\n';
      line = std::string(indent, ' ') + line.substr(cut + 1);
    }
    out += line + '\n';
  }
  return out;
}

void set_up(CLI::App& app, const Options::Impl& impl) {
  app.get_formatter()->column_width(doc_column);
  app.footer(examples_text(impl.description.examples));
}

// Every command's own.
void add_verbosity(Options& options, Verbosity& verbosity) {
  options.flag("-q,--quiet", verbosity.quiet, "print errors only")
      .flag("-v,--verbose", verbosity.verbose, "print every detail");
}

// One command behind its own parser: `words` are what follows its name.
int run_command(const Command& command, const std::string& full_name, const std::string& version,
                std::vector<std::string> words) {
  CLI::App app(command.summary, full_name);
  Verbosity verbosity;
  auto impl = std::make_shared<Options::Impl>();
  impl->app = &app;
  if (!version.empty()) app.set_version_flag("--version", full_name + " " + version);
  Options options(impl);
  const std::function<int()> work = command.declare(options, verbosity);
  add_verbosity(options, verbosity);
  set_up(app, *impl);
  std::reverse(words.begin(), words.end());  // CLI11 takes them off the end
  try {
    app.parse(words);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", wrapped(app.help(), static_cast<std::size_t>(width(stdout))));
    return 0;
  } catch (const CLI::Success& wanted) {  // --version
    return app.exit(wanted);
  } catch (const CLI::ParseError& failure) {
    print_error(refusal(app, failure));
    return bad_input;
  }
  if (verbosity.quiet && verbosity.verbose) {
    print_error("--quiet and --verbose exclude each other; give one of them");
    return bad_input;
  }
  return work();
}

std::string completion(const Program& program, const std::string& shell) {
  if (shell == "bash") return bash_completion(program);
  if (shell == "zsh") return zsh_completion(program);
  if (shell == "fish") return fish_completion(program);
  throw std::invalid_argument(
      fmt::format("there is no completion for \"{}\"; write bash, zsh or fish", shell));
}

const Command& named_command(const Program& program, const std::string& name) {
  std::vector<std::string> names;
  for (const Command& command : program.commands) {
    if (command.name == name) return command;
    names.push_back(command.name);
  }
  throw std::invalid_argument(fmt::format("unknown command \"{}\"{}", name, input::suggestion(name, names)));
}

// How many words a request to the program itself has at most; 0 for a command, which counts its own.
std::size_t words_of_its_own(const std::string& word) {
  for (const char* const two : {"help", "completion", "man"})
    if (word == two) return 2;
  for (const char* const one : {"--help", "-h", "--version", "version"})
    if (word == one) return 1;
  return 0;
}

std::string program_help(const Program& program) {
  std::string text =
      fmt::format("{}\nUsage: {} COMMAND [OPTIONS]\n\nCommands:\n", program.summary, program.name);
  std::size_t longest = 0;
  for (const Command& command : program.commands) longest = std::max(longest, command.name.size());
  for (const Command& command : program.commands) {
    text += fmt::format("  {:<{}}  {}\n", command.name, longest, command.summary);
  }
  text += fmt::format(
      "\n\"{0} COMMAND --help\" describes one command, \"{0} --version\" says which version this is.\n"
      "\"{0} man | man -l -\" is the manual (\"{0} man COMMAND\" of one), eval \"$({0} completion)\" "
      "completes in bash, "
      "\"{0} completion zsh\" and \"fish\" print theirs.\n"
      "Exit codes: 0 done, 1 failed or interrupted (what was computed is kept), 2 bad input; a signal that "
      "leaves "
      "nothing to keep ends the program itself.\n",
      program.name);
  if (!program.examples.empty()) text += "\n" + examples_text(program.examples);
  return wrapped(text, static_cast<std::size_t>(width(stdout)), longest + 4);
}

}  // namespace

Description describe(const Command& command) {
  CLI::App app;
  Verbosity verbosity;
  auto impl = std::make_shared<Options::Impl>();
  impl->app = &app;
  Options options(impl);
  command.declare(options, verbosity);
  add_verbosity(options, verbosity);
  return impl->description;
}

// A variable of the shell that is not set: the default would be taken in silence.
static std::string not_empty(const std::string& word) {
  return word.empty() ? "the value is empty; give one, or leave the option out" : "";
}

// --- Options ---------------------------------------------------------------------------------------------

Options& Options::argument(const std::string& name, std::string& value, const std::string& doc) {
  impl_->last = impl_->app->add_option(name, value, doc)->required()->type_name("");
  impl_->note(name, "", doc, true);
  return *this;
}
Options& Options::optional_argument(const std::string& name, std::string& value, const std::string& doc) {
  impl_->last = impl_->app->add_option(name, value, doc)->type_name("");
  impl_->note(name, "", doc, true);
  return *this;
}
Options& Options::arguments(const std::string& name, std::vector<std::string>& values,
                            const std::string& doc) {
  impl_->last = impl_->app->add_option(name, values, doc)->required()->type_name("");
  impl_->note(name, "", doc, true);
  return *this;
}
Options& Options::option(const std::string& names, std::string& value, const std::string& what,
                         const std::string& doc) {
  impl_->last = impl_->app->add_option(names, value, doc)->type_name(what);
  if (!value.empty()) impl_->last->capture_default_str();
  impl_->last->check(not_empty);
  impl_->note(names, what, doc);
  return *this;
}
Options& Options::option(const std::string& names, int& value, const std::string& what,
                         const std::string& doc) {
  impl_->last = impl_->app->add_option(names, value, doc)->type_name(what);
  impl_->last->check(not_empty);
  if (value >= 0)
    impl_->last->capture_default_str();
  else  // a negative number stands for none: it cannot be given
    impl_->last->check([](const std::string& word) -> std::string {
      return word.starts_with('-') ? word + " is negative; give 0 or more, or leave it out" : "";
    });
  impl_->note(names, what, doc);
  return *this;
}
Options& Options::option(const std::string& names, double& value, const std::string& what,
                         const std::string& doc) {
  impl_->last = impl_->app->add_option(names, value, doc)->type_name(what);
  if (std::isfinite(value)) impl_->last->capture_default_str();
  impl_->last->check(not_empty)->check([](const std::string& word) -> std::string {
    const bool is_none =
        std::isnan(std::strtod(word.c_str(), nullptr));  // which stands for an option that is not given
    return is_none ? word + " is no number; give one" : "";
  });
  impl_->note(names, what, doc);
  return *this;
}
Options& Options::option(const std::string& names, std::vector<std::string>& values, const std::string& what,
                         const std::string& doc) {
  impl_->last = impl_->app->add_option(names, values, doc)->type_name(what)->check(not_empty);
  impl_->note(names, what, doc);
  return *this;
}
Options& Options::optional_value(const std::string& names, std::string& value, const std::string& bare,
                                 const std::string& what, const std::string& doc) {
  impl_->last = impl_->app->add_option(names, value, doc)->type_name("[" + what + "]")->expected(0, 1);
  impl_->last->default_str(bare);
  impl_->note(names, what, doc);
  return *this;
}
Options& Options::choice(const std::string& names, std::string& value,
                         const std::vector<std::string>& choices, const std::string& doc) {
  std::string all;
  for (const std::string& one : choices) all += (all.empty() ? "" : "|") + one;
  impl_->last = impl_->app->add_option(names, value, doc)->type_name(all);
  if (!value.empty()) impl_->last->capture_default_str();
  impl_->last->check([choices](const std::string& word) -> std::string {
    if (std::find(choices.begin(), choices.end(), word) != choices.end()) return {};
    return "\"" + word + "\" is not a known choice" + input::suggestion(word, choices);
  });
  impl_->note(names, "WORD", doc);
  impl_->description.entries.back().choices = choices;
  return *this;
}
Options& Options::flag(const std::string& names, bool& value, const std::string& doc) {
  impl_->last = impl_->app->add_flag(names, value, doc);
  impl_->note(names, "", doc);
  return *this;
}
Options& Options::required() {
  impl_->last->required();
  impl_->description.entries.back().is_required = true;
  return *this;
}
Options& Options::example(const std::string& command, const std::string& what) {
  impl_->description.examples.emplace_back(command, what);
  return *this;
}

// --- Running ---------------------------------------------------------------------------------------------

int guarded(const std::function<int()>& work) {
  try {
    hdf5::start();
    return work();
  } catch (const input::InputError& failure) {
    print_error(failure.what());
    return bad_input;
  } catch (const hdf5::BadFile& failure) {
    print_error(failure.what());
    return bad_input;
  } catch (const std::invalid_argument& failure) {
    print_error(failure.what());
    return bad_input;
  } catch (const std::bad_alloc&) {
    print_error("out of memory; take a smaller model or fewer modes");
  } catch (const std::length_error&) {  // of a container: larger than any memory
    print_error("out of memory; take a smaller model or fewer modes");
  } catch (const std::logic_error& failure) {
    print_error(std::string("a mistake of the program, not of the input: ") + failure.what() +
                "; please report this with the input");
  } catch (const std::filesystem::filesystem_error& failure) {
    print_error(failure.path1().string() + ": " + failure.code().message() + "; check the path");
  } catch (const std::exception& failure) {
    print_error(std::ferror(stdout) ? "standard output cannot be written; what was printed is not whole"
                                    : failure.what());
  } catch (...) {  // of a library of the user's
    print_error(
        "an element of a user's library throws what is no std::exception; let it throw std::runtime_error");
  }
  return 1;
}

namespace {

// A whole program: its work, and what it printed has left the house.
int run_guarded(const std::function<int()>& work) {
  files::prepare_process();
  guard_standard_streams();
  files::guard_inputs();
  return guarded([&] {
    const int code = work();
    files::finish_standard_output();
    return code;
  });
}

}  // namespace

int run(const Command& command, const std::string& version, int argc, const char* const* argv) {
  return run_guarded([&] {
    const std::string only = argc == 2 ? argv[1] : "";
    if (only == "--list-options" || only == "--manual-section") {
      fmt::print("{}",
                 only == "--list-options" ? option_list(command) : manual_section(command.name, command));
      return 0;
    }
    return run_command(command, command.name, version + "\nlibraries: " + loaded_libraries(),
                       std::vector<std::string>(argv + 1, argv + argc));
  });
}

int run(const Program& program, int argc, const char* const* argv) {
  return run_guarded([&] {
    std::vector<std::string> words(argv + 1, argv + argc);
    if (words.empty()) {
      fmt::print("{}", program_help(program));
      return bad_input;
    }
    if (const std::size_t most = words_of_its_own(words[0]); most > 0 && words.size() > most) {
      print_error(fmt::format("\"{}\" is one argument too many; write {} {}", words[most], program.name,
                              fmt::join(words.begin(), words.begin() + static_cast<long>(most), " ")));
      return bad_input;
    }
    if (words[0] == "--help" || words[0] == "-h" || (words[0] == "help" && words.size() == 1)) {
      fmt::print("{}", program_help(program));
      return 0;
    }
    if (words[0] == "--version" || words[0] == "version") {
      fmt::print("{} {}\n{}", program.name, program.version, program.details ? program.details() : "");
      return 0;
    }
    if (words[0] == "completion") {
      fmt::print("{}", completion(program, words.size() > 1 ? words[1] : "bash"));
      return 0;
    }
    if (words[0] == "man") {
      fmt::print("{}", words.size() > 1 ? manual_page(program, named_command(program, words[1]))
                                        : manual_page(program));
      return 0;
    }
    if (words[0] == "help") words = {words[1], "--help"};
    std::vector<std::string> names;
    for (const Command& command : program.commands) {
      if (command.name == words[0]) {
        return run_command(command, program.name + " " + command.name, program.version,
                           {words.begin() + 1, words.end()});
      }
      names.push_back(command.name);
    }
    if (words[0].starts_with("-")) {
      print_error(fmt::format("the command comes first: {} COMMAND [OPTIONS]; commands are {}", program.name,
                              fmt::join(names, ", ")));
    } else {
      print_error(fmt::format("unknown command \"{}\"{}", words[0], input::suggestion(words[0], names)));
    }
    return bad_input;
  });
}

}  // namespace flexura::terminal
