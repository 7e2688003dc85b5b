// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "mbs/solver/start/prepare.hpp"

/// What `flexura check` says of the quantities of a mechanism.
namespace flexura::app {

/// Lines no longer than `width`: what each joint, body or element offers, with units; "*" marks what is
/// stored when the file does not say what, "?" what redundant constraints leave open.
std::string quantity_list(const mbs::PreparedMechanism& prepared, std::size_t width);

/// [{"name", "unit", "doc", "is_usual", "is_unique"}, ...], those of a run's account included.
nlohmann::json quantity_json(const mbs::PreparedMechanism& prepared);

}  // namespace flexura::app
