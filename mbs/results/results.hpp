// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// The results file of a simulation: HDF5, one group for each run, every scalar quantity by name and with its
/// unit.
///
///     /                                   format, version, created_by, model (the input file's text)
///     /bodies/NAME                        kind, superelement, shape (JSON for pictures)
///     /connections (JSON)                 joints, forces, with the bodies they join, for pictures
///     /runs/RUN/time                      n_t [s]
///     /runs/RUN/quantities/NAME           n_t, attributes unit and doc
///     /runs/RUN/bodies/NAME/pose          n_t x 7: position of Bo in W [m], quaternion w x y z of R_WB
///     /runs/RUN/bodies/NAME/modal         n_t x m modal coordinates s
///     /runs/RUN/bodies/NAME/basis         n_se x m: superelement coordinates u_se = basis s
///     /runs/RUN/states                    n_t x n_y, with the states' names
///     /runs/RUN  attributes               complete (0 or 1), stopped_because, summary (JSON)
namespace flexura::results {

struct Quantity {
  std::string name;  ///< "crank.speed", "energy.kinetic"
  std::string unit;  ///< SI, "rad/s"
  std::string doc;
};

struct BodyHeader {
  std::string name;
  std::string kind;          ///< "ground", "rigid" or "flexible"
  std::string superelement;  ///< path relative to the results file, or ""
  std::string shape_json;    ///< primitive shapes for pictures, see mbs/view
};

struct ModelHeader {
  std::string name;
  std::string source;  ///< the mechanism file's text
  std::string created_by;
  std::vector<BodyHeader> bodies;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< [m/s^2] in W: pictures stand upright in it
  std::string connections_json;  ///< [{"name","kind","body_1","p_1","body_2","p_2","axis_1"}...]
};

struct RunBody {
  std::string name;
  Eigen::MatrixXd basis;  ///< n_se x m; empty for a rigid body
};

/// What a run stores at one output time.
struct Row {
  double time = 0.0;
  Eigen::VectorXd quantities;                     ///< in the order of the run's quantities
  std::vector<Eigen::Matrix<double, 7, 1>> pose;  ///< one for each run body
  std::vector<Eigen::VectorXd> modal;             ///< one for each run body, empty for rigid ones
  Eigen::VectorXd states;                         ///< empty when states are not stored
};

/// Writes as it goes (a killed run leaves FILE.part, readable up to its last flush); close() renames to FILE.
class Writer {
 public:
  Writer(const std::filesystem::path& path, const ModelHeader& model);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void begin_run(const std::string& run, const std::vector<Quantity>& quantities,
                 const std::vector<RunBody>& bodies, const std::vector<std::string>& state_names = {});
  /// Buffered, flushed at least every second.  Throws std::invalid_argument, naming the quantity and the
  /// time, for a value that is not finite; the file keeps all rows up to there.
  void append(const Row& row);
  void end_run(bool complete, const std::string& stopped_because, const std::string& summary_json);
  /// After a failure: ends the open run as incomplete for this reason and closes the file.  False when there
  /// is no row to keep.
  bool keep(const std::string& stopped_because);
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct BodyHistory {
  std::string name;
  Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> pose;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> modal;
  Eigen::MatrixXd basis;
};

struct Run {
  std::string name;
  bool complete = false;
  std::string stopped_because, summary_json;
  Eigen::VectorXd time;
  std::vector<Quantity> quantities;
  Eigen::MatrixXd values;  ///< n_t x n_quantities
  std::vector<BodyHistory> bodies;
  std::vector<std::string> state_names;
  Eigen::MatrixXd states;  ///< n_t x n_y, empty when they were not stored
};

struct Results {
  ModelHeader model;
  std::vector<Run> runs;
};

/// Reads a results file whole; also a FILE.part.  Throws std::runtime_error, one sentence.
Results read(const std::filesystem::path& path);

/// One CSV file per run beside `path`, engine.h5 giving engine.RUN.csv: time and all quantities, names and
/// units in the first line.
std::vector<std::filesystem::path> write_csv(const Results& results, const std::filesystem::path& path);

}  // namespace flexura::results
