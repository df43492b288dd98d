// The constrained shortest path, literally (the paper's Eq. 3 and 4).
//
//   c_1(0, j)     = 0
//   c_p+1(j, k)   = min over a of  c_p(j - a, j) + f(j - a, j, k)
//
// A vertex (j, k) is kept as (j, b), where b is the step from j to k. Invariant: after layer p, cost(j, b) is the least
// total of any path that stands at frame j in position p - 1, goes on by a step b, and has met every anchor so far; inf
// where there is none. Ties go to the smaller step a, read back from the end. Only frames from which the next anchor
// can still be met are kept (the band). The steps that won are one byte each; where all of them would not fit in
// memory, costs are kept every so many layers and the layers between two such checkpoints are swept again on the way
// back.

#include "layered_path.hpp"

#include "recurrence.hpp"
#include "watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retime {
namespace {

// The costs that leave the frames of `here`, from those that left the frames of `before`, one position earlier.
template <typename Level, bool kEvery>
RETIME_INLINE void advance_frames(const PathProblem& p, const double* scores, const Band& before, const Band& here,
                                  const double* cost, double* next, uint8_t* won) {
    const Steps& steps = p.steps;
    const Reading r(p, scores);
    const Band from = before, to = here;
    for (int64_t j = to.low; j <= to.high; ++j) {
        if (j % 64 == 0) look();
        const int64_t row = (j - to.low) * r.n;
        extend<Level, kEvery>(steps, r, j, cost + (j - from.low) * r.n, up_to<kEvery>(steps, r, j - from.high - 1),
                              up_to<kEvery>(steps, r, j - from.low), 0.0, next + row, won + row);
    }
}

template <typename Level>
RETIME_INLINE void advance_body(const PathProblem& p, const double* scores, const Band& before, const Band& here,
                                const double* cost, double* next, uint8_t* won) {
    if (p.steps.every)
        advance_frames<Level, true>(p, scores, before, here, cost, next, won);
    else
        advance_frames<Level, false>(p, scores, before, here, cost, next, won);
}

RETIME_VERSIONS(void, advance,
                (const PathProblem& p, const double* scores, const Band& before, const Band& here, const double* cost,
                 double* next, uint8_t* won),
                (p, scores, before, here, cost, next, won))

class Layers {
  public:
    Layers(const PathProblem& problem, ScoresByPosition* by_position) : problem_(problem), by_position_(by_position) {
        const int64_t shortest = problem.steps.shortest, longest = problem.steps.longest;
        const auto& anchors = problem.anchors;
        bands_.resize(problem.last_position_max + 1);
        for (size_t span = 0; span + 1 < anchors.size(); ++span) {
            const Anchor &from = anchors[span], &to = anchors[span + 1];
            const int64_t latest = span + 2 == anchors.size() ? problem.last_position_max : to.position;
            for (int64_t p = from.position; p <= latest; ++p)
                bands_[p] = {std::max(from.frame + shortest * (p - from.position), to.frame - longest * (latest - p)),
                             std::min(from.frame + longest * (p - from.position),
                                      to.frame - shortest * std::max<int64_t>(0, to.position - p))};
        }
        if (problem.band)
            for (size_t p = 0; p < bands_.size(); ++p)
                bands_[p] = {std::max(bands_[p].low, problem.band[2 * p]),
                             std::min(bands_[p].high, problem.band[2 * p + 1])};
        for (const Band& band : bands_) widest_ = std::max(widest_, band.size());
    }

    int64_t last() const { return static_cast<int64_t>(bands_.size()) - 1; }
    const Band& band(int64_t p) const { return bands_[p]; }
    size_t widest() const { return widest_; }

    void start(std::vector<double>& cost) const {
        cost.assign(problem_.start_cost, problem_.start_cost + problem_.steps.n);
    }

    // From layer p to p + 1. won: the step a of the best path into each (j, b), of no meaning where there is none.
    void advance(int64_t p, const std::vector<double>& cost, std::vector<double>& next, uint8_t* won) const {
        next.resize(bands_[p].size() * problem_.steps.n + kGroup);
        const double* scores = by_position_ ? by_position_->at(p, bands_) : problem_.scores;
        RETIME_CALL(advance, problem_, scores, bands_[p - 1], bands_[p], cost.data(), next.data(), won);
    }

  private:
    const PathProblem& problem_;
    ScoresByPosition* by_position_;
    std::vector<Band> bands_;
    size_t widest_ = 0;
};

}  // namespace

Path layered_path(const PathProblem& problem, size_t memory_limit, ScoresByPosition* by_position) {
    const Layers layers(problem, by_position);
    const Steps& steps = problem.steps;
    const int64_t first_end = problem.anchors.back().position, last = layers.last(), n = static_cast<int64_t>(steps.n);
    const int64_t end_frame = problem.anchors.back().frame;
    const size_t row = std::max<size_t>(1, layers.widest() * steps.n);
    // All in one block where it fits; else blocks that balance the bytes of steps against the doubles of checkpoints.
    int64_t block = std::max<int64_t>(1, last - 1);
    if (static_cast<double>(row) * static_cast<double>(block) > static_cast<double>(memory_limit))
        block = std::max<int64_t>(1, static_cast<int64_t>(std::sqrt(8.0 * static_cast<double>(last))));
    const bool one_block = block >= last - 1;

    Path path;
    path.total = kInf;
    int64_t p = 0, b = 0;
    std::vector<std::vector<double>> checkpoints;
    std::vector<double> cost, next;
    std::vector<uint8_t> won(row * static_cast<size_t>(block) + (one_block ? 0 : row) + kGroup);
    uint8_t* const unused = won.data() + row * static_cast<size_t>(block);
    layers.start(cost);
    for (int64_t q = 1;; ++q) {
        // A shorter path wins a tie, then the smaller last step.
        const Band &band = layers.band(q), &before = layers.band(q - 1);
        if (q >= first_end && end_frame >= band.low && end_frame <= band.high)
            for (int64_t a = steps.up_to(end_frame - before.high - 1); a < steps.up_to(end_frame - before.low); ++a) {
                const double total = cost[(end_frame - steps.length[a] - before.low) * n + a] + problem.end_cost[a];
                if (total < path.total) path.total = total, p = q, b = a;
            }
        if (q == last) break;
        look(static_cast<size_t>(q), static_cast<size_t>(last));
        if ((q - 1) % block == 0) checkpoints.push_back(cost);
        layers.advance(q, cost, next, one_block ? won.data() + (q - 1) * row : unused);
        cost.swap(next);
    }
    path.found = path.total < kInf;
    if (!path.found) return path;

    path.frames.assign(p + 1, 0);
    path.frames[p] = end_frame;
    path.frames[p - 1] = end_frame - steps.length[b];
    int64_t k = end_frame;
    while (p > 1) {
        const int64_t part = (p - 2) / block, first = 1 + part * block;
        if (!one_block) {
            cost = checkpoints[part];
            for (int64_t q = first; q < p; ++q) {
                layers.advance(q, cost, next, won.data() + (q - first) * row);
                cost.swap(next);
            }
        }
        for (; p > first; --p) {
            const int64_t j = k - steps.length[b];
            const uint8_t a = won[(p - 1 - first) * row + (j - layers.band(p - 1).low) * n + b];
            k = j, b = a;
            path.frames[p - 2] = k - steps.length[b];
        }
    }
    return path;
}

}  // namespace retime
