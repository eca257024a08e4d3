#pragma once

/// Before a function's definition: it is compiled a second time, for AVX2, and that is taken where the
/// machine has it: its loops work on twice as many numbers at once. The operations stay the same (nothing is
/// contracted to FMA), and so do the bytes. Not under sanitizers, which run too late for the choice.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define UNIQUADRIC_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define UNIQUADRIC_VECTOR_CLONES
#endif
