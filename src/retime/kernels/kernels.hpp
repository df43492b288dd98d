// The kernels' common words. They take arrays and scalars, know nothing of Python, and give the same bits on every
// machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simd.hpp"
#include "steps.hpp"

namespace retime {

using std::size_t;

// A path must be at input frame `frame` when it is at output position `position`.
struct Anchor {
    int64_t position;
    int64_t frame;
};

// What a path search is asked for. scores: (n_input, n_pairs), inf forbids. The first anchor is (0, 0), the
// last one stands at frame n_input - 1 in a position from its own to `last_position_max` (the same where the length is
// fixed). start_cost and end_cost: one number a step, added for the first and the last step; inf forbids.
struct PathProblem {
    const double* scores;
    size_t n_input;
    const Steps& steps;
    const std::vector<Anchor>& anchors;
    int64_t last_position_max;
    const double* start_cost;
    const double* end_cost;
    // For each position the first and the last frame at which the path may stand there; null: any. For the layered
    // recurrence alone.
    const int64_t* band = nullptr;
};

struct Path {
    std::vector<int64_t> frames;
    double total = 0.0;
    bool found = false;
};

}  // namespace retime
