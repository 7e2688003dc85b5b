// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/checks.hpp"
#include "mbs/superelement/mesh_error_file.hpp"
#include "mbs/superelement/nodes_file.hpp"
#include "mbs/superelement/recovery_file.hpp"

// The layout is described in FORMAT.md; change both together, and the version with them.
namespace flexura::superelement {
namespace {

using hdf5::Group;
using hdf5::Shape;
using nlohmann::json;

constexpr const char* format_name = "flexura superelement";
constexpr int format_version = 2;  // 2 only where a direction follows: readers of 1 would hold it at rest
constexpr const char* direction_names[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
constexpr const char* u_se_unit =
    "by the dofs: force [N], moment [N m], modal [sqrt(kg) m/s^2] per [m], [rad], [sqrt(kg) m]";

// --- Header ----------------------------------------------------------------------------------------------

std::string header_text(const Superelement& se) {
  json header = {{"name", se.name},
                 {"created_by", se.created_by},
                 {"n_b", se.n_b},
                 {"n_q", se.n_q},
                 {"modal_damping", se.modal_damping},
                 {"interfaces", json::array()},
                 {"load_cases", json::array()}};
  for (const Interface& interface : se.interfaces) {
    json directions = json::array();
    for (const Direction direction : interface.directions) {
      directions.push_back(direction_names[static_cast<int>(direction)]);
    }
    header["interfaces"].push_back(
        {{"name", interface.name},
         {"tie", interface.tie},
         {"p_BoN_B", {interface.p_BoN_B.x(), interface.p_BoN_B.y(), interface.p_BoN_B.z()}},
         {"directions", directions},
         {"first_dof", interface.first_dof}});
    const auto write_rows = [&](const char* key, const std::vector<Direction>& directions_of,
                                const Eigen::MatrixXd& rows) {
      for (std::size_t k = 0; k < directions_of.size(); ++k) {
        const Eigen::VectorXd row = rows.row(static_cast<Eigen::Index>(k));
        header["interfaces"].back()[key][direction_names[static_cast<int>(directions_of[k])]] =
            std::vector<double>(row.begin(), row.end());
      }
    };
    write_rows("follow", interface.following, interface.follow);
    write_rows("free", interface.free, interface.free_motion);
  }
  for (const LoadCase& load : se.load_cases) {
    header["load_cases"].push_back(load.name);
    if (load.is_preload) header["preloads"].push_back(load.name);
  }
  // Names may hold bytes that are no UTF-8; they come back as replacement characters instead of failing the
  // write.
  return header.dump(1, ' ', false, json::error_handler_t::replace);
}

void read_header(const std::string& text, const std::string& label, Superelement& se) {
  try {
    const json header = files::read_json(text);
    header.at("name").get_to(se.name);
    header.at("created_by").get_to(se.created_by);
    header.at("n_b").get_to(se.n_b);
    header.at("n_q").get_to(se.n_q);
    header.at("modal_damping").get_to(se.modal_damping);
    for (const json& entry : header.at("interfaces")) {
      Interface interface;
      entry.at("name").get_to(interface.name);
      entry.at("tie").get_to(interface.tie);
      for (std::size_t a = 0; a < 3; ++a)
        entry.at("p_BoN_B").at(a).get_to(interface.p_BoN_B[static_cast<int>(a)]);
      entry.at("first_dof").get_to(interface.first_dof);
      const auto direction = [&](const std::string& name) {
        const auto* found = std::find(std::begin(direction_names), std::end(direction_names), name);
        if (found == std::end(direction_names))
          throw hdf5::BadFile(label + ": unknown direction " + json(name).dump());
        return static_cast<Direction>(found - std::begin(direction_names));
      };
      for (const json& name : entry.at("directions"))
        interface.directions.push_back(direction(name.get<std::string>()));
      const auto read_rows = [&](const char* key, std::vector<Direction>& directions, Eigen::MatrixXd& rows) {
        if (!entry.contains(key)) return;
        for (const auto& [name, row] : entry.at(key).items()) {
          directions.push_back(direction(name));
          const auto values = row.get<std::vector<double>>();
          const auto k = static_cast<Eigen::Index>(directions.size());
          if (k == 1) rows.resize(1, static_cast<Eigen::Index>(values.size()));
          if (rows.cols() != static_cast<Eigen::Index>(values.size()))
            throw hdf5::BadFile(label + ": rows of \"" + interface.name + "\" differ in length");
          rows.conservativeResize(k, Eigen::NoChange);
          rows.row(k - 1) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), rows.cols());
        }
      };
      read_rows("follow", interface.following, interface.follow);
      read_rows("free", interface.free, interface.free_motion);
      se.interfaces.push_back(std::move(interface));
    }
    for (const json& name : header.at("load_cases")) se.load_cases.push_back({name.get<std::string>(), {}});
    if (header.contains("preloads"))
      for (const json& name : header.at("preloads"))
        for (LoadCase& load : se.load_cases)
          if (load.name == name.get<std::string>()) load.is_preload = true;
  } catch (const json::exception&) {
    throw hdf5::BadFile(label + ": cannot be understood; the file is damaged, make it again");
  }
  constexpr int most_dofs = 100'000;  // a dense matrix of that size is 80 GB; a larger number is damage
  if (se.n_b < 0 || se.n_q < 0 || se.n_b > most_dofs || se.n_q > most_dofs) {
    throw hdf5::BadFile(fmt::format("{}: n_b = {} and n_q = {} cannot be", label, se.n_b, se.n_q));
  }
}

// --- Stacks of matrices ----------------------------------------------------------------------------------

template <typename Matrices>
void write_stack(Group& group, const std::string& name, const Matrices& matrices, int n,
                 const std::string& unit, const std::string& doc) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<double> values;
  values.reserve(matrices.size() * size * size);
  for (const Eigen::MatrixXd& matrix : matrices) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) values.push_back(matrix(i, j));
    }
  }
  group.write(name, {matrices.size(), size, size}, values.data(), unit, doc);
}

template <typename Matrices>
void read_stack(const Group& group, const std::string& name, Matrices& matrices, int n) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<double> values(matrices.size() * size * size);
  group.read(name, {matrices.size(), size, size}, values.data());
  std::size_t at = 0;
  for (Eigen::MatrixXd& matrix : matrices) {
    matrix.resize(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) matrix(i, j) = values[at++];
    }
  }
}

// --- Parts -----------------------------------------------------------------------------------------------

void write_matrices(Group root, const Superelement& se) {
  Group group = root.create_group("matrices");
  hdf5::write_matrix(group, "K_se", se.K_se, u_se_unit, "stiffness, n x n; T^T K T");
  hdf5::write_matrix(group, "M_se", se.M_se, "as K_se, times s^2", "mass, n x n; T^T M T");
  if (se.D_se.size() > 0)
    hdf5::write_matrix(group, "D_se", se.D_se, "as K_se, times s", "damping, n x n; T^T D T");
  hdf5::write_vector(group, "omega2", se.omega2, "rad^2/s^2",
                     "eigenvalues of the fixed-interface problem, n_q");
  if (se.load_cases.empty()) return;
  Eigen::MatrixXd p_se(static_cast<Eigen::Index>(se.load_cases.size()), se.n());
  for (std::size_t i = 0; i < se.load_cases.size(); ++i) {
    p_se.row(static_cast<Eigen::Index>(i)) = se.load_cases[i].p_se.transpose();
  }
  hdf5::write_matrix(group, "p_se", p_se, "by the dofs",
                     "load vectors T^T p, one row for each name in load_cases");
  if (se.load_cases.front().moment.size() == 0) return;
  Eigen::MatrixXd moment(3 * p_se.rows(), se.n());
  for (Eigen::Index i = 0; i < p_se.rows(); ++i)
    moment.middleRows<3>(3 * i) = se.load_cases[static_cast<std::size_t>(i)].moment;
  hdf5::write_matrix(group, "p_moment", moment, "N m times shape",
                     "row 3 i + a: torque of load i about Bo by displacement, sum of (phi_k x p)_a");
}

void read_matrices(const Group& root, Superelement& se) {
  const Group group = root.group("matrices");
  const Eigen::Index n = se.n();
  se.K_se = hdf5::read_matrix(group, "K_se", n, n);
  se.M_se = hdf5::read_matrix(group, "M_se", n, n);
  if (group.has("D_se")) se.D_se = hdf5::read_matrix(group, "D_se", n, n);
  se.omega2 = hdf5::read_vector(group, "omega2", se.n_q);
}

// Rigid bodies feel loads, too.
void read_load_cases(const Group& root, Superelement& se) {
  if (se.load_cases.empty()) return;
  const Group group = root.group("matrices");
  const Eigen::Index n = se.n(), n_cases = static_cast<Eigen::Index>(se.load_cases.size());
  const Eigen::MatrixXd p_se = hdf5::read_matrix(group, "p_se", n_cases, n);
  Eigen::MatrixXd moment;
  if (group.has("p_moment")) moment = hdf5::read_matrix(group, "p_moment", 3 * n_cases, n);
  for (Eigen::Index i = 0; i < n_cases; ++i) {
    LoadCase& load = se.load_cases[static_cast<std::size_t>(i)];
    load.p_se = p_se.row(i);
    if (moment.size() > 0) load.moment = moment.middleRows<3>(3 * i);
  }
}

void write_inertia(Group root, const Superelement& se) {
  Group group = root.create_group("inertia");
  const InertiaIntegrals& I = se.inertia;
  group.write("mass", {1}, &I.mass, "kg", "integral of dm");
  hdf5::write_vector(group, "S_x", I.S_x, "kg m", "(a): integral of x_a dm, about Bo");
  hdf5::write_matrix(group, "S_xx", I.S_xx, "kg m^2", "(a, b): integral of x_a x_b dm, about Bo");
  hdf5::write_matrix(group, "S_phi", I.S_phi, "kg times shape", "(a, k): integral of phi_k,a dm");
  hdf5::write_matrix(group, "S_xphi", I.S_xphi, "kg m times shape",
                     "(3 a + b, k): integral of x_a phi_k,b dm");
  write_stack(group, "S_phiphi", I.S_phiphi, se.n(), "kg times shape^2",
              "(p, k, l): integral of phi_k,a phi_l,b dm, p = xx, yy, zz, xy, yz, zx");
}

void read_inertia(const Group& root, Superelement& se) {
  const Group group = root.group("inertia");
  InertiaIntegrals& I = se.inertia;
  group.read("mass", {1}, &I.mass);
  I.S_x = hdf5::read_vector(group, "S_x", 3);
  I.S_xx = hdf5::read_matrix(group, "S_xx", 3, 3);
  I.S_phi = hdf5::read_matrix(group, "S_phi", 3, se.n());
  I.S_xphi = hdf5::read_matrix(group, "S_xphi", 9, se.n());
  read_stack(group, "S_phiphi", I.S_phiphi, se.n());
}

void write_stiffening(Group root, const Superelement& se) {
  Group group = root.create_group("stiffening");
  const StiffeningTerms& terms = *se.stiffening;
  write_stack(group, "K0t", terms.K0t, se.n(), "as K_se, per m/s^2",
              "(a, k, l): for unit acceleration of B along a");
  write_stack(group, "K0r", terms.K0r, se.n(), "as K_se, per rad/s^2",
              "(a, k, l): for unit angular acceleration about a");
  write_stack(group, "K0omega", terms.K0omega, se.n(), "as K_se, per rad^2/s^2",
              "(p, k, l): for unit omega_a omega_b, p = xx, yy, zz, xy, yz, zx");
  write_stack(group, "K0F", terms.K0F, se.n(), "as K_se, per N or N m",
              "(i, k, l): for a unit load on interface dof i");
  if (!terms.K0p.empty())
    write_stack(group, "K0p", terms.K0p, se.n(), "as K_se", "(i, k, l): for load case i");
}

void read_stiffening(const Group& root, Superelement& se) {
  if (!root.has("stiffening")) return;
  const Group group = root.group("stiffening");
  StiffeningTerms& terms = se.stiffening.emplace();
  terms.K0F.resize(static_cast<std::size_t>(se.n_b));
  read_stack(group, "K0t", terms.K0t, se.n());
  read_stack(group, "K0r", terms.K0r, se.n());
  read_stack(group, "K0omega", terms.K0omega, se.n());
  read_stack(group, "K0F", terms.K0F, se.n());
  if (!group.has("K0p")) return;
  terms.K0p.resize(se.load_cases.size());
  read_stack(group, "K0p", terms.K0p, se.n());
}

void write_surface(Group root, const Surface& surface) {
  Group group = root.create_group("surface");
  write_rows(group, "vertices", surface.vertices, "m", "(v, a): position in frame B");
  write_rows(group, "triangles", surface.triangles, "",
             "(t, 3): vertices, counter-clockwise seen from outside");
  write_rows(group, "edges", surface.edges, "", "(e, 2): vertices of feature edges");
  group.write("triangle_interface", {surface.triangle_interface.size()}, surface.triangle_interface.data(),
              "", "(t): index of the interface the triangle belongs to, or -1");
}

void read_surface(const Group& root, Superelement& se) {
  if (!root.has("surface")) return;
  const Group group = root.group("surface");
  read_rows(group, "vertices", se.surface.vertices);
  read_rows(group, "triangles", se.surface.triangles);
  read_rows(group, "edges", se.surface.edges);
  const Shape shape = group.shape("triangle_interface");
  if (shape.size() != 1 ||
      (shape[0] != 0 && static_cast<Eigen::Index>(shape[0]) != se.surface.triangles.rows())) {
    throw hdf5::BadFile(group.label() +
                        "/triangle_interface: has the wrong shape; the file is damaged, make it again");
  }
  se.surface.triangle_interface.resize(shape[0]);
  group.read("triangle_interface", shape, se.surface.triangle_interface.data());
}

// Shape k is row k in the file and column k here, 3 n_v numbers in a row either way: nothing is copied.
void write_shapes(Group root, const Superelement& se) {
  Group group = root.create_group("shapes");
  group.write("surface",
              {static_cast<std::size_t>(se.shapes.cols()), static_cast<std::size_t>(se.shapes.rows())},
              se.shapes.data(), "m per dof",
              "(k, 3 v + a): shape k at vertex v of the surface, direction a, float32");
}

void read_shapes(const Group& root, Superelement& se) {
  if (!root.has("shapes")) return;
  const Group group = root.group("shapes");
  const Shape shape = group.shape("surface");
  constexpr std::size_t most_columns = std::size_t{1} << 31;
  if (shape.size() != 2 || static_cast<int>(shape[0]) != se.n() || shape[1] > most_columns) {
    throw hdf5::BadFile(group.label() + "/surface: has the wrong shape; the file is damaged, make it again");
  }
  se.shapes.resize(static_cast<Eigen::Index>(shape[1]), se.n());
  group.read("surface", shape, se.shapes.data());
}

void write_all(hdf5::File& file, const Superelement& se) {
  {
    Group root = file.root();
    root.set("format", format_name);
    const bool follows =
        std::ranges::any_of(se.interfaces, [](const Interface& i) { return !i.following.empty(); });
    root.set("version", follows ? format_version : 1);
    root.set("units", "SI: m, kg, s, rad");
    root.set("frame", "B, the coordinate system of the part's CAD file or mesh");
    root.write_text("header", header_text(se),
                    "JSON: name, created_by, n_b, n_q, modal_damping, interfaces, load_cases");
    root.write_text("source", se.source, "the part file");
    root.write_text("report", se.report_json, "JSON: report of the reduction");
    write_matrices(file.root(), se);
    write_inertia(file.root(), se);
    if (se.stiffening) write_stiffening(file.root(), se);
    if (se.surface.vertices.rows() > 0) write_surface(file.root(), se.surface);
    if (se.shapes.size() > 0) write_shapes(file.root(), se);
    if (se.stress) write_stress(file.root(), *se.stress);
    if (se.sections) write_sections(file.root(), *se.sections);
    if (se.mesh_error) write_mesh_error(file.root(), *se.mesh_error);
    if (se.nodes) write_nodes(file.root(), *se.nodes);
  }
  file.close();
}

}  // namespace

void write(const std::filesystem::path& path, const Superelement& se) {
  validate(se);
  files::Output output(path);
  try {
    hdf5::File file(output.part(), hdf5::Mode::create);
    try {
      write_all(file, se);
    } catch (const hdf5::Error&) {
      try {
        file.close();  // gives it up
      } catch (const hdf5::Error&) {
      }
      throw;
    }
  } catch (const hdf5::BadFile& failure) {  // the disk is to blame, not an input
    throw hdf5::Error(failure.what());
  }
  output.commit();
}

Superelement read(const std::filesystem::path& path, const Parts& parts) {
  if (path.extension() == ".xml")
    throw hdf5::BadFile(path.string() + ": is no superelement; if it is a FlexData file, \"flexura reduce " +
                        path.filename().string() + "\" makes one of it");
  const hdf5::File file(path, hdf5::Mode::read);
  const Group root = file.root();
  if (!root.has_attribute("format") || root.text("format") != format_name) {
    throw hdf5::BadFile(path.string() +
                        ": is an HDF5 file but not a superelement; make one with \"flexura reduce\"");
  }
  const int version = root.integer("version");
  if (version > format_version) {
    throw hdf5::BadFile(
        fmt::format("{}: is written in version {} of the superelement format, this program reads up to {}; "
                    "update Flexura or reduce the part again",
                    path.string(), version, format_version));
  }
  Superelement se;
  read_header(root.read_text("header"), root.label() + "header", se);
  se.source = root.read_text("source");
  se.report_json = root.read_text("report");
  read_load_cases(root, se);
  if (parts.matrices) read_matrices(root, se);
  if (parts.inertia) read_inertia(root, se);
  if (parts.stiffening) read_stiffening(root, se);
  if (parts.surface) read_surface(root, se);
  if (parts.shapes) read_shapes(root, se);
  if (parts.stress) read_stress(root, se);
  if (parts.sections) read_sections(root, se);
  if (parts.mesh_error) read_mesh_error(root, se);
  if (parts.nodes) read_nodes(root, se);
  try {
    validate_parts(se, parts);
  } catch (const std::invalid_argument& failure) {
    throw hdf5::BadFile(path.string() + ": " + failure.what());
  }
  return se;
}

}  // namespace flexura::superelement
