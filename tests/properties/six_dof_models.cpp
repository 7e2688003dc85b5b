// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/properties/six_dof_models.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/part/make_part.hpp"

namespace flexura::properties {
namespace {

// Motion (u, theta) at p that follows a node; 6 x 6, of nodes that do not turn the displacement at the node itself.
Eigen::Matrix<double, 6, 6> carried(const Model& model, std::size_t a, const Vector3d& p) {
  Eigen::Matrix<double, 6, 6> C = Eigen::Matrix<double, 6, 6>::Zero();
  C.topLeftCorner<3, 3>().setIdentity();
  if (model.turns[a] == 0) return C;
  C.bottomRightCorner<3, 3>().setIdentity();
  for (int d = 0; d < 3; ++d) C.block<3, 1>(0, 3 + d) = Vector3d::Unit(d).cross(p - model.x[a]);
  return C;
}

// Adds springs between two nodes: of their relative motion at a place of nodes that turn, displacements alone otherwise.
void join(const Model& model, std::size_t a, std::size_t b, Chance& chance, double size, MatrixXd& X) {
  if (model.turns[a] == 0 && model.turns[b] == 0) return;
  const bool all = model.turns[a] != 0 && model.turns[b] != 0;
  const Vector3d p = model.turns[a] == 0   ? model.x[a]
                     : model.turns[b] == 0 ? model.x[b]
                                           : Vector3d(0.5 * (model.x[a] + model.x[b]) + chance.vector(0.1));
  MatrixXd B = MatrixXd::Zero(all ? 6 : 3, X.rows());
  B.middleCols<6>(6 * static_cast<Index>(a)) = -carried(model, a, p).topRows(B.rows());
  B.middleCols<6>(6 * static_cast<Index>(b)) = carried(model, b, p).topRows(B.rows());
  MatrixXd F(B.rows(), B.rows());
  for (double& f : F.reshaped()) f = chance.between(-1.0, 1.0);
  X += size * B.transpose() * (F * F.transpose() + 0.3 * MatrixXd::Identity(F.rows(), F.cols())) * B;
}

// Mass in places that follow up to three nodes by shares that add up to 1: consistent, with rotary inertia and offsets.
void add_mass(Model& model, Chance& chance) {
  const Index n = model.n();
  const auto point = [&](const Vector3d& p, double w,
                         const std::vector<std::pair<std::size_t, double>>& from) {
    MatrixXd C = MatrixXd::Zero(3, 6 * n);
    for (const auto& [node, share] : from)
      C.middleCols<6>(6 * static_cast<Index>(node)) += share * carried(model, node, p).topRows<3>();
    model.M += w * C.transpose() * C;
    model.mass += w;
    model.S_x += w * p;
    model.S_xx += w * p * p.transpose();
  };
  for (std::size_t a = 0; a < model.x.size(); ++a) {
    if (model.turns[a] == 0) {
      point(model.x[a], chance.between(0.5, 2.0), {{a, 1.0}});
      continue;
    }
    for (int k = 0; k < 4; ++k) point(model.x[a] + chance.vector(0.2), chance.between(0.2, 1.0), {{a, 1.0}});
  }
  for (int k = chance.below(6); k > 0; --k) {
    std::vector<std::pair<std::size_t, double>> from;
    double whole = 0.0;
    for (std::size_t a = 0; a < model.x.size() && from.size() < 3; ++a)
      if (model.turns[a] != 0 && chance.flip(0.5)) from.emplace_back(a, chance.between(0.1, 1.0));
    for (const auto& [node, share] : from) whole += share;
    for (auto& [node, share] : from) share /= whole;
    if (!from.empty()) point(chance.vector(1.0), chance.between(0.2, 1.0), from);
  }
}

std::string dmig_number(double value, bool small) {
  std::string text = small ? fmt::format("{:.2E}", value) : fmt::format("{:.9E}", value);
  const auto e = text.find('E');
  if (small) return text.substr(0, e) + text.substr(e + 1);  // "1.23+05"
  text[e] = 'D';
  return text;
}

}  // namespace

Model random_model(Chance& chance) {
  Model model;
  const int n = 2 + chance.below(4);
  std::int64_t label = 0;
  for (int k = 0; k < n; ++k) {
    model.x.push_back(chance.vector(1.0));
    model.label.push_back(label += 1 + chance.below(9));
    model.turns.push_back(k < 2 || chance.flip(0.7));
  }
  model.K = model.M = model.D = MatrixXd::Zero(6 * n, 6 * n);
  for (std::size_t b = 1; b < model.x.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (a > 0 && chance.flip(0.4)) continue;  // all hang on the first
      join(model, a, b, chance, 1e5, model.K);
      if (chance.flip(0.5)) join(model, a, b, chance, 10.0, model.D);
    }
  add_mass(model, chance);
  return model;
}

std::string written(const Model& model, const MatrixXd& A, Format format, const char* name, Chance& chance) {
  const bool both = chance.flip(0.3), upper = chance.flip(0.5);
  const auto wanted = [&](Index i, Index j) { return A(i, j) != 0.0 && (both || (upper ? i <= j : i >= j)); };
  const auto label = [&](Index i) { return model.label[static_cast<std::size_t>(i / 6)]; };
  std::string text;
  int count = 0;
  if (format == Format::small || format == Format::large || format == Format::free) {
    const bool free = format == Format::free, small = format == Format::small;
    const int form = both ? 1 : 6;
    text = "$TITLE   = A CAR BODY\n$SUBTITLE=\n";
    text += free    ? fmt::format("DMIG,{},0,{},2,0\n", name, form)
            : small ? fmt::format("{:<8}{:<8}{:>8}{:>8}{:>8}\n", "DMIG", name, 0, form, 1)
                    : fmt::format("{:<8}{:<16}{:>16}{:>16}{:>16}\n*       {:>16}\n", "DMIG*", name, 0, form,
                                  2, 0);
    for (Index j = 0; j < A.cols(); ++j) {
      bool open = false, half = false;
      for (Index i = 0; i < A.rows(); ++i) {
        if (!wanted(i, j)) continue;
        const std::string value = free ? fmt::format("{:.17g}", A(i, j)) : dmig_number(A(i, j), small);
        if (free) {
          text += open ? fmt::format(",{},{},{}\n", label(i), i % 6 + 1, value)
                       : fmt::format("DMIG,{},{},{},,{},{},{}\n", name, label(j), j % 6 + 1, label(i),
                                     i % 6 + 1, value);
        } else if (small) {
          // Two rows of the matrix a line once the column is open.
          text += open ? (half ? "" : fmt::format("{:<8}", "+")) + fmt::format("{:>8}{:>8}{:>8}{:>8}{}",
                                                                               label(i), i % 6 + 1, value, "",
                                                                               half ? "\n" : "")
                       : fmt::format("{:<8}{:<8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}\n", "DMIG", name, label(j),
                                     j % 6 + 1, "", label(i), i % 6 + 1, value);
          half = open && !half;
        } else {
          if (!open) text += fmt::format("{:<8}{:<16}{:>16}{:>16}\n", "DMIG*", name, label(j), j % 6 + 1);
          text += fmt::format("{:<8}{:>16}{:>16}{:>16}\n", "*", label(i), i % 6 + 1, value);
        }
        open = true;
      }
      if (half) text += "\n";
    }
    return text;
  }
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < A.rows(); ++i) {
      if (!wanted(i, j)) continue;
      ++count;
      text += format == Format::nodes ? fmt::format("{}, {}, {}, {}, {:.17g}\n", label(i), i % 6 + 1,
                                                    label(j), j % 6 + 1, A(i, j))
                                      : fmt::format("{} {} {:.17g}\n", i + 1, j + 1, A(i, j));
    }
  if (format == Format::market)
    text = fmt::format("%%MatrixMarket matrix coordinate real {}\n{} {} {}\n", both ? "general" : "symmetric",
                       A.rows(), A.cols(), count) +
           text;
  return text;
}

std::string dense(const MatrixXd& A) {
  std::string out;
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < A.cols(); ++j) out += fmt::format("{:.17g} ", A(i, j));
    out += "\n";
  }
  return out;
}

MatrixXd in_units(const MatrixXd& A, double length, double mass) {
  MatrixXd out = A / mass;
  for (Index i = 0; i < A.rows(); ++i)
    for (Index j = 0; j < A.cols(); ++j) out(i, j) /= (i % 6 < 3 ? 1.0 : length) * (j % 6 < 3 ? 1.0 : length);
  return out;
}

std::string table_of_nodes(const Model& model, double length) {
  std::string text;
  for (std::size_t k = 0; k < model.x.size(); ++k)
    text += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", model.label[k], model.x[k].x() / length,
                        model.x[k].y() / length, model.x[k].z() / length);
  return text;
}

VectorXd eigenvalues(const MatrixXd& A, const MatrixXd& B) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(A, B, Eigen::EigenvaluesOnly).eigenvalues();
}

void expect_close(const VectorXd& found, const VectorXd& right, double tolerance, const char* what) {
  ASSERT_EQ(found.size(), right.size()) << what;
  const double size = right.cwiseAbs().maxCoeff();
  for (Index k = 0; k < found.size(); ++k)
    EXPECT_NEAR(found(k), right(k), tolerance * std::max(std::abs(right(k)), 1e-5 * size))
        << what << " " << k;
}

std::string random_sheet(Chance& chance, int n, int across) {
  std::string deck = "*NODE\n";
  const auto label = [&](int i, int j) { return 1 + 2 * (i * across + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < across; ++j)
      deck += fmt::format("{}, {:.6f}, {:.6f}, {:.6f}\n", label(i, j), 0.1 * i + chance.between(-0.02, 0.02),
                          0.08 * j + chance.between(-0.01, 0.01), chance.between(-0.02, 0.02));
  std::string quads = "*ELEMENT, TYPE=S4, ELSET=ALL\n", triangles = "*ELEMENT, TYPE=S3, ELSET=ALL\n";
  int element = 0;
  bool split = false;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j + 1 < across; ++j) {
      if (chance.flip(0.3)) {
        triangles +=
            fmt::format("{}, {}, {}, {}\n", element + 3, label(i, j), label(i + 1, j), label(i + 1, j + 1));
        triangles +=
            fmt::format("{}, {}, {}, {}\n", element + 7, label(i, j), label(i + 1, j + 1), label(i, j + 1));
        split = true;
      } else {
        quads += fmt::format("{}, {}, {}, {}, {}\n", element + 5, label(i, j), label(i + 1, j),
                             label(i + 1, j + 1), label(i, j + 1));
      }
      element += 10;
    }
  deck += quads + (split ? triangles : "");
  deck +=
      fmt::format("*SHELL SECTION, ELSET=ALL, MATERIAL=M{}\n0.004\n", chance.flip(0.5) ? ", OFFSET=0.3" : "");
  return deck + "*MATERIAL, NAME=M\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n";
}

Model full_model(const reduce::PartInput& input) {
  reduce::ModelledPart modelled = make_part(input, reduce::load_part_mesh(input, {}));
  reduce::Part& part = modelled.part;
  part.interfaces.clear();
  reduce::AssemblyOptions options;
  options.may_be_free = true;
  const reduce::TiedModel full(part, options);
  const Index n_i = full.n_i();
  MatrixXd M;
  full.multiply_M(MatrixXd::Identity(n_i, n_i), M);
  MatrixXd K;
  full.multiply_K(MatrixXd::Identity(n_i, n_i), K);
  Model model;
  std::vector<Index> row, dof;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    if (full.numbering().follows(node)) continue;
    const Index at = 6 * model.n();
    model.x.emplace_back(part.mesh.points.row(node));
    model.label.push_back(part.mesh.node_label[static_cast<std::size_t>(node)]);
    const int turning = full.numbering().rotation_of(node);
    model.turns.push_back(turning >= 0);
    for (int d = 0; d < 3; ++d) {
      row.push_back(at + d), dof.push_back(full.numbering().code(node, d));
      if (turning >= 0)
        row.push_back(at + 3 + d),
            dof.push_back(full.numbering().rotation_code(turning)[static_cast<std::size_t>(d)]);
    }
  }
  model.K = model.M = model.D = MatrixXd::Zero(6 * model.n(), 6 * model.n());
  model.K(row, row) = K(dof, dof);
  model.M(row, row) = 0.5 * (M(dof, dof) + M(dof, dof).transpose());
  return model;
}

}  // namespace flexura::properties
