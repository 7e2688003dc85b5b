// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/study/study_file.hpp"

/// The part of a study file that compares designs: what is to be least or greatest.
namespace flexura::study {

/// The keys of [want] for it.
std::vector<input::Key> goal_keys();

/// Reads them.  Throws input::InputError for a label that no quantity has, and where errors are asked for beside goals.
void read_goals(const input::Section& root, const input::Section& want, StudyFile& study);

}  // namespace flexura::study
