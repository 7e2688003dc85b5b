// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <fstream>

#include "mbs/base/files/output.hpp"
#include "mbs/base/files/table_text.hpp"
#include "mbs/results/csv_name.hpp"
#include "mbs/results/results.hpp"

namespace flexura::results {
namespace {

void write_run(const Run& run, const std::filesystem::path& path) {
  std::ofstream out(path, std::ios::binary);
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "time [s]");
  for (const Quantity& quantity : run.quantities) {
    fmt::format_to(
        std::back_inserter(line), ",{}",
        files::csv_field(quantity.name + (quantity.unit.empty() ? "" : " [" + quantity.unit + "]")));
  }
  line.push_back('\n');
  for (Eigen::Index t = 0; t < run.time.size(); ++t) {
    fmt::format_to(std::back_inserter(line), "{}",
                   run.time[t]);  // the shortest text that reads back as the same double
    for (Eigen::Index i = 0; i < run.values.cols(); ++i) {
      fmt::format_to(std::back_inserter(line), ",{}", run.values(t, i));
    }
    line.push_back('\n');
    if (line.size() > 1 << 16) {
      out.write(line.data(), static_cast<std::streamsize>(line.size()));
      line.clear();
    }
  }
  out.write(line.data(), static_cast<std::streamsize>(line.size()));
  out.close();
  if (!out)
    throw std::runtime_error(path.string() +
                             ": cannot be written; check the folder, its permissions and the disk");
}

}  // namespace

std::filesystem::path csv_name(const std::filesystem::path& path, const std::string& run) {
  std::filesystem::path target = path;
  return target.replace_extension("." + run + ".csv");
}

std::vector<std::filesystem::path> write_csv(const Results& results, const std::filesystem::path& path) {
  std::vector<std::filesystem::path> written;
  for (const Run& run : results.runs) {
    const std::filesystem::path target = csv_name(path, run.name);
    files::Output output(target);
    write_run(run, output.part());
    output.commit();
    written.push_back(target);
  }
  return written;
}

}  // namespace flexura::results
