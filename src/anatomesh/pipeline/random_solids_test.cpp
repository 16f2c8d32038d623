// Random solids of known shape, cut by random sets of planes: every model is closed, holds its contours and
// lies near the truth, by a check that shares no code with the certificate. 500 cases of few planes run by
// default, in parts, and some of them as files may give them, rounded or out of place; the environment
// variable ANATOMESH_RANDOM_SOLIDS = "first-last" runs those of a range, and prints their figures: 500 to 999
// have more planes, 1000 to 1499 are rounded, 1500 to 1999 out of place.
#include <gtest/gtest.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/contour/walls/close_gaps.h"
#include "anatomesh/contour/walls/merge_coincident.h"
#include "anatomesh/contour/walls/slivers.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/independent_check_for_test.h"
#include "anatomesh/pipeline/random_solids_for_test.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::random_solids_test {
namespace {

using namespace random_solids;
using namespace independent;

constexpr std::uint32_t repeated_every = 30;
constexpr double narrow_gap_mm = 0.4;  // a narrow pixel
// Of the cases of a set of planes, each a test; those run by default.
constexpr int parts = 6;
// The planes meet one of the structures so little that most of it is lost, which is warned of.
constexpr std::array<std::uint32_t, 1> hardly_met{314};

// In spacings of the planes.
struct Bounds {
    double mean, p95;                // distance of the model's surface from the truth
    double mean_missed, p95_missed;  // distance of the true surface from the model
    double offset;                   // difference of the volumes over the area
};
// Of the truth, walls and tubes as thin as one spacing may be missed by few planes.
constexpr Bounds coarse_bounds{0.3, 1, 0.8, 2.5, 0.7}, fine_bounds{0.3, 1, 0.3, 1, 0.2};
// Of the contour segments of a structure, the share that may be no chain of edges: where planes cross close
// to each other all over, and where contours of two structures run beside each other; and how many besides.
constexpr double most_broken_where_planes_cross = 0.4, most_broken_beside_others = 0.03;
constexpr std::size_t broken_besides_where_planes_cross = 10, broken_besides = 2;
// Of all segments of a part of the cases of a set of planes.
constexpr std::array<double, plane_sets> broken_in_all{0.0005, 0.0002, 0.0002, 0.0002, 0.001, 0.0002, 0.0005};

constexpr double most_of_a_cut = 1e-3;  // of what is drawn, that may be wrong
// Of all cuts of a part of the cases, those of which more is: none where planes do not cross.
constexpr std::array<double, plane_sets> cuts_off_in_all{0, 0, 0, 0, 0.005, 0, 0.005};
// Of a cell, also between contours that force it: flatter ones are of no use to finite elements.
constexpr double flattest_degrees = 0.05;

// Of those that are rounded or out of place: in all, of segments, and of sets.
constexpr double broken_in_files = 0.02;
constexpr std::size_t most_refused = 1;
// Of those every so many; about an axis each takes as long as the others together.
constexpr std::uint32_t sparsely = 11, sparsely_about_an_axis = 31;

struct Segments {
    std::size_t all = 0, broken = 0;
    std::size_t cuts = 0, cuts_off = 0;
    std::size_t refused = 0;  // sets
};

std::size_t most_broken(const Case& drawn, std::size_t segments) {
    const auto share = [&](double part) {
        return static_cast<std::size_t>(part * static_cast<double>(segments));
    };
    if (drawn.planes == Planes::rotational || drawn.planes == Planes::crossing_stacks)
        return broken_besides_where_planes_cross + share(most_broken_where_planes_cross);
    const bool alone = drawn.arrangement == Arrangement::one || drawn.arrangement == Arrangement::nested;
    return broken_besides + (alone ? 0 : share(most_broken_beside_others));
}

struct Range {
    std::uint32_t first = 0, last = coarse_cases - 1;
};

// "first-last", or one number alone; nothing for other texts and for cases that there are not.
std::optional<Range> range_of(std::string_view text) {
    Range range;
    const char* end = text.data() + text.size();
    auto read = std::from_chars(text.data(), end, range.first);
    range.last = range.first;
    if (read.ec == std::errc{} && read.ptr < end && *read.ptr == '-')
        read = std::from_chars(read.ptr + 1, end, range.last);
    if (read.ec != std::errc{} || read.ptr != end || range.first > range.last || range.last >= all_cases)
        return {};
    return range;
}

TEST(RangeOfRandomSolids, is_refused_where_there_are_no_such_cases) {
    for (const char* text : {"0", "999", "0-999", "0-1999", "7-7", "100-199"})
        EXPECT_TRUE(range_of(text)) << text;
    EXPECT_EQ(range_of("100-199").value().first, 100u);
    EXPECT_EQ(range_of("100-199").value().last, 199u);
    for (const char* text :
         {"", "x", "5000-5009", "0-2000", "2000", "9-3", "3-", "-3", "1-2x", "99999999999"})
        EXPECT_FALSE(range_of(text)) << text;
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

// The vertices of a surface by place, and what they are joined to.
class SurfaceEdges {
  public:
    SurfaceEdges(const TetMesh& mesh, const Surface& surface) : mesh_(mesh) {
        for (const Corners& t : surface.triangles) {
            for (int k = 0; k < 3; ++k) joined_[mesh.points[t[k]]].push_back(t[(k + 1) % 3]);
        }
    }

    bool has(Vec3 p) const { return joined_.count(p) != 0; }

    // Whether a chain of edges runs from p to q within a millionth of their distance from the straight way.
    bool chain(Vec3 p, Vec3 q) const {
        const double tolerance = 1e-6 * length(q - p);
        for (Vec3 at = p; at != q;) {
            const auto found = joined_.find(at);
            if (found == joined_.end()) return false;
            const Vec3 way = normalized(q - p);
            Vec3 next = at;
            for (const std::uint32_t v : found->second) {
                const Vec3 u = mesh_.points[v];
                const double ahead = dot(u - at, way);
                if (ahead <= tolerance || dot(q - u, way) < -tolerance ||
                    length(cross(u - p, way)) > tolerance)
                    continue;
                if (next == at || ahead < dot(next - at, way)) next = u;
            }
            if (next == at) return false;
            at = next;
        }
        return true;
    }

  private:
    struct Less {
        bool operator()(Vec3 a, Vec3 b) const { return lexicographic_less(a, b); }
    };
    const TetMesh& mesh_;
    std::map<Vec3, std::vector<std::uint32_t>, Less> joined_;
};

// How far each contour's points are from the lines of the drawn contours of its structure in its slice.
double farthest_from_drawn(const ContourSet& kept, const ContourSet& drawn) {
    double farthest = 0;
    for (const Contour& contour : kept.contours) {
        for (const Vec3 p : kept.points_of(contour)) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Contour& other : drawn.contours_of(drawn.slices[contour.slice])) {
                if (other.structure != contour.structure) continue;
                const auto points = drawn.points_of(other);
                for (std::size_t n = 0; n < points.size(); ++n) {
                    const Vec3 a = points[n], way = points[(n + 1) % points.size()] - a;
                    const double along = std::clamp(dot(p - a, way) / squared_length(way), 0.0, 1.0);
                    nearest = std::min(nearest, length(p - a - along * way));
                }
            }
            farthest = std::max(farthest, nearest);
        }
    }
    return farthest;
}

// Re-routed contours are simple and apart from each other, and nowhere further from their
// planes and from what is drawn, nor that from them, than is reported; all others lie in their planes.
void expect_near_drawn(const Model& model, const ContourSet& drawn, double most_mm, double off_plane_mm) {
    const ContourSet& kept = model.contours;
    ASSERT_EQ(kept.contours.size(), drawn.contours.size());
    double reported = 0;
    std::map<std::string, double> reported_in;  // slices
    for (const RoutedContourReport& routed : model.report.contours.routed) {
        reported = std::max(reported, routed.farthest_mm);
        reported_in[routed.slice] = std::max(reported_in[routed.slice], routed.farthest_mm);
    }
    EXPECT_LE(reported, most_mm);
    constexpr double rounding = 1e-9;
    EXPECT_LE(farthest_from_drawn(kept, drawn), reported + rounding);
    EXPECT_LE(farthest_from_drawn(drawn, kept), reported + rounding);
    for (const Slice& slice : kept.slices) {
        double farthest = 0;
        for (const Contour& contour : kept.contours_of(slice)) {
            for (const Vec3 p : kept.points_of(contour))
                farthest = std::max(farthest, std::abs(slice.plane.signed_distance(p)));
        }
        const auto rerouted = reported_in.find(slice.name);
        EXPECT_LT(farthest, off_plane_mm + (rerouted == reported_in.end() ? 0 : rerouted->second))
            << slice.name;
        EXPECT_TRUE(slice_faults(plane_rings(kept, slice), kept.exclusive).empty()) << slice.name;
    }
}

// Every point of the kept contours is a vertex of its structure's surface, in the same bits; every segment is
// a chain of its edges, but for few of which the certificate says so.
Segments expect_contours_on_surface(const Case& drawn, const ContourSet& kept, const Model& model,
                                    std::uint32_t structure, const Surface& surface) {
    const SurfaceEdges edges(model.mesh, surface);
    std::size_t lost = 0, broken = 0, segments = 0;
    for (const Contour& contour : kept.contours) {
        if (contour.structure != structure) continue;
        const auto points = kept.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            lost += !edges.has(points[n]);
            broken += !edges.chain(points[n], points[(n + 1) % points.size()]);
        }
        segments += points.size();
    }
    EXPECT_EQ(lost, 0u) << "contour vertices off the surface";
    const StructureReport& report = model.report.structures[structure];
    EXPECT_EQ(report.fidelity.segments, segments);
    EXPECT_EQ(report.fidelity.segments - report.fidelity.segments_on_surface, broken);
    EXPECT_LE(broken, most_broken(drawn, segments)) << "of " << segments;
    if (broken > 0) {
        EXPECT_NE(model.report.certificate.at(1).state, ClauseState::kept);
    }
    return {segments, broken};
}

Segments expect_sound(const Case& drawn, const Model& model, const ContourSet& kept) {
    Segments segments;
    const TetMesh& mesh = model.mesh;
    EXPECT_EQ(fault_of_cells(mesh), "");
    EXPECT_GT(model.report.quality.dihedral_deg.min, flattest_degrees);
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
        const Segments own = expect_contours_on_surface(drawn, kept, model, s, surface);
        segments.all += own.all;
        segments.broken += own.broken;
        // It goes round every point once or not at all.
        const Box3 box = kept.box();
        for (int n = 0; n < 20; ++n) {
            const Vec3 p{random.between(box.low.x, box.high.x), random.between(box.low.y, box.high.y),
                         random.between(box.low.z, box.high.z)};
            const double turns = winding(mesh, surface, p);
            EXPECT_LT(std::min(std::abs(turns), std::abs(turns - 1)), 1e-6) << turns;
        }
    }
    return segments;
}

void expect_near_truth(const Case& drawn, const Model& model, const Bounds& bounds, bool printed) {
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
                to_model.max / drawn.spacing, volume, truth, offset,
                model.report.structures[s].surface.components,
                static_cast<long long>(model.report.structures[s].surface.genus));
        }
        EXPECT_LT(to_truth.mean, bounds.mean * drawn.spacing);
        EXPECT_LT(to_truth.p95, bounds.p95 * drawn.spacing);
        EXPECT_LT(to_model.mean, bounds.mean_missed * drawn.spacing);
        EXPECT_LT(to_model.p95, bounds.p95_missed * drawn.spacing);
        EXPECT_LT(std::abs(offset), bounds.offset);
    }
}

// The same bits again, with another number of threads.
void expect_same_again(const Model& model, const ContourSet& kept, const ModelOptions& options) {
    RunContext context;
    context.threads = 2;
    const auto again = build_model(kept, options, context);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again.value().mesh.points, model.mesh.points);
    EXPECT_EQ(again.value().mesh.cells, model.mesh.cells);
    EXPECT_EQ(again.value().mesh.regions, model.mesh.regions);
}

void check_case(std::uint32_t number, bool printed, Segments& segments) {
    const Case drawn = random_case(number);
    SCOPED_TRACE(drawn.name);
    RunContext context;
    auto cleaned = clean_contours(drawn.drawn, {}, context);
    if (!cleaned.ok()) {  // too few points for its turns: a drawing that crosses itself is refused
        EXPECT_TRUE(drawn.sampling.sparse);
        EXPECT_EQ(cleaned.error().code, "E-CON-006") << to_line(cleaned.error());
        return;
    }
    // Nothing is left out in silence.
    std::size_t left_out = 0;
    for (const ContourLog& log : cleaned.value().log) {
        EXPECT_FALSE(log.rule.empty()) << log.raw_contour;
        left_out += log.points_kept == 0;
    }
    EXPECT_EQ(cleaned.value().log.size(), drawn.drawn.contours.size());
    EXPECT_TRUE(left_out == 0 || !context.warnings.empty());
    merge_coincident(cleaned.value().kept, {});
    close_slivers(cleaned.value().kept, {});
    auto reconciled = reconcile_contours(std::move(cleaned).value().kept, {}, context);
    if (!reconciled.ok()) {  // refused where a contour would have to move too far
        EXPECT_EQ(drawn.spoiling, Spoiling::out_of_place);
        EXPECT_EQ(reconciled.error().code, "E-RCN-003") << to_line(reconciled.error());
        ++segments.refused;
        return;
    }
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
    options.max_reroute_mm = ReconcileOptions{}.max_disagreement_mm;
    if (drawn.planes == Planes::uneven) options.max_gap_spacings = 5;  // gaps are meant to be uneven
    const auto model = build_model(kept, options, context);
    if (printed) {
        std::map<std::string, int> codes;
        for (const Warning& warning : context.warnings) ++codes[warning.code];
        for (const auto& [code, count] : codes) std::printf("%s x%d ", code.c_str(), count);
    }
    ASSERT_TRUE(model.ok()) << to_line(model.error());
    if (number % repeated_every == 0) expect_same_again(model.value(), kept, options);
    const Segments own = expect_sound(drawn, model.value(), model.value().contours);
    // 1e-6 of the longest segments, or what is taken as it is.
    const double off_plane_mm =
        drawn.spoiling == Spoiling::none ? 2e-5 : CleanOptions{}.planes.plane_tolerance_mm;
    expect_near_drawn(model.value(), kept, 0.6 * model.value().report.lengths.size_mm, off_plane_mm);
    segments.all += own.all;
    segments.broken += own.broken;
    for (const SliceSectionReport& cut : model.value().report.contours.sections) {
        segments.cuts += cut.drawn_mm2 > 0;
        segments.cuts_off += cut.drawn_mm2 > 0 && cut.difference_mm2 > most_of_a_cut * cut.drawn_mm2;
    }
    if (printed) std::printf("segments %zu, no chains of edges %zu\n", own.all, own.broken);
    if (std::find(hardly_met.begin(), hardly_met.end(), number % coarse_cases) != hardly_met.end()) {
        EXPECT_TRUE(std::any_of(context.warnings.begin(), context.warnings.end(),
                                [](const Warning& w) { return w.code == "W-FLD-007"; }));
        return;
    }
    const bool fine = number >= coarse_cases && number < exact_cases;
    expect_near_truth(drawn, model.value(), fine ? fine_bounds : coarse_bounds, printed);
    if (printed) std::fflush(stdout);
}

// Vertices of a structure that lie nearer to another one's contour on their slice than copies of a line do,
// but not on it; none beside a vertex of both, where contours meet at an angle.
std::size_t slivers(const ContourSet& set) {
    std::size_t count = 0;
    for (const Contour& one : set.contours) {
        for (const Contour& other : set.contours_of(set.slices[one.slice])) {
            if (one.structure == other.structure) continue;
            const auto vertices = set.points_of(one), line = set.points_of(other);
            for (const Vec3& x : vertices) {
                const auto is_beside = [&](Vec3 y) {
                    return length(y - x) < MergeCoincidentOptions{}.width_mm &&
                           std::find(vertices.begin(), vertices.end(), y) != vertices.end();
                };
                if (std::any_of(line.begin(), line.end(), is_beside)) continue;
                double least = std::numeric_limits<double>::infinity();
                for (std::size_t n = 0; n < line.size(); ++n) {
                    const Vec3 a = line[n], way = line[(n + 1) % line.size()] - a;
                    const double t = std::clamp(dot(x - a, way) / squared_length(way), 0.0, 1.0);
                    least = std::min(least, length(a + t * way - x));
                }
                count += least < MergeCoincidentOptions{}.width_mm;
            }
        }
    }
    return count;
}

TEST(WallsOfRandomSolids, are_not_parted_where_slices_that_cross_are_made_to_agree) {
    std::size_t before = 0, after = 0, sets = 0;
    for (std::uint32_t number = 0; number < coarse_cases; ++number) {
        const Case drawn = random_case(number);
        if (drawn.structures.size() < 2 ||
            (drawn.planes != Planes::rotational && drawn.planes != Planes::crossing_stacks))
            continue;
        RunContext context;
        auto cleaned = clean_contours(drawn.drawn, {}, context);
        if (!cleaned.ok()) continue;
        ContourSet kept = std::move(cleaned).value().kept;
        merge_coincident(kept, {});
        before += slivers(kept);
        close_gaps(kept, {narrow_gap_mm});
        const auto reconciled = reconcile_contours(std::move(kept), {}, context);
        ASSERT_TRUE(reconciled.ok()) << drawn.name;
        after += slivers(reconciled.value().kept);
        ++sets;
    }
    EXPECT_GT(sets, 30u);
    EXPECT_LE(before, sets / 50);  // a segment may come nearer to a vertex as its ends move
    EXPECT_LT(after, sets / 2);
}

class RandomSolids : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(RandomSolids, are_modelled_soundly_and_near_the_truth) {
    const char* asked = std::getenv("ANATOMESH_RANDOM_SOLIDS");
    const std::optional<Range> cases = asked != nullptr ? range_of(asked) : Range{};
    ASSERT_TRUE(cases) << "ANATOMESH_RANDOM_SOLIDS=" << asked << ": cases are 0 to " << all_cases - 1;
    const auto [planes, part] = GetParam();
    Segments segments;
    for (std::uint32_t number = cases->first; number <= cases->last; ++number) {
        const auto drawing = static_cast<int>(number % coarse_cases);
        if (drawing % plane_sets == planes && drawing / plane_sets % parts == part)
            check_case(number, asked != nullptr, segments);
    }
    if (asked != nullptr) return;  // a few of them tell nothing of all
    EXPECT_GT(segments.all, 1000u);
    EXPECT_LT(static_cast<double>(segments.broken),
              broken_in_all[static_cast<std::size_t>(planes)] * static_cast<double>(segments.all));
    EXPECT_GT(segments.cuts, 100u);
    EXPECT_LE(static_cast<double>(segments.cuts_off),
              cuts_off_in_all[static_cast<std::size_t>(planes)] * static_cast<double>(segments.cuts));
    EXPECT_EQ(segments.refused, 0u);
}

class RandomSolidsInFiles : public testing::TestWithParam<int> {};

// A few of them: all with the environment variable.
TEST_P(RandomSolidsInFiles, rounded_or_out_of_place_are_modelled_soundly_and_near_the_truth) {
    if (std::getenv("ANATOMESH_RANDOM_SOLIDS") != nullptr) GTEST_SKIP() << "those of the range run above";
    const auto planes = static_cast<std::uint32_t>(GetParam());
    const bool about_an_axis = static_cast<Planes>(planes) == Planes::rotational;
    const std::uint32_t step = (about_an_axis ? sparsely_about_an_axis : sparsely) * plane_sets;
    Segments segments;
    for (const std::uint32_t first : {exact_cases, exact_cases + coarse_cases}) {
        for (std::uint32_t drawing = planes; drawing < coarse_cases; drawing += step)
            check_case(first + drawing, false, segments);
    }
    EXPECT_GT(segments.all, 1000u);
    EXPECT_LT(static_cast<double>(segments.broken), broken_in_files * static_cast<double>(segments.all));
    EXPECT_LE(segments.refused, most_refused);
}

std::string name_of_planes(int planes) {
    std::string name = plane_set_names[static_cast<std::size_t>(planes)];
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

std::string name_of(const testing::TestParamInfo<std::tuple<int, int>>& info) {
    const auto [planes, part] = info.param;
    return name_of_planes(planes) + "_" + std::to_string(part);
}

INSTANTIATE_TEST_SUITE_P(plane_sets, RandomSolidsInFiles, testing::Range(0, plane_sets),
                         [](const auto& set) { return name_of_planes(set.param); });
INSTANTIATE_TEST_SUITE_P(plane_sets, RandomSolids,
                         testing::Combine(testing::Range(0, plane_sets), testing::Range(0, parts)), name_of);

}  // namespace
}  // namespace anatomesh::random_solids_test
