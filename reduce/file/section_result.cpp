// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/section_result.hpp"

#include <fmt/format.h>

#include "mbs/base/documents/document.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;
using input::TableSchema;
namespace dim = input::dim;

namespace {

std::string list(const Eigen::Ref<const Eigen::MatrixXd>& matrix, const char* format) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    text += i == 0 ? "[" : ",\n  [";
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      text += (j == 0 ? "" : ", ") + fmt::format(fmt::runtime(format), matrix(i, j));
    text += "]";
  }
  return text + "]";
}

Eigen::MatrixXd sized(const Section& in, const std::string& key, int rows, int columns) {
  Eigen::MatrixXd matrix = in.matrix(key);
  if (matrix.rows() != rows || matrix.cols() != columns)
    in.refuse(key, fmt::format("is {} x {}, it has {} x {}", matrix.rows(), matrix.cols(), rows, columns));
  return matrix;
}

}  // namespace

const TableSchema& section_result_schema() {
  static const TableSchema schema = [] {
    TableSchema point{.name = "point", .doc = "A point of the section where stresses are wanted."};
    point.keys = {
        input::text("name", "where it lies").required(),
        input::quantity("y", dim::length, "place").required(),
        input::quantity("z", dim::length, "place").required(),
        input::matrix("stress", "3 x 6: sigma_xx, tau_xy, tau_xz of N, V_y, V_z, T, M_y, M_z").required()};
    TableSchema outline{.name = "outline", .doc = "A closed line around the material or a hole."};
    outline.keys = {
        input::matrix("points", "rows [y, z] in m").required(),
        input::matrix("stress",
                      "three rows for each point: sigma_xx, tau_xy, tau_xz of N, V_y, V_z, T, M_y, M_z")};
    TableSchema s{.name = "section", .doc = "A solved section, written by `flexura section`."};
    s.keys = {input::quantity("I_t", dim::area_moment, "torsion constant").required(),
              input::quantity("I_w", {{6, 0, 0, 0}}, "warping constant").required(),
              input::quantity("young", dim::pressure, "reference").required(),
              input::quantity("shear", dim::pressure, "reference").required(),
              input::flag("open_thin_walled", "open and thin-walled").required(),
              input::matrix("stiffness", "6x6, order N, V_y, V_z, T, M_y, M_z").required(),
              input::matrix("mass", "6x6, order u_x, u_y, u_z, theta_x, theta_y, theta_z").required(),
              input::tables("point", point, "stress points"),
              input::tables("outline", outline, "for pictures")};
    return s;
  }();
  return schema;
}

std::string section_result(const beam::SectionProperties& s) {
  std::string text = fmt::format(
      "# Section \"{}\", made by flexura section; SI units.  In a beam part: type = \"file\", file = "
      "\"...\".\n"
      "I_t = {:.17g}\nI_w = {:.17g}\nyoung = {:.17g}\nshear = {:.17g}\nopen_thin_walled = {}\n"
      "stiffness = {}\nmass = {}\n",
      s.section.name, s.I_t, s.I_w, s.E_ref, s.G_ref, s.section.open_thin_walled,
      list(s.section.stiffness(), "{:.17g}"), list(s.section.inertia.matrix(), "{:.17g}"));
  for (const beam::StressPoint& point : s.section.points)
    text += fmt::format("\n[[point]]\nname = \"{}\"\ny = {:.17g}\nz = {:.17g}\nstress = {}\n", point.name,
                        point.y, point.z, list(point.S, "{:.17g}"));
  std::size_t first = 0;
  for (const beam::Loop& loop : s.section.outline) {
    Eigen::MatrixXd stress(3 * loop.rows(), 6);
    for (Eigen::Index k = 0; k < loop.rows(); ++k) stress.middleRows<3>(3 * k) = s.outline_stress.at(first++);
    text += fmt::format("\n[[outline]]\npoints = {}\nstress = {}\n", list(loop, "{:.9g}"),
                        list(stress, "{:.9g}"));
  }
  return text;
}

beam::Section read_section_result(const std::string& name, const std::filesystem::path& file,
                                  std::vector<Eigen::Matrix<double, 3, 6>>* outline_stress) {
  const Section in = input::read_document(file, section_result_schema());
  beam::Section section;
  try {
    section = beam::matrix_section(name, sized(in, "stiffness", 6, 6), sized(in, "mass", 6, 6));
  } catch (const std::invalid_argument& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  section.I_w = in.quantity("I_w");
  section.open_thin_walled = in.flag("open_thin_walled");
  section.material = beam::Material{name, in.quantity("young"), in.quantity("shear"), 0.0};
  beam::Constants constants;  // for the warning of restrained warping
  constants.I_t = in.quantity("I_t");
  section.constants = constants;
  if (in.has("point"))
    for (const Section& p : in.tables("point"))
      section.points.push_back({p.text("name"), p.quantity("y"), p.quantity("z"), sized(p, "stress", 3, 6)});
  if (in.has("outline"))
    for (const Section& loop : in.tables("outline")) {
      const Eigen::MatrixXd points = loop.matrix("points");
      if (points.cols() != 2 || points.rows() < 3)
        loop.refuse("points", fmt::format("is {} x {}, an outline has at least three rows [y, z]",
                                          points.rows(), points.cols()));
      section.outline.push_back(points);
      if (!outline_stress || !loop.has("stress")) continue;
      const Eigen::MatrixXd stress = sized(loop, "stress", 3 * static_cast<int>(points.rows()), 6);
      for (Eigen::Index k = 0; k < points.rows(); ++k) outline_stress->push_back(stress.middleRows<3>(3 * k));
    }
  return section;
}

}  // namespace flexura::reduce
