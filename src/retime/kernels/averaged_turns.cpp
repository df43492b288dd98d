#include "averaged_turns.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "threads.hpp"

namespace retime {
namespace {

// Output frames that are worth a thread.
constexpr size_t kWorth = 256;

double dot(const double* a, const double* b) { return ((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) + a[3] * b[3]; }

// a b, in the order of NumPy's sums.
void multiply(const double* a, const double* b, double* out) {
    const double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    const double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    const double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    const double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    out[0] = w, out[1] = x, out[2] = y, out[3] = z;
}

// For each frame and joint whether its quaternion is to be turned over, so that each lies on the side of the one
// before; nothing where none is.
std::vector<char> sides(const double* rotations, size_t n_frames, size_t n_joints) {
    std::vector<char> over;
    for (size_t frame = 1; frame < n_frames; ++frame) {
        const double* here = rotations + 4 * frame * n_joints;
        const double* before = here - 4 * n_joints;
        for (size_t joint = 0; joint < n_joints; ++joint) {
            const bool turns = dot(here + 4 * joint, before + 4 * joint) < 0;
            if (turns && over.empty()) over.resize(n_frames * n_joints);
            if (!over.empty()) {
                const char was = over[(frame - 1) * n_joints + joint];
                over[frame * n_joints + joint] = static_cast<char>(was != static_cast<char>(turns));
            }
        }
    }
    return over;
}

// The frames that a window weighs, and how much: the areas, inside it, of the hats that stand on them.
struct Window {
    size_t first = 0;
    std::vector<double> weights;

    void set(double low, double high, size_t n_frames) {
        first = std::min(static_cast<size_t>(std::max(low, 0.0)), n_frames - 1);
        const size_t last = std::min(static_cast<size_t>(std::ceil(high)), n_frames - 1);
        weights.resize(last - first + 1);
        for (size_t i = 0; i < weights.size(); ++i) {
            const double frame = static_cast<double>(first + i);
            const double a = std::clamp(low - frame, -1.0, 1.0), b = std::clamp(high - frame, -1.0, 1.0);
            // From a to b: 1 + x where x < 0, 1 - x where x > 0. Each side is a width times its middle's height.
            const double left_a = std::min(a, 0.0), left_b = std::min(b, 0.0);
            const double right_a = std::max(a, 0.0), right_b = std::max(b, 0.0);
            double area = (left_b - left_a) * (1.0 + (left_a + left_b) / 2);
            area += (right_b - right_a) * (1.0 - (right_a + right_b) / 2);
            weights[i] = area / (high - low);
        }
    }
};

// Poses of one group at one output frame.
struct Pose {
    std::vector<double> turns;

    const double* of(size_t joint) const { return turns.data() + 4 * joint; }

    // How a joint is turned in space.
    void in_space(size_t joint, const int64_t* parents, double* turn) const {
        std::copy_n(of(joint), 4, turn);
        while (parents[joint] >= 0) {
            joint = static_cast<size_t>(parents[joint]);
            multiply(of(joint), turn, turn);
        }
    }
};

class Averaging {
  public:
    Averaging(const AveragedTurns& turns, const double* rotations, size_t n_frames, const std::vector<char>& over)
        : t_(turns), rotations_(rotations), n_frames_(n_frames), over_(over), poses_(turns.n_groups) {
        for (Pose& pose : poses_) pose.turns.resize(4 * turns.n_joints);
    }

    void frame(size_t frame, double* sampled) {
        bool some = false;
        for (size_t group = 0; group < t_.n_groups; ++group) some = some || half(t_.own[group], frame) > t_.closed;
        if (!some) return;
        for (size_t group = 0; group < t_.n_groups; ++group) pose(group, frame, sampled);
        for (size_t joint = 0; joint < t_.n_joints; ++joint) {
            const auto group = static_cast<size_t>(t_.groups[joint]);
            if (half(t_.own[group], frame) > t_.closed) turn(joint, group, sampled + 4 * joint);
        }
    }

  private:
    double half(int64_t which, size_t frame) const {
        return t_.halves[static_cast<size_t>(which) * t_.n_output + frame];
    }

    void pose(size_t group, size_t frame, const double* sampled) {
        double known = -1.0;
        for (size_t joint = 0; joint < t_.n_joints; ++joint) {
            const int64_t width = t_.widths[group * t_.n_joints + joint];
            if (width < 0) continue;
            double* to = poses_[group].turns.data() + 4 * joint;
            const double wide = half(width, frame);
            if (!(wide > t_.closed)) {
                std::copy_n(sampled + 4 * joint, 4, to);
                continue;
            }
            if (wide != known) {
                window_.set(t_.centres[frame] - wide, t_.centres[frame] + wide, n_frames_);
                known = wide;
            }
            mean(joint, sampled + 4 * joint, to);
        }
    }

    // The mean of neighbouring quaternions, all on one side and scaled to unit length, is their mean rotation. Where
    // they go all the way round and cancel there is none.
    void mean(size_t joint, const double* sampled, double* to) const {
        double sum[4] = {};
        for (size_t i = 0; i < window_.weights.size(); ++i) {
            const size_t at = (window_.first + i) * t_.n_joints + joint;
            const double* q = rotations_ + 4 * at;
            const double weight = !over_.empty() && over_[at] ? -window_.weights[i] : window_.weights[i];
            for (size_t part = 0; part < 4; ++part) sum[part] += q[part] * weight;
        }
        if (dot(sum, sum) < t_.least) std::copy_n(sampled, 4, sum);
        const double length = std::sqrt(dot(sum, sum));
        for (size_t part = 0; part < 4; ++part) to[part] = sum[part] / length;
    }

    // Turns a joint, in space, as its group's pose has it.
    void turn(size_t joint, size_t group, double* to) const {
        std::copy_n(poses_[group].of(joint), 4, to);
        if (t_.parents[joint] < 0) return;
        const auto parent = static_cast<size_t>(t_.parents[joint]);
        const auto above = static_cast<size_t>(t_.groups[parent]);
        if (above == group) return;
        // The parent carries a foot that this joint doesn't, and may be averaged over less.
        double there[4], here[4];
        poses_[above].in_space(parent, t_.parents, there);
        poses_[group].in_space(parent, t_.parents, here);
        for (size_t part = 1; part < 4; ++part) there[part] *= -1.0;
        multiply(there, here, here);
        multiply(here, to, to);
    }

    const AveragedTurns& t_;
    const double* rotations_;
    size_t n_frames_;
    const std::vector<char>& over_;
    std::vector<Pose> poses_;
    Window window_;
};

}  // namespace

void average_turns(const AveragedTurns& turns, const double* rotations, size_t n_frames, int n_threads,
                   double* sampled) {
    const std::vector<char> over = sides(rotations, n_frames, turns.n_joints);
    const size_t most = turns.n_output / kWorth + 1;
    const int n_parts = static_cast<int>(std::min<size_t>(n_threads < 1 ? 1 : n_threads, most));
    in_threads(0, turns.n_output, n_parts, [&](size_t from, size_t to) {
        Averaging averaging(turns, rotations, n_frames, over);
        for (size_t frame = from; frame < to; ++frame) averaging.frame(frame, sampled + 4 * frame * turns.n_joints);
    });
}

}  // namespace retime
