// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mbs/file/bodies/body_surfaces.hpp"
#include "mbs/file/elements/read_context.hpp"
#include "mbs/file/read_markers.hpp"

/// Reads one mechanism file, and through itself the subsystems in it, into one model.  Private to the sources
/// of the reader.
///
/// A subsystem is a mechanism file of its own.  Its bodies, joints and elements get the prefix "NAME."; what
/// it calls ground is a frame on a body of the mechanism that places it; its parameters take the values given
/// there.  Within the file names are as if it stood alone.
namespace flexura::mbs {

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
    return {model_.description,
            parameters_,
            tables_,
            prefix_,
            [this](int marker) { return undeformed_place(model_, marker); },
            [this](const input::Section& s, int body) { return touching_surface(model_, prefix_, s, body); },
            [this](const input::Section& s, const std::string& key, const std::string& prefix, int body) {
              return touched_surface(model_, s, {key, prefix}, body);
            },
            [this](const input::Section& s, const std::string& key, int body) {
              return measured_surface(model_, s, key, body);
            }};
  }
  void read_subsystem(const std::string& name, const input::Section& s);
  void read_body(const std::string& name, const input::Section& s);
  std::shared_ptr<const superelement::Superelement> load(const input::Section& s, const std::string& body);
  void note_user_element(const std::string& name, const input::Section& s);
  void note_long_bearing(const std::string& name, const input::Section& s);
  ReadModel& model_;
  std::filesystem::path file_;
  const input::TableSchema& solver_;
  std::map<std::string, std::vector<std::string>> overrides_below_;  ///< of each subsystem
  std::string prefix_;
  Base base_;
  int depth_;
  int n_beams_ = 0;  ///< of this file
  input::Section root_;
  std::map<std::string, double> parameters_;
  Curves tables_;
  std::vector<std::unique_ptr<Reader>> subsystems_;
  std::vector<std::pair<std::size_t, input::Section>> joints_;  ///< of the file, by their places
};

}  // namespace flexura::mbs
