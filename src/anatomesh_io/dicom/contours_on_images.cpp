#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/choose.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// Contours lie on an image up to this distance from its plane: both positions are rounded in files.
// [mm; 0 to 1; D digits of files]
constexpr double same_plane_mm = 0.05;

// Contours nearer to each other along the normal lie in one plane. [mm; > 0; D digits of files]
constexpr double distinct_planes_mm = 1e-4;
// More planes of contours on an image in the mean are a shrunken set: its slices lie within the tolerance of one image.
// [planes; >= 2; C]
constexpr std::uint64_t most_planes_on_image = 3;

enum class Lies : std::uint8_t { on, between, outside, across };

// The planes of a series, parallel to its first one.
class ImagePlanes {
  public:
    ImagePlanes(const DicomFolder& folder, const std::vector<std::uint32_t>& images) {
        for (const std::uint32_t index : images) {
            if (!folder.objects[index].known_axes) continue;  // contours are in the patient's axes
            for (const DicomFrame& plane : folder.objects[index].planes) {
                if (!first_) first_ = &plane;
                planes_.push_back({dot(plane.position, normal()), &plane});
            }
        }
        std::sort(planes_.begin(), planes_.end(),
                  [](const Placed& a, const Placed& b) { return a.height < b.height; });
    }
    bool empty() const { return !first_; }
    Vec3 normal() const { return cross(first_->row, first_->column); }
    double spacing() const {
        return planes_.size() > 1 ? (planes_.back().height - planes_.front().height) /
                                        static_cast<double>(planes_.size() - 1)
                                  : 1;
    }
    // Where a contour lies when its coordinates are multiplied by `scale`, the nearest image, how far that is away, and
    // how far the contour reaches beyond the images: beyond their pixels, or beyond the first or the last one. mm
    struct Place {
        Lies lies = Lies::across;
        double away = 0;
        const DicomFrame* image = nullptr;
        double beyond = 0;
    };
    Place place_of(const RawContours& contours, const RawContour& contour, double scale) const {
        double low = 1e300, high = -1e300;
        for (std::uint32_t p = 0; p < contour.point_count; ++p) {
            const double height = dot(scale * contours.points[contour.first_point + p], normal());
            low = std::min(low, height);
            high = std::max(high, height);
        }
        if (high - low > same_plane_mm) return {};
        const Placed& nearest = nearest_to((low + high) / 2);
        const double away = std::abs(nearest.height - (low + high) / 2);
        if (low < planes_.front().height - spacing() || high > planes_.back().height + spacing())
            return {Lies::outside, away, nearest.frame, away};
        double nearest_aside = 1e300, farthest_aside = 0;
        for (std::uint32_t p = 0; p < contour.point_count; ++p) {
            const double aside = aside_of(scale * contours.points[contour.first_point + p], *nearest.frame);
            nearest_aside = std::min(nearest_aside, aside);
            farthest_aside = std::max(farthest_aside, aside);
        }
        if (nearest_aside > 0) return {Lies::outside, away, nearest.frame, farthest_aside};
        return {away > same_plane_mm ? Lies::between : Lies::on, away, nearest.frame, farthest_aside};
    }

  private:
    struct Placed {
        double height = 0;
        const DicomFrame* frame = nullptr;
    };

    const Placed& nearest_to(double height) const {
        const auto above = std::lower_bound(planes_.begin(), planes_.end(), height,
                                            [](const Placed& plane, double h) { return plane.height < h; });
        if (above == planes_.begin()) return *above;
        if (above == planes_.end()) return planes_.back();
        return above->height - height < height - (above - 1)->height ? *above : *(above - 1);
    }

    // How far a point lies beside the pixels of an image, wherever along the normal; 0 on them. With a gantry tilt each
    // image is shifted against the one before it. mm
    static double aside_of(Vec3 point, const DicomFrame& image) {
        const Vec3 p = point - image.position;
        const auto beyond = [](double at, double spacing, double count) {
            return std::max({-0.5 * spacing - at, at - (count - 0.5) * spacing, 0.0});
        };
        return std::hypot(beyond(dot(p, image.row), image.spacing[0], image.columns),
                          beyond(dot(p, image.column), image.spacing[1], image.rows));
    }

    const DicomFrame* first_ = nullptr;
    std::vector<Placed> planes_;
};

// The contour that reaches farthest beyond its images, of those that do.
struct FarthestBeyond {
    std::uint64_t count = 0;
    const RawContour* contour = nullptr;
    double mm = 0;

    void add(const RawContour& one, double beyond) {
        ++count;
        if (contour != nullptr && beyond <= mm) return;
        contour = &one;
        mm = beyond;
    }
};

struct Counts {
    std::uint64_t on = 0, between = 0, outside = 0;
    FarthestBeyond wholly, partly;         // of the contours that lie outside, and of the others
    std::uint64_t planes = 0, images = 0;  // planes of contours, and images that these lie on
    double worst = 0;

    bool all_are_on() const { return on > 0 && between + outside == 0; }
    bool are_crowded() const { return planes >= most_planes_on_image * std::max<std::uint64_t>(images, 1); }
};

Counts count_places(const RawContours& contours, const ImagePlanes& images, double scale) {
    Counts counts;
    std::set<const DicomFrame*> used;
    double before = 1e300;
    for (const RawContour& contour : contours.contours) {
        if (contour.point_count == 0) continue;
        const auto [lies, away, image, beyond] = images.place_of(contours, contour, scale);
        counts.on += lies == Lies::on;
        counts.between += lies == Lies::between;
        counts.outside += lies == Lies::outside;
        if (lies == Lies::outside) counts.wholly.add(contour, beyond);
        if (lies != Lies::outside && beyond > same_plane_mm) counts.partly.add(contour, beyond);
        if (lies == Lies::between) counts.worst = std::max(counts.worst, away);
        if (lies == Lies::on) used.insert(image);
        const double height = dot(contours.points[contour.first_point], images.normal());
        counts.planes += std::abs(height - before) > distinct_planes_mm;
        before = height;
    }
    counts.images = used.size();
    return counts;
}

// Coordinates that do not fit the images as mm, or all of which lie on a few of them, and that fit as another unit.
Status check_unit(const RawContours& contours, const ImagePlanes& images, const Counts& as_mm) {
    if ((as_mm.between + as_mm.outside == 0 && !as_mm.are_crowded()) || as_mm.planes < 3) return Nothing{};
    for (const auto& [scale, unit] : {std::pair{10.0, "cm"}, {1000.0, "m"}}) {
        const Counts scaled = count_places(contours, images, scale);
        if (!scaled.all_are_on() || scaled.are_crowded()) continue;
        return Error{
            ErrorKind::input,
            "E-DCM-038",
            fmt::format("the contours do not lie on the images they refer to, but would if their "
                        "coordinates were in {}",
                        unit),
            {contours.source, {}, {}, {}, {}},
            fmt::format("give --unit {} to read them so, or --unit mm to take them as they are", unit)};
    }
    return Nothing{};
}

// The contour, and how far it reaches beyond its images.
Place place_beyond(const RawContours& contours, const FarthestBeyond& farthest) {
    const RawContour& contour = *farthest.contour;
    const Structure& structure = contours.structures[contour.structure];
    const Vec3 at = contours.points[contour.first_point];
    return {contours.source, contour.slice.empty() ? fmt::format("z = {:.6g}", at.z) : contour.slice,
            structure.name.empty() ? std::to_string(structure.number) : structure.name, contour.name,
            fmt::format("{:.3g} mm outside", farthest.mm)};
}

std::optional<Vec3> first_point(std::string_view data) {
    double xyz[3];
    for (double& value : xyz) {
        const std::size_t end = std::min(data.find('\\'), data.size());
        std::string_view word = data.substr(0, end);
        while (!word.empty() && word.front() == ' ') word.remove_prefix(1);
        while (!word.empty() && (word.back() == ' ' || word.back() == '\0')) word.remove_suffix(1);
        const auto number = parse_number(word);
        if (!number) return std::nullopt;
        value = *number;
        data.remove_prefix(std::min(end + 1, data.size()));
    }
    return Vec3{xyz[0], xyz[1], xyz[2]};
}

// The frame of a multi-frame image that a reference names, from 1; 0: it names none.
std::uint64_t named_frame(const DicomItem& reference) {
    std::string_view text = reference.text(tags::referenced_frame_number);
    text = text.substr(0, text.find('\\'));  // of several the first
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
    const auto number = parse_number(text);
    // A DICOM integer string has so many digits at most. [1; > 0; D PS3.5, 6.2]
    constexpr double largest_integer = 2147483647;
    return number && *number >= 1 && *number <= largest_integer ? static_cast<std::uint64_t>(*number) : 0;
}

}  // namespace

Result<bool> check_against_images(const RawContours& contours, const DicomFolder& folder,
                                  const std::vector<std::uint32_t>& images, const AcceptContours& accept,
                                  RunContext& context) {
    const ImagePlanes planes(folder, images);
    if (planes.empty()) return false;
    const Counts counts = count_places(contours, planes, 1);
    if (!accept.unit_is_given) {
        ANATOMESH_CHECK_STATUS(check_unit(contours, planes, counts));
    }
    const bool are_on_images = counts.all_are_on();
    if (are_on_images && !counts.are_crowded())
        std::erase_if(context.warnings, [](const Warning& warning) { return warning.code == "W-RTS-006"; });
    if (counts.outside > 0 && counts.on + counts.between == 0 && !accept.outside)
        return Error{ErrorKind::input,
                     "E-DCM-037",
                     "all contours lie outside the images they refer to",
                     {contours.source, {}, {}, {}, fmt::format("{} contours", counts.outside)},
                     "check that they belong together, or accept them with --allow-outside"};
    if (counts.between > 0)
        context.warn({"W-DCM-019",
                      fmt::format("{} contours lie between the images they refer to", counts.between),
                      {contours.source, {}, {}, {}, fmt::format("up to {:.3g} mm", counts.worst)},
                      "their coordinates were used"});
    if (counts.outside > 0)
        context.warn(
            {"W-DCM-020",
             fmt::format("{} contours lie outside the images they refer to; the one that lies farthest "
                         "outside is named",
                         counts.outside),
             place_beyond(contours, counts.wholly),
             "their coordinates were used; check that contours and images belong together"});
    if (counts.partly.count > 0)
        context.warn(
            {"W-DCM-027",
             fmt::format("{} contours reach beyond the edge of the images they refer to, where no pixel "
                         "shows what they follow; the one that reaches farthest is named",
                         counts.partly.count),
             place_beyond(contours, counts.partly),
             "their coordinates were used; check these contours, and that they belong to these images"});
    return are_on_images;
}

Result<std::vector<std::uint32_t>> match_images(const RawContours& contours, const DicomFolder& folder) {
    std::vector<const DicomSeries*> matches;
    for (const DicomSeries& series : folder.series) {
        if (series.kind != DicomKind::image) continue;
        const ImagePlanes planes(folder, series.objects);
        if (planes.empty()) continue;
        const Counts counts = count_places(contours, planes, 1);
        if (counts.all_are_on()) matches.push_back(&series);
    }
    if (matches.size() == 1) return matches[0]->objects;
    std::string list;
    for (const DicomSeries* series : matches)
        list += (list.empty() ? "" : "; ") + describe_series(folder, *series);
    return Error{ErrorKind::input,
                 "E-DCM-036",
                 matches.empty() ? "no image series here has the planes of the contours"
                                 : "several image series here have the planes of the contours",
                 {contours.source, {}, {}, {}, list},
                 "give the object alone, or only with its own images"};
}

Status check_references(const DicomItem& rtstruct, const DicomFolder& folder,
                        const std::vector<std::uint32_t>& images, RunContext& context) {
    std::map<std::string_view, const DicomObject*> image_of;
    for (const std::uint32_t index : images)
        image_of[folder.objects[index].sop_instance] = &folder.objects[index];
    const ImagePlanes planes(folder, images);
    std::set<std::pair<std::string_view, std::uint64_t>> without_place;
    std::uint64_t wrong = 0, absent = 0;
    double worst = 0;
    for (const DicomItem& roi : rtstruct.items(tags::roi_contour_sequence))
        for (const DicomItem& contour : roi.items(tags::contour_sequence)) {
            const auto reference = contour.item(tags::contour_image_sequence);
            if (!reference) continue;
            const auto named = image_of.find(reference->text(tags::referenced_sop_instance));
            const auto point = first_point(contour.bytes(tags::contour_data));
            if (named == image_of.end() || !point) continue;
            const DicomObject& image = *named->second;
            if (!image.known_axes) continue;
            const std::uint64_t frame = named_frame(*reference);
            if (image.planes.empty()) {
                if (image.frames > 1 && frame > 0) without_place.emplace(named->first, frame);
                continue;
            }
            if (image.planes.size() > 1 && frame == 0) continue;
            const std::uint64_t place = image.planes.size() > 1 ? frame - 1 : 0;
            if (place >= image.planes.size()) {
                ++absent;
                continue;
            }
            const double away = std::abs(dot(*point - image.planes[place].position, planes.normal()));
            // Between two images it may refer to either.
            if (away <= 0.6 * planes.spacing()) continue;
            ++wrong;
            worst = std::max(worst, away);
        }
    if (without_place.size() > 1)
        return Error{
            ErrorKind::input,
            "E-DCM-039",
            fmt::format("the contours are drawn on {} frames of an image that does not say where its frames "
                        "lie",
                        without_place.size()),
            {rtstruct.set().name(), {}, {}, {}, {}},
            "export the image with the positions of its frames, and draw the contours on that"};
    if (wrong > 0)
        context.warn({"W-DCM-024",
                      fmt::format("{} contours refer to an image at another place", wrong),
                      {rtstruct.set().name(), {}, {}, {}, fmt::format("up to {:.4g} mm away", worst)},
                      "their coordinates were used"});
    if (absent > 0)
        context.warn({"W-DCM-025",
                      fmt::format("{} contours refer to a frame that the image does not have", absent),
                      {rtstruct.set().name(), {}, {}, {}, {}},
                      "their coordinates were used"});
    return Nothing{};
}

}  // namespace anatomesh
