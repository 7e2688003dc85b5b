// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/base/files/left_behind.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/hdf5/file.hpp"
#include "mbs/results/results.hpp"

// How a killed run stays readable: between runs the file is closed.  While a run writes, the file is open for
// appending (HDF5's single-writer mode), in which every write leaves consistent blocks on disk; groups cannot
// be made then, so begin_run() makes them all first and end_run() adds the summary afterwards.  Both write
// blocks in an order that leaves the file unreadable when they are cut, so they work on a copy of it.
namespace flexura::results {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto flush_interval = std::chrono::milliseconds(500);
constexpr std::size_t buffered_rows = 1024;  // one chunk of a series

std::string dump(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace);
}

struct Column {
  hdf5::Series series;
  std::vector<double> buffer;
  std::size_t width() const { return std::max<std::size_t>(series.width(), 1); }
};

}  // namespace

struct Writer::Impl {
  explicit Impl(const std::filesystem::path& path) : output(path), path(path), part(output.part()) {}
  files::Output output;
  std::filesystem::path path, part;
  bool closed = false;
  int n_runs = 0;

  // The open run.
  std::string run;
  std::vector<std::string> quantity_names, body_names;
  std::optional<hdf5::File> file;
  std::vector<Column> columns;  // time, quantities, then pose and modal of each body, then states
  std::vector<bool> has_modal;
  bool has_states = false;
  std::size_t n_buffered = 0;
  Clock::time_point last_flush;
  long n_rows = 0;  // of all runs

  void put(std::size_t column, const double* values, std::size_t count, const std::string& what,
           double time) {
    Column& c = columns[column];
    if (count != c.width()) {
      throw std::invalid_argument(fmt::format("{} has {} values, {} are wanted", what, count, c.width()));
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!std::isfinite(values[i])) {
        throw std::invalid_argument(
            fmt::format("{} is {} at time {:.9g} s; results must be finite", what, values[i], time));
      }
    }
    c.buffer.insert(c.buffer.end(), values, values + count);
  }

  void change(const std::function<void(hdf5::File&)>& what) {
    output.change([&](const std::filesystem::path& place) {
      hdf5::File changed(place, hdf5::Mode::modify);
      what(changed);
      changed.close();
    });
  }

  void flush() {
    for (Column& column : columns) {
      column.series.append(column.buffer.data(), column.buffer.size() / column.width());
      column.buffer.clear();
    }
    for (Column& column : columns) column.series.flush();
    n_buffered = 0;
    last_flush = Clock::now();
  }
};

Writer::Writer(const std::filesystem::path& path, const ModelHeader& model)
    : impl_(std::make_unique<Impl>(path)) {
  hdf5::File file(impl_->part, hdf5::Mode::create);
  {
    hdf5::Group root = file.root();
    root.set("format", "flexura results");
    root.set("version", 1);
    root.set("created_by", model.created_by);
    root.set("units", "SI: m, kg, s, rad");
    const Eigen::Vector3d& g = model.gravity;
    json header = {{"name", model.name},
                   {"created_by", model.created_by},
                   {"gravity", {g.x(), g.y(), g.z()}},
                   {"bodies", json::array()}};
    hdf5::Group bodies = root.create_group("bodies");
    for (const BodyHeader& body : model.bodies) {
      hdf5::Group group = bodies.create_group(body.name);
      group.set("kind", body.kind);
      group.set("superelement", body.superelement);
      group.write_text("shape", body.shape_json, "JSON: primitive shapes for pictures");
      header["bodies"].push_back(
          {{"name", body.name}, {"kind", body.kind}, {"superelement", body.superelement}});
    }
    root.write_text("header", dump(header),
                    "JSON: name, created_by, gravity [m/s^2], bodies in the order of the model");
    root.write_text("model", model.source, "the mechanism file");
    root.write_text("connections", model.connections_json,
                    "JSON: joints and forces with the bodies they join");
    root.create_group("runs");
  }
  file.close();
}

// What is not whole by now is closed first and removed then.
Writer::~Writer() {
  try {
    if (impl_->file) impl_->file->close();
  } catch (const std::exception&) {
    // Its trouble has been told.
  }
}

void Writer::begin_run(const std::string& run, const std::vector<Quantity>& quantities,
                       const std::vector<RunBody>& bodies, const std::vector<std::string>& state_names) {
  Impl& w = *impl_;
  if (w.closed || w.file) throw std::logic_error("begin_run: the results file is closed or a run is open");
  w.change([&](hdf5::File& file) {
    hdf5::Group group = file.root().group("runs").create_group(run);
    group.set("order", w.n_runs);
    group.set("complete", 0);
    json header = {{"quantities", json::array()}, {"bodies", json::array()}, {"states", state_names}};
    group.create_series("time", 0, "s", "output times");
    hdf5::Group quantity_group = group.create_group("quantities");
    for (const Quantity& quantity : quantities) {
      quantity_group.create_series(quantity.name, 0, quantity.unit, quantity.doc);
      header["quantities"].push_back(
          {{"name", quantity.name}, {"unit", quantity.unit}, {"doc", quantity.doc}});
    }
    hdf5::Group body_group = group.create_group("bodies");
    for (const RunBody& body : bodies) {
      hdf5::Group one = body_group.create_group(body.name);
      one.create_series("pose", 7, "m, 1", "position of Bo in W, quaternion w x y z of R_WB");
      const auto n_modes = static_cast<std::size_t>(body.basis.cols());
      if (n_modes > 0) {
        one.create_series("modal", n_modes, "", "modal coordinates s");
        hdf5::write_matrix(one, "basis", body.basis, "", "n_se x m: u_se = basis s");
      }
      header["bodies"].push_back({{"name", body.name}, {"n_se", body.basis.rows()}, {"n_modes", n_modes}});
    }
    if (!state_names.empty())
      group.create_series("states", state_names.size(), "", "states, named in the header");
    group.write_text("header", dump(header), "JSON: quantities, bodies and states in order");
  });
  w.file.emplace(w.part, hdf5::Mode::append);
  const hdf5::Group group = w.file->root().group("runs").group(run);
  w.columns.clear();
  w.quantity_names.clear();
  w.body_names.clear();
  w.has_modal.clear();
  w.columns.push_back({group.series("time"), {}});
  const hdf5::Group quantity_group = group.group("quantities");
  for (const Quantity& quantity : quantities) {
    w.columns.push_back({quantity_group.series(quantity.name), {}});
    w.quantity_names.push_back(quantity.name);
  }
  const hdf5::Group body_group = group.group("bodies");
  for (const RunBody& body : bodies) {
    const hdf5::Group one = body_group.group(body.name);
    w.columns.push_back({one.series("pose"), {}});
    w.has_modal.push_back(body.basis.cols() > 0);
    if (w.has_modal.back()) w.columns.push_back({one.series("modal"), {}});
    w.body_names.push_back(body.name);
  }
  w.has_states = !state_names.empty();
  if (w.has_states) w.columns.push_back({group.series("states"), {}});
  w.run = run;
  w.n_buffered = 0;
  w.last_flush = Clock::now();
  ++w.n_runs;
}

void Writer::append(const Row& row) {
  Impl& w = *impl_;
  if (!w.file) throw std::logic_error("append: no run is open");
  if (static_cast<std::size_t>(row.quantities.size()) != w.quantity_names.size() ||
      row.pose.size() != w.body_names.size() || row.modal.size() != w.body_names.size()) {
    throw std::invalid_argument("a row of results has another number of quantities or bodies than its run");
  }
  try {
    std::size_t column = 0;
    w.put(column++, &row.time, 1, "time", row.time);
    for (std::size_t i = 0; i < w.quantity_names.size(); ++i) {
      w.put(column++, &row.quantities[static_cast<Eigen::Index>(i)], 1, w.quantity_names[i], row.time);
    }
    for (std::size_t i = 0; i < w.body_names.size(); ++i) {
      w.put(column++, row.pose[i].data(), 7, "the pose of " + w.body_names[i], row.time);
      const auto n_modes = static_cast<std::size_t>(row.modal[i].size());
      const std::string what = "the deformation of " + w.body_names[i];
      if (w.has_modal[i]) {
        w.put(column++, row.modal[i].data(), n_modes, what, row.time);
      } else if (n_modes > 0) {
        throw std::invalid_argument(what + " is given, but the body is rigid in this run");
      }
    }
    if (w.has_states) {
      w.put(column++, row.states.data(), static_cast<std::size_t>(row.states.size()), "the state vector",
            row.time);
    }
  } catch (...) {
    // The row is whole or not there.
    for (Column& column : w.columns) column.buffer.resize(w.n_buffered * column.width());
    throw;
  }
  ++w.n_buffered;
  ++w.n_rows;
  if (w.n_buffered >= buffered_rows || Clock::now() - w.last_flush >= flush_interval) w.flush();
}

void Writer::end_run(bool complete, const std::string& stopped_because, const std::string& summary_json) {
  Impl& w = *impl_;
  if (!w.file) throw std::logic_error("end_run: no run is open");
  w.flush();
  w.columns.clear();
  w.file->close();
  w.file.reset();
  w.change([&](hdf5::File& file) {
    hdf5::Group group = file.root().group("runs").group(w.run);
    group.write_text("summary", summary_json, "JSON: energy balance, counts, times");
    group.set("stopped_because", stopped_because);
    group.set("complete", complete ? 1 : 0);
  });
}

bool Writer::keep(const std::string& stopped_because) {
  const Impl& w = *impl_;
  if (w.closed || w.n_rows == 0) return false;
  if (w.file) end_run(false, stopped_because, "{}");
  close();
  return true;
}

void Writer::close() {
  Impl& w = *impl_;
  if (w.closed) return;
  if (w.file) end_run(false, "the program ended the file while the run was going on", "{}");
  w.output.commit();
  w.closed = true;
  // Whole results take the place of those that a killed run left under a private name.
  files::remove_left_behind(w.path, "\x89HDF\r\n\x1a\n");
}

}  // namespace flexura::results
