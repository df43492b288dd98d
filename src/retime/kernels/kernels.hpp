// The kernels' common words. They take arrays and scalars, know nothing of Python, and give the same bits on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Wide SIMD chosen when the program starts, where the compiler and the platform can do that. The clones differ in width only:
// sums are written in a fixed order and never contracted, so their results don't.
#if defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && (defined(__GNUC__) && !defined(__clang__))
#define RETIME_WIDE __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define RETIME_WIDE
#endif

namespace retime {

using std::size_t;

// A path must be at input frame `frame` when it is at output position `position`.
struct Anchor {
    int64_t position;
    int64_t frame;
};

struct Path {
    std::vector<int64_t> frames;
    double total = 0.0;
    bool found = false;
};

}  // namespace retime
