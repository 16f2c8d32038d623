#include "anatomesh_io/provenance/routed_contour_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/improve/reroute/routed_contours.h"
#include "anatomesh/improve/reroute/snap_round_segments.h"
#include "anatomesh_io/provenance/model_description.h"

namespace anatomesh {

namespace {

constexpr const char *contour_key = "followed_contour", *point_key = "followed_point";
// A file that does not say how far contours may leave their places is believed up to this.
// [mm; > 0; D as ModelOptions::max_reroute_mm]
constexpr double widest_mm = 1000;
// Distances in a file are rounded by no more. [mm; 0 to 0.1; D digits of files]
constexpr double rounded_mm = 0.01;

// The next word of the text as a number, which is taken off it.
template <class Number>
std::optional<Number> take(std::string_view& text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    Number value{};
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{}) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

struct Note {
    std::uint32_t contour = 0;  // by number, as drawn
    std::uint64_t segments = 0;
    std::vector<Vec3> drawn, on_surface;
};

// A note as it is read: the points that are still to come are counted.
struct Reading {
    Note note;
    std::size_t drawn = 0, on_surface = 0;

    bool is_whole() const {
        return drawn >= 3 && on_surface >= 3 && note.drawn.size() == drawn &&
               note.on_surface.size() == on_surface;
    }
    bool add(Vec3 p) {
        if (note.on_surface.size() == on_surface) return false;
        (note.drawn.size() < drawn ? note.drawn : note.on_surface).push_back(p);
        return true;
    }
};

std::optional<Reading> begin_note(std::string_view text) {
    const auto number = take<std::uint32_t>(text), segments = take<std::uint32_t>(text),
               before = take<std::uint32_t>(text), now = take<std::uint32_t>(text);
    if (!number || !segments || !before || !now || !text.empty()) return std::nullopt;
    return Reading{{*number, *segments, {}, {}}, *before, *now};
}

std::optional<Vec3> point_of(std::string_view text) {
    const auto x = take<double>(text), y = take<double>(text), z = take<double>(text);
    if (!x || !y || !z || !text.empty() || !std::isfinite(*x + *y + *z)) return std::nullopt;
    return Vec3{*x, *y, *z};
}

std::optional<std::vector<Note>> notes_of(const MeshDescription& description) {
    std::vector<Note> notes;
    std::optional<Reading> reading;
    const auto end_note = [&] {
        if (!reading) return true;
        if (!reading->is_whole() || (!notes.empty() && notes.back().contour >= reading->note.contour))
            return false;
        notes.push_back(std::move(reading->note));
        reading.reset();
        return true;
    };
    for (const auto& [name, text] : description.notes) {
        if (name == contour_key) {
            if (!end_note()) return std::nullopt;
            reading = begin_note(text);
            if (!reading) return std::nullopt;
        } else if (name == point_key) {
            const std::optional<Vec3> p = point_of(text);
            if (!p || !reading || !reading->add(*p)) return std::nullopt;
        }
    }
    if (!end_note()) return std::nullopt;
    return notes;
}

using Ring = std::vector<Vec3>;

// From its smallest point on, as kept contours begin.
Ring turned(Ring ring) {
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), less), ring.end());
    return ring;
}

// The contours of a set by their points.
class RingFinder {
  public:
    explicit RingFinder(const ContourSet& contours) : contours_(contours) {
        for (std::uint32_t c = 0; c < contours.contours.size(); ++c)
            by_start_[key(contours.points_of(contours.contours[c]).front())].push_back(c);
    }

    // The number of that with these points, from whichever on.
    std::optional<std::uint32_t> find(const Ring& points) const {
        const Ring ring = turned(points);
        const auto found = by_start_.find(key(ring.front()));
        if (found == by_start_.end()) return std::nullopt;
        for (const std::uint32_t c : found->second) {
            if (std::ranges::equal(contours_.points_of(contours_.contours[c]), ring)) return c;
        }
        return std::nullopt;
    }

  private:
    static std::array<double, 3> key(Vec3 p) { return {p.x, p.y, p.z}; }

    const ContourSet& contours_;
    std::map<std::array<double, 3>, std::vector<std::uint32_t>> by_start_;  // by their first points
};

// With other rings in the place of some. `by_contour`: number and ring, rising.
ContourSet with_rings(const ContourSet& contours, const std::map<std::uint32_t, const Ring*>& by_contour) {
    std::vector<RoutedContour> routed;
    std::vector<Vec3> points;
    for (const auto& [contour, ring] : by_contour) {
        RoutedContour& one = routed.emplace_back(RoutedContour{contour, {}, 0, 0});
        for (const Vec3 p : *ring) {
            one.vertices.push_back(static_cast<std::uint32_t>(points.size()));
            points.push_back(p);
        }
    }
    const std::vector<std::uint32_t> vertex_of(contours.points.size(), 0);
    return route_contours(contours, vertex_of, routed, points).contours;
}

// Of contours as they are drawn.
std::vector<RoutedContourReport> reports_of(const ContourSet& drawn, const std::vector<Note>& notes) {
    std::vector<RoutedContour> routed;
    std::vector<Vec3> points = drawn.points;
    std::vector<std::uint32_t> vertex_of(drawn.points.size());
    std::iota(vertex_of.begin(), vertex_of.end(), 0u);
    for (const Note& note : notes) {
        const Contour& contour = drawn.contours[note.contour];
        RoutedContour& one = routed.emplace_back(RoutedContour{note.contour, {}, note.segments, 0});
        for (const Vec3 p : note.on_surface) {
            const std::span<const Vec3> was = drawn.points_of(contour);
            const auto at = std::find(was.begin(), was.end(), p);
            one.vertices.push_back(
                static_cast<std::uint32_t>(at != was.end() ? contour.first_point + (at - was.begin())
                                                           : static_cast<std::ptrdiff_t>(points.size())));
            if (at == was.end()) points.push_back(p);
        }
    }
    return routed_contour_reports(drawn, vertex_of, routed, points);
}

// Whether the contours of a slice are what those of kept sets are.
bool is_sound(const ContourSet& contours, const Slice& slice) {
    return slice_faults(plane_rings(contours, slice), contours.exclusive).empty();
}

// A file may say anything: contours that no model can have re-routed there are nothing.
std::optional<BothContours> checked(BothContours both, const std::vector<Note>& notes,
                                    const MeshDescription& description) {
    const double most_mm =
        std::min(number_of(description, "max_disagreement_mm").value_or(widest_mm),
                 most_sizes_beside * number_of(description, "size_mm").value_or(widest_mm));
    for (std::size_t n = 0; n < notes.size(); ++n) {
        if (notes[n].segments > both.drawn.contours[notes[n].contour].point_count ||
            both.routed[n].farthest_mm > most_mm + rounded_mm)
            return std::nullopt;
    }
    if (!std::ranges::all_of(both.on_surface.slices,
                             [&](const Slice& slice) { return is_sound(both.on_surface, slice); }))
        return std::nullopt;
    return both;
}

}  // namespace

void add_routed_contour_notes(const Model& model, MeshDescription& description) {
    for (const RoutedContour& contour : model.routed) {
        const std::span<const Vec3> drawn = model.drawn.points_of(model.drawn.contours[contour.contour]);
        description.notes.emplace_back(
            contour_key, fmt::format("{} {} {} {}", contour.contour, contour.segments, drawn.size(),
                                     contour.vertices.size()));
        const auto add = [&](Vec3 p) {
            description.notes.emplace_back(point_key, fmt::format("{} {} {}", p.x, p.y, p.z));
        };
        for (const Vec3 p : drawn) add(p);
        for (const std::uint32_t v : contour.vertices) add(model.mesh.points[v]);
    }
}

std::optional<BothContours> both_contours(const ContourSet& contours, const MeshDescription& description) {
    std::optional<std::vector<Note>> notes = notes_of(description);
    if (!notes || notes->empty()) return std::nullopt;
    const RingFinder given(contours);
    std::map<std::uint32_t, const Ring*> to_rerouted, to_drawn;
    for (Note& note : *notes) {
        // A plane that was read again may look the other way, and its contours run so.
        if (!given.find(note.drawn) && !given.find(note.on_surface)) {
            std::ranges::reverse(note.drawn);
            std::ranges::reverse(note.on_surface);
        }
        if (const auto as_drawn = given.find(note.drawn))
            to_rerouted[*as_drawn] = &note.on_surface;
        else if (const auto as_rerouted = given.find(note.on_surface))
            to_drawn[*as_rerouted] = &note.drawn;
        else
            return std::nullopt;
    }
    ContourSet drawn = with_rings(contours, to_drawn);
    // Slices that all but coincide may have changed places since, and contours their numbers.
    const RingFinder as_drawn(drawn);
    for (Note& note : *notes) {
        const std::optional<std::uint32_t> number = as_drawn.find(note.drawn);
        if (!number) return std::nullopt;
        note.contour = *number;
    }
    std::vector<RoutedContourReport> reports = reports_of(drawn, *notes);
    return checked({std::move(drawn), with_rings(contours, to_rerouted), std::move(reports)}, *notes,
                   description);
}

}  // namespace anatomesh
