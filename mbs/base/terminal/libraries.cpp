// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/libraries.hpp"

#include <link.h>

#include <filesystem>
#include <set>

namespace flexura::terminal {

std::string loaded_libraries() {
  std::set<std::string> names;
  ::dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        std::error_code failure;
        const auto file = std::filesystem::canonical(info->dlpi_name, failure);  // links lead to the version
        if (failure || info->dlpi_name[0] == '\0') return 0;
        const std::string name = file.filename().string();
        // What they bring along themselves (HDF5 a web client) computes nothing here.
        for (const char* const known :
             {"libhdf5",     "libsundials", "libklu",          "libcholmod",       "libumfpack",
              "libmuparser", "libfmt",      "libtoml",         "libtinyxml2",      "libpetsc",
              "libslepc",    "libgmsh",     "libmetis",        "libmpi.",          "libTKernel",
              "libopenblas", "libblas",     "libmumps_common", "liburdfdom_model", "liborocos-kdl",
              "libz."})
          if (name.starts_with(known)) {
            static_cast<std::set<std::string>*>(out)->insert(name);
            break;
          }
        return 0;
      },
      &names);
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace flexura::terminal
