// The two loops in which scoring spends its time, in single precision: matrix products, and the least of differences.
// Both only choose candidates, so products may be contracted here. Every loop is written once, for vectors of any
// width.
#pragma once

#include <algorithm>
#include <limits>

#include "exact_distances.hpp"

namespace retime {

// Columns are kept in panels of so many: panel p of a (depth, n) matrix holds its columns [64 p, 64 p + 64), row after
// row.
constexpr size_t kPanel = 64;
// Lanes that the least of a block is kept in, and blocks whose centres are looked at together.
constexpr size_t kLeast = 16;
constexpr float kFarFloat = std::numeric_limits<float>::infinity();

// A block of kPanel numbers where some of a group may be within their limits: bit g stands for the g-th of them.
struct Hit {
    uint32_t block;
    uint32_t group;
};

// kRows rows' products with one panel, as many columns at a time as registers hold sums.
template <typename Level, size_t kRows>
RETIME_INLINE void panel_products(const float* rows, size_t depth, const float* panel, float* out, size_t stride) {
    using Floats = typename Level::Floats;
    constexpr size_t kWidth = Level::kFloats, kColumns = Level::kColumns;
    for (size_t begin = 0; begin < kPanel; begin += kColumns * kWidth) {
        Floats sum[kRows][kColumns] = {};
        for (size_t d = 0; d < depth; ++d) {
            Floats column[kColumns];
            for (size_t part = 0; part < kColumns; ++part)
                column[part] = load<Floats>(panel + d * kPanel + begin + part * kWidth);
            for (size_t r = 0; r < kRows; ++r) {
                const float number = rows[r * depth + d];
                for (size_t part = 0; part < kColumns; ++part) Level::add_product(sum[r][part], number, column[part]);
            }
        }
        for (size_t r = 0; r < kRows; ++r)
            for (size_t part = 0; part < kColumns; ++part)
                store(sum[r][part], out + r * stride + begin + part * kWidth);
    }
}

// out[row, 64 p + lane] = sum over d of rows[row, d] * panels[p, d, lane].
template <typename Level>
RETIME_INLINE void multiply_panels(const float* rows, size_t n_rows, size_t depth, const float* panels, size_t n_panels,
                                   float* out, size_t stride) {
    for (size_t p = 0; p < n_panels; ++p) {
        const float* panel = panels + p * depth * kPanel;
        size_t row = 0;
        for (; row + 4 <= n_rows; row += 4)
            panel_products<Level, 4>(rows + row * depth, depth, panel, out + row * stride + p * kPanel, stride);
        for (; row < n_rows; ++row)
            panel_products<Level, 1>(rows + row * depth, depth, panel, out + row * stride + p * kPanel, stride);
    }
}

// Rows of products whose differences are scanned: (here - before) - after[g] for a group of g < n_group <= kGroup.
struct Rows {
    const float* here;
    const float* before;
    const float* after[kGroup];
    size_t n_group;

    float at(size_t g, size_t column) const { return (here[column] - before[column]) - after[g][column]; }

    template <typename Floats>
    RETIME_INLINE Floats without_after(size_t column) const {
        return load<Floats>(here + column) - load<Floats>(before + column);
    }
};

template <typename Level, size_t kTriples>
RETIME_INLINE size_t scan_group(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks,
                                Hit* hits) {
    using Floats = typename Level::Floats;
    constexpr size_t kWidth = Level::kFloats, kParts = kPanel / kWidth;
    size_t n_hits = 0;
    Floats limit[kTriples];
    for (size_t g = 0; g < kTriples; ++g) limit[g] = Floats{} + limits[g];
    for (size_t place = 0; place < n_blocks; ++place) {
        const size_t start = blocks[place] * kPanel;
        Floats row[kParts];
        for (size_t part = 0; part < kParts; ++part) row[part] = rows.without_after<Floats>(start + part * kWidth);
        uint32_t found = 0;
        for (size_t g = 0; g < kTriples; ++g) {
            const float* after = rows.after[g] + start;
            Floats least = Floats{} + kFarFloat;
            for (size_t part = 0; part < kParts; ++part)
                Level::lower(least, row[part] - load<Floats>(after + part * kWidth));
            found |= static_cast<uint32_t>(Level::at_most(least, limit[g]) != 0) << g;
        }
        if (found) hits[n_hits++] = {blocks[place], found};
    }
    return n_hits;
}

template <typename Level, size_t kTriples>
RETIME_INLINE void minima_of_group(const Rows& rows, size_t n_blocks, float* least, float* total) {
    using Floats = typename Level::Floats;
    constexpr size_t kWidth = Level::kFloats, kParts = kPanel / kLeast;
    for (size_t lane = 0; lane < kLeast; lane += kWidth) {
        Floats whole[kTriples];
        for (auto& some : whole) some = Floats{} + kFarFloat;
        for (size_t block = 0; block < n_blocks; ++block) {
            const size_t start = block * kPanel + lane;
            Floats row[kParts];
            for (size_t part = 0; part < kParts; ++part) row[part] = rows.without_after<Floats>(start + part * kLeast);
            for (size_t g = 0; g < kTriples; ++g) {
                Floats some = Floats{} + kFarFloat;
                for (size_t part = 0; part < kParts; ++part)
                    Level::lower(some, row[part] - load<Floats>(rows.after[g] + start + part * kLeast));
                store(some, least + (g * n_blocks + block) * kLeast + lane);
                Level::lower(whole[g], some);
            }
        }
        for (size_t g = 0; g < kTriples; ++g) store(whole[g], total + g * kLeast + lane);
    }
}

// A group's size is known to the compiler in the loops above, so that what belongs to it stays in registers.
#define RETIME_BY_GROUP(loop, ...)                   \
    switch (rows.n_group) {                          \
        case 1: return loop<Level, 1>(__VA_ARGS__);  \
        case 2: return loop<Level, 2>(__VA_ARGS__);  \
        case 3: return loop<Level, 3>(__VA_ARGS__);  \
        case 4: return loop<Level, 4>(__VA_ARGS__);  \
        case 5: return loop<Level, 5>(__VA_ARGS__);  \
        case 6: return loop<Level, 6>(__VA_ARGS__);  \
        case 7: return loop<Level, 7>(__VA_ARGS__);  \
        default: return loop<Level, 8>(__VA_ARGS__); \
    }
static_assert(kGroup == 8);

// Those of the blocks that hold a number at most limits[g]. What is not a number is never within. Returns how many were
// written to `hits`, which has room for n_blocks.
template <typename Level>
RETIME_INLINE size_t scan(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks, Hit* hits) {
    RETIME_BY_GROUP(scan_group, rows, limits, blocks, n_blocks, hits)
}

// least[(g * n_blocks + block) * 16 + lane] = the least of the differences l % 16 == lane of a block, for the blocks
// from the first on; what is not a number is left out. total[g * 16 + lane]: the least of these in all blocks.
template <typename Level>
RETIME_INLINE void minima(const Rows& rows, size_t n_blocks, float* least, float* total) {
    RETIME_BY_GROUP(minima_of_group, rows, n_blocks, least, total)
}
#undef RETIME_BY_GROUP

// The numbers of one block within a limit: bit l stands for the l-th.
template <typename Level>
RETIME_INLINE uint64_t within(const Rows& rows, size_t g, size_t start, float limit) {
    using Floats = typename Level::Floats;
    const Floats most = Floats{} + limit;
    uint64_t found = 0;
    for (size_t l = 0; l < kPanel; l += Level::kFloats) {
        const Floats value = rows.without_after<Floats>(start + l) - load<Floats>(rows.after[g] + start + l);
        found |= static_cast<uint64_t>(Level::at_most(value, most)) << l;
    }
    return found;
}

// For 16 blocks, the rows being those of their centres: bit l of masks[g] tells whether block l may hold a number
// within limits[g], that is whether value - radius * reach[g] <= limits[g].
template <typename Level>
RETIME_INLINE void near_blocks(const Rows& rows, const float* radii, const float* reach, const float* limits,
                               uint32_t* masks) {
    using Floats = typename Level::Floats;
    for (size_t g = 0; g < rows.n_group; ++g) masks[g] = 0;
    for (size_t l = 0; l < kLeast; l += Level::kFloats) {
        const Floats row = rows.without_after<Floats>(l), radius = load<Floats>(radii + l);
        for (size_t g = 0; g < rows.n_group; ++g) {
            const Floats value = row - load<Floats>(rows.after[g] + l);
            masks[g] |= Level::at_most(value - radius * reach[g], Floats{} + limits[g]) << l;
        }
    }
}

// For each of a group the count-th least of its 16 numbers `total`, each that of a lane; infinity where there are not
// so many. Numbers that are not of the group's may be any.
RETIME_INLINE void nth_least(const float* total, size_t count, float* out) {
#if defined(RETIME_SHUFFLE)
    constexpr size_t kWidth = 4;
#else
    constexpr size_t kWidth = 1;
#endif
    using Floats = Wide<float, kWidth>;
    for (size_t g = 0; g < kGroup; g += kWidth) {
        // The least so far of each triple, in order.
        Floats nearest[kLeast];
        for (auto& some : nearest) some = Floats{} + kFarFloat;
        const size_t n_kept = std::min(count, kLeast);
        const auto keep = [&](Floats more) RETIME_LAMBDA_INLINE {
            for (size_t m = 0; m + 1 < n_kept; ++m) {
                const Floats here = nearest[m];
                nearest[m] = choose(more < here, more, here);
                more = choose(more < here, here, more);
            }
            nearest[n_kept - 1] = choose(more < nearest[n_kept - 1], more, nearest[n_kept - 1]);
        };
        for (size_t l = 0; l < kLeast; l += kWidth) {
            Floats rows[kWidth];
            for (size_t m = 0; m < kWidth; ++m) rows[m] = load<Floats>(total + (g + m) * kLeast + l);
#if defined(RETIME_SHUFFLE)
            // Rows become columns: one number of each triple.
            const Floats a = RETIME_SHUFFLE(rows[0], rows[1], 0, 4, 1, 5);
            const Floats b = RETIME_SHUFFLE(rows[0], rows[1], 2, 6, 3, 7);
            const Floats c = RETIME_SHUFFLE(rows[2], rows[3], 0, 4, 1, 5);
            const Floats d = RETIME_SHUFFLE(rows[2], rows[3], 2, 6, 3, 7);
            rows[0] = RETIME_SHUFFLE(a, c, 0, 1, 4, 5), rows[1] = RETIME_SHUFFLE(a, c, 2, 3, 6, 7);
            rows[2] = RETIME_SHUFFLE(b, d, 0, 1, 4, 5), rows[3] = RETIME_SHUFFLE(b, d, 2, 3, 6, 7);
#endif
            for (const auto& row : rows) keep(row);
        }
        store(count > kLeast ? Floats{} + kFarFloat : nearest[n_kept - 1], out + g);
    }
}

// near[block]: the numbers of a block that are within the limit of some of a group; bit l stands for the l-th. Returns
// the blocks that have any. `least` is what `minima` found.
template <typename Level>
RETIME_INLINE uint32_t nearby(const Rows& rows, size_t n_blocks, const float* least, const float* limits,
                              uint64_t* near) {
    using Floats = typename Level::Floats;
    uint32_t blocks = 0;
    for (size_t block = 0; block < n_blocks; ++block) {
        uint64_t found = 0;
        for (size_t g = 0; g < rows.n_group; ++g) {
            const float* lanes = least + (g * n_blocks + block) * kLeast;
            Floats some = load<Floats>(lanes);
            for (size_t l = Level::kFloats; l < kLeast; l += Level::kFloats)
                Level::lower(some, load<Floats>(lanes + l));
            if (Level::at_most(some, Floats{} + limits[g])) found |= within<Level>(rows, g, block * kPanel, limits[g]);
        }
        near[block] = found;
        blocks |= static_cast<uint32_t>(found != 0) << block;
    }
    return blocks;
}

}  // namespace retime
