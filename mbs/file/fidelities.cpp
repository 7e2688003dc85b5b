// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/fidelities.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/bodies/one_way_body.hpp"

namespace flexura::mbs {
namespace {

using Superelement = Fidelity::OfSuperelement;
using Beam = Fidelity::OfBeam;

template <class Body>
std::shared_ptr<const FlexibleBody> make(ModalData data) {
  return std::make_shared<const Body>(std::move(data));
}

Segments rigid_beam(MechanismDescription& d, int body, const BeamPart& beam) {
  d.bodies[static_cast<std::size_t>(body)].inertia = rigid_inertia(beam);
  return {};
}

Segments ancf_beam(MechanismDescription& d, int body, const BeamPart& beam) {
  d.bodies[static_cast<std::size_t>(body)].inertia = rigid_inertia(beam);  // where its mass is, undeformed
  d.bodies[static_cast<std::size_t>(body)].flexible = ancf_body(beam);
  return {};
}

template <beam::exact::Kind kind>
Segments exact_beam(MechanismDescription& d, int body, const BeamPart& beam) {
  return add_exact_elements(d, body, beam, kind);
}

}  // namespace

const std::vector<Fidelity>& fidelities() {
  static const std::vector<Fidelity> all = {
      {"modal", "deformation in modal coordinates", Superelement{.make = make<ModalBody>}, {}},
      {"modal-stiffened",
       "with geometric stiffening",
       Superelement{.make = make<ModalBody>, .is_stiffened = true},
       {}},
      {"ked",
       "one-way, the motion is that of the rigid body",
       Superelement{.make = make<OneWayBody>, .acts_back = false, .held_by_joints = true},
       {}},
      {"static", "quasi-static", Superelement{.make = make<ModalBody>, .by_loads_alone = true}, {}},
      {"rigid", "without deformation", Superelement{},
       Beam{.make = rigid_beam, .has_elements = false, .use = {.may_be_planar = true}}},
      {"ancf",
       "absolute nodal coordinates for any bending",
       {},
       Beam{.make = ancf_beam,
            .has_elements = true,
            .use = {.ignores_in_plane = {"GA_y", "rho_I_z"}, .may_be_planar = true}}},
      {"beam",
       "geometrically exact, for any bending",
       {},
       Beam{.make = exact_beam<beam::exact::Kind::beam>,
            .has_elements = true,
            .use = {.may_be_curved = true, .may_be_planar = true}}},
      {"rod",
       "the same without stretch and shear",
       {},
       Beam{.make = exact_beam<beam::exact::Kind::rod>,
            .has_elements = true,
            .use = {.ignores = {"EA", "GA_y", "GA_z"}, .may_be_curved = true, .may_be_planar = true}}},
      {"cable",
       "the same with stretch and bending alone",
       {},
       Beam{.make = exact_beam<beam::exact::Kind::cable>,
            .has_elements = true,
            .use = {.ignores = {"GA_y", "GA_z", "GI_t", "EI_y", "EI_z", "rho_I_y", "rho_I_z"},
                    .may_be_curved = true,
                    .may_be_planar = true}}},
      {"segments",
       "rigid segments joined by its stiffness",
       {},
       Beam{.make = add_segments, .has_elements = true}},
  };
  return all;
}

const Fidelity& fidelity_of(const input::Section& s) {
  const std::string word = s.text("fidelity");
  return *std::ranges::find_if(fidelities(), [&](const Fidelity& f) {
    return word == kAutomaticFidelity ? f.of_superelement.has_value() : f.name == word;
  });
}

input::Key fidelity_key() {
  std::vector<std::string> words;
  std::string of_superelement, of_beam;
  for (const Fidelity& f : fidelities()) {
    words.push_back(f.name);
    const auto add = [&](std::string& list) {
      list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", f.name, f.doc);
    };
    if (f.of_superelement)
      add(of_superelement);
    else if (f.of_beam)
      add(of_beam);
  }
  words.push_back(kAutomaticFidelity);
  return input::choice("fidelity", words,
                       fmt::format("of a superelement, and of a beam ([body.NAME.beam]) that bends little: "
                                   "{}; of a beam alone: {}; "
                                   "{}: flexura simulate chooses among rigid, static, modal and "
                                   "modal-stiffened, and the number "
                                   "of modes, of a beam that leaves their range beam with as many elements "
                                   "as it takes, for the "
                                   "run's accuracy (see solver.accuracy; 1 % without it)",
                                   of_superelement, of_beam, kAutomaticFidelity))
      .or_default(fidelities().front().name);
}

}  // namespace flexura::mbs
