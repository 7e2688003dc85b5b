// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/names.hpp"
#include "mbs/superelement/text_file.hpp"

// Matrix Market (math.nist.gov/MatrixMarket/formats.html) and DMIG (Nastran Quick Reference Guide, bulk
// data).
namespace flexura::superelement {
namespace {

constexpr const char* direction_names[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};

std::string without_line_breaks(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return text;
}

std::string dof_comments(const Superelement& se) {
  std::string text;
  for (const Interface& interface : se.interfaces) {
    for (std::size_t i = 0; i < interface.directions.size(); ++i) {
      text += fmt::format("% dof {}: {} {}\n", interface.first_dof + static_cast<int>(i) + 1,
                          without_line_breaks(interface.name),
                          direction_names[static_cast<int>(interface.directions[i])]);
    }
  }
  for (int j = 0; j < se.n_q; ++j) text += fmt::format("% dof {}: mode {}\n", se.n_b + j + 1, j + 1);
  for (const Interface& interface : se.interfaces)
    for (std::size_t k = 0; k < interface.following.size(); ++k) {
      const Eigen::VectorXd row = interface.follow.row(static_cast<Eigen::Index>(k));
      text += fmt::format("% {} {} is no dof; it follows by: {:.16e}\n", without_line_breaks(interface.name),
                          direction_names[static_cast<int>(interface.following[k])],
                          fmt::join(row.begin(), row.end(), " "));
    }
  return text;
}

std::string matrix_market(const Eigen::MatrixXd& A, const std::string& comments) {
  fmt::memory_buffer out;
  fmt::format_to(std::back_inserter(out), "%%MatrixMarket matrix array real symmetric\n{}{} {}\n", comments,
                 A.rows(), A.cols());
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (Eigen::Index i = j; i < A.rows(); ++i) fmt::format_to(std::back_inserter(out), "{:.16e}\n", A(i, j));
  }
  return fmt::to_string(out);
}

// T by columns, 6 rows a node.
std::string recovery_matrix(const NodalMotions& nodes, const std::string& comments) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "%%MatrixMarket matrix array real general\n{}", comments);
  fmt::format_to(
      to,
      "% (u_x, u_y, u_z, theta_x, theta_y, theta_z) of each node, in rows; their numbers and places "
      "[m]:\n");
  for (std::size_t i = 0; i < nodes.numbers.size(); ++i) {
    const auto x = nodes.positions.row(static_cast<Eigen::Index>(i));
    fmt::format_to(to, "% node {}: {:.16e} {:.16e} {:.16e}\n", nodes.numbers[i], x[0], x[1], x[2]);
  }
  fmt::format_to(to, "{} {}\n", nodes.T.rows(), nodes.T.cols());
  for (const double value : nodes.T.reshaped()) fmt::format_to(to, "{:.16e}\n", value);
  return fmt::to_string(out);
}

// A number in a large field of 16 columns: ten digits and a D exponent.
std::string large_field(double value) {
  std::string text = fmt::format("{:.9E}", value);
  if (text.size() - text.find('E') > 4) text = fmt::format("{:.8E}", value);  // an exponent of three digits
  text[text.find('E')] = 'D';
  return text;
}

struct Point {
  int id, component;
};

std::vector<Point> points(const Superelement& se) {
  std::vector<Point> all;
  for (std::size_t k = 0; k < se.interfaces.size(); ++k) {
    for (const Direction direction : se.interfaces[k].directions) {
      all.push_back({static_cast<int>(k) + 1, static_cast<int>(direction) + 1});
    }
  }
  for (int j = 0; j < se.n_q; ++j) all.push_back({1'000'001 + j, 0});
  return all;
}

void append_dmig(fmt::memory_buffer& out, const std::string& name, const Eigen::MatrixXd& A,
                 const std::vector<Point>& points) {
  auto to = std::back_inserter(out);
  // Form 6: symmetric, one triangle; types 2: real double precision.
  fmt::format_to(to, "{:<8}{:<8}{:>8}{:>8}{:>8}{:>8}\n", "DMIG", name, 0, 6, 2, 2);
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const Point& column = points[static_cast<std::size_t>(j)];
    bool open = false;
    for (Eigen::Index i = j; i < A.rows(); ++i) {
      if (A(i, j) == 0.0) continue;
      if (!open) fmt::format_to(to, "{:<8}{:<16}{:>16}{:>16}\n", "DMIG*", name, column.id, column.component);
      open = true;
      const Point& row = points[static_cast<std::size_t>(i)];
      fmt::format_to(to, "{:<8}{:>16}{:>16}{:>16}\n", "*", row.id, row.component, large_field(A(i, j)));
    }
  }
}

}  // namespace

std::filesystem::path matrix_market_name(const std::filesystem::path& stem, const std::string& letter) {
  return stem.string() + "." + letter + ".mtx";
}

std::vector<std::filesystem::path> write_matrix_market(const std::filesystem::path& stem,
                                                       const Superelement& se) {
  std::vector<std::filesystem::path> written;
  const std::string comments =
      fmt::format("% superelement {}, SI units\n{}", without_line_breaks(se.name), dof_comments(se));
  const auto write = [&](const char* letter, const Eigen::MatrixXd& A) {
    written.push_back(matrix_market_name(stem, letter));
    write_whole(written.back(), matrix_market(A, comments));
  };
  write("K", se.K_se);
  write("M", se.M_se);
  if (se.D_se.size() > 0) write("D", se.D_se);
  if (se.nodes) {
    written.push_back(matrix_market_name(stem, "T"));
    write_whole(written.back(), recovery_matrix(*se.nodes, comments));
  }
  return written;
}

void write_dmig(const std::filesystem::path& path, const Superelement& se) {
  for (const Interface& interface : se.interfaces)
    if (!interface.following.empty())
      throw std::invalid_argument(
          fmt::format("superelement \"{}\": {} of interface \"{}\" is no dof of its own, which DMIG matrices "
                      "at grids cannot say; "
                      "keep more modes, or export flexdata, sid or matrix-market",
                      se.name, direction_names[static_cast<int>(interface.following[0])], interface.name));
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "$ Superelement {}, SI units. Use: K2GG=KFLEX, M2GG=MFLEX\n",
                 without_line_breaks(se.name));
  for (std::size_t k = 0; k < se.interfaces.size(); ++k) {
    const Interface& interface = se.interfaces[k];
    fmt::format_to(to, "$ interface {}\n{:<8}{:>16}{:>16}{:>16}{:>16}\n{:<8}{:>16}\n",
                   without_line_breaks(interface.name), "GRID*", k + 1, "", large_field(interface.p_BoN_B[0]),
                   large_field(interface.p_BoN_B[1]), "*", large_field(interface.p_BoN_B[2]));
  }
  for (int j = 0; j < se.n_q; ++j) fmt::format_to(to, "{:<8}{:>8}\n", "SPOINT", 1'000'001 + j);
  const std::vector<Point> all = points(se);
  append_dmig(out, "KFLEX", se.K_se, all);
  append_dmig(out, "MFLEX", se.M_se, all);
  if (se.D_se.size() > 0) append_dmig(out, "BFLEX", se.D_se, all);
  write_whole(path, {out.data(), out.size()});
}

}  // namespace flexura::superelement
