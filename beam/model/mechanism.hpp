// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "beam/model/model.hpp"

namespace flexura::beam {

/// A motion that releases leave, other than that of the whole structure, which strains no member: a sentence with the node that
/// moves most and its direction; empty where there is none.  Throws std::invalid_argument where a member moves so by itself.
///
/// One element for each member (its end stiffness is exact), one node of each part held
/// (anchors, where it has any).  The softest
/// displacement z of K comes from inverse iteration; whether it strains anything is judged member by member
/// from its stretch H z, where round-off is eps^2 of the energy, not from K, where it is eps.  The bound is
/// 1e-17 of the energy that z's components would have one by one: a chain of n members has 1/n^4 in its
/// softest motion, so chains up to 10,000 members pass, and hinges are found in chains up to 3,000 members
/// (tested).
std::string mechanism_of(const Model& model);

}  // namespace flexura::beam
