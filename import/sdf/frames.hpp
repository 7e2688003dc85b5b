// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "import/model/mechanism.hpp"
#include "import/xml/node.hpp"

namespace flexura::import::sdf {

/// Six numbers of a <pose>: x, y, z and turns about x, y, z that stand (R = R_z R_y R_x), or x, y, z and a quaternion x, y, z, w.
Pose pose_in(const xml::Node& element, Findings& findings);

/// Named frames, each given in another one (SDF, "Pose frame semantics"): models, links, joints and <frame>s by full names, "arm::hand"; a model's
/// own frame is "arm::__model__".
class Frames {
 public:
  struct Frame {
    std::string parent;
    Pose X;
    std::string placed = {};  ///< the frame of this model that stands at X, instead of its own
    std::string link = {};    ///< that it is attached to, or a frame that is
  };
  void add(const std::string& name, const Frame& frame) { frames_.emplace(name, frame); }
  bool has(const std::string& name) const { return name == "world" || frames_.contains(name); }
  const Frame* find(const std::string& name) const;

  /// In the world.  Throws std::invalid_argument where frames are given in each other, or in one that is not there.
  Pose in_world(const std::string& name) const { return in(name, "world", 0); }

 private:
  Pose in(const std::string& name, const std::string& base, int depth) const;

  std::map<std::string, Frame> frames_;
};

}  // namespace flexura::import::sdf
