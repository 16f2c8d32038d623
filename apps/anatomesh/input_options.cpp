#include "input_options.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "help_text.h"
#include "option_values.h"

namespace anatomesh {

namespace {

// Grey values beyond this are no threshold of any image. [grey values; > 0; C]
constexpr double largest_value = 1e15;
// Frames of no image lie so far apart. [mm; > smallest_frame_step_mm; C]
constexpr double largest_frame_step_mm = 1e4;
// Frames that lie nearer lie in one plane. [mm; > 0; C]
constexpr double smallest_frame_step_mm = 1e-3;

ThresholdOptions threshold_of(const std::string& text) {
    const std::size_t colon = text.find(':');
    ThresholdOptions threshold;
    threshold.low = strict_number("--threshold", text.substr(0, colon), -largest_value, largest_value);
    if (colon != std::string::npos) {
        threshold.high = strict_number("--threshold", text.substr(colon + 1), -largest_value, largest_value);
    }
    if (threshold.high < threshold.low) {
        throw CLI::ValidationError("--threshold",
                                   fmt::format("in '{}' the upper value is below the lower", text));
    }
    return threshold;
}

}  // namespace

void add_reading_options(CLI::App& verb, InputOptions& options) {
    verb.add_option(
            "INPUT", options.input,
            "Image, label map or contour file, or a folder of DICOM objects. The content tells the format.")
        ->type_name("FILE")
        ->required();
    add_choice(verb, "--frame", options.frame, {"LPS", "RAS"},
               "Axes of the coordinates, for a file that does not state them.");
    add_choice(verb, "--use", options.nifti_transform, {"qform", "sform"},
               "The transform of a NIfTI image to use where its two transforms disagree.");
    add_text(verb, "--assume-orientation", options.assume_orientation, "AXES",
             "Directions of the axes, such as RAS, for an image that states no orientation.");
    add_optional_count(
        verb, "--volume", options.volume, 0,
        "The volume to read from an image that holds several, or the time frame of guide points. "
        "The first one is 0.");
    add_text(verb, "--series", options.series, "UID",
             "The series to read from a folder of DICOM objects, by its UID or by its name in 'info'.");
    verb.add_flag("--allow-gaps", options.allow_gaps,
                  "Interpolate DICOM images where slices are missing or unevenly spaced.");
    verb.add_flag("--ignore-frame-of-reference", options.ignore_frame_of_reference,
                  "Use contours and DICOM images together even if their frames of reference differ.");
    verb.add_flag("--ignore-patient", options.ignore_patient,
                  "Use contours and DICOM images together even if their patients or studies differ.");
    verb.add_flag("--match-by-geometry", options.match_by_geometry,
                  "Find the images of DICOM contours by their position, not by the references in the file.");
    verb.add_flag("--allow-outside", options.allow_outside,
                  "Accept DICOM contours that all lie outside their images.");
    verb.add_option_function<std::string>(
            "--unit",
            [&options](const std::string& text) {
                const std::pair<const char*, double> units[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}};
                for (const auto& [name, mm] : units)
                    if (text == name) options.unit_mm = mm;
                if (!options.unit_mm)
                    throw CLI::ValidationError("--unit", fmt::format("'{}' is not one of mm, cm, m", text));
            },
            "Unit of the coordinates in a contour file. Default: mm; DICOM contours that contradict it are "
            "refused.")
        ->type_name("mm|cm|m");
    add_optional_count(
        verb, "--ultrasound-region", options.ultrasound_region, 0,
        "The region whose scale applies, for an ultrasound image with several. The first one is 0.");
    verb.add_option_function<std::string>(
            "--frame-step",
            [&options](const std::string& text) {
                options.frame_step_mm =
                    strict_number("--frame-step", text, -largest_frame_step_mm, largest_frame_step_mm);
                if (std::abs(*options.frame_step_mm) < smallest_frame_step_mm)
                    throw CLI::ValidationError("--frame-step", fmt::format("'{}' is nearer to 0 than {}",
                                                                           text, smallest_frame_step_mm));
            },
            "Distance of each frame from the one before, for a DICOM file that states the place of its first "
            "frame alone. It counts along row x column of that frame; a negative one counts against it.")
        ->type_name("MM");
    const auto read_matrix = [&options](const std::string& text) {
        options.image_to_probe.clear();
        for (std::size_t begin = 0; begin <= text.size();) {
            const std::size_t end = std::min(text.find_first_of(", ", begin), text.size());
            if (end > begin)
                options.image_to_probe.push_back(
                    strict_number("--image-to-probe", text.substr(begin, end - begin), -1e7, 1e7));
            begin = end + 1;
        }
        if (options.image_to_probe.size() != 12 && options.image_to_probe.size() != 16)
            throw CLI::ValidationError("--image-to-probe", "12 or 16 numbers, row by row, are needed");
    };
    verb.add_option_function<std::string>("--image-to-probe", read_matrix,
                                          "Calibration of tracked ultrasound: the matrix from pixels to the "
                                          "probe in mm, 12 or 16 numbers, row by row.")
        ->type_name("M11,M12,...");
    add_text(
        verb, "--pose-to", options.pose_to, "NAME",
        "Coordinate system in which to place tracked frames. Default: the first one present of Reference, "
        "Tracker and World.");
    verb.add_flag(
        "--keep-patient-ids", options.keep_patient_ids,
        "Keep DICOM file names in reports, and the patient's identity and all UIDs in DICOM outputs.");
    group_new_options(verb, option_group::input);
}

void add_cleaning_options(CLI::App& verb, InputOptions& options) {
    CleanOptions& cleaning = options.prepare.clean;
    const auto add = [&](const std::string& name, double& target, double low, double high, const char* unit,
                         const std::string& description) {
        const auto read = [&options, &target, name, low, high](const std::string& text) {
            target = strict_number(name, text, low, high);
            options.cleaning_given.push_back(name);
        };
        verb.add_option_function<std::string>(name, read, description)->type_name(unit);
    };
    const auto read_holes = [&options](const std::string& text) {
        if (text != "even-odd" && text != "filled") {
            throw CLI::ValidationError("--holes", fmt::format("'{}' is not one of even-odd, filled", text));
        }
        options.prepare.clean.rings.holes = text == "filled" ? HoleRule::united : HoleRule::even_odd;
        options.cleaning_given.emplace_back("--holes");
    };
    verb.add_option_function<std::string>("--holes", read_holes,
                                          "A drawn contour inside another one of its structure is a hole "
                                          "(even-odd) or belongs to the structure "
                                          "(filled). Default: even-odd.")
        ->type_name("even-odd|filled");
    verb.add_flag_callback(
        "--unite-repeated-planes",
        [&options] {
            options.prepare.clean.rings.unite_repeated_planes = true;
            options.cleaning_given.emplace_back("--unite-repeated-planes");
        },
        "Unite the contours if a plane is drawn twice and the two drawings contradict each other.");
    add("--closing-gap", cleaning.closing_gap_mm, 0, 100, "MM",
        fmt::format("Close an open contour if the gap is at most this wide, 0 to 100 mm. Default: {}.",
                    cleaning.closing_gap_mm));
    add("--same-line", options.prepare.walls.same_line_mm, 0, 0.1, "MM",
        fmt::format("Neighbouring structures share their boundary where their contours are closer than this, "
                    "0 to 0.1 "
                    "mm. 0 keeps contours as drawn. Default: {}.",
                    options.prepare.walls.same_line_mm));
    add("--close-slivers", options.prepare.walls.close_slivers_mm, 0, 10, "MM",
        fmt::format(
            "Neighbouring structures share their boundary where their contours cross repeatedly and stay "
            "closer "
            "than this and {:.0f} % of a segment, 0 to 10 mm. 0 keeps contours as drawn. Default: {}.",
            100 * CloseSliversOptions{}.share_of_segment, options.prepare.walls.close_slivers_mm));
    add("--close-gaps", options.prepare.walls.close_gaps_mm, 0, 10, "MM",
        "Neighbouring structures share their boundary where the gap between their contours is narrower than "
        "this, 0 to "
        "10 mm. One pixel is a good value. Default: 0, which keeps contours as drawn.");
    add("--plane-repair", cleaning.planes.plane_repair_mm, cleaning.planes.plane_tolerance_mm, 10, "MM",
        fmt::format("Project points onto the plane of their contour from at most this distance, {} to 10 mm. "
                    "Default: "
                    "{}.",
                    cleaning.planes.plane_tolerance_mm, cleaning.planes.plane_repair_mm));
    add("--keyhole", cleaning.rings.keyhole_mm, 0, 10, "MM",
        fmt::format("Close a straight corridor from a contour to a hole if it is at most this wide, 0 to 10 "
                    "mm, and at least ten times as long as wide. Default: {}.",
                    cleaning.rings.keyhole_mm));
    add("--close-loops", cleaning.rings.loop_mm2, 0, 100, "MM2",
        fmt::format("Close loops where a contour crosses itself if they are smaller than this, 0 to 100 mm2, "
                    "and than "
                    "0.2 % of its area. 0 keeps contours as drawn. Default: {}.",
                    cleaning.rings.loop_mm2));
    add("--max-repair", cleaning.rings.max_repair_area_share, 0, 1, "SHARE",
        fmt::format("Refuse a contour if more than this share of its area is ambiguous, 0 to 1. Default: {}.",
                    cleaning.rings.max_repair_area_share));
    group_new_options(verb, option_group::contour_repair);
}

void add_threshold_option(CLI::App& verb, InputOptions& options) {
    verb.add_option_function<std::string>(
            "--threshold",
            [&options](const std::string& text) {
                options.prepare.label_maps.threshold = threshold_of(text);
            },
            "The structure is all voxels of a grey image with values from LO up, or from LO to HI (HU in a "
            "CT).")
        ->type_name("LO[:HI]");
    group_new_options(verb, option_group::slices);
}

void add_without_option(CLI::App& verb, InputOptions& options) {
    add_texts(verb, "--without", options.prepare.choice.without, "SLICE",
              "Leave out this slice, by its name in messages, such as 'plane 9', 'z = -12.5' or 'k = 40'. "
              "Repeatable.");
    group_new_options(verb, option_group::slices);
}

void add_keep_largest_option(CLI::App& verb, InputOptions& options) {
    add_optional_count(
        verb, "--keep-largest", options.prepare.label_maps.keep_largest, 1,
        "Keep the N largest connected parts of each structure in the image, from 1. Default: all.");
    group_new_options(verb, option_group::slices);
}

void add_selection_options(CLI::App& verb, InputOptions& options) {
    add_texts(verb, "--structure", options.prepare.choice.structures, "NAME",
              "Use this structure, by name or number. Repeatable. Default: all structures.");
    add_text(verb, "--name", options.prepare.choice.name, "NEW",
             "Name of the one structure that is used. Default: as the input calls it, 'threshold LO' for a "
             "threshold.");
    add_without_option(verb, options);
    add_threshold_option(verb, options);
    add_keep_largest_option(verb, options);
    verb.add_option_function<std::string>(
            "--axis",
            [&options](const std::string& text) {
                const std::size_t axis = std::string_view("xyz").find(text);
                if (text.size() != 1 || axis == std::string_view::npos)
                    throw CLI::ValidationError("--axis", fmt::format("'{}' is not one of x, y, z", text));
                options.prepare.label_maps.axis = static_cast<std::uint32_t>(axis);
            },
            "Take the slices of an image along this axis of the patient: x (right to left), y (front to "
            "back) or z "
            "(feet to head). Default: the axis with the largest distance of slices.")
        ->type_name("x|y|z");
    verb.add_option_function<std::string>(
            "--between-sparse",
            [&options](const std::string& text) {
                if (text != "nothing" && text != "interpolated")
                    throw CLI::ValidationError("--between-sparse",
                                               fmt::format("'{}' is not one of nothing, interpolated", text));
                options.prepare.label_maps.between_sparse =
                    text == "nothing" ? BetweenSparse::nothing : BetweenSparse::interpolated;
            },
            "What lies between the slices of a structure that is painted on every Nth slice alone: nothing, "
            "so that "
            "each slice is a plate, or what the slices tell (interpolated). Default: nothing, with a "
            "warning.")
        ->type_name("nothing|interpolated");
    add_optional_count(verb, "--every", options.prepare.choice.every, 1,
                       "Use every Nth slice, from 1. Default: 1, all slices.");
    add_count(verb, "--offset", options.prepare.choice.offset, 0, largest_count,
              "The first slice that --every keeps, from 0. Default: 0.");
    verb.add_option_function<std::string>(
            "--epsilon",
            [&options](const std::string& text) {
                options.prepare.epsilon_mm =
                    text == "exact" ? 0.0 : strict_number("--epsilon", text, 1e-6, 10);
            },
            "Simplify contours: every drawn point stays within this distance of the new contour, 1e-6 to 10 "
            "mm. Default: "
            "0.15 pixel for contours of images; drawn contours lose only points less than 0.01 mm apart.")
        ->type_name("MM|exact");
    verb.add_option_function<std::string>(
            "--min-area",
            [&options](const std::string& text) {
                options.prepare.label_maps.min_area_mm2 = strict_number("--min-area", text, 0, 1e6);
            },
            "Leave out islands and fill holes of images that are smaller than this, 0 to 1e6 mm2. Default: 4 "
            "pixels.")
        ->type_name("MM2");
    group_new_options(verb, option_group::slices);
}

}  // namespace anatomesh
