// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

/// Work on a sequence of items by a second thread, in their order, while the first one makes the next items.
/// Items are used again and again, so that their memory is.  What the work throws is thrown by the first
/// thread, at its next push() or drain(); the items behind it are left out.
namespace flexura::mbs {

template <class Item>
class BackgroundQueue {
 public:
  /// `beside` false: the work is done by push() itself.
  BackgroundQueue(std::function<void(Item&)> work, bool beside) : work_(std::move(work)), beside_(beside) {}
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;
  /// What was handed over is finished; what it throws now is lost.
  ~BackgroundQueue() {
    if (!thread_.joinable()) return;
    {
      const std::lock_guard lock(guard_);
      ends_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  /// The item to fill next.
  Item& next() {
    if (n_filled_ == filled_.size()) filled_.emplace_back();
    return filled_[n_filled_];
  }

  /// The item that next() gave is filled.
  void push() {
    ++n_filled_;
    if (!beside_) return work_off();
    // Waking a thread costs as much as some short steps: items go in batches, those of long steps at once.
    const auto now = Clock::now();
    if (n_filled_ == 1) since_ = now;
    if (n_filled_ < kBatch && now - since_ < kPatience) return;
    std::unique_lock lock(guard_);
    if (is_busy_ && n_filled_ < kMost) return;
    hand_over(lock);
  }

  /// Waits until all that was pushed is worked off.
  void drain() {
    if (thread_.joinable()) {
      std::unique_lock lock(guard_);
      wait(lock);
    }
    work_off();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kBatch = 16, kMost = 128;
  static constexpr auto kPatience = std::chrono::milliseconds(1);

  void work_off() {
    const std::size_t n = n_filled_;
    n_filled_ = 0;
    for (std::size_t i = 0; i < n; ++i) work_(filled_[i]);
  }

  void wait(std::unique_lock<std::mutex>& lock) {
    changed_.wait(lock, [&] { return !is_busy_; });
    if (failure_) {
      n_filled_ = 0;
      std::rethrow_exception(std::exchange(failure_, nullptr));
    }
  }

  void hand_over(std::unique_lock<std::mutex>& lock) {
    wait(lock);
    filled_.swap(handed_);
    n_handed_ = std::exchange(n_filled_, 0);
    is_busy_ = true;
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    lock.unlock();
    changed_.notify_all();
  }

  void run() {
    std::unique_lock lock(guard_);
    for (;;) {
      changed_.wait(lock, [&] { return is_busy_ || ends_; });
      if (!is_busy_) return;
      lock.unlock();
      std::exception_ptr failure;
      try {
        for (std::size_t i = 0; i < n_handed_; ++i) work_(handed_[i]);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      failure_ = failure;
      is_busy_ = false;
      changed_.notify_all();
    }
  }

  std::function<void(Item&)> work_;
  bool beside_;
  // The first thread's:
  std::vector<Item> filled_;
  std::size_t n_filled_ = 0;
  Clock::time_point since_;
  // The second thread's while is_busy_, else the first one's:
  std::vector<Item> handed_;
  std::size_t n_handed_ = 0;
  // Both threads', under guard_:
  std::mutex guard_;
  std::condition_variable changed_;
  bool is_busy_ = false, ends_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // the first one's; last, so that it starts when the rest is there
};

}  // namespace flexura::mbs
