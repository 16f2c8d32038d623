// Laws of tubes that cross parallel slices at a low angle, on families of tubes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/voxel_topology_for_test.h"

namespace anatomesh::oblique_tubes_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

struct Tube {
    double radius, flatness;      // half the width across, mm; that by the half height
    double tilt, tilting;         // of the axis from the normal, degrees, and by how much more a slice
    double azimuth, turning = 0;  // degrees, and by how much more a slice
    double spacing;               // mm
    Vec2 start{};                 // of the axis in the first slice
    std::vector<Vec3> axis{};     // where it meets the slices
    std::vector<Ring> sections{};
};

double radians(double degrees) {
    return degrees * pi / 180;
}

Tube drawn(Tube tube, int slices) {
    Vec2 at = tube.start;
    for (int k = 0; k < slices; ++k) {
        const double tilt = radians(tube.tilt + k * tube.tilting), height = tube.radius / tube.flatness,
                     azimuth = radians(tube.azimuth + k * tube.turning);
        const Vec2 along{std::cos(azimuth), std::sin(azimuth)}, across{-along.y, along.x};
        Ring ring;
        for (const Vec2 q : circle({}, 1, 48))
            ring.push_back(at + (q.x * height / std::cos(tilt)) * along + (q.y * tube.radius) * across);
        tube.sections.push_back(ring);
        tube.axis.push_back({at.x, at.y, k * tube.spacing});
        const double next = radians(tube.azimuth + (k + 0.5) * tube.turning),
                     way = tube.spacing * std::tan(radians(tube.tilt + (k + 0.5) * tube.tilting));
        at = at + way * Vec2{std::cos(next), std::sin(next)};
    }
    return tube;
}

// Whether each of its sections touches the next one.
bool is_connected(const Tube& tube, double steepest) {
    const double way = tube.spacing * std::tan(radians(steepest)),
                 size = tube.radius / tube.flatness / std::cos(radians(steepest));
    return way < 2 * size;
}

std::vector<Tube> tubes() {
    std::mt19937 random(58);
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    std::vector<Tube> family;
    for (const double tilt : {60.0, 70.0, 75.0, 80.0}) {
        for (const double radius : {1.5, 2.0, 4.0, 6.0})
            family.push_back(drawn({radius, 1, tilt, 0, 17, 0, 3}, 8));
    }
    for (int n = 0; family.size() < 80; ++n) {
        // Straight ones, ones that turn about the normal, and ones that lean more and more.
        const double steepest = n % 2 == 0 ? between(60, 80) : between(0, 60);
        const double tilting = n % 3 == 1 ? between(0, std::min(1.5, steepest / 8)) : 0;
        const Tube tube{between(1.5, 6), between(0.6, 1.6), steepest - 7 * tilting,
                        tilting,         between(0, 360),   n % 3 == 2 ? between(-8, 8) : 0,
                        between(1, 5)};
        if (is_connected(tube, steepest)) family.push_back(drawn(tube, 8));
    }
    return family;
}

ContourSet set_of(const std::vector<Tube>& tubes) {
    SetBuilder builder;
    for (std::size_t k = 0; k < tubes.front().axis.size(); ++k) {
        builder.slice(axial(tubes.front().axis[k].z));
        for (const Tube& tube : tubes) builder.ring(0, tube.sections[k]);
    }
    return builder.set;
}

std::shared_ptr<const StructureField> field_of(const std::vector<Tube>& tubes) {
    RunContext context;
    return make_structure_field(set_of(tubes), {}, context).value();
}

double volume_error(const StructureField& field) {
    RunContext context;
    const StructureVolume volume = field_volumes(field, 1, {}, context).value().front();
    return volume.by_field / volume.by_slices - 1;
}

// The smallest and the largest area across the axis, where the ends are not near; in areas of the tube.
std::pair<double, double> areas_across(const StructureField& field, const Tube& tube) {
    const double height = tube.radius / tube.flatness, reach = 1.5 * std::max(tube.radius, height);
    const double low = tube.axis.front().z, high = tube.axis.back().z, step = tube.radius / 9;
    std::pair<double, double> areas{1e9, 0};
    for (std::size_t k = 0; k + 1 < tube.axis.size(); ++k) {
        const Vec3 way = tube.axis[k + 1] - tube.axis[k];
        const Vec3 along = (1 / length(way)) * way;
        const double level = std::hypot(along.x, along.y);
        const Vec3 across = level > 1e-9 ? Vec3{-along.y / level, along.x / level, 0} : Vec3{1, 0, 0};
        const Vec3 up = cross(along, across);
        for (int n = 0; n < 4; ++n) {
            const Vec3 middle = tube.axis[k] + (n / 4.0) * way;
            if (middle.z - level * reach < low || middle.z + level * reach > high) continue;
            std::size_t inside = 0;
            for (double x = -reach; x <= reach; x += step) {
                for (double y = -reach; y <= reach; y += step)
                    inside += field.value(0, middle + x * across + y * up) < 0;
            }
            const double area = static_cast<double>(inside) * step * step / (pi * tube.radius * height);
            areas = {std::min(areas.first, area), std::max(areas.second, area)};
        }
    }
    return areas;
}

std::string text(const Tube& tube) {
    std::ostringstream out;
    out << "radius " << tube.radius << " flatness " << tube.flatness << " tilt " << tube.tilt << "+"
        << tube.tilting << " azimuth " << tube.azimuth << "+" << tube.turning << " spacing " << tube.spacing;
    return out.str();
}

TEST(ObliqueTubes, keep_their_volume_and_have_no_necks) {
    int measured = 0;
    for (const Tube& tube : tubes()) {
        const auto field = field_of({tube});
        EXPECT_NEAR(volume_error(*field), 0, tube.tilt <= 70 ? 0.015 : 0.02) << text(tube);
        const auto [least, most] = areas_across(*field, tube);
        if (most == 0) continue;  // too short
        ++measured;
        EXPECT_GT(least, 0.85 * most) << text(tube);
    }
    EXPECT_GT(measured, 50);
}

TEST(ObliqueTubes, are_one_piece) {
    int n = 0;
    for (const Tube& tube : tubes()) {
        if (n++ % 5 != 0) continue;
        const double least = std::min(tube.radius, tube.radius / tube.flatness);
        EXPECT_EQ(Voxels(*field_of({tube}), 0.35 * least).topology(), (Topology{1, 0, 0})) << text(tube);
    }
}

// Sections that do not quite touch.
TEST(ObliqueTubes, are_joined_where_their_sections_nearly_touch) {
    for (const double tilt : {70.0, 75.0, 80.0}) {
        const double radius = 1.5 * std::sin(radians(tilt)) / 1.05;  // 5 % apart
        const Tube tube = drawn({radius, 1, tilt, 0, 30, 0, 3}, 8);
        EXPECT_NEAR(volume_error(*field_of({tube})), 0, 0.02) << tilt;
    }
}

// Two of them in different directions, one over the other, in one structure.
TEST(ObliqueTubes, keep_their_volume_where_two_pass) {
    int passing = 0;
    for (const double tilt : {65.0, 72.0, 78.0}) {
        for (const double angle : {40.0, 70.0, 90.0, 150.0}) {
            for (const double aside : {3.0, 10.0}) {
                const double radius = 2, spacing = 3, way = 3.5 * spacing * std::tan(radians(tilt));
                // In the middle of the stack the axes pass at this distance and the two radii.
                const double off = (2 * radius + aside) / std::cos(radians(tilt));
                Tube one{radius, 1, tilt, 0, 0, 0, spacing}, other{radius, 1, tilt - 3, 0, angle, 0, spacing};
                one.start = {-way, 0};
                const double back = 3.5 * spacing * std::tan(radians(tilt - 3)), a = radians(angle);
                other.start = Vec2{off, off} - back * Vec2{std::cos(a), std::sin(a)};
                const auto field = field_of({drawn(one, 8), drawn(other, 8)});
                EXPECT_NEAR(volume_error(*field), 0, 0.02) << tilt << " " << angle << " " << aside;
                ++passing;
            }
        }
    }
    EXPECT_EQ(passing, 24);
}

double unexplained(const ContourSet& set, EndCaps caps) {
    RunContext context;
    FieldOptions options;
    options.caps = caps;
    const auto field = make_structure_field(set, options, context).value();
    const StructureVolume volume = field_volumes(*field, 1, {6000, 60000, 1000000}, context).value().front();
    return volume.unexplained / volume.by_slices;
}

// So far apart that nothing joins them as they are.
TEST(ObliqueTubes, what_they_lose_where_sections_lie_apart_is_told_of) {
    for (const double radius : {1.0, 1.15, 1.3}) {
        const Tube tube = drawn({radius, 1, 80, 0, 30, 0, 3}, 8);
        EXPECT_GT(std::abs(unexplained(set_of({tube}), EndCaps::half)), 0.05) << radius;
    }
}

// Cones, balls and spindles on few slices, wherever these lie: their volume is not that of their areas.
TEST(ObliqueTubes, what_tapers_is_explained) {
    for (const EndCaps caps : {EndCaps::half, EndCaps::flat, EndCaps::rounded}) {
        for (const double spacing : {3.0, 6.0, 8.0}) {
            for (const double phase : {0.1, 0.4, 0.7}) {
                for (const int kind : {0, 1, 2}) {
                    SetBuilder builder;
                    for (double z = phase * spacing - 20; z < 20; z += spacing) {
                        const double share = kind == 0   ? 0.5 - z / 40
                                             : kind == 1 ? std::sqrt(std::max(0.0, 1 - z * z / 400))
                                                         : std::pow(1 - std::abs(z) / 20, 2);
                        if (20 * share < 0.5) continue;
                        builder.slice(axial(z));
                        builder.ring(0, circle({0.2 * z, 0}, 20 * share, 60));
                    }
                    EXPECT_NEAR(unexplained(builder.set, caps), 0, 0.04)
                        << kind << " " << spacing << " " << phase;
                }
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::oblique_tubes_test
