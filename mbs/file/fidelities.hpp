// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/bodies/modal_data.hpp"
#include "mbs/file/bodies/read_beam_part.hpp"
#include "mbs/mechanism/beam_part.hpp"

/// The words of `fidelity`: what a body is modelled as.  A new one is a body of its own (flexible_body.hpp) and one entry
/// in the list of fidelities.cpp; the choice in the file, the manual and the refusals follow from it.
namespace flexura::mbs {

struct Fidelity {
  /// How a superelement becomes the body.
  struct OfSuperelement {
    /// Null: the body is rigid.
    std::function<std::shared_ptr<const FlexibleBody>(ModalData)> make = nullptr;
    bool acts_back = true;      ///< FlexibleBody::acts_back() of what is made
    bool is_stiffened = false;  ///< takes the superelement's stiffening terms
    bool by_loads_alone =
        false;  ///< response modes of what acts on the body, no eigenmodes; critically damped
    bool held_by_joints = false;  ///< without a `frame`, the body's joints hold it and its eigenmodes
    bool deforms() const { return make != nullptr; }
  };
  /// How a beam, [body.NAME.beam], becomes body `body` of the description, which has its place already.
  struct OfBeam {
    /// A chain of further bodies, or none.
    std::function<Segments(MechanismDescription& d, int body, const BeamPart& beam)> make;
    bool
        has_elements;  ///< the number of elements decides how right it is; else it is judged as a superelement is
    BeamUse use = {};
  };

  std::string name;
  std::string doc;  ///< completes "name: "
  std::optional<OfSuperelement> of_superelement;
  std::optional<OfBeam> of_beam;
};

/// All, in the order of the manual.
const std::vector<Fidelity>& fidelities();

/// The word that stands for a choice of the program.
inline constexpr const char* kAutomaticFidelity = "auto";

/// What a body's table asks for: of "auto" modal, until a run chooses.
const Fidelity& fidelity_of(const input::Section& s);

/// The key, with all words.
input::Key fidelity_key();

}  // namespace flexura::mbs
