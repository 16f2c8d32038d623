#include "followed_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/pipeline/followed_contours.h"

namespace anatomesh {

namespace {

constexpr const char* key = "followed_contour";

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

// The points are appended.
std::optional<FollowedContour> contour_of(std::string_view text, std::vector<Vec3>& points) {
    const std::optional<std::uint32_t> number = take<std::uint32_t>(text);
    if (!number) return std::nullopt;
    FollowedContour contour{*number, {}, 0, 0};
    while (!text.empty()) {
        const std::optional<double> x = take<double>(text), y = take<double>(text), z = take<double>(text);
        if (!x || !y || !z || !std::isfinite(*x + *y + *z)) return std::nullopt;
        contour.vertices.push_back(static_cast<std::uint32_t>(points.size()));
        points.push_back({*x, *y, *z});
    }
    if (contour.vertices.size() < 3) return std::nullopt;
    return contour;
}

}  // namespace

void add_followed_notes(const Model& model, MeshDescription& description) {
    for (const FollowedContour& contour : model.followed) {
        std::string text = fmt::format("{}", contour.contour);
        for (const std::uint32_t v : contour.vertices) {
            const Vec3 p = model.mesh.points[v];
            text += fmt::format(" {} {} {}", p.x, p.y, p.z);
        }
        description.notes.emplace_back(key, std::move(text));
    }
}

std::optional<ContourSet> with_followed(const ContourSet& contours, const MeshDescription& description) {
    std::vector<FollowedContour> followed;
    std::vector<Vec3> points;
    for (const auto& [name, text] : description.notes) {
        if (name != key) continue;
        std::optional<FollowedContour> contour = contour_of(text, points);
        const bool fits = contour && contour->contour < contours.contours.size() &&
                          (followed.empty() || followed.back().contour < contour->contour);
        if (!fits) return std::nullopt;
        followed.push_back(std::move(*contour));
    }
    if (followed.empty()) return std::nullopt;
    const std::vector<std::uint32_t> vertex_of(contours.points.size(), 0);
    return follow_contours(contours, vertex_of, followed, points).contours;
}

}  // namespace anatomesh
