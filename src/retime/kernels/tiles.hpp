// The two loops in which scoring spends its time, in single precision: matrix products, and the least of differences. Both only choose
// candidates, so products may be contracted here.
#pragma once

#include <algorithm>
#include <limits>

#include "measure.hpp"

#if RETIME_X86
#include <immintrin.h>
#endif

namespace retime {

// Columns are kept in panels of so many: panel p of a (depth, n) matrix holds its columns [64 p, 64 p + 64), row after row.
constexpr size_t kPanel = 64;

// A block of kPanel numbers where some of a group may be within their limits: bit g stands for the g-th of them.
struct Hit {
    uint32_t block;
    uint32_t group;
};

// out[row, 64 p + lane] = sum over d of rows[row, d] * panels[p, d, lane].
inline void products_plain(const float* rows, size_t n_rows, size_t depth, const float* panels, size_t n_panels, float* out, size_t stride) {
    for (size_t p = 0; p < n_panels; ++p)
        for (size_t row = 0; row < n_rows; ++row) {
            float sum[kPanel] = {};
            const float* panel = panels + p * depth * kPanel;
            for (size_t d = 0; d < depth; ++d)
                for (size_t lane = 0; lane < kPanel; ++lane) sum[lane] += rows[row * depth + d] * panel[d * kPanel + lane];
            for (size_t lane = 0; lane < kPanel; ++lane) out[row * stride + p * kPanel + lane] = sum[lane];
        }
}

// Rows of products whose differences are scanned: (here - before) - after[g] for a group of g < n_group <= kGroup.
struct Rows {
    const float* here;
    const float* before;
    const float* after[kGroup];
    size_t n_group;

    float at(size_t g, size_t column) const { return (here[column] - before[column]) - after[g][column]; }
};

// Which of kGroup numbers are not above others: bit g stands for the g-th.
inline uint32_t not_above_plain(const double* numbers, const double* others) {
    uint32_t found = 0;
    for (size_t g = 0; g < kGroup; ++g) found |= static_cast<uint32_t>(!(numbers[g] > others[g])) << g;
    return found;
}

// Those of the blocks that hold a number at most limits[g]. What is not a number is never within. Returns how many were written to
// `hits`, which has room for n_blocks.
inline size_t scan_plain(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks, Hit* hits) {
    size_t n_hits = 0;
    for (size_t place = 0; place < n_blocks; ++place) {
        const size_t start = blocks[place] * kPanel;
        uint32_t found = 0;
        float row[kPanel];
        for (size_t l = 0; l < kPanel; ++l) row[l] = rows.here[start + l] - rows.before[start + l];
        for (size_t g = 0; g < rows.n_group; ++g) {
            const float *after = rows.after[g] + start, limit = limits[g];
            int32_t n_within = 0;
            for (size_t l = 0; l < kPanel; ++l) n_within += row[l] - after[l] <= limit;
            found |= static_cast<uint32_t>(n_within > 0) << g;
        }
        if (found) hits[n_hits++] = {blocks[place], found};
    }
    return n_hits;
}

// The numbers of one block within a limit: bit l stands for the l-th.
inline uint64_t within_plain(const float* here, const float* before, const float* after, float limit) {
    uint64_t found = 0;
    for (size_t l = 0; l < kPanel; ++l) found |= static_cast<uint64_t>((here[l] - before[l]) - after[l] <= limit) << l;
    return found;
}

// For 16 blocks, the rows being those of their centres: bit l of masks[g] tells whether block l may hold a number within limits[g], that is
// whether value - radius * reach[g] <= limits[g].
inline void near_plain(const Rows& rows, const float* radii, const float* reach, const float* limits, uint32_t* masks) {
    for (size_t g = 0; g < rows.n_group; ++g) {
        masks[g] = 0;
        for (size_t l = 0; l < 16; ++l) {
            const float value = (rows.here[l] - rows.before[l]) - rows.after[g][l];
            masks[g] |= static_cast<uint32_t>(value - radii[l] * reach[g] <= limits[g]) << l;
        }
    }
}

// least[(g * n_blocks + block) * 16 + lane] = the least of the differences l % 16 == lane of a block, for the blocks from the first on; what
// is not a number is left out. total[g * 16 + lane]: the least of these in all blocks.
inline void minima_plain(const Rows& rows, size_t n_blocks, float* least, float* total) {
    std::fill_n(total, rows.n_group * 16, std::numeric_limits<float>::infinity());
    for (size_t g = 0; g < rows.n_group; ++g)
        for (size_t block = 0; block < n_blocks; ++block) {
            float* to = least + (g * n_blocks + block) * 16;
            std::fill_n(to, 16, std::numeric_limits<float>::infinity());
            for (size_t start = block * kPanel; start < (block + 1) * kPanel; start += 16)
                for (size_t l = 0; l < 16; ++l) {
                    const float value = rows.at(g, start + l);
                    to[l] = value < to[l] ? value : to[l];
                }
            for (size_t l = 0; l < 16; ++l) total[g * 16 + l] = std::min(total[g * 16 + l], to[l]);
        }
}

// For each of a group the count-th least of its 16 numbers `total`, each that of a lane; infinity where there are not so many. Numbers that
// are not of the group's may be any.
RETIME_INLINE void nth_least(const float* total, size_t count, float* out) {
#if defined(RETIME_SHUFFLE)
    typedef float Floats __attribute__((vector_size(16)));
    constexpr size_t kWidth = 4;
#else
    typedef float Floats;
    constexpr size_t kWidth = 1;
#endif
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (size_t g = 0; g < kGroup; g += kWidth) {
        // The least so far of each triple, in order.
        Floats nearest[16];
        for (auto& some : nearest) some = Floats{} + kInfinity;
        const size_t n_kept = std::min<size_t>(count, 16);
        const auto keep = [&](Floats more) RETIME_LAMBDA_INLINE {
            for (size_t m = 0; m + 1 < n_kept; ++m) {
                const Floats here = nearest[m];
                nearest[m] = more < here ? more : here;
                more = more < here ? here : more;
            }
            nearest[n_kept - 1] = more < nearest[n_kept - 1] ? more : nearest[n_kept - 1];
        };
        for (size_t l = 0; l < 16; l += kWidth) {
            Floats rows[kWidth];
            for (size_t m = 0; m < kWidth; ++m) std::memcpy(&rows[m], total + (g + m) * 16 + l, sizeof rows[m]);
#if defined(RETIME_SHUFFLE)
            // Rows become columns: one number of each triple.
            const Floats a = RETIME_SHUFFLE(rows[0], rows[1], 0, 4, 1, 5), b = RETIME_SHUFFLE(rows[0], rows[1], 2, 6, 3, 7);
            const Floats c = RETIME_SHUFFLE(rows[2], rows[3], 0, 4, 1, 5), d = RETIME_SHUFFLE(rows[2], rows[3], 2, 6, 3, 7);
            rows[0] = RETIME_SHUFFLE(a, c, 0, 1, 4, 5), rows[1] = RETIME_SHUFFLE(a, c, 2, 3, 6, 7);
            rows[2] = RETIME_SHUFFLE(b, d, 0, 1, 4, 5), rows[3] = RETIME_SHUFFLE(b, d, 2, 3, 6, 7);
#endif
            for (const auto& row : rows) keep(row);
        }
        const Floats nth = count > 16 ? Floats{} + kInfinity : nearest[n_kept - 1];
        std::memcpy(out + g, &nth, sizeof nth);
    }
}

// near[block]: the numbers of a block that are within the limit of some of a group; bit l stands for the l-th. Returns the blocks that have
// any. `least` is what `minima` found.
inline uint32_t nearby_plain(const Rows& rows, size_t n_blocks, const float* least, const float* limits, uint64_t* near) {
    uint32_t blocks = 0;
    for (size_t block = 0; block < n_blocks; ++block) {
        uint64_t found = 0;
        for (size_t g = 0; g < rows.n_group; ++g) {
            const float *lanes = least + (g * n_blocks + block) * 16, limit = limits[g];
            int32_t n_within = 0;
            for (size_t l = 0; l < 16; ++l) n_within += lanes[l] <= limit;
            if (n_within == 0) continue;
            for (size_t l = 0; l < kPanel; ++l) found |= static_cast<uint64_t>(rows.at(g, block * kPanel + l) <= limit) << l;
        }
        near[block] = found;
        blocks |= static_cast<uint32_t>(found != 0) << block;
    }
    return blocks;
}

#if RETIME_X86
namespace x86 {

template <size_t kGroups>
RETIME_AVX512 inline void minima_avx512(const Rows& rows, size_t n_blocks, float* least, float* total) {
    __m512 all[kGroups];
    for (size_t g = 0; g < kGroups; ++g) all[g] = _mm512_set1_ps(__builtin_inff());
    for (size_t block = 0; block < n_blocks; ++block) {
        const size_t start = block * kPanel;
        __m512 here[4];
        for (size_t part = 0; part < 4; ++part) {
            const size_t at = start + 16 * part;
            here[part] = _mm512_sub_ps(_mm512_loadu_ps(rows.here + at), _mm512_loadu_ps(rows.before + at));
        }
        for (size_t g = 0; g < kGroups; ++g) {
            const float* after = rows.after[g] + start;
            // The minimum is its second operand where the first is not a number.
            __m512 lanes = _mm512_set1_ps(__builtin_inff());
            for (size_t part = 0; part < 4; ++part) lanes = _mm512_min_ps(_mm512_sub_ps(here[part], _mm512_loadu_ps(after + 16 * part)), lanes);
            _mm512_storeu_ps(least + (g * n_blocks + block) * 16, lanes);
            all[g] = _mm512_min_ps(lanes, all[g]);
        }
    }
    for (size_t g = 0; g < kGroups; ++g) _mm512_storeu_ps(total + g * 16, all[g]);
}

template <size_t kGroups>
RETIME_AVX2 inline void minima_avx2(const Rows& rows, size_t n_blocks, float* least, float* total) {
    for (size_t half = 0; half < 16; half += 8) {
        __m256 all[kGroups];
        for (size_t g = 0; g < kGroups; ++g) all[g] = _mm256_set1_ps(__builtin_inff());
        for (size_t block = 0; block < n_blocks; ++block) {
            const size_t start = block * kPanel + half;
            __m256 here[4];
            for (size_t part = 0; part < 4; ++part) {
                const size_t at = start + 16 * part;
                here[part] = _mm256_sub_ps(_mm256_loadu_ps(rows.here + at), _mm256_loadu_ps(rows.before + at));
            }
            for (size_t g = 0; g < kGroups; ++g) {
                const float* after = rows.after[g] + start;
                __m256 lanes = _mm256_set1_ps(__builtin_inff());
                for (size_t part = 0; part < 4; ++part) lanes = _mm256_min_ps(_mm256_sub_ps(here[part], _mm256_loadu_ps(after + 16 * part)), lanes);
                _mm256_storeu_ps(least + (g * n_blocks + block) * 16 + half, lanes);
                all[g] = _mm256_min_ps(lanes, all[g]);
            }
        }
        for (size_t g = 0; g < kGroups; ++g) _mm256_storeu_ps(total + g * 16 + half, all[g]);
    }
}

template <size_t kRows>
RETIME_AVX512 inline void panel_avx512(const float* rows, size_t depth, const float* panel, float* out, size_t stride) {
    __m512 sum[kRows][4];
    for (size_t r = 0; r < kRows; ++r)
        for (size_t part = 0; part < 4; ++part) sum[r][part] = _mm512_setzero_ps();
    for (size_t d = 0; d < depth; ++d) {
        __m512 column[4];
        for (size_t part = 0; part < 4; ++part) column[part] = _mm512_loadu_ps(panel + d * kPanel + 16 * part);
        for (size_t r = 0; r < kRows; ++r) {
            const __m512 number = _mm512_set1_ps(rows[r * depth + d]);
            for (size_t part = 0; part < 4; ++part) sum[r][part] = _mm512_fmadd_ps(number, column[part], sum[r][part]);
        }
    }
    for (size_t r = 0; r < kRows; ++r)
        for (size_t part = 0; part < 4; ++part) _mm512_storeu_ps(out + r * stride + 16 * part, sum[r][part]);
}

// The same with a quarter of a panel at a time: AVX2 has half as many registers.
template <size_t kRows>
RETIME_AVX2 inline void panel_avx2(const float* rows, size_t depth, const float* panel, float* out, size_t stride) {
    for (size_t quarter = 0; quarter < kPanel; quarter += 16) {
        __m256 sum[kRows][2];
        for (size_t r = 0; r < kRows; ++r)
            for (size_t part = 0; part < 2; ++part) sum[r][part] = _mm256_setzero_ps();
        for (size_t d = 0; d < depth; ++d) {
            const __m256 low = _mm256_loadu_ps(panel + d * kPanel + quarter), high = _mm256_loadu_ps(panel + d * kPanel + quarter + 8);
            for (size_t r = 0; r < kRows; ++r) {
                const __m256 number = _mm256_set1_ps(rows[r * depth + d]);
                sum[r][0] = _mm256_add_ps(sum[r][0], _mm256_mul_ps(number, low));
                sum[r][1] = _mm256_add_ps(sum[r][1], _mm256_mul_ps(number, high));
            }
        }
        for (size_t r = 0; r < kRows; ++r)
            for (size_t part = 0; part < 2; ++part) _mm256_storeu_ps(out + r * stride + quarter + 8 * part, sum[r][part]);
    }
}

template <size_t kGroups>
RETIME_AVX512 inline size_t scan_avx512(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks, Hit* hits) {
    size_t n_hits = 0;
    __m512 limit[kGroups];
    for (size_t g = 0; g < kGroups; ++g) limit[g] = _mm512_set1_ps(limits[g]);
    for (size_t place = 0; place < n_blocks; ++place) {
        const size_t start = blocks[place] * kPanel;
        __m512 here[4];
        for (size_t part = 0; part < 4; ++part) {
            const size_t at = start + 16 * part;
            here[part] = _mm512_sub_ps(_mm512_loadu_ps(rows.here + at), _mm512_loadu_ps(rows.before + at));
        }
        uint32_t found = 0;
        for (size_t g = 0; g < kGroups; ++g) {
            const float* after = rows.after[g] + start;
            // The minimum is its second operand where the first is not a number.
            __m512 least = _mm512_set1_ps(__builtin_inff());
            for (size_t part = 0; part < 4; ++part) least = _mm512_min_ps(_mm512_sub_ps(here[part], _mm512_loadu_ps(after + 16 * part)), least);
            found |= static_cast<uint32_t>(_mm512_cmp_ps_mask(least, limit[g], _CMP_LE_OQ) != 0) << g;
        }
        if (found) hits[n_hits++] = {blocks[place], found};
    }
    return n_hits;
}

template <size_t kGroups>
RETIME_AVX2 inline size_t scan_avx2(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks, Hit* hits) {
    size_t n_hits = 0;
    for (size_t place = 0; place < n_blocks; ++place) {
        const size_t start = blocks[place] * kPanel;
        uint32_t found = 0;
        __m256 here[8];
        for (size_t part = 0; part < 8; ++part) {
            const size_t at = start + 8 * part;
            here[part] = _mm256_sub_ps(_mm256_loadu_ps(rows.here + at), _mm256_loadu_ps(rows.before + at));
        }
        for (size_t g = 0; g < kGroups; ++g) {
            const float* after = rows.after[g] + start;
            __m256 least = _mm256_set1_ps(__builtin_inff());
            for (size_t part = 0; part < 8; ++part) least = _mm256_min_ps(_mm256_sub_ps(here[part], _mm256_loadu_ps(after + 8 * part)), least);
            const __m256 within = _mm256_cmp_ps(least, _mm256_set1_ps(limits[g]), _CMP_LE_OQ);
            found |= static_cast<uint32_t>(_mm256_movemask_ps(within) != 0) << g;
        }
        if (found) hits[n_hits++] = {blocks[place], found};
    }
    return n_hits;
}

}  // namespace x86

RETIME_AVX512 inline uint32_t nearby_avx512(const Rows& rows, size_t n_blocks, const float* least, const float* limits, uint64_t* near) {
    uint32_t blocks = 0;
    for (size_t block = 0; block < n_blocks; ++block) {
        const size_t start = block * kPanel;
        uint64_t found = 0;
        for (size_t g = 0; g < rows.n_group; ++g) {
            const __m512 limit = _mm512_set1_ps(limits[g]);
            if (!_mm512_cmp_ps_mask(_mm512_loadu_ps(least + (g * n_blocks + block) * 16), limit, _CMP_LE_OQ)) continue;
            for (size_t l = 0; l < kPanel; l += 16) {
                const __m512 row = _mm512_sub_ps(_mm512_loadu_ps(rows.here + start + l), _mm512_loadu_ps(rows.before + start + l));
                const __m512 value = _mm512_sub_ps(row, _mm512_loadu_ps(rows.after[g] + start + l));
                found |= static_cast<uint64_t>(_mm512_cmp_ps_mask(value, limit, _CMP_LE_OQ)) << l;
            }
        }
        near[block] = found;
        blocks |= static_cast<uint32_t>(found != 0) << block;
    }
    return blocks;
}

RETIME_AVX2 inline uint32_t nearby_avx2(const Rows& rows, size_t n_blocks, const float* least, const float* limits, uint64_t* near) {
    uint32_t blocks = 0;
    for (size_t block = 0; block < n_blocks; ++block) {
        const size_t start = block * kPanel;
        uint64_t found = 0;
        for (size_t g = 0; g < rows.n_group; ++g) {
            const __m256 limit = _mm256_set1_ps(limits[g]);
            const float* lanes = least + (g * n_blocks + block) * 16;
            if (!_mm256_movemask_ps(_mm256_cmp_ps(_mm256_min_ps(_mm256_loadu_ps(lanes), _mm256_loadu_ps(lanes + 8)), limit, _CMP_LE_OQ))) continue;
            for (size_t l = 0; l < kPanel; l += 8) {
                const __m256 row = _mm256_sub_ps(_mm256_loadu_ps(rows.here + start + l), _mm256_loadu_ps(rows.before + start + l));
                const __m256 within = _mm256_cmp_ps(_mm256_sub_ps(row, _mm256_loadu_ps(rows.after[g] + start + l)), limit, _CMP_LE_OQ);
                found |= static_cast<uint64_t>(static_cast<uint32_t>(_mm256_movemask_ps(within))) << l;
            }
        }
        near[block] = found;
        blocks |= static_cast<uint32_t>(found != 0) << block;
    }
    return blocks;
}

RETIME_AVX512 inline uint32_t not_above_avx512(const double* numbers, const double* others) {
    return _mm512_cmp_pd_mask(_mm512_loadu_pd(numbers), _mm512_loadu_pd(others), _CMP_NGT_UQ);
}

RETIME_AVX2 inline uint32_t not_above_avx2(const double* numbers, const double* others) {
    const int low = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(numbers), _mm256_loadu_pd(others), _CMP_NGT_UQ));
    const int high = _mm256_movemask_pd(_mm256_cmp_pd(_mm256_loadu_pd(numbers + 4), _mm256_loadu_pd(others + 4), _CMP_NGT_UQ));
    return static_cast<uint32_t>(low | high << 4);
}

RETIME_AVX512 inline uint64_t within_avx512(const float* here, const float* before, const float* after, float limit) {
    uint64_t found = 0;
    for (size_t l = 0; l < kPanel; l += 16) {
        const __m512 row = _mm512_sub_ps(_mm512_loadu_ps(here + l), _mm512_loadu_ps(before + l));
        const __m512 value = _mm512_sub_ps(row, _mm512_loadu_ps(after + l));
        found |= static_cast<uint64_t>(_mm512_cmp_ps_mask(value, _mm512_set1_ps(limit), _CMP_LE_OQ)) << l;
    }
    return found;
}

RETIME_AVX2 inline uint64_t within_avx2(const float* here, const float* before, const float* after, float limit) {
    uint64_t found = 0;
    for (size_t l = 0; l < kPanel; l += 8) {
        const __m256 row = _mm256_sub_ps(_mm256_loadu_ps(here + l), _mm256_loadu_ps(before + l));
        const __m256 within = _mm256_cmp_ps(_mm256_sub_ps(row, _mm256_loadu_ps(after + l)), _mm256_set1_ps(limit), _CMP_LE_OQ);
        found |= static_cast<uint64_t>(static_cast<uint32_t>(_mm256_movemask_ps(within))) << l;
    }
    return found;
}

RETIME_AVX512 inline void near_avx512(const Rows& rows, const float* radii, const float* reach, const float* limits, uint32_t* masks) {
    const __m512 row = _mm512_sub_ps(_mm512_loadu_ps(rows.here), _mm512_loadu_ps(rows.before)), radius = _mm512_loadu_ps(radii);
    for (size_t g = 0; g < rows.n_group; ++g) {
        const __m512 value = _mm512_sub_ps(row, _mm512_loadu_ps(rows.after[g]));
        const __m512 least = _mm512_sub_ps(value, _mm512_mul_ps(radius, _mm512_set1_ps(reach[g])));
        masks[g] = _mm512_cmp_ps_mask(least, _mm512_set1_ps(limits[g]), _CMP_LE_OQ);
    }
}

RETIME_AVX2 inline void near_avx2(const Rows& rows, const float* radii, const float* reach, const float* limits, uint32_t* masks) {
    for (size_t g = 0; g < rows.n_group; ++g) masks[g] = 0;
    for (size_t l = 0; l < 16; l += 8) {
        const __m256 row = _mm256_sub_ps(_mm256_loadu_ps(rows.here + l), _mm256_loadu_ps(rows.before + l)), radius = _mm256_loadu_ps(radii + l);
        for (size_t g = 0; g < rows.n_group; ++g) {
            const __m256 value = _mm256_sub_ps(row, _mm256_loadu_ps(rows.after[g] + l));
            const __m256 least = _mm256_sub_ps(value, _mm256_mul_ps(radius, _mm256_set1_ps(reach[g])));
            const __m256 within = _mm256_cmp_ps(least, _mm256_set1_ps(limits[g]), _CMP_LE_OQ);
            masks[g] |= static_cast<uint32_t>(_mm256_movemask_ps(within)) << l;
        }
    }
}

#define RETIME_TILE_KERNELS(level, TARGET)                                                                                                             \
    TARGET inline void products_##level(const float* rows, size_t n_rows, size_t depth, const float* panels, size_t n_panels, float* out,              \
                                        size_t stride) {                                                                                               \
        for (size_t p = 0; p < n_panels; ++p) {                                                                                                        \
            const float* panel = panels + p * depth * kPanel;                                                                                          \
            size_t row = 0;                                                                                                                            \
            for (; row + 4 <= n_rows; row += 4) x86::panel_##level<4>(rows + row * depth, depth, panel, out + row * stride + p * kPanel, stride);      \
            for (; row < n_rows; ++row) x86::panel_##level<1>(rows + row * depth, depth, panel, out + row * stride + p * kPanel, stride);              \
        }                                                                                                                                              \
    }                                                                                                                                                  \
    TARGET inline void minima_##level(const Rows& rows, size_t n_blocks, float* least, float* total) {                                                 \
        switch (rows.n_group) {                                                                                                                        \
            case 1: return x86::minima_##level<1>(rows, n_blocks, least, total);                                                                       \
            case 2: return x86::minima_##level<2>(rows, n_blocks, least, total);                                                                       \
            case 3: return x86::minima_##level<3>(rows, n_blocks, least, total);                                                                       \
            case 4: return x86::minima_##level<4>(rows, n_blocks, least, total);                                                                       \
            case 5: return x86::minima_##level<5>(rows, n_blocks, least, total);                                                                       \
            case 6: return x86::minima_##level<6>(rows, n_blocks, least, total);                                                                       \
            case 7: return x86::minima_##level<7>(rows, n_blocks, least, total);                                                                       \
            default: return x86::minima_##level<8>(rows, n_blocks, least, total);                                                                       \
        }                                                                                                                                              \
    }                                                                                                                                                  \
    TARGET inline size_t scan_##level(const Rows& rows, const float* limits, const uint32_t* blocks, size_t n_blocks, Hit* hits) {                     \
        switch (rows.n_group) {                                                                                                                        \
            case 1: return x86::scan_##level<1>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 2: return x86::scan_##level<2>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 3: return x86::scan_##level<3>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 4: return x86::scan_##level<4>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 5: return x86::scan_##level<5>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 6: return x86::scan_##level<6>(rows, limits, blocks, n_blocks, hits);                                                                 \
            case 7: return x86::scan_##level<7>(rows, limits, blocks, n_blocks, hits);                                                                 \
            default: return x86::scan_##level<8>(rows, limits, blocks, n_blocks, hits);                                                                \
        }                                                                                                                                              \
    }
RETIME_TILE_KERNELS(avx2, RETIME_AVX2)
RETIME_TILE_KERNELS(avx512, RETIME_AVX512)
#undef RETIME_TILE_KERNELS
#endif

// What one kind of machine has: vectors of double precision, rows whose running sums its registers hold, and the loops.
#define RETIME_LEVEL(Name, level, Vectors, rows, wide)                                    \
    struct Name {                                                                        \
        using Pack = Vectors;                                                            \
        static constexpr size_t kRows = rows;                                            \
        static constexpr bool kWide = wide;                                              \
        static constexpr auto products = products_##level;                               \
        static constexpr auto minima = minima_##level;                                   \
        static constexpr auto not_above = not_above_##level;                             \
        static constexpr auto nearby = nearby_##level;                                   \
        static constexpr auto scan = scan_##level;                                       \
        static constexpr auto within = within_##level;                                   \
        static constexpr auto near = near_##level;                                       \
    };
RETIME_LEVEL(Plain, plain, Two, 1, false)
#if RETIME_X86
RETIME_LEVEL(Avx2, avx2, Four, 2, true)
RETIME_LEVEL(Avx512, avx512, Eight, 4, true)
#endif
#undef RETIME_LEVEL

}  // namespace retime
