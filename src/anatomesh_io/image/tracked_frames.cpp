#include "anatomesh_io/image/tracked_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>

#include "anatomesh/geom/numbers.h"
#include "anatomesh/image/components.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

constexpr std::string_view frame_prefix = "Seq_Frame", transform_suffix = "Transform",
                           status_suffix = "TransformStatus", image_status = "ImageStatus";

// Lengths and cosines of a rotation may be so far off 1 and 0, because headers have six digits.
// [1; 0 to 0.1; D digits of files]
constexpr double rotation_tolerance = 0.005;

// x -> the columns of a 3 x 3 matrix times x, plus a translation.
struct Affine {
    std::array<Vec3, 3> columns{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    Vec3 shift;

    Vec3 apply(Vec3 p) const { return p.x * columns[0] + p.y * columns[1] + p.z * columns[2] + shift; }
};

Affine after(const Affine& second, const Affine& first) {
    Affine both;
    for (std::size_t c = 0; c < 3; ++c) both.columns[c] = second.apply(first.columns[c]) - second.shift;
    both.shift = second.apply(first.shift);
    return both;
}

std::optional<Affine> inverse(const Affine& of) {
    const auto& [a, b, c] = of.columns;
    const double volume = dot(a, cross(b, c));
    if (!(std::abs(volume) > 1e-12)) return std::nullopt;
    const Vec3 rows[3] = {(1 / volume) * cross(b, c), (1 / volume) * cross(c, a), (1 / volume) * cross(a, b)};
    Affine back;
    back.columns = {Vec3{rows[0].x, rows[1].x, rows[2].x}, Vec3{rows[0].y, rows[1].y, rows[2].y},
                    Vec3{rows[0].z, rows[1].z, rows[2].z}};
    back.shift = Vec3{} - Vec3{dot(rows[0], of.shift), dot(rows[1], of.shift), dot(rows[2], of.shift)};
    return back;
}

std::optional<Affine> affine_of(const std::vector<double>& m) {
    if (m.size() != 16 && m.size() != 12) return std::nullopt;
    for (const double value : m)
        if (!std::isfinite(value)) return std::nullopt;
    const bool has_last_row = m.size() == 16;
    if (has_last_row && (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)) return std::nullopt;
    Affine affine;
    for (std::size_t c = 0; c < 3; ++c) affine.columns[c] = {m[c], m[4 + c], m[8 + c]};
    affine.shift = {m[3], m[7], m[11]};
    return affine;
}

bool is_mirrored(const Affine& affine) {
    return dot(affine.columns[0], cross(affine.columns[1], affine.columns[2])) < 0;
}
bool is_rotation(const Affine& affine) {
    for (std::size_t c = 0; c < 3; ++c) {
        if (!(std::abs(length(affine.columns[c]) - 1) <= rotation_tolerance)) return false;
        if (!(std::abs(dot(affine.columns[c], affine.columns[(c + 1) % 3])) <= rotation_tolerance))
            return false;
    }
    return true;
}

// "ProbeToTracker" is from Probe to Tracker.
struct Name {
    std::string from, to;
    friend auto operator<=>(const Name&, const Name&) = default;
};
std::optional<Name> name_of(std::string_view text) {
    for (std::size_t at = text.find("To", 1); at != std::string_view::npos; at = text.find("To", at + 1))
        if (at + 2 < text.size() && text[at + 2] >= 'A' && text[at + 2] <= 'Z')
            return Name{std::string(text.substr(0, at)), std::string(text.substr(at + 2))};
    return std::nullopt;
}

struct Transform {
    std::string_view numbers;
    bool is_ok = true;
};
using Transforms = std::map<Name, Transform>;

// What a key says: of which frame (nothing: of all), and of which transform the matrix or the status, or the
// status of the frame's pixels.
struct Key {
    std::optional<std::uint64_t> frame;
    Name name;
    bool is_status = false, is_of_pixels = false;
};
std::optional<Key> key_of(std::string_view text) {
    Key key;
    if (text.starts_with(frame_prefix)) {
        text.remove_prefix(frame_prefix.size());
        const std::size_t bar = text.find('_');
        if (bar == std::string_view::npos) return std::nullopt;
        const auto number = parse_integer(text.substr(0, bar));
        if (!number || *number < 0) return std::nullopt;
        key.frame = static_cast<std::uint64_t>(*number);
        text.remove_prefix(bar + 1);
    }
    if (key.frame && text == image_status) {
        key.is_of_pixels = true;
        return key;
    }
    key.is_status = text.ends_with(status_suffix);
    if (!key.is_status && !text.ends_with(transform_suffix)) return std::nullopt;
    text.remove_suffix(key.is_status ? status_suffix.size() : transform_suffix.size());
    const auto name = name_of(text);
    if (!name) return std::nullopt;
    key.name = *name;
    return key;
}

class PoseReader {
  public:
    PoseReader(const KeyValues& keys, const std::array<std::uint64_t, 3>& sizes, const std::string& path,
               const ReadImageOptions& options, RunContext& context)
        : sizes_(sizes), path_(path), options_(options), context_(context) {
        for (const auto& [key, value] : keys) {
            if (key == "UltrasoundImageOrientation") orientation_ = value;
            const auto found = key_of(key);
            if (!found || (found->frame && *found->frame >= sizes[2])) continue;
            if (found->is_of_pixels) {
                if (value != "OK") without_pixels_.insert(*found->frame);
                continue;
            }
            Transform& transform = (found->frame ? of_frame_[*found->frame] : of_all_)[found->name];
            if (found->is_status)
                transform.is_ok = value == "OK";
            else
                transform.numbers = value;
            names_[found->name] = true;
        }
        if (!options.image_to_probe.empty()) names_[{"Image", "Probe"}] = true;
    }

    Result<std::vector<FramePose>> read() {
        ANATOMESH_TRY(const std::vector<Step> way, find_way());
        ANATOMESH_TRY(const Affine upright, image_orientation());
        std::vector<FramePose> poses;
        for (const auto& [number, transforms] : of_frame_) {
            if (without_pixels_.contains(number)) continue;
            const auto frame = static_cast<std::uint32_t>(number);
            ANATOMESH_TRY(const std::optional<Affine> pose, pose_of(frame, transforms, way));
            if (!pose) continue;
            ANATOMESH_TRY(const FramePose placed, placed_pose(frame, after(*pose, upright)));
            poses.push_back(placed);
        }
        if (poses.empty())
            return failure("E-TRK-004", "no frame of the sequence has both a pose and an image", "",
                           "record it again with the tools in sight of the tracker");
        warn_of_left_out(sizes_[2] - poses.size());
        if (!options_.frame)
            context_.warn(image_warning(
                "W-TRK-002", "the poses of the frames do not refer to the axes of a patient", path_, target_,
                "the numbers were kept; --frame LPS or --frame RAS names the axes"));
        return poses;
    }

  private:
    struct Step {
        Name name;
        bool is_inverse = false;
    };

    Error failure(const char* code, const std::string& message, const std::string& value,
                  const std::string& next) const {
        return image_error(code, message, path_, shown(value), next);
    }

    void warn_of_left_out(std::uint64_t frames) const {
        if (frames == 0) return;
        const std::uint64_t blank = without_pixels_.size(), lost = frames - blank;
        const std::string no_image = "no image (ImageStatus is not OK)";
        const std::string lacks = blank == 0  ? "no pose"
                                  : lost == 0 ? no_image
                                              : fmt::format("no pose ({}) or {} ({})", lost, no_image, blank);
        context_.warn(image_warning("W-TRK-001", "frames of the sequence have " + lacks, path_,
                                    fmt::format("{} of {}", frames, sizes_[2]), "they were left out"));
    }

    // The shortest way from Image to the target over the transforms there are and their inverses.
    Result<std::vector<Step>> find_way() {
        std::map<std::string, std::vector<Step>> ways{{"Image", {}}};
        std::deque<std::string> open{"Image"};
        while (!open.empty()) {
            const std::string at = open.front();
            open.pop_front();
            for (const auto& [name, unused] : names_)
                for (const bool is_inverse : {false, true}) {
                    if ((is_inverse ? name.to : name.from) != at) continue;
                    const std::string& next = is_inverse ? name.from : name.to;
                    if (ways.contains(next)) continue;
                    ways[next] = ways[at];
                    ways[next].push_back({name, is_inverse});
                    open.push_back(next);
                }
        }
        const std::vector<std::string> targets =
            options_.pose_to.empty() ? std::vector<std::string>{"Reference", "Tracker", "World"}
                                     : std::vector{options_.pose_to};
        for (const std::string& target : targets)
            if (const auto way = ways.find(target); way != ways.end() && !way->second.empty()) {
                target_ = target;
                return way->second;
            }
        std::string list;
        for (const auto& [name, unused] : names_)
            list += (list.empty() ? "" : ", ") + shown(name.from) + "To" + shown(name.to);
        return image_error(
            "E-TRK-001",
            fmt::format("the sequence has no transforms from Image to {}; it has {}",
                        options_.pose_to.empty() ? "Reference, Tracker or World" : options_.pose_to, list),
            path_, "",
            names_.contains({"Image", "Probe"})
                ? "choose another target with --pose-to"
                : "give the calibration of the probe with --image-to-probe, 12 or 16 numbers");
    }

    // Tools and rooms lie to each other by rotations; a calibration scales pixels, but mirrors no more than
    // they.
    Status check_part(std::uint32_t frame, const Name& name, const Affine& part) const {
        const std::string which =
            fmt::format("the transform {}To{} of frame {}", shown(name.from), shown(name.to), frame);
        const bool is_calibration = name.from == "Image" || name.to == "Image";
        if (is_mirrored(part))
            return failure(
                "E-TRK-007", which + " mirrors the image: its determinant is negative", "",
                is_calibration
                    ? "check which side of the probe is marked; if the first two columns are right, change "
                      "the sign of the third one in --image-to-probe"
                    : "correct the header of the sequence");
        if (!is_calibration && !is_rotation(part))
            return failure("E-TRK-003",
                           which + " is no rotation: its axes are not at right angles, or not of length 1",
                           "", "correct the header of the sequence");
        return Nothing{};
    }

    Result<std::optional<Affine>> pose_of(std::uint32_t frame, const Transforms& of_frame,
                                          const std::vector<Step>& way) const {
        Affine pose;
        for (const Step& step : way) {
            std::optional<Affine> part;
            if (step.name == Name{"Image", "Probe"} && !options_.image_to_probe.empty()) {
                part = affine_of(options_.image_to_probe);
                if (!part)
                    return failure("E-TRK-002", "--image-to-probe is no matrix of 3 or 4 rows", "",
                                   "give 12 or 16 numbers, row by row");
            } else {
                const auto own = of_frame.find(step.name), all = of_all_.find(step.name);
                if (own == of_frame.end() && all == of_all_.end()) return std::optional<Affine>{};
                const Transform& transform = own != of_frame.end() ? own->second : all->second;
                if (!transform.is_ok) return std::optional<Affine>{};
                std::vector<double> numbers;
                for (const std::string_view word : words(transform.numbers))
                    numbers.push_back(parse_double(word).value_or(std::nan("")));
                part = affine_of(numbers);
                if (!part)
                    return failure(
                        "E-TRK-002",
                        fmt::format("the transform {}To{} of frame {} is no affine matrix of 16 numbers",
                                    shown(step.name.from), shown(step.name.to), frame),
                        std::string(transform.numbers), "correct the header of the sequence");
            }
            ANATOMESH_CHECK_STATUS(check_part(frame, step.name, *part));
            if (step.is_inverse) part = inverse(*part);
            if (!part)
                return failure("E-TRK-002",
                               fmt::format("the transform {}To{} of frame {} cannot be inverted",
                                           shown(step.name.from), shown(step.name.to), frame),
                               "", "correct the header of the sequence");
            pose = after(*part, pose);
        }
        return std::optional(pose);
    }

    // From pixels as stored to pixels from the marked side of the probe (M) away from it (F).
    Result<Affine> image_orientation() const {
        Affine upright;
        if (orientation_.empty()) return upright;
        const char across = orientation_[0], along = orientation_.size() > 1 ? orientation_[1] : '?';
        if ((across != 'M' && across != 'U') || (along != 'F' && along != 'N'))
            return failure("E-TRK-006",
                           "the orientation of the ultrasound image is not one of MF, UF, MN, UN",
                           orientation_, "export the sequence with the orientation MF");
        if (across == 'U') {
            upright.columns[0].x = -1;
            upright.shift.x = static_cast<double>(sizes_[0]) - 1;
        }
        if (along == 'N') {
            upright.columns[1].y = -1;
            upright.shift.y = static_cast<double>(sizes_[1]) - 1;
        }
        return upright;
    }

    Result<FramePose> placed_pose(std::uint32_t frame, const Affine& pose) const {
        FramePose placed{frame, pose.shift, {pose.columns[0], pose.columns[1]}};
        if (options_.frame == ImageFrame::ras)
            for (Vec3* v : {&placed.origin, &placed.step[0], &placed.step[1]})
                *v = {0 - v->x, 0 - v->y, v->z};
        const double across = length(placed.step[0]), along = length(placed.step[1]);
        const auto unusable = [&](const std::string& what) {
            return failure("E-TRK-003", fmt::format("the pose of frame {} {}", frame, what),
                           fmt::format("pixels of {:.4g} x {:.4g} mm", across, along),
                           "check the calibration and the transforms of the sequence");
        };
        if (!(across > 1e-6 && across < 1e4 && along > 1e-6 && along < 1e4))
            return unusable("has pixels of an impossible size");
        if (!(std::abs(dot(placed.step[0], placed.step[1])) <= 0.01 * across * along))
            return unusable("has axes that are not at right angles");
        for (const double coordinate : {placed.origin.x, placed.origin.y, placed.origin.z})
            if (!(std::abs(coordinate) <= coordinate_bound_mm)) return unusable("lies beyond 1e7 mm");
        return placed;
    }

    std::array<std::uint64_t, 3> sizes_;
    const std::string& path_;
    const ReadImageOptions& options_;
    RunContext& context_;
    std::map<std::uint64_t, Transforms> of_frame_;
    Transforms of_all_;
    std::map<Name, bool> names_;
    std::set<std::uint64_t> without_pixels_;
    std::string orientation_, target_;
};

// One contour set of the slices of many, in their order. Structures are those of the label map.
class SliceJoiner {
  public:
    explicit SliceJoiner(const std::vector<Structure>& structures) { all_.structures = structures; }

    void add(const ContourSet& set, const std::string& name) {
        std::vector<std::uint32_t> index;
        for (const Structure& structure : set.structures)
            for (std::uint32_t s = 0; s < all_.structures.size(); ++s)
                if (all_.structures[s].number == structure.number) index.push_back(s);
        for (Slice slice : set.slices) {
            if (slice.contour_count == 0) continue;
            const auto first = static_cast<std::uint32_t>(all_.contours.size());
            for (Contour contour : set.contours_of(slice)) {
                const auto points = set.points_of(contour);
                contour.structure = index[contour.structure];
                contour.slice = static_cast<std::uint32_t>(all_.slices.size());
                contour.first_point = static_cast<std::uint32_t>(all_.points.size());
                all_.points.insert(all_.points.end(), points.begin(), points.end());
                all_.contours.push_back(contour);
            }
            slice.first_contour = first;
            slice.name = name;
            all_.slices.push_back(std::move(slice));
        }
        all_.exclusive = set.exclusive;
        all_.drawn = set.drawn;
        all_.pixel_mm = set.pixel_mm;
    }
    ContourSet take() && { return std::move(all_); }

  private:
    ContourSet all_;
};

}  // namespace

bool has_tracked_frames(const KeyValues& keys) {
    return std::any_of(keys.begin(), keys.end(), [](const auto& pair) {
        const auto key = pair.first.starts_with(frame_prefix) ? key_of(pair.first) : std::nullopt;
        return key && !key->is_of_pixels;
    });
}

Result<std::vector<FramePose>> read_poses(const KeyValues& keys, const std::array<std::uint64_t, 3>& sizes,
                                          const std::string& path, const ReadImageOptions& options,
                                          RunContext& context) {
    if (!options.tracked)
        return image_error("E-TRK-005", "the file is a tracked sequence of frames, not a volume", path, "",
                           "use anatomesh segment, contours or model, which read its frames as slices");
    return PoseReader(keys, sizes, path, options, context).read();
}

ImageGeometry geometry_of(const FramePose& pose, std::uint32_t columns, std::uint32_t rows) {
    return {{columns, rows, 1},
            pose.origin,
            {pose.step[0], pose.step[1], normalized(cross(pose.step[0], pose.step[1]))}};
}

Result<TraceResult> trace_frames(const LabelMap& labels, const std::vector<FramePose>& poses, Frame frame,
                                 const GreyImage* grey, double threshold, std::uint32_t largest,
                                 const TraceOptions& options, RunContext& context) {
    const auto& size = labels.geometry.size;
    const std::size_t pixels = std::size_t{size[0]} * size[1];
    SliceJoiner joiner(labels.structures);
    TraceResult result;
    for (std::size_t p = options.offset; p < poses.size(); p += options.every) {
        const FramePose& pose = poses[p];
        if (context.cancelled()) return cancelled_error();
        const auto first = static_cast<std::ptrdiff_t>(pose.frame * pixels);
        LabelMap slice;
        slice.geometry = geometry_of(pose, size[0], size[1]);
        slice.structures = labels.structures;
        slice.source = labels.source;
        slice.voxels.assign(labels.voxels.begin() + first,
                            labels.voxels.begin() + first + static_cast<std::ptrdiff_t>(pixels));
        if (largest > 0) keep_largest(slice, largest);
        if (std::all_of(slice.voxels.begin(), slice.voxels.end(), [](auto label) { return label == 0; }))
            continue;
        GreyImage image;
        if (grey) {
            image.geometry = slice.geometry;
            image.source = grey->source;
            image.voxels.assign(grey->voxels.begin() + first,
                                grey->voxels.begin() + first + static_cast<std::ptrdiff_t>(pixels));
        }
        TraceOptions tracing = options;
        tracing.every = 1;
        tracing.offset = 0;
        RunContext quiet;  // structures that are absent from one frame are no news
        quiet.threads = context.threads;
        const auto traced = trace_contours(slice, grey ? &image : nullptr, threshold, tracing, quiet);
        if (!traced.ok()) {
            if (traced.error().kind == ErrorKind::geometry) continue;  // islands alone
            return traced.error();
        }
        const TraceStats& stats = traced.value().stats;
        joiner.add(traced.value().kept, fmt::format("frame {}", pose.frame));
        result.stats.points_traced += stats.points_traced;
        result.stats.points_kept += stats.points_kept;
        result.stats.islands_left_out += stats.islands_left_out;
        result.stats.area_left_out_mm2 += stats.area_left_out_mm2;
        result.stats.holes_filled += stats.holes_filled;
        result.stats.area_filled_mm2 += stats.area_filled_mm2;
        result.stats.epsilon_mm = stats.epsilon_mm;
        result.stats.max_distance_mm = std::max(result.stats.max_distance_mm, stats.max_distance_mm);
    }
    result.kept = std::move(joiner).take();
    result.kept.frame = frame;
    result.kept.source = labels.source;
    result.stats.slices = static_cast<std::uint32_t>(result.kept.slices.size());
    result.stats.contours = static_cast<std::uint32_t>(result.kept.contours.size());
    if (result.kept.contours.empty())
        return Error{ErrorKind::geometry,
                     "E-TRC-001",
                     "no frame of the sequence has a contour",
                     {labels.source, "", "", "", ""},
                     "choose another threshold or method"};
    if (result.stats.islands_left_out > 0)
        context.warn(
            {"W-TRC-002",
             fmt::format("{} islands are smaller than the minimum area", result.stats.islands_left_out),
             {labels.source, "", "", "", fmt::format("{:.4g} mm2", result.stats.area_left_out_mm2)},
             "they were left out; --min-area 0 keeps them"});
    return result;
}

}  // namespace anatomesh
