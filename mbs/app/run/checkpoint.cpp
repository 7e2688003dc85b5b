// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/json_text.hpp"
#include "mbs/base/files/left_behind.hpp"
#include "mbs/base/files/output.hpp"

namespace flexura::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kRowsOpening = "flexura rows 1\n";
constexpr const char* kFormat = "flexura checkpoint";
enum Kind : std::uint64_t { run_begins = 1, row = 2, run_ends = 3 };
// No record is larger: a row of a million states.
constexpr std::uint64_t kLargestRecord = std::uint64_t{1} << 26;

fs::path with(const fs::path& path, const char* ending) {
  fs::path out = path;
  return out += ending;
}

std::string checksum(json value) {
  value.erase("checksum");
  return input::ContentHash().add(value.dump()).hex();
}

std::vector<double> plain(const Eigen::VectorXd& x) {
  return {x.begin(), x.end()};
}
Eigen::VectorXd vector_of(const json& values) {
  const auto v = values.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

using Energies = std::array<double*, 10>;
Energies numbers(mbs::EnergyAccount& e) {
  return {&e.now.kinetic, &e.now.strain, &e.now.potential, &e.now.input_power, &e.now.dissipated_power,
          &e.start,       &e.work_in,    &e.dissipated,    &e.gross_work,      &e.peak};
}
std::array<long*, 7> numbers(mbs::StepCounts& c) {
  return {&c.steps,           &c.evaluations, &c.jacobians,         &c.error_failures,
          &c.newton_failures, &c.restarts,    &c.singular_crossings};
}
std::array<double*, 5> numbers(mbs::RunMemory& m) {
  return {&m.largest_energy_error, &m.peak_position_drift, &m.peak_velocity_drift, &m.good_step,
          &m.wall_time};
}
template <class Places>
json list_of(const Places& places) {
  json out = json::array();
  for (const auto* x : places) out.push_back(*x);
  return out;
}
template <class Places>
void take(const json& from, const Places& places) {
  if (from.size() != places.size()) throw std::invalid_argument("a list is cut short");
  for (std::size_t i = 0; i < places.size(); ++i) from[i].get_to(*places[i]);
}

json to_json(mbs::RunMemory m) {
  const mbs::State& s = m.continuation.state;
  json events = json::array();
  for (const mbs::RootEvent& e : m.events) events.push_back({e.t, e.which, e.jumped});
  return {{"method", m.continuation.method},
          {"time", s.t},
          {"p", plain(s.p)},
          {"v", plain(s.v)},
          {"c", plain(s.c)},
          {"a", plain(s.a)},
          {"lambda", plain(s.lambda)},
          {"switches", s.root},
          {"v_dot", plain(m.continuation.v_dot)},
          {"energy", list_of(numbers(m.continuation.energy))},
          {"next_row", m.continuation.next_row},
          {"history", m.continuation.history},
          {"counts", list_of(numbers(m.counts))},
          {"figures", list_of(numbers(m))},
          {"events", events}};
}

mbs::RunMemory memory_from(const json& in) {
  mbs::RunMemory m;
  mbs::State& s = m.continuation.state;
  in.at("method").get_to(m.continuation.method);
  in.at("time").get_to(s.t);
  s.p = vector_of(in.at("p"));
  s.v = vector_of(in.at("v"));
  s.c = vector_of(in.at("c"));
  s.a = vector_of(in.at("a"));
  s.lambda = vector_of(in.at("lambda"));
  in.at("switches").get_to(s.root);
  m.continuation.v_dot = vector_of(in.at("v_dot"));
  take(in.at("energy"), numbers(m.continuation.energy));
  in.at("next_row").get_to(m.continuation.next_row);
  in.at("history").get_to(m.continuation.history);
  take(in.at("counts"), numbers(m.counts));
  take(in.at("figures"), numbers(m));
  for (const json& e : in.at("events"))
    m.events.push_back({e.at(0).get<double>(), e.at(1).get<int>(), e.at(2).get<bool>()});
  return m;
}

struct Record {
  std::uint64_t kind = 0;
  std::string content;
};
std::string packed(std::uint64_t kind, std::string_view content) {
  const std::uint64_t head[2] = {kind, content.size()};
  std::string out(reinterpret_cast<const char*>(head), sizeof head);
  return out += content;
}
/// The next record that ends before `end`; false behind the last.
bool next(std::ifstream& in, std::uint64_t end, Record& record) {
  const auto at = static_cast<std::uint64_t>(in.tellg());
  std::uint64_t head[2];
  if (at + sizeof head > end || !in.read(reinterpret_cast<char*>(head), sizeof head)) return false;
  if (head[1] > kLargestRecord || at + sizeof head + head[1] > end) return false;
  record.kind = head[0];
  record.content.resize(head[1]);
  return static_cast<bool>(in.read(record.content.data(), static_cast<std::streamsize>(head[1])));
}
std::ifstream open_rows(const fs::path& file) {
  files::require_no_device(file);
  std::ifstream in(file, std::ios::binary);
  std::string opening(kRowsOpening.size(), ' ');
  in.read(opening.data(), static_cast<std::streamsize>(opening.size()));
  if (!in || opening != kRowsOpening) in.setstate(std::ios::failbit);
  return in;
}

/// The checkpoint as it was written; throws std::invalid_argument with what is wrong with it.
json read_whole(const fs::path& file) {
  files::require_no_device(file);
  std::ifstream in(file);
  if (!in) throw std::invalid_argument("there is no such file");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  json out = files::try_read_json(text);
  if (out.is_discarded() || !out.is_object() || !out.contains("format") || out["format"] != kFormat)
    throw std::invalid_argument("is not a checkpoint");
  if (!out.contains("checksum") || out["checksum"] != checksum(out))
    throw std::invalid_argument("is damaged: its checksum does not fit");
  if (out.at("version") != 1) throw std::invalid_argument("is of another version of Flexura");
  return out;
}

}  // namespace

CheckpointFiles::CheckpointFiles(const fs::path& output)
    : newest(with(output, ".checkpoint")),
      before(with(output, ".checkpoint.before")),
      rows(with(output, ".checkpoint.rows")) {}

json identity_of_runs(const MechanismArguments& arguments, const json& options) {
  input::ContentHash model, states;
  model.add_input_file(arguments.file);
  if (!arguments.from_state.empty()) states.add_file(arguments.from_state);
  return {{"Flexura", FLEXURA_VERSION},
          {"mechanism file or a file that it names", model.hex()},
          {"--from-state", states.hex()},
          {"--state", arguments.state},
          {"--set", arguments.set},
          {"--run", arguments.runs},
          {"options", options}};
}

// --- Reading
// -------------------------------------------------------------------------------------------------

Resumption::Resumption(const fs::path& output, const json& identity) : files_(output) {
  std::string trouble;
  json found;
  for (const fs::path& file : {files_.newest, files_.before}) try {
      found = read_whole(file);
      // The rows that belong to it.
      ends_.clear();
      size_ = found.at("rows_size");
      input::ContentHash hash;
      std::ifstream in = open_rows(files_.rows);
      Record record;
      std::string run;
      while (in && next(in, size_, record)) {
        hash.add(packed(record.kind, record.content));
        if (record.kind == run_begins) run = record.content;
        if (record.kind == run_ends) ends_[run] = files::read_json(record.content);
      }
      if (found.at("rows_checksum").get<std::string>() != hash.hex())
        throw std::invalid_argument("its rows in " + files_.rows.string() + " are damaged or of another run");
      run_ = found.at("run");
      interval_ = found.at("interval");
      memory_ = found.at("memory");
      break;
    } catch (const std::exception& failure) {
      trouble += fmt::format("{}{}: {}", trouble.empty() ? "" : "; ", file.string(), failure.what());
      found = json();
    }
  if (found.is_null())
    throw std::invalid_argument(
        fmt::format("there is no checkpoint to go on from ({}); leave --continue out", trouble));
  if (!trouble.empty()) note_ = fmt::format("{}; going on from the checkpoint before", trouble);
  const json& theirs = found.at("identity");
  for (const auto& [what, value] : identity.items())
    if (!theirs.contains(what) || theirs[what] != value)
      throw std::invalid_argument(fmt::format(
          "{}: is of another run: {} differ{} from what the run that was cut had{}; give the same, or leave "
          "--continue out",
          files_.newest.string(), what, what.starts_with("options") ? "" : "s",
          theirs.contains(what) && what != "mechanism file or a file that it names" && what != "--from-state"
              ? fmt::format(" ({} instead of {})", value.dump(), theirs[what].dump())
              : ""));
}

const json* Resumption::end_of(const std::string& run) const {
  const auto found = ends_.find(run);
  return found == ends_.end() ? nullptr : &found->second;
}

void Resumption::replay(const std::string& wanted, const mbs::Mechanism& mechanism,
                        const StoredRow& give) const {
  const mbs::Sizes n = mechanism.sizes();
  const Eigen::Index n_states = n.n_p + n.n_v + n.n_dyn + n.n_alg + n.n_lambda + n.n_root;
  std::ifstream in = open_rows(files_.rows);
  Record record;
  std::string run;
  while (next(in, size_, record)) {
    if (record.kind == run_begins) run = record.content;
    if (record.kind != row || run != wanted) continue;
    Eigen::VectorXd x(static_cast<Eigen::Index>(record.content.size() / sizeof(double)));
    std::memcpy(x.data(), record.content.data(), static_cast<std::size_t>(x.size()) * sizeof(double));
    const Eigen::Index n_v_dot = x.size() - 4 - n_states;
    if (n_v_dot != 0 && n_v_dot != n.n_v)
      throw std::invalid_argument(
          fmt::format("{}: its rows are of another mechanism; leave --continue out", files_.rows.string()));
    give(unpack(mechanism, x(0), x.segment(4, n_states)), x.tail(n_v_dot), EnergyRow{x(1), x(2), x(3)});
  }
}

mbs::RunMemory Resumption::memory(const mbs::Mechanism&) const {
  try {
    return memory_from(memory_);
  } catch (const json::exception&) {
    throw std::invalid_argument(files_.newest.string() +
                                ": what it remembers cannot be read; leave --continue out");
  }
}

// --- Writing
// -------------------------------------------------------------------------------------------------

struct Checkpoints::RowsFile {
  explicit RowsFile(const fs::path& path) : path(path) {}
  ~RowsFile() {
    if (file) std::fclose(file);
  }
  [[noreturn]] void fail() const {
    throw std::runtime_error(
        fmt::format("{}: the rows of the checkpoints cannot be written: {}; check the folder and the disk",
                    path.string(), std::strerror(errno ? errno : ENOSPC)));
  }
  void write(std::string_view text) {
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), file) != text.size()) fail();
    size += text.size();
  }
  void synchronise() {
    errno = 0;
    if (std::fflush(file) != 0 || ::fdatasync(::fileno(file)) != 0) fail();
  }

  fs::path path;
  std::optional<files::Output> output;  // until the first checkpoint
  std::FILE* file = nullptr;
  std::uint64_t size = 0;
  input::ContentHash hash;
};

Checkpoints::Checkpoints(const fs::path& output, double interval, json identity, const Resumption* from)
    : files_(output),
      interval_(interval),
      identity_(std::move(identity)),
      rows_(std::make_unique<RowsFile>(files_.rows)) {
  if (from == nullptr) {
    rows_->output.emplace(files_.rows);
    rows_->file = std::fopen(rows_->output->part().c_str(), "wbe");
    if (rows_->file == nullptr) rows_->fail();
    rows_->write(kRowsOpening);
    return;
  }
  {
    std::ifstream in = open_rows(files_.rows);
    for (Record record; next(in, from->size(), record);) rows_->hash.add(packed(record.kind, record.content));
  }
  rows_->size = from->size();
  rows_->file = std::fopen(files_.rows.c_str(), "r+be");
  if (rows_->file == nullptr || ::ftruncate(::fileno(rows_->file), static_cast<off_t>(from->size())) != 0 ||
      std::fseek(rows_->file, 0, SEEK_END) != 0)
    rows_->fail();
  run_ = from->run();
  any_ = true;
}

Checkpoints::~Checkpoints() = default;

void Checkpoints::put(std::uint64_t kind, std::string_view content) {
  const std::string record = packed(kind, content);
  rows_->write(record);
  rows_->hash.add(record);
}

void Checkpoints::begin_run(const std::string& run) {
  run_ = run;
  last_ = Clock::now();
  put(run_begins, run);
}

void Checkpoints::add(const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
  const Eigen::VectorXd states = pack(s);
  Eigen::VectorXd x(4 + states.size() + v_dot.size());
  x << s.t, energy.work_in, energy.dissipated, energy.balance, states, v_dot;
  put(row, {reinterpret_cast<const char*>(x.data()), static_cast<std::size_t>(x.size()) * sizeof(double)});
}

void Checkpoints::end_run(const json& end) {
  put(run_ends, end.dump());
}

void Checkpoints::take(const mbs::RunMemory& memory) {
  const Clock::time_point begin = Clock::now();
  rows_->synchronise();
  json out = {{"format", kFormat},
              {"version", 1},
              {"identity", identity_},
              {"interval", interval_.count()},
              {"run", run_},
              {"rows_size", rows_->size},
              {"rows_checksum", rows_->hash.hex()},
              {"memory", to_json(memory)}};
  out["checksum"] = checksum(out);
  std::error_code none;
  if (rows_->output) {
    // From here on there is nothing to go back to of an earlier run.
    rows_->output->commit();
    rows_->output.reset();
    fs::remove(files_.before, none);
  } else {
    fs::rename(files_.newest, files_.before, none);
  }
  files::write_whole(files_.newest, out.dump(1) + "\n");
  any_ = true;
  last_ = Clock::now();
  cost_ = last_ - begin;
}

void Checkpoints::remove() {
  std::error_code none;
  rows_.reset();
  for (const fs::path& file : {files_.newest, files_.before, files_.rows}) fs::remove(file, none);
  files::remove_left_behind(files_.newest, "{");
  files::remove_left_behind(files_.rows, kRowsOpening);
}

}  // namespace flexura::app
