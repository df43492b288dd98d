#include "poses.hpp"

#include <cmath>
#include <limits>

#include "simd.hpp"
#include "threads.hpp"

namespace retime {
namespace {

// a b, in the order of NumPy's sums (retime.kernels.numpy_backend).
RETIME_INLINE void multiply(const double* a, const double* b, double* out) {
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

// origin + v turned by q.
RETIME_INLINE void transform(const double* q, const double* origin, const double* v, double* out) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
    out[0] = origin[0] + v[0] + w * tx + y * tz - z * ty;
    out[1] = origin[1] + v[1] + w * ty + z * tx - x * tz;
    out[2] = origin[2] + v[2] + w * tz + x * ty - y * tx;
}

// Work on parts of n things, where there are enough of them for several threads.
template <typename Work>
void in_parts(size_t n, size_t worth, int n_threads, Work work) {
    const size_t most = n / worth + 1;
    in_threads(0, n, static_cast<int>(std::min<size_t>(n_threads < 1 ? 1 : n_threads, most)), work);
}

// kLanes running extents; the compiler turns them into vectors.
constexpr size_t kLanes = 32;

struct Lanes {
    alignas(64) double least[kLanes], greatest[kLanes], bad[kLanes];

    Lanes() {
        for (size_t l = 0; l < kLanes; ++l)
            least[l] = std::numeric_limits<double>::infinity(), greatest[l] = -least[l], bad[l] = 0.0;
    }

    RETIME_INLINE void meet(size_t l, double number) {
        least[l] = number < least[l] ? number : least[l];
        greatest[l] = number > greatest[l] ? number : greatest[l];
        // 0, or NaN where the number is not finite.
        bad[l] += number - number;
    }

    void meet(const Extent& other) { meet(0, other.least), meet(0, other.greatest); }

    Extent extent() const {
        Extent all{least[0], greatest[0]};
        bool some_bad = false;
        for (size_t l = 0; l < kLanes; ++l) {
            all.least = std::min(all.least, least[l]), all.greatest = std::max(all.greatest, greatest[l]);
            some_bad = some_bad || bad[l] != 0.0;
        }
        if (some_bad) all.least = all.greatest = std::numeric_limits<double>::quiet_NaN();
        return all;
    }
};

template <typename Level>
RETIME_INLINE Extent extent_of_body(const double* numbers, size_t begin, size_t end) {
    Lanes lanes;
    size_t at = begin;
    for (; at + kLanes <= end; at += kLanes)
        for (size_t l = 0; l < kLanes; ++l) lanes.meet(l, numbers[at + l]);
    for (; at < end; ++at) lanes.meet(0, numbers[at]);
    return lanes.extent();
}
RETIME_VERSIONS(Extent, extent_of, (const double* numbers, size_t begin, size_t end), (numbers, begin, end))

template <typename Level>
RETIME_INLINE Extent lengths_of_body(const double* quaternions, size_t begin, size_t end) {
    Lanes lanes;
    const auto square = [&](size_t at) RETIME_LAMBDA_INLINE {
        const double* q = quaternions + 4 * at;
        return ((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3];
    };
    size_t at = begin;
    for (; at + kLanes <= end; at += kLanes)
        for (size_t l = 0; l < kLanes; ++l) lanes.meet(l, square(at + l));
    for (; at < end; ++at) lanes.meet(0, square(at));
    return lanes.extent();
}
RETIME_VERSIONS(Extent, lengths_of, (const double* quaternions, size_t begin, size_t end), (quaternions, begin, end))

template <typename Work>
Extent extent_in_parts(size_t n, int n_threads, Work work) {
    std::mutex alone;
    Lanes all;
    in_parts(n, size_t{1} << 15, n_threads, [&](size_t from, size_t to) {
        const Extent found = work(from, to);
        const std::lock_guard<std::mutex> locked(alone);
        all.meet(found);
    });
    return all.extent();
}

template <typename Level>
RETIME_INLINE void pose_frames_body(const Joints& joints, const double* rotations, const double* translations,
                                    size_t begin, size_t end, const Posed& out) {
    const size_t n = joints.n_joints, n_sites = joints.n_sites;
    for (size_t frame = begin; frame < end; ++frame) {
        const double* local_q = rotations + 4 * frame * n;
        const double* local_p = translations + 3 * frame * n;
        double* q = out.rotations + 4 * frame * n;
        double* p = out.positions + 3 * frame * n;
        if (joints.turn) {
            multiply(joints.turn, local_q, q);
            p[0] = local_p[0], p[1] = local_p[2], p[2] = local_p[1] * -1.0;
        } else {
            for (size_t part = 0; part < 4; ++part) q[part] = local_q[part];
            for (size_t axis = 0; axis < 3; ++axis) p[axis] = local_p[axis];
        }
        for (size_t joint = 1; joint < n; ++joint) {
            const auto parent = static_cast<size_t>(joints.parents[joint]);
            multiply(q + 4 * parent, local_q + 4 * joint, q + 4 * joint);
            transform(q + 4 * parent, p + 3 * parent, local_p + 3 * joint, p + 3 * joint);
        }
        for (size_t site = 0; site < n_sites; ++site) {
            const auto parent = static_cast<size_t>(joints.site_parents[site]);
            transform(q + 4 * parent, p + 3 * parent, joints.site_offsets + 3 * site,
                      out.end_positions + 3 * (frame * n_sites + site));
        }
    }
}
RETIME_VERSIONS(void, pose_frames,
                (const Joints& joints, const double* rotations, const double* translations, size_t begin, size_t end,
                 const Posed& out),
                (joints, rotations, translations, begin, end, out))

}  // namespace

void pose_joints(const Joints& joints, const double* rotations, const double* translations, size_t n_frames,
                 int n_threads, const Posed& out) {
    in_parts(n_frames, 256, n_threads,
             [&](size_t from, size_t to) { RETIME_CALL(pose_frames, joints, rotations, translations, from, to, out); });
}

Extent extent(const double* numbers, size_t n, int n_threads) {
    return extent_in_parts(n, n_threads,
                           [&](size_t from, size_t to) { return RETIME_CALL(extent_of, numbers, from, to); });
}

Extent squared_lengths(const double* quaternions, size_t n, int n_threads) {
    return extent_in_parts(n, n_threads,
                           [&](size_t from, size_t to) { return RETIME_CALL(lengths_of, quaternions, from, to); });
}

}  // namespace retime
