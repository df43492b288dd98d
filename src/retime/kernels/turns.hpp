// Quaternions of turns about coordinate axes, by sines and cosines that are the same bits on every machine.
#pragma once

#include <cstddef>
#include <cstdint>

namespace retime {

using std::size_t;

// The largest angle that may be turned by, radians: its half, in quarter turns, is a number of 20 bits.
constexpr double kLargestTurn = 2e6;

// Three turns about different axes, multiplied in this order; `sign` is 1 where the axes follow each other as X, Y, Z
// do, -1 where they stand the other way round.
struct TurnOrder {
    size_t axes[3];
    double sign;
};

// Turns angles (n, 3), radians up to kLargestTurn, into quaternions (n, 4), wxyz.
void three_turns(const double* angles, size_t n, const TurnOrder& order, double* quaternions);

// Joints whose channels are three turns of one order.
struct TurnedJoints {
    const int64_t* joints;   // (n): which joints
    const int64_t* columns;  // (n, 3): where their channels stand in a row
    size_t n;
    TurnOrder order;
};

// Fills those joints' angles (n_rows, n_joints, 3), radians, and quaternions (n_rows, n_joints, 4) from rows of degrees
// (n_rows, n_columns). Of angles beyond `many` degrees whole turns are left out.
void turn_joints(const double* rows, size_t n_rows, size_t n_columns, const TurnedJoints& turned, size_t n_joints,
                 double many, int n_threads, double* angles, double* quaternions);

}  // namespace retime
