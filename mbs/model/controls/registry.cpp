// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {

const std::vector<ControlType>& control_types() {
  static const std::vector<ControlType> types = {
      state_control(), filter_control(), pid_control(),       transfer_function_control(),
      delay_control(), relay_control(),  algebraic_control(), sample_control(),
  };
  return types;
}

}  // namespace flexura::mbs
