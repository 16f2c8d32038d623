#include "anatomesh/field/slice/slice_stack.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/field/slice/bit_volume.h"
#include "anatomesh/field/slice/distance_raster.h"
#include "anatomesh/field/slice/slice_regions.h"

namespace anatomesh {

namespace {

// A slice may be so far off its place in an even stack, because headers round positions.
// [spacings; 0 to 0.5; D digits of files]
constexpr double even_share = 0.02;

Error stack_error(ErrorKind kind, const char* code, std::string message, const ContourSet& set,
                  std::string slice, std::string next_step) {
    return {kind, code, std::move(message), {set.source, std::move(slice), "", "", ""}, std::move(next_step)};
}

Box2 box_of(const ContourSet& set, const Plane& frame) {
    Box2 box;
    for (const Contour& contour : set.contours)
        for (const Vec3& point : set.points_of(contour)) box.extend(frame.to_plane(point));
    return box;
}

double found_pixel(const ContourSet& set, const Box2& box) {
    std::vector<double> lengths;
    for (const Contour& contour : set.contours) {
        const auto points = set.points_of(contour);
        for (std::size_t i = 0; i < points.size(); ++i)
            lengths.push_back(length(points[(i + 1) % points.size()] - points[i]));
    }
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    const double side = std::max(box.high.x - box.low.x, box.high.y - box.low.y);
    return std::max({*middle, side / 1024, 1e-6});
}

// Which place each slice takes, in steps of `spacing` from the first. E-FLD-005 where one takes none.
Result<std::vector<std::uint32_t>> places(const ContourSet& set, const Plane& frame, double spacing) {
    std::vector<std::uint32_t> place(set.slices.size());
    std::vector<double> at;
    for (const Slice& slice : set.slices) at.push_back(frame.signed_distance(slice.plane.origin));
    const double first = *std::min_element(at.begin(), at.end());
    double before = -1;
    for (std::size_t s = 0; s < at.size(); ++s) {
        const double steps = spacing > 0 ? (at[s] - first) / spacing : 0, whole = std::round(steps);
        if (std::abs(steps - whole) > even_share || whole == before || whole > 1e6)
            return stack_error(ErrorKind::geometry, "E-FLD-005",
                               "the slices are not equidistant, and an image needs equidistant ones", set,
                               set.slices[s].name, "choose equidistant slices with --every and --offset");
        place[s] = static_cast<std::uint32_t>(whole);
        before = whole;
    }
    return place;
}

// The regions of the slice at place k, in the stack's coordinates.
std::vector<SliceRegion> regions_at(const ContourSet& set, const SliceStack& stack, std::size_t k) {
    if (stack.slice[k] == SliceStack::none) return {};
    return slice_regions(set, stack.slice[k], stack.frame);
}

// How thick a slice alone is.
double thickness_of_one(const ContourSet& set, double asked_mm, double pixel, RunContext& context) {
    if (asked_mm > 0) return asked_mm;
    const bool is_stated = set.slice_thickness_mm > 0;
    const double thickness = is_stated ? set.slice_thickness_mm : pixel;
    const Place place{set.source, set.slices.front().name, "", "", brief(thickness) + " mm"};
    if (is_stated)
        context.warn(
            {"W-FLD-013",
             "everything is drawn on one slice, so that nothing shows how it goes on above and below", place,
             "the image is as thick as the source says that a slice is; --slice-thickness gives another "
             "thickness"});
    else
        context.warn({"W-FLD-015", "everything is drawn on one slice, and nothing says how thick it is",
                      place, "the image is one pixel thick; --slice-thickness states the thickness"});
    return thickness;
}

}  // namespace

Result<SliceStack> slice_stack(const ContourSet& set, const SliceStackOptions& options, RunContext& context) {
    if (set.contours.empty())
        return stack_error(ErrorKind::geometry, "E-FLD-001", "the input has no contours", set, "",
                           "choose a structure that has contours");
    if (!all_parallel(set, parallel_tolerance_mm))
        return stack_error(ErrorKind::geometry, "E-FLD-004",
                           "the slices are not parallel, and an image needs parallel ones", set, "",
                           "leave out the slices of other directions with --without");
    SliceStack stack;
    stack.frame = set.slices.front().plane;
    const Box2 box = box_of(set, stack.frame);
    const double pixel = options.pixel_mm > 0 ? options.pixel_mm
                         : set.pixel_mm > 0   ? set.pixel_mm
                                              : found_pixel(set, box);
    const double gap = median_spacing(set),
                 spacing = gap > 0 ? gap : thickness_of_one(set, options.slice_mm, pixel, context);
    ANATOMESH_TRY(const std::vector<std::uint32_t> place, places(set, stack.frame, spacing));

    const double margin = options.margin_pixels;
    const Vec2 first{std::floor(box.low.x / pixel) - margin, std::floor(box.low.y / pixel) - margin};
    const Vec2 last{std::ceil(box.high.x / pixel) + margin, std::ceil(box.high.y / pixel) + margin};
    const double nx = last.x - first.x + 1, ny = last.y - first.y + 1;
    const double nz = *std::max_element(place.begin(), place.end()) + 1.0;
    if (nx * ny * nz > static_cast<double>(options.max_voxels) || std::max(nx, ny) > 1e6)
        return stack_error(ErrorKind::limit, "E-FLD-006",
                           "the image would have more voxels than the limit allows", set, "",
                           "give a larger --pixel, or --limit voxels=N");
    stack.grid = {
        pixel * first, {pixel, pixel}, static_cast<std::uint32_t>(nx), static_cast<std::uint32_t>(ny)};
    stack.slice.assign(static_cast<std::size_t>(nz), SliceStack::none);
    std::size_t lowest = 0;
    for (std::size_t s = 0; s < place.size(); ++s) {
        stack.slice[place[s]] = static_cast<std::uint32_t>(s);
        if (place[s] == 0) lowest = s;
    }
    if (const std::size_t missing = stack.slice.size() - place.size(); missing > 0)
        context.warn({"W-FLD-006",
                      "slices are missing between those with contours",
                      {set.source, "", "", "", std::to_string(missing)},
                      "they are empty in the image"});
    ImageGeometry& geometry = stack.geometry;
    geometry.size = {stack.grid.nx, stack.grid.ny, static_cast<std::uint32_t>(stack.slice.size())};
    geometry.step = {pixel * stack.frame.u, pixel * stack.frame.v, spacing * stack.frame.normal};
    const double up = stack.frame.signed_distance(set.slices[lowest].plane.origin);
    geometry.origin = stack.frame.to_space(stack.grid.low) + up * stack.frame.normal;
    return stack;
}

LabelMap bit_image(const ContourSet& set, const SliceStack& stack, RunContext& context,
                   std::uint64_t* overlaps) {
    LabelMap labels;
    labels.geometry = stack.geometry;
    labels.structures = set.structures;
    labels.source = set.source;
    labels.voxels.assign(stack.geometry.voxel_count(), 0);
    std::atomic<std::uint64_t> in_several = 0;
    parallel_for(stack.slice.size(), 1, context.threads, [&](std::size_t k, std::size_t) {
        if (context.cancelled()) return;
        std::uint64_t here = 0;
        for (const SliceRegion& region : regions_at(set, stack, k)) {
            BitVolume bits(stack.grid, 1);
            bits.fill(0, region.edges);
            std::size_t voxel = k * stack.grid.nx * stack.grid.ny;
            for (std::uint32_t j = 0; j < stack.grid.ny; ++j) {
                for (std::uint32_t i = 0; i < stack.grid.nx; ++i, ++voxel) {
                    if (!bits.inside(i, j, 0)) continue;
                    here += labels.voxels[voxel] != 0;
                    labels.voxels[voxel] = static_cast<std::uint16_t>(region.structure + 1);
                }
            }
        }
        in_several += here;
    });
    if (overlaps) *overlaps = in_several;
    return labels;
}

std::vector<float> distance_image(const ContourSet& set, const SliceStack& stack, std::uint32_t structure,
                                  RunContext& context) {
    const std::size_t pixels = std::size_t{stack.grid.nx} * stack.grid.ny;
    const double diagonal = stack.grid.step.x * std::hypot(stack.grid.nx, stack.grid.ny);
    std::vector<float> image(stack.geometry.voxel_count(), static_cast<float>(diagonal));
    parallel_for(stack.slice.size(), 1, context.threads, [&](std::size_t k, std::size_t) {
        if (context.cancelled()) return;
        for (const SliceRegion& region : regions_at(set, stack, k)) {
            if (region.structure != structure) continue;
            const std::vector<double> distance = distance_raster(region.edges, stack.grid);
            std::transform(distance.begin(), distance.end(),
                           image.begin() + static_cast<std::ptrdiff_t>(k * pixels),
                           [](double value) { return static_cast<float>(value); });
        }
    });
    return image;
}

}  // namespace anatomesh
