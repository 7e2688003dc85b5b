// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_deck.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_beam_sections.hpp"
#include "mesh/import/abaqus/abaqus_bindings.hpp"
#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_materials.hpp"
#include "mesh/import/abaqus/abaqus_section_cards.hpp"
#include "mesh/import/abaqus/abaqus_types.hpp"

namespace flexura::mesh::abaqus {
namespace {

class Reader {
 public:
  explicit Reader(DeckProgram program) : program_(program) {}

  Deck read(const std::filesystem::path& path) {
    const std::vector<Keyword> keywords = read_keywords(path, deck_.file_names);
    if (program_ == DeckProgram::unknown) program_ = written_for(keywords);
    deck_.parts.emplace_back();
    Faults faults;
    for (const Keyword& keyword : keywords) faults.guard([&] { take(keyword); });
    faults.raise();
    return std::move(deck_);
  }

 private:
  Part& here() { return instance_ ? instance_->own : deck_.parts[static_cast<std::size_t>(part_)]; }

  /// The name as the file first spelt it: labels are compared without case.
  std::string known(const std::string& name) { return spelling_.emplace(upper(name), name).first->second; }

  void take(const Keyword& k) {
    if (k.name.empty()) {
      deck_.unused.add("(data before the first one)", k.where);
      return;
    }
    if (in_step_) {
      in_step_ = k.name != "END STEP";
      return;
    }
    if (materials_.take(k, deck_)) return;
    if (k.name == "PART" || k.name == "INSTANCE" || k.name == "END PART" || k.name == "END INSTANCE")
      system_ = Transform();
    if (k.name == "STEP")
      in_step_ = true;
    else if (k.name == "PART") {
      deck_.parts.emplace_back();
      deck_.parts.back().name = upper(k.get("NAME"));
      part_ = static_cast<int>(deck_.parts.size()) - 1;
    } else if (k.name == "END PART")
      part_ = 0;
    else if (k.name == "ASSEMBLY")
      in_assembly_ = true;
    else if (k.name == "END ASSEMBLY")
      in_assembly_ = false;
    else if (k.name == "INSTANCE")
      start_instance(k);
    else if (k.name == "END INSTANCE")
      instance_ = nullptr;
    else if (k.name == "NODE")
      take_nodes(k);
    else if (k.name == "ELEMENT")
      take_elements(k);
    else if (k.name == "NSET" || k.name == "ELSET")
      take_set(k);
    else if (gives_section(k.name))
      here().sections.push_back(section_of(
          k, program_, [this](const std::string& name) { return known(name); }, deck_));
    else if (k.name == "MASS" || k.name == "ROTARY INERTIA" || k.name == "SPRING" || k.name == "DASHPOT") {
      if (k.name == "DASHPOT" && k.has("NONLINEAR"))
        throw std::invalid_argument(
            k.where.text() + ": *DASHPOT, NONLINEAR is not read; give the coefficient of small motion");
      const bool two = (k.name == "SPRING" || k.name == "DASHPOT") && k.data.size() > 1;
      here().data.push_back({.kind = k.name,
                             .set = known(k.get("ELSET")),
                             .values = numbers_of(k, two ? 1 : 0),
                             .where = k.where,
                             .orientation = upper(k.get("ORIENTATION")),
                             .dofs = two ? numbers_of(k, 0) : std::vector<double>(),
                             .alpha = k.has("ALPHA") ? to_real(k.get("ALPHA"), k.where) : 0.0});
      require_not_negative(here().data.back().alpha, "*" + k.name, "ALPHA", k.where);
    } else if (take_binding(k, deck_)) {
      // said in the deck
    } else if (k.name == "SURFACE")
      take_surface(k);
    else if (k.name == "ORIENTATION")
      deck_.orientations[part_name() + upper(k.get("NAME"))] = orientation_of(k);
    else if (const std::string what = changes_the_body(k.name); !what.empty())
      deck_.otherwise.add("*" + k.name + ": " + what, k.where);
    else if (k.name == "TRANSFORM")
      deck_.transforms.push_back(transform_of(k));
    else if (k.name == "SYSTEM")
      system_ = system_of(k);
    else if (makes_mesh(k.name))
      throw std::invalid_argument(
          fmt::format("{}: *{} makes nodes or elements from others, which is not read: write the deck out "
                      "with all its nodes and elements",
                      k.where.text(), k.name));
    else if (k.name == "KINEMATIC COUPLING" || k.name == "DISTRIBUTING COUPLING" ||
             k.name == "EMBEDDED ELEMENT" || k.name == "SHELL TO SOLID COUPLING" || k.name == "FASTENER" ||
             k.name == "CONTACT PAIR" || k.name == "CONTACT")
      deck_.unbound.add("*" + k.name, k.where);
    else if (k.name == "MATERIAL")
      materials_.start(k, known(k.get("NAME")), deck_);
    else if (k.name != "HEADING" && k.name != "PREPRINT" && k.name != "RESTART")
      deck_.unused.add("*" + k.name, k.where);
  }

  void start_instance(const Keyword& k) {
    auto instance = std::make_unique<Instance>();
    instance->name = known(k.get("NAME"));
    instance->where = k.where;
    const std::string wanted = upper(k.get("PART"));
    for (std::size_t p = 1; p < deck_.parts.size(); ++p)
      if (deck_.parts[p].name == wanted) instance->part = static_cast<int>(p);
    if (instance->part < 0)
      throw std::invalid_argument(
          fmt::format("{}: *INSTANCE of a part \"{}\" that is not defined", k.where.text(), k.get("PART")));
    const auto numbers = [&](std::size_t line, std::size_t n) {
      Eigen::VectorXd v(n);
      for (std::size_t i = 0; i < n; ++i)
        v[static_cast<Eigen::Index>(i)] = to_real(field(k, line, i), k.data[line].where);
      return v;
    };
    if (!k.data.empty()) instance->t = numbers(0, 3);
    if (k.data.size() >
        1) {  // rotation by an angle (degrees) about a line through two points, after the translation
      const Eigen::VectorXd r = numbers(1, 7);
      const Eigen::Vector3d a = r.head<3>(), b = r.segment<3>(3);
      instance->R = Eigen::AngleAxisd(r[6] * std::numbers::pi / 180, (b - a).normalized()).toRotationMatrix();
      instance->t = a + instance->R * (instance->t - a);
    }
    deck_.instances.push_back(std::move(instance));
    instance_ = deck_.instances.back().get();
  }

  /// Before names of what belongs to a part.
  std::string part_name() const {
    return part_ > 0 ? deck_.parts[static_cast<std::size_t>(part_)].name + "." : "";
  }

  /// Keywords that are not read and without which the body is another one: what they do.
  static std::string changes_the_body(const std::string& name) {
    static const std::map<std::string, std::string> kWhat = {
        {"NODAL THICKNESS", "the sections' thicknesses are used"},
        {"NONSTRUCTURAL MASS", "the mass that it adds is missing"},
        {"BEAM ADDED INERTIA", "the mass that it adds is missing"},
        {"ADDED MASS", "the mass that it adds is missing"},
        {"TRANSVERSE SHEAR STIFFNESS", "shear deformation is that of the section and its material"},
        {"TRANSVERSE SHEAR", "shear deformation is that of the section and its material"},
        {"CENTROID", "the beams' centroids are taken at their nodes"},
        {"SHEAR CENTER", "the beams' shear centres are taken at their nodes"},
        {"MATRIX ASSEMBLE", "the stiffness or mass that it adds is missing"},
        {"DISTRIBUTION", "what it distributes is taken as uniform"}};
    const auto found = kWhat.find(name);
    return found == kWhat.end() ? "" : found->second;
  }

  static bool makes_mesh(const std::string& name) {
    static const std::set<std::string> kNames = {"NGEN",  "NCOPY",  "NFILL",     "NMAP",
                                                 "ELGEN", "ELCOPY", "ASSEMBLED", "SUBSTRUCTURE PROPERTY"};
    return kNames.contains(name);
  }

  void take_nodes(const Keyword& k) {
    if (k.has("SYSTEM") && upper(k.get("SYSTEM")) != "R")
      throw std::invalid_argument(
          k.where.text() +
          ": *NODE in a cylindrical or spherical SYSTEM is not read; export in rectangular coordinates");
    Part& part = here();
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      NodeLine node{to_integer(line.fields[0], line.where), Eigen::Vector3d::Zero(), line.where};
      for (std::size_t i = 1; i < std::min<std::size_t>(4, line.fields.size()); ++i)
        if (!line.fields[i].empty())
          node.x[static_cast<Eigen::Index>(i) - 1] = to_real(line.fields[i], line.where);
      node.x = (system_.origin + system_.R * node.x).eval();
      part.nodes.push_back(node);
      if (k.has("NSET")) part.node_sets[known(k.get("NSET"))].push_back(node.label);
    }
  }

  void take_elements(const Keyword& k) {
    std::optional<SolidType> solid = solid_type(k.get("TYPE"));
    if (!solid) solid = shell_type(k.get("TYPE"));
    if (const auto other = other_elements().find(upper(k.get("TYPE"))); other != other_elements().end()) {
      take_others(k, other->second);
      return;
    }
    if (!solid) {
      for (const DataLine& line : records(k, SIZE_MAX)) {
        deck_.left_out.add(k.get("TYPE"), line.where);
        // Sections and masses can name the set all the same.
        if (k.has("ELSET") && !line.fields.empty() && as_integer(line.fields[0]))
          here().element_sets[known(k.get("ELSET"))].push_back(*as_integer(line.fields[0]));
      }
      return;
    }
    Part& part = here();
    const CellType type = solid->shape;
    const auto n = static_cast<std::size_t>(nodes_per_cell(type));
    for (const DataLine& line : records(k, n + 1)) {
      if (line.fields.empty()) continue;
      if (!solid->replaced.empty()) {
        auto& [count, effect] = deck_.replaced[upper(k.get("TYPE"))];
        ++count;
        effect = solid->replaced;
      }
      ElementLine element{type, solid->variant, to_integer(line.fields[0], line.where), {}, line.where};
      if (line.fields.size() > n + 1)
        deck_.otherwise.add(
            fmt::format("element of type {} has more entries than its {} nodes: the rest is not used",
                        k.get("TYPE"), n),
            line.where);
      if (line.fields.size() < n + 1)
        throw std::invalid_argument(fmt::format("{}: element {} of type {} has {} nodes instead of {}",
                                                line.where.text(), element.label, k.get("TYPE"),
                                                line.fields.size() - 1, n));
      for (std::size_t i = 1; i <= n; ++i) element.nodes.push_back(to_integer(line.fields[i], line.where));
      element.nodes = in_mesh_order(type, element.nodes);
      part.elements.push_back(element);
      if (k.has("ELSET")) part.element_sets[known(k.get("ELSET"))].push_back(element.label);
    }
  }

  void take_others(const Keyword& k, std::size_t n) {
    Part& part = here();
    if (n == 3) {
      auto& [count, effect] = deck_.replaced[upper(k.get("TYPE"))];
      count += k.data.size();
      effect = "each taken as two straight ones between its nodes";
    }
    for (const DataLine& line : records(k, n + 1)) {
      if (line.fields.empty()) continue;
      OtherElement element{upper(k.get("TYPE")), to_integer(line.fields[0], line.where), {}, line.where};
      // One more node of a beam gives its direction 1.
      if (line.fields.size() < n + 1)
        throw std::invalid_argument(fmt::format("{}: element {} of type {} has {} nodes instead of {}",
                                                line.where.text(), element.label, element.type,
                                                line.fields.size() - 1, n));
      for (std::size_t i = 1;
           i < line.fields.size() && i <= n + (element.type[0] == 'B' || element.type[0] == 'U' ? 1 : 0); ++i)
        if (!line.fields[i].empty()) element.nodes.push_back(to_integer(line.fields[i], line.where));
      if (k.has("ELSET")) part.element_sets[known(k.get("ELSET"))].push_back(element.label);
      part.others.push_back(std::move(element));
    }
  }

  void take_surface(const Keyword& k) {
    Surface surface;
    surface.where = k.where;
    surface.of_nodes = upper(k.get("TYPE")) == "NODE";
    for (const DataLine& line : k.data)
      if (!line.fields.empty() && !line.fields[0].empty())
        surface.entries.emplace_back(line.fields[0], line.fields.size() > 1 ? upper(line.fields[1]) : "");
    if (k.has("COMBINE") || k.has("CROP"))
      throw std::invalid_argument(k.where.text() +
                                  ": *SURFACE that combines or crops others is not read; list its elements");
    deck_.surfaces[part_name() + upper(k.get("NAME"))] = std::move(surface);
  }

  void take_set(const Keyword& k) {
    const bool of_nodes = k.name == "NSET";
    AssemblySet set{
        known(k.get(of_nodes ? "NSET" : "ELSET")), upper(k.get("INSTANCE")), of_nodes, {}, {}, k.where};
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      if (k.has("GENERATE")) {
        const std::int64_t first = to_integer(line.fields[0], line.where),
                           last = to_integer(line.fields.size() > 1 ? line.fields[1] : line.fields[0],
                                             line.where),
                           step = line.fields.size() > 2 ? to_integer(line.fields[2], line.where) : 1;
        if (step <= 0)
          throw std::invalid_argument(line.where.text() +
                                      ": the increment of a generated set must be greater than zero");
        constexpr std::int64_t most = 100'000'000;  // labels: more elements than fit into any memory
        if (first < 0 || last > most * std::min<std::int64_t>(step, 1000))
          throw std::invalid_argument(fmt::format(
              "{}: a generated set from {} to {} by {}: labels lie between 0 and {}, at most {} in a set",
              line.where.text(), first, last, step, most * 1000, most));
        if (last >= first) implied_.add(static_cast<std::size_t>((last - first) / step), line.where);
        for (std::int64_t label = first; label <= last; label += step) set.labels.push_back(label);
        continue;
      }
      for (const std::string& entry : line.fields) {
        if (entry.empty()) continue;
        if (const auto label = as_integer(entry))
          set.labels.push_back(*label);
        else
          set.names.push_back(known(entry));
      }
    }
    if (in_assembly_ && !instance_) {
      deck_.assembly_sets.push_back(std::move(set));
      return;
    }
    auto& sets = of_nodes ? here().node_sets : here().element_sets;
    for (const std::string& name : set.names) {
      const auto found = sets.find(name);
      if (found == sets.end())
        throw std::invalid_argument(fmt::format("{}: set \"{}\" names a set \"{}\" that is not defined",
                                                k.where.text(), set.name, name));
      implied_.add(found->second.size(), k.where);
      set.labels.insert(set.labels.end(), found->second.begin(), found->second.end());
    }
    auto& own = sets[set.name];
    own.insert(own.end(), set.labels.begin(), set.labels.end());
    if (set.names.empty()) return;
    // Sets of sets, a set of itself among them, would double with each line.
    std::ranges::sort(own);
    const auto again = std::ranges::unique(own);
    own.erase(again.begin(), again.end());
  }

  DeckProgram program_;
  Deck deck_;
  MaterialReader materials_;
  std::map<std::string, std::string> spelling_;
  Transform system_;  // of the nodes that follow
  Instance* instance_ = nullptr;
  int part_ = 0;
  bool in_step_ = false, in_assembly_ = false;
  Implied implied_;
};

}  // namespace

Deck read_deck(const std::filesystem::path& path, DeckProgram program) {
  return Reader(program).read(path);
}

}  // namespace flexura::mesh::abaqus
