// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/mode_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <span>

#include "mbs/app/run/recorder.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/solver/accuracy/scales.hpp"
#include "mbs/superelement/superelement.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

/// Where bodies, their interfaces and their surfaces stand, in W; of each body three points `arm` [m] away from its
/// origin as well, so that a turn about it is seen.
std::vector<Eigen::Vector3d> places(const mbs::Mechanism& m, const mbs::State& s, double arm,
                                    const view::Pictures& pictures) {
  std::vector<mbs::Pose> poses;
  m.body_poses(s, *m.make_scratch(), poses);
  std::vector<Eigen::Vector3d> out;
  for (std::size_t b = 0; b < poses.size(); ++b) {
    const auto place = [&](const Eigen::Vector3d& p_B) { out.push_back(poses[b].p + poses[b].R * p_B); };
    place(Eigen::Vector3d::Zero());
    for (int i = 0; i < 3; ++i) place(arm * Eigen::Vector3d::Unit(i));
    const mbs::FlexibleBody* const body = m.deforming(static_cast<int>(b));
    const double* const modal = m.modal_coordinates(static_cast<int>(b), s);
    for (std::size_t n = 0; body && modal && n < body->nodes().size(); ++n)
      place(body->node_pose(static_cast<int>(n), modal).p);
    const auto picture = pictures.find(m.description().bodies[b].name);
    if (picture == pictures.end() || !picture->second) continue;
    const auto& vertices = picture->second->surface.vertices;
    Eigen::VectorXf u = Eigen::VectorXf::Zero(3 * vertices.rows());
    const mbs::ModalData* const data = body && modal ? body->modal() : nullptr;
    if (data && data->Y.rows() == picture->second->shapes.cols())
      u = picture->second->shapes *
          (data->Y * Eigen::Map<const Eigen::VectorXd>(modal, data->Y.cols())).cast<float>();
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
      place(vertices.row(v).transpose() + u.segment<3>(3 * v).cast<double>());
  }
  return out;
}

/// How much of the shape shows, at most a tenth of the mechanism's size: from a small step, as turns are no lines.
double shown_amplitude(const mbs::PreparedMechanism& p, const Eigen::VectorXcd& shape,
                       const view::Pictures& pictures) {
  constexpr double kPart = 0.1, kSmall = 1e-3;
  const double length = p.options.scales ? p.options.scales->length : 1.0;
  const std::vector<Eigen::Vector3d> before = places(*p.mechanism, p.state, 0.5 * length, pictures);
  double most = 0.0;
  for (const std::complex<double> phase : {std::complex<double>(1.0, 0.0), std::complex<double>(0.0, 1.0)}) {
    mbs::State s = p.state;
    p.mechanism->retract(p.state.p, kSmall * (shape * phase).real(), s.p);
    const std::vector<Eigen::Vector3d> after = places(*p.mechanism, s, 0.5 * length, pictures);
    for (std::size_t i = 0; i < after.size(); ++i)
      most = std::max(most, (after[i] - before[i]).norm() / kSmall);
  }
  return most > 0.0 ? kPart * length / most : 0.0;
}

}  // namespace

std::string moves_most(const mbs::Mechanism& m, const Eigen::VectorXd& sizes) {
  Eigen::Index largest = 0;
  if (sizes.size() > 0) sizes.maxCoeff(&largest);
  return m.name_of_velocity(static_cast<int>(largest));
}

void write_mode_pictures(const std::filesystem::path& output, const NamedRun& run,
                         const std::string& mechanism, const std::vector<mbs::NaturalMode>& modes, int count,
                         double amplitude) {
  constexpr int kPhases = 24;
  const mbs::PreparedMechanism& p = run.prepared;
  const mbs::Mechanism& m = *p.mechanism;
  const results::ModelHeader header = model_header(std::span(&run, 1), mechanism, output);
  const view::Pictures pictures = view::read_pictures(header, output);
  results::Writer writer(output, header);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.sizes().n_v);
  // As in the table of `eigen`: decompositions leave some 1e-13 of the largest eigenvalue in every other.
  double round_off = 0.0;
  for (const mbs::NaturalMode& mode : modes)
    round_off = std::max(round_off, 1e-12 * std::abs(mode.eigenvalue));
  for (std::size_t k = 0; k < modes.size() && static_cast<int>(k) < count; ++k) {
    const mbs::NaturalMode& mode = modes[k];
    const bool is_undamped = std::abs(mode.eigenvalue.real()) < round_off && mode.eigenvalue.imag() != 0.0;
    Eigen::Index largest = 0;
    if (mode.shape.size() > 0) mode.shape.cwiseAbs().maxCoeff(&largest);
    const double size = std::isnan(amplitude) ? shown_amplitude(p, mode.shape, pictures)
                                              : amplitude * m.velocity_scale(static_cast<int>(largest));
    Recorder recorder(p, writer, {"energy.potential"}, false);
    recorder.begin(fmt::format("mode {}, {} Hz", k + 1, terminal::number(mode.frequency_hz, 4)));
    for (int i = 0; i <= kPhases; ++i) {
      const double phase = static_cast<double>(i) / kPhases;
      mbs::State s = p.state;
      s.t = p.state.t + phase;  // of one period, whatever it lasts
      const Eigen::VectorXd d = size * (mode.shape * std::polar(1.0, 2.0 * M_PI * phase)).real();
      m.retract(p.state.p, d, s.p);
      s.v = rest;
      recorder.append(s, rest, EnergyRow{});
    }
    writer.end_run(true, "",
                   nlohmann::json{{"mode",
                                   {{"frequency_hz", mode.frequency_hz},
                                    {"damping", is_undamped ? 0.0 : mode.damping},
                                    {"moves_most", moves_most(m, mode.shape.cwiseAbs())}}}}
                       .dump());
  }
  writer.close();
}

}  // namespace flexura::app
