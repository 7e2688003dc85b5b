// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "mbs/view/pages.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::PageReader;
using testing::scratch;
using testing::slurp;
namespace fs = std::filesystem;

/// Runs a command line and returns what it printed, errors too, and its exit code.
std::pair<std::string, int> run_program(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char part[512];
  while (std::fgets(part, sizeof part, pipe)) text += part;
  return {text, WEXITSTATUS(pclose(pipe))};
}

TEST(ViewCommand, WritesThePageBesideTheResultsAndPrintsASummary) {
  // A file as the runtime writes it; the rod without its superelement, drawn as a rod between its pins.
  Pictures pictures;
  results::Results engine = synthetic::engine(pictures);
  engine.model.bodies[2].superelement.clear();
  const fs::path file = scratch("engine.h5"), html = scratch("engine.html");
  {
    results::Writer writer(file, engine.model);
    for (const auto& run : engine.runs) {
      std::vector<results::RunBody> bodies;
      for (const auto& body : run.bodies) bodies.push_back({body.name, body.basis});
      writer.begin_run(run.name, run.quantities, bodies);
      for (Eigen::Index i = 0; i < run.time.size(); ++i) {
        results::Row row;
        row.time = run.time[i];
        row.quantities = run.values.row(i);
        for (const auto& body : run.bodies) {
          row.pose.push_back(body.pose.row(i).transpose());
          row.modal.push_back(body.modal.rows() > 0 ? Eigen::VectorXd(body.modal.row(i)) : Eigen::VectorXd());
        }
        writer.append(row);
      }
      writer.end_run(run.complete, run.stopped_because, run.summary_json);
    }
    writer.close();
  }
  const std::string program = std::string(FLEXURA_BIN_DIR) + "/flexura view " + file.string();
  const auto [text, code] = run_program(program + " --plot crank.speed");
  EXPECT_EQ(code, 0) << text;
  EXPECT_THAT(text, HasSubstr("wrote " + html.string()));
  const PageReader page(slurp(html));
  EXPECT_EQ(page.header["plots"], json::parse(R"([["crank.speed"]])"));
  EXPECT_EQ(page.block<double>("run1/quantity/1")[9], engine.runs[1].values(9, 1));

  const auto [summary, summary_code] = run_program(program + " --summary");
  EXPECT_EQ(summary_code, 0);
  EXPECT_THAT(summary, HasSubstr("slider.position [m]"));
  EXPECT_THAT(summary, HasSubstr("0.75 .. 1.25"));
  EXPECT_THAT(summary, HasSubstr("warning: rigid stopped early: end of the test's patience"));

  // A film needs a browser; whether it can be made is said before anything is computed.
  const std::string film = scratch("engine.mp4").string();
  for (const auto& [words, says] : std::initializer_list<std::pair<std::string, const char*>>{
           {"x.avi", "a film ends in .mp4, .webm, .gif"},
           {film + " --film-size 20", "write width and height, 64 to 4096 pixels each"},
           {film + " --film-fps 0", "frames per second are 1 to 60"},
           {film + " --film-seconds 1000", "a film has 1 to 6000 frames"},
           {film + " --film-view front", "it is one of +x, -x"},
           {film + " --film-color red", "it is one of bodies, displacement, stress"},
           {film, "none is in PATH (chromium, "}}) {
    const auto [refused, refused_code] =
        run_program("env -u FLEXURA_BROWSER PATH=/none " + program + " --film " + words);
    EXPECT_NE(refused_code, 0);
    EXPECT_THAT(refused, HasSubstr(says));
    EXPECT_FALSE(fs::exists(film));
  }

  const auto [wrong, wrong_code] = run_program(program + " --plot crank.sped");
  EXPECT_EQ(wrong_code, 2);
  EXPECT_THAT(wrong, HasSubstr("error: no run stored the quantity 'crank.sped'"));
}

// What nothing judges is no "0 %"; what is known in part is a lower bound.
TEST(ViewCommand, CallsAnErrorUnknownThatNothingHasJudged) {
  const auto told = [](const std::string& estimate) {
    const fs::path file = scratch("judged.h5");
    results::ModelHeader model;
    model.bodies = {{"ground", "ground", "", ""}};
    results::Writer writer(file, model);
    writer.begin_run("run", {{"x", "m", ""}}, {});
    for (const double t : {0.0, 1.0}) {
      results::Row row;
      row.time = t;
      row.quantities = Eigen::VectorXd::Constant(1, t);
      writer.append(row);
    }
    writer.end_run(true, "", R"({"steps": 3, "estimate": )" + estimate + "}");
    writer.close();
    const auto [text, code] =
        run_program(std::string(FLEXURA_BIN_DIR) + "/flexura view --summary " + file.string());
    EXPECT_EQ(code, 0) << text;
    const auto at = text.find("estimated error, at least");
    return at == std::string::npos ? text : text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_THAT(told(R"({"at_least": 0.0, "error": null})"), ::testing::EndsWith(" unknown"));
  EXPECT_THAT(told(R"({"at_least": 0.021, "error": null})"), ::testing::EndsWith(" 2.1 %"));
  EXPECT_THAT(told(R"({"at_least": 0.0, "error": 0.0})"), ::testing::EndsWith(" 0 %"));
}

}  // namespace
}  // namespace flexura::view
