// The joint score of triples (i, j, k) of input frames, a step and another one apart, against references that fit a few
// tiles:
//
//   f = mean of the n_neighbors smallest |y^ - z^_l|,  y^ = [y_j, v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))].
//
// The squared distance separates into a term of j, one of k and one of i for each reference frame l, so a candidate
// costs two subtractions instead of 3 * n_numbers of them. In single precision each is right up to `slack`: a row that
// is farther than the n_neighbors nearest by more than twice that can't be among them. The rest are measured exactly
// (exact_distances.hpp), eight triples at once.

#include "candidates.hpp"

namespace retime {
namespace {

// What all threads share.
struct Joint {
    const ScoreProblem& p;
    PaddedRows measured;
    Low low;
    Columns columns;

    Joint(const ScoreProblem& problem, double scale)
        : p(problem),
          measured(problem),
          low(p.input, p.n_input, p.n_numbers, scale),
          columns(p.reference, p.n_reference, p.n_numbers, p.velocity, p.acceleration, scale) {}
};

template <typename Level>
RETIME_INLINE void joint_rows_body(const Joint& q, size_t begin, size_t end, bool each, double* out) {
    const ScoreProblem& p = q.p;
    const Steps& steps = p.steps;
    const size_t n = p.n_numbers, count = p.n_neighbors, depth = n + 1, n_panels = q.columns.n_panels;
    const double unit = rounding(n);
    const size_t n_tile = tile_frames(end - begin, steps, std::min(kChunk, n_panels) * kPanel);
    TileProducts tile(n_tile, steps, std::min(kChunk, n_panels) * kPanel);

    // Of each triple of the tile: the squared distances of its nearest rows so far, the smallest first, for kGroup
    // triples beside each other.
    Array<double> squares(n_tile * steps.n_groups * count * kGroup);
    Array<float> lowest_limits(n_tile * steps.n_groups * kGroup), least(kGroup * kChunk * kLeast);
    float total[kGroup * kLeast] = {};
    TripleDistances<Level> exact(q.measured, begin, end, true);

    for (size_t first = begin; first < end; first += n_tile) {
        const size_t last = std::min(first + n_tile, end);
        std::fill(squares.begin(), squares.end(), kFar);
        std::fill(lowest_limits.begin(), lowest_limits.end(), kFarFloat);
        exact.begin_tile(first, last);
        for (size_t panel = 0; panel < n_panels; panel += kChunk) {
            const size_t n_blocks = std::min(kChunk, n_panels - panel);
            tile.multiply<Level>(q.low, q.columns, p, depth, first, last, panel, n_blocks, 0, n_panels <= kChunk);
            for (size_t j = first; j < last; ++j) {
                look(j - begin, end - begin);
                exact.begin_frame(j);
                const auto meet = [&](size_t a, size_t b, size_t n_group, size_t place) RETIME_LAMBDA_INLINE {
                    const size_t group = (j - first) * steps.n_groups + place;
                    const Rows rows = tile.rows(steps, j, a, b, n_group, 0);
                    minima<Level>(rows, n_blocks, least.data(), total);
                    // Never above what an earlier chunk has shown.
                    float limits[kGroup], *lowest = lowest_limits.data() + group * kGroup;
                    if (count == 3)
                        nth_least(total, 3, limits);
                    else
                        nth_least(total, count, limits);
                    const double some_slack =
                        q.low.lengths[j] * q.columns.longest_here +
                        q.low.lengths[j - static_cast<size_t>(steps.length[a])] * q.columns.longest_before +
                        q.columns.largest;
                    for (size_t g = 0; g < n_group; ++g) {
                        const double longest_after =
                            q.low.lengths[j + static_cast<size_t>(steps.length[b + g])] * q.columns.longest_after;
                        const double slack = unit * (some_slack + longest_after) + 1e-30;
                        limits[g] = static_cast<float>(limits[g] + 2.000001 * slack) + std::abs(limits[g]) * 2.4e-7f;
                        limits[g] = lowest[g] = std::min(lowest[g], limits[g]);
                    }
                    uint64_t near[kChunk];
                    uint32_t blocks = nearby<Level>(rows, n_blocks, least.data(), limits, near);
                    // What one triple needs is measured for its neighbours too: a few instructions for all of them.
                    double* nearest = squares.data() + group * count * kGroup;
                    for (; blocks; blocks &= blocks - 1) {
                        const size_t block = next_bit(blocks);
                        for (uint64_t some = near[block]; some; some &= some - 1) {
                            const size_t row = (panel + block) * kPanel + next_bit(some);
                            double measured[kGroup];
                            exact.squares(a, b, n_group, row, exact.find(row), measured);
                            keep_least<Level>(measured, count, nearest);
                        }
                    }
                };
                steps.each_group(j, p.n_input, meet);
            }
        }
        for (size_t j = first; j < last; ++j)
            steps.each_group(j, p.n_input, [&](size_t a, size_t b, size_t n_group, size_t place) {
                const size_t triple = j * steps.n_pairs + static_cast<size_t>(steps.row[a]) + b;
                const double* nearest = squares.data() + ((j - first) * steps.n_groups + place) * count * kGroup;
                write_least(nearest, count, n_group, each, out + triple * (each ? count : 1));
            });
    }
}

RETIME_VERSIONS(void, joint_rows, (const Joint& q, size_t begin, size_t end, bool each, double* out),
                (q, begin, end, each, out))

}  // namespace

void joint_scores(const ScoreProblem& problem, double scale, int n_threads, bool each, double* out) {
    const Joint shared(problem, scale);
    in_threads(0, problem.n_input, n_threads,
               [&](size_t from, size_t to) { RETIME_CALL(joint_rows, shared, from, to, each, out); });
}

}  // namespace retime
