// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace flexura::view::testing {

namespace fs = std::filesystem;
using nlohmann::json;

/// A file of this name, not there yet, in a folder of the tests'.
inline fs::path scratch(const std::string& name) {
  const fs::path directory = fs::path(::testing::TempDir()) / "flexura-view";
  fs::create_directories(directory);
  fs::remove(directory / name);
  return directory / name;
}

inline std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A reader of pages written from PAGE.md alone: it shares no code with the writer.
class PageReader {
 public:
  explicit PageReader(std::string text) : text_(std::move(text)) {
    const std::string open = "<script type=\"application/json\" id=\"header\">";
    const auto from = text_.find(open) + open.size();
    header = json::parse(text_.substr(from, text_.find("</script>", from) - from));
  }

  template <typename T>
  std::vector<T> block(const std::string& name) const {
    const auto start = text_.find("data-block=\"" + name + "\"");
    if (start == std::string::npos) throw std::runtime_error("no block " + name);
    const auto from = text_.find('>', start) + 1;
    const auto packed = from_base64(text_.substr(from, text_.find('<', from) - from));
    std::vector<unsigned char> planes(1 << 20);
    uLongf size = planes.size();
    int status = Z_BUF_ERROR;
    while ((status = uncompress(planes.data(), &size, packed.data(), packed.size())) == Z_BUF_ERROR) {
      planes.resize(planes.size() * 4);
      size = planes.size();
    }
    if (status != Z_OK) throw std::runtime_error("damaged block " + name);
    std::vector<T> values(size / sizeof(T));
    for (std::size_t i = 0; i < values.size(); ++i) {
      unsigned char bytes[sizeof(T)];
      for (std::size_t k = 0; k < sizeof(T); ++k) bytes[k] = planes[k * values.size() + i];
      std::memcpy(&values[i], bytes, sizeof(T));
    }
    return values;
  }

  /// u of a shape, 3 n_v.
  std::vector<double> shape(const std::string& key, int j) const { return field(key, "shape", j, 3); }

  /// A field with C components of each vertex, by PAGE.md's rule: "shape" or "stress".
  std::vector<double> field(const std::string& key, const std::string& kind, int j,
                            std::size_t components) const {
    const json& surface = header.at("surface");
    const auto rest = block<std::uint16_t>(key + "/" + kind + "/" + std::to_string(j));
    const auto triangles = block<std::int32_t>(key + "/triangles"),
               parent = block<std::int32_t>(key + "/parent");
    const std::size_t n = surface.at("vertices");
    const double scale =
        surface.at("shapes").at(static_cast<std::size_t>(j)).at(kind == "shape" ? "scale" : "stress");
    std::vector<int> q(components * n, 0);
    std::vector<bool> met(n, false);
    std::size_t place = 0, last = n;
    const auto decode = [&](std::size_t v, auto guess) {
      for (std::size_t a = 0; a < components; ++a) {
        const int code = rest[a * n + place];
        const int difference = code % 2 == 1 ? -(code + 1) / 2 : code / 2;
        q[components * v + a] = static_cast<std::int16_t>(static_cast<std::uint16_t>(guess(a) + difference));
      }
      met[v] = true;
      last = v;
      ++place;
    };
    const auto from_last = [&](std::size_t a) { return last == n ? 0 : q[components * last + a]; };
    for (std::size_t t = 0; t < parent.size(); ++t) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::size_t v = static_cast<std::size_t>(triangles[3 * t + corner]);
        if (met[v]) continue;
        if (parent[t] < 0) {
          decode(v, from_last);
          continue;
        }
        // Corners of both triangles, each once: those of the shared edge come twice.
        std::map<std::int32_t, int> uses;
        for (std::size_t k = 0; k < 3; ++k) {
          ++uses[triangles[3 * t + k]];
          ++uses[triangles[3 * static_cast<std::size_t>(parent[t]) + k]];
        }
        decode(v, [&](std::size_t a) {
          int guess = 0;
          for (const auto& [w, times] : uses) {
            if (static_cast<std::size_t>(w) != v)
              guess += (times == 2 ? 1 : -1) * q[components * static_cast<std::size_t>(w) + a];
          }
          return guess;
        });
      }
    }
    for (std::size_t v = 0; v < n; ++v) {
      if (!met[v]) decode(v, from_last);
    }
    std::vector<double> u;
    for (const int value : q) u.push_back(scale * value);
    return u;
  }

  json header;

 private:
  static std::vector<unsigned char> from_base64(const std::string& text) {
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<unsigned char> bytes;
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : text) {
      if (c == '=') break;
      bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
      held += 6;
      if (held >= 8) {
        held -= 8;
        bytes.push_back(static_cast<unsigned char>(bits >> held));
        bits &= (1u << held) - 1;
      }
    }
    return bytes;
  }

  std::string text_;
};

}  // namespace flexura::view::testing
