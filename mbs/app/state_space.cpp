// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/state_space.hpp"

#include <fmt/format.h>

#include <iterator>

#include "mbs/base/files/output.hpp"
#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

namespace flexura::app {
namespace {

using superelement::write_whole;

std::string octave_matrix(const Eigen::MatrixXd& A) {
  if (A.size() == 0) return fmt::format("zeros({}, {});\n", A.rows(), A.cols());
  std::string text(1, '[');
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      fmt::format_to(std::back_inserter(text), "{}{:.17g}", j == 0 ? "" : ", ", A(i, j));
    text += i + 1 < A.rows() ? ";\n  " : "];\n";
  }
  return text;
}

std::string octave_names(const std::vector<std::string>& names) {
  std::string text = "{";
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string quoted;
    for (const char c : names[i]) quoted += c == '\'' ? std::string("''") : std::string(1, c);
    text += fmt::format("{}'{}'", i == 0 ? "" : ", ", quoted);
  }
  return text + "};\n";
}

std::string script(const StateSpace& s) {
  std::string text = fmt::format("% {}; SI units\n", s.title);
  for (const auto& [name, list] : s.names) text += name + " = " + octave_names(list);
  for (const auto& [name, A] : s.matrices) text += name + " = " + octave_matrix(A);
  return text;
}

std::string matrix_market(const StateSpace& s, const std::string& name, const Eigen::MatrixXd& A) {
  std::string text =
      fmt::format("%%MatrixMarket matrix coordinate real general\n% {} of {}; SI units\n", name, s.title);
  for (const auto& [kind, list] : s.names)
    for (std::size_t i = 0; i < list.size(); ++i) text += fmt::format("% {} {}: {}\n", kind, i + 1, list[i]);
  text += fmt::format("{} {} {}\n", A.rows(), A.cols(), (A.array() != 0.0).count());
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (Eigen::Index i = 0; i < A.rows(); ++i)
      if (A(i, j) != 0.0) fmt::format_to(std::back_inserter(text), "{} {} {:.17g}\n", i + 1, j + 1, A(i, j));
  return text;
}

void write_hdf5(const StateSpace& s, const std::filesystem::path& path) {
  files::Output output(path);
  {
    hdf5::File file(output.part(), hdf5::Mode::create);
    hdf5::Group root = file.root();
    root.set("format", "flexura state space");
    root.set("title", s.title);
    root.set("time", s.time);
    for (const auto& [name, A] : s.matrices) hdf5::write_matrix(root, name, A, "SI", name + ", row by row");
    for (const auto& [name, list] : s.names) {
      std::string lines;
      for (const std::string& line : list) lines += line + "\n";
      root.write_text(name, lines, "one name a line");
    }
    file.close();
  }
  output.commit();
}

std::filesystem::path matrix_file(const std::filesystem::path& path, const std::string& name) {
  return path.parent_path() / (path.stem().string() + "_" + name + ".mtx");
}

}  // namespace

std::vector<std::filesystem::path> state_space_files(const std::filesystem::path& path, bool descriptor) {
  const std::string ending = path.extension().string();
  if (ending == ".m" || ending == ".h5") return {path};
  if (ending != ".mtx")
    throw std::invalid_argument(fmt::format(
        "{}: the ending must be .m (Octave, MATLAB), .h5 (HDF5) or .mtx (Matrix Market)", path.string()));
  std::vector<std::filesystem::path> files;
  for (const char* const name : {"A", "B", "C", "D", "x_0", "u_0", "y_0"})
    files.push_back(matrix_file(path, name));
  if (descriptor) files.push_back(matrix_file(path, "E"));
  return files;
}

std::vector<std::filesystem::path> write_state_space(const StateSpace& system,
                                                     const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".m") {
    write_whole(path, script(system));
    return {path};
  }
  if (ending == ".h5") {
    write_hdf5(system, path);
    return {path};
  }
  std::vector<std::filesystem::path> files;
  for (const auto& [name, A] : system.matrices) {
    if (A.size() == 0) continue;
    files.push_back(matrix_file(path, name));
    write_whole(files.back(), matrix_market(system, name, A));
  }
  return files;
}

}  // namespace flexura::app
