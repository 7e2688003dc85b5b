// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/sdf/files.hpp"

#include "import/xml/node.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::sdf {

namespace fs = std::filesystem;

fs::path find_uri(const std::string& uri, const fs::path& file, const std::vector<std::string>& packages) {
  std::error_code none;
  const fs::path folder = fs::absolute(file).parent_path();
  const auto there = [&](const fs::path& path) { return fs::exists(path, none) ? path : fs::path(); };
  const auto scheme_end = uri.find("://");
  if (scheme_end == std::string::npos) return there(folder / uri);
  const std::string scheme = uri.substr(0, scheme_end), rest = uri.substr(scheme_end + 3);
  if (scheme == "file") return there(rest.starts_with("/") ? fs::path(rest) : folder / rest);
  if (scheme != "model" && scheme != "package") return {};
  const auto slash = rest.find('/');
  const std::string name = rest.substr(0, slash),
                    path = slash == std::string::npos ? "" : rest.substr(slash + 1);
  for (const std::string& given : packages)
    if (given.starts_with(name + "=")) return there(fs::path(given.substr(name.size() + 1)) / path);
  for (fs::path at = folder;; at = at.parent_path()) {
    for (const fs::path& base : {at.filename() == name ? at : fs::path(), at / name})
      if (!base.empty() && fs::exists(base / path, none)) return base / path;
    if (path.empty() && fs::is_regular_file(at / (name + ".sdf"), none)) return at / (name + ".sdf");
    if (at == at.parent_path()) return {};
  }
}

fs::path model_file(const fs::path& folder) {
  std::error_code none;
  if (fs::is_regular_file(folder, none)) return folder;
  fs::path best;
  double newest = -1.0;
  if (fs::is_regular_file(folder / "model.config", none)) {
    const xml::Node config = xml::read(folder / "model.config", "description of a model");
    for (const xml::Node* sdf : config.all("sdf")) {
      const double version = xml::parse_number(sdf->get("version", "0")).value_or(0.0);
      if (version > newest && fs::is_regular_file(folder / sdf->text, none)) {
        newest = version;
        best = folder / sdf->text;
      }
    }
  }
  if (best.empty() && fs::is_regular_file(folder / "model.sdf", none)) best = folder / "model.sdf";
  return best;
}

}  // namespace flexura::import::sdf
