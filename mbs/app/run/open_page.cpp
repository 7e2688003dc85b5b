// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/open_page.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/app/run/recorder.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

using mbs::Pose;
using mbs::Vector3d;
using nlohmann::json;

constexpr const char* kRed = "#d62728";
constexpr const char* kPink = "#ff9896";

json list(const Vector3d& x) {
  return {x.x(), x.y(), x.z()};
}

// Where markers are at a state.
class Places {
 public:
  Places(const mbs::Mechanism& mechanism, const mbs::State& s) : mechanism_(mechanism), s_(s) {
    const auto scratch = mechanism.make_scratch();
    mechanism.body_poses(s, *scratch, bodies);
    Vector3d low = Vector3d::Zero(), high = low;
    const auto take = [&](const Vector3d& p) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    };
    for (std::size_t i = 0; i < mechanism.description().markers.size(); ++i)
      take(marker(static_cast<int>(i)).p);
    size = std::max((high - low).norm(), 1e-6);
  }

  Pose marker(int i) const {
    const mbs::MarkerDescription& m = mechanism_.description().markers[i];
    const mbs::FlexibleBody* flexible = mechanism_.description().bodies[m.body].flexible.get();
    if (m.node < 0 || !flexible || !flexible->acts_back())
      return bodies[m.body] * mechanism_.description().undeformed(i);
    return bodies[m.body] * flexible->node_pose(m.node, mechanism_.modal_coordinates(m.body, s_)) * m.X_BP;
  }

  std::vector<Pose> bodies;
  double size = 1.0;

 private:
  const mbs::Mechanism& mechanism_;
  const mbs::State& s_;
};

// Both sides of an open joint, in W.
json shapes_of(const mbs::Opening& opening, const Places& places) {
  const Pose F = places.marker(opening.marker_F), M = places.marker(opening.marker_M);
  json shapes = json::array();
  const auto ball = [&](const Pose& X, const char* color) {
    shapes.push_back(
        {{"type", "sphere"}, {"radius", 0.012 * places.size}, {"position", list(X.p)}, {"color", color}});
    const Vector3d axis = 0.06 * places.size * X.R.col(2);
    shapes.push_back({{"type", "line"}, {"points", {list(X.p - axis), list(X.p + axis)}}, {"color", color}});
  };
  ball(F, kRed);
  ball(M, kPink);
  if ((M.p - F.p).norm() > 1e-9 * places.size)
    shapes.push_back({{"type", "line"}, {"points", {list(F.p), list(M.p)}}, {"color", kRed}});
  return shapes;
}

}  // namespace

void write_open_page(const std::filesystem::path& html, const mbs::NotAssembled& failure,
                     const std::filesystem::path& mechanism_file) {
  const mbs::PreparedMechanism& prepared = *failure.as_it_stands;
  const mbs::Mechanism& mechanism = *prepared.mechanism;
  results::Results page;
  page.model = model_header({&prepared}, mechanism_file, html);
  page.model.name += " (does not assemble)";
  const view::Pictures pictures = view::read_pictures(page.model, html);

  const Places places(mechanism, prepared.state);
  results::Run run;
  run.name = "as it stands";
  run.stopped_because = failure.what();
  run.time = Eigen::VectorXd::Constant(1, prepared.state.t);
  const auto add_body = [&](const std::string& name, const Pose& X) {
    results::BodyHistory history;
    history.name = name;
    history.pose.resize(1, 7);
    const Eigen::Quaterniond q(X.R);
    history.pose << X.p.transpose(), q.w(), q.x(), q.y(), q.z();
    run.bodies.push_back(std::move(history));
  };
  for (std::size_t b = 0; b < places.bodies.size(); ++b) {
    add_body(mechanism.description().bodies[b].name, places.bodies[b]);
    const int body = static_cast<int>(b);
    const mbs::FlexibleBody* deforms = mechanism.deforming(body);
    if (!deforms || !deforms->modal()) continue;
    run.bodies.back().basis = deforms->modal()->Y;
    run.bodies.back().modal =
        Eigen::Map<const Eigen::RowVectorXd>(mechanism.modal_coordinates(body, prepared.state), deforms->m());
  }
  std::vector<double> values;
  for (const mbs::Opening& opening : failure.openings) {
    if (opening.marker_F >= 0 && opening.marker_M >= 0) {
      results::BodyHeader header;
      header.name = "open: " + opening.name;
      header.kind = "rigid";
      header.shape_json = shapes_of(opening, places).dump();
      page.model.bodies.push_back(std::move(header));
      add_body("open: " + opening.name, Pose{});
    }
    const auto add = [&](double value, const char* what, const char* unit) {
      if (!(value > 0.0)) return;
      run.quantities.push_back({fmt::format("open.{}.{}", opening.name, what), unit, "what stays open"});
      values.push_back(value);
    };
    add(opening.length, "length", "m");
    add(opening.angle, "angle", "rad");
    add(opening.other, "value", "");
  }
  run.values = Eigen::Map<const Eigen::RowVectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  page.runs.push_back(std::move(run));
  view::write_motion_page(html, page, pictures);
}

}  // namespace flexura::app
