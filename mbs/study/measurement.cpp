// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/measurement.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/json_text.hpp"
#include "mbs/base/files/new_folder.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/threads/pool.hpp"
#include "mbs/file/mechanism_document.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/results/results.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/study/cache/child_process.hpp"
#include "mbs/study/cache/reduction.hpp"
#include "mbs/study/cache/study_cache.hpp"

namespace flexura::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A reduction or a simulation that is wanted; equal keys are the same work.
struct Task {
  std::string key, name;
  std::vector<std::string> command;  ///< without the output file
  double reduce_wall = 0.0;
};

std::string machine_name() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  std::ifstream cpu("/proc/cpuinfo");
  for (std::string line; std::getline(cpu, line);)
    if (line.starts_with("model name")) return std::string(host) + line;
  return host;
}

class Laboratory {
 public:
  Laboratory(const StudyFile& study, const Programs& programs, const MeasureOptions& options)
      : study_(study), programs_(programs), options_(options) {
    check_mechanism();
    // What the programs that this one starts are going to read: no output of the study may lie there.
    for (const input::InputFile& file : input::input_files(study_.mechanism)) files::note_input(file.path);
    for (const Part& part : study_.parts)
      for (const input::InputFile& file : input::input_files(part.file)) files::note_input(file.path);
    made_.emplace(study.cache);
    cache_ = fs::absolute(study.cache);
    remove_scratch_left(cache_);
    store_.emplace(cache_, [this](const std::string& words) {
      const std::lock_guard lock(guard_);
      if (options_.note) options_.note(words);
    });
    flexura_ = input::ContentHash().add_file(programs.flexura).hex();
    machine_ = machine_name();
    if (!study.parts.empty())
      reduce_ = input::ContentHash().add_file(programs.reduce).add_file(programs.mesh).hex();
  }

  Measurements run() {
    std::vector<const Choice*> wanted;
    for (const Choice& choice : study_.choices) wanted.push_back(&choice);
    if (!study_.compares_designs()) wanted.push_back(&study_.reference);
    for (const Check& check : study_.checks) wanted.push_back(&check.choice);
    for (const Choice& choice : study_.finer) wanted.push_back(&choice);
    for (const Choice* choice : wanted) {
      if (files::StopRequests::wanted())
        throw Interrupted(std::string("interrupted by ") + files::StopRequests::name());
      check_keys(*choice);
    }

    std::vector<std::size_t> mine;
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (static_cast<int>(i % static_cast<std::size_t>(options_.shares)) + 1 == options_.share)
        mine.push_back(i);
    std::vector<Task> tasks(wanted.size());
    reduce_parts(wanted, mine);
    for (const std::size_t i : mine) tasks[i] = simulation(*wanted[i]);

    // Choices that come out the same are run once.
    std::map<std::string, std::size_t> first;
    for (const std::size_t i : mine) first.emplace(tasks[i].key, i);
    std::vector<std::size_t> unique;
    for (const auto& [key, i] : first) unique.push_back(i);
    std::ranges::sort(unique);
    made_->keep();  // the runs go on from there
    say("runs", 0.0);
    std::atomic<std::size_t> done{0};
    threads::parallel_for(
        static_cast<int>(unique.size()),
        [&](int at) {
          const auto k = static_cast<std::size_t>(at);
          first_run(tasks[unique[k]]);
          say("runs", static_cast<double>(++done) / static_cast<double>(unique.size()));
        },
        options_.jobs);
    require_some_that_run(tasks, mine);
    if (!study_.compares_designs()) repeat_runs(tasks, unique);

    Measurements out;
    out.whole = options_.shares == 1;
    if (!out.whole) return out;
    std::vector<Measurement> all;
    for (const Task& task : tasks) all.push_back(measurement(task));
    const std::size_t n = study_.choices.size();
    out.choices.assign(all.begin(), all.begin() + static_cast<long>(n));
    if (study_.compares_designs()) {
      out.finer.assign(all.begin() + static_cast<long>(n), all.end());
      return out;
    }
    out.reference = all[n];
    out.checks.assign(all.begin() + static_cast<long>(n) + 1, all.end());
    return out;
  }

 private:
  void say(std::string_view stage, double fraction) {
    const std::lock_guard lock(guard_);
    if (options_.progress) options_.progress(stage, fraction);
  }

  // A rung that refuses to run (the stress of a rigid body is asked for) is a failed one.  Where all choices do, or the
  // reference or a check, the study asks for what cannot be.
  void require_some_that_run(const std::vector<Task>& tasks, const std::vector<std::size_t>& mine) const {
    if (refused_.empty()) return;
    const auto first = std::ranges::find_if(
        mine, [&](std::size_t i) { return i >= study_.choices.size() && refused_.contains(tasks[i].key); });
    const bool all =
        std::ranges::all_of(mine, [&](std::size_t i) { return refused_.contains(tasks[i].key); });
    if (!all && (study_.compares_designs() || first == mine.end())) return;
    const Task& task = tasks[all ? mine.front() : *first];
    throw input::InputError(
        fmt::format("{}: choice \"{}\": {}", study_.file.string(), task.name, refused_.at(task.key)));
  }

  // Before anything runs: does the mechanism have the run and the bodies that the study names?
  void check_mechanism() {
    const input::Section root =
        mbs::read_mechanism_document(study_.mechanism, mbs::solver_schema(), study_.set);
    std::vector<std::string> runs, bodies;
    for (const auto& [name, section] : root.table_map("run")) runs.push_back(name);
    for (const auto& [name, section] : root.table_map("body")) bodies.push_back(name);
    if (study_.run.empty() && runs.size() > 1)
      throw input::InputError(fmt::format("{}: {} has {} runs; say which with run = \"{}\"",
                                          study_.file.string(), study_.mechanism.string(), runs.size(),
                                          runs.back()));
    if (!study_.run.empty() && std::ranges::find(runs, study_.run) == runs.end())
      throw input::InputError(fmt::format("{}: run = \"{}\": {} has no such run{}", study_.file.string(),
                                          study_.run, study_.mechanism.string(),
                                          input::suggestion(study_.run, runs)));
    for (const Part& part : study_.parts)
      for (const std::string& body : part.bodies)
        if (std::ranges::find(bodies, body) == bodies.end())
          throw input::InputError(fmt::format("{}: part.{}.bodies: {} has no body \"{}\"{}",
                                              study_.file.string(), part.name, study_.mechanism.string(),
                                              body, input::suggestion(body, bodies)));
  }

  void check_keys(const Choice& choice) const {
    std::vector<std::string> set = study_.set;
    set.insert(set.end(), choice.set.begin(), choice.set.end());
    try {
      mbs::read_mechanism_document(study_.mechanism, mbs::solver_schema(), set);
    } catch (const input::InputError& e) {
      throw input::InputError(
          fmt::format("{}: choice \"{}\": {}", study_.file.string(), choice.name, e.what()));
    }
  }

  Task reduction(const Part& part, const Choice& choice) const {
    std::vector<std::string> set = part.set;
    if (const auto found = choice.part_set.find(part.name); found != choice.part_set.end())
      set.insert(set.end(), found->second.begin(), found->second.end());
    Task task;
    input::ContentHash hash;
    hash.add(reduce_).add_input_file(part.file);
    task.command = {programs_.reduce.string(), fs::absolute(part.file).string(), "-q"};
    if (options_.run_scripts) task.command.emplace_back("--run-scripts");
    for (const std::string& text : set) {
      hash.add(text);
      task.command.insert(task.command.end(), {"--set", text});
    }
    task.key = hash.hex();
    task.name = fmt::format("part {} ({})", part.name, choice.name);
    return task;
  }

  void reduce_parts(const std::vector<const Choice*>& wanted, const std::vector<std::size_t>& mine) {
    std::map<std::string, Task> tasks;
    for (const std::size_t i : mine)
      for (const Part& part : study_.parts) {
        Task task = reduction(part, *wanted[i]);
        const std::string key = task.key;
        if (!store_->is_there(key, ".se.h5")) tasks.emplace(key, std::move(task));
      }
    std::vector<Task> list;
    for (auto& [key, task] : tasks) list.push_back(std::move(task));
    std::atomic<std::size_t> done{0};
    if (!list.empty()) say("reductions", 0.0);
    threads::parallel_for(
        static_cast<int>(list.size()),
        [&](int at) {
          const auto k = static_cast<std::size_t>(at);
          reduce(list[k]);
          say("reductions", static_cast<double>(++done) / static_cast<double>(list.size()));
        },
        options_.jobs);
  }

  void reduce(const Task& task) const {
    reduce_into(*store_, cache_, {.key = task.key, .name = task.name, .command = task.command});
  }

  Task simulation(const Choice& choice) const {
    Task task;
    task.name = choice.name;
    input::ContentHash hash;
    hash.add(flexura_).add(machine_).add_input_file(study_.mechanism).add(study_.run);
    if (study_.compares_designs()) hash.add("without estimate");
    if (study_.times_estimates) hash.add("timed with estimates");
    task.command = {programs_.flexura.string(), "simulate", fs::absolute(study_.mechanism).string(), "-q"};
    if (!study_.run.empty()) task.command.insert(task.command.end(), {"--run", study_.run});
    std::vector<std::string> set;
    for (const Part& part : study_.parts) {
      const std::string key = reduction(part, choice).key;
      hash.add(key);
      if (const auto entry = store_->find(key)) task.reduce_wall += entry->total_wall();
      for (const std::string& body : part.bodies)
        set.push_back(fmt::format("body.{}.superelement=\"{}\"", body, store_->path(key, ".se.h5").string()));
    }
    set.insert(set.end(), study_.set.begin(), study_.set.end());
    set.insert(set.end(), choice.set.begin(), choice.set.end());
    // Only what the study compares is evaluated and stored.
    std::string quantities;
    for (const WantedQuantity& q : study_.quantities)
      quantities += fmt::format("{}\"{}\"", quantities.empty() ? "" : ", ", q.name);
    set.push_back(fmt::format("output.quantities=[{}]", quantities));
    for (const std::string& text : set) {
      hash.add(text);
      // A superelement that an override names counts by its content.
      const std::size_t equals = text.find('=');
      std::string value = text.substr(equals + 1);
      std::erase(value, '"');
      std::error_code none;
      const fs::path named = fs::absolute(study_.mechanism).parent_path() / value;
      if (value.size() < 1024 && fs::is_regular_file(named, none)) {
        files::note_input(named);
        hash.add_file(named);
      }
      task.command.insert(task.command.end(), {"--set", text});
    }
    task.key = hash.hex();
    return task;
  }

  ChildOutcome simulate(const Task& task, const fs::path& output, bool is_timed) const {
    std::vector<std::string> command = task.command;
    // Timed runs prepare their bodies as a run by itself does.
    if (!is_timed) command.insert(command.end(), {"--cache", (cache_ / "bodies").string()});
    if (study_.compares_designs() || (is_timed && !study_.times_estimates))
      command.push_back("--no-estimate");
    command.insert(command.end(), {"-o", output.string()});
    return run_child(command, cache_, {study_.time_limit, study_.cpu_is_cost});
  }

  void first_run(const Task& task) {
    if (!options_.fresh && store_->is_there(task.key, ".h5")) return;
    const StudyCache::Passing beside{store_->path(task.key, ("." + scratch_mark() + "first").c_str())};
    const ChildOutcome outcome = simulate(task, beside.path, false);
    if (outcome.exit_code == 2) {
      const std::lock_guard lock(guard_);
      refused_[task.key] = refusal(outcome);
      return;
    }
    CacheEntry entry;
    entry.choice = task.name;
    entry.exit_code = outcome.exit_code;
    if (outcome.timed_out)
      entry.failure = fmt::format("took longer than {:.6g} s", study_.time_limit);
    else if (outcome.exit_code != 0)
      entry.failure = outcome.exit_code > 128 ? fmt::format("ended by signal {}", outcome.exit_code - 128)
                                              : refusal(outcome);
    if (fs::is_regular_file(beside.path)) {
      fs::rename(beside.path, store_->path(task.key, ".h5"));
    } else {
      files::write_whole(store_->path(task.key, ".h5"), "");  // the mark of a run that left nothing
    }
    store_->record(task.key, ".h5", entry);
  }

  // One round of all choices after the other, so that a slow drift of the machine meets all alike.
  void repeat_runs(const std::vector<Task>& tasks, const std::vector<std::size_t>& unique) {
    std::vector<std::size_t> timed;
    for (const std::size_t i : unique)
      if (i < study_.choices.size() && !refused_.contains(tasks[i].key)) timed.push_back(i);
    std::size_t done = 0;
    for (int round = 1; round <= study_.repeats; ++round)
      for (const std::size_t i : timed) {
        const Task& task = tasks[i];
        CacheEntry entry = store_->entry_of(task.key);
        if (entry.failure.empty() && static_cast<int>(entry.wall.size()) < round) {
          const StudyCache::Passing scratch{store_->path(task.key, ("." + scratch_mark() + "again").c_str())};
          const ChildOutcome outcome = simulate(task, scratch.path, true);
          entry.wall.push_back(outcome.wall);
          entry.cpu.push_back(outcome.cpu);
          entry.peak_memory = std::max(entry.peak_memory, outcome.peak_memory);
          store_->write(task.key, entry);
        }
        say("times", static_cast<double>(++done) / static_cast<double>(timed.size() * study_.repeats));
      }
  }

  Measurement measurement(const Task& task) const {
    Measurement m;
    m.results = store_->path(task.key, ".h5");
    if (const auto found = refused_.find(task.key); found != refused_.end()) {
      m.failure = found->second;
      return m;
    }
    const CacheEntry entry = store_->entry_of(task.key);
    m.reduce_wall = task.reduce_wall;
    m.wall = entry.wall;
    m.cpu = entry.cpu;
    m.peak_memory = entry.peak_memory;
    m.failure = entry.failure;
    m.complete = m.failure.empty();
    if (!m.complete) return m;
    const results::Results results = results::read(m.results);
    if (results.runs.empty())
      throw std::runtime_error(fmt::format("{}: holds no run; remove it, and the study runs \"{}\" again",
                                           m.results.string(), task.name));
    const json summary = files::try_read_json(results.runs.front().summary_json);
    if (summary.is_object()) {
      m.solver_wall = summary.value("wall_time", 0.0);
      m.steps = summary.value("steps", 0L);
      m.evaluations = summary.value("evaluations", 0L);
      m.energy_error = summary.value("relative_energy_error", 0.0);
    }
    return m;
  }

  const StudyFile& study_;
  const Programs& programs_;
  const MeasureOptions& options_;
  fs::path cache_;
  std::optional<files::NewFolder> made_;
  std::optional<StudyCache> store_;
  std::string flexura_, reduce_, machine_;
  std::map<std::string, std::string> refused_;  // why, by the task's key; not kept in the cache
  std::mutex guard_;
};

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

double Measurement::median_wall() const {
  return median(wall);
}
double Measurement::median_cpu() const {
  return median(cpu);
}

Measurements measure(const StudyFile& study, const Programs& programs, const MeasureOptions& options) {
  return Laboratory(study, programs, options).run();
}

}  // namespace flexura::study
