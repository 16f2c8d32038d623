// ANATOMESH_CLONES stands before the definition of a function. The function is compiled twice, for any x86-64 processor
// and for those with AVX2, and the program takes the one that fits when it starts.
#pragma once

#ifdef __linux__
#include <features.h>
#endif

// Functions that are long beside a call and spend their time on floating-point numbers become a fifth to a half faster.
// What they call is compiled for AVX2 only where it is inlined. Both give the same bytes, because AVX2 brings no fused
// multiply-add, and nothing is summed in another order. For other compilers and processors the macro is empty, and for
// sanitizers, which run before the choice can be made. It is GCC's attribute target_clones, on indirect functions of ELF.
#if defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && defined(__GNUC__) && \
    !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define ANATOMESH_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define ANATOMESH_CLONES
#endif
