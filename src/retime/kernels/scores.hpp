#pragma once

#include "kernels.hpp"

namespace retime {

// Arrays of the joint score; all row-major.
struct JointProblem {
    const double* input;      // (n_input, n_numbers) poses y
    const double* reference;  // (n_reference, 3 * n_numbers) features [z, dz, ddz], already scaled
    size_t n_input, n_reference, n_numbers;
    size_t max_skip, n_neighbors;
    double velocity, acceleration;  // factors of first and second differences
};

// Reference frames are padded to a multiple of this in the products.
constexpr size_t kProductsPadding = 64;

// Products that find candidates, in single precision, for input frames [first, first + n_rows) of the problem:
//   half |y^ - z^|^2 = half |y^|^2 + here[j, l] - after[k, l] - before[i, l].
struct Products {
    const float* here;
    const float* after;
    const float* before;
    size_t stride;         // from one row of any of them to the next: 3 times n_reference, padded
    const double* slack;  // (n_rows, 3): each frame's share, as here, after, before, of the error bound
    double reference_slack;
    size_t first, n_rows;
};

// For the triples whose middle frame is in [begin, end): the mean distance to the nearest reference features into out (n_input,
// max_skip, max_skip), or with `each` the distances themselves, the smallest first, into out (n_input, max_skip, max_skip, n_neighbors).
void joint_scores(const JointProblem& problem, const Products& products, size_t begin, size_t end, int n_threads, bool each, double* out);

// The n_neighbors rows of `poses` (n_reference, n_numbers) nearest to each input row, the nearest first, ties to the earlier row.
// products: half |z|^2 - y . z in single precision, one row an input frame, `stride` apart; slack bounds its error for each of them.
void nearest_poses(const double* input, const double* poses, size_t n_input, size_t n_reference, size_t n_numbers, size_t n_neighbors,
                   const float* products, size_t stride, const double* slack, int64_t* out);

// The conditional score: for every input frame the n_neighbors rows in `nearest` say how its pose should move.
//   out[j, a, b] = mean over l in nearest[j] of | [dy, ddy] - [dz_l, ddz_l] |.
void conditional_scores(const JointProblem& problem, const int64_t* nearest, int n_threads, double* out);

}  // namespace retime
