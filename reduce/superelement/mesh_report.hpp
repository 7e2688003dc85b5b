// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "reduce/cms/result/mesh_share.hpp"

/// What the estimate of the mesh's error says, for people and for programs.
namespace flexura::reduce {

/// The mesh's estimate is worth half to twice the truth (docs/mesh_error.md); what is promised has this margin.
constexpr double kMeshMargin = 1.5;
/// That of the greatest stress, likewise measured there.
constexpr double kStressMargin = 2.0;

/// "0.32 %", "50 % or more"
std::string percent_or_more(double error);

nlohmann::json mesh_error_json(const std::optional<MeshShare>& share);

/// "mesh error, estimated: first free frequency 0.3 %, ...", a line each of frequencies and statics and of stress.  `stresses`:
/// whether the superelement keeps them.
std::string mesh_error_text(const std::optional<MeshShare>& share, bool stresses);

/// "; static compliance within 2 %; greatest stress ..." of a verdict.
std::string promised_statics(const MeshShare& share, bool stresses);

/// What to say of a mesh whose estimated error is beyond 20 % in the first frequency or in statics; else empty.
std::string too_coarse(const std::optional<MeshShare>& mesh);

}  // namespace flexura::reduce
