// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/benchmarks/mesh_truth.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/full_model.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::vector<mesh::Index> nearest_nodes(const mesh::Mesh& mesh, const Eigen::Matrix3Xd& points) {
  std::vector<mesh::Index> out;
  for (Index k = 0; k < points.cols(); ++k) {
    Index at = 0;
    (mesh.points.rowwise() - points.col(k).transpose()).rowwise().squaredNorm().minCoeff(&at);
    out.push_back(static_cast<mesh::Index>(at));
  }
  return out;
}

}  // namespace

Eigen::Matrix3Xd points_of(const Part& part) {
  constexpr int kAlong = 6;
  const Eigen::Vector3d low = part.mesh.points.colwise().minCoeff(),
                        high = part.mesh.points.colwise().maxCoeff();
  Eigen::Matrix3Xd grid(3, kAlong * kAlong * kAlong);
  for (int k = 0; k < grid.cols(); ++k)
    grid.col(k) =
        low + (high - low)
                  .cwiseProduct(Eigen::Vector3d(k % kAlong, k / kAlong % kAlong, k / kAlong / kAlong) /
                                (kAlong - 1));
  std::vector<mesh::Index> nodes = nearest_nodes(part.mesh, grid);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  Eigen::Matrix3Xd out(3, static_cast<Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k)
    out.col(static_cast<Index>(k)) = part.mesh.points.row(nodes[k]).transpose();
  return out;
}

std::vector<double> compliance_of(const Reduction& r) {
  std::vector<double> out;
  int n_interfaces = 0;
  for (const ReducedInterface& interface : r.interfaces) n_interfaces += !interface.directions.empty();
  if (n_interfaces < 2) return out;
  for (const ReducedInterface& interface : r.interfaces) {
    const auto n = static_cast<Index>(interface.directions.size());
    if (n == 0) continue;
    const MatrixXd C = r.K_se.block(interface.first_dof, interface.first_dof, n, n).inverse();
    for (Index d = 0; d < n; ++d) out.push_back(C(d, d));
  }
  return out;
}

Answer answer_of(const Part& part, const Reduction& reduction, int n_modes, const Eigen::Matrix3Xd& points) {
  const FreeModes modes =
      free_modes_on_nodes(part, {6 + n_modes, 0.0, 1e-7}, reduced_free_modes(reduction)(6));
  Answer out;
  for (int k = 0; k < n_modes; ++k)
    out.hz.push_back(std::sqrt(modes.pairs.omega2(6 + k)) / (2 * std::numbers::pi));
  const std::vector<mesh::Index> nodes = nearest_nodes(part.mesh, points);
  out.shapes.resize(3 * points.cols(), n_modes);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    out.shapes.middleRows<3>(3 * static_cast<Index>(k)) =
        modes.U.block(3 * static_cast<Index>(nodes[k]), 6, 3, n_modes);
  out.compliance = compliance_of(reduction);
  out.dofs = reduction.report.n_i + reduction.report.n_b;
  return out;
}

Known limit_of(double a, double b, double c, double ratio, double least_order) {
  constexpr double kRoundOff = 1e-6;  // of eigenvalues with residuals of 1e-7
  const double first = a - b, last = b - c, size = std::abs(c);
  if (std::abs(last) < kRoundOff * size) return {c, std::max(std::abs(last), kRoundOff * size) / size};
  if (!(first * last > 0.0)) return {c, std::max(std::abs(first), std::abs(last)) / size};
  const double least = std::pow(ratio, least_order),
               shown = std::clamp(first / last, least, std::pow(ratio, 4.0));
  const double more = last / (shown - 1.0), most = last / (least - 1.0);
  return {c - more, std::max({std::abs(most - more), 0.5 * std::abs(more), kRoundOff * size}) / size};
}

std::vector<int> partners(const MatrixXd& shapes, const MatrixXd& known) {
  constexpr double kAlike = 0.3;  // of two with the same frequency each is half of either
  MatrixXd mac = (shapes.colwise().normalized().transpose() * known.colwise().normalized()).array().square();
  std::vector<int> out(static_cast<std::size_t>(shapes.cols()), -1);
  for (;;) {
    Index i = 0, j = 0;
    if (mac.size() == 0 || mac.maxCoeff(&i, &j) < kAlike) return out;
    out[static_cast<std::size_t>(i)] = static_cast<int>(j);
    mac.row(i).setZero();
    mac.col(j).setZero();
  }
}

namespace {

// The answers of a sequence as text: a name, its points, and of each mesh dofs, frequencies, compliances, shapes.
std::filesystem::path kept_file(const std::string& kind) {
  const char* folder = std::getenv("FLEXURA_TRUTHS");
  if (!folder) return {};
  std::string name = kind;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == ' '; }, '_');
  return std::filesystem::path(folder) / (name + ".txt");
}

void put(std::ostream& out, const MatrixXd& m) {
  out << m.rows() << ' ' << m.cols() << '\n';
  for (const double x : m.reshaped()) out << fmt::format("{:.17g}\n", x);
}

MatrixXd take(std::istream& in) {
  Index rows = 0, cols = 0;
  in >> rows >> cols;
  MatrixXd m(rows, cols);
  for (double& x : m.reshaped()) in >> x;
  return m;
}

void keep(const std::filesystem::path& file, const Eigen::Matrix3Xd& points,
          const std::vector<Answer>& answers) {
  std::ofstream out(file);
  put(out, points);
  for (const Answer& a : answers) {
    out << a.dofs << '\n';
    put(out, Eigen::Map<const Eigen::VectorXd>(a.hz.data(), static_cast<Index>(a.hz.size())));
    put(out, Eigen::Map<const Eigen::VectorXd>(a.compliance.data(), static_cast<Index>(a.compliance.size())));
    put(out, a.shapes);
  }
}

void recall(const std::filesystem::path& file, Eigen::Matrix3Xd& points, std::vector<Answer>& answers) {
  std::ifstream in(file);
  if (!in) return;
  points = take(in);
  for (int k = 0; k < 3; ++k) {
    Answer a;
    in >> a.dofs;
    const MatrixXd hz = take(in), compliance = take(in);
    a.hz.assign(hz.data(), hz.data() + hz.size());
    a.compliance.assign(compliance.data(), compliance.data() + compliance.size());
    a.shapes = take(in);
    answers.push_back(std::move(a));
  }
}

}  // namespace

Truth truth_of(const Sequence& sequence, int n_modes) {
  const std::size_t n = sequence.meshes.size();
  if (n < 3) throw std::invalid_argument("a limit needs three meshes");
  Truth out;
  std::vector<Answer> answers;  // the finest first: it says by which points modes are told apart
  const std::filesystem::path kept = kept_file(sequence.kind);
  if (!kept.empty()) recall(kept, out.points, answers);
  const bool known = !answers.empty();
  for (std::size_t k = 0; !known && k < 3; ++k) {
    const Part part = sequence.meshes[n - 1 - k]();
    if (k == 0) out.points = points_of(part);
    ReductionOptions options;
    options.n_modes = 20;
    answers.push_back(answer_of(part, craig_bampton(part, options), n_modes, out.points));
    std::fprintf(stderr, "%s: %d dofs,", sequence.kind.c_str(), answers.back().dofs);
    for (const double hz : answers.back().hz) std::fprintf(stderr, " %.6g", hz);
    std::fprintf(stderr, "\n");
  }
  if (!known && !kept.empty()) keep(kept, out.points, answers);
  for (const Answer& a : answers) out.dofs.insert(out.dofs.begin(), a.dofs);
  out.shapes = answers[0].shapes;
  const std::vector<int> of_b = partners(out.shapes, answers[1].shapes),
                         of_a = partners(out.shapes, answers[2].shapes);
  for (std::size_t k = 0; k < answers[0].hz.size(); ++k) {
    const double c = answers[0].hz[k];
    if (of_a[k] < 0 || of_b[k] < 0)
      out.hz.push_back({c, HUGE_VAL});
    else
      out.hz.push_back(limit_of(answers[2].hz[static_cast<std::size_t>(of_a[k])],
                                answers[1].hz[static_cast<std::size_t>(of_b[k])], c, sequence.ratio,
                                sequence.least_order));
  }
  for (std::size_t k = 0; k < answers[0].compliance.size(); ++k)
    out.compliance.push_back(limit_of(answers[2].compliance[k], answers[1].compliance[k],
                                      answers[0].compliance[k], sequence.ratio, sequence.least_order));
  return out;
}

}  // namespace flexura::reduce
