// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"
#include "mbs/base/files/plain_text.hpp"
#include "mbs/base/hdf5/file.hpp"
#include "mbs/results/results.hpp"

namespace flexura::results {
namespace {

using nlohmann::json;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int format_version = 1;

json parse(const hdf5::Group& group, const std::string& name) {
  try {
    return files::read_json(group.read_text(name));
  } catch (const json::exception&) {
    throw hdf5::BadFile(
        fmt::format("{}/{}: cannot be understood; the file is damaged, make it again", group.label(), name));
  }
}

// All series of a run; a killed run may have flushed some of them once more than others.
struct SeriesOfRun {
  std::vector<hdf5::Series> all;
  std::size_t common_rows() const {
    std::size_t n = all.front().n_rows();
    for (const hdf5::Series& series : all) n = std::min(n, series.n_rows());
    return n;
  }
};

RowMajor read_rows(const hdf5::Series& series, std::size_t n_rows) {
  const std::vector<double> values = series.read(n_rows);
  const auto odd = std::ranges::find_if(values, [](double value) { return !std::isfinite(value); });
  if (odd != values.end())
    throw hdf5::BadFile(fmt::format(
        "{}: number {} of its rows is not finite, which no run writes; the file is damaged, make it again",
        series.label(), odd - values.begin() + 1));
  const auto width = static_cast<Eigen::Index>(std::max<std::size_t>(series.width(), 1));
  return Eigen::Map<const RowMajor>(values.data(), static_cast<Eigen::Index>(values.size()) / width, width);
}

Run read_run(const hdf5::Group& group, const std::string& name) {
  Run run;
  run.name = files::plain_text(name);
  run.complete = group.integer("complete") != 0;
  run.stopped_because = group.has_attribute("stopped_because")
                            ? group.text("stopped_because")
                            : "the run is still going on, or the program was killed";
  run.summary_json = group.has("summary") ? group.read_text("summary") : "{}";
  const json header = parse(group, "header");
  SeriesOfRun series;
  series.all.push_back(group.series("time"));
  const hdf5::Group quantity_group = group.group("quantities");
  for (const json& entry : header.at("quantities")) {
    run.quantities.push_back({entry.at("name"), entry.at("unit"), entry.at("doc")});
    series.all.push_back(quantity_group.series(run.quantities.back().name));
  }
  const hdf5::Group body_group = group.group("bodies");
  std::vector<bool> has_modal;
  for (const json& entry : header.at("bodies")) {
    BodyHistory body;
    body.name = entry.at("name");
    const hdf5::Group one = body_group.group(body.name);
    series.all.push_back(one.series("pose"));
    if (series.all.back().width() != 7) throw hdf5::BadFile(one.label() + "/pose: does not have 7 columns");
    has_modal.push_back(entry.at("n_modes").get<int>() > 0);
    if (has_modal.back()) {
      series.all.push_back(one.series("modal"));
      body.basis = hdf5::read_matrix(one, "basis", entry.at("n_se"), entry.at("n_modes"));
    }
    run.bodies.push_back(std::move(body));
  }
  run.state_names = header.at("states").get<std::vector<std::string>>();
  if (!run.state_names.empty()) series.all.push_back(group.series("states"));

  const std::size_t n_t = series.common_rows();
  std::size_t at = 0;
  run.time = read_rows(series.all[at++], n_t);
  run.values.resize(static_cast<Eigen::Index>(n_t), static_cast<Eigen::Index>(run.quantities.size()));
  for (Eigen::Index i = 0; i < run.values.cols(); ++i) run.values.col(i) = read_rows(series.all[at++], n_t);
  for (std::size_t i = 0; i < run.bodies.size(); ++i) {
    run.bodies[i].pose = read_rows(series.all[at++], n_t);
    if (has_modal[i]) run.bodies[i].modal = read_rows(series.all[at++], n_t);
  }
  if (!run.state_names.empty()) run.states = read_rows(series.all[at++], n_t);
  return run;
}

}  // namespace

Results read(const std::filesystem::path& path) {
  const hdf5::File file(path, hdf5::Mode::read);
  const hdf5::Group root = file.root();
  if (!root.has_attribute("format") || root.text("format") != "flexura results") {
    throw hdf5::BadFile(
        path.string() +
        ": is an HDF5 file but holds no results of a simulation; make one with \"flexura simulate\"");
  }
  if (const int version = root.integer("version"); version > format_version) {
    throw hdf5::BadFile(
        fmt::format("{}: is written in version {} of the results format, this program reads up to {}; "
                    "update Flexura",
                    path.string(), version, format_version));
  }
  Results results;
  try {
    const json header = parse(root, "header");
    results.model.name = header.at("name");
    results.model.created_by = header.at("created_by");
    if (header.contains("gravity"))
      for (int k = 0; k < 3; ++k) results.model.gravity(k) = header["gravity"].at(k);
    results.model.source = root.read_text("model");
    results.model.connections_json = root.read_text("connections");
    const hdf5::Group bodies = root.group("bodies");
    for (const json& entry : header.at("bodies")) {
      BodyHeader body{entry.at("name"), entry.at("kind"), entry.at("superelement"), ""};
      body.shape_json = bodies.group(body.name).read_text("shape");
      results.model.bodies.push_back(std::move(body));
    }
    const hdf5::Group runs = root.group("runs");
    std::vector<std::pair<int, std::string>> in_order;
    for (const std::string& name : runs.names())
      in_order.emplace_back(runs.group(name).integer("order"), name);
    std::sort(in_order.begin(), in_order.end());
    for (const auto& [order, name] : in_order) results.runs.push_back(read_run(runs.group(name), name));
  } catch (const json::exception&) {
    throw hdf5::BadFile(
        path.string() +
        ": a header lacks an entry, or has one of another kind; the file is damaged, make it again");
  }
  return results;
}

}  // namespace flexura::results
