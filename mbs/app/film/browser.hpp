// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

/// A browser of this machine, run without a window, that shows a page and answers to its script: the Chrome DevTools protocol over two
/// inherited descriptors (--remote-debugging-pipe), so that nothing listens on the network.
namespace flexura::app {

/// $FLEXURA_BROWSER, else the first Chromium of PATH under its usual names.  Throws std::runtime_error, with the remedy, where
/// there is none.
std::filesystem::path find_browser();

class Browser {
 public:
  /// `wide` x `high` [px]: of its window.  Throws std::runtime_error where it does not start.
  Browser(const std::filesystem::path& program, int wide, int high);
  /// Ends it and removes its profile.
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Opens a page from disk and waits until it stands; throws std::runtime_error with what the page says where it cannot be shown.
  void open(const std::filesystem::path& html);
  /// The value of an expression on the page, awaited; throws std::runtime_error with the message of what it throws.
  nlohmann::json evaluate(const std::string& expression);

 private:
  /// Lenient: an empty object where the browser refuses.
  nlohmann::json call(const std::string& method, const nlohmann::json& params, bool is_lenient = false);
  void send(const std::string& message);
  nlohmann::json receive();
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_as_ended() const;

  std::filesystem::path program_, profile_;
  pid_t pid_ = -1;
  int to_ = -1, from_ = -1, log_ = -1;
  std::string session_, buffer_;
  int calls_ = 0;
};

}  // namespace flexura::app
