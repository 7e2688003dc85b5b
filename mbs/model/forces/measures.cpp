// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/types.hpp"

namespace flexura::mbs {
namespace {

/// A scalar of the motion of one marker M relative to another F.
class RelativeMeasure final : public Measure {
 public:
  using Function = double (*)(const Kinematics&, int F, int M, const Vector3d& direction);
  /// Its derivatives by X_FM and V_FM (Derivatives::by_relative).
  using Row = Eigen::Matrix<double, 1, 12>;
  using Gradient = Row (*)(const Relative& rel, const Vector3d& direction);
  RelativeMeasure(std::string name, int F, int M, const Vector3d& direction, input::Dimension dimension,
                  Function f, Gradient gradient)
      : Measure(std::move(name)),
        F_(F),
        M_(M),
        direction_(direction),
        dimension_(dimension),
        f_(f),
        gradient_(gradient) {}
  input::Dimension dimension() const override { return dimension_; }
  double value(const Kinematics& kin, const double*) const override { return f_(kin, F_, M_, direction_); }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    d.rows();
    d.by_relative(F_, M_, gradient_(kin.relative_motion(F_, M_), direction_));
  }

 private:
  int F_, M_;
  Vector3d direction_;
  input::Dimension dimension_;
  Function f_;
  Gradient gradient_;
};

class ExpressionMeasure final : public Measure {
 public:
  ExpressionMeasure(std::string name, std::shared_ptr<const Expression> value)
      : Measure(std::move(name)), value_(std::move(value)) {}
  input::Dimension dimension() const override { return input::dim::none; }
  double value(const Kinematics&, const double* signals) const override { return value_->evaluate(signals); }
  std::vector<int> reads() const override { return value_->reads(); }
  const Expression* formula() const override { return value_.get(); }
  void differentiate(const Kinematics&, const double* signals, Derivatives& d) const override {
    d.rows();
    d.by_formula(*value_, signals);
  }

 private:
  std::shared_ptr<const Expression> value_;
};

using Row = RelativeMeasure::Row;

/// A row that has one block of three.
Row row(int first, const Vector3d& x) {
  Row r = Row::Zero();
  r.segment<3>(first) = x.transpose();
  return r;
}

double distance(const Kinematics& kin, int F, int M, const Vector3d&) {
  return (kin.markers[M].X_WP.p - kin.markers[F].X_WP.p).norm();
}
double distance_rate(const Kinematics& kin, int F, int M, const Vector3d&) {
  const Vector3d r = kin.markers[M].X_WP.p - kin.markers[F].X_WP.p;
  const double length = r.norm();
  return length > 0.0 ? r.dot(kin.markers[M].V.linear - kin.markers[F].V.linear) / length : 0.0;
}
double position(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_pose(F, M).p.dot(e);
}
double axis_component(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.markers[M].X_WP.R.col(2).dot(kin.markers[F].X_WP.R * e);
}
double velocity(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_motion(F, M).V.tail<3>().dot(e);
}
double angle(const Kinematics& kin, int F, int M, const Vector3d&) {
  const Matrix3d R = kin.relative_pose(F, M).R;
  return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
}
double angular_velocity(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_motion(F, M).V.head<3>().dot(e);
}

Row distance_gradient(const Relative& rel, const Vector3d&) {
  const double length = rel.X_FM.p.norm();
  return length > 0.0 ? row(3, rel.X_FM.p / length) : Row(Row::Zero());
}
Row distance_rate_gradient(const Relative& rel, const Vector3d&) {
  const double length = rel.X_FM.p.norm();
  if (length == 0.0) return Row::Zero();
  const Vector3d e = rel.X_FM.p / length, u = rel.V.tail<3>();
  return row(3, (u - e * e.dot(u)) / length) + row(9, e);
}
Row position_gradient(const Relative&, const Vector3d& e) {
  return row(3, e);
}
Row axis_gradient(const Relative& rel, const Vector3d& e) {
  return row(0, Vector3d(rel.X_FM.R.col(2)).cross(e));
}
Row velocity_gradient(const Relative&, const Vector3d& e) {
  return row(9, e);
}
Row angle_gradient(const Relative& rel, const Vector3d&) {
  return row(0, TurnAboutZ(rel.X_FM.R, Vector3d::Zero()).gradient);
}
Row angular_velocity_gradient(const Relative&, const Vector3d& e) {
  return row(6, e);
}

constexpr bool with_direction = true, without_direction = false;

template <RelativeMeasure::Function f, RelativeMeasure::Gradient gradient, bool directed>
MeasureType relative(const char* name, const char* doc, const input::Dimension& dimension) {
  using namespace input;
  MeasureType type;
  type.name = name;
  type.doc = doc;
  type.keys = {text("from", "marker F that it is seen from, \"body.marker\"").required(),
               text("to", "marker M that it is taken of").required()};
  if (directed) type.keys.push_back(vector3("direction", dim::none, "in the axes of F").required());
  static const Dimension measured = dimension;
  type.read = [](const std::string& own, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Measure> {
    Vector3d e = Vector3d::Zero();
    if (directed) {
      e = s.vector3("direction");
      if (!(e.norm() > 0.0)) s.refuse("direction", "has no length", "write for example [1, 0, 0]");
      e.normalize();
    }
    return std::make_shared<RelativeMeasure>(own, c.marker(s, "from"), c.marker(s, "to"), e, measured, f,
                                             gradient);
  };
  return type;
}

}  // namespace

MeasureType distance_measure() {
  return relative<distance, distance_gradient, without_direction>("distance", "Distance of two markers.",
                                                                  input::dim::length);
}
MeasureType distance_rate_measure() {
  return relative<distance_rate, distance_rate_gradient, without_direction>(
      "distance_rate", "Time derivative of the distance of two markers.", input::dim::velocity);
}
MeasureType position_measure() {
  return relative<position, position_gradient, with_direction>(
      "position", "Component of the position of M in F.", input::dim::length);
}
MeasureType axis_measure() {
  return relative<axis_component, axis_gradient, with_direction>(
      "axis", "Component of the z axis of M in F, a direction cosine.", input::dim::none);
}
MeasureType velocity_measure() {
  return relative<velocity, velocity_gradient, with_direction>(
      "velocity", "Component of the velocity of M as seen from F.", input::dim::velocity);
}
MeasureType angle_measure() {
  return relative<angle, angle_gradient, without_direction>(
      "angle", "Angle of M about the z axis of F, within +-180 deg.", input::dim::angle);
}
MeasureType angular_velocity_measure() {
  return relative<angular_velocity, angular_velocity_gradient, with_direction>(
      "angular_velocity", "Component of the angular velocity of M as seen from F.",
      input::dim::angular_velocity);
}
MeasureType expression_measure() {
  using namespace input;
  return {"expression",
          "A formula of t, parameters, joint coordinates and the measures above it.",
          {expression("value", "the formula").required()},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const Measure> {
            return std::make_shared<ExpressionMeasure>(name, context.expression(s, "value"));
          }};
}

}  // namespace flexura::mbs
