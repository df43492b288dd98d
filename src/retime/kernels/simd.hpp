// Which vector instructions to use, chosen when the program runs. Versions of a kernel differ in width only: sums are written in a
// fixed order and never contracted, so their results don't. RETIME_SIMD=plain or avx2 in the environment narrows the choice.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>

#if defined(__GNUC__)
#define RETIME_INLINE inline __attribute__((always_inline))
#define RETIME_LAMBDA_INLINE __attribute__((always_inline))
#else
#define RETIME_INLINE inline
#define RETIME_LAMBDA_INLINE
#endif

#if defined(__x86_64__) && defined(__GNUC__)
#define RETIME_X86 1
#define RETIME_AVX2 __attribute__((target("avx2")))
#define RETIME_AVX512 __attribute__((target("arch=x86-64-v4")))
#else
#define RETIME_X86 0
#define RETIME_AVX2
#define RETIME_AVX512
#endif

namespace retime {

// Numbers that a kernel takes at a time. Vectors of the compiler's own, as wide as the registers: left to itself it keeps sums in memory,
// and so it does with wider ones.
struct One {
    typedef double Numbers;
    typedef int64_t Integers;
};
#if defined(__GNUC__)
struct Two {
    typedef double Numbers __attribute__((vector_size(16)));
    typedef int64_t Integers __attribute__((vector_size(16)));
};
struct Four {
    typedef double Numbers __attribute__((vector_size(32)));
    typedef int64_t Integers __attribute__((vector_size(32)));
};
struct Eight {
    typedef double Numbers __attribute__((vector_size(64)));
    typedef int64_t Integers __attribute__((vector_size(64)));
};
#else
using Two = One;
using Four = One;
#endif

// Those of two vectors' numbers that stand in the given places.
#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define RETIME_SHUFFLE(...) __builtin_shufflevector(__VA_ARGS__)
#endif
#endif

enum class Simd { plain, avx2, avx512 };

inline Simd simd_level() {
    static const Simd level = [] {
        Simd best = Simd::plain;
#if RETIME_X86
        if (__builtin_cpu_supports("avx2")) best = Simd::avx2;
        if (best == Simd::avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
            best = Simd::avx512;
#endif
        const char* wanted = std::getenv("RETIME_SIMD");
        if (wanted && std::strcmp(wanted, "plain") == 0) best = Simd::plain;
        if (wanted && std::strcmp(wanted, "avx2") == 0 && best == Simd::avx512) best = Simd::avx2;
        return best;
    }();
    return level;
}

// Calls the version of `kernel` for this machine: kernel_plain, kernel_avx2, kernel_avx512.
#if RETIME_X86
#define RETIME_CALL(kernel, ...)                                                                     \
    (::retime::simd_level() == ::retime::Simd::avx512 ? kernel##_avx512(__VA_ARGS__)                 \
     : ::retime::simd_level() == ::retime::Simd::avx2 ? kernel##_avx2(__VA_ARGS__)                   \
                                                      : kernel##_plain(__VA_ARGS__))
#else
#define RETIME_CALL(kernel, ...) kernel##_plain(__VA_ARGS__)
#endif

// Defines those versions from one body, `kernel_body`, which must be RETIME_INLINE.
#define RETIME_VERSIONS(result, kernel, parameters, arguments)          \
    result kernel##_plain parameters { return kernel##_body arguments; } \
    RETIME_VERSIONS_X86(result, kernel, parameters, arguments)
#if RETIME_X86
#define RETIME_VERSIONS_X86(result, kernel, parameters, arguments)                     \
    RETIME_AVX2 result kernel##_avx2 parameters { return kernel##_body arguments; }     \
    RETIME_AVX512 result kernel##_avx512 parameters { return kernel##_body arguments; }
#else
#define RETIME_VERSIONS_X86(result, kernel, parameters, arguments)
#endif

}  // namespace retime
