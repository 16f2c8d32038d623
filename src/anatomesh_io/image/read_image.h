// read_image: a grey image or label map from a file: NIfTI, NRRD, MetaImage, InVesalius project.
//
// The kind is found by content. Positions come out in LPS millimetres: NIfTI's RAS and NRRD's spaces are
// turned, stated units are converted. The header is checked against the length of the data before memory is
// taken.
//
// Where a file leaves a choice that would place or mirror the patient differently, reading is refused and the
// error's next step names the option that decides; a decision taken is put on record by a warning.
//
// Errors by reader: E-IMG any image, E-NII NIfTI, E-NRD NRRD, E-MTI MetaImage, E-INV InVesalius, E-LBL label
// maps; E-INP the file itself. They are listed with their meaning in docs/errors.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/file/detect.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

enum class ImageFrame : std::uint8_t { lps, ras };
enum class NiftiTransform : std::uint8_t { automatic, qform, sform };

struct ReadImageOptions {
    // --frame LPS|RAS: the frame of the numbers in a file that does not say; ignored when it does.
    std::optional<ImageFrame> frame;
    // --use qform|sform: which transform of a NIfTI image counts when it has two that disagree.
    NiftiTransform nifti_transform = NiftiTransform::automatic;
    // --assume-orientation RAS: where i, j and k run to in a NIfTI image without orientation; one letter of
    // each pair L R, A P, S I. Empty: refuse such an image.
    std::string assume_orientation;
    // Whether a tracked sequence, whose frames have poses and make no volume, is read or refused; and how its
    // frames are placed (see tracked_frames.h): --image-to-probe, 12 or 16 numbers, the calibration where the
    // file has none; --pose-to NAME, the frame to place them in.
    bool tracked = false;
    std::vector<double> image_to_probe;
    std::string pose_to;
    // --volume N: which volume of an image that holds several, from 0.
    std::optional<std::uint64_t> volume;

    InputLimits limits;
    std::uint64_t max_voxels = std::uint64_t{1} << 34;
};

// Pixel (i, j) of a frame is centred at origin + i step[0] + j step[1], mm.
struct FramePose {
    std::uint32_t frame = 0;
    Vec3 origin;
    std::array<Vec3, 2> step;
};

struct InputHash {
    std::string path;
    std::string sha256;
};

// What the values look like: enough to tell a label map from a grey image.
struct ImageFacts {
    std::string voxel_type;  // "int16", as stored
    double slope = 1, intercept = 0;
    float low = 0, high = 0;       // of the finite values
    std::uint64_t not_finite = 0;  // NaN or infinite; set to `low` in the image
    std::array<std::uint32_t, 3> first_not_finite{0, 0, 0};
    std::uint32_t distinct = 0;  // different values, counted to 1001; 1001 also when one is negative
    // Gathered until `distinct` reaches 1001:
    double largest_fraction = 0;  // largest distance of a value from an integer, at most 0.5
    double equal_neighbors = 1;   // of the pairs (i, i + 1) that are not both 0: share with equal values
};

struct LoadedImage {
    GreyImage image;
    ImageFacts facts;
    FileKind kind = FileKind::unknown;
    std::vector<Structure> structures;  // names and colours, when the file gives them (3D Slicer); by number
    std::vector<InputHash> inputs;      // every file that was read
    // Of a tracked sequence: the frames that have a pose. Slice k of the image is then a frame wherever its
    // pose puts it, and the image's own geometry says no more than its size.
    std::vector<FramePose> poses;
    bool known_axes = true;  // whether positions are LPS; else in axes that the file does not tell
};

// Reads the image at `path`. Linear in the file and the voxels; memory about 4 bytes a voxel, the file, and
// the inflated file.
Result<LoadedImage> read_image(const std::string& path, const ReadImageOptions& options, RunContext& context);

// Whether the values are labels, judged by what they look like: integers from 0 up (within 0.001), at most
// 1000 different ones, and either at most 16 or mostly equal to their neighbours.
bool looks_like_label_map(const ImageFacts& facts);

// The image's values as labels; 0 is outside. Values within 0.001 of an integer are rounded with a warning.
// Structures take the values as numbers and the file's names where it has any.
// Warns of structures that the image border cuts.
// Errors (input): E-LBL-001 a value is not finite, -002 negative, -003 no integer, -004 above 16777215,
// -005 more than 65535 labels, -006 nothing but zeros. Linear in the voxels.
Result<LabelMap> to_label_map(const LoadedImage& loaded, RunContext& context);

}  // namespace anatomesh
