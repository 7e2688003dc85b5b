// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_deck.hpp"
#include "mesh/import/abaqus/abaqus_keywords.hpp"

// Axes of an Abaqus deck: *TRANSFORM and *SYSTEM.
namespace flexura::mesh::abaqus {
namespace {

// Six numbers, a and b: x along a, y in the plane of a and b; of cylinders and spheres the axis from a to b.
Transform axes_of(const std::vector<double>& v, char kind, const Where& where) {
  Transform to{.set = {}, .kind = kind, .where = where};
  const Eigen::Vector3d a(v[0], v[1], v[2]), b(v[3], v[4], v[5]);
  Eigen::Vector3d x = a, z = a.cross(b);
  if (kind != 'R') {
    to.origin = a;
    z = b - a;
    x = z.unitOrthogonal();
  }
  if (!(x.norm() > 0) || !(z.norm() > 0))
    throw std::invalid_argument(fmt::format("{}: these points span no axes", where.text()));
  to.R.col(2) = z.normalized();
  to.R.col(1) = z.cross(x).normalized();
  to.R.col(0) = to.R.col(1).cross(to.R.col(2));
  return to;
}

}  // namespace

Transform transform_of(const Keyword& k) {
  const std::string type = upper(k.has("TYPE") ? k.get("TYPE") : "R");
  std::vector<double> v = numbers_of(k, 0);
  if (v.size() < 6 || (type != "R" && type != "C" && type != "S"))
    throw std::invalid_argument(k.where.text() + ": *TRANSFORM wants TYPE=R, C or S and six numbers");
  Transform to = axes_of(v, type[0], k.where);
  to.set = upper(k.get("NSET"));
  return to;
}

Orientation orientation_of(const Keyword& k) {
  Orientation to{.where = k.where};
  const std::string system = upper(k.has("SYSTEM") ? k.get("SYSTEM") : "RECTANGULAR"),
                    definition = upper(k.has("DEFINITION") ? k.get("DEFINITION") : "COORDINATES");
  const char kind = system.empty() ? 'R' : system[0];
  if ((kind != 'R' && kind != 'C' && kind != 'S') || definition != "COORDINATES") {
    to.not_read = definition != "COORDINATES" ? "DEFINITION=" + definition : "SYSTEM=" + system;
    return to;
  }
  std::vector<double> v = numbers_of(k, 0);
  if (v.size() < 6) {
    to.not_read = fmt::format("{} numbers instead of six", v.size());
    return to;
  }
  if (kind == 'R') {
    v.resize(9, 0.0);  // a, b and the origin
    for (std::size_t d = 0; d < 3; ++d) v[d] -= v[6 + d], v[3 + d] -= v[6 + d];
  }
  to.system = axes_of(v, kind, k.where);
  // One more turn, about one of the axes, in degrees.
  if (const std::vector<double> turn = numbers_of(k, 1); !turn.empty()) {
    to.about = static_cast<int>(turn[0]);
    if (to.about < 1 || to.about > 3)
      throw std::invalid_argument(
          fmt::format("{}: *ORIENTATION turns about axis {:g}; 1 to 3 are known", k.where.text(), turn[0]));
    if (turn.size() > 1) to.angle = turn[1] * std::numbers::pi / 180;
  }
  return to;
}

Eigen::Matrix3d Orientation::axes_at(const Eigen::Vector3d& x) const {
  const Eigen::Matrix3d axes = system.axes_at(x);
  return angle == 0
             ? axes
             : Eigen::Matrix3d(Eigen::AngleAxisd(angle, axes.col(about - 1)).toRotationMatrix() * axes);
}

Eigen::Matrix3d Orientation::shell_axes_at(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
  const Eigen::Matrix3d axes = system.axes_at(x);
  const Eigen::Matrix3d laid = laid_on(normal, axes.col(about % 3), axes.col((about + 1) % 3));
  return angle == 0 ? laid : Eigen::Matrix3d(Eigen::AngleAxisd(angle, laid.col(2)).toRotationMatrix() * laid);
}

Eigen::Matrix3d laid_on(const Eigen::Vector3d& normal, const Eigen::Vector3d& along,
                        const Eigen::Vector3d& otherwise) {
  constexpr double kUpright = 1.7e-3;  // sine of a tenth of a degree
  const Eigen::Vector3d n = normal.normalized();
  const bool upright = along.cross(n).norm() < kUpright * along.norm();
  const Eigen::Vector3d& from = upright ? otherwise : along;
  Eigen::Matrix3d out;
  out.col(0) = (from - n * n.dot(from)).normalized();
  out.col(2) = n;
  out.col(1) = n.cross(out.col(0));
  return out;
}

Transform system_of(const Keyword& k) {
  std::vector<double> v = numbers_of(k, 0), more = numbers_of(k, 1);
  v.insert(v.end(), more.begin(), more.end());
  if (v.empty()) return {};
  const bool about_z = v.size() <= 6;  // two points alone
  v.resize(9, 0.0);
  const Eigen::Vector3d o(v[0], v[1], v[2]), x = Eigen::Vector3d(v[3], v[4], v[5]) - o;
  Eigen::Vector3d y = Eigen::Vector3d(v[6], v[7], v[8]) - o;
  if (about_z) y = Eigen::Vector3d::UnitZ().cross(x);
  Transform system = axes_of({x[0], x[1], x[2], y[0], y[1], y[2]}, 'R', k.where);
  system.origin = o;
  return system;
}

Eigen::Matrix3d Transform::axes_at(const Eigen::Vector3d& x) const {
  if (kind == 'R') return R;
  const Eigen::Vector3d from = x - origin, z = R.col(2);
  const Eigen::Vector3d radial = kind == 'S' ? from : Eigen::Vector3d(from - z * z.dot(from)),
                        around = z.cross(from);
  if (!(around.norm() > 1e-12 * from.norm())) return R;  // on the axis
  Eigen::Matrix3d axes;
  const Eigen::Vector3d r = radial.normalized(), t = around.normalized();
  axes << r, t, (kind == 'S' ? Eigen::Vector3d(r.cross(t)) : z);
  return axes;
}

}  // namespace flexura::mesh::abaqus
