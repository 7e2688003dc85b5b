// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/contents.hpp"

#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::superelement {

Contents contents(const std::filesystem::path& path) {
  Contents out{read(path, {.matrices = false, .inertia = false}), {}};
  const hdf5::File file(path, hdf5::Mode::read);
  const hdf5::Group root = file.root();
  const auto size = [&](const std::string& part) {
    double sum = 0.0;
    if (!root.has(part)) return sum;
    const hdf5::Group group = root.group(part);
    for (const std::string& name : group.names()) {
      double entries = sizeof(double);
      for (const std::size_t extent : group.shape(name)) entries *= static_cast<double>(extent);
      sum += entries;
    }
    return sum;
  };
  out.bytes = {size("matrices"), size("inertia"), size("stiffening"),
               size("surface"),  size("shapes"),  size("stress")};
  return out;
}

}  // namespace flexura::superelement
