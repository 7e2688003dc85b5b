// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/element/section_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "beam/section/shapes.hpp"

namespace flexura::beam::ancf {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

const Material steel = isotropic("steel", 210e9, 0.3, 7850);

TEST(AncfSection, RodGivesLineAndBeamTheSameConstants) {
  const double d = 0.02, A = M_PI * d * d / 4, I = M_PI * std::pow(d, 4) / 64;
  const Section rod = make_section("rod", Circle{d}, steel);
  const LineSection line = spatial_line_section(rod, 1e-4);
  const BeamSection beam = beam_section(rod, 1e-4);
  // Closed forms through one 6x6 inversion: a few round-offs.
  EXPECT_NEAR(line.EA, 210e9 * A, 1e-13 * 210e9 * A);
  EXPECT_NEAR(line.EI, 210e9 * I, 1e-13 * 210e9 * I);
  EXPECT_NEAR(line.mass_per_length, 7850 * A, 1e-13 * 7850 * A);
  EXPECT_EQ(line.damping_time_bending, 1e-4);
  EXPECT_NEAR(beam.C(0, 0), line.EA, 1e-13 * line.EA);
  EXPECT_NEAR(beam.C(5, 5), line.EI, 1e-13 * line.EI);
  EXPECT_NEAR(beam.m_yy, 7850 * I, 1e-13 * 7850 * I);
}

TEST(AncfSection, LinesRefuseWhatOnlyBeamsCarry) {
  const Section blade = make_section("blade", Rectangle{0.05, 0.002}, steel);
  // Width along y: stiff about z.
  EXPECT_NEAR(planar_line_section(blade).EI, 210e9 * 0.002 * std::pow(0.05, 3) / 12, 1e-9);
  EXPECT_THAT([&] { spatial_line_section(blade); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("section 'blade' has E I_y")));
  Constants eccentric = constants_of(Circle{0.02}, 0.3);
  eccentric.S_y = 0.001 * eccentric.A;
  eccentric.I_y += 1e-6 * eccentric.A;
  eccentric.z_cg = 0.001;
  const Section off = make_section("off", eccentric, steel);
  EXPECT_THAT([&] { spatial_line_section(off); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("'off' couples stretch and bending")));
  const Section stiff = make_section("stiff", Circle{0.02}, steel, ShearFormula::rigid);
  EXPECT_THROW(beam_section(stiff), std::invalid_argument);
  EXPECT_NO_THROW(spatial_line_section(stiff));
}

}  // namespace
}  // namespace flexura::beam::ancf
