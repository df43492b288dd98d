// Local scores of triples (i, j, k) = (j - a, j, j + b).
//
// joint:  f = mean of the n_neighbors smallest |y^ - z^_l|,  y^ = [y_j, v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))].
//
// The squared distance separates into a term of j, one of k and one of i for each reference frame l, so a candidate costs two
// additions instead of 3 * n_numbers of them. Those terms are single precision and only choose candidates. Invariant: |approximate
// - exact| <= slack for every l, so a frame whose approximate value exceeds the n_neighbors-th smallest by more than 2 * slack
// can't be a neighbour. What is left is measured exactly, in a fixed order of summation that every backend shares: pose and movement
// apart, each in 32 running sums that are then halved to one. The pose part belongs to (j, l) alone and is kept for all triples of j.

#include "scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#if RETIME_X86
#include <immintrin.h>
#endif

namespace retime {
namespace {

constexpr size_t kLanes = 32;
constexpr size_t kBlock = kProductsPadding;
// Of terms that cancel to less than this share of their size, too few digits are left.
constexpr double kCancelled = 1e-3;
constexpr float kFar = std::numeric_limits<float>::infinity();

// Running sums are added by halves: 16, 8, 4, 2, 1.
RETIME_INLINE double added(const double* sum) {
    alignas(64) double t[8];
    for (size_t lane = 0; lane < 8; ++lane) t[lane] = (sum[lane] + sum[lane + 16]) + (sum[lane + 8] + sum[lane + 24]);
    return ((t[0] + t[4]) + (t[2] + t[6])) + ((t[1] + t[5]) + (t[3] + t[7]));
}

// Sum of squared differences; n is a multiple of kLanes. Lane l holds the terms l, l + 32, ...
RETIME_INLINE double squared_distance(const double* __restrict a, const double* __restrict b, size_t n) {
    alignas(64) double sum[kLanes] = {};
    for (size_t d = 0; d < n; d += kLanes)
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const double difference = a[d + lane] - b[d + lane];
            sum[lane] += difference * difference;
        }
    return added(sum);
}

// Sum of products, in the same order.
RETIME_INLINE double dot(const double* __restrict a, const double* __restrict b, size_t n) {
    alignas(64) double sum[kLanes] = {};
    for (size_t d = 0; d < n; d += kLanes)
        for (size_t lane = 0; lane < kLanes; ++lane) sum[lane] += a[d + lane] * b[d + lane];
    return added(sum);
}

inline size_t padded(size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

// Copy n numbers of each row into rows padded with zeros.
std::vector<double> pad_rows(const double* rows, size_t n_rows, size_t stride, size_t offset, size_t n) {
    const size_t wide = padded(n);
    std::vector<double> out(n_rows * wide, 0.0);
    for (size_t row = 0; row < n_rows; ++row) std::copy_n(rows + row * stride + offset, n, out.data() + row * wide);
    return out;
}

template <typename Work>
void in_threads(size_t begin, size_t end, int n_threads, Work work) {
    const size_t n = end - begin, parts = std::max<size_t>(1, std::min<size_t>(n_threads < 1 ? 1 : n_threads, n));
    std::vector<std::thread> pool;
    for (size_t part = 1; part < parts; ++part)
        pool.emplace_back([=] { work(begin + n * part / parts, begin + n * (part + 1) / parts); });
    work(begin, begin + n / parts);
    for (auto& thread : pool) thread.join();
}

// Rows whose approximate value may belong to the n smallest.
class Nearest {
  public:
    explicit Nearest(size_t n) : n_(n) { smallest_.reserve(n + 1); }

    // `guesses` are rows of a triple close by: their values here bound the n-th smallest from above before the scan begins.
    RETIME_INLINE void start(float slack, const std::vector<int32_t>& guesses, const float* row, const float* other) {
        slack2_ = 2 * slack;
        limit_ = kFar;
        rows_.clear();
        values_.clear();
        smallest_.clear();
        if (guesses.size() < n_) return;
        for (const int32_t l : guesses) rank(row[l] - other[l]);
        limit_ = loosened();
        smallest_.clear();
    }

    float limit() const { return limit_; }

    RETIME_INLINE void add(float value, int32_t row) {
        rows_.push_back(row);
        values_.push_back(value);
        rank(value);
        if (smallest_.size() == n_) limit_ = std::min(limit_, loosened());
    }

    // Forget rows that the limit has come down past.
    RETIME_INLINE const std::vector<int32_t>& rows() {
        size_t kept = 0;
        for (size_t i = 0; i < rows_.size(); ++i)
            if (values_[i] <= limit_) rows_[kept++] = rows_[i];
        rows_.resize(kept);
        return rows_;
    }

  private:
    RETIME_INLINE void rank(float value) {
        if (smallest_.size() == n_) {
            if (!(value < smallest_.back())) return;
            smallest_.pop_back();
        }
        size_t place = smallest_.size();
        smallest_.push_back(value);
        for (; place > 0 && smallest_[place - 1] > value; --place) smallest_[place] = smallest_[place - 1];
        smallest_[place] = value;
    }

    // A little more than the bound, so that single precision can't push a neighbour out.
    float loosened() const { return smallest_.back() + slack2_ + std::abs(smallest_.back()) * 2.4e-7f; }

    size_t n_;
    float slack2_ = 0, limit_ = 0;
    std::vector<int32_t> rows_;
    std::vector<float> values_, smallest_;
};

// Give the rows with row[l] - other[l] within the limit to `nearest`, which lowers it on the way. n is a multiple of kBlock; the padding
// of `row` is not a number, so it is never within.
void scan_plain(const float* __restrict row, const float* __restrict other, size_t n, Nearest& nearest) {
    for (size_t start = 0; start < n; start += kBlock) {
        const float limit = nearest.limit();
        int32_t hits = 0;
        for (size_t l = start; l < start + kBlock; ++l) hits += row[l] - other[l] <= limit;
        if (hits == 0) continue;
        for (size_t l = start; l < start + kBlock; ++l) {
            const float value = row[l] - other[l];
            if (value <= nearest.limit()) nearest.add(value, static_cast<int32_t>(l));
        }
    }
}

#if RETIME_X86
RETIME_INLINE void add_hits(uint64_t hits, size_t start, const float* row, const float* other, Nearest& nearest) {
    for (; hits; hits &= hits - 1) {
        const size_t l = start + static_cast<size_t>(__builtin_ctzll(hits));
        const float value = row[l] - other[l];
        if (value <= nearest.limit()) nearest.add(value, static_cast<int32_t>(l));
    }
}

RETIME_AVX2 void scan_avx2(const float* __restrict row, const float* __restrict other, size_t n, Nearest& nearest) {
    for (size_t start = 0; start < n; start += kBlock) {
        const __m256 limit = _mm256_set1_ps(nearest.limit());
        uint64_t hits = 0;
        for (size_t part = 0; part < kBlock; part += 8) {
            const __m256 value = _mm256_sub_ps(_mm256_loadu_ps(row + start + part), _mm256_loadu_ps(other + start + part));
            hits |= static_cast<uint64_t>(static_cast<uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(value, limit, _CMP_LE_OQ)))) << part;
        }
        add_hits(hits, start, row, other, nearest);
    }
}

RETIME_AVX512 void scan_avx512(const float* __restrict row, const float* __restrict other, size_t n, Nearest& nearest) {
    for (size_t start = 0; start < n; start += kBlock) {
        const __m512 limit = _mm512_set1_ps(nearest.limit());
        uint64_t hits = 0;
        for (size_t part = 0; part < kBlock; part += 16) {
            const __m512 value = _mm512_sub_ps(_mm512_loadu_ps(row + start + part), _mm512_loadu_ps(other + start + part));
            hits |= static_cast<uint64_t>(_mm512_cmp_ps_mask(value, limit, _CMP_LE_OQ)) << part;
        }
        add_hits(hits, start, row, other, nearest);
    }
}
#endif

// The movement of a triple, [v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))]; the order of operations is the NumPy backend's.
RETIME_INLINE void movement(const JointProblem& p, size_t i, size_t j, size_t k, double* __restrict out) {
    const size_t n = p.n_numbers;
    const double* __restrict yi = p.input + i * n;
    const double* __restrict yj = p.input + j * n;
    const double* __restrict yk = p.input + k * n;
    const double velocity = p.velocity, acceleration = p.acceleration;
    for (size_t d = 0; d < n; ++d) out[d] = (yk[d] - yi[d]) * velocity;
    for (size_t d = 0; d < n; ++d) out[n + d] = ((yk[d] - yj[d]) - (yj[d] - yi[d])) * acceleration;
}

// Put the n smallest first, in order, and average them.
RETIME_INLINE double mean_of_smallest(std::vector<double>& distances, size_t n) {
    double sum = 0.0;
    for (size_t m = 0; m < n; ++m) {
        size_t least = m;
        for (size_t i = m + 1; i < distances.size(); ++i) least = distances[i] < distances[least] ? i : least;
        std::swap(distances[m], distances[least]);
        sum += distances[m];
    }
    return sum / static_cast<double>(n);
}

template <typename Scan>
RETIME_INLINE void joint_rows_body(const JointProblem& p, const Products& products, const double* poses, const double* moves, size_t begin, size_t end,
                            bool each, double* out, Scan scan) {
    const size_t s = p.max_skip, r = p.n_reference, n = p.n_numbers, wide = padded(n), wide_move = padded(2 * n);
    const size_t r_wide = products.stride / 3;
    std::vector<float> row(r_wide, std::numeric_limits<float>::quiet_NaN());
    std::vector<double> here(wide, 0.0), move(wide_move, 0.0), pose_part(r), distances;
    // Neighbours of the triple before this one; of the first triple of the row before; of the first triple of the frame before.
    std::vector<int32_t> guesses, row_guesses, frame_guesses;
    Nearest nearest(p.n_neighbors);
    for (size_t j = begin; j < end; ++j) {
        const size_t jj = j - products.first;
        std::copy_n(p.input + j * n, n, here.data());
        std::fill(pose_part.begin(), pose_part.end(), -1.0);
        // One frame on, the reference has likely gone on too.
        row_guesses.clear();
        for (const int32_t l : frame_guesses)
            if (l + 1 < static_cast<int32_t>(r)) row_guesses.push_back(l + 1);
        for (size_t a = 1; a <= s && a <= j; ++a) {
            const size_t ii = jj - a;
            const float* __restrict first = products.here + jj * products.stride;
            const float* __restrict before = products.before + ii * products.stride;
            for (size_t l = 0; l < r; ++l) row[l] = first[l] - before[l];
            guesses = row_guesses;
            for (size_t b = 1; b <= s && j + b < p.n_input; ++b) {
                const size_t kk = jj + b;
                const float* after = products.after + kk * products.stride;
                const double slack = products.reference_slack + products.slack[3 * jj] + products.slack[3 * kk + 1] + products.slack[3 * ii + 2];
                nearest.start(static_cast<float>(slack * 1.000001), guesses, row.data(), after);
                scan(row.data(), after, r_wide, nearest);
                movement(p, j - a, j, j + b, move.data());
                guesses = nearest.rows();
                distances.resize(guesses.size());
                for (size_t i = 0; i < guesses.size(); ++i) {
                    const size_t l = static_cast<size_t>(guesses[i]);
                    if (pose_part[l] < 0) pose_part[l] = squared_distance(here.data(), poses + l * wide, wide);
                    distances[i] = std::sqrt(pose_part[l] + squared_distance(move.data(), moves + l * wide_move, wide_move));
                }
                const double mean = mean_of_smallest(distances, p.n_neighbors);
                const size_t triple = (j * s + a - 1) * s + b - 1;
                if (each)
                    std::copy_n(distances.begin(), p.n_neighbors, out + triple * p.n_neighbors);
                else
                    out[triple] = mean;
                if (b == 1) row_guesses = guesses;
            }
            if (a == 1) frame_guesses = row_guesses;
        }
    }
}

template <typename Scan>
RETIME_INLINE void nearest_poses_body(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers, size_t n_neighbors,
                                      const float* products, size_t stride, const double* slack, int64_t* out, Scan scan) {
    const size_t wide = padded(n_numbers);
    std::vector<double> here(wide, 0.0);
    std::vector<float> row(stride, std::numeric_limits<float>::quiet_NaN());
    const std::vector<float> nothing(stride, 0.0f);
    std::vector<std::pair<double, int64_t>> found;
    std::vector<int32_t> guesses;
    Nearest nearest(n_neighbors);
    for (size_t j = 0; j < n_input; ++j) {
        std::copy_n(input + j * n_numbers, n_numbers, here.data());
        std::copy_n(products + j * stride, n_reference, row.data());
        nearest.start(static_cast<float>(slack[j] * 1.000001), guesses, row.data(), nothing.data());
        scan(row.data(), nothing.data(), stride, nearest);
        guesses = nearest.rows();
        found.clear();
        for (const int32_t l : guesses) found.emplace_back(squared_distance(here.data(), poses + static_cast<size_t>(l) * wide, wide), l);
        std::sort(found.begin(), found.end());
        for (size_t m = 0; m < n_neighbors; ++m) out[j * n_neighbors + m] = found[m].second;
    }
}

void nearest_poses_plain(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers, size_t n_neighbors,
                         const float* products, size_t stride, const double* slack, int64_t* out) {
    nearest_poses_body(input, poses, n_input, n_reference, n_numbers, n_neighbors, products, stride, slack, out, scan_plain);
}

#if RETIME_X86
RETIME_AVX2 void nearest_poses_avx2(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers, size_t n_neighbors,
                                    const float* products, size_t stride, const double* slack, int64_t* out) {
    nearest_poses_body(input, poses, n_input, n_reference, n_numbers, n_neighbors, products, stride, slack, out, scan_avx2);
}

RETIME_AVX512 void nearest_poses_avx512(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers,
                                        size_t n_neighbors, const float* products, size_t stride, const double* slack, int64_t* out) {
    nearest_poses_body(input, poses, n_input, n_reference, n_numbers, n_neighbors, products, stride, slack, out, scan_avx512);
}
#endif

// What the conditional score needs of the reference, in padded rows.
struct Moves {
    const double* both;          // [dz, ddz], padded together
    const double* velocity;      // dz
    const double* acceleration;  // ddz
};

// With e = y_k - y_j, f = y_j - y_i the movement is [v (e + f), w (e - f)], so its distance to a reference frame needs only the inner
// products of e, f, dz and ddz: those of one frame's steps, not of its triples. Where they all but cancel, what is left is measured.
RETIME_INLINE void conditional_rows_body(const JointProblem& p, const Moves& moves, const int64_t* nearest, size_t begin, size_t end, double* out) {
    const size_t n = p.n_numbers, s = p.max_skip, count = p.n_neighbors, wide = padded(n), wide_both = padded(2 * n);
    const double v = p.velocity, w = p.acceleration, vv = v * v, ww = w * w;
    std::vector<double> after(s * wide, 0.0), before(s * wide, 0.0), both(wide_both, 0.0), distances(count);
    std::vector<double> ee(s), ff(s), e_dz(s * count), e_ddz(s * count), f_dz(s * count), f_ddz(s * count), zz(count);
    for (size_t j = begin; j < end; ++j) {
        const size_t n_after = std::min(s, p.n_input - 1 - j), n_before = std::min(s, j);
        const double* here = p.input + j * n;
        for (size_t b = 0; b < n_after; ++b) {
            double* e = after.data() + b * wide;
            for (size_t d = 0; d < n; ++d) e[d] = here[(b + 1) * n + d] - here[d];
            ee[b] = dot(e, e, wide);
        }
        for (size_t a = 0; a < n_before; ++a) {
            double* f = before.data() + a * wide;
            const double* there = here - (a + 1) * n;
            for (size_t d = 0; d < n; ++d) f[d] = here[d] - there[d];
            ff[a] = dot(f, f, wide);
        }
        for (size_t m = 0; m < count; ++m) {
            const size_t l = static_cast<size_t>(nearest[j * count + m]);
            const double *dz = moves.velocity + l * wide, *ddz = moves.acceleration + l * wide;
            zz[m] = dot(dz, dz, wide) + dot(ddz, ddz, wide);
            for (size_t b = 0; b < n_after; ++b) {
                e_dz[b * count + m] = dot(after.data() + b * wide, dz, wide);
                e_ddz[b * count + m] = dot(after.data() + b * wide, ddz, wide);
            }
            for (size_t a = 0; a < n_before; ++a) {
                f_dz[a * count + m] = dot(before.data() + a * wide, dz, wide);
                f_ddz[a * count + m] = dot(before.data() + a * wide, ddz, wide);
            }
        }
        for (size_t a = 0; a < n_before; ++a)
            for (size_t b = 0; b < n_after; ++b) {
                const double ef = dot(after.data() + b * wide, before.data() + a * wide, wide), sum = ee[b] + ff[a];
                const double moved = vv * (sum + 2 * ef) + ww * (sum - 2 * ef), size = (vv + ww) * (2 * sum);
                bool measured = false;
                for (size_t m = 0; m < count; ++m) {
                    const double along = v * (e_dz[b * count + m] + f_dz[a * count + m]) + w * (e_ddz[b * count + m] - f_ddz[a * count + m]);
                    double square = (moved - 2 * along) + zz[m];
                    if (!(square > kCancelled * (size + zz[m]))) {
                        if (!measured) movement(p, j - a - 1, j, j + b + 1, both.data());
                        measured = true;
                        square = squared_distance(both.data(), moves.both + static_cast<size_t>(nearest[j * count + m]) * wide_both, wide_both);
                    }
                    distances[m] = std::sqrt(square);
                }
                out[(j * s + a) * s + b] = mean_of_smallest(distances, count);
            }
    }
}

void joint_rows_plain(const JointProblem& p, const Products& products, const double* poses, const double* moves, size_t begin, size_t end, bool each,
                      double* out) {
    joint_rows_body(p, products, poses, moves, begin, end, each, out, scan_plain);
}

#if RETIME_X86
RETIME_AVX2 void joint_rows_avx2(const JointProblem& p, const Products& products, const double* poses, const double* moves, size_t begin, size_t end,
                                 bool each, double* out) {
    joint_rows_body(p, products, poses, moves, begin, end, each, out, scan_avx2);
}

RETIME_AVX512 void joint_rows_avx512(const JointProblem& p, const Products& products, const double* poses, const double* moves, size_t begin, size_t end,
                                     bool each, double* out) {
    joint_rows_body(p, products, poses, moves, begin, end, each, out, scan_avx512);
}
#endif

RETIME_VERSIONS(void, conditional_rows,
                (const JointProblem& p, const Moves& moves, const int64_t* nearest, size_t begin, size_t end, double* out),
                (p, moves, nearest, begin, end, out))

}  // namespace

void joint_scores(const JointProblem& p, const Products& products, size_t begin, size_t end, int n_threads, bool each, double* out) {
    const auto poses = pad_rows(p.reference, p.n_reference, 3 * p.n_numbers, 0, p.n_numbers);
    const auto moves = pad_rows(p.reference, p.n_reference, 3 * p.n_numbers, p.n_numbers, 2 * p.n_numbers);
    in_threads(begin, end, n_threads, [&](size_t from, size_t to) { RETIME_CALL(joint_rows, p, products, poses.data(), moves.data(), from, to, each, out); });
}

void nearest_poses(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers, size_t n_neighbors,
                   const float* products, size_t stride, const double* slack, int64_t* out) {
    const auto rows = pad_rows(poses, n_reference, n_numbers, 0, n_numbers);
    RETIME_CALL(nearest_poses, input, rows.data(), n_input, n_reference, n_numbers, n_neighbors, products, stride, slack, out);
}

void conditional_scores(const JointProblem& p, const int64_t* nearest, int n_threads, double* out) {
    const size_t n = p.n_numbers;
    const auto both = pad_rows(p.reference, p.n_reference, 3 * n, n, 2 * n);
    const auto velocity = pad_rows(p.reference, p.n_reference, 3 * n, n, n);
    const auto acceleration = pad_rows(p.reference, p.n_reference, 3 * n, 2 * n, n);
    const Moves moves{both.data(), velocity.data(), acceleration.data()};
    in_threads(0, p.n_input, n_threads, [&](size_t from, size_t to) { RETIME_CALL(conditional_rows, p, moves, nearest, from, to, out); });
}

}  // namespace retime
