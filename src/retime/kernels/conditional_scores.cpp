// The conditional score of triples of input frames: how the reference moves where its pose is nearest to
// that of frame j.

#include "candidates.hpp"

namespace retime {
namespace {

// Input frames whose products are made at once.
constexpr size_t kTile = 32;

// The n nearest rows of a query met so far, the nearest first; of rows at one distance the earlier first.
class Nearest {
  public:
    Nearest(size_t n, double* squares, int32_t* rows) : n_(n), squares_(squares), rows_(rows) {}

    void clear() {
        std::fill_n(squares_, n_, kFar);
        std::fill_n(rows_, n_, -1);
    }

    bool holds(int32_t row) const {
        for (size_t m = 0; m < n_; ++m)
            if (rows_[m] == row) return true;
        return false;
    }

    // Whether the limit came down.
    bool add(double square, int32_t row) {
        const auto after = [&](size_t m) { return squares_[m] > square || (squares_[m] == square && rows_[m] > row); };
        if (!after(n_ - 1) && rows_[n_ - 1] >= 0) return false;
        size_t place = n_ - 1;
        for (; place > 0 && (rows_[place - 1] < 0 || after(place - 1)); --place)
            squares_[place] = squares_[place - 1], rows_[place] = rows_[place - 1];
        squares_[place] = square, rows_[place] = row;
        return true;
    }

  private:
    size_t n_;
    double* squares_;
    int32_t* rows_;
};

// What all threads share in the search for poses.
struct Poses {
    const PoseProblem& p;
    Blank<double> input, poses;
    Low low;
    Blank<float> panels;
    size_t n_panels;
    double longest = 0, largest = 0;

    explicit Poses(const PoseProblem& problem)
        : p(problem),
          input(pad_rows(p.input, p.n_input, p.n_numbers, 0, p.n_numbers)),
          poses(pad_rows(p.poses, p.n_reference, p.n_numbers, 0, p.n_numbers)),
          low(p.input, p.n_input, p.n_numbers, p.scale, p.origin),
          n_panels((p.n_reference + kPanel - 1) / kPanel) {
        const size_t n = p.n_numbers;
        panels.resize(n_panels * (n + 1) * kPanel);
        // Sixteen rows at a time: their numbers of one place stand beside each other.
        for (size_t first = 0; first < n_panels * kPanel; first += 16) {
            float* column = panels.data() + first / kPanel * (n + 1) * kPanel + first % kPanel;
            double squares[16] = {};
            for (size_t d = 0; d < n; ++d)
                for (size_t l = 0; l < 16; ++l) {
                    const double number =
                        first + l < p.n_reference ? (p.poses[(first + l) * n + d] - p.origin[d]) * p.scale : 0.0;
                    column[d * kPanel + l] = static_cast<float>(-number);
                    squares[l] += number * number;
                }
            for (size_t l = 0; l < 16; ++l) {
                const bool there = first + l < p.n_reference;
                column[n * kPanel + l] =
                    there ? static_cast<float>(0.5 * squares[l]) : std::numeric_limits<float>::quiet_NaN();
                longest = std::max(longest, std::sqrt(squares[l]));
                largest = std::max(largest, 0.5 * squares[l]);
            }
        }
    }
};

template <typename Level>
RETIME_INLINE void nearest_poses_body(const Poses& q, size_t begin, size_t end, int64_t* out) {
    const PoseProblem& p = q.p;
    const size_t n = p.n_numbers, wide = padded(n), count = p.n_neighbors;
    Array<float> products(kTile * kChunk * kPanel), limits(kTile);
    const Array<float> nothing(kChunk * kPanel, 0.0f);
    Array<double> squares(kTile * count);
    Array<int32_t> rows(kTile * count, -1), guesses(count, -1);
    const auto nearest = [&](size_t t) { return Nearest(count, squares.data() + t * count, rows.data() + t * count); };
    const auto exact = [&](size_t j, int32_t row) RETIME_LAMBDA_INLINE {
        return squared_distance<Level>(q.input.data() + j * wide, q.poses.data() + static_cast<size_t>(row) * wide,
                                       wide);
    };
    const auto limit = [&](size_t j, size_t t) {
        const double length = q.low.lengths[j],
                     root = std::sqrt(squares[t * count + count - 1]) * p.scale * (1 + 1e-12) + p.blur;
        const double least = 0.5 * root * root - 0.5 * length * length;
        limits[t] = static_cast<float>(least + rounding(n) * (length * q.longest + q.largest) +
                                       1e-12 * length * length + 2.4e-7 * std::abs(least) + 1e-30);
    };
    for (size_t first = begin; first < end; first += kTile) {
        const size_t last = std::min(first + kTile, end);
        for (size_t panel = 0; panel < q.n_panels; panel += kChunk) {
            const size_t n_blocks = std::min(kChunk, q.n_panels - panel), stride = kChunk * kPanel;
            multiply_panels<Level>(q.low.rows.data() + first * (n + 1), last - first, n + 1,
                                   q.panels.data() + panel * (n + 1) * kPanel, n_blocks, products.data(), stride);
            look(first - begin, end - begin);
            for (size_t j = first; j < last; ++j) {
                const size_t t = j - first;
                if (panel == 0) {
                    // One frame on, the reference has likely gone on too.
                    if (j > begin)
                        std::copy_n(rows.data() + (t > 0 ? t - 1 : kTile - 1) * count, count, guesses.data());
                    nearest(t).clear();
                    for (const int32_t row : guesses)
                        if (row >= 0 && row + 1 < static_cast<int32_t>(p.n_reference))
                            nearest(t).add(exact(j, row + 1), row + 1);
                    limit(j, t);
                }
                for (size_t block = 0; block < n_blocks; ++block) {
                    const float* here = products.data() + t * stride + block * kPanel;
                    uint64_t found = within<Level>({here, nothing.data(), {nothing.data()}, 1}, 0, 0, limits[t]);
                    for (; found; found &= found - 1) {
                        const size_t lane = next_bit(found);
                        const int32_t row = static_cast<int32_t>((panel + block) * kPanel + lane);
                        if (here[lane] > limits[t] || nearest(t).holds(row)) continue;
                        if (nearest(t).add(exact(j, row), row)) limit(j, t);
                    }
                }
            }
        }
        for (size_t t = 0; t < last - first; ++t)
            for (size_t m = 0; m < count; ++m) out[(first + t) * count + m] = rows[t * count + m];
    }
}

RETIME_VERSIONS(void, nearest_poses, (const Poses& q, size_t begin, size_t end, int64_t* out), (q, begin, end, out))

// Movements of a frame's triples against those of the rows that are nearest to it in pose.
template <typename Level>
RETIME_INLINE void conditional_rows_body(const PaddedRows& q, const int64_t* nearest, size_t begin, size_t end,
                                         double* out) {
    const ScoreProblem& p = q.p;
    const Steps& steps = p.steps;
    const size_t count = p.n_neighbors, n_tile = tile_frames(end - begin, steps, kPanel);
    TripleDistances<Level> exact(q, begin, end, false);
    Array<double> squares(steps.n_groups * count * kGroup);
    for (size_t first = begin; first < end; first += n_tile) {
        const size_t last = std::min(first + n_tile, end);
        exact.begin_tile(first, last);
        for (size_t j = first; j < last; ++j) {
            look(j - begin, end - begin);
            std::fill(squares.begin(), squares.end(), kFar);
            exact.begin_frame(j);
            for (size_t m = 0; m < count; ++m) {
                const size_t row = static_cast<size_t>(nearest[j * count + m]), slot = exact.find(row);
                const auto meet = [&](size_t a, size_t b, size_t n_group, size_t place) RETIME_LAMBDA_INLINE {
                    double measured[kGroup];
                    exact.squares(a, b, n_group, row, slot, measured);
                    keep_least<Level>(measured, count, squares.data() + place * count * kGroup);
                };
                steps.each_group(j, p.n_input, meet);
            }
            steps.each_group(j, p.n_input, [&](size_t a, size_t b, size_t n_group, size_t place) {
                write_least(squares.data() + place * count * kGroup, count, n_group, false,
                            out + j * steps.n_pairs + static_cast<size_t>(steps.row[a]) + b);
            });
        }
    }
}

RETIME_VERSIONS(void, conditional_rows,
                (const PaddedRows& q, const int64_t* nearest, size_t begin, size_t end, double* out),
                (q, nearest, begin, end, out))

}  // namespace

void nearest_poses(const PoseProblem& problem, int n_threads, int64_t* out) {
    const Poses shared(problem);
    in_threads(0, problem.n_input, n_threads,
               [&](size_t from, size_t to) { RETIME_CALL(nearest_poses, shared, from, to, out); });
}

void conditional_scores(const ScoreProblem& p, const int64_t* nearest, int n_threads, double* out) {
    const PaddedRows shared(p);
    in_threads(0, p.n_input, n_threads,
               [&](size_t from, size_t to) { RETIME_CALL(conditional_rows, shared, nearest, from, to, out); });
}

}  // namespace retime
