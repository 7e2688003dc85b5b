// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/results/results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "mbs/base/hdf5/file.hpp"
#include "tests/setup/scratch_place.hpp"

namespace flexura::results {
namespace {

using ::testing::HasSubstr;

ModelHeader model() {
  return {.name = "engine",
          .source = "name = \"engine\"\n",
          .created_by = "tests",
          .bodies = {{"rod", "flexible", "rod.se.h5", ""}, {"crank", "rigid", "", "{\"cylinder\": 1}"}},
          .gravity = {0.0, -9.81, 0.5},
          .connections_json = "[]"};
}

const std::vector<Quantity> quantities = {
    {"crank.speed", "rad/s", "speed"}, {"piston, \"force\"", "N", "force"}, {"a", "", ""}};

// Every number of row i is a known function of i, so a reader can tell a right row from a wrong one.
Row row(int i) {
  Row r;
  r.time = 1e-3 * i;
  r.quantities = Eigen::Vector3d(i, std::sqrt(i + 0.1), -1.0 / (1 + i));
  Eigen::Matrix<double, 7, 1> pose;
  pose << i, 2 * i, 3 * i, 1, 0, 0, 0;
  r.pose = {pose, 2 * pose};
  r.modal = {Eigen::Vector2d(0.1 * i, -0.2 * i), {}};
  r.states = Eigen::Vector4d::Constant(i);
  return r;
}

std::vector<RunBody> run_bodies() {
  return {{"rod", Eigen::MatrixXd::Random(5, 2)}, {"crank", {}}};
}
const std::vector<std::string> states = {"a", "b", "c", "d"};

void expect_rows(const Run& run, int n) {
  ASSERT_EQ(run.time.size(), n);
  ASSERT_EQ(run.values.rows(), n);
  ASSERT_EQ(run.bodies.size(), 2u);
  ASSERT_EQ(run.bodies[0].modal.rows(), n);
  for (int i = 0; i < n; ++i) {
    const Row r = row(i);
    ASSERT_EQ(run.time[i], r.time);
    ASSERT_EQ(Eigen::VectorXd(run.values.row(i)), r.quantities);
    ASSERT_EQ((Eigen::Matrix<double, 7, 1>(run.bodies[0].pose.row(i))), r.pose[0]);
    ASSERT_EQ((Eigen::Matrix<double, 7, 1>(run.bodies[1].pose.row(i))), r.pose[1]);
    ASSERT_EQ(Eigen::VectorXd(run.bodies[0].modal.row(i)), r.modal[0]);
    ASSERT_EQ(Eigen::VectorXd(run.states.row(i)), r.states);
  }
}

class ResultsFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::flexura::test::scratch_place() / ("flexura_results_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "engine.h5";
    part_ = folder_ / "engine.h5.part";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_, file_, part_;
};

TEST_F(ResultsFile, TwoRunsReadBackAsWritten) {
  const auto bodies = run_bodies();
  {
    Writer writer(file_, model());
    writer.begin_run("rigid", quantities, bodies, states);
    for (int i = 0; i < 2500; ++i) writer.append(row(i));
    writer.end_run(true, "end time", "{\"steps\": 7}");
    writer.begin_run("flexible", quantities, bodies, states);
    for (int i = 0; i < 3; ++i) writer.append(row(i));
    writer.end_run(false, "interrupted", "{}");
    EXPECT_FALSE(std::filesystem::exists(file_));
    writer.close();
    EXPECT_FALSE(std::filesystem::exists(part_));
  }
  const Results results = read(file_);
  EXPECT_EQ(results.model.name, "engine");
  EXPECT_EQ(results.model.gravity, Eigen::Vector3d(0.0, -9.81, 0.5));
  EXPECT_EQ(results.model.source, model().source);
  ASSERT_EQ(results.model.bodies.size(), 2u);
  EXPECT_EQ(results.model.bodies[0].name, "rod");  // the model's order
  EXPECT_EQ(results.model.bodies[0].superelement, "rod.se.h5");
  EXPECT_EQ(results.model.bodies[1].shape_json, "{\"cylinder\": 1}");
  ASSERT_EQ(results.runs.size(), 2u);
  EXPECT_EQ(results.runs[0].name, "rigid");
  EXPECT_TRUE(results.runs[0].complete);
  EXPECT_EQ(results.runs[0].stopped_because, "end time");
  EXPECT_EQ(results.runs[0].summary_json, "{\"steps\": 7}");
  EXPECT_EQ(results.runs[0].bodies[0].basis, bodies[0].basis);
  EXPECT_EQ(results.runs[0].quantities[1].name, quantities[1].name);
  EXPECT_EQ(results.runs[0].quantities[1].unit, "N");
  EXPECT_EQ(results.runs[0].state_names, states);
  expect_rows(results.runs[0], 2500);
  EXPECT_FALSE(results.runs[1].complete);
  expect_rows(results.runs[1], 3);
}

// Reads a run while another process writes it, kills the writer at some instant of a second run, reads what
// it left.
TEST_F(ResultsFile, AKilledRunKeepsWhatItHadAndAReaderDoesNotDisturbIt) {
  int rows_before = 0;
  for (const int milliseconds : {0, 3, 20, 600, 1300}) {
    std::filesystem::remove(part_);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) try {
        Writer writer(file_, model());
        writer.begin_run("first", quantities, run_bodies(), states);
        for (int i = 0; i < 1500; ++i) writer.append(row(i));
        writer.end_run(true, "end time", "{}");
        writer.begin_run("second", quantities, run_bodies(), states);
        for (int i = 0;; ++i) {
          writer.append(row(i));
          std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
      } catch (...) {
        ::_exit(1);
      }
    // Wait until the first run is there, then a little longer.
    for (int wait = 0; wait < 10000; ++wait) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      try {
        if (std::filesystem::exists(part_) && !read(part_).runs.empty() && read(part_).runs[0].complete)
          break;
      } catch (const std::runtime_error&) {
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the writer failed before it was killed";

    EXPECT_FALSE(std::filesystem::exists(file_));
    const Results results = read(part_);
    ASSERT_GE(results.runs.size(), 1u);
    EXPECT_TRUE(results.runs[0].complete);
    expect_rows(results.runs[0], 1500);
    if (results.runs.size() > 1) {
      EXPECT_FALSE(results.runs[1].complete);
      EXPECT_THAT(results.runs[1].stopped_because, HasSubstr("killed"));
      expect_rows(results.runs[1], static_cast<int>(results.runs[1].time.size()));
      rows_before = static_cast<int>(results.runs[1].time.size());
    }
  }
  // After 1.3 s two flushes have happened; one row takes at least 0.2 ms, on a busy machine much longer.
  EXPECT_GT(rows_before, 100);
}

TEST_F(ResultsFile, AValueThatIsNotFiniteIsRefusedByNameAndTime) {
  Writer writer(file_, model());
  writer.begin_run("rigid", quantities, run_bodies(), states);
  for (int i = 0; i < 10; ++i) writer.append(row(i));
  Row bad = row(10);
  bad.quantities[1] = std::nan("");
  try {
    writer.append(bad);
    FAIL();
  } catch (const std::invalid_argument& failure) {
    EXPECT_STREQ(failure.what(), "piston, \"force\" is nan at time 0.01 s; results must be finite");
  }
  bad = row(10);
  bad.states[2] = INFINITY;
  EXPECT_THROW(writer.append(bad), std::invalid_argument);
  bad = row(10);
  bad.pose.pop_back();
  EXPECT_THROW(writer.append(bad), std::invalid_argument);
  writer.append(row(10));
  writer.close();
  const Results results = read(file_);
  expect_rows(results.runs[0], 11);
  EXPECT_FALSE(results.runs[0].complete);
}

TEST_F(ResultsFile, AWriterThatIsDroppedLeavesNothing) {
  {
    Writer writer(file_, model());
    writer.begin_run("rigid", quantities, run_bodies(), states);
    for (int i = 0; i < 10; ++i) writer.append(row(i));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(ResultsFile, AWriterThatIsDroppedBeforeARunLeavesNothing) {
  { Writer writer(file_, model()); }
  EXPECT_FALSE(std::filesystem::exists(part_));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(ResultsFile, OtherFilesAreRefused) {
  const auto refusal = [&] {
    try {
      read(file_);
    } catch (const std::runtime_error& failure) {
      return std::string(failure.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal(), HasSubstr("engine.h5: there is no such file"));
  std::ofstream(file_) << "time,speed\n";
  EXPECT_THAT(refusal(), HasSubstr("engine.h5: is not an HDF5 file"));
  {
    hdf5::File file(file_, hdf5::Mode::create);
    file.root().set("format", "flexura superelement");
    file.close();
  }
  EXPECT_THAT(refusal(), HasSubstr("holds no results of a simulation; make one with \"flexura simulate\""));
}

TEST_F(ResultsFile, CsvHoldsNamesUnitsAndTheExactNumbers) {
  Writer writer(file_, model());
  writer.begin_run("rigid", quantities, run_bodies(), states);
  for (int i = 0; i < 5000; ++i) writer.append(row(i));
  writer.end_run(true, "end time", "{}");
  writer.close();
  const auto files = write_csv(read(file_), file_);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0], folder_ / "engine.rigid.csv");
  std::ifstream in(files[0]);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "time [s],crank.speed [rad/s],\"piston, \"\"force\"\" [N]\",a");
  for (int i = 0; i < 5000; ++i) {
    std::getline(in, line);
    double time = 0, speed = 0, force = 0, a = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &time, &speed, &force, &a), 4);
    ASSERT_EQ(time, row(i).time);
    ASSERT_EQ(Eigen::Vector3d(speed, force, a), row(i).quantities);
  }
  EXPECT_FALSE(std::getline(in, line));
}

}  // namespace
}  // namespace flexura::results
