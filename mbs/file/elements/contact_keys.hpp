// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/base/documents/schema.hpp"
#include "mbs/file/elements/read_context.hpp"
#include "mbs/forces/contacts/contact_law.hpp"

/// The keys of contact_law.hpp that elements share, and their readers.
namespace flexura::mbs {

/// Stiffness, exponent, and impact_keys().
std::vector<input::Key> contact_law_keys();
ContactLaw read_contact_law(const input::Section& s, const ReadContext& context);

/// What an impact loses: damping, or restitution and slowest_impact.
std::vector<input::Key> impact_keys();
ContactLaw read_impact(const input::Section& s, const ReadContext& context, double stiffness,
                       double exponent);

}  // namespace flexura::mbs
