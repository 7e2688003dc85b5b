// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/robot.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "import/app/try_run.hpp"
#include "import/app/xacro.hpp"
#include "import/cad/assembly.hpp"
#include "import/urdf/link_parts.hpp"
#include "import/urdf/templates.hpp"
#include "mbs/view/reports/report.hpp"

namespace flexura::import {
namespace {

// All parts of an assembly where they stand.
Surface surface_of_step(const std::filesystem::path& file) {
  constexpr double limit_s = 60.0;
  const cad::Assembly assembly = cad::read_assembly(file, limit_s);
  Surface surface;
  for (const cad::Instance& i : assembly.instances)
    surface.append(assembly.parts[static_cast<std::size_t>(i.part)].surface, i.X_WP);
  urdf::weld(surface);
  return surface;
}

}  // namespace

ReadRobot read_robot(const std::filesystem::path& file, urdf::Choices choices, bool strict, bool trusted) {
  choices.read_cad = surface_of_step;
  ReadRobot out{.findings = Findings(file, strict)};
  Findings& findings = out.findings;
  std::string text = urdf::read_text(file);
  const urdf::Template looked = urdf::look_through(text, file);
  if (looked.first || (!looked.includes.empty() && has_xacro())) {
    text = expand_xacro(file, choices.packages, trusted);
    findings.note("templates", "expanded by xacro: lines are those of its output");
  }
  out.mechanism = urdf::to_mechanism(urdf::read_robot(text, findings), choices, findings);
  out.texts = urdf::link_parts(out.mechanism, findings);
  tell(findings, out.mechanism);
  require_run(out.mechanism);
  return out;
}

void write_robot_page(const std::filesystem::path& file, const ReadRobot& robot) {
  const Mechanism& m = robot.mechanism;
  double mass = 0.0;
  for (const Body& body : m.bodies) mass += body.mass;
  view::Report page{.title = m.name + " · import", .summary = m.note_count, .created_by = "flexura import"};
  page.facts = {{"file", robot.findings.file().filename().string()},
                {"bodies", fmt::format("{}", m.bodies.size())},
                {"mass", fmt::format("{:.6g} kg", mass)}};
  if (!robot.findings.kinds().empty()) {
    view::ReportTable notes{.columns = {{"kind"}, {"note"}}};
    for (const auto& [kind, texts] : robot.findings.kinds())
      for (const std::string& text : texts) notes.rows.push_back({kind, text});
    page.add("Notes").add(notes);
  }
  if (!m.renamed.empty()) {
    view::ReportTable names{.columns = {{"of the file"}, {"name here"}}};
    for (const auto& [theirs, ours] : m.renamed) names.rows.push_back({theirs, ours});
    page.add("Names").add(names);
  }
  view::ReportTable bodies{
      .columns = {{"body"}, {"mass", "kg"}, {"I_1", "kg m^2"}, {"I_2", "kg m^2"}, {"I_3", "kg m^2"}}};
  for (const Body& body : m.bodies) {
    const Vector3d I =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues();
    bodies.rows.push_back({body.name, body.mass, I[0], I[1], I[2]});
  }
  page.add("Bodies").add(bodies);
  view::ReportTable joints{.columns = {{"joint"}, {"type"}, {"from"}, {"to"}}};
  const auto plain = [](std::string text) {
    std::erase(text, '"');
    return text;
  };
  for (const Element& e : m.elements)
    if (e.table == "joint" && e.lines.size() >= 3)
      joints.rows.push_back(
          {e.name, plain(e.lines[0].second), plain(e.lines[1].second), plain(e.lines[2].second)});
  page.add("Joints").add(joints);
  view::write_report_page(file, page);
}

}  // namespace flexura::import
