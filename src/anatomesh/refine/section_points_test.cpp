// Laws of the vertices that cross-sections by planes of slices lack.
#include "anatomesh/refine/section_points.h"

#include <cmath>
#include <random>

#include "anatomesh/cull/culled_mesh_for_test.h"

namespace anatomesh::section_points_test {
namespace {

using namespace fixtures;

constexpr double radius = 5, size = 1;
constexpr double beside = 0.15;  // the planes, at most: a twentieth of a section's width

// A ball with slots along two planes that cross in its middle, in which nothing is drawn.
struct Slots {
    std::vector<Plane> planes;
    std::vector<Box2> extents{{{-radius, -radius}, {radius, radius}}, {{-radius, -radius}, {radius, radius}}};
    std::vector<double> weights = std::vector<double>(2, 1 / (radius * radius * M_PI));
    AnalyticField field;

    Slots(const Slots&) = delete;
    Slots& operator=(const Slots&) = delete;
    Slots(double angle, double width)
        : planes{make_plane({}, {1, 0, 0.1}), make_plane({}, {std::cos(angle), std::sin(angle), 0})},
          field({[this, width](Vec3 p) {
                    double value = length(p) - radius;
                    for (const Plane& plane : planes)
                        value = std::max(value, 0.5 * width - std::abs(plane.signed_distance(p)));
                    return value;
                }},
                radius + 1) {}

    std::vector<ContradictedPlace> contradicted;

    CrossedSlices slices() const { return {{planes, extents, 1e-9}, weights, contradicted}; }
};

// Random points in the ball and beside it, and the corners of a large box.
CulledMesh mesh_beside_slots(const Slots& slots, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<Vec3> points;
    for (int n = 0; n < 700; ++n) {
        const Vec3 direction = normalized({normal(random), normal(random), normal(random)});
        points.push_back((n % 2 ? 5.0 + 2 * share(random) : 5.0 * std::cbrt(share(random))) * direction);
    }
    return culled_mesh_of(std::move(points), slots.field, size);
}

// Of a slot's plane, the share of a cross-section in which cells are in the ball.
double wrong_share(const CulledMesh& mesh, const Slots& slots) {
    double sum = 0;
    for (std::size_t c = 0; c < mesh.regions.size(); ++c) {
        if (mesh.regions[c] == 0) continue;
        std::array<Vec3, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) corners[i] = mesh.points()[mesh.cells.cells[c][i]];
        for_each_section(corners, slots.slices().planes, [&](std::uint32_t k, const PlaneSection& section) {
            if (section.facet == PlaneSection::no_facet) sum += section.area * slots.weights[k];
        });
    }
    return sum;
}

std::vector<Vec3> section_points(const CulledMesh& mesh, const Slots& slots,
                                 const SectionPointOptions& options = {}, SectionPointStats* stats = nullptr,
                                 const ProtectedSegments& protected_segments = ProtectedSegments(size, 0),
                                 int threads = 1) {
    RunContext context;
    context.threads = threads;
    std::vector<Vec3> found;
    std::vector<std::uint32_t> look = mesh.all_cells();
    const SectionPointStats seen =
        find_section_points(mesh.view(slots.field), slots.slices(), {mesh.grid, protected_segments}, options,
                            look, found, context);
    EXPECT_LE(look.size(), seen.wrong);
    EXPECT_TRUE(std::is_sorted(look.begin(), look.end()));
    if (stats) *stats = seen;
    return found;
}

TEST(SectionPoints, rounds_open_slots_that_are_narrower_than_edges) {
    for (const double angle : {1.5, 0.5}) {
        for (const double width : {0.4, 0.1}) {
            const Slots slots(angle, width);
            CulledMesh mesh = mesh_beside_slots(slots, 3);
            const double before = wrong_share(mesh, slots);
            EXPECT_GT(before, 0.2) << width;
            int round = 0;
            for (std::vector<Vec3> found = section_points(mesh, slots); !found.empty() && round < 12;
                 ++round) {
                mesh.delaunay.insert(found);
                mesh.update(slots.field, 1, {0.02});
                found = section_points(mesh, slots);
            }
            EXPECT_LT(round, 12);
            EXPECT_LT(wrong_share(mesh, slots), 0.02 * before) << "angle " << angle << ", width " << width;
        }
    }
}

TEST(SectionPoints, they_lie_beside_the_planes_apart_from_each_other_and_from_vertices) {
    const Slots slots(0.7, 0.3);
    const CulledMesh mesh = mesh_beside_slots(slots, 5);
    double closest_before = 0;
    std::size_t found_before = mesh.cells.cells.size();
    for (const double spacing : {0.1, 0.3, 1.0}) {
        SectionPointOptions options;
        options.min_spacing = spacing;
        SectionPointStats stats;
        const std::vector<Vec3> found = section_points(mesh, slots, options, &stats);
        EXPECT_GT(found.size(), 10u);
        EXPECT_LE(found.size() + stats.refused, stats.wrong);
        for (const Vec3& p : found) {
            EXPECT_LT(std::min(std::abs(slots.planes[0].signed_distance(p)),
                               std::abs(slots.planes[1].signed_distance(p))),
                      beside);
        }
        double closest = radius;
        for (std::size_t n = 0; n < found.size(); ++n) {
            for (std::size_t m = 0; m < n; ++m) closest = std::min(closest, length(found[n] - found[m]));
            for (const Vec3& p : mesh.points()) closest = std::min(closest, length(found[n] - p));
        }
        EXPECT_GT(closest, closest_before) << spacing;
        EXPECT_LT(found.size(), found_before) << spacing;
        closest_before = closest;
        found_before = found.size();
    }
}

TEST(SectionPoints, a_cut_of_which_little_is_wrong_stays) {
    const Slots slots(0.7, 0.3);
    const CulledMesh mesh = mesh_beside_slots(slots, 5);
    SectionPointOptions options;
    options.least_of_cross_section = 1;
    SectionPointStats stats;
    EXPECT_TRUE(section_points(mesh, slots, options, &stats).empty());
    EXPECT_EQ(stats.wrong, 0u);
    Slots silent(0.7, 0.3);
    silent.weights.assign(2, 0);
    EXPECT_TRUE(section_points(mesh, silent).empty()) << "the slices do not say where the structure is";
}

TEST(SectionPoints, they_keep_out_of_the_balls_of_contour_segments) {
    const Slots slots(0.7, 0.3);
    const CulledMesh mesh = mesh_beside_slots(slots, 5);
    ProtectedSegments protected_segments(size, 0);
    protected_segments.add_segment({0, 0, -3}, {0, 0, 3});
    SectionPointStats free, kept_out;
    section_points(mesh, slots, {}, &free);
    const std::vector<Vec3> found = section_points(mesh, slots, {}, &kept_out, protected_segments);
    EXPECT_GT(kept_out.refused, free.refused);
    EXPECT_EQ(kept_out.wrong, free.wrong);
    for (const Vec3& p : found) EXPECT_GE(length(p), 3);
}

TEST(SectionPoints, they_keep_away_from_where_slices_contradict_each_other) {
    Slots slots(0.7, 0.3);
    const CulledMesh mesh = mesh_beside_slots(slots, 5);
    SectionPointOptions options;
    options.clearance_mm = 1.5;
    const Vec3 low{0, 0, -2}, high{0, 0, 2};
    const auto near_place = [&](const std::vector<Vec3>& found) {
        return std::count_if(found.begin(), found.end(), [&](Vec3 p) {
            return length(p - Vec3{0, 0, std::clamp(p.z, -2.0, 2.0)}) < options.clearance_mm - beside;
        });
    };
    const std::vector<Vec3> all = section_points(mesh, slots, options);
    EXPECT_GT(near_place(all), 3);
    slots.contradicted = {{1, low, high}};
    EXPECT_EQ(section_points(mesh, slots, options), all) << "it is of another structure";
    slots.contradicted = {{0, low, high}};
    const std::vector<Vec3> found = section_points(mesh, slots, options);
    EXPECT_EQ(near_place(found), 0);
    EXPECT_GT(found.size(), 10u);
}

TEST(SectionPoints, same_points_for_any_number_of_threads) {
    const Slots slots(1.0, 0.2);
    const CulledMesh mesh = mesh_beside_slots(slots, 7);
    const std::vector<Vec3> one = section_points(mesh, slots);
    EXPECT_GT(one.size(), 10u);
    for (const int threads : {2, 4})
        EXPECT_EQ(section_points(mesh, slots, {}, nullptr, ProtectedSegments(size, 0), threads), one);
}

}  // namespace
}  // namespace anatomesh::section_points_test
