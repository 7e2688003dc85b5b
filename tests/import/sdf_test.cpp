// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <numbers>

#include "import/model/folder.hpp"
#include "import/sdf/convert.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/library/simulation.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

const char* const kBall =
    "<inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.25</izz></inertia></inertial>";

class Sdf : public testing::Test {
 protected:
  import::Mechanism read(const std::string& inside, const std::string& version = "1.9") {
    const auto file = folder_.write("m.sdf", fmt::format("<sdf version='{}'>{}</sdf>", version, inside));
  import::Findings findings(file);
  import::Mechanism m = import::sdf::to_mechanism(file, {}, findings);
  import::tell(findings, m);
  return m;
} std::string faults(const std::string& inside) {
  try {
    read(inside);
  } catch (const import::Faults& all) {
    std::string out = all.what();
    for (const std::string& fault : all.all()) out += "\n" + fault;
    return out;
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return "";
}
mbs::Simulation run(const std::string& inside, std::vector<std::string> set = {}) {
  const std::string name = fmt::format("out{}", ++n_);
  import::write_folder(folder_ / name, read(inside), {}, false);
  return mbs::Simulation(mbs::Mechanism(
      mbs::read_mechanism(folder_ / name / "mechanism.toml", mbs::solver_schema(), set).description));
}
static std::string notes(const import::Mechanism& m) {
  std::string out;
  for (const std::string& note : m.notes) out += note + "\n";
  return out;
}

Folder folder_;
int n_ = 0;
};  // namespace

TEST_F(Sdf, LinksThatNothingHoldsFallUnlessTheirModelIsStatic) {
  const std::string model = fmt::format("<model name='m'><link name='l'>{}</link></model>", kBall);
  EXPECT_NEAR(run(model).output("m_l_free.a_z"), -9.81, 1e-12);
  const auto still = read("<model name='m'><static>true</static><link name='l'/></model>");
  EXPECT_THAT(import::mechanism_text(still), HasSubstr("type = \"fixed\""));
}

TEST_F(Sdf, LinksWithoutInertialHaveTheFormatsOwn) {
  const auto m = read("<model name='m'><link name='l'/></model>");
  EXPECT_EQ(m.bodies[0].mass, 1.0);
  EXPECT_TRUE(m.bodies[0].inertia.isIdentity());
  EXPECT_THAT(notes(m), HasSubstr("1 kg and 1 kg m^2"));
}

// A screw of thread_pitch p turns by p in a metre, left-handed: (m / p^2 + I) alpha = m g / p, downwards.
TEST_F(Sdf, ScrewsHaveTheirThread) {
  const double p = 20.0, m = 2.0, I = 0.25;
  const auto s =
      run(fmt::format("<model name='m'><link name='l'>{}</link><joint name='j' "
                      "type='screw'><parent>world</parent><child>l</child>"
                      "<axis><xyz>0 0 1</xyz></axis><thread_pitch>20</thread_pitch></joint></model>",
                      kBall));
  EXPECT_NEAR(s.output("m_j.acceleration"), m * 9.81 / p / (m / (p * p) + I), 1e-10);
}

// theta_2 = -ratio theta_1; the wheels turn about z and feel no weight, the first is driven by a spring from 0.5 rad.
TEST_F(Sdf, GearboxesCoupleTheirLinks) {
  const auto joint = [](const char* name, const char* child, const char* more) {
    return fmt::format(
        "<joint name='{}' type='revolute'><parent>base</parent><child>{}</child><axis><xyz>0 0 "
        "1</xyz>{}</axis></joint>",
        name, child, more);
  };
  const auto s = run(fmt::format(
      "<model name='m'><link name='base'>{0}</link><link name='a'>{0}</link><link name='b'>{0}</link>"
      "<joint name='w' type='fixed'><parent>world</parent><child>base</child></joint>{1}{2}"
      "<joint name='g' type='gearbox'><parent>a</parent><child>b</child><gearbox_ratio>3</gearbox_ratio>"
      "<gearbox_reference_body>base</gearbox_reference_body></joint></model>",
      kBall,
      joint("ja", "a",
            "<dynamics><spring_stiffness>4</spring_stiffness><spring_reference>0.5</spring_reference></"
            "dynamics>"),
      joint("jb", "b", "")));
  EXPECT_NEAR(s.output("m_ja.acceleration"), 4.0 * 0.5 / (0.25 + 9.0 * 0.25), 1e-10);
  EXPECT_NEAR(s.output("m_jb.acceleration"), -3.0 * 4.0 * 0.5 / (0.25 + 9.0 * 0.25), 1e-10);
}

TEST_F(Sdf, RingsOfJointsAreClosed) {
  std::string links, joints;
  for (int i = 0; i < 4; ++i) {
    links += fmt::format("<link name='l{}'><pose>{} {} 0 0 0 0</pose>{}</link>", i, i == 1 || i == 2 ? 1 : 0,
                         i > 1 ? 1 : 0, kBall);
    joints += fmt::format(
        "<joint name='j{}' type='revolute'><parent>l{}</parent><child>l{}</child><axis><xyz>0 0 "
        "1</xyz></axis></joint>",
        i, i, (i + 1) % 4);
  }
  const auto s = run("<model name='m'>" + links + joints +
                     "<joint name='w' type='fixed'><parent>world</parent><child>l0</child></joint></model>");
  EXPECT_EQ(s.mechanism().sizes().n_v, 3);
}

TEST_F(Sdf, IncludesModelsBesideTheFile) {
  std::filesystem::create_directories(folder_ / "arm");
  folder_.write(
      "arm/model.sdf",
      fmt::format("<sdf version='1.6'><model name='x'><link name='l'>{}</link></model></sdf>", kBall));
  const std::string include =
      "<include><uri>model://arm</uri><name>left</name><pose>1 2 3 0 0 0</pose></include>";
  const auto m = read("<world name='w'>" + include + "</world>");
  ASSERT_EQ(m.bodies.size(), 1U);
  EXPECT_EQ(m.bodies[0].name, "left_l");
  const std::string all = faults(
      "<world "
      "name='w'><include><uri>model://lost</uri></include><include><uri>model://gone</uri></include></"
      "world>");
  EXPECT_THAT(all, HasSubstr("\"model://lost\", which is included, is not there"));
  EXPECT_THAT(all, HasSubstr("\"model://gone\", which is included, is not there"));
}

TEST_F(Sdf, RefusesFilesThatIncludeThemselves) {
  std::filesystem::create_directories(folder_ / "a");
  folder_.write("a/model.sdf",
                "<sdf version='1.6'><model name='x'><include><uri>model://a</uri></include></model></sdf>");
  EXPECT_THAT(faults("<world name='w'><include><uri>model://a</uri></include></world>"),
              HasSubstr("includes itself"));
}

TEST_F(Sdf, TellsAllFaultsAtOnce) {
  const std::string all = faults(
      "<model name='m'><link name='l'><inertial><mass>-1</mass></inertial></link><link name='l'/><joint "
      "name='j' type='hinge'><parent>l</parent><child>l</child></joint>"
      "<joint name='k' type='revolute'><parent>l</parent><child>lost</child></joint><link name='p'><pose>1 "
      "2</pose></link>"
      "<frame name='f'><pose relative_to='g'/></frame><frame name='g'><pose relative_to='f'/></frame><link "
      "name='q'><pose relative_to='f'/></link></model>");
  for (const char* what : {"the mass of link \"m::l\" is -1", "a second \"m::l\"", "\"hinge\"", "is \"lost\"",
                           "6 finite numbers are wanted", "is given in itself"})
    EXPECT_THAT(all, HasSubstr(what));
}

TEST_F(Sdf, MendsWhatOlderReadersTook) {
  const auto file = folder_.write("old.sdf",
                                  "<!-- licence -->\n<?xml version='1.0'?>\n<sdf version='1.4'><model "
                                  "name=m><link name='l'/></model></sdf>");
  import::Findings findings(file), strict(file, true);
  EXPECT_EQ(import::sdf::to_mechanism(file, {}, findings).bodies.size(), 1U);
  EXPECT_THAT(findings.count(), HasSubstr("texts that are not XML"));
  EXPECT_THROW(import::sdf::to_mechanism(file, {}, strict), std::invalid_argument);
}

}  // namespace flexura::test
}  // namespace flexura::test
