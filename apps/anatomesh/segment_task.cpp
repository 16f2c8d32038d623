#include "segment_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "anatomesh/image/components.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/segment/segment_slices.h"

namespace anatomesh {

namespace {

constexpr std::pair<const char*, SegmentMethod> methods[] = {
    {"threshold", SegmentMethod::threshold}, {"otsu", SegmentMethod::otsu},
    {"grow", SegmentMethod::grow},           {"confidence", SegmentMethod::confidence},
    {"region", SegmentMethod::region},       {"geodesic", SegmentMethod::geodesic},
    {"chan-vese", SegmentMethod::chan_vese}};

Error task_error(const char* code, std::string message, const LoadedImage& image, const SegmentTask& task,
                 std::string value, std::string next_step) {
    return {ErrorKind::usage,
            code,
            std::move(message),
            {image.image.source, "", task.name == "structure" ? "" : task.name, "", std::move(value)},
            std::move(next_step)};
}

bool is_seeded(const SegmentTask& task) {
    return !task.seeds.empty() || !task.voxel_seeds.empty();
}

// The method, as given or as the other options imply it.
std::string method_of(const SegmentTask& task) {
    if (!task.method.empty()) return task.method;
    if (task.threshold) return is_seeded(task) ? "grow" : "threshold";
    return is_seeded(task) ? "geodesic" : "otsu";
}

// Options that the method cannot do without, or has no use for.
Status check_method(const SegmentTask& task, const LoadedImage& image, const std::string& name,
                    SegmentMethod method) {
    const bool seeded = is_seeded(task);
    const bool ranged = method == SegmentMethod::threshold || method == SegmentMethod::grow;
    const bool grows = method != SegmentMethod::threshold && method != SegmentMethod::otsu;
    const bool moves = method == SegmentMethod::region || method == SegmentMethod::geodesic ||
                       method == SegmentMethod::chan_vese;
    const bool spreads = method == SegmentMethod::region || method == SegmentMethod::geodesic ||
                         method == SegmentMethod::confidence;
    if (grows && !seeded)
        return task_error("E-SGM-005", "the method needs a seed", image, task, name,
                          "give --seed X,Y,Z, a point inside the structure in mm (LPS)");
    if (ranged && !task.threshold)
        return task_error("E-SGM-006", "the method needs a range of values", image, task, name,
                          "give --threshold LO[:HI]");
    if (method == SegmentMethod::geodesic && (task.per_slice || !image.poses.empty()))
        return task_error("E-SGM-012", "the method geodesic does not work from slice to slice", image, task,
                          name, "give --method region or chan-vese");
    const std::pair<const char*, bool> useless[] = {
        {"--threshold", task.threshold && !ranged}, {"--seed", seeded && !grows},
        {"--spread", task.spread && !spreads},      {"--seed-radius", task.radius_mm && !spreads && !moves},
        {"--curvature", task.curvature && !moves},  {"--iterations", task.iterations && !moves}};
    for (const auto& [option, given] : useless) {
        if (given)
            return task_error("E-CMD-008", fmt::format("{} does not apply to this method", option), image,
                              task, name, fmt::format("leave out {}, or choose another --method", option));
    }
    return Nothing{};
}

// The voxel, in fractions, that a position lies at.
Vec3 voxel_at(const ImageGeometry& geometry, Vec3 position) {
    const Vec3 w = position - geometry.origin, a = geometry.step[0], b = geometry.step[1],
               c = geometry.step[2];
    const double volume = dot(a, cross(b, c));
    return {dot(w, cross(b, c)) / volume, dot(a, cross(w, c)) / volume, dot(a, cross(b, w)) / volume};
}

// Of frames with poses: the frame whose plane is nearest to the position, and the pixel there.
Vec3 pixel_at(const LoadedImage& image, Vec3 position) {
    Vec3 found;
    double nearest = 1e300;
    for (const FramePose& pose : image.poses) {
        const Vec3 w = position - pose.origin;
        const double away = std::abs(dot(w, normalized(cross(pose.step[0], pose.step[1]))));
        const double i = dot(w, pose.step[0]) / squared_length(pose.step[0]),
                     j = dot(w, pose.step[1]) / squared_length(pose.step[1]);
        const auto& size = image.image.geometry.size;
        const bool is_in = i > -0.5 && j > -0.5 && i < size[0] - 0.5 && j < size[1] - 0.5;
        if (!is_in || away >= nearest) continue;
        nearest = away;
        found = {i, j, double{1} * pose.frame};
    }
    return nearest < 1e300 ? found : Vec3{-1, -1, -1};
}

Status add_seed(Vec3 voxel, Vec3 given, const SegmentTask& task, const LoadedImage& image,
                SegmentOptions& segmenting) {
    const std::array<double, 3> at = {std::round(voxel.x), std::round(voxel.y), std::round(voxel.z)};
    const auto& size = image.image.geometry.size;
    std::array<std::uint32_t, 3> seed{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(at[axis] >= 0 && at[axis] < size[axis]))
            return task_error(
                "E-SGM-007", "a seed lies outside the image, or outside the box of --within", image, task,
                fmt::format("{},{},{}, which is voxel {:.0f}, {:.0f}, {:.0f} of {} x {} x {}", given.x,
                            given.y, given.z, at[0], at[1], at[2], size[0], size[1], size[2]),
                "give --seed in mm (LPS: x to the left, y to the back), or --seed-voxel as indices from 0");
        seed[axis] = static_cast<std::uint32_t>(at[axis]);
    }
    segmenting.seeds.push_back(seed);
    return Nothing{};
}

// A part of an image: a range of voxels along each axis.
struct ImagePart {
    std::array<std::uint32_t, 3> first{0, 0, 0}, size{0, 0, 0};
};

// The voxels between the two corners, those of the corners included.
Result<ImagePart> part_of(const SegmentTask& task, const LoadedImage& image) {
    const ImageGeometry& geometry = image.image.geometry;
    if (task.within.empty()) return ImagePart{{0, 0, 0}, geometry.size};
    if (!image.poses.empty())
        return task_error("E-CMD-008", "--within does not apply to a tracked sequence of frames", image, task,
                          "", "leave out --within");
    const Vec3 a = voxel_at(geometry, task.within[0]), b = voxel_at(geometry, task.within[1]);
    const std::array<double, 3> low{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
        high{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
    ImagePart part;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = std::max(std::round(low[axis]), 0.0),
                     last = std::min(std::round(high[axis]), geometry.size[axis] - 1.0);
        if (!(first <= last))
            return task_error(
                "E-SGM-013", "the box of --within lies outside the image", image, task,
                fmt::format("voxels {:.0f} to {:.0f} along axis {} of {}", std::round(low[axis]),
                            std::round(high[axis]), axis + 1, geometry.size[axis]),
                "give two corners in mm (LPS: x to the left, y to the back)");
        part.first[axis] = static_cast<std::uint32_t>(first);
        part.size[axis] = static_cast<std::uint32_t>(last - first) + 1;
    }
    return part;
}

// Calls body(index in the image, index in the part, voxels) for every row of the part.
template <class Body>
void each_row(const ImageGeometry& geometry, const ImagePart& part, Body&& body) {
    for (std::uint32_t k = 0; k < part.size[2]; ++k)
        for (std::uint32_t j = 0; j < part.size[1]; ++j)
            body(static_cast<std::ptrdiff_t>(
                     geometry.index(part.first[0], part.first[1] + j, part.first[2] + k)),
                 static_cast<std::ptrdiff_t>((std::size_t{k} * part.size[1] + j) * part.size[0]),
                 static_cast<std::ptrdiff_t>(part.size[0]));
}

LoadedImage cut_out(const LoadedImage& image, const ImagePart& part) {
    const ImageGeometry& geometry = image.image.geometry;
    LoadedImage cut;
    cut.image.source = image.image.source;
    cut.image.geometry = geometry;
    cut.image.geometry.size = part.size;
    cut.image.geometry.origin = geometry.position(part.first[0], part.first[1], part.first[2]);
    cut.image.voxels.resize(cut.image.geometry.voxel_count());
    each_row(geometry, part, [&](std::ptrdiff_t from, std::ptrdiff_t to, std::ptrdiff_t count) {
        std::copy_n(image.image.voxels.begin() + from, count, cut.image.voxels.begin() + to);
    });
    return cut;
}

// The labels of a part in the whole image.
void put_back(LabelMap& labels, const ImageGeometry& geometry, const ImagePart& part) {
    std::vector<std::uint16_t> voxels(geometry.voxel_count());
    each_row(geometry, part, [&](std::ptrdiff_t to, std::ptrdiff_t from, std::ptrdiff_t count) {
        std::copy_n(labels.voxels.begin() + from, count, voxels.begin() + to);
    });
    labels.voxels = std::move(voxels);
    labels.geometry = geometry;
}

Result<SegmentOptions> segmenting_of(const SegmentTask& task, SegmentMethod method,
                                     const LoadedImage& image) {
    SegmentOptions segmenting;
    segmenting.method = method;
    if (task.threshold) {
        segmenting.low = task.threshold->low;
        segmenting.high = task.threshold->high;
    }
    if (task.radius_mm) segmenting.seed_radius_mm = *task.radius_mm;
    if (task.spread) segmenting.spread = *task.spread;
    if (task.curvature) segmenting.curvature = *task.curvature;
    if (task.iterations) segmenting.iterations = *task.iterations;
    for (const Vec3 seed : task.seeds) {
        const Vec3 voxel = image.poses.empty() ? voxel_at(image.image.geometry, seed) : pixel_at(image, seed);
        ANATOMESH_CHECK_STATUS(add_seed(voxel, seed, task, image, segmenting));
    }
    for (const Vec3 seed : task.voxel_seeds) {
        ANATOMESH_CHECK_STATUS(add_seed(seed, seed, task, image, segmenting));
    }
    return segmenting;
}

std::uint64_t voxels_inside(const LabelMap& labels) {
    return labels.voxels.size() -
           static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), 0));
}

// Each slice cleaned by itself; one of which nothing is left is empty.
Status clean_slices(LabelMap& labels, const SegmentTask& task, bool largest_of_slice, RunContext& context) {
    const std::size_t pixels = std::size_t{labels.geometry.size[0]} * labels.geometry.size[1];
    LabelMap slice;
    slice.geometry = labels.geometry;
    slice.geometry.size[2] = 1;
    slice.structures = labels.structures;
    slice.source = labels.source;
    for (std::uint32_t k = 0; k < labels.geometry.size[2]; ++k) {
        const auto first = labels.voxels.begin() + static_cast<std::ptrdiff_t>(k * pixels);
        slice.voxels.assign(first, first + static_cast<std::ptrdiff_t>(pixels));
        if (voxels_inside(slice) == 0) continue;
        const Status cleaned = clean_mask(slice, task.cleaning, context);
        if (!cleaned.ok() && cleaned.error().code != "E-SGM-004") return cleaned;
        if (task.keep_largest && largest_of_slice) keep_largest(slice, *task.keep_largest);
        std::copy(slice.voxels.begin(), slice.voxels.end(), first);
    }
    return Nothing{};
}

}  // namespace

const std::vector<std::string> segment_methods{"threshold", "otsu",     "grow",     "confidence",
                                               "region",    "geodesic", "chan-vese"};

namespace {

Result<TaskResult> run_in(const SegmentTask& task, const LoadedImage& image, RunContext& context) {
    TaskResult result;
    result.method = method_of(task);
    const SegmentMethod method = std::find_if(std::begin(methods), std::end(methods), [&](const auto& entry) {
                                     return entry.first == result.method;
                                 })->second;
    ANATOMESH_CHECK_STATUS(check_method(task, image, result.method, method));
    result.by_value =
        method == SegmentMethod::threshold || method == SegmentMethod::otsu || method == SegmentMethod::grow;
    ANATOMESH_TRY(const SegmentOptions segmenting, segmenting_of(task, method, image));
    const bool is_tracked = !image.poses.empty();
    if (task.per_slice || is_tracked) {
        SliceOptions slices;
        for (const FramePose& pose : image.poses) slices.order.push_back(pose.frame);
        ANATOMESH_TRY(result.segmentation, segment_slices(image.image, segmenting, slices, context));
    } else {
        ANATOMESH_TRY(result.segmentation, segment_image(image.image, segmenting, context));
    }
    LabelMap& labels = result.segmentation.labels;
    labels.structures[0].name = task.name;
    labels.structures[0].number = static_cast<std::int32_t>(task.number);
    if (task.per_slice || is_tracked) {
        ANATOMESH_CHECK_STATUS(clean_slices(labels, task, is_tracked, context));
    } else {
        ANATOMESH_CHECK_STATUS(clean_mask(labels, task.cleaning, context));
    }
    if (task.keep_largest && !is_tracked) keep_largest(labels, *task.keep_largest);
    result.voxels = voxels_inside(labels);
    if (result.voxels > 0) return result;
    return Error{ErrorKind::geometry,
                 "E-SGM-004",
                 "the clean-up removes all of the structure",
                 {labels.source, "", task.name, "", ""},
                 "give smaller radii to --median and --open"};
}

}  // namespace

Result<TaskResult> run_task(const SegmentTask& task, const LoadedImage& image, RunContext& context) {
    ANATOMESH_TRY(const ImagePart part, part_of(task, image));
    const ImageGeometry& geometry = image.image.geometry;
    if (part.size == geometry.size) return run_in(task, image, context);
    SegmentTask inside = task;
    for (Vec3& seed : inside.voxel_seeds)
        seed = seed - Vec3{1.0 * part.first[0], 1.0 * part.first[1], 1.0 * part.first[2]};
    ANATOMESH_TRY(TaskResult result, run_in(inside, cut_out(image, part), context));
    put_back(result.segmentation.labels, geometry, part);
    return result;
}

// ---- recipes

namespace {

using RecipeJson = nlohmann::json;

class RecipeReader {
  public:
    explicit RecipeReader(const std::string& path) : path_(path) {}

    Result<std::vector<SegmentTask>> read(std::string_view text) {
        const RecipeJson recipe = RecipeJson::parse(text, nullptr, false);
        if (!recipe.is_object() || !recipe.contains("format") || recipe["format"] != "anatomesh-recipe")
            return failure("the file is no JSON object with \"format\": \"anatomesh-recipe\"", "");
        if (recipe.contains("version") && recipe["version"] != 1)
            return failure("its \"version\" is not 1", "");
        if (!recipe.contains("structures") || !recipe["structures"].is_array() ||
            recipe["structures"].empty())
            return failure("\"structures\" is missing or empty", "");
        std::vector<SegmentTask> tasks;
        for (const RecipeJson& each : recipe["structures"]) {
            ANATOMESH_TRY(SegmentTask task, task_of(each, static_cast<std::uint32_t>(tasks.size()) + 1));
            for (const SegmentTask& other : tasks)
                if (other.number == task.number || other.name == task.name)
                    return failure("two structures have the same number or name", task.name);
            tasks.push_back(std::move(task));
        }
        return tasks;
    }

  private:
    Error failure(const std::string& message, const std::string& structure) const {
        return {ErrorKind::input,
                "E-SGM-009",
                "the recipe cannot be followed: " + message,
                {path_, "", structure, "", ""},
                "see the recipe in docs/formats.md"};
    }

    Result<SegmentTask> task_of(const RecipeJson& json, std::uint32_t place) const {
        SegmentTask task;
        task.number = place;
        task.name = fmt::format("structure {}", place);
        if (!json.is_object()) return failure("a structure is not an object", task.name);
        if (json.contains("name") && json["name"].is_string()) task.name = json["name"].get<std::string>();
        for (const auto& [key, value] : json.items())
            if (!take(key, value, task))
                return failure(
                    fmt::format("the key \"{}\" is unknown, or its value is not possible", key.substr(0, 40)),
                    task.name);
        return task;
    }

    static bool number_in(const RecipeJson& value, double low, double high) {
        return value.is_number() && value.get<double>() >= low && value.get<double>() <= high;
    }
    static bool count_in(const RecipeJson& value, std::uint32_t low, std::uint32_t high) {
        return value.is_number_unsigned() && value.get<std::uint64_t>() >= low &&
               value.get<std::uint64_t>() <= high;
    }
    static bool take_number(const RecipeJson& value, double low, double high, double& target) {
        if (!number_in(value, low, high)) return false;
        target = value.get<double>();
        return true;
    }
    static bool take_optional(const RecipeJson& value, double low, double high,
                              std::optional<double>& target) {
        return take_number(value, low, high, target.emplace());
    }
    static bool take_flag(const RecipeJson& value, bool& target) {
        if (!value.is_boolean()) return false;
        target = value.get<bool>();
        return true;
    }
    static bool take_points(const RecipeJson& value, bool whole, std::vector<Vec3>& target) {
        if (!value.is_array()) return false;
        for (const RecipeJson& point : value) {
            if (!point.is_array() || point.size() != 3) return false;
            for (const RecipeJson& x : point)
                if (whole ? !count_in(x, 0, 1'000'000) : !number_in(x, -1e7, 1e7)) return false;
            target.push_back({point[0].get<double>(), point[1].get<double>(), point[2].get<double>()});
        }
        return true;
    }
    static bool take_threshold(const RecipeJson& value, std::optional<ThresholdOptions>& target) {
        target.emplace();
        if (value.is_number()) return take_number(value, -1e15, 1e15, target->low);
        if (!value.is_array() || value.size() != 2 || !take_number(value[0], -1e15, 1e15, target->low))
            return false;
        return value[1].is_null() || take_number(value[1], target->low, 1e15, target->high);
    }

    static bool take(const std::string& key, const RecipeJson& value, SegmentTask& task) {
        if (key == "name") return value.is_string() && !task.name.empty();
        if (key == "number") {
            if (!count_in(value, 1, 65535)) return false;
            task.number = value.get<std::uint32_t>();
            return true;
        }
        if (key == "method") {
            if (!value.is_string()) return false;
            task.method = value.get<std::string>();
            return std::find(segment_methods.begin(), segment_methods.end(), task.method) !=
                   segment_methods.end();
        }
        if (key == "threshold") return take_threshold(value, task.threshold);
        if (key == "seeds") return take_points(value, false, task.seeds);
        if (key == "seed_voxels") return take_points(value, true, task.voxel_seeds);
        if (key == "within") return take_points(value, false, task.within) && task.within.size() == 2;
        if (key == "seed_radius") return take_optional(value, 0.01, 1000, task.radius_mm);
        if (key == "spread") return take_optional(value, 0.01, 100, task.spread);
        if (key == "curvature") return take_optional(value, 0, 100, task.curvature);
        if (key == "median") return take_number(value, 0, 100, task.cleaning.median_mm);
        if (key == "open") return take_number(value, 0, 100, task.cleaning.open_mm);
        if (key == "close") return take_number(value, 0, 100, task.cleaning.close_mm);
        if (key == "fill_holes") return take_flag(value, task.cleaning.fill_holes);
        if (key == "per_slice") return take_flag(value, task.per_slice);
        for (const auto& [name, low, high, target] :
             {std::tuple{"iterations", 1u, 100'000u, &task.iterations},
              {"keep_largest", 1u, 1'000'000u, &task.keep_largest}})
            if (key == name) {
                if (!count_in(value, low, high)) return false;
                *target = value.get<std::uint32_t>();
                return true;
            }
        return false;
    }

    const std::string& path_;
};

}  // namespace

Result<std::vector<SegmentTask>> read_recipe(const std::string& path, const InputLimits& limits) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, limits));
    const auto bytes = file.bytes();
    return RecipeReader(path).read({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace anatomesh
