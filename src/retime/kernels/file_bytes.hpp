// A long file's bytes, quickly. New memory costs more than what is read into it: the system clears it a small page at a
// time, at the first touch of each. Large pages, and several threads, make that a small part.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <system_error>

#include "threads.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace retime {

#if defined(__linux__)

constexpr bool kReadsFiles = true;
constexpr size_t kLargePage = size_t{1} << 21;
// Bytes of one read: between two the work can be ended.
constexpr size_t kReadBytes = size_t{1} << 24;

// Reads a file that was opened from its begin, `most` bytes or as many as it has: returns how many. Throws
// std::system_error.
inline size_t read_file(int file, char* out, size_t most, int n_threads) {
    const auto address = reinterpret_cast<uintptr_t>(out);
    const uintptr_t first = (address + kLargePage - 1) & ~(kLargePage - 1), last = (address + most) & ~(kLargePage - 1);
    // Advice: where there are no large pages, small ones come as ever.
    if (last > first) (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
    std::mutex alone;
    size_t end = most;
    in_threads(0, most / kLargePage + 1, n_threads, [&](size_t from, size_t to) {
        size_t at = std::min(most, from * kLargePage);
        const size_t stop = std::min(most, to * kLargePage);
        while (at < stop) {
            const ssize_t n = pread(file, out + at, std::min(kReadBytes, stop - at), static_cast<off_t>(at));
            if (n < 0 && errno != EINTR) throw std::system_error(errno, std::generic_category());
            if (n == 0) {
                // The file ends here, or ended here as this was read.
                const std::lock_guard<std::mutex> locked(alone);
                end = std::min(end, at);
                return;
            }
            at += n > 0 ? static_cast<size_t>(n) : 0;
            look();
        }
    });
    return end;
}

#else

constexpr bool kReadsFiles = false;

inline size_t read_file(int, char*, size_t, int) { return 0; }

#endif

}  // namespace retime
