// Joints placed in space, and what a motion's numbers are checked for.
#pragma once

#include <cstddef>
#include <cstdint>

namespace retime {

using std::size_t;

// A skeleton's joints, each behind its parent, and its end sites.
struct Joints {
    const int64_t* parents;  // (n_joints): that of the first is not looked at
    size_t n_joints;
    const int64_t* site_parents;  // (n_sites)
    const double* site_offsets;   // (n_sites, 3)
    size_t n_sites;
    const double* turn;  // (4): of the space that the first joint stands in, or null
};

// Places (n_frames, n_joints, 3) and rotations (n_frames, n_joints, 4) of the joints in space, and places of the end
// sites (n_frames, n_sites, 3), from local rotations and translations of those shapes. With a `turn`, which is a
// quarter of one about X, Z becomes Y.
struct Posed {
    double* positions;
    double* rotations;
    double* end_positions;
};
void pose_joints(const Joints& joints, const double* rotations, const double* translations, size_t n_frames,
                 int n_threads, const Posed& out);

// The least and the greatest of some numbers; both are NaN where a number is not finite.
struct Extent {
    double least, greatest;
};
Extent extent(const double* numbers, size_t n, int n_threads);

// The same of the squared lengths of quaternions.
Extent squared_lengths(const double* quaternions, size_t n, int n_threads);

}  // namespace retime
