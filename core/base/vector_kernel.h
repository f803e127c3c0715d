#pragma once

/// @file
/// Loops over columns that the compiler turns into vector code.

// One copy of a kernel for every kind of processor, chosen when the program starts. All give the
// same bits: vector instructions round each operation like scalar ones, std::fma is rounded once
// everywhere, and the build forbids to contract a multiplication and an addition into one.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    defined(__GNUC__) && !defined(__clang__)
#define PLIANT_VECTOR_KERNEL __attribute__((target_clones("avx2", "default")))
#define PLIANT_FMA_KERNEL __attribute__((target_clones("arch=haswell", "default")))
#else
#define PLIANT_VECTOR_KERNEL
#define PLIANT_FMA_KERNEL
#endif

// What a loop calls has to be put in place; the compiler may think it too large.
#if defined(__GNUC__)
#define PLIANT_PART_OF_KERNEL [[gnu::always_inline]]
#else
#define PLIANT_PART_OF_KERNEL
#endif

// The columns of a kernel never overlap; the compiler cannot know.
#if defined(__clang__)
#define PLIANT_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define PLIANT_INDEPENDENT _Pragma("GCC ivdep")
#endif
