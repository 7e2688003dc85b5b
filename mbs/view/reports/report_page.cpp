// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/view/html/html.hpp"
#include "mbs/view/html/html_file.hpp"
#include "mbs/view/html/resources.hpp"
#include "mbs/view/reports/report.hpp"
#include "mbs/view/reports/svg_plot.hpp"

namespace flexura::view {

namespace {

const char* tone_name(Tone tone) {
  switch (tone) {
    case Tone::good:
      return "good";
    case Tone::warning:
      return "warning";
    case Tone::bad:
      return "bad";
    default:
      return "plain";
  }
}

/// Spoken and printed beside the colour.
const char* tone_mark(Tone tone) {
  switch (tone) {
    case Tone::good:
      return "<span class=\"sign\" role=\"img\" aria-label=\"good\">✓</span> ";
    case Tone::warning:
      return "<span class=\"sign\" role=\"img\" aria-label=\"warning\">▲</span> ";
    case Tone::bad:
      return "<span class=\"sign\" role=\"img\" aria-label=\"failed\">✗</span> ";
    default:
      return "";
  }
}

void require_fit(const ReportTable& table, const std::string& place) {
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].size() != table.columns.size()) {
      throw std::invalid_argument(
          fmt::format("{}: row {} of table '{}' has {} cells, but the table has {} columns", place, i + 1,
                      table.title, table.rows[i].size(), table.columns.size()));
    }
  }
}

void require_fit(const ReportPlot& plot, const std::string& place) {
  for (const ReportCurve& curve : plot.curves) {
    if (curve.x.size() != curve.y.size() ||
        (!curve.labels.empty() && curve.labels.size() != curve.x.size())) {
      throw std::invalid_argument(
          fmt::format("{}: curve '{}' of plot '{}' has {} values of x, {} of y and {} labels; they must be "
                      "equally many (or no "
                      "labels)",
                      place, curve.name, plot.title, curve.x.size(), curve.y.size(), curve.labels.size()));
    }
  }
}

class ReportWriter {
 public:
  ReportWriter(const std::filesystem::path& html, const Report& report)
      : report_(report), file_(html, report.title, report_style()) {}

  void write() {
    put_bar();
    file_.put("<div class=\"report\">");
    put_contents();
    file_.put("<main>");
    if (!report_.summary.empty()) file_.put("<p class=\"lead\">" + sentence_html(report_.summary) + "</p>");
    if (!report_.facts.empty()) put(ReportFacts{report_.facts});
    for (std::size_t i = 0; i < report_.sections.size(); ++i) {
      const ReportSection& section = report_.sections[i];
      file_.put(fmt::format(
          "<section id=\"section-{0}\" aria-labelledby=\"heading-{0}\"><h2 id=\"heading-{0}\">{1}</h2>",
          i + 1, escape_html(section.title)));
      for (std::size_t j = 0; j < section.blocks.size(); ++j) {
        place_ = fmt::format("report '{}', section '{}', block {}", report_.title, section.title, j + 1);
        std::visit([&](const auto& block) { put(block); }, section.blocks[j]);
      }
      file_.put("</section>\n");
    }
    file_.put("</main></div>");
    if (!report_.created_by.empty()) {
      file_.put("<footer class=\"foot\">Written by " + escape_html(report_.created_by) + ".</footer>\n");
    }
    file_.finish(report_script());
  }

 private:
  void put_bar() {
    file_.put(
        "<header class=\"bar\"><span class=\"brand\"><svg viewBox=\"0 0 32 32\" width=\"26\" height=\"26\" "
        "aria-hidden=\"true\"><rect width=\"32\" height=\"32\" rx=\"8\" fill=\"var(--accent)\"/><path d=\"M6 "
        "21c5 0 6-11 11-11s5 7 9 7\" fill=\"none\" stroke=\"#fff\" stroke-width=\"2.6\" "
        "stroke-linecap=\"round\"/><circle cx=\"6\" cy=\"21\" r=\"2.4\" fill=\"#fff\"/><circle cx=\"26\" "
        "cy=\"17\" r=\"2.4\" fill=\"#fff\"/></svg><span>Flexura</span></span><h1>");
    file_.put(escape_html(report_.title));
    file_.put("</h1><div class=\"bar-buttons\"></div></header>\n");
  }

  void put_contents() {
    if (report_.sections.size() < 2) return;
    file_.put("<nav aria-label=\"Contents\"><ol>");
    for (std::size_t i = 0; i < report_.sections.size(); ++i) {
      file_.put(fmt::format("<li><a href=\"#section-{}\">{}</a></li>", i + 1,
                            escape_html(report_.sections[i].title)));
    }
    file_.put("</ol></nav>");
  }

  void put(const ReportText& block) {
    for (std::size_t from = 0; from < block.text.size();) {
      const std::size_t to = std::min(block.text.find("\n\n", from), block.text.size());
      if (to > from) file_.put("<p>" + sentence_html(block.text.substr(from, to - from)) + "</p>");
      from = to + 2;
    }
  }

  void put(const ReportNotice& block) {
    file_.put(fmt::format("<p class=\"notice {}\">{}<span>{}</span></p>", tone_name(block.tone),
                          tone_mark(block.tone), sentence_html(block.text)));
  }

  void put(const ReportFacts& block) {
    file_.put("<dl class=\"fact-list\">");
    for (const auto& [name, value] : block.facts) {
      file_.put(fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", escape_html(name), sentence_html(value)));
    }
    file_.put("</dl>");
  }

  void put(const ReportDrawing& block) {
    file_.put(fmt::format("<figure class=\"card drawing\"><h3>{}</h3>", escape_html(block.title)));
    file_.put(block.svg);
    put_note(block.note);
    file_.put("</figure>\n");
  }

  void put(const ReportCode& block) {
    file_.put(fmt::format(
        "<details class=\"card code\"><summary>{}</summary><pre tabindex=\"0\">{}</pre></details>\n",
        escape_html(block.title), escape_html(block.text)));
  }

  void put(const ReportTable& block) {
    require_fit(block, place_);
    file_.put("<figure class=\"card\"><div class=\"table-box\" tabindex=\"0\"><table class=\"data\">");
    if (!block.title.empty()) file_.put("<caption>" + escape_html(block.title) + "</caption>");
    file_.put("<thead><tr>");
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const ReportColumn& column = block.columns[c];
      file_.put(fmt::format(
          "<th scope=\"col\"{}>{}{}</th>", is_numeric(block, c) ? " class=\"number\"" : "",
          escape_html(column.name),
          column.unit.empty() ? "" : fmt::format(" <small>[{}]</small>", unit_text(column.unit))));
    }
    file_.put("</tr></thead><tbody>");
    for (const auto& row : block.rows) {
      file_.put("<tr>");
      for (std::size_t c = 0; c < row.size(); ++c) {
        const ReportCell& cell = row[c];
        std::string classes = cell.is_number ? "number" : "";
        if (cell.tone != Tone::plain)
          classes += std::string(classes.empty() ? "" : " ") + tone_name(cell.tone);
        file_.put("<td");
        if (!classes.empty()) file_.put(fmt::format(" class=\"{}\"", classes));
        if (cell.is_number && std::isfinite(cell.value))
          file_.put(fmt::format(" data-value=\"{}\"", cell.value));
        file_.put(fmt::format(
            ">{}{}</td>", tone_mark(cell.tone),
            cell.is_number ? figure_text(cell.value, block.columns[c].digits) : escape_html(cell.text)));
      }
      file_.put("</tr>");
    }
    file_.put("</tbody></table></div>");
    put_note(block.note);
    file_.put("</figure>\n");
  }

  static bool is_numeric(const ReportTable& table, std::size_t column) {
    for (const auto& row : table.rows) {
      if (row[column].is_number) return true;
    }
    return false;
  }

  void put(const ReportPlot& block) {
    require_fit(block, place_);
    file_.put(fmt::format("<figure class=\"card plot-card\"><h3>{}</h3>", escape_html(block.title)));
    file_.put(svg_plot(block));
    if (block.curves.size() > 1) {
      file_.put("<ul class=\"plot-legend\">");
      for (std::size_t i = 0; i < block.curves.size(); ++i) {
        file_.put(
            fmt::format("<li>{}{}</li>", svg_key(block.curves[i], i), escape_html(block.curves[i].name)));
      }
      file_.put("</ul>");
    }
    put_note(block.note);
    file_.put("<script type=\"application/json\" class=\"plot-data\">");
    file_.put(escape_script(plot_json(block).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
    file_.put("</script></figure>\n");
  }

  /// What the script needs for the pointer, the table of numbers and CSV; NaN becomes null.
  static nlohmann::json plot_json(const ReportPlot& plot) {
    const auto heading = [](const ReportAxis& axis) {
      return axis.unit.empty() ? axis.name : fmt::format("{} [{}]", axis.name, axis.unit);
    };
    nlohmann::json curves = nlohmann::json::array();
    for (const ReportCurve& curve : plot.curves) {
      curves.push_back({{"name", curve.name}, {"x", curve.x}, {"y", curve.y}, {"labels", curve.labels}});
    }
    return {{"title", plot.title}, {"x", heading(plot.x)}, {"y", heading(plot.y)}, {"curves", curves}};
  }

  void put_note(const std::string& note) {
    if (!note.empty()) file_.put("<figcaption>" + sentence_html(note) + "</figcaption>");
  }

  const Report& report_;
  HtmlFile file_;
  std::string place_;
};

}  // namespace

void write_report_page(const std::filesystem::path& html, const Report& report) {
  ReportWriter(html, report).write();
}

}  // namespace flexura::view
