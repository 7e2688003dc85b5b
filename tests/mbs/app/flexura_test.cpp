// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "mbs/base/terminal/terminal.hpp"
#include "tests/mbs/app/flexura_fixture.hpp"

namespace flexura {
namespace {

using testing::Flexura;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::run_program;

TEST_F(Flexura, ModesPrintsATableThatFits) {
  const Outcome outcome = flexura("modes " + beam_);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr("Free body\n"));
  EXPECT_THAT(outcome.out, HasSubstr("All interfaces held (fixed-interface modes)\n"));
  EXPECT_THAT(outcome.out, HasSubstr("  83.33  "));  // 5/6 of the mass, see modes_test.cpp
  std::istringstream lines(outcome.out);
  int rigid = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 80u) << line;
    EXPECT_EQ(line.find('\033'), std::string::npos);  // no colour in a pipe
    rigid += line.find(" rigid ") != std::string::npos;
  }
  EXPECT_EQ(rigid, 6);
}

// Mechanisms with several runs and many states; sentences (notes, names of files) may be longer.
TEST_F(Flexura, TablesOfEveryCommandFitEightyColumns) {
  const std::string cases = FLEXURA_SOURCE_DIR "/cases/", suspension = cases + "macpherson/macpherson.toml";
  const std::string results = (folder_ / "suspension.h5").string();
  const std::vector<std::string> commands = {"check " + suspension,
                                             "assemble " + suspension,
                                             "eigen " + cases + "bicycle/bicycle.toml",
                                             "statics " + suspension + " --run ride",
                                             "simulate " + suspension + " --end-time 0.02 -v -o " + results,
                                             "view " + results + " --summary",
                                             "check " + beam_};
  for (const std::string& command : commands) {
    const Outcome outcome = flexura(command);
    ASSERT_EQ(outcome.code, 0) << command << outcome.err;
    std::istringstream lines(outcome.out);
    int rules = 0;
    for (std::string line; std::getline(lines, line);) {
      rules += line.find_first_not_of('-') == std::string::npos && line.size() > 3;
      if (line.starts_with("note: ") || line.starts_with("results ") ||
          line.find(": estimated error ") != std::string::npos)
        continue;
      EXPECT_LE(terminal::display_width(line), 80) << command << "\n" << line;
    }
    EXPECT_GT(rules, 0) << command;
  }
}

// Options with their texts, wrapped; commands in the examples may be copied and stay whole.
TEST_F(Flexura, HelpOfEveryCommandFitsEightyColumnsAndHasExamplesAndAVersion) {
  // The version in the first line, below it libraries and what is missing.
  const auto first_line = [](const std::string& text) { return text.substr(0, text.find('\n')); };
  const std::string told = run_program(FLEXURA_BIN_DIR "/flexura --version").out, program = first_line(told);
  for (const char* words : {"\ncompiler: ", "\nlibraries: Eigen 3", "libhdf5", "libsundials",
                            "\npages for the browser: ", "\nflexura-reduce: ", "\nsandbox of flexura-mesh"})
    EXPECT_THAT(told, HasSubstr(words));
  std::istringstream overview(flexura("--help").out);
  std::vector<std::string> commands;
  bool is_list = false;
  for (std::string line; std::getline(overview, line);) {
    EXPECT_LE(terminal::display_width(line), 80) << line;
    is_list = line == "Commands:" || (is_list && !line.empty());
    if (is_list && line.starts_with("  ") && line[2] != ' ')
      commands.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  EXPECT_THAT(commands, ::testing::IsSupersetOf({"reduce", "simulate", "assemble"}));
  for (const std::string& command : commands) {
    if (command == "import") continue;  // of flexura-import, which need not be there: tests/import
    const Outcome help = flexura(command + " --help");
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_THAT(help.out, HasSubstr("Examples:\n  flexura " + command)) << command;
    std::istringstream lines(help.out);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("  flexura")) continue;
      EXPECT_LE(terminal::display_width(line), 80) << line;
    }
    const Outcome version = flexura(command + " --version");
    EXPECT_EQ(first_line(version.out), "flexura " + command + program.substr(program.find(' ')));
  }
}

// Every detail: what the integrator counted, and the stages where no terminal shows them moving.
TEST_F(Flexura, VerboseTellsCountsAndStages) {
  const std::string run = "simulate " FLEXURA_SOURCE_DIR
                          "/cases/macpherson/macpherson.toml --run bump --end-time 0.02 -o " +
                          (folder_ / "bump.h5").string();
  const Outcome plain = flexura(run), verbose = flexura(run + " -v");
  EXPECT_EQ(plain.err.find("run bump: "), std::string::npos);
  EXPECT_EQ(plain.out.find("jacobians"), std::string::npos);
  EXPECT_THAT(verbose.err, HasSubstr("run bump: "));
  EXPECT_THAT(verbose.out, HasSubstr("jacobians"));
}

TEST_F(Flexura, ModesWritesAPage) {
  const std::string page = (folder_ / "beam.html").string();
  const Outcome outcome = flexura("modes " + beam_ + " --html " + page);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("wrote " + page));
  EXPECT_GT(std::filesystem::file_size(page), 10'000u);
}

TEST_F(Flexura, CheckSummarises) {
  const Outcome outcome = flexura("check " + beam_);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("9.42 kg"));  // 7850 * 0.03 * 0.05 * 0.8
  EXPECT_THAT(outcome.out, HasSubstr("All checksums and relations hold."));
  EXPECT_EQ(flexura("check -q " + beam_).out, "");
}

TEST_F(Flexura, ExportWritesEachFormat) {
  for (const std::string format : {"dmig", "sid", "flexdata", "vtk", "gmsh"}) {
    const auto file = folder_ / ("out." + format);
    const Outcome outcome = flexura("export " + beam_ + " -f " + format + " -o " + file.string());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "wrote " + file.string() + "\n");
    EXPECT_GT(std::filesystem::file_size(file), 1000u);
  }
  EXPECT_EQ(flexura("export -f matrix-market " + beam_).code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "beam.K.mtx"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "beam.M.mtx"));
}

TEST_F(Flexura, BadInputIsRefusedInOneLineWithCode2) {
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const Outcome outcome = flexura(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_TRUE(outcome.err.starts_with("error: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(words));
  };
  refused("mods x", "unknown command \"mods\", did you mean \"modes\"?");
  refused("modes nowhere.h5", "nowhere.h5: there is no such file");
  refused("modes " FLEXURA_SOURCE_DIR "/CMakeLists.txt", "CMakeLists.txt: is not an HDF5 file");
  refused("modes " + beam_ + " --clamped middle",
          "there is no interface \"middle\" in superelement \"box beam\"; it has left, right");
  refused("modes " + beam_ + " --free --fixed",
          "--free, --fixed, --clamped and --constraint exclude each other");
  refused("modes " + beam_ + " -n 0", "--count is 0, it must be at least 1");
  refused("export " + beam_ + " -f vkt", "\"vkt\" is not a known choice, did you mean \"vtk\"?");
  refused("export " + beam_, "--format is required");
  std::filesystem::resize_file(beam_, std::filesystem::file_size(beam_) - 1);
  refused("check " + beam_, "the file is cut short");
  const auto cad = folder_ / "rod.step", results = folder_ / "refused.h5";
  std::ofstream(cad) << "ISO-10303-21;";
  refused("reduce " + cad.string(), "is a CAD file, a part file (.toml) that names it is wanted");
  // What other programs write is named, and never answered as a CAD file.
  const std::pair<const char*, const char*> foreign[] = {
      {"body.mnf", "is a modal neutral file of Adams"},
      {"body.h3d", "is an Altair H3D file"},
      {"body.op2", "is a results file of Nastran"},
      {"body.rst", "is a binary file of Ansys"},
      {"body.sldprt", "export the part as STEP"},
      {"body.xyz", "is a kind of file that is not known here"}};
  for (const auto& [name, says] : foreign) {
    std::ofstream(folder_ / name) << "binary";
    std::ofstream(folder_ / "part.toml") << "[geometry]\nfile = \"" << name << "\"\n[material.s]\n"
                                         << "young = \"1 GPa\"\npoisson = 0.3\ndensity = 1000\n";
    refused("reduce " + (folder_ / "part.toml").string(), says);
    if (std::string(name) != "body.xyz") refused("reduce " + (folder_ / name).string(), says);
  }
  refused(
      "simulate " FLEXURA_SOURCE_DIR "/cases/macpherson/macpherson.toml --accuracy much -o " +
          results.string(),
      "--accuracy is \"much\", it must be a part of the outputs above 0 and at most 1, like \"1 %\" or 0.01");
  refused("simulate " FLEXURA_SOURCE_DIR "/cases/macpherson/macpherson.toml --end-time soon -o " +
              results.string(),
          "solver.end_time = \"soon\": is not a number with a unit, a time is wanted, like \"10 ms\", or a "
          "formula");
  refused("man modes extra", "\"extra\" is one argument too many; write flexura man modes");
  EXPECT_FALSE(std::filesystem::exists(results.string() + ".part"));
}

// Before anything is computed or printed.
TEST_F(Flexura, OutputsInAFolderThatIsNotThereAreRefused) {
  const std::string nowhere = (folder_ / "nowhere").string();
  const std::vector<std::string> commands = {
      "modes " + beam_ + " --html ",
      "report " + beam_ + " -o ",
      "export " + beam_ + " -f gltf -o ",
      "section " FLEXURA_SOURCE_DIR "/cases/jib_crane/jib_section.toml -o ",
      "reduce " FLEXURA_SOURCE_DIR "/cases/steam_engine/conrod.toml --report ",
      "statics " FLEXURA_SOURCE_DIR "/cases/macpherson/macpherson.toml --save-state ",
      "linearize " FLEXURA_SOURCE_DIR "/cases/bicycle/bicycle.toml -o ",
      "study " FLEXURA_SOURCE_DIR "/cases/trade/four_bar.toml -o "};
  for (const std::string& command : commands) {
    // The file of a linearisation is known by its ending.
    const Outcome outcome =
        flexura(command + nowhere + (command.starts_with("linearize") ? "/file.m" : "/file"));
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_EQ(outcome.out, "") << command;
    EXPECT_THAT(outcome.err, HasSubstr("the folder " + nowhere + " does not exist; make it first"))
        << command;
  }
}

// A file may have no more than 512 bytes here, as on a full disk: one sentence, code 1, nothing left behind.
TEST_F(Flexura, OutputsThatCannotBeWrittenAreSaidSoAndLeaveNothing) {
  const auto out = folder_ / "out";
  std::filesystem::create_directory(out);
  const std::string suspension = " " FLEXURA_SOURCE_DIR "/cases/macpherson/macpherson.toml --run ride ";
  const std::vector<std::string> commands = {
      "modes " + beam_ + " --html ", "report " + beam_ + " -o ", "export " + beam_ + " -f vtk -o ",
      "linearize" + suspension + "--frozen --descriptor -o ", "statics" + suspension + "--save-state "};
  for (const std::string& command : commands) {
    const std::string file = (out / "file.m").string(), script = (folder_ / "limited.sh").string();
    std::ofstream(script) << "trap '' XFSZ\nulimit -f 1\nexec " FLEXURA_BIN_DIR "/flexura " << command << file
                          << " -q 2>&1 | cat\nexit ${PIPESTATUS[0]}\n";
    const Outcome outcome = run_program("bash " + script);
    EXPECT_EQ(outcome.code, 1) << command;
    EXPECT_TRUE(outcome.out.starts_with("error: ")) << command << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << outcome.out;
    EXPECT_THAT(outcome.out, HasSubstr("file.m"));
    EXPECT_TRUE(std::filesystem::is_empty(out)) << command;
  }
}

// Bash itself completes: the words typed so far, and what it would offer.
TEST_F(Flexura, BashCompletesCommandsOptionsAndChoices) {
  const auto offers = [&](const std::string& words, int at) {
    const std::string script = "eval \"$(" FLEXURA_BIN_DIR "/flexura completion)\"; COMP_WORDS=(" + words +
                               "); COMP_CWORD=" + std::to_string(at) +
                               "; _flexura_complete; echo \"${COMPREPLY[*]}\"";
    const auto file = folder_ / "complete.sh";
    std::ofstream(file) << script;
    const Outcome outcome = run_program("bash " + file.string());
    EXPECT_EQ(outcome.err, "");
    return outcome.out;
  };
  EXPECT_EQ(offers("flexura mo", 1), "modes\n");
  EXPECT_EQ(offers("flexura modes --cl", 2), "--clamped\n");
  EXPECT_EQ(offers("flexura export beam --format d", 4), "dmig\n");
  EXPECT_EQ(offers("flexura modes beam", 2), "\n");  // files are bash's own business
  EXPECT_EQ(offers(FLEXURA_BIN_DIR "/flexura reduce --mesh-", 2),
            "--mesh-size\n");  // asked of flexura-reduce
}

// A copy of the program alone in a folder has no companion to hand over to; beside one it becomes that
// program.
TEST_F(Flexura, ReduceHandsOverToTheProgramBesideIt) {
  const auto alone = folder_ / "flexura";
  std::filesystem::copy_file(FLEXURA_BIN_DIR "/flexura", alone);
  Outcome outcome = run_program(alone.string() + " reduce conrod.toml");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("flexura-reduce: this program is not there; build it"));

  const auto companion = folder_ / "flexura-reduce";
  std::ofstream(companion) << "#!/bin/sh\necho \"$#:$1:$2\"\nexit 5\n";
  std::filesystem::permissions(companion, std::filesystem::perms::owner_all);
  outcome = run_program(alone.string() + " reduce 'a b.toml' --list-faces");
  EXPECT_EQ(outcome.out, "2:a b.toml:--list-faces\n");
  EXPECT_EQ(outcome.code, 5);
}

}  // namespace
}  // namespace flexura
