// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Every constraint and every force that a mechanism file knows, by its example: a new type stands here by itself.
#include <gmock/gmock.h>

#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/examples.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

class Registry : public MechanismFileTest {
 protected:
  /// A mechanism with the type's example, in some state; calls `hold`.
  template <class Types, class Hold>
  void each(const std::string& kind, const Types& types, const Examples& examples, const Hold& hold) const {
    int held = 0;
    for (const auto& type : types) {
      const auto example = examples.find(std::string(type.name));
      if (example == examples.end()) continue;  // what needs files beside it is held elsewhere
      ++held;
      const Mechanism m(read(std::string(kThreeBodies) + "[" + kind + ".x]\ntype = \"" + example->first +
                             "\"\n" + example->second)
                            .description);
      for (const unsigned seed : {3U, 4U}) {
        SCOPED_TRACE(kind + " " + example->first);
        State s = random_state(m, seed, 0.3);
        const auto scratch = m.make_scratch();
        m.start_contacts(s, *scratch);
        m.start_switches(s, *scratch);
        hold(m, s, seed);
      }
    }
    EXPECT_EQ(held, static_cast<int>(examples.size()));
  }
};

TEST_F(Registry, ConstraintsHaveTheRowsOfTheirPositions) {
  each("constraint", constraint_types(), constraint_examples(),
       [](const Mechanism& m, const State& s, unsigned seed) {
         constraints_are_consistent(m, s, seed);
         power_balances(m, s, seed);
         // Of coordinates of order one, turned by chance; a row that nothing moves has 1e-16 and lets every comparison hold.
         const auto scratch = m.make_scratch();
         MatrixXd G(m.sizes().n_lambda, m.sizes().n_v);
         m.constraint_matrix(s.t, s.p, *scratch, G);
         EXPECT_GT(G.rowwise().norm().minCoeff(), 1e-3);
       });
}

TEST_F(Registry, ForcesHaveThePowersOfTheirEnergies) {
  each("force", force_types(), force_examples(),
       [](const Mechanism& m, const State& s, unsigned seed) { power_balances(m, s, seed); });
}

}  // namespace
}  // namespace flexura::mbs
