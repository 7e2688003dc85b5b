// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
//
// The relations that hold between the parts of any superelement (theory: "Checks that always hold"). With
// R_t, R_r the rigid translations and rotations, R = [R_t R_r], and [e]x the cross-product matrix:
//
//     K_se R = 0
//     R_t,a^T M_se = S_phi(a, :),    R_r,c^T M_se = eps_cab S_xphi(3 a + b, :)
//     S_phi R_t = m 1,   eps_cab S_xphi(3 a + b, :) R_t,d = eps_cad S_x,a,   and R_r likewise with S_xx
//     S_phiphi,xx + S_phiphi,yy + S_phiphi,zz = M_se
//
// The last three compare numbers that took different roads from one mass matrix. Each is measured against its
// bound by Cauchy and Schwarz, |f^T M g| <= sqrt(f^T M f) sqrt(g^T M g), which gives every entry a scale of
// its own unit.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <set>

#include "mbs/superelement/checks.hpp"

namespace flexura::superelement {
namespace {

// The two roads differ by how well Psi R_b = R_i holds, the round-off of one solve with K_ii: 1e-10 for
// compact parts, up to 1e-8 for slender ones (condition of K_ii 1e8 and more). A lost element, a density or a
// unit gone wrong changes the first three digits. 1e-6 lies between.
constexpr double mass_tolerance = 1e-6;

// Symmetry and strain-free rigid motion are compared with the largest diagonal stiffness of the same unit (unit_sizes()). K_bb of the tied faces exceeds the body's own stiffness by length over element
// size, so round-off is at most 1e-12 of that scale; a wrong row shows at full size.
constexpr double stiffness_tolerance = 1e-8;

// Of sums of many terms, each known to 1e-16.
constexpr double kRoundOff = 1e-14;

constexpr int max_interfaces = 100'000;

class Check {
 public:
  explicit Check(const Superelement& se) : se_(se) {}

  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(fmt::format("superelement \"{}\": {}", se_.name, what));
  }

  void interfaces() const {
    if (se_.interfaces.empty())
      refuse("it has no interface; a body without interface cannot be joined to anything");
    if (se_.interfaces.size() > max_interfaces) refuse("it has more than 100000 interfaces");
    if (se_.n_b < 0 || se_.n_q < 0) refuse("its number of dofs is negative");
    std::set<std::string> names;
    int next = 0;
    for (const Interface& interface : se_.interfaces) {
      if (interface.name.empty()) refuse("an interface has no name");
      if (!names.insert(interface.name).second) {
        refuse(fmt::format("two interfaces are called \"{}\"; names must differ", interface.name));
      }
      if (!interface.p_BoN_B.allFinite())
        refuse(fmt::format("the position of \"{}\" is not finite", interface.name));
      if (interface.first_dof != next) {
        refuse(
            fmt::format("interface \"{}\" starts at column {}, {} is wanted: interfaces follow one another",
                        interface.name, interface.first_dof, next));
      }
      int last = -1;
      for (const Direction direction : interface.directions) {
        const int d = static_cast<int>(direction);
        if (d <= last || d > 5) {
          refuse(fmt::format("the directions of interface \"{}\" are not in the order u_x .. theta_z",
                             interface.name));
        }
        last = d;
      }
      next += static_cast<int>(interface.directions.size());
    }
    if (next != se_.n_b) {
      refuse(fmt::format("its interfaces have {} directions together, but n_b is {}", next, se_.n_b));
    }
    if (!std::isfinite(se_.modal_damping) || se_.modal_damping < 0.0) {
      refuse(fmt::format("its modal damping is {}, it must be at least 0", se_.modal_damping));
    }
  }

  // Rows of directions that are no dofs: of their size, and true to rigid motions.
  void following() const {
    for (const Interface& interface : se_.interfaces) {
      std::set<Direction> seen(interface.directions.begin(), interface.directions.end());
      rows_move_rigidly(interface, "follows", interface.following, interface.follow, seen);
      rows_move_rigidly(interface, "is free", interface.free, interface.free_motion, seen);
    }
  }

  void rows_move_rigidly(const Interface& interface, const char* how,
                         const std::vector<Direction>& directions, const Eigen::MatrixXd& rows,
                         std::set<Direction>& seen) const {
    const auto count = static_cast<Eigen::Index>(directions.size());
    if (count == 0 && rows.size() == 0) return;
    sized_and_finite(fmt::format("motion of {} that {}", interface.name, how).c_str(), rows, count, se_.n());
    Interface whole;
    whole.name = interface.name;
    whole.p_BoN_B = interface.p_BoN_B;
    for (const Direction d : directions) {
      if (static_cast<int>(d) > 5 || !seen.insert(d).second)
        refuse(fmt::format("a direction of interface \"{}\" is given twice", interface.name));
      whole.directions.push_back(d);
    }
    Superelement alone;
    alone.n_b = static_cast<int>(count);
    alone.interfaces = {whole};
    const Eigen::MatrixXd R = rigid_motions_about(se_, middle()), own = rigid_motions_about(alone, middle());
    // Each term of the sum is known to mass_tolerance, as rigid motions are known to M_se.
    const Eigen::MatrixXd apart = rows * R - own, terms = rows.cwiseAbs() * R.cwiseAbs() + own.cwiseAbs();
    for (Eigen::Index k = 0; k < count; ++k)
      for (int c = 0; c < 6; ++c)
        if (std::abs(apart(k, c)) > mass_tolerance * terms.row(k).maxCoeff())
          refuse(fmt::format(
              "a direction of interface \"{}\" that {} does not follow rigid motions: off by {:.2g}",
              interface.name, how, apart(k, c)));
  }

  template <typename Matrix>
  void sized_and_finite(const char* name, const Matrix& matrix, Eigen::Index rows,
                        Eigen::Index columns) const {
    if (matrix.rows() != rows || matrix.cols() != columns) {
      refuse(fmt::format("{} is {} x {}, {} x {} is wanted (n_b = {}, n_q = {})", name, matrix.rows(),
                         matrix.cols(), rows, columns, se_.n_b, se_.n_q));
    }
    if (matrix.allFinite()) return;
    for (Eigen::Index j = 0; j < columns; ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        if (!std::isfinite(matrix(i, j))) {
          refuse(fmt::format("{}({}, {}) is {}, not a finite number", name, i, j, matrix(i, j)));
        }
      }
    }
  }

  // |A_ij - A_ji| against sqrt(s_i s_j), where s is the largest diagonal entry of the dof's kind.
  void symmetric(const char* name, const Eigen::MatrixXd& A) const {
    const Eigen::VectorXd scale = unit_sizes(se_, A).cwiseSqrt();
    for (Eigen::Index j = 0; j < A.cols(); ++j) {
      // Three points in a plane hold nothing across it: zero stiffness comes out of a solve with either sign.
      if (A(j, j) < -stiffness_tolerance * scale[j] * scale[j])
        refuse(fmt::format("{}({}, {}) = {} is negative", name, j, j, A(j, j)));
      for (Eigen::Index i = j + 1; i < A.rows(); ++i) {
        if (std::abs(A(i, j) - A(j, i)) <= stiffness_tolerance * scale[i] * scale[j]) continue;
        refuse(fmt::format("{} is not symmetric: ({}, {}) is {} but ({}, {}) is {}", name, i, j, A(i, j), j,
                           i, A(j, i)));
      }
    }
  }

  void rigid_motions_are_strain_free() const {
    const Eigen::MatrixXd R = rigid_motions_about(se_, middle());
    const Eigen::VectorXd scale = unit_sizes(se_, se_.K_se).cwiseSqrt();
    static const char* const motion[] = {"translation along x", "translation along y", "translation along z",
                                         "rotation about x",    "rotation about y",    "rotation about z"};
    for (int c = 0; c < 6; ++c) {
      const double size =
          (scale.array() * R.col(c).array()).matrix().norm();  // sqrt(energy) if it were strain
      const Eigen::VectorXd force = se_.K_se * R.col(c);
      for (Eigen::Index i = 0; i < force.size(); ++i) {
        if (std::abs(force[i]) <= stiffness_tolerance * scale[i] * size) continue;
        refuse(fmt::format(
            "rigid {} strains the body: K_se R gives {:.3g} in row {} where round-off allows {:.1g}",
            motion[c], force[i], i, stiffness_tolerance * scale[i] * size));
      }
    }
  }

  void inertia_sizes() const {
    const InertiaIntegrals& I = se_.inertia;
    if (!std::isfinite(I.mass) || I.mass <= 0.0) {
      refuse(fmt::format("its mass is {} kg, it must be above 0", I.mass));
    }
    sized_and_finite("S_x", I.S_x, 3, 1);
    sized_and_finite("S_xx", I.S_xx, 3, 3);
    sized_and_finite("S_phi", I.S_phi, 3, se_.n());
    sized_and_finite("S_xphi", I.S_xphi, 9, se_.n());
    for (const Eigen::MatrixXd& S : I.S_phiphi) sized_and_finite("S_phiphi", S, se_.n(), se_.n());
    if ((I.S_xx - I.S_xx.transpose()).cwiseAbs().maxCoeff() > mass_tolerance * I.S_xx.cwiseAbs().maxCoeff()) {
      refuse("S_xx is not symmetric");
    }
  }

  void mass_matrix_and_integrals_agree() const {
    const InertiaIntegrals& I = se_.inertia;
    const Eigen::MatrixXd R = rigid_motions(se_);
    // W(c, k) = integral of r_c . phi_k dm, with r_c the c-th rigid motion.
    Eigen::MatrixXd W(6, se_.n());
    Eigen::Matrix<double, 6, 6> M_rr = Eigen::Matrix<double, 6, 6>::Zero();  // rigid mass matrix about Bo
    W.topRows<3>() = I.S_phi;
    for (int c = 0; c < 3; ++c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;  // e_c x x has the components x_a along b and -x_b along a
      W.row(3 + c) = I.S_xphi.row(3 * a + b) - I.S_xphi.row(3 * b + a);
      M_rr(c, c) = I.mass;
      M_rr(b, 3 + c) = M_rr(3 + c, b) = I.S_x[a];
      M_rr(a, 3 + c) = M_rr(3 + c, a) = -I.S_x[b];
    }
    M_rr.bottomRightCorner<3, 3>() = I.S_xx.trace() * Eigen::Matrix3d::Identity() - I.S_xx;

    const Eigen::MatrixXd W_M = R.transpose() * se_.M_se;
    static const char* const quantity[] = {"mass along x",    "mass along y",    "mass along z",
                                           "inertia about x", "inertia about y", "inertia about z"};
    const Eigen::Matrix<double, 6, 6> M_from_matrix = W_M * R;
    for (int c = 0; c < 6; ++c) {
      for (int d = c; d < 6; ++d) {
        const double bound = std::sqrt(std::max(M_rr(c, c), 0.0) * std::max(M_rr(d, d), 0.0));
        // Moments of inertia are differences of S_xx: of a slender body about its axis, small ones of large.
        const double round_off = c < 3 ? 0.0 : kRoundOff * I.S_xx.trace();
        if (std::abs(M_from_matrix(c, d) - M_rr(c, d)) <= mass_tolerance * bound + round_off) continue;
        refuse(c == d
                   ? fmt::format("{} is {:.9g} by M_se but {:.9g} by the inertia integrals", quantity[c],
                                 M_from_matrix(c, d), M_rr(c, d))
                   : fmt::format(
                         "M_se and the inertia integrals disagree on the coupling of {} and {} (mass centre, "
                         "products of inertia): {:.9g} and {:.9g}",
                         quantity[c], quantity[d], M_from_matrix(c, d), M_rr(c, d)));
      }
      for (Eigen::Index k = 0; k < se_.n(); ++k) {
        const double bound = std::sqrt(std::max(M_rr(c, c), 0.0) * se_.M_se(k, k));
        const double round_off = c < 3 ? 0.0 : kRoundOff * std::sqrt(I.S_xx.trace() * se_.M_se(k, k));
        if (std::abs(W_M(c, k) - W(c, k)) <= mass_tolerance * bound + round_off) continue;
        refuse(fmt::format("the integral {} of shape {} for rigid motion {} is {:.9g}, M_se gives {:.9g}",
                           c < 3 ? "S_phi" : "S_xphi", k, c, W(c, k), W_M(c, k)));
      }
    }
    for (Eigen::Index l = 0; l < se_.n(); ++l) {
      for (Eigen::Index k = 0; k < se_.n(); ++k) {
        const double sum = I.S_phiphi[0](k, l) + I.S_phiphi[1](k, l) + I.S_phiphi[2](k, l);
        const double bound = std::sqrt(se_.M_se(k, k) * se_.M_se(l, l));
        if (std::abs(sum - se_.M_se(k, l)) <= mass_tolerance * bound) continue;
        refuse(fmt::format("S_phiphi sums to {:.9g} at ({}, {}) where M_se is {:.9g}", sum, k, l,
                           se_.M_se(k, l)));
      }
    }
  }

  void surface(const Surface& s) const {
    const Eigen::Index n_v = s.vertices.rows();
    if (!s.vertices.allFinite()) refuse("a vertex of the surface is not finite");
    const auto in_range = [n_v](const auto& indices) {
      return indices.size() == 0 || (indices.minCoeff() >= 0 && indices.maxCoeff() < n_v);
    };
    if (!in_range(s.triangles))
      refuse(fmt::format("a triangle of the surface names a vertex beyond the {} there are", n_v));
    if (!in_range(s.edges))
      refuse(fmt::format("an edge of the surface names a vertex beyond the {} there are", n_v));
    if (!s.triangle_interface.empty() &&
        static_cast<Eigen::Index>(s.triangle_interface.size()) != s.triangles.rows()) {
      refuse(fmt::format("triangle_interface has {} entries for {} triangles", s.triangle_interface.size(),
                         s.triangles.rows()));
    }
    for (const std::int32_t i : s.triangle_interface) {
      if (i < -1 || i >= static_cast<std::int32_t>(se_.interfaces.size())) {
        refuse(fmt::format("triangle_interface names interface {}, there are {}", i, se_.interfaces.size()));
      }
    }
  }

  void nodes(const NodalMotions& nodes) const {
    const auto n_k = static_cast<Eigen::Index>(nodes.numbers.size());
    sized_and_finite("the positions of the nodes", nodes.positions, n_k, 3);
    sized_and_finite("the motions of the nodes", nodes.T, 6 * n_k, se_.n());
    if (nodes.rotations.size() != nodes.numbers.size() ||
        std::ranges::any_of(nodes.rotations, [](NodalMotions::Rotation r) {
          return r < NodalMotions::Rotation::unknown || r > NodalMotions::Rotation::curl;
        }))
      refuse("the kinds of the nodes' rotations do not fit the nodes");
  }

  void mesh_error(const MeshError& error, bool with_surface) const {
    const Eigen::Index n_v = with_surface ? se_.surface.vertices.rows() : std::numeric_limits<int>::max();
    const auto relative = [&](double value) {
      if (value != -1.0 && !(value >= 0.0 && value <= 1.0))
        refuse(fmt::format("an estimate of the mesh's error is {}, neither -1 (not known) nor from 0 to 1",
                           value));
    };
    const auto stress = [&](const MeshError::Stress& of) {
      relative(of.mean);
      relative(of.peak);
      if (of.vertex < -1 || of.vertex >= n_v)
        refuse(fmt::format("the estimate of the mesh's error names vertex {}, the surface has {}", of.vertex,
                           n_v));
    };
    for (const MeshError::Mode& mode : error.modes) {
      if (!std::isfinite(mode.frequency_hz)) refuse("a frequency whose error is estimated is not finite");
      relative(mode.error);
      stress(mode.stress);
    }
    for (const MeshError::Interface& interface : error.interfaces) {
      relative(interface.compliance_error);
      stress(interface.stress);
    }
    if (!error.at_vertices.allFinite() ||
        (with_surface && error.at_vertices.size() > 0 && error.at_vertices.size() != n_v))
      refuse(fmt::format(
          "the mesh's error has {} values on the surface's {} vertices, or one that is not finite",
          error.at_vertices.size(), n_v));
  }

  void stress(const StressModes& stress, bool with_surface) const {
    const auto n_s = static_cast<Eigen::Index>(stress.vertices.size());
    sized_and_finite("the stress modes", stress.S, 6 * n_s, se_.n());
    if (stress.of_loads.size() > 0)
      sized_and_finite("the stresses of load cases", stress.of_loads, 6 * n_s,
                       static_cast<Eigen::Index>(se_.load_cases.size()));
    if (stress.of_acceleration.size() > 0)
      sized_and_finite("the stresses of acceleration", stress.of_acceleration, 6 * n_s, 6 + se_.n_b);
    std::int32_t last = -1;
    if (!stress.compliance.empty()) {
      for (const auto& C : stress.compliance) sized_and_finite("the compliance", C, 6, 6);
      const auto n_materials = static_cast<std::int32_t>(stress.compliance.size());
      if (stress.material.size() != stress.vertices.size() ||
          std::ranges::any_of(stress.material, [&](std::int32_t k) { return k < 0 || k >= n_materials; }))
        refuse("the materials of the stress modes do not fit their places");
    }
    for (const std::int32_t vertex : stress.vertices) {
      if (vertex <= last) refuse("the vertices of the stress modes do not ascend");
      last = vertex;
    }
    if (with_surface && last >= se_.surface.vertices.rows()) {
      refuse(fmt::format("the stress modes name vertex {}, the surface has {}", last,
                         se_.surface.vertices.rows()));
    }
  }

  void sections(const SectionForces& sections) const {
    const auto n_p = static_cast<Eigen::Index>(sections.member.size());
    sized_and_finite("the positions of the section forces", sections.positions, n_p, 3);
    sized_and_finite("the axes of the section forces", sections.axes, n_p, 9);
    sized_and_finite("the section forces", sections.S, 6 * n_p, se_.n());
    if (sections.of_loads.size() > 0)
      sized_and_finite("the section forces of load cases", sections.of_loads, 6 * n_p,
                       static_cast<Eigen::Index>(se_.load_cases.size()));
    if (sections.of_acceleration.size() > 0) {
      sized_and_finite("the section forces of acceleration", sections.of_acceleration, 6 * n_p, 12);
      sized_and_finite("the section forces of accelerated deformation", sections.of_deformation, 6 * n_p,
                       9 * se_.n());
      sized_and_finite("the turning of the sections", sections.turning, 3 * n_p, se_.n());
      if (sections.of_stiffening.size() > 0)
        sized_and_finite("the section forces of tension", sections.of_stiffening, 6 * n_p,
                         (12 + se_.n_b + static_cast<Eigen::Index>(se_.load_cases.size())) * se_.n());
    }
    std::vector<std::int32_t> places(sections.members.size());
    std::int32_t last = 0;
    for (const std::int32_t member : sections.member) {
      if (member < 0 || member >= static_cast<std::int32_t>(sections.members.size())) {
        refuse(
            fmt::format("the section forces name member {}, there are {}", member, sections.members.size()));
      }
      if (member < last) refuse("the places of the section forces do not follow each other by members");
      last = member;
      ++places[static_cast<std::size_t>(member)];
    }
    const int wanted = sections.of_acceleration.size() > 0 ? 4 : 1;
    for (std::size_t m = 0; m < places.size(); ++m)
      if (places[m] < wanted)
        refuse(fmt::format("the section forces know {} places of member \"{}\", {} are wanted", places[m],
                           sections.members[m], wanted));
  }

 private:
  Eigen::Vector3d middle() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Interface& interface : se_.interfaces) sum += interface.p_BoN_B;
    return sum / static_cast<double>(se_.interfaces.size());
  }

  const Superelement& se_;
};

}  // namespace

void validate_parts(const Superelement& se, const Parts& present) {
  const Check check(se);
  const Eigen::Index n = se.n();
  check.interfaces();
  check.following();
  if (present.matrices) {
    check.sized_and_finite("K_se", se.K_se, n, n);
    check.sized_and_finite("M_se", se.M_se, n, n);
    check.sized_and_finite("omega2", se.omega2, se.n_q, 1);
    check.symmetric("K_se", se.K_se);
    check.symmetric("M_se", se.M_se);
    if (se.D_se.size() > 0) {
      check.sized_and_finite("D_se", se.D_se, n, n);
      check.symmetric("D_se", se.D_se);
    }
    check.rigid_motions_are_strain_free();
  }
  for (const LoadCase& load : se.load_cases) {
    if (load.name.empty()) check.refuse("a load case has no name");
    check.sized_and_finite(("load case " + load.name).c_str(), load.p_se, n, 1);
    if (load.moment.size() > 0 || se.load_cases.front().moment.size() > 0)
      check.sized_and_finite(("torque of load case " + load.name).c_str(), load.moment, 3, n);
  }
  if (present.inertia) check.inertia_sizes();
  if (present.matrices && present.inertia) check.mass_matrix_and_integrals_agree();
  if (present.stiffening && se.stiffening) {
    for (const auto& K : se.stiffening->K0t) check.sized_and_finite("K0t", K, n, n);
    for (const auto& K : se.stiffening->K0r) check.sized_and_finite("K0r", K, n, n);
    for (const auto& K : se.stiffening->K0omega) check.sized_and_finite("K0omega", K, n, n);
    for (const auto& K : se.stiffening->K0F) check.sized_and_finite("K0F", K, n, n);
    if (static_cast<int>(se.stiffening->K0F.size()) != se.n_b) {
      check.refuse(fmt::format("K0F has {} matrices, one for each of the {} interface dofs is wanted",
                               se.stiffening->K0F.size(), se.n_b));
    }
    for (const auto& K : se.stiffening->K0p) check.sized_and_finite("K0p", K, n, n);
    if (!se.stiffening->K0p.empty() && se.stiffening->K0p.size() != se.load_cases.size())
      check.refuse(fmt::format("K0p has {} matrices, one for each of the {} load cases is wanted",
                               se.stiffening->K0p.size(), se.load_cases.size()));
  }
  if (present.surface) check.surface(se.surface);
  if (present.shapes && se.shapes.size() > 0) {
    const Eigen::Index rows = present.surface ? 3 * se.surface.vertices.rows() : se.shapes.rows();
    check.sized_and_finite("shapes", se.shapes, rows, n);
  }
  if (present.stress && se.stress) check.stress(*se.stress, present.surface);
  if (present.sections && se.sections) check.sections(*se.sections);
  if (present.mesh_error && se.mesh_error) check.mesh_error(*se.mesh_error, present.surface);
  if (present.nodes && se.nodes) check.nodes(*se.nodes);
}

void validate(const Superelement& se) {
  validate_parts(se, {.matrices = true,
                      .inertia = true,
                      .stiffening = true,
                      .surface = true,
                      .shapes = true,
                      .stress = true,
                      .sections = true,
                      .mesh_error = true,
                      .nodes = true});
}

}  // namespace flexura::superelement
