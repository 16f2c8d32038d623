// Structures drawn on slices of their own, among others.
#include "anatomesh/overlaps/outlines_between.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "anatomesh/contour/same_contours_for_test.h"
#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"

namespace anatomesh::outlines_between_test {
namespace {

using namespace fixtures;

// A disc at every height, or none.
struct Solid {
    std::function<Vec2(double)> middle;
    std::function<double(double)> radius;
    double low = 0, high = 0;
    int first = 0, step = 1;  // drawn at low + first, then every `step` mm
};

Solid tube(Vec2 middle, double lean, double radius, double growth, double low, double high, int first,
           int step) {
    return {[=](double z) {
                return middle + Vec2{lean * z, 0};
            },
            [=](double z) { return radius + growth * z; },
            low,
            high,
            first,
            step};
}

ContourSet drawn(const std::vector<Solid>& solids, int corners = 40) {
    SetBuilder builder;
    for (int z = -60; z <= 60; ++z) {
        const auto draws = [&](const Solid& solid) {
            const double after = z - solid.low - solid.first;
            return after >= 0 && z <= solid.high && std::fmod(after, solid.step) == 0;
        };
        if (std::none_of(solids.begin(), solids.end(), draws)) continue;
        builder.slice(axial(z));
        builder.set.slices.back().name = "z = " + std::to_string(z);
        for (std::uint32_t s = 0; s < solids.size(); ++s) {
            if (draws(solids[s])) builder.ring(s, circle(solids[s].middle(z), solids[s].radius(z), corners));
        }
    }
    return builder.set;
}

// Rings begin with their lexicographically smallest vertex.
ContourSet kept(ContourSet set) {
    for (const Contour& contour : set.contours) {
        const auto first = set.points.begin() + contour.first_point, last = first + contour.point_count;
        std::rotate(first, std::min_element(first, last, LexicographicLess{}), last);
    }
    return set;
}

double disc(double radius) {
    return 0.5 * 40 * radius * radius * std::sin(2 * std::numbers::pi / 40);
}

bool is_drawn(const ContourSet& set, std::uint32_t slice, std::uint32_t structure) {
    const auto contours = set.contours_of(set.slices[slice]);
    return std::any_of(contours.begin(), contours.end(),
                       [&](const Contour& contour) { return contour.structure == structure; });
}

TEST(OutlinesBetween, of_tubes_that_lean_or_grow_are_those_of_the_tube) {
    for (const int step : {2, 3, 5}) {
        for (const double lean : {0.0, 0.3}) {
            for (const double growth : {0.0, 0.1}) {
                SCOPED_TRACE(testing::Message() << step << " mm, leans " << lean << ", grows " << growth);
                const Solid organ = tube({}, lean, 12, growth, 0, 6 * step, 0, step);
                const ContourSet set = kept(drawn({organ, tube({50, 0}, 0, 5, 0, 0, 6 * step, 0, 1)}));
                RunContext context;
                const ContourSet all = outlines_between(set, {}, context).value();
                ASSERT_EQ(all.slices.size(), set.slices.size());
                for (std::uint32_t k = 0; k < all.slices.size(); ++k) {
                    const double z = set.slices[k].plane.origin.z;
                    EXPECT_TRUE(is_drawn(all, k, 0));
                    EXPECT_EQ(is_interpolated(all, k, 0), !is_drawn(set, k, 0)) << z;
                    EXPECT_FALSE(is_interpolated(all, k, 1));
                    for (const Contour& contour : all.contours_of(all.slices[k])) {
                        if (contour.structure != 0) continue;
                        EXPECT_LE(contour.point_count, 100u);
                        double area = 0;
                        const auto points = all.points_of(contour);
                        for (std::size_t n = 0; n < points.size(); ++n) {
                            const Vec3 p = points[n], q = points[(n + 1) % points.size()];
                            EXPECT_NEAR(length(Vec2{p.x, p.y} - organ.middle(z)), organ.radius(z), 0.15);
                            area += 0.5 * (p.x * q.y - p.y * q.x);
                        }
                        const double r = organ.radius(z);
                        EXPECT_NEAR(area, disc(r), 0.01 * disc(r)) << z;
                    }
                }
                EXPECT_TRUE(same(drawn_alone(all), set));
            }
        }
    }
}

TEST(OutlinesBetween, are_the_same_at_any_number_of_threads) {
    const ContourSet set =
        kept(drawn({tube({}, 0.2, 12, 0.1, 0, 24, 0, 4), tube({30, 0}, 0, 5, 0, 0, 24, 0, 1)}));
    RunContext one, many;
    one.threads = 1;
    many.threads = 4;
    const ContourSet a = outlines_between(set, {}, one).value(), b = outlines_between(set, {}, many).value();
    EXPECT_TRUE(same(a, b));
}

TEST(OutlinesBetween, are_none_where_the_structure_is_in_pieces_or_every_slice_draws_it) {
    // Two pieces of an organ, four of its spacings apart.
    ContourSet set = drawn({tube({}, 0, 12, 0, 0, 44, 0, 4), tube({40, 0}, 0, 5, 0, 0, 44, 0, 1)});
    for (const int z : {16, 20, 24}) {
        for (Contour& contour : set.contours) {
            if (contour.structure == 0 && set.points[contour.first_point].z == z) contour.structure = 2;
        }
    }
    set.structures.push_back({3, "other", {}});
    set = kept(std::move(set));
    RunContext context;
    const ContourSet all = outlines_between(set, {}, context).value();
    for (std::uint32_t k = 0; k < all.slices.size(); ++k) {
        const double z = all.slices[k].plane.origin.z;
        const bool is_in_piece = z < 12 || z > 28;
        EXPECT_EQ(is_interpolated(all, k, 0), is_in_piece && !is_drawn(set, k, 0)) << z;
    }
    const ContourSet every =
        kept(drawn({tube({}, 0, 12, 0, 0, 20, 0, 2), tube({30, 0}, 0, 5, 0, 0, 20, 0, 2)}));
    EXPECT_FALSE(has_interpolated(outlines_between(every, {}, context).value()));
}

// What each keeps, by the field.
std::vector<double> volumes(const ContourSet& set) {
    RunContext context;
    const auto field = make_structure_field(set, {}, context).value();
    std::vector<double> found;
    const auto count = static_cast<std::uint32_t>(set.structures.size());
    const std::vector<StructureVolume> all = field_volumes(*field, count, {}, context).value();
    for (const StructureVolume& one : all) found.push_back(one.by_field);
    return found;
}

PriorityResult parted(const ContourSet& set, const std::vector<std::uint32_t>& order,
                      std::vector<Warning>* warnings = nullptr) {
    RunContext context;
    PriorityResult result = part_structures(set, order, {}, context).value();
    if (warnings != nullptr) *warnings = context.warnings;
    return result;
}

TEST(PartStructures, an_organ_and_lesions_each_on_slices_of_its_own_stay_whole) {
    for (const int organ : {3, 4, 5}) {
        for (const int lesion : {1, 2}) {
            SCOPED_TRACE(testing::Message() << organ << " and " << lesion << " mm");
            // Two lesions, one partly out of the organ, the other drawn on every second of its slices.
            const ContourSet set = kept(drawn({tube({}, 0, 14, 0, 0, 8 * organ, 0, organ),
                                               tube({11, 0}, 0, 5, 0, organ, 5 * organ, 0, lesion),
                                               tube({-4, 0}, 0, 4, 0, organ, 5 * organ, 1, 2)}));
            std::vector<Warning> warnings;
            const PriorityResult result = parted(set, {1, 2}, &warnings);
            EXPECT_TRUE(has_interpolated(result.kept));
            EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(),
                                    [](const Warning& w) { return w.code == "W-PRI-002"; }));
            const std::vector<double> found = volumes(result.kept);
            ASSERT_EQ(found.size(), 3u);
            // From the first to the last slice, and up to half a gap to the next one of any.
            const double long_way = 4 * organ / lesion * lesion, other = (4 * organ - 1) / 2 * 2;
            const double all = disc(14) * 9 * organ, first = disc(5) * long_way, second = disc(4) * other;
            EXPECT_GT(found[1], first + 0.9 * disc(5));
            EXPECT_LT(found[1], first + 4.1 * disc(5));
            EXPECT_GT(found[2], second + 0.9 * disc(4));
            EXPECT_LT(found[2], second + 4.1 * disc(4));
            // What the first has of the organ: all but what is out of it.
            EXPECT_GT(found[0], all - found[1] - found[2] - 0.02 * all);
            EXPECT_LT(found[0], all - second);
        }
    }
}

TEST(PartStructures, organs_that_never_share_a_slice_stay_whole) {
    const ContourSet set =
        kept(drawn({tube({}, 0, 12, 0, 0, 32, 0, 4), tube({22, 0}, 0, 12, 0, 0, 36, 2, 4)}));
    const PriorityResult result = parted(set, {0});
    const std::vector<double> found = volumes(result.kept);
    EXPECT_NEAR(found[0], disc(12) * 36, 0.05 * disc(12) * 36);
    EXPECT_NEAR(found[1], disc(12) * 36, 0.12 * disc(12) * 36);
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        EXPECT_EQ(result.kept.slices[k].name, set.slices[k].name);
        EXPECT_NEAR(result.kept.slices[k].plane.origin.z, set.slices[k].plane.origin.z, 1e-12);
    }
}

TEST(PartStructures, what_voxels_or_levels_tell_already_is_left_as_it_is) {
    const std::vector<Solid> nested{tube({}, 0, 14, 0, 0, 32, 0, 4), tube({2, 0}, 0, 4, 0, 9, 23, 0, 1)};
    EXPECT_FALSE(has_interpolated(parted(kept(drawn(nested)), {1}).kept));
    ContourSet voxels = kept(drawn({tube({}, 0, 12, 0, 0, 32, 0, 4), tube({22, 0}, 0, 12, 0, 0, 36, 2, 4)}));
    voxels.drawn = false;
    EXPECT_FALSE(has_interpolated(parted(voxels, {0}).kept));
}

}  // namespace
}  // namespace anatomesh::outlines_between_test
