// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/robot.hpp"

#include "import/app/try_run.hpp"
#include "import/app/xacro.hpp"
#include "import/cad/assembly.hpp"
#include "import/urdf/link_parts.hpp"
#include "import/urdf/templates.hpp"

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
  Findings findings(file, strict);
  std::string text = urdf::read_text(file);
  if (urdf::look_through(text, file).first) {
    text = expand_xacro(file, choices.packages, trusted);
    findings.note("templates", "expanded by xacro: lines are those of its output");
  }
  ReadRobot out;
  out.mechanism = urdf::to_mechanism(urdf::read_robot(text, findings), choices, findings);
  out.texts = urdf::link_parts(out.mechanism, findings);
  tell(findings, out.mechanism);
  require_run(out.mechanism);
  return out;
}

}  // namespace flexura::import
