// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/library/part_source.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "mbs/bodies/modal_basis.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/complete_model.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/mechanism/beam_superelement.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs {
namespace {

// The keys of a flexible body, as its table in a file has them.
input::Section section_of(const std::string& name, const BodyModel& model) {
  input::TableSchema schema;
  schema.name = "body";
  schema.doc = "A flexible body.";
  schema.keys = flexible_body_keys();
  std::string text;
  for (const std::string& word : words_of({.bodies = {{"x", model}}})) {
    const auto equals = word.find('=');
    const std::string key =
                          word.substr(std::string("body.x.").size(), equals - std::string("body.x.").size()),
                      value = word.substr(equals + 1);
    if (value.empty() || key == "beam.elements") continue;
    const bool is_number = value.find_first_not_of("0123456789") == std::string::npos;
    text += is_number ? fmt::format("{} = {}\n", key, value) : fmt::format("{} = \"{}\"\n", key, value);
  }
  return input::read_text_document("body " + name, text, schema);
}

// The first `n` markers, those on stations of the beam: where these are now.
void move_markers(MechanismDescription& d, std::size_t n, int body, const Segments& chain) {
  for (std::size_t i = 0; i < n; ++i) {
    MarkerDescription& marker = d.markers[i];
    if (marker.body != body || chain.seats.empty()) continue;
    const Segments::Seat seat =
        marker.node < 0 ? Segments::Seat{body, -1} : chain.seats[static_cast<std::size_t>(marker.node)];
    marker.X_BP.p += seat.p;
    marker.body = seat.body;
    marker.node = seat.node;
  }
}

void hold_markers(MechanismDescription& d, int body,
                  const std::vector<std::pair<std::string, Vector3d>>& interfaces) {
  for (MarkerDescription& marker : d.markers) {
    if (marker.body != body || marker.node < 0) continue;
    marker.X_BP.p += interfaces[static_cast<std::size_t>(marker.node)].second;
    marker.node = -1;
  }
}

}  // namespace

PartSource::PartSource(const MechanismBuilder& builder, RunSettings settings)
    : d_(builder.description()), open_(builder.open()), settings_(std::move(settings)) {
  for (const auto& [name, value] :
       {std::pair("end_time", settings_.end_time), std::pair("tolerance", settings_.tolerance)})
    if (!(value > 0.0) || !std::isfinite(value))
      throw std::invalid_argument(fmt::format("the {} of a run is {}; give a number above 0", name, value));
  for (const auto& [name, value] :
       {std::pair("output_step", settings_.output_step), std::pair("accuracy", settings_.accuracy)})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument(
          fmt::format("the {} of a run is {}; give 0 or a number above", name, value));
}

MechanismFile PartSource::read(const ModelChoice& choice, PreparationCache& cache) const {
  ReadModel model{cache};
  model.description = d_;
  MechanismDescription& d = model.description;
  std::map<std::string, bool> leaves_open;
  std::vector<std::string> deformable;
  for (const auto& [b, open] : open_) {
    const std::string name = d.bodies[static_cast<std::size_t>(b)].name;
    ModelChoice all{.bodies = {{name, open.model}}};
    if (const auto found = choice.bodies.find(name); found != choice.bodies.end())
      all.add({.bodies = {*found}});
    const BodyModel& wanted = all.bodies[name];
    const input::Section s = section_of(name, wanted);
    const Fidelity& fidelity = fidelity_of(s);
    deformable.push_back(name);
    if (!open.model.fidelity.empty()) leaves_open[name] = open.model.fidelity == kAutomaticFidelity;
    BodyDescription& body = d.bodies[static_cast<std::size_t>(b)];
    BeamPart beam = open.beam.value_or(BeamPart{});
    if (wanted.elements > 0) beam.elements = wanted.elements;
    if (open.beam && fidelity.of_beam && fidelity.of_beam->has_elements) {
      const std::size_t n_markers = d.markers.size();
      const Segments chain = fidelity.of_beam->make(d, b, beam);
      move_markers(d, n_markers, b, chain);
      model.blind_spots.push_back(
          {"elements", name, "a run with twice as many tells", "elements", beam.elements});
      continue;
    }
    if (!fidelity.of_superelement)
      throw std::invalid_argument(
          fmt::format("body \"{}\": fidelity \"{}\" is for beams; add it as a Beam", name, fidelity.name));
    std::shared_ptr<const superelement::Superelement> se;
    if (open.beam) {
      se = body.of_beam = cache.made(key_of(beam), [&] { return beam_superelement(beam); });
    } else {
      superelement::Parts parts;
      parts.matrices = fidelity.of_superelement->deforms();
      parts.stiffening = fidelity.of_superelement->is_stiffened;
      se = cache.read(open.superelement, parts);
    }
    body.loads = body_loads(*se);
    if (fidelity.of_superelement->deforms()) {
      model.to_prepare.emplace(b, se);
      model.sections.emplace(b, s);
      continue;
    }
    body.inertia = open.beam ? rigid_inertia(beam) : rigid_inertia(*se);
    hold_markers(d, b, open.interfaces);
  }
  prepare_bodies(model);

  std::string text =
      fmt::format("end_time = {:.17g}\noutput_step = {:.17g}\n", settings_.end_time,
                  settings_.output_step > 0.0 ? settings_.output_step : settings_.end_time / 200.0);
  text += fmt::format("tolerance = {:.17g}\n", choice.tolerance.value_or(settings_.tolerance));
  if (choice.absolute_factor) text += fmt::format("absolute_factor = {:.17g}\n", *choice.absolute_factor);
  if (settings_.accuracy > 0.0) text += fmt::format("accuracy = {:.17g}\n", settings_.accuracy);
  if (!settings_.method.empty()) text += fmt::format("method = \"{}\"\n", settings_.method);
  MechanismFile out{
      d.name, "", std::move(d),           settings_.outputs,
      {},     {}, std::move(model.notes), input::read_text_document("run settings", text, solver_schema())};
  out.runs.push_back({"run", {}});
  out.leaves_fidelity_open = std::move(leaves_open);
  out.blind_spots = std::move(model.blind_spots);
  out.deformable = std::move(deformable);
  return out;
}

// What a program holds has no content that could be told apart: each source is its own.
void PartSource::add_to(input::ContentHash& hash) const {
  hash.add(fmt::format("program {:p}", static_cast<const void*>(this)));
}

}  // namespace flexura::mbs
