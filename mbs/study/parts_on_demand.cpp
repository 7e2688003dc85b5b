// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/parts_on_demand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/base/documents/table_names.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/new_folder.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/file/mechanism_document.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/study/cache/reduction.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/study/nearest_interface.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::study {

namespace fs = std::filesystem;
using input::Section;

namespace {

constexpr int kMostRounds = 3;
// Of files that place one another without end; read_mechanism() refuses them.
constexpr std::size_t kMostDocuments = 1000;

// "parts/rod.toml" of "parts/rod.se.h5".
fs::path part_file_of(fs::path superelement) {
  superelement.replace_extension();
  if (superelement.extension() == ".se") superelement.replace_extension();
  return superelement += ".toml";
}

// N of "faceN", 0 of other names.
int face_number(const std::string& name) {
  constexpr std::string_view word = "face";
  int number = 0;
  if (!name.starts_with(word)) return 0;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + word.size(), end, number);
  return read.ec == std::errc() && read.ptr == end && number > 0 ? number : 0;
}

// As overrides name them; others would need quotes in the path of a key.
bool is_plain(const std::string& name) {
  return !name.empty() &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
             std::string::npos;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string toml(const Eigen::Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

// "body.marker" or "body.interface" of every joint of the file, with `prefix`.
void add_places_of_joints(std::vector<std::string>& places, const std::string& prefix, const Section& root) {
  for (const char* kind : {"joint", "connection"})
    for (const auto& [name, joint] : root.table_map(kind))
      for (const char* key : {"from", "to"})
        if (joint.has(key)) places.push_back(prefix + joint.text(key));
}

bool is_linked(const Section& marker) {
  return marker.has("nodes") || marker.has("points") || marker.has("within");
}

struct Found {
  bool is_there = false, is_rigid = false;
  std::vector<std::string> interfaces;
  superelement::Superelement se = {};  ///< where it is the rigid one of an import: its surface
};

// What cannot be read is refused where it is read for the run.
Found look_at(const fs::path& superelement) {
  Found found;
  std::error_code none;
  found.is_there = fs::exists(superelement, none);
  if (!found.is_there) return found;
  try {
    const superelement::Superelement se =
        superelement::read(superelement, {.matrices = false, .inertia = false, .surface = true});
    found.is_rigid = se.created_by.starts_with("flexura import");
    for (const superelement::Interface& i : se.interfaces) found.interfaces.push_back(i.name);
    if (found.is_rigid) found.se = se;
  } catch (const std::runtime_error&) {
  }
  return found;
}

bool is_to_deform(const Section& body, double accuracy) {
  if (!body.has("fidelity") && accuracy > 0.0) return true;  // it is chosen
  if (body.text("fidelity") == mbs::kAutomaticFidelity) return true;
  const mbs::Fidelity& fidelity = mbs::fidelity_of(body);
  return fidelity.of_superelement && fidelity.of_superelement->deforms();
}

}  // namespace

PartsOnDemand::PartsOnDemand(fs::path mechanism, fs::path bin, fs::path cache, bool run_scripts,
                             Telling telling)
    : mechanism_(std::move(mechanism)),
      bin_(std::move(bin)),
      cache_(std::move(cache)),
      run_scripts_(run_scripts),
      telling_(std::move(telling)) {}

void PartsOnDemand::add_documents(std::vector<Document>& all, Document document,
                                  const std::vector<std::string>& overrides) {
  all.push_back(document);
  for (const mbs::PlacedFile& placed : mbs::placed_files(document.root, overrides)) {
    if (!is_plain(placed.name) || all.size() >= kMostDocuments) continue;
    add_documents(all,
                  {document.prefix + placed.name + ".", document.keys + "subsystem." + placed.name + ".",
                   mbs::read_mechanism_document(placed.file, mbs::solver_schema(), placed.overrides)},
                  placed.overrides);
  }
}

void PartsOnDemand::collect(const std::vector<std::string>& overrides) {
  std::vector<Document> all;
  add_documents(all, {"", "", mbs::read_mechanism_document(mechanism_, mbs::solver_schema(), overrides)},
                overrides);
  // Joints of one file may lead to the bodies of another.
  std::vector<std::string> places;
  for (const Document& document : all) add_places_of_joints(places, document.prefix, document.root);
  const double accuracy = all.front().root.table("solver").quantity("accuracy");
  for (const Document& document : all) collect(document, places, accuracy);
}

void PartsOnDemand::collect(const Document& document, const std::vector<std::string>& places,
                            double accuracy) {
  const auto is_used = [&](const std::string& place) {
    return std::ranges::find(places, place) != places.end();
  };
  for (const auto& [own_name, body] : document.root.table_map("body")) {
    if (!body.has("superelement") || !is_plain(own_name)) continue;
    const std::string name = document.prefix + own_name, body_key = document.keys + "body." + own_name;
    std::string joined = name;
    std::ranges::replace(joined, '.', '_');
    const fs::path path = fs::absolute(body.file("superelement")).lexically_normal();
    const Found found = look_at(path);
    const bool deforms = is_to_deform(body, accuracy);
    if (found.is_there && !deforms) continue;
    const fs::path file = part_file_of(path);
    std::error_code none;
    if (!fs::exists(file, none)) {
      if (found.is_there && !found.is_rigid) continue;  // it is as it is
      body.refuse(
          "superelement",
          found.is_there ? "is the rigid one of an import, and the body is to deform" : "is not there",
          fmt::format("--reduce makes it of a part file {}, which is not there either: write it (flexura "
                      "new part, flexura reduce --schema), or name a superelement that is there",
                      file.string()));
    }
    auto [at, is_new] = parts_.try_emplace(path.string(), Part{.file = file, .known = {}});
    Part& part = at->second;
    if (is_new) {
      part.known = input::names_in_table(file, "interface");
      part.has_mesh = !input::names_in_table(file, "geometry").empty();
    }
    part_of_[name] = path.string();
    bool lacks = !found.is_there || found.is_rigid;
    const auto is_known = [&](const std::string& interface) {
      return std::ranges::find(part.known, interface) != part.known.end();
    };
    const auto need_face = [&](const std::string& interface) {
      const int number = face_number(interface);
      if (number == 0) return;
      if (!is_known(interface))
        part.added[interface] = fmt::format("{{by = \"faces\", faces = [{}]}}", number);
      lacks = lacks || std::ranges::find(found.interfaces, interface) == found.interfaces.end();
    };
    std::vector<std::string>& set = part.bodies[body_key];
    set.clear();
    std::vector<std::string> markers;
    for (const auto& [marker, m] : body.table_map("marker")) {
      markers.push_back(name + "." + marker);
      if (m.has("on")) need_face(m.text("on"));
      if (m.has("on") || is_linked(m) || !deforms || !is_plain(marker) || !is_used(markers.back())) continue;
      const Eigen::Vector3d place =
          m.has("position") ? m.vector3("position") : Eigen::Vector3d(Eigen::Vector3d::Zero());
      const std::string position = toml(place);
      // A face is one interface: where the nearest is one already, or was taken for a marker at this place, it is that.
      std::string interface = nearest_interface(found.se, place);
      const bool has_one = face_number(interface) > 0;
      if (has_one)
        need_face(interface);
      else
        interface = part.at_place.try_emplace(position, "at_" + joined + "_" + marker).first->second;
      if (!has_one && !is_known(interface))
        part.added[interface] = fmt::format("{{by = \"near\", point = {}}}", position);
      lacks = lacks || std::ranges::find(found.interfaces, interface) == found.interfaces.end();
      set.push_back(fmt::format("{}.marker.{}.on={}", body_key, marker, quoted(std::as_const(interface))));
      set.push_back(fmt::format("{}.marker.{}.position={}", body_key, marker, position));
    }
    for (const std::string& place : places)
      if (place.starts_with(name + ".") && std::ranges::find(markers, place) == markers.end())
        need_face(place.substr(name.size() + 1));
    if (lacks && std::ranges::find(part.wanted, body_key) == part.wanted.end())
      part.wanted.push_back(body_key);
  }
}

std::vector<std::string> PartsOnDemand::overrides_for(const Part& part,
                                                      const std::vector<std::string>& keys) const {
  std::vector<std::string> set;
  for (const std::string& key : keys) {
    set.push_back(fmt::format("{}.superelement={}", key, quoted(part.made.string())));
    const std::vector<std::string>& markers = part.bodies.at(key);
    set.insert(set.end(), markers.begin(), markers.end());
  }
  return set;
}

void PartsOnDemand::reduce(const std::string& superelement, Part& part) {
  // No output of the run may lie where the program reads.
  for (const input::InputFile& file : input::input_files(part.file)) files::note_input(file.path);
  const fs::path folder =
      fs::absolute(cache_.empty() ? fs::path(superelement).parent_path() / "reduced" : cache_);
  if (cache_.empty() && files::leads_out_of(folder.parent_path(), folder))
    throw input::InputError(
        folder.string() +
        ": is a link that leads out of the part's folder; remove it, or name a folder by --cache");
  const files::NewFolder made(folder);
  remove_scratch_left(folder);
  const StudyCache store(folder, telling_.note);
  input::ContentHash hash;
  hash.add_file(bin_ / "flexura-reduce").add_file(bin_ / "flexura-mesh").add_input_file(part.file);
  std::vector<std::string> command = {(bin_ / "flexura-reduce").string(), fs::absolute(part.file).string()};
  if (run_scripts_) command.emplace_back("--run-scripts");
  std::vector<std::string> set;
  for (const auto& [name, table] : part.added) set.push_back(fmt::format("interface.{}={}", name, table));
  if (part.accuracy > 0.0) set.push_back(fmt::format("modes.accuracy={:.3g}", part.accuracy));
  for (const std::string& text : set) {
    hash.add(text);
    command.insert(command.end(), {"--set", text});
  }
  const std::string stem = part.file.stem().string();
  const std::string key = stem + "-" + hash.hex().substr(0, 16);
  part.made = store.path(key, ".se.h5");
  const std::string what = part.accuracy > 0.0
                               ? fmt::format("{} for {}", part.file.string(), percent(part.accuracy))
                               : part.file.string();
  if (store.is_there(key, ".se.h5")) {
    telling_.note(fmt::format("{} was reduced before: {}", what, part.made.string()));
    return;
  }
  telling_.progress("reducing " + stem);
  const auto warnings = reduce_into(
      store, folder, {.key = key, .name = fmt::format("reducing {}", what), .command = command},
      [&](std::string_view line) {
        telling_.progress(line.empty() ? "reducing " + stem : fmt::format("reducing {}: {}", stem, line));
      });
  for (const std::string& sentence : warnings) telling_.warning(fmt::format("{}: {}", stem, sentence));
  std::vector<std::string> names;
  for (const auto& [name, table] : part.added) names.push_back(name);
  telling_.note(fmt::format(
      "{} reduced in {:.3g} s{}: {}", what, store.entry_of(key).total_wall(),
      names.empty() ? "" : fmt::format(", with interfaces {} beside its own", fmt::join(names, ", ")),
      part.made.string()));
}

std::vector<std::string> PartsOnDemand::provide(const std::vector<std::string>& given,
                                                const std::vector<std::string>& runs) {
  const auto of_file = mbs::read_mechanism_document(mechanism_, mbs::solver_schema(), given).table_map("run");
  for (const auto& [name, run] : of_file) {
    if (!runs.empty() && std::ranges::find(runs, name) == runs.end()) continue;
    std::vector<std::string> overrides = run.texts("set");
    if (run.has("accuracy"))
      overrides.push_back(fmt::format("solver.accuracy={:.17g}", run.quantity("accuracy")));
    overrides.insert(overrides.end(), given.begin(), given.end());
    collect(overrides);
  }
  if (of_file.empty()) collect(given);
  std::vector<std::string> set;
  for (auto& [name, part] : parts_) {
    if (part.wanted.empty()) continue;
    reduce(name, part);
    const auto more = overrides_for(part, part.wanted);
    set.insert(set.end(), more.begin(), more.end());
  }
  return set;
}

std::vector<std::string> PartsOnDemand::refine(const std::vector<MeshOfBody>& meshes, double accuracy) {
  std::vector<std::string> set;
  const double budget = 0.5 * accuracy / static_cast<double>(std::max<std::size_t>(meshes.size(), 1));
  std::map<std::string, std::optional<double>> too_coarse;  // by part, the worst of its bodies
  for (const MeshOfBody& mesh : meshes) {
    if (mesh.error && *mesh.error <= budget) continue;
    const auto known = part_of_.find(mesh.body);
    if (known == part_of_.end()) {
      telling_.warning(
          fmt::format("body \"{}\": no part file beside its superelement to reduce it anew from", mesh.body));
      continue;
    }
    auto [at, is_new] = too_coarse.try_emplace(known->second, mesh.error);
    if (!is_new && at->second) at->second = mesh.error ? std::max(*at->second, *mesh.error) : mesh.error;
  }
  for (const auto& [name, error] : too_coarse) {
    Part& part = parts_.at(name);
    if (!part.has_mesh || part.rounds++ >= kMostRounds) continue;
    const Part before = part;
    part.accuracy = part.accuracy == 0.0 ? budget : part.accuracy * (error ? 0.8 * budget / *error : 0.5);
    try {
      reduce(name, part);
    } catch (const Interrupted&) {
      throw;
    } catch (const std::runtime_error& why) {
      // The run has a mesh to go on with.
      telling_.warning(fmt::format("{}; the mesh before it is kept", why.what()));
      part.made = before.made;
      part.rounds = kMostRounds;
      continue;
    }
    std::vector<std::string> keys;
    for (const auto& [key, markers] : part.bodies) keys.push_back(key);
    const auto more = overrides_for(part, keys);
    set.insert(set.end(), more.begin(), more.end());
  }
  return set;
}

}  // namespace flexura::study
