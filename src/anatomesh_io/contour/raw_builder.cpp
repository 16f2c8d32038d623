#include "anatomesh_io/contour/raw_builder.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "anatomesh/base/text.h"
#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

Error over_limit(const char* code, const char* what, std::uint64_t limit, Place place) {
    return {ErrorKind::limit, code, std::string("more than ") + std::to_string(limit) + " " + what,
            std::move(place), "raise the limit with --limit when the file is right (--limits lists them)"};
}

bool within(double value, double limit) {
    return std::abs(value) <= limit;
}  // false for NaN

// Names that a reader would take for the same: without blanks, in lower case (ASCII).
std::string plain_name(const std::string& name) {
    std::string plain = lower_case(name);
    std::erase_if(plain, [](char c) { return c == ' ' || c == '\t'; });
    return plain;
}

// Turns x and y; never to a negative zero.
Vec3 turned(Vec3 p) {
    return {0.0 - p.x, 0.0 - p.y, p.z};
}

}  // namespace

std::string valid_utf8(std::string_view text, bool& changed) {
    std::string valid;
    valid.reserve(text.size());
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        if (length == 0) changed = true;
        valid += length == 0 ? std::string_view("\xEF\xBF\xBD") : text.substr(0, length);
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return valid;
}

std::string label_of(const Structure& structure) {
    return structure.name.empty() ? "number " + std::to_string(structure.number) : structure.name;
}

RawBuilder::RawBuilder(std::string file, const ContourLimits& limits, RunContext& context)
    : limits_(limits), context_(context) {
    raw_.source = std::move(file);
}

std::optional<std::uint32_t> RawBuilder::find_structure(std::int32_t number) const {
    const auto found = index_of_number_.find(number);
    if (found == index_of_number_.end()) return std::nullopt;
    return found->second;
}

Result<std::uint32_t> RawBuilder::add_structure(Structure structure) {
    assert(!find_structure(structure.number));
    if (raw_.structures.size() >= limits_.structures) return too_many_structures();
    bool changed = false;
    structure.name = valid_utf8(structure.name, changed);
    if (changed)
        context_.warn({"W-CIO-005",
                       "the name contains bytes that are not text",
                       {file(), {}, label_of(structure), {}, {}},
                       "they were replaced by the sign U+FFFD"});
    const auto index = static_cast<std::uint32_t>(raw_.structures.size());
    index_of_number_.emplace(structure.number, index);
    raw_.structures.push_back(std::move(structure));
    return index;
}

Result<std::uint32_t> RawBuilder::structure_of(std::int32_t number) {
    if (const auto found = find_structure(number)) return *found;
    return add_structure({.number = number, .name = {}});
}

Result<std::uint32_t> RawBuilder::add_plane(Vec3 origin, Vec3 normal, std::string name, const Place& place) {
    if (raw_.planes.size() >= limits_.contours)
        return over_limit("E-CIO-002", "slices", limits_.contours, {file(), {}, {}, {}, {}});
    const double limit = limits_.coordinate_mm;
    const double squared = squared_length(normal);
    if (!within(origin.x, limit) || !within(origin.y, limit) || !within(origin.z, limit) ||
        !(squared > 1e-200 && squared < 1e200))
        return Error{ErrorKind::input, "E-CIO-007", "the plane has no normal, or it is too far away", place,
                     "correct the plane in the file"};
    Plane plane = make_plane(origin, normal);
    // What was written from a unit normal comes back to the last bit.
    if (std::abs(squared - 1.0) < 1e-14) plane.normal = normal;
    raw_.planes.push_back(plane);
    raw_.plane_names.push_back(std::move(name));
    return static_cast<std::uint32_t>(raw_.planes.size() - 1);
}

Status RawBuilder::begin_contour(std::uint32_t structure, ContourKind kind, std::int32_t plane,
                                 std::string name, std::string slice) {
    if (raw_.contours.size() >= limits_.contours)
        return over_limit("E-CIO-002", "contours", limits_.contours, {file(), {}, {}, {}, {}});
    raw_.contours.push_back({.structure = structure,
                             .kind = kind,
                             .first_point = static_cast<std::uint32_t>(raw_.points.size()),
                             .point_count = 0,
                             .plane = plane,
                             .name = std::move(name),
                             .space = space,
                             .slice = std::move(slice)});
    return Nothing{};
}

Status RawBuilder::expect_points(std::uint64_t count) {
    const std::uint64_t in_contour = raw_.contours.back().point_count;
    if (count > limits_.points_per_contour - std::min(in_contour, limits_.points_per_contour))
        return over_limit("E-CIO-003", "points in one contour", limits_.points_per_contour, contour_place());
    if (count > limits_.points - std::min<std::uint64_t>(raw_.points.size(), limits_.points))
        return over_limit("E-CIO-004", "points in all", limits_.points, contour_place());
    return Nothing{};
}

Status RawBuilder::add_point(Vec3 point) {
    ANATOMESH_CHECK_STATUS(expect_points(1));
    RawContour& contour = raw_.contours.back();
    for (const double value : {point.x, point.y, point.z}) {
        if (within(value, limits_.coordinate_mm)) continue;
        Place place = point_place(contour.point_count);
        append_number(place.value, value);
        return Error{ErrorKind::input, "E-CIO-005",
                     "a coordinate is impossible for a patient (not finite, or too large)", std::move(place),
                     "correct the file, or export it again"};
    }
    raw_.points.push_back(point);
    ++contour.point_count;
    return Nothing{};
}

Error RawBuilder::too_many_structures() const {
    return over_limit("E-CIO-001", "structures", limits_.structures, {file(), {}, {}, {}, {}});
}

Place RawBuilder::contour_place() const {
    const RawContour& contour = raw_.contours.back();
    Place place{file(), {}, {}, contour.name, {}};
    if (contour.structure < raw_.structures.size())
        place.structure = label_of(raw_.structures[contour.structure]);
    return place;
}

Place RawBuilder::point_place(std::uint64_t point) const {
    Place place = contour_place();
    place.contour += ", point " + std::to_string(point);
    return place;
}

void RawBuilder::settle_frame(FileFrame asked) {
    if (frame == FileFrame::unknown && asked == FileFrame::unknown) {
        raw_.frame = Frame::unknown;
        context_.warn({"W-CIO-001",
                       "the file does not state the axes of its coordinates (LPS or RAS)",
                       {file(), {}, {}, {}, {}},
                       "the numbers were kept, with SPACE=unknown; give --frame LPS or --frame RAS"});
        return;
    }
    if (frame != FileFrame::unknown && asked != FileFrame::unknown && asked != frame)
        context_.warn({"W-CIO-002",
                       "--frame differs from the axes that the file states",
                       {file(), {}, {}, {}, asked == FileFrame::lps ? "LPS" : "RAS"},
                       "the axes of the file were used"});
    raw_.frame = Frame::lps;
    if ((frame == FileFrame::unknown ? asked : frame) != FileFrame::ras) return;
    for (Vec3& point : raw_.points) point = turned(point);
    for (Plane& plane : raw_.planes) {
        const Vec3 normal = turned(plane.normal);
        plane = make_plane(turned(plane.origin), normal);
        plane.normal = normal;
    }
}

void RawBuilder::keep_structures_with_contours() {
    std::vector<std::uint32_t> order(raw_.structures.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return raw_.structures[a].number < raw_.structures[b].number;
    });
    std::vector<bool> drawn(raw_.structures.size(), false);
    for (const RawContour& contour : raw_.contours) drawn[contour.structure] = true;

    std::vector<Structure> kept;
    std::vector<std::uint32_t> new_index(raw_.structures.size(), 0);
    for (const std::uint32_t old : order) {
        Structure& structure = raw_.structures[old];
        if (!drawn[old]) {
            context_.warn({"W-CIO-003",
                           "the structure has no contours",
                           {file(), {}, label_of(structure), {}, {}},
                           "it was left out"});
            continue;
        }
        new_index[old] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(std::move(structure));
    }
    for (RawContour& contour : raw_.contours) contour.structure = new_index[contour.structure];
    raw_.structures = std::move(kept);
}

void RawBuilder::warn_about_names() {
    std::map<std::string, const Structure*> seen;
    for (const Structure& structure : raw_.structures) {
        if (structure.name.empty()) continue;
        const auto [found, is_new] = seen.emplace(plain_name(structure.name), &structure);
        if (is_new) continue;
        context_.warn({"W-CIO-004",
                       "structure number " + std::to_string(found->second->number) +
                           " has the same name, apart from case and blanks",
                       {file(), {}, structure.name, {}, std::to_string(structure.number)},
                       "both were kept; use their numbers to choose one"});
    }
}

Result<RawContours> RawBuilder::finish(FileFrame asked) {
    if (raw_.contours.empty()) {
        std::string names;
        for (const Structure& structure : raw_.structures) {
            if (names.size() > 400) {
                names += ", ...";
                break;
            }
            names += (names.empty() ? "" : ", ") + shown(label_of(structure));
        }
        return Error{ErrorKind::input,
                     "E-CIO-006",
                     names.empty() ? "the file holds no contours and no structures"
                                   : "the file holds no contours; its structures are " + names,
                     {file(), {}, {}, {}, {}},
                     "give a file with contours"};
    }
    keep_structures_with_contours();
    warn_about_names();
    settle_frame(asked);
    raw_.pixel_mm = pixel_mm;
    raw_.slice_thickness_mm = slice_thickness_mm;
    raw_.complete = complete;
    raw_.exclusive = exclusive;
    raw_.unit_is_given = unit_is_given;
    return std::move(raw_);
}

}  // namespace anatomesh
