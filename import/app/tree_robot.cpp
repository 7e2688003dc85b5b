// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/tree_robot.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "import/app/try_run.hpp"
#include "import/mjcf/convert.hpp"
#include "import/sdf/convert.hpp"
#include "import/urdf/link_parts.hpp"
#include "import/xml/node.hpp"

namespace flexura::import {

std::optional<TreeFormat> tree_format(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  if (ending == ".mjcf") return TreeFormat::mjcf;
  if (ending == ".sdf" || ending == ".world") return TreeFormat::sdf;
  if (ending != ".xml") return {};
  const std::string root = xml::read(file, "MJCF or SDF").tag;
  if (root == "sdf" || root == "gazebo") return TreeFormat::sdf;
  if (root == "robot") return {};
  return TreeFormat::mjcf;
}

ReadRobot read_tree(const std::filesystem::path& file, TreeFormat format, const TreeChoices& choices,
                    bool strict) {
  if (format == TreeFormat::mjcf && choices.floating_base)
    throw std::invalid_argument(
        file.string() + ": --base is for robots whose file leaves it open; an MJCF does not, leave it out");
  ReadRobot out{.findings = Findings(file, strict)};
  Findings& findings = out.findings;
  if (format == TreeFormat::mjcf)
    out.mechanism = mjcf::to_mechanism(file, {.stops = choices.stops}, findings);
  else
    out.mechanism = sdf::to_mechanism(file,
                                      {.floating = choices.floating_base.value_or(true),
                                       .stops = choices.stops,
                                       .packages = choices.packages},
                                      findings);
  out.texts = urdf::link_parts(out.mechanism, findings);
  tell(findings, out.mechanism);
  require_run(out.mechanism);
  return out;
}

}  // namespace flexura::import
