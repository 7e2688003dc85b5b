// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every part that brings damping along (a matrix, materials, dampers), all of whose modes are kept: a mechanism of it has the
// eigenvalues of the full model, whose matrices are put together here.
#include <Eigen/QR>
#include <cmath>

#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/properties/quadratic_problem.hpp"

namespace flexura::properties {
namespace {

// A part of N points with three directions each.
struct FullModel {
  std::vector<Vector3d> x;
  MatrixXd K, M, D, K_loss;
};

MatrixXd rigid(const FullModel& full) {
  MatrixXd R(3 * static_cast<Index>(full.x.size()), 6);
  for (std::size_t k = 0; k < full.x.size(); ++k) {
    const auto row = 3 * static_cast<Index>(k);
    R.middleRows<3>(row).leftCols<3>().setIdentity();
    for (int a = 0; a < 3; ++a) R.block<3, 1>(row, 3 + a) = Vector3d::Unit(a).cross(full.x[k]);
  }
  return R;
}

// D without what resists rigid motion, and with loss factors as viscous damping at the free part's modes.
MatrixXd whole_damping(const FullModel& full) {
  const MatrixXd R = rigid(full), MR = full.M * R;
  const MatrixXd P = MatrixXd::Identity(full.M.rows(), full.M.cols()) -
                     R * (R.transpose() * MR).ldlt().solve(MR.transpose());
  MatrixXd D = P.transpose() * full.D * P;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(full.K, full.M);
  const Index n = full.K.rows() - 6;
  const MatrixXd Y = modes.eigenvectors().rightCols(n);
  const VectorXd omega = modes.eigenvalues().tail(n).cwiseSqrt();
  const VectorXd share = omega.cwiseSqrt().cwiseInverse();
  D += full.M * Y * share.asDiagonal() * (Y.transpose() * full.K_loss * Y) * share.asDiagonal() *
       Y.transpose() * full.M;
  return D;
}

// As those of expect_same() take it.
Superelement as_superelement(const FullModel& full) {
  Superelement se;
  se.n_q = static_cast<int>(full.K.rows());
  se.K_se = full.K;
  se.M_se = full.M;
  se.D_se = whole_damping(full);
  return se;
}

FullModel random_points(Chance& chance) {
  FullModel full;
  const int n = 5 + chance.below(4);
  for (int k = 0; k < n; ++k) full.x.push_back(chance.vector(1.0));
  full.K = MatrixXd::Zero(3 * n, 3 * n);
  full.M = full.D = full.K_loss = full.K;
  return full;
}

// X += c e e^T between two points, e along their line.
void join(const FullModel& full, std::size_t a, std::size_t b, double c, MatrixXd& X) {
  VectorXd q = VectorXd::Zero(X.rows());
  const Vector3d e = (full.x[b] - full.x[a]).normalized();
  q.segment<3>(3 * static_cast<Index>(a)) = -e;
  q.segment<3>(3 * static_cast<Index>(b)) = e;
  X += c * q * q.transpose();
}

std::string market(const MatrixXd& A) {
  std::string entries;
  int count = 0;
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = j; i < A.rows(); ++i)
      if (A(i, j) != 0.0) {
        entries += fmt::format("{} {} {:.17g}\n", i + 1, j + 1, A(i, j));
        ++count;
      }
  return fmt::format("%%MatrixMarket matrix coordinate real symmetric\n{} {} {}\n{}", A.rows(), A.cols(),
                     count, entries);
}

constexpr const char* kInterface =
    "[interface.i0]\nby = \"nodes\"\nnodes = [1, 2, 3, 4]\ntie = \"average\"\n[modes]\ncount = 500\n";

void expect_full_eigenvalues(Chance& chance, const test::Folder& folder, const FullModel& full,
                             const std::string& part) {
  SCOPED_TRACE(part);
  const auto reduced = reduce::reduce(reduce::read_part(folder.write("part.toml", part)));
  ASSERT_EQ(reduced.superelement.n(), full.K.rows());
  EXPECT_EQ(reduced.superelement.modal_damping, 0.0);
  const Case c = make_case(chance, folder, reduced.superelement, "", kJoints[6]);
  EXPECT_STREQ(c.joint->type, "six_dof");
  expect_same(c.found, as_superelement(full),
              [](const Superelement& se) { return right(se, se.D_se, MatrixXd(0, se.n())); });
}

// Springs, masses, dampers, and damping in proportion to the mass, which resists rigid motion.
FullModel random_lattice(Chance& chance) {
  FullModel full = random_points(chance);
  for (std::size_t a = 0; a < full.x.size(); ++a) {
    const auto row = 3 * static_cast<Index>(a);
    full.M.block<3, 3>(row, row).diagonal().setConstant(chance.between(0.5, 5.0));
    for (std::size_t b = 0; b < a; ++b) {
      join(full, a, b, chance.between(1e4, 1e6), full.K);
      if (chance.flip(0.4)) join(full, a, b, std::pow(10.0, chance.between(0.0, 3.0)), full.D);
    }
  }
  if (chance.flip(0.5)) full.D += chance.between(0.1, 10.0) * full.M;
  return full;
}

TEST(PartDamping, OfAMatrixIsThatOfTheFullModel) {
  const test::Folder folder;
  for (int seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const FullModel full = random_lattice(chance);
    std::string nodes;
    for (std::size_t k = 0; k < full.x.size(); ++k)
      nodes +=
          fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", k + 1, full.x[k].x(), full.x[k].y(), full.x[k].z());
    folder.write("nodes.csv", nodes);
    folder.write("K.mtx", market(full.K));
    folder.write("M.mtx", market(full.M));
    folder.write("D.mtx", market(full.D));
    std::string text = "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n";
    if (chance.flip(0.5)) {
      text += "[matrices]\nstiffness = \"K.mtx\"\nmass = \"M.mtx\"\ndamping = \"D.mtx\"\n";
      expect_full_eigenvalues(chance, folder, full, text + kInterface);
    } else {  // vectors that span everything
      MatrixXd V(full.K.rows(), full.K.cols());
      for (double& v : V.reshaped()) v = chance.between(-1.0, 1.0);
      const auto dense = [](const MatrixXd& A) {
        std::string out;
        for (Index i = 0; i < A.rows(); ++i) {
          for (Index j = 0; j < A.cols(); ++j) out += fmt::format("{:.17g} ", A(i, j));
          out += "\n";
        }
        return out;
      };
      V = MatrixXd(V.householderQr().householderQ());  // well apart
      const auto reduced_by_V = [&](const MatrixXd& X) { return dense(V.transpose() * X * V); };
      folder.write("V.txt", dense(V));
      folder.write("KV.txt", reduced_by_V(full.K));
      folder.write("DV.txt", reduced_by_V(full.D));
      text +=
          "[mode_vectors]\nvectors = \"V.txt\"\nstiffness = \"KV.txt\"\nmass = \"M.mtx\"\ndamping = "
          "\"DV.txt\"\n";
      std::string interface = kInterface;
      interface.resize(interface.find("[modes]"));
      expect_full_eigenvalues(chance, folder, full, text + interface);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Rods between all points, of materials with damping of their own, dampers and point masses.
TEST(PartDamping, OfDecksIsThatOfTheFullModel) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const bool nastran = chance.flip(0.5);
    FullModel full = random_points(chance);
    const int n_materials = 1 + chance.below(3);
    struct Own {
      double E, rho, alpha = 0.0, beta = 0.0, loss = 0.0;
    };
    std::vector<Own> materials;
    const double G = nastran && chance.flip(0.5) ? chance.between(0.001, 0.1) : 0.0,
                 alpha = nastran && chance.flip(0.3) ? chance.between(0.1, 10.0) : 0.0,
                 beta = nastran && chance.flip(0.3) ? chance.between(1e-6, 1e-4) : 0.0;
    std::string deck = nastran ? "BEGIN BULK\n" : "*NODE\n", cards;
    for (std::size_t k = 0; k < full.x.size(); ++k) {
      for (double& c : full.x[k]) c = std::round(1e6 * c) / 1e6;  // fields of 16
      deck += nastran ? fmt::format("GRID,{},,{:.8f},{:.8f},{:.8f}\n", k + 1, full.x[k].x(), full.x[k].y(),
                                    full.x[k].z())
                      : fmt::format("{}, {:.8f}, {:.8f}, {:.8f}\n", k + 1, full.x[k].x(), full.x[k].y(),
                                    full.x[k].z());
    }
    const double area = 1e-4;
    for (int m = 0; m < n_materials; ++m) {
      Own own{chance.between(50.0, 250.0) * 1e9, chance.between(1000.0, 8000.0)};
      own.E = std::round(own.E / 1e6) * 1e6, own.rho = std::round(own.rho);
      if (!nastran && chance.flip(0.6)) own.alpha = std::round(1e3 * chance.between(0.1, 10.0)) / 1e3;
      if (!nastran && chance.flip(0.6)) own.beta = std::round(1e9 * chance.between(1e-6, 1e-4)) / 1e9;
      if (chance.flip(0.5)) own.loss = std::round(1e6 * chance.between(0.001, 0.1)) / 1e6;
      materials.push_back(own);
      if (nastran)
        cards += fmt::format("MAT1,{},{:.6e},,0.3,{:.1f},,,{:.6f}\n", m + 1, own.E, own.rho, own.loss) +
                 fmt::format("PROD,{},{},{:.4e},0.\n", m + 1, m + 1, area);
      else
        cards += fmt::format(
            "*MATERIAL, NAME=M{}\n*ELASTIC\n{:.6e}, 0.3\n*DENSITY\n{:.1f}\n*DAMPING, ALPHA={:.17g}, "
            "BETA={:.17g}, STRUCTURAL={:.17g}\n*SOLID SECTION, ELSET=E{}, MATERIAL=M{}\n{:.4e}\n",
            m, own.E, own.rho, own.alpha, own.beta, own.loss, m, m, area);
    }
    int label = 0;
    std::string dampers;
    for (std::size_t a = 0; a < full.x.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        const int m = chance.below(n_materials);
        const Own& own = materials[static_cast<std::size_t>(m)];
        deck += nastran
                    ? fmt::format("CROD,{},{},{},{}\n", ++label, m + 1, a + 1, b + 1)
                    : fmt::format("*ELEMENT, TYPE=T3D2, ELSET=E{}\n{}, {}, {}\n", m, ++label, a + 1, b + 1);
        const double l = (full.x[a] - full.x[b]).norm(), k = own.E * area / l, mass = own.rho * area * l;
        join(full, a, b, k, full.K);
        join(full, a, b, (own.beta + beta) * k, full.D);
        join(full, a, b, (own.loss + G) * k, full.K_loss);
        // Consistent: mass/6 (2, 1; 1, 2) in each direction.
        const auto A = 3 * static_cast<Index>(a), B = 3 * static_cast<Index>(b);
        for (int d = 0; d < 3; ++d)
          for (MatrixXd* X : {&full.M, &full.D}) {
            const double c = X == &full.M ? mass / 6.0 : (own.alpha + alpha) * mass / 6.0;
            (*X)(A + d, A + d) += 2.0 * c, (*X)(B + d, B + d) += 2.0 * c;
            (*X)(A + d, B + d) += c, (*X)(B + d, A + d) += c;
          }
        if (!chance.flip(0.2)) continue;
        const double c = std::round(std::pow(10.0, chance.between(0.0, 3.0)));
        join(full, a, b, c, full.D);
        ++label;
        dampers +=
            nastran
                ? fmt::format("CVISC,{},{},{},{}\nPVISC,{},{:.1f}\n", label, label, a + 1, b + 1, label, c)
                : fmt::format(
                      "*ELEMENT, TYPE=DASHPOTA, ELSET=D{}\n{}, {}, {}\n*DASHPOT, ELSET=D{}\n\n{:.1f}\n",
                      label, label, a + 1, b + 1, label, c);
      }
    for (std::size_t a = 0; a < full.x.size(); ++a) {  // point masses
      if (!chance.flip(0.2)) continue;
      const double mass = std::round(1e3 * chance.between(0.1, 2.0)) / 1e3,
                   own = nastran ? alpha : std::round(1e3 * chance.between(0.1, 10.0)) / 1e3;
      const auto A = 3 * static_cast<Index>(a);
      full.M.block<3, 3>(A, A).diagonal().array() += mass;
      full.D.block<3, 3>(A, A).diagonal().array() += own * mass;
      ++label;
      dampers += nastran
                     ? fmt::format("CONM2,{},{},,{:.3f}\n", label, a + 1, mass)
                     : fmt::format(
                           "*ELEMENT, TYPE=MASS, ELSET=P{}\n{}, {}\n*MASS, ELSET=P{}, ALPHA={:.3f}\n{:.3f}\n",
                           label, label, a + 1, label, own, mass);
    }
    if (nastran) {
      if (G > 0.0) cards += fmt::format("PARAM,G,{:.17g}\n", G);
      if (alpha > 0.0) cards += fmt::format("PARAM,ALPHA1,{:.17g}\n", alpha);
      if (beta > 0.0) cards += fmt::format("PARAM,ALPHA2,{:.17g}\n", beta);
    }
    deck += dampers + cards + (nastran ? "ENDDATA\n" : "");
    const std::string name = nastran ? "part.bdf" : "part.inp";
    folder.write(name, deck);
    SCOPED_TRACE(deck);
    const bool damps = whole_damping(full).norm() > 0.0;
    std::string text = fmt::format("[geometry]\nfile = \"{}\"\nunit = \"m\"\n", name) + kInterface;
    if (!damps || full.D.isZero(0.0) || dampers.size() > 0) text += "damping = 0.0\n";
    expect_full_eigenvalues(chance, folder, full, text);
    if (testing::Test::HasFailure()) return;
  }
}

// Bricks, sheets and beams of one material: alpha M + beta K without rigid motion's share, by M_se and K_se themselves.
TEST(PartDamping, OfOneMaterialIsRayleighs) {
  const test::Folder folder;
  for (int seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const double alpha = chance.flip(0.3) ? 0.0 : chance.between(0.1, 10.0),
                 beta = chance.between(1e-6, 1e-4);
    const char* const types[] = {"C3D8", "C3D8I", "C3D8R", "S4", "B31"};
    const std::string type = chance.one_of(types);
    const int n = 2 + chance.below(4),
              across = type[0] == 'C'   ? 3
                       : type[0] == 'S' ? 3
                                        : 1,
              up = type[0] == 'C' ? 2 : 1;
    const auto label = [&](int i, int j, int k) { return 1 + (i * across + j) * up + k; };
    std::string deck = "*NODE\n", ends[2];
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < across; ++j)
        for (int k = 0; k < up; ++k) {
          deck += fmt::format("{}, {:.6f}, {:.6f}, {:.6f}\n", label(i, j, k), 0.1 * i, 0.05 * j, 0.03 * k);
          if (i == 0 || i == n)
            ends[i == n] += fmt::format("{}{}", ends[i == n].empty() ? "" : ", ", label(i, j, k));
        }
    deck += fmt::format("*ELEMENT, TYPE={}, ELSET=ALL\n", type);
    int element = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < std::max(1, across - 1); ++j) {
        if (type[0] == 'B')
          deck += fmt::format("{}, {}, {}\n", ++element, label(i, 0, 0), label(i + 1, 0, 0));
        else if (type[0] == 'S')
          deck += fmt::format("{}, {}, {}, {}, {}\n", ++element, label(i, j, 0), label(i + 1, j, 0),
                              label(i + 1, j + 1, 0), label(i, j + 1, 0));
        else
          deck += fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", ++element, label(i, j, 0),
                              label(i + 1, j, 0), label(i + 1, j + 1, 0), label(i, j + 1, 0), label(i, j, 1),
                              label(i + 1, j, 1), label(i + 1, j + 1, 1), label(i, j + 1, 1));
      }
    deck += type[0] == 'B'   ? "*BEAM SECTION, SECTION=RECT, ELSET=ALL, MATERIAL=M\n0.02, 0.01\n0., 0., -1.\n"
            : type[0] == 'S' ? fmt::format("*SHELL SECTION, ELSET=ALL, MATERIAL=M{}\n0.004\n",
                                           chance.flip(0.5) ? ", OFFSET=0.3" : "")
                             : std::string("*SOLID SECTION, ELSET=ALL, MATERIAL=M\n");
    deck += fmt::format(
        "*MATERIAL, NAME=M\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n*DAMPING, ALPHA={:.17g}, BETA={:.17g}\n",
        alpha, beta);
    folder.write("part.inp", deck);
    std::string text = fmt::format(
        "[geometry]\nfile = \"part.inp\"\nunit = \"m\"\n[interface.a]\nby = \"nodes\"\nnodes = "
        "[{}]\n[interface.b]\nby = "
        "\"nodes\"\nnodes = [{}]\ntie = \"{}\"\n[modes]\ncount = {}\n",
        ends[0], ends[1], type[0] != 'C' || chance.flip(0.5) ? "rigid" : "average", chance.below(12));
    // Far above all modes: the material's own damping holds below, and no ratio comes to it.
    if (chance.flip(0.3)) text += "[damping]\ncritical_above = \"1e9 Hz\"\n";
    SCOPED_TRACE(deck + text);
    const Superelement se = reduce::reduce(reduce::read_part(folder.write("part.toml", text))).superelement;
    ASSERT_EQ(se.D_se.rows(), se.n());
    EXPECT_EQ(se.modal_damping, 0.0);
    const MatrixXd R = superelement::rigid_motions(se), MR = se.M_se * R;
    const MatrixXd P =
        MatrixXd::Identity(se.n(), se.n()) - R * (R.transpose() * MR).ldlt().solve(MR.transpose());
    const MatrixXd D = alpha * P.transpose() * se.M_se * P + beta * se.K_se;
    const VectorXd size = D.diagonal().cwiseSqrt().cwiseMax(1e-12 * D.diagonal().maxCoeff());
    for (Index i = 0; i < se.n(); ++i)
      for (Index j = 0; j < se.n(); ++j)
        // Sums of elements against products of sums: round-off of stiffness that cancels, 1e-16 times its spread of 1e6.
        EXPECT_NEAR(se.D_se(i, j), D(i, j), 1e-9 * size(i) * size(j) + 1e-12 * D.cwiseAbs().maxCoeff());
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
