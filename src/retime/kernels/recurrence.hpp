// One step of the recurrence, shared by both searches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "simd.hpp"

namespace retime {

constexpr double kInf = std::numeric_limits<double>::infinity();

// Asks for a cache line that will be read soon.
RETIME_INLINE void prefetch(const void* place) {
#if defined(__GNUC__)
    __builtin_prefetch(place);
#else
    (void)place;
#endif
}

// Costs are kept where a step begins: leaving[j * s + b - 1] is that of the best path whose last step goes from frame j
// to j + b. So what a frame computes is one row, stored at once, and the frames ahead read single numbers of it:
//
//   best[b] = charge + min over nearest <= a <= farthest of  leaving[(j - a) * s + a - 1] + f[a - 1][b];
//
// step[b] is that a, in a tie the smaller. The farthest a comes first: the nearest frame's row was stored just before.
template <size_t kLanes, size_t kPacks>
RETIME_INLINE void extend_packs(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest,
                                double charge, double* best, uint8_t* step) {
    using Sums = Wide<double, kLanes>;
    using Steps = Wide<int64_t, kLanes>;
    Sums least[kPacks];
    Steps from[kPacks];
    for (size_t pack = 0; pack < kPacks; ++pack) least[pack] = Sums{} + kInf, from[pack] = Steps{};
    for (int64_t a = farthest; a >= nearest; --a) {
        const double cost = leaving[a - 1 - a * s];
        for (size_t pack = 0; pack < kPacks; ++pack) {
            const Sums total = load<Sums>(f + (a - 1) * s + pack * kLanes) + cost;
            const auto better = total <= least[pack];
            least[pack] = choose(better, total, least[pack]);
            from[pack] = choose(better, Steps{} + a, from[pack]);
        }
    }
    for (size_t pack = 0; pack < kPacks; ++pack) {
        store(Sums(least[pack] + charge), best + pack * kLanes);
        int64_t each[kLanes];
        store(from[pack], each);
        for (size_t b = 0; b < kLanes; ++b) step[pack * kLanes + b] = static_cast<uint8_t>(each[b]);
    }
}

// All steps b = 1 to s out of frame j; leaving, best and step are the rows of that frame, f its scores.
template <typename Level>
RETIME_INLINE void extend(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest,
                          double charge, double* best, uint8_t* step) {
    constexpr int64_t kLanes = Level::kDoubles;
    constexpr int64_t kEight = kLanes < 8 ? 8 / kLanes : 1;
    if (s == 8 && nearest == 1 && farthest == 8)
        return extend_packs<kLanes, kEight>(8, leaving, f, 1, 8, charge, best, step);
    int64_t b = 0;
    for (; b + kLanes * kEight <= s; b += kLanes * kEight)
        extend_packs<kLanes, kEight>(s, leaving, f + b, nearest, farthest, charge, best + b, step + b);
    if (b == s) return;
    if (s >= kLanes) {
        for (; b < s; b += kLanes) {
            // The last ones may overlap those before: the same again.
            const int64_t first = std::min(b, s - kLanes);
            extend_packs<kLanes, 1>(s, leaving, f + first, nearest, farthest, charge, best + first, step + first);
        }
        return;
    }
    if constexpr (kLanes > 4)
        if (s >= 4) {
            extend_packs<4, 1>(s, leaving, f, nearest, farthest, charge, best, step);
            if (s > 4) extend_packs<4, 1>(s, leaving, f + s - 4, nearest, farthest, charge, best + s - 4, step + s - 4);
            return;
        }
    for (; b < s; ++b) extend_packs<1, 1>(s, leaving, f + b, nearest, farthest, charge, best + b, step + b);
}

}  // namespace retime
