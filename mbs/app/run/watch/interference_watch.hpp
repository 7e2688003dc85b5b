// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mbs/proximity/surface.hpp"
#include "mbs/solver/start/prepare.hpp"

/// `flexura simulate --interferences`: bodies whose surfaces overlap in the stored rows of a run.
///
/// A surface is that of the superelement, deformed where the body is, or the shapes of the file.  A pair is told where one is in
/// the other by more than the tolerance and what the flat facets of both may be off (Surface::facet_error()); bodies that a
/// joint connects by more than they overlap at the start besides: pins in bores are drawn so.  Between rows nothing is looked at.
namespace flexura::app {

class InterferenceWatch {
 public:
  /// `tolerance` [m].
  InterferenceWatch(const mbs::PreparedMechanism& prepared, double tolerance);

  /// A row: poses X_WB and modal coordinates of all bodies, the ground first.
  void take(double t, const std::vector<mbs::Pose>& poses, const std::vector<Eigen::VectorXd>& modal);

  /// How far [m] points of two bodies that may have met between two rows moved past each other from the one to the other:
  /// what is thinner was not seen.
  double blind_way() const { return blind_way_; }
  /// [s] that it has taken so far.
  double wall() const { return wall_; }

  /// A sentence for each pair, the deepest first, the first ten; and one for what could not be judged.
  std::vector<std::string> sentences() const;
  /// [{"bodies": [a, b], "depth" (null where unknown), "time", "point", "from", "to", "times"}], SI.
  nlohmann::json json() const;

 private:
  struct Body {
    std::string name;
    std::vector<proximity::Surface> surfaces;
    /// Of a body that deforms: its one surface undeformed, and displacements of the vertices by modal coordinate.
    Eigen::Matrix3Xd vertices;
    Eigen::MatrixXd shapes;
    double radius = 0.0;  ///< of a sphere about Bo that holds all of it
    bool is_closed = true;
    double facet_error = 0.0;
  };
  struct Pair {
    int a = 0, b = 0;
    bool is_joined = false;
    std::optional<mbs::Pose> X_AB{};      ///< that was looked at last, of rigid bodies
    std::optional<mbs::Pose> row_X_AB{};  ///< at the last row
    bool was_met = false;                 ///< then
    double at_start = 0.0;                ///< depth
    bool seen = false;                    ///< the start
    std::optional<double> depth{};        ///< the greatest
    bool is_unknown = false;              ///< they cross, and how deep is not known
    double t = 0.0, from = 0.0, to = 0.0;
    int times = 0;  ///< that they came together
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    bool is_told() const { return times > 0; }
  };
  void add_surfaces(const mbs::MechanismDescription& d, std::size_t b);
  void look(double t, const std::vector<mbs::Pose>& poses, Pair& pair) const;
  static void meet(double t, bool now, Pair& pair);
  std::string sentence(const Pair& pair) const;
  std::vector<const Pair*> told() const;

  void pass(const mbs::Pose& X_AB, double reach, Pair& pair);

  double tolerance_, wall_ = 0.0, blind_way_ = 0.0;
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
};

}  // namespace flexura::app
