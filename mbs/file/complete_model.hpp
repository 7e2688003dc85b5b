// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/file/read_model.hpp"

/// What is done to a model after all its files are read.
namespace flexura::mbs {

/// Whether the body's table says where it starts.
bool is_placed(const input::Section& body);

/// Bodies that nothing holds get six freedoms to ground.
void add_free_joints(ReadModel& model);

/// Flexible bodies from their superelements and what acts on them, after everything else is read.
void prepare_bodies(ReadModel& model);

}  // namespace flexura::mbs
