// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Where libraries of users' own found it before.
#include "mbs/mechanism/user_element.hpp"
