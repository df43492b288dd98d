#pragma once

#include "kernels.hpp"

namespace retime {

// The frames at which a path may stand in one position, both included.
struct Band {
    int64_t low, high;
    size_t size() const { return high < low ? 0 : static_cast<size_t>(high - low + 1); }
};

// Scores that depend on where in the output a triple is shown.
class ScoresByPosition {
  public:
    virtual ~ScoresByPosition() = default;
    // Those of triples whose middle is shown in position p, (n_input, n_pairs); the rows of bands[p] hold them. They
    // stay until the next call.
    virtual const double* at(int64_t p, const std::vector<Band>& bands) = 0;
};

// The best path through every anchor, by the layered recurrence (Eq. 3 and 4). memory_limit bounds the trace, in bytes.
// With `by_position` those are its scores, in place of the problem's.
Path layered_path(const PathProblem& problem, size_t memory_limit, ScoresByPosition* by_position = nullptr);

}  // namespace retime
