// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/petsc/team.hpp"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

constexpr int kTag = 1;
constexpr std::size_t kPiece = std::size_t{1} << 30;  // MPI counts with 32 bits

// MPI waits by spinning, which takes a core from those that work.  False: not done within that time.
bool sleep_until_done(MPI_Request request,
                      std::chrono::steady_clock::duration most = std::chrono::steady_clock::duration::max()) {
  const auto start = std::chrono::steady_clock::now();
  for (int done = 0; !done;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (!done && std::chrono::steady_clock::now() - start > most) return false;
    if (!done) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return true;
}

std::vector<int> places(std::span<const int> counts) {
  std::vector<int> begin(counts.size(), 0);
  for (std::size_t r = 1; r < counts.size(); ++r) begin[r] = begin[r - 1] + counts[r - 1];
  return begin;
}

}  // namespace

Team::Team() {
  require_session();
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  int beside = 1;
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &beside);
  MPI_Comm_free(&machine);
  cores_each_ = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / beside);
}

Team::~Team() {
  if (rank_ == 0) call(Task::stop);
}

void Team::call(Task task) const {
  int number = static_cast<int>(task);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&number, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
  sleep_until_done(request);
}

Team::Task Team::wait() const {
  int number = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&number, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
  sleep_until_done(request);
  return static_cast<Task>(number);
}

void Team::send(const Message& message, int to) const {
  const std::size_t size = message.bytes().size();
  MPI_Send(&size, sizeof(size), MPI_BYTE, to, kTag, MPI_COMM_WORLD);
  for (std::size_t at = 0; at < size; at += kPiece)
    MPI_Send(message.bytes().data() + at, static_cast<int>(std::min(kPiece, size - at)), MPI_BYTE, to, kTag,
             MPI_COMM_WORLD);
}

Message Team::receive(int from) const {
  std::size_t size = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Irecv(&size, sizeof(size), MPI_BYTE, from, kTag, MPI_COMM_WORLD, &request);
  sleep_until_done(request);
  std::vector<std::byte> bytes(size);
  for (std::size_t at = 0; at < size; at += kPiece)
    MPI_Recv(bytes.data() + at, static_cast<int>(std::min(kPiece, size - at)), MPI_BYTE, from, kTag,
             MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return Message(std::move(bytes));
}

void Team::together(const std::function<void()>& work) const {
  try {
    work();
  } catch (const std::exception& error) {
    end_all(error.what());
  }
}

void Team::end_all(const char* text) const {
  std::fprintf(stderr, "error: process %d of %d: %s\n", rank_ + 1, size_, text);
  std::fflush(stderr);
  MPI_Abort(MPI_COMM_WORLD, 1);
  std::abort();  // MPI has ended this process
}

// All ranks come here when they have done their work or failed.  One that has failed does not wait for ever: others may be
// within a collective to which it will not come.
void Team::agree(const std::exception* failed) const {
  constexpr auto kPatience = std::chrono::seconds(60);
  const int mine = failed ? rank_ : size_;
  int first = size_;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(&mine, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD, &request);
  if (!failed)
    sleep_until_done(request);
  else if (!sleep_until_done(request, kPatience))
    end_all(failed->what());
  if (first == size_) return;
  std::string text;
  int size[2] = {0, 0};  // of the text, and whether the input is bad
  if (first == rank_) {
    text = failed->what();
    size[0] = static_cast<int>(text.size());
    size[1] = dynamic_cast<const std::invalid_argument*>(failed) != nullptr;
  }
  MPI_Bcast(size, 2, MPI_INT, first, MPI_COMM_WORLD);
  text.resize(static_cast<std::size_t>(size[0]));
  MPI_Bcast(text.data(), size[0], MPI_CHAR, first, MPI_COMM_WORLD);
  if (first != rank_) throw Elsewhere(text, size[1] != 0);
}

void Team::in_step(const std::function<void()>& work) const {
  try {
    try {
      work();
      agree(nullptr);
    } catch (const Elsewhere&) {
      throw;
    } catch (const std::bad_alloc&) {
      end_all("memory has run out; more machines bring more of it, or take a coarser mesh");
    } catch (const std::exception& error) {
      agree(&error);
      throw;
    }
  } catch (const Elsewhere& there) {
    if (there.bad_input) throw std::invalid_argument(there.what());
    throw std::runtime_error(there.what());
  }
}

void Team::meet() const {
  agree(nullptr);
}

void Team::share(int& number) const {
  MPI_Bcast(&number, 1, MPI_INT, 0, MPI_COMM_WORLD);
}

void Team::share(double& number) const {
  MPI_Bcast(&number, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

void Team::share(std::span<double> numbers) const {
  MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

void Team::sum(std::span<double> numbers) const {
  MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, MPI_SUM,
                MPI_COMM_WORLD);
}

double Team::greatest(double number) const {
  MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return number;
}

void Team::scatter(const double* all, std::span<const int> counts, double* own) const {
  const std::vector<int> begin = places(counts);
  MPI_Scatterv(all, counts.data(), begin.data(), MPI_DOUBLE, own, counts[rank_], MPI_DOUBLE, 0,
               MPI_COMM_WORLD);
}

void Team::gather(const double* own, std::span<const int> counts, double* all) const {
  const std::vector<int> begin = places(counts);
  MPI_Gatherv(own, counts[rank_], MPI_DOUBLE, all, counts.data(), begin.data(), MPI_DOUBLE, 0,
              MPI_COMM_WORLD);
}

}  // namespace flexura::linalg
