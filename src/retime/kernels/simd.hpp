// Vectors of any width, and the machines that have them; which to use is chosen when the program runs. Versions of a
// kernel differ in width only: sums are written in a fixed order and never contracted, so their results don't.
// RETIME_SIMD=plain or avx2 in the environment narrows the choice.
#pragma once

#include <bit>
#include <cfloat>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <type_traits>

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "the kernels need sums in the order that is written, and infinities: build them without fast-math"
#endif
static_assert(FLT_EVAL_METHOD == 0, "the kernels need every operation rounded to its own type");
#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)
#endif

// GCC and clang have vectors of any width. Elsewhere (and with RETIME_NO_VECTORS, to try that) they are arrays whose
// loops the compiler may unroll.
#if defined(__GNUC__) && !defined(RETIME_NO_VECTORS)
#define RETIME_VECTORS 1
#else
#define RETIME_VECTORS 0
#endif

// Vectors stay in registers only where what works on them becomes part of its caller.
#if defined(__GNUC__)
#define RETIME_INLINE inline __attribute__((always_inline))
#define RETIME_LAMBDA_INLINE __attribute__((always_inline))
#elif defined(_MSC_VER)
#define RETIME_INLINE __forceinline
#define RETIME_LAMBDA_INLINE
#else
#define RETIME_INLINE inline
#define RETIME_LAMBDA_INLINE
#endif

// Versions for AVX2 and AVX-512 stand beside the plain one, where the compiler takes a target for a single function.
#if RETIME_VECTORS && defined(__x86_64__)
#define RETIME_X86 1
#define RETIME_AVX2 __attribute__((target("avx2")))
#define RETIME_AVX512 __attribute__((target("arch=x86-64-v4")))
#include <immintrin.h>
#else
#define RETIME_X86 0
#endif

namespace retime {

using std::size_t;

template <typename T, size_t n>
struct WideOf;

template <typename T>
struct WideOf<T, 1> {
    using type = T;
};

#if RETIME_VECTORS

template <typename T, size_t n>
struct WideOf {
    typedef T type __attribute__((vector_size(n * sizeof(T))));
};

#else

template <typename T, size_t n>
struct Numbers {
    T at[n];

    template <typename Result, typename Work>
    static RETIME_INLINE Numbers<Result, n> each(Work work) {
        Numbers<Result, n> out;
        for (size_t lane = 0; lane < n; ++lane) out.at[lane] = work(lane);
        return out;
    }
};

#define RETIME_EACH_LANE(op, Result)                                                                        \
    template <typename T, size_t n>                                                                         \
    RETIME_INLINE Numbers<Result, n> operator op(const Numbers<T, n>& one, const Numbers<T, n>& other) {    \
        return Numbers<T, n>::template each<Result>([&](size_t l) { return one.at[l] op other.at[l]; });    \
    }                                                                                                       \
    template <typename T, size_t n>                                                                         \
    RETIME_INLINE Numbers<Result, n> operator op(const Numbers<T, n>& one, std::type_identity_t<T> other) { \
        return Numbers<T, n>::template each<Result>([&](size_t l) { return one.at[l] op other; });          \
    }                                                                                                       \
    template <typename T, size_t n>                                                                         \
    RETIME_INLINE Numbers<Result, n> operator op(std::type_identity_t<T> one, const Numbers<T, n>& other) { \
        return Numbers<T, n>::template each<Result>([&](size_t l) { return one op other.at[l]; });          \
    }
RETIME_EACH_LANE(+, T)
RETIME_EACH_LANE(-, T)
RETIME_EACH_LANE(*, T)
RETIME_EACH_LANE(<, bool)
RETIME_EACH_LANE(<=, bool)
RETIME_EACH_LANE(>, bool)
#undef RETIME_EACH_LANE

template <typename T, size_t n, typename More>
RETIME_INLINE Numbers<T, n>& operator+=(Numbers<T, n>& sum, const More& more) {
    return sum = sum + more;
}

template <typename T, size_t n>
RETIME_INLINE Numbers<T, n> choose(const Numbers<bool, n>& which, const Numbers<T, n>& one,
                                   const Numbers<T, n>& other) {
    return Numbers<T, n>::template each<T>([&](size_t l) { return which.at[l] ? one.at[l] : other.at[l]; });
}

template <typename T, size_t n>
struct WideOf {
    using type = Numbers<T, n>;
};

#endif

// n numbers, on which + - * and comparisons work lane by lane; `V{} + x` has x in every lane.
template <typename T, size_t n>
using Wide = typename WideOf<T, n>::type;

// In each lane the one number where `which` holds, else the other.
template <typename Which, typename V>
RETIME_INLINE V choose(const Which& which, const V& one, const V& other) {
    return which ? one : other;
}

template <typename V, typename T>
RETIME_INLINE V load(const T* from) {
    V numbers;
    std::memcpy(&numbers, from, sizeof numbers);
    return numbers;
}

template <typename V, typename T>
RETIME_INLINE void store(const V& numbers, T* to) {
    std::memcpy(to, &numbers, sizeof numbers);
}

// Where the next set bit stands; bits are not all zero.
template <typename Bits>
RETIME_INLINE size_t next_bit(Bits bits) {
    return static_cast<size_t>(std::countr_zero(bits));
}

// A kind of machine: how many numbers its registers hold, how many rows' sums of products they take at once and how
// many registers of each, and what it does in an instruction of its own. A kernel's body takes one of them as its
// `Level`. Vectors go by reference: not every function that is compiled may have them as arguments.
struct Plain {
    static constexpr size_t kDoubles = 2, kFloats = 4, kRows = 1, kColumns = 2;
    using Floats = Wide<float, kFloats>;
    using Doubles = Wide<double, kDoubles>;

    // Bit l: lane l of one is at most (above) that of the other; not so where either is not a number.
    static RETIME_INLINE uint32_t at_most(const Floats& one, const Floats& other) {
#if RETIME_X86
        return static_cast<uint32_t>(_mm_movemask_ps((__m128)(one <= other)));
#else
        return bits<kFloats, float>(one, other, [](float a, float b) { return a <= b; });
#endif
    }
    static RETIME_INLINE uint32_t above(const Doubles& one, const Doubles& other) {
#if RETIME_X86
        return static_cast<uint32_t>(_mm_movemask_pd((__m128d)(one > other)));
#else
        return bits<kDoubles, double>(one, other, [](double a, double b) { return a > b; });
#endif
    }
    // least = min(number, least), that is `least` where the number is none.
    static RETIME_INLINE void lower(Floats& least, const Floats& number) {
        least = choose(number < least, number, least);
    }
    // sum += number * column: products that only choose candidates may be rounded once or twice.
    static RETIME_INLINE void add_product(Floats& sum, float number, const Floats& column) { sum += number * column; }

  private:
    template <size_t n, typename T, typename V, typename Holds>
    static RETIME_INLINE uint32_t bits(const V& one, const V& other, Holds holds) {
        T a[n], b[n];
        store(one, a), store(other, b);
        uint32_t found = 0;
        for (size_t l = 0; l < n; ++l) found |= static_cast<uint32_t>(holds(a[l], b[l])) << l;
        return found;
    }
};

#if RETIME_X86

struct Avx2 {
    static constexpr size_t kDoubles = 4, kFloats = 8, kRows = 2, kColumns = 2;
    using Floats = Wide<float, kFloats>;
    using Doubles = Wide<double, kDoubles>;

    RETIME_AVX2 static inline uint32_t at_most(const Floats& one, const Floats& other) {
        return static_cast<uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps((__m256)one, (__m256)other, _CMP_LE_OQ)));
    }
    RETIME_AVX2 static inline uint32_t above(const Doubles& one, const Doubles& other) {
        return static_cast<uint32_t>(_mm256_movemask_pd(_mm256_cmp_pd((__m256d)one, (__m256d)other, _CMP_GT_OQ)));
    }
    // The minimum is its second operand where the first is not a number.
    RETIME_AVX2 static inline void lower(Floats& least, const Floats& number) {
        least = (Floats)_mm256_min_ps((__m256)number, (__m256)least);
    }
    RETIME_AVX2 static inline void add_product(Floats& sum, float number, const Floats& column) {
        sum += number * column;
    }
};

struct Avx512 {
    static constexpr size_t kDoubles = 8, kFloats = 16, kRows = 4, kColumns = 4;
    using Floats = Wide<float, kFloats>;
    using Doubles = Wide<double, kDoubles>;

    RETIME_AVX512 static inline uint32_t at_most(const Floats& one, const Floats& other) {
        return _mm512_cmp_ps_mask((__m512)one, (__m512)other, _CMP_LE_OQ);
    }
    RETIME_AVX512 static inline uint32_t above(const Doubles& one, const Doubles& other) {
        return _mm512_cmp_pd_mask((__m512d)one, (__m512d)other, _CMP_GT_OQ);
    }
    RETIME_AVX512 static inline void lower(Floats& least, const Floats& number) {
        least = (Floats)_mm512_min_ps((__m512)number, (__m512)least);
    }
    RETIME_AVX512 static inline void add_product(Floats& sum, float number, const Floats& column) {
        sum = (Floats)_mm512_fmadd_ps(_mm512_set1_ps(number), (__m512)column, (__m512)sum);
    }
};

#endif

// Those of two vectors' numbers that stand in the given places.
#if RETIME_VECTORS && defined(__has_builtin)
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
        if (best == Simd::avx2 && __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
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

// RETIME_VERSIONS defines a kernel's versions from one body, the RETIME_INLINE template `kernel_body<Level>`;
// RETIME_CALL calls that for this machine.
#if RETIME_X86
#define RETIME_VERSIONS(result, kernel, parameters, arguments)                            \
    result kernel##_plain parameters { return kernel##_body<Plain> arguments; }           \
    RETIME_AVX2 result kernel##_avx2 parameters { return kernel##_body<Avx2> arguments; } \
    RETIME_AVX512 result kernel##_avx512 parameters { return kernel##_body<Avx512> arguments; }
#define RETIME_CALL(kernel, ...)                                                     \
    (::retime::simd_level() == ::retime::Simd::avx512 ? kernel##_avx512(__VA_ARGS__) \
     : ::retime::simd_level() == ::retime::Simd::avx2 ? kernel##_avx2(__VA_ARGS__)   \
                                                      : kernel##_plain(__VA_ARGS__))
#else
#define RETIME_VERSIONS(result, kernel, parameters, arguments) \
    result kernel##_plain parameters { return kernel##_body<Plain> arguments; }
#define RETIME_CALL(kernel, ...) kernel##_plain(__VA_ARGS__)
#endif

}  // namespace retime
