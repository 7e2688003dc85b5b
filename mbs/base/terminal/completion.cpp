// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Completion scripts for bash, zsh and fish, made of what the commands declare.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mbs/base/terminal/description.hpp"

namespace flexura::terminal {
namespace {

std::vector<std::string> split_names(const std::string& names) {
  std::vector<std::string> all;
  std::size_t start = 0;
  for (std::size_t comma; (comma = names.find(',', start)) != std::string::npos; start = comma + 1) {
    all.push_back(names.substr(start, comma - start));
  }
  all.push_back(names.substr(start));
  return all;
}

// In single quotes; `escape` is what a quote becomes there.
std::string quoted(const std::string& text, const char* escape) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? escape : std::string(1, c);
  return out + "'";
}

// What the program itself knows beside the commands.
constexpr std::pair<const char*, const char*> own_words[] = {
    {"help", "describe a command"},
    {"man", "the manual in roff, of all commands or of one"},
    {"completion", "a completion script for bash, zsh or fish"}};

std::string command_names(const Program& program) {
  std::string names;
  for (const Command& command : program.commands) names += (names.empty() ? "" : " ") + command.name;
  return names;
}

}  // namespace

std::string bash_completion(const Program& program) {
  const std::string commands = command_names(program);
  std::string cases;
  for (const Command& command : program.commands) {
    if (!command.helper.empty()) {
      cases += fmt::format(
          "    {0}) options=$(\"$(dirname -- \"$(command -v -- \"${{COMP_WORDS[0]}}\")\")\"/{1} "
          "--list-options 2>/dev/null) ;;\n",
          command.name, command.helper);
      continue;
    }
    std::string options, values;
    for (const Entry& entry : describe(command).entries) {
      if (entry.is_argument) continue;
      const std::vector<std::string> names = split_names(entry.names);
      for (const std::string& name : names) options += " " + name;
      if (!entry.choices.empty()) {
        values += fmt::format("        {}) COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); return ;;\n",
                              fmt::join(names, "|"), fmt::join(entry.choices, " "));
      }
    }
    cases += fmt::format("    {})\n      options=\"{} --help\"\n", command.name,
                         options.substr(options.empty() ? 0 : 1));
    if (!values.empty()) cases += "      case $prev in\n" + values + "      esac\n";
    cases += "      ;;\n";
  }
  return fmt::format(
      "# Completion of {0} for bash: eval \"$({0} completion)\"\n"
      "_{0}_complete() {{\n"
      "  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} options=\n"
      "  COMPREPLY=()\n"
      "  if ((COMP_CWORD == 1)); then\n"
      "    COMPREPLY=($(compgen -W \"{1} help completion man --help --version\" -- \"$cur\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n"
      "{2}"
      "    help|man) COMPREPLY=($(compgen -W \"{1}\" -- \"$cur\")); return ;;\n"
      "    completion) COMPREPLY=($(compgen -W \"bash zsh fish\" -- \"$cur\")); return ;;\n"
      "  esac\n"
      "  [[ $cur != -* ]] || COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
      "}}\n"
      "complete -o bashdefault -o default -F _{0}_complete {0}\n",
      program.name, commands, cases);
}

// _describe takes "name:doc" with colons of the name escaped.
std::string zsh_completion(const Program& program) {
  const auto described = [](const std::string& name, const std::string& doc) {
    return quoted(name + ":" + doc, "'\\''");
  };
  std::string commands, cases;
  for (const Command& command : program.commands) {
    commands += " " + described(command.name, command.summary);
    if (!command.helper.empty()) {
      cases += fmt::format(
          "    {}) options=(${{(s: :)\"$(\"${{program:h}}\"/{} --list-options 2>/dev/null)\"}}) ;;\n",
          command.name, command.helper);
      continue;
    }
    std::string options, values;
    for (const Entry& entry : describe(command).entries) {
      if (entry.is_argument) continue;
      const std::vector<std::string> names = split_names(entry.names);
      for (const std::string& name : names) options += " " + described(name, entry.doc);
      if (!entry.choices.empty())
        values += fmt::format("        {}) choices=({}) ;;\n", fmt::join(names, "|"),
                              fmt::join(entry.choices, " "));
    }
    cases += fmt::format("    {})\n      options=({} '--help:describe the command')\n", command.name,
                         options.substr(options.empty() ? 0 : 1));
    if (!values.empty()) cases += "      case $words[CURRENT-1] in\n" + values + "      esac\n";
    cases += "      ;;\n";
  }
  for (const auto& [name, doc] : own_words) commands += " " + described(name, doc);
  return fmt::format(
      "#compdef {0}\n"
      "# Completion of {0} for zsh: source <({0} completion zsh), or this file as _{0} in a folder of "
      "$fpath.\n"
      "_{0}() {{\n"
      "  local -a verbs options choices\n"
      "  local program=$(whence -p -- ${{words[1]}})\n"
      "  verbs=({1})\n"
      "  if (( CURRENT == 2 )); then\n"
      "    _describe command verbs\n"
      "    return\n"
      "  fi\n"
      "  case $words[2] in\n"
      "{2}"
      "    help|man) _describe command verbs; return ;;\n"
      "    completion) choices=(bash zsh fish) ;;\n"
      "  esac\n"
      "  if (( $#choices )); then\n"
      "    _describe value choices\n"
      "  elif [[ $words[CURRENT] == -* ]]; then\n"
      "    _describe -o option options\n"
      "  else\n"
      "    _files\n"
      "  fi\n"
      "}}\n"
      "if [[ ${{funcstack[1]}} == _{0} ]]; then _{0} \"$@\"; else compdef _{0} {0}; fi\n",
      program.name, commands.substr(1), cases);
}

std::string fish_completion(const Program& program) {
  const auto text = [](const std::string& words) { return quoted(words, "\\'"); };
  const std::string first = fmt::format("test (count (commandline -opc)) -eq 1");
  std::string out = fmt::format(
      "# Completion of {0} for fish: {0} completion fish | source\n"
      "function __{0}_options\n"
      "  set -l folder (dirname (command -s {0}))\n"
      "  command $folder/$argv[1] $argv[2..-1] --list-options 2>/dev/null | string split ' '\n"
      "end\n",
      program.name);
  const auto line = [&](const std::string& condition, const std::string& rest) {
    out += fmt::format("complete -c {} -n {} {}\n", program.name, text(condition), rest);
  };
  for (const Command& command : program.commands)
    line(first, fmt::format("-f -a {} -d {}", command.name, text(command.summary)));
  for (const auto& [name, doc] : own_words) line(first, fmt::format("-f -a {} -d {}", name, text(doc)));
  for (const Command& command : program.commands) {
    const std::string inside = fmt::format("__fish_seen_subcommand_from {}", command.name);
    if (!command.helper.empty()) {
      line(inside + "; and string match -q -- '-*' (commandline -ct)",
           fmt::format("-f -a '(__{}_options {})'", program.name, command.helper));
      continue;
    }
    for (const Entry& entry : describe(command).entries) {
      if (entry.is_argument) continue;
      std::string rest;
      for (const std::string& name : split_names(entry.names))
        rest += name.starts_with("--") ? "-l " + name.substr(2) + " " : "-s " + name.substr(1) + " ";
      if (!entry.choices.empty())
        rest += fmt::format("-x -a {} ", text(fmt::format("{}", fmt::join(entry.choices, " "))));
      else if (!entry.what.empty())
        rest += "-r ";
      line(inside, rest + "-d " + text(entry.doc));
    }
  }
  line("__fish_seen_subcommand_from help man", "-f -a " + text(command_names(program)));
  line("__fish_seen_subcommand_from completion", "-f -a 'bash zsh fish'");
  return out;
}

std::string option_list(const Command& command) {
  std::string text;
  for (const Entry& entry : describe(command).entries) {
    if (entry.is_argument) continue;
    for (const std::string& name : split_names(entry.names)) text += name + " ";
  }
  return text + "--help --version\n";
}

}  // namespace flexura::terminal
