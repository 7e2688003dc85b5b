// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/model/folder.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <set>
#include <stdexcept>

#include "mbs/base/files/new_folder.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::import {
namespace {

namespace fs = std::filesystem;

// u(x) = u_0 + theta x x for the six coordinates (u_0, theta) of the node at Bo: phi_k = e_k, phi_3+k = e_k x
// x.
superelement::InertiaIntegrals rigid_integrals(const Body& body) {
  superelement::InertiaIntegrals integrals;
  integrals.mass = body.mass;
  integrals.S_x = body.mass * body.center;
  // I = tr(S) 1 - S about the centre, so S = tr(I) / 2 1 - I; then Steiner.
  integrals.S_xx = 0.5 * body.inertia.trace() * Matrix3d::Identity() - body.inertia +
                   body.mass * body.center * body.center.transpose();
  // phi_k,a is linear in (1, x): phi_k,a = c_k,a + sum_b C_k(a, b) x_b.
  std::array<Vector3d, 6> c;
  std::array<Matrix3d, 6> C;
  for (int k = 0; k < 3; ++k) {
    c[k] = Vector3d::Unit(k);
    C[k].setZero();
    c[3 + k].setZero();
    for (int b = 0; b < 3; ++b) C[3 + k].col(b) = Vector3d::Unit(k).cross(Vector3d::Unit(b));
  }
  integrals.S_phi.resize(3, 6);
  integrals.S_xphi.resize(9, 6);
  for (int k = 0; k < 6; ++k) {
    integrals.S_phi.col(k) = c[k] * body.mass + C[k] * integrals.S_x;
    for (int a = 0; a < 3; ++a)
      integrals.S_xphi.block<3, 1>(3 * a, k) = integrals.S_x(a) * c[k] + C[k] * integrals.S_xx.col(a);
  }
  constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (int i = 0; i < 6; ++i) {
    const auto [a, b] = pairs[i];
    Eigen::MatrixXd& S = integrals.S_phiphi[static_cast<std::size_t>(i)];
    S.resize(6, 6);
    for (int k = 0; k < 6; ++k)
      for (int l = 0; l < 6; ++l)
        S(k, l) = c[k](a) * c[l](b) * body.mass + c[k](a) * C[l].row(b).dot(integrals.S_x) +
                  c[l](b) * C[k].row(a).dot(integrals.S_x) +
                  C[k].row(a).dot(integrals.S_xx * C[l].row(b).transpose());
  }
  return integrals;
}

void require_folder(const fs::path& folder) {
  const auto status = fs::status(folder);
  if (fs::exists(status) && !fs::is_directory(status))
    throw std::invalid_argument(folder.string() + ": is not a folder; name one, or a new one, with -o");
}

}  // namespace

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

superelement::Superelement rigid_superelement(const Body& body, const std::string& source) {
  if (!(body.mass > 0.0))
    throw std::invalid_argument(
        fmt::format("body \"{}\" has no mass and cannot carry a surface; give it one", body.name));
  superelement::Superelement se;
  se.name = body.file();
  se.created_by = "flexura import";
  se.source = source;
  using superelement::Direction;
  se.interfaces.push_back({.name = "origin",
                           .tie = "rigid",
                           .directions = {Direction::u_x, Direction::u_y, Direction::u_z, Direction::theta_x,
                                          Direction::theta_y, Direction::theta_z},
                           .first_dof = 0});
  se.n_b = 6;
  for (const auto& [name, p] : body.interfaces)
    se.interfaces.push_back({.name = name, .tie = "rigid", .p_BoN_B = p, .directions = {}, .first_dof = 6});
  se.K_se = Eigen::MatrixXd::Zero(6, 6);
  se.inertia = rigid_integrals(body);
  se.M_se = se.inertia.S_phiphi[0] + se.inertia.S_phiphi[1] + se.inertia.S_phiphi[2];
  const auto n_v = static_cast<Eigen::Index>(body.surface.vertices.size());
  se.surface.vertices.resize(n_v, 3);
  se.shapes = Eigen::MatrixXf::Zero(3 * n_v, 6);
  for (Eigen::Index v = 0; v < n_v; ++v) {
    const Vector3d& x = body.surface.vertices[static_cast<std::size_t>(v)];
    se.surface.vertices.row(v) = x.transpose();
    for (int k = 0; k < 3; ++k) {
      se.shapes(3 * v + k, k) = 1.0F;
      se.shapes.block<3, 1>(3 * v, 3 + k) = Vector3d::Unit(k).cross(x).cast<float>();
    }
  }
  const auto n_t = static_cast<Eigen::Index>(body.surface.triangles.size());
  se.surface.triangles.resize(n_t, 3);
  for (Eigen::Index t = 0; t < n_t; ++t)
    se.surface.triangles.row(t) = body.surface.triangles[static_cast<std::size_t>(t)].transpose();
  se.surface.edges.resize(static_cast<Eigen::Index>(body.surface.edges.size()), 2);
  for (Eigen::Index e = 0; e < se.surface.edges.rows(); ++e) {
    const auto& [a, b] = body.surface.edges[static_cast<std::size_t>(e)];
    se.surface.edges.row(e) << a, b;
  }
  se.surface.triangle_interface.assign(static_cast<std::size_t>(n_t), -1);
  for (std::size_t t = 0; t < body.triangle_interface.size(); ++t)  // behind "origin"
    if (body.triangle_interface[t] >= 0) se.surface.triangle_interface[t] = body.triangle_interface[t] + 1;
  return se;
}

namespace {

/// The files of a folder that is written as a whole: where that fails, those that are new go again.
class Begun {
 public:
  void expect(const fs::path& file) {
    std::error_code none;
    if (!fs::exists(file, none)) new_.push_back(file);
  }
  void are_whole() { new_.clear(); }
  ~Begun() {
    std::error_code none;
    for (const fs::path& file : new_) fs::remove(file, none);
  }

 private:
  std::vector<fs::path> new_;
};

}  // namespace

void write_folder(const fs::path& folder, const Mechanism& mechanism, const std::vector<TextFile>& texts,
                  bool force, const std::vector<fs::path>& later) {
  const std::string main_text = mechanism_text(mechanism);
  std::vector<std::pair<fs::path, superelement::Superelement>> parts;
  std::set<std::string> written;
  std::vector<fs::path> files = {folder / "mechanism.toml"};
  for (const TextFile& text : texts) files.push_back(folder / text.name);
  for (const Body& body : mechanism.bodies) {
    if (body.surface.empty() || !written.insert(body.file()).second) continue;
    files.push_back(folder / "parts" / (body.file() + ".se.h5"));
    parts.emplace_back(files.back(), rigid_superelement(body, "flexura import: " + mechanism.name));
    superelement::validate(parts.back().second);
  }
  files.insert(files.end(), later.begin(), later.end());
  require_folder(folder);
  if (fs::is_symlink(folder / "parts"))
    throw std::invalid_argument((folder / "parts").string() +
                                ": is a link, and an import writes inside its folder only; remove the link");
  require_folder(folder / "parts");
  if (!force)
    for (const fs::path& file : files)
      if (fs::exists(fs::symlink_status(file)))
        throw std::invalid_argument(
            file.string() + ": is there already; name another folder, or replace its files with --force");
  for (const fs::path& file : files)
    if (fs::is_symlink(file))
      throw std::invalid_argument(
          file.string() + ": is a link, and an import writes inside its folder only; remove the link");
  const files::NewFolder made(files.size() > 1 ? folder / "parts" : folder);
  files::Claims claims;
  Begun begun;
  for (const fs::path& file : files) {
    claims.add(file);
    begun.expect(file);
  }
  for (const TextFile& text : texts) files::write_whole(folder / text.name, text.text);
  for (const auto& [path, se] : parts) superelement::write(path, se);
  files::write_whole(folder / "mechanism.toml", main_text);
  begun.are_whole();
}

}  // namespace flexura::import
