#include "joint_rows.hpp"

#include <algorithm>
#include <cstring>
#include <mutex>

#include "memory_pool.hpp"
#include "threads.hpp"

namespace retime {

namespace {

// How many line feeds there are.
size_t count_line_feeds(const char* text, size_t n_bytes) {
    // Counters of one byte, which the compiler turns into vectors; they are full after 255.
    constexpr size_t kCounters = 64, kMost = 255;
    size_t count = 0, at = 0;
    while (at + kCounters <= n_bytes) {
        uint8_t counters[kCounters] = {};
        const size_t end = at + kCounters * std::min(kMost, (n_bytes - at) / kCounters);
        for (; at < end; at += kCounters)
            for (size_t i = 0; i < kCounters; ++i) counters[i] += text[at + i] == '\n';
        for (const uint8_t found : counters) count += found;
    }
    for (; at < n_bytes; ++at) count += text[at] == '\n';
    return count;
}

struct Piece {
    size_t begin, end, first_row, n_rows;
    bool is_read;
};

// Hands out the pieces of a text, from the front; any thread may ask.
class Pieces {
  public:
    Pieces(const char* text, size_t n_bytes, size_t piece_bytes, size_t line_bytes, size_t capacity)
        : text_(text), n_bytes_(n_bytes), piece_bytes_(piece_bytes), line_bytes_(line_bytes), capacity_(capacity) {}

    // The next one's number; false where there is none.
    bool next(size_t& which, Piece& piece) {
        const std::lock_guard<std::mutex> alone(mutex_);
        if (at_end_ || begin_ == n_bytes_) return false;
        at_end_ = true;
        size_t end = n_bytes_;
        if (n_bytes_ - begin_ > piece_bytes_) {
            const size_t from = begin_ + piece_bytes_, left = n_bytes_ - from;
            // No row goes on for longer: this is not to look through a whole file in which there is no line feed.
            const size_t most = left > line_bytes_ ? line_bytes_ + 1 : left;
            const auto* const feed = static_cast<const char*>(std::memchr(text_ + from, '\n', most));
            if (feed == nullptr && most < left) return false;
            if (feed != nullptr) end = static_cast<size_t>(feed + 1 - text_);
        }
        const size_t n_rows = count_line_feeds(text_ + begin_, end - begin_) + (text_[end - 1] != '\n');
        if (n_rows > capacity_ - n_rows_) return false;
        at_end_ = false;
        which = pieces_.size();
        piece = {begin_, end, n_rows_, n_rows, false};
        pieces_.push_back(piece);
        begin_ = end;
        n_rows_ += n_rows;
        return true;
    }

    void end(size_t which, bool is_read) {
        const std::lock_guard<std::mutex> alone(mutex_);
        pieces_[which].is_read = is_read;
        if (!is_read) at_end_ = true;
    }

    const std::vector<Piece>& all() const { return pieces_; }

  private:
    const char* const text_;
    const size_t n_bytes_, piece_bytes_, line_bytes_, capacity_;
    std::mutex mutex_;
    std::vector<Piece> pieces_;
    size_t begin_ = 0, n_rows_ = 0;
    bool at_end_ = false;
};

}  // namespace

RowsRead read_joint_rows(const char* text, size_t n_bytes, size_t piece_bytes, size_t n_columns,
                         const RowFormat& format, const JointChannels& channels, const JointArrays& out,
                         int n_threads) {
    const size_t n_joints = channels.n_joints;
    Pieces pieces(text, n_bytes, piece_bytes, format.line_bytes, out.capacity);
    const auto read = [&](const Piece& piece, Blank<double>& numbers) {
        const size_t bytes = piece.end - piece.begin, n_numbers = piece.n_rows * n_columns;
        // A number takes a digit and what parts it from the next.
        if (n_numbers > (bytes + 1) / 2) return false;
        if (numbers.size() < n_numbers) numbers = Blank<double>(n_numbers);
        const RowsRead found = read_rows(text + piece.begin, bytes, n_columns, format, numbers.data(), n_numbers);
        if (found.n_bytes != bytes || found.n_rows != piece.n_rows) return false;
        for (size_t row = 0; row < piece.n_rows; ++row) {
            const double* const from = numbers.data() + row * n_columns;
            double* const to = out.translations + 3 * n_joints * (piece.first_row + row);
            std::memcpy(to, channels.offsets, 3 * n_joints * sizeof(double));
            for (size_t i = 0; i < channels.n_places; ++i) to[channels.places[i]] = from[channels.columns[i]];
        }
        for (const TurnedJoints& turned : channels.turned)
            turn_joints(numbers.data(), piece.n_rows, n_columns, turned, n_joints, channels.many, 1,
                        out.angles + 3 * n_joints * piece.first_row, out.quaternions + 4 * n_joints * piece.first_row);
        return true;
    };
    const size_t n_parts = std::min<size_t>(n_threads < 1 ? 1 : n_threads, n_bytes / piece_bytes + 1);
    in_threads(0, n_parts, static_cast<int>(n_parts), [&](size_t, size_t) {
        Blank<double> numbers;
        Piece piece;
        for (size_t which; pieces.next(which, piece); look()) pieces.end(which, read(piece, numbers));
    });
    RowsRead all;
    all.n_columns = n_columns;
    for (const Piece& piece : pieces.all()) {
        if (!piece.is_read) break;
        all.n_rows = piece.first_row + piece.n_rows;
        all.n_bytes = piece.end;
    }
    return all;
}

}  // namespace retime
