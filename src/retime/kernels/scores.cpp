// Local scores of triples (i, j, k) = (j - a, j, j + b).
//
// joint:  f = mean of the n_neighbors smallest |y^ - z^_l|,  y^ = [y_j, v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))].
//
// The squared distance separates into a term of j, one of k and one of i for each reference frame l, so a candidate costs two
// additions instead of 3 * n_numbers of them. Those terms are in single precision, of a projection, and only choose candidates: half the
// squared distance less half |y^|^2, never more than the true one by more than a bound on their rounding (`slack`, `margin`).
// Invariant: each triple keeps the n_neighbors nearest rows met so far, measured exactly; a row, or a whole block of rows, whose lower
// bound exceeds the largest of these can't be nearer. Distances are summed in a fixed order that every backend shares: pose and movement
// apart, each in 32 running sums that are then halved to one. The pose part belongs to (j, l) alone and is kept for all triples of j.

#include "scores.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>
#include <system_error>
#include <thread>

#include "tiles.hpp"

namespace retime {
namespace {

constexpr size_t kLanes = 32;
// Of terms that cancel to less than this share of their size, too few digits are left.
constexpr double kCancelled = 1e-3;
constexpr double kFar = std::numeric_limits<double>::infinity();
// Input frames of a tile, blocks of the reference that its products hold at once, and blocks whose centres are compared at once.
constexpr size_t kTile = 32;
constexpr size_t kChunk = 16;

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

// `start` and the same, or infinity where that exceeds `most`: sums only grow, rounded ones too, so half of the terms may tell.
RETIME_INLINE double squared_distance(const double* __restrict a, const double* __restrict b, size_t n, double start, double most) {
    alignas(64) double sum[kLanes] = {};
    const size_t half = n / kLanes / 2 * kLanes;
    for (size_t d = 0; d < n; d += kLanes) {
        if (d == half && d > 0 && start + added(sum) > most) return kFar;
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const double difference = a[d + lane] - b[d + lane];
            sum[lane] += difference * difference;
        }
    }
    return start + added(sum);
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

// Runs work(from, to) on parts of [begin, end), one a thread. Throws what one of them threw.
template <typename Work>
void in_threads(size_t begin, size_t end, int n_threads, Work work) {
    const size_t n = end - begin, parts = std::max<size_t>(1, std::min<size_t>(n_threads < 1 ? 1 : n_threads, n));
    std::vector<std::exception_ptr> failed(parts);
    const auto run = [&](size_t part) {
        try {
            work(begin + n * part / parts, begin + n * (part + 1) / parts);
        } catch (...) {
            failed[part] = std::current_exception();
        }
    };
    std::vector<std::thread> pool;
    pool.reserve(parts);
    size_t started = 1;
    try {
        for (; started < parts; ++started) pool.emplace_back(run, started);
    } catch (const std::system_error&) {
        // The system gives no more threads: this one does the rest.
        for (size_t part = started; part < parts; ++part) run(part);
    }
    run(0);
    for (auto& thread : pool) thread.join();
    for (const auto& failure : failed)
        if (failure) std::rethrow_exception(failure);
}

// The movement of a triple, [v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))]; the order of operations is the NumPy backend's.
RETIME_INLINE void movement(const ScoreProblem& p, size_t i, size_t j, size_t k, double* __restrict out) {
    const size_t n = p.n_numbers;
    const double* __restrict yi = p.input + i * n;
    const double* __restrict yj = p.input + j * n;
    const double* __restrict yk = p.input + k * n;
    const double velocity = p.velocity, acceleration = p.acceleration;
    for (size_t d = 0; d < n; ++d) out[d] = (yk[d] - yi[d]) * velocity;
    for (size_t d = 0; d < n; ++d) out[n + d] = ((yk[d] - yj[d]) - (yj[d] - yi[d])) * acceleration;
}

// |y^|^2; n is a multiple of 8.
RETIME_INLINE double squared_feature(const double* __restrict yi, const double* __restrict yj, const double* __restrict yk, double v, double w, size_t n) {
    alignas(64) double sum[8] = {};
    for (size_t d = 0; d < n; d += 8)
        for (size_t lane = 0; lane < 8; ++lane) {
            const double here = yj[d + lane], velocity = (yk[d + lane] - yi[d + lane]) * v;
            const double acceleration = ((yk[d + lane] - here) - (here - yi[d + lane])) * w;
            sum[lane] += here * here + velocity * velocity + acceleration * acceleration;
        }
    return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
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

// The n nearest rows of a query met so far, the nearest first; of rows at one distance the earlier first.
class Nearest {
  public:
    Nearest(size_t n, double* squares, int32_t* rows) : n_(n), squares_(squares), rows_(rows) {}

    void clear() {
        std::fill_n(squares_, n_, kFar);
        std::fill_n(rows_, n_, -1);
    }

    double limit() const { return squares_[n_ - 1]; }

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
        for (; place > 0 && (rows_[place - 1] < 0 || after(place - 1)); --place) squares_[place] = squares_[place - 1], rows_[place] = rows_[place - 1];
        squares_[place] = square, rows_[place] = row;
        return true;
    }

  private:
    size_t n_;
    double* squares_;
    int32_t* rows_;
};

// A unit of rounding for sums of `depth` products of rounded numbers, whatever their order, and a few additions more.
double rounding(size_t depth) { return static_cast<double>(depth + 12) * 0x1p-24 * 1.01; }

// Rows in single precision with a 1 behind them, to meet a column's last number, which stands alone.
std::vector<float> with_one(const double* rows, size_t n_rows, size_t depth) {
    std::vector<float> out(n_rows * (depth + 1));
    for (size_t row = 0; row < n_rows; ++row) {
        for (size_t d = 0; d < depth; ++d) out[row * (depth + 1) + d] = static_cast<float>(rows[row * depth + d]);
        out[row * (depth + 1) + depth] = 1.0f;
    }
    return out;
}

std::vector<double> lengths(const double* rows, size_t n_rows, size_t n) {
    std::vector<double> out(n_rows);
    for (size_t row = 0; row < n_rows; ++row) {
        double sum = 0.0;
        for (size_t d = 0; d < n; ++d) sum += rows[row * n + d] * rows[row * n + d];
        out[row] = std::sqrt(sum);
    }
    return out;
}

// Columns that turn frames into terms of half |y^ - z^|^2 - half |y^|^2 = here(j) - before(i) - after(k), for rows z^ = [z, dz, ddz].
struct Columns {
    size_t n_panels = 0;
    std::vector<float> here, before, after;
    // The longest of each, and the largest half |z^|^2.
    double longest_here = 0, longest_before = 0, longest_after = 0, largest = 0;

    // `less`, one number a row, is taken off. Columns beyond the rows are not numbers.
    Columns(const double* rows, size_t n_rows, size_t depth, double v, double w, const double* less) : n_panels((n_rows + kPanel - 1) / kPanel) {
        const size_t n = depth + 1;
        for (auto* part : {&here, &before, &after}) part->assign(n_panels * n * kPanel, 0.0f);
        for (size_t l = 0; l < n_panels * kPanel; ++l) {
            const size_t at = l / kPanel * n * kPanel + l % kPanel;
            if (l >= n_rows) {
                here[at + depth * kPanel] = std::numeric_limits<float>::quiet_NaN();
                continue;
            }
            const double *z = rows + l * 3 * depth, *dz = z + depth, *ddz = dz + depth;
            double squares = 0.0, h = 0.0, b = 0.0, a = 0.0;
            for (size_t d = 0; d < depth; ++d) {
                const double of_here = z[d] - 2 * w * ddz[d], of_after = v * dz[d] + w * ddz[d], of_before = w * ddz[d] - v * dz[d];
                here[at + d * kPanel] = static_cast<float>(-of_here);
                after[at + d * kPanel] = static_cast<float>(of_after);
                before[at + d * kPanel] = static_cast<float>(of_before);
                h += of_here * of_here, b += of_before * of_before, a += of_after * of_after;
                squares += z[d] * z[d] + dz[d] * dz[d] + ddz[d] * ddz[d];
            }
            here[at + depth * kPanel] = static_cast<float>(0.5 * squares - less[l]);
            longest_here = std::max(longest_here, std::sqrt(h));
            longest_before = std::max(longest_before, std::sqrt(b));
            longest_after = std::max(longest_after, std::sqrt(a));
            largest = std::max(largest, 0.5 * squares + less[l]);
        }
    }
};

// Blocks of kPanel rows as balls.
struct Balls {
    std::vector<double> centres, less;
    std::vector<float> radii;

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
struct Joint {
    const ScoreProblem& p;
    const Projection& low;
    std::vector<double> input, poses, moves, low_input, lengths;
    std::vector<float> rows;
    Columns columns;
    Balls balls;
    Columns centres;

    Joint(const ScoreProblem& problem, const Projection& projection)
        : p(problem),
          low(projection),
          input(pad_rows(p.input, p.n_input, p.n_numbers, 0, p.n_numbers)),
          poses(pad_rows(p.reference, p.n_reference, 3 * p.n_numbers, 0, p.n_numbers)),
          moves(pad_rows(p.reference, p.n_reference, 3 * p.n_numbers, p.n_numbers, 2 * p.n_numbers)),
          low_input(pad_rows(low.input, p.n_input, low.depth, 0, low.depth)),
          lengths(retime::lengths(low.input, p.n_input, low.depth)),
          rows(with_one(low.input, p.n_input, low.depth)),
          columns(low.reference, p.n_reference, low.depth, p.velocity, p.acceleration, std::vector<double>(p.n_reference, 0.0).data()),
          balls(low.reference, low.prune ? p.n_reference : 0, 3 * low.depth),
          centres(balls.centres.data(), balls.less.size(), low.depth, p.velocity, p.acceleration, balls.less.data()) {}
};

// Products of a tile's frames, or of their steps' ends, with panels of columns.
struct TileProducts {
    size_t stride;
    std::vector<float> here, before, after;

    TileProducts(size_t n_rows, size_t reach, size_t n_columns)
        : stride(n_columns), here(n_rows * stride), before((n_rows + reach) * stride), after((n_rows + reach) * stride) {}
};

struct JointLoops {
    void (*products)(const float*, size_t, size_t, const float*, size_t, float*, size_t);
    size_t (*scan)(const Rows&, const float*, const uint32_t*, size_t, Hit*);
    uint64_t (*within)(const float*, const float*, const float*, float);
    void (*near)(const Rows&, const float*, const float*, const float*, uint32_t*);
};

// Work on tiles of input frames, one after another, each with chunks of the reference.
RETIME_INLINE void joint_rows_body(const Joint& q, size_t begin, size_t end, bool each, double* out, JointLoops loops) {
    const ScoreProblem& p = q.p;
    const size_t s = p.max_skip, r = p.n_reference, n = p.n_numbers, count = p.n_neighbors, depth = q.low.depth + 1;
    const size_t wide = padded(n), wide_move = padded(2 * n), wide_low = padded(q.low.depth), n_panels = q.columns.n_panels;
    const double v = p.velocity, w = p.acceleration, scale = q.low.scale, unit = rounding(q.low.depth);
    const size_t n_tile = std::min(end - begin, std::max<size_t>(1, std::min(kTile, (size_t{1} << 17) / (s * s))));
    TileProducts tile(n_tile, s, std::min(kChunk, n_panels) * kPanel);
    TileProducts centre_products(q.low.prune ? n_tile : 0, q.low.prune ? s : 0, q.low.prune ? (q.centres.n_panels + kChunk) * kPanel : 0);
    TileProducts of_centres = centre_products;

    // Of each triple of the tile, and of the frame before the tile: its nearest rows, and what its bounds are made of.
    const size_t n_triples = (n_tile + 1) * s * s;
    std::vector<double> squares(n_triples * count, kFar), base(n_triples), margin(n_triples);
    std::vector<int32_t> nearest_rows(n_triples * count, -1);
    std::vector<float> limits(n_triples), reach(n_triples);
    std::vector<uint16_t> masks(n_triples);
    const auto nearest = [&](size_t t) RETIME_LAMBDA_INLINE { return Nearest(count, squares.data() + t * count, nearest_rows.data() + t * count); };

    // With one chunk and no projection, values alone tell how near is near enough: up to slack they are right.
    const bool by_values = n_panels <= kChunk && q.low.tight;
    std::vector<double> move(wide_move, 0.0), pose_part(r);
    // The frame that a pose part was measured for, and the triple that `move` belongs to.
    std::vector<int64_t> measured_for(r, -1);
    size_t moved = std::numeric_limits<size_t>::max();
    // The squared distance, or one that is farther than `most` where it is farther.
    const auto exact = [&](size_t j, size_t a, size_t b, int32_t row, double most) RETIME_LAMBDA_INLINE {
        const size_t l = static_cast<size_t>(row), triple = (j * s + a - 1) * s + b - 1;
        if (measured_for[l] != static_cast<int64_t>(j)) pose_part[l] = squared_distance(q.input.data() + j * wide, q.poses.data() + l * wide, wide);
        measured_for[l] = static_cast<int64_t>(j);
        if (!q.low.tight && pose_part[l] > most) return kFar;
        if (moved != triple) movement(p, j - a, j, j + b, move.data());
        moved = triple;
        // Where nothing was left out, what was chosen is hardly ever farther.
        if (q.low.tight) return pose_part[l] + squared_distance(move.data(), q.moves.data() + l * wide_move, wide_move);
        return squared_distance(move.data(), q.moves.data() + l * wide_move, wide_move, pose_part[l], most);
    };
    // Lower the limits of triple t to its worst neighbour.
    const auto limit = [&](size_t t) RETIME_LAMBDA_INLINE {
        const double root = std::sqrt(squares[t * count + count - 1]) * scale, half = 0.5 * root * root, least = half - base[t];
        limits[t] = static_cast<float>(least + margin[t] + 1e-12 * half + 2.4e-7 * std::abs(least));
        reach[t] = static_cast<float>(std::min(root, 1e15) * 1.000001);
    };

    // Rows of one chunk that may be among a triple's nearest, with half their squared distance, less half |y^|^2, or less than that.
    struct Found {
        float value;
        int32_t row;
    };
    std::vector<Found> found;
    const auto slack_of = [&](size_t i, size_t j, size_t k) {
        return unit * (q.lengths[j] * q.columns.longest_here + q.lengths[i] * q.columns.longest_before + q.lengths[k] * q.columns.longest_after +
                       q.columns.largest + q.centres.largest) + 1e-30;
    };
    const auto loosened = [](float value, double slack) { return static_cast<float>(value + 2.000001 * slack) + std::abs(value) * 2.4e-7f; };

    // The limit that a triple begins with: how near the neighbours of another one are to it. One frame on, the reference has likely gone on
    // too; or it is as for the smaller first skip.
    const auto begin_triple = [&](size_t j, size_t a, size_t b, size_t t, const Rows& rows, size_t g) RETIME_LAMBDA_INLINE {
        const size_t i = j - a, k = j + b;
        const double slack = slack_of(i, j, k);
        nearest(t).clear();
        margin[t] = slack;
        if (!by_values) {
            base[t] = 0.5 * squared_feature(q.low_input.data() + i * wide_low, q.low_input.data() + j * wide_low, q.low_input.data() + k * wide_low, v,
                                            w, wide_low);
            const double most_v = v * (q.lengths[k] + q.lengths[i]), most_w = w * (q.lengths[k] + 2 * q.lengths[j] + q.lengths[i]);
            margin[t] += 1e-12 * (q.lengths[j] * q.lengths[j] + most_v * most_v + most_w * most_w);
        }
        float least = static_cast<float>(kFar);
        for (const bool on : {true, false}) {
            if (!q.low.following || (on ? j <= a || j == begin : a == 1)) continue;
            const size_t other = on ? t - s * s : t - s;
            float worst = -static_cast<float>(kFar);
            for (size_t m = 0; m < count; ++m) {
                const int32_t row = nearest_rows[other * count + m], guess = on && row >= 0 ? q.low.following[row] : row;
                if (guess < 0)
                    worst = static_cast<float>(kFar);
                else if (by_values)
                    worst = std::max(worst, rows.at(g, static_cast<size_t>(guess)));
                else if (!nearest(t).holds(guess))
                    nearest(t).add(exact(j, a, b, guess, nearest(t).limit()), guess);
            }
            least = std::min(least, worst);
        }
        if (by_values)
            limits[t] = loosened(least, slack);
        else
            limit(t);
    };

    // Measure what was found, the nearest first: the limit comes down early.
    const auto measure = [&](size_t j, size_t a, size_t b, size_t t) RETIME_LAMBDA_INLINE {
        const auto farther = [](const Found& one, const Found& other) { return one.value > other.value; };
        const bool many = found.size() > 16;
        if (many) std::make_heap(found.begin(), found.end(), farther);
        for (size_t m = 0; m < found.size(); ++m) {
            Found next;
            if (many) {
                std::pop_heap(found.begin(), found.end() - static_cast<std::ptrdiff_t>(m), farther);
                next = found[found.size() - 1 - m];
            } else {
                size_t least = m;
                for (size_t other = m + 1; other < found.size(); ++other) least = farther(found[least], found[other]) ? other : least;
                std::swap(found[m], found[least]);
                next = found[m];
            }
            if (next.value > limits[t]) break;
            if (by_values && m + 1 == count) limits[t] = std::min(limits[t], loosened(next.value, margin[t]));
            if (nearest(t).holds(next.row)) continue;
            if (nearest(t).add(exact(j, a, b, next.row, nearest(t).limit()), next.row) && !by_values) limit(t);
        }
    };

    std::vector<Hit> hits(kChunk);
    // The blocks in the order in which a tile meets them.
    std::vector<uint32_t> order(n_panels);
    std::vector<size_t> held((n_panels + kChunk - 1) / kChunk);
    std::vector<float> radii(q.balls.radii), values(q.centres.n_panels * kPanel), behind(values.size());
    for (size_t first = begin; first < end; first += n_tile) {
        const size_t last = std::min(first + n_tile, end);
        // The last frame of the tile before becomes the first of this one's.
        const size_t kept = first == begin ? 0 : n_tile;
        std::copy_n(squares.data() + kept * s * s * count, s * s * count, squares.data());
        std::copy_n(nearest_rows.data() + kept * s * s * count, s * s * count, nearest_rows.data());
        // Frames that the tile's triples begin and end with.
        const size_t before_first = first > s ? first - s : 0, after_last = std::min(last + s, p.n_input), after_first = std::min(first + 1, after_last);
        const auto multiply = [&](const Columns& columns, size_t panel, size_t n_some, TileProducts& to, size_t column) {
            const size_t at = panel * depth * kPanel;
            loops.products(q.rows.data() + first * depth, last - first, depth, columns.here.data() + at, n_some, to.here.data() + column, to.stride);
            loops.products(q.rows.data() + before_first * depth, last - before_first, depth, columns.before.data() + at, n_some,
                           to.before.data() + column, to.stride);
            loops.products(q.rows.data() + after_first * depth, after_last - after_first, depth, columns.after.data() + at, n_some,
                           to.after.data() + column, to.stride);
        };
        const auto rows_of = [&](const TileProducts& of, size_t j, size_t a, size_t b, size_t n_group, size_t column) RETIME_LAMBDA_INLINE {
            Rows rows{of.here.data() + (j - first) * of.stride + column, of.before.data() + (j - a - before_first) * of.stride + column, {}, n_group};
            for (size_t g = 0; g < n_group; ++g) rows.after[g] = of.after.data() + (j + b + g - after_first) * of.stride + column;
            return rows;
        };
        if (q.low.prune) {
            multiply(q.centres, 0, q.centres.n_panels, centre_products, 0);
            // Blocks that are the nearest of some triple come first, then those that come close to that: so limits come down early.
            std::fill(behind.begin(), behind.end(), static_cast<float>(kFar));
            for (size_t j = first; j < last; ++j)
                for (size_t a = 1; a <= s && a <= j; a += 2)
                    for (size_t b = 1; b <= s && j + b < p.n_input; b += 2) {
                        const Rows rows = rows_of(centre_products, j, a, b, 1, 0);
                        const float *__restrict here = rows.here, *__restrict before = rows.before, *__restrict after = rows.after[0];
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
                    }
            std::iota(order.begin(), order.end(), uint32_t{0});
            std::sort(order.begin(), order.end(), [&](uint32_t one, uint32_t other) {
                return behind[one] < behind[other] || (behind[one] == behind[other] && one < other);
            });
            const auto arrange = [&](const std::vector<float>& from, std::vector<float>& to, size_t n_rows) {
                for (size_t row = 0; row < n_rows; ++row)
                    for (size_t place = 0; place < n_panels; ++place)
                        to[row * of_centres.stride + place] = from[row * of_centres.stride + order[place]];
            };
            arrange(centre_products.here, of_centres.here, last - first);
            arrange(centre_products.before, of_centres.before, last - before_first);
            arrange(centre_products.after, of_centres.after, after_last - after_first);
            for (size_t place = 0; place < n_panels; ++place) radii[place] = q.balls.radii[order[place]];
        } else {
            // Chunks that held the neighbours of the frame before come first.
            std::fill(held.begin(), held.end(), 0);
            for (size_t m = 0; m < s * s * count; ++m)
                if (nearest_rows[m] >= 0) ++held[static_cast<size_t>(nearest_rows[m]) / (kChunk * kPanel)];
            std::iota(order.begin(), order.end(), uint32_t{0});
            std::stable_sort(order.begin(), order.end(), [&](uint32_t one, uint32_t other) { return held[one / kChunk] > held[other / kChunk]; });
        }

        for (size_t panel = 0; panel < n_panels; panel += kChunk) {
            const size_t n_blocks = std::min(kChunk, n_panels - panel);
            const bool fresh = panel == 0, pruned = q.low.prune;
            const uint32_t all = (1u << n_blocks) - 1;
            uint32_t needed = pruned && !fresh ? 0 : all;
            const auto near = [&](size_t j, size_t a, size_t b, size_t n_group, size_t t) RETIME_LAMBDA_INLINE {
                uint32_t found[kGroup], any = 0;
                loops.near(rows_of(of_centres, j, a, b, n_group, panel), radii.data() + panel, reach.data() + t, limits.data() + t, found);
                for (size_t g = 0; g < n_group; ++g) any |= found[g];
                masks[t] = static_cast<uint16_t>(any & all);
            };
            if (pruned && !fresh) {
                for (size_t j = first; j < last; ++j)
                    for (size_t a = 1; a <= s && a <= j; ++a)
                        for (size_t b = 1; b <= s && j + b < p.n_input; b += kGroup) {
                            const size_t n_group = std::min({kGroup, s - b + 1, p.n_input - j - b}), t = ((j - first + 1) * s + a - 1) * s + b - 1;
                            near(j, a, b, n_group, t);
                            needed |= masks[t];
                        }
            }
            for (size_t block = 0; block < n_blocks;) {
                // Neighbouring blocks together.
                const size_t from = order[panel + block];
                size_t n_some = 0;
                while (block + n_some < n_blocks && needed >> (block + n_some) & 1 && order[panel + block + n_some] == from + n_some) ++n_some;
                if (n_some) multiply(q.columns, from, n_some, tile, block * kPanel);
                block += std::max<size_t>(n_some, 1);
            }
            for (size_t j = first; j < last; ++j)
                for (size_t a = 1; a <= s && a <= j; ++a)
                    for (size_t b = 1; b <= s && j + b < p.n_input; b += kGroup) {
                        const size_t n_group = std::min({kGroup, s - b + 1, p.n_input - j - b}), t = ((j - first + 1) * s + a - 1) * s + b - 1;
                        const Rows rows = rows_of(tile, j, a, b, n_group, 0);
                        if (fresh) {
                            for (size_t g = 0; g < n_group; ++g) begin_triple(j, a, b + g, t + g, rows, g);
                            if (pruned) near(j, a, b, n_group, t);
                        }
                        uint32_t blocks[kChunk], some = pruned ? masks[t] : needed;
                        size_t n_some = 0;
                        for (; some; some &= some - 1) blocks[n_some++] = static_cast<uint32_t>(__builtin_ctz(some));
                        const size_t n_hits = loops.scan(rows, limits.data() + t, blocks, n_some, hits.data());
                        uint32_t left = 0;
                        for (size_t hit = 0; hit < n_hits; ++hit) left |= hits[hit].group;
                        for (; left; left &= left - 1) {
                            const size_t g = static_cast<size_t>(__builtin_ctz(left));
                            found.clear();
                            for (size_t hit = 0; hit < n_hits; ++hit) {
                                if (!(hits[hit].group >> g & 1)) continue;
                                const size_t column = hits[hit].block * kPanel, row = order[panel + hits[hit].block] * kPanel;
                                uint64_t near = loops.within(rows.here + column, rows.before + column, rows.after[g] + column, limits[t + g]);
                                for (; near; near &= near - 1) {
                                    const size_t lane = static_cast<size_t>(__builtin_ctzll(near));
                                    found.push_back({rows.at(g, column + lane), static_cast<int32_t>(row + lane)});
                                }
                            }
                            measure(j, a, b + g, t + g);
                        }
                    }
        }
        for (size_t j = first; j < last; ++j)
            for (size_t a = 1; a <= s && a <= j; ++a)
                for (size_t b = 1; b <= s && j + b < p.n_input; ++b) {
                    const size_t t = ((j - first + 1) * s + a - 1) * s + b - 1, triple = (j * s + a - 1) * s + b - 1;
                    double sum = 0.0;
                    for (size_t m = 0; m < count; ++m) {
                        const double distance = std::sqrt(squares[t * count + m]);
                        sum += distance;
                        if (each) out[triple * count + m] = distance;
                    }
                    if (!each) out[triple] = sum / static_cast<double>(count);
                }
    }
}

void joint_rows_plain(const Joint& q, size_t begin, size_t end, bool each, double* out) {
    joint_rows_body(q, begin, end, each, out, {products_plain, scan_plain, within_plain, near_plain});
}

#if RETIME_X86
RETIME_AVX2 void joint_rows_avx2(const Joint& q, size_t begin, size_t end, bool each, double* out) {
    joint_rows_body(q, begin, end, each, out, {products_avx2, scan_avx2, within_avx2, near_avx2});
}

RETIME_AVX512 void joint_rows_avx512(const Joint& q, size_t begin, size_t end, bool each, double* out) {
    joint_rows_body(q, begin, end, each, out, {products_avx512, scan_avx512, within_avx512, near_avx512});
}
#endif

// What all threads share in the search for poses.
struct Poses {
    const PoseProblem& p;
    std::vector<double> input, poses, lengths;
    std::vector<float> rows, panels;
    size_t n_panels;
    double longest = 0, largest = 0;

    explicit Poses(const PoseProblem& problem)
        : p(problem),
          input(pad_rows(p.input, p.n_input, p.n_numbers, 0, p.n_numbers)),
          poses(pad_rows(p.poses, p.n_reference, p.n_numbers, 0, p.n_numbers)),
          lengths(retime::lengths(p.low_input, p.n_input, p.n_numbers)),
          rows(with_one(p.low_input, p.n_input, p.n_numbers)),
          n_panels((p.n_reference + kPanel - 1) / kPanel) {
        const size_t n = p.n_numbers;
        panels.assign(n_panels * (n + 1) * kPanel, 0.0f);
        for (size_t l = 0; l < n_panels * kPanel; ++l) {
            float* column = panels.data() + l / kPanel * (n + 1) * kPanel + l % kPanel;
            if (l >= p.n_reference) {
                column[n * kPanel] = std::numeric_limits<float>::quiet_NaN();
                continue;
            }
            double square = 0.0;
            for (size_t d = 0; d < n; ++d) {
                const double number = p.low_poses[l * n + d];
                column[d * kPanel] = static_cast<float>(-number);
                square += number * number;
            }
            column[n * kPanel] = static_cast<float>(0.5 * square);
            longest = std::max(longest, std::sqrt(square));
            largest = std::max(largest, 0.5 * square);
        }
    }
};

RETIME_INLINE void nearest_poses_body(const Poses& q, size_t begin, size_t end, int64_t* out, JointLoops loops) {
    const PoseProblem& p = q.p;
    const size_t n = p.n_numbers, wide = padded(n), count = p.n_neighbors;
    std::vector<float> products(kTile * kChunk * kPanel), limits(kTile);
    const std::vector<float> nothing(kChunk * kPanel, 0.0f);
    std::vector<double> squares(kTile * count);
    std::vector<int32_t> rows(kTile * count, -1), guesses(count, -1);
    const auto nearest = [&](size_t t) { return Nearest(count, squares.data() + t * count, rows.data() + t * count); };
    const auto exact = [&](size_t j, int32_t row) RETIME_LAMBDA_INLINE {
        return squared_distance(q.input.data() + j * wide, q.poses.data() + static_cast<size_t>(row) * wide, wide);
    };
    const auto limit = [&](size_t j, size_t t) {
        const double length = q.lengths[j], root = std::sqrt(squares[t * count + count - 1]) * p.scale * (1 + 1e-12) + p.blur;
        const double least = 0.5 * root * root - 0.5 * length * length;
        limits[t] = static_cast<float>(least + rounding(n) * (length * q.longest + q.largest) + 1e-12 * length * length + 2.4e-7 * std::abs(least) + 1e-30);
    };
    for (size_t first = begin; first < end; first += kTile) {
        const size_t last = std::min(first + kTile, end);
        for (size_t panel = 0; panel < q.n_panels; panel += kChunk) {
            const size_t n_blocks = std::min(kChunk, q.n_panels - panel), stride = kChunk * kPanel;
            loops.products(q.rows.data() + first * (n + 1), last - first, n + 1, q.panels.data() + panel * (n + 1) * kPanel, n_blocks, products.data(),
                           stride);
            for (size_t j = first; j < last; ++j) {
                const size_t t = j - first;
                if (panel == 0) {
                    // One frame on, the reference has likely gone on too.
                    if (j > begin) std::copy_n(rows.data() + (t > 0 ? t - 1 : kTile - 1) * count, count, guesses.data());
                    nearest(t).clear();
                    for (const int32_t row : guesses)
                        if (row >= 0 && row + 1 < static_cast<int32_t>(p.n_reference)) nearest(t).add(exact(j, row + 1), row + 1);
                    limit(j, t);
                }
                for (size_t block = 0; block < n_blocks; ++block) {
                    const float* here = products.data() + t * stride + block * kPanel;
                    uint64_t found = loops.within(here, nothing.data(), nothing.data(), limits[t]);
                    for (; found; found &= found - 1) {
                        const size_t lane = static_cast<size_t>(__builtin_ctzll(found));
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

void nearest_poses_plain(const Poses& q, size_t begin, size_t end, int64_t* out) {
    nearest_poses_body(q, begin, end, out, {products_plain, scan_plain, within_plain, near_plain});
}

#if RETIME_X86
RETIME_AVX2 void nearest_poses_avx2(const Poses& q, size_t begin, size_t end, int64_t* out) {
    nearest_poses_body(q, begin, end, out, {products_avx2, scan_avx2, within_avx2, near_avx2});
}

RETIME_AVX512 void nearest_poses_avx512(const Poses& q, size_t begin, size_t end, int64_t* out) {
    nearest_poses_body(q, begin, end, out, {products_avx512, scan_avx512, within_avx512, near_avx512});
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
RETIME_INLINE void conditional_rows_body(const ScoreProblem& p, const Moves& moves, const int64_t* nearest, size_t begin, size_t end, double* out) {
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

RETIME_VERSIONS(void, conditional_rows,
                (const ScoreProblem& p, const Moves& moves, const int64_t* nearest, size_t begin, size_t end, double* out),
                (p, moves, nearest, begin, end, out))

}  // namespace

void joint_scores(const ScoreProblem& problem, const Projection& projection, int n_threads, bool each, double* out) {
    const Joint shared(problem, projection);
    in_threads(0, problem.n_input, n_threads, [&](size_t from, size_t to) { RETIME_CALL(joint_rows, shared, from, to, each, out); });
}

void nearest_poses(const PoseProblem& problem, int n_threads, int64_t* out) {
    const Poses shared(problem);
    in_threads(0, problem.n_input, n_threads, [&](size_t from, size_t to) { RETIME_CALL(nearest_poses, shared, from, to, out); });
}

void conditional_scores(const ScoreProblem& p, const int64_t* nearest, int n_threads, double* out) {
    const size_t n = p.n_numbers;
    const auto both = pad_rows(p.reference, p.n_reference, 3 * n, n, 2 * n);
    const auto velocity = pad_rows(p.reference, p.n_reference, 3 * n, n, n);
    const auto acceleration = pad_rows(p.reference, p.n_reference, 3 * n, 2 * n, n);
    const Moves moves{both.data(), velocity.data(), acceleration.data()};
    in_threads(0, p.n_input, n_threads, [&](size_t from, size_t to) { RETIME_CALL(conditional_rows, p, moves, nearest, from, to, out); });
}

}  // namespace retime
