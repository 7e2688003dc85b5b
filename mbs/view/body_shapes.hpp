// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace flexura::view {

/// Reads the primitive shapes of a body (PAGE.md lists them) and returns them complete: every default filled
/// in, every axis a unit vector.  "" gives no shapes.  Throws std::invalid_argument, naming body, shape and
/// remedy.
nlohmann::json parse_body_shapes(const std::string& body, const std::string& shape_json);

}  // namespace flexura::view
