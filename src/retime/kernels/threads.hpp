// Work on parts of a range, one a thread.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "watch.hpp"

namespace retime {

using std::size_t;

// Runs work(from, to) on parts of [begin, end), one a thread. Throws what one of them threw.
template <typename Work>
void in_threads(size_t begin, size_t end, int n_threads, Work work) {
    const size_t n = end - begin, parts = std::max<size_t>(1, std::min<size_t>(n_threads < 1 ? 1 : n_threads, n));
    std::vector<std::exception_ptr> failed(parts);
    const auto run = [&](size_t part) {
        try {
            work(begin + n * part / parts, begin + n * (part + 1) / parts);
        } catch (...) {
            failed[part] = std::current_exception();
        }
    };
    Watch* const watch = Watch::here();
    std::mutex alone;
    std::condition_variable ended;
    size_t n_running = 0;
    const auto help = [&](size_t part) {
        {
            const Watch::Helper helper(watch);
            run(part);
        }
        const std::lock_guard<std::mutex> locked(alone);
        --n_running;
        ended.notify_one();
    };
    std::vector<std::thread> pool;
    pool.reserve(parts);
    size_t started = 1;
    try {
        for (; started < parts; ++started) {
            {
                const std::lock_guard<std::mutex> locked(alone);
                ++n_running;
            }
            pool.emplace_back(help, started);
        }
    } catch (const std::system_error&) {
        // The system gives no more threads: this one does the rest.
        {
            const std::lock_guard<std::mutex> locked(alone);
            --n_running;
        }
        for (size_t part = started; part < parts; ++part) run(part);
    }
    run(0);
    // Helpers ask nobody: while they are at work, this thread does.
    std::unique_lock<std::mutex> locked(alone);
    while (!ended.wait_for(locked, Watch::kRest, [&] { return n_running == 0; })) {
        locked.unlock();
        try {
            look();
        } catch (...) {
            failed[0] = std::current_exception();
        }
        locked.lock();
    }
    locked.unlock();
    for (auto& thread : pool) thread.join();
    for (const auto& failure : failed)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace retime
