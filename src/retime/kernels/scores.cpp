// Local scores of triples (i, j, k) = (j - a, j, j + b).
//
// joint:  f = mean of the n_neighbors smallest |y^ - z^_l|,  y^ = [y_j, v (y_k - y_i), w ((y_k - y_j) - (y_j - y_i))].
//
// The squared distance separates into a term of j, one of k and one of i for each reference frame l, so a candidate costs two
// additions instead of 3 * n_numbers of them. Those terms are single precision and only choose candidates. Invariant: |approximate
// - exact| <= slack for every l, so a frame whose approximate value exceeds the n_neighbors-th smallest by more than 2 * slack
// can't be a neighbour. What is left is measured exactly, in a fixed order of summation that every backend shares.

#include "scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace retime {
namespace {

constexpr size_t kLanes = 8;
constexpr size_t kBlock = 64;

// Eight running sums, then a fixed tree; the NumPy backend adds in the same order.
inline double squared_distance(const double* a, const double* b, size_t n_padded) {
    double sum[kLanes] = {};
    for (size_t d = 0; d < n_padded; d += kLanes)
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const double difference = a[d + lane] - b[d + lane];
            sum[lane] += difference * difference;
        }
    return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

inline size_t padded(size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

// Copy rows of n numbers into rows padded with zeros.
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

struct Candidate {
    float value;
    int32_t row;
};

// Keep every row whose value may belong to the n smallest.
class Nearest {
  public:
    explicit Nearest(size_t n) : n_(n) {}

    void start(float slack) {
        slack2_ = 2 * slack;
        limit_ = std::numeric_limits<float>::infinity();
        found_.clear();
        smallest_.clear();
    }

    float limit() const { return limit_; }

    void add(float value, int32_t row) {
        found_.push_back({value, row});
        if (smallest_.size() == n_ && value >= smallest_.back()) return;
        smallest_.insert(std::upper_bound(smallest_.begin(), smallest_.end(), value), value);
        if (smallest_.size() > n_) smallest_.pop_back();
        // Rounded up, so that single precision can't push a neighbour out.
        if (smallest_.size() == n_)
            limit_ = std::nextafter(smallest_.back() + slack2_, std::numeric_limits<float>::infinity());
    }

    template <typename Visit>
    void each(Visit visit) const {
        for (const auto& candidate : found_)
            if (candidate.value <= limit_) visit(candidate.row);
    }

  private:
    size_t n_;
    float slack2_ = 0, limit_ = 0;
    std::vector<Candidate> found_;
    std::vector<float> smallest_;
};

// Feed the rows with row[l] - other[l] below the limit to `nearest`, which lowers it on the way.
RETIME_WIDE void scan(const float* row, const float* other, size_t n, Nearest& nearest) {
    for (size_t start = 0; start < n; start += kBlock) {
        const size_t stop = std::min(start + kBlock, n);
        const float limit = nearest.limit();
        int hits = 0;
        if (stop - start == kBlock) {
            for (size_t l = 0; l < kBlock; ++l) hits += row[start + l] - other[start + l] <= limit;
        } else {
            for (size_t l = start; l < stop; ++l) hits += row[l] - other[l] <= limit;
        }
        if (hits == 0) continue;
        for (size_t l = start; l < stop; ++l) {
            const float value = row[l] - other[l];
            if (value <= nearest.limit()) nearest.add(value, static_cast<int32_t>(l));
        }
    }
}

RETIME_WIDE void subtract(const float* a, const float* b, size_t n, float* out) {
    for (size_t l = 0; l < n; ++l) out[l] = a[l] - b[l];
}

// y^ of a triple, padded; the order of operations is the NumPy backend's.
RETIME_WIDE void feature(const JointProblem& p, size_t i, size_t j, size_t k, double* out) {
    const size_t n = p.n_numbers;
    const double *yi = p.input + i * n, *yj = p.input + j * n, *yk = p.input + k * n;
    for (size_t d = 0; d < n; ++d) {
        out[d] = yj[d];
        out[n + d] = (yk[d] - yi[d]) * p.velocity;
        out[2 * n + d] = ((yk[d] - yj[d]) - (yj[d] - yi[d])) * p.acceleration;
    }
}

RETIME_WIDE double exact_distance(const double* a, const double* b, size_t n_padded) {
    return std::sqrt(squared_distance(a, b, n_padded));
}

void joint_rows(const JointProblem& p, const Products& products, const double* reference, size_t begin, size_t end, bool each, double* out) {
    const size_t s = p.max_skip, r = p.n_reference, wide = padded(3 * p.n_numbers);
    std::vector<float> row(r);
    std::vector<double> y(wide, 0.0), distances;
    Nearest nearest(p.n_neighbors);
    for (size_t j = begin; j < end; ++j) {
        const size_t jj = j - products.first;
        for (size_t a = 1; a <= s && a <= j; ++a) {
            const size_t ii = jj - a;
            subtract(products.here + jj * r, products.before + ii * r, r, row.data());
            for (size_t b = 1; b <= s && j + b < p.n_input; ++b) {
                const size_t kk = jj + b;
                const double slack = products.reference_slack + products.slack[3 * jj] + products.slack[3 * kk + 1] + products.slack[3 * ii + 2];
                nearest.start(std::nextafter(static_cast<float>(slack), std::numeric_limits<float>::infinity()));
                scan(row.data(), products.after + kk * r, r, nearest);
                feature(p, j - a, j, j + b, y.data());
                distances.clear();
                nearest.each([&](int32_t l) { distances.push_back(exact_distance(y.data(), reference + l * wide, wide)); });
                std::partial_sort(distances.begin(), distances.begin() + p.n_neighbors, distances.end());
                const size_t triple = (j * s + a - 1) * s + b - 1;
                if (each) {
                    std::copy_n(distances.begin(), p.n_neighbors, out + triple * p.n_neighbors);
                    continue;
                }
                double sum = 0.0;
                for (size_t m = 0; m < p.n_neighbors; ++m) sum += distances[m];
                out[triple] = sum / static_cast<double>(p.n_neighbors);
            }
        }
    }
}

}  // namespace

void joint_scores(const JointProblem& p, const Products& products, size_t begin, size_t end, int n_threads, bool each, double* out) {
    const auto reference = pad_rows(p.reference, p.n_reference, 3 * p.n_numbers, 0, 3 * p.n_numbers);
    in_threads(begin, end, n_threads, [&](size_t from, size_t to) { joint_rows(p, products, reference.data(), from, to, each, out); });
}

void conditional_scores(const JointProblem& p, const int64_t* nearest, int n_threads, double* out) {
    const size_t n = p.n_numbers, s = p.max_skip, wide = padded(2 * n);
    const auto reference = pad_rows(p.reference, p.n_reference, 3 * n, n, 2 * n);
    in_threads(0, p.n_input, n_threads, [&](size_t begin, size_t end) {
        std::vector<double> y(3 * n), move(wide, 0.0), distances(p.n_neighbors);
        for (size_t j = begin; j < end; ++j)
            for (size_t a = 1; a <= s && a <= j; ++a)
                for (size_t b = 1; b <= s && j + b < p.n_input; ++b) {
                    feature(p, j - a, j, j + b, y.data());
                    std::copy_n(y.data() + n, 2 * n, move.data());
                    for (size_t m = 0; m < p.n_neighbors; ++m)
                        distances[m] = exact_distance(move.data(), reference.data() + nearest[j * p.n_neighbors + m] * wide, wide);
                    std::sort(distances.begin(), distances.end());
                    double sum = 0.0;
                    for (const double distance : distances) sum += distance;
                    out[(j * s + a - 1) * s + b - 1] = sum / static_cast<double>(p.n_neighbors);
                }
    });
}

}  // namespace retime
