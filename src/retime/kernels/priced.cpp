// The constrained shortest path by a price on the count.
//
// Relaxation: charge lambda_k for each step in the span k between two anchors and forget the positions. One sweep over the vertices
// (frame, step) finds the best path of any length,
//
//   V(j + b, b) = min over a of  V(j, a) + f(j - a, j, j + b) + lambda(j),
//
// and V(end) - sum of lambda_k * (steps that span k must have) is a lower bound on every path that meets the anchors, whatever lambda.
//
// Proof: with G(j, a) the least priced cost from vertex (j, a) to the end, a partial path with cost c at position p can't belong to a
// path within `gap` of the bound if  c + price so far + G(j, a) > bound + gap.  So labels (position, cost) are carried over the other
// vertices only. Invariant: after frame j, a label (p, j, a) holds the least cost of any path to (j, a) in position p that was not
// ruled out; it is the value of the layered recurrence, computed by the same additions, so totals and ties agree with it to the last
// bit. If labels reach the end within the gap, the best of them is optimal; else the gap widens. All labels survive at worst (scores
// all equal): then it gives up before memory does, and the caller runs the layered recurrence.

#include "priced.hpp"

#include "extend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retime {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

struct Spans {
    explicit Spans(const PathProblem& p) : s(static_cast<int64_t>(p.max_skip)), n(static_cast<int64_t>(p.n_input)) {
        const auto& anchors = p.anchors;
        count = anchors.size() - 1;
        of.resize(n);
        reach.resize(n);
        size_t span = 0;
        for (int64_t j = 0; j < n; ++j) {
            while (span + 1 < count && j >= anchors[span + 1].frame) ++span;
            of[j] = static_cast<int32_t>(span);
            reach[j] = static_cast<int32_t>(std::min(s, anchors[span + 1].frame - j));
        }
    }

    int64_t s, n;
    size_t count;
    std::vector<int32_t> of;     // the span of the step that leaves frame j
    std::vector<int32_t> reach;  // the longest step from frame j that does not pass an anchor
};

// One sweep at given prices: the best path of any length, and what it spends in each span.
struct Sweep {
    std::vector<double> value;
    std::vector<uint8_t> won;  // at (j, b): the step before it
    std::vector<int64_t> steps;
    std::vector<double> spent;
    std::vector<int64_t> frames;
    double priced = kInf;
};

RETIME_INLINE void sweep_body(const PathProblem& p, const Spans& spans, const std::vector<double>& price, Sweep& out) {
    const int64_t s = spans.s, n = spans.n;
    out.value.assign(n * s, kInf);
    out.won.resize(n * s);
    for (int64_t b = 1; b <= spans.reach[0]; ++b) out.value[b * s + b - 1] = p.start_cost[b - 1] + price[0];
    std::vector<double> best(s);
    for (int64_t j = 1; j + 1 < n; ++j) {
        extend(s, out.value.data() + j * s, p.scores + j * s * s, best.data(), out.won.data() + j * s);
        const double charge = price[spans.of[j]];
        for (int64_t b = 1; b <= spans.reach[j]; ++b) out.value[(j + b) * s + b - 1] = best[b - 1] + charge;
    }
    int64_t last = 0;
    out.priced = kInf;
    for (int64_t a = 1; a <= s; ++a) {
        const double total = out.value[(n - 1) * s + a - 1] + p.end_cost[a - 1];
        if (total < out.priced) out.priced = total, last = a;
    }
    out.steps.assign(spans.count, 0);
    out.spent.assign(spans.count, 0.0);
    out.frames.clear();
    if (!(out.priced < kInf)) return;
    int64_t k = n - 1, b = last;
    out.spent.back() += p.end_cost[b - 1];
    out.frames.push_back(k);
    while (true) {
        const int64_t j = k - b;
        const int32_t span = spans.of[j];
        out.frames.push_back(j);
        ++out.steps[span];
        if (j == 0) {
            out.spent[span] += p.start_cost[b - 1];
            break;
        }
        const int64_t a = out.won[j * s + b - 1];
        out.spent[span] += p.scores[(j * s + a - 1) * s + b - 1];
        k = j, b = a;
    }
    std::reverse(out.frames.begin(), out.frames.end());
}

// Least priced cost from every vertex to the end.
RETIME_INLINE void to_go_body(const PathProblem& p, const Spans& spans, const std::vector<double>& price, std::vector<double>& out) {
    const int64_t s = spans.s, n = spans.n;
    out.assign(n * s, kInf);
    for (int64_t a = 1; a <= s; ++a) out[(n - 1) * s + a - 1] = p.end_cost[a - 1];
    std::vector<double> ahead(s);
    for (int64_t j = n - 2; j >= 1; --j) {
        const double charge = price[spans.of[j]];
        for (int64_t b = 1; b <= s; ++b) ahead[b - 1] = b <= spans.reach[j] ? out[(j + b) * s + b - 1] + charge : kInf;
        const double* f = p.scores + j * s * s;
        for (int64_t a = 0; a < s; ++a) {
            double least = kInf;
            for (int64_t b = 0; b < s; ++b) least = std::min(least, f[a * s + b] + ahead[b]);
            out[j * s + a] = least;
        }
    }
}

// Labels at one frame: rows of costs, one row a position.
struct Rows {
    int64_t low = 0;  // position of the first row
    std::vector<double> cost;

    double* at(int64_t position, int64_t s) {
        if (cost.empty()) low = position;
        if (position < low) {
            cost.insert(cost.begin(), static_cast<size_t>((low - position) * s), kInf);
            low = position;
        }
        const size_t need = static_cast<size_t>((position - low + 1) * s);
        if (cost.size() < need) cost.resize(need, kInf);
        return cost.data() + (position - low) * s;
    }
};

// Positions that frame j may have, by the steps left and the steps behind.
struct Reachable {
    int64_t low, high;
};

Reachable reachable(const PathProblem& p, const Spans& spans, int64_t j) {
    // The frame belongs to the span that enters it: its next anchor is the first one at or after j.
    size_t span = static_cast<size_t>(spans.of[j]);
    if (j == p.anchors[span].frame && span > 0) --span;
    const Anchor &from = p.anchors[span], &to = p.anchors[span + 1];
    const int64_t to_max = span + 1 == spans.count ? p.last_position_max : to.position;
    const int64_t s = spans.s, behind = j - from.frame, ahead = to.frame - j;
    return {std::max(from.position + (behind + s - 1) / s, to.position - ahead), std::min(from.position + behind, to_max - (ahead + s - 1) / s)};
}

struct Pass {
    bool found = false, overflow = false;
    int64_t labels = 0;
    Path path;
};

RETIME_INLINE Pass carry_labels_body(const PathProblem& p, const Spans& spans, const std::vector<double>& price, const std::vector<double>& go, double owed,
                  double limit, size_t max_labels) {
    // owed: the prices of all steps that the bound has paid for; a label survives while cost + price so far + to go - owed <= limit.
    const int64_t s = spans.s, n = spans.n;
    Pass pass;
    std::vector<double> paid(spans.count + 1, 0.0);
    for (size_t span = 0; span < spans.count; ++span)
        paid[span + 1] = paid[span] + price[span] * static_cast<double>(p.anchors[span + 1].position - p.anchors[span].position);

    std::vector<Rows> ring(s + 1);
    std::vector<int64_t> trace_low(n, 0), trace_start(n, 0), trace_rows(n, 0);
    std::vector<uint8_t> trace;
    const double ceiling = limit + owed;
    for (int64_t b = 1; b <= spans.reach[0]; ++b) {
        const Reachable ok = reachable(p, spans, b);
        const double cost = p.start_cost[b - 1];
        if (ok.low <= 1 && 1 <= ok.high && cost + price[0] + go[b * s + b - 1] <= ceiling) ring[b % (s + 1)].at(1, s)[b - 1] = cost;
    }
    std::vector<double> best(s);
    std::vector<uint8_t> step(s);
    std::vector<Reachable> ok(s + 1);
    for (int64_t j = 1; j + 1 < n; ++j) {
        Rows& rows = ring[j % (s + 1)];
        if (rows.cost.empty()) continue;
        const int64_t n_rows = static_cast<int64_t>(rows.cost.size()) / s;
        trace_low[j] = rows.low, trace_start[j] = static_cast<int64_t>(trace.size()), trace_rows[j] = n_rows;
        pass.labels += n_rows;
        if (trace.size() + static_cast<size_t>(n_rows * s) > max_labels) {
            pass.overflow = true;
            return pass;
        }
        trace.resize(trace.size() + static_cast<size_t>(n_rows * s));
        const int32_t span = spans.of[j], reach = spans.reach[j];
        for (int64_t b = 1; b <= reach; ++b) ok[b] = reachable(p, spans, j + b);
        for (int64_t row = 0; row < n_rows; ++row) {
            const int64_t next = rows.low + row + 1;
            extend(s, rows.cost.data() + row * s, p.scores + j * s * s, best.data(), step.data());
            std::copy(step.begin(), step.end(), trace.begin() + trace_start[j] + row * s);
            const double price_so_far = paid[span] + price[span] * static_cast<double>(next - p.anchors[span].position);
            for (int64_t b = 1; b <= reach; ++b) {
                if (next < ok[b].low || next > ok[b].high) continue;
                const int64_t k = j + b;
                if (best[b - 1] + price_so_far + go[k * s + b - 1] > ceiling || best[b - 1] == kInf) continue;
                ring[k % (s + 1)].at(next, s)[b - 1] = best[b - 1];
            }
        }
        rows.cost.clear();
    }
    // The last frame: the cheapest label, then the shorter path, then the smaller last step.
    Rows& rows = ring[(n - 1) % (s + 1)];
    const int64_t n_rows = static_cast<int64_t>(rows.cost.size()) / s;
    double total = kInf;
    int64_t position = 0, b = 0;
    for (int64_t row = 0; row < n_rows; ++row)
        for (int64_t a = 1; a <= s; ++a) {
            const double cost = rows.cost[row * s + a - 1] + p.end_cost[a - 1];
            if (cost < total) total = cost, position = rows.low + row, b = a;
        }
    if (!(total < kInf)) return pass;
    pass.found = true;
    pass.path.found = true;
    pass.path.total = total;
    pass.path.frames.assign(position + 1, 0);
    int64_t k = n - 1;
    pass.path.frames[position] = k;
    for (int64_t q = position - 1; q >= 0; --q) {
        const int64_t j = k - b;
        pass.path.frames[q] = j;
        if (q == 0) break;
        b = trace[trace_start[j] + (q - trace_low[j]) * s + b - 1];
        k = j;
    }
    return pass;
}

RETIME_VERSIONS(void, sweep, (const PathProblem& p, const Spans& spans, const std::vector<double>& price, Sweep& out), (p, spans, price, out))
RETIME_VERSIONS(void, to_go, (const PathProblem& p, const Spans& spans, const std::vector<double>& price, std::vector<double>& out),
                (p, spans, price, out))
RETIME_VERSIONS(Pass, carry_labels,
                (const PathProblem& p, const Spans& spans, const std::vector<double>& price, const std::vector<double>& go, double owed, double limit,
                 size_t max_labels),
                (p, spans, price, go, owed, limit, max_labels))

}  // namespace

Path free_path(const PathProblem& p) {
    const Spans spans(p);
    Sweep best;
    RETIME_CALL(sweep, p, spans, std::vector<double>(spans.count, 0.0), best);
    Path path;
    path.found = best.priced < kInf;
    if (!path.found) return path;
    path.frames = std::move(best.frames);
    path.total = best.priced;
    return path;
}

PricedPath priced_path(const PathProblem& p, size_t max_labels) {
    const Spans spans(p);
    const size_t count = spans.count;
    PricedPath result;
    const bool ranged = p.last_position_max > p.anchors.back().position;

    // What each span must have, at least and at most; they differ in the last one only, where the length is a range.
    std::vector<int64_t> least(count), most(count);
    for (size_t k = 0; k < count; ++k) least[k] = most[k] = p.anchors[k + 1].position - p.anchors[k].position;
    most.back() = p.last_position_max - p.anchors[count - 1].position;

    // Prices: each span keeps a bracket, one price that buys too many steps and one that buys too few, and tries the price at which
    // the two paths cost the same.
    std::vector<double> price(count, 0.0), low(count, -kInf), high(count, kInf);
    std::vector<double> low_spent(count), high_spent(count);
    std::vector<int64_t> low_steps(count), high_steps(count);
    std::vector<double> best_price = price;
    double bound = -kInf;
    Sweep now;
    double scale = 0.0;
    int stalled = 0;
    double ceiling = kInf;
    for (int round = 0; round < 60; ++round) {
        RETIME_CALL(sweep, p, spans, price, now);
        ++result.sweeps;
        if (!(now.priced < kInf)) return result;
        double dual = now.priced;
        bool exact = true;
        for (size_t k = 0; k < count; ++k) {
            // Of the allowed counts, the one that this price likes best bounds all of them.
            dual -= price[k] * static_cast<double>(price[k] > 0 ? most[k] : least[k]);
            exact = exact && now.steps[k] >= least[k] && now.steps[k] <= most[k];
        }
        // The bound is concave in the prices. Where the last three prices between two straddling paths did not raise it, it is at
        // its top, or so near that wider gaps cost less than more sweeps.
        bool inside = true;
        for (size_t k = 0; k < count; ++k) inside = inside && low[k] > -kInf && high[k] < kInf;
        stalled = !inside || dual > bound + 1e-9 * std::abs(bound) ? 0 : stalled + 1;
        if (dual > bound) bound = dual, best_price = price;
        bool straddled = true;
        for (size_t k = 0; k < count; ++k)
            straddled = straddled && ((low[k] > -kInf && high[k] < kInf) || (now.steps[k] >= least[k] && now.steps[k] <= most[k]));
        if (straddled && stalled >= 6) break;
        // With one span it can't rise above the price at which the two straddling paths cost the same.
        if (count == 1 && dual >= ceiling - 1e-12 * std::abs(ceiling)) break;
        if (exact && (!ranged || price.back() == 0.0)) break;
        if (round == 0)
            for (size_t k = 0; k < count; ++k) scale += std::abs(now.spent[k]) / static_cast<double>(std::max<int64_t>(1, now.steps[k]));
        bool moved = false;
        for (size_t k = 0; k < count; ++k) {
            const double old = price[k];
            if (now.steps[k] > most[k]) {
                low[k] = old, low_steps[k] = now.steps[k], low_spent[k] = now.spent[k];
            } else if (now.steps[k] < least[k]) {
                high[k] = old, high_steps[k] = now.steps[k], high_spent[k] = now.spent[k];
            } else {
                continue;
            }
            if (low[k] > -kInf && high[k] < kInf) {
                double next = (high_spent[k] - low_spent[k]) / static_cast<double>(low_steps[k] - high_steps[k]);
                // Neighbouring spans shift what a span spends; stay inside the bracket, and halve it now and then.
                if (!(next > low[k] && next < high[k]) || round % 4 == 3) next = low[k] + (high[k] - low[k]) / 2;
                price[k] = next;
                ceiling = low_spent[k] + next * static_cast<double>(low_steps[k] - (next > 0 ? most[k] : least[k]));
            } else if (low[k] > -kInf) {
                price[k] = old + std::max(scale, std::abs(old)) * 0.5;
            } else {
                price[k] = old - std::max(scale, std::abs(old)) * 0.5;
            }
            moved = moved || price[k] != old;
        }
        if (scale == 0.0) scale = 1e-300;
        if (!moved) break;
    }
    double owed = 0.0;
    for (size_t k = 0; k < count; ++k) owed += best_price[k] * static_cast<double>(best_price[k] > 0 ? most[k] : least[k]);
    result.lower_bound = bound;
    std::vector<double> go;
    RETIME_CALL(to_go, p, spans, best_price, go);

    // Rounding in sums of n terms; also keeps every path that ties with the best.
    const double size = std::abs(bound) + std::abs(owed);
    const double slack = 1e-11 * size + 1e-290;
    // What the count costs beyond the bound is a matter of a few frames, however long the path: a share of one frame's score.
    double gap = 0.005 * std::abs(bound) / static_cast<double>(std::max<int64_t>(1, p.anchors.back().position)) + 4 * slack;
    for (;; gap *= 6) {
        Pass pass = RETIME_CALL(carry_labels, p, spans, best_price, go, owed, bound + gap, max_labels);
        ++result.passes;
        result.labels = pass.labels;
        if (pass.overflow) {
            result.gave_up = true;
            return result;
        }
        if (pass.found && pass.path.total + slack <= bound + gap) {
            result.path = std::move(pass.path);
            result.lower_bound = std::min(bound, result.path.total);
            return result;
        }
        if (!(gap < 1e3 * size + 1.0)) {
            result.gave_up = true;
            return result;
        }
    }
}

}  // namespace retime
