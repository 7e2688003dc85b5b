// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "mbs/base/files/json_text.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/body_shapes.hpp"
#include "mbs/view/html/page_file.hpp"
#include "mbs/view/largest.hpp"
#include "mbs/view/pages.hpp"
#include "mbs/view/stress_picture.hpp"
#include "mbs/view/surface_blocks.hpp"
#include "mbs/view/thin.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;
using superelement::Superelement;

/// A superelement with every basis in which the runs move it: column j of bases[i] is shape first + j of the
/// surface.
struct Figure {
  const Superelement* se;
  std::vector<const Eigen::MatrixXd*> bases;
  std::vector<int> first;
  int n_shapes = 0;

  int use(const Eigen::MatrixXd& basis) {
    for (std::size_t i = 0; i < bases.size(); ++i) {
      if (bases[i]->rows() == basis.rows() && bases[i]->cols() == basis.cols() && *bases[i] == basis)
        return first[i];
    }
    bases.push_back(&basis);
    first.push_back(n_shapes);
    n_shapes += static_cast<int>(basis.cols());
    return first.back();
  }
};

template <typename T, typename Matrix>
std::vector<T> gather(const Matrix& m, const std::vector<Eigen::Index>& rows) {
  std::vector<T> values;
  values.reserve(rows.size() * static_cast<std::size_t>(m.cols()));
  // Column after column: each one is smooth in time.
  for (Eigen::Index c = 0; c < m.cols(); ++c) {
    for (const Eigen::Index r : rows) values.push_back(static_cast<T>(m(r, c)));
  }
  return values;
}

/// Name, place [m] in the body, and how each modal coordinate displaces and turns them (m x 6, m and rad).
json frames_json(const std::vector<ReferenceFrame>& frames) {
  json list = json::array();
  for (const ReferenceFrame& frame : frames) {
    json motion = json::array();
    for (const auto& column : frame.motion.colwise())
      motion.push_back(std::vector<double>(column.begin(), column.end()));
    list.push_back(
        {{"name", frame.name}, {"point", {frame.p.x(), frame.p.y(), frame.p.z()}}, {"motion", motion}});
  }
  return list;
}

/// The frame at which a joint to the ground holds the body, or null.
json held_by(const json& frames, const json& connections, const std::string& body) {
  if (!connections.is_array()) return nullptr;
  for (const json& c : connections)
    for (const auto& [own, other, point] :
         {std::array{"body_1", "body_2", "p_1"}, std::array{"body_2", "body_1", "p_2"}}) {
      if (!c.is_object() || !c.value("is_joint", false) || c.value(own, "") != body ||
          c.value(other, "") != "ground")
        continue;
      const auto p = c.find(point);
      for (std::size_t i = 0; p != c.end() && i < frames.size(); ++i)
        if (*p == frames[i].at("point")) return i;
    }
  return nullptr;
}

void sort_unique(std::vector<Eigen::Index>& rows) {
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

/// JSON kept in the results, or null where it cannot be read: a page is more useful than a refusal.
json lenient(const std::string& text) {
  json value = files::try_read_json(text);
  return value.is_discarded() ? json() : value;
}

class MotionWriter {
 public:
  MotionWriter(const std::filesystem::path& html, const results::Results& results, const Pictures& pictures,
               const MotionPage& page)
      : results_(results),
        pictures_(pictures),
        page_(page),
        html_(html),
        connections_(lenient(results.model.connections_json)) {}

  void write() {
    require_something();
    const json plots = plots_json();
    json bodies = bodies_json();
    find_figures();
    const std::string name = results_.model.name.empty() ? html_.stem().string() : results_.model.name;
    file_.emplace(html_, name + " · motion");
    const json surfaces = surfaces_json();
    const Eigen::Vector3d& g = results_.model.gravity;
    json runs = json::array();
    for (std::size_t i = 0; i < results_.runs.size(); ++i) runs.push_back(run_json(i));
    file_->finish({{"format", 1},
                   {"page", "motion"},
                   {"title", name},
                   {"created_by", results_.model.created_by},
                   {"surfaces", surfaces},
                   {"gravity", {g.x(), g.y(), g.z()}},
                   {"bodies", bodies},
                   {"connections", connections_},
                   {"plots", plots},
                   {"runs", runs}});
  }

 private:
  void require_something() const {
    for (const auto& run : results_.runs) {
      if (run.time.size() > 0) return;
    }
    throw std::invalid_argument("the results hold no run with a stored time: simulate first");
  }

  json plots_json() const {
    json plots = json::array();
    for (const std::string& entry : page_.plots) {
      json names = json::array();
      for (std::size_t from = 0; from <= entry.size();) {
        const std::size_t to = std::min(entry.find(',', from), entry.size());
        std::string name = entry.substr(from, to - from);
        name.erase(0, name.find_first_not_of(' '));
        name.erase(name.find_last_not_of(' ') + 1);
        require_quantity(name);
        names.push_back(name);
        from = to + 1;
      }
      plots.push_back(names);
    }
    return plots;
  }

  void require_quantity(const std::string& name) const {
    std::vector<std::string> known;
    for (const auto& run : results_.runs) {
      for (const auto& quantity : run.quantities) {
        if (quantity.name == name) return;
        known.push_back(quantity.name);
      }
    }
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    throw std::invalid_argument(
        fmt::format("no run stored the quantity '{}' that is to be plotted; stored are {}", name,
                    fmt::join(known, ", ")));
  }

  json bodies_json() const {
    json bodies = json::array();
    for (const auto& body : results_.model.bodies) {
      bodies.push_back({{"name", body.name},
                        {"kind", body.kind},
                        {"shapes", parse_body_shapes(body.name, body.shape_json)},
                        {"surface", nullptr}});
    }
    return bodies;
  }

  /// The superelement a body is drawn from, or null.
  const Superelement* picture(const std::string& body) const {
    const auto found = pictures_.find(body);
    if (found == pictures_.end() || !found->second || found->second->surface.vertices.rows() == 0)
      return nullptr;
    return found->second.get();
  }

  void find_figures() {
    for (const auto& body : results_.model.bodies) {
      if (const Superelement* se = picture(body.name)) figure_of(*se);
    }
    for (const auto& run : results_.runs) {
      for (const auto& body : run.bodies) {
        const Superelement* se = picture(body.name);
        if (!se || body.basis.cols() == 0) continue;
        require_pictures(*se);
        if (body.basis.rows() != se->n() || body.modal.cols() != body.basis.cols()) {
          throw std::invalid_argument(
              fmt::format("run '{}' moves body '{}' with {} modal coordinates in a basis of {} x {}, but its "
                          "superelement '{}' has "
                          "{} shape functions: it is not the one that was simulated",
                          run.name, body.name, body.modal.cols(), body.basis.rows(), body.basis.cols(),
                          se->name, se->n()));
        }
        first_shape_[&body] = figures_[figure_of(*se)].use(body.basis);
      }
    }
  }

  std::size_t figure_of(const Superelement& se) {
    for (std::size_t i = 0; i < figures_.size(); ++i) {
      if (figures_[i].se == &se) return i;
    }
    figures_.push_back({&se, {}, {}, 0});
    return figures_.size() - 1;
  }

  json surfaces_json() {
    json surfaces = json::array();
    for (std::size_t i = 0; i < figures_.size(); ++i) {
      const Figure& figure = figures_[i];
      SurfaceBlocks blocks(*file_, fmt::format("surface{}", i), figure.se->surface,
                           fmt::format("superelement '{}'", figure.se->name), figure.n_shapes);
      std::optional<StressField> stress;
      if (figure.se->stress) stress.emplace(*figure.se);
      for (const Eigen::MatrixXd* basis : figure.bases) {
        for (Eigen::Index j = 0; j < basis->cols(); ++j) {
          blocks.add_shape(figure.se->shapes * basis->col(j).cast<float>());
          if (stress) blocks.add_stress(stress->components(basis->col(j)), 6);
        }
      }
      surfaces.push_back(blocks.header());
      if (figure.se->sections)
        surfaces.back()["sections"] = sections_json(figure, fmt::format("surface{}", i));
    }
    return surfaces;
  }

  /// Where section forces are given; those of each shape as blocks KEY/section/J.
  json sections_json(const Figure& figure, const std::string& key) {
    const superelement::SectionForces& sections = *figure.se->sections;
    int shape = 0;
    for (const Eigen::MatrixXd* basis : figure.bases) {
      const Eigen::MatrixXf forces = (sections.S * *basis).cast<float>();
      for (Eigen::Index j = 0; j < forces.cols(); ++j)
        file_->add<float>(fmt::format("{}/section/{}", key, shape++),
                          std::span(forces.col(j).data(), static_cast<std::size_t>(forces.rows())));
    }
    const auto rows = [](const auto& m) {
      json list = json::array();
      for (Eigen::Index i = 0; i < m.rows(); ++i)
        list.push_back(std::vector<double>(m.row(i).begin(), m.row(i).end()));
      return list;
    };
    return {{"members", sections.members},
            {"member", sections.member},
            {"positions", rows(sections.positions)},
            {"axes", rows(sections.axes)}};
  }

  /// Of every body: where and when displacement (by the page's references) and stress are largest.  The rows of it become
  /// frames, so that the page can show them.
  std::vector<json> largest_json(const results::Run& run, std::vector<Eigen::Index>& frames) const {
    std::vector<json> bodies(run.bodies.size());
    if (run.time.size() == 0) return bodies;
    const auto entry = [&](const Largest& most) -> json {
      frames.push_back(most.row);
      return {{"value", most.value}, {"time", run.time[most.row]}, {"vertex", most.vertex}};
    };
    for (std::size_t j = 0; j < run.bodies.size(); ++j) {
      const results::BodyHistory& body = run.bodies[j];
      if (!first_shape_.contains(&body)) continue;
      const Superelement& se = *picture(body.name);
      std::vector<const results::BodyHistory*> observers;
      for (const results::BodyHistory& other : run.bodies) observers.push_back(&other);
      for (const auto& [from, most] :
           largest_displacements(se, body, reference_frames(se, body.basis), observers))
        bodies[j]["displacement"][from] = entry(most);
      if (const auto most = largest_stress(se, body, run)) {
        bodies[j]["stress"] = entry(*most);
        bodies[j]["stress"]["drawn"] = drawn_stress(se, body, *most);
      }
      // Diagrams of section forces are scaled by what the frames show: six rows for the six resultants.
      if (!se.sections) continue;
      const Eigen::MatrixXd forces = se.sections->S * body.basis * body.modal.transpose();
      for (Eigen::Index c = 0; c < 6; ++c) {
        Eigen::Index row = 0;
        const auto of_all = Eigen::seq(c, forces.rows() - 6 + c, Eigen::fix<6>);
        forces(of_all, Eigen::all).cwiseAbs().colwise().maxCoeff().maxCoeff(&row);
        frames.push_back(row);
      }
    }
    sort_unique(frames);
    return bodies;
  }

  /// The rows at which a quantity is largest or smallest stay in its plot.
  static void keep_peaks(const results::Run& run, std::vector<Eigen::Index>& rows) {
    for (Eigen::Index j = 0; j < run.values.cols() && run.time.size() > 0; ++j) {
      Eigen::Index row = 0;
      run.values.col(j).maxCoeff(&row);
      rows.push_back(row);
      run.values.col(j).minCoeff(&row);
      rows.push_back(row);
    }
    sort_unique(rows);
  }

  json run_json(std::size_t number) {
    const results::Run& run = results_.runs[number];
    const std::string key = fmt::format("run{}", number);
    const Eigen::Index rows = run.time.size();
    const auto n_quantities = static_cast<double>(run.quantities.size() + 1);
    auto frames = thin(rows, page_.most_frames);
    auto kept = thin(rows, page_.most_values / n_quantities / static_cast<double>(results_.runs.size()));
    const std::vector<json> largest = largest_json(run, frames);
    keep_peaks(run, kept);
    file_->add<double>(key + "/frame_time", gather<double>(run.time, frames));
    file_->add<double>(key + "/time", gather<double>(run.time, kept));
    json quantities = json::array();
    for (std::size_t j = 0; j < run.quantities.size(); ++j) {
      const auto& quantity = run.quantities[j];
      file_->add<double>(fmt::format("{}/quantity/{}", key, j),
                         gather<double>(run.values.col(static_cast<Eigen::Index>(j)), kept));
      quantities.push_back({{"name", quantity.name}, {"unit", quantity.unit}, {"doc", quantity.doc}});
    }
    json bodies = json::array();
    for (std::size_t j = 0; j < run.bodies.size(); ++j) {
      const auto& body = run.bodies[j];
      file_->add<float>(fmt::format("{}/body/{}/pose", key, j), gather<float>(body.pose, frames));
      json entry = {{"name", body.name}, {"surface", nullptr}, {"first_shape", 0}, {"n_shapes", 0}};
      if (const Superelement* se = picture(body.name)) entry["surface"] = figure_of(*se);
      if (const auto found = first_shape_.find(&body); found != first_shape_.end()) {
        file_->add<float>(fmt::format("{}/body/{}/modal", key, j), gather<float>(body.modal, frames));
        entry["first_shape"] = found->second;
        entry["n_shapes"] = body.basis.cols();
        entry["frames"] = frames_json(reference_frames(*picture(body.name), body.basis));
        entry["largest"] = largest[j];
        entry["held_by"] = held_by(entry["frames"], connections_, body.name);
      }
      bodies.push_back(entry);
    }
    return {{"name", run.name},         {"complete", run.complete}, {"stopped_because", run.stopped_because},
            {"rows_stored", rows},      {"rows", kept.size()},      {"frames", frames.size()},
            {"quantities", quantities}, {"bodies", bodies},         {"summary", lenient(run.summary_json)}};
  }

  const results::Results& results_;
  const Pictures& pictures_;
  const MotionPage& page_;
  const std::filesystem::path html_;
  const json connections_;
  std::vector<Figure> figures_;
  std::map<const results::BodyHistory*, int> first_shape_;
  std::optional<PageFile> file_;
};

}  // namespace

Pictures read_pictures(const results::ModelHeader& model, const std::filesystem::path& results_file) {
  Pictures pictures;
  std::map<std::filesystem::path, std::shared_ptr<const Superelement>> known;
  for (const auto& body : model.bodies) {
    if (body.superelement.empty()) continue;
    const auto path = (results_file.parent_path() / body.superelement).lexically_normal();
    auto& se = known[path];
    if (!se) {
      if (!std::filesystem::exists(path)) {
        throw std::runtime_error(
            fmt::format("body '{}' is drawn from the superelement '{}', which is not there: put it back, or "
                        "run the simulation again "
                        "to name the new place ('{}' names it relative to its own folder)",
                        body.name, path.string(), results_file.string()));
      }
      superelement::Parts parts;
      parts.matrices = parts.inertia = false;
      parts.surface = parts.shapes = parts.stress = parts.sections = true;
      Superelement read = superelement::read(path, parts);
      // Factors of preloads are not kept beside the motion, so that the stresses would lack those.
      if (std::ranges::any_of(read.load_cases, &superelement::LoadCase::is_preload)) {
        read.stress.reset();
        read.sections.reset();
      }
      se = std::make_shared<const Superelement>(std::move(read));
    }
    pictures[body.name] = se;
  }
  return pictures;
}

void write_motion_page(const std::filesystem::path& html, const results::Results& results,
                       const Pictures& pictures, const MotionPage& page) {
  MotionWriter(html, results, pictures, page).write();
}

}  // namespace flexura::view
