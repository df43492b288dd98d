// The constrained shortest path by a price on the count.
//
// Relaxation: charge lambda_k for each step in the span k between two anchors and forget the positions. One sweep over
// the vertices (frame, step) finds the best path of any length,
//
//   V(j, b) = lambda(j) + min over a of  V(j - a, a) + f(j - a, j, j + b),
//
// where V(j, b) is the least priced cost of a path whose last step goes from frame j to j + b. Its least value at the
// end, Phi, less the sum of lambda_k * (steps that span k must have) is a lower bound on every path that meets the
// anchors, whatever lambda.
//
// Proof: with G the least priced cost from a vertex to the end, a path within `gap` of the bound uses only vertices
// with V + G <= Phi + gap. Those are few: a walk back from the end finds them, and the edges between them (the
// corridor). Labels (position, cost) are carried over the corridor only; they too are dropped where cost + price so far
// + G > Phi + gap. Invariant: a label holds the least cost of any path to its vertex in its position that was not ruled
// out. It is the value of the layered recurrence, computed by the same additions, so totals and ties agree with it to
// the last bit. If labels reach the end within the gap, the best of them is optimal; else the gap widens. All of the
// vertices survive at worst (scores nearly all equal): then it gives up before memory does, and the caller runs the
// layered recurrence. Where all scores are equal, as of a clip in which nothing moves, there is nothing to search.

#include "priced_path.hpp"

#include "recurrence.hpp"
#include "watch.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace retime {
namespace {

// Frames that are asked for ahead of a sweep: it reads each score once, and would wait for memory.
constexpr int64_t kAhead = 24;
constexpr int64_t kLine = 64 / sizeof(double);
// Frames, or labels' vertices, between two looks at whether the search is still wanted.
constexpr int64_t kLook = 64;

struct Sweep {
    std::vector<double> leaving;  // V(j, b) at j * n + b
    std::vector<uint8_t> won;     // at the same place: the step before
    std::vector<int64_t> steps;   // of the best path, in each span
    std::vector<double> spent;    // its scores in each span
    double priced = kInf;         // Phi
};

// Walks back along the best path, which ends with a step `b`.
void count_steps(const PathProblem& p, const std::vector<double>& price, int64_t b, Sweep& out) {
    const int64_t n = static_cast<int64_t>(p.steps.n);
    int64_t k = p.anchors.back().frame;
    double until = out.priced;
    for (size_t span = p.anchors.size() - 1; span-- > 0;) {
        const int64_t from = p.anchors[span].frame;
        int64_t steps = 0;
        while (true) {
            k -= p.steps.length[b], ++steps;
            if (k <= 0) break;
            b = out.won[k * n + b];
            if (k == from) break;
        }
        const double before = k <= 0 ? 0.0 : out.leaving[(k - p.steps.length[b]) * n + b];
        out.steps[span] = steps;
        out.spent[span] = until - before - price[span] * static_cast<double>(steps);
        until = before;
    }
}

// V of every frame, one span after another.
template <typename Level, bool kEvery>
RETIME_INLINE void sweep_frames(const PathProblem& p, const std::vector<double>& price, Sweep& out) {
    const Steps& steps = p.steps;
    const Reading r(p);
    double* const all = out.leaving.data();
    uint8_t* const won = out.won.data();
    const size_t count = p.anchors.size() - 1;
    for (size_t span = 0; span < count; ++span) {
        const int64_t from = p.anchors[span].frame, end = p.anchors[span + 1].frame, to = std::min(end, r.n_input - 2);
        // The step that leaves an anchor belongs to the next span.
        const double inside = price[span], at_end = end <= to ? price[span + 1] : 0.0;
        for (int64_t j = from + 1; j <= to; ++j) {
            if (j % kLook == 0) look();
            const double* ahead = r.scores + std::min(j + kAhead, r.n_input - 1) * r.n_pairs;
            for (int64_t line = 0; line < r.n_pairs; line += kLine) prefetch(ahead + line);
            double* leaving = all + j * r.n;
            extend<Level, kEvery>(steps, r, j, leaving, 0, up_to<kEvery>(steps, r, j - from),
                                  j == end ? at_end : inside, leaving, won + j * r.n);
        }
    }
}

template <typename Level>
RETIME_INLINE void sweep_body(const PathProblem& p, const std::vector<double>& price, Sweep& out) {
    const int64_t n = static_cast<int64_t>(p.steps.n), n_input = static_cast<int64_t>(p.n_input);
    const size_t count = p.anchors.size() - 1;
    out.leaving.resize(static_cast<size_t>(n_input * n) + kGroup);
    out.won.resize(static_cast<size_t>(n_input * n) + kGroup);
    out.steps.assign(count, 0);
    out.spent.assign(count, 0.0);
    for (int64_t b = 0; b < n; ++b) out.leaving[b] = p.start_cost[b] + price[0];
    if (p.steps.every)
        sweep_frames<Level, true>(p, price, out);
    else
        sweep_frames<Level, false>(p, price, out);
    out.priced = kInf;
    int64_t last = 0;
    for (int64_t a = 0; a < p.steps.up_to(n_input - 1 - p.anchors[count - 1].frame); ++a) {
        const double total = out.leaving[(n_input - 1 - p.steps.length[a]) * n + a] + p.end_cost[a];
        if (total < out.priced) out.priced = total, last = a;
    }
    if (out.priced < kInf) count_steps(p, price, last, out);
}

RETIME_VERSIONS(void, sweep, (const PathProblem& p, const std::vector<double>& price, Sweep& out), (p, price, out))

// The search for one span's price: a price at which the best path has too many steps, and one at which it has too few.
class Bracket {
  public:
    double price = 0.0;

    // How far to go at first, where only one side is known: `stride`, or by the steps that a unit of price saves.
    void expect(double stride, double slope) { stride_ = stride, slope_ = slope; }
    bool expects() const { return stride_ > 0; }

    void add(int64_t steps, double spent, int64_t least, int64_t most) {
        // Of the allowed counts, the one that this price likes best bounds all of them; no price likes all of them
        // alike.
        target_ = price > 0 ? most : price < 0 ? least : std::clamp(steps, least, most);
        exact_ = steps == target_;
        here_ = spent + price * static_cast<double>(steps - target_);
        if (exact_) return;
        const bool too_many = steps > target_;
        Side& side = too_many ? many_ : few_;
        if (turned_ && price != last_price_) {
            const double slope = static_cast<double>(last_steps_ - steps) / (price - last_price_);
            if (slope > 0) slope_ = slope;
        }
        turned_ = true, last_price_ = price, last_steps_ = steps;
        side = {price, spent, steps, true};
        if (straddled()) {
            const int64_t before = apart_;
            apart_ = many_.steps - few_.steps;
            slow_ = before > 0 && 2 * apart_ > before ? slow_ + 1 : 0;
            meet_ = (few_.spent - many_.spent) / static_cast<double>(apart_);
            ceiling_ = many_.spent + meet_ * static_cast<double>(many_.steps - (meet_ > 0 ? most : least));
        }
    }

    bool exact() const { return exact_; }
    bool straddled() const { return many_.known && few_.known; }
    // How much the bound may still rise for this span.
    double loss() const { return exact_ ? 0.0 : straddled() ? std::max(0.0, ceiling_ - here_) : kInf; }
    // How high the bound can get for this span, by the two paths that straddle.
    double ceiling() const { return straddled() ? ceiling_ : kInf; }

    // Moves on; false where the price stays.
    bool next(int round) {
        if (exact_) return false;
        const double old = price;
        if (!straddled()) {
            // Rather too far than not far enough: two sides are worth more than a near miss.
            const double wanted =
                slope_ > 0 ? 1.3 * std::abs(static_cast<double>(last_steps_ - target_)) / slope_ : stride_;
            stride_ = std::clamp(wanted, 0.3 * stride_, 10.0 * stride_);
            price += many_.known ? stride_ : -stride_;
            stride_ *= 2.0;
            return price != old;
        }
        // Counts fall smoothly with the price while they differ by many: from the nearer side go as far as they last
        // fell, and a little beyond. Then it is a matter of single paths, and the price at which two of them cost the
        // same is the next to try. Neighbouring spans shift what a span spends, so stay inside the bracket.
        const double low = many_.price, high = few_.price;
        double wanted = meet_;
        if (apart_ > 12 && slow_ < 2 && slope_ > 0) {
            const int64_t above = many_.steps - target_, below = target_ - few_.steps;
            wanted = above < below ? low + (1.15 * static_cast<double>(above) + 1) / slope_
                                   : high - (1.15 * static_cast<double>(below) + 1) / slope_;
        } else {
            slow_ = 0;
        }
        if (!(wanted > low && wanted < high) || round % 12 == 11) wanted = low + (high - low) / 2;
        price = wanted;
        return price != old;
    }

  private:
    struct Side {
        double price = 0.0, spent = 0.0;
        int64_t steps = 0;
        bool known = false;
    };
    Side many_, few_;
    bool exact_ = false, turned_ = false;
    int slow_ = 0;  // turns on which the two sides came no nearer
    int64_t target_ = 0, apart_ = 0, last_steps_ = 0;
    double stride_ = 0.0, slope_ = 0.0, here_ = 0.0, meet_ = 0.0, ceiling_ = kInf, last_price_ = 0.0;
};

// A first price for a long span, from a few short pieces of it: they stay in the cache, and every sweep over all scores
// waits for memory.
void guess_price(const PathProblem& p, int64_t from, int64_t to, int64_t wanted_steps, Bracket& out) {
    constexpr int64_t kPieces = 12, kLongest = 256;
    const int64_t n_pairs = static_cast<int64_t>(p.steps.n_pairs),
                  length = std::min({kLongest, to - from, std::max(4 * p.steps.longest, (to - from) / (6 * kPieces))});
    const std::vector<double> nothing(p.steps.n, 0.0);
    const std::vector<Anchor> ends{{0, 0}, {length, length}};
    const double share = static_cast<double>(wanted_steps) / static_cast<double>(to - from);
    Sweep sweep;
    int64_t steps = 0, frames = 0;
    double spent = 0.0;
    const auto run = [&](double price) {
        steps = frames = 0, spent = 0.0;
        for (int64_t piece = 0; piece < kPieces; ++piece) {
            const int64_t first = from + (to - from - length) * (2 * piece + 1) / (2 * kPieces);
            const PathProblem part{p.scores + first * n_pairs,
                                   static_cast<size_t>(length + 1),
                                   p.steps,
                                   ends,
                                   length,
                                   nothing.data(),
                                   nothing.data()};
            RETIME_CALL(sweep, part, {price}, sweep);
            // Forbidden triples may leave no way through a piece.
            if (sweep.priced < kInf) steps += sweep.steps[0], spent += sweep.spent[0], frames += length;
        }
    };
    Bracket bracket;
    for (int round = 0; round < 12; ++round) {
        run(bracket.price);
        if (steps == 0) return;
        if (round == 0) bracket.expect(std::max(std::abs(spent) / static_cast<double>(steps), 1e-300), 0.0);
        const int64_t target = static_cast<int64_t>(share * static_cast<double>(frames) + 0.5);
        bracket.add(steps, spent, target, target);
        if (bracket.exact() || !bracket.next(round)) break;
    }
    const int64_t before = steps;
    const double stride = 0.1 * std::abs(bracket.price);
    run(bracket.price + stride);
    const double slope = static_cast<double>(before - steps) / stride * static_cast<double>(to - from) /
                         static_cast<double>(std::max<int64_t>(1, frames));
    out.price = bracket.price;
    out.expect(stride, slope > 0 && std::isfinite(slope) ? slope : 0.0);
}

// The vertices and edges that a path within the gap can use.
struct Corridor {
    struct Vertex {
        double go;  // G
        int64_t frame, first_edge;
        int64_t low, high;  // positions of its labels; the costs of a frame and a step share a slot,
        int64_t first;      // and that of the lowest position stands here in it
        int64_t trace;      // where the edges that won begin, one byte a position; only where there are several
        int32_t slot;
        uint16_t step, n_edges;
    };
    struct Edge {
        int64_t from;
        double score;
    };

    std::vector<Vertex> vertices;
    std::vector<Edge> edges;     // those of a vertex side by side, by the step before
    std::vector<int64_t> order;  // vertices by frame, the last frame first
    bool complete = true;        // nothing was left out for its cost
    bool overflow = false;

    size_t bytes() const { return vertices.size() * (sizeof(Vertex) + sizeof(int64_t)) + edges.size() * sizeof(Edge); }
};

void find_corridor(const PathProblem& p, const std::vector<double>& price, const Sweep& sweep, double ceiling,
                   size_t max_bytes, Corridor& out) {
    const Steps& steps = p.steps;
    const int64_t n = static_cast<int64_t>(steps.n), n_pairs = static_cast<int64_t>(steps.n_pairs);
    const int64_t n_input = static_cast<int64_t>(p.n_input), longest = steps.longest;
    const int64_t *const length = steps.length.data(), *const rows = steps.row.data();
    out.vertices.clear(), out.edges.clear(), out.order.clear();
    out.complete = true, out.overflow = false;
    // At (frame, step into it): the vertex there, plus one.
    std::vector<int64_t> met(static_cast<size_t>((longest + 1) * n), 0);
    int64_t row = (n_input - 1) % (longest + 1);  // of the frame that is visited, in `met`
    const auto touch = [&](int64_t frame, int64_t back, int64_t step, double go) {
        const double cost = sweep.leaving[(frame - length[step]) * n + step] + go;
        if (!(cost <= ceiling)) {
            out.complete = out.complete && !(cost < kInf);
            return int64_t{-1};
        }
        const int64_t slot = (row - back + (row < back ? longest + 1 : 0)) * n + step;
        int64_t& place = met[slot];
        if (!place) {
            out.vertices.push_back(
                {go, frame, 0, 0, -1, 0, 0, static_cast<int32_t>(slot), static_cast<uint16_t>(step), 0});
            place = static_cast<int64_t>(out.vertices.size());
        }
        Corridor::Vertex& vertex = out.vertices[place - 1];
        vertex.go = std::min(vertex.go, go);
        return place - 1;
    };
    size_t span = p.anchors.size() - 2;
    for (int64_t a = 0; a < steps.up_to(n_input - 1 - p.anchors[span].frame); ++a)
        touch(n_input - 1, 0, a, p.end_cost[a]);
    for (int64_t k = n_input - 1; k >= 1; --k, row = row ? row - 1 : longest) {
        if (k % kLook == 0) look();
        while (k <= p.anchors[span].frame) --span;
        const double* soon = p.scores + std::max<int64_t>(k - kAhead, 0) * n_pairs;
        if (n_pairs <= 256)
            for (int64_t line = 0; line < n_pairs; line += kLine) prefetch(soon + line);
        int64_t* here = met.data() + row * n;
        for (int64_t b = 0; b < n; ++b) {
            if (!here[b]) continue;
            const int64_t id = here[b] - 1;
            here[b] = 0;
            out.order.push_back(id);
            const int64_t j = k - length[b];
            if (j == 0) continue;
            const double ahead = out.vertices[id].go + price[span];
            const int64_t behind = j == p.anchors[span].frame ? p.anchors[span - 1].frame : p.anchors[span].frame;
            const double* f = p.scores + j * n_pairs + b;
            out.vertices[id].first_edge = static_cast<int64_t>(out.edges.size());
            uint16_t n_edges = 0;
            const int64_t end = std::min(steps.before_end[b], steps.up_to(j - behind));
            for (int64_t a = steps.before_first[b]; a < end; ++a) {
                const int64_t from = touch(j, length[b], a, f[rows[a]] + ahead);
                if (from < 0) continue;
                out.edges.push_back({from, f[rows[a]]});
                ++n_edges;
            }
            out.vertices[id].n_edges = n_edges;
        }
        if (out.bytes() > max_bytes) {
            out.overflow = true;
            return;
        }
    }
}

// Positions that frame k may have in the span that enters it, by the steps left and the steps behind.
struct Reachable {
    int64_t low, high;
};

Reachable reachable(const PathProblem& p, size_t span, int64_t k) {
    const Anchor &from = p.anchors[span], &to = p.anchors[span + 1];
    const int64_t to_max = span + 2 == p.anchors.size() ? p.last_position_max : to.position;
    const int64_t shortest = p.steps.shortest, longest = p.steps.longest, behind = k - from.frame, ahead = to.frame - k;
    return {std::max(from.position + (behind + longest - 1) / longest, to.position - ahead / shortest),
            std::min(from.position + behind / shortest, to_max - (ahead + longest - 1) / longest)};
}

struct Pass {
    bool overflow = false, complete = true;
    int64_t labels = 0;
    Path path;
};

template <typename Level>
RETIME_INLINE Pass carry_labels_body(const PathProblem& p, const std::vector<double>& price, Corridor& corridor,
                                     double ceiling, size_t max_bytes) {
    const int64_t n = static_cast<int64_t>(p.n_input);
    const size_t count = p.anchors.size() - 1;
    Pass pass;
    pass.complete = corridor.complete;
    std::vector<double> paid(count + 1, 0.0);
    for (size_t span = 0; span < count; ++span)
        paid[span + 1] =
            paid[span] + price[span] * static_cast<double>(p.anchors[span + 1].position - p.anchors[span].position);

    // Costs of the labels at (frame, step), one a position.
    std::vector<std::vector<double>> costs((static_cast<size_t>(p.steps.longest) + 1) * p.steps.n);
    std::vector<uint8_t> trace;
    size_t span = 0;
    Reachable ok{0, -1};
    int64_t frame = 0;
    double total = kInf;
    int64_t end = -1, position = 0;
    for (size_t at = corridor.order.size(); at-- > 0;) {
        if (static_cast<int64_t>(at) % kLook == 0) look();
        const int64_t id = corridor.order[at];
        Corridor::Vertex& vertex = corridor.vertices[id];
        if (vertex.frame != frame) {
            frame = vertex.frame;
            while (frame > p.anchors[span + 1].frame) ++span;
            ok = reachable(p, span, frame);
        }
        std::vector<double>& cost = costs[vertex.slot];
        vertex.low = 0, vertex.high = -1, vertex.first = 0;
        if (frame == p.steps.length[vertex.step]) {
            // The first step.
            if (ok.low > 1 || ok.high < 1) continue;
            vertex.low = vertex.high = 1;
            cost.assign(1, p.start_cost[vertex.step]);
        } else {
            const Corridor::Edge* edges = corridor.edges.data() + vertex.first_edge;
            int64_t low = std::numeric_limits<int64_t>::max(), high = -1;
            int n_sources = 0, only = 0;
            for (int e = 0; e < vertex.n_edges; ++e) {
                const Corridor::Vertex& from = corridor.vertices[edges[e].from];
                if (from.high < from.low) continue;
                low = std::min(low, from.low + 1), high = std::max(high, from.high + 1);
                ++n_sources, only = e;
            }
            low = std::max(low, ok.low), high = std::min(high, ok.high);
            if (high < low) continue;
            const int64_t size = high - low + 1;
            vertex.low = low, vertex.high = high;
            cost.resize(static_cast<size_t>(size));
            double* const out = cost.data();
            if (n_sources == 1) {
                const Corridor::Vertex& from = corridor.vertices[edges[only].from];
                const double* in = costs[from.slot].data() + from.first + low - 1 - from.low;
                const double score = edges[only].score;
                for (int64_t i = 0; i < size; ++i) out[i] = in[i] + score;
                vertex.trace = -1 - only;
            } else {
                vertex.trace = static_cast<int64_t>(trace.size());
                if (trace.size() + static_cast<size_t>(size) > max_bytes) {
                    pass.overflow = true;
                    return pass;
                }
                trace.resize(trace.size() + static_cast<size_t>(size));
                std::fill(out, out + size, kInf);
                for (int e = 0; e < vertex.n_edges; ++e) {
                    const Corridor::Vertex& from = corridor.vertices[edges[e].from];
                    const int64_t first = std::max(low, from.low + 1), last = std::min(high, from.high + 1);
                    if (last < first) continue;
                    const double* in = costs[from.slot].data() + from.first + first - 1 - from.low;
                    const double score = edges[e].score;
                    double* const joined = out + first - low;
                    uint8_t* const won = trace.data() + vertex.trace + first - low;
                    for (int64_t i = 0; i <= last - first; ++i) {
                        const double total = in[i] + score;
                        if (total < joined[i]) joined[i] = total, won[i] = static_cast<uint8_t>(e);
                    }
                }
            }
        }
        const auto dropped = [&](int64_t q) {
            const double value = cost[q - vertex.low + vertex.first];
            const double all =
                value + (paid[span] + price[span] * static_cast<double>(q - p.anchors[span].position)) + vertex.go;
            if (all <= ceiling) return false;
            pass.complete = pass.complete && !(value < kInf);
            return true;
        };
        while (vertex.high >= vertex.low && dropped(vertex.high)) --vertex.high;
        const int64_t lowest = vertex.low;
        while (vertex.low <= vertex.high && dropped(vertex.low)) ++vertex.low, ++vertex.first;
        if (vertex.trace >= 0) vertex.trace += vertex.low - lowest;
        pass.labels += vertex.high - vertex.low + 1;
        if (frame < n - 1) continue;
        // The cheapest label, then the shorter path, then the smaller last step.
        for (int64_t q = vertex.low; q <= vertex.high; ++q) {
            const double whole = cost[q - vertex.low + vertex.first] + p.end_cost[vertex.step];
            const bool tied = whole == total && end >= 0;
            if (whole < total ||
                (tied && (q < position || (q == position && vertex.step < corridor.vertices[end].step))))
                total = whole, end = id, position = q;
        }
    }
    if (end < 0) return pass;
    pass.path.found = true;
    pass.path.total = total;
    pass.path.frames.assign(static_cast<size_t>(position + 1), 0);
    for (int64_t q = position; q >= 1; --q) {
        const Corridor::Vertex& vertex = corridor.vertices[end];
        pass.path.frames[q] = vertex.frame;
        if (q == 1) break;
        const int64_t edge = vertex.trace < 0 ? -1 - vertex.trace : trace[vertex.trace + q - vertex.low];
        end = corridor.edges[vertex.first_edge + edge].from;
    }
    return pass;
}

RETIME_VERSIONS(Pass, carry_labels,
                (const PathProblem& p, const std::vector<double>& price, Corridor& corridor, double ceiling,
                 size_t max_bytes),
                (p, price, corridor, ceiling, max_bytes))

// Whether all triples within the clip have one score, and all steps at an end one cost: which it is goes to `score`.
bool is_flat(const PathProblem& p, double& score) {
    const Steps& steps = p.steps;
    const auto n = static_cast<int64_t>(steps.n), n_input = static_cast<int64_t>(p.n_input);
    for (int64_t b = 1; b < n; ++b)
        if (p.start_cost[b] != p.start_cost[0] || p.end_cost[b] != p.end_cost[0]) return false;
    bool is_first = true;
    for (int64_t j = 1; j < n_input - 1; ++j) {
        const double* const f = p.scores + j * static_cast<int64_t>(steps.n_pairs);
        const int64_t n_in = steps.up_to(j), n_out = steps.up_to(n_input - 1 - j);
        for (int64_t a = 0; a < n_in; ++a)
            for (int64_t b = steps.first[a]; b < std::min(steps.end[a], n_out); ++b) {
                const double here = f[steps.row[a] + b];
                if (is_first) score = here, is_first = false;
                if (here != score) return false;
            }
    }
    return std::abs(score) < kInf && std::abs(p.start_cost[0]) < kInf && std::abs(p.end_cost[0]) < kInf;
}

// The best path where all of one length cost the same: of those, which have each the steps that they may have, the one
// whose last step is the smallest, then the step before it, and so on. False where it takes a search.
bool flat_path(const PathProblem& p, Path& path) {
    const Steps& steps = p.steps;
    const int64_t shortest = steps.shortest, longest = steps.longest;
    // Any sum of so many steps from the shortest to the longest can be had, whichever came before.
    if (steps.n_pairs != steps.n * steps.n || longest - shortest + 1 != static_cast<int64_t>(steps.n)) return false;
    std::vector<Anchor> anchors = p.anchors;
    const Anchor& before_last = anchors[anchors.size() - 2];
    const int64_t ahead = anchors.back().frame - before_last.frame;
    int64_t& last = anchors.back().position;
    last = std::max(last, before_last.position + (ahead + longest - 1) / longest);
    if (last > p.last_position_max) return false;
    for (size_t span = 0; span + 1 < anchors.size(); ++span) {
        const int64_t n_steps = anchors[span + 1].position - anchors[span].position;
        const int64_t frames = anchors[span + 1].frame - anchors[span].frame;
        if (n_steps < 1 || n_steps * shortest > frames || n_steps * longest < frames) return false;
    }
    double score = 0.0;
    // Of several lengths the shortest is the cheapest, unless a frame more is a gain.
    if (!is_flat(p, score) || (score < 0.0 && last < p.last_position_max)) return false;
    // By the additions of the recurrence.
    double total = p.start_cost[0];
    for (int64_t q = 1; q < last; ++q) total += score;
    total += p.end_cost[0];
    if (!(total < kInf)) return false;
    path.found = true, path.total = total;
    path.frames.assign(static_cast<size_t>(last + 1), 0);
    for (size_t span = anchors.size() - 1; span-- > 0;) {
        const int64_t from = anchors[span].frame;
        int64_t frame = anchors[span + 1].frame;
        for (int64_t q = anchors[span + 1].position; q > anchors[span].position; --q) {
            path.frames[q] = frame;
            const int64_t left = q - anchors[span].position - 1;
            frame -= std::max(shortest, frame - from - left * longest);
        }
    }
    return true;
}

// The sum of the sizes of all terms in a sweep's best path: rounding is a share of it.
double sum_of_sizes(const std::vector<double>& price, const Sweep& sweep) {
    double size = std::abs(sweep.priced);
    for (size_t span = 0; span < price.size(); ++span)
        size += std::abs(sweep.spent[span]) + std::abs(price[span]) * static_cast<double>(sweep.steps[span]);
    return size;
}

}  // namespace

PricedPath priced_path(const PathProblem& p, size_t max_bytes) {
    const size_t count = p.anchors.size() - 1;
    PricedPath result;
    if (flat_path(p, result.path)) {
        result.lower_bound = result.path.total;
        return result;
    }

    // What each span must have, at least and at most; they differ in the last one only, where the length is a range.
    std::vector<int64_t> least(count), most(count);
    for (size_t k = 0; k < count; ++k) least[k] = most[k] = p.anchors[k + 1].position - p.anchors[k].position;
    most.back() = p.last_position_max - p.anchors[count - 1].position;
    const double n_frames = static_cast<double>(std::max<int64_t>(1, p.anchors.back().position));

    constexpr int64_t kLong = 1024;
    std::vector<Bracket> brackets(count);
    std::vector<double> price(count, 0.0), best_price;
    for (size_t k = 0; k < count; ++k) {
        const int64_t from = p.anchors[k].frame, to = p.anchors[k + 1].frame;
        // A range of lengths begins at no price: it may need none.
        if (to - from >= kLong && least[k] == most[k]) guess_price(p, from, to, least[k], brackets[k]);
        price[k] = brackets[k].price;
    }
    Sweep now, best;
    double bound = -kInf;
    int stalled = 0;
    for (int round = 0; round < 60; ++round) {
        const auto begun = std::chrono::steady_clock::now();
        RETIME_CALL(sweep, p, price, now);
        result.sweep_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        ++result.sweeps;
        if (!(now.priced < kInf)) return result;
        double dual = now.priced, loss = 0.0;
        bool exact = true, straddled = true;
        for (size_t k = 0; k < count; ++k) {
            // Of the allowed counts, the one that this price likes best bounds all of them.
            dual -= price[k] * static_cast<double>(price[k] > 0 ? most[k] : least[k]);
            if (!brackets[k].expects())
                brackets[k].expect(
                    std::max(std::abs(now.spent[k]) / static_cast<double>(std::max<int64_t>(1, now.steps[k])), 1e-300),
                    0.0);
            brackets[k].add(now.steps[k], now.spent[k], least[k], most[k]);
            loss += brackets[k].loss();
            exact = exact && brackets[k].exact();
            straddled = straddled && (brackets[k].exact() || brackets[k].straddled());
        }
        // Where the last prices between straddling paths did not raise the bound, it is at its top, or so near that
        // wider gaps cost less than more sweeps.
        stalled = !straddled || dual > bound + 1e-9 * std::abs(bound) ? 0 : stalled + 1;
        if (dual > bound) {
            bound = dual, best_price = price;
            std::swap(now, best);
        }
        if (exact) break;
        const double enough = 2e-3 * std::abs(bound) / n_frames;
        if (loss <= enough || (count == 1 && brackets[0].ceiling() - bound <= enough) || stalled >= 6) break;
        bool moved = false;
        for (size_t k = 0; k < count; ++k) {
            moved = brackets[k].next(round) || moved;
            price[k] = brackets[k].price;
        }
        if (!moved) break;
    }
    double owed = 0.0;
    for (size_t k = 0; k < count; ++k)
        owed += best_price[k] * static_cast<double>(best_price[k] > 0 ? most[k] : least[k]);
    result.lower_bound = bound;

    // Rounding in sums of so many terms; also keeps every path that ties with the best.
    const double size = sum_of_sizes(best_price, best) + std::abs(owed);
    const double slack = 1e-15 * static_cast<double>(p.n_input + 64) * size + 1e-290;
    // What the count costs beyond the bound is a share of one frame's score, and smaller the more frames there are to
    // choose from. Each span adds its own.
    double gap =
        static_cast<double>(2 * count - 1) * std::clamp(50.0 / n_frames, 0.004, 0.03) * std::abs(bound) / n_frames +
        4 * slack;
    Corridor corridor;
    for (;; gap *= 6) {
        ++result.passes;
        find_corridor(p, best_price, best, best.priced + gap, max_bytes, corridor);
        Pass pass;
        if (!corridor.overflow)
            pass = RETIME_CALL(carry_labels, p, best_price, corridor, best.priced + gap,
                               max_bytes - std::min(max_bytes, corridor.bytes()));
        result.labels = pass.labels;
        result.gave_up = corridor.overflow || pass.overflow;
        if (result.gave_up) return result;
        if (pass.path.found && (pass.path.total + slack <= bound + gap || pass.complete)) {
            result.path = std::move(pass.path);
            result.lower_bound = std::min(bound, result.path.total);
            return result;
        }
        // Nothing was left out: there is no path.
        if (pass.complete) return result;
        if (!(gap < 1e3 * size + 1.0)) {
            result.gave_up = true;
            return result;
        }
    }
}

Path free_path(const PathProblem& p) {
    const Steps& q = p.steps;
    const int64_t n = static_cast<int64_t>(q.n), n_pairs = static_cast<int64_t>(q.n_pairs);
    const int64_t n_input = static_cast<int64_t>(p.n_input);
    std::vector<double> leaving(static_cast<size_t>(n_input * n));
    std::vector<int32_t> steps(static_cast<size_t>(n_input * n), 1);
    std::vector<uint8_t> won(static_cast<size_t>(n_input * n));
    std::copy(p.start_cost, p.start_cost + n, leaving.begin());
    Path path;
    path.total = kInf;
    int64_t k = n_input - 1, b = 0;
    int32_t n_steps = 0;
    size_t span = 0;
    for (int64_t j = 1; j < n_input; ++j) {
        if (j % kLook == 0) look(static_cast<size_t>(j), p.n_input);
        while (j > p.anchors[span + 1].frame) ++span;
        const int64_t farthest = q.up_to(j - p.anchors[span].frame);
        if (j == n_input - 1) {
            for (int64_t a = 0; a < farthest; ++a) {
                const double total = leaving[(j - q.length[a]) * n + a] + p.end_cost[a];
                const int32_t taken = steps[(j - q.length[a]) * n + a];
                if (total < path.total || (total == path.total && taken < n_steps))
                    path.total = total, n_steps = taken, b = a;
            }
            break;
        }
        // Of equal costs the fewer steps, then the smaller one before.
        double* best = leaving.data() + j * n;
        int32_t* fewest = steps.data() + j * n;
        uint8_t* from = won.data() + j * n;
        std::fill(best, best + n, kInf);
        for (int64_t a = 0; a < farthest; ++a) {
            const double cost = leaving[(j - q.length[a]) * n + a];
            const int32_t taken = steps[(j - q.length[a]) * n + a] + 1;
            const double* f = p.scores + j * n_pairs + q.row[a];
            for (int64_t c = q.first[a]; c < q.end[a]; ++c) {
                const double total = cost + f[c];
                if (total < best[c] || (total == best[c] && total < kInf && taken < fewest[c]))
                    best[c] = total, fewest[c] = taken, from[c] = static_cast<uint8_t>(a);
            }
        }
    }
    path.found = path.total < kInf;
    if (!path.found) return path;
    path.frames.assign(static_cast<size_t>(n_steps + 1), 0);
    for (int64_t taken = n_steps; taken > 0; --taken) {
        path.frames[taken] = k;
        k -= q.length[b];
        if (k > 0) b = won[k * n + b];
    }
    return path;
}

}  // namespace retime
