// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Same input, same numbers: two reductions and two runs of one input write the same files to the bit, but for
// the times and the memory that are measured (docs/reliability.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;

/// JSON without what is measured; other texts as they are.
std::string without_measured(const std::string& text) {
  nlohmann::ordered_json value = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!value.is_structured()) return text;
  const std::function<void(nlohmann::ordered_json&)> strip = [&](nlohmann::ordered_json& in) {
    if (in.is_object())
      for (const char* const key :
           {"seconds", "processor_seconds", "peak_memory_bytes", "wall_time", "real_time_factor"})
        in.erase(key);
    if (in.is_structured())
      for (auto& part : in) strip(part);
  };
  strip(value);
  return value.dump();
}

/// The bytes of a data set or an attribute, by the functions of the one or the other.
std::string bytes_of(hid_t type, hid_t space, const std::function<herr_t(hid_t, void*)>& read) {
  const auto n = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> texts(n, nullptr);
    if (read(type, texts.data()) < 0) return "unreadable";
    std::string all;
    for (char* text : texts) {
      if (text != nullptr) all += without_measured(text);
      H5free_memory(text);
    }
    return all;
  }
  std::string raw(n * H5Tget_size(type), '\0');
  if (!raw.empty() && read(type, raw.data()) < 0) return "unreadable";
  return raw.starts_with('{') ? without_measured(raw.substr(0, raw.find('\0'))) : raw;
}

/// Every data set and attribute of a file by its path.
std::map<std::string, std::string> contents(const fs::path& file) {
  std::map<std::string, std::string> all;
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const auto visit = [](hid_t root, const char* name, const H5O_info_t* info, void* to) -> herr_t {
    auto& out = *static_cast<std::map<std::string, std::string>*>(to);
    const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
    if (info->type == H5O_TYPE_DATASET) {
      const hid_t type = H5Dget_type(object), space = H5Dget_space(object);
      out[name] = bytes_of(type, space, [&](hid_t as, void* data) {
        return H5Dread(object, as, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
      });
      H5Tclose(type);
      H5Sclose(space);
    }
    for (hsize_t k = 0; k < info->num_attrs; ++k) {
      const hid_t attribute =
          H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, k, H5P_DEFAULT, H5P_DEFAULT);
      const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
      char label[200] = "";
      H5Aget_name(attribute, sizeof label, label);
      if (H5Tget_class(type) != H5T_REFERENCE && H5Tget_class(type) != H5T_VLEN)
        out[std::string(name) + "@" + label] =
            bytes_of(type, space, [&](hid_t as, void* data) { return H5Aread(attribute, as, data); });
      H5Tclose(type);
      H5Sclose(space);
      H5Aclose(attribute);
    }
    H5Oclose(object);
    return 0;
  };
  H5Ovisit2(id, H5_INDEX_NAME, H5_ITER_INC, visit, &all, H5O_INFO_ALL);
  H5Fclose(id);
  return all;
}

void expect_same(const fs::path& a, const fs::path& b, std::size_t least) {
  const auto in_a = contents(a), in_b = contents(b);
  EXPECT_GE(in_a.size(), least) << "the test sees the file";
  ASSERT_EQ(in_a.size(), in_b.size());
  for (const auto& [name, bytes] : in_a)
    EXPECT_TRUE(in_b.contains(name) && in_b.at(name) == bytes) << a.filename() << ": " << name;
}

const std::string kFound = FLEXURA_SOURCE_DIR "/tests/found/";

TEST(Repeatable, ReductionsOfOneInputAreTheSameToTheBit) {
  for (const std::vector<std::string>& part : std::vector<std::vector<std::string>>{
           {kFound + "reduce/response_two_frequencies.toml"},
           // Meshed; several fronts and many blocks of vectors, shared by two threads.
           {FLEXURA_SOURCE_DIR "/cases/cad_parts/bracket.toml", "--set", "mesh.size=14 mm", "--threads", "2"},
           {kFound + "safe/beam/h.toml", "--set", "member.blade.elements=4", "--set", "modes.count=4"}}) {
    const Folder a, b;
    for (const Folder* f : {&a, &b}) {
      std::vector<std::string> words = {"reduce", "-q", "-o", *f / "part.se.h5"};
      words.insert(words.end(), part.begin(), part.end());
      const Outcome outcome = run("flexura", words);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    expect_same(a / "part.se.h5", b / "part.se.h5", 20);
  }
}

TEST(Repeatable, RunsOfOneInputAreTheSameToTheBit) {
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    const Folder a, b;
    for (const Folder* f : {&a, &b}) {
      const Outcome outcome =
          run("flexura", {"simulate", kFound + "rigid/check_integrator_noise.toml", "-q", "--end-time", "0.1",
                          "-o", *f / "run.h5", "--save-state", *f / "state.json", "--csv",
                          "--check-integrator", "--set", std::string("solver.method=") + method});
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    expect_same(a / "run.h5", b / "run.h5", 10);
    for (const char* const text : {"state.json", "run.run.csv"}) {
      EXPECT_FALSE(read_text(a / text).empty()) << text;
      EXPECT_EQ(read_text(a / text), read_text(b / text)) << method;
    }
  }
}

}  // namespace
}  // namespace flexura::test
