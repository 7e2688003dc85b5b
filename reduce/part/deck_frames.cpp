// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/deck_frames.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>

#include "beam/element/element.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Motion = Eigen::Matrix<double, 3, 12>;  // of a point by (u, theta) of both nodes

// Collects points and gives them to the mesh at once.
class Points {
 public:
  explicit Points(Part& part) : part_(part), next_(part.mesh.n_nodes()) {}
  mesh::Index add(const Vector3d& x, const std::array<mesh::Index, 2>& nodes, const Motion& C) {
    Follower follower{.point = next_++, .from = {}};
    for (int end = 0; end < 2; ++end)
      if (const Eigen::Matrix<double, 3, 6> of_end = C.middleCols<6>(6 * end); !of_end.isZero(0.0))
        follower.from.emplace_back(nodes[end], of_end);
    part_.followers.push_back(std::move(follower));
    points_.push_back(x);
    return part_.followers.back().point;
  }
  // On the ends of a bar between the nodes, by forces at the point: forces on the nodes, brought there.
  Eigen::Matrix<double, 12, 3> forces(mesh::Index point, const std::array<mesh::Index, 2>& nodes,
                                      const beam::Matrix12d& to_ends) const {
    Motion C = Motion::Zero();
    const Follower& follower =
        part_.followers[part_.followers.size() - static_cast<std::size_t>(next_ - point)];
    for (const auto& [node, of_end] : follower.from) C.middleCols<6>(node == nodes[0] ? 0 : 6) = of_end;
    return to_ends * C.transpose();
  }
  void finish() {
    mesh::Mesh& mesh = part_.mesh;
    const Eigen::Index before = mesh.points.rows();
    mesh.points.conservativeResize(next_, 3);
    for (std::size_t k = 0; k < points_.size(); ++k)
      mesh.points.row(before + static_cast<Eigen::Index>(k)) = points_[k].transpose();
    if (!mesh.node_label.empty()) mesh.node_label.resize(static_cast<std::size_t>(next_), -1);
  }

 private:
  Part& part_;
  mesh::Index next_;
  std::vector<Vector3d> points_;
};

Matrix3d cross_matrix(const Vector3d& r) {
  Matrix3d X;
  X << 0, -r(2), r(1), r(2), 0, -r(0), -r(1), r(0), 0;
  return X;
}

// A beam, or a rod as a beam whose bending is struck out.
struct Bar {
  beam::Placement place;
  beam::Matrix12d K;     // of the nodes, axes of B
  beam::Matrix12d ends;  // forces and moments at the ends of its axis, in its own axes, by the nodes' motions
  std::function<beam::Matrix6x12d(double)> move;  // axes of B, at x along it
};

Bar make_bar(const mesh::ImportedBar& from, const Part& part, const std::string& name) {
  const Eigen::Matrix<double, 6, 6> S = part.materials.at(from.material).D.inverse();
  const double E = 1.0 / S(0, 0), G = from.G > 0.0 ? from.G : 1.0 / S(3, 3);
  const Vector3d a = part.mesh.points.row(from.nodes[0]), b = part.mesh.points.row(from.nodes[1]);
  const bool is_rod = from.I_yy == 0.0 && from.I_zz == 0.0;
  const Vector3d side = is_rod ? Vector3d((b - a).unitOrthogonal()) : from.orientation;
  Bar bar{.place = beam::place(name, a, b, side, from.offset[0], from.offset[1]),
          .K = {},
          .ends = {},
          .move = {}};
  const double l = bar.place.length;
  const beam::Matrix12d T = bar.place.transform();
  Eigen::Matrix<double, 6, 6> R = Eigen::Matrix<double, 6, 6>::Zero();
  R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = bar.place.R_BE;
  if (!(from.A > 0.0))
    throw std::invalid_argument(fmt::format("{} has the area {:g}; it must be above 0", name, from.A));
  // Torsion alone is struck out where the section has none: what holds the node elsewhere does.
  const auto spring = [&](int d, double k) {
    beam::Vector12d q = beam::Vector12d::Zero();
    q(d) = -1.0, q(6 + d) = 1.0;
    return beam::Matrix12d(k / l * q * q.transpose());
  };
  if (is_rod) {
    const beam::Matrix12d K = spring(0, E * from.A) + spring(3, G * from.J);
    bar.ends = K * T;
    bar.K = T.transpose() * bar.ends;
    // It turns with its ends' displacements, theta = e_x x (u_2 - u_1) / l.
    bar.move = [T, R, l](double x) {
      beam::Matrix6x12d shape = beam::Matrix6x12d::Zero();
      shape.leftCols<6>().diagonal().head<3>().setConstant(1.0 - x / l);
      shape.rightCols<6>().diagonal().head<3>().setConstant(x / l);
      shape(4, 2) = 1.0 / l, shape(4, 8) = -1.0 / l;
      shape(5, 1) = -1.0 / l, shape(5, 7) = 1.0 / l;
      return beam::Matrix6x12d(R * shape * T);
    };
    return bar;
  }
  const double y = from.centroid(0), z = from.centroid(1);  // moments are about the axis
  // Bending in a plane is struck out where the section has no moment for it.
  const double I_yy = from.I_yy > 0.0 ? from.I_yy : from.I_zz, I_zz = from.I_zz > 0.0 ? from.I_zz : from.I_yy;
  beam::Constants constants{.A = from.A, .I_y = I_yy + from.A * z * z, .I_z = I_zz + from.A * y * y};
  constants.S_y = from.A * z, constants.S_z = from.A * y;
  constants.y_cg = y, constants.z_cg = z;
  constants.I_t = from.J > 0.0 ? from.J : from.I_yy + from.I_zz;
  if (from.kappa_y > 0.0) constants.A_sy = from.kappa_y * from.A;
  if (from.kappa_z > 0.0) constants.A_sz = from.kappa_z * from.A;
  constants.I_yz = -(from.I_yz + from.A * y * z);  // the sign of an inertia tensor
  const beam::Section section = beam::make_section(
      name, constants, {.name = name, .E = E, .G = G, .rho = part.materials.at(from.material).density});
  beam::Releases releases;
  for (std::size_t end = 0; end < 2; ++end)
    for (std::size_t d = 0; d < 6; ++d) releases[6 * end + d] = from.released[end][d];
  const beam::Element element(l, beam::matrices_of(section, beam::Theory::timoshenko), releases);
  beam::Matrix12d K = element.stiffness();
  if (!(from.J > 0.0)) K -= spring(3, G * constants.I_t);
  const auto strike = [&](std::initializer_list<int> dofs) {
    for (const int d : dofs) K.row(d).setZero(), K.col(d).setZero();
  };
  if (!(from.I_yy > 0.0)) strike({2, 4, 8, 10});
  if (!(from.I_zz > 0.0)) strike({1, 5, 7, 11});
  bar.ends = K * T;
  bar.K = T.transpose() * bar.ends;
  bar.move = [element, T, R](double x) { return beam::Matrix6x12d(R * element.shape(x) * T); };
  return bar;
}

// Of axial force and bending at an end, at (y, z) from the centroid: sigma_xx = N/A + a y + b z with
// int y sigma dA = -M_z, int z sigma dA = M_y.  Rows (xx, yy, zz, xy, yz, zx) in the axes of B.
Eigen::Matrix<double, 6, 12> stress_at(const mesh::ImportedBar& from, const Bar& bar, int end,
                                       const Eigen::Vector2d& at) {
  const double sign = end == 0 ? -1.0 : 1.0;
  const auto force = [&](int d) { return Eigen::RowVectorXd(sign * bar.ends.row(6 * end + d)); };
  const Eigen::RowVectorXd N = force(0);
  Eigen::RowVectorXd sigma = N / from.A;
  if (from.I_yy > 0.0 || from.I_zz > 0.0) {
    Eigen::Matrix2d I;
    I << from.I_zz, from.I_yz, from.I_yz, from.I_yy;
    Eigen::Matrix<double, 2, 12> moments;  // about the centroid
    moments << -force(5) - from.centroid(0) * N, force(4) - from.centroid(1) * N;
    sigma += at.transpose() * I.inverse() * moments;
  }
  const Vector3d e = bar.place.R_BE.col(0);
  Eigen::Matrix<double, 6, 1> tensor;
  tensor << e(0) * e(0), e(1) * e(1), e(2) * e(2), e(0) * e(1), e(1) * e(2), e(2) * e(0);
  return tensor * sigma;
}

// Their numbers in the deck; "7.1" and "7.2" where several have one, as the halves of an element of three nodes.
std::vector<std::string> names_of(const std::vector<mesh::ImportedBar>& bars) {
  std::map<std::int64_t, std::pair<int, int>> uses;  // how many there are, how many are named
  for (const mesh::ImportedBar& bar : bars) ++uses[bar.label].first;
  std::vector<std::string> names;
  for (const mesh::ImportedBar& bar : bars) {
    auto& [count, named] = uses[bar.label];
    names.push_back(count == 1 ? fmt::format("{}", bar.label) : fmt::format("{}.{}", bar.label, ++named));
  }
  return names;
}

template <std::size_t n>
void add_boundary(mesh::CellType type, const std::vector<std::array<mesh::Index, n>>& cells,
                  mesh::Mesh& mesh) {
  mesh::CellBlock block{.type = type};
  block.nodes.resize(static_cast<Eigen::Index>(cells.size()), n);
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (std::size_t c = 0; c < n; ++c)
      block.nodes(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) = cells[k][c];
  mesh.boundary.push_back(std::move(block));
}

}  // namespace

void add_bars(const std::vector<mesh::ImportedBar>& bars, Part& part) {
  constexpr double kGauss[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                0.8611363115940526};
  constexpr double kWeight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                 0.3478548451374538};
  const std::vector<std::string> names = names_of(bars);
  Points points(part);
  std::vector<std::array<mesh::Index, 4>> sides;
  std::vector<std::array<mesh::Index, 3>> faces;
  for (const mesh::ImportedBar& from : bars) {
    const Bar bar = make_bar(from, part, fmt::format("beam element {}", from.label));
    const double l = bar.place.length, density = part.materials.at(from.material).density;
    FrameElement element{.nodes = {from.nodes[0], from.nodes[1]}, .K = 0.5 * (bar.K + bar.K.transpose())};
    const double size = element.K.cwiseAbs().maxCoeff();
    for (int end = 0; end < 2; ++end)  // a rod's rotations are round-off: none
      if (element.K.middleRows<3>(6 * end + 3).cwiseAbs().maxCoeff() < 1e-13 * size * l) {
        element.K.middleRows<3>(6 * end + 3).setZero();
        element.K.middleCols<3>(6 * end + 3).setZero();
      }
    const MaterialDamping& damping = part.materials.at(from.material).damping;
    if (damping.beta != 0.0) element.D = damping.beta * element.K;
    if (damping.loss != 0.0) element.K_loss = damping.loss * element.K;
    part.frames.push_back(std::move(element));
    CutBar cut{.name = names[static_cast<std::size_t>(&from - bars.data())],
               .nodes = from.nodes,
               .R_BE = bar.place.R_BE,
               .p_Bo1_B = bar.place.p_Bo1_B,
               .length = l,
               .ends = bar.ends};
    const beam::Matrix12d to_ends = bar.place.transform().inverse().transpose();

    // Mass, and the section's moments about its principal axes.
    const bool apart = from.extra_mass_at != from.centroid && from.extra_mass_per_length > 0.0;
    const double mass = density * from.A + (apart ? 0.0 : from.extra_mass_per_length);
    const auto across = [&](const Eigen::Vector2d& at) -> Vector3d {
      return bar.place.R_BE.rightCols<2>() * at;
    };
    const Vector3d centroid = across(from.centroid), extra_at = across(from.extra_mass_at);
    Eigen::Matrix2d moments;
    moments << from.I_zz, from.I_yz, from.I_yz, from.I_yy;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(density * moments);
    for (int g = 0; g < 4; ++g) {
      const double x = 0.5 * l * (1.0 + kGauss[g]), share = 0.5 * l * kWeight[g];
      const beam::Matrix6x12d move = bar.move(x);
      const Vector3d on_axis = bar.place.p_Bo1_B + x * bar.place.R_BE.col(0);
      const auto add = [&](const Vector3d& arm) {
        return points.add(on_axis + arm, from.nodes,
                          move.topRows<3>() - cross_matrix(arm) * move.bottomRows<3>());
      };
      const auto weigh = [&](mesh::Index point, double kg) {
        part.masses.push_back({point, kg, damping.alpha});
        cut.masses.push_back({point, kg, points.forces(point, from.nodes, to_ends)});
      };
      const mesh::Index middle = add(centroid);
      if (apart) weigh(add(extra_at), from.extra_mass_per_length * share);
      double left = mass;
      for (int k = 0; k < 2; ++k) {
        const double moment = axes.eigenvalues()(k);
        if (!(moment > 0.0) || !(mass > 0.0)) continue;
        // 2 w r^2 = moment with w = mass/6, so that a third stays on the axis.
        const double w = mass / 6.0, reach = std::sqrt(moment / (2.0 * w));
        const Vector3d r = reach * bar.place.R_BE.rightCols<2>() * axes.eigenvectors().col(k);
        for (const double way : {-1.0, 1.0}) weigh(add(centroid + way * r), w * share);
        left -= 2.0 * w;
      }
      if (left > 0.0) weigh(middle, left * share);
    }
    for (std::size_t k = 0; k < cut.turning.size(); ++k)
      cut.turning[k] = bar.move(static_cast<double>(k) / 3.0 * l).bottomRows<3>();
    part.bars.push_back(std::move(cut));

    // What is seen of it: its outline, or a rectangle with the same radii of gyration.
    const bool is_rod = from.I_yy == 0.0 && from.I_zz == 0.0;
    std::vector<Eigen::Vector2d> outline = from.outline;
    const bool known = is_rod || outline.size() >= 3;
    if (outline.size() < 3) {
      const double half_y = is_rod ? 0.5 * std::sqrt(from.A) : std::sqrt(3.0 * from.I_zz / from.A),
                   half_z = is_rod ? 0.5 * std::sqrt(from.A) : std::sqrt(3.0 * from.I_yy / from.A);
      outline = {{-half_y, -half_z}, {half_y, -half_z}, {half_y, half_z}, {-half_y, half_z}};
    }
    std::array<std::vector<mesh::Index>, 2> ring;
    for (int end = 0; end < 2; ++end) {
      beam::Matrix6x12d move = bar.move(end * l);
      if (!is_rod) move.middleCols<6>(6 - 6 * end).setZero();  // round-off of the other end
      for (const Eigen::Vector2d& at : outline) {
        const Vector3d arm = centroid + across(at);
        const mesh::Index point =
            points.add(bar.place.p_Bo1_B + end * l * bar.place.R_BE.col(0) + arm, from.nodes,
                       move.topRows<3>() - cross_matrix(arm) * move.bottomRows<3>());
        ring[end].push_back(point);
        if (known)
          part.beam_stresses.push_back({.point = point,
                                        .material = from.material,
                                        .nodes = from.nodes,
                                        .of_nodes = stress_at(from, bar, end, at)});
      }
    }
    const std::size_t n = outline.size();
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t next = (c + 1) % n;
      sides.push_back({ring[0][c], ring[0][next], ring[1][next], ring[1][c]});
    }
    for (std::size_t c = 1; c + 1 < n; ++c) {
      faces.push_back({ring[0][c + 1], ring[0][c], ring[0][0]});
      faces.push_back({ring[1][0], ring[1][c], ring[1][c + 1]});
    }
  }
  points.finish();
  if (sides.empty()) return;
  add_boundary(mesh::CellType::quad4, sides, part.mesh);
  add_boundary(mesh::CellType::tri3, faces, part.mesh);
  part.mesh.boundary_face.clear();
}

void add_springs(const std::vector<mesh::ImportedSpring>& springs, Part& part) {
  for (const mesh::ImportedSpring& from : springs) {
    const Vector3d a = part.mesh.points.row(from.nodes[0]), b = part.mesh.points.row(from.nodes[1]);
    const Vector3d middle = from.at.value_or(a + from.place * (b - a));
    // The relative motion at the place of the springs, carried there by rigid arms, in the axes.
    Eigen::Matrix<double, 6, 12> relative;
    relative << -node_motion_at(middle - a), node_motion_at(middle - b);
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = from.R.transpose();
    const Eigen::Matrix<double, 6, 12> strain = turn * relative;
    const auto numbers = [&](const std::array<double, 6>& of, const char* element, const char* what) {
      for (const double value : of)
        if (!(value >= 0.0 && std::isfinite(value)))
          throw std::invalid_argument(
              fmt::format("{} element {} has the {} {:g}; it must be at least 0 and finite", element,
                          from.label, what, value));
      return Eigen::Matrix<double, 6, 1>(of.data());
    };
    const Eigen::Matrix<double, 6, 1> k = numbers(from.stiffness, "spring", "stiffness"),
                                      c = numbers(from.damping, "damper", "coefficient");
    if (k.isZero(0.0) && c.isZero(0.0)) continue;
    const auto matrix = [&](const Eigen::Matrix<double, 6, 1>& of) {
      Eigen::MatrixXd K = strain.transpose() * of.asDiagonal() * strain;
      // Along the line of its nodes it turns nothing: what round-off leaves of the arms is none.
      const double size = K.cwiseAbs().maxCoeff(), arm = (b - a).norm();
      for (int end = 0; end < 2; ++end)
        if (of.tail<3>().isZero(0.0) &&
            K.middleRows<3>(6 * end + 3).cwiseAbs().maxCoeff() <= 1e-12 * size * std::max(arm, 1e-300)) {
          K.middleRows<3>(6 * end + 3).setZero();
          K.middleCols<3>(6 * end + 3).setZero();
        }
      return K;
    };
    FrameElement element{.nodes = {from.nodes[0], from.nodes[1]}, .K = matrix(k)};
    if (!c.isZero(0.0)) element.D = matrix(c);
    if (from.loss != 0.0) element.K_loss = from.loss * element.K;
    part.frames.push_back(std::move(element));
  }
}

}  // namespace flexura::reduce
