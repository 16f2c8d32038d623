// InputOptions: what the command line says about how to read an input and which part of it to take.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/pipeline/prepare_contours.h"
#include "limits.h"

namespace anatomesh {

// Defaults are those of the readers and of prepare_contours(); an option that was not given is empty.
struct InputOptions {
    std::string input;
    std::string frame;               // "LPS", "RAS" or empty
    std::string nifti_transform;     // "qform", "sform" or empty
    std::string assume_orientation;  // "RAS" or the like, or empty
    std::optional<std::uint32_t> volume;
    std::string series;             // of a folder of DICOM objects; empty: the one there is
    bool allow_gaps = false;        // --allow-gaps
    bool keep_patient_ids = false;  // --keep-patient-ids
    // What DICOM objects may contradict each other in.
    bool ignore_frame_of_reference = false, ignore_patient = false, match_by_geometry = false,
         allow_outside = false;
    std::optional<double> unit_mm;  // of the coordinates of contours: 1, 10 or 1000; nothing: 1, and checked
    std::optional<std::uint32_t> ultrasound_region;
    std::optional<double> frame_step_mm;
    // Tracked sequences.
    std::vector<double> image_to_probe;
    std::string pose_to;

    // Which part of the input is taken, and what is done to its contours.
    PrepareOptions prepare;
    std::vector<std::string>
        cleaning_given;  // the options among those of add_cleaning_options() that were given
    std::vector<std::string> reconcile_given;  // and of add_reconcile_options()
    Limits limits;
};

// INPUT and how to place it: --frame, --use, --assume-orientation, --volume, --series, --allow-gaps,
// --keep-patient-ids, --ignore-frame-of-reference, --ignore-patient, --match-by-geometry, --allow-outside,
// --ultrasound-region, --frame-step, --image-to-probe, --pose-to.
void add_reading_options(CLI::App& verb, InputOptions& options);

// How drawn contours are read and repaired: --holes, --unite-repeated-planes, --closing-gap, --same-line,
// --close-slivers, --close-gaps, --plane-repair, --keyhole, --max-repair.
void add_cleaning_options(CLI::App& verb, InputOptions& options);

// Which part of it, and how closely: --structure, --without, --threshold, --keep-largest, --every, --offset,
// --epsilon, --min-area.
void add_selection_options(CLI::App& verb, InputOptions& options);

// Three of these alone.
void add_without_option(CLI::App& verb, InputOptions& options);
void add_threshold_option(CLI::App& verb, InputOptions& options);
void add_keep_largest_option(CLI::App& verb, InputOptions& options);

}  // namespace anatomesh
