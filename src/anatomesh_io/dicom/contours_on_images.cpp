#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/choose.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// Contours lie on an image up to this distance from its plane: both positions are rounded in files.
// [mm; 0 to 1; D digits of files]
constexpr double same_plane_mm = 0.05;

enum class Lies : std::uint8_t { on, between, outside, across };

// The planes of a series, parallel to its first one.
class ImagePlanes {
  public:
    ImagePlanes(const DicomFolder& folder, const std::vector<std::uint32_t>& images) {
        for (const std::uint32_t index : images)
            for (const DicomFrame& plane : folder.objects[index].planes) {
                if (!first_) first_ = &plane;
                heights_.push_back(dot(plane.position, normal()));
            }
        std::sort(heights_.begin(), heights_.end());
    }
    bool empty() const { return !first_; }
    Vec3 normal() const { return cross(first_->row, first_->column); }
    double spacing() const {
        return heights_.size() > 1
                   ? (heights_.back() - heights_.front()) / static_cast<double>(heights_.size() - 1)
                   : 1;
    }
    double distance(double height) const {
        const auto above = std::lower_bound(heights_.begin(), heights_.end(), height);
        double nearest = above == heights_.end() ? 1e300 : *above - height;
        if (above != heights_.begin()) nearest = std::min(nearest, height - *(above - 1));
        return nearest;
    }
    // Where a contour lies when its coordinates are multiplied by `scale`; `away`: from the nearest plane.
    Lies place_of(const RawContours& contours, const RawContour& contour, double scale, double& away) const {
        double low = 1e300, high = -1e300;
        bool all_aside = true;
        for (std::uint32_t p = 0; p < contour.point_count; ++p) {
            const Vec3 point = scale * contours.points[contour.first_point + p];
            low = std::min(low, dot(point, normal()));
            high = std::max(high, dot(point, normal()));
            all_aside = all_aside && is_aside(point);
        }
        if (high - low > same_plane_mm) return Lies::across;
        away = distance((low + high) / 2);
        if (all_aside || low < heights_.front() - spacing() || high > heights_.back() + spacing())
            return Lies::outside;
        return away > same_plane_mm ? Lies::between : Lies::on;
    }

  private:
    // Whether a point lies beside the pixels of the first image, wherever along the normal.
    bool is_aside(Vec3 point) const {
        const Vec3 p = point - first_->position;
        const double i = dot(p, first_->row) / first_->spacing[0],
                     j = dot(p, first_->column) / first_->spacing[1];
        return i < -0.5 || j < -0.5 || i > first_->columns - 0.5 || j > first_->rows - 0.5;
    }

    const DicomFrame* first_ = nullptr;
    std::vector<double> heights_;
};

struct Counts {
    std::uint64_t on = 0, between = 0, outside = 0, planes = 0;
    double worst = 0;
};

Counts count_places(const RawContours& contours, const ImagePlanes& images, double scale) {
    Counts counts;
    double before = 1e300;
    for (const RawContour& contour : contours.contours) {
        if (contour.point_count == 0) continue;
        double away = 0;
        const Lies lies = images.place_of(contours, contour, scale, away);
        counts.on += lies == Lies::on;
        counts.between += lies == Lies::between;
        counts.outside += lies == Lies::outside;
        if (lies == Lies::between) counts.worst = std::max(counts.worst, away);
        const double height = dot(contours.points[contour.first_point], images.normal());
        counts.planes += std::abs(height - before) > 1e-3;
        before = height;
    }
    return counts;
}

// Coordinates that fit no image as mm, and the images as another unit.
void check_unit(const RawContours& contours, const ImagePlanes& images, const Counts& as_mm,
                RunContext& context) {
    if (as_mm.on > 0 || as_mm.planes < 3) return;
    for (const auto& [scale, unit] : {std::pair{10.0, "cm"}, {1000.0, "m"}}) {
        const Counts scaled = count_places(contours, images, scale);
        if (scaled.on == 0 || scaled.between + scaled.outside > 0) continue;
        context.warn(
            {"W-DCM-023",
             fmt::format("the contours would lie on the images if their coordinates were in {}", unit),
             {contours.source, {}, {}, {}, {}},
             "they were read as mm, as the standard requires; check the unit"});
    }
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

}  // namespace

Status check_against_images(const RawContours& contours, const DicomFolder& folder,
                            const std::vector<std::uint32_t>& images, bool allow_outside,
                            RunContext& context) {
    const ImagePlanes planes(folder, images);
    if (planes.empty()) return Nothing{};
    const Counts counts = count_places(contours, planes, 1);
    check_unit(contours, planes, counts, context);
    if (counts.outside > 0 && counts.on + counts.between == 0 && !allow_outside)
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
        context.warn({"W-DCM-020",
                      fmt::format("{} contours lie outside the images they refer to", counts.outside),
                      {contours.source, {}, {}, {}, {}},
                      "their coordinates were used"});
    return Nothing{};
}

Result<std::vector<std::uint32_t>> match_images(const RawContours& contours, const DicomFolder& folder) {
    std::vector<const DicomSeries*> matches;
    for (const DicomSeries& series : folder.series) {
        if (series.kind != DicomKind::image) continue;
        const ImagePlanes planes(folder, series.objects);
        if (planes.empty()) continue;
        const Counts counts = count_places(contours, planes, 1);
        if (counts.on > 0 && counts.between + counts.outside == 0) matches.push_back(&series);
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

void check_references(const DicomItem& rtstruct, const DicomFolder& folder,
                      const std::vector<std::uint32_t>& images, RunContext& context) {
    const ImagePlanes planes(folder, images);
    if (planes.empty()) return;
    std::map<std::string_view, const DicomFrame*> plane_of;
    for (const std::uint32_t index : images)
        if (folder.objects[index].planes.size() == 1)
            plane_of[folder.objects[index].sop_instance] = &folder.objects[index].planes[0];
    std::uint64_t wrong = 0;
    double worst = 0;
    for (const DicomItem& roi : rtstruct.items(tags::roi_contour_sequence))
        for (const DicomItem& contour : roi.items(tags::contour_sequence)) {
            const auto reference = contour.item(tags::contour_image_sequence);
            if (!reference) continue;
            const auto named = plane_of.find(reference->text(tags::referenced_sop_instance));
            const auto point = first_point(contour.bytes(tags::contour_data));
            if (named == plane_of.end() || !point) continue;
            const double away = std::abs(dot(*point - named->second->position, planes.normal()));
            // Between two images it may refer to either.
            if (away <= 0.6 * planes.spacing()) continue;
            ++wrong;
            worst = std::max(worst, away);
        }
    if (wrong == 0) return;
    context.warn({"W-DCM-024",
                  fmt::format("{} contours refer to an image at another place", wrong),
                  {rtstruct.set().name(), {}, {}, {}, fmt::format("up to {:.4g} mm away", worst)},
                  "their coordinates were used"});
}

}  // namespace anatomesh
