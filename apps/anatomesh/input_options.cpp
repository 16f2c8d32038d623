#include "input_options.h"

#include <fmt/format.h>

#include "option_values.h"

namespace anatomesh {

namespace {

constexpr double largest_value = 1e15;

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
    verb.add_option("INPUT", options.input,
                    "Image, label map or contour file, or a folder of DICOM objects; its kind is found from "
                    "its content")
        ->type_name("FILE")
        ->required();
    add_choice(verb, "--frame", options.frame, {"LPS", "RAS"},
               "Axes of the coordinates in a file that does not say");
    add_choice(verb, "--use", options.nifti_transform, {"qform", "sform"},
               "Which transform of a NIfTI image counts when its two disagree");
    add_text(verb, "--assume-orientation", options.assume_orientation, "AXES",
             "Where the axes of an image without orientation run to, as RAS");
    add_optional_count(
        verb, "--volume", options.volume, 0,
        "Which volume of an image that holds several, from 0, or which time frame of guide points");
    add_text(verb, "--series", options.series, "UID",
             "Which series of a folder of DICOM objects, by its UID or the name that info gives it");
    verb.add_flag("--allow-gaps", options.allow_gaps,
                  "Interpolate between DICOM images where slices are missing or not equidistant");
    verb.add_flag("--ignore-frame-of-reference", options.ignore_frame_of_reference,
                  "Take contours and DICOM images of different frames of reference as they are");
    verb.add_flag("--ignore-patient", options.ignore_patient,
                  "Take contours and DICOM images of different patients or studies together");
    verb.add_flag("--match-by-geometry", options.match_by_geometry,
                  "Find the images of contours that refer to others by where they lie (DICOM)");
    verb.add_flag("--allow-outside", options.allow_outside,
                  "Take contours all of which lie outside their DICOM images");
    add_optional_count(verb, "--ultrasound-region", options.ultrasound_region, 0,
                       "Which region's scale counts in an ultrasound image of several, from 0");
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
    verb.add_option_function<std::string>(
            "--image-to-probe", read_matrix,
            "Calibration of a tracked ultrasound sequence: the matrix from pixels to the probe, row by row")
        ->type_name("M11,M12,...");
    add_text(
        verb, "--pose-to", options.pose_to, "NAME",
        "The tool's or room's axes that frames of a tracked sequence are placed in (default: the first there "
        "is of Reference, Tracker, World)");
    verb.add_flag(
        "--keep-patient-ids", options.keep_patient_ids,
        "Keep names of DICOM files in messages, and the patient's identity and all UIDs in DICOM outputs");
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
        options.prepare.clean.holes = text == "filled" ? HoleRule::united : HoleRule::even_odd;
        options.cleaning_given.emplace_back("--holes");
    };
    verb.add_option_function<std::string>(
            "--holes", read_holes,
            "A drawn contour inside another one of its structure: a hole (even-odd, default), or part of the "
            "inside (filled)")
        ->type_name("even-odd|filled");
    verb.add_flag_callback(
        "--unite-repeated-planes",
        [&options] {
            options.prepare.clean.unite_repeated_planes = true;
            options.cleaning_given.emplace_back("--unite-repeated-planes");
        },
        "Unite the drawn contours of a plane that is given twice where they contradict each other");
    add("--closing-gap", cleaning.closing_gap_mm, 0, 100, "MM",
        fmt::format("Close open contours over a gap up to MM, 0 to 100 (default {})",
                    cleaning.closing_gap_mm));
    add("--same-line", options.prepare.walls.same_line_mm, 0, 0.1, "MM",
        fmt::format(
            "Contours of different structures share their vertices where they lie less than MM apart, "
            "0 to 0.1 (default {}: copies of one line; 0: as drawn)",
            options.prepare.walls.same_line_mm));
    add("--close-slivers", options.prepare.walls.close_slivers_mm, 0, 10, "MM",
        fmt::format(
            "Close slivers between contours of structures that cross and soon cross again: one wall where "
            "they "
            "are less than MM, and {:.0f} % of their segments, apart, 0 to 10 (default {}; 0: as drawn)",
            100 * CloseSliversOptions{}.share_of_segment, options.prepare.walls.close_slivers_mm));
    add("--close-gaps", options.prepare.walls.close_gaps_mm, 0, 10, "MM",
        "Give neighbouring structures drawn less than MM apart, about a pixel, one wall through the vertices "
        "of both, "
        "0 to 10 (default 0: as drawn)");
    add("--plane-repair", cleaning.plane_repair_mm, cleaning.plane_tolerance_mm, 10, "MM",
        fmt::format("Move drawn points up to MM off their plane onto it, {} to 10 (default {})",
                    cleaning.plane_tolerance_mm, cleaning.plane_repair_mm));
    add("--keyhole", cleaning.keyhole_mm, 0, 10, "MM",
        fmt::format("Close straight corridors up to MM wide that a contour runs through to a hole, 0 to 10 "
                    "(default {})",
                    cleaning.keyhole_mm));
    add("--close-loops", cleaning.loop_mm2, 0, 100, "MM2",
        fmt::format("Close loops below MM2 that a contour makes by crossing itself, up to 0.2 % of its "
                    "area: no holes "
                    "or islands of their own, 0 to 100 (default {}; 0: as drawn)",
                    cleaning.loop_mm2));
    add("--max-repair", cleaning.max_repair_area_share, 0, 1, "SHARE",
        fmt::format(
            "Refuse a contour of which more than this share of the area is ambiguous, 0 to 1 (default "
            "{})",
            cleaning.max_repair_area_share));
}

void add_threshold_option(CLI::App& verb, InputOptions& options) {
    verb.add_option_function<std::string>(
            "--threshold",
            [&options](const std::string& text) { options.prepare.threshold = threshold_of(text); },
            "Take the voxels of a grey image from LO up (to HI)")
        ->type_name("LO[:HI]");
}

void add_without_option(CLI::App& verb, InputOptions& options) {
    add_texts(verb, "--without", options.prepare.without, "SLICE",
              "Slice to leave out, by its name in messages, like 'plane 9', 'z = -12.5' or 'k = 40'; may be "
              "repeated");
}

void add_keep_largest_option(CLI::App& verb, InputOptions& options) {
    add_optional_count(verb, "--keep-largest", options.prepare.keep_largest, 1,
                       "Keep the N largest connected pieces of each structure of the whole image");
}

void add_selection_options(CLI::App& verb, InputOptions& options) {
    add_texts(verb, "--structure", options.prepare.structures, "NAME",
              "Structure to take, by name or number; may be repeated (default: all)");
    add_without_option(verb, options);
    add_threshold_option(verb, options);
    add_keep_largest_option(verb, options);
    add_optional_count(verb, "--every", options.prepare.every, 1, "Keep every Nth slice");
    add_count(verb, "--offset", options.prepare.offset, 0, largest_count,
              "The first slice that --every keeps, from 0 (default 0)");
    verb.add_option_function<std::string>(
            "--epsilon",
            [&options](const std::string& text) {
                options.prepare.epsilon_mm =
                    text == "exact" ? 0.0 : strict_number("--epsilon", text, 1e-6, 10);
            },
            "Every traced or drawn point stays within MM of the kept polygon, 1e-6 to 10 (default: 0.15 of "
            "the "
            "pixel for traced contours, exact for drawn ones, but for points less than 0.01 mm apart)")
        ->type_name("MM|exact");
    verb.add_option_function<std::string>(
            "--min-area",
            [&options](const std::string& text) {
                options.prepare.min_area_mm2 = strict_number("--min-area", text, 0, 1e6);
            },
            "Leave out traced islands below this area and count them (default: 4 pixels)")
        ->type_name("MM2");
}

}  // namespace anatomesh
