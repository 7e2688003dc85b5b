// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/control.hpp"
#include "mbs/model/forces/types.hpp"

/// The types of control elements: one file each, listed here and in registry.cpp.
namespace flexura::mbs {

struct ControlType : ElementType<Control> {
  bool feeds_through =
      false;  ///< as the element says: its output can be read by later controls and forces only
};

const std::vector<ControlType>& control_types();

ControlType state_control();
ControlType filter_control();
ControlType pid_control();
ControlType delay_control();
ControlType relay_control();
ControlType sample_control();
ControlType algebraic_control();
ControlType transfer_function_control();

}  // namespace flexura::mbs
