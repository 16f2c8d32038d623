// Random solids of known shape, cut by random sets of planes: every model is closed, holds its contours and
// lies near the truth, by a check that shares no code with the certificate. Some of the 500 cases run by
// default; the environment variable ANATOMESH_RANDOM_SOLIDS = "first-last" runs those of a range and prints
// their figures.
#include <gtest/gtest.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "anatomesh/contour/clean.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/independent_check_for_test.h"
#include "anatomesh/pipeline/random_solids_for_test.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh {
namespace {

using namespace random_solids;
using namespace independent;

constexpr std::uint32_t all_cases = 500, default_cases = 42;

// Bounds, in spacings of the planes. Walls and tubes are as thin as one spacing, and the polygons of sparse
// drawings cut the corners of what is no wider than three.
constexpr double most_mean = 0.3;  // distance of the surfaces, either way
constexpr double most_p95 = 1;
constexpr double most_offset = 0.2;  // difference of the volumes over the area

struct Range {
    std::uint32_t first = 0, last = default_cases - 1;
    bool printed = false;
};

Range range_of_cases() {
    Range range;
    const char* text = std::getenv("ANATOMESH_RANDOM_SOLIDS");
    if (text == nullptr) return range;
    const std::string_view view = text;
    const char* end = view.data() + view.size();
    const auto first = std::from_chars(view.data(), end, range.first);
    range.last = range.first;
    if (first.ptr < end && *first.ptr == '-') std::from_chars(first.ptr + 1, end, range.last);
    range.last = std::min(range.last, all_cases - 1);
    range.printed = true;
    return range;
}

// Points of a solid's true surface, spread by area, within the ball that the planes cut.
std::vector<Vec3> truth_samples(const Solid& solid, double radius, int count, Random& random) {
    std::vector<Vec3> samples;
    const double band = 0.02 * radius;
    for (int tries = 0; tries < 400 * count && static_cast<int>(samples.size()) < count; ++tries) {
        Vec3 p = radius * Vec3{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        if (std::abs(solid.distance(p)) > band) continue;
        for (int step = 0; step < 8; ++step) {
            const double h = 1e-5 * radius, d = solid.distance(p);
            const Vec3 slope{solid.distance(p + Vec3{h, 0, 0}) - d, solid.distance(p + Vec3{0, h, 0}) - d,
                             solid.distance(p + Vec3{0, 0, h}) - d};
            const double square = squared_length(slope);
            if (!(square > 0)) break;
            p = p - (d * h / square) * slope;
        }
        if (std::abs(solid.distance(p)) < 1e-3 * radius) samples.push_back(p);
    }
    return samples;
}

double truth_volume(const Solid& solid, double radius) {
    constexpr int steps = 48;
    const double step = 2 * radius / steps;
    double count = 0;
    for (int k = 0; k < steps; ++k) {
        for (int j = 0; j < steps; ++j) {
            for (int i = 0; i < steps; ++i) {
                const double d =
                    solid.distance(step * Vec3{i + 0.5, j + 0.5, k + 0.5} - radius * Vec3{1, 1, 1}) / step;
                count += std::clamp(0.5 - d, 0.0, 1.0);
            }
        }
    }
    return count * step * step * step;
}

struct Errors {
    double mean = 0, p95 = 0, max = 0;
};

Errors errors_of(std::vector<double> distances) {
    Errors errors;
    if (distances.empty()) return errors;
    std::sort(distances.begin(), distances.end());
    for (const double d : distances) errors.mean += d / static_cast<double>(distances.size());
    errors.p95 = distances[distances.size() * 95 / 100];
    errors.max = distances.back();
    return errors;
}

// Every point of the kept contours is a vertex of its structure's surface, in the same bits.
void expect_contours_on_surface(const ContourSet& kept, const TetMesh& mesh, std::uint32_t structure,
                                const Surface& surface) {
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    std::set<Vec3, decltype(less)> vertices(less);
    for (const Corners& t : surface.triangles) {
        for (const std::uint32_t v : t) vertices.insert(mesh.points[v]);
    }
    std::size_t lost = 0;
    for (const Contour& contour : kept.contours) {
        if (contour.structure != structure) continue;
        for (const Vec3& p : kept.points_of(contour)) lost += vertices.count(p) == 0;
    }
    EXPECT_EQ(lost, 0u) << "contour vertices off the surface";
}

void expect_sound(const Model& model, const ContourSet& kept) {
    const TetMesh& mesh = model.mesh;
    EXPECT_EQ(fault_of_cells(mesh), "");
    for (Region region = 0; region < model.regions.members.size(); ++region) {
        const Surface surface = region == 0 ? boundary_of(mesh, [](Region) { return true; })
                                            : boundary_of(mesh, [&](Region r) { return r == region; });
        EXPECT_EQ(fault_of_surface(surface), "") << "region " << region;
    }
    Random random(7);
    for (std::uint32_t s = 0; s < model.structures.size(); ++s) {
        const Surface surface = boundary_of(mesh, [&](Region r) { return model.regions.contains(r, s); });
        EXPECT_FALSE(surface.triangles.empty()) << "structure " << s;
        EXPECT_EQ(fault_of_surface(surface), "") << "structure " << s;
        expect_contours_on_surface(kept, mesh, s, surface);
        // It goes round every point once or not at all.
        const Box3 box = kept.box();
        for (int n = 0; n < 20; ++n) {
            const Vec3 p{random.between(box.low.x, box.high.x), random.between(box.low.y, box.high.y),
                         random.between(box.low.z, box.high.z)};
            const double turns = winding(mesh, surface, p);
            EXPECT_LT(std::min(std::abs(turns), std::abs(turns - 1)), 1e-6) << turns;
        }
    }
}

void expect_near_truth(const Case& drawn, const Model& model, bool printed) {
    Random random(11);
    for (std::uint32_t s = 0; s < model.structures.size(); ++s) {
        const Solid& solid = drawn.structures[static_cast<std::size_t>(model.structures[s].number) - 1];
        const Surface surface =
            boundary_of(model.mesh, [&](Region r) { return model.regions.contains(r, s); });
        const Nearest nearest(model.mesh, surface, 0.5 * drawn.spacing);
        std::vector<double> there, back;
        for (const Vec3& p : samples_of(model.mesh, surface, 2000))
            there.push_back(std::abs(solid.distance(p)));
        for (const Vec3& p : truth_samples(solid, drawn.radius, 1000, random))
            back.push_back(nearest.distance(p, drawn.radius));
        double area = 0;
        for (const Corners& t : surface.triangles) area += area_of(model.mesh, t);
        const double volume = volume_of(model.mesh, surface), truth = truth_volume(solid, drawn.radius);
        const double offset = (volume - truth) / area / drawn.spacing;
        ASSERT_GT(there.size(), 50u);
        ASSERT_GT(back.size(), 50u);
        const Errors to_truth = errors_of(there), to_model = errors_of(back);
        if (printed) {
            std::printf(
                "structure %u of %zu cells: to truth mean %.3f 95 %% %.3f max %.3f, to model mean %.3f 95 %% "
                "%.3f "
                "max %.3f spacings; volume %.4g of %.4g: mean offset %.4f spacings; pieces %u genus %lld\n",
                s, model.mesh.cells.size(), to_truth.mean / drawn.spacing, to_truth.p95 / drawn.spacing,
                to_truth.max / drawn.spacing, to_model.mean / drawn.spacing, to_model.p95 / drawn.spacing,
                to_model.max / drawn.spacing, volume, truth, offset, model.report.structures[s].components,
                static_cast<long long>(model.report.structures[s].genus));
        }
        for (const Errors& errors : {to_truth, to_model}) {
            EXPECT_LT(errors.mean, most_mean * drawn.spacing);
            EXPECT_LT(errors.p95, most_p95 * drawn.spacing);
        }
        EXPECT_LT(std::abs(offset), most_offset);
    }
}

void check_case(std::uint32_t number, bool printed) {
    const Case drawn = random_case(number);
    SCOPED_TRACE(drawn.name);
    RunContext context;
    auto cleaned = clean_contours(drawn.drawn, {}, context);
    ASSERT_TRUE(cleaned.ok()) << to_line(cleaned.error());
    auto reconciled = reconcile_contours(std::move(cleaned).value().kept, {}, context);
    ASSERT_TRUE(reconciled.ok()) << to_line(reconciled.error());
    const ContourSet& kept = reconciled.value().kept;
    if (printed) {
        const ReconcileStats& stats = reconciled.value().stats;
        std::printf("%s; spacing %.2f, %zu planes, %zu points; ends %zu 95 %% %.3f left %.3f moved %.3f\n",
                    drawn.name.c_str(), drawn.spacing, kept.slices.size(), kept.points.size(),
                    static_cast<std::size_t>(stats.ends), stats.p95_mm, stats.difference_after_mm,
                    stats.max_movement_mm);
        std::fflush(stdout);
    }
    ModelOptions options;
    if (drawn.planes == Planes::uneven) options.max_gap_spacings = 5;  // gaps are meant to be uneven
    const auto model = build_model(kept, options, context);
    if (printed) {
        std::map<std::string, int> codes;
        for (const Warning& warning : context.warnings) ++codes[warning.code];
        for (const auto& [code, count] : codes) std::printf("%s x%d ", code.c_str(), count);
    }
    ASSERT_TRUE(model.ok()) << to_line(model.error());
    expect_sound(model.value(), kept);
    expect_near_truth(drawn, model.value(), printed);
    if (printed) std::fflush(stdout);
}

class RandomSolids : public testing::TestWithParam<int> {};

TEST_P(RandomSolids, are_modelled_soundly_and_near_the_truth) {
    const Range range = range_of_cases();
    for (std::uint32_t number = range.first; number <= range.last; ++number) {
        if (static_cast<int>(number % plane_sets) == GetParam()) check_case(number, range.printed);
    }
}

std::string name_of(const testing::TestParamInfo<int>& planes) {
    std::string name = plane_set_names[static_cast<std::size_t>(planes.param)];
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(plane_sets, RandomSolids, testing::Range(0, plane_sets), name_of);

}  // namespace
}  // namespace anatomesh
