// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_solve.hpp"

#include <algorithm>
#include <memory>

#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/enriched_cells.hpp"
#include "reduce/linalg/dense/cell_products.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;

namespace {

constexpr int kGroup = EnrichedCells::kLanes;

Index row_of(int function) {
  return 3 * static_cast<Index>(function);
}

}  // namespace

template <class Work>
void EnrichedSolve::over_ranges(const Work& work) const {
  linalg::parallel_for(static_cast<int>(ranges_.size()), [&](int p) { work(static_cast<std::size_t>(p)); });
}

EnrichedSolve::EnrichedSolve(const Part& part, const EnrichedMesh& mesh,
                             const std::vector<std::size_t>& chosen) {
  number(mesh, part, chosen);
  find_ranges();
  compute_cells(part, mesh, chosen);
  weigh_shared_functions();
}

void EnrichedSolve::number(const EnrichedMesh& mesh, const Part& part,
                           const std::vector<std::size_t>& chosen) {
  std::vector<int> gained(static_cast<std::size_t>(mesh.n_functions()), -1),
      own(static_cast<std::size_t>(part.mesh.n_nodes()), -1);
  std::vector<float> all(gained.size(), 0.0f);
  for (const int number : mesh.numbers())
    if (number >= 0) all[static_cast<std::size_t>(number)] += 1.0f;
  // Nodes between cells that are chosen and others.
  std::vector<char> at_border(own.size(), 0), is_chosen(mesh.cells().size(), 0);
  for (const std::size_t k : chosen) is_chosen[k] = 1;
  for (std::size_t k = 0; k < is_chosen.size() && chosen.size() < is_chosen.size(); ++k) {
    const EnrichedMesh::Cell& cell = mesh.cells()[k];
    const mesh::CellBlock& block = part.mesh.solids[static_cast<std::size_t>(cell.block)];
    for (Index a = 0; a < block.nodes.cols() && !is_chosen[k]; ++a)
      at_border[static_cast<std::size_t>(block.nodes(cell.row, a))] = 1;
  }
  std::vector<float> here;
  std::size_t entries = 0;
  const auto take = [&](int& number, float sign, int from) {
    if (number < 0) {
      number = n_functions_++;
      from_.push_back(from);
      here.push_back(0.0f);
    }
    here[static_cast<std::size_t>(number)] += 1.0f;
    numbers_.push_back(number);
    sign_.push_back(sign);
  };
  const auto leave_out = [&] {
    numbers_.push_back(-1);
    sign_.push_back(0.0f);
  };
  for (const std::size_t k : chosen) {
    const EnrichedMesh::Cell& cell = mesh.cells()[k];
    const mesh::CellBlock& block = part.mesh.solids[static_cast<std::size_t>(cell.block)];
    const int n = cell.n_functions + static_cast<int>(block.nodes.cols());
    cells_.push_back({numbers_.size(), entries, n, cell.n_functions});
    entries += static_cast<std::size_t>(9 * n) * static_cast<std::size_t>(n);
    for (int f = 0; f < cell.n_functions; ++f) {
      const std::size_t at = cell.first_function + static_cast<std::size_t>(f);
      const int from = mesh.numbers()[at];
      if (from < 0)
        leave_out();
      else
        take(gained[static_cast<std::size_t>(from)], mesh.signs()[at], from);
    }
    for (Index a = 0; a < block.nodes.cols(); ++a) {
      const mesh::Index node = block.nodes(cell.row, a);
      if (mesh.held(node) || at_border[static_cast<std::size_t>(node)])
        leave_out();
      else
        take(own[static_cast<std::size_t>(node)], 1.0f, -1);
    }
  }
  for (std::size_t k = 0; k < from_.size(); ++k)
    share_.push_back(from_[k] < 0 ? 0.0f : here[k] / all[static_cast<std::size_t>(from_[k])]);
  K_.resize(entries);
  B_.resize(entries);
}

// As many as leave each thread enough to do; the same on every machine, so that sums are the same to the bit.
void EnrichedSolve::find_ranges() {
  constexpr std::size_t kLeast = 300, kMost = 16;
  const std::size_t n_ranges = std::clamp(cells_.size() / kLeast, std::size_t{1}, kMost);
  places_ = numbers_;
  std::vector<int> place_of(static_cast<std::size_t>(n_functions_), -1);
  int first_function = 0;
  for (std::size_t k = 0; k < n_ranges; ++k) {
    Range range{
        cells_.size() * k / n_ranges, cells_.size() * (k + 1) / n_ranges, first_function, first_function, {}};
    for (std::size_t c = range.first_cell; c < range.last_cell; ++c)
      for (int f = 0; f < cells_[c].n; ++f) {
        int& at = places_[cells_[c].first_function + static_cast<std::size_t>(f)];
        if (at < 0) continue;
        if (at >= range.first_function) {
          range.last_function = std::max(range.last_function, at + 1);
          continue;
        }
        int& place = place_of[static_cast<std::size_t>(at)];
        const auto slot = static_cast<std::size_t>(-2 - place);
        if (place > -2 || slot >= range.shared.size() || range.shared[slot] != at) {
          place = -2 - static_cast<int>(range.shared.size());
          range.shared.push_back(at);
        }
        at = place;
      }
    first_function = range.last_function;
    shared_.emplace_back(row_of(static_cast<int>(range.shared.size())), kStatesTogether);
    ranges_.push_back(std::move(range));
  }
}

void EnrichedSolve::compute_cells(const Part& part, const EnrichedMesh& mesh,
                                  const std::vector<std::size_t>& chosen) {
  over_ranges([&](std::size_t p) {
    std::vector<std::unique_ptr<EnrichedCells>> matrices(part.mesh.solids.size());
    for (std::size_t first = ranges_[p].first_cell; first < ranges_[p].last_cell;) {
      const auto b = static_cast<std::size_t>(mesh.cells()[chosen[first]].block);
      const mesh::CellBlock& block = part.mesh.solids[b];
      if (!matrices[b]) matrices[b] = std::make_unique<EnrichedCells>(block.type, part.materials);
      EnrichedCells::Cell lanes[kGroup];
      int count = 0;
      for (std::size_t k = first; k < ranges_[p].last_cell && count < kGroup; ++k, ++count) {
        const EnrichedMesh::Cell& cell = mesh.cells()[chosen[k]];
        if (static_cast<std::size_t>(cell.block) != b) break;
        const auto sign = sign_.begin() + static_cast<std::ptrdiff_t>(cells_[k].first_function);
        lanes[count] = {
            positions(part.mesh, block, cell.row), material_of(block, cell.row), {sign, sign + cells_[k].n}};
      }
      matrices[b]->take(lanes);
      matrices[b]->compute_stiffness();
      for (int lane = 0; lane < count; ++lane) {
        const std::size_t entry = cells_[first + static_cast<std::size_t>(lane)].first_entry;
        matrices[b]->copy_stiffness(lane, K_.data() + entry);
        matrices[b]->copy_inverse(lane, B_.data() + entry);
      }
      first += static_cast<std::size_t>(count);
    }
  });
}

// A cell's share in a function is that of its stiffness.
void EnrichedSolve::weigh_shared_functions() {
  std::vector<float> total(static_cast<std::size_t>(row_of(n_functions_)), 0.0f);
  const auto diagonal = [&](const Cell& cell, int i) {
    return K_[cell.first_entry + static_cast<std::size_t>(i) * static_cast<std::size_t>(3 * cell.n + 1)];
  };
  const auto number = [&](const Cell& cell, int i) {
    return numbers_[cell.first_function + static_cast<std::size_t>(i / 3)];
  };
  for (const Cell& cell : cells_)
    for (int i = 0; i < 3 * cell.n; ++i)
      if (const int f = number(cell, i); f >= 0) total[3 * f + i % 3] += diagonal(cell, i);
  over_ranges([&](std::size_t p) {
    Eigen::VectorXf weight;
    for (std::size_t k = ranges_[p].first_cell; k < ranges_[p].last_cell; ++k) {
      const Cell& cell = cells_[k];
      const Index n = 3 * cell.n;
      weight.setZero(n);
      for (int i = 0; i < n; ++i)
        if (const int f = number(cell, i); f >= 0) weight(i) = diagonal(cell, i) / total[3 * f + i % 3];
      Eigen::Map<Eigen::MatrixXf> B(B_.data() + cell.first_entry, n, n);
      for (Index c = 0; c < n; ++c) B.col(c).array() *= weight.array() * weight(c);
    }
  });
}

void EnrichedSolve::multiply(const std::vector<float>& matrices, const StatePanel& X, StatePanel& Y) {
  over_ranges([&](std::size_t p) {
    const Range& range = ranges_[p];
    StatePanel &shared = shared_[p], x, y;
    shared.setZero();
    Y.middleRows(row_of(range.first_function), row_of(range.last_function - range.first_function)).setZero();
    for (std::size_t k = range.first_cell; k < range.last_cell; ++k) {
      const int n = cells_[k].n;
      x.resize(3 * n, kStatesTogether);
      y.resize(3 * n, kStatesTogether);
      const int *numbers = numbers_.data() + cells_[k].first_function,
                *places = places_.data() + cells_[k].first_function;
      for (int f = 0; f < n; ++f)
        if (numbers[f] < 0)
          x.middleRows<3>(3 * f).setZero();
        else
          x.middleRows<3>(3 * f) = X.middleRows<3>(row_of(numbers[f]));
      linalg::multiply_sixteen(matrices.data() + cells_[k].first_entry, 3 * n, 3 * n, x.data(), y.data());
      for (int f = 0; f < n; ++f)
        if (places[f] >= 0)
          Y.middleRows<3>(row_of(places[f])) += y.middleRows<3>(3 * f);
        else if (places[f] < -1)
          shared.middleRows<3>(row_of(-2 - places[f])) += y.middleRows<3>(3 * f);
    }
  });
  for (std::size_t p = 0; p < ranges_.size(); ++p)
    for (std::size_t k = 0; k < ranges_[p].shared.size(); ++k)
      Y.middleRows<3>(row_of(ranges_[p].shared[k])) += shared_[p].middleRows<3>(row_of(static_cast<int>(k)));
}

EnrichedSolve::Numbers EnrichedSolve::dots(const StatePanel& a, const StatePanel& b) const {
  std::vector<Numbers> sums(ranges_.size(), Numbers::Zero());
  over_ranges([&](std::size_t p) {
    // Single precision for a few rows, double for their sums.
    constexpr Index kRows = 64;
    const Index last = row_of(ranges_[p].last_function);
    for (Index row = row_of(ranges_[p].first_function); row < last; row += kRows) {
      Eigen::Array<float, 1, kStatesTogether> part = Eigen::Array<float, 1, kStatesTogether>::Zero();
      for (Index k = row; k < std::min(row + kRows, last); ++k) part += a.row(k).array() * b.row(k).array();
      sums[p] += part.cast<double>();
    }
  });
  Numbers out = Numbers::Zero();
  for (const Numbers& sum : sums) out += sum;
  return out;
}

StatePanel EnrichedSolve::energies(const StatePanel& load) {
  constexpr int kMostSteps = 12;
  constexpr double kEnough = 0.05, kSlowest = 0.6;
  const Index n = row_of(n_functions_);
  StatePanel r(n, kStatesTogether), z(n, kStatesTogether), A_d(n, kStatesTogether),
      e = StatePanel::Zero(n, kStatesTogether);
  for (std::size_t k = 0; k < from_.size(); ++k)
    if (from_[k] < 0)
      r.middleRows<3>(row_of(static_cast<int>(k))).setZero();
    else
      r.middleRows<3>(row_of(static_cast<int>(k))) = share_[k] * load.middleRows<3>(row_of(from_[k]));
  // Loads of one, so that single precision holds their squares.
  using States = Eigen::Array<float, 1, kStatesTogether>;
  States scale = States::Zero();
  for (Index row = 0; row < n; ++row) scale = scale.max(r.row(row).array().abs());
  scale = (scale > 0.0f).select(scale, 1.0f);
  for (Index row = 0; row < n; ++row) r.row(row).array() /= scale;
  multiply(B_, r, z);
  StatePanel d = z;
  Numbers rz = dots(r, z), energy = Numbers::Zero(), gain = energy, before = energy, earlier = energy,
          factor = energy, more = energy;
  for (int step = 0; step < kMostSteps; ++step) {
    multiply(K_, d, A_d);
    const Numbers dAd = dots(d, A_d), alpha = (dAd > 0.0).select(rz / dAd, 0.0);
    earlier = before;
    before = gain;
    gain = alpha * rz;
    energy += gain;
    const States a = alpha.cast<float>();
    // Gains fall off by about the same factor from step to step: what further ones would add.
    factor = (earlier > 0.0).select((gain / earlier).sqrt().min(kSlowest), kSlowest);
    more = gain * factor / (1.0 - factor);
    const bool last = step >= 2 && (more <= kEnough * energy).all();
    over_ranges([&](std::size_t p) {
      for (Index row = row_of(ranges_[p].first_function); row < row_of(ranges_[p].last_function); ++row) {
        e.row(row).array() += a * d.row(row).array();
        r.row(row).array() -= a * A_d.row(row).array();
      }
    });
    if (last) break;
    multiply(B_, r, z);
    const Numbers next = dots(r, z), beta = (rz > 0.0).select(next / rz, 0.0);
    rz = next;
    const States b = beta.cast<float>();
    over_ranges([&](std::size_t p) {
      for (Index row = row_of(ranges_[p].first_function); row < row_of(ranges_[p].last_function); ++row)
        d.row(row).array() = z.row(row).array() + b * d.row(row).array();
    });
  }
  const Numbers whole = (energy > 0.0).select(1.0 + more / energy, 1.0);
  const States to_energy = (whole * scale.cast<double>().square()).cast<float>();

  StatePanel out(static_cast<Index>(cells_.size()), kStatesTogether);
  over_ranges([&](std::size_t p) {
    StatePanel x, K_x;
    for (std::size_t k = ranges_[p].first_cell; k < ranges_[p].last_cell; ++k) {
      const Cell& cell = cells_[k];
      x.setZero(3 * cell.n, kStatesTogether);
      K_x.resize(3 * cell.n, kStatesTogether);
      for (int f = 0; f < cell.n; ++f)
        if (const int number = numbers_[cell.first_function + static_cast<std::size_t>(f)]; number >= 0)
          x.middleRows<3>(3 * f) = e.middleRows<3>(row_of(number));
      linalg::multiply_sixteen(K_.data() + cell.first_entry, 3 * cell.n, 3 * cell.n, x.data(), K_x.data());
      out.row(static_cast<Index>(k)) = x.cwiseProduct(K_x).colwise().sum().array() * to_energy;
    }
  });
  return out;
}

}  // namespace flexura::reduce
