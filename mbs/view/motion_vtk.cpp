// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/motion_vtk.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/new_folder.hpp"
#include "mbs/base/files/place.hpp"
#include "mbs/base/files/signals.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/polydata.hpp"
#include "mbs/superelement/text_file.hpp"
#include "mbs/view/body_shapes.hpp"
#include "mbs/view/stress_picture.hpp"
#include "mbs/view/surface_blocks.hpp"
#include "mbs/view/tessellate.hpp"
#include "mbs/view/thin.hpp"

namespace flexura::view {

namespace {

namespace fs = std::filesystem;
using superelement::Superelement;
using superelement::exchange::PolyData;

/// A body's points in its own frame and where they stand among all points.
struct Part {
  const results::BodyHistory* history = nullptr;  ///< null for the ground
  const Superelement* se = nullptr;               ///< its vertices are the first points
  std::shared_ptr<const StressField> stress;
  Eigen::Matrix3Xd points;
  Eigen::Index first = 0;
};

class VtkWriter {
 public:
  VtkWriter(const results::Results& results, const results::Run& run, const Pictures& pictures) : run_(run) {
    std::map<const Superelement*, std::shared_ptr<const StressField>> fields;
    std::vector<int> line_bodies, triangle_bodies;
    for (std::size_t b = 0; b < results.model.bodies.size(); ++b) {
      const auto& body = results.model.bodies[b];
      Part part;
      for (const auto& history : run.bodies) {
        if (history.name == body.name) part.history = &history;
      }
      Tessellation shapes;
      if (const auto found = pictures.find(body.name); found != pictures.end() && found->second) {
        part.se = found->second.get();
        require_fit(part, body.name);
        for (Eigen::Index v = 0; v < part.se->surface.vertices.rows(); ++v) {
          shapes.points.push_back(part.se->surface.vertices.row(v));
        }
        for (Eigen::Index t = 0; t < part.se->surface.triangles.rows(); ++t) {
          const auto row = part.se->surface.triangles.row(t);
          shapes.triangles.push_back({row[0], row[1], row[2]});
        }
        // Lines only where there are no faces (beams).
        for (Eigen::Index e = 0; e < part.se->surface.edges.rows() && shapes.triangles.empty(); ++e) {
          shapes.lines.push_back({part.se->surface.edges(e, 0), part.se->surface.edges(e, 1)});
        }
        if (part.se->stress) {
          auto& field = fields[part.se];
          if (!field) field = std::make_shared<const StressField>(*part.se);
          part.stress = field;
          has_stress_ = true;
        }
      }
      for (const auto& shape : parse_body_shapes(body.name, body.shape_json)) tessellate(shape, shapes);
      part.first = n_points_;
      part.points.resize(3, static_cast<Eigen::Index>(shapes.points.size()));
      for (std::size_t i = 0; i < shapes.points.size(); ++i)
        part.points.col(static_cast<Eigen::Index>(i)) = shapes.points[i];
      n_points_ += part.points.cols();
      const auto offset = static_cast<std::int32_t>(part.first);
      for (const auto& t : shapes.triangles) {
        triangles_.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        triangle_bodies.push_back(static_cast<int>(b));
      }
      for (const auto& l : shapes.lines) {
        lines_.push_back({l[0] + offset, l[1] + offset});
        line_bodies.push_back(static_cast<int>(b));
      }
      parts_.push_back(std::move(part));
    }
    // PolyData numbers its cells lines first.
    line_bodies.insert(line_bodies.end(), triangle_bodies.begin(), triangle_bodies.end());
    cell_bodies_ =
        Eigen::Map<const Eigen::VectorXi>(line_bodies.data(), static_cast<Eigen::Index>(line_bodies.size()));
  }

  void write(const fs::path& path, Eigen::Index row) const {
    PolyData::Points points(n_points_, 3);
    Eigen::VectorXf displacement = Eigen::VectorXf::Zero(3 * n_points_);
    Eigen::VectorXf stress = Eigen::VectorXf::Zero(has_stress_ ? n_points_ : 0);
    for (const Part& part : parts_) {
      Eigen::Matrix3Xd p = part.points;
      Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
      Eigen::Vector3d p_WBo = Eigen::Vector3d::Zero();
      if (part.history) {
        const auto pose = part.history->pose.row(row);
        R_WB = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).normalized().toRotationMatrix();
        p_WBo = pose.head<3>();
      }
      // Of a beam of the mechanism file pictures have the elements.
      if (part.history && part.se && part.history->basis.cols() > 0) {
        const Eigen::VectorXd u_se = part.history->basis * part.history->modal.row(row).transpose();
        const Eigen::VectorXf u = part.se->shapes * u_se.cast<float>();
        const Eigen::Map<const Eigen::Matrix3Xf> moved(u.data(), 3, u.size() / 3);
        p.leftCols(moved.cols()) += moved.cast<double>();
        Eigen::Map<Eigen::Matrix3Xf>(displacement.data() + 3 * part.first, 3, moved.cols()) =
            R_WB.cast<float>() * moved;
        if (part.stress) stress.segment(part.first, moved.cols()) = part.stress->von_mises(u_se);
      }
      points.middleRows(part.first, p.cols()) = ((R_WB * p).colwise() + p_WBo).transpose();
    }
    PolyData data(points, by_rows<3>(triangles_), by_rows<2>(lines_));
    data.add_field("TimeValue", run_.time[row]);
    data.add_point_array("displacement", 3, displacement);
    if (has_stress_) data.add_point_array("von Mises stress", 1, stress);
    data.add_cell_array("body", cell_bodies_);
    data.write(path);
  }

 private:
  template <int corners>
  static Eigen::Matrix<std::int32_t, Eigen::Dynamic, corners, Eigen::RowMajor> by_rows(
      const std::vector<std::array<std::int32_t, static_cast<std::size_t>(corners)>>& cells) {
    return Eigen::Map<const Eigen::Matrix<std::int32_t, Eigen::Dynamic, corners, Eigen::RowMajor>>(
        cells.empty() ? nullptr : cells.front().data(), static_cast<Eigen::Index>(cells.size()), corners);
  }

  void require_fit(const Part& part, const std::string& body) const {
    if (!part.history || part.history->basis.cols() == 0) return;
    require_pictures(*part.se);
    if (part.history->basis.rows() != part.se->n()) {
      throw std::invalid_argument(
          fmt::format("run '{}' moves body '{}' in a basis of {} rows, but its superelement '{}' has {} "
                      "shape functions: it is not "
                      "the one that was simulated",
                      run_.name, body, part.history->basis.rows(), part.se->name, part.se->n()));
    }
  }

  const results::Run& run_;
  std::vector<Part> parts_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<std::array<std::int32_t, 2>> lines_;
  Eigen::VectorXi cell_bodies_;
  Eigen::Index n_points_ = 0;
  bool has_stress_ = false;
};

// The pictures of a run without their list are in the way: those that are new go where it does not come to
// that.
struct Frames {
  std::vector<fs::path> begun{};
  ~Frames() {
    std::error_code none;
    for (const fs::path& file : begun) fs::remove(file, none);
  }
};

fs::path folder_of(const fs::path& stem, const results::Run& run) {
  return stem.string() + "." + run.name;
}

fs::path frame_of(const fs::path& folder, int number) {
  return folder / fmt::format("{:05}.vtp", number);
}

// Before the first picture is written: can all of them be where they belong?
void require_places(const fs::path& folder, std::size_t n_frames) {
  std::error_code failure;
  const fs::file_status status = fs::status(folder, failure);
  if (status.type() == fs::file_type::not_found) {
    files::place_of(folder);  // its own folder
    return;
  }
  if (!fs::is_directory(status))
    throw std::invalid_argument(fmt::format(
        "{}: is no folder, and the pictures are to be put in one of this name; name another output",
        folder.string()));
  for (std::size_t k = 0; k < n_frames; ++k) {
    const fs::path frame = frame_of(folder, static_cast<int>(k));
    files::place_of(frame);
    if (const auto input = files::input_like(frame))
      throw std::invalid_argument(
          fmt::format("{}: is read by this command, as {}, and would be overwritten; name another output",
                      frame.string(), input->string()));
  }
}

}  // namespace

std::vector<fs::path> write_motion_vtk(const fs::path& stem, const results::Results& results,
                                       const Pictures& pictures, int most_frames) {
  using superelement::exchange::escape_xml;
  for (const results::Run& run : results.runs)
    if (run.time.size() > 0) require_places(folder_of(stem, run), thin(run.time.size(), most_frames).size());
  const files::StopRequests signals;
  std::vector<fs::path> written;
  for (const results::Run& run : results.runs) {
    if (run.time.size() == 0) continue;
    const VtkWriter writer(results, run, pictures);
    const fs::path folder = folder_of(stem, run);
    const files::NewFolder made(folder);
    std::string list =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
    int number = 0;
    Frames frames;
    for (const Eigen::Index row : thin(run.time.size(), most_frames)) {
      if (files::StopRequests::wanted())
        throw std::runtime_error(fmt::format("interrupted by {}; the list of the pictures is not written",
                                             files::StopRequests::name()));
      const fs::path frame = frame_of(folder, number++);
      std::error_code none;
      if (!fs::exists(fs::symlink_status(frame, none))) frames.begun.push_back(frame);
      writer.write(frame, row);
      list += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", run.time[row],
                          escape_xml((folder.filename() / frame.filename()).generic_string()));
    }
    written.push_back(stem.string() + "." + run.name + ".pvd");
    superelement::write_whole(written.back(), list + "</Collection>\n</VTKFile>\n");
    frames.begun.clear();
  }
  if (written.empty())
    throw std::invalid_argument("the results hold no run with a stored time: simulate first");
  return written;
}

}  // namespace flexura::view
