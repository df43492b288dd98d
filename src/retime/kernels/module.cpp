// Python's door to the kernels: shapes are checked by the callers in retime.kernels.compiled.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "aligned_path.hpp"
#include "averaged_turns.hpp"
#include "file_bytes.hpp"
#include "freed_memory.hpp"
#include "joint_rows.hpp"
#include "layered_path.hpp"
#include "number_rows.hpp"
#include "poses.hpp"
#include "priced_path.hpp"
#include "scores.hpp"
#include "turns.hpp"
#include "watch.hpp"

#include <cerrno>
#include <exception>
#include <system_error>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const int32_t, nb::c_contig, nb::device::cpu>;
using Integers = nb::ndarray<const int64_t, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using IntegerOutput = nb::ndarray<int64_t, nb::c_contig, nb::device::cpu>;

// The steps in rising order, and for each the range of those that may follow it.
retime::Steps steps_of(const Integers& steps) {
    const int64_t* rows = steps.data();
    const size_t n = steps.shape(1);
    return {rows, rows + n, rows + 2 * n, n};
}

retime::ScoreProblem problem(const Doubles& input, const Doubles& reference, const retime::Steps& steps,
                             double velocity, double acceleration, size_t n_neighbors) {
    return {input.data(), reference.data(), input.shape(0), reference.shape(0), input.shape(1),
            steps,        n_neighbors,      velocity,       acceleration};
}

std::vector<retime::Anchor> anchors_of(const Integers& positions, const Integers& frames) {
    std::vector<retime::Anchor> anchors;
    for (size_t i = 0; i < positions.shape(0); ++i) anchors.push_back({positions.data()[i], frames.data()[i]});
    return anchors;
}

// What Python wants to hear of the work's progress; it raises where the work is not wanted any more. Never freed: a
// thread may still work when Python ends.
nb::object* progress = nullptr;

// Runs work() while other Python threads go on. Ctrl-C, and what `progress` raises, end it and are raised.
template <typename Work>
auto unlocked(Work work) {
    std::exception_ptr raised;
    try {
        const nb::gil_scoped_release without;
        retime::Watch watch([&](double share) {
            const nb::gil_scoped_acquire with;
            try {
                if (PyErr_CheckSignals() != 0) nb::raise_python_error();
                if (progress) (*progress)(share);
                return true;
            } catch (const nb::python_error&) {
                raised = std::current_exception();
                return false;
            }
        });
        return work();
    } catch (const retime::Stopped&) {
    }
    std::rethrow_exception(raised);
}

nb::object to_python(retime::Path&& path) {
    if (!path.found) return nb::none();
    auto* frames = new std::vector<int64_t>(std::move(path.frames));
    nb::capsule owner(frames, [](void* p) noexcept { delete static_cast<std::vector<int64_t>*>(p); });
    return nb::make_tuple(nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>(frames->data(), {frames->size()}, owner),
                          path.total);
}

retime::TurnOrder order_of(const nb::tuple& axes, double sign) {
    return {{nb::cast<size_t>(axes[0]), nb::cast<size_t>(axes[1]), nb::cast<size_t>(axes[2])}, sign};
}

}  // namespace

NB_MODULE(_kernels, m) {
    m.doc() = "Compiled kernels of retime; see retime.kernels.compiled.";

    m.attr("sources") = RETIME_SOURCES;

    m.def("tell", [](nb::object heard) { progress = new nb::object(std::move(heard)); });

    m.def("joint_scores", [](Doubles input, Doubles reference, Integers steps, double velocity, double acceleration,
                             size_t n_neighbors, double scale, int n_threads, bool each, Output out) {
        const auto pairs = steps_of(steps);
        const auto p = problem(input, reference, pairs, velocity, acceleration, n_neighbors);
        unlocked([&] { retime::joint_scores(p, scale, n_threads, each, out.data()); });
    });

    m.def("bounded_scores", [](Doubles input, Doubles reference, Integers steps, double velocity, double acceleration,
                               size_t n_neighbors, Doubles low_input, Doubles low_reference, double scale,
                               Integers order, Rows following, int n_threads, bool each, Output out) {
        const auto pairs = steps_of(steps);
        const auto p = problem(input, reference, pairs, velocity, acceleration, n_neighbors);
        const retime::Projection low{low_input.data(), low_reference.data(), low_input.shape(1), scale,
                                     order.data(),     following.data()};
        unlocked([&] { retime::bounded_scores(p, low, n_threads, each, out.data()); });
    });

    m.def("conditional_scores",
          [](Doubles input, Doubles reference, Integers steps, double velocity, double acceleration, size_t n_neighbors,
             Integers nearest, int n_threads, Output out) {
              const auto pairs = steps_of(steps);
              const auto p = problem(input, reference, pairs, velocity, acceleration, n_neighbors);
              unlocked([&] { retime::conditional_scores(p, nearest.data(), n_threads, out.data()); });
          });

    m.def("nearest_poses", [](Doubles input, Doubles poses, size_t n_neighbors, Doubles origin, double scale,
                              double blur, int n_threads, IntegerOutput out) {
        const retime::PoseProblem p{input.data(),   poses.data(),   origin.data(),
                                    input.shape(0), poses.shape(0), input.shape(1),
                                    n_neighbors,    scale,          blur};
        unlocked([&] { retime::nearest_poses(p, n_threads, out.data()); });
    });

    m.def("layered_path",
          [](Doubles scores, Integers steps, Integers positions, Integers frames, int64_t last_position_max,
             Doubles start_cost, Doubles end_cost, Integers band, size_t memory_limit) {
              const auto pairs = steps_of(steps);
              const auto anchors = anchors_of(positions, frames);
              const retime::PathProblem problem{
                  scores.data(),     scores.shape(0),   pairs,           anchors,
                  last_position_max, start_cost.data(), end_cost.data(), band.size() ? band.data() : nullptr};
              return to_python(unlocked([&] { return retime::layered_path(problem, memory_limit); }));
          });

    m.def("aligned_path", [](Doubles input, Doubles reference, Integers steps, double velocity, double acceleration,
                             Doubles prices, Integers positions, Integers frames, Doubles start_cost, Doubles end_cost,
                             int n_threads, size_t memory_limit, size_t table_limit) {
        const auto pairs = steps_of(steps);
        const auto anchors = anchors_of(positions, frames);
        const auto scores = problem(input, reference, pairs, velocity, acceleration, 1);
        const retime::PathProblem path{prices.data(),           prices.shape(0),   pairs,          anchors,
                                       anchors.back().position, start_cost.data(), end_cost.data()};
        return to_python(
            unlocked([&] { return retime::aligned_path(scores, path, n_threads, memory_limit, table_limit); }));
    });

    m.def("priced_path", [](Doubles scores, Integers steps, Integers positions, Integers frames,
                            int64_t last_position_max, Doubles start_cost, Doubles end_cost, size_t max_bytes) {
        const auto pairs = steps_of(steps);
        const auto anchors = anchors_of(positions, frames);
        const retime::PathProblem problem{scores.data(),     scores.shape(0),   pairs,          anchors,
                                          last_position_max, start_cost.data(), end_cost.data()};
        retime::PricedPath result = unlocked([&] { return retime::priced_path(problem, max_bytes); });
        return nb::make_tuple(to_python(std::move(result.path)), result.lower_bound, result.gave_up, result.labels,
                              result.passes, result.sweeps, result.sweep_seconds);
    });

    m.def("free_path", [](Doubles scores, Integers steps, Integers positions, Integers frames, Doubles start_cost,
                          Doubles end_cost) {
        const auto pairs = steps_of(steps);
        const auto anchors = anchors_of(positions, frames);
        const retime::PathProblem problem{scores.data(),     scores.shape(0), pairs, anchors, 0,
                                          start_cost.data(), end_cost.data()};
        return to_python(unlocked([&] { return retime::free_path(problem); }));
    });

    m.def("read_rows", [](nb::bytes text, size_t n_columns, char delimiter, bool decimal_comma, double largest,
                          size_t line_bytes, int n_threads, Output out) {
        const char* const begin = text.c_str();
        const size_t n_bytes = text.size();
        const retime::RowFormat format{delimiter, decimal_comma, largest, line_bytes};
        const auto read =
            unlocked([&] { return retime::read_rows(begin, n_bytes, n_columns, format, n_threads, out.data()); });
        return nb::make_tuple(read.n_rows, read.n_columns, read.n_bytes);
    });

    m.def("read_joint_rows", [](nb::bytes text, size_t start, size_t piece_bytes, size_t n_columns, bool decimal_comma,
                                double largest, size_t line_bytes, nb::list turned, double many, Integers columns,
                                Integers places, Doubles offsets, int n_threads, Output angles, Output quaternions,
                                Output translations) {
        std::vector<Integers> held;
        retime::JointChannels channels{
            {}, many, columns.data(), places.data(), columns.shape(0), offsets.data(), offsets.shape(0)};
        for (nb::handle each : turned) {
            const auto told = nb::cast<nb::tuple>(each);
            const auto joints = nb::cast<Integers>(told[0]), its_columns = nb::cast<Integers>(told[1]);
            held.push_back(joints), held.push_back(its_columns);
            channels.turned.push_back({joints.data(), its_columns.data(), joints.shape(0),
                                       order_of(nb::cast<nb::tuple>(told[2]), nb::cast<double>(told[3]))});
        }
        const retime::RowFormat format{'\0', decimal_comma, largest, line_bytes};
        const retime::JointArrays out{angles.data(), quaternions.data(), translations.data(), angles.shape(0)};
        const char* const begin = text.c_str() + start;
        const size_t n_bytes = text.size() - start;
        const auto read = unlocked([&] {
            return retime::read_joint_rows(begin, n_bytes, piece_bytes, n_columns, format, channels, out, n_threads);
        });
        return nb::make_tuple(read.n_rows, read.n_bytes);
    });

    m.def("write_rows", [](Doubles rows) {
        const size_t n_rows = rows.shape(0), n_columns = rows.shape(1);
        std::vector<char> text(n_rows * n_columns * retime::kWrittenBytes);
        const size_t n_bytes =
            unlocked([&] { return retime::write_rows(rows.data(), n_rows, n_columns, text.data()); });
        return nb::bytes(text.data(), n_bytes);
    });

    m.def("three_turns", [](Doubles angles, nb::tuple axes, double sign, Output quaternions) {
        const auto order = order_of(axes, sign);
        unlocked([&] { retime::three_turns(angles.data(), angles.shape(0), order, quaternions.data()); });
    });

    m.def("turn_joints", [](Doubles rows, Integers joints, Integers columns, nb::tuple axes, double sign, double many,
                            int n_threads, Output angles, Output quaternions) {
        const retime::TurnedJoints turned{joints.data(), columns.data(), joints.shape(0), order_of(axes, sign)};
        unlocked([&] {
            retime::turn_joints(rows.data(), rows.shape(0), rows.shape(1), turned, angles.shape(1), many, n_threads,
                                angles.data(), quaternions.data());
        });
    });

    m.def("pose_joints", [](Integers parents, Integers site_parents, Doubles site_offsets, Doubles turn,
                            Doubles rotations, Doubles translations, int n_threads, Output positions,
                            Output global_rotations, Output end_positions) {
        const retime::Joints joints{parents.data(),      parents.shape(0),      site_parents.data(),
                                    site_offsets.data(), site_parents.shape(0), turn.size() ? turn.data() : nullptr};
        const retime::Posed out{positions.data(), global_rotations.data(), end_positions.data()};
        unlocked([&] {
            retime::pose_joints(joints, rotations.data(), translations.data(), rotations.shape(0), n_threads, out);
        });
    });

    m.def("average_turns", [](Integers parents, Integers groups, Integers widths, Integers own, Doubles halves,
                              Doubles centres, double closed, double least, Doubles rotations, int n_threads,
                              Output sampled) {
        const retime::AveragedTurns turns{parents.data(), groups.data(), parents.shape(0), widths.data(),    own.data(),
                                          own.shape(0),   halves.data(), centres.data(),   centres.shape(0), closed,
                                          least};
        unlocked(
            [&] { retime::average_turns(turns, rotations.data(), rotations.shape(0), n_threads, sampled.data()); });
    });

    m.def("read_file", [](int file, size_t most, int n_threads) -> nb::object {
        if (!retime::kReadsFiles) return nb::none();
        PyObject* bytes = PyBytes_FromStringAndSize(nullptr, static_cast<Py_ssize_t>(most));
        if (bytes == nullptr) nb::raise_python_error();
        nb::object owner = nb::steal(bytes);
        size_t n_bytes = 0;
        try {
            char* const out = PyBytes_AS_STRING(bytes);
            n_bytes = unlocked([&] { return retime::read_file(file, out, most, n_threads); });
        } catch (const std::system_error& error) {
            errno = error.code().value();
            PyErr_SetFromErrno(PyExc_OSError);
            nb::raise_python_error();
        }
        bytes = owner.release().ptr();
        if (_PyBytes_Resize(&bytes, static_cast<Py_ssize_t>(n_bytes)) != 0) nb::raise_python_error();
        return nb::steal(bytes);
    });

    m.def("keep_freed_memory", [] { retime::keep_freed_memory(); });

    m.def("extent", [](Doubles numbers, int n_threads) {
        const auto found = unlocked([&] { return retime::extent(numbers.data(), numbers.size(), n_threads); });
        return nb::make_tuple(found.least, found.greatest);
    });

    m.def("squared_lengths", [](Doubles quaternions, int n_threads) {
        const auto found =
            unlocked([&] { return retime::squared_lengths(quaternions.data(), quaternions.size() / 4, n_threads); });
        return nb::make_tuple(found.least, found.greatest);
    });
}
