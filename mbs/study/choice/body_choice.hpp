// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/study/choice/screening.hpp"

namespace flexura::study {

/// What a body whose fidelity is chosen is to be, in the words of a mechanism file and in a user's.
struct BodyChoice {
  bool rigid = true, stiffened = false;
  Candidate candidate;
  int available = 0;     ///< deformations of its superelement
  bool is_beam = false;  ///< of the mechanism file: it may be geometrically exact
  bool exact = false;    ///< a beam that is
  int elements = 0;      ///< of that; 0: as many as the file gives
  /// Without geometric stiffening: what that may change of the outputs, so much that the run's shadows are to have it.
  bool stiffening_counts = false;
  std::string reason;  ///< why

  mbs::BodyModel model() const;
  /// "rod: modal, 4 of 22 modes".
  std::string what(const std::string& body) const;
  /// The same with the reason.
  std::string text(const std::string& body) const;
  /// False where nothing is left to add.
  bool can_be_refined() const {
    return !exact && (rigid || !candidate.all || (stiffening_counts && !stiffened));
  }
  /// More of it, where it can be refined.
  void refine();
  /// Sets the reason: what the screening saw, with `share` [1] of the accuracy for this body.
  void explain(const Screened& screened, double share);
  /// Makes a beam geometrically exact.
  void make_exact(const std::string& why);
};

}  // namespace flexura::study
