// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
//
// Standard input data of flexible members (Wallrapp 1993; Schwertassek and Wallrapp 1999), in the floating
// frame B: with r = x + phi_k s_k, in the equations [translation; rotation; deformation]
//
//     mdCM = int r dm                      J = int (r^T r 1 - r r^T) dm
//     Ct_j = int phi_j dm                  Cr_j = int r x phi_j dm           Me_jk = int phi_j . phi_k dm
//     Gr   = -2 int r~ phi~_j dm           (coefficient of s_j' omega, 3 x 3)
//     Ge_j = 2 int (phi_j x phi_i) dm      (row i: coefficient of s_j' omega)
//     Oe_i = int phi_i . (omega x (omega x r)) dm = sum_p Oe_ip Omega_p,  Omega = (xx, yy, zz, xy, yz, xz)
//
// each expanded to first order in s, Gr and Ge to zeroth. All are sums of the integrals of InertiaIntegrals,
// with S_phi, S_xphi, S_phiphi transformed to the shapes Y.
#include <fmt/format.h>

#include <cmath>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

namespace flexura::superelement {
namespace {

// S(a, b)(k, l) = integral of phi_k,a phi_l,b dm for all nine pairs, from the six that are stored.
using Pairs = std::array<std::array<Eigen::MatrixXd, 3>, 3>;

Pairs transform_pairs(const InertiaIntegrals& I, const Eigen::MatrixXd& Y) {
  constexpr int first[] = {0, 1, 2, 0, 1, 2}, second[] = {0, 1, 2, 1, 2, 0};
  Pairs S;
  for (std::size_t p = 0; p < 6; ++p) {
    const auto a = static_cast<std::size_t>(first[p]), b = static_cast<std::size_t>(second[p]);
    S[a][b] = Y.transpose() * I.S_phiphi[p] * Y;
    if (a != b) S[b][a] = S[a][b].transpose();
  }
  return S;
}

// The coefficients of omega_a omega_b in v . (omega x (omega x w)) = (v . omega)(w . omega) - (v . w)
// omega^2, given the 3 x 3 matrix A_ab = integral of v_a w_b dm.
Eigen::Matrix<double, 1, 6> centrifugal(const Eigen::Matrix3d& A) {
  Eigen::Matrix<double, 1, 6> c;
  const double trace = A.trace();
  c << A(0, 0) - trace, A(1, 1) - trace, A(2, 2) - trace, A(0, 1) + A(1, 0), A(1, 2) + A(2, 1),
      A(0, 2) + A(2, 0);
  return c;
}

// The vector of integral v x w dm, given A_ab = integral of v_a w_b dm.
Eigen::Vector3d cross(const Eigen::Matrix3d& A) {
  return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)};
}

}  // namespace

StandardInputData standard_input_data(const Superelement& se, const Eigen::MatrixXd& Y) {
  const InertiaIntegrals& I = se.inertia;
  const Eigen::Index m = Y.cols();
  const Eigen::Matrix3Xd S_phi = I.S_phi * Y;
  const Eigen::MatrixXd S_xphi = I.S_xphi * Y;
  const Pairs S = transform_pairs(I, Y);
  const auto x_phi = [&](Eigen::Index j) {  // A_ab = integral of x_a phi_j,b
    Eigen::Matrix3d A;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) A(a, b) = S_xphi(3 * a + b, j);
    }
    return A;
  };
  const auto phi_phi = [&](Eigen::Index k, Eigen::Index l) {
    Eigen::Matrix3d A;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) A(a, b) = S[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)](k, l);
    }
    return A;
  };

  StandardInputData sid;
  sid.mdCM_0 = I.S_x;
  sid.mdCM_1 = S_phi;
  sid.J_0 = I.S_xx.trace() * Eigen::Matrix3d::Identity() - I.S_xx;
  sid.Ct_0 = S_phi.transpose();
  sid.Cr_0.resize(m, 3);
  sid.Oe_0.resize(m, 6);
  sid.Me = S[0][0] + S[1][1] + S[2][2];
  sid.Ke = Y.transpose() * se.K_se * Y;
  sid.De = se.D_se.size() > 0 ? Eigen::MatrixXd(Y.transpose() * se.D_se * Y) : Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Eigen::Matrix3d A = x_phi(j), A_s = A + A.transpose();
    sid.J_1.push_back(A_s.trace() * Eigen::Matrix3d::Identity() - A_s);
    sid.Cr_0.row(j) = cross(A).transpose();
    // -2 x~ phi~ = 2 (x . phi 1 - phi x^T)
    sid.Gr_0.push_back(2 * (A.trace() * Eigen::Matrix3d::Identity() - A.transpose()));
    sid.Oe_0.row(j) = centrifugal(A);  // symmetric in its two arguments
    Eigen::MatrixXd Ge(m, 3), Cr_1(m, 3), Oe_1(m, 6);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Matrix3d A_ji = phi_phi(j, i);
      Ge.row(i) = 2 * cross(A_ji).transpose();
      Cr_1.row(i) = cross(A_ji).transpose();
      Oe_1.row(i) = centrifugal(A_ji);
    }
    sid.Ge_0.push_back(Ge);
    sid.Cr_1.push_back(Cr_1);
    sid.Oe_1.push_back(Oe_1);
    sid.Ct_1.push_back(Eigen::MatrixXd::Zero(m, 3));
  }
  // Geometric stiffening: the stiffness that acceleration a, angular acceleration and spin products add acts
  // on s like first-order terms of Ct, Cr and Oe.
  if (se.stiffening) {
    constexpr int order[] = {0, 1, 2, 3, 4, 5};  // xx, yy, zz, xy, yz, zx on both sides
    for (int c = 0; c < 6; ++c) {
      const auto column = static_cast<std::size_t>(c);
      const Eigen::MatrixXd K_omega = Y.transpose() * se.stiffening->K0omega[column] * Y;
      for (Eigen::Index k = 0; k < m; ++k)
        sid.Oe_1[static_cast<std::size_t>(k)].col(order[c]) += K_omega.col(k);
      if (c >= 3) continue;
      const Eigen::MatrixXd K_t = Y.transpose() * se.stiffening->K0t[column] * Y;
      const Eigen::MatrixXd K_r = Y.transpose() * se.stiffening->K0r[column] * Y;
      for (Eigen::Index k = 0; k < m; ++k) {
        sid.Ct_1[static_cast<std::size_t>(k)].col(c) += K_t.col(k);
        sid.Cr_1[static_cast<std::size_t>(k)].col(c) += K_r.col(k);
      }
    }
  }
  return sid;
}

namespace {

class SidText {
 public:
  explicit SidText(Eigen::Index n_modes) : m_(n_modes) {}

  template <typename... Args>
  void line(int indent, fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), "{:{}}", "", indent);
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
    out_.push_back('\n');
  }

  // M = M0 + sum_k M1[k] s_k.
  void taylor(int indent, const char* name, const Eigen::MatrixXd& M0,
              const std::vector<Eigen::MatrixXd>& M1) {
    bool has_first = false;
    for (const Eigen::MatrixXd& first : M1) has_first = has_first || !first.isZero(0.0);
    const bool zero = M0.isZero(0.0) && !has_first;
    line(indent, "{}", name);
    property(indent + 5, "order", has_first ? 1 : 0);
    property(indent + 5, "nrow", M0.rows());
    property(indent + 5, "ncol", M0.cols());
    property(indent + 5, "nq", m_);
    property(indent + 5, "nqn", 0);
    property(indent + 5, "structure", zero ? 0 : 3);
    for (Eigen::Index i = 0; i < M0.rows(); ++i) {
      for (Eigen::Index j = 0; j < M0.cols(); ++j) {
        if (M0(i, j) != 0.0) entry(indent + 5, fmt::format("m0( {}, {})", i + 1, j + 1), M0(i, j));
      }
    }
    if (has_first) {
      for (Eigen::Index j = 0; j < M0.cols(); ++j) {
        for (Eigen::Index i = 0; i < M0.rows(); ++i) {
          for (std::size_t k = 0; k < M1.size(); ++k) {
            if (M1[k](i, j) != 0.0)
              entry(indent + 5, fmt::format("m1( {}, {}, {})", i + 1, k + 1, j + 1), M1[k](i, j));
          }
        }
      }
    }
    line(indent, "end {}", name);
  }

  void entry(int indent, const std::string& name, double value) {
    std::string number = fmt::format("{:.14E}", value);
    number[number.find('E')] = 'D';
    line(indent, "{:<{}}={:>23}", name, 48 - indent, number);
  }
  void property(int indent, const char* name, Eigen::Index value) {
    line(indent, "{:<{}}={:5}", name, 48 - indent, value);
  }

  std::string_view text() const { return {out_.data(), out_.size()}; }

 private:
  Eigen::Index m_;
  fmt::memory_buffer out_;
};

// Rotations psi of a node with its directions, and first-order terms from K0F: a load on interface dof i does
// the virtual work ds^T K0F_i s, as if the shape there were phi_i + K0F_i s with the sign of a load instead
// of a stiffness.
void write_node(SidText& out, const Superelement& se, const Interface& interface, std::size_t number,
                const Eigen::MatrixXd& Y) {
  const Eigen::Index m = Y.cols();
  Eigen::MatrixXd phi, psi;
  std::vector<Eigen::MatrixXd> phi_1(static_cast<std::size_t>(m), Eigen::MatrixXd::Zero(3, m)), psi_1 = phi_1;
  const Eigen::MatrixXd motion = interface_motion(se, interface) * Y;
  phi = motion.topRows<3>();
  psi = motion.bottomRows<3>();
  for (std::size_t i = 0; i < interface.directions.size() && se.stiffening; ++i) {
    const int d = static_cast<int>(interface.directions[i]), dof = interface.first_dof + static_cast<int>(i);
    const Eigen::MatrixXd K_F = Y.transpose() * se.stiffening->K0F[static_cast<std::size_t>(dof)] * Y;
    for (std::size_t k = 0; k < static_cast<std::size_t>(m); ++k) {
      (d < 3 ? phi_1 : psi_1)[k].row(d % 3) = -K_F.col(static_cast<Eigen::Index>(k)).transpose();
    }
  }
  std::vector<Eigen::MatrixXd> origin_1, AP_1;
  for (Eigen::Index k = 0; k < m; ++k) {
    origin_1.emplace_back(phi.col(k));
    const Eigen::Vector3d t = psi.col(k);
    Eigen::MatrixXd skew(3, 3);
    skew << 0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0;
    AP_1.push_back(skew);
  }
  out.line(16, "new node                        ={:5}", number);
  out.line(21, "rframe                     = body ref");
  out.taylor(21, "origin", interface.p_BoN_B, origin_1);
  out.taylor(21, "phi", phi, phi_1);
  out.taylor(21, "psi", psi, psi_1);
  out.taylor(21, "AP", Eigen::Matrix3d::Identity(), AP_1);
  out.line(16, "end node");
}

}  // namespace

void write_sid(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  const Eigen::MatrixXd Y = exchange::elastic_shapes(se, modes);
  const Eigen::Index m = Y.cols();
  StandardInputData sid = standard_input_data(se, Y);
  for (Eigen::Index j = 0; j < m; ++j) {  // the modes' own damping, next to the dampers of D_se
    const Mode& mode = modes.modes[static_cast<std::size_t>(modes.n_rigid + j)];
    sid.De(j, j) += 2 * se.modal_damping * std::sqrt(mode.omega2) * sid.Me(j, j);
  }
  const auto six = [](const Eigen::Matrix3d& J) {
    Eigen::MatrixXd column(6, 1);
    column << J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2);
    return column;
  };
  const auto widened = [&](const auto& blocks, Eigen::Index rows) {
    Eigen::MatrixXd wide(rows, 3 * m);
    for (Eigen::Index j = 0; j < m; ++j) wide.middleCols(3 * j, 3) = blocks[static_cast<std::size_t>(j)];
    return wide;
  };

  SidText out(m);
  std::string name = se.name;
  for (char& c : name) c = static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  out.line(0, "{:5}{:5}    :No. nodes, No. modes: {}, by Flexura, SI", se.interfaces.size(), m, name);
  out.line(1, "part");
  out.line(6, "new modal                                 =");
  out.line(11, "refmod");
  out.entry(16, "mass", se.inertia.mass);
  out.property(16, "nelastq", m);
  for (Eigen::Index j = 0; j < m; ++j) {
    out.line(16, "{:<32}= Eigen Mode {:4} : {:12.3f} Hz", fmt::format("ielastq ({:4})", j + 1),
             modes.n_rigid + j + 1, modes.modes[static_cast<std::size_t>(modes.n_rigid + j)].frequency_hz);
  }
  out.line(11, "end refmod");
  out.line(11, "frame");
  for (std::size_t k = 0; k < se.interfaces.size(); ++k) write_node(out, se, se.interfaces[k], k + 1, Y);
  out.line(11, "end frame");
  std::vector<Eigen::MatrixXd> mdCM_1, J_1;
  for (Eigen::Index j = 0; j < m; ++j) {
    mdCM_1.emplace_back(sid.mdCM_1.col(j));
    J_1.push_back(six(sid.J_1[static_cast<std::size_t>(j)]));
  }
  out.taylor(11, "mdCM", sid.mdCM_0, mdCM_1);
  out.taylor(11, "J", six(sid.J_0), J_1);
  out.taylor(11, "Ct", sid.Ct_0, sid.Ct_1);
  out.taylor(11, "Cr", sid.Cr_0, sid.Cr_1);
  out.taylor(11, "Me", sid.Me, {});
  out.taylor(11, "Gr", widened(sid.Gr_0, 3), {});
  out.taylor(11, "Ge", widened(sid.Ge_0, m), {});
  out.taylor(11, "Oe", sid.Oe_0, sid.Oe_1);
  out.taylor(11, "ksigma", Eigen::MatrixXd::Zero(m, 1), {});
  out.taylor(11, "Ke", sid.Ke, {});
  out.taylor(11, "De", sid.De, {});
  out.line(6, "end modal");
  out.line(1, "end part");
  write_whole(path, out.text());
}

}  // namespace flexura::superelement
