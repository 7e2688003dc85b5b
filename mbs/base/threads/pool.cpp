// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/threads/pool.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace flexura::threads {
namespace {

std::atomic<int> wanted{0};  // 0: as many as cores

class Pool {
 public:
  ~Pool() {
    {
      const std::lock_guard lock(guard_);
      ends_ = true;
    }
    begins_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  void run(int n, const std::function<void(int)>& work, int most) {
    std::unique_lock<std::mutex> sole;
    if (n > 1 && most > 1 && !is_worker_) sole = std::unique_lock(busy_, std::try_to_lock);
    if (!sole.owns_lock()) {
      for (int i = 0; i < n; ++i) work(i);
      return;
    }
    const int helpers = grow(std::min(n, most) - 1);
    {
      const std::lock_guard lock(guard_);
      work_ = &work;
      n_ = n;
      next_ = 0;
      error_ = nullptr;
      places_ = working_ = helpers;
      ++round_;
    }
    begins_.notify_all();
    is_worker_ = true;
    share();
    is_worker_ = false;
    std::unique_lock lock(guard_);
    ended_.wait(lock, [&] { return working_ == 0; });
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  // So many threads beside the caller's, or as many as there are to have.
  int grow(int helpers) {
    try {
      while (static_cast<int>(threads_.size()) < helpers) threads_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {
    }
    return std::min(helpers, static_cast<int>(threads_.size()));
  }

  void serve() {
    is_worker_ = true;
    std::uint64_t seen = 0;
    std::unique_lock lock(guard_);
    for (;;) {
      begins_.wait(lock, [&] { return ends_ || (round_ != seen && places_ > 0); });
      if (ends_) return;
      seen = round_;
      --places_;
      lock.unlock();
      share();
      lock.lock();
      if (--working_ == 0) ended_.notify_one();
    }
  }

  void share() {
    try {
      for (int i = next_++; i < n_; i = next_++) (*work_)(i);
    } catch (...) {
      const std::lock_guard lock(guard_);
      if (!error_) error_ = std::current_exception();
      next_ = n_;
    }
  }

  static thread_local bool is_worker_;
  std::mutex busy_;  // held by the thread whose work is shared
  std::mutex guard_;
  std::condition_variable begins_, ended_;
  std::vector<std::thread> threads_;
  const std::function<void(int)>* work_ = nullptr;
  int n_ = 0;
  std::atomic<int> next_{0};
  std::exception_ptr error_;
  int places_ = 0;   // for helpers in this round that are free
  int working_ = 0;  // helpers that have not ended this round
  std::uint64_t round_ = 0;
  bool ends_ = false;
};
thread_local bool Pool::is_worker_ = false;

}  // namespace

int count() {
  const int n = wanted;
  return n > 0 ? n : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void set_count(int n) {
  wanted = std::max(1, n);
}

void parallel_for(int n, const std::function<void(int)>& work, int most) {
  static Pool pool;
  pool.run(n, work, most > 0 ? most : count());
}

}  // namespace flexura::threads
