// DicomObject: what one DICOM file says about itself: identity, what it refers to, and where its frames lie.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh_io/dicom/data_set.h"

namespace anatomesh {

enum class DicomKind : std::uint8_t { image, rtstruct, segmentation, other };

// A plane of pixels in space, LPS mm. Pixel (i, j) is centred at position + i spacing[0] row + j spacing[1]
// column.
struct DicomFrame {
    std::uint32_t object = 0;  // index of the object it is in, as the caller counts
    std::uint32_t frame = 0;   // in the object, from 0
    std::uint32_t columns = 0, rows = 0;
    Vec3 position, row, column;
    std::array<double, 2> spacing{1, 1};  // between columns, between rows
    double slope = 1, intercept = 0;      // of stored values
    std::int64_t number = 0;              // InstanceNumber, of one frame a file; 0 when absent
    // So many marks tell volumes at the same place apart: acquisition, time, echo and b-value among them.
    // They are texts, empty when absent. [marks; 5; D]
    static constexpr std::size_t marks = 5;
    std::array<std::string, marks> mark;
};
const char* mark_name(std::size_t mark);

// How the values of a frame are stored.
struct PixelFormat {
    std::uint32_t rows = 0, columns = 0, frames = 1;
    std::uint32_t bits_allocated = 16, bits_stored = 16, high_bit = 15;
    bool is_signed = false;

    std::uint64_t frame_bits() const { return std::uint64_t{rows} * columns * bits_allocated; }
    friend bool operator==(const PixelFormat&, const PixelFormat&) = default;
};

struct DicomObject {
    std::string path, label;  // where it is; how messages and reports call it
    std::string sha256;
    std::uint64_t bytes = 0;

    DicomKind kind = DicomKind::other;
    std::string sop_class, sop_instance, study, series, frame_of_reference, modality, transfer_syntax;
    std::string description;  // of the series, UTF-8
    std::string patient_key;  // equal for equal patients; a hash
    std::string image_type;
    std::int64_t series_number = 0;
    std::uint32_t rows = 0, columns = 0, frames = 0;

    // Facts that only check the geometry; absent when the file does not say.
    std::optional<double> gantry_tilt, spacing_between_slices, slice_thickness, images_in_acquisition;
    // Series and instances that an RTSTRUCT or SEG refers to.
    std::vector<std::string> referenced_series, referenced_instances;

    // Of images and segmentations: the frames with their places, and how their values are stored; or why they
    // cannot be used; and the warnings to be given when they are.
    std::vector<DicomFrame> planes;
    PixelFormat format;
    bool known_axes = true, placed_by_step = false;  // as in FramesOfObject
    std::optional<Error> image_error;
    std::vector<Warning> image_warnings;

    // A file that is damaged but says its series; little else of it is known then.
    std::optional<Error> damage;
};

// How the frames of an object are read where it leaves that open.
struct FrameOptions {
    // --ultrasound-region N: which region's scale counts, from 0.
    std::optional<std::uint32_t> ultrasound_region;
    // --frame-step MM: how far each frame of a file that says the place of its first frame alone lies from the one
    // before, along the normal of the first (row x column); negative: against it. mm, not 0.
    std::optional<double> step_mm;
};

// Reads the header of a data set. Never fails: what is malformed is kept as `image_error`.
DicomObject describe_object(const DataSet& set, const std::string& path, const std::string& label,
                            const FrameOptions& options = {});

struct FramesOfObject {
    std::vector<DicomFrame> frames;
    bool known_axes =
        true;  // whether positions are LPS; else in axes of the volume that the file does not tell
    bool by_step = false;  // whether FrameOptions::step_mm placed them
};

// The frames of an image or segmentation object with their places (frame_places.h), and what else their functional
// groups say: per-frame values before shared ones before those of the whole object. Errors: those of
// frame_places.h; E-DCM-002, -003 values; E-DCM-006 no usable pixel spacing; E-DCM-007 a number of frames that does
// not fit; E-DCM-034 ultrasound regions of different scales, of which an option chooses one. An ultrasound image
// without PixelSpacing has that of its region in two dimensions; regions of other kinds (Doppler, M-mode) and
// without unit of length have none. Warns W-DCM-005 of an orientation off by rounding, which is made exact;
// W-DCM-021 of a region whose scale is not the PixelSpacing, which counts.
Result<FramesOfObject> read_frames(const DataSet& set, RunContext& context, const FrameOptions& options = {});

// The pixel format. Errors: E-DCM-003 missing, E-DCM-010 impossible, or one that is not read (colours, 64
// bits). Warns W-DCM-006 of a high bit that does not fit, W-DCM-007 of MONOCHROME1.
Result<PixelFormat> read_pixel_format(const DataSet& set, RunContext& context);

}  // namespace anatomesh
