// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A marker on several nodes in the runtime against the averaging interface (RBE3) of the reduction.
#include <gtest/gtest.h>

#include <numeric>

#include "mbs/bodies/body_node.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::test {
namespace {

TEST(InterpolatedMarker, MovesAsTheAveragingInterfaceOfTheReduction) {
  reduce::Part part = reduce::testing::beam({0.4, 0.1, 0.06}, {4, 2, 2}, mesh::CellType::hex20,
                                            reduce::Tie::rigid, reduce::Tie::average);
  reduce::testing::deform(part.mesh, [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return {x(0) + 0.1 * x(1), x(1) + 0.8 * x(0) * x(0), x(2) * (1.0 - x(0))};
  });
  reduce::InterfaceSpec& right = part.interfaces[1];
  const std::vector<mesh::Index> face = right.set.nodes;
  mbs::NodePlaces places;
  for (std::size_t k = 0; k < face.size(); ++k) right.weights.push_back(1.0 + 0.1 * static_cast<double>(k));
  places.weights = right.weights;
  reduce::ReductionOptions options;
  options.n_modes = 8;
  options.shape_nodes = face;
  const reduce::Reduction reduction = reduce::craig_bampton(part, options);

  superelement::Superelement se;
  se.n_b = 12;
  se.n_q = static_cast<int>(reduction.shapes.cols()) - 12;
  se.shapes = reduction.shapes;
  se.surface.vertices.resize(static_cast<Eigen::Index>(face.size()), 3);
  for (std::size_t k = 0; k < face.size(); ++k)
    se.surface.vertices.row(static_cast<Eigen::Index>(k)) = part.mesh.points.row(face[k]);
  places.vertices.resize(face.size());
  std::iota(places.vertices.begin(), places.vertices.end(), 0);
  const mbs::BodyNode node = mbs::interpolated_node(se, "face", places);

  // The interface's own coordinates are the node's motion, taken to the interface's point; nothing else
  // moves it, neither the other interface nor a fixed-interface mode.
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(6, se.n());
  expected.block<6, 6>(0, 6).setIdentity();
  expected.block<3, 3>(0, 9) = -mbs::skew(node.p_BoN_B - right.point);
  // Shapes in single precision, displacements of up to 1 for a unit turn over a radius of 5 cm: rotations are
  // right to 6e-8 / 0.05.  Modes are mass-normalised: displacements of order one for some kg.
  const double size = std::max(1.0, reduction.shapes.cwiseAbs().maxCoeff() * 1.0);
  EXPECT_LT((node.rows - expected).cwiseAbs().maxCoeff(), 6e-8 / 0.03 * size);
}

}  // namespace
}  // namespace flexura::test
