// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/range/linear_range.hpp"

#include <gmock/gmock.h>

#include "mbs/bodies/modal_body.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

namespace flexura::mbs {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A cantilever L = m = EI = 1 under a force F at its tip: the linear deflection F L^3 / 3 EI, the slope
// F L^2 / 2 EI.
TEST(LinearRange, TellsTheSlopeOfACantileverAndWhatItCosts) {
  beams::StraightBeam b;
  b.EA = 1e4;
  b.GI_t = 10.0;
  b.elements = 8;
  const superelement::Superelement se = beams::beam_superelement(b);
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  MechanismDescription d;
  d.gravity.setZero();
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
  const Mechanism m(d);
  const FlexibleBody& beam = *m.description().bodies[body].flexible;
  const auto sentences = [&](double force) {
    State s = m.initial_state();
    // All modes are there, so the static answer is the beam's.
    s.p.segment(m.modal_position(body), beam.m()) =
        force * beam.modal()->nodes[1].Phi_t.row(1).transpose().cwiseQuotient(beam.modal()->stiffness);
    LinearRange range(m);
    range.observe(m.initial_state());
    range.observe(s);
    return range.sentences();
  };
  // The tip stands F / 3 off and is turned by F / 2: limits are 0.1 of the length and 0.1745 rad.
  EXPECT_TRUE(sentences(0.29).empty());
  const auto displaced = sentences(0.32);
  ASSERT_EQ(displaced.size(), 1u);
  // 3/5 (d / l)^2 = 0.6 * 0.1067^2.
  EXPECT_THAT(displaced[0], AllOf(HasSubstr("is displaced by 0.107 m against"), HasSubstr("about 0.68 %")));
  const auto told = sentences(0.8);
  ASSERT_EQ(told.size(), 1u);
  // 0.4 rad = 22.9 deg; a displacement linear in the modes leaves out 0.4^2 / 2 of the length.
  EXPECT_THAT(told[0], HasSubstr("body \"beam\" leaves the linear range"));
  EXPECT_THAT(told[0], HasSubstr("is turned by 22.9 deg against"));
  EXPECT_THAT(told[0], HasSubstr("about 8 % of its length"));
}

// The hub and the rim of a wheel stand at one place; that they move against each other turns no line between them.
TEST(LinearRange, PlacesAtOnePointAreMeasuredByTheBodysSize) {
  beams::StraightBeam b;
  b.EA = 1e4;
  b.GI_t = 10.0;
  b.elements = 8;
  const superelement::Superelement se = beams::beam_superelement(b);
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  const auto sentences = [&](double offset) {
    ModalData data = modal_data(se, options);
    data.nodes[1].p_BoN_B = data.nodes[0].p_BoN_B + Vector3d(offset, 0.0, 0.0);
    MechanismDescription d;
    d.gravity.setZero();
    const int body = d.add_body({.name = "wheel", .flexible = std::make_shared<ModalBody>(data)});
    d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
    const Mechanism m(d);
    State s = m.initial_state();
    const double force = 0.003;  // the second place moves by F / 3 = 1e-3, a thousandth of the body
    s.p.segment(m.modal_position(body), data.stiffness.size()) =
        force * data.nodes[1].Phi_t.row(1).transpose().cwiseQuotient(data.stiffness);
    LinearRange range(m);
    range.observe(m.initial_state());
    range.observe(s);
    return range.sentences();
  };
  EXPECT_TRUE(sentences(0.0).empty());
  EXPECT_EQ(sentences(5e-3).size(), 1u);  // a fifth of the distance there
}

}  // namespace
}  // namespace flexura::mbs
