#pragma once

/// A function compiled for AVX2 and FMA as well, chosen when the library is loaded.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define IMPACT_CLONES __attribute__((target_clones("default", "arch=x86-64-v3")))
#else
#define IMPACT_CLONES
#endif
