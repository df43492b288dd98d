#pragma once

#include "kernels.hpp"

namespace retime {

struct PricedPath {
    Path path;
    double lower_bound = 0.0;
    int64_t labels = 0;          // labels carried in the last pass
    int64_t passes = 0;          // passes with a widening gap
    int64_t sweeps = 0;          // sweeps over all scores that looked for the price
    double sweep_seconds = 0.0;  // spent in them
    bool gave_up = false;        // more memory than allowed: the layered recurrence is the better way
};

// The best path through every anchor, found by a price on the count and proved by its bound.
PricedPath priced_path(const PathProblem& problem, size_t max_bytes);

// The best path of any length through the anchors' frames, of equal ones the shortest; their positions are ignored.
Path free_path(const PathProblem& problem);

}  // namespace retime
