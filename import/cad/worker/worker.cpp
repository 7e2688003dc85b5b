// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-assembly: the child process in which OpenCASCADE reads an assembly (see job.hpp). A file that crashes or hangs it
// ends this process only.
#include <unistd.h>

#include <iostream>
#include <iterator>
#include <new>

#include "import/cad/job.hpp"
#include "import/cad/worker/worker_assembly.hpp"
#include "mesh/gmsh/job.hpp"
#include "mesh/gmsh/worker/sandbox.hpp"
#include "mesh/gmsh/worker/worker_start.hpp"

namespace flexura::import::cad {
namespace {

int work() {
  const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
  const AssemblyJob job = nlohmann::json::parse(text).get<AssemblyJob>();
  if (!mesh::start_worker(job.parent)) return 1;
  AssemblyAnswer answer;
  if (!mesh::enter_sandbox())
    answer.notes.push_back(
        "OpenCASCADE works without a sandbox: this kernel has no seccomp filters, which would keep a hostile "
        "file from programs, "
        "files and connections");
  try {
    read_step(job, answer);
  } catch (const std::bad_alloc&) {
    answer.error = "asks for more memory than there is; is it damaged?";
  } catch (const std::exception& e) {
    answer.error = e.what();
  } catch (...) {
    answer.error = "made OpenCASCADE fail without a reason";
  }
  const std::vector<std::uint8_t> bytes = nlohmann::json::to_cbor(nlohmann::json(answer));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = write(mesh::kResultDescriptor, bytes.data() + done, bytes.size() - done);
    if (n <= 0) return 1;
    done += static_cast<std::size_t>(n);
  }
  std::cout.flush();
  _exit(0);  // the kernel's own clean-up takes time; the answer is complete
}

}  // namespace
}  // namespace flexura::import::cad

int main() {
  try {
    return flexura::import::cad::work();
  } catch (const std::exception& e) {
    std::cerr << "flexura-assembly works for flexura-import and is not started by hand: " << e.what() << '\n';
    return 2;
  }
}
