#pragma once

#include "kernels.hpp"

namespace retime {

// The best path through every anchor, by the layered recurrence (Eq. 3 and 4). The first anchor is (0, first frame), the last one
// (n_output - 1, last frame). scores: (n_input, max_skip, max_skip), inf forbids. memory_limit bounds the trace, in bytes.
Path layered_path(const double* scores, size_t n_input, size_t max_skip, const std::vector<Anchor>& anchors, size_t memory_limit);

}  // namespace retime
