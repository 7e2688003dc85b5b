// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesh/gmsh/picture.hpp"
#include "mesh/model/face.hpp"

/// What a part file writes to choose a face as it is shown, so that it stays chosen when the drawing is changed.
namespace flexura::reduce {

/// The numbers of the other faces of a bore or shaft that its file has cut along its axis into several, all of one height.
std::vector<mesh::Index> others_of(const mesh::Face& face, const std::vector<mesh::Face>& faces);

/// The lines of an [interface] that choose this face and its others_of by cylinder (with an extent where bores are in line) or by
/// plane; nothing where these would choose more, or the face is neither.  The same for all faces of one bore.
std::optional<std::string> surface_lines(const mesh::Face& face, const std::vector<mesh::Face>& faces);

/// Of each face: by its surface; else by a point on it, from which every other face is farther away; by its number only where
/// faces lie on one another.
std::vector<std::string> face_lines(const std::vector<mesh::Face>& faces, const mesh::FacesPicture& picture);

}  // namespace flexura::reduce
