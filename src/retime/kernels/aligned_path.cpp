// The path that keeps step with a reference: the layered recurrence with costs that depend on the position.
//
//   c_1(0, j)     = 0
//   c_p+1(j, k)   = min over a of  c_p(j - a, j) + | ŷ(j - a, j, k) - ẑ_p | + price(j, a, k - j)
//
// ŷ is the feature of three input frames shown one after another, ẑ_p that of reference frame p. Invariant: as that of
// layered_path.cpp, whose recurrence and trace these are. The costs of a position are all different, so they are made
// where they are needed: for as many positions at once as the memory holds, since what a frame's triples have in common
// is measured once for all of those. Where the trace is made in blocks, the way back makes them again.

#include "aligned_path.hpp"

#include "candidates.hpp"
#include "layered_path.hpp"

#include <algorithm>
#include <cmath>

namespace retime {
namespace {

// Positions from..to-1, and where their costs go.
struct Positions {
    int64_t from, to;
    const std::vector<Band>& bands;
    double* out;
};

// The costs of triples with their middle in frames begin to end.
template <typename Level>
RETIME_INLINE void costs_body(const PaddedRows& q, const double* prices, const Positions& at, size_t begin,
                              size_t end) {
    const ScoreProblem& p = q.p;
    const Steps& steps = p.steps;
    const size_t n_tile = tile_frames(end - begin, steps, kGroup);
    TripleDistances<Level> exact(q, begin, end, true);
    for (size_t first = begin; first < end; first += n_tile) {
        const size_t last = std::min(first + n_tile, end);
        exact.begin_tile(first, last);
        for (size_t j = first; j < last; ++j) {
            look();
            exact.begin_frame(j);
            const double* price = prices + j * steps.n_pairs;
            for (int64_t position = at.from; position < at.to; ++position) {
                const Band& band = at.bands[position];
                if (static_cast<int64_t>(j) < band.low || static_cast<int64_t>(j) > band.high) continue;
                const size_t row = static_cast<size_t>(position - 1), slot = exact.find(row);
                double* out = at.out + (static_cast<size_t>(position - at.from) * p.n_input + j) * steps.n_pairs;
                // Outside the input the prices are infinite.
                std::copy_n(price, steps.n_pairs, out);
                steps.each_group(j, p.n_input, [&](size_t a, size_t b, size_t n, size_t) RETIME_LAMBDA_INLINE {
                    double squares[kGroup];
                    exact.squares(a, b, n, row, slot, squares);
                    for (size_t g = 0; g < kGroup; ++g) squares[g] = std::sqrt(squares[g]);
                    double* here = out + steps.row[a] + static_cast<int64_t>(b);
                    for (size_t g = 0; g < n; ++g) here[g] += squares[g];
                });
            }
        }
    }
}

RETIME_VERSIONS(void, costs, (const PaddedRows& q, const double* prices, const Positions& at, size_t begin, size_t end),
                (q, prices, at, begin, end))

class AlignedCosts : public ScoresByPosition {
  public:
    AlignedCosts(const ScoreProblem& scores, const double* prices, int n_threads, size_t table_limit)
        : rows_(scores), prices_(prices), n_threads_(n_threads), size_(scores.n_input * scores.steps.n_pairs) {
        const size_t most = std::max<size_t>(1, table_limit / sizeof(double) / std::max<size_t>(1, size_));
        n_positions_ = static_cast<int64_t>(std::min(most, std::max<size_t>(1, scores.n_reference)));
        // What reads them may look a group beyond.
        table_.resize(static_cast<size_t>(n_positions_) * size_ + kGroup);
    }

    const double* at(int64_t p, const std::vector<Band>& bands) override {
        if (p < from_ || p >= to_) {
            // Positions 1 to the last but one are inner frames.
            from_ = p, to_ = std::min(p + n_positions_, static_cast<int64_t>(bands.size()) - 1);
            int64_t low = bands[from_].low, high = bands[from_].high;
            for (int64_t q = from_; q < to_; ++q)
                low = std::min(low, bands[q].low), high = std::max(high, bands[q].high);
            if (low <= high) {
                const Positions positions{from_, to_, bands, table_.data()};
                in_threads(
                    static_cast<size_t>(low), static_cast<size_t>(high + 1), n_threads_,
                    [&](size_t begin, size_t end) { RETIME_CALL(costs, rows_, prices_, positions, begin, end); });
            }
        }
        return table_.data() + static_cast<size_t>(p - from_) * size_;
    }

  private:
    const PaddedRows rows_;
    const double* prices_;
    int n_threads_;
    size_t size_;
    int64_t n_positions_, from_ = 0, to_ = 0;
    Blank<double> table_;
};

}  // namespace

Path aligned_path(const ScoreProblem& scores, const PathProblem& path, int n_threads, size_t memory_limit,
                  size_t table_limit) {
    AlignedCosts costs(scores, path.scores, n_threads, table_limit);
    return layered_path(path, memory_limit, &costs);
}

}  // namespace retime
