// Distances as every backend measures them: in double precision, in one fixed order. Term t of a sum is added to
// running sum t % 16; the 16 are halved to one: 8 + 8, 4 + 4, 2 + 2, 1 + 1. Each part of a vector (pose, velocity,
// acceleration) begins at running sum 0, so rows are padded with zeros, which change no sum.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "memory_pool.hpp"
#include "scores.hpp"
#include "watch.hpp"

namespace retime {

constexpr size_t kLanes = 16;
// Rows that are measured at once.
constexpr size_t kBatch = 4;
// Of terms that cancel to less than this share of their size, too few digits are left.
constexpr double kCancelled = 1e-3;
constexpr double kFar = std::numeric_limits<double>::infinity();

inline size_t padded(size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

// Copy n numbers of each row, from `offset` on, into rows padded with zeros.
inline Blank<double> pad_rows(const double* rows, size_t n_rows, size_t stride, size_t offset, size_t n) {
    const size_t wide = padded(n);
    Blank<double> out(n_rows * wide);
    for (size_t row = 0; row < n_rows; ++row) {
        std::copy_n(rows + row * stride + offset, n, out.data() + row * wide);
        std::fill_n(out.data() + row * wide + n, wide - n, 0.0);
    }
    return out;
}

// Runs add(d, lane) for the numbers of a row, running sums beside each other.
template <size_t kSums, typename Add>
RETIME_INLINE void in_lanes(size_t n, Add add) {
    const size_t whole = n / kSums * kSums;
    for (size_t d = 0; d < whole; d += kSums)
        for (size_t lane = 0; lane < kSums; ++lane) add(d + lane, lane);
    for (size_t d = whole; d < n; ++d) add(d, d - whole);
}

RETIME_INLINE double eight_halved(const double* sum) {
    return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

RETIME_INLINE double halved(const double* lanes) {
    double half[kLanes / 2];
    for (size_t l = 0; l < kLanes / 2; ++l) half[l] = lanes[l] + lanes[l + kLanes / 2];
    return eight_halved(half);
}

// Running sums of a batch.
typedef double Lanes[kBatch][kLanes];

// Halves them to one number a row.
template <typename Level>
RETIME_INLINE void halve(const Lanes& lanes, double* out) {
#if defined(RETIME_SHUFFLE)
    if constexpr (Level::kDoubles >= 4) {
        Wide<double, 4> four[kBatch];
        for (size_t row = 0; row < kBatch; ++row) {
            Wide<double, 4> part[4];
            std::memcpy(part, lanes[row], sizeof part);
            four[row] = (part[0] + part[2]) + (part[1] + part[3]);
        }
        // Two rows beside each other, then all four.
        const Wide<double, 4> a =
            RETIME_SHUFFLE(four[0], four[1], 0, 1, 4, 5) + RETIME_SHUFFLE(four[0], four[1], 2, 3, 6, 7);
        const Wide<double, 4> b =
            RETIME_SHUFFLE(four[2], four[3], 0, 1, 4, 5) + RETIME_SHUFFLE(four[2], four[3], 2, 3, 6, 7);
        const Wide<double, 4> all = RETIME_SHUFFLE(a, b, 0, 2, 4, 6) + RETIME_SHUFFLE(a, b, 1, 3, 5, 7);
        std::memcpy(out, &all, sizeof all);
        return;
    }
#endif
    for (size_t row = 0; row < kBatch; ++row) out[row] = halved(lanes[row]);
}

// Squared distance of two rows; `wide` is a multiple of kLanes.
template <typename Level>
RETIME_INLINE double squared_distance(const double* a, const double* b, size_t wide) {
    using Doubles = typename Level::Doubles;
    constexpr size_t kWidth = Level::kDoubles, kParts = kLanes / kWidth;
    Doubles sum[kParts] = {};
    for (size_t d = 0; d < wide; d += kLanes)
        for (size_t part = 0; part < kParts; ++part) {
            const Doubles difference = load<Doubles>(a + d + part * kWidth) - load<Doubles>(b + d + part * kWidth);
            sum[part] += difference * difference;
        }
    double lanes[kLanes];
    std::memcpy(lanes, sum, sizeof lanes);
    return halved(lanes);
}

// Inner products of a row with each of n rows, or with `apart` its squared distances to them; row_of says where the
// m-th stands.
template <typename Level, bool apart, typename RowOf>
RETIME_INLINE void dots(const double* x, RowOf row_of, size_t n, size_t wide, double* out) {
    using Doubles = typename Level::Doubles;
    constexpr size_t kWidth = Level::kDoubles, kParts = kLanes / kWidth;
    for (size_t begin = 0; begin < n; begin += kBatch) {
        const double* row[kBatch];
        for (size_t m = 0; m < kBatch; ++m) row[m] = row_of(std::min(begin + m, n - 1));
        alignas(64) Lanes lanes;
        for (size_t first = 0; first < kBatch; first += Level::kRows) {
            Doubles sum[Level::kRows][kParts] = {};
            for (size_t d = 0; d < wide; d += kLanes)
                for (size_t part = 0; part < kParts; ++part) {
                    const Doubles here = load<Doubles>(x + d + part * kWidth);
                    for (size_t m = 0; m < Level::kRows; ++m) {
                        const Doubles there = load<Doubles>(row[first + m] + d + part * kWidth);
                        if constexpr (apart) {
                            const Doubles difference = here - there;
                            sum[m][part] += difference * difference;
                        } else {
                            sum[m][part] += here * there;
                        }
                    }
                }
            std::memcpy(lanes[first], sum, sizeof sum);
        }
        double some[kBatch];
        halve<Level>(lanes, some);
        for (size_t m = 0; m < kBatch && begin + m < n; ++m) out[begin + m] = some[m];
    }
}

// Which of kGroup numbers are not above others: bit g stands for the g-th.
template <typename Level>
RETIME_INLINE uint32_t not_above(const double* numbers, const double* others) {
    using Doubles = typename Level::Doubles;
    uint32_t found = 0;
    for (size_t g = 0; g < kGroup; g += Level::kDoubles)
        found |= Level::above(load<Doubles>(numbers + g), load<Doubles>(others + g)) << g;
    return ~found & ((1u << kGroup) - 1);
}

// Puts kGroup numbers among the `count` least of each of kGroup queries, the smallest first; those of one rank are
// kGroup apart. With `ids` each brings `id` along.
template <typename Level>
RETIME_INLINE void keep_least(const double* numbers, size_t count, double* nearest, int64_t id = 0,
                              int64_t* ids = nullptr) {
    using Doubles = typename Level::Doubles;
    using Integers = Wide<int64_t, Level::kDoubles>;
    for (size_t g = 0; g < kGroup; g += Level::kDoubles) {
        Doubles more = load<Doubles>(numbers + g);
        Integers more_id = Integers{} + id;
        for (size_t m = 0; m < count; ++m) {
            const size_t at = m * kGroup + g;
            const Doubles here = load<Doubles>(nearest + at);
            const auto nearer = more < here;
            if (ids) {
                const Integers here_id = load<Integers>(ids + at);
                store(choose(nearer, more_id, here_id), ids + at);
                more_id = choose(nearer, here_id, more_id);
            }
            store(choose(nearer, more, here), nearest + at);
            more = choose(nearer, here, more);
        }
    }
}

// The mean of the roots of what keep_least kept of n queries, the smallest first, or with `each` the roots.
RETIME_INLINE void write_least(const double* nearest, size_t count, size_t n, bool each, double* out) {
    double sum[kGroup] = {};
    for (size_t m = 0; m < count; ++m) {
        double distance[kGroup];
        for (size_t g = 0; g < kGroup; ++g) distance[g] = std::sqrt(nearest[m * kGroup + g]), sum[g] += distance[g];
        if (each)
            for (size_t g = 0; g < n; ++g) out[g * count + m] = distance[g];
    }
    if (!each)
        for (size_t g = 0; g < n; ++g) out[g] = sum[g] / static_cast<double>(count);
}

// Rows as distances need them, all padded.
struct PaddedRows {
    const ScoreProblem& p;
    size_t wide;
    // Poses y and z; v dz + w ddz and v dz - w ddz; |dz|^2 + |ddz|^2.
    Blank<double> input, poses, plus, minus, squares;

    // How many frames on the squared lengths reach that triples need, the fewest first; the places there of the steps,
    // and of two steps together.
    std::vector<size_t> reaches;
    std::vector<int64_t> reach_of_step, reach_of_pair;

    const int64_t* order;

    // With `order`, row l is that row of the reference.
    explicit PaddedRows(const ScoreProblem& problem, const int64_t* order = nullptr);

    const double* reference(size_t row) const {
        return p.reference + (order ? static_cast<size_t>(order[row]) : row) * 3 * p.n_numbers;
    }
};

// Squared distances of triples to reference rows. With e = y_k - y_j, f = y_j - y_i a triple's movement is [v (e + f),
// w (e - f)], so that
//
//   |[dy, ddy] - [dz, ddz]|^2 = (vv |e + f|^2 + ww |e - f|^2 - 2 (e.(v dz + w ddz) + f.(v dz - w ddz)))
//                               + |dz|^2 + |ddz|^2
//
// needs inner products of single steps only, those of a row with the steps of one frame for all of its triples; e + f
// is a step too, and |e - f|^2 = 2 (|e|^2 + |f|^2) - |e + f|^2. Where the terms all but cancel, the movement is
// measured as it is.
template <typename Level>
class TripleDistances {
  public:
    // For triples with their middle in frames begin to end. Without poses, distances are those of movements.
    RETIME_INLINE TripleDistances(const PaddedRows& measured, size_t begin, size_t end, bool with_poses)
        : q_(measured),
          steps_(q_.p.steps),
          with_poses_(with_poses),
          n_(steps_.n),
          wide_(q_.wide),
          begin_(begin - std::min(begin, static_cast<size_t>(steps_.longest))),
          lengths_((end - begin_) * q_.reaches.size()),
          out_(n_ * wide_),
          in_(n_ * wide_),
          scratch_(2 * wide_),
          nothing_(2 * wide_),
          stamp_(q_.p.n_reference, 0),
          slot_(q_.p.n_reference) {
        const size_t n_reaches = q_.reaches.size();
        size_t within = n_reaches;
        for (size_t i = begin_; i < end; ++i) {
            look();
            const double* here = q_.input.data() + i * wide_;
            while (within > 0 && q_.reaches[within - 1] > q_.p.n_input - 1 - i) --within;
            const auto ahead = [&](size_t m) RETIME_LAMBDA_INLINE { return here + q_.reaches[m] * wide_; };
            dots<Level, true>(here, ahead, within, wide_, lengths_.data() + (i - begin_) * n_reaches);
        }
    }

    // Triples of frames first to last are next.
    RETIME_INLINE void begin_tile(size_t first, size_t last) {
        first_ = first;
        moved_.resize((last - first) * steps_.n_pairs + kGroup);
        size_.resize(moved_.size());
        if (steps_.every)
            measure_steps(last, [](int64_t a) { return a; }, [](int64_t a, int64_t b) { return a + b + 1; });
        else
            measure_steps(
                last, [&](int64_t a) { return q_.reach_of_step[a]; },
                [&](int64_t a, int64_t b) { return q_.reach_of_pair[steps_.row[a] + b]; });
    }

    // Triples of frame j are next.
    RETIME_INLINE void begin_frame(size_t j) {
        j_ = j;
        forget();
    }

    // Where what is known of a row is kept; that of other rows may be forgotten.
    RETIME_INLINE size_t find(size_t row) {
        if (stamp_[row] == now_) return slot_[row];
        if (n_slots_ == kMostSlots) forget();
        const size_t slot = n_slots_++;
        stamp_[row] = now_, slot_[row] = static_cast<uint32_t>(slot);
        if (poses_.size() < n_slots_) {
            poses_.resize(n_slots_), complete_.resize(n_slots_);
            e_.resize(n_slots_ * n_ + kGroup), f_.resize(n_slots_ * n_);
        }
        complete_[slot] = 0;
        poses_[slot] = with_poses_
                           ? squared_distance<Level>(q_.input.data() + j_ * wide_, q_.poses.data() + row * wide_, wide_)
                           : 0.0;
        return slot;
    }

    // The squared distance of the poses alone.
    double pose(size_t slot) const { return poses_[slot]; }

    // Of the triples of a group: step a, then n <= kGroup steps from b on; the rest of `out` (kGroup) has no meaning.
    RETIME_INLINE void squares(size_t a, size_t b, size_t n, size_t row, size_t slot, double* out) {
        using Doubles = typename Level::Doubles;
        if (!complete_[slot]) complete(row, slot);
        const size_t t = (j_ - first_) * steps_.n_pairs + static_cast<size_t>(steps_.row[a]) + b;
        const double zz = q_.squares[row], of_a = f_[slot * n_ + a], pose = poses_[slot];
        double enough[kGroup];
        for (size_t g = 0; g < kGroup; g += Level::kDoubles) {
            const Doubles along = load<Doubles>(e_.data() + slot * n_ + b + g);
            const Doubles moved = load<Doubles>(moved_.data() + t + g), size = load<Doubles>(size_.data() + t + g);
            store(Doubles(pose + ((moved - 2 * (along + of_a)) + zz)), out + g);
            store(Doubles(kCancelled * (size + zz)), enough + g);
        }
        uint32_t cancelled = not_above<Level>(out, enough);
        for (cancelled &= (1u << n) - 1; cancelled; cancelled &= cancelled - 1) {
            const size_t g = next_bit(cancelled);
            out[g] = pose + direct(a, b + g, row);
        }
    }

  private:
    static constexpr size_t kMostSlots = 4096;

    // What triples of frames first_ to last have in common, whatever the row; by the places of squared lengths.
    template <typename OfStep, typename OfPair>
    RETIME_INLINE void measure_steps(size_t last, OfStep of_step, OfPair of_pair) {
        const double vv = q_.p.velocity * q_.p.velocity, ww = q_.p.acceleration * q_.p.acceleration;
        const size_t n_reaches = q_.reaches.size();
        for (size_t j = first_; j < last; ++j) {
            const int64_t n_in = steps_.up_to(static_cast<int64_t>(j));
            const int64_t n_out = steps_.up_to(static_cast<int64_t>(q_.p.n_input - 1 - j));
            for (int64_t a = 0; a < n_in; ++a) {
                // Squared lengths of the steps from i on and from j on.
                const double* from_i = lengths_.data() + (j - steps_.length[a] - begin_) * n_reaches;
                const double* from_j = lengths_.data() + (j - begin_) * n_reaches;
                double* moved = moved_.data() + (j - first_) * steps_.n_pairs + steps_.row[a];
                double* size = size_.data() + (j - first_) * steps_.n_pairs + steps_.row[a];
                const double of_a = from_i[of_step(a)];
                for (int64_t b = steps_.first[a]; b < std::min(steps_.end[a], n_out); ++b) {
                    const double both = from_i[of_pair(a, b)], twice = 2 * (from_j[of_step(b)] + of_a);
                    moved[b] = vv * both + ww * (twice - both);
                    size[b] = (vv + ww) * twice;
                }
            }
        }
    }

    RETIME_INLINE void forget() {
        n_slots_ = 0;
        if (++now_ == 0) std::fill(stamp_.begin(), stamp_.end(), 0), now_ = 1;
    }

    RETIME_INLINE void complete(size_t row, size_t slot) {
        if (stepped_ != j_) step(j_);
        const auto out = [&](size_t b) RETIME_LAMBDA_INLINE { return out_.data() + b * wide_; };
        const auto in = [&](size_t a) RETIME_LAMBDA_INLINE { return in_.data() + a * wide_; };
        dots<Level, false>(q_.plus.data() + row * wide_, out, n_out_, wide_, e_.data() + slot * n_);
        dots<Level, false>(q_.minus.data() + row * wide_, in, n_in_, wide_, f_.data() + slot * n_);
        complete_[slot] = 1;
    }

    // The steps of frame j.
    RETIME_INLINE void step(size_t j) {
        stepped_ = j;
        n_in_ = static_cast<size_t>(steps_.up_to(static_cast<int64_t>(j)));
        n_out_ = static_cast<size_t>(steps_.up_to(static_cast<int64_t>(q_.p.n_input - 1 - j)));
        const double* here = q_.input.data() + j * wide_;
        for (size_t a = 0; a < n_in_; ++a) {
            const double* before = here - static_cast<size_t>(steps_.length[a]) * wide_;
            for (size_t d = 0; d < wide_; ++d) in_[a * wide_ + d] = here[d] - before[d];
        }
        for (size_t b = 0; b < n_out_; ++b) {
            const double* after = here + static_cast<size_t>(steps_.length[b]) * wide_;
            for (size_t d = 0; d < wide_; ++d) out_[b * wide_ + d] = after[d] - here[d];
        }
    }

    // The order of operations is the NumPy backend's.
    RETIME_INLINE double direct(size_t a, size_t b, size_t row) {
        const ScoreProblem& p = q_.p;
        const double v = p.velocity, w = p.acceleration;
        const double* here = q_.input.data() + j_ * wide_;
        const double* before = here - static_cast<size_t>(steps_.length[a]) * wide_;
        const double* after = here + static_cast<size_t>(steps_.length[b]) * wide_;
        const double *dz = q_.reference(row) + p.n_numbers, *ddz = dz + p.n_numbers;
        // Nothing that is written here is read here.
        double* __restrict apart = scratch_.data();
        double* __restrict apart_too = scratch_.data() + wide_;
        for (size_t d = 0; d < p.n_numbers; ++d) {
            apart[d] = (after[d] - before[d]) * v - dz[d];
            apart_too[d] = ((after[d] - here[d]) - (here[d] - before[d])) * w - ddz[d];
        }
        return squared_distance<Level>(scratch_.data(), nothing_.data(), 2 * wide_);
    }

    const PaddedRows& q_;
    const Steps& steps_;
    bool with_poses_;
    size_t n_, wide_, begin_, first_ = 0, j_ = 0, stepped_ = std::numeric_limits<size_t>::max(), n_in_ = 0, n_out_ = 0,
                              n_slots_ = 0;
    uint32_t now_ = 0;
    Array<double> lengths_, out_, in_, scratch_, nothing_, moved_, size_, poses_, e_, f_;
    Array<uint32_t> stamp_, slot_;
    Array<uint8_t> complete_;
};

inline PaddedRows::PaddedRows(const ScoreProblem& problem, const int64_t* in_order)
    : p(problem),
      wide(padded(p.n_numbers)),
      input(pad_rows(p.input, p.n_input, p.n_numbers, 0, p.n_numbers)),
      poses(p.n_reference * wide),
      plus(p.n_reference * wide),
      minus(p.n_reference * wide),
      squares(p.n_reference),
      order(in_order) {
    const Steps& steps = p.steps;
    for (const int64_t one : steps.length) reaches.push_back(static_cast<size_t>(one));
    for (size_t a = 0; a < steps.n; ++a)
        for (int64_t b = steps.first[a]; b < steps.end[a]; ++b)
            reaches.push_back(static_cast<size_t>(steps.length[a] + steps.length[b]));
    const std::vector<size_t> asked = reaches;
    std::sort(reaches.begin(), reaches.end());
    reaches.erase(std::unique(reaches.begin(), reaches.end()), reaches.end());
    for (const size_t reach : asked) {
        auto& places = reach_of_step.size() < steps.n ? reach_of_step : reach_of_pair;
        places.push_back(std::lower_bound(reaches.begin(), reaches.end(), reach) - reaches.begin());
    }
    const double v = p.velocity, w = p.acceleration;
    for (size_t row = 0; row < p.n_reference; ++row) {
        const double *z = reference(row), *dz = z + p.n_numbers, *ddz = dz + p.n_numbers;
        std::copy_n(z, p.n_numbers, poses.data() + row * wide);
        std::fill_n(poses.data() + row * wide + p.n_numbers, wide - p.n_numbers, 0.0);
        double lanes[2][kLanes] = {}, *sum = plus.data() + row * wide, *difference = minus.data() + row * wide;
        in_lanes<kLanes>(p.n_numbers, [&](size_t d, size_t lane) RETIME_LAMBDA_INLINE {
            sum[d] = v * dz[d] + w * ddz[d];
            difference[d] = v * dz[d] - w * ddz[d];
            lanes[0][lane] += dz[d] * dz[d];
            lanes[1][lane] += ddz[d] * ddz[d];
        });
        for (size_t d = p.n_numbers; d < wide; ++d) sum[d] = difference[d] = 0.0;
        squares[row] = halved(lanes[0]) + halved(lanes[1]);
    }
}

}  // namespace retime
