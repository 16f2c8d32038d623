// anatomesh info: what is in an image, label map or contour file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/plural.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/image/select.h"
#include "anatomesh/outliers/warn_about_outlying_slices.h"
#include "answer.h"
#include "dicom_input.h"
#include "input_options.h"
#include "read_input.h"
#include "session.h"
#include "verbs.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

Json vector_json(Vec3 v) {
    return Json::array({v.x, v.y, v.z});
}

// Volume of one voxel, mm3.
double voxel_volume(const ImageGeometry& geometry) {
    return std::abs(dot(cross(geometry.step[0], geometry.step[1]), geometry.step[2]));
}

Json geometry_json(const ImageGeometry& geometry) {
    Json json;
    json["size"] = geometry.size;
    json["spacing_mm"] = {length(geometry.step[0]), length(geometry.step[1]), length(geometry.step[2])};
    json["origin_mm"] = vector_json(geometry.origin);
    json["axes"] = {vector_json(normalized(geometry.step[0])), vector_json(normalized(geometry.step[1])),
                    vector_json(normalized(geometry.step[2]))};
    return json;
}

Result<Json> image_json(const LoadedImage& loaded, RunContext& context) {
    const ImageGeometry& geometry = loaded.image.geometry;
    const ImageFacts& facts = loaded.facts;
    Json json = geometry_json(geometry);
    if (!loaded.poses.empty()) {
        json = Json::object();
        json["size"] = geometry.size;
        json["spacing_mm"] = {length(loaded.poses[0].step[0]), length(loaded.poses[0].step[1])};
        json["tracked_frames"] = loaded.poses.size();
        Box3 box;
        for (const FramePose& pose : loaded.poses)
            for (const double i : {0.0, geometry.size[0] - 1.0})
                for (const double j : {0.0, geometry.size[1] - 1.0})
                    box.extend(pose.origin + i * pose.step[0] + j * pose.step[1]);
        json["low_mm"] = vector_json(box.low);
        json["high_mm"] = vector_json(box.high);
    }
    json["voxel_type"] = facts.voxel_type;
    json["values"] = {{"low", facts.low}, {"high", facts.high}, {"not_finite", facts.not_finite}};
    json["label_map"] = looks_like_label_map(facts);
    if (!looks_like_label_map(facts) || !loaded.poses.empty()) return json;
    ANATOMESH_TRY(const LabelMap labels, to_label_map(loaded, context));
    const std::vector<std::uint64_t> voxels = count_voxels(labels);
    json["structures"] = Json::array();
    for (std::size_t i = 0; i < voxels.size(); ++i) {
        json["structures"].push_back(
            {{"number", labels.structures[i].number},
             {"name", labels.structures[i].name},
             {"voxels", voxels[i]},
             {"volume_mm3", static_cast<double>(voxels[i]) * voxel_volume(geometry)}});
    }
    return json;
}

// As that of a label map.
Json segmentation_json(const LoadedSegmentation& loaded) {
    const ImageGeometry& geometry = loaded.layers[0].geometry;
    Json json = geometry_json(geometry);
    json["voxel_type"] = loaded.type;
    json["layers"] = loaded.layers.size();
    json["frames"] = loaded.frames;
    json["label_map"] = true;
    json["structures"] = Json::array();
    std::int32_t largest = 0;
    for (const LabelMap& layer : loaded.layers) {
        const std::vector<std::uint64_t> voxels = count_voxels(layer);
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            largest = std::max(largest, layer.structures[i].number);
            json["structures"].push_back(
                {{"number", layer.structures[i].number},
                 {"name", layer.structures[i].name},
                 {"voxels", voxels[i]},
                 {"volume_mm3", static_cast<double>(voxels[i]) * voxel_volume(geometry)}});
        }
    }
    json["values"] = {{"low", 0.0}, {"high", static_cast<double>(largest)}, {"not_finite", 0}};
    return json;
}

Result<Json> contours_json(const RawContours& raw, const CleanOptions& cleaning, RunContext& context) {
    ANATOMESH_TRY(const CleanResult cleaned, clean_contours(raw, cleaning, context));
    const ContourSet& set = cleaned.kept;
    warn_about_outlying_slices(set, arrangement_of(set), {}, context);
    const Box3 box = set.box();
    const bool parallel = all_parallel(set, parallel_tolerance_mm);
    Json json;
    json["slices"] = set.slices.size();
    json["parallel"] = parallel;
    if (parallel) json["slice_spacing_mm"] = median_spacing(set);
    json["contours"] = set.contours.size();
    json["points"] = set.points.size();
    json["contours_in_file"] = raw.contours.size();
    json["points_in_file"] = raw.points.size();
    json["low_mm"] = vector_json(box.low);
    json["high_mm"] = vector_json(box.high);
    std::vector<std::array<std::uint64_t, 2>> counts(set.structures.size());
    for (const Contour& contour : set.contours) {
        ++counts[contour.structure][0];
        counts[contour.structure][1] += contour.point_count;
    }
    json["structures"] = Json::array();
    for (std::size_t i = 0; i < set.structures.size(); ++i) {
        json["structures"].push_back({{"number", set.structures[i].number},
                                      {"name", set.structures[i].name},
                                      {"color", set.structures[i].color},
                                      {"contours", counts[i][0]},
                                      {"points", counts[i][1]}});
    }
    return json;
}

std::string numbers_text(const Json& values) {
    std::string text;
    for (const Json& value : values) {
        text += (text.empty() ? "" : " x ") +
                (value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump());
    }
    return text;
}

// ", parallel, 3 mm apart"; nothing for one slice.
std::string arrangement_text(const Json& contours) {
    if (contours["slices"].get<std::uint64_t>() < 2) return "";
    if (!contours["parallel"].get<bool>()) return ", not parallel";
    return fmt::format(", parallel, {:.6g} mm apart", contours["slice_spacing_mm"].get<double>());
}

std::string text_of(const Json& answer) {
    std::string text = fmt::format("{}: {}, {}\n", answer["file"].get<std::string>(),
                                   answer["kind"].get<std::string>(), answer["space"].get<std::string>());
    const bool is_image = answer.contains("image");
    const Json& what = is_image ? answer["image"] : answer["contours"];
    if (is_image) {
        text += fmt::format("  {} voxels of {} mm, {}, values {} to {}: a {}\n", numbers_text(what["size"]),
                            numbers_text(what["spacing_mm"]), what["voxel_type"].get<std::string>(),
                            what["values"]["low"].get<double>(), what["values"]["high"].get<double>(),
                            what["label_map"].get<bool>() ? "label map" : "grey image (needs --threshold)");
        if (what.contains("tracked_frames"))
            text += fmt::format("  {} with a pose, each a slice of its own in space\n",
                                counted(what["tracked_frames"].get<std::uint64_t>(), "frame"));
    } else {
        text += fmt::format("  {}{}, {}, {}\n", counted(what["slices"].get<std::uint64_t>(), "slice"),
                            arrangement_text(what), counted(what["contours"].get<std::uint64_t>(), "contour"),
                            counted(what["points"].get<std::uint64_t>(), "point"));
    }
    if (!what.contains("structures")) return text;
    text += fmt::format("  {}:\n", counted(what["structures"].size(), "structure"));
    for (const Json& each : what["structures"]) {
        text += fmt::format("  {:>6}  {:<32} ", each["number"].get<std::int32_t>(),
                            on_one_line(each["name"].get<std::string>()));
        text += is_image
                    ? fmt::format("{}, {:.1f} mm3\n", counted(each["voxels"].get<std::uint64_t>(), "voxel"),
                                  each["volume_mm3"].get<double>())
                    : fmt::format("{}, {}\n", counted(each["contours"].get<std::uint64_t>(), "contour"),
                                  counted(each["points"].get<std::uint64_t>(), "point"));
    }
    return text;
}

Status give_folder(const InputOptions& options, Session& session) {
    Json answer;
    answer["file"] = options.input;
    answer["kind"] = "DICOM folder";
    ANATOMESH_TRY(answer["folder"], folder_json(options, session.context));
    const std::string text =
        fmt::format("{}: DICOM folder\n{}", options.input, folder_text(answer["folder"]));
    return give_answer(session, answer, text);
}

Status run_info(InputOptions options, Session& session) {
    options.limits = session.limits;
    if (options.series.empty() && is_dicom_folder(options.input)) return give_folder(options, session);
    ANATOMESH_TRY(const OpenedInput input, open_input(options, session.context));
    Json answer;
    answer["file"] = options.input;
    answer["kind"] = name_of(input.kind);
    const bool known_axes = input.contours ? input.contours->frame != Frame::unknown
                            : input.image  ? input.image->known_axes
                                           : input.segmentation->known_axes;
    answer["space"] = known_axes ? "LPS" : "unknown";
    answer["unit"] = "mm";
    answer["inputs"] = inputs_json(input.files);
    if (input.image) {
        ANATOMESH_TRY(answer["image"], image_json(*input.image, session.context));
    } else if (input.segmentation) {
        answer["image"] = segmentation_json(*input.segmentation);
    } else {
        ANATOMESH_TRY(answer["contours"],
                      contours_json(*input.contours, options.prepare.clean, session.context));
    }
    return give_answer(session, answer, text_of(answer));
}

}  // namespace

Work declare_info(CLI::App& verb) {
    auto options = std::make_shared<InputOptions>();
    add_reading_options(verb, *options);
    add_cleaning_options(verb, *options);
    return [options](Session& session) { return run_info(*options, session); };
}

}  // namespace anatomesh
