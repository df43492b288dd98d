// One step of the recurrence, shared by both searches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "simd.hpp"

namespace retime {

// best[b] = min over a of cost[a] + f[a][b], the smaller a in a tie; step[b] = that a, 0 where all are inf.
template <int kSteps>
RETIME_INLINE void extend_fixed(const double* cost, const double* f, double* best, uint8_t* step) {
    double least[kSteps];
    double from[kSteps];
    for (int b = 0; b < kSteps; ++b) least[b] = std::numeric_limits<double>::infinity(), from[b] = 0.0;
    for (int a = 0; a < kSteps; ++a)
        for (int b = 0; b < kSteps; ++b) {
            const double total = cost[a] + f[a * kSteps + b];
            const bool better = total < least[b];
            least[b] = better ? total : least[b];
            from[b] = better ? static_cast<double>(a + 1) : from[b];
        }
    for (int b = 0; b < kSteps; ++b) best[b] = least[b], step[b] = static_cast<uint8_t>(from[b]);
}

RETIME_INLINE void extend_any(int64_t s, const double* cost, const double* f, double* best, uint8_t* step) {
    std::fill(best, best + s, std::numeric_limits<double>::infinity());
    std::fill(step, step + s, uint8_t{0});
    for (int64_t a = 0; a < s; ++a) {
        if (cost[a] == std::numeric_limits<double>::infinity()) continue;
        for (int64_t b = 0; b < s; ++b) {
            const double total = cost[a] + f[a * s + b];
            if (total < best[b]) best[b] = total, step[b] = static_cast<uint8_t>(a + 1);
        }
    }
}

RETIME_INLINE void extend(int64_t s, const double* cost, const double* f, double* best, uint8_t* step) {
    if (s == 8)
        extend_fixed<8>(cost, f, best, step);
    else if (s == 4)
        extend_fixed<4>(cost, f, best, step);
    else if (s == 16)
        extend_fixed<16>(cost, f, best, step);
    else
        extend_any(s, cost, f, best, step);
}

}  // namespace retime
