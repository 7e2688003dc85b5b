// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/node_motions.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <fstream>
#include <map>
#include <stdexcept>

#include "mbs/base/files/output.hpp"
#include "mbs/base/files/table_text.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/thin.hpp"

namespace flexura::view {

namespace {

namespace fs = std::filesystem;
using superelement::Superelement;
using Bodies = std::map<std::string, Superelement>;

Bodies bodies_with_nodes(const results::ModelHeader& model, const fs::path& results_file) {
  Bodies bodies;
  for (const results::BodyHeader& body : model.bodies) {
    if (body.superelement.empty()) continue;
    const fs::path path = (results_file.parent_path() / body.superelement).lexically_normal();
    if (!fs::exists(path))
      throw std::runtime_error(fmt::format(
          "the nodes of body '{}' are those of '{}', which is not there: put it back, or run the simulation "
          "again to name the new place",
          body.name, path.string()));
    superelement::Parts parts{.matrices = false, .inertia = false};
    parts.nodes = true;
    Superelement se = superelement::read(path, parts);
    if (se.nodes) bodies.emplace(body.name, std::move(se));
  }
  if (bodies.empty())
    throw std::invalid_argument(
        "no body's superelement keeps the motions of all nodes: reduce the part with [recovery] nodes = "
        "\"all\"");
  return bodies;
}

void append_rows(const results::BodyHistory& history, const Superelement& se, Eigen::Index row, double time,
                 fmt::memory_buffer& out) {
  const auto pose = history.pose.row(row);
  const Eigen::Matrix3d R_WB =
      Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).normalized().toRotationMatrix();
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(se.nodes->T.rows());
  if (history.basis.cols() > 0) motion = se.nodes->T * (history.basis * history.modal.row(row).transpose());
  const std::string body = files::csv_field(history.name);
  for (std::size_t i = 0; i < se.nodes->numbers.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto q = motion.segment<6>(6 * k);
    const Eigen::Vector3d x =
        pose.head<3>().transpose() + R_WB * (se.nodes->positions.row(k).transpose() + q.head<3>());
    fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{}", time, body, se.nodes->numbers[i], x[0], x[1],
                   x[2]);
    for (const double value : q) fmt::format_to(std::back_inserter(out), ",{}", value);
    out.push_back('\n');
  }
}

void write_run(const results::Run& run, const Bodies& bodies, int most_frames, const fs::path& path) {
  for (const results::BodyHistory& history : run.bodies) {
    const auto found = bodies.find(history.name);
    if (found != bodies.end() && history.basis.cols() > 0 && history.basis.rows() != found->second.n())
      throw std::invalid_argument(
          fmt::format("run '{}' moves body '{}' in a basis of {} rows, but its superelement has {} shape "
                      "functions: it is "
                      "not the one that was simulated",
                      run.name, history.name, history.basis.rows(), found->second.n()));
  }
  std::ofstream out(path, std::ios::binary);
  out << "time [s],body,node,x [m],y [m],z [m],u_x [m],u_y [m],u_z [m],theta_x [rad],theta_y [rad],theta_z "
         "[rad]\n";
  fmt::memory_buffer lines;
  for (const Eigen::Index row : thin(run.time.size(), most_frames))
    for (const results::BodyHistory& history : run.bodies) {
      const auto found = bodies.find(history.name);
      if (found == bodies.end()) continue;
      append_rows(history, found->second, row, run.time[row], lines);
      out.write(lines.data(), static_cast<std::streamsize>(lines.size()));
      lines.clear();
    }
  out.close();
  if (!out)
    throw std::runtime_error(path.string() +
                             ": cannot be written; check the folder, its permissions and the disk");
}

}  // namespace

std::vector<fs::path> write_node_motions(const fs::path& stem, const results::Results& results,
                                         const fs::path& results_file, int most_frames) {
  const Bodies bodies = bodies_with_nodes(results.model, results_file);
  std::vector<fs::path> written;
  for (const results::Run& run : results.runs) {
    const fs::path path = fmt::format("{}.{}.nodes.csv", stem.string(), run.name);
    files::Output output(path);
    write_run(run, bodies, most_frames, output.part());
    output.commit();
    written.push_back(path);
  }
  return written;
}

}  // namespace flexura::view
