// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "reduce/assembly/ties/tied_codes.hpp"
#include "reduce/assembly/ties/tied_numbering.hpp"

// What a rank of a team has of a numbering.
namespace flexura::reduce {

TiedNumbering::Share TiedNumbering::share(const std::vector<mesh::Index>& nodes,
                                          const std::vector<int>& with) const {
  Share out;
  TiedNumbering& s = out.numbering;
  std::vector<int> groups = with, of_node;
  for (const mesh::Index node : nodes) {
    of_node.clear();
    add_groups(node, of_node);
    groups.insert(groups.end(), of_node.begin(), of_node.end());
  }
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  std::vector<int> group_there(group_begin_.size(), -1), dof_there(static_cast<std::size_t>(n_i_), -1);
  s.group_begin_ = {0};
  for (const int group : groups) {
    group_there[group] = static_cast<int>(s.group_begin_.size()) - 1;
    for (int i = group_begin_[group]; i < group_begin_[group + 1]; ++i) {
      dof_there[i] = static_cast<int>(out.dofs.size());
      out.dofs.push_back(i);
    }
    s.group_begin_.push_back(static_cast<int>(out.dofs.size()));
  }
  // Interior dofs of interfaces none of whose nodes is here are not either.
  const auto code_there = [&](int code) {
    return code < 0 ? code : dof_there[code] >= 0 ? dof_there[code] : kUnused;
  };
  const auto there = [&](int group) { return group >= 0 ? group_there[group] : -1; };
  s.n_nodes_ = static_cast<int>(nodes.size());
  s.n_i_ = static_cast<int>(out.dofs.size());
  s.n_b_ = n_b_;
  s.length_ = length_;
  s.points_.resize(s.n_nodes_, 3);
  s.slave_begin_ = {0};
  for (int k = 0; k < s.n_nodes_; ++k) {
    const mesh::Index node = nodes[k];
    s.points_.row(k) = points_.row(node);
    if (!node_label_.empty()) s.node_label_.push_back(node_label_[node]);
    for (int d = 0; d < 3; ++d) s.code_.push_back(code_there(code(node, d)));
    s.tie_of_.push_back(tie_of_[node]);
    s.group_of_.push_back(there(group_of_[node]));
    s.rotation_of_.push_back(-1);
    if (const int r = rotation_of_[node]; r >= 0) {
      s.rotation_of_.back() = static_cast<int>(s.rotation_code_.size());
      s.rotation_code_.push_back(rotation_code_[r]);
      for (int& code : s.rotation_code_.back()) code = code_there(code);
    }
    s.slave_of_.push_back(-1);
    if (!follows(node)) continue;
    s.slave_of_.back() = static_cast<int>(s.slave_begin_.size()) - 1;
    const Followed of = followed(node);
    for (const int code : of.code) s.slave_code_.push_back(code_there(code));
    s.slave_C_.insert(s.slave_C_.end(), of.C.begin(), of.C.end());
    s.slave_begin_.push_back(static_cast<int>(s.slave_code_.size()));
  }
  for (const int group : tie_group_) s.tie_group_.push_back(there(group));
  s.interfaces_ = interfaces_;
  for (InterfaceDofs& interface : s.interfaces_) {
    interface.nodes.clear();
    for (int& code : interface.code) code = code_there(code);
  }
  return out;
}

void TiedNumbering::put(linalg::Message& message) const {
  for (const int number : {n_nodes_, n_i_, n_b_}) message.put(number);
  message.put(length_);
  message.put_all(points_.reshaped<Eigen::RowMajor>().eval());
  message.put_all(node_label_);
  for (const std::vector<int>* numbers : {&code_, &tie_of_, &group_begin_, &group_of_, &tie_group_,
                                          &rotation_of_, &slave_of_, &slave_begin_, &slave_code_})
    message.put_all(*numbers);
  message.put_all(rotation_code_);
  message.put(slave_C_.size());
  for (const Eigen::Vector3d& C : slave_C_) message.put_array(C.data(), 3);
  message.put(interfaces_.size());
  for (const InterfaceDofs& interface : interfaces_) {
    message.put(interface.tie);
    message.put_array(interface.point.data(), 3);
    message.put_all(interface.directions);
    message.put(interface.first_b);
    message.put(interface.code);
  }
}

TiedNumbering::TiedNumbering(linalg::Message& message) {
  for (int* number : {&n_nodes_, &n_i_, &n_b_}) *number = message.take<int>();
  length_ = message.take<double>();
  const auto points = message.take_all<double>();
  points_ = Eigen::Map<const Points>(points.data(), n_nodes_, 3);
  node_label_ = message.take_all<std::int64_t>();
  for (std::vector<int>* numbers : {&code_, &tie_of_, &group_begin_, &group_of_, &tie_group_, &rotation_of_,
                                    &slave_of_, &slave_begin_, &slave_code_})
    *numbers = message.take_all<int>();
  rotation_code_ = message.take_all<std::array<int, 3>>();
  slave_C_.resize(message.take<std::size_t>());
  for (Eigen::Vector3d& C : slave_C_) message.take_array(C.data(), 3);
  interfaces_.resize(message.take<std::size_t>());
  for (InterfaceDofs& interface : interfaces_) {
    interface.tie = message.take<Tie>();
    message.take_array(interface.point.data(), 3);
    interface.directions = message.take_all<int>();
    interface.first_b = message.take<int>();
    interface.code = message.take<std::array<int, 6>>();
  }
}

}  // namespace flexura::reduce
