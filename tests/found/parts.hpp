// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {

/// Parts reduced by the program as users start it, in a folder of the test's own.
class Parts : public testing::Test {
 protected:
  struct Reduced {
    Outcome outcome;
    nlohmann::json report;            ///< null where it was refused
    superelement::Superelement se{};  ///< of reduce_deck alone
  };

  /// Reduces a part file to output().
  Reduced reduce(const std::filesystem::path& part, std::vector<std::string> options = {}) {
    const std::string report = folder_ / "report.json";
    options.insert(options.begin(), {part.string(), "-o", output(), "--report", report});
    Reduced out{run("flexura-reduce", options), {}};
    if (out.outcome.exit_code == 0) out.report = nlohmann::json::parse(read_text(report));
    return out;
  }

  /// Reduces a deck under [geometry] (which `rest` may go on with) to a new file, and reads it.
  Reduced reduce_deck(const std::string& deck, const std::string& rest,
                      const std::vector<std::string>& options = {}, const std::string& name = "deck.bdf") {
    folder_.write(name, deck);
    std::filesystem::remove(output());  // coarse meshes do not replace finer ones
    Reduced out = reduce(folder_.write("part.toml", "[geometry]\nfile = \"" + name + "\"\n" + rest), options);
    if (out.outcome.exit_code == 0)
      out.se = superelement::read(output(), {.surface = true, .shapes = true, .stress = true});
    return out;
  }

  std::string output() const { return folder_ / "part.se.h5"; }

  /// Frequencies [Hz] with all interfaces held.
  static Eigen::VectorXd clamped_hz(const superelement::Superelement& se) {
    return se.omega2.cwiseSqrt() / (2 * std::numbers::pi);
  }

  /// Static displacements of all coordinates with interface `held` at rest under six loads at interface `loaded`.
  static Eigen::VectorXd statics(const superelement::Superelement& se, int held, int loaded,
                                 const Eigen::VectorXd& load) {
    std::vector<int> free;
    for (int k = 0; k < se.n(); ++k)
      if (k < se.interfaces[held].first_dof || k >= se.interfaces[held].first_dof + 6) free.push_back(k);
    Eigen::VectorXd p = Eigen::VectorXd::Zero(se.n()), u = p;
    p.segment(se.interfaces[loaded].first_dof, 6) = load;
    const Eigen::MatrixXd K = se.K_se(free, free);
    u(free) = K.ldlt().solve(Eigen::VectorXd(p(free))).eval();
    return u;
  }

  Folder folder_;
};

}  // namespace flexura::test
