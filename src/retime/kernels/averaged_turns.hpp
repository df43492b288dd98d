// Joints turned, in space, as poses averaged over windows of the input would have them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace retime {

using std::size_t;

// Joints in groups, each with poses of its own: those of a group are turned as its poses have them, whatever those of
// their parents' groups do.
struct AveragedTurns {
    const int64_t* parents;  // (n_joints): each joint's, which stands before it; -1 for none
    const int64_t* groups;   // (n_joints): the group that turns it
    size_t n_joints;
    const int64_t* widths;  // (n_groups, n_joints): which half-widths a joint of a group's poses has; -1: it is not
                            // needed
    const int64_t* own;     // (n_groups): the half-widths that tell where a group turns anything
    size_t n_groups;
    const double* halves;   // (n_halves, n_output): half-widths of windows, in frames; up to `closed` one is closed
    const double* centres;  // (n_output): middles of windows, in frames
    size_t n_output;
    double closed;
    double least;  // of squared lengths: a mean that is shorter is no rotation, and what was sampled stays
};

// Changes what was sampled (n_output, n_joints, 4) by means of rotations (n_frames, n_joints, 4), whose joints turn
// from each frame to the next by less than half a turn.
void average_turns(const AveragedTurns& turns, const double* rotations, size_t n_frames, int n_threads,
                   double* sampled);

}  // namespace retime
