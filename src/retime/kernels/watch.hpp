// Who began a kernel is asked now and then whether its answer is still wanted: so Ctrl-C, or a newer request, ends it.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <utility>

namespace retime {

// Thrown through a kernel that is not wanted any more.
struct Stopped {};

class Watch {
  public:
    // Called in the thread that made the watch, with the share of the work that is done, or nan where nobody knows;
    // false ends the work.
    using Ask = std::function<bool(double share)>;

    explicit Watch(Ask ask) : ask_(std::move(ask)), before_(here_) { here_ = this; }
    ~Watch() { here_ = before_; }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    // The one of this thread, or null.
    static Watch* here() { return here_; }

    // A thread that helps with what is watched.
    class Helper {
      public:
        explicit Helper(Watch* watch) { here_ = watch, helps_ = true; }
        ~Helper() { here_ = nullptr, helps_ = false; }
        Helper(const Helper&) = delete;
        Helper& operator=(const Helper&) = delete;
    };

    void look(double share) {
        if (stopped_.load(std::memory_order_relaxed)) throw Stopped{};
        if (helps_) return;
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < kRest) return;
        if (!ask_(share)) {
            stopped_.store(true, std::memory_order_relaxed);
            throw Stopped{};
        }
        last_ = std::chrono::steady_clock::now();
    }

    // Between two questions; also how long a thread waits for its helpers before it asks.
    static constexpr std::chrono::milliseconds kRest{50};

  private:
    Ask ask_;
    Watch* before_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
    std::atomic<bool> stopped_{false};
    inline static thread_local Watch* here_ = nullptr;
    inline static thread_local bool helps_ = false;
};

// Called by long loops, some thousands of times a second or more.
inline void look(double share = std::numeric_limits<double>::quiet_NaN()) {
    if (Watch* watch = Watch::here()) watch->look(share);
}

inline void look(size_t done, size_t all) { look(static_cast<double>(done) / static_cast<double>(all ? all : 1)); }

}  // namespace retime
