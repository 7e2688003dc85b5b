// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "mbs/superelement/superelement.hpp"

/// The largest displacement and von Mises stress of a flexible body: over all stored rows and all vertices, whatever the
/// page keeps of them for drawing.
namespace flexura::view {

struct Largest {
  double value = 0.0;       ///< [m] or [Pa]
  Eigen::Index row = 0;     ///< of the run
  Eigen::Index vertex = 0;  ///< of the superelement's surface
};

/// A frame fixed to the body, from which its displacement may be taken.
struct ReferenceFrame {
  std::string name;
  Eigen::Vector3d p;  ///< [m] in B
  Eigen::Matrix<double, 6, Eigen::Dynamic>
      motion{};  ///< by each modal coordinate: displacement [m], rotation [rad]
};

/// The interfaces that have a rotation as well, moved by the columns of `basis` (n_se x m).
std::vector<ReferenceFrame> reference_frames(const superelement::Superelement& se,
                                             const Eigen::MatrixXd& basis);

/// By the page's names of what displacement counts from: "own" (the floating frame), "interface:NAME" of each of `frames`,
/// and since the start seen from "ground" and from "body:NAME", each of `observers` (its pose in every row, see
/// results::BodyHistory).  One that has the poses of the body itself gives what "own" gives.
std::map<std::string, Largest> largest_displacements(
    const superelement::Superelement& se, const results::BodyHistory& body,
    const std::vector<ReferenceFrame>& frames, const std::vector<const results::BodyHistory*>& observers);

/// Over the places that have stress modes; nothing where there are none.  Where the run stores NAME.von_mises it is this, at the
/// vertex next to NAME.von_mises_x, _y, _z: it holds what loads and accelerations add inside the body, too.  Otherwise it is
/// that of the shapes alone.
std::optional<Largest> largest_stress(const superelement::Superelement& se, const results::BodyHistory& body,
                                      const results::Run& run);

/// What the shapes alone make at the vertex and the row of `most` [Pa]: it is drawn there.
double drawn_stress(const superelement::Superelement& se, const results::BodyHistory& body,
                    const Largest& most);

}  // namespace flexura::view
