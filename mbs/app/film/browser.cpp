// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/film/browser.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "mbs/base/files/signals.hpp"

extern char** environ;

namespace flexura::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array kNames = {"chromium",       "chromium-browser", "google-chrome", "google-chrome-stable",
                               "microsoft-edge", "brave-browser"};
// What --remote-debugging-pipe reads from and writes to.
constexpr int kCommands = 3, kAnswers = 4;

/// file:///..., with everything but plain letters, digits and slashes written as %XX.
std::string address_of(const fs::path& file) {
  std::string text = "file://";
  for (const char c : fs::absolute(file).string()) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) || std::strchr("/-._~", c);
    text += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return text;
}

/// Out of the way of the child's numbers, and closed in every other child.
int above_standard(int fd) {
  const int moved = ::fcntl(fd, F_DUPFD_CLOEXEC, 10);
  ::close(fd);
  return moved;
}

}  // namespace

fs::path find_browser() {
  if (const char* const named = std::getenv("FLEXURA_BROWSER"); named && *named) {
    if (::access(named, X_OK) != 0)
      throw std::runtime_error(
          fmt::format("FLEXURA_BROWSER is '{}', which is no program: give the path of a Chromium", named));
    return named;
  }
  const char* const path = std::getenv("PATH");
  for (const char* const name : kNames) {
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
      if (const fs::path program = fs::path(folder) / name;
          !folder.empty() && ::access(program.c_str(), X_OK) == 0)
        return program;
  }
  throw std::runtime_error(fmt::format(
      "a film is drawn by a browser, and none is in PATH ({}): install Debian's chromium, or name another "
      "one of its family "
      "in FLEXURA_BROWSER; without one, write the page (-o) and press M on it where there is a browser",
      fmt::join(kNames, ", ")));
}

Browser::Browser(const fs::path& program, int wide, int high) : program_(program) {
  std::string profile = (fs::temp_directory_path() / "flexura-film-XXXXXX").string();
  if (!::mkdtemp(profile.data()))
    throw std::runtime_error(fmt::format("cannot make the folder '{}': {}", profile, std::strerror(errno)));
  profile_ = profile;
  int commands[2], answers[2];
  log_ = ::memfd_create("browser", MFD_CLOEXEC);
  if (log_ < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, commands) != 0 ||
      ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, answers) != 0)
    fail(std::string("no descriptors are left for it: ") + std::strerror(errno));
  to_ = above_standard(commands[0]);
  from_ = above_standard(answers[0]);
  const int child_reads = above_standard(commands[1]), child_writes = above_standard(answers[1]);

  std::vector<std::string> words = {
      program_.string(), "--headless=new", "--remote-debugging-pipe", "--user-data-dir=" + profile,
      fmt::format("--window-size={},{}", wide, high), "--no-first-run", "--no-default-browser-check",
      "--disable-background-networking", "--disable-extensions", "--mute-audio", "--hide-scrollbars",
      // A machine without a graphics card draws in software.
      "--enable-unsafe-swiftshader", "about:blank"};
  // Its sandbox refuses to run as root, as in containers; the page is our own and asks the network for nothing.
  if (::geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  for (const auto& [fd, as] :
       {std::pair{log_, 1}, {log_, 2}, {child_reads, kCommands}, {child_writes, kAnswers}})
    posix_spawn_file_actions_adddup2(&actions, fd, as);
  const int error = ::posix_spawn(&pid_, program_.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(child_reads);
  ::close(child_writes);
  if (error != 0) {
    pid_ = -1;
    fail(std::strerror(error));
  }
}

Browser::~Browser() {
  for (const int fd : {to_, from_, log_})
    if (fd >= 0) ::close(fd);
  if (pid_ > 0) {
    // Without its pipe it ends by itself, and all its processes with it.
    for (int i = 0; i < 50 && ::waitpid(pid_, nullptr, WNOHANG) == 0; ++i) {
      if (i == 30) ::kill(pid_, SIGKILL);
      ::usleep(100'000);
    }
  }
  std::error_code ignored;
  fs::remove_all(profile_, ignored);
}

void Browser::fail(const std::string& what) const {
  throw std::runtime_error(
      fmt::format("the browser '{}' did not draw the film: {}", program_.string(), what));
}

void Browser::fail_as_ended() const {
  std::string said(4000, '\0');
  const off_t size = ::lseek(log_, 0, SEEK_END);
  const ssize_t n = ::pread(log_, said.data(), said.size(), std::max<off_t>(0, size - 4000));
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(0, n)));
  while (said.ends_with('\n')) said.pop_back();
  fail("it has ended" + (said.empty() ? "" : ", and said: " + said.substr(said.rfind('\n') + 1)));
}

void Browser::send(const std::string& message) {
  // With the zero at its end, which parts messages.
  for (std::size_t done = 0; done <= message.size();) {
    const ssize_t n = ::send(to_, message.c_str() + done, message.size() + 1 - done, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_as_ended();
    done += static_cast<std::size_t>(n);
  }
}

json Browser::receive() {
  std::size_t searched = 0;
  while (true) {
    if (const auto end = buffer_.find('\0', searched); end != std::string::npos) {
      json message = json::parse(buffer_.substr(0, end), nullptr, false);
      buffer_.erase(0, end + 1);
      return message;
    }
    searched = buffer_.size();
    if (files::StopRequests::wanted()) fail("the program was told to end");
    pollfd event{from_, POLLIN, 0};
    if (::poll(&event, 1, 200) <= 0) continue;
    std::array<char, 1 << 16> part;
    const ssize_t n = ::read(from_, part.data(), part.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail_as_ended();
    buffer_.append(part.data(), static_cast<std::size_t>(n));
  }
}

json Browser::call(const std::string& method, const json& params, bool is_lenient) {
  const int id = ++calls_;
  json message = {{"id", id}, {"method", method}, {"params", params}};
  if (!session_.empty()) message["sessionId"] = session_;
  send(message.dump());
  while (true) {
    const json answer = receive();
    if (!answer.is_object()) fail("it does not answer as a Chromium does");
    if (answer.value("method", "") == "Inspector.targetCrashed")
      fail("the page has crashed: too little memory");
    if (answer.value("id", 0) != id) continue;  // an event
    if (answer.contains("error") && is_lenient) return json::object();
    if (answer.contains("error")) fail(answer["error"].value("message", method));
    return answer.at("result");
  }
}

void Browser::open(const fs::path& html) {
  const json target = call("Target.createTarget", {{"url", address_of(html)}});
  session_ =
      call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}}).at("sessionId");
  call("Inspector.enable", json::object());
  // The page may not have begun to load: until then there is nothing to ask.
  const std::string look =
      "document.documentElement?.dataset.ready === 'failed' ? document.querySelector('.failure "
      "p').textContent "
      ": document.documentElement?.dataset.ready ?? ''";
  json state = "";
  for (int i = 0; state == ""; ++i) {
    if (i == 2400) fail("the page does not stand after two minutes");
    ::usleep(50'000);
    state = call("Runtime.evaluate", {{"expression", look}, {"returnByValue", true}}, true)
                .value("/result/value"_json_pointer, json(""));
  }
  if (state != "true") fail(state.get<std::string>());
}

json Browser::evaluate(const std::string& expression) {
  const json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (const auto failed = answer.find("exceptionDetails"); failed != answer.end()) {
    std::string text = failed->value("/exception/description"_json_pointer,
                                     failed->value("text", "the page's script failed"));
    fail(text.substr(0, text.find('\n')));
  }
  return answer.at("result").value("value", json());
}

}  // namespace flexura::app
