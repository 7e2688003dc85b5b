// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/file/read_mechanism.hpp"

/// How a mechanism's bodies are modelled, as an object, and what makes the mechanism anew with it: a file, or a program.
namespace flexura::mbs {

/// Of one body.  What is empty stays as its source has it.
struct BodyModel {
  static constexpr int kAllModes = std::numeric_limits<int>::max();

  std::string fidelity = {};           ///< one of fidelities(), by its name
  std::optional<int> modes = {};       ///< eigenmodes, lowest first, of all frequencies
  std::optional<bool> responses = {};  ///< response modes for what acts on the body, beside them
  std::string boundary = {};           ///< "free", "joint"
  std::string frame = {};              ///< "mean_axis", "joint_fixed", "joints"
  std::string coupling = {};           ///< "full", "partial", "constant"
  int elements = 0;                    ///< of a beam
};

struct ModelChoice {
  std::map<std::string, BodyModel> bodies = {};                ///< by name, of a subsystem's "left.rod"
  std::optional<double> tolerance = {}, absolute_factor = {};  ///< of the integrator

  /// What `later` says takes the place of what is said here.
  void add(const ModelChoice& later);
  ModelChoice with(const ModelChoice& later) const;
};

/// The body's table for overrides: "body.rod", of a subsystem's "left.rod" "subsystem.left.body.rod".
std::string table_of(const std::string& body);

/// The choice as keys of a mechanism file: "body.rod.fidelity=modal".
std::vector<std::string> words_of(const ModelChoice& choice);

class ModelSource {
 public:
  virtual ~ModelSource() = default;
  /// The mechanism with its bodies modelled so.  Throws input::InputError, std::invalid_argument.
  virtual MechanismFile read(const ModelChoice& choice, PreparationCache& cache) const = 0;
  /// What it is called in messages: the file's path.
  virtual std::string name() const = 0;
  /// Keys with which the file was read besides.
  virtual std::vector<std::string> words() const { return {}; }
  /// The content, for what is kept of it; keys of [parameters] by their names alone.
  virtual void add_to(input::ContentHash& hash) const = 0;
};

class FileSource final : public ModelSource {
 public:
  explicit FileSource(std::filesystem::path file, std::vector<std::string> overrides = {})
      : file_(std::move(file)), overrides_(std::move(overrides)) {}

  MechanismFile read(const ModelChoice& choice, PreparationCache& cache) const override;
  std::string name() const override { return file_.string(); }
  std::vector<std::string> words() const override { return overrides_; }
  void add_to(input::ContentHash& hash) const override;

 private:
  std::filesystem::path file_;
  std::vector<std::string> overrides_;
};

}  // namespace flexura::mbs
