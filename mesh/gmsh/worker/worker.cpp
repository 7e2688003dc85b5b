// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// flexura-mesh: the child process in which gmsh and OpenCASCADE read and mesh a CAD file (see job.hpp).
#include <fcntl.h>
#include <gmsh.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <iterator>
#include <new>
#include <stdexcept>

#include "mesh/gmsh/job_text.hpp"
#include "mesh/gmsh/worker/read_mesh.hpp"
#include "mesh/gmsh/worker/sandbox.hpp"
#include "mesh/gmsh/worker/worker_curves.hpp"
#include "mesh/gmsh/worker/worker_picture.hpp"
#include "mesh/gmsh/worker/worker_planar.hpp"
#include "mesh/gmsh/worker/worker_progress.hpp"
#include "mesh/gmsh/worker/worker_sheet.hpp"
#include "mesh/gmsh/worker/worker_solids.hpp"
#include "mesh/gmsh/worker/worker_start.hpp"
#include "mesh/gmsh/worker/worker_surface.hpp"
#include "mesh/gmsh/worker/worker_volume.hpp"

namespace flexura::mesh {
namespace {

/// The job's file on its descriptor, under the name that gmsh is to read it by.  A script includes others beside it: it keeps
/// its own.
void open_file(Job& job) {
  if (job.path.empty() || job.format == "geo") return;
  const int opened = open(job.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) throw std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
  if (opened != kFileDescriptor) {
    dup2(opened, kFileDescriptor);
    close(opened);
  }
  job.path = kFileOfDescriptor;
}

/// gmsh, ready to read the job's file, and all that this process needs no more given up.
void start_gmsh(Job& job, ResultRecord& result) {
  open_file(job);
  if (job.format != "geo" && !enter_sandbox())  // a script is code that the user let run
    result.messages.push_back(
        "the mesher works without a sandbox: this kernel has no seccomp filters, which would keep a hostile "
        "file from programs, files and connections");
  // Where there is no sandbox it would leave preferences of its windows in the user's home.
  const char* const given = std::getenv("HOME");
  const std::string home = given ? given : "";
  setenv("HOME", "/proc", 1);
  gmsh::initialize(0, nullptr, false);
  given ? setenv("HOME", home.c_str(), 1) : unsetenv("HOME");
}

void run(const Job& job, ResultRecord& result, Arrays& arrays) {
  gmsh::option::setNumber("General.NumThreads", 1);
  gmsh::option::setNumber("General.Terminal", 1);  // into the log descriptor
  gmsh::option::setNumber("General.Verbosity", 3);
  // OpenCASCADE converts to mm, its default, for which its tolerances are made; gmsh can say so for STEP
  // only.
  if (job.format == "step") gmsh::option::setString("Geometry.OCCTargetUnit", "MM");
  gmsh::option::setNumber("Geometry.OCCImportLabels", 1);
  if (job.task == "read" || job.task == "read shells") {
    say(0, "reading the mesh");
    read_mesh(job.path, job.task == "read" ? 3 : 2, result, arrays);
    return;
  }
  const bool is_surface = job.format == "stl";
  if (is_surface && job.task != "list" && job.task != "picture" && job.task != "mesh")
    throw std::runtime_error(
        "is a surface of triangles, which bounds a solid; curves, sections and sheets are taken from STEP, "
        "IGES and "
        "BREP files");
  if (job.task == "curves") {
    say(0, "reading the curves");
    collect_curves(job, result, arrays);
    return;
  }
  if (job.task == "planar") {
    say(0, "meshing the section");
    mesh_planar_faces(job, result, arrays);
    return;
  }
  say(0, "reading the CAD file");
  if (job.task == "sheet") {
    mesh_sheet(job, result, arrays);
    return;
  }
  gmsh::vectorpair solids;
  if (is_surface) {
    solids = import_surface(job, result);
  } else {
    solids = import_solids(job, result);
    say(0.02, "measuring the solids");
    choose_solids(job, result, solids);
    if (job.fuse) fuse_solids(result, solids);
    if (job.heal) heal_solids(result, solids);
    gmsh::model::occ::synchronize();
    say(0.05, "measuring the faces");
    describe_kept(job, solids, result);
  }
  if (job.task == "picture") arrays = collect_picture(job, result);
  if (job.task != "mesh") return;
  generate_mesh(job, result);
  arrays = collect_mesh(job, solids, result);
  if (arrays.tetrahedra.empty()) {
    std::string last;
    gmsh::logger::getLastError(last);
    throw std::runtime_error("the volume was not filled" + (last.empty() ? "" : " (" + last + ")"));
  }
}

void write_all(const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = write(kResultDescriptor, at, size);
    if (n <= 0) throw std::runtime_error("cannot write the result");
    at += n;
    size -= static_cast<std::size_t>(n);
  }
}

template <class T>
void write_array(const std::vector<T>& values) {
  write_all(values.data(), values.size() * sizeof(T));
}

int work() {
  const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
  Job job = read_job(text);
  if (!start_worker(job.parent)) return 1;
  ResultRecord result;
  Arrays arrays;
  try {
    start_gmsh(job, result);
    run(job, result, arrays);
  } catch (const std::bad_alloc&) {
    result.error = "asks for more memory than there is; is it damaged?";
  } catch (const std::logic_error&) {  // of containers: a number that leads out of them
    result.error = "names things that it does not hold; is it damaged?";
  } catch (const std::exception& e) {
    result.error = e.what();
  } catch (const std::string& e) {  // gmsh throws strings
    result.error =
        e.find("OpenCASCADE exception") == std::string::npos
            ? e
            : "is given up by OpenCASCADE; it is damaged, or holds what OpenCASCADE does not know: save it "
              "again from the CAD program";
  } catch (...) {
    result.error = "OpenCASCADE or gmsh failed without a reason";
  }
  result.n_points = arrays.points.size() / 3;
  result.n_tetrahedra = arrays.tetrahedra.size() / (job.order == 2 ? 10 : 4);
  result.n_triangles = arrays.face.size();
  result.n_integers = arrays.integers.size();
  const std::string head = text_of(result);
  const std::uint64_t length = head.size();
  write_all(&length, sizeof length);
  write_all(head.data(), head.size());
  write_array(arrays.points);
  write_array(arrays.tetrahedra);
  write_array(arrays.triangles);
  write_array(arrays.face);
  write_array(arrays.integers);
  std::cout.flush();
  _exit(0);  // gmsh's own clean-up takes time and has been seen to crash; the result is complete
}

}  // namespace
}  // namespace flexura::mesh

int main() {
  try {
    return flexura::mesh::work();
  } catch (const std::exception& e) {
    std::cerr << "flexura-mesh works for flexura-reduce and is not started by hand: " << e.what() << '\n';
    return 2;
  }
}
