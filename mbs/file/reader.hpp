// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/file/elements/read_context.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/file/read_flexible_body.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/mechanism/beam_part.hpp"

/// Reads one mechanism file, and through itself the subsystems in it, into one model.  Private to the sources
/// of the reader.
///
/// A subsystem is a mechanism file of its own.  Its bodies, joints and elements get the prefix "NAME."; what
/// it calls ground is a frame on a body of the mechanism that places it; its parameters take the values given
/// there.  Within the file names are as if it stood alone.
namespace flexura::mbs {

/// What all files of a mechanism are read into.
struct ReadModel {
  PreparationCache& cache;
  MechanismDescription description = {};
  std::vector<std::string> notes = {};
  std::map<int, input::Section> sections = {};  ///< of bodies
  std::map<int, std::vector<std::pair<std::string, Vector3d>>> interfaces = {};
  std::set<int> joined = {};  ///< bodies with a joint
  /// Of deforming bodies; they are prepared when it is known what acts on them.
  std::map<int, std::shared_ptr<const superelement::Superelement>> to_prepare = {};
  std::map<int, std::vector<BodyNode>> linked = {};  ///< nodes of deforming bodies beside their interfaces
  std::map<int, Segments> segments = {};             ///< beams cut into pieces, by the piece at the root
  std::vector<BlindSpot> blind_spots = {};

  bool deforms(int body) const { return to_prepare.contains(body) || description.bodies[body].flexible; }
};

/// Bodies that nothing holds get six freedoms to ground.
void add_free_joints(ReadModel& model);

/// Flexible bodies from their superelements and what acts on them, after everything else is read.
void prepare_bodies(ReadModel& model);

class Reader {
 public:
  Reader(ReadModel& model, const std::filesystem::path& file, const input::TableSchema& solver,
         const std::vector<std::string>& overrides);

  const input::Section& root() const { return root_; }
  void read_bodies();    ///< markers too, its own and those of its subsystems
  void read_joints();    ///< after all bodies
  void read_elements();  ///< after all joints and their signals: constraints, measures, controls, forces

 private:
  struct Base {
    int body = 0;
    Pose X_BG;  ///< what the file calls ground
  };
  Reader(ReadModel& model, const std::filesystem::path& file, const input::TableSchema& solver,
         const std::vector<std::string>& overrides, std::string prefix, Base base, int depth);
  ReadContext context() const {
    return {model_.description, parameters_, tables_, prefix_,
            [this](int marker) { return undeformed(marker); }};
  }
  /// See ReadContext::Undeformed; flexible bodies need not be prepared yet.
  std::pair<int, Pose> undeformed(int marker) const;
  void read_subsystem(const std::string& name, const input::Section& s);
  void read_body(const std::string& name, const input::Section& s);
  std::shared_ptr<const superelement::Superelement> load(const input::Section& s);
  void read_markers(const input::Section& s, int body, const Pose& X_B, const std::string& owner,
                    bool deforms, const superelement::Superelement* se = nullptr);
  std::pair<int, Vector3d> carrying_node(const input::Section& marker, int body, const std::string& name,
                                         bool deforms, const superelement::Superelement* se);
  void note_user_element(const std::string& name, const input::Section& s);
  /// `node` is one of a deforming body, or -1.
  /// At X in the body, or beside its node; of a beam in segments on the piece that is where it is carried (in the body).
  void add_marker(int body, const std::string& full_name, const Pose& X, int node,
                  const Vector3d& carried_at);

  ReadModel& model_;
  std::filesystem::path file_;
  const input::TableSchema& solver_;
  std::map<std::string, std::vector<std::string>> overrides_below_;  ///< of each subsystem
  std::string prefix_;
  Base base_;
  int depth_;
  input::Section root_;
  std::map<std::string, double> parameters_;
  Curves tables_;
  std::vector<std::unique_ptr<Reader>> subsystems_;
};

}  // namespace flexura::mbs
