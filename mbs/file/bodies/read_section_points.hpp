// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mbs/bodies/section_points.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {

/// [body.NAME.section_point.NAME].
input::TableSchema section_point_table();

/// True where a body's table asks for section forces.
bool wants_sections(const input::Section& s);

/// The section forces its table asks for; `se` with those.  Adds a note where the superelement knows only part of them.
/// `nodes`: of the body, interfaces first; empty where loads act on it beside them.  Throws InputError.
std::shared_ptr<const SectionPoints> read_section_points(const input::Section& s,
                                                         const superelement::Superelement& se,
                                                         const ModalData& body,
                                                         const std::vector<BodyNode>& nodes,
                                                         std::vector<std::string>& notes);

}  // namespace flexura::mbs
