// What chooses a triple's candidates among reference frames: products in single precision, and a bound on their
// rounding.
#pragma once

#include <cmath>

#include "exact_distances.hpp"
#include "rough_distances.hpp"
#include "threads.hpp"
#include "watch.hpp"

namespace retime {

// Blocks of the reference that a tile's products hold at once, and bytes of them that stay in a second cache.
constexpr size_t kChunk = 16;
constexpr size_t kTileBytes = size_t{1} << 19;

// How many frames of n a tile takes, where its products have so many columns: fewer where a frame has many triples.
inline size_t tile_frames(size_t n, const Steps& steps, size_t n_columns) {
    const size_t reach = 2 * static_cast<size_t>(steps.longest);
    const size_t n_rows = kTileBytes / (n_columns * sizeof(float));
    const size_t most = std::clamp<size_t>(n_rows > reach ? (n_rows - reach) / 3 : 0, 32, 64);
    return std::min(n, std::max<size_t>(1, std::min(most, (size_t{1} << 17) / steps.n_pairs)));
}

// A unit of rounding for sums of `depth` products of rounded numbers, whatever their order, and a few additions more.
inline double rounding(size_t depth) { return static_cast<double>(depth + 12) * 0x1p-24 * 1.01; }

// Rows about an origin, times `scale`: in single precision, with a 1 behind them to meet a column's last number, which
// stands alone; and their lengths.
struct Low {
    Blank<float> rows;
    Array<double> lengths;

    Low(const double* from, size_t n_rows, size_t depth, double scale, const double* origin = nullptr)
        : rows(n_rows * (depth + 1)), lengths(n_rows) {
        const Array<double> nothing(origin ? 0 : depth, 0.0);
        const double* middle = origin ? origin : nothing.data();
        for (size_t row = 0; row < n_rows; ++row) {
            double sum[8] = {};
            in_lanes<8>(depth, [&](size_t d, size_t lane) RETIME_LAMBDA_INLINE {
                const double number = (from[row * depth + d] - middle[d]) * scale;
                rows[row * (depth + 1) + d] = static_cast<float>(number);
                sum[lane] += number * number;
            });
            rows[row * (depth + 1) + depth] = 1.0f;
            lengths[row] = std::sqrt(eight_halved(sum));
        }
    }
};

// Columns that turn frames into terms of half |y^ - z^|^2 - half |y^|^2 = here(j) - before(i) - after(k), for rows z^ =
// [z, dz, ddz] times `scale`.
struct Columns {
    size_t n_panels = 0;
    Blank<float> here, before, after;
    // The longest of each, and the largest half |z^|^2.
    double longest_here = 0, longest_before = 0, longest_after = 0, largest = 0;

    // `less`, one number a row, is taken off. Columns beyond the rows are not numbers.
    Columns(const double* rows, size_t n_rows, size_t depth, double v, double w, double scale,
            const double* less = nullptr)
        : n_panels((n_rows + kPanel - 1) / kPanel) {
        const size_t n = depth + 1;
        for (auto* part : {&here, &before, &after}) part->resize(n_panels * n * kPanel);
        // Sixteen rows at a time: their numbers of one place stand beside each other.
        Array<float> some(16 * 3 * depth);
        for (size_t first = 0; first < n_panels * kPanel; first += 16) {
            const size_t at = first / kPanel * n * kPanel + first % kPanel,
                         n_some = first < n_rows ? std::min<size_t>(16, n_rows - first) : 0;
            double h[16] = {}, b[16] = {}, a[16] = {}, squares[16] = {};
            if (n_some < 16) std::fill(some.begin(), some.end(), 0.0f);
            for (size_t l = 0; l < n_some; ++l) {
                const double* row = rows + (first + l) * 3 * depth;
                float* to = some.data() + l * 3 * depth;
                double sums[4][8] = {};
                in_lanes<8>(depth, [&](size_t d, size_t lane) RETIME_LAMBDA_INLINE {
                    const double z = row[d] * scale, dz = row[depth + d] * scale, ddz = row[2 * depth + d] * scale;
                    const double of_here = z - 2 * w * ddz, of_after = v * dz + w * ddz, of_before = w * ddz - v * dz;
                    to[d] = static_cast<float>(-of_here), to[depth + d] = static_cast<float>(of_before),
                    to[2 * depth + d] = static_cast<float>(of_after);
                    sums[0][lane] += of_here * of_here, sums[1][lane] += of_before * of_before,
                        sums[2][lane] += of_after * of_after;
                    sums[3][lane] += z * z + dz * dz + ddz * ddz;
                });
                h[l] = eight_halved(sums[0]), b[l] = eight_halved(sums[1]), a[l] = eight_halved(sums[2]),
                squares[l] = eight_halved(sums[3]);
            }
            for (size_t d = 0; d < depth; ++d)
                for (size_t l = 0; l < 16; ++l) {
                    const float* from = some.data() + l * 3 * depth + d;
                    here[at + d * kPanel + l] = from[0], before[at + d * kPanel + l] = from[depth],
                                           after[at + d * kPanel + l] = from[2 * depth];
                }
            for (size_t l = 0; l < 16; ++l) {
                float& alone = here[at + depth * kPanel + l];
                before[at + depth * kPanel + l] = after[at + depth * kPanel + l] = 0.0f;
                if (l >= n_some) {
                    alone = std::numeric_limits<float>::quiet_NaN();
                    continue;
                }
                const double off = less ? less[first + l] : 0.0;
                alone = static_cast<float>(0.5 * squares[l] - off);
                longest_here = std::max(longest_here, std::sqrt(h[l]));
                longest_before = std::max(longest_before, std::sqrt(b[l]));
                longest_after = std::max(longest_after, std::sqrt(a[l]));
                largest = std::max(largest, 0.5 * squares[l] + off);
            }
        }
    }
};

// Products of neighbouring frames, a row each, in a ring: those that the next tile needs too stay where they are.
struct FrameProducts {
    size_t stride, n_rows;
    Blank<float> numbers;
    // The frames that it holds, and where the first of them stands.
    size_t begin = 0, end = 0, place = 0;

    FrameProducts(size_t most_frames, size_t n_columns)
        : stride(n_columns), n_rows(most_frames), numbers(most_frames * n_columns) {}

    size_t row(size_t frame) const {
        const size_t row = frame - begin + place;
        return row < n_rows ? row : row - n_rows;
    }
    const float* of(size_t frame) const { return numbers.data() + row(frame) * stride; }

    // Holds frames from..to next; make(first, last, out) computes some of them. With `keep`, those that are there stay.
    template <typename Make>
    RETIME_INLINE void hold(size_t from, size_t to, bool keep, Make make) {
        if (keep && begin <= from && from <= end) {
            place = row(from), begin = from;
        } else {
            begin = end = from, place = 0;
        }
        while (end < to) {
            const size_t at = row(end), some = std::min(to - end, n_rows - at);
            make(end, end + some, numbers.data() + at * stride);
            end += some;
        }
    }
};

// Products of a tile's frames, and of the frames that its triples begin and end with, with panels of columns.
struct TileProducts {
    FrameProducts here, before, after;

    TileProducts(size_t n_tile, const Steps& steps, size_t n_columns)
        : here(n_tile, n_columns),
          before(n_tile + static_cast<size_t>(steps.longest), n_columns),
          after(n_tile + static_cast<size_t>(steps.longest), n_columns) {}

    // Products of frames [from, to) with `n_some` panels from `panel` on, put at `column`. With `keep`, what the tile
    // before needed of the same panels is not made again.
    template <typename Level>
    RETIME_INLINE void multiply(const Low& low, const Columns& columns, const ScoreProblem& p, size_t depth,
                                size_t from, size_t to, size_t panel, size_t n_some, size_t column, bool keep) {
        const size_t longest = static_cast<size_t>(p.steps.longest), at = panel * depth * kPanel;
        const size_t last = std::min(to + longest, p.n_input);
        const auto part = [&](const Blank<float>& panels, size_t begin, size_t end, FrameProducts& out)
                              RETIME_LAMBDA_INLINE {
                                  const auto make = [&](size_t first, size_t behind, float* rows) RETIME_LAMBDA_INLINE {
                                      multiply_panels<Level>(low.rows.data() + first * depth, behind - first, depth,
                                                             panels.data() + at, n_some, rows + column, out.stride);
                                  };
                                  out.hold(begin, end, keep, make);
                              };
        part(columns.here, from, to, here);
        part(columns.before, from - std::min(from, longest), to, before);
        part(columns.after, std::min(from + 1, last), last, after);
    }

    // Those of triples that begin with step a and go on with n_group steps from b on, from a column on.
    RETIME_INLINE Rows rows(const Steps& steps, size_t j, size_t a, size_t b, size_t n_group, size_t column) const {
        Rows rows{here.of(j) + column, before.of(j - static_cast<size_t>(steps.length[a])) + column, {}, n_group};
        for (size_t g = 0; g < n_group; ++g)
            rows.after[g] = after.of(j + static_cast<size_t>(steps.length[b + g])) + column;
        return rows;
    }
};

}  // namespace retime
