// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Runs a target without libFuzzer, in any build:
//     fuzz_TARGET FOLDER...                     every file of the folders: findings that were mended, and
//     seeds fuzz_TARGET --mutate SECONDS SEED FOLDER  random changes of them; a finding leaves its file
//     "last.TARGET"
#include <algorithm>
#include <chrono>
#include <iterator>
#include <random>
#include <vector>

#include "tests/fuzz/judge.hpp"

namespace {

std::vector<std::string> files_of(const std::vector<std::string>& folders, bool tell) {
  std::vector<std::filesystem::path> files;
  for (const std::string& folder : folders)
    if (std::filesystem::is_directory(folder))
      for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> texts;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    texts.emplace_back((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (tell) std::fprintf(stderr, "%s\n", file.c_str());
    if (tell)
      LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(texts.back().data()), texts.back().size());
  }
  return texts;
}

constexpr const char* odd_words[] = {
    "-1",     "0",         "1e308", "-1e308", "nan", "inf",     "9223372036854775807",
    "1e-308", "\"\"",      "[]",    "{}",     "[[",  "]]",      "\n\n",
    "= ",     "*",         "\x1b[", "\xff",   ",,",  "\"0,5\"", "2147483648",
    "..",     "/dev/zero", "-0.0"};

std::string mutated(std::string text, const std::vector<std::string>& seeds, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t times = 1 + below(6); times > 0; --times) {
    const std::size_t at = below(text.size() + 1),
                      length = std::min(text.size() - at, 1 + below(1u << below(9)));
    switch (below(8)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        if (at < text.size()) text[at] = static_cast<char>(random());
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(below(text.size() + 1), text.substr(at, length));
        break;
      case 4: {
        const std::string& other = seeds[below(seeds.size())];
        const std::size_t from = below(other.size() + 1);
        text.insert(at, other.substr(from, 1 + below(200)));
        break;
      }
      case 5:
        text.insert(at, odd_words[below(std::size(odd_words))]);
        break;
      case 6: {  // a number becomes another
        const std::size_t digit = text.find_first_of("0123456789", at);
        if (digit == std::string::npos) break;
        const std::size_t end = text.find_first_not_of("0123456789.eE+-", digit);
        text.replace(digit, end == std::string::npos ? end : end - digit,
                     odd_words[below(std::size(odd_words))]);
        break;
      }
      default: {  // two lines change places
        const std::size_t line = text.find('\n', at),
                          next = line == std::string::npos ? line : text.find('\n', line + 1);
        if (next != std::string::npos) {
          const std::string moved = text.substr(line, next - line);
          text.erase(line, next - line);
          text.insert(below(text.size() + 1), moved);
        }
      }
    }
  }
  return text;
}

int mutate(const std::string& name, double seconds, unsigned seed, const std::vector<std::string>& folders) {
  std::vector<std::string> seeds = files_of(folders, false);
  if (seeds.empty()) seeds.emplace_back();
  std::erase_if(seeds, [](const std::string& text) { return text.size() > 200'000; });
  std::mt19937 random(seed);
  const auto start = std::chrono::steady_clock::now();
  long n = 0;
  const std::string last = "last." + name;
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < seconds) {
    const std::string text = mutated(seeds[random() % seeds.size()], seeds, random);
    std::ofstream(last, std::ios::binary) << text;
    alarm(25);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    ++n;
  }
  std::filesystem::remove(last);
  std::printf("%s: %ld changed files read or refused\n", name.c_str(), n);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string name = std::filesystem::path(argv[0]).filename();
  if (words.size() > 3 && words[0] == "--mutate")
    return mutate(name, std::stod(words[1]), static_cast<unsigned>(std::stoul(words[2])),
                  {words.begin() + 3, words.end()});
  std::printf("%zu files read or refused\n", files_of(words, true).size());
}
