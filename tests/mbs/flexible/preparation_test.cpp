// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <fstream>

#include "mbs/bodies/modal_basis.hpp"
#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/test_folder.hpp"

/// What of a body's preparation is computed again when something changes.
namespace flexura::mbs {
namespace {

using checks::Random;
using Eigen::MatrixXd;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

superelement::Superelement stiffened_lattice() {
  superelement::Superelement se = lattice::make_lattice(9).se;
  se.stiffening = lattice::any_stiffening(se.n(), 4);
  return se;
}

/// The stages computed since the last call, by name.
class Computed {
 public:
  explicit Computed(const PreparationCache& cache) : cache_(cache) {}
  std::vector<std::string> stages() {
    std::vector<std::string> out;
    for (const auto& [stage, counts] : cache_.counts()) {
      if (counts.computed > before_[stage]) out.push_back(stage);
      before_[stage] = counts.computed;
    }
    return out;
  }

 private:
  const PreparationCache& cache_;
  std::map<std::string, int> before_;
};

TEST(PreparationCache, AChangeOfOneChoiceRedoesOnlyWhatFollowsFromIt) {
  superelement::Superelement se = stiffened_lattice();
  PreparationCache cache;
  Computed computed(cache);
  BasisOptions options;
  options.modes = 6;
  const auto prepare = [&] {
    modal_data(se, options, nullptr, &cache);
    return computed.stages();
  };
  EXPECT_THAT(prepare(), ElementsAre("basis", "eigenmodes", "integrals"));
  EXPECT_THAT(prepare(), IsEmpty());
  options.damping = 0.02;
  EXPECT_THAT(prepare(), IsEmpty());
  options.coupling = Coupling::partial;
  EXPECT_THAT(prepare(), IsEmpty());
  options.coupling = Coupling::full;
  options.modes = 4;
  EXPECT_THAT(prepare(), ElementsAre("basis", "integrals"));
  options.loads = interface_loads(se, 1);
  EXPECT_THAT(prepare(), ElementsAre("basis", "integrals", "responses"));
  options.fixed_interface = 0;
  EXPECT_THAT(prepare(), ElementsAre("basis", "integrals"));
  options.held = interface_loads(se, 0);
  EXPECT_THAT(prepare(), ElementsAre("basis", "eigenmodes", "integrals"));
  options.response_frequency = 0.3;
  EXPECT_THAT(prepare(), ElementsAre("basis", "integrals", "responses"));
  options.stiffening = true;
  EXPECT_THAT(prepare(), ElementsAre("loads_stiffening", "stiffening"));
  se.stiffening->K0F[3](0, 0) += 1.0;
  EXPECT_THAT(prepare(), ElementsAre("loads_stiffening"));
  se.inertia.S_xphi(2, 1) += 1e-9;
  EXPECT_THAT(prepare(), ElementsAre("integrals"));
  se.K_se(14, 14) *= 1.0 + 1e-12;
  EXPECT_THAT(prepare(),
              ElementsAre("basis", "eigenmodes", "integrals", "loads_stiffening", "responses", "stiffening"));
  // A rigid link is part of the problem.
  options.nodes = {rigidly_linked_node(se, "link", {0, 1})};
  options.fixed_interface = -1;
  options.held.resize(0, 0);
  EXPECT_THAT(prepare(),
              ElementsAre("basis", "eigenmodes", "integrals", "loads_stiffening", "responses", "stiffening"));
}

void expect_same(const ModalData& a, const ModalData& b) {
  EXPECT_EQ(a.Y, b.Y);
  EXPECT_EQ(a.stiffness, b.stiffness);
  EXPECT_EQ(a.damping, b.damping);
  EXPECT_EQ(a.inertia.S_phi, b.inertia.S_phi);
  EXPECT_EQ(a.inertia.S_xphi, b.inertia.S_xphi);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(a.inertia.S_phiphi[k], b.inertia.S_phiphi[k]);
  EXPECT_EQ(a.inertia.S_xx, b.inertia.S_xx);
  ASSERT_EQ(a.second.has_value(), b.second.has_value());
  if (a.second) EXPECT_EQ(a.second->t, b.second->t);
  if (a.second) EXPECT_EQ(a.second->x, b.second->x);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].Phi_t, b.nodes[i].Phi_t);
    EXPECT_EQ(a.nodes[i].Phi_r, b.nodes[i].Phi_r);
    EXPECT_EQ(a.nodes[i].second, b.nodes[i].second);
  }
}

class PreparationFolder : public test::TestFolder {};

TEST_F(PreparationFolder, GivesTheSameBodyToTheBitFromMemoryAndFromFiles) {
  const superelement::Superelement se = stiffened_lattice();
  BasisOptions options;
  options.modes = 5;
  options.stiffening = true;
  options.loads = interface_loads(se, {0, 1});
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  const ModalData alone = modal_data(se, options);
  PreparationCache first(folder_ / "bodies"), second(folder_ / "bodies");
  expect_same(modal_data(se, options, nullptr, &first), alone);
  expect_same(modal_data(se, options, nullptr, &first), alone);
  expect_same(modal_data(se, options, nullptr, &second), alone);
  EXPECT_THAT(Computed(second).stages(), IsEmpty());
  // A file that is cut short or changed is made again.
  int damaged = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "bodies")) {
    EXPECT_EQ(entry.path().extension(), ".prepared");
    const auto size = std::filesystem::file_size(entry.path());
    if (++damaged % 2 == 0) {
      std::filesystem::resize_file(entry.path(), size / 2);
    } else {
      std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<long>(size / 2));
      file.put('x');
      file.put('y');
    }
  }
  EXPECT_EQ(damaged, 6);
  PreparationCache third(folder_ / "bodies"), fourth(folder_ / "bodies");
  expect_same(modal_data(se, options, nullptr, &third), alone);
  EXPECT_EQ(Computed(third).stages().size(), 6u);
  expect_same(modal_data(se, options, nullptr, &fourth), alone);
  EXPECT_THAT(Computed(fourth).stages(), IsEmpty());
}

TEST_F(PreparationFolder, PreparesEqualBodiesOnceAndReadsAChangedFileAgain) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(6).se);
  const auto mechanism = file(R"toml(
[body.a]
superelement = "beam.se.h5"
modes = 4
[body.b]
superelement = "beam.se.h5"
modes = 4
damping = 0.1
[joint.one]
type = "revolute"
from = "ground"
to = "a.left"
[joint.two]
type = "revolute"
from = "a.right"
to = "b.left"
)toml");
  const PreparedMechanism run = prepare(mechanism);
  const auto counts = [&](const char* stage) { return run.cache->counts().at(stage); };
  EXPECT_EQ(counts("superelement").computed, 1);
  EXPECT_EQ(counts("eigenmodes").computed, 1);
  EXPECT_EQ(counts("basis").computed, 1);
  EXPECT_EQ(counts("basis").reused, 1);
  // Another run of the file with one more choice.
  prepare(mechanism, {"body.b.modes=3", "gravity=[0, 0, 0]"}, {}, run.cache);
  EXPECT_EQ(counts("superelement").computed, 1);
  EXPECT_EQ(counts("eigenmodes").computed, 1);
  EXPECT_EQ(counts("basis").computed, 2);
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(7).se);
  prepare(mechanism, {}, {}, run.cache);
  EXPECT_EQ(counts("superelement").computed, 2);
  EXPECT_EQ(counts("eigenmodes").computed, 2);
}

}  // namespace
}  // namespace flexura::mbs
