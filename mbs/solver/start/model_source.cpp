// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/model_source.hpp"

#include <fmt/format.h>

#include "mbs/solver/accuracy/options.hpp"

namespace flexura::mbs {

void ModelChoice::add(const ModelChoice& later) {
  for (const auto& [name, model] : later.bodies) {
    BodyModel& mine = bodies[name];
    if (!model.fidelity.empty()) mine.fidelity = model.fidelity;
    if (model.modes) mine.modes = model.modes;
    if (model.responses) mine.responses = model.responses;
    if (!model.boundary.empty()) mine.boundary = model.boundary;
    if (!model.frame.empty()) mine.frame = model.frame;
    if (!model.coupling.empty()) mine.coupling = model.coupling;
    if (model.elements > 0) mine.elements = model.elements;
  }
  if (later.tolerance) tolerance = later.tolerance;
  if (later.absolute_factor) absolute_factor = later.absolute_factor;
}

ModelChoice ModelChoice::with(const ModelChoice& later) const {
  ModelChoice out = *this;
  out.add(later);
  return out;
}

std::string table_of(const std::string& body) {
  const auto dot = body.find('.');
  return dot == std::string::npos
             ? "body." + body
             : fmt::format("subsystem.{}.{}", body.substr(0, dot), table_of(body.substr(dot + 1)));
}

std::vector<std::string> words_of(const ModelChoice& choice) {
  std::vector<std::string> out;
  if (choice.tolerance) out.push_back(fmt::format("solver.tolerance={:.3g}", *choice.tolerance));
  if (choice.absolute_factor)
    out.push_back(fmt::format("solver.absolute_factor={:g}", *choice.absolute_factor));
  for (const auto& [name, model] : choice.bodies) {
    const auto say = [&](const char* key, const std::string& value) {
      out.push_back(fmt::format("{}.{}={}", table_of(name), key, value));
    };
    if (!model.coupling.empty()) say("coupling", model.coupling);
    if (model.modes) {
      say("max_frequency", "");
      say("modes", *model.modes == BodyModel::kAllModes ? "" : std::to_string(*model.modes));
    }
    if (model.responses) say("attachments", *model.responses ? "used" : "none");
    if (!model.frame.empty()) say("frame", model.frame);
    if (!model.boundary.empty()) say("boundary", model.boundary);
    if (!model.fidelity.empty()) say("fidelity", model.fidelity);
    if (model.elements > 0) say("beam.elements", std::to_string(model.elements));
  }
  return out;
}

MechanismFile FileSource::read(const ModelChoice& choice, PreparationCache& cache) const {
  std::vector<std::string> all = overrides_;
  const std::vector<std::string> more = words_of(choice);
  all.insert(all.end(), more.begin(), more.end());
  return read_mechanism(file_, solver_schema(), all, &cache);
}

void FileSource::add_to(input::ContentHash& hash) const {
  hash.add_input_file(file_);
  for (const std::string& word : overrides_)
    hash.add(word.starts_with("parameters.") ? word.substr(0, word.find('=')) : word);
}

}  // namespace flexura::mbs
