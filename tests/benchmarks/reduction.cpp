// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "mbs/superelement/file.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/linalg/session/session.hpp"
#include "reduce/linalg/session/user_options.hpp"
#include "reduce/part/make_part.hpp"
#include "reduce/superelement/surface.hpp"
#include "reduce/superelement/to_superelement.hpp"

/// The reduction of one CAD part against its own factorisation, against Krylov-Schur and against CalculiX,
/// all on one mesh.  bench_reduction NAME PART.toml SIZE MODES [krylov] [one_basis] [slice=MODES] [packages] [calculix] [file]
/// [petsc=OPTIONS] [tolerance=1e-8]; with `one_basis` and `slice=` also without and with slices of the spectrum, with `packages`
/// also on the factors of other solver packages, with `petsc=` also by other options, with `file` the factor is kept in a file
namespace flexura::reduce {
namespace {

void print(const std::string& name, double value, const char* unit) {
  fmt::print("{} = {:.6g} {}\n", name, value, unit);
  std::fflush(stdout);
}

struct Timed {
  Reduction reduction;
  double seconds = 0.0;
};

Timed reduce(const Part& part, const ReductionOptions& options) {
  linalg::Stopwatch watch;
  Timed timed{craig_bampton(part, options), 0.0};
  timed.seconds = watch.lap();
  return timed;
}

/// From the factorisation to the projection.
double core_seconds(const ReductionReport& r) {
  return r.factor.seconds_numeric + r.seconds_constraint_modes + r.seconds_normal_modes +
         r.seconds_projection;
}

void print_stages(const std::string& name, const Timed& timed) {
  const ReductionReport& r = timed.reduction.report;
  print(name + ".assembly", r.seconds_assembly, "s");
  print(name + ".ordering", r.factor.seconds_ordering + r.factor.seconds_symbolic, "s");
  print(name + ".factorisation", r.factor.seconds_numeric, "s");
  print(name + ".constraint_modes", r.seconds_constraint_modes, "s");
  print(name + ".normal_modes", r.seconds_normal_modes, "s");
  print(name + ".projection", r.seconds_projection, "s");
  print(name + ".estimate", r.seconds_estimate, "s");
  print(name + ".certificate", r.seconds_certificate, "s");
  print(name + ".right_hand_sides", r.solved_right_hand_sides, "1");
  print(name + ".greatest_residual", r.mode_residual.maxCoeff(), "1");
  print(name + ".modes_certified", r.certified_modes, "1");
}

/// The same mesh and material as a CalculiX deck, the interfaces' nodes held: what fixed-interface modes are.
void write_deck(const Part& part, const std::filesystem::path& file, double E, double nu, int n_modes) {
  std::ofstream out(file);
  const mesh::Mesh& mesh = part.mesh;
  out << "*NODE, NSET=ALL\n";
  for (mesh::Index n = 0; n < mesh.n_nodes(); ++n)
    out << fmt::format("{},{:.13g},{:.13g},{:.13g}\n", n + 1, mesh.points(n, 0), mesh.points(n, 1),
                       mesh.points(n, 2));
  out << "*ELEMENT, TYPE=C3D10, ELSET=PART\n";
  mesh::Index element = 0;
  for (const mesh::CellBlock& block : mesh.solids)
    for (Eigen::Index c = 0; c < block.nodes.rows(); ++c) {
      out << ++element;
      for (Eigen::Index k = 0; k < block.nodes.cols(); ++k) out << ',' << block.nodes(c, k) + 1;
      out << '\n';
    }
  out << "*NSET, NSET=HELD\n";
  for (const InterfaceSpec& interface : part.interfaces)
    for (const mesh::Index node : interface.set.nodes) out << node + 1 << "\n";
  out << fmt::format(
      "*BOUNDARY\nHELD, 1, 3\n*MATERIAL, NAME=M\n*ELASTIC\n{:.13g}, {:.13g}\n*DENSITY\n{:.13g}\n"
      "*SOLID SECTION, ELSET=PART, MATERIAL=M\n*STEP\n*FREQUENCY\n{}\n*END STEP\n",
      E, nu, part.materials.front().density, n_modes);
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
}

/// The frequencies of ccx's .dat file [Hz].
std::vector<double> read_frequencies(const std::filesystem::path& file, int n_modes) {
  std::ifstream in(file);
  std::vector<double> hertz;
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    int mode = 0;
    double eigenvalue = 0.0, radians = 0.0, cycles = 0.0;
    if (words >> mode >> eigenvalue >> radians >> cycles && mode == static_cast<int>(hertz.size()) + 1)
      hertz.push_back(cycles);
    if (static_cast<int>(hertz.size()) == n_modes) break;
  }
  return hertz;
}

double greatest_difference(const Reduction& ours, const std::vector<double>& hertz) {
  double worst = 0.0;
  for (std::size_t k = 0; k < hertz.size(); ++k)
    worst =
        std::max(worst, std::abs(frequency_hz(ours.omega2(static_cast<Eigen::Index>(k))) / hertz[k] - 1.0));
  return worst;
}

void against_calculix(const std::string& name, const PartInput& input, Part part, const Timed& ours,
                      const ReductionOptions& options, const std::filesystem::path& folder) {
  // E and nu of the isotropic D: D_12 = lambda, D_44 = mu.
  const Matrix6& D = part.materials.front().D;
  const double lambda = D(0, 1), mu = D(3, 3);
  write_deck(part, folder / "part.inp", mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
             0.5 * lambda / (lambda + mu), options.n_modes);
  linalg::Stopwatch watch;
  const std::string command = fmt::format(
      "cd '{}' && OMP_NUM_THREADS=2 OPENBLAS_NUM_THREADS=2 ccx part >ccx.txt 2>&1", folder.string());
  if (std::system("command -v ccx >/dev/null") != 0) {
    fmt::print(stderr, "ccx (Debian's calculix-ccx) is not there: no comparison\n");
    return;
  }
  const int status = std::system(command.c_str());
  const double seconds = watch.lap();
  const std::vector<double> hertz = read_frequencies(folder / "part.dat", options.n_modes);
  if (status != 0 || static_cast<int>(hertz.size()) < options.n_modes) {
    fmt::print(stderr, "{}: ccx found {} of {} modes (status {})\n", input.where, hertz.size(),
               options.n_modes, status);
    return;
  }
  print(name + ".calculix", seconds, "s");
  print(name + ".calculix_over_ours", seconds / ours.seconds, "1");
  print(name + ".difference_to_calculix", greatest_difference(ours.reduction, hertz), "1");
  part.mass = MassKind::reduced;
  ReductionOptions like_ccx = options;
  like_ccx.certify = like_ccx.estimate_error = false;
  print(name + ".difference_to_calculix_with_its_mass",
        greatest_difference(reduce(part, like_ccx).reduction, hertz), "1");
}

/// The same reduction on factors of other packages; block low-rank ones are less accurate, which the residuals show.
void against_packages(const std::string& name, const Part& part, const Timed& ours,
                      const ReductionOptions& options) {
  const std::string mumps = "-pc_factor_mat_solver_type mumps",
                    low_rank = mumps + " -mat_mumps_icntl_35 2 -mat_mumps_cntl_7 ";
  const std::pair<std::string, std::string> packages[] = {{"cholmod", "-pc_factor_mat_solver_type cholmod"},
                                                          {"mumps", mumps},
                                                          {"mumps_low_rank_1e-12", low_rank + "1e-12"},
                                                          {"mumps_low_rank_1e-10", low_rank + "1e-10"},
                                                          {"mumps_low_rank_1e-8", low_rank + "1e-8"}};
  for (const auto& [package, text] : packages) try {
      const linalg::UserOptions user(linalg::parse_options(text));
      const double before = linalg::processor_seconds();
      const Timed theirs = reduce(part, options);
      const ReductionReport& r = theirs.reduction.report;
      const std::string their_name = name + "." + package;
      print_stages(their_name, theirs);
      print(their_name + ".core", core_seconds(r), "s");
      print(their_name + ".processor", linalg::processor_seconds() - before, "s");
      print(their_name + ".core_over_ours", core_seconds(r) / core_seconds(ours.reduction.report), "1");
      const Eigen::VectorXd &a = ours.reduction.omega2, &b = theirs.reduction.omega2;
      if (a.size() == b.size())
        print(their_name + ".difference", 0.5 * ((b - a).array() / a.array()).abs().maxCoeff(), "1");
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}.{}: {}\n", name, package, error.what());
    }
}

/// Another way to the same modes, by options of PETSc.
void against_options(const std::string& name, const std::string& text, const Part& part, const Timed& ours,
                     ReductionOptions options) {
  options.certify = options.estimate_error = false;
  const linalg::UserOptions user(linalg::parse_options(text));
  const double before = linalg::processor_seconds();
  const Timed theirs = reduce(part, options);
  const ReductionReport& r = theirs.reduction.report;
  print(name + ".normal_modes", r.seconds_normal_modes, "s");
  print(name + ".right_hand_sides", r.solved_right_hand_sides, "1");
  print(name + ".processor", linalg::processor_seconds() - before, "s");
  print(name + ".greatest_residual", r.mode_residual.maxCoeff(), "1");
  print(name + "_over_ours", r.seconds_normal_modes / ours.reduction.report.seconds_normal_modes, "1");
  const Eigen::VectorXd &a = ours.reduction.omega2, &b = theirs.reduction.omega2;
  const Eigen::Index n = std::min(a.size(), b.size());
  print(name + ".difference", 0.5 * ((b.head(n) - a.head(n)).array() / a.head(n).array()).abs().maxCoeff(),
        "1");
}

/// What follows a word that begins like this.
std::string value_of(const std::set<std::string>& words, const std::string& begin,
                     const std::string& otherwise) {
  const auto found = words.lower_bound(begin);
  return found != words.end() && found->substr(0, begin.size()) == begin ? found->substr(begin.size())
                                                                         : otherwise;
}

/// A misspelt word would be a comparison that is not made.
void refuse_unknown(const std::set<std::string>& words) {
  const std::set<std::string> known = {"krylov", "one_basis", "packages", "calculix", "file"};
  for (const std::string& word : words)
    if (!known.contains(word) && !word.starts_with("slice=") && !word.starts_with("petsc=") &&
        !word.starts_with("tolerance="))
      throw std::invalid_argument("bench_reduction does not know the word '" + word + "'");
}

void run(const std::string& name, const std::filesystem::path& file, const std::string& size, int n_modes,
         const std::set<std::string>& words) {
  refuse_unknown(words);
  PartInput input = read_part(file, {"mesh.size=" + size, fmt::format("modes.count={}", n_modes)});
  input.cad.worker = FLEXURA_BIN_DIR "/flexura-mesh";
  const ModelledPart modelled = make_part(input, load_part_mesh(input, {}));
  const Part& part = modelled.part;
  std::vector<std::vector<mesh::Index>> interface_nodes;
  for (const InterfaceSpec& interface : part.interfaces) interface_nodes.push_back(interface.set.nodes);
  SurfacePicture picture = make_surface(part.mesh, interface_nodes);

  ReductionOptions options;
  options.n_modes = n_modes;
  options.tolerance = std::stod(value_of(words, "tolerance=", "1e-8"));
  options.certify = true;
  if (words.contains("file")) options.storage.place = linalg::FactorStorage::Place::file;
  options.shape_nodes = picture.nodes;
  const double before = linalg::processor_seconds();
  Timed ours = reduce(part, options);
  const double processor = linalg::processor_seconds() - before;
  const ReductionReport r = ours.reduction.report;
  print(name + ".dofs", r.n_i + r.n_b, "1");
  print_stages(name, ours);
  print(name + ".core", core_seconds(r), "s");
  print(name + ".processor", processor, "s");
  print(name + ".factor", r.factor.bytes / 1e9, "GB");
  print(name + ".peak_memory", r.peak_memory_bytes / 1e9, "GB");
  print(name + ".core_over_factorisation", core_seconds(r) / r.factor.seconds_numeric, "1");

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("flexura_bench_{}", std::random_device{}());
  std::filesystem::create_directories(folder);
  if (words.contains("packages")) against_packages(name, part, ours, options);
  if (words.contains("one_basis"))
    against_options(name + ".one_basis", "-eps_blocklanczos_slice 0", part, ours, options);
  for (const std::string& word : words)
    if (word.substr(0, 6) == "slice=")
      against_options(name + ".slices_of_" + word.substr(6), "-eps_blocklanczos_slice " + word.substr(6),
                      part, ours, options);
  int n_others = 0;
  for (const std::string& word : words)
    if (word.substr(0, 6) == "petsc=") {
      fmt::print("# {}.other_{}: {}\n", name, ++n_others, word.substr(6));
      against_options(fmt::format("{}.other_{}", name, n_others), word.substr(6), part, ours, options);
    }
  if (words.contains("krylov")) {
    ReductionOptions plain = options;
    plain.eigensolver = Eigensolver::krylov_schur;
    plain.certify = plain.estimate_error = false;
    const double start = linalg::processor_seconds();
    const Timed theirs = reduce(part, plain);
    const double seconds = theirs.reduction.report.seconds_normal_modes;
    print(name + ".krylov_schur.processor", linalg::processor_seconds() - start, "s");
    print(name + ".krylov_schur.normal_modes", seconds, "s");
    print(name + ".krylov_schur.core_over_factorisation",
          core_seconds(theirs.reduction.report) / theirs.reduction.report.factor.seconds_numeric, "1");
    print(name + ".krylov_schur_over_ours", seconds / r.seconds_normal_modes, "1");
  }
  if (words.contains("calculix")) against_calculix(name, input, part, ours, options, folder);
  linalg::Stopwatch watch;
  superelement::write(folder / "part.se.h5",
                      to_superelement(input, std::move(ours.reduction), std::move(picture.surface), "{}"));
  const double writing = watch.lap();
  print(name + ".writing", writing, "s");
  print(name + ".all_over_factorisation", (ours.seconds + writing) / r.factor.seconds_numeric, "1");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace flexura::reduce

int main(int argc, char** argv) {
  if (argc < 5) {
    fmt::print(
        stderr,
        "usage: bench_reduction NAME PART.toml SIZE MODES [krylov] [one_basis] [slice=MODES] [packages] "
        "[calculix] [file] [petsc=OPTIONS] [tolerance=1e-8]\n");
    return 2;
  }
  const flexura::linalg::Session session;
  try {
    flexura::reduce::run(argv[1], argv[2], argv[3], std::stoi(argv[4]), {argv + 5, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
  return 0;
}
