#pragma once

#include "kernels.hpp"

namespace retime {

// The best path through every anchor, by the layered recurrence (Eq. 3 and 4). memory_limit bounds the trace, in bytes.
Path layered_path(const PathProblem& problem, size_t memory_limit);

}  // namespace retime
