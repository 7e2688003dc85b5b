// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/judged_outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "mbs/base/documents/units.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/accuracy/scales.hpp"

namespace flexura::study {
namespace {

// Rows beyond so many are thinned out.
constexpr double kMostRows = 800.0;
// What nobody asked for by name has to be larger than this part of the largest of its unit to matter.
constexpr double kNothingUnasked = 1e-3;
// Below these parts of its family an output is zero or noise (see the header).
constexpr double kOfOwner = 1e-3, kOfForces = 1e-3, kOfRest = 1e-6;
// Of the tolerance: a coordinate that is zero is followed to a hundredth of what others move (absolute_factor).
constexpr double kOfTolerance = 0.1;
// An error of a run below this part of its output: the output is known, however small it is.
constexpr double kKnown = 0.01;
// Of a linear correction, beside a whole mechanism: round-off of its equations, which are as stiff as 1e7 to 1; and what
// the run's own noise, of which the correction takes a part, is beside its tolerance.
constexpr double kOfCorrection = 1e-9, kOfNoise = 1e-3;
// What terms of higher order leave of an output is known to its size: an output that is twice as large is more than that.
constexpr double kAboveRest = 2.0;
// Nothing at all: round-off of sums of what the mechanism's forces, lengths and speeds make.
constexpr double kRoundOff = 1e-12;

// "j2" of "j2.force_x"; measures have none.
std::string owner_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? std::string() : name.substr(0, dot);
}

bool is_motion(const input::Dimension& d) {
  return d == input::dim::length || d == input::dim::angle;
}
bool is_force(const input::Dimension& d) {
  return d == input::dim::force || d == input::dim::torque || d == input::dim::acceleration ||
         d == input::dim::angular_acceleration;
}

// A lever that a moment of this mechanism may have [m]: a pendulum whose only marker is its hinge has no length but this.
double lever_of(const mbs::Mechanism& mechanism, double length) {
  for (const mbs::BodyDescription& body : mechanism.description().bodies) {
    const mbs::RigidInertia I = body.flexible ? body.flexible->undeformed_inertia() : body.inertia;
    const double radius = I.mass > 0.0 ? std::sqrt(0.5 * I.inertia.trace() / I.mass) : 0.0;
    if (std::isfinite(radius)) length = std::max(length, radius);
  }
  return length;
}

// Sizes by what they are of.
class OfDimension {
 public:
  double& operator[](const input::Dimension& d) { return sizes_[d.exponent]; }
  double of(const input::Dimension& d) const {
    const auto found = sizes_.find(d.exponent);
    return found == sizes_.end() ? 0.0 : found->second;
  }

 private:
  std::map<std::array<int, 4>, double> sizes_;
};

std::vector<std::string> usual_outputs(const mbs::Mechanism& mechanism) {
  std::vector<std::string> out;
  const auto infos = mechanism.quantities();
  for (const int i : mechanism.usual_quantities()) out.push_back(infos[static_cast<std::size_t>(i)].name);
  return out;
}

// What the patterns name in the run; a pattern that names nothing there what it names in the full model
// (stress of a body that is rigid in the run).
std::vector<std::string> asked_outputs(const mbs::PreparedMechanism& run, const mbs::Mechanism& full) {
  std::set<std::string> in_run;
  for (const mbs::OutputInfo& info : run.mechanism->quantities()) in_run.insert(info.name);
  const auto infos = full.quantities();
  std::vector<std::string> out;
  for (const std::string& pattern : run.file.outputs) {
    std::vector<std::string> all, there;
    for (const int i : mbs::select_quantities(full, {pattern})) {
      all.push_back(infos[static_cast<std::size_t>(i)].name);
      if (in_run.contains(all.back())) there.push_back(all.back());
    }
    for (std::string& name : there.empty() ? all : there)
      if (std::ranges::find(out, name) == out.end()) out.push_back(std::move(name));
  }
  return out;
}

}  // namespace

std::vector<int> judged_outputs(const mbs::PreparedMechanism& run, const mbs::Mechanism& full,
                                std::vector<OutputEstimate>& sums) {
  const auto infos = full.quantities();
  const bool asked = !run.file.outputs.empty();
  std::vector<int> outputs;
  for (const std::string& name : asked ? asked_outputs(run, full) : usual_outputs(*run.mechanism)) {
    const auto found = std::ranges::find(infos, name, &mbs::OutputInfo::name);
    if (found == infos.end() || found->role == mbs::OutputRole::mode ||
        found->role == mbs::OutputRole::place_of_stress)
      continue;
    // Energies are stored for the balance; strain energy is not what a rigid body is judged by.
    if (!asked && found->role == mbs::OutputRole::energy) continue;
    outputs.push_back(static_cast<int>(found - infos.begin()));
    OutputEstimate output;
    output.name = name;
    output.dimension = found->dimension;
    sums.push_back(std::move(output));
  }
  return outputs;
}

void set_rests(const mbs::Mechanism& mechanism, const Eigen::VectorXd& rests,
               std::vector<OutputEstimate>& outputs) {
  const std::vector<mbs::JointPlace>& places = mechanism.joint_places();
  for (std::size_t j = 0; j < places.size(); ++j) {
    if (!places[j].in_tree()) continue;
    const std::string& name = mechanism.description().joints[j].name;
    const auto speeds = places[j].joint->speeds();
    for (OutputEstimate& o : outputs) {
      if (owner_of(o.name) != name) continue;
      for (std::size_t k = 0; k < speeds.size(); ++k) {
        const bool moves = speeds[k].dimension == input::dim::velocity;
        if (o.dimension == (moves ? input::dim::force : input::dim::torque))
          o.rest = std::max(o.rest, rests(places[j].i_v + static_cast<Eigen::Index>(k)));
      }
    }
  }
}

double tolerance_of_noise(const mbs::PreparedMechanism& run) {
  const double accuracy = run.file.solver.quantity("accuracy");
  return accuracy > 0.0 ? std::min(run.options.tolerance, 1e-3 * accuracy) : run.options.tolerance;
}

long rows_between(const mbs::PreparedMechanism& run) {
  const mbs::SolverOptions& o = run.options;
  return std::max(1L, static_cast<long>((o.end_time - o.start_time) / o.output_step / kMostRows));
}

double length_of(const mbs::PreparedMechanism& run) {
  return run.options.scales ? run.options.scales->length : 1.0;
}

Families::Families(const mbs::Mechanism& mechanism, double length)
    : mechanism_(mechanism),
      length_(length),
      lever_(lever_of(mechanism, length)),
      scratch_(mechanism.make_scratch()) {
  const auto infos = mechanism.quantities();
  for (std::size_t i = 0; i < infos.size(); ++i) {
    // Stresses cost as much as all the rest; numbers without a unit have no family.
    if (infos[i].dimension == input::dim::pressure || infos[i].dimension == input::dim::none ||
        infos[i].role == mbs::OutputRole::place_of_stress)
      continue;
    which_.push_back(static_cast<int>(i));
    const bool is_alone = infos[i].role == mbs::OutputRole::deformation;
    owner_.push_back(is_alone ? std::string() : owner_of(infos[i].name));
    if (is_alone) alone_.insert(infos[i].name);
    dimension_.push_back(infos[i].dimension);
  }
  y_.setZero(static_cast<Eigen::Index>(which_.size()));
  sum_ = squares_ = y_;
}

void Families::take(const mbs::State& s, const Eigen::VectorXd& v_dot) {
  mechanism_.evaluate(which_, s, v_dot, *scratch_, y_);
  sum_ += y_;
  squares_ += y_.cwiseAbs2();
  ++rows_;
}

void Families::judge(std::vector<OutputEstimate>& outputs, bool asked, double tolerance, Of of) const {
  OfDimension of_all, largest;
  std::map<std::string, OfDimension> of_owner;
  const double n = std::max(1.0, static_cast<double>(rows_));
  for (std::size_t i = 0; i < which_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double mean = is_motion(dimension_[i]) ? sum_(k) / n : 0.0;
    double size = std::sqrt(std::max(0.0, squares_(k) / n - mean * mean));
    // The difference of two squares is right to their round-off.
    if (size < 1e-7 * std::abs(mean)) size = 0.0;
    if (!std::isfinite(size)) continue;
    double& most = of_all[dimension_[i]];
    most = std::max(most, size);
    if (owner_[i].empty()) continue;
    double& most_of_owner = of_owner[owner_[i]][dimension_[i]];
    most_of_owner = std::max(most_of_owner, size);
  }
  for (const OutputEstimate& o : outputs) {
    double& most = largest[o.dimension];
    most = std::max(most, o.size_rms);
  }
  // What forces, lengths and speeds of the mechanism make of other dimensions.
  namespace dim = input::dim;
  const double length = length_, force = std::max(of_all[dim::force], of_all[dim::torque] / lever_),
               speed = std::max(of_all[dim::velocity], of_all[dim::angular_velocity] * length),
               acceleration = std::max(of_all[dim::acceleration], of_all[dim::angular_acceleration] * length);
  OfDimension natural;
  natural[dim::length] = length;
  natural[dim::angle] = 1.0;
  natural[dim::velocity] = speed;
  natural[dim::angular_velocity] = speed / length;
  natural[dim::acceleration] = acceleration;
  natural[dim::angular_acceleration] = acceleration / length;
  natural[dim::force] = force;
  natural[dim::torque] = force * length;  // and energies
  natural[dim::power] = force * speed;
  const bool corrected = of == Of::deformation;
  for (OutputEstimate& o : outputs) {
    o.scale = o.size_rms;
    if (const auto own = of_owner.find(owner_of(o.name)); own != of_owner.end() && !alone_.contains(o.name))
      if (const double size = own->second.of(o.dimension); o.scale < kOfOwner * size) o.scale = size;
    const bool is_known = !corrected && o.rms < kKnown * o.size_rms;
    const double correction = std::max(kOfCorrection, kOfNoise * tolerance),
                 run = is_force(o.dimension) ? kOfForces : std::max(kOfRest, kOfTolerance * tolerance),
                 noise = corrected  ? correction
                         : is_known ? kRoundOff
                                    : run;
    if (const double all = of_all.of(o.dimension); o.scale < noise * all) o.scale = all;
    // Where a whole family is zero (cranks at constant speed have no angular accelerations) it is noise of the state's
    // errors times what the others make of it: nothing of a force, an acceleration or a power is known to less.
    const bool follows = is_force(o.dimension) || o.dimension == dim::power;
    const double unknown = std::max(kRoundOff, !follows ? 0.0 : corrected ? kOfNoise * tolerance : tolerance);
    if (const double made = natural.of(o.dimension);
        o.scale < unknown * made || o.size_rms < kAboveRest * o.rest)
      o.scale = std::max(o.scale, made);
    o.counts = asked || o.size_rms > kNothingUnasked * largest[o.dimension];
  }
}

double OutputEstimate::relative_max() const {
  return size_max > 0.0 ? max / size_max : 0.0;
}
double OutputEstimate::relative_rms() const {
  return scale > 0.0 ? rms / scale : 0.0;
}

std::pair<double, int> worst_output(const Eigen::VectorXd& squares, double span,
                                    const std::vector<OutputEstimate>& outputs) {
  std::pair<double, int> worst{0.0, -1};
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const OutputEstimate& o = outputs[i];
    if (!o.counts || !(o.scale > 0.0)) continue;
    const double error = std::sqrt(squares(static_cast<Eigen::Index>(i)) / span) / o.scale;
    if (error > worst.first) worst = {error, static_cast<int>(i)};
  }
  return worst;
}

}  // namespace flexura::study
