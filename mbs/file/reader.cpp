// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mbs/base/documents/plausible.hpp"
#include "mbs/bodies/modal_basis.hpp"
#include "mbs/file/bodies/read_body.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/bodies/read_pose.hpp"
#include "mbs/file/bodies/read_section_points.hpp"
#include "mbs/file/complete_model.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/mechanism_document.hpp"
#include "mbs/file/read_joint.hpp"
#include "mbs/file/read_linked_marker.hpp"
#include "mbs/file/read_markers.hpp"
#include "mbs/file/read_tables.hpp"
#include "mbs/file/subsystem_overrides.hpp"
#include "mbs/formulas/parameters.hpp"
#include "mbs/mechanism/beam_superelement.hpp"

namespace flexura::mbs {
namespace {

using input::Section;

constexpr int deepest = 20;
// In all: files of 330 bytes that place one another ten times each make 1e12 bodies.
constexpr int most_subsystems = 1000;
constexpr std::uintmax_t most_bytes = 10'000'000;
// With their stations at rest, of all beams of a file together, and of each.
constexpr int modes_of_beams = 240, least_modes_of_beam = 6, most_modes_of_beam = 60, most_judged_beams = 40;

template <class Types>
const auto& find_type(const Types& types, const std::string& name) {
  return *std::ranges::find_if(types, [&](const auto& type) {
    return type.name == name || std::ranges::find(type.synonyms, name) != type.synonyms.end();
  });
}

std::string in_words(const Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x(), v.y(), v.z());
}

Section read_file(const std::filesystem::path& file, const input::TableSchema& solver,
                  const std::vector<std::string>& overrides) {
  const auto formulas = [](const Section& root) { return evaluate_with(read_parameters(root)); };
  return input::read_document(file, mechanism_schema(solver), overrides, formulas);
}

}  // namespace

Section read_mechanism_document(const std::filesystem::path& file, const input::TableSchema& solver,
                                const std::vector<std::string>& overrides) {
  std::map<std::string, std::vector<std::string>> below;
  return read_file(file, solver, take_overrides_below(overrides, below));
}

std::vector<PlacedFile> placed_files(const Section& root, const std::vector<std::string>& overrides) {
  std::map<std::string, std::vector<std::string>> below;
  take_overrides_below(overrides, below);
  const std::map<std::string, double> parameters = read_parameters(root);
  std::vector<PlacedFile> out;
  for (const auto& [name, s] : root.table_map("subsystem"))
    out.push_back({name, s.file("file"), overrides_of_placed(s, parameters, below[name])});
  return out;
}

Reader::Reader(ReadModel& model, const std::filesystem::path& file, const input::TableSchema& solver,
               const std::vector<std::string>& overrides)
    : Reader(model, file, solver, overrides, "", Base{}, 0) {}

Reader::Reader(ReadModel& model, const std::filesystem::path& file, const input::TableSchema& solver,
               const std::vector<std::string>& overrides, std::string prefix, Base base, int depth)
    : model_(model),
      file_(file),
      solver_(solver),
      prefix_(std::move(prefix)),
      base_(std::move(base)),
      depth_(depth),
      root_(read_file(file, solver, take_overrides_below(overrides, overrides_below_))),
      parameters_(read_parameters(root_)),
      tables_(read_tables(root_)) {
  if (const auto& remarks = root_.remarks(); !remarks.empty())
    model_.notes.push_back(remarks.front() +
                           (remarks.size() > 1 ? fmt::format("; so with {} more", remarks.size() - 1) : ""));
  const auto subsystems = root_.table_map("subsystem");
  for (const auto& [name, below] : overrides_below_)
    if (std::ranges::none_of(subsystems, [&](const auto& entry) { return entry.first == name; })) {
      std::vector<std::string> known;
      for (const auto& [other, s] : subsystems) known.push_back(other);
      throw input::InputError(fmt::format("command line: subsystem.{}.{}: there is no such subsystem{}", name,
                                          below.front(), input::suggestion(name, known)));
    }
}

void Reader::read_bodies() {
  MechanismDescription& d = model_.description;
  for (const auto& [name, s] : root_.table_map("force"))
    for (const std::string& key : find_type(force_types(), s.text("type")).surfaces_of)
      if (s.has(key)) model_.surfaces_in_use.insert(prefix_ + s.text(key));
  for (const auto& [name, s] : root_.table_map("measure"))
    for (const std::string& key : find_type(measure_types(), s.text("type")).meshes_of)
      model_.surfaces_in_use.insert(prefix_ + s.text(key));
  const Section ground = root_.table("ground");
  if (prefix_.empty()) {
    d.bodies[0].shape_json = shapes_json(ground);
  } else {
    d.markers.push_back({prefix_ + "ground", base_.body, base_.X_BG, -1});
  }
  read_markers(model_, ground, base_.body, base_.X_BG, prefix_ + "ground", false);
  const auto bodies = root_.table_map("body");
  n_beams_ = static_cast<int>(std::ranges::count_if(bodies, [](const auto& entry) {
    return entry.second.has("beam") && !entry.second.has("superelement");
  }));
  for (const auto& [name, s] : bodies) read_body(name, s);
  for (const auto& [name, s] : root_.table_map("subsystem")) read_subsystem(name, s);
}

void Reader::read_subsystem(const std::string& name, const Section& s) {
  if (depth_ >= deepest)
    s.refuse("file",
             fmt::format("lies {} files deep, each placed by the one before; at most {} are taken",
                         deepest + 1, deepest),
             "a file must not place itself");
  if (name == "ground") s.refuse("", "is the name of the world", "choose another name");
  for (const BodyDescription& body : model_.description.bodies)
    if (body.name == prefix_ + name) s.refuse("", "has the name of a body", "choose another name");
  Base base = base_;
  if (s.has("on")) {
    const int index = context().marker(s, "on");
    const MarkerDescription& marker = model_.description.markers[static_cast<std::size_t>(index)];
    Pose X = marker.X_BP;
    if (marker.node >= 0) {
      const auto to_prepare = model_.to_prepare.find(marker.body);
      if (to_prepare == model_.to_prepare.end() ||
          fidelity_of(model_.sections.at(marker.body)).of_superelement->acts_back)
        s.refuse("on", "is an interface of a flexible body, which deforms",
                 "place the subsystem on a rigid body and join the two");
      X = undeformed_place(model_, index).second;
    }
    base = {marker.body, X};
  }
  base.X_BG = base.X_BG * read_pose(s);

  const auto below = overrides_below_.find(name);
  const std::vector<std::string> overrides = overrides_of_placed(
      s, parameters_, below == overrides_below_.end() ? std::vector<std::string>() : below->second);
  const std::filesystem::path file = s.file("file");
  if (std::error_code none; !std::filesystem::exists(file, none))
    s.refuse("file", "there is no such file",
             "paths start at the folder of the file that places the subsystem");
  if (++model_.n_subsystems > most_subsystems)
    s.refuse("file",
             fmt::format("is placed as subsystem number {} of the mechanism; at most {} are taken",
                         model_.n_subsystems, most_subsystems),
             "do files place one another?");
  std::error_code none;
  if (const std::uintmax_t size = std::filesystem::file_size(file, none);
      size != static_cast<std::uintmax_t>(-1))
    model_.bytes_of_subsystems += size;
  if (model_.bytes_of_subsystems > most_bytes)
    s.refuse("file",
             fmt::format("makes {:.3g} MB of text of all subsystems; at most {:.3g} MB are taken",
                         1e-6 * static_cast<double>(model_.bytes_of_subsystems),
                         1e-6 * static_cast<double>(most_bytes)),
             "place fewer or smaller files");
  if (const auto given = s.formulas("parameters"); !given.empty()) {
    // A misspelt parameter would be a new one that nothing reads.
    const Section plain = read_file(file, solver_, {});
    std::vector<std::string> known;
    for (const auto& [parameter, formula] : plain.formulas("parameters")) known.push_back(parameter);
    for (const auto& [parameter, formula] : given)
      if (std::ranges::find(known, parameter) == known.end())
        s.refuse("parameters", fmt::format("{} has no parameter \"{}\"{}", file.filename().string(),
                                           parameter, input::suggestion(parameter, known)));
  }
  subsystems_.push_back(std::unique_ptr<Reader>(
      new Reader(model_, file, solver_, overrides, prefix_ + name + ".", std::move(base), depth_ + 1)));
  const Section& placed = subsystems_.back()->root();
  // Written for the whole it is read with, as the axes of its bodies' start are.
  if (const Vector3d& g = model_.description.gravity;
      placed.has("gravity") && !placed.vector3("gravity").isApprox(g, 1e-9))
    model_.notes.push_back(fmt::format(
        "subsystem \"{}\": its own {} = {} m/s^2 does not count; the whole falls with {} m/s^2 (world axes)",
        prefix_ + name, placed.where("gravity"), in_words(placed.vector3("gravity")), in_words(g)));
  subsystems_.back()->read_bodies();
}

std::shared_ptr<const superelement::Superelement> Reader::load(const Section& s, const std::string& body) {
  const std::filesystem::path path = s.file("superelement");
  superelement::Parts parts;
  const Fidelity::OfSuperelement& fidelity = *fidelity_of(s).of_superelement;
  parts.matrices = fidelity.deforms();
  parts.stiffening = fidelity.is_stiffened;
  const bool by_surface = a_marker_follows_surface(s) || model_.surfaces_in_use.contains(body);
  parts.stress = wants_stress(s);
  parts.sections = parts.matrices && wants_sections(s);
  parts.surface = parts.stress || by_surface || wants_surface_points(s);
  parts.shapes = parts.matrices && (by_surface || wants_surface_points(s));
  try {
    return model_.cache.read(path, parts);
  } catch (const std::runtime_error& error) {
    throw input::InputError(s.where("superelement") + ": " + error.what());
  }
}

void Reader::read_body(const std::string& own_name, const Section& s) {
  if (own_name == "ground") s.refuse("", "is the name of the world", "choose another name");
  MechanismDescription& d = model_.description;
  BodyDescription body;
  body.name = prefix_ + own_name;
  // "s.p" may stand in the file itself and be the body p of the subsystem s.
  for (const BodyDescription& other : d.bodies)
    if (other.name == body.name)
      s.refuse("",
               fmt::format(
                   "would be called \"{}\" in the mechanism, as another body is (of a subsystem, or in the "
                   "file that places it)",
                   body.name),
               "choose another name");
  std::vector<std::pair<std::string, Vector3d>> interfaces;
  const Fidelity& fidelity = fidelity_of(s);
  const bool is_beam =
      s.has("beam") && fidelity.of_beam && !(fidelity.of_superelement && s.has("superelement"));
  const bool is_reduced_beam = s.has("beam") && !s.has("superelement") && fidelity.of_superelement &&
                               fidelity.of_superelement->deforms();
  if (!fidelity.of_superelement && !is_beam)
    s.refuse("fidelity", fmt::format("\"{}\" is for beams", fidelity.name),
             fmt::format("describe the beam in [body.{}.beam]", own_name));
  refuse_keys_of_others(s);
  std::shared_ptr<const superelement::Superelement> se;
  BeamPart beam;
  if (is_beam || is_reduced_beam) {
    const Section part = s.table("beam");
    beam = read_beam_part(part, is_beam ? fidelity.of_beam->use : BeamUse{.may_be_planar = true});
    if (part.has("young") && part.has("density"))
      if (const std::string odd =
              input::odd_material(body.name, 1.5 * part.quantity("young") / (1.0 + part.quantity("poisson")),
                                  part.quantity("density"));
          !odd.empty())
        model_.notes.push_back("warning: " + odd);
    interfaces = beam.stations();
    // Of many rigid beams the estimate would cost more than the run.
    const bool is_judged = is_reduced_beam || n_beams_ <= most_judged_beams;
    if (is_judged && (is_reduced_beam || !fidelity.of_beam->has_elements)) {
      const int modes =
          std::clamp(modes_of_beams / std::max(1, n_beams_), least_modes_of_beam, most_modes_of_beam);
      try {
        body.of_beam = model_.cache.made(fmt::format("{} {}", key_of(beam), modes),
                                         [&] { return beam_superelement(beam, modes); });
      } catch (const std::invalid_argument& error) {
        s.refuse("beam", error.what());
      }
    }
    if (is_reduced_beam) se = body.of_beam;
  } else if (s.has("superelement")) {
    se = load(s, body.name);
    body.superelement = s.file("superelement").string();
    const bool is_touched = model_.surfaces_in_use.contains(body.name);
    body.follows_surface = a_marker_follows_surface(s) || is_touched;
    if (is_touched) model_.with_surface.emplace(static_cast<int>(d.bodies.size()), se);
    body.loads = body_loads(*se);
    for (const superelement::Interface& i : se->interfaces) interfaces.emplace_back(i.name, i.p_BoN_B);
    if (!fidelity.of_superelement->deforms()) {
      body.inertia = rigid_inertia(*se);
      if (wants_surface_points(s)) body.surface_points = read_surface_points(s, *se, nullptr);
    }
  } else {
    body.inertia = read_inertia(s);
  }
  if (body.of_beam && !is_reduced_beam && wants_surface_points(s))
    body.surface_points = read_surface_points(s, *body.of_beam, nullptr);
  else if (!se && wants_surface_points(s))
    s.refuse("surface_point", "the body has no superelement, whose surface has nodes",
             "give it one, or measure at a marker");
  if (is_placed(s) || !prefix_.empty()) {
    // Where the base itself starts is known if its own table says so.
    const std::optional<Pose>& X_W_base = d.bodies[base_.body].X_WB;
    body.X_WB = (X_W_base ? *X_W_base : Pose{}) * base_.X_BG * read_pose(s);
  }
  body.shape_json = shapes_json(s);
  const std::string name = body.name;
  const int b = d.add_body(std::move(body));
  model_.sections.emplace(b, s);
  if (is_beam && fidelity.of_beam->has_elements) {
    const std::string key = prefix_.empty() ? fmt::format("body.{}.beam.elements", name) : "";
    model_.blind_spots.push_back({"elements", name,
                                  key.empty()
                                      ? "a run with twice as many tells"
                                      : fmt::format("a run with --set {}={} tells", key, 2 * beam.elements),
                                  key, beam.elements});
  }
  if (is_beam && !fidelity.of_beam->has_elements && !d.bodies[static_cast<std::size_t>(b)].of_beam)
    model_.blind_spots.push_back(
        {"beam", name, fmt::format("a run with --set body.{}.fidelity=modal tells", name)});
  // What acts across the plane is carried without a deflection, and nothing of it is judged.
  if ((is_reduced_beam || (is_beam && fidelity.of_beam->has_elements)) && beam.is_planar)
    model_.blind_spots.push_back({"plane", name, "a run without planar = true tells"});
  if (se && fidelity.of_superelement->deforms()) model_.to_prepare.emplace(b, se);
  if (is_beam) {
    try {
      Segments chain = fidelity.of_beam->make(d, b, beam);
      for (const int piece : chain.bodies) model_.sections.emplace(piece, s);
      if (!chain.bodies.empty()) model_.segments[b] = std::move(chain);
    } catch (const std::invalid_argument& error) {
      s.refuse("beam", error.what());
    }
  }
  const bool deforms = model_.deforms(b);
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    // The nodes of a flexible body are its interfaces, in their order.
    add_marker(model_, b, name + "." + interfaces[i].first,
               {Matrix3d::Identity(), deforms ? Vector3d::Zero() : interfaces[i].second},
               deforms ? static_cast<int>(i) : -1, interfaces[i].second);
  }
  model_.interfaces[b] = std::move(interfaces);
  read_markers(model_, s, b, Pose{}, name, deforms, se.get());
}

// What comes out of a library of the user's may hold anything.
void Reader::note_user_element(const std::string& name, const Section& s) {
  if (s.has("library")) model_.blind_spots.push_back({"user_element", name, ""});
}

// The short bearing's pressure along the axis is a parabola; Reynolds' equation at small eccentricity, with the same round about,
// gives 3 (1 - tanh(a) / a) / a^2 of its load, a = length / (2 radius).
void Reader::note_long_bearing(const std::string& name, const Section& s) {
  if (s.text("type") != "journal_bearing") return;
  const double a = 0.5 * s.quantity("length") / s.quantity("radius");
  if (a <= 0.5 * (1.0 + 1e-9)) return;
  model_.notes.push_back(fmt::format(
      "journal bearing \"{}\" is {:.3g} times as long as its radius: the theory of the short bearing, for "
      "lengths "
      "up to the radius, takes it for stiffer than it is; at small eccentricity it bears {:.2g} of the load",
      name, 2.0 * a, 3.0 * (1.0 - std::tanh(a) / a) / (a * a)));
}

void Reader::read_joints() {
  const ReadContext names = context();
  MechanismDescription& d = model_.description;
  for (const char* kind : {"joint", "connection"})
    for (const auto& [name, s] : root_.table_map(kind)) {
      for (const JointDescription& other : d.joints)
        if (other.name == prefix_ + name) s.refuse("", "has the name of a joint", "choose another name");
      JointDescription joint = read_joint(prefix_ + name, s, names, std::string_view(kind) == "connection");
      note_user_element(prefix_ + name, s);
      model_.joined.insert({d.markers[joint.marker_F].body, d.markers[joint.marker_M].body});
      joints_.emplace_back(d.joints.size(), s);
      d.joints.push_back(std::move(joint));
    }
  for (const auto& subsystem : subsystems_) subsystem->read_joints();
}

void Reader::read_elements() {
  for (const auto& subsystem : subsystems_) subsystem->read_elements();
  const ReadContext names = context();
  MechanismDescription& d = model_.description;
  const auto take_name = [&](const std::string& name, const Section& s) {
    if (name == "t" || name == "pi" || parameters_.contains(name) || tables_.contains(name) ||
        d.signals.find(prefix_ + name) >= 0)
      s.refuse("", "the name is taken already in formulas", "choose another");
    d.signals.add(prefix_ + name);
  };
  const auto take_unit = [&](const std::string& name, const Section& s) {
    if (s.has("unit")) d.units[prefix_ + name] = read_unit(s);
  };
  for (const auto& [name, s] : root_.table_map("input")) {
    d.inputs.push_back({prefix_ + name, names.input_expression(s, "value")});
    take_unit(name, s);
    take_name(name, s);
  }
  // Outputs of states alone can be read by every formula, measures by those below, the rest by forces.
  const auto controls = root_.table_map("control");
  for (const auto& [name, s] : controls)
    if (!find_type(control_types(), s.text("type")).feeds_through(s)) take_name(name, s);
  std::vector<std::pair<std::size_t, std::size_t>> last;  // places in d.measures and here
  const auto measures = root_.table_map("measure");
  for (std::size_t i = 0; i < measures.size(); ++i) {
    const auto& [name, s] = measures[i];
    const MeasureType& type = find_type(measure_types(), s.text("type"));
    // What it takes of elements below is there only after these.
    if (type.is_read_last) last.emplace_back(d.measures.size(), i);
    d.measures.push_back(type.is_read_last ? nullptr : type.read(prefix_ + name, s, names));
    note_user_element(prefix_ + name, s);
    take_name(name, s);
  }
  for (const auto& [name, s] : controls) {
    const ControlType& type = find_type(control_types(), s.text("type"));
    d.controls.push_back(type.read(prefix_ + name, s, names));
    take_unit(name, s);
    note_user_element(prefix_ + name, s);
    if (type.feeds_through(s)) take_name(name, s);
  }
  // What moves by controls.
  for (const auto& [name, s] : root_.table_map("constraint")) {
    d.constraints.push_back(find_type(constraint_types(), s.text("type")).read(prefix_ + name, s, names));
    note_user_element(prefix_ + name, s);
  }
  for (const auto& [joint, s] : joints_) mbs::read_drives(s, names, d.joints[joint]);
  for (const auto& [name, s] : root_.table_map("force")) {
    d.forces.push_back(find_type(force_types(), s.text("type")).read(prefix_ + name, s, names));
    note_user_element(prefix_ + name, s);
    note_long_bearing(prefix_ + name, s);
    if (const auto [body, load] = d.forces.back()->load_case(); body >= 0)
      d.bodies[body].is_loaded_by_case = true;
  }
  for (const auto& [place, i] : last) {
    const auto& [name, s] = measures[i];
    d.measures[place] = find_type(measure_types(), s.text("type")).read(prefix_ + name, s, names);
  }
}

}  // namespace flexura::mbs
