// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/base/documents/document.hpp"

/// Parts that are reduced because a run wants them: `flexura simulate --reduce`.
///
/// A body that is to deform and whose superelement is not there, or is the rigid one of an import, gets one made of the part file
/// beside it (NAME.toml of NAME.se.h5) by `flexura-reduce`, a program of its own.  Its joints need interfaces: those that the
/// part file has; "faceN", which an import calls face N of the CAD file; and for a joint's marker on no interface the face nearest to it.
/// Bodies of one part, in subsystems too, share one superelement with all their interfaces.  What is made is kept by the content of the part file, its geometry
/// and the programs, beside the part (reduced/) or where the caller says; no file of the user's is replaced.
///
/// Where the mesh's share of the error of a run is above half of the accuracy that was asked (shared by its bodies), refine()
/// reduces anew for that, then for as much less as the last estimate was above, three times at most.
namespace flexura::study {

/// What the mesh and the modes of a reduction cost in a body's deformation, relative; nothing where it is not known.
struct MeshOfBody {
  std::string body;
  std::optional<double> error;
};

/// What is told of the work.
struct Telling {
  std::function<void(std::string_view stage)> progress;   ///< of what is being reduced now
  std::function<void(const std::string& sentence)> note;  ///< what was made
  std::function<void(const std::string& sentence)>
      warning;  ///< what the reduction warns of, what could not be made
};

class PartsOnDemand {
 public:
  /// `bin`: the folder of the programs. `cache`: empty for a folder beside each part. `run_scripts`: parts may name scripts.
  PartsOnDemand(std::filesystem::path mechanism, std::filesystem::path bin, std::filesystem::path cache,
                bool run_scripts, Telling telling);

  /// The overrides ("body.rod.superelement=...") with which the mechanism's runs (all, or those named) find what they want, as they are
  /// with the overrides `set`.  Throws input::InputError where the mechanism cannot be read, a part file is not there or is refused, std::runtime_error where a
  /// reduction fails.
  std::vector<std::string> provide(const std::vector<std::string>& set, const std::vector<std::string>& runs);

  /// Overrides for finer reductions; none where the meshes are good enough, or where nothing finer can be made.
  std::vector<std::string> refine(const std::vector<MeshOfBody>& meshes, double accuracy);

 private:
  struct Part {
    std::filesystem::path file;
    std::vector<std::string> known;                               ///< interfaces in the file
    bool has_mesh = false;                                        ///< parts of beams have none to refine
    std::map<std::string, std::string> added = {};                ///< interfaces by name, as inline tables
    std::map<std::string, std::string> at_place = {};             ///< those of markers on none, by place
    std::map<std::string, std::vector<std::string>> bodies = {};  ///< overrides of their markers, by key
    std::vector<std::string> wanted = {};  ///< keys of bodies that have no superelement to go on with
    double accuracy = 0.0;                 ///< asked of the last reduction; 0: the part file's own
    int rounds = 0;
    std::filesystem::path made = {};
  };
  /// A mechanism file, alone or as a subsystem: "left." before the names of its bodies, "subsystem.left." before their keys.
  struct Document {
    std::string prefix, keys;
    input::Section root;
  };
  void collect(const std::vector<std::string>& overrides);
  void collect(const Document& document, const std::vector<std::string>& places, double accuracy);
  static void add_documents(std::vector<Document>& all, Document document,
                            const std::vector<std::string>& overrides);
  void reduce(const std::string& name, Part& part);
  std::vector<std::string> overrides_for(const Part& part, const std::vector<std::string>& keys) const;

  std::filesystem::path mechanism_, bin_, cache_;
  bool run_scripts_;
  Telling telling_;
  std::map<std::string, Part> parts_;           ///< by the path of the superelement that the file names
  std::map<std::string, std::string> part_of_;  ///< of a body, "left.rod" of a subsystem
};

}  // namespace flexura::study
