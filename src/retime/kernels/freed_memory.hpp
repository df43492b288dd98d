// What a process does with memory that it has freed.
#pragma once

#include <climits>
#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace retime {

// Keep freed memory for what is allocated next. glibc would give every large block back to the system, which clears
// the pages of the next one again: where arrays of a long take come and go, a good part of all the work.
inline void keep_freed_memory() {
#if defined(__GLIBC__)
    mallopt(M_MMAP_MAX, 0);
    // More than this at the end of the heap is given back all the same.
    mallopt(M_TRIM_THRESHOLD, INT_MAX);
#endif
}

}  // namespace retime
