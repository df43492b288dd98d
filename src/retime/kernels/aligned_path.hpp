#pragma once

#include "kernels.hpp"
#include "scores.hpp"

namespace retime {

// The path that keeps step with a reference: what a triple costs is its distance to the one reference row that stands
// for its place in the output, and a price of its own. Row p - 1 of scores.reference stands for position p, so that it
// has as many rows as the output has inner frames; the scores of `path` (n_input, n_pairs) are the prices, inf forbids.
// memory_limit bounds the trace, in bytes; table_limit the costs that are kept at once, if one position's are fewer.
Path aligned_path(const ScoreProblem& scores, const PathProblem& path, int n_threads, size_t memory_limit,
                  size_t table_limit);

}  // namespace retime
