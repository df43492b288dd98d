// Text to numbers, lines of decimal numbers, strictly; and numbers to text.
#pragma once

#include <cstddef>
#include <cstdint>

namespace retime {

using std::size_t;

// How rows are written. A number is [+-]digits[.digits][e[+-]digits], in ASCII; ".5" and "5." count too.
struct RowFormat {
    // What parts two fields of a row, with blanks around it or none; 0: one blank or more. Spaces and tabs are blanks,
    // but for a delimiter.
    char delimiter;
    // ',' beside '.' before the decimals.
    bool decimal_comma;
    // The largest number, of either sign, and the most bytes of a line.
    double largest;
    size_t line_bytes;
};

struct RowsRead {
    // Whole rows, from the front, and the numbers in each.
    size_t n_rows = 0, n_columns = 0;
    // Bytes up to the end of the last whole row's line; all of the text, unless something in it needs another reader.
    size_t n_bytes = 0;
};

// Reads lines of n_columns numbers each (0: as many as the first one has) up to the text's end, or to the first line
// that is anything else. Lines end in LF, CR or CRLF; blank ones don't count. Each number is the nearest double. It
// also stops where `out`, which has room for `capacity` numbers, is full; a text holds one in two bytes at most.
RowsRead read_rows(const char* text, size_t n_bytes, size_t n_columns, const RowFormat& format, double* out,
                   size_t capacity);

// The same on several threads, where the text is long and n_columns is said. `out` has room for half as many numbers as
// there are bytes, and one more for each thread; what it holds behind the whole rows is anything.
RowsRead read_rows(const char* text, size_t n_bytes, size_t n_columns, const RowFormat& format, int n_threads,
                   double* out);

// Bytes that a number takes at most, with what follows it.
constexpr size_t kWrittenBytes = 19;

// Writes rows of one number or more, each smaller than 1e9, with six decimals: the nearest by the rounding of |number|
// * 1e6, ties to even; zero without a sign. A space stands between two, a line feed after each row. `out` has room for
// kWrittenBytes a number; returns how many bytes were written.
size_t write_rows(const double* numbers, size_t n_rows, size_t n_columns, char* out);

}  // namespace retime
