#include "turns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "simd.hpp"
#include "threads.hpp"

namespace retime {
namespace {

// A quarter turn in three parts; the first two have 33 bits, so that their products with a whole number of 20 bits are
// exact.
constexpr double kQuarter[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};
constexpr double kQuarters = 0x1.45f306dc9c883p-1;  // in a radian
// A double of 1.5 * 2^52 has no decimals: adding it rounds, and its last bits hold the whole number.
constexpr double kWhole = 6755399441055744.0;
constexpr double kRadians = 3.14159265358979323846 / 180.0;
// The series of sine and cosine, up to what lies below the last bit within an eighth of a turn.
constexpr double kSine[] = {-1.0 / 6,
                            1.0 / 120,
                            -1.0 / 5040,
                            1.0 / 362880,
                            -1.0 / 39916800.0,
                            1.0 / 6227020800.0,
                            -1.0 / 1307674368000.0,
                            1.0 / 355687428096000.0};
constexpr double kCosine[] = {1.0 / 24,
                              -1.0 / 720,
                              1.0 / 40320,
                              -1.0 / 3628800.0,
                              1.0 / 479001600.0,
                              -1.0 / 87178291200.0,
                              1.0 / 20922789888000.0,
                              -1.0 / 6402373705728000.0};

// Angles that are worked on at once; all of them stay in the first cache.
constexpr size_t kSome = 96;

RETIME_INLINE void sines(const double* __restrict half, double* __restrict sine, double* __restrict cosine) {
    for (size_t l = 0; l < kSome; ++l) {
        const double x = half[l], shifted = x * kQuarters + kWhole, k = shifted - kWhole;
        const int64_t quarter = std::bit_cast<int64_t>(shifted);
        // What is left of the angle, and what rounding has left of that.
        const double near = x - k * kQuarter[0], more = k * kQuarter[1], most = near - more;
        const double last = k * kQuarter[2], r = most - last;
        const double rest = ((near - most) - more) + ((most - r) - last);
        const double z = r * r, hz = 0.5 * z;
        double s = kSine[7], c = kCosine[7];
        for (int term = 6; term >= 0; --term) s = s * z + kSine[term], c = c * z + kCosine[term];
        s = r + (r * z * s + (rest - rest * hz));
        const double one = 1.0 - hz;
        c = one + (((1.0 - one) - hz) + (z * z * c - r * rest));
        const bool odd = (quarter & 1) != 0;
        const double from_s = odd ? c : s, from_c = odd ? s : c;
        sine[l] = (quarter & 2) != 0 ? -from_s : from_s;
        cosine[l] = ((quarter + 1) & 2) != 0 ? -from_c : from_c;
    }
}

// Quaternions of halves of angles: (3, kSome) in, four rows of kSome out.
RETIME_INLINE void compose(const double (&half)[3][kSome], const TurnOrder& order, double (&q)[4][kSome]) {
    alignas(64) double s[3][kSome], c[3][kSome];
    for (size_t turn = 0; turn < 3; ++turn) sines(half[turn], s[turn], c[turn]);
    const double sign = order.sign;
    double* __restrict w = q[0];
    double* __restrict x = q[1 + order.axes[0]];
    double* __restrict y = q[1 + order.axes[1]];
    double* __restrict z = q[1 + order.axes[2]];
    for (size_t l = 0; l < kSome; ++l) {
        const double s1 = s[0][l], s2 = s[1][l], s3 = s[2][l], c1 = c[0][l], c2 = c[1][l], c3 = c[2][l];
        w[l] = c1 * c2 * c3 - sign * (s1 * s2 * s3);
        x[l] = s1 * c2 * c3 + sign * (c1 * s2 * s3);
        y[l] = c1 * s2 * c3 - sign * (s1 * c2 * s3);
        z[l] = c1 * c2 * s3 + sign * (s1 * s2 * c3);
    }
}

template <typename Level>
RETIME_INLINE void three_turns_of_body(const double* angles, size_t n, const TurnOrder& order, double* quaternions) {
    alignas(64) double half[3][kSome] = {}, q[4][kSome];
    for (size_t first = 0; first < n; first += kSome) {
        const size_t some = std::min(kSome, n - first);
        for (size_t l = 0; l < some; ++l)
            for (size_t turn = 0; turn < 3; ++turn) half[turn][l] = angles[3 * (first + l) + turn] * 0.5;
        compose(half, order, q);
        for (size_t l = 0; l < some; ++l)
            for (size_t part = 0; part < 4; ++part) quaternions[4 * (first + l) + part] = q[part][l];
    }
}

RETIME_VERSIONS(void, three_turns_of, (const double* angles, size_t n, const TurnOrder& order, double* quaternions),
                (angles, n, order, quaternions))

template <typename Level>
RETIME_INLINE void turn_joints_of_body(const double* rows, size_t n_rows, size_t n_columns, const TurnedJoints& turned,
                                       size_t n_joints, double many, double* angles, double* quaternions) {
    alignas(64) double half[3][kSome] = {}, q[4][kSome];
    double* to[kSome] = {};
    size_t n_waiting = 0;
    const auto turn = [&]() RETIME_LAMBDA_INLINE {
        compose(half, turned.order, q);
        for (size_t l = 0; l < n_waiting; ++l)
            for (size_t part = 0; part < 4; ++part) to[l][part] = q[part][l];
        n_waiting = 0;
    };
    for (size_t row = 0; row < n_rows; ++row) {
        const double* numbers = rows + row * n_columns;
        for (size_t t = 0; t < turned.n; ++t) {
            const size_t joint = row * n_joints + static_cast<size_t>(turned.joints[t]);
            for (size_t axis = 0; axis < 3; ++axis) {
                double degrees = numbers[turned.columns[3 * t + axis]];
                if (std::abs(degrees) > many) degrees = std::fmod(degrees, 360.0);
                const double radians = degrees * kRadians;
                angles[3 * joint + axis] = radians;
                half[axis][n_waiting] = radians * 0.5;
            }
            to[n_waiting++] = quaternions + 4 * joint;
            if (n_waiting == kSome) turn();
        }
    }
    turn();
}

RETIME_VERSIONS(void, turn_joints_of,
                (const double* rows, size_t n_rows, size_t n_columns, const TurnedJoints& turned, size_t n_joints,
                 double many, double* angles, double* quaternions),
                (rows, n_rows, n_columns, turned, n_joints, many, angles, quaternions))

}  // namespace

void three_turns(const double* angles, size_t n, const TurnOrder& order, double* quaternions) {
    RETIME_CALL(three_turns_of, angles, n, order, quaternions);
}

void turn_joints(const double* rows, size_t n_rows, size_t n_columns, const TurnedJoints& turned, size_t n_joints,
                 double many, int n_threads, double* angles, double* quaternions) {
    // Few rows are not worth a thread.
    const int n_parts = static_cast<int>(std::min<size_t>(n_threads < 1 ? 1 : n_threads, n_rows / 256 + 1));
    in_threads(0, n_rows, n_parts, [&](size_t from, size_t to) {
        RETIME_CALL(turn_joints_of, rows + from * n_columns, to - from, n_columns, turned, n_joints, many,
                    angles + 3 * from * n_joints, quaternions + 4 * from * n_joints);
    });
}

}  // namespace retime
