#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/random_drawing_for_test.h"
#include "anatomesh/field/stack/earlier_maps.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh::earlier_field_test {
namespace {

using namespace fixtures;

struct Made {
    std::shared_ptr<const StructureField> field;
    std::vector<Warning> warnings;
};

Made made(const ContourSet& set, const FieldOptions& options, int threads = 1) {
    RunContext context;
    context.threads = threads;
    auto field = make_structure_field(set, options, context);
    EXPECT_TRUE(field.ok()) << to_line(field.error());
    return {field.value(), context.warnings};
}

// Values, regions and unions at places in and about the box.
void expect_same(const StructureField& a, const StructureField& b, std::uint32_t structures, int places,
                 std::mt19937& random) {
    const Box3 box = b.box();
    std::uniform_real_distribution<double> unit(-0.05, 1.05);
    std::vector<std::uint32_t> in_a, in_b;
    ASSERT_EQ(a.clamp(), b.clamp());
    ASSERT_EQ(a.box().low, box.low);
    ASSERT_EQ(a.box().high, box.high);
    for (int n = 0; n < places; ++n) {
        const Vec3 size = box.high - box.low;
        const Vec3 p = box.low + Vec3{unit(random) * size.x, unit(random) * size.y, unit(random) * size.z};
        for (std::uint32_t s = 0; s < structures; ++s) ASSERT_EQ(a.value(s, p), b.value(s, p)) << n;
        ASSERT_EQ(a.union_value(p), b.union_value(p));
        a.members(p, in_a);
        b.members(p, in_b);
        ASSERT_EQ(in_a, in_b);
    }
}

// However the slices lie, after edits of all kinds: values, regions, boxes, volumes and warnings are those of a field
// made without an earlier one.
TEST(EarlierField, changes_no_value) {
    std::mt19937 random(1);
    std::size_t taken = 0;
    for (int member = 0; member < 40; ++member) {
        DrawnSlices drawing = random_drawing(static_cast<Lie>(member % 5), member % 7 == 3, random);
        const auto structures = static_cast<std::uint32_t>(drawing.seeds[0].size());
        FieldOptions options;
        options.caps = static_cast<EndCaps>(member % 3);
        std::shared_ptr<const StructureField> earlier = made(set_of(drawing), options).field;
        for (int step = 0; step < 4; ++step) {
            edit(drawing, random);
            const ContourSet set = set_of(drawing);
            const Made fresh = made(set, options);
            FieldOptions from_earlier = options;
            from_earlier.earlier = earlier;
            const Made kept = made(set, from_earlier, 1 + step % 2);
            ASSERT_NO_FATAL_FAILURE(expect_same(*kept.field, *fresh.field, structures, 200, random))
                << member << ' ' << step;
            if (step == 0 && member % 8 == 0) {
                VolumeOptions coarse;
                coarse.points_per_slab = 4000;
                const auto volumes = [&](const StructureField& field) {
                    RunContext context;
                    return std::move(field_volumes(field, structures, coarse, context).value());
                };
                const auto kept_volumes = volumes(*kept.field), fresh_volumes = volumes(*fresh.field);
                for (std::uint32_t s = 0; s < structures; ++s)
                    EXPECT_EQ(kept_volumes[s].by_field, fresh_volumes[s].by_field);
            }
            ASSERT_EQ(kept.warnings.size(), fresh.warnings.size());
            for (std::size_t w = 0; w < fresh.warnings.size(); ++w)
                EXPECT_EQ(to_line(kept.warnings[w]), to_line(fresh.warnings[w]));
            taken += taken_from_earlier(*kept.field).gaps_taken;
            EXPECT_EQ(taken_from_earlier(*fresh.field).maps_taken, 0u);
            earlier = kept.field;
        }
    }
    EXPECT_GT(taken, 500u);
}

// Outside the stretches that are named no value differs; of structures that exclude each other by rounding at most.
TEST(EarlierField, names_where_values_differ) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-0.05, 1.05);
    int apart = 0, within = 0;
    for (int member = 0; member < 40; ++member) {
        DrawnSlices drawing = random_drawing(static_cast<Lie>(member % 3), member % 4 == 3, random);
        const auto structures = static_cast<std::uint32_t>(drawing.seeds[0].size());
        FieldOptions options;
        options.caps = static_cast<EndCaps>(member % 3);
        options.earlier = made(set_of(drawing), options).field;
        const Plane frame = drawing.planes[0];
        edit(drawing, random);
        if (drawing.planes[0].origin != frame.origin) continue;
        const auto field = made(set_of(drawing), options).field;
        const auto stretches = stretches_unlike(*field, *options.earlier);
        EXPECT_EQ(stretches_unlike(*field, *field)->size(), 0u);
        if (!stretches) continue;  // another spacing
        const Box3 box = field->box(), before = options.earlier->box();
        Box3 both = box;
        both.extend(before.low);
        both.extend(before.high);
        for (int n = 0; n < 2000; ++n) {
            const Vec3 size = both.high - both.low;
            const Vec3 p =
                both.low + Vec3{unit(random) * size.x, unit(random) * size.y, unit(random) * size.z};
            const double z = frame.signed_distance(p);
            const bool named = std::any_of(stretches->begin(), stretches->end(),
                                           [&](const FieldStretch& s) { return s.low <= z && z <= s.high; });
            bool differs = false;
            for (std::uint32_t s = 0; s < structures; ++s)
                differs = differs || std::abs(field->value(s, p) - options.earlier->value(s, p)) >
                                         (drawing.exclusive ? 1e-12 : 0);
            ASSERT_FALSE(differs && !named) << member << ' ' << z;
            apart += !named;
            within += differs;
        }
    }
    EXPECT_GT(apart, 10000);
    EXPECT_GT(within, 1000);
}

// An edit of one slice makes one map anew, and what lies in six gaps at most: paths curve by the slices beyond, and
// what ends there by those beyond them.
TEST(EarlierField, makes_anew_what_one_slice_touches) {
    std::mt19937 random(2);
    for (int member = 0; member < 40; ++member) {
        DrawnSlices drawing = random_drawing(static_cast<Lie>(member % 3), false, random);
        for (auto& seeds : drawing.seeds)
            for (std::uint32_t& seed : seeds) seed = std::max(seed, 1u);
        FieldOptions options;
        const Made before = made(set_of(drawing), options);
        options.earlier = before.field;
        const TakenFromEarlier all = taken_from_earlier(*made(set_of(drawing), options).field);
        EXPECT_EQ(all.maps_taken, all.maps);
        EXPECT_EQ(all.gaps_taken, all.gaps);
        drawing.seeds[random() % drawing.seeds.size()][0] = 1 + random() % 1000000;
        const TakenFromEarlier one = taken_from_earlier(*made(set_of(drawing), options).field);
        EXPECT_EQ(one.maps_taken + 1, one.maps);
        // On oblique planes new vertices round the height of the slice for all structures.
        EXPECT_LE(one.gaps, one.gaps_taken + 6 * (member % 3 == 2 ? drawing.seeds[0].size() : 1));
    }
}

// Between slices k - 1 and k + 1 the field of slices k - 2 to k + 2 is that of all with the clamp and the frame of
// all: bit for bit, or within rounding where structures exclude each other.
TEST(EarlierField, five_slices_say_all_about_the_middle_one) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    int places = 0;
    for (int member = 0; member < 500; ++member) {
        DrawnSlices drawing = random_drawing(static_cast<Lie>(member % 3), member % 4 == 3, random);
        for (auto& seeds : drawing.seeds)
            for (std::uint32_t& seed : seeds) seed = std::max(seed, 1u);
        const Made whole = made(set_of(drawing), {});
        const std::size_t k = 2 + random() % (drawing.planes.size() - 4);
        DrawnSlices window = drawing;
        window.planes = {drawing.planes.begin() + static_cast<std::ptrdiff_t>(k - 2),
                         drawing.planes.begin() + static_cast<std::ptrdiff_t>(k + 3)};
        window.seeds = {drawing.seeds.begin() + static_cast<std::ptrdiff_t>(k - 2),
                        drawing.seeds.begin() + static_cast<std::ptrdiff_t>(k + 3)};
        if (k > 2) {  // the frame is that of the first slice, on which nothing is drawn here
            window.planes.insert(window.planes.begin(), drawing.planes.front());
            window.seeds.insert(window.seeds.begin(), std::vector<std::uint32_t>(drawing.seeds[0].size(), 0));
        }
        FieldOptions options;
        options.clamp_mm = whole.field->clamp();
        const Made five = made(set_of(window), options);
        const auto structures = static_cast<std::uint32_t>(drawing.seeds[0].size());
        for (int n = 0; n < 200; ++n) {
            const Plane &below = drawing.planes[k - 1], &above = drawing.planes[k + 1];
            const double share = unit(random);
            const Vec3 p = (1 - share) * below.origin + share * above.origin +
                           (40 * unit(random) - 20) * below.u + (40 * unit(random) - 20) * below.v;
            for (std::uint32_t s = 0; s < structures; ++s) {
                const double expected = whole.field->value(s, p), value = five.field->value(s, p);
                // Where structures exclude each other, what is subtracted rounds.
                ASSERT_NEAR(value, expected, drawing.exclusive ? 1e-12 : 0) << member;
                places += std::abs(expected) < whole.field->clamp();
            }
        }
    }
    EXPECT_GT(places, 50000);
}

// Slices that are copies of each other have gaps that are alike: each is taken from its own.
TEST(EarlierField, copied_slices_are_taken_over_whole) {
    std::mt19937 random(6);
    for (const std::uint32_t structures : {1u, 2u}) {
        DrawnSlices drawing = random_drawing(Lie::even, false, random);
        while (drawing.planes.size() < 12) {
            drawing.planes.push_back(axial(3.0 * static_cast<double>(drawing.planes.size())));
            drawing.seeds.push_back(drawing.seeds.back());
        }
        for (auto& seeds : drawing.seeds) seeds.assign(structures, 77);
        FieldOptions options;
        options.earlier = made(set_of(drawing), {}).field;
        drawing.seeds[10].back() = 99;
        const auto field = made(set_of(drawing), options).field;
        const TakenFromEarlier taken = taken_from_earlier(*field);
        EXPECT_EQ(taken.maps, taken.maps_taken + 1);
        EXPECT_LE(taken.gaps, taken.gaps_taken + 6);
        const auto stretches = stretches_unlike(*field, *options.earlier);
        ASSERT_TRUE(stretches);
        ASSERT_EQ(stretches->size(), 1u);
        EXPECT_GE((*stretches)[0].low, 3 * 7);
    }
}

// Of structures that exclude each other, what ends beside a slice depends on which of them an outline belongs to, also
// where the outlines stay.
TEST(EarlierField, an_outline_may_change_its_structure) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    int relabelled = 0, differs = 0;
    for (int member = 0; member < 60; ++member) {
        DrawnSlices drawing = random_drawing(Lie::even, true, random);
        for (auto& seeds : drawing.seeds)
            if (random() % 3 == 0) seeds[random() % 2] = 0;
        drawing.seeds[0] = {1, 1};
        const ContourSet before = set_of(drawing);
        ContourSet after = before;
        for (const Slice& slice : before.slices) {
            if (slice.contour_count != 1 || random() % 2) continue;
            Contour& contour = after.contours[slice.first_contour];
            contour.structure = 1 - contour.structure;
            ++relabelled;
        }
        FieldOptions options;
        options.earlier = made(before, {}).field;
        const Made kept = made(after, options), fresh = made(after, {});
        ASSERT_NO_FATAL_FAILURE(expect_same(*kept.field, *fresh.field, 2, 1000, random)) << member;
        for (int n = 0; n < 500; ++n) {
            const Vec3 p{24 * unit(random) - 12, 24 * unit(random) - 12, 24 * unit(random)};
            differs += kept.field->union_value(p) != options.earlier->union_value(p);
        }
    }
    EXPECT_GT(relabelled, 50);
    EXPECT_GT(differs, 100);
}

TEST(EarlierMaps, are_found_by_the_bits_of_their_edges) {
    std::mt19937 random(4);
    std::vector<std::unique_ptr<DistanceMap>> maps;
    std::vector<EarlierMaps::Entry> entries;
    std::vector<std::vector<Edge2>> outlines;
    for (std::uint32_t n = 0; n < 100; ++n) {
        outlines.push_back(edges_of({star({}, 5, 9, 20, random)}));
        maps.push_back(std::make_unique<DistanceMap>(outlines.back(), 3));
        entries.push_back({fingerprint_of(outlines.back()), maps.back().get(), 0, n});
    }
    const EarlierMaps earlier(entries);
    for (std::uint32_t n = 0; n < 100; ++n) {
        std::vector<Edge2> edges = outlines[n];
        ASSERT_NE(earlier.find(fingerprint_of(edges), edges, 3), nullptr);
        EXPECT_EQ(earlier.find(fingerprint_of(edges), edges, 3)->place, n);
        EXPECT_EQ(earlier.find(fingerprint_of(edges), edges, 4), nullptr);
        edges[7].b.x = std::nextafter(edges[7].b.x, 100);
        EXPECT_EQ(earlier.find(fingerprint_of(outlines[n]), edges, 3), nullptr);
        edges.pop_back();
        EXPECT_EQ(earlier.find(fingerprint_of(edges), edges, 3), nullptr);
    }
    EXPECT_EQ(EarlierMaps().find(0, outlines[0], 3), nullptr);
}

}  // namespace
}  // namespace anatomesh::earlier_field_test
