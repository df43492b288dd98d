// The joint score against long references, put in order beforehand so that each block of rows holds frames near one
// another.
//
// Rows and blocks are rejected by lower bounds of their distance, made in fewer numbers: an orthogonal projection only
// makes distances shorter, and no row is nearer than its block's centre less its radius. Invariant: each triple keeps
// the n_neighbors nearest rows met so far, measured exactly; what is farther than the last of these, or than as many
// rows that were guessed, need not be looked at.

#include <numeric>

#include "candidates.hpp"

namespace retime {
namespace {

// |y^|^2; n is a multiple of 8.
RETIME_INLINE double squared_feature(const double* __restrict yi, const double* __restrict yj,
                                     const double* __restrict yk, double v, double w, size_t n) {
    alignas(64) double sum[8] = {};
    for (size_t d = 0; d < n; d += 8)
        for (size_t lane = 0; lane < 8; ++lane) {
            const double here = yj[d + lane], velocity = (yk[d + lane] - yi[d + lane]) * v;
            const double acceleration = ((yk[d + lane] - here) - (here - yi[d + lane])) * w;
            sum[lane] += here * here + velocity * velocity + acceleration * acceleration;
        }
    return eight_halved(sum);
}

// Blocks of kPanel rows as balls.
struct Balls {
    Array<double> centres, less;
    Array<float> radii;

    Balls(const double* rows, size_t n_rows, size_t n) {
        const size_t n_blocks = (n_rows + kPanel - 1) / kPanel;
        centres.assign(n_blocks * n, 0.0);
        less.assign(n_blocks, 0.0);
        radii.assign((n_blocks + kChunk - 1) / kChunk * kChunk, 0.0f);
        for (size_t block = 0; block < n_blocks; ++block) {
            const size_t first = block * kPanel, last = std::min(first + kPanel, n_rows);
            double* centre = centres.data() + block * n;
            for (size_t l = first; l < last; ++l)
                for (size_t d = 0; d < n; ++d) centre[d] += rows[l * n + d];
            for (size_t d = 0; d < n; ++d) centre[d] /= static_cast<double>(last - first);
            double largest = 0.0;
            for (size_t l = first; l < last; ++l) {
                double square = 0.0;
                for (size_t d = 0; d < n; ++d) square += (rows[l * n + d] - centre[d]) * (rows[l * n + d] - centre[d]);
                largest = std::max(largest, square);
            }
            // A little wider than it is: so it stays when rounded.
            const double radius = std::sqrt(largest) * 1.000002 + 1e-18;
            radii[block] = static_cast<float>(radius);
            less[block] = 0.5 * radius * radius;
        }
    }
};

// What all threads share.
struct Bounds {
    const ScoreProblem& p;
    const Projection& projection;
    PaddedRows measured;
    Blank<double> low_input;
    Low low;
    Columns columns;
    Balls balls;
    Columns centres;

    Bounds(const ScoreProblem& problem, const Projection& few)
        : p(problem),
          projection(few),
          measured(problem, few.order),
          low_input(pad_rows(few.input, p.n_input, few.depth, 0, few.depth)),
          low(few.input, p.n_input, few.depth, 1.0),
          columns(few.reference, p.n_reference, few.depth, p.velocity, p.acceleration, 1.0),
          balls(few.reference, p.n_reference, 3 * few.depth),
          centres(balls.centres.data(), balls.less.size(), few.depth, p.velocity, p.acceleration, 1.0,
                  balls.less.data()) {}
};

// Work on tiles of input frames, one after another, each with chunks of the reference.
template <typename Level>
RETIME_INLINE void bounded_rows_body(const Bounds& q, size_t begin, size_t end, bool each, double* out) {
    const ScoreProblem& p = q.p;
    const Steps& steps = p.steps;
    const size_t count = p.n_neighbors, depth = q.projection.depth + 1, wide_low = padded(q.projection.depth),
                 n_panels = q.columns.n_panels;
    const double v = p.velocity, w = p.acceleration, scale = q.projection.scale, unit = rounding(q.projection.depth);
    const size_t n_tile = tile_frames(end - begin, steps, kChunk * kPanel);
    TileProducts tile(n_tile, steps, std::min(kChunk, n_panels) * kPanel);
    TileProducts centre_products(n_tile, steps, (q.centres.n_panels + kChunk) * kPanel);
    TileProducts of_centres = centre_products;

    // Of each group of triples of the tile, and of the frame before the tile: its nearest rows, and what its bounds are
    // made of.
    const size_t frame_groups = steps.n_groups, all_groups = (n_tile + 1) * frame_groups;
    Array<double> squares(all_groups * count * kGroup), base(all_groups * kGroup), margin(base), farthest(base);
    Array<int64_t> ids(squares.size(), -1);
    Array<float> limits(base.size()), reach(base.size());
    Array<uint16_t> masks(all_groups);
    TripleDistances<Level> exact(q.measured, begin, end, true);

    // The rows that a group begins with, each once.
    std::vector<size_t> guesses;
    Array<uint32_t> guessed(p.n_reference, 0);
    uint32_t n_guessed = 0;
    Array<double> of_guesses(count * kGroup);

    // Lower the limits of a group to what is farthest of its nearest.
    const auto limit = [&](size_t group) RETIME_LAMBDA_INLINE {
        for (size_t t = group * kGroup; t < (group + 1) * kGroup; ++t) {
            const double root = std::sqrt(farthest[t]) * scale, half = 0.5 * root * root, least = half - base[t];
            limits[t] = static_cast<float>(least + margin[t] + 1e-12 * half + 2.4e-7 * std::abs(least));
            reach[t] = static_cast<float>(std::min(root, 1e15) * 1.000001);
        }
    };

    // The blocks in the order in which a tile meets them.
    Array<uint32_t> order(n_panels);
    Array<float> least(kGroup * kChunk * 16);
    float total[kGroup * 16] = {}, nth[kGroup];
    uint64_t near_bits[kChunk];

    // One frame on, the reference has likely gone on too; or it is as for the group before; or what lies near in
    // fewer numbers does in all of them.
    const auto begin_group = [&](size_t j, size_t a, size_t b, size_t n_group, size_t group,
                                 const Rows& rows) RETIME_LAMBDA_INLINE {
        guesses.clear();
        ++n_guessed;
        const auto guess = [&](int64_t row) {
            if (row < 0 || guessed[static_cast<size_t>(row)] == n_guessed) return;
            guessed[static_cast<size_t>(row)] = n_guessed;
            guesses.push_back(static_cast<size_t>(row));
        };
        for (size_t m = 0; m < count; ++m)
            for (size_t g = 0; g < n_group; ++g) {
                if (j > static_cast<size_t>(steps.length[a]) && j > begin)
                    if (const int64_t row = ids[((group - frame_groups) * count + m) * kGroup + g]; row >= 0)
                        guess(q.projection.following[row]);
                if (a > 0) guess(ids[((group - 1) * count + m) * kGroup + g]);
            }
        const size_t n_blocks = std::min(kChunk, n_panels);
        minima<Level>(rows, n_blocks, least.data(), total);
        nth_least(total, count, nth);
        for (uint32_t some = nearby<Level>(rows, n_blocks, least.data(), nth, near_bits); some; some &= some - 1) {
            const size_t block = next_bit(some);
            for (uint64_t found = near_bits[block]; found; found &= found - 1)
                guess(static_cast<int64_t>(order[block] * kPanel) + next_bit(found));
        }
        std::fill(of_guesses.begin(), of_guesses.end(), kFar);
        double measured[kGroup];
        for (const size_t row : guesses) {
            exact.squares(a, b, n_group, row, exact.find(row), measured);
            keep_least<Level>(measured, count, of_guesses.data());
        }
        std::fill_n(squares.data() + group * count * kGroup, count * kGroup, kFar);
        std::fill_n(ids.data() + group * count * kGroup, count * kGroup, -1);
        for (size_t g = 0; g < n_group; ++g) {
            const size_t i = j - static_cast<size_t>(steps.length[a]);
            const size_t k = j + static_cast<size_t>(steps.length[b + g]), t = group * kGroup + g;
            base[t] = 0.5 * squared_feature(q.low_input.data() + i * wide_low, q.low_input.data() + j * wide_low,
                                            q.low_input.data() + k * wide_low, v, w, wide_low);
            const double most_v = v * (q.low.lengths[k] + q.low.lengths[i]),
                         most_w = w * (q.low.lengths[k] + 2 * q.low.lengths[j] + q.low.lengths[i]);
            margin[t] =
                1e-12 * (q.low.lengths[j] * q.low.lengths[j] + most_v * most_v + most_w * most_w) + 1e-30 +
                unit * (q.low.lengths[j] * q.columns.longest_here + q.low.lengths[i] * q.columns.longest_before +
                        q.low.lengths[k] * q.columns.longest_after + q.columns.largest + q.centres.largest);
            farthest[t] = of_guesses[(count - 1) * kGroup + g];
        }
        limit(group);
    };

    std::vector<Hit> hits(kChunk);
    // Columns of a chunk that may be near enough, and how far they are over the limits.
    struct Found {
        float over;
        uint32_t column;
    };
    std::vector<Found> found;
    Array<float> radii(q.balls.radii), values(q.centres.n_panels * kPanel), behind(values.size());
    for (size_t first = begin; first < end; first += n_tile) {
        const size_t last = std::min(first + n_tile, end);
        // The last frame of the tile before becomes the first of this one's.
        if (first > begin)
            std::copy_n(ids.data() + n_tile * frame_groups * count * kGroup, frame_groups * count * kGroup, ids.data());
        exact.begin_tile(first, last);
        const auto each_group = [&](auto work) RETIME_LAMBDA_INLINE {
            for (size_t j = first; j < last; ++j) {
                look(j - begin, end - begin);
                exact.begin_frame(j);
                const auto in_place = [&](size_t a, size_t b, size_t n_group, size_t place) RETIME_LAMBDA_INLINE {
                    work(j, a, b, n_group, (j - first + 1) * frame_groups + place);
                };
                steps.each_group(j, p.n_input, in_place);
            }
        };
        centre_products.multiply<Level>(q.low, q.centres, p, depth, first, last, 0, q.centres.n_panels, 0, true);
        // Blocks that are the nearest of some triple come first, then those that come close to that: so limits come
        // down early.
        std::fill(behind.begin(), behind.end(), static_cast<float>(kFar));
        const auto look = [&](const Rows& rows) RETIME_LAMBDA_INLINE {
            const float* __restrict here = rows.here;
            const float* __restrict before = rows.before;
            const float* __restrict after = rows.after[0];
            alignas(64) float some[16];
            std::fill_n(some, 16, static_cast<float>(kFar));
            float* __restrict gap = values.data();
            for (size_t at = 0; at < values.size(); at += 16)
                for (size_t l = 0; l < 16; ++l) {
                    const float value = (here[at + l] - before[at + l]) - after[at + l];
                    gap[at + l] = value;
                    some[l] = value < some[l] ? value : some[l];
                }
            const float least = *std::min_element(some, some + 16);
            float* __restrict nearest_gap = behind.data();
            for (size_t at = 0; at < values.size(); ++at) {
                const float more = gap[at] - least;
                nearest_gap[at] = more < nearest_gap[at] ? more : nearest_gap[at];
            }
        };
        // Every other step tells enough.
        for (size_t j = first; j < last; ++j) {
            retime::look(j - begin, end - begin);
            const int64_t n_in = steps.up_to(static_cast<int64_t>(j));
            const int64_t n_out = steps.up_to(static_cast<int64_t>(p.n_input - 1 - j));
            for (int64_t a = 0; a < n_in; a += 2)
                for (int64_t b = steps.first[a]; b < std::min(steps.end[a], n_out); b += 2)
                    look(centre_products.rows(steps, j, static_cast<size_t>(a), static_cast<size_t>(b), 1, 0));
        }
        std::iota(order.begin(), order.end(), uint32_t{0});
        std::sort(order.begin(), order.end(), [&](uint32_t one, uint32_t other) {
            return behind[one] < behind[other] || (behind[one] == behind[other] && one < other);
        });
        const auto arrange = [&](const FrameProducts& from, FrameProducts& to) {
            to.begin = from.begin, to.end = from.end, to.place = from.place;
            for (size_t frame = from.begin; frame < from.end; ++frame) {
                float* row = to.numbers.data() + to.row(frame) * to.stride;
                for (size_t place = 0; place < n_panels; ++place) row[place] = from.of(frame)[order[place]];
            }
        };
        arrange(centre_products.here, of_centres.here);
        arrange(centre_products.before, of_centres.before);
        arrange(centre_products.after, of_centres.after);
        for (size_t place = 0; place < n_panels; ++place) radii[place] = q.balls.radii[order[place]];

        for (size_t panel = 0; panel < n_panels; panel += kChunk) {
            const size_t n_blocks = std::min(kChunk, n_panels - panel);
            const bool fresh = panel == 0;
            const uint32_t all = (1u << n_blocks) - 1;
            uint32_t needed = fresh ? all : 0;
            const auto near = [&](size_t j, size_t a, size_t b, size_t n_group, size_t group) RETIME_LAMBDA_INLINE {
                uint32_t found[kGroup], any = 0;
                near_blocks<Level>(of_centres.rows(steps, j, a, b, n_group, panel), radii.data() + panel,
                                   reach.data() + group * kGroup, limits.data() + group * kGroup, found);
                for (size_t g = 0; g < n_group; ++g) any |= found[g];
                masks[group] = static_cast<uint16_t>(any & all);
            };
            if (!fresh)
                each_group([&](size_t j, size_t a, size_t b, size_t n_group, size_t group) RETIME_LAMBDA_INLINE {
                    near(j, a, b, n_group, group);
                    needed |= masks[group];
                });
            for (size_t block = 0; block < n_blocks;) {
                // Neighbouring blocks together.
                const size_t from = order[panel + block];
                size_t n_some = 0;
                while (block + n_some < n_blocks && needed >> (block + n_some) & 1 &&
                       order[panel + block + n_some] == from + n_some)
                    ++n_some;
                if (n_some)
                    tile.multiply<Level>(q.low, q.columns, p, depth, first, last, from, n_some, block * kPanel, false);
                block += std::max<size_t>(n_some, 1);
            }
            each_group([&](size_t j, size_t a, size_t b, size_t n_group, size_t group) RETIME_LAMBDA_INLINE {
                const Rows rows = tile.rows(steps, j, a, b, n_group, 0);
                if (fresh) {
                    begin_group(j, a, b, n_group, group, rows);
                    near(j, a, b, n_group, group);
                }
                uint32_t blocks[kChunk];
                size_t n_some = 0;
                for (uint32_t some = masks[group]; some; some &= some - 1)
                    blocks[n_some++] = static_cast<uint32_t>(next_bit(some));
                const size_t n_hits = scan<Level>(rows, limits.data() + group * kGroup, blocks, n_some, hits.data());
                // The nearest first: so limits come down before the others are measured.
                found.clear();
                const auto over = [&](size_t column) RETIME_LAMBDA_INLINE {
                    float least_over = std::numeric_limits<float>::infinity();
                    for (size_t g = 0; g < n_group; ++g)
                        least_over = std::min(least_over, rows.at(g, column) - limits[group * kGroup + g]);
                    return least_over;
                };
                for (size_t hit = 0; hit < n_hits; ++hit) {
                    const size_t column = hits[hit].block * kPanel;
                    uint64_t within = 0;
                    for (uint32_t some = hits[hit].group; some; some &= some - 1) {
                        const size_t g = next_bit(some);
                        within |= retime::within<Level>(rows, g, column, limits[group * kGroup + g]);
                    }
                    for (; within; within &= within - 1) {
                        const size_t at = column + next_bit(within);
                        found.push_back({over(at), static_cast<uint32_t>(at)});
                    }
                }
                if (found.size() > 1)
                    std::sort(found.begin(), found.end(),
                              [](const Found& one, const Found& other) { return one.over < other.over; });
                double *far = farthest.data() + group * kGroup, *nearest = squares.data() + group * count * kGroup;
                bool lower = false;
                for (const Found& next : found) {
                    if (lower && over(next.column) > 0) continue;
                    const size_t row = order[panel + next.column / kPanel] * kPanel + next.column % kPanel,
                                 slot = exact.find(row);
                    if (exact.pose(slot) > *std::max_element(far, far + n_group)) continue;
                    // What one triple needs is measured for its neighbours too: a few instructions for all of them.
                    double measured[kGroup];
                    exact.squares(a, b, n_group, row, slot, measured);
                    keep_least<Level>(measured, count, nearest, static_cast<int64_t>(row),
                                      ids.data() + group * count * kGroup);
                    bool lowered = false;
                    for (size_t g = 0; g < kGroup; ++g) {
                        const double worst = nearest[(count - 1) * kGroup + g];
                        lowered |= worst < far[g];
                        far[g] = worst < far[g] ? worst : far[g];
                    }
                    if (lowered) limit(group);
                    lower |= lowered;
                }
            });
        }
        each_group([&](size_t j, size_t a, size_t b, size_t n_group, size_t group) RETIME_LAMBDA_INLINE {
            write_least(squares.data() + group * count * kGroup, count, n_group, each,
                        out + (j * steps.n_pairs + static_cast<size_t>(steps.row[a]) + b) * (each ? count : 1));
        });
    }
}

RETIME_VERSIONS(void, bounded_rows, (const Bounds& q, size_t begin, size_t end, bool each, double* out),
                (q, begin, end, each, out))

}  // namespace

void bounded_scores(const ScoreProblem& problem, const Projection& projection, int n_threads, bool each, double* out) {
    const Bounds shared(problem, projection);
    in_threads(0, problem.n_input, n_threads,
               [&](size_t from, size_t to) { RETIME_CALL(bounded_rows, shared, from, to, each, out); });
}

}  // namespace retime
