// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>

/// What every target of tests/fuzz shares: the input as a text or a file, and what a reader may do with it.
/// Each target is one function, LLVMFuzzerTestOneInput, that libFuzzer calls in the preset fuzz and
/// replay.cpp for each file of findings/TARGET in the others.
namespace flexura::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A folder of this process, the place of all files.
inline const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const char* given =
        std::getenv("FLEXURA_FUZZ_FOLDER");  // who gives it clears it: libFuzzer ends without a word
    const std::filesystem::path base =
        given ? std::filesystem::path(given) : std::filesystem::temp_directory_path();
    const auto made = base / ("flexura-fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] {
      std::error_code ignored;
      std::filesystem::remove_all(folder(), ignored);
    });
    return made;
  }();
  return path;
}

inline std::filesystem::path file_of(const char* name, const std::string& text) {
  const auto path = folder() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

[[noreturn]] inline void found(const char* what, const char* words) {
  std::fprintf(stderr, "finding: %s: %s\n", what, words);
  std::abort();
}

/// Reads, or refuses in words of our own.  Anything else is a finding: an index out of range, a length that
/// no container takes, memory that no machine has, an error of a library.
template <class Read>
int judged(Read&& read) {
  try {
    read();
  } catch (const std::invalid_argument& refusal) {
    if (std::string(refusal.what()).find(' ') == std::string::npos)
      found("words of a library", refusal.what());
  } catch (const std::logic_error& error) {
    found("a mistake of ours", error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    found("words of a library", error.what());
  } catch (const std::runtime_error&) {
  } catch (const std::bad_alloc& error) {
    found("memory", error.what());
  } catch (const std::exception& error) {
    found("words of a library", error.what());
  } catch (...) {
    found("an exception that is none", "");
  }
  return 0;
}

}  // namespace flexura::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
