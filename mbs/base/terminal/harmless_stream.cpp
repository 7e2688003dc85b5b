// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/harmless_stream.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ext/stdio_sync_filebuf.h>
#include <iostream>
#include <string>
#include <string_view>

#include "mbs/base/files/plain_text.hpp"
#include "mbs/base/terminal/sequences.hpp"

namespace flexura::terminal {
namespace {

struct Sink {
  int descriptor;
  bool is_terminal;
  std::string begun;  // of a character or a sequence that the next piece goes on with
};

/// The sequence that `text` begins with; empty where there is none. `is_cut`: it ends within one.
std::string_view sequence_at(std::string_view text, bool& is_cut) {
  for (const std::string_view sequence : kSequences) {
    if (text.starts_with(sequence)) return sequence;
    is_cut = is_cut || sequence.starts_with(text);
  }
  return {};
}

/// What of `text` may be written; the rest is left in `sink.begun`.
std::string harmless_part(Sink& sink, std::string_view text) {
  std::string out;
  for (std::size_t size = 0; !text.empty(); text.remove_prefix(size)) {
    bool is_cut = false;
    const std::string_view sequence = sink.is_terminal ? sequence_at(text, is_cut) : std::string_view();
    const files::Letter letter = files::first_letter(text);
    if (is_cut || letter.is_cut) break;
    size = sequence.empty() ? letter.size : sequence.size();
    if (sequence.empty() && letter.code != '\n' && letter.code != '\t' &&
        (!letter.is_whole || files::is_harmful(letter.code)))
      out += files::escaped(letter.code, letter.is_whole);
    else
      out += text.substr(0, size);
  }
  sink.begun = text;
  return out;
}

ssize_t write_to(void* cookie, const char* data, std::size_t size) {
  auto& sink = *static_cast<Sink*>(cookie);
  const std::string text = harmless_part(sink, sink.begun + std::string(data, size));
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(sink.descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return 0;  // the stream takes it for an error
    done += static_cast<std::size_t>(n);
  }
  return static_cast<ssize_t>(size);
}

/// The guarded streams live until the process ends, as those do in whose place they are.
std::FILE* guarded(int descriptor, std::FILE* otherwise, int buffering) {
  auto* const sink = new Sink{descriptor, ::isatty(descriptor) == 1, {}};
  std::FILE* const stream = ::fopencookie(sink, "w", {nullptr, write_to, nullptr, nullptr});
  if (stream == nullptr) return otherwise;
  std::setvbuf(stream, nullptr, sink->is_terminal && buffering == _IOFBF ? _IOLBF : buffering, 1 << 14);
  return stream;
}

}  // namespace

void guard_standard_streams() {
  static const bool done = [] {
    std::cout.flush();
    std::fflush(nullptr);
    // Beside these variables nothing knows the streams: glibc and libstdc++ take them anew at every call.
    stdout = guarded(STDOUT_FILENO, stdout, _IOFBF);
    stderr = guarded(STDERR_FILENO, stderr, _IONBF);
    std::cout.rdbuf(new __gnu_cxx::stdio_sync_filebuf<char>(stdout));
    std::cerr.rdbuf(new __gnu_cxx::stdio_sync_filebuf<char>(stderr));
    return true;
  }();
  static_cast<void>(done);
}

int descriptor_of(std::FILE* stream) {
  return stream == stdout ? STDOUT_FILENO : stream == stderr ? STDERR_FILENO : ::fileno(stream);
}

}  // namespace flexura::terminal
