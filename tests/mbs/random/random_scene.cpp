// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/random_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/random/scene_physics.hpp"

namespace flexura::mbs::chance {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

Matrix3d about_z(double angle) { return rotation_exp({0.0, 0.0, angle}); }

class Maker {
 public:
  explicit Maker(std::uint64_t seed) : chance_(seed), more_chance_(~seed), has_more_(seed % 3 == 0) { s_.bodies.resize(1); }

  Scene make() {
    s_.gravity = chance_.flip(0.3) ? Vector3d::Zero() : Vector3d(9.81 * chance_.direction());
    if (chance_.flip(0.5)) s_.gravity = {0.0, 0.0, s_.gravity.isZero() ? 0.0 : -9.81};
    switch (chance_.below(6)) {
      case 0:
        tree();
        break;
      case 1:
        spatial_loops();
        break;
      case 2:
      case 3:
        planar();
        break;
      case 4:
        door();
        break;
      default:
        gears();
        break;
    }
    decorate();
    // From numbers of their own: the other mechanisms stay what they were.
    if (has_more_) {
      if (more_chance_.flip(0.2)) add_wheel();
      if (more_chance_.flip(0.3)) add_curve();
      decorate_more();
    }
    choose_start();
    if (s_.digits < 17) round_markers();
    if (s_.start == Start::guess) {
      s_.guess = s_.poses();
      for (std::size_t b = 1; b < s_.guess.size(); ++b) {
        s_.guess[b].R = rotation_exp(chance_.vector(0.03)) * s_.guess[b].R;
        s_.guess[b].p += chance_.vector(0.005);
      }
    }
    s_.end_time = chance_.between(0.15, 0.4);
    s_.output_step = s_.end_time / 20.0;
    return std::move(s_);
  }

 private:
  // ---- parts
  int body(const Pose& X_WB) {
    SceneBody b;
    b.mass = std::exp(chance_.between(std::log(0.3), std::log(5.0)));
    b.center = chance_.flip(0.5) ? Vector3d::Zero() : chance_.vector(0.15);
    const Vector3d box = {chance_.between(0.05, 0.5), chance_.between(0.05, 0.5), chance_.between(0.05, 0.5)};
    const Vector3d square = box.cwiseProduct(box);
    const Matrix3d R = chance_.flip(0.5) ? Matrix3d(Matrix3d::Identity()) : chance_.rotation();
    b.inertia = R * Vector3d(square.y() + square.z(), square.z() + square.x(), square.x() + square.y()).asDiagonal() *
                R.transpose() * (b.mass / 12.0);
    b.inertia = 0.5 * (b.inertia + b.inertia.transpose()).eval();
    b.X_WB = X_WB;
    s_.bodies.push_back(b);
    return static_cast<int>(s_.bodies.size()) - 1;
  }
  Pose pose(double size) { return {chance_.rotation(), chance_.vector(size)}; }
  /// A marker of `body` where X_W stands in the world.
  int marker_at(int b, const Pose& X_W) { return s_.add_marker(b, s_.bodies[b].X_WB.inverse() * X_W); }

  Pose joint_pose(const SceneJoint& joint) {
    const double turn = chance_.between(-1.2, 1.2), way = chance_.between(-0.2, 0.2);
    const std::string& type = joint.type;
    if (type == "revolute") return {about_z(turn), Vector3d::Zero()};
    if (type == "prismatic") return {Matrix3d::Identity(), {0, 0, way}};
    if (type == "cylindrical") return {about_z(turn), {0, 0, way}};
    if (type == "screw") return {about_z(turn), {0, 0, joint.pitch * turn / kTurn}};
    if (type == "planar") return {about_z(turn), {way, chance_.between(-0.2, 0.2), 0}};
    if (type == "spherical") return {chance_.rotation(), Vector3d::Zero()};
    if (type == "universal")
      return {rotation_exp({turn, 0, 0}) * rotation_exp({0, chance_.between(-1.0, 1.0), 0}), Vector3d::Zero()};
    if (type == "constant_velocity") return {rotation_exp({turn, chance_.between(-1.0, 1.0), 0}), Vector3d::Zero()};
    if (type == "fixed") return {};
    if (type == "orientation") return {Matrix3d::Identity(), chance_.vector(0.2)};
    if (type == "parallel") return {about_z(turn), chance_.vector(0.2)};
    if (type == "point_on_line") return {chance_.rotation(), {0, 0, way}};
    if (type == "point_on_plane") return {chance_.rotation(), {way, chance_.between(-0.2, 0.2), 0}};
    return {chance_.rotation(), chance_.vector(0.3)};  // free
  }

  /// Joins two bodies that stand where they are.
  int join(const std::string& type, int from, const Pose& X_WF, int to, const Pose& X_WM, double pitch = 0.0) {
    SceneJoint joint;
    joint.type = type;
    joint.pitch = pitch;
    joint.F = marker_at(from, X_WF);
    joint.M = marker_at(to, X_WM);
    s_.joints.push_back(joint);
    return static_cast<int>(s_.joints.size()) - 1;
  }

  /// A new body on a joint of this type at a random place of `parent`.
  int grow(const std::string& type, int parent) {
    SceneJoint joint;
    joint.type = type;
    joint.pitch = type == "screw" ? chance_.between(0.02, 0.3) * (chance_.flip(0.5) ? 1 : -1) : 0.0;
    const Pose X_FM = joint_pose(joint);
    const bool reversed = chance_.flip(0.2);
    const Pose X_W1 = s_.bodies[parent].X_WB * pose(0.3), X_B2 = pose(0.3);
    const int child = body(X_W1 * (reversed ? X_FM.inverse() : X_FM) * X_B2.inverse());
    joint.F = reversed ? s_.add_marker(child, X_B2) : marker_at(parent, X_W1);
    joint.M = reversed ? marker_at(parent, X_W1) : s_.add_marker(child, X_B2);
    s_.joints.push_back(joint);
    return child;
  }

  void grow_tree(int n, bool is_grounded) {
    static const char* const types[] = {"revolute", "revolute",    "prismatic", "cylindrical",   "screw",
                                        "planar",   "spherical",   "universal", "constant_velocity", "fixed",
                                        "free",     "orientation", "parallel",  "point_on_line", "point_on_plane"};
    const int first = static_cast<int>(s_.bodies.size());
    for (int i = 0; i < n; ++i) {
      const int last = static_cast<int>(s_.bodies.size()) - 1;
      if (i == 0 && !is_grounded) {
        const int b = body(pose(0.5));
        s_.bodies[b].velocity = chance_.vector(1.0);
        s_.bodies[b].angular_velocity = chance_.vector(2.0);
        if (chance_.flip(0.5)) join("free", 0, pose(1.0), b, pose(0.2));
        continue;
      }
      const int parent = i == 0 ? 0 : chance_.flip(0.7) ? last : first + chance_.below(last - first + 1);
      grow(chance_.one_of(types), parent);
    }
  }

  void give_speeds(double probability) {
    for (SceneJoint& joint : s_.joints) {
      const auto& coordinates = coordinates_of(joint.type);
      if (joint.closes || joint.is_connection) continue;
      for (int i = 0; i < static_cast<int>(coordinates.size()); ++i)
        if (chance_.flip(probability))
          joint.speeds.emplace_back(i, chance_.between(-1.0, 1.0) * (coordinates[i].is_angle() ? 4.0 : 0.7));
    }
  }

  // The program's tree takes driven and coupled joints first; the others that close a loop here are cut, so that
  // initial values stand on joints of the tree.
  void choose_start() {
    bool has_free_root = false;
    for (std::size_t b = 1; b < s_.bodies.size(); ++b) has_free_root = has_free_root || !is_held(static_cast<int>(b));
    const auto is_wanted = [&](int j) {
      return !s_.joints[j].drives.empty() ||
             std::ranges::any_of(s_.constraints, [&](const SceneConstraint& c) {
               return std::ranges::any_of(c.terms, [&](const auto& term) { return term.joint == j; });
             });
    };
    bool tree_is_ours = true, has_speeds = false;
    for (int j = 0; j < static_cast<int>(s_.joints.size()); ++j) {
      if (s_.joints[j].closes && !s_.joints[j].is_connection && is_wanted(j)) tree_is_ours = false;
      has_speeds = has_speeds || !s_.joints[j].speeds.empty();
    }
    s_.start = chance_.flip(0.2)                                              ? Start::guess
               : tree_is_ours && !has_free_root && chance_.flip(0.5) ? Start::joints
                                                                              : Start::poses;
    if (!tree_is_ours) {
      for (SceneJoint& joint : s_.joints) joint.speeds.clear();
      for (SceneBody& body : s_.bodies) body.velocity.setZero();
    } else if (s_.start == Start::joints || has_speeds || chance_.flip(0.5))
      for (SceneJoint& joint : s_.joints) joint.cut = joint.closes && !joint.is_connection;
    // What the body that leads a floating tree does at the start is not said where no joint says it.
    s_.order_matters = has_free_root && s_.bodies.size() > 2;
  }
  /// By a joint, to ground at last.
  bool is_held(int b) const {
    std::vector<bool> held(s_.bodies.size(), false);
    held[0] = true;
    for (std::size_t pass = 0; pass < s_.bodies.size(); ++pass)
      for (const SceneJoint& joint : s_.joints) {
        const int F = s_.markers[joint.F].body, M = s_.markers[joint.M].body;
        if (joint.closes) continue;
        if (held[F] || held[M]) held[F] = held[M] = true;
      }
    return held[b];
  }

  // ---- kinds of mechanisms
  void tree() {
    const bool is_grounded = chance_.flip(0.6);
    s_.what = is_grounded ? "tree on ground" : "tree that floats";
    grow_tree(1 + chance_.below(4), is_grounded);
    give_speeds(0.7);
    drives(chance_.flip(0.5) ? 0 : 1 + chance_.below(2));
  }

  void spatial_loops() {
    s_.what = "spatial loops";
    grow_tree(2 + chance_.below(3), chance_.flip(0.85));
    static const char* const types[] = {"distance",  "distance",      "distance",       "point_on_plane", "point_on_line",
                                        "spherical", "perpendicular", "parallel",       "orientation",    "cylindrical",
                                        "revolute",  "universal",     "planar",         "prismatic",      "j point_on_plane"};
    const int loops = 1 + chance_.below(2);
    for (int tries = 0, made = 0; tries < 12 && made < loops; ++tries) {
      const int n = static_cast<int>(s_.bodies.size());
      const int A = chance_.below(n), B = chance_.below(n);
      if (A == B) continue;
      Scene before = s_;
      close(chance_.one_of(types), A, B);
      const ScenePhysics physics(s_);
      const int mobility = physics.n_freedoms() - physics.rank(s_.poses(), 0.0).rank;
      if (mobility > 0 || chance_.flip(0.1))
        ++made;
      else
        s_ = before;
    }
    give_speeds(0.2);
    drives(chance_.below(3));
  }

  void close(std::string type, int A, int B) {
    const Pose at = {chance_.rotation(), s_.bodies[B].X_WB * chance_.vector(0.3)};
    const bool is_joint = type[0] == 'j' || type == "spherical" || type == "cylindrical" || type == "revolute" ||
                          type == "universal" || type == "planar" || type == "prismatic";
    if (type[0] == 'j') type = type.substr(2);
    if (is_joint) {
      SceneJoint joint;
      joint.type = type;
      const int j = join(type, A, at * joint_pose(joint).inverse(), B, at);
      s_.joints[j].closes = true;
      s_.joints[j].is_connection = chance_.flip(0.3);
      return;
    }
    SceneConstraint c;
    c.type = type;
    Pose at_A = at;
    if (type == "distance") {
      at_A.p = s_.bodies[A].X_WB * chance_.vector(0.4);
      c.length = (at_A.p - at.p).norm();
    } else if (type == "perpendicular") {
      at_A.R = at.R * rotation_exp({0.5 * std::numbers::pi, 0, 0});
      at_A.p = s_.bodies[A].X_WB * chance_.vector(0.4);
    } else {
      SceneJoint like;
      like.type = type;
      at_A = at * joint_pose(like).inverse();
    }
    c.F = marker_at(A, at_A);
    c.M = marker_at(B, at);
    s_.constraints.push_back(c);
  }

  // Bodies that move in one plane, on joints whose axes stand across it.
  void planar() {
    s_.what = "planar linkage";
    const Pose plane = {chance_.flip(0.5) ? Matrix3d(Matrix3d::Identity()) : chance_.rotation(), chance_.vector(1.0)};
    const auto at = [&](double x, double y, double z, double turn) {
      return plane * Pose{about_z(turn), {x, y, z}};
    };
    const auto sideways = [&](double x, double y, double z, double turn) {  // z axis in the plane
      return plane * Pose{about_z(turn) * rotation_exp({0, 0.5 * std::numbers::pi, 0}), {x, y, z}};
    };
    const auto depth = [&] { return chance_.flip(0.5) ? 0.0 : chance_.between(-0.1, 0.1); };
    const auto pin = [&](int A, int B, double x, double y) {
      const Pose X = at(x, y, depth(), chance_.between(-3, 3));
      return join("revolute", A, X, B, X * Pose{about_z(chance_.between(-3, 3)), Vector3d::Zero()});
    };
    const int kind = chance_.below(4);
    const double a = chance_.between(0.1, 0.3), turn = chance_.between(0.3, 2.6);
    const double x = a * std::cos(turn), y = a * std::sin(turn);
    const auto somewhere = [&] { return at(chance_.between(-0.5, 0.5), chance_.between(-0.5, 0.5), depth(), chance_.between(-3, 3)); };
    const int crank = body(somewhere()), rod = body(somewhere());
    int closing = -1;
    if (kind == 0) {  // slider-crank
      s_.what += ", slider-crank";
      const int slider = body(somewhere());
      const double end = x + chance_.between(0.5, 0.8), offset = chance_.between(-0.05, 0.05);
      pin(0, crank, 0, 0), pin(crank, rod, x, y);
      const int wrist = pin(rod, slider, end, offset);
      const Pose guide = sideways(chance_.between(-0.2, 0.2), chance_.between(-0.1, 0.1), depth(), 0.0);
      Pose on_slider = guide;
      on_slider.p += chance_.between(-0.3, 0.3) * guide.R.col(2);
      closing = join("prismatic", 0, guide, slider, on_slider);
      if (chance_.flip(0.5)) std::swap(s_.joints[wrist], s_.joints[closing]), closing = wrist + 1;
    } else if (kind == 1) {  // four-bar
      s_.what += ", four-bar";
      const int rocker = body(somewhere());
      const double ground = chance_.between(0.4, 0.6), up = chance_.between(0.3, 0.5), lean = chance_.between(-0.1, 0.2);
      pin(0, crank, 0, 0), pin(crank, rod, x, y), pin(rod, rocker, ground + lean, up);
      closing = pin(rocker, 0, ground, 0);
    } else if (kind == 2) {  // parallelogram, with a third crank
      s_.what += ", parallelogram";
      const int cranks = 2 + chance_.below(2);
      pin(0, crank, 0, 0), pin(crank, rod, x, y);
      for (int i = 1; i < cranks; ++i) {
        const int other = body(somewhere());
        const double d = 0.4 * i, out = chance_.flip(0.7) ? 0.0 : chance_.between(-0.1, 0.1);
        pin(0, other, d, out);
        closing = pin(other, rod, x + d, y + out);
        s_.joints[closing].closes = true;
      }
    } else {  // a double pendulum whose end is led
      s_.what += ", led end";
      pin(0, crank, 0, 0), pin(crank, rod, x, y);
      const Pose end = at(x + 0.3, y + chance_.between(-0.2, 0.2), depth(), 0.0);
      const char* const types[] = {"distance", "point_on_plane", "point_on_line", "parallel", "planar"};
      const std::string type = chance_.one_of(types);
      if (type == "planar") {
        closing = join("planar", 0, at(0.1, 0.1, end.p.norm() * 0.0, 0.3), rod, at(0.2, -0.1, 0.0, 1.0));
      } else {
        SceneConstraint c;
        c.type = type;
        Pose X_F = end;
        if (type == "distance") {
          X_F.p += plane.R * Vector3d(0.4, -0.3, 0.0);
          c.length = 0.5;
        } else if (type == "point_on_plane" || type == "point_on_line") {
          X_F.R = plane.R * rotation_exp({0.5 * std::numbers::pi, 0, 0});  // its z lies in the plane
          X_F.R = rotation_exp(chance_.between(-1, 1) * plane.R.col(2)) * X_F.R;
        }
        c.F = marker_at(0, X_F);
        c.M = marker_at(rod, end);
        s_.constraints.push_back(c);
      }
    }
    if (closing >= 0) s_.joints[closing].closes = true;
    if (chance_.flip(0.12)) {
      // One hinge out of line: closed as it stands, and stuck.
      const int j = chance_.below(static_cast<int>(s_.joints.size()));
      const double tilts[] = {0.2, 0.02, 1e-3};
      s_.what += ", misaligned";
      const Matrix3d tilt = rotation_exp(chance_.one_of(tilts) * (plane.R * Vector3d(0.6, 0.8, 0.0)));
      for (const int m : {s_.joints[j].F, s_.joints[j].M}) {
        const Matrix3d& R_WB = s_.bodies[s_.markers[m].body].X_WB.R;
        s_.markers[m].X_BP.R = R_WB.transpose() * tilt * R_WB * s_.markers[m].X_BP.R;
      }
    } else if (chance_.flip(0.3)) {
      s_.digits = 9 + chance_.below(6);
    }
    if (chance_.flip(0.5)) give_speeds(0.15);
    drives(chance_.below(3));
    if (kind == 2 && s_.joints[0].drives.empty() && chance_.flip(0.5)) {
      // Both cranks driven, alike or not.
      const Law law = drive_law(0, 0, 0.0);
      const bool agrees = chance_.flip(0.6);
      s_.what += agrees ? ", two motors that agree" : ", two motors that do not";
      for (const int j : {0, 2}) {
        s_.joints[j].drives = {{0, law, 0}};
        s_.joints[j].speeds.clear();
        s_.joints[j].drives.clear();
        const double start = ScenePhysics(s_).coordinate(j, 0, s_.poses());
        s_.joints[j].drives = {{0, law, 0}};
        s_.joints[j].drives[0].law.a = start - law.c * std::sin(law.phi);
        if (j == 2 && !agrees) s_.joints[j].drives[0].law.b += 0.5;
      }
    }
  }

  // Two bodies on several joints that allow the same motion.
  void door() {
    s_.what = "door";
    const bool slides = chance_.flip(0.4);
    const int first = chance_.flip(0.4) ? grow("revolute", 0) : 0;
    const Pose axis = {chance_.rotation(), chance_.vector(1.0)};
    const int leaf = body(axis * pose(0.5));
    const int n = 2 + chance_.below(3);
    const char* const turning[] = {"revolute", "revolute", "cylindrical", "spherical", "point_on_line", "parallel"};
    const char* const sliding[] = {"prismatic", "prismatic", "cylindrical", "orientation", "parallel", "planar"};
    for (int i = 0; i < n; ++i) {
      const std::string type = i == 0 ? (slides ? "prismatic" : "revolute")
                                      : (slides ? chance_.one_of(sliding) : chance_.one_of(turning));
      Pose X = axis * Pose{about_z(chance_.between(-3, 3)), {0, 0, i * chance_.between(0.3, 0.6)}};
      if (slides) X.p += axis.R * Vector3d(chance_.between(-0.3, 0.3), chance_.between(-0.3, 0.3), 0.0);
      if (type == "planar") X.R = axis.R * rotation_exp({0, 0.5 * std::numbers::pi, 0});
      Pose on_leaf = X;
      if (slides && type != "planar") on_leaf.p += chance_.between(-0.1, 0.1) * axis.R.col(2);
      if (!slides && type == "revolute") on_leaf.R = X.R * about_z(chance_.between(-3, 3));
      const int j = join(type, first, X, leaf, on_leaf);
      if (i > 0) s_.joints[j].closes = true;
      if (i > 0) s_.joints[j].is_connection = chance_.flip(0.3);
    }
    s_.digits = chance_.flip(0.5) ? 17 : 9 + chance_.below(7);
    if (chance_.flip(0.5)) give_speeds(0.5);
    if (chance_.flip(0.3)) drives(1);
  }

  // Shafts on a carrier, each in mesh with the next; racks; a ring that closes.
  void gears() {
    s_.what = "gears";
    const int carrier = chance_.flip(0.3) ? grow("revolute", 0) : 0;
    const int n = 2 + chance_.below(3);
    const Matrix3d R = chance_.rotation();
    std::vector<int> shafts;
    const bool racks = chance_.flip(0.3);
    for (int i = 0; i < n; ++i) {
      const Pose X = {R * about_z(chance_.between(-3, 3)), R * Vector3d(0.3 * i, chance_.between(-0.1, 0.1), 0)};
      const int wheel = body(X * pose(0.02));
      const bool is_rack = racks && i == n - 1;
      const std::string type = is_rack ? "prismatic" : chance_.flip(0.2) ? "cylindrical" : "revolute";
      SceneJoint like;
      like.type = type;
      const Pose X_FM = is_rack ? Pose{Matrix3d::Identity(), {0, 0, chance_.between(-0.2, 0.2)}}
                                : Pose{about_z(chance_.between(-1, 1)), Vector3d::Zero()};
      Pose X_F = X * X_FM.inverse();
      if (is_rack) X_F = X_F * Pose{rotation_exp({0.5 * std::numbers::pi, 0, 0}), Vector3d::Zero()};
      shafts.push_back(join(type, carrier, X_F, wheel, is_rack ? X_F * X_FM : X));
    }
    std::vector<double> ratio(n, 1.0);  // speed of each over that of the first
    const auto mesh = [&](int i, int k) {
      SceneConstraint c;
      c.terms = {{shafts[i], 0, 1.0}, {shafts[k], 0, 1.0}};
      const double q_i = start_of(shafts[i]), q_k = start_of(shafts[k]);
      if (racks && k == n - 1) {
        c.type = "rack_and_pinion";
        std::swap(c.terms[0], c.terms[1]);
        c.length = chance_.between(0.03, 0.1) * (chance_.flip(0.5) ? 1 : -1);
        c.offset = q_k - c.length * q_i;
        ratio[k] = ratio[i] * c.length;
      } else if (chance_.flip(0.3)) {
        c.type = "coupler";
        c.terms[1].factor = chance_.between(0.5, 2.0) * (chance_.flip(0.5) ? 1 : -1);
        c.offset = q_i + c.terms[1].factor * q_k;
        ratio[k] = -ratio[i] / c.terms[1].factor;
      } else {
        c.type = "gear";
        c.teeth_1 = 10 + chance_.below(30);
        c.teeth_2 = 10 + chance_.below(30);
        c.internal = chance_.flip(0.3);
        const double factor = (c.internal ? -1.0 : 1.0) * c.teeth_2 / c.teeth_1;
        c.offset = q_i + factor * q_k;
        ratio[k] = -ratio[i] / factor;
      }
      s_.constraints.push_back(c);
    };
    for (int k = 1; k < n; ++k) mesh(k - 1, k);
    if (chance_.flip(0.3) && n > 2 && !racks) {
      // The last wheel back to the first, at the ratio that fits or another.
      SceneConstraint c;
      c.type = "coupler";
      const bool agrees = chance_.flip(0.6);
      s_.what += agrees ? ", ring" : ", ring at another ratio";
      const double factor = -1.0 / ratio[n - 1] * (agrees ? 1.0 : chance_.flip(0.5) ? 1.25 : 1.0001);
      c.terms = {{shafts[0], 0, 1.0}, {shafts[n - 1], 0, factor}};
      c.offset = start_of(shafts[0]) + factor * start_of(shafts[n - 1]);
      s_.constraints.push_back(c);
    }
    const int n_drives = chance_.below(3);
    const Law law = drive_law(shafts[0], 0, start_of(shafts[0]));
    const int derivative = chance_.below(3);
    if (n_drives > 0) s_.joints[shafts[0]].drives = {{0, law, derivative}};
    if (n_drives > 1) {
      const int k = 1 + chance_.below(n - 1);
      Law other = law;
      other.a = start_of(shafts[k]) - ratio[k] * (law.value(0.0) - law.a);
      other.b *= ratio[k];
      other.c *= ratio[k];
      const bool agrees = chance_.flip(0.6);
      s_.what += agrees ? ", two drives that agree" : ", two drives that do not";
      if (!agrees) other.b += (racks && k == n - 1 ? 0.02 : 0.3) * (chance_.flip(0.5) ? 1 : -1);
      s_.joints[shafts[k]].drives = {{0, other, chance_.flip(0.7) ? derivative : chance_.below(3)}};
    }
    if (n_drives == 0 && chance_.flip(0.5)) s_.joints[shafts[0]].speeds = {{0, chance_.between(-3, 3)}};
  }

  double start_of(int joint) { return ScenePhysics(s_).coordinate(joint, 0, s_.poses()); }

  // ---- what acts
  Law drive_law(int joint, int coordinate, double start) {
    const double size = coordinates_of(s_.joints[joint].type)[coordinate].is_angle() ? 1.0 : 0.15;
    Law law;
    law.b = size * chance_.between(-3.0, 3.0);
    if (chance_.flip(0.5)) {
      law.c = size * chance_.between(0.05, 0.3);
      law.w = chance_.between(2.0, 12.0);
      if (chance_.flip(0.5)) law.phi = chance_.between(-1.0, 1.0);
      if (chance_.flip(0.2)) law.b = 0.0;
    }
    law.a = start - law.c * std::sin(law.phi);
    return law;
  }

  void drives(int n) {
    for (int tries = 0; tries < 4 * n && n > 0; ++tries) {
      if (s_.joints.empty()) return;
      const int j = chance_.below(static_cast<int>(s_.joints.size()));
      SceneJoint& joint = s_.joints[j];
      const auto& coordinates = coordinates_of(joint.type);
      if (coordinates.empty() || joint.is_connection || !joint.drives.empty()) continue;
      const int i = chance_.below(static_cast<int>(coordinates.size()));
      if (!coordinates[i].can_be_driven) continue;
      const double start = ScenePhysics(s_).coordinate(j, i, s_.poses());
      joint.drives.push_back({i, drive_law(j, i, start), chance_.below(3)});
      std::erase_if(joint.speeds, [&](const auto& given) { return given.first == i; });
      --n;
    }
  }

  void decorate() {
    const int n_bodies = static_cast<int>(s_.bodies.size());
    for (int n = chance_.below(4); n > 0; --n) {
      SceneForce f;
      switch (chance_.below(4)) {
        case 0: {
          const int A = chance_.below(n_bodies), B = chance_.below(n_bodies);
          if (A == B) continue;
          f.type = "spring_damper";
          f.F = s_.add_marker(A, {chance_.rotation(), chance_.vector(0.3)});
          f.M = s_.add_marker(B, {chance_.rotation(), chance_.vector(0.3)});
          const double length = (s_.marker(f.F, s_.poses()).p - s_.marker(f.M, s_.poses()).p).norm();
          if (length < 0.15) continue;
          f.stiffness = std::exp(chance_.between(1.0, 6.0));
          f.rest = length * chance_.between(0.8, 1.2);
          if (chance_.flip(0.4)) f.damping = chance_.between(0.1, 5.0);
          break;
        }
        case 1: {
          if (s_.joints.empty()) continue;
          f.joint = chance_.below(static_cast<int>(s_.joints.size()));
          const SceneJoint& joint = s_.joints[f.joint];
          const auto& coordinates = coordinates_of(joint.type);
          if (coordinates.empty() || joint.is_connection || joint.type == "universal" ||
              joint.type == "point_on_line" || joint.type == "point_on_plane")
            continue;
          f.type = "joint_spring_damper";
          f.coordinate = chance_.below(static_cast<int>(coordinates.size()));
          f.stiffness = coordinates[f.coordinate].is_angle() ? chance_.between(0.5, 30.0) : chance_.between(10.0, 500.0);
          if (chance_.flip(0.4)) f.damping = 0.02 * f.stiffness;
          f.rest = coordinates[f.coordinate].is_angle() ? chance_.between(-0.5, 0.5) : chance_.between(-0.1, 0.1);
          break;
        }
        default: {
          if (chance_.flip(0.5)) continue;
          f.type = chance_.flip(0.5) ? "force" : "torque";
          f.M = s_.add_marker(1 + chance_.below(n_bodies - 1), {chance_.rotation(), chance_.vector(0.3)});
          for (Law& law : f.law) {
            law.a = chance_.between(-1.0, 1.0) * (f.type == "force" ? 10.0 : 1.0);
            if (chance_.flip(0.3)) law.c = 5.0 * (law.a), law.w = chance_.between(2.0, 15.0);
          }
          break;
        }
      }
      s_.forces.push_back(f);
    }
  }

  // A body of its own that rolls over a plane and is held to another one by a spring.
  void add_wheel() {
    std::swap(chance_, more_chance_);  // bodies and poses are drawn from the former
    const Pose plane = pose(0.5);
    std::swap(chance_, more_chance_);
    const double lean = more_chance_.between(-0.5, 0.5), turn = more_chance_.between(-3.0, 3.0);
    // The disc's axis is level but for its lean; its centre stands radius * cos(lean) above the plane.
    SceneConstraint c;
    c.type = "rolling_disc";
    c.length = more_chance_.between(0.1, 0.3);
    const Pose disc = plane * Pose{about_z(turn) * rotation_exp({0.5 * std::numbers::pi + lean, 0, 0}),
                                   {more_chance_.between(-0.3, 0.3), 0.1, c.length * std::cos(lean)}};
    const int other = more_chance_.below(static_cast<int>(s_.bodies.size()));
    std::swap(chance_, more_chance_);
    const int wheel = body(disc * pose(0.02));
    std::swap(chance_, more_chance_);
    s_.bodies[wheel].velocity = more_chance_.vector(1.0);
    s_.bodies[wheel].angular_velocity = more_chance_.vector(4.0);
    c.F = marker_at(0, plane);
    c.M = marker_at(wheel, disc);
    s_.constraints.push_back(c);
    s_.what += ", a disc rolls";
    SceneForce f;
    f.type = "spring_damper";
    f.F = s_.add_marker(other, {more_chance_.rotation(), more_chance_.vector(0.3)});
    f.M = marker_at(wheel, disc);
    f.rest = (s_.marker(f.F, s_.poses()).p - disc.p).norm();
    f.stiffness = more_chance_.between(1.0, 50.0);
    if (f.rest > 0.15) s_.forces.push_back(f);
  }

  // A point of a body stays on a curve of another, where that leaves a freedom.
  void add_curve() {
    const int n = static_cast<int>(s_.bodies.size()), A = more_chance_.below(n), B = more_chance_.below(n);
    if (A == B) return;
    const Scene before = s_;
    SceneConstraint c;
    c.type = "point_on_curve";
    for (const double x : {-0.4, -0.12, 0.15, 0.45})
      c.points.push_back({x, more_chance_.between(-0.1, 0.1), more_chance_.between(-0.05, 0.05)});
    const SceneCurve curve(c.points);
    const Pose X_W = {more_chance_.rotation(), s_.bodies[B].X_WB * more_chance_.vector(0.2)};
    const double s = 0.5 * (curve.knots()[1] + curve.knots()[2]);
    c.F = marker_at(A, X_W);
    c.M = marker_at(B, X_W * Pose{Matrix3d::Identity(), curve.at(s)});
    s_.constraints.push_back(c);
    const ScenePhysics physics(s_), without(before);
    const ScenePhysics::Rank rank = physics.rank(s_.poses(), 0.0), less = without.rank(before.poses(), 0.0);
    if (physics.n_freedoms() == rank.rank || rank.rank != less.rank + 2 || rank.smallest < 0.02)
      s_ = before;
    else
      s_.what += ", a point on a curve";
  }

  // Elements that touch, switch, rub and hold in six directions.
  void decorate_more() {
    const int n_bodies = static_cast<int>(s_.bodies.size());
    for (int n = 1 + more_chance_.below(3); n > 0; --n) {
      SceneForce f;
      const int A = more_chance_.below(n_bodies), B = 1 + more_chance_.below(n_bodies - 1);
      const int kind = more_chance_.below(5);
      if (kind <= 1) {
        if (A == B) continue;
        const Pose X = {more_chance_.rotation(), s_.bodies[B].X_WB * more_chance_.vector(0.3)};
        f.F = marker_at(A, X);
        if (kind == 0) {
          f.type = "bushing";
          f.M = marker_at(B, X * Pose{rotation_exp(more_chance_.vector(0.1)), more_chance_.vector(0.02)});
          f.stiffness = std::exp(more_chance_.between(5.0, 9.0));
          f.turn_stiffness = std::exp(more_chance_.between(1.0, 4.0));
          if (more_chance_.flip(0.4)) f.damping = 0.01 * f.stiffness, f.turn_damping = 0.01 * f.turn_stiffness;
        } else {
          f.type = "contact";
          f.radius = more_chance_.flip(0.3) ? 0.0 : more_chance_.between(0.01, 0.1);
          const double x = more_chance_.between(-0.2, 0.2), gap = more_chance_.between(-0.001, 0.02);
          f.M = marker_at(B, X * Pose{Matrix3d::Identity(), {x, 0.0, f.radius + gap}});
          f.exponent = more_chance_.flip(0.5) ? 1.0 : 1.5;
          f.stiffness = std::exp(more_chance_.between(7.0, 11.0));
          if (more_chance_.flip(0.4)) f.damping = more_chance_.between(1.0, 20.0);
        }
      } else {
        if (s_.joints.empty()) continue;
        f.joint = more_chance_.below(static_cast<int>(s_.joints.size()));
        const SceneJoint& joint = s_.joints[f.joint];
        const auto& coordinates = coordinates_of(joint.type);
        // Angles of joints that close loops end the run where they jump (turn_watch.hpp).
        if (coordinates.empty() || joint.closes || joint.is_connection || joint.type == "universal" ||
            joint.type == "screw" || joint.type == "point_on_line" || joint.type == "point_on_plane")
          continue;
        f.coordinate = more_chance_.below(static_cast<int>(coordinates.size()));
        const bool turns = coordinates[f.coordinate].is_angle();
        const double size = turns ? 2.0 : 10.0;
        if (kind == 2) {
          f.type = "joint_friction";
          f.coulomb = size * more_chance_.between(0.05, 1.0);
          f.transition = turns ? 0.3 : 0.05;
          if (more_chance_.flip(0.5)) f.damping = 0.1 * f.coulomb;
        } else {
          f.type = kind == 3 ? "actuator" : "joint_force";
          f.level[0] = size * more_chance_.between(-1.0, 1.0);
          f.level[1] = size * more_chance_.between(-1.0, 1.0);
          f.time_constant = more_chance_.between(0.01, 0.1);
          f.start = more_chance_.flip(0.5) ? 0.0 : f.level[0];
          f.at = kind == 3 ? more_chance_.between(0.02, 0.2)
                           : ScenePhysics(s_).coordinate(f.joint, f.coordinate, s_.poses()) +
                                 more_chance_.between(-0.2, 0.2) * (turns ? 1.0 : 0.2);
        }
      }
      s_.forces.push_back(f);
    }
  }

  // As a file with so many digits gives them.
  void round_markers() {
    const auto rounded = [&](double x) { return std::stod(fmt::format("{:.{}g}", x, s_.digits)); };
    for (SceneMarker& marker : s_.markers) {
      marker.X_BP.p = marker.X_BP.p.unaryExpr(rounded);
      if (marker.X_BP.R.isIdentity(0.0)) continue;
      const Eigen::Vector4d q = quaternion_of_rotation(marker.X_BP.R).unaryExpr(rounded);
      marker.X_BP.R = rotation_of_quaternion(q.data());
    }
  }

  Chance chance_, more_chance_;
  bool has_more_;
  Scene s_;
};

}  // namespace

Scene random_scene(std::uint64_t seed) { return Maker(seed).make(); }

}  // namespace flexura::mbs::chance
