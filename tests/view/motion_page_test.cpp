// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mbs/view/pages.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::PageReader;
using testing::scratch;
using testing::slurp;
namespace fs = std::filesystem;

TEST(MotionPage, HoldsTimesQuantitiesPosesAndModalCoordinatesAsStored) {
  Pictures pictures;
  const results::Results engine = synthetic::engine(pictures);
  const fs::path html = scratch("motion.html");
  write_motion_page(html, engine, pictures);
  const PageReader page(slurp(html));
  const auto rows = static_cast<std::size_t>(synthetic::engine_rows);
  for (std::size_t r = 0; r < 2; ++r) {
    const std::string key = "run" + std::to_string(r);
    const auto time = page.block<double>(key + "/time");
    ASSERT_EQ(time.size(), rows);
    for (std::size_t j = 0; j < engine.runs[r].quantities.size(); ++j) {
      const auto values = page.block<double>(key + "/quantity/" + std::to_string(j));
      ASSERT_EQ(values.size(), rows);
      for (std::size_t i = 0; i < rows; ++i) {
        EXPECT_EQ(values[i],
                  engine.runs[r].values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
      }
    }
    const auto pose = page.block<float>(key + "/body/2/pose");
    ASSERT_EQ(pose.size(), 7 * rows);
    for (std::size_t i = 0; i < rows; ++i) {
      EXPECT_EQ(pose[i], static_cast<float>(synthetic::engine_pose(time[i]).slider));
    }
  }
  const auto modal = page.block<float>("run1/body/1/modal");
  ASSERT_EQ(modal.size(), synthetic::rod_modes * rows);
  const double t = page.block<double>("run1/frame_time")[77];
  EXPECT_EQ(modal[rows * 3 + 77], static_cast<float>(synthetic::rod_modal(3, t)));
  EXPECT_EQ(page.header["runs"][1]["bodies"][1]["n_shapes"], synthetic::rod_modes);
  EXPECT_EQ(page.header["runs"][0]["bodies"][1]["n_shapes"], 0);
  EXPECT_EQ(page.header["surfaces"].size(), 1u);
}

// Where a joint to the ground sits on an interface, displacements are taken from there at first (PAGE.md: held_by).
TEST(MotionPage, NamesTheInterfaceAtWhichAJointToTheGroundHoldsABody) {
  Pictures pictures;
  results::Results engine = synthetic::engine(pictures);
  const fs::path html = scratch("held.html");
  write_motion_page(html, engine, pictures);
  const json before = PageReader(slurp(html)).header["runs"][1]["bodies"][1];
  ASSERT_EQ(before["frames"].size(), 2u);
  EXPECT_EQ(before["frames"][1]["point"], json::parse("[1.0, 0.0, 0.0]"));
  EXPECT_TRUE(before["held_by"].is_null());
  json clamp = {{"name", "clamp"}, {"kind", "fixed"},        {"is_joint", true},      {"body_1", "ground"},
                {"body_2", "rod"}, {"p_1", {0.3, 0.0, 0.0}}, {"p_2", {1.0, 0.0, 0.0}}};
  // The same written the other way round; a force at that place holds nothing.
  for (const bool turned : {false, true}) {
    if (turned)
      for (const char* const key : {"body_", "p_"})
        std::swap(clamp[key + std::string("1")], clamp[key + std::string("2")]);
    engine.model.connections_json = json::array({clamp}).dump();
    write_motion_page(html, engine, pictures);
    EXPECT_EQ(PageReader(slurp(html)).header["runs"][1]["bodies"][1]["held_by"], 1) << turned;
  }
  clamp["is_joint"] = false;
  engine.model.connections_json = json::array({clamp}).dump();
  write_motion_page(html, engine, pictures);
  EXPECT_TRUE(PageReader(slurp(html)).header["runs"][1]["bodies"][1]["held_by"].is_null());
}

TEST(MotionPage, ThinsLongRunsEvenlyAndKeepsTheLastTime) {
  Pictures pictures;
  const results::Results engine = synthetic::engine(pictures);
  const fs::path html = scratch("thinned.html");
  MotionPage options;
  options.most_frames = 50;
  // 8 quantities and the time, 2 runs: 18 numbers for each row, so 100 rows.
  options.most_values = 1800;
  write_motion_page(html, engine, pictures, options);
  const PageReader page(slurp(html));
  const auto frames = page.block<double>("run0/frame_time"), time = page.block<double>("run0/time");
  EXPECT_LE(frames.size(), 51u);
  EXPECT_GE(frames.size(), 40u);
  // And the rows at which one of the 8 quantities is largest or smallest.
  EXPECT_LE(time.size(), 101u + 2u * 8u);
  EXPECT_GE(time.size(), 80u);
  EXPECT_EQ(frames.front(), 0.0);
  EXPECT_EQ(frames.back(), synthetic::engine_time);
  EXPECT_EQ(time.back(), synthetic::engine_time);
  EXPECT_EQ(page.header["runs"][0]["rows_stored"], synthetic::engine_rows);
}

std::string motion_refusal(const results::Results& results, const Pictures& pictures,
                           const MotionPage& page = {}) {
  const fs::path html = scratch("motion-refused.html");
  try {
    write_motion_page(html, results, pictures, page);
  } catch (const std::exception& error) {
    EXPECT_FALSE(fs::exists(html));
    EXPECT_FALSE(fs::exists(html.string() + ".part"));
    return error.what();
  }
  return "";
}

TEST(MotionPage, RefusesWhatItCannotShow) {
  Pictures pictures;
  const results::Results good = synthetic::engine(pictures);
  auto results = good;
  results.runs.clear();
  EXPECT_THAT(motion_refusal(results, pictures), HasSubstr("no run with a stored time: simulate first"));
  EXPECT_THAT(motion_refusal(good, pictures, {.plots = {"slider.position, crank.sped"}}),
              HasSubstr("no run stored the quantity 'crank.sped'"));
  results = good;
  results.model.bodies[1].shape_json = R"([{"type": "cylinder", "radius": -1, "length": 2}])";
  EXPECT_THAT(motion_refusal(results, pictures),
              HasSubstr("body 'crank', shape 1 (cylinder) needs a positive number 'radius'"));
  results.model.bodies[1].shape_json = R"([{"type": "torus"}])";
  EXPECT_THAT(motion_refusal(results, pictures), HasSubstr("has the type 'torus'; types are box, cone"));
  results.model.bodies[1].shape_json = R"([{"type": "box", "size": [1, 2]}])";
  EXPECT_THAT(motion_refusal(results, pictures), HasSubstr("needs 3 numbers in 'size'"));
  results.model.bodies[1].shape_json = R"([{"type": "sphere", "radius": 1, "color": "red"}])";
  EXPECT_THAT(motion_refusal(results, pictures), HasSubstr("has the color 'red'; write it like '#88aacc'"));
  results = good;
  results.runs[1].bodies[1].basis.conservativeResize(10, Eigen::NoChange);
  EXPECT_THAT(motion_refusal(results, pictures), HasSubstr("it is not the one that was simulated"));
}

TEST(MotionPage, NamesTheSuperelementThatIsNotThere) {
  results::ModelHeader model;
  model.bodies = {{"ground", "ground", "", ""}, {"rod", "flexible", "parts/rod.se.h5", ""}};
  try {
    read_pictures(model, "/data/engine.h5");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("body 'rod' is drawn from the superelement '/data/parts/rod.se.h5', "
                                        "which is not there"));
  }
}

}  // namespace
}  // namespace flexura::view
