// One step of the recurrence, shared by both searches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "simd.hpp"

namespace retime {

// Asks for a cache line that will be read soon.
RETIME_INLINE void prefetch(const void* place) {
#if defined(__GNUC__)
    __builtin_prefetch(place);
#else
    (void)place;
#endif
}

// Costs are kept where a step begins: leaving[j * s + b - 1] is that of the best path whose last step goes from frame j to j + b. So
// what a frame computes is one row, stored at once, and the frames ahead read single numbers of it:
//
//   best[b] = charge + min over nearest <= a <= farthest of  leaving[(j - a) * s + a - 1] + f[a - 1][b],  the smaller a in a tie;
//
// step[b] is that a. The farthest a comes first: the nearest frame's row was stored just before.
template <typename Lanes, int kPacks>
RETIME_INLINE void extend_packs(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest, double charge, double* best,
                                uint8_t* step) {
    using Sums = typename Lanes::Numbers;
    using Steps = typename Lanes::Integers;
    constexpr int kLanes = sizeof(Sums) / sizeof(double);
    Sums least[kPacks];
    Steps from[kPacks];
    for (int pack = 0; pack < kPacks; ++pack) least[pack] = std::numeric_limits<double>::infinity() - Sums{}, from[pack] = Steps{};
    for (int64_t a = farthest; a >= nearest; --a) {
        const double cost = leaving[a - 1 - a * s];
        for (int pack = 0; pack < kPacks; ++pack) {
            Sums total;
            std::memcpy(&total, f + (a - 1) * s + pack * kLanes, sizeof total);
            total += cost;
            const Steps better = total <= least[pack];
            least[pack] = better ? total : least[pack];
            from[pack] = better ? Steps{} + a : from[pack];
        }
    }
    for (int pack = 0; pack < kPacks; ++pack) {
        const Sums sum = least[pack] + charge;
        std::memcpy(best + pack * kLanes, &sum, sizeof sum);
        int64_t each[kLanes];
        std::memcpy(each, &from[pack], sizeof each);
        for (int b = 0; b < kLanes; ++b) step[pack * kLanes + b] = static_cast<uint8_t>(each[b]);
    }
}

// All steps b = 1 to s out of frame j; leaving, best and step are the rows of that frame, f its scores.
template <typename Lanes>
RETIME_INLINE void extend(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest, double charge, double* best,
                          uint8_t* step) {
    constexpr int64_t kLanes = sizeof(typename Lanes::Numbers) / sizeof(double);
    constexpr int kEight = kLanes < 8 ? 8 / kLanes : 1;
    if (s == 8 && nearest == 1 && farthest == 8) return extend_packs<Lanes, kEight>(8, leaving, f, 1, 8, charge, best, step);
    int64_t b = 0;
    for (; b + kLanes * kEight <= s; b += kLanes * kEight)
        extend_packs<Lanes, kEight>(s, leaving, f + b, nearest, farthest, charge, best + b, step + b);
    if (b == s) return;
    if (s >= kLanes) {
        for (; b < s; b += kLanes) {
            // The last ones may overlap those before: the same again.
            const int64_t first = std::min(b, s - kLanes);
            extend_packs<Lanes, 1>(s, leaving, f + first, nearest, farthest, charge, best + first, step + first);
        }
        return;
    }
    if constexpr (kLanes > 4)
        if (s >= 4) {
            extend_packs<Four, 1>(s, leaving, f, nearest, farthest, charge, best, step);
            if (s > 4) extend_packs<Four, 1>(s, leaving, f + s - 4, nearest, farthest, charge, best + s - 4, step + s - 4);
            return;
        }
    for (; b < s; ++b) extend_packs<One, 1>(s, leaving, f + b, nearest, farthest, charge, best + b, step + b);
}

// Defines the versions of a kernel from one body, a template over the steps taken at a time.
#define RETIME_STEP_VERSIONS(result, kernel, parameters, arguments)              \
    result kernel##_plain parameters { return kernel##_body<Two> arguments; }     \
    RETIME_STEP_VERSIONS_X86(result, kernel, parameters, arguments)
#if RETIME_X86
#define RETIME_STEP_VERSIONS_X86(result, kernel, parameters, arguments)                        \
    RETIME_AVX2 result kernel##_avx2 parameters { return kernel##_body<Four> arguments; }      \
    RETIME_AVX512 result kernel##_avx512 parameters { return kernel##_body<Eight> arguments; }
#else
#define RETIME_STEP_VERSIONS_X86(result, kernel, parameters, arguments)
#endif

}  // namespace retime
