#include "anatomesh_io/report/report_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/field/slice/distance_raster.h"
#include "anatomesh_io/report/html_text.h"

namespace anatomesh {

namespace {

// The raster of a distance map has so many points along its longer side: more make the page large.
// [points; >= 2; B]
constexpr double most_points = 96;
// Distances have so many steps of colour on each side of the contour; more make the page larger and no
// clearer. [steps; >= 2; D]
constexpr int steps = 16;

struct Chosen {
    std::uint32_t slice = 0, structure = 0;
    std::uint64_t points = 0;
};

Chosen fullest(const ContourSet& contours) {
    Chosen best;
    for (std::uint32_t s = 0; s < contours.slices.size(); ++s) {
        std::vector<std::uint64_t> points(contours.structures.size());
        for (const Contour& contour : contours.contours_of(contours.slices[s]))
            points[contour.structure] += contour.point_count;
        for (std::uint32_t structure = 0; structure < points.size(); ++structure)
            if (points[structure] > best.points) best = {s, structure, points[structure]};
    }
    return best;
}

// Contours of the slice in its plane, in mm from the upper left of the picture.
class Picture {
  public:
    Picture(const ContourSet& contours, const Chosen& chosen) {
        const Slice& slice = contours.slices[chosen.slice];
        for (const Contour& contour : contours.contours_of(slice)) {
            if (contour.structure != chosen.structure) continue;
            const auto points = contours.points_of(contour);
            rings_.emplace_back();
            for (const Vec3& p : points) rings_.back().push_back(slice.plane.to_plane(p));
            for (std::size_t i = 0; i < points.size(); ++i) {
                edges_.push_back({rings_.back()[i], rings_.back()[(i + 1) % points.size()]});
                box_.extend(rings_.back()[i]);
            }
        }
        const Vec2 size = box_.high - box_.low;
        const double margin = 0.15 * std::max(size.x, size.y);
        box_ = box_.grown(margin);
        step_ = std::max(box_.high.x - box_.low.x, box_.high.y - box_.low.y) / most_points;
    }

    std::string contours() const { return opened() + path("#1b6ca8", 1.5) + "</svg>"; }

    std::string distances() const {
        const PixelGrid grid{box_.low + Vec2{step_ / 2, step_ / 2},
                             {step_, step_},
                             static_cast<std::uint32_t>((box_.high.x - box_.low.x) / step_ + 0.5),
                             static_cast<std::uint32_t>((box_.high.y - box_.low.y) / step_ + 0.5)};
        const std::vector<double> distance = distance_raster(edges_, grid);
        double deepest = 0, farthest = 0;
        for (const double d : distance) {
            deepest = std::max(deepest, -d);
            farthest = std::max(farthest, d);
        }
        std::string svg = opened();
        for (std::uint32_t j = 0; j < grid.ny; ++j)
            for (std::uint32_t i = 0; i < grid.nx;) {
                const int level = level_of(distance[std::size_t{j} * grid.nx + i], deepest, farthest);
                std::uint32_t end = i + 1;
                while (end < grid.nx &&
                       level_of(distance[std::size_t{j} * grid.nx + end], deepest, farthest) == level)
                    ++end;
                svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"1.05\" fill=\"{}\"/>", i, j,
                                   end - i + 0.05, color_of(level));
                i = end;
            }
        return svg + path("#ffffff", 0.8) + "</svg>";
    }

  private:
    std::string opened() const {
        return fmt::format(
            "<svg viewBox=\"0 0 {:.2f} {:.2f}\" width=\"380\" role=\"img\" style=\"max-width:100%\">",
            (box_.high.x - box_.low.x) / step_, (box_.high.y - box_.low.y) / step_);
    }
    std::string path(const char* color, double line_width) const {
        std::string data;
        for (const auto& ring : rings_) {
            for (std::size_t i = 0; i < ring.size(); ++i) {
                const Vec2 p = (1 / step_) * (ring[i] - box_.low);
                data += fmt::format("{}{:.2f} {:.2f}", i == 0 ? "M" : "L", p.x, p.y);
            }
            data += "Z";
        }
        return fmt::format(
            "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" "
            "vector-effect=\"non-scaling-stroke\"/>",
            data, color, line_width);
    }
    static int level_of(double d, double deepest, double farthest) {
        if (d < 0) return -1 - static_cast<int>(std::min((steps - 1.0), steps * -d / deepest));
        return farthest > 0 ? static_cast<int>(std::min((steps - 1.0), steps * d / farthest)) : 0;
    }
    // Inside from light to dark blue, outside from light to dark orange.
    static std::string color_of(int level) {
        const bool is_inside = level < 0;
        const double t = (is_inside ? -1 - level : level) / (steps - 1.0);
        const auto mixed = [&](int light, int dark) {
            return static_cast<int>(std::lround(light + t * (dark - light)));
        };
        return is_inside ? fmt::format("#{:02x}{:02x}{:02x}", mixed(0xc6, 0x08), mixed(0xdb, 0x30),
                                       mixed(0xef, 0x6b))
                         : fmt::format("#{:02x}{:02x}{:02x}", mixed(0xfd, 0x7f), mixed(0xd9, 0x27),
                                       mixed(0xb0, 0x04));
    }

    std::vector<std::vector<Vec2>> rings_;
    std::vector<Edge2> edges_;
    Box2 box_;
    double step_ = 1;
};

}  // namespace

std::string slice_figure(const ContourSet& contours) {
    const Chosen chosen = fullest(contours);
    if (chosen.points == 0) return {};
    const Picture picture(contours, chosen);
    const Structure& structure = contours.structures[chosen.structure];
    const Slice& slice = contours.slices[chosen.slice];
    const std::string name = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    return "<div style=\"display:flex;flex-wrap:wrap;gap:16px\">" + picture.contours() + picture.distances() +
           "</div><p>" + outside_html(name) +
           (slice.name.empty() ? "" : ", slice " + outside_html(slice.name)) +
           fmt::format(
               ": {} contour points; right, the distance from the contour in the plane of the slice, blue "
               "inside, orange outside.</p>",
               chosen.points);
}

}  // namespace anatomesh
