// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/mesh_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/superelement/known_errors.hpp"
#include "reduce/cms/result/reduction.hpp"

namespace flexura::reduce {

namespace {

/// A number that JSON can hold: null where the mesh does not resolve what is asked, or it is not known.
nlohmann::json number(double value) {
  return std::isfinite(value) && value >= 0.0 ? nlohmann::json(value) : nlohmann::json(nullptr);
}

std::string place(const Eigen::Vector3d& x) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) mm", 1e3 * x.x(), 1e3 * x.y(), 1e3 * x.z());
}

void put_stress(nlohmann::json& row, const MeshShare::Stress& stress) {
  const auto list = [](const Eigen::Vector3d& x) { return std::vector<double>{x.x(), x.y(), x.z()}; };
  row["stress_error"] = number(stress.mean);
  row["peak_stress_error"] = number(stress.peak.error);
  row["peak_stress_at"] =
      stress.peak.node >= 0 ? nlohmann::json(list(stress.peak.at)) : nlohmann::json(nullptr);
  row["unbounded_stress_at"] =
      stress.peak.singular ? nlohmann::json(list(stress.peak.singular_at)) : nlohmann::json(nullptr);
}

/// The worst of modes and interfaces.
struct Worst {
  const MeshShare::Stress *peak = nullptr, *singular = nullptr;
  double mean = 0.0;
  std::string of;  ///< under which load the worst peak is
};

Worst worst_stress(const MeshShare& share) {
  Worst out;
  const auto take = [&](const MeshShare::Stress& stress, const std::string& of) {
    out.mean = std::max(out.mean, stress.mean);
    if (stress.peak.error >= 0.0 && (!out.peak || stress.peak.error > out.peak->peak.error))
      out.peak = &stress, out.of = of;
    if (stress.peak.singular && !out.singular) out.singular = &stress;
  };
  // What a part is loaded by, not what its modes would be.
  for (const MeshShare::Interface& interface : share.interfaces)
    take(interface.stress, "loads on " + interface.name);
  if (share.interfaces.empty() && !share.modes.empty()) take(share.modes.front().stress, "the first mode");
  return out;
}

bool has_no_limit(const MeshShare& share) {
  return std::any_of(share.interfaces.begin(), share.interfaces.end(),
                     [](const auto& interface) { return interface.error < 0.0; });
}

std::string no_limit() {
  return "an interface at a single node or along a line presses into elastic solids without bound as the "
         "mesh becomes finer";
}

std::string stress_text(const MeshShare& share) {
  const Worst worst = worst_stress(share);
  std::string text =
      fmt::format("  stress, estimated: of the elements {} (root mean square)", percent_or_more(worst.mean));
  if (worst.peak)
    text += fmt::format("; greatest nodal stress where it is finite: {} under {}, at {}",
                        percent_or_more(worst.peak->peak.error), worst.of, place(worst.peak->peak.at));
  else
    text += "; of the greatest nodal stress: unknown";
  if (worst.singular)
    text += fmt::format(
        "; at {} no finite stress exists (a sharp re-entrant edge, or the edge of a rigid interface): what "
        "stands there grows with "
        "every finer mesh",
        place(worst.singular->peak.singular_at));
  return text + "\n";
}

}  // namespace

std::string percent_or_more(double error) {
  return error < 0.5 ? fmt::format("{:.2g} %", 100.0 * error) : std::string("50 % or more");
}

nlohmann::json mesh_error_json(const std::optional<MeshShare>& share) {
  if (!share) return nullptr;
  nlohmann::json out = {{"modes", nlohmann::json::array()},
                        {"interfaces", nlohmann::json::array()},
                        {"by", share->rough ? "recovered stresses" : "enrichment"}};
  for (const MeshShare::Mode& mode : share->modes) {
    out["modes"].push_back({{"hz", frequency_hz(mode.omega2)}, {"frequency_error", number(mode.error)}});
    put_stress(out["modes"].back(), mode.stress);
  }
  for (const MeshShare::Interface& interface : share->interfaces) {
    out["interfaces"].push_back({{"name", interface.name}, {"compliance_error", number(interface.error)}});
    put_stress(out["interfaces"].back(), interface.stress);
  }
  return out;
}

std::string mesh_error_text(const std::optional<MeshShare>& share, bool stresses) {
  if (!share)
    return "  mesh error: unknown (no estimate for such elements or matrices); compare with a finer mesh\n";
  std::string text;
  if (!share->modes.empty()) {
    text += fmt::format("  mesh error, estimated: first free frequency {}",
                        percent_or_more(share->modes[0].error));
    // The worst of the first six, which need not be the last of them.
    const auto end = share->modes.begin() + std::min<std::ptrdiff_t>(std::ssize(share->modes), 6);
    const auto worst = std::max_element(share->modes.begin(), end,
                                        [](const auto& a, const auto& b) { return a.error < b.error; });
    if (worst != share->modes.begin())
      text += fmt::format(", number {} {}", worst - share->modes.begin() + 1, percent_or_more(worst->error));
  }
  double worst = -1.0;
  std::string where;
  for (const MeshShare::Interface& interface : share->interfaces)
    if (interface.error > worst) worst = interface.error, where = interface.name;
  if (worst >= 0.0)
    text += fmt::format("{}static compliance at {} {}", text.empty() ? "  mesh error, estimated: " : "; ",
                        where, percent_or_more(worst));
  if (has_no_limit(*share)) text += "; static compliance: unknown (" + no_limit() + ")";
  return text + "\n" + (stresses ? stress_text(*share) : "");
}

std::string promised_statics(const MeshShare& share, bool stresses) {
  double statics = 0.0;
  for (const MeshShare::Interface& interface : share.interfaces) statics = std::max(statics, interface.error);
  std::string text = has_no_limit(share)        ? "; static compliance unknown, as " + no_limit()
                     : share.interfaces.empty() ? ""
                                                : fmt::format("; static compliance within {}",
                                                              percent_or_more(kMeshMargin * statics));
  if (!stresses) return text;
  const Worst worst = worst_stress(share);
  const std::string where = worst.singular ? " where it is finite" : "";
  if (worst.peak && kStressMargin * worst.peak->peak.error < 0.5)
    text += fmt::format("; greatest stress{} within {}", where,
                        percent_or_more(kStressMargin * worst.peak->peak.error));
  else if (worst.peak)
    text += fmt::format("; greatest stress{} not resolved by this mesh", where);
  else
    text += "; greatest stress unknown";
  if (worst.singular) text += fmt::format(", unbounded at {}", place(worst.singular->peak.singular_at));
  return text;
}

std::string too_coarse(const std::optional<MeshShare>& mesh) {
  if (!mesh) return "";
  double worst = mesh->modes.empty() ? 0.0 : mesh->modes.front().error;
  for (const MeshShare::Interface& interface : mesh->interfaces) worst = std::max(worst, interface.error);
  if (superelement::is_resolved(worst, mesh->rough)) return "";
  return fmt::format(
      "the mesh does not resolve the part: its error is estimated at {}; choose a smaller mesh size, or "
      "elements of "
      "order 2",
      percent_or_more(worst));
}

}  // namespace flexura::reduce
