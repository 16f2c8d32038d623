// Raw contours under construction for tests, and what cleaning makes of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/clean.h"
#include "anatomesh/contour/same_contours_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::fixtures {

using Points = std::vector<Vec3>;

// A raw contour file under construction.
struct File {
    RawContours raw;

    File() {
        raw.source = "test";
        raw.structures = {{1, "liver", {}}, {2, "spleen", {}}};
    }
    File& add(const Points& points, std::uint32_t structure = 0,
              ContourKind kind = ContourKind::closed_planar, std::int32_t plane = -1) {
        raw.contours.push_back({structure, kind, static_cast<std::uint32_t>(raw.points.size()),
                                static_cast<std::uint32_t>(points.size()), plane, ""});
        raw.points.insert(raw.points.end(), points.begin(), points.end());
        return *this;
    }
};

inline Points square(double x, double y, double size, double z = 10) {
    return {{x, y, z}, {x + size, y, z}, {x + size, y + size, z}, {x, y + size, z}};
}

inline Points circle(double x, double y, double radius, int count, double z = 10) {
    Points points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * (i + 0.25) / count;
        points.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), z});
    }
    return points;
}

struct Cleaned {
    Result<CleanResult> result;
    std::vector<Warning> warnings;

    bool ok() const { return result.ok(); }
    const ContourSet& kept() const { return result.value().kept; }
    std::size_t count(const std::string& code) const {
        std::size_t n = 0;
        for (const Warning& warning : warnings) n += warning.code == code;
        return n;
    }
    // The first of a code. Requires: there is one.
    const Warning& warning(const std::string& code) const {
        return *std::find_if(warnings.begin(), warnings.end(),
                             [&](const Warning& each) { return each.code == code; });
    }
    std::string code() const { return result.ok() ? "" : result.error().code; }
    // Area of a structure's region in a slice: holes count negative.
    double area(std::uint32_t slice = 0, std::uint32_t structure = 0) const {
        double sum = 0;
        for (const Contour& contour : kept().contours) {
            if (contour.slice != slice || contour.structure != structure) continue;
            std::vector<Vec2> at;
            for (const Vec3& p : kept().points_of(contour))
                at.push_back(kept().slices[slice].plane.to_plane(p));
            sum += signed_area(at);
        }
        return sum;
    }
};

inline Cleaned clean(const File& file, const CleanOptions& options = {}) {
    RunContext context;
    auto result = clean_contours(file.raw, options, context);
    return {std::move(result), std::move(context.warnings)};
}

}  // namespace anatomesh::fixtures
