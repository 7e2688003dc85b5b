// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "mbs/terminal/description.hpp"

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

// roff takes a leading dot or quote for a request and a backslash for an escape; a bare "-" would become a
// hyphen.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) {
      out += std::string("\\&") + c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return text;
}

}  // namespace

std::string bash_completion(const Program& program) {
  std::string commands, cases;
  for (const Command& command : program.commands) {
    commands += (commands.empty() ? "" : " ") + command.name;
    if (!command.helper.empty()) {
      cases += fmt::format(
          "    {0}) options=$(\"$(dirname -- \"$(command -v -- \"${{COMP_WORDS[0]}}\")\")\"/{1} "
          "--list-options "
          "2>/dev/null) ;;\n",
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
      "    help) COMPREPLY=($(compgen -W \"{1}\" -- \"$cur\")); return ;;\n"
      "  esac\n"
      "  [[ $cur != -* ]] || COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
      "}}\n"
      "complete -o bashdefault -o default -F _{0}_complete {0}\n",
      program.name, commands, cases);
}

std::string manual_page(const Program& program) {
  std::string out = fmt::format(
      ".TH {} 1 \"\" \"{} {}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n.I COMMAND\n[OPTIONS]\n",
      upper(program.name), program.name, program.version, program.name, roff(program.summary), program.name);
  for (const Command& command : program.commands) {
    out += fmt::format(".SH {} {}\n{}\n", upper(program.name), upper(command.name), roff(command.summary));
    if (!command.helper.empty()) {
      out += fmt::format(".PP\nRun by {}; see {} {} \\-\\-help.\n", roff(command.helper), program.name,
                         command.name);
      continue;
    }
    const Description description = describe(command);
    for (const Entry& entry : description.entries) {
      std::string heading = roff(entry.names);
      if (!entry.what.empty()) heading += " \\fI" + roff(entry.what) + "\\fR";
      std::string text = entry.doc;
      if (!entry.choices.empty()) text += fmt::format(" ({})", fmt::join(entry.choices, ", "));
      if (!entry.fallback.empty()) text += "; default " + entry.fallback;
      if (entry.is_required && !entry.is_argument) text += "; required";
      out += fmt::format(".TP\n\\fB{}\\fR\n{}\n", heading, roff(text));
    }
    if (!description.examples.empty()) out += ".PP\nExamples:\n";
    for (const auto& [example, what] : description.examples) {
      out += fmt::format(".PP\n.nf\n    {}\n.fi\n{}\n", roff(example), roff(what));
    }
  }
  return out + ".SH EXIT STATUS\n0 done, 1 failed, 2 bad input (command line or files).\n";
}

}  // namespace flexura::terminal
