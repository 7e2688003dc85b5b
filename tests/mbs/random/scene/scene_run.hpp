// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "tests/mbs/random/scene/scene.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// A scene, run by the program from its file.
namespace flexura::mbs::chance {

/// In the scene's units and with the scene's numbers of bodies, whatever the file says.
struct RanRow {
  double t = 0.0, kinetic = 0.0, potential = 0.0;  ///< energies as the program says; potential with strain
  std::vector<BodyMotion> motion;
  std::vector<std::vector<double>> coordinates, speeds;  ///< of the joints, as the program says
};

struct Ran {
  enum class End { complete, stopped, refused, broken } end = End::broken;
  std::string message;
  std::vector<RanRow> rows;
  double balance = 0.0;
  long steps = 0;
  std::string warning;  ///< of rows near rank loss
  std::string sentence() const {
    return end == End::complete ? "complete" : (end == End::stopped ? "stopped: " : "refused: ") + message;
  }
};

/// What the program may throw: what it has a sentence for.
bool is_documented(const std::exception& e);

/// Writes FILE.toml, `file` followed by the writing's suffix, and the parts beside it; returns its name.
std::string to_file(const Scene& scene, const Writing& how, const std::string& file);
Ran simulate(const Scene& scene, const Writing& how, const std::string& file);

/// What a mechanism made from a scene's file says of a state.
class RowReader {
 public:
  RowReader(const Scene& scene, const Writing& how, const Mechanism& mechanism);
  RanRow read(const State& s, const Eigen::VectorXd& v_dot);

 private:
  void read_body(int body, const MarkerState& x, const State& s, const Eigen::VectorXd& v_dot,
                 BodyMotion& out) const;
  Eigen::VectorXd modal(int body, const double* values) const;
  MarkerState marker(const std::string& name, const State& s, const std::vector<MarkerState>& bodies) const;
  void read_ends(const State& s, const std::vector<MarkerState>& bodies, RanRow& row) const;
  void read_coordinates(const State& s, const Eigen::VectorXd& v_dot, RanRow& row);

  const Scene& scene_;
  const Writing how_;
  const Mechanism& m_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::vector<int>
      modal_speed_;         ///< of each body of the mechanism: first of its modal coordinates in v, or -1
  std::vector<int> which_;  ///< quantities: the joints' coordinates
  Eigen::VectorXd values_;
};

/// Of two motions: largest way over `size`, or turn.
double difference(const std::vector<BodyMotion>& a, const std::vector<BodyMotion>& b, double size);
/// At the rows that both have.
double difference(const Ran& a, const Ran& b, double size);

}  // namespace flexura::mbs::chance
