// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Report pages: what is given stands in the HTML, without a script; plots put points where their axes say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "mbs/view/html/html.hpp"
#include "mbs/view/reports/reduction_report.hpp"
#include "mbs/view/reports/svg_plot.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::scratch;
using testing::slurp;

Report sample() {
  Report report{
      .title = "engine · study", .summary = "Speed against accuracy.", .created_by = "flexura tests"};
  report.facts = {{"runs", "3"}};
  report.add("Runs").add(ReportTable{.title = "All runs",
                                     .columns = {{"run"}, {"wall time", "s"}, {"error"}},
                                     .rows = {{"rigid", 0.02, {1.25e-1, Tone::bad}},
                                              {"modal", 0.3125, 2.0e-4},
                                              {"dash", NAN, {"none", Tone::good}}}});
  report.add("Curves")
      .add(ReportText{"One paragraph.\n\nAnother."})
      .add(ReportNotice{Tone::warning, "careful"})
      .add(ReportPlot{.title = "Error",
                      .x = {"wall time", "s", true},
                      .y = {"error", "1", true},
                      .curves = {{.name = "IDA",
                                  .x = {0.01, 0.1, 1.0},
                                  .y = {1e-2, 1e-3, 1e-4},
                                  .style = CurveStyle::line_and_points,
                                  .labels = {"a", "b", "c"}}}});
  return report;
}

TEST(ReportFigures, HaveTheDigitsAskedForAndPowersOfTenBeyond) {
  EXPECT_EQ(figure_text(0.31250, 5), "0.3125");
  EXPECT_EQ(figure_text(79995, 5), "79\u2009995");
  EXPECT_EQ(figure_text(1234.56, 5), "1234.6");
  EXPECT_EQ(figure_text(-2.0e-4, 3), "\u22122·10\u207b\u2074");
  EXPECT_EQ(figure_text(999999.7, 5), "1·10\u2076");  // rounds up into the next power
  EXPECT_EQ(figure_text(0.00099999, 3), "0.001");
  EXPECT_EQ(figure_text(0.0, 3), "0");
  EXPECT_EQ(figure_text(NAN, 3), "\u2013");
  EXPECT_EQ(sentence_html("within 1.07e-05 % & 2.5e+10, not 1e-7"),
            "within 1.07\u00b710\u207b\u2075 % &amp; 2.5\u00b710\u00b9\u2070, not 1e-7");
  EXPECT_EQ(unit_text("kg*m^2"), "kg·m²");
}

TEST(ReportTicks, AreRoundNumbersInsideTheRange) {
  EXPECT_EQ(axis_ticks(0.0, 1.0, false), (std::vector<double>{0.0, 0.2, 0.4, 2 * 0.2 + 0.2, 0.8, 1.0}));
  EXPECT_EQ(axis_ticks(1e-3, 1e3, true).size(), 7u);
  for (const auto& [low, high] : {std::pair{-3.7, 11.2}, {1e-9, 1.3e-9}, {9.1e5, 4e6}, {-1.0, -0.999}}) {
    const auto ticks = axis_ticks(low, high, false);
    EXPECT_GE(ticks.size(), 3u);
    EXPECT_LE(ticks.size(), 8u);
    for (const double tick : ticks) {
      EXPECT_GE(tick, low - 1e-9 * (high - low));
      EXPECT_LE(tick, high + 1e-9 * (high - low));
    }
  }
  for (const auto& [low, high] : {std::pair{3.0, 50.0}, {0.02, 0.04}, {1e-12, 1e9}}) {
    const auto ticks = axis_ticks(low, high, true);
    EXPECT_GE(ticks.size(), 2u);
    EXPECT_LE(ticks.size(), 9u);
  }
}

TEST(ReportPage, ShowsTablesTextAndFactsWithoutAScript) {
  const auto html = scratch("report.html");
  write_report_page(html, sample());
  std::string text = slurp(html);
  for (const std::string tag : {"script", "style"}) {  // by hand: std::regex recurses once for each character
    for (std::size_t from; (from = text.find('<' + tag)) != std::string::npos;) {
      const std::size_t to = text.find("</" + tag + '>', from);
      ASSERT_NE(to, std::string::npos) << tag;
      text.erase(from, to + tag.size() + 3 - from);
    }
  }
  EXPECT_THAT(text, HasSubstr("<h1>engine · study</h1>"));
  EXPECT_THAT(text, HasSubstr("<dt>runs</dt><dd>3</dd>"));
  EXPECT_THAT(text, HasSubstr("<th scope=\"col\" class=\"number\">wall time <small>[s]</small></th>"));
  EXPECT_THAT(text, HasSubstr("<td class=\"number\" data-value=\"0.3125\">0.3125</td>"));
  EXPECT_THAT(text, HasSubstr("aria-label=\"failed\""));  // said, not only coloured
  EXPECT_THAT(text, HasSubstr("<p>One paragraph.</p><p>Another.</p>"));
  EXPECT_THAT(text, HasSubstr("<td class=\"number\">\u2013</td>"));
  // Every element that opens closes: the page is well formed where a browser would guess.
  for (const char* tag : {"section", "table", "tr", "td", "figure", "main", "div", "svg", "nav"}) {
    const auto count = [&](const std::string& pattern) {
      const std::regex regex(pattern);
      return std::distance(std::sregex_iterator(text.begin(), text.end(), regex), std::sregex_iterator());
    };
    EXPECT_EQ(count(std::string("<") + tag + "[ >]"), count(std::string("</") + tag + ">")) << tag;
  }
}

TEST(ReportPage, PutsPointsWhereTheAxesSay) {
  const std::string svg = svg_plot(std::get<ReportPlot>(sample().sections[1].blocks[2]));
  std::smatch frame, x, y;
  ASSERT_TRUE(std::regex_search(svg, frame, std::regex("data-frame=\"(\\S+) (\\S+) (\\S+) (\\S+)\"")));
  ASSERT_TRUE(std::regex_search(svg, x, std::regex("data-x=\"(\\S+) (\\S+) log\"")));
  ASSERT_TRUE(std::regex_search(svg, y, std::regex("data-y=\"(\\S+) (\\S+) log\"")));
  const auto number = [](const std::smatch& m, std::size_t i) { return std::stod(m[i]); };
  const std::regex circle("cx=\"(\\S+)\" cy=\"(\\S+)\"");
  auto found = std::sregex_iterator(svg.begin(), svg.end(), circle);
  const double values[][2] = {{0.01, 1e-2}, {0.1, 1e-3}, {1.0, 1e-4}};
  for (const auto& [vx, vy] : values) {
    ASSERT_NE(found, std::sregex_iterator());
    const double px = number(frame, 1) + (number(frame, 3) - number(frame, 1)) * std::log(vx / number(x, 1)) /
                                             std::log(number(x, 2) / number(x, 1));
    const double py = number(frame, 4) + (number(frame, 2) - number(frame, 4)) * std::log(vy / number(y, 1)) /
                                             std::log(number(y, 2) / number(y, 1));
    // Printed to a tenth of a user unit.
    EXPECT_NEAR(std::stod((*found)[1]), px, 0.051);
    EXPECT_NEAR(std::stod((*found)[2]), py, 0.051);
    ++found;
  }
}

// Six points in one place: four labels have room around it, each once; the fifth and sixth do not.
TEST(ReportPage, LabelsDoNotLieOverOneAnother) {
  ReportPlot plot{.title = "t", .note = {}, .x = {"x"}, .y = {"y"}, .curves = {}};
  plot.curves = {{.name = "c",
                  .x = {0, 1, 1, 1, 1, 1, 1, 2},
                  .y = {0, 1, 1, 1, 1, 1, 1, 2},
                  .style = CurveStyle::points,
                  .labels = {"low", "a", "b", "c", "d", "e", "f", "high"}}};
  const std::string svg = svg_plot(plot);
  const auto has = [&](const std::string& label) {
    return svg.find(">" + label + "</text>") != std::string::npos;
  };
  for (const char* label : {"low", "a", "b", "c", "d", "high"}) EXPECT_TRUE(has(label)) << label;
  for (const char* label : {"e", "f"}) EXPECT_FALSE(has(label)) << label;
  EXPECT_THAT(svg, HasSubstr("f · c: "));  // in the title of its mark
}

// To the right of a point in the middle of a rising curve, the curve itself would run through the words: they
// stand left above.
TEST(ReportPage, LabelsStandOffCurvesAndMarks) {
  ReportPlot plot{.title = "t", .note = {}, .x = {"x"}, .y = {"y"}, .curves = {}};
  plot.curves = {{.name = "c",
                  .x = {0, 1, 2},
                  .y = {0, 1, 2},
                  .style = CurveStyle::line_and_points,
                  .labels = {"", "here", ""}}};
  const std::string svg = svg_plot(plot);
  const auto label = svg.find(">here</text>");
  ASSERT_NE(label, std::string::npos);
  const std::string tag = svg.substr(svg.rfind('<', label), label - svg.rfind('<', label));
  EXPECT_THAT(tag, HasSubstr("text-anchor=\"end\""));
  EXPECT_GT(label, svg.rfind("class=\"mark"));  // on top of everything
  // The legend shows what is drawn: here a line and a mark.
  const std::string key = svg_key(plot.curves[0], 0);
  EXPECT_THAT(key, HasSubstr("class=\"curve"));
  EXPECT_THAT(key, HasSubstr("class=\"mark"));
  plot.curves[0].style = CurveStyle::points;
  EXPECT_THAT(svg_key(plot.curves[0], 0), Not(HasSubstr("class=\"curve")));
}

TEST(ReportPage, LongCurvesKeepTheirPeaks) {
  ReportPlot plot{.title = "long", .x = {"t"}, .y = {"y"}, .curves = {{.name = "y", .x = {}, .y = {}}}};
  for (int i = 0; i < 200000; ++i) {
    plot.curves[0].x.push_back(i);
    plot.curves[0].y.push_back(i == 123456 ? 1.0 : 0.0);
  }
  const std::string svg = svg_plot(plot);
  EXPECT_LT(svg.size(), 120000u);
  // The frame's top is y = 12 at 1.06: the peak at 1 stands 0.06 / 1.12 of 270 below it.
  EXPECT_THAT(svg, HasSubstr(" 26.5"));
}

TEST(ReportPage, NamesCannotBreakOutOfTheirPlace) {
  Report report = sample();
  report.title = "</style></title><script>alert(1)</script>";
  std::get<ReportPlot>(report.sections[1].blocks[2]).curves[0].name = "</script><script>alert(2)</script>\"";
  const auto html = scratch("report_names.html");
  write_report_page(html, report);
  EXPECT_THAT(slurp(html), Not(HasSubstr("<script>alert")));
}

TEST(ReportPage, RefusesRowsAndCurvesThatDoNotFitAndLeavesNoFile) {
  const auto html = scratch("report_bad.html");
  const auto refusal = [&](const Report& report) {
    try {
      write_report_page(html, report);
    } catch (const std::invalid_argument& failure) {
      return std::string(failure.what());
    }
    return std::string("accepted");
  };
  Report report = sample();
  std::get<ReportTable>(report.sections[0].blocks[0]).rows[1].pop_back();
  EXPECT_THAT(refusal(report), HasSubstr("section 'Runs', block 1: row 2 of table 'All runs' has 2 cells"));
  report = sample();
  std::get<ReportPlot>(report.sections[1].blocks[2]).curves[0].x.pop_back();
  EXPECT_THAT(refusal(report), HasSubstr("curve 'IDA' of plot 'Error' has 2 values of x, 3 of y"));
  EXPECT_FALSE(std::filesystem::exists(html));
  EXPECT_FALSE(std::filesystem::exists(html.string() + ".part"));
}

TEST(ReportJson, ReadsEveryBlockAndNamesThePlaceOfAFault) {
  const json given =
      json::parse(R"({"title": "t", "facts": [["a", "b"]], "sections": [{"title": "s", "blocks": [
      {"text": "words"}, {"notice": "look", "tone": "bad"}, {"code": {"text": "x = 1"}},
      {"table": {"columns": ["n", {"name": "f", "unit": "Hz", "digits": 3}],
                 "rows": [["one", 1.5], [null, {"value": 2, "tone": "good"}]]}},
      {"plot": {"title": "p", "x": {"name": "x"}, "y": {"name": "y", "logarithmic": true},
                "curves": [{"name": "c", "x": [1, 2], "y": [3, null], "style": "points"}]}}]}]})");
  const Report report = report_from_json(given);
  const auto& blocks = report.sections.at(0).blocks;
  ASSERT_EQ(blocks.size(), 5u);
  EXPECT_EQ(std::get<ReportNotice>(blocks[1]).tone, Tone::bad);
  const auto& table = std::get<ReportTable>(blocks[3]);
  EXPECT_EQ(table.columns[1].digits, 3);
  EXPECT_EQ(table.rows[1][1].value, 2.0);
  EXPECT_EQ(table.rows[1][1].tone, Tone::good);
  const auto& plot = std::get<ReportPlot>(blocks[4]);
  EXPECT_TRUE(plot.y.logarithmic);
  EXPECT_TRUE(std::isnan(plot.curves[0].y[1]));
  write_report_page(scratch("report_json.html"), report);

  json bad = given;
  bad["sections"][0]["blocks"][4]["plot"]["curves"][0]["y"][0] = "three";
  try {
    report_from_json(bad);
    FAIL();
  } catch (const std::invalid_argument& failure) {
    EXPECT_THAT(failure.what(),
                HasSubstr("JSON.sections[0].blocks[4].plot.curves[0].y[0] must be a number or null"));
  }
  EXPECT_THROW(report_from_json(json::parse(R"({"sections": []})")), std::invalid_argument);
}

TEST(ReductionReport, ShowsTheBodyItsInterfacesAndWhateverTheReductionTold) {
  auto se = synthetic::tube(16, 10, 4);
  se.omega2 = Eigen::Vector4d(1e6, 2e6, 3e6, 4e6);
  se.report_json = R"({"mesh": {"nodes": 1234}, "notes": ["one note"], "seconds": 3.5,
      "checks": [{"check": "rigid motions", "value": 1e-13, "bound": 1e-9, "passed": true},
                 {"check": "mass", "value": 0.5, "bound": 1e-9, "passed": false}],
      "reduction": {"dofs": 5000, "seconds": {"assembly": 1.0, "factor": 3.0}}, "novelty": {"depth": 7}, "mode_set": "craig_bampton", "cad_mass": 2.5,
      "inertia": [17.5], "mesh_of": {"centroid": [0.25, 1e-17], "volume": 0.125}})";
  const Report report = reduction_report(se);
  const auto html = scratch("reduction.html");
  write_report_page(html, report);
  const std::string text = slurp(html);
  for (const char* word :
       {"one note", "1234", "rigid motions", "right end", "Novelty", "<dt>depth</dt><dd>7</dd>",
        "<dt>mode set</dt><dd>Craig-Bampton</dd>", "<dt>mass from CAD</dt><dd>2.5 kg</dd>",
        "<dt>centre of the mesh</dt><dd>250, 0 mm</dd>", "<dd>125\u2009000 cm³</dd>",
        "data:image/png;base64,"}) {
    EXPECT_THAT(text, HasSubstr(word));
  }
  EXPECT_THAT(text, Not(HasSubstr("17.5")));           // the body's own figures stand there already
  EXPECT_THAT(text, HasSubstr("<td class=\"bad\">"));  // mass: passed is false
  EXPECT_THAT(text, HasSubstr("data-value=\"75\""));   // factor: 3 s of 4 s
  EXPECT_THAT(text, HasSubstr(figure_text(1000.0 / (2 * M_PI), 4).substr(0, 4)));  // first frequency
  // What --report wrote, without the superelement.
  json told = json::parse(se.report_json);
  EXPECT_FALSE(is_told_by_reduction(told));
  told["part"] = "tube";
  told["mass"] = 2.5;
  told["centre"] = {0.25, 1e-9, 0.0};
  told["reduction"]["fixed_interface_frequencies_hz"] = {123.5, 234.5};
  told["mesh_error"] = {
      {"by", "enrichment"},
      {"modes", {{{"hz", 100.0}, {"frequency_error", 0.0125}, {"peak_stress_at", nullptr}}}}};
  told["reduction"]["processor_seconds"] = {{"factorisation", 1.5}, {"mesh_error", 0.5}};
  ASSERT_TRUE(is_told_by_reduction(told));
  write_report_page(html, reduction_report(told));
  const std::string alone = slurp(html);
  for (const char* word :
       {"tube", "one note", "<dd>250, 0, 0 mm</dd>", "error of the frequency <small>[%]</small>",
        "data-value=\"1.25\"", "frequency <small>[Hz]</small>", "123.5", "Processor time"})
    EXPECT_THAT(alone, HasSubstr(word));
  EXPECT_THAT(alone, Not(HasSubstr("50 %")));                // half a second of the mesh's error is no error
  EXPECT_THAT(alone, Not(HasSubstr("greatest stress at")));  // nothing is known of it in any row
  se.report_json = "not JSON";
  write_report_page(html, reduction_report(se));  // an old or foreign file still has a report
}

}  // namespace
}  // namespace flexura::view
