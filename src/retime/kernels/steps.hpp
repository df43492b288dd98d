// The steps that a path may take, and which of them may follow which.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "simd.hpp"

namespace retime {

// Steps out of a frame that are taken together, after the same step into it.
constexpr size_t kGroup = 8;

// Steps are named by their places in `length`, the shortest first: a is the step into a frame, b the one out of it.
// After a come the steps from first[a] on, to before end[a]; neither goes down as a goes up, so that those before b are
// neighbours too. The scores of a frame stand one after another, by a, then by b: that of a pair at row[a] + b.
struct Steps {
    std::vector<int64_t> length, first, end, row, before_first, before_end;
    // The steps after a stand in groups of kGroup, from group[a] on of those of all.
    std::vector<size_t> group;
    size_t n_groups = 0;
    // What a path pays for a pair: nothing, or infinity where it may not be; (n, wide).
    std::vector<double> forbidden;
    size_t n, wide, n_pairs = 0;
    int64_t shortest, longest;
    // Whether these are all steps from one frame on, each of which may follow each.
    bool every;

    Steps(const int64_t* lengths, const int64_t* firsts, const int64_t* ends, size_t n_steps)
        : length(lengths, lengths + n_steps),
          first(firsts, firsts + n_steps),
          end(ends, ends + n_steps),
          before_first(n_steps, static_cast<int64_t>(n_steps)),
          before_end(n_steps, 0),
          n(n_steps),
          wide((n_steps + kGroup - 1) / kGroup * kGroup),
          shortest(length.front()),
          longest(length.back()),
          up_to_(static_cast<size_t>(longest) + 1, 0) {
        forbidden.assign(n * wide, std::numeric_limits<double>::infinity());
        for (size_t a = 0; a < n; ++a) {
            row.push_back(static_cast<int64_t>(n_pairs) - first[a]);
            n_pairs += static_cast<size_t>(end[a] - first[a]);
            group.push_back(n_groups);
            n_groups += (static_cast<size_t>(end[a] - first[a]) + kGroup - 1) / kGroup;
            for (int64_t b = first[a]; b < end[a]; ++b) {
                before_first[b] = std::min(before_first[b], static_cast<int64_t>(a));
                before_end[b] = static_cast<int64_t>(a) + 1;
                forbidden[a * wide + b] = 0.0;
            }
            for (int64_t frames = length[a]; frames <= longest; ++frames) up_to_[frames] = static_cast<int64_t>(a) + 1;
        }
        every = n_pairs == n * n && longest == static_cast<int64_t>(n);
    }

    // How many steps are no longer than so many frames.
    int64_t up_to(int64_t frames) const { return frames <= 0 ? 0 : up_to_[std::min(frames, longest)]; }

    // Runs work(a, b, n, place) for the groups of triples (j - length[a], j, j + length[b]) up to that of b + n - 1,
    // all within n_input frames; they are n <= kGroup, and `place` is that of the group.
    template <typename Work>
    RETIME_INLINE void each_group(size_t j, size_t n_input, Work work) const {
        const int64_t n_in = up_to(static_cast<int64_t>(j)), n_out = up_to(static_cast<int64_t>(n_input - 1 - j));
        for (int64_t a = 0; a < n_in; ++a) {
            size_t place = group[a];
            const int64_t last = std::min(end[a], n_out);
            for (int64_t b = first[a]; b < last; b += kGroup, ++place)
                work(static_cast<size_t>(a), static_cast<size_t>(b),
                     static_cast<size_t>(std::min<int64_t>(kGroup, last - b)), place);
        }
    }

  private:
    std::vector<int64_t> up_to_;
};

}  // namespace retime
