// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/benchmarks/solver_matrix.hpp"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/part/make_part.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Vector3d;
using mesh::CellType;

template <class T>
void put(std::ofstream& out, const std::vector<T>& values) {
  const auto count = static_cast<std::uint64_t>(values.size());
  out.write(reinterpret_cast<const char*>(&count), sizeof(count));
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T>
void take(std::ifstream& in, std::vector<T>& values) {
  std::uint64_t count = 0;
  in.read(reinterpret_cast<char*>(&count), sizeof(count));
  values.resize(count);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
}

// The middle of a sheet bent to a tube with a slit of five degrees: x runs around, y along, z through the wall.
Vector3d rolled(const Vector3d& x, double around, double radius) {
  const double angle = x(0) / around * (355.0 / 180.0) * std::numbers::pi, r = radius + x(2);
  return {r * std::cos(angle), r * std::sin(angle), x(1)};
}

Part made(const std::string& name) {
  if (name == "slender")
    return testing::beam({1.0, 0.02, 0.02}, {170, 3, 3}, CellType::tet10, Tie::rigid, Tie::rigid);
  if (name == "thin")
    return testing::beam({0.4, 0.4, 0.002}, {116, 116, 1}, CellType::tet10, Tie::rigid, Tie::rigid);
  constexpr double kRadius = 0.099, kAround = 2.0 * std::numbers::pi * kRadius;
  Part part = testing::beam({kAround, 0.3, 0.002}, {130, 62, 1}, CellType::tet10, Tie::rigid, Tie::rigid);
  testing::deform(
      part.mesh, [&](const Vector3d& x) { return rolled(x, kAround, kRadius); }, true);
  for (InterfaceSpec& interface : part.interfaces)
    interface.point = rolled(interface.point, kAround, kRadius);
  return part;
}

Part meshed(const std::string& file, const std::string& size) {
  PartInput input = read_part(file, {"mesh.size=" + size});
  input.cad.worker = FLEXURA_BIN_DIR "/flexura-mesh";
  return make_part(input, load_part_mesh(input, {})).part;
}

}  // namespace

SolverMatrix stiffness_of(const std::string& part, const std::string& size) {
  const TiedModel model(size.empty() ? made(part) : meshed(part, size));
  const linalg::UpperCsr csr = model.K_ii().csr();
  SolverMatrix A;
  A.row_begin.assign(csr.row_begin.begin(), csr.row_begin.end());
  A.columns.assign(csr.columns.begin(), csr.columns.end());
  A.values.assign(csr.values.begin(), csr.values.end());
  A.group_begin.assign(model.numbering().group_begin().begin(), model.numbering().group_begin().end());
  for (const int pin : model.pins()) A.values[static_cast<std::size_t>(csr.row_begin[pin])] *= 2.0;
  return A;
}

void write(const std::filesystem::path& file, const SolverMatrix& A) {
  std::ofstream out(file, std::ios::binary);
  put(out, A.row_begin);
  put(out, A.columns);
  put(out, A.group_begin);
  put(out, A.values);
  if (!out.flush()) throw std::runtime_error(file.string() + " cannot be written");
}

SolverMatrix read_matrix(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  SolverMatrix A;
  take(in, A.row_begin);
  take(in, A.columns);
  take(in, A.group_begin);
  take(in, A.values);
  if (!in) throw std::runtime_error(file.string() + " cannot be read");
  return A;
}

}  // namespace flexura::reduce
