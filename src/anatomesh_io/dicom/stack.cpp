#include "anatomesh_io/dicom/stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

// Unit vectors of images in one stack differ by no more, because files round cosines.
// [1; 0 to 0.1; D digits of files]
constexpr double same_direction = 1e-3;
// Frames whose heights differ by less lie at one place and belong to several volumes.
// [mm; 0 to 0.1; D digits of files]
constexpr double same_place_mm = 1e-3;
// A larger image is unusual for a patient: its unit may be wrong. [mm; > smallest_usual_mm; C W-DCM-012]
constexpr double largest_usual_mm = 2500;
// A smaller image is unusual for a patient: its unit may be wrong. [mm; > 0; C W-DCM-012]
constexpr double smallest_usual_mm = 10;

using Indices = std::vector<std::uint32_t>;

class Stacker {
  public:
    Stacker(const std::vector<DicomFrame>& frames, const std::vector<std::string>& labels,
            const SeriesFacts& facts, const StackOptions& options, RunContext& context)
        : frames_(frames), labels_(labels), facts_(facts), options_(options), context_(context) {}

    Result<Stack> run() {
        std::vector<Indices> volumes;
        const std::vector<Indices> stacks = by_orientation();
        for (const Indices& stack : stacks) add_volumes(stack, volumes);
        ANATOMESH_TRY(const std::size_t chosen, choose(volumes, stacks.size()));
        const Indices& volume = volumes[chosen];
        ANATOMESH_CHECK_STATUS(check_equal(volume));
        if (volume.size() == 1) return single(volume[0]);
        ANATOMESH_TRY(Stack stack, placed(volume));
        check_facts(volume, stack);
        return stack;
    }

  private:
    Vec3 normal(std::uint32_t frame) const { return cross(frames_[frame].row, frames_[frame].column); }
    double height(std::uint32_t frame, Vec3 along) const { return dot(frames_[frame].position, along); }

    Place place(std::uint32_t frame, std::string value = {}) const {
        const DicomFrame& f = frames_[frame];
        return {labels_[f.object],
                f.frame > 0 ? fmt::format("frame {}", f.frame + 1) : "",
                {},
                {},
                std::move(value)};
    }
    Place series_place(std::string value = {}) const { return {facts_.name, {}, {}, {}, std::move(value)}; }

    // Frames of one orientation each, those with most frames first, then in the order of the file list.
    std::vector<Indices> by_orientation() const {
        std::vector<Indices> stacks;
        for (std::uint32_t i = 0; i < frames_.size(); ++i) {
            const auto fits = [&](const Indices& stack) {
                const DicomFrame& a = frames_[stack[0]];
                return length(a.row - frames_[i].row) < same_direction &&
                       length(a.column - frames_[i].column) < same_direction;
            };
            const auto found = std::find_if(stacks.begin(), stacks.end(), fits);
            if (found == stacks.end())
                stacks.push_back({i});
            else
                found->push_back(i);
        }
        // Sorted by something that does not depend on the order of the files.
        std::stable_sort(stacks.begin(), stacks.end(), [&](const Indices& a, const Indices& b) {
            if (a.size() != b.size()) return a.size() > b.size();
            const Vec3 na = normal(a[0]), nb = normal(b[0]);
            return na == nb ? lexicographic_less(frames_[a[0]].row, frames_[b[0]].row)
                            : lexicographic_less(na, nb);
        });
        return stacks;
    }

    // Sorted along the normal; frames at one place stand together, by their marks and numbers.
    Indices sorted(const Indices& stack) const {
        const Vec3 along = normal(*std::min_element(stack.begin(), stack.end(), [&](auto a, auto b) {
            return lexicographic_less(normal(a), normal(b));
        }));
        Indices order = stack;
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            const double ha = height(a, along), hb = height(b, along);
            return ha != hb ? ha < hb : before(a, b);
        });
        // Rounding must not part frames at one place from their order.
        for (std::size_t first = 0; first < order.size();) {
            std::size_t end = first + 1;
            while (end < order.size() &&
                   height(order[end], along) - height(order[first], along) < same_place_mm)
                ++end;
            std::sort(order.begin() + static_cast<std::ptrdiff_t>(first),
                      order.begin() + static_cast<std::ptrdiff_t>(end),
                      [&](auto a, auto b) { return before(a, b); });
            first = end;
        }
        return order;
    }

    bool before(std::uint32_t a, std::uint32_t b) const {
        const DicomFrame &fa = frames_[a], &fb = frames_[b];
        for (std::size_t m = 0; m < DicomFrame::marks; ++m)
            if (fa.mark[m] != fb.mark[m]) return mark_before(fa.mark[m], fb.mark[m]);
        if (fa.number != fb.number) return fa.number < fb.number;
        if (fa.object != fb.object) return labels_[fa.object] < labels_[fb.object];
        return fa.frame < fb.frame;
    }
    static bool mark_before(const std::string& a, const std::string& b) {
        const auto na = parse_number(a), nb = parse_number(b);
        return na && nb ? *na < *nb : a < b;
    }

    // The volumes of a stack: one frame of every place each. When the places differ in how many frames they
    // have, the frames are parted by the first mark that tells all frames of a place apart.
    void add_volumes(const Indices& stack, std::vector<Indices>& volumes) const {
        const Indices order = sorted(stack);
        const Vec3 along = normal(order[0]);
        std::vector<Indices> places;
        for (const std::uint32_t i : order) {
            if (places.empty() || height(i, along) - height(places.back()[0], along) >= same_place_mm)
                places.emplace_back();
            places.back().push_back(i);
        }
        const bool is_even = std::all_of(places.begin(), places.end(),
                                         [&](const Indices& p) { return p.size() == places[0].size(); });
        if (is_even) {
            for (std::size_t v = 0; v < places[0].size(); ++v) {
                volumes.emplace_back();
                for (const Indices& p : places) volumes.back().push_back(p[v]);
            }
            return;
        }
        for (std::size_t m = 0; m < DicomFrame::marks; ++m) {
            if (!tells_apart(places, m)) continue;
            std::map<std::pair<double, std::string>, Indices> of_mark;
            for (const std::uint32_t i : order) {
                const std::string& mark = frames_[i].mark[m];
                of_mark[{parse_number(mark).value_or(0), mark}].push_back(i);
            }
            for (auto& [mark, indices] : of_mark) volumes.push_back(std::move(indices));
            return;
        }
        // Nothing tells them apart: the first, second, ... frame of each place.
        std::size_t most = 0;
        for (const Indices& p : places) most = std::max(most, p.size());
        for (std::size_t v = 0; v < most; ++v) {
            volumes.emplace_back();
            for (const Indices& p : places)
                if (v < p.size()) volumes.back().push_back(p[v]);
        }
    }
    bool tells_apart(const std::vector<Indices>& places, std::size_t m) const {
        for (const Indices& p : places)
            for (std::size_t a = 0; a < p.size(); ++a)
                for (std::size_t b = 0; b < a; ++b)
                    if (frames_[p[a]].mark[m] == frames_[p[b]].mark[m]) return false;
        return true;
    }

    Result<std::size_t> choose(const std::vector<Indices>& volumes, std::size_t stacks) const {
        if (options_.volume) {
            if (*options_.volume < volumes.size()) return static_cast<std::size_t>(*options_.volume);
            return error("E-DCM-015",
                         fmt::format("the series has no volume of this number; it holds {}", volumes.size()),
                         series_place(std::to_string(*options_.volume)),
                         fmt::format("choose one with --volume N, 0 to {}", volumes.size() - 1));
        }
        if (volumes.size() == 1) return std::size_t{0};
        std::string list;
        for (std::size_t v = 0; v < std::min<std::size_t>(volumes.size(), 12); ++v)
            list +=
                fmt::format("{}{}: {} slices{}", v ? "; " : "", v, volumes[v].size(), what_marks(volumes, v));
        if (volumes.size() > 12) list += fmt::format("; ... {}", volumes.size() - 1);
        const std::string next = fmt::format("choose one with --volume N: {}", list);
        if (stacks > 1)
            return error("E-DCM-012", fmt::format("the slices have {} different orientations", stacks),
                         place(volumes.back()[0]), next);
        return error("E-DCM-013",
                     fmt::format("the series holds {} volumes at the same positions", volumes.size()),
                     series_place(), next);
    }
    // How a volume differs from the others, for the list.
    std::string what_marks(const std::vector<Indices>& volumes, std::size_t v) const {
        for (std::size_t m = 0; m < DicomFrame::marks; ++m) {
            const std::string& mark = frames_[volumes[v][0]].mark[m];
            const bool differs = std::any_of(volumes.begin(), volumes.end(), [&](const Indices& other) {
                return frames_[other[0]].mark[m] != mark;
            });
            if (differs) return fmt::format(" with {} {}", mark_name(m), mark.empty() ? "absent" : mark);
        }
        return "";
    }

    Status check_equal(const Indices& volume) const {
        const DicomFrame& first = frames_[volume[0]];
        for (const std::uint32_t i : volume) {
            const DicomFrame& frame = frames_[i];
            const bool same_size = frame.columns == first.columns && frame.rows == first.rows;
            const bool same_spacing =
                std::abs(frame.spacing[0] - first.spacing[0]) <= 1e-4 * first.spacing[0] &&
                std::abs(frame.spacing[1] - first.spacing[1]) <= 1e-4 * first.spacing[1];
            if (same_size && same_spacing) continue;
            return error("E-DCM-011", "the slices differ in size or pixel spacing",
                         place(i, fmt::format("{} x {} pixels of {} x {} mm, other slices {} x {} of {} x {}",
                                              frame.columns, frame.rows, frame.spacing[0], frame.spacing[1],
                                              first.columns, first.rows, first.spacing[0], first.spacing[1])),
                         "give slices of one size");
        }
        return Nothing{};
    }

    ImageGeometry geometry_of(std::uint32_t frame, std::size_t slices, Vec3 step) const {
        const DicomFrame& f = frames_[frame];
        return {{f.columns, f.rows, static_cast<std::uint32_t>(slices)},
                f.position,
                {f.spacing[0] * f.row, f.spacing[1] * f.column, step}};
    }

    Result<Stack> single(std::uint32_t frame) {
        const auto thickness = facts_.spacing_between_slices && *facts_.spacing_between_slices > 0
                                   ? facts_.spacing_between_slices
                                   : facts_.slice_thickness;
        if (!thickness || !(*thickness > 1e-6) || !(*thickness < 1e4))
            return error("E-DCM-016", "the series has a single slice and does not state its thickness",
                         place(frame), "give the whole series");
        context_.warn({"W-DCM-013", "the series has a single slice", place(frame),
                       fmt::format("its stated thickness of {} mm was used", *thickness)});
        Stack stack;
        stack.geometry = geometry_of(frame, 1, *thickness * normal(frame));
        stack.slices.push_back({frame, frame, 0});
        return stack;
    }

    Result<Stack> placed(const Indices& volume) {
        const std::uint32_t first = volume.front(), last = volume.back();
        const auto count = static_cast<double>(volume.size() - 1);
        const Vec3 span = frames_[last].position - frames_[first].position;
        const Vec3 step = (1 / count) * span;
        const Vec3 along = normal(first);
        const double spacing = dot(step, along);
        if (!(length(step - spacing * along) <= 3 * spacing))  // steeper than any gantry tilts
            return error("E-DCM-014", "the slices are displaced within their planes, not along their normal",
                         series_place(), "correct the files, or export them again");
        double worst = 0;
        std::uint32_t worst_frame = first;
        for (std::size_t k = 0; k < volume.size(); ++k) {
            const Vec3 expected = frames_[first].position + static_cast<double>(k) * step;
            const double off = length(frames_[volume[k]].position - expected) / spacing;
            if (off > worst) {
                worst = off;
                worst_frame = volume[k];
            }
        }
        if (worst > options_.even) return uneven(volume, spacing);
        if (worst > options_.exact)
            context_.warn({"W-DCM-009", "the slices are not exactly equidistant",
                           place(worst_frame, fmt::format("off by {:.3g} mm", worst * spacing)),
                           fmt::format("they were placed {:.6g} mm apart", spacing)});
        Stack stack;
        stack.geometry = geometry_of(first, volume.size(), step);
        for (const std::uint32_t i : volume) stack.slices.push_back({i, i, 0});
        return stack;
    }

    std::string gaps_text(const Indices& volume, double usual) const {
        const Vec3 along = normal(volume[0]);
        std::string text;
        int listed = 0;
        for (std::size_t k = 1; k < volume.size() && listed < 4; ++k) {
            const double a = height(volume[k - 1], along), b = height(volume[k], along);
            if (std::abs(b - a - usual) <= options_.even * usual) continue;
            text += fmt::format("{}{:.6g} mm from {:.6g} to {:.6g}", listed ? ", " : "", b - a, a, b);
            ++listed;
        }
        return text;
    }

    // Slices missing, or not equidistant: interpolated onto equidistant ones where that was asked for.
    Result<Stack> uneven(const Indices& volume, double mean) {
        const Vec3 along = normal(volume[0]);
        std::vector<double> at, gaps;
        for (const std::uint32_t i : volume) at.push_back(height(i, along) - height(volume[0], along));
        for (std::size_t k = 1; k < at.size(); ++k) gaps.push_back(at[k] - at[k - 1]);
        std::sort(gaps.begin(), gaps.end());
        const double usual = gaps[gaps.size() / 2];
        ANATOMESH_CHECK_STATUS(check_above_each_other(volume, at));
        if (!options_.allow_gaps)
            return error(
                "E-DCM-014", "slices are missing or not equidistant",
                series_place(fmt::format("usually {:.6g} mm apart: {}", usual, gaps_text(volume, usual))),
                "give the missing slices, or interpolate them linearly with --allow-gaps");
        // Where every gap is a multiple of the usual one, all slices stay where they are.
        const bool are_multiples = std::all_of(gaps.begin(), gaps.end(), [&](double gap) {
            return std::abs(gap / usual - std::round(gap / usual)) < options_.even && gap > usual / 2;
        });
        const double target = are_multiples ? usual : gaps.front();
        if (!(target > 1e-3 * mean))
            return error("E-DCM-014", "two slices have nearly the same position", series_place(),
                         "correct the files");
        const auto count = static_cast<std::size_t>(std::llround(at.back() / target)) + 1;
        const double even = at.back() / static_cast<double>(count - 1);
        const Vec3 span = frames_[volume.back()].position - frames_[volume.front()].position;
        Stack stack;
        stack.is_uneven = true;
        stack.geometry = geometry_of(volume[0], count, (1 / static_cast<double>(count - 1)) * span);
        std::size_t below = 0, between = 0;
        for (std::size_t k = 0; k < count; ++k) {
            const double z = static_cast<double>(k) * even;
            while (below + 1 < at.size() && at[below + 1] <= z + options_.even * even) ++below;
            const double past = z - at[below];
            if (std::abs(past) <= options_.even * even || below + 1 == at.size()) {
                stack.slices.push_back({volume[below], volume[below], 0});
                continue;
            }
            ++between;
            stack.slices.push_back({volume[below], volume[below + 1], past / (at[below + 1] - at[below])});
        }
        context_.warn(
            {"W-DCM-014", "slices are missing or not equidistant",
             series_place(fmt::format("usually {:.6g} mm apart: {}", usual, gaps_text(volume, usual))),
             fmt::format("{} slices were interpolated, {:.6g} mm apart", between, even)});
        return stack;
    }

    // All positions lie on the line from the first to the last.
    Status check_above_each_other(const Indices& volume, const std::vector<double>& at) const {
        const Vec3 first = frames_[volume.front()].position, last = frames_[volume.back()].position;
        for (std::size_t k = 0; k < volume.size(); ++k) {
            const Vec3 expected = first + (at[k] / at.back()) * (last - first);
            const double off = length(frames_[volume[k]].position - expected);
            const DicomFrame& frame = frames_[volume[k]];
            if (off <= 0.05 * std::min(frame.spacing[0], frame.spacing[1])) continue;
            return error("E-DCM-014", "the slices are displaced within their planes",
                         place(volume[k], fmt::format("{:.3g} mm aside", off)),
                         "give slices of one acquisition");
        }
        return Nothing{};
    }

    void check_facts(const Indices& volume, const Stack& stack) {
        const Vec3 along = normal(volume[0]);
        const Vec3 step = stack.geometry.step[2];
        const double spacing = dot(step, along);
        if (const auto stated = facts_.spacing_between_slices;
            stated && !stack.is_uneven && std::abs(*stated - spacing) > 0.01 * spacing)
            context_.warn({"W-DCM-010",
                           "SpacingBetweenSlices differs from the distance between the positions",
                           series_place(fmt::format("{:.6g} mm, positions {:.6g} mm", *stated, spacing)),
                           "the positions were used"});
        const double shear =
            std::atan2(length(step - spacing * along), spacing) * 180 / 3.14159265358979323846;
        if (const auto tilt = facts_.gantry_tilt; tilt && std::abs(*tilt) > 0.5 && shear < 0.1)
            context_.warn({"W-DCM-011", "the file states a gantry tilt, but the positions show none",
                           series_place(fmt::format("{:.3g} degrees", *tilt)), "the positions were used"});
        double extent = 0;
        for (int axis = 0; axis < 3; ++axis)
            extent = std::max(extent, length(stack.geometry.step[axis]) * stack.geometry.size[axis]);
        if (extent > largest_usual_mm || extent < smallest_usual_mm)
            context_.warn({"W-DCM-012", "the size of the image is unusual for a patient",
                           series_place(fmt::format("{:.4g} mm", extent)),
                           "the numbers were kept; check the unit"});
        if (const auto stated = facts_.images_in_acquisition;
            stated && *stated > static_cast<double>(volume.size()) && *stated < 1e6)
            context_.warn({"W-DCM-015", "the series states more slices than there are",
                           series_place(fmt::format("{} of {:.0f}", volume.size(), *stated)),
                           "the slices that are there were read"});
        check_numbers(volume);
    }

    void check_numbers(const Indices& volume) {
        bool rises = true, falls = true;
        for (std::size_t k = 1; k < volume.size(); ++k) {
            const auto a = frames_[volume[k - 1]].number, b = frames_[volume[k]].number;
            rises = rises && a <= b;
            falls = falls && a >= b;
        }
        if (rises || falls) return;
        context_.warn({"W-DCM-008", "the InstanceNumbers are not in the order of the positions",
                       series_place(), "the positions were used"});
    }

    static Error error(const char* code, std::string message, Place place, std::string next_step) {
        return {ErrorKind::input, code, std::move(message), std::move(place), std::move(next_step)};
    }

    const std::vector<DicomFrame>& frames_;
    const std::vector<std::string>& labels_;
    const SeriesFacts& facts_;
    const StackOptions& options_;
    RunContext& context_;
};

}  // namespace

Result<Stack> stack_frames(const std::vector<DicomFrame>& frames, const std::vector<std::string>& labels,
                           const SeriesFacts& facts, const StackOptions& options, RunContext& context) {
    return Stacker(frames, labels, facts, options, context).run();
}

}  // namespace anatomesh
