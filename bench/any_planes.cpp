#include "any_planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/measure/hausdorff.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/random_solids_for_test.h"
#include "anatomesh/read_input.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile_options.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

using random_solids::Random;

constexpr int samples = 10'000;
constexpr double reach = 20;  // mm; of distances in a plane
constexpr double most = 15;   // mm; what is further off counts as much

// The truth, moved so that its centre lies at the origin.
struct Truth {
    std::shared_ptr<const StructureField> field;
    Vec3 centre;
    double radius = 0;
    double distance(Vec3 p) const { return field->value(0, p + centre); }
    // By differences over +-h mm: over a pixel or more where the direction counts, since voxels make steps.
    Vec3 slope(Vec3 p, double h = 0.3) const {
        const auto along = [&](Vec3 way) { return (distance(p + way) - distance(p - way)) / (2 * h); };
        return {along({h, 0, 0}), along({0, h, 0}), along({0, 0, h})};
    }
};

Truth truth_of(const ContourSet& set, std::shared_ptr<const StructureField> field) {
    const Box3 box = set.box();
    return {std::move(field), 0.5 * (box.low + box.high), 0.5 * box.diagonal()};
}

std::vector<Plane> planes_of(const CutOptions& cut, double radius) {
    std::vector<Plane> planes;
    Random random(4);
    const double count = cut.planes, pi = std::numbers::pi;
    for (std::uint32_t k = 0; k < cut.planes; ++k) {
        if (cut.kind == "fan") {
            const double a = (-45 + 90 * k / (count - 1)) * pi / 180;
            planes.push_back(make_plane({0, 0, -120}, {std::cos(a), 0, -std::sin(a)}));
        } else if (cut.kind == "axis") {
            const double a = pi * k / count;
            planes.push_back(make_plane({}, {std::cos(a), std::sin(a), 0}));
        } else if (cut.kind == "stacks") {
            const Vec3 normals[]{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            const double at = -radius + 2 * radius * (k / 3 + 0.5) / std::ceil(count / 3);
            planes.push_back(make_plane(at * normals[k % 3], normals[k % 3]));
        } else {
            const Vec3 normal{1, 0.1 * std::sin(k / 40.0) + 0.01 * random.between(-1, 1),
                              0.08 * std::cos(k / 55.0) + 0.01 * random.between(-1, 1)};
            planes.push_back(make_plane({-radius + 2 * radius * k / (count - 1), 0, 0}, normal));
        }
    }
    return planes;
}

RawContours contours_of(const Truth& truth, const std::vector<Plane>& planes, double spacing) {
    RawContours raw;
    raw.structures.push_back({1, "solid", {}});
    random_solids::Sampling sampling;
    sampling.grid = spacing;
    for (const Plane& plane : planes) {
        random_solids::SectionTracer tracer(plane, truth.radius, sampling);
        for (const std::vector<Vec3>& loop : tracer.trace(truth, 0)) {
            RawContour contour;
            contour.first_point = static_cast<std::uint32_t>(raw.points.size());
            contour.point_count = static_cast<std::uint32_t>(loop.size());
            contour.plane = static_cast<std::int32_t>(raw.planes.size());
            raw.contours.push_back(contour);
            raw.points.insert(raw.points.end(), loop.begin(), loop.end());
        }
        raw.planes.push_back(plane);
        raw.plane_names.push_back(fmt::format("{}", raw.planes.size()));
    }
    return raw;
}

// The distances that the planes draw, each in itself.
class DrawnPlanes {
  public:
    explicit DrawnPlanes(const ContourSet& set) : patches_(plane_patches(set)), maps_(patches_.size()) {
        for (std::uint32_t k = 0; k < patches_.size(); ++k) {
            maps_[k].resize(set.structures.size());
            for (SliceRegion& region : slice_regions(set, k, patches_[k].plane))
                maps_[k][region.structure].emplace(std::move(region.edges), reach);
        }
    }

    // By the nearest plane alone, or the mean of the two nearest, weighted with the nearness.
    double value(std::uint32_t structure, Vec3 p, bool nearest_alone) const {
        double first = 1e300, second = 1e300, a = reach, b = reach;
        for (std::size_t k = 0; k < patches_.size(); ++k) {
            if (patches_[k].box.empty()) continue;
            const double distance = length(patches_[k].offset_from(p, reach));
            if (distance >= second) continue;
            const auto& map = maps_[k][structure];
            const double value = map ? map->value(patches_[k].plane.to_plane(p)) : reach;
            if (distance < first) {
                second = first, b = a;
                first = distance, a = value;
            } else {
                second = distance, b = value;
            }
        }
        if (nearest_alone || first + second == 0) return a;
        return (a * second + b * first) / (first + second);
    }

  private:
    std::vector<PlanePatch> patches_;
    std::vector<std::vector<std::optional<DistanceMap>>> maps_;  // by plane and structure
};

std::string mean_and_p95(std::vector<double> distances) {
    if (distances.empty()) return "- | -";
    std::sort(distances.begin(), distances.end());
    double sum = 0;
    for (const double distance : distances) sum += distance;
    return fmt::format("{:.2f} | {:.2f}", sum / static_cast<double>(distances.size()),
                       distances[distances.size() * 95 / 100]);
}

// Whether planes lie on both sides of the point: beyond a fan's sides nothing is known.
bool within(const CutOptions& cut, Vec3 p) {
    return cut.kind != "fan" || std::abs(std::atan2(p.x, p.z + 120)) <= std::numbers::pi / 4;
}

// Where a boundary should be, and across it.
struct SurfacePlace {
    Vec3 at, normal;
    std::uint32_t structure = 0;
};

// Points of the true surface; of a fan, only within it.
std::vector<SurfacePlace> surface_places(const Truth& truth, const CutOptions& cut) {
    std::vector<SurfacePlace> places;
    Random random(1);
    while (places.size() < samples) {
        Vec3 p = truth.radius * Vec3{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        if (std::abs(truth.distance(p)) > 1.5) continue;
        for (int step = 0; step < 6; ++step) {
            const Vec3 slope = truth.slope(p);
            if (squared_length(slope) < 0.05) break;
            p = p - (truth.distance(p) / squared_length(slope)) * slope;
        }
        if (std::abs(truth.distance(p)) > 0.05 || squared_length(truth.slope(p)) < 0.05) continue;
        if (within(cut, p)) places.push_back({p, normalized(truth.slope(p, 1.5)), 0});
    }
    return places;
}

// The vertices of one contour, with the normals in its plane.
void add_places(const ContourSet& set, const Contour& contour, std::vector<SurfacePlace>& places) {
    const auto points = set.points_of(contour);
    const Vec3 across = set.slices[contour.slice].plane.normal;
    const std::size_t count = points.size();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 normal = cross(points[(k + 1) % count] - points[(k + count - 1) % count], across);
        if (squared_length(normal) > 0) places.push_back({points[k], normalized(normal), contour.structure});
    }
}

// Mean and 95 % of the distances from the places to where `inside` changes, along the normals.
template <class Inside>
std::string errors_of(const std::vector<SurfacePlace>& places, Inside inside) {
    std::vector<double> errors;
    for (const auto& [p, n, structure] : places) {
        const bool start = inside(structure, p);
        double near = 0, far = 0.05;
        const auto changes = [&](double s) {
            return inside(structure, p + s * n) != start || inside(structure, p - s * n) != start;
        };
        while (far < most && !changes(far)) near = far, far *= 1.15;
        for (int step = 0; far < most && step < 10; ++step) {
            const double half = 0.5 * (near + far);
            (changes(half) ? far : near) = half;
        }
        errors.push_back(std::min(far, most));
    }
    return mean_and_p95(std::move(errors));
}

std::string errors_of_all(const std::vector<SurfacePlace>& places, const ContourSet& kept,
                          const StructureField& field) {
    const DrawnPlanes drawn(kept);
    return fmt::format("{} | {} | {}",
                       errors_of(places, [&](auto s, Vec3 p) { return drawn.value(s, p, true) < 0; }),
                       errors_of(places, [&](auto s, Vec3 p) { return drawn.value(s, p, false) < 0; }),
                       errors_of(places, [&](auto s, Vec3 p) { return field.value(s, p) < 0; }));
}

// How far the nearest point of the true surface is, by steps along its slope.
double distance_from_truth(const Truth& truth, Vec3 from) {
    Vec3 p = from;
    for (int step = 0; step < 12; ++step) {
        const Vec3 slope = truth.slope(p);
        if (squared_length(slope) < 0.05) break;
        p = p - (truth.distance(p) / squared_length(slope)) * slope;
    }
    return std::min(most, std::max(length(p - from), std::abs(truth.distance(from))));
}

// The model of the contours: distances of the true surface from it and of its surface from the truth.
Result<std::string> errors_of_model(const Truth& truth, const std::vector<SurfacePlace>& places,
                                    const CutOptions& cut, const ContourSet& kept, RunContext& context) {
    const auto start = std::chrono::steady_clock::now();
    ANATOMESH_TRY(const Model model, build_model(kept, {}, context));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const SurfaceMesh surface = extract_interfaces(model.mesh);
    const ClosestPoint closest(surface);
    std::vector<double> to_model, to_truth;
    for (const SurfacePlace& place : places) to_model.push_back(std::min(most, closest.distance(place.at)));
    for (const Vec3& p : area_samples(surface, samples)) {
        if (within(cut, p)) to_truth.push_back(distance_from_truth(truth, p));
    }
    std::size_t segments = 0, missed = 0;
    for (const StructureReport& structure : model.report.structures) {
        segments += structure.fidelity.segments;
        missed += structure.fidelity.segments - structure.fidelity.segments_on_surface;
    }
    return fmt::format("{} | {} | {} of {} | {} | {:.1f}", mean_and_p95(std::move(to_model)),
                       mean_and_p95(std::move(to_truth)), missed, segments, model.mesh.cells.size(), seconds);
}

// Without every n-th slice.
ContourSet leave_out(std::uint32_t every, const ContourSet& set) {
    std::vector<std::uint32_t> kept;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (s % every != every - 1) kept.push_back(s);
    }
    return chosen_slices(set, kept);
}

std::string name_of(const InputOptions& options) {
    return std::filesystem::path(options.input).filename().string();
}

}  // namespace

Status cut_planes(const InputOptions& options, const CutOptions& cut, bool header) {
    RunContext context;
    context.threads = 2;
    ANATOMESH_TRY(OpenedInput opened, open_input(options, context));
    ANATOMESH_TRY(const InputContours all, contours_of(std::move(opened), options, context));
    ANATOMESH_TRY(auto whole, make_structure_field(all.kept, {}, context));
    const Truth truth = truth_of(all.kept, std::move(whole));
    const RawContours raw = contours_of(truth, planes_of(cut, truth.radius), cut.spacing_mm);
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, {}, context));
    ANATOMESH_TRY(const ReconcileResult reconciled, reconcile_contours(std::move(cleaned.kept), {}, context));
    const ContourSet& kept = reconciled.kept;
    ANATOMESH_TRY(const auto field, make_structure_field(kept, {}, context));
    const std::vector<SurfacePlace> places = surface_places(truth, cut);
    ANATOMESH_TRY(const std::string of_model, errors_of_model(truth, places, cut, kept, context));
    if (header) {
        fmt::print(
            "| input | planes | points | nearest plane: mean, mm | 95 % | shape-based: mean | 95 % "
            "| ours, the field: mean | 95 % | truth to model: mean | 95 % | model to truth: mean | 95 % "
            "| segments missed | tetrahedra | s |\n"
            "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    }
    fmt::print("| {} | {} {} | {} | {} | {} |\n", name_of(options), kept.slices.size(), cut.kind,
               kept.points.size(), errors_of_all(places, kept, *field), of_model);
    return Nothing{};
}

Status leave_out_planes(const InputOptions& options, std::uint32_t every, bool header) {
    RunContext context;
    context.threads = 2;
    ANATOMESH_TRY(OpenedInput opened, open_input(options, context));
    ANATOMESH_TRY(const InputContours all, contours_of(std::move(opened), options, context));
    std::vector<SurfacePlace> places;
    for (std::uint32_t s = every - 1; s < all.kept.slices.size(); s += every) {
        for (const Contour& contour : all.kept.contours_of(all.kept.slices[s]))
            add_places(all.kept, contour, places);
    }
    ContourSet part = leave_out(every, all.kept);
    ANATOMESH_CHECK_STATUS(check_reconcile_options(part, options));
    const ReconcileOptions reconcile = reconcile_options(options.prepare);
    ANATOMESH_TRY(const ReconcileResult reconciled, reconcile_contours(std::move(part), reconcile, context));
    const ContourSet& kept = reconciled.kept;
    ANATOMESH_TRY(const auto field, make_structure_field(kept, {}, context));
    if (header) {
        fmt::print(
            "| input | kept contours | planes kept | vertices compared | nearest plane: mean, mm | 95 % | "
            "shape-based: mean | 95 % | ours: mean | 95 % "
            "|\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    }
    const std::string_view state = !reconcile.reconcile ? "as drawn"
                                   : reconcile.align    ? "shifted, reconciled"
                                                        : "reconciled";
    fmt::print("| {} | {} | {} | {} | {} |\n", name_of(options), state, kept.slices.size(), places.size(),
               errors_of_all(places, kept, *field));
    return Nothing{};
}

}  // namespace anatomesh
