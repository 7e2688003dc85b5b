// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// FLEXURA_ADDRESS_SANITIZER is defined where the address sanitizer is compiled in, by g++ or clang: it owns malloc and takes
/// terabytes of addresses.
#if defined(__SANITIZE_ADDRESS__)
#define FLEXURA_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define FLEXURA_ADDRESS_SANITIZER
#endif
#endif
