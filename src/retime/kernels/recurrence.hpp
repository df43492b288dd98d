// One step of the recurrence, shared by both searches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "kernels.hpp"

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

// Costs are kept where a step begins: leaving[j * n + b] is that of the best path whose last step b goes on from frame
// j. So what a frame computes is one row, stored at once, and the frames ahead read single numbers of it:
//
//   best[b] = charge + min over nearest <= a < farthest of  leaving[(j - length[a]) * n + a] + f[row[a] + b];
//
// step[b] is that a, in a tie the smaller. The farthest a comes first: the nearest frame's row was stored just before.
// This is for the steps 1 to s, each of which may follow each.
template <size_t kLanes, size_t kPacks>
RETIME_INLINE void extend_packs(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest,
                                double charge, double* best, uint8_t* step) {
    using Sums = Wide<double, kLanes>;
    using Places = Wide<int64_t, kLanes>;
    Sums least[kPacks];
    Places from[kPacks];
    for (size_t pack = 0; pack < kPacks; ++pack) least[pack] = Sums{} + kInf, from[pack] = Places{};
    for (int64_t a = farthest - 1; a >= nearest; --a) {
        const double cost = leaving[a - (a + 1) * s];
        for (size_t pack = 0; pack < kPacks; ++pack) {
            const Sums total = load<Sums>(f + a * s + pack * kLanes) + cost;
            const auto better = total <= least[pack];
            least[pack] = choose(better, total, least[pack]);
            from[pack] = choose(better, Places{} + a, from[pack]);
        }
    }
    for (size_t pack = 0; pack < kPacks; ++pack) {
        store(Sums(least[pack] + charge), best + pack * kLanes);
        int64_t each[kLanes];
        store(from[pack], each);
        for (size_t b = 0; b < kLanes; ++b) step[pack * kLanes + b] = static_cast<uint8_t>(each[b]);
    }
}

// All steps out of frame j; leaving, best and step are the rows of that frame, f its scores.
template <typename Level>
RETIME_INLINE void extend_every(int64_t s, const double* leaving, const double* f, int64_t nearest, int64_t farthest,
                                double charge, double* best, uint8_t* step) {
    constexpr int64_t kLanes = Level::kDoubles;
    constexpr int64_t kEight = kLanes < 8 ? 8 / kLanes : 1;
    if (s == 8 && nearest == 0 && farthest == 8)
        return extend_packs<kLanes, kEight>(8, leaving, f, 0, 8, charge, best, step);
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

// The same for any steps and pairs. A pack of steps out meets those steps in that may come before one of them; a pair
// that may not be is read all the same, whatever stands in its place, and made infinite. So with kLanes > 1 a frame's
// scores need Steps::wide numbers before them and behind, and its rows as many behind, which the next frame overwrites.
template <size_t kLanes>
RETIME_INLINE void extend_pairs(const Steps& steps, const double* leaving, const double* f, int64_t nearest,
                                int64_t farthest, double charge, double* best, uint8_t* step) {
    using Sums = Wide<double, kLanes>;
    using Places = Wide<int64_t, kLanes>;
    const int64_t n = static_cast<int64_t>(steps.n), wide = static_cast<int64_t>(steps.wide);
    for (int64_t b = 0; b < n; b += static_cast<int64_t>(kLanes)) {
        const int64_t last = std::min(b + static_cast<int64_t>(kLanes), n) - 1;
        const int64_t low = std::max(nearest, steps.before_first[b]), high = std::min(farthest, steps.before_end[last]);
        Sums least = Sums{} + kInf;
        Places from = Places{};
        for (int64_t a = high - 1; a >= low; --a) {
            const double cost = leaving[a - steps.length[a] * n];
            const Sums total =
                (load<Sums>(f + steps.row[a] + b) + cost) + load<Sums>(steps.forbidden.data() + a * wide + b);
            const auto better = total <= least;
            least = choose(better, total, least);
            from = choose(better, Places{} + a, from);
        }
        store(Sums(least + charge), best + b);
        int64_t each[kLanes];
        store(from, each);
        for (size_t lane = 0; lane < kLanes; ++lane) step[b + lane] = static_cast<uint8_t>(each[lane]);
    }
}

// What a search reads again and again, in one place that nothing is written to: a step is kept as a byte, and a
// compiler must expect such a byte to change whatever it has a pointer to.
struct Reading {
    const double* scores;
    int64_t n, n_pairs, n_input, longest, wide;

    explicit Reading(const PathProblem& p) : Reading(p, p.scores) {}
    Reading(const PathProblem& p, const double* from)
        : scores(from),
          n(static_cast<int64_t>(p.steps.n)),
          n_pairs(static_cast<int64_t>(p.steps.n_pairs)),
          n_input(static_cast<int64_t>(p.n_input)),
          longest(p.steps.longest),
          wide(static_cast<int64_t>(p.steps.wide)) {}
};

// How many steps are no longer than so many frames; kEvery is what Steps::every says.
template <bool kEvery>
RETIME_INLINE int64_t up_to(const Steps& steps, const Reading& r, int64_t frames) {
    return kEvery ? std::clamp<int64_t>(frames, 0, r.longest) : steps.up_to(frames);
}

// All steps out of frame j.
template <typename Level, bool kEvery>
RETIME_INLINE void extend(const Steps& steps, const Reading& r, int64_t j, const double* leaving, int64_t nearest,
                          int64_t farthest, double charge, double* best, uint8_t* step) {
    const double* f = r.scores + j * r.n_pairs;
    if constexpr (kEvery)
        extend_every<Level>(r.n, leaving, f, nearest, farthest, charge, best, step);
    else if (j * r.n_pairs >= r.wide && (r.n_input - 1 - j) * r.n_pairs >= r.wide)
        extend_pairs<Level::kDoubles>(steps, leaving, f, nearest, farthest, charge, best, step);
    else
        extend_pairs<1>(steps, leaving, f, nearest, farthest, charge, best, step);
}

}  // namespace retime
