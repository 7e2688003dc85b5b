// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/part_modes.hpp"

#include <algorithm>
#include <numbers>

namespace flexura::reduce {

using input::InputError;
using input::Section;

namespace {

ModesInput read_modes(const Section& in) {
  ModesInput modes;
  modes.count = in.integer("count");
  if (in.has("up_to")) modes.up_to = in.quantity("up_to");
  modes.damping = in.quantity("damping");
  modes.damping_given = in.has("damping");
  const std::string set = in.text("set");
  modes.set = set == "guyan"         ? ModeSet::guyan
              : set == "craig_chang" ? ModeSet::craig_chang
                                     : ModeSet::craig_bampton;
  if (in.has("accuracy")) modes.accuracy = in.quantity("accuracy");
  modes.compliance_accuracy =
      in.has("compliance_accuracy") ? in.quantity("compliance_accuracy") : modes.accuracy;
  if (modes.compliance_accuracy > 0.0 && !(modes.accuracy > 0.0))
    in.refuse("compliance_accuracy", "goes with the accuracy of frequencies", "add e.g. accuracy = \"1 %\"");
  if (in.has("effective_mass")) modes.effective_mass = in.quantity("effective_mass");
  if (in.has("response_at"))
    for (const double f : in.quantities("response_at")) {
      if (!(f >= 0.0)) in.refuse("response_at", "must be at least 0 Hz");
      modes.response_omegas.push_back(2.0 * std::numbers::pi * f);
    }
  if (in.has("strike_modes")) modes.struck = in.integers("strike_modes");
  modes.certify = in.flag("certify");
  modes.where = in.where();
  if (modes.accuracy > 0.0 && modes.effective_mass > 0.0)
    in.refuse("effective_mass", "modes are kept by accuracy or by effective mass, one of the two");
  const char* const fixed_only[] = {"accuracy", "effective_mass", "response_at"};
  for (const char* key : fixed_only)
    if (in.has(key) && modes.set != ModeSet::craig_bampton)
      in.refuse(key, "goes with fixed-interface modes", "take set = \"craig_bampton\"");
  if (modes.set == ModeSet::guyan) modes.count = 0, modes.up_to = 0.0;
  return modes;
}

DampingRule read_damping(const Section& in) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  DampingRule rule;
  if (in.has("frequencies") != in.has("ratios"))
    in.refuse(in.has("ratios") ? "ratios" : "frequencies", "a table has both frequencies and ratios");
  if (in.has("frequencies")) {
    for (const double f : in.quantities("frequencies")) rule.omega.push_back(kTwoPi * f);
    rule.ratio = in.quantities("ratios");
    if (rule.omega.size() != rule.ratio.size()) in.refuse("ratios", "has as many entries as frequencies");
    for (std::size_t k = 1; k < rule.omega.size(); ++k)
      if (!(rule.omega[k] > rule.omega[k - 1])) in.refuse("frequencies", "must ascend");
    for (const double ratio : rule.ratio)
      if (!(ratio >= 0.0)) in.refuse("ratios", "must be at least 0");
  }
  if (in.has("critical_above")) rule.critical_above = kTwoPi * in.quantity("critical_above");
  rule.alpha = in.quantity("alpha");
  rule.beta = in.quantity("beta");
  return rule;
}

void check_elastic_ties(const Section& modes, const PartInput& part) {
  const bool elastic = std::any_of(part.interfaces.begin(), part.interfaces.end(),
                                   [](const InterfaceInput& f) { return f.tie == Tie::elastic; });
  if (elastic && !part.finished.vectors.empty())
    modes.refuse("interface_count", "goes with a reduction here, not with finished vectors",
                 "tie the interfaces as an average");
  if (!elastic) {
    for (const char* key : {"interface_count", "interface_up_to", "interface_accuracy"})
      if (modes.has(key)) modes.refuse(key, "is about elastic ties", "give an interface tie = \"elastic\"");
    return;
  }
  if (part.modes.accuracy > 0.0)
    modes.refuse("accuracy", "is not estimated with elastic ties",
                 "keep modes by count, up_to or effective_mass");
  if (part.modes.set == ModeSet::craig_chang)
    modes.refuse("set", "does not go with elastic ties", "take craig_bampton or guyan");
}

}  // namespace

RecoveryInput read_recovery(const Section& in) {
  return {.stress = in.flag("stress"),
          .groups = {},
          .all_nodes = in.text("nodes") == "all",
          .double_precision = in.text("precision") == "double",
          .where = in.where()};
}

void read_request(const Section& in, ReductionRequest& request) {
  request.modes = read_modes(in.table("modes"));
  request.damping = read_damping(in.table("damping"));
  const DampingRule& rule = request.damping;
  request.has_damping =
      !rule.omega.empty() || rule.critical_above > 0.0 || rule.alpha > 0.0 || rule.beta > 0.0;
  request.stiffening = in.flag("stiffening");
}

void read_interface_modes(const Section& in, PartInput& part) {
  InterfaceModesRequest& faces = part.modes.interface_modes;
  faces.count = in.integer("interface_count");
  if (in.has("interface_up_to")) {
    faces.omega_max = 2.0 * std::numbers::pi * in.quantity("interface_up_to");
    faces.count = 0;
  }
  if (in.has("interface_accuracy")) faces.accuracy = in.quantity("interface_accuracy");
  if (in.has("interface_accuracy") + in.has("interface_up_to") + in.has("interface_count") > 1)
    throw InputError(in.where() +
                     ": interface modes are kept by interface_count, interface_up_to or interface_accuracy, "
                     "one of them");
  check_elastic_ties(in, part);
}

void read_finished_modes(const Section& in, PartInput& part) {
  const Section modes = in.table("mode_vectors");
  part.finished.vectors = modes.file("vectors");
  part.finished.stiffness = modes.file("stiffness");
  part.finished.mass = modes.file("mass");
  if (modes.has("damping")) part.finished.damping = modes.file("damping");
  if (modes.has("reduced_mass")) part.finished.reduced_mass = modes.file("reduced_mass");
  if (modes.has("stress")) part.finished.stress = modes.file("stress");
  const std::string place = modes.text("stress_at");
  part.finished.stress_at = place == "elements"  ? StressPlace::elements
                            : place == "corners" ? StressPlace::corners
                                                 : StressPlace::nodes;
  if (part.finished.stress_at != StressPlace::nodes && part.format == PartFormat::nodes)
    modes.refuse("stress_at", "needs the elements, a table of nodes has none",
                 "give the mesh as the geometry file");
  if (part.format == PartFormat::cad)
    in.table("geometry").refuse("file", "mode vectors go with the nodes of a mesh file or of a table (.csv)");
  if (in.table("recovery").flag("stress") && part.finished.stress.empty())
    modes.refuse("stress", "is wanted by recovery.stress: the vectors alone do not tell stresses");
  if (in.flag("stiffening"))
    in.refuse("stiffening", "needs the elements, mode vectors do not have them", "take it away");
  const Section choice = in.table("modes");
  for (const char* key : {"set", "count", "up_to", "accuracy", "effective_mass", "response_at"})
    if (choice.has(key))
      choice.refuse(key, "chooses modes to compute, but the vectors are finished", "leave the key out");
  for (const char* table : {"mass_point", "link"})
    if (!in.table_map(table).empty())
      in.refuse(table, "cannot change finished modes", "have it in the model that the vectors come from");
}

}  // namespace flexura::reduce
