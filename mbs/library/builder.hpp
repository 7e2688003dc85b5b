// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <concepts>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/formulas/expression.hpp"
#include "mbs/library/same_layout.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/start/model_source.hpp"

/// Mechanisms in C++, without a file:
///
///     MechanismBuilder b;
///     b.gravity({0, 0, -9.81});
///     auto crank = b.add("crank", RigidBody{.mass = 2.0, .center = {0.1, 0, 0}, .inertia = I});
///     auto rod = b.add("rod", ModalBody::read("rod.se.h5", {.modes = 10}));
///     b.add<Revolute>("main", b.ground().marker(), crank.marker()).start(0.3);
///     b.add<Revolute>("pin", crank.marker({R, {0.2, 0, 0}}), rod.marker("big_end"));
///     b.add<SpringDamper>("s", P, Q, {.stiffness = 1e4});
///     Mechanism m = b.build();
///
/// Elements are the public classes of mbs/joints, mbs/constraints, mbs/forces, mbs/measures and mbs/controls: add()
/// hands its arguments to their constructors behind the name: markers and bodies as int, coordinates as CoordinateRef.
/// A force of your own (a class derived from ForceElement, docs/architecture.md) is added like these.  All numbers are SI.
/// Handles of bodies and joints are good as long as the builder stays where it is.
namespace flexura::mbs {

/// In the body's own axes.
struct RigidBody {
  double mass = 0.0;                    ///< [kg]
  Vector3d center = Vector3d::Zero();   ///< of mass [m]
  Matrix3d inertia = Matrix3d::Zero();  ///< about it [kg m^2]
};

/// A part whose model is chosen for an accuracy (mbs/study/library/run.hpp), or is that of `model`.
struct Part {
  std::filesystem::path superelement;  ///< a file that flexura reduce has made
  BodyModel model = {};  ///< without a fidelity: chosen where an accuracy is asked for, else modal
};
/// The same of a beam.
struct Beam {
  BeamPart shape;
  BodyModel model = {};
};

class MechanismBuilder {
 public:
  /// A frame on a body.
  struct Marker {
    int index = -1;
    const MechanismBuilder* of = nullptr;  ///< that made it
  };

  class Body {
   public:
    /// A new marker at X_BP in the body (undeformed).
    /// Throws std::invalid_argument where X_BP is not finite or no rotation.
    Marker marker(const Pose& X_BP = {}) const;
    /// In the body's axes, at {x, y, z} from its origin [m].
    Marker marker(std::initializer_list<double> p_BoP_B) const;
    template <class Derived>
    Marker marker(const Eigen::MatrixBase<Derived>& p_BoP_B) const {
      return marker(Pose{Matrix3d::Identity(), Vector3d(p_BoP_B)});
    }
    /// A new marker that moves with an interface of a flexible body, at X_NP from it.  Throws
    /// std::invalid_argument for a name that the body does not have.  A template, so that the numbers of {0, 0, 1} are no letters.
    template <std::convertible_to<std::string> Text>
    Marker marker(const Text& interface, const Pose& X_NP = {}) const {
      return marker_at(interface, X_NP);
    }
    int index() const { return index_; }

   private:
    friend class MechanismBuilder;
    Marker marker_at(const std::string& interface, const Pose& X_NP) const;
    Body(MechanismBuilder& builder, int index) : builder_(&builder), index_(index) {}
    MechanismBuilder* builder_;
    int index_;
  };

  class JointHandle {
   public:
    /// Coordinate, speed or acceleration i of the joint, for elements that work on it.
    CoordinateRef coordinate(int i = 0) const { return {index_, i}; }
    /// Its value and its speed at the start; loops that do not close move others first.
    JointHandle& start(double q, int i = 0);
    JointHandle& speed(double v, int i = 0);
    /// Prescribes the coordinate by a formula of t, parameters and states of controls that were added before.
    JointHandle& drive(const std::string& formula, int i = 0);

   private:
    friend class MechanismBuilder;
    JointHandle(MechanismBuilder& builder, int index) : builder_(&builder), index_(index) {}
    MechanismBuilder* builder_;
    int index_;
  };

  explicit MechanismBuilder(std::string name = "mechanism") { d_.name = std::move(name); }

  /// Acceleration of free fall in world axes [m/s^2]; none without it, where a file has [0, 0, -9.81].
  void gravity(const Vector3d& g_W);
  /// A constant that formulas read by its name.
  void parameter(const std::string& name, double value);
  /// An input: a function of t that formulas read by its name.
  void input(const std::string& name, const std::string& formula);

  Body ground() { return {*this, 0}; }
  /// `X_WB` is a guess of where it stands, for loops that close in more than one way.  Throws std::invalid_argument for what a
  /// file is refused for: masses, inertias and places that no body has.
  Body add(const std::string& name, const RigidBody& body, std::optional<Pose> X_WB = {});
  Body add(const std::string& name, const ModalBody& body, std::optional<Pose> X_WB = {});
  /// Its interfaces are the superelement's.  Throws std::runtime_error for a file that is none.
  Body add(const std::string& name, const Part& part, std::optional<Pose> X_WB = {});
  /// Its interfaces are "root", "tip" and its points.  Throws std::invalid_argument for what is no beam.
  Body add(const std::string& name, const Beam& beam, std::optional<Pose> X_WB = {});
  /// Any other law of deformation.
  Body add(const std::string& name, std::shared_ptr<const FlexibleBody> body, std::optional<Pose> X_WB = {});

  /// A joint between two markers, closed as a loop where the tree does not need it; `args` go to its constructor.
  template <std::derived_from<Joint> J, class... Args>
  JointHandle add(const std::string& name, Marker F, Marker M, Args&&... args) {
    return add_joint(name, std::make_shared<J>(std::forward<Args>(args)...), F, M);
  }
  /// Rows on the pose of M in F (geometric.hpp, point_on_curve.hpp).
  template <std::derived_from<RelativeRows> Rows, class... Args>
  requires(!std::derived_from<Rows, Joint>) void add(const std::string& name, Marker F, Marker M,
                                                     Args&&... args) {
    add_element(std::make_shared<RelativeConstraint>(name, plain(F), plain(M),
                                                     std::make_shared<Rows>(std::forward<Args>(args)...)));
  }
  /// Any other element: Element(name, args...) with markers and coordinates in their places.
  template <class Element, class... Args>
  requires(!std::derived_from<Element, RelativeRows>) void add(const std::string& name, Args&&... args) {
    add_element(std::make_shared<Element>(name, plain(std::forward<Args>(args))...));
  }
  /// The same of an element whose law has names: {.stiffness = 1e4}.
  template <class Element>
  void add(const std::string& name, Marker P, Marker Q, typename Element::Law law) {
    require_law(name, law);
    add_element(std::make_shared<Element>(name, plain(P), plain(Q), std::move(law)));
  }
  template <class Element>
  void add(const std::string& name, CoordinateRef c, typename Element::Law law) {
    require_law(name, law);
    add_element(std::make_shared<Element>(name, plain(c), std::move(law)));
  }

  /// A formula of t, parameters, and of coordinates ("main.angle", "main.speed"), measures, controls and inputs that
  /// are there already.  Throws std::invalid_argument.
  std::shared_ptr<const Expression> formula(const std::string& text);
  /// One of t and parameters alone that prescribes a motion.
  std::shared_ptr<const Expression> motion(const std::string& text);

  const MechanismDescription& description() const { return d_; }
  /// Throws std::invalid_argument for a description that cannot move or stand.
  Mechanism build() const;

  /// A body whose model is open.
  struct Open {
    std::filesystem::path superelement;
    std::optional<BeamPart> beam;
    BodyModel model;
    std::vector<std::pair<std::string, Vector3d>> interfaces;
  };
  const std::map<int, Open>& open() const { return open_; }

 private:
  // What handles stand for.  Throw std::invalid_argument for one of another mechanism, as far as that shows.
  int plain(Marker m) const;
  int plain(const Body& b) const;
  CoordinateRef plain(CoordinateRef c) const;
  template <class T>
  static T&& plain(T&& x) {
    return std::forward<T>(x);
  }
  // As the keys of a file are: stiffness and damping that are not negative.
  template <class Law>
  static void require_law(const std::string& name, const Law& law) {
    const auto check = [&](const char* what, const auto& value) {
      if constexpr (std::convertible_to<decltype(value), double>)
        require_not_negative(name, what, static_cast<double>(value));
    };
    if constexpr (requires { law.stiffness; }) check("stiffness", law.stiffness);
    if constexpr (requires { law.damping; }) check("damping", law.damping);
    if constexpr (requires { law.stick_stiffness; }) check("stick_stiffness", law.stick_stiffness);
    if constexpr (requires { law.stick_damping; }) check("stick_damping", law.stick_damping);
  }
  static void require_not_negative(const std::string& name, const char* what, double value);
  JointHandle add_joint(const std::string& name, std::shared_ptr<const Joint> joint, Marker F, Marker M);
  Body add_body(BodyDescription body);
  void add_element(std::shared_ptr<const Constraint> element);
  void add_element(std::shared_ptr<const ForceElement> element);
  void add_element(std::shared_ptr<const Measure> element);
  void add_element(std::shared_ptr<const Control> element);
  void take_signal(const std::string& name);
  void require_new(const std::string& name, const char* what);

  Body add_open(const std::string& name, Open open, std::optional<Pose> X_WB);

  MechanismDescription d_;
  std::map<int, Open> open_;
  std::map<std::string, double> parameters_;
  std::map<std::string, const char*> names_;  ///< of bodies and elements, and what they are
};

}  // namespace flexura::mbs
