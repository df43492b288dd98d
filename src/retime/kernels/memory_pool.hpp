// Memory for arrays that live as long as a call: on cache lines, and kept for the next call. New pages cost more than
// what is written to them, and so do vectors that cross lines.
#pragma once

#include <cstddef>
#include <mutex>
#include <new>
#include <vector>

namespace retime {

constexpr std::size_t kLine = 64;

class MemoryPool {
  public:
    static MemoryPool& all() {
        static MemoryPool pool;
        return pool;
    }

    void* take(std::size_t n_bytes) {
        {
            const std::lock_guard<std::mutex> alone(mutex_);
            size_t best = blocks_.size();
            for (size_t i = 0; i < blocks_.size(); ++i) {
                const size_t size = blocks_[i]->n_bytes;
                if (size >= n_bytes && size / 2 <= n_bytes && (best == blocks_.size() || size < blocks_[best]->n_bytes))
                    best = i;
            }
            if (best < blocks_.size()) {
                Header* block = blocks_[best];
                blocks_[best] = blocks_.back();
                blocks_.pop_back();
                n_kept_ -= block->n_bytes;
                return reinterpret_cast<char*>(block) + kLine;
            }
        }
        auto* block = static_cast<Header*>(::operator new(kLine + n_bytes, std::align_val_t{kLine}));
        block->n_bytes = n_bytes;
        return reinterpret_cast<char*>(block) + kLine;
    }

    void give(void* memory) noexcept {
        auto* block = reinterpret_cast<Header*>(static_cast<char*>(memory) - kLine);
        {
            const std::lock_guard<std::mutex> alone(mutex_);
            if (blocks_.size() < blocks_.capacity() && n_kept_ + block->n_bytes <= kMostBytes) {
                blocks_.push_back(block);
                n_kept_ += block->n_bytes;
                return;
            }
        }
        ::operator delete(block, std::align_val_t{kLine});
    }

  private:
    struct Header {
        std::size_t n_bytes;
    };
    // What a take of a minute needs; long ones pay for their pages.
    static constexpr std::size_t kMostBytes = std::size_t{16} << 20;

    MemoryPool() { blocks_.reserve(64); }
    ~MemoryPool() {
        for (Header* block : blocks_) ::operator delete(block, std::align_val_t{kLine});
    }

    std::mutex mutex_;
    std::vector<Header*> blocks_;
    std::size_t n_kept_ = 0;
};

template <typename T>
struct FromPool {
    using value_type = T;

    FromPool() = default;
    template <typename U>
    FromPool(const FromPool<U>&) {}

    T* allocate(std::size_t n) { return static_cast<T*>(MemoryPool::all().take(n * sizeof(T))); }
    void deallocate(T* memory, std::size_t) noexcept { MemoryPool::all().give(memory); }
    template <typename U>
    bool operator==(const FromPool<U>&) const {
        return true;
    }
};

template <typename T>
using Array = std::vector<T, FromPool<T>>;

// The same, of which the caller sets every number: as it is made it holds any.
template <typename T>
struct Unset : FromPool<T> {
    template <typename U>
    struct rebind {
        using other = Unset<U>;
    };

    Unset() = default;
    template <typename U>
    Unset(const Unset<U>&) {}

    template <typename U>
    void construct(U* place) {
        ::new (static_cast<void*>(place)) U;
    }
    template <typename U, typename... From>
    void construct(U* place, From&&... from) {
        ::new (static_cast<void*>(place)) U(static_cast<From&&>(from)...);
    }
};

template <typename T>
using Blank = std::vector<T, Unset<T>>;

}  // namespace retime
