// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mbs/bodies/body_node.hpp"

/// Markers that follow several places of a superelement at once: [body.NAME.marker.NAME] with nodes, points
/// or within.
namespace flexura::mbs {

/// Keys of a marker for that.
std::vector<input::Key> linked_marker_keys();

/// The key by which a marker names several nodes (the first of nodes, points and within), null where it has
/// none of them.
const char* linking_key(const input::Section& marker);

/// True where it follows nodes of the surface: the superelement must be read with surface and shapes.
bool follows_surface(const input::Section& marker);
/// True where a marker of the body does.
bool a_marker_follows_surface(const input::Section& body);

/// The node that the marker `name` = "body.marker" sits on.  Without `deforms` its place is all that is
/// needed, and shapes are not.  Notes for the user are appended.  Throws InputError.
BodyNode read_linked_node(const input::Section& marker, const std::string& name,
                          const superelement::Superelement& se, bool deforms,
                          std::vector<std::string>& notes);

}  // namespace flexura::mbs
