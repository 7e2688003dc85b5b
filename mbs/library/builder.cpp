// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/library/builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/library/part_source.hpp"
#include "mbs/mechanism/description/body_faults.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs {

template <int alignment, bool malloc_is_aligned, bool debugs_containers>
bool is_compiled_as_the_library() {
  return true;
}
template bool
is_compiled_as_the_library<EIGEN_MAX_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED != 0, same_layout::kDebugs>();

namespace {

void require_finite(const std::string& what, double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument(fmt::format("{} is {}; give a finite number", what, value));
}

void require_pose(const std::string& of, const Pose& X) {
  if (const std::string fault = pose_fault(X); !fault.empty()) throw std::invalid_argument(of + ": " + fault);
}

}  // namespace

void MechanismBuilder::require_not_negative(const std::string& name, const char* what, double value) {
  if (!(value >= 0.0 && std::isfinite(value)))
    throw std::invalid_argument(
        fmt::format("element \"{}\": {} is {:g}; it must be finite and not negative", name, what, value));
}

MechanismBuilder::Marker MechanismBuilder::Body::marker(const Pose& X_BP) const {
  MechanismDescription& d = builder_->d_;
  require_pose("a marker of body \"" + d.bodies[index_].name + "\"", X_BP);
  return {d.add_marker(index_, fmt::format("marker_{}", d.markers.size() + 1), X_BP), builder_};
}

MechanismBuilder::Marker MechanismBuilder::Body::marker(std::initializer_list<double> p_BoP_B) const {
  if (p_BoP_B.size() != 3)
    throw std::invalid_argument(fmt::format("a marker of body \"{}\" has {} numbers; give x, y and z",
                                            builder_->d_.bodies[index_].name, p_BoP_B.size()));
  return marker(Pose{Matrix3d::Identity(), Vector3d(p_BoP_B.begin())});
}

MechanismBuilder::Marker MechanismBuilder::Body::marker_at(const std::string& interface,
                                                           const Pose& X_NP) const {
  MechanismDescription& d = builder_->d_;
  const BodyDescription& body = d.bodies[index_];
  int node = body.flexible ? body.flexible->find_node(interface) : -1;
  if (const auto open = builder_->open_.find(index_); open != builder_->open_.end()) {
    const auto& all = open->second.interfaces;
    const auto found = std::ranges::find(all, interface, &std::pair<std::string, Vector3d>::first);
    if (found != all.end()) node = static_cast<int>(found - all.begin());
  }
  if (node < 0)
    throw std::invalid_argument(fmt::format(
        "body \"{}\" has no interface \"{}\"; name one of its superelement's", body.name, interface));
  require_pose(fmt::format("a marker on interface \"{}\" of body \"{}\"", interface, body.name), X_NP);
  return {d.add_marker(index_, fmt::format("{}_{}", interface, d.markers.size() + 1), X_NP, node), builder_};
}

MechanismBuilder::JointHandle& MechanismBuilder::JointHandle::start(double q, int i) {
  JointDescription& joint = builder_->d_.joints[index_];
  if (i < 0 || i >= joint.joint->n_p())
    throw std::invalid_argument(fmt::format("joint \"{}\" has {} coordinates, there is none of index {}",
                                            joint.name, joint.joint->n_p(), i));
  if (joint.drives.contains(i))
    throw std::invalid_argument(
        fmt::format("coordinate {} of joint \"{}\" is driven; leave its start out", i, joint.name));
  require_finite(fmt::format("the start of coordinate {} of joint \"{}\"", i, joint.name), q);
  joint.initial_coordinates[i] = q;
  return *this;
}

MechanismBuilder::JointHandle& MechanismBuilder::JointHandle::speed(double v, int i) {
  JointDescription& joint = builder_->d_.joints[index_];
  if (i < 0 || i >= joint.joint->n_v())
    throw std::invalid_argument(fmt::format("joint \"{}\" has {} speeds, there is none of index {}",
                                            joint.name, joint.joint->n_v(), i));
  if (joint.drives.contains(i))
    throw std::invalid_argument(
        fmt::format("coordinate {} of joint \"{}\" is driven; leave its speed out", i, joint.name));
  require_finite(fmt::format("the speed {} of joint \"{}\"", i, joint.name), v);
  joint.initial_speeds[i] = v;
  return *this;
}

MechanismBuilder::JointHandle& MechanismBuilder::JointHandle::drive(const std::string& formula, int i) {
  JointDescription& joint = builder_->d_.joints[index_];
  if (joint.joint->n_p() != joint.joint->n_v() || i < 0 || i >= joint.joint->n_p())
    throw std::invalid_argument(fmt::format(
        "coordinate {} of joint \"{}\" cannot be driven; drive a joint whose coordinates are its freedoms", i,
        joint.name));
  if (joint.drives.contains(i) || joint.initial_coordinates.contains(i) || joint.initial_speeds.contains(i))
    throw std::invalid_argument(fmt::format(
        "coordinate {} of joint \"{}\" has a drive or a start already; keep one of them", i, joint.name));
  joint.drives[i] = builder_->motion(formula);
  return *this;
}

void MechanismBuilder::gravity(const Vector3d& g_W) {
  for (const double g : g_W) require_finite("gravity", g);
  d_.gravity = g_W;
}

void MechanismBuilder::parameter(const std::string& name, double value) {
  require_finite("parameter \"" + name + "\"", value);
  if (name == "t" || name == "pi" || d_.signals.find(name) >= 0)
    throw std::invalid_argument(
        fmt::format("\"{}\" means something in formulas already; choose another name", name));
  parameters_[name] = value;
}

void MechanismBuilder::input(const std::string& name, const std::string& text) {
  require_new(name, "input");
  d_.inputs.push_back(
      {name, std::make_shared<Expression>("input " + name, text, SignalNames(), parameters_)});
  take_signal(name);
}

MechanismBuilder::Body MechanismBuilder::add(const std::string& name, const RigidBody& body,
                                             std::optional<Pose> X_WB) {
  if (const auto fault = body_fault(body.mass, body.center, body.inertia))
    throw std::invalid_argument(
        fmt::format("body \"{}\": {} {}; {}", name, fault->key, fault->rule, fault->remedy));
  return add_body({.name = name,
                   .inertia = RigidInertia::from_center(body.mass, body.center, body.inertia),
                   .X_WB = std::move(X_WB)});
}

MechanismBuilder::Body MechanismBuilder::add(const std::string& name, const ModalBody& body,
                                             std::optional<Pose> X_WB) {
  return add(name, std::make_shared<const ModalBody>(body), std::move(X_WB));
}

MechanismBuilder::Body MechanismBuilder::add(const std::string& name,
                                             std::shared_ptr<const FlexibleBody> body,
                                             std::optional<Pose> X_WB) {
  if (!body)
    throw std::invalid_argument(fmt::format("body \"{}\" is nothing; make it before it is added", name));
  return add_body({.name = name, .flexible = std::move(body), .X_WB = std::move(X_WB)});
}

MechanismBuilder::Body MechanismBuilder::add(const std::string& name, const Part& part,
                                             std::optional<Pose> X_WB) {
  const auto se = superelement::read(part.superelement, {.matrices = false});
  Open open{std::filesystem::absolute(part.superelement), {}, part.model, {}};
  for (const superelement::Interface& i : se.interfaces) open.interfaces.emplace_back(i.name, i.p_BoN_B);
  return add_open(name, std::move(open), std::move(X_WB));
}

MechanismBuilder::Body MechanismBuilder::add(const std::string& name, const Beam& beam,
                                             std::optional<Pose> X_WB) {
  beam.shape.R_BE();
  return add_open(name, {{}, beam.shape, beam.model, beam.shape.stations()}, std::move(X_WB));
}

MechanismBuilder::Body MechanismBuilder::add_open(const std::string& name, Open open,
                                                  std::optional<Pose> X_WB) {
  Body body = add_body({.name = name, .X_WB = std::move(X_WB), .superelement = open.superelement.string()});
  open_.emplace(body.index(), std::move(open));
  return body;
}

Mechanism MechanismBuilder::build() const {
  if (open_.empty()) return Mechanism(d_);
  PreparationCache cache;
  return Mechanism(PartSource(*this).read({}, cache).description);
}

MechanismBuilder::Body MechanismBuilder::add_body(BodyDescription body) {
  require_new(body.name, "body");
  if (body.X_WB) require_pose("body \"" + body.name + "\"", *body.X_WB);
  return {*this, d_.add_body(std::move(body))};
}

std::shared_ptr<const Expression> MechanismBuilder::formula(const std::string& text) {
  auto f = std::make_shared<Expression>("formula \"" + text + "\"", text, d_.signals, parameters_, Curves{},
                                        &d_.signals);
  d_.formulas.push_back({f, false});
  return f;
}

std::shared_ptr<const Expression> MechanismBuilder::motion(const std::string& text) {
  if (auto f = std::make_shared<Expression>("formula \"" + text + "\"", text, d_.signals, parameters_,
                                            Curves{}, &d_.signals);
      !f->reads().empty()) {
    d_.formulas.push_back({f, true});
    return f;
  }
  auto f = std::make_shared<Expression>("formula \"" + text + "\"", text, SignalNames(), parameters_);
  d_.formulas.push_back({f, true});
  return f;
}

MechanismBuilder::JointHandle MechanismBuilder::add_joint(const std::string& name,
                                                          std::shared_ptr<const Joint> joint, Marker F,
                                                          Marker M) {
  require_new(name, "joint");
  for (const CoordinateInfo& c : joint->coordinates()) d_.signals.add(name + "." + c.name);
  for (const CoordinateInfo& c : joint->speeds()) d_.signals.add(name + "." + c.name);
  JointDescription description;
  description.name = name;
  description.joint = std::move(joint);
  description.marker_F = plain(F);
  description.marker_M = plain(M);
  d_.joints.push_back(std::move(description));
  return {*this, static_cast<int>(d_.joints.size()) - 1};
}

void MechanismBuilder::add_element(std::shared_ptr<const Constraint> element) {
  require_new(element->name(), "constraint");
  d_.constraints.push_back(std::move(element));
}

void MechanismBuilder::add_element(std::shared_ptr<const ForceElement> element) {
  require_new(element->name(), "force");
  if (const auto [body, load] = element->load_case(); body >= 0) d_.bodies[body].is_loaded_by_case = true;
  d_.forces.push_back(std::move(element));
}

void MechanismBuilder::add_element(std::shared_ptr<const Measure> element) {
  require_new(element->name(), "measure");
  take_signal(element->name());
  d_.measures.push_back(std::move(element));
}

void MechanismBuilder::add_element(std::shared_ptr<const Control> element) {
  require_new(element->name(), "control");
  take_signal(element->name());
  d_.controls.push_back(std::move(element));
}

int MechanismBuilder::plain(Marker m) const {
  if (m.index < 0 || m.index >= static_cast<int>(d_.markers.size()) || (m.of && m.of != this))
    throw std::invalid_argument(
        fmt::format("the marker {} is none of mechanism \"{}\"; make markers by the bodies of the builder "
                    "that they are for",
                    m.index, d_.name));
  return m.index;
}

int MechanismBuilder::plain(const Body& b) const {
  if (b.builder_ != this)
    throw std::invalid_argument(
        fmt::format("a body is none of mechanism \"{}\"; add it to the builder that it is for", d_.name));
  return b.index_;
}

CoordinateRef MechanismBuilder::plain(CoordinateRef c) const {
  if (c.joint < 0 || c.joint >= static_cast<int>(d_.joints.size()) || c.index < 0 ||
      c.index >= d_.joints[static_cast<std::size_t>(c.joint)].joint->n_v())
    throw std::invalid_argument(
        fmt::format("the coordinate {} of joint {} is none of mechanism \"{}\"; take it of a joint of the "
                    "builder that it is for",
                    c.index, c.joint, d_.name));
  return c;
}

void MechanismBuilder::take_signal(const std::string& name) {
  if (name == "t" || name == "pi" || parameters_.contains(name) || d_.signals.find(name) >= 0)
    throw std::invalid_argument(
        fmt::format("\"{}\" means something in formulas already; choose another name", name));
  d_.signals.add(name);
}

void MechanismBuilder::require_new(const std::string& name, const char* what) {
  if (name.empty()) throw std::invalid_argument(fmt::format("a {} needs a name", what));
  if (const auto [known, is_new] = names_.emplace(name, what); !is_new)
    throw std::invalid_argument(fmt::format("a {} is called \"{}\" already; choose another name for this {}",
                                            known->second, name, what));
}

}  // namespace flexura::mbs
