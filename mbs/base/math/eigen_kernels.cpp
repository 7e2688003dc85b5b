// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#define FLEXURA_EIGEN_KERNEL template
#include "mbs/base/math/eigen_kernels.hpp"
