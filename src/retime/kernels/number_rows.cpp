#include "number_rows.hpp"

#include "number_text.hpp"

namespace retime {

namespace {

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
            if (!read_number(cursor.at, cursor.end, format.decimal_comma, format.largest, number)) return read;
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

}  // namespace retime
