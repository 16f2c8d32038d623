#include "anatomesh/contour/planes/near_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// Planes are near each other up to this share of the gap on either side of them. [1; 0 to 1; M 2026-11 stacks with
// points off their planes, and with holes at heights of their own]
constexpr double near_share_of_gap = 0.4;
// Times the noise of their points, what planes that are one may differ by. [1; >= 1; M 2026-11, the same]
constexpr double noise_reach = 2;
// Read as one slice, structures must differ from slice to slice by less than this share of what they do read as several.
// [1; 0 to 1; M 2026-11, the same, and knobs on a last slice]
constexpr double clear_share = 0.5;
// Contours that differ by a smaller share of the larger area are two slices of one thing. [1; 0 to 1; M 2026-11, the
// same]
constexpr double repeat_share = 0.1;
// Planes of different structures that are nearer are one that a file rounded, to a tenth for some of them.
// [mm; 0 to 0.1; D digits of files]
constexpr double rounded_mm = 0.06;
constexpr int scan_lines = 128;  // Areas are summed along so many lines. [lines; >= 1; B]

using Contours = std::vector<std::uint32_t>;
using Run = std::pair<std::size_t, std::size_t>;  // of clusters: [first, last)

// What speaks for a run's being one slice or several.
struct Reading {
    bool is_within_noise = false;
    bool is_repeated = false;           // a structure has contours on several of its planes
    bool has_repeats = false;           // and on two of them nearly the same one
    bool is_compared = false;           // there are slices beside it
    bool is_beside = true;              // no contours of a structure on two of its planes lie over each other
    double as_one = 0, as_several = 0;  // how much the structures differ from slice to slice
};

class StackReader {
  public:
    StackReader(std::span<const PositionedCluster> stack, std::span<const ContourToPlace> contours,
                Vec3 normal)
        : stack_(stack), contours_(contours), frame_(make_plane({}, normal)) {}

    double span_of(std::size_t first, std::size_t last) const {
        return stack_[last - 1].offset - stack_[first].offset;
    }

    // As many runs as there are places; the longest that is near enough at each.
    std::vector<Run> near_runs(double most_mm) const {
        std::vector<Run> runs;
        for (std::size_t first = 0; first < stack_.size(); ++first) {
            std::size_t last = first + 1;
            for (std::size_t next = first + 1; next < stack_.size(); ++next) {
                if (stack_[next].is_declared || stack_[first].is_declared) break;
                const double spread = span_of(first, next + 1);
                if (spread > std::min(most_mm, near_share_of_gap * gap_before(first))) break;
                if (spread <= near_share_of_gap * gap_before(next + 1)) last = next + 1;
            }
            if (last > first + 1) runs.push_back({first, last});
            first = last - 1;
        }
        return runs;
    }

    // `before` and `after` the run: the clusters of the slices beside it.
    Reading read(Run before, Run run, Run after) const {
        Reading reading;
        double noise = 0;
        for (std::size_t s = run.first; s < run.second; ++s) noise = std::max(noise, stack_[s].noise);
        reading.is_within_noise = span_of(run.first, run.second) <= noise_reach * noise;
        for (const std::uint32_t structure : structures_of(run)) {
            std::vector<Contours> several;
            if (before.first < before.second) add({before.second - 1, before.second}, structure, several);
            const std::size_t beside = several.size();
            for (std::size_t s = run.first; s < run.second; ++s) add({s, s + 1}, structure, several);
            if (several.size() < beside + 2) continue;
            // Not all planes of the run need hold the structure.
            const std::span<const Contours> of_run = std::span(several).subspan(beside);
            reading.is_beside &= are_beside(of_run);
            const bool has_repeats = this->has_repeats(of_run);
            if (after.first < after.second) add({after.first, after.first + 1}, structure, several);
            std::vector<Contours> one;
            add(before, structure, one);
            add(run, structure, one);
            add(after, structure, one);
            reading.is_repeated = true;
            reading.has_repeats |= has_repeats;
            reading.is_compared |= one.size() > 1;
            reading.as_one += has_repeats ? 1 : mean_difference(one);
            reading.as_several += mean_difference(several);
        }
        return reading;
    }

  private:
    double gap_before(std::size_t at) const {
        return at == 0 || at == stack_.size() ? std::numeric_limits<double>::infinity()
                                              : stack_[at].offset - stack_[at - 1].offset;
    }

    std::set<std::uint32_t> structures_of(Run run) const {
        std::set<std::uint32_t> structures;
        for (std::size_t s = run.first; s < run.second; ++s) {
            for (const std::uint32_t c : stack_[s].contours) structures.insert(contours_[c].structure);
        }
        return structures;
    }

    // The structure's contours on these clusters, as one slice; none where it has none.
    void add(Run clusters, std::uint32_t structure, std::vector<Contours>& slices) const {
        Contours slice;
        for (std::size_t s = clusters.first; s < clusters.second; ++s) {
            for (const std::uint32_t c : stack_[s].contours) {
                if (contours_[c].structure == structure) slice.push_back(c);
            }
        }
        if (!slice.empty()) slices.push_back(std::move(slice));
    }

    // Whether the boxes of what the slices hold have nothing in common, seen along the normal.
    bool are_beside(std::span<const Contours> slices) const {
        std::vector<Box2> boxes(slices.size());
        for (std::size_t s = 0; s < slices.size(); ++s)
            for (const std::uint32_t c : slices[s])
                for (const Vec3& p : contours_[c].points) boxes[s].extend(frame_.to_plane(p));
        for (std::size_t s = 0; s < boxes.size(); ++s)
            for (std::size_t t = 0; t < s; ++t)
                if (boxes[s].low.x <= boxes[t].high.x && boxes[t].low.x <= boxes[s].high.x &&
                    boxes[s].low.y <= boxes[t].high.y && boxes[t].low.y <= boxes[s].high.y)
                    return false;
        return true;
    }

    // By the even-odd rule, along lines of equal distance.
    double area_of(const Contours& slice) const {
        Box2 box;
        for (const std::uint32_t c : slice) {
            for (const Vec3& p : contours_[c].points) box.extend(frame_.to_plane(p));
        }
        const double step = (box.high.y - box.low.y) / scan_lines;
        if (!(step > 0)) return 0;
        std::vector<std::vector<double>> crossings(scan_lines);
        for (const std::uint32_t c : slice) {
            const std::span<const Vec3> points = contours_[c].points;
            Vec2 from = frame_.to_plane(points.back());
            for (const Vec3& point : points) {
                const Vec2 to = frame_.to_plane(point);
                add_crossings(from, to, box.low.y, step, crossings);
                from = to;
            }
        }
        double length = 0;
        for (std::vector<double>& line : crossings) {
            std::sort(line.begin(), line.end());
            for (std::size_t i = 0; i + 1 < line.size(); i += 2) length += line[i + 1] - line[i];
        }
        return step * length;
    }

    // Line k lies at low + (k + 1 / 2) step; a segment holds its lower end and not its upper one.
    static void add_crossings(Vec2 from, Vec2 to, double low, double step,
                              std::vector<std::vector<double>>& crossings) {
        if (from.y > to.y) std::swap(from, to);
        const auto line_at = [&](double y) { return std::ceil((y - low) / step - 0.5); };
        const auto first = static_cast<std::size_t>(std::max(line_at(from.y), 0.0));
        const auto last = static_cast<std::size_t>(std::clamp(line_at(to.y), 0.0, double{scan_lines}));
        for (std::size_t k = first; k < last; ++k) {
            const double y = low + (static_cast<double>(k) + 0.5) * step;
            crossings[k].push_back(from.x + (y - from.y) / (to.y - from.y) * (to.x - from.x));
        }
    }

    // Whether a contour of one of several slices is nearly one of another.
    bool has_repeats(std::span<const Contours> several) const {
        struct Sized {
            double area;
            std::size_t slice;
            std::uint32_t contour;
        };
        std::vector<Sized> contours;
        for (std::size_t i = 0; i < several.size(); ++i) {
            for (const std::uint32_t c : several[i]) contours.push_back({area_of({c}), i, c});
        }
        std::stable_sort(contours.begin(), contours.end(),
                         [](const Sized& p, const Sized& q) { return p.area < q.area; });
        for (std::size_t i = 0; i < contours.size(); ++i) {
            const Sized& larger = contours[i];
            for (std::size_t j = i; j-- > 0 && contours[j].area > (1 - repeat_share) * larger.area;) {
                if (contours[j].slice != larger.slice &&
                    area_of({contours[j].contour, larger.contour}) < repeat_share * larger.area)
                    return true;
            }
        }
        return false;
    }

    // Between the slices and their next ones; 0 without one.
    double mean_difference(const std::vector<Contours>& slices) const {
        double sum = 0;
        for (std::size_t i = 0; i + 1 < slices.size(); ++i) {
            // What lies in one of two regions alone is what the even-odd rule makes of both.
            Contours both = slices[i];
            both.insert(both.end(), slices[i + 1].begin(), slices[i + 1].end());
            const double areas = area_of(slices[i]) + area_of(slices[i + 1]);
            sum += areas > 0 ? area_of(both) / areas : 0;
        }
        return slices.size() < 2 ? 0 : sum / static_cast<double>(slices.size() - 1);
    }

    std::span<const PositionedCluster> stack_;
    std::span<const ContourToPlace> contours_;
    Plane frame_;
};

}  // namespace

std::vector<Run> runs_of_one_slice(std::span<const PositionedCluster> stack,
                                   std::span<const ContourToPlace> contours, Vec3 normal, double most_mm,
                                   bool is_whole_set) {
    const StackReader reader(stack, contours, normal);
    const std::vector<Run> near = reader.near_runs(most_mm);
    std::vector<Reading> readings;
    double as_one = 0, as_several = 0;
    bool is_shown_inside = false;
    const auto is_at_end = [&](const Run& run) { return run.first == 0 || run.second == stack.size(); };
    for (std::size_t i = 0; i < near.size(); ++i) {
        const auto [first, last] = near[i];
        Run before{first, first}, after{last, last};
        if (first > 0) before = i > 0 && near[i - 1].second == first ? near[i - 1] : Run{first - 1, first};
        if (last < stack.size())
            after = i + 1 < near.size() && near[i + 1].first == last ? near[i + 1] : Run{last, last + 1};
        readings.push_back(reader.read(before, near[i], after));
        const Reading& reading = readings.back();
        as_one += reading.as_one;
        as_several += reading.as_several;
        is_shown_inside |= !is_at_end(near[i]) && reading.is_repeated && !reading.has_repeats &&
                           reading.is_compared && reading.as_one <= clear_share * reading.as_several;
    }
    const bool all_show_it = as_one <= clear_share * as_several;
    std::vector<Run> runs;
    for (std::size_t i = 0; i < near.size(); ++i) {
        const Reading& reading = readings[i];
        if (!is_whole_set && reading.is_repeated && reading.is_beside && !reading.is_within_noise) continue;
        // The last slice has a neighbour on one side only, and a knob on it looks like its hole: so that one
        // within the stack must show it too.
        const bool is_likelier =
            (reading.is_within_noise || is_shown_inside || !is_at_end(near[i])) &&
            (all_show_it ||
             reading.as_one <= (reading.is_within_noise ? 1 : clear_share) * reading.as_several);
        if (reading.is_repeated
                ? !reading.has_repeats && is_likelier && (reading.is_compared || reading.is_within_noise)
                : reading.is_within_noise || reader.span_of(near[i].first, near[i].second) <= rounded_mm)
            runs.push_back(near[i]);
    }
    return runs;
}

}  // namespace anatomesh
