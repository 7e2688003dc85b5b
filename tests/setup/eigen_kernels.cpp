// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#define FLEXURA_EIGEN_INSTANCES
#include "tests/setup/eigen_instances.hpp"

namespace Eigen::internal {
FLEXURA_EIGEN_KERNELS(template)
}
