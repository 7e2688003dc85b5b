// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>

#include "mbs/file/read_model.hpp"

/// Markers of the mechanism being read, on bodies that deform too and on those cut into segments.
namespace flexura::mbs {

/// See ReadContext::Undeformed; flexible bodies need not be prepared yet.
std::pair<int, Pose> undeformed_place(const ReadModel& model, int marker);

/// At X in the body, or beside its node (one of a deforming body, or -1); of a beam in segments on the piece
/// that is where it is carried (in the body).
void add_marker(ReadModel& model, int body, const std::string& full_name, const Pose& X, int node,
                const Vector3d& carried_at);

/// Those of [OWNER.marker.*], the frame of whose table is at X_B in the body.
void read_markers(ReadModel& model, const input::Section& s, int body, const Pose& X_B,
                  const std::string& owner, bool deforms, const superelement::Superelement* se = nullptr);

}  // namespace flexura::mbs
