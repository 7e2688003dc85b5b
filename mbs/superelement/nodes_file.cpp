// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/nodes_file.hpp"

#include "mbs/superelement/recovery_file.hpp"

namespace flexura::superelement {

using hdf5::Group;
using hdf5::Shape;

namespace {

template <typename Scalar>
using RowMajor = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

template <typename Scalar>
void write_T(Group& group, const NodalMotions& nodes) {
  const RowMajor<Scalar> by_shape = nodes.T.transpose().cast<Scalar>();
  write_rows(group, "T", by_shape, "m, rad per dof",
             "(k, 6 i + c): motion of node i by shape k, c = u_x, u_y, u_z, theta_x, theta_y, theta_z");
}

template <typename Scalar>
void read_T(const Group& group, Eigen::Index n, NodalMotions& nodes) {
  RowMajor<Scalar> by_shape(n, 6 * nodes.positions.rows());
  group.read("T", {static_cast<std::size_t>(by_shape.rows()), static_cast<std::size_t>(by_shape.cols())},
             by_shape.data());
  nodes.T = by_shape.transpose().template cast<double>();
}

}  // namespace

void write_nodes(Group root, const NodalMotions& nodes) {
  Group group = root.create_group("nodes");
  write_rows(group, "positions", nodes.positions, "m", "(i, a): position in frame B");
  group.write("numbers", {nodes.numbers.size()}, nodes.numbers.data(), "", "(i): number in the mesh file");
  std::vector<std::int32_t> rotations;
  for (const NodalMotions::Rotation rotation : nodes.rotations)
    rotations.push_back(static_cast<int>(rotation));
  group.write("rotations", {rotations.size()}, rotations.data(), "",
              "(i): 0 none known, 1 dofs of the model, 2 half the curl of the displacements");
  group.set("precision", nodes.double_precision ? "float64" : "float32");
  if (nodes.double_precision)
    write_T<double>(group, nodes);
  else
    write_T<float>(group, nodes);
}

void read_nodes(const Group& root, Superelement& se) {
  if (!root.has("nodes")) return;
  const Group group = root.group("nodes");
  NodalMotions& nodes = se.nodes.emplace();
  nodes.double_precision = group.text("precision") == "float64";
  read_rows(group, "positions", nodes.positions);
  const auto count = static_cast<std::size_t>(nodes.positions.rows());
  nodes.numbers.resize(count);
  group.read("numbers", {count}, nodes.numbers.data());
  std::vector<std::int32_t> rotations(count);
  group.read("rotations", {count}, rotations.data());
  for (const std::int32_t rotation : rotations)
    nodes.rotations.push_back(rotation >= 0 && rotation <= 2 ? static_cast<NodalMotions::Rotation>(rotation)
                                                             : static_cast<NodalMotions::Rotation>(-1));
  if (nodes.double_precision)
    read_T<double>(group, se.n(), nodes);
  else
    read_T<float>(group, se.n(), nodes);
}

}  // namespace flexura::superelement
