// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <limits>
#include <thread>

#include "mbs/base/hdf5/file.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/setup/scratch_place.hpp"

namespace flexura::superelement {
namespace {

using ::testing::HasSubstr;
using testing::make_box_beam;

constexpr Parts everything{.matrices = true,
                           .inertia = true,
                           .stiffening = true,
                           .surface = true,
                           .shapes = true,
                           .stress = true,
                           .sections = true,
                           .mesh_error = true};

Superelement complete_beam() {
  Superelement se = make_box_beam();
  const int n = se.n();
  StiffeningTerms& terms = se.stiffening.emplace();
  int seed = 1;
  const auto fill = [&](auto& matrices) {
    for (Eigen::MatrixXd& K : matrices) {
      K = Eigen::MatrixXd::NullaryExpr(
          n, n, [&](Eigen::Index i, Eigen::Index j) { return seed + 1.0 / static_cast<double>(1 + i + j); });
      ++seed;
    }
  };
  terms.K0F.resize(12);
  fill(terms.K0t);
  fill(terms.K0r);
  fill(terms.K0omega);
  fill(terms.K0F);
  se.load_cases.push_back({"steam", Eigen::VectorXd::LinSpaced(n, 0.1, 2.7),
                           Eigen::VectorXd::LinSpaced(3 * n, -1.1, 3.2).reshaped(3, n)});
  se.D_se = 1e-5 * se.K_se;
  se.load_cases.push_back({.name = "bolts",
                           .p_se = Eigen::VectorXd::LinSpaced(n, -0.1, 1.7),
                           .moment = Eigen::Matrix3Xd::Zero(3, n),
                           .is_preload = true});
  terms.K0p = {terms.K0t[0], terms.K0t[1]};
  StressModes& stress = se.stress.emplace();
  stress.of_loads = Eigen::MatrixXd::Constant(18, 2, 1.5e6);
  stress.vertices = {0, 2, 5};
  // Multiples of 1/8 pass through single precision unchanged.
  stress.S = Eigen::MatrixXd::NullaryExpr(
      18, n, [](Eigen::Index i, Eigen::Index k) { return 0.125 * static_cast<double>(7 * i - 3 * k); });
  stress.compliance = {Eigen::Matrix<double, 6, 6>::Constant(1e-12),
                       Eigen::Matrix<double, 6, 6>::Constant(3e-12)};
  stress.material = {1, 0, 1};
  MeshError& error = se.mesh_error.emplace();
  error.modes = {{.frequency_hz = 812.5, .error = 0.01, .stress = {.mean = 0.1, .peak = 0.25, .vertex = 3}},
                 {.frequency_hz = 900.0, .error = 1.0, .stress = {.singular = true}}};
  error.interfaces = {{.name = "big \"end\"", .compliance_error = 0.03, .stress = {.mean = 0.2}}};
  error.at_vertices = Eigen::VectorXf::LinSpaced(se.surface.vertices.rows(), 0.0f, 1.5f);
  SectionForces& sections = se.sections.emplace();
  sections.members = {"jib", "tie \"b\""};
  sections.member = {0, 0, 0, 0, 1, 1, 1, 1};
  sections.positions = Eigen::MatrixXd::Constant(8, 3, 1.0 / 3.0);
  sections.axes = Eigen::MatrixXd::Constant(8, 9, 0.6);
  const auto some = [](Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [](Eigen::Index i, Eigen::Index k) {
      return 0.1 * static_cast<double>(5 * i - 2 * k);
    });
  };
  sections.S = some(48, n);
  sections.of_acceleration = some(48, 12);
  sections.of_deformation = some(48, 9 * n).cast<float>();
  sections.turning = some(24, n);
  sections.of_stiffening = some(48, (12 + se.n_b + 2) * n).cast<float>();
  return se;
}

void expect_same(const Superelement& a, const Superelement& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.created_by, b.created_by);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.report_json, b.report_json);
  EXPECT_EQ(a.n_b, b.n_b);
  EXPECT_EQ(a.n_q, b.n_q);
  EXPECT_EQ(a.modal_damping, b.modal_damping);
  ASSERT_EQ(a.interfaces.size(), b.interfaces.size());
  for (std::size_t i = 0; i < a.interfaces.size(); ++i) {
    EXPECT_EQ(a.interfaces[i].name, b.interfaces[i].name);
    EXPECT_EQ(a.interfaces[i].tie, b.interfaces[i].tie);
    EXPECT_EQ(a.interfaces[i].p_BoN_B, b.interfaces[i].p_BoN_B);
    EXPECT_EQ(a.interfaces[i].directions, b.interfaces[i].directions);
    EXPECT_EQ(a.interfaces[i].first_dof, b.interfaces[i].first_dof);
  }
  EXPECT_EQ(a.K_se, b.K_se);
  EXPECT_EQ(a.M_se, b.M_se);
  EXPECT_EQ(a.D_se, b.D_se);
  EXPECT_EQ(a.omega2, b.omega2);
  EXPECT_EQ(a.inertia.mass, b.inertia.mass);
  EXPECT_EQ(a.inertia.S_x, b.inertia.S_x);
  EXPECT_EQ(a.inertia.S_xx, b.inertia.S_xx);
  EXPECT_EQ(a.inertia.S_phi, b.inertia.S_phi);
  EXPECT_EQ(a.inertia.S_xphi, b.inertia.S_xphi);
  EXPECT_EQ(a.inertia.S_phiphi, b.inertia.S_phiphi);
  ASSERT_EQ(a.stiffening.has_value(), b.stiffening.has_value());
  if (a.stiffening) {
    EXPECT_EQ(a.stiffening->K0t, b.stiffening->K0t);
    EXPECT_EQ(a.stiffening->K0r, b.stiffening->K0r);
    EXPECT_EQ(a.stiffening->K0omega, b.stiffening->K0omega);
    EXPECT_EQ(a.stiffening->K0F, b.stiffening->K0F);
    EXPECT_EQ(a.stiffening->K0p, b.stiffening->K0p);
  }
  ASSERT_EQ(a.load_cases.size(), b.load_cases.size());
  for (std::size_t i = 0; i < a.load_cases.size(); ++i) {
    EXPECT_EQ(a.load_cases[i].name, b.load_cases[i].name);
    EXPECT_EQ(a.load_cases[i].p_se, b.load_cases[i].p_se);
    EXPECT_EQ(a.load_cases[i].moment, b.load_cases[i].moment);
    EXPECT_EQ(a.load_cases[i].is_preload, b.load_cases[i].is_preload);
  }
  EXPECT_EQ(a.surface.vertices, b.surface.vertices);
  EXPECT_EQ(a.surface.triangles, b.surface.triangles);
  EXPECT_EQ(a.surface.edges, b.surface.edges);
  EXPECT_EQ(a.surface.triangle_interface, b.surface.triangle_interface);
  EXPECT_EQ(a.shapes, b.shapes);
  ASSERT_EQ(a.stress.has_value(), b.stress.has_value());
  if (a.stress) {
    EXPECT_EQ(a.stress->vertices, b.stress->vertices);
    EXPECT_EQ(a.stress->S, b.stress->S);
    EXPECT_EQ(a.stress->compliance, b.stress->compliance);
    EXPECT_EQ(a.stress->material, b.stress->material);
    EXPECT_EQ(a.stress->of_loads, b.stress->of_loads);
    EXPECT_EQ(a.stress->double_precision, b.stress->double_precision);
  }
  ASSERT_EQ(a.mesh_error.has_value(), b.mesh_error.has_value());
  if (a.mesh_error) {
    EXPECT_EQ(a.mesh_error->rough, b.mesh_error->rough);
    EXPECT_EQ(a.mesh_error->modes, b.mesh_error->modes);
    EXPECT_EQ(a.mesh_error->interfaces, b.mesh_error->interfaces);
    EXPECT_EQ(a.mesh_error->at_vertices, b.mesh_error->at_vertices);
  }
  ASSERT_EQ(a.sections.has_value(), b.sections.has_value());
  if (a.sections) {
    EXPECT_EQ(a.sections->members, b.sections->members);
    EXPECT_EQ(a.sections->member, b.sections->member);
    EXPECT_EQ(a.sections->positions, b.sections->positions);
    EXPECT_EQ(a.sections->axes, b.sections->axes);
    EXPECT_EQ(a.sections->S, b.sections->S);
    EXPECT_EQ(a.sections->of_acceleration, b.sections->of_acceleration);
    EXPECT_EQ(a.sections->of_deformation, b.sections->of_deformation);
    EXPECT_EQ(a.sections->turning, b.sections->turning);
    EXPECT_EQ(a.sections->of_stiffening, b.sections->of_stiffening);
  }
}

class SuperelementFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::flexura::test::scratch_place() / ("flexura_superelement_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "beam.se.h5";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string bytes() const {
    std::ifstream in(file_, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  }
  void put(const std::string& content) const { std::ofstream(file_, std::ios::binary) << content; }

  std::string refusal(const Parts& parts = {}) const {
    try {
      read(file_, parts);
    } catch (const std::runtime_error& failure) {
      return failure.what();
    }
    return "accepted";
  }

  // A file like ours, but for what the test leaves out.
  void write_root(const std::string& format, int version, const std::string& header) const {
    hdf5::File file(file_, hdf5::Mode::create);
    {
      hdf5::Group root = file.root();
      root.set("format", format);
      root.set("version", version);
      root.write_text("header", header, "");
      root.write_text("source", "", "");
      root.write_text("report", "", "");
    }
    file.close();
  }

  std::filesystem::path folder_, file_;
};

TEST_F(SuperelementFile, RoundTripIsBitExact) {
  const Superelement se = complete_beam();
  write(file_, se);
  expect_same(read(file_, everything), se);
  const std::string first = bytes();
  std::this_thread::sleep_for(std::chrono::milliseconds(1001));  // HDF5's time stamps are in seconds
  write(file_, se);
  EXPECT_EQ(bytes(), first);  // there are none: equal content gives equal files
}

TEST_F(SuperelementFile, StressModesKeepAllDigitsInDoublePrecision) {
  Superelement se = complete_beam();
  se.stress->S.array() += 1.0 / 3.0;
  write(file_, se);
  const Eigen::MatrixXd single = read(file_, everything).stress->S;
  EXPECT_NE(single, se.stress->S);
  // Half a unit in the last of 24 bits.
  EXPECT_LE(((single - se.stress->S).array() / se.stress->S.array()).abs().maxCoeff(), 1.0 / (1 << 24));
  se.stress->double_precision = true;
  write(file_, se);
  expect_same(read(file_, everything), se);
}

TEST_F(SuperelementFile, WorksWithoutTheOptionalParts) {
  Superelement se = make_box_beam();
  se.source.clear();
  se.surface = {};
  se.shapes.resize(0, 0);
  write(file_, se);
  expect_same(read(file_, everything), se);
}

// Every 23rd byte of the file, one bit or all eight turned. Either the reader refuses or the content is
// unharmed.
TEST_F(SuperelementFile, AFlippedByteIsNoticedOrHarmless) {
  const Superelement se = complete_beam();
  write(file_, se);
  const std::string good = bytes();
  int noticed = 0, harmless = 0;
  for (std::size_t at = 0; at < good.size(); at += 23) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ (at % 2 ? 0xFF : 1 << (at % 8)));
    put(bad);
    try {
      expect_same(read(file_, everything), se);
      ++harmless;
      ASSERT_FALSE(HasFailure()) << "silent damage at byte " << at;
    } catch (const std::runtime_error& failure) {
      ++noticed;
      ASSERT_THAT(failure.what(), HasSubstr("beam.se.h5"));
    }
  }
  // Most of the file means something; the rest is room that HDF5 leaves free in its blocks.
  EXPECT_GT(noticed, harmless);
}

TEST_F(SuperelementFile, AFlippedByteInAMatrixIsCalledDamage) {
  write(file_, complete_beam());
  const std::string good = bytes();
  int checksum = 0;
  for (std::size_t at = good.size() / 3; at < good.size(); at += good.size() / 40) {
    std::string bad = good;
    bad[at] = static_cast<char>(~bad[at]);
    put(bad);
    checksum +=
        refusal(everything).ends_with("its checksum does not match, the file is damaged; make it again");
  }
  EXPECT_GT(checksum, 10);
}

TEST_F(SuperelementFile, ATruncatedFileIsRefused) {
  write(file_, complete_beam());
  const std::string good = bytes();
  for (const std::size_t length : {good.size() - 1, good.size() / 2, good.size() / 10, std::size_t{100}}) {
    put(good.substr(0, length));
    EXPECT_THAT(refusal(), HasSubstr("beam.se.h5: the file is cut short; make it again")) << length;
  }
  put(good.substr(0, 20));
  EXPECT_THAT(refusal(), HasSubstr("beam.se.h5: "));
  put("");
  EXPECT_THAT(refusal(), HasSubstr("beam.se.h5: is not an HDF5 file"));
}

TEST_F(SuperelementFile, WhatIsNoSuperelementIsRefused) {
  EXPECT_THAT(refusal(), HasSubstr("beam.se.h5: there is no such file"));
  put("name = \"beam\"\n");
  EXPECT_THAT(refusal(), HasSubstr("beam.se.h5: is not an HDF5 file"));
  write_root("flexura results", 1, "{}");
  EXPECT_THAT(refusal(),
              HasSubstr("is an HDF5 file but not a superelement; make one with \"flexura reduce\""));
  write_root("flexura superelement", 7, "{}");
  EXPECT_THAT(refusal(),
              HasSubstr("is written in version 7 of the superelement format, this program reads up to 2; "
                        "update Flexura"));
  write_root("flexura superelement", 1, "{}");
  EXPECT_THAT(refusal(), HasSubstr("/header: cannot be understood"));
  write_root(
      "flexura superelement", 1,
      R"({"name":"x","created_by":"y","n_b":-6,"n_q":0,"modal_damping":0,"interfaces":[],"load_cases":[]})");
  EXPECT_THAT(refusal(), HasSubstr("n_b = -6 and n_q = 0 cannot be"));
  write_root(
      "flexura superelement", 1,
      R"({"name":"x","created_by":"y","n_b":6,"n_q":0,"modal_damping":0,"interfaces":[],"load_cases":[]})");
  EXPECT_THAT(refusal(), HasSubstr("/matrices: is missing; the file is not complete, make it again"));
}

// The counter of bytes read by this process, from the kernel.
long bytes_read_so_far() {
  std::ifstream io("/proc/self/io");
  std::string word;
  long count = 0;
  while (io >> word >> count) {
    if (word == "rchar:") return count;
  }
  return -1;
}

TEST_F(SuperelementFile, PartsThatAreNotWantedAreNotRead) {
  Superelement se = complete_beam();
  const int n_v = 20'000;  // a surface of 20,000 vertices, whose shapes do not compress
  se.surface.vertices.setRandom(n_v, 3);
  se.shapes.setRandom(3 * n_v, se.n());
  se.mesh_error->at_vertices.setRandom(n_v);
  write(file_, se);
  const long size = static_cast<long>(std::filesystem::file_size(file_));
  ASSERT_GT(size, 2'000'000);

  const long start = bytes_read_so_far();
  ASSERT_GE(start, 0) << "the kernel keeps no account";
  read(file_, {});
  const long lazily = bytes_read_so_far() - start;
  read(file_, everything);
  const long all = bytes_read_so_far() - start - lazily;
  EXPECT_LT(lazily, size / 10);
  EXPECT_GT(all, size * 8 / 10);

  // And damage in the shapes, which fill the last half of the file, does not keep anyone from simulating.
  std::string bad = bytes();
  bad[bad.size() * 3 / 4] = static_cast<char>(~bad[bad.size() * 3 / 4]);
  put(bad);
  EXPECT_EQ(refusal({}), "accepted");
  EXPECT_THAT(refusal(everything), HasSubstr("/shapes/surface: its checksum does not match"));
}

// Errors are relative, -1 or from 0 to 1; places are vertices of the surface.
TEST_F(SuperelementFile, AnEstimateOfTheMeshThatCannotBeIsRefused) {
  const auto refused = [&](const auto& spoil) {
    Superelement se = complete_beam();
    spoil(*se.mesh_error);
    EXPECT_THROW(write(file_, se), std::invalid_argument);
  };
  refused([](MeshError& e) { e.modes[0].error = std::numeric_limits<double>::quiet_NaN(); });
  refused([](MeshError& e) { e.modes[0].error = -0.5; });
  refused([](MeshError& e) { e.modes[0].frequency_hz = std::numeric_limits<double>::infinity(); });
  refused([](MeshError& e) { e.modes[0].stress.vertex = 100000; });
  refused([](MeshError& e) { e.interfaces[0].stress.peak = 2.0; });
  refused([](MeshError& e) { e.at_vertices.conservativeResize(2); });
}

TEST_F(SuperelementFile, ARefusedWriteLeavesNothingBehind) {
  Superelement se = complete_beam();
  se.K_se(3, 4) = std::nan("");
  EXPECT_THROW(write(file_, se), std::invalid_argument);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));

  write(file_, complete_beam());
  const std::string good = bytes();
  EXPECT_THROW(write(file_, se), std::invalid_argument);
  EXPECT_EQ(bytes(), good);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);

  try {
    write(folder_ / "nowhere" / "beam.se.h5", complete_beam());
    FAIL();
  } catch (const std::invalid_argument& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("nowhere does not exist; make it first"));
  }
}

}  // namespace
}  // namespace flexura::superelement
