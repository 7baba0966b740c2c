// SPDX-License-Identifier: MIT
#pragma once

/// A function compiled for AVX2 and FMA, and for AVX-512, as well; the library chooses one when it is loaded. Not with
/// sanitizers: their checks, which are the same in each copy, make these functions long to compile.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define IMPACT_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define IMPACT_CLONES
#endif

/// What clones share: a function that is called would be compiled for the oldest processors only.
#if defined(__GNUC__)
#define IMPACT_INLINED __attribute__((always_inline)) inline
#else
#define IMPACT_INLINED inline
#endif
