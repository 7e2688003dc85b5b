// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/flexdata_text.hpp"

/// What the format has no place for (inertia integrals, names, what a load does to the body as a rigid one), in a comment of our own
/// that other programs pass over.  Words and numbers in SI, matrices column by column; names as in addresses, "%20" for a blank.
namespace flexura::superelement::flexdata {

/// The comment, of `loads` those whose resultant is known.
std::string comment_of(const FlexDataBody& body, const std::vector<FlexData::LoadLine>& loads);

/// What the comment within `element` of `text` (with its comments) says; nothing where there is none, as in the files of other
/// programs.  Completes the load cases that it names.  Throws std::invalid_argument, "file:line: what".
std::optional<FlexDataBody> body_in_comment(const Text& text, const Element& element, int n_nodes,
                                            int n_modes, std::vector<FlexData::LoadLine>& loads);

}  // namespace flexura::superelement::flexdata
