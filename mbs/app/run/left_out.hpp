// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mbs/solver/start/prepare.hpp"

/// What a run did not need and therefore did not read, build, integrate or store.
namespace flexura::app {

struct LeftOut {
  struct Body {
    std::string name;
    int available = 0, kept = 0;          ///< deformations
    std::vector<std::string> not_read;    ///< parts of its superelement file: "stress modes", ...
    double bytes = 0.0, whole_bytes = 0;  ///< of the file: not read; all parts
  };
  std::vector<Body> bodies;
  int states = 0, states_of_all = 0;          ///< integrated; with all deformations
  int quantities = 0, quantities_of_all = 0;  ///< evaluated and stored; known by name
};

/// Reads the contents of the superelement files.
LeftOut left_out(const mbs::PreparedMechanism& prepared);

/// "left out: 18 of 24 deformations of arm; ...", or "" where everything was taken.
std::string left_out_line(const LeftOut& left_out);
nlohmann::json left_out_json(const LeftOut& left_out);

}  // namespace flexura::app
