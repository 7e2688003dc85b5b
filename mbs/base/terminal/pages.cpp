// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

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

// What a program beside this one prints, or nothing.
std::string helper_says(const std::string& program_and_words) {
  std::error_code failure;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failure);
  if (failure) return {};
  const auto space = program_and_words.find(' ');
  const std::string path = (self.parent_path() / program_and_words.substr(0, space)).string();
  if (::access(path.c_str(), X_OK) != 0 || path.find('\'') != std::string::npos) return {};
  std::string text;
  std::FILE* pipe =
      ::popen(("'" + path + "'" + program_and_words.substr(space) + " 2>/dev/null").c_str(), "r");
  if (!pipe) return {};
  char block[4096];
  for (std::size_t n; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, n);
  return ::pclose(pipe) == 0 ? text : std::string();
}

}  // namespace

std::string bash_completion(const Program& program) {
  std::string commands, cases;
  for (const Command& command : program.commands) {
    commands += (commands.empty() ? "" : " ") + command.name;
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
      "    help) COMPREPLY=($(compgen -W \"{1}\" -- \"$cur\")); return ;;\n"
      "  esac\n"
      "  [[ $cur != -* ]] || COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
      "}}\n"
      "complete -o bashdefault -o default -F _{0}_complete {0}\n",
      program.name, commands, cases);
}

std::string option_list(const Command& command) {
  std::string text;
  for (const Entry& entry : describe(command).entries) {
    if (entry.is_argument) continue;
    for (const std::string& name : split_names(entry.names)) text += name + " ";
  }
  return text + "--help --version\n";
}

std::string manual_section(const std::string& full_name, const Command& command) {
  std::string out = fmt::format(".SH {}\n{}\n", roff(upper(full_name)), roff(command.summary));
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
  return out;
}

std::string manual_page(const Program& program) {
  std::string out = fmt::format(
      ".TH {} 1 \"\" \"{} {}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n.I COMMAND\n[OPTIONS]\n",
      upper(program.name), program.name, program.version, program.name, roff(program.summary), program.name);
  for (const Command& command : program.commands) {
    const std::string full_name = program.name + " " + command.name;
    if (command.helper.empty()) {
      out += manual_section(full_name, command);
    } else if (const std::string told = helper_says(command.helper + " --manual-section"); !told.empty()) {
      out += told;
    } else {
      out += fmt::format(".SH {}\n{}\n.PP\nRun by {}; see {} \\-\\-help.\n", roff(upper(full_name)),
                         roff(command.summary), roff(command.helper), roff(full_name));
    }
  }
  return out +
         ".SH EXIT STATUS\n0 done, 1 failed or interrupted (what was computed is kept), 2 bad input (command "
         "line or files).\n" +
         ".SH ENVIRONMENT\n.TP\n\\fBNO_COLOR\\fR\nplain text on terminals too\n.TP\n\\fBCOLUMNS\\fR\n" +
         "width of tables where the output is no terminal; default 80\n";
}

}  // namespace flexura::terminal
