// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "tests/mbs/random/simbody/simbody_system.hpp"

/// Bodies, the tree of joints, and what is read of them.
namespace flexura::mbs::chance {

namespace sim = SimTK;

sim::Vec3 to_simbody(const Vector3d& x) {
  return {x.x(), x.y(), x.z()};
}

sim::Transform to_simbody(const Pose& X) {
  sim::Mat33 R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R(i, j) = X.R(i, j);
  return {sim::Rotation(R, true), to_simbody(X.p)};
}

namespace {

Vector3d to_eigen(const sim::Vec3& x) {
  return {x[0], x[1], x[2]};
}
Pose to_eigen(const sim::Transform& X) {
  Pose out{Matrix3d::Identity(), to_eigen(X.p())};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.R(i, j) = X.R().asMat33()(i, j);
  return out;
}
Spatial to_eigen(const sim::SpatialVec& V) {
  return {to_eigen(V[0]), to_eigen(V[1])};
}

enum class Mobilizer {
  pin,
  slide_x,
  slide_y,
  slide_z,
  cylinder,
  screw,
  planar,
  translation,
  ball,
  universal,
  weld,
  free
};

// From F to M.  Joints of several are ways first, then turns.
const std::vector<Mobilizer>& mobilizers_of(const std::string& type) {
  using M = Mobilizer;
  static const std::map<std::string, std::vector<Mobilizer>> table = {
      {"revolute", {M::pin}},
      {"prismatic", {M::slide_z}},
      {"cylindrical", {M::cylinder}},
      {"screw", {M::screw}},
      {"planar", {M::planar}},
      {"spherical", {M::ball}},
      {"universal", {M::universal}},
      {"fixed", {M::weld}},
      {"free", {M::free}},
      {"orientation", {M::translation}},
      {"parallel", {M::translation, M::pin}},
      {"point_on_line", {M::slide_z, M::ball}},
      {"point_on_plane", {M::slide_x, M::slide_y, M::ball}}};
  static const std::vector<Mobilizer> none;
  const auto found = table.find(type);
  return found == table.end() ? none : found->second;
}

// Simbody's slider goes along x.
sim::Rotation axes_of(Mobilizer what) {
  const sim::Real quarter = 0.5 * sim::Pi;
  if (what == Mobilizer::slide_y) return sim::Rotation(quarter, sim::ZAxis);
  if (what == Mobilizer::slide_z) return sim::Rotation(-quarter, sim::YAxis);
  return {};
}

struct Ends {
  sim::MobilizedBody& parent;
  sim::Transform X_PF;
  sim::Body child;
  sim::Transform X_BM;
  sim::MobilizedBody::Direction direction;
};

sim::MobilizedBody mobilize(Mobilizer what, const Ends& e, double pitch) {
  using B = sim::MobilizedBody;
  switch (what) {
    case Mobilizer::pin:
      return B::Pin(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::slide_x:
    case Mobilizer::slide_y:
    case Mobilizer::slide_z:
      return B::Slider(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::cylinder:
      return B::Cylinder(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::screw:
      return B::Screw(e.parent, e.X_PF, e.child, e.X_BM, pitch / (2.0 * sim::Pi), e.direction);
    case Mobilizer::planar:
      return B::Planar(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::translation:
      return B::Translation(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::ball:
      return B::Ball(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::universal:
      return B::Universal(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
    case Mobilizer::weld:
      return B::Weld(e.parent, e.X_PF, e.child, e.X_BM);
    case Mobilizer::free:
      return B::Free(e.parent, e.X_PF, e.child, e.X_BM, e.direction);
  }
  throw std::logic_error("a mobilizer without a case");
}

template <class List, class Is>
bool any_of(const List& list, Is is) {
  return std::any_of(list.begin(), list.end(), is);
}

bool acts_on(const Scene& scene, int joint) {
  return !scene.joints[joint].drives.empty() ||
         any_of(scene.forces, [&](const SceneForce& f) { return f.is_along_joint() && f.joint == joint; }) ||
         any_of(scene.constraints, [&](const SceneConstraint& c) {
           return any_of(c.terms, [&](const auto& term) { return term.joint == joint; });
         });
}

// Joints of a spanning tree: first those whose coordinates are asked for, last those that were made to close a loop.
std::vector<bool> tree_of(const Scene& scene) {
  std::vector<int> group(scene.bodies.size());
  std::iota(group.begin(), group.end(), 0);
  std::vector<bool> in_tree(scene.joints.size(), false);
  for (int pass = 0; pass < 3; ++pass)
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const SceneJoint& joint = scene.joints[j];
      const int wanted = acts_on(scene, static_cast<int>(j)) ? 0 : joint.closes ? 2 : 1;
      const int A = group[scene.markers[joint.F].body], B = group[scene.markers[joint.M].body];
      if (wanted != pass || A == B) continue;
      in_tree[j] = true;
      std::replace(group.begin(), group.end(), B, A);
    }
  return in_tree;
}

}  // namespace

std::string SimbodySystem::lacks(const Scene& scene) {
  if (scene.is_flexible()) return "flexible bodies";
  const std::vector<bool> in_tree = tree_of(scene);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const SceneJoint& joint = scene.joints[j];
    if (mobilizers_of(joint.type).empty()) return "joint " + joint.type;
    if (!in_tree[j] && joint.type == "screw") return "screw that closes a loop";
    if (!in_tree[j] && acts_on(scene, static_cast<int>(j))) return "coordinate of a joint that closes a loop";
  }
  for (const SceneConstraint& c : scene.constraints)
    if (c.type == "rolling_disc" || c.type == "point_on_curve") return "constraint " + c.type;
  for (const SceneForce& f : scene.forces)
    if (f.type == "contact") return "force " + f.type;
  return "";
}

SimbodySystem::SimbodySystem(const Scene& scene)
    : scene_(scene), matter_(system_), forces_(system_), bodies_(scene.bodies.size()) {
  if (const std::string what = lacks(scene); !what.empty())
    throw std::invalid_argument("Simbody lacks: " + what);
  grow_tree();
  add_constraints();
  add_forces();
  state_ = system_.realizeTopology();
  system_.realizeModel(state_);
}

sim::Body SimbodySystem::body_of(int b) const {
  const SceneBody& body = scene_.bodies[b];
  const Matrix3d& I = body.inertia;
  const sim::Vec3 center = to_simbody(body.center);
  const sim::Inertia about_center(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return sim::Body::Rigid(
      sim::MassProperties(body.mass, center, about_center.shiftFromMassCenter(center, body.mass)));
}

void SimbodySystem::grow_tree() {
  const std::vector<bool> in_tree = tree_of(scene_);
  std::vector<bool> stands(bodies_.size(), false), grown(scene_.joints.size(), false);
  bodies_[0] = matter_.updGround();
  stands[0] = true;
  for (std::size_t root = 0; root < bodies_.size(); ++root) {
    if (root > 0 && stands[root]) continue;
    if (root > 0) {
      Branch free;
      free.B = static_cast<int>(root);
      add_branch(free);
    }
    stands[root] = true;
    for (bool is_growing = true; is_growing;) {
      is_growing = false;
      for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
        const SceneJoint& joint = scene_.joints[j];
        const int A = scene_.markers[joint.F].body, B = scene_.markers[joint.M].body;
        if (!in_tree[j] || grown[j] || stands[A] == stands[B]) continue;
        add_branch({static_cast<int>(j), A, B, on_body(joint.F), on_body(joint.M), !stands[A], {}});
        stands[A] = stands[B] = grown[j] = is_growing = true;
      }
    }
  }
}

void SimbodySystem::add_branch(Branch branch) {
  const std::vector<Mobilizer>& mobilizers =
      mobilizers_of(branch.joint < 0 ? "free" : scene_.joints[branch.joint].type);
  const double pitch = branch.joint < 0 ? 0.0 : scene_.joints[branch.joint].pitch;
  const int n = static_cast<int>(mobilizers.size()), last = branch.is_reversed ? 0 : n - 1;
  const int child = branch.is_reversed ? branch.A : branch.B;
  sim::MobilizedBody parent = bodies_[branch.is_reversed ? branch.B : branch.A];
  sim::Transform X_PF = branch.is_reversed ? branch.X_BM : branch.X_AF;
  branch.steps.resize(n);
  for (int k = branch.is_reversed ? n - 1 : 0;; k += branch.is_reversed ? -1 : 1) {
    const Mobilizer what = mobilizers[k];
    const sim::Rotation axes = axes_of(what);
    const sim::Transform on_child = k != last            ? sim::Transform()
                                    : branch.is_reversed ? branch.X_AF
                                                         : branch.X_BM;
    const Ends ends{parent, X_PF * sim::Transform(axes),
                    k == last ? body_of(child) : sim::Body(sim::Body::Massless()),
                    on_child * sim::Transform(axes),
                    branch.is_reversed ? sim::MobilizedBody::Reverse : sim::MobilizedBody::Forward};
    branch.steps[k] = {mobilize(what, ends, pitch), axes, n == 1 || k == n - 1, n == 1 || k < n - 1};
    if (k == last) break;
    parent = branch.steps[k].body;
    X_PF = sim::Transform();
  }
  bodies_[child] = branch.steps[last].body;
  branches_.push_back(std::move(branch));
}

const SimbodySystem::Branch* SimbodySystem::branch_of(int joint) const {
  for (const Branch& branch : branches_)
    if (branch.joint == joint) return &branch;
  return nullptr;
}

SimbodySystem::Coordinate SimbodySystem::coordinate(int joint, int i) const {
  const Branch& branch = *branch_of(joint);
  const std::string& type = scene_.joints[joint].type;
  int step = 0, q = i;
  if (type == "planar") q = (i + 1) % 3;  // x, y, angle here; the angle first there
  if (type == "parallel") step = i == 0 ? 1 : 0, q = i == 0 ? 0 : i - 1;
  if (type == "point_on_plane") step = i, q = 0;
  return {branch.steps[step].body.getMobilizedBodyIndex(), sim::MobilizerQIndex(q)};
}

void SimbodySystem::place(double t, const std::vector<BodyMotion>& motion) {
  struct Relative {
    sim::Transform X;
    sim::SpatialVec V;
  };
  // Of M in F.
  const auto relative = [&](const Branch& branch) -> Relative {
    const BodyMotion &A = motion[branch.A], &B = motion[branch.B];
    const sim::Transform X_GA = to_simbody(A.place.X_WB), X_GB = to_simbody(B.place.X_WB);
    const sim::Transform X_GF = X_GA * branch.X_AF, X_GM = X_GB * branch.X_BM;
    const sim::Vec3 w_A = to_simbody(A.V.angular), w_B = to_simbody(B.V.angular);
    const sim::Vec3 v_M = to_simbody(B.V.linear) + w_B % (X_GM.p() - X_GB.p()),
                    v_A = to_simbody(A.V.linear) + w_A % (X_GM.p() - X_GA.p());
    return {~X_GF * X_GM, {~X_GF.R() * (w_B - w_A), ~X_GF.R() * (v_M - v_A)}};
  };
  // What a step takes of it, in its own axes, from parent to child.
  const auto part = [](const Branch& branch, const Step& step, const Relative& all) -> Relative {
    Relative out;
    const sim::Rotation R = step.turns ? all.X.R() : sim::Rotation();
    out.X = {~step.axes * R * step.axes, step.slides ? ~step.axes * all.X.p() : sim::Vec3(0)};
    out.V = {step.turns ? ~step.axes * all.V[0] : sim::Vec3(0),
             step.slides ? ~step.axes * all.V[1] : sim::Vec3(0)};
    if (!branch.is_reversed) return out;
    return {~out.X, sim::reverseRelativeVelocity(out.X, out.V)};
  };
  if (t <= state_.getTime()) angles_.clear();
  state_.setTime(t);
  for (const Branch& branch : branches_)
    for (const Step& step : branch.steps)
      step.body.setQToFitTransform(state_, part(branch, step, relative(branch)).X);
  count_turns();
  system_.realize(state_, sim::Stage::Position);
  for (const Branch& branch : branches_)
    for (const Step& step : branch.steps)
      step.body.setUToFitVelocity(state_, part(branch, step, relative(branch)).V);
  choose_rows();
}

// From the last place on; a pose knows no whole turns.
void SimbodySystem::count_turns() {
  for (const Branch& branch : branches_) {
    if (branch.joint < 0) continue;
    const std::string& type = scene_.joints[branch.joint].type;
    const auto& names = coordinates_of(type);
    for (int i = 0; i < static_cast<int>(names.size()); ++i) {
      if (!names[i].is_angle() || type == "screw") continue;  // a screw's turns move it
      const Coordinate at = coordinate(branch.joint, i);
      const sim::MobilizedBody& body = matter_.getMobilizedBody(at.body);
      double q = body.getOneQ(state_, at.q);
      if (const auto before = angles_.find({branch.joint, i}); before != angles_.end())
        q += 2.0 * sim::Pi * std::rint((before->second - q) / (2.0 * sim::Pi));
      angles_[{branch.joint, i}] = q;
      body.setOneQ(state_, at.q, q);
    }
  }
}

std::vector<BodyMotion> SimbodySystem::motion() const {
  system_.realize(state_, sim::Stage::Acceleration);
  std::vector<BodyMotion> out(bodies_.size());
  for (std::size_t b = 1; b < bodies_.size(); ++b) {
    out[b].place.X_WB = to_eigen(bodies_[b].getBodyTransform(state_));
    out[b].V = to_eigen(bodies_[b].getBodyVelocity(state_));
    out[b].A = to_eigen(bodies_[b].getBodyAcceleration(state_));
  }
  return out;
}

long SimbodySystem::run(double t, double accuracy, double disturbance) {
  constexpr int kSteps = 20000;
  for (int i = 0; i < state_.getNU(); ++i) state_.updU()[i] += i % 2 == 0 ? disturbance : -disturbance;
  sim::RungeKuttaMersonIntegrator integrator(system_);
  integrator.setAccuracy(accuracy);
  integrator.setConstraintTolerance(0.1 * accuracy);
  integrator.setInternalStepLimit(kSteps);
  integrator.setFinalTime(t);
  integrator.initialize(state_);
  while (integrator.getTime() < t)
    if (integrator.stepTo(t) == sim::Integrator::ReachedStepLimit)
      throw std::runtime_error("Simbody is not done after " + std::to_string(kSteps) + " steps");
  state_ = integrator.getState();
  return integrator.getNumStepsTaken();
}

SimbodyScene::SimbodyScene(const Scene& scene) : system_(std::make_unique<SimbodySystem>(scene)) {}
SimbodyScene::~SimbodyScene() = default;
std::string SimbodyScene::lacks(const Scene& scene) {
  return SimbodySystem::lacks(scene);
}
void SimbodyScene::place(double t, const std::vector<BodyMotion>& motion) {
  system_->place(t, motion);
}
long SimbodyScene::run(double t, double accuracy, double disturbance) {
  return system_->run(t, accuracy, disturbance);
}
std::vector<BodyMotion> SimbodyScene::motion() const {
  return system_->motion();
}
SimbodyScene::Rows SimbodyScene::rows() const {
  return system_->rows();
}

}  // namespace flexura::mbs::chance
