#include "number_rows.hpp"

#include <cmath>
#include <cstring>

#include <vector>

#include "number_text.hpp"
#include "threads.hpp"

namespace retime {

namespace {

// Fewer bytes are not worth a thread.
constexpr size_t kThreadBytes = size_t{1} << 17;

inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

struct Cursor {
    const char* at;
    const char* end;

    bool at_line_end() const { return at == end || is_line_end(*at); }

    void skip_line_end() {
        if (at == end) return;
        if (*at == '\r' && at + 1 < end && at[1] == '\n') ++at;
        ++at;
    }
};

}  // namespace

RowsRead read_rows(const char* text, size_t n_bytes, size_t n_columns, const RowFormat& format, double* out,
                   size_t capacity) {
    RowsRead read;
    read.n_columns = n_columns;
    const char delimiter = format.delimiter;
    Cursor cursor{text, text + n_bytes};
    const auto skip_blanks = [&] {
        while (cursor.at < cursor.end && (*cursor.at == ' ' || *cursor.at == '\t') && *cursor.at != delimiter)
            ++cursor.at;
    };
    while (cursor.at < cursor.end) {
        const char* const line = cursor.at;
        size_t n_numbers = 0;
        skip_blanks();
        while (!cursor.at_line_end()) {
            if (n_numbers == capacity || (read.n_columns && n_numbers == read.n_columns)) return read;
            double& number = out[n_numbers];
            if (!read_short_number(cursor.at, cursor.end, delimiter, format.largest, number) &&
                !read_number(cursor.at, cursor.end, format.decimal_comma, format.largest, number))
                return read;
            ++n_numbers;
            const char* const after = cursor.at;
            skip_blanks();
            if (cursor.at_line_end()) break;
            if (delimiter) {
                if (*cursor.at != delimiter) return read;
                ++cursor.at;
                skip_blanks();
                // A delimiter at the line's end has an empty field behind it.
                if (cursor.at_line_end()) return read;
            } else if (cursor.at == after) {
                return read;
            }
        }
        if (static_cast<size_t>(cursor.at - line) > format.line_bytes) return read;
        if (n_numbers) {
            if (read.n_columns && n_numbers != read.n_columns) return read;
            read.n_columns = n_numbers;
            ++read.n_rows;
            out += n_numbers;
            capacity -= n_numbers;
        }
        cursor.skip_line_end();
        read.n_bytes = static_cast<size_t>(cursor.at - text);
    }
    return read;
}

RowsRead read_rows(const char* text, size_t n_bytes, size_t n_columns, const RowFormat& format, int n_threads,
                   double* out) {
    // Parts begin behind a line feed: no line end is cut in two.
    std::vector<size_t> starts{0};
    const size_t n_parts = n_columns ? std::min<size_t>(n_threads < 1 ? 1 : n_threads, n_bytes / kThreadBytes) : 1;
    for (size_t part = 1; part < n_parts; ++part) {
        const size_t from = std::max(n_bytes * part / n_parts, starts.back());
        const auto* const feed = static_cast<const char*>(std::memchr(text + from, '\n', n_bytes - from));
        if (feed == nullptr) break;
        starts.push_back(static_cast<size_t>(feed + 1 - text));
    }
    starts.push_back(n_bytes);
    const auto place = [&](size_t part) { return starts[part] / 2 + part; };
    std::vector<RowsRead> read(starts.size() - 1);
    in_threads(0, read.size(), n_threads, [&](size_t from, size_t to) {
        for (size_t part = from; part < to; ++part) {
            const size_t bytes = starts[part + 1] - starts[part];
            read[part] = read_rows(text + starts[part], bytes, n_columns, format, out + place(part), (bytes + 1) / 2);
        }
    });
    RowsRead all = read[0];
    for (size_t part = 1; part < read.size() && all.n_bytes == starts[part]; ++part) {
        const size_t n_numbers = read[part].n_rows * n_columns;
        std::memmove(out + all.n_rows * n_columns, out + place(part), n_numbers * sizeof(double));
        all.n_rows += read[part].n_rows;
        all.n_bytes += read[part].n_bytes;
    }
    return all;
}

namespace {

// "00" to "99".
struct Pairs {
    char of[200];

    constexpr Pairs() : of{} {
        for (int n = 0; n < 100; ++n) {
            of[2 * n] = static_cast<char>('0' + n / 10);
            of[2 * n + 1] = static_cast<char>('0' + n % 10);
        }
    }
};
constexpr Pairs kPairs;

inline void put_pair(uint32_t n, char* at) { std::memcpy(at, kPairs.of + 2 * n, 2); }

// All digits of a whole number, up to ten of them, without zeros in front; returns where they end.
inline char* put_whole(uint32_t n, char* at) {
    char digits[10];
    char* first = digits + 10;
    while (n >= 100) put_pair(n % 100, first -= 2), n /= 100;
    put_pair(n, first -= 2);
    first += n < 10;
    const size_t count = static_cast<size_t>(digits + 10 - first);
    std::memcpy(at, first, count);
    return at + count;
}

}  // namespace

size_t write_rows(const double* numbers, size_t n_rows, size_t n_columns, char* out) {
    // A double of 2^52 has no decimals: adding it rounds a smaller number to a whole one, ties to even.
    constexpr double kWhole = 4503599627370496.0;
    char* at = out;
    for (size_t row = 0; row < n_rows; ++row) {
        for (size_t column = 0; column < n_columns; ++column) {
            const double number = *numbers++;
            const auto millionths = static_cast<uint64_t>((std::abs(number) * 1e6 + kWhole) - kWhole);
            const auto whole = static_cast<uint32_t>(millionths / 1'000'000);
            const auto decimals = static_cast<uint32_t>(millionths - uint64_t{whole} * 1'000'000);
            *at = '-';
            at += number < 0 && millionths > 0;
            at = put_whole(whole, at);
            *at = '.';
            put_pair(decimals / 10'000, at + 1);
            put_pair(decimals / 100 % 100, at + 3);
            put_pair(decimals % 100, at + 5);
            at[7] = ' ';
            at += 8;
        }
        at[-1] = '\n';
    }
    return static_cast<size_t>(at - out);
}

}  // namespace retime
