// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "mbs/base/terminal/description.hpp"

namespace flexura::terminal {
namespace {

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

namespace {

// One command's part of the page; the program beside this one tells its own.
std::string section_of(const Program& program, const Command& command) {
  const std::string full_name = program.name + " " + command.name;
  if (command.helper.empty()) return manual_section(full_name, command);
  if (std::string told = helper_says(command.helper + " --manual-section"); !told.empty()) return told;
  return fmt::format(".SH {}\n{}\n.PP\nRun by {}; see {} \\-\\-help.\n", roff(upper(full_name)),
                     roff(command.summary), roff(command.helper), roff(full_name));
}

const char* const kLastSections =
    ".SH EXIT STATUS\n0 done, 1 failed or interrupted (what was computed is kept), 2 bad input (command line "
    "or files); a signal that leaves nothing to keep ends the program itself.\n"
    ".SH ENVIRONMENT\n.TP\n\\fBNO_COLOR\\fR\nplain text on terminals too\n.TP\n\\fBCOLUMNS\\fR\n"
    "width of tables where the output is no terminal; default 80\n";

}  // namespace

std::string manual_page(const Program& program) {
  std::string out = fmt::format(
      ".TH {} 1 \"\" \"{} {}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n.I COMMAND\n[OPTIONS]\n",
      upper(program.name), program.name, program.version, program.name, roff(program.summary), program.name);
  for (const Command& command : program.commands) out += section_of(program, command);
  return out + kLastSections;
}

std::string manual_page(const Program& program, const Command& command) {
  const std::string name = program.name + "-" + command.name;
  std::string arguments;
  if (command.helper.empty())
    for (const Entry& entry : describe(command).entries)
      if (entry.is_argument) arguments += entry.is_required ? " " + entry.names : " [" + entry.names + "]";
  std::string body = section_of(program, command);
  body.replace(0, body.find('\n'), ".SH DESCRIPTION");
  return fmt::format(".TH {} 1 \"\" \"{} {}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {} {}\n[OPTIONS]{}\n",
                     roff(upper(name)), program.name, program.version, roff(name), roff(command.summary),
                     roff(program.name), roff(command.name), roff(arguments)) +
         body + kLastSections + fmt::format(".SH SEE ALSO\n.BR {} (1)\n", roff(program.name));
}

}  // namespace flexura::terminal
