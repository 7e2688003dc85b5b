// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What a CAD file of faces must say.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using OpenCad = Parts;

// What a CAD file of faces must say: where it is open, or that it was healed and to which volume.  Drawn for this: a box
// of 30 x 20 x 10 mm without its lid, its six faces loose, two lines; the first two as IGES, too, which knows faces alone.
TEST_F(OpenCad, OpenCadFilesSayWhereTheyAreOpen) {
  const auto list = [](const std::string& name) {
    return run("flexura-reduce",
               {std::string(FLEXURA_SOURCE_DIR "/tests/found/reduce/") + name, "--list-faces"});
  };
  const Outcome open = list("open_box.brep"), bore = list("open_bore.brep"), lines = list("two_lines.brep"),
                loose = list("faces_of_box.brep");
  EXPECT_EQ(open.exit_code, 2);
  EXPECT_THAT(open.err,
              AllOf(HasSubstr("is not closed"),
                    HasSubstr("4 of its 12 edges belong to one face only, 100 mm together"),
                    HasSubstr("(0, 20, 10) to (30, 20, 10), 30 mm"), HasSubstr("export a solid body")));
  EXPECT_EQ(bore.exit_code, 2);  // a block whose bore has no wall
  EXPECT_THAT(bore.err, AllOf(HasSubstr("is not closed"),
                              HasSubstr("2 of its 14 edges belong to one face only, 50.265 mm together")));
  EXPECT_EQ(lines.exit_code, 2);
  EXPECT_THAT(lines.err, HasSubstr("only 2 curves"));
  EXPECT_EQ(loose.exit_code, 0) << loose.err;
  EXPECT_THAT(loose.out, AllOf(HasSubstr("healed: 6 faces"), HasSubstr("6000 mm3")));
  const Outcome open_iges = list("open_box.igs"), loose_iges = list("faces_of_box.igs");
  EXPECT_EQ(open_iges.exit_code, 2);
  EXPECT_THAT(open_iges.err,
              AllOf(HasSubstr("is not closed"),
                    HasSubstr("4 of its 12 edges belong to one face only, 100 mm together"),
                    HasSubstr("(0, 20, 10) to (30, 20, 10), 30 mm"), HasSubstr("export a solid body")));
  EXPECT_EQ(loose_iges.exit_code, 0) << loose_iges.err;
  EXPECT_THAT(loose_iges.out, AllOf(HasSubstr("healed: 6 faces"), HasSubstr("6000 mm3")));
}

}  // namespace
}  // namespace flexura::test
