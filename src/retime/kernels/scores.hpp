#pragma once

#include "kernels.hpp"

namespace retime {

// Arrays of a score; all row-major.
struct ScoreProblem {
    const double* input;      // (n_input, n_numbers) poses y
    const double* reference;  // (n_reference, 3 * n_numbers) features [z, dz, ddz], already scaled
    size_t n_input, n_reference, n_numbers;
    const Steps& steps;
    size_t n_neighbors;
    double velocity, acceleration;  // factors of first and second differences
};

// Mean distances to the nearest reference features into out (n_input, n_pairs), or with `each` the distances
// themselves, the smallest first, into out (n_input, n_pairs, n_neighbors). Triples outside the input are left as they
// are. `scale` times the largest number is at most 1.
void joint_scores(const ScoreProblem& problem, double scale, int n_threads, bool each, double* out);

// The same poses and features in fewer numbers, times `scale`: an orthogonal projection, so that distances here are at
// most those there, times scale; and the reference put in order, so that each 64 rows of it, from the first on, are
// near one another.
struct Projection {
    const double* input;      // (n_input, depth), numbers within [-1, 1]
    const double* reference;  // (n_reference, 3 * depth), in that order
    size_t depth;
    double scale;
    const int64_t* order;      // (n_reference): where these rows stand in the problem's reference
    const int32_t* following;  // (n_reference): the row of the next frame in time, or -1
};

// The same scores; quicker for long inputs and references.
void bounded_scores(const ScoreProblem& problem, const Projection& projection, int n_threads, bool each, double* out);

// The n_neighbors rows of `poses` (n_reference, n_numbers) nearest to each row of `input`, the nearest first, ties to
// the earlier row. Candidates are found about an origin, by numbers times `scale`, then within [-1, 1]; `blur` bounds
// what a distance between such is off by.
struct PoseProblem {
    const double* input;
    const double* poses;
    const double* origin;
    size_t n_input, n_reference, n_numbers, n_neighbors;
    double scale, blur;
};
void nearest_poses(const PoseProblem& problem, int n_threads, int64_t* out);

// The conditional score: for every input frame the n_neighbors rows in `nearest` say how its pose should move.
//   out[j, a, b] = mean over l in nearest[j] of | [dy, ddy] - [dz_l, ddz_l] |.
void conditional_scores(const ScoreProblem& problem, const int64_t* nearest, int n_threads, double* out);

}  // namespace retime
