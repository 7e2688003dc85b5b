// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What an Eigen matrix does when memory runs out while it changes its size: it has freed its old numbers, the new
// ones are refused, std::bad_alloc is thrown, and the destructor frees the old ones again (Eigen 3.4,
// DenseStorage::resize).  A program that then wants to say so in a sentence, and to keep the rows it has, dies of
// that.  Linked with --wrap=malloc and --wrap=free, this remembers what was freed just before a request that was
// refused: the next free() of that address does nothing, and until then no request of ours gets it.
#include <array>
#include <cstddef>

extern "C" {
// The linker's names.
void* __real_malloc(std::size_t size);  // NOLINT
void __real_free(void* place);          // NOLINT
void* __wrap_malloc(std::size_t size);  // NOLINT
void __wrap_free(void* place);          // NOLINT
}

namespace {

struct Freed {
  void* last = nullptr;
  std::array<void*, 32> dangling{};
  std::size_t n = 0;

  bool take(const void* place) {
    for (std::size_t i = 0; i < n; ++i)
      if (dangling[i] == place) {
        dangling[i] = dangling[--n];
        return true;
      }
    return false;
  }
  bool has(const void* place) const {
    for (std::size_t i = 0; i < n; ++i)
      if (dangling[i] == place) return true;
    return false;
  }
};

thread_local constinit Freed freed;

}  // namespace

void* __wrap_malloc(std::size_t size) {
  void* place = __real_malloc(size);
  if (place == nullptr) {
    if (size > 0 && freed.last != nullptr && freed.n < freed.dangling.size())
      freed.dangling[freed.n++] = freed.last;
    freed.last = nullptr;
  }
  while (freed.n > 0 && place != nullptr && freed.has(place)) place = __real_malloc(size);
  return place;
}

void __wrap_free(void* place) {
  if (place == nullptr || (freed.n > 0 && freed.take(place))) return;
  freed.last = place;
  __real_free(place);
}
