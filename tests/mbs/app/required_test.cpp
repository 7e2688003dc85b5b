// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/sanitized.hpp"

/// Only what a scene requires: instructions counted by valgrind (which needs no privileges and counts the
/// same number on a busy machine), with and without what a run does not need.
namespace flexura::test {
namespace {

const char* const kScene = R"toml(
gravity = [0, 0, 0]
[ground.marker.wall]
position = [0.3, -0.2, 0.1]
axis = [0, 0, 1]
[body.beam]
superelement = "beam.se.h5"
fidelity = "rigid"
[joint.hinge]
type = "revolute"
from = "ground.wall"
to = "beam.left"
speed = 3
[output]
quantities = ["hinge.angle"]
[solver]
end_time = "0.1 s"
output_step = "1 ms"
)toml";

// The box beam with what pictures, stresses and stiffening take: noise of the right shape, as large as that
// of a small solid part.
superelement::Superelement rich_beam() {
  superelement::Superelement se = superelement::testing::make_box_beam();
  const int n_v = 4000;
  se.surface.vertices = Eigen::MatrixXd::Random(n_v, 3);
  se.surface.triangles.resize(n_v - 2, 3);
  for (int i = 0; i < n_v - 2; ++i) se.surface.triangles.row(i) << i, i + 1, i + 2;
  se.surface.edges.resize(0, 2);
  se.surface.triangle_interface.assign(static_cast<std::size_t>(n_v - 2), -1);
  se.shapes = Eigen::MatrixXf::Random(3 * n_v, se.n());
  superelement::StressModes& stress = se.stress.emplace();
  for (int i = 0; i < n_v; ++i) stress.vertices.push_back(i);
  stress.S = Eigen::MatrixXd::Random(6 * n_v, se.n());
  return se;
}

// Instructions that valgrind counts in one run of the program; negative where it cannot.
double instructions(const Folder& folder, const std::vector<std::string>& more) {
  const std::string report = (folder / "callgrind.txt").string(), results = (folder / "out.h5").string();
  std::vector<std::string> words = {"valgrind",
                                    "--tool=callgrind",
                                    "--callgrind-out-file=/dev/null",
                                    FLEXURA_BIN_DIR "/flexura",
                                    "simulate",
                                    (folder / "scene.toml").string(),
                                    "-q",
                                    "--no-estimate",
                                    "-o",
                                    results};
  words.insert(words.end(), more.begin(), more.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 2, report.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int started = posix_spawnp(&child, "valgrind", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(started, 0) << "valgrind is in tests/setup/packages.txt";
  if (started != 0) return -1.0;
  int status = 0;
  waitpid(child, &status, 0);
  const std::string text = read_text(report);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << text;
  const auto at = text.find("Collected : ");
  EXPECT_NE(at, std::string::npos) << text;
  return at == std::string::npos ? -1.0 : std::strtod(text.c_str() + at + 12, nullptr);
}

TEST(OnlyWhatASceneRequires, IsReadBuiltAndStored) {
#ifdef FLEXURA_ADDRESS_SANITIZER
  GTEST_SKIP() << "valgrind does not run programs with an address sanitizer of their own";
#endif
  const Folder folder;
  folder.write("scene.toml", kScene);
  superelement::write(folder / "beam.se.h5", superelement::testing::make_box_beam());
  const double lean = instructions(folder, {});
  superelement::write(folder / "beam.se.h5", rich_beam());
  const double rich = instructions(folder, {});
  // The file holds 100 times more; what is not needed is not read.  Three per cent: the longer table of
  // contents, and a start-up of 50 million instructions that varies by two.
  EXPECT_NEAR(rich / lean, 1.0, 0.03);
  // What is needed costs: the counter sees it.  All deformations are integrated, and their names and outputs
  // evaluated.
  const double all =
      instructions(folder, {"--set", "body.beam.fidelity=modal", "--set", "output.quantities=[\"*\"]"});
  EXPECT_GT(all, 1.2 * rich);
  std::printf("instructions: rigid %.4g, of a file with everything %.4g, modal with all quantities %.4g\n",
              lean, rich, all);
}

TEST(OnlyWhatASceneRequires, ReportSaysWhatWasLeftOutAndWhatItSaved) {
  const Folder folder;
  folder.write("scene.toml", kScene);
  superelement::write(folder / "beam.se.h5", rich_beam());
  const Outcome outcome =
      run("flexura", {"simulate", (folder / "scene.toml").string(), "-o", (folder / "out.h5").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const int n = superelement::testing::make_box_beam().n() - 6;
  EXPECT_NE(outcome.out.find(std::to_string(n) + " of " + std::to_string(n) + " deformations of beam"),
            std::string::npos)
      << outcome.out;
  EXPECT_NE(outcome.out.find("matrices, stress modes, surface, shapes of the surface of beam"),
            std::string::npos)
      << outcome.out;
  // A marker that follows nodes of the surface takes it along.
  folder.write("scene.toml", std::string(kScene) +
                                 "[body.beam.marker.skin]\npoints = [[0.3, 0.2, 0.1], [-0.4, 0.3, 0.2], "
                                 "[0.1, -0.5, -0.3]]\n");
  const Outcome followed = run("flexura", {"simulate", (folder / "scene.toml").string(), "--set",
                                           "body.beam.fidelity=modal", "-o", (folder / "out.h5").string()});
  ASSERT_EQ(followed.exit_code, 0) << followed.err;
  EXPECT_NE(followed.out.find("left out: stress modes of beam ("), std::string::npos) << followed.out;
  // Many bodies alike are told by their number.
  std::string many = kScene;
  for (const char* name : {"b", "c", "d"})
    many += std::string("[body.") + name + "]\nsuperelement = \"beam.se.h5\"\nfidelity = \"rigid\"\n";
  folder.write("scene.toml", many);
  const Outcome alike = run("flexura", {"simulate", (folder / "scene.toml").string(), "--set",
                                        "body.beam.fidelity=rigid", "-o", (folder / "out.h5").string()});
  ASSERT_EQ(alike.exit_code, 0) << alike.err;
  EXPECT_NE(alike.out.find("surface, shapes of the surface of 4 bodies ("), std::string::npos) << alike.out;
}

}  // namespace
}  // namespace flexura::test
