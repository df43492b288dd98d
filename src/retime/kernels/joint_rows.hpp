// From the text of a motion's frames to its joints, without a table of all numbers between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "number_rows.hpp"
#include "turns.hpp"

namespace retime {

// What a row of channels means for joints.
struct JointChannels {
    std::vector<TurnedJoints> turned;
    // Of angles beyond so many degrees whole turns are left out.
    double many;
    // Columns that are coordinates, and where each belongs among the n_joints * 3 of a frame; the others are `offsets`.
    const int64_t* columns;
    const int64_t* places;
    size_t n_places;
    const double* offsets;
    size_t n_joints;
};

// Where they go: angles (capacity, n_joints, 3), radians; quaternions (capacity, n_joints, 4); translations (capacity,
// n_joints, 3).
struct JointArrays {
    double* angles;
    double* quaternions;
    double* translations;
    size_t capacity;
};

// Reads lines of n_columns numbers each (as read_rows) in pieces, which end behind the first line feed after
// `piece_bytes`, on several threads. It ends at the text's end, and before the first piece that does not fit, or where
// there are not as many rows as line feeds: a blank line, one that is no row, line ends of another kind. What stands in
// the arrays behind the rows that it found is anything.
RowsRead read_joint_rows(const char* text, size_t n_bytes, size_t piece_bytes, size_t n_columns,
                         const RowFormat& format, const JointChannels& channels, const JointArrays& out, int n_threads);

}  // namespace retime
