// What the tests of contour files share.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh::contour_test {

using Reader = Status (*)(std::string_view, RawBuilder&);

inline Result<RawContours> read_with(Reader reader, std::string_view text, RunContext& context,
                                     FileFrame asked = FileFrame::unknown, const ContourLimits& limits = {}) {
    RawBuilder builder("input", limits, context);
    ANATOMESH_CHECK_STATUS(reader(text, builder));
    return builder.finish(asked);
}

// The codes of the warnings, in order.
inline std::vector<std::string> codes(const RunContext& context) {
    std::vector<std::string> all;
    for (const Warning& warning : context.warnings) all.push_back(warning.code);
    return all;
}

inline testing::AssertionResult fails(const Result<RawContours>& result, const std::string& code,
                                      const std::string& text = {}) {
    if (result.ok()) return testing::AssertionFailure() << "it was read, " << code << " was expected";
    const std::string line = to_line(result.error());
    if (result.error().code != code || line.find(text) == std::string::npos)
        return testing::AssertionFailure()
               << line << "\n  but " << code << " with \"" << text << "\" was expected";
    return testing::AssertionSuccess();
}

// The raw contours as a set, without any cleaning: one slice per plane. Requires: contours sorted by plane.
inline ContourSet set_of(const RawContours& raw) {
    ContourSet set;
    set.structures = raw.structures;
    set.points = raw.points;
    set.frame = raw.frame;
    set.pixel_mm = raw.pixel_mm;
    for (std::size_t i = 0; i < raw.planes.size(); ++i)
        set.slices.push_back({raw.planes[i], 0, 0, raw.plane_names[i]});
    for (const RawContour& contour : raw.contours) {
        Slice& slice = set.slices.at(static_cast<std::size_t>(contour.plane));
        if (slice.contour_count++ == 0) slice.first_contour = static_cast<std::uint32_t>(set.contours.size());
        set.contours.push_back({contour.structure, static_cast<std::uint32_t>(contour.plane),
                                contour.first_point, contour.point_count});
    }
    return set;
}

// Slices at any tilt with rings of odd coordinates, a hole in each, in structures that are out of order.
inline ContourSet tilted_rings(unsigned seed, int slices) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    ContourSet set;
    set.structures = {{7, "Niere, \"links\"", {1, 2, 3}},
                      {-3, "", {200, 200, 200}},
                      {5, "no contours", {0, 0, 0}},
                      {2, "\xF0\x9F\xAB\x80\n../../x", {255, 0, 128}}};
    set.pixel_mm = 0.1 + 1.0 / 3;
    for (int s = 0; s < slices; ++s) {
        const Plane plane = make_plane({100 * any(random), 100 * any(random), 100 * any(random)},
                                       {any(random), any(random), any(random) + 0.01});
        set.slices.push_back(
            {plane, static_cast<std::uint32_t>(set.contours.size()), 0, "slice " + std::to_string(s)});
        for (const std::uint32_t structure : {3u, 1u, 0u}) {
            for (const double radius : {10.0, -4.0}) {  // negative: clockwise, a hole
                const auto first = static_cast<std::uint32_t>(set.points.size());
                for (int k = 0; k < 9; ++k) {
                    const double angle = k * 0.7 * (radius > 0 ? 1 : -1);
                    const double r = std::abs(radius) * (1 + 0.1 * any(random));
                    const Vec2 q{30.0 * structure + r * std::cos(angle), r * std::sin(angle)};
                    set.points.push_back(plane.to_space(q));
                }
                set.contours.push_back({structure, static_cast<std::uint32_t>(s), first, 9});
                ++set.slices.back().contour_count;
            }
        }
    }
    return set;
}

// A folder of its own, removed at the end.
class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "anatomesh-contours-XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

}  // namespace anatomesh::contour_test
