#include "seeds.h"

#include "anatomesh/live/edit/drawing_for_test.h"
#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/csl_writer.h"
#include "anatomesh_io/contour/json_writer.h"
#include "anatomesh_io/dicom/dicom_fixtures.h"
#include "anatomesh_io/dicom/segmentation_fixtures.h"
#include "anatomesh_io/dicom/write_objects.h"
#include "anatomesh_io/image/image_fixtures.h"
#include "anatomesh_io/image/invesalius_fixtures.h"
#include "anatomesh_io/project/write_record.h"

namespace anatomesh::fuzz {

using namespace fixtures;

namespace {

// Poses of three frames, the last one lost.
std::string pose_lines(const char* separator) {
    std::string lines;
    for (int frame = 0; frame < 5; ++frame) {
        const std::string name = "Seq_Frame000" + std::to_string(frame) + "_ImageToReferenceTransform";
        lines += name + separator + "0.1 0 0 " + std::to_string(frame) + " 0 0.1 0 0 0 0 1 2 0 0 0 1\n";
        lines += name + "Status" + separator + (frame == 4 ? "INVALID" : "OK") + "\n";
    }
    return lines;
}

}  // namespace

std::vector<std::string> dicom_series_seeds() {
    std::vector<std::string> seeds;
    const SliceFile good = ct_slice(0, {-10, -20, 30});
    seeds.push_back(good.bytes());
    SliceFile implicit = good;
    implicit.syntax = DicomWriter::Syntax::implicit_little;
    seeds.push_back(implicit.bytes());
    for (const auto& [tag, vr, value] : {std::tuple{tags::rows, "US", std::string("\xFF\xFF")},
                                         {tags::pixel_spacing, "DS", std::string("0\\0")},
                                         {tags::image_position, "DS", std::string("1e30\\nan\\1,5")},
                                         {tags::bits_allocated, "US", std::string("\x0c\0", 2)},
                                         {tags::number_of_frames, "IS", std::string("1000000000")},
                                         {tags::image_orientation, "DS", std::string("0\\0\\0\\0\\0\\0")}}) {
        SliceFile wrong = good;
        wrong.set(tag, vr, value);
        seeds.push_back(wrong.bytes());
    }
    seeds.push_back(good.bytes().substr(132));                         // without preamble
    seeds.push_back(good.bytes().substr(0, good.bytes().size() / 2));  // cut off
    SegFile frames = SegFile::stack(3);
    frames.bits = 8;
    frames.type = "FRACTIONAL";
    seeds.push_back(frames.bytes());
    return seeds;
}

std::vector<std::string> rtstruct_seeds() {
    const std::string good = format_rtstruct(contour_test::tilted_rings(1, 2), {});
    std::vector<std::string> seeds{good};
    seeds.push_back(good.substr(0, good.size() / 2));
    for (const char* word : {"CLOSED_PLANAR", "\\"}) {
        std::string wrong = good;
        wrong.replace(wrong.find(word), 1, "x");
        seeds.push_back(wrong);
    }
    return seeds;
}

std::vector<std::string> seg_seeds() {
    std::vector<std::string> seeds;
    SegFile file = SegFile::stack(3);
    seeds.push_back(file.bytes());
    file.frames[1].segment = 0;
    file.segments = {0, 1, 1};
    seeds.push_back(file.bytes());
    file = SegFile::stack(3);
    file.frames[2].position.z = 100;
    seeds.push_back(file.bytes());
    file.frames[2].axes = std::pair{Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    seeds.push_back(file.bytes());
    for (const auto& [type, bits] :
         {std::pair{"FRACTIONAL", 8}, {"LABELMAP", 8}, {"LABELMAP", 16}, {"OTHER", 1}}) {
        SegFile other = SegFile::stack(2);
        other.type = type;
        other.bits = static_cast<std::uint16_t>(bits);
        seeds.push_back(other.bytes());
    }
    return seeds;
}

std::vector<std::string> nifti_seeds() {
    std::vector<std::string> seeds;
    for (const int version : {1, 2})
        for (const std::endian order : {std::endian::little, std::endian::big}) {
            Nifti image;
            image.version = version;
            image.order = order;
            seeds.push_back(image.bytes());
            image.qform_code = 1;
            image.slope = 2.5;
            seeds.push_back(deflated(image.bytes()));
            image.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1};
            seeds.push_back(image.bytes());
            image.dim = {3, 3, 4, 5, 1, 1, 1, 1};
            image.vox_offset = version == 1 ? 1e30 : 1e15;
            seeds.push_back(image.bytes());
        }
    seeds.push_back(seeds[0].substr(0, 350));
    return seeds;
}

std::vector<std::string> nrrd_seeds() {
    const std::string data = Nifti().default_data();
    std::string text;
    for (int n = 0; n < 60; ++n) text += std::to_string(n % 7) + " ";
    return {nrrd_header() + data,
            nrrd_header("", "space: RAS\n", "gzip") + deflated(data),
            nrrd_header("", "space: LPS\n", "ascii") + text,
            nrrd_header("byte skip: -1\n") + data,
            nrrd_header("Segment0_Name:=liver\nSegment0_LabelValue:=3\nSegment0_Color:=1 0 0.5\n") + data,
            nrrd_header("data file: other.raw\n"),
            nrrd_header("space units: \"mm\" \"mm\" \"cm\"\n") + data,
            nrrd_header(pose_lines(":=")) + data,
            deflated(nrrd_header() + data),
            nrrd_header().substr(0, 60)};
}

std::vector<std::string> metaimage_seeds() {
    const std::string data = Nifti().default_data();
    std::string compressed = metaimage_header();
    compressed.replace(compressed.find("CompressedData = False"), 22, "CompressedData = True ");
    return {metaimage_header() + data,
            metaimage_header(pose_lines(" = ") + "UltrasoundImageOrientation = UN\n") + data,
            compressed + deflated(data, 15),
            metaimage_header("HeaderSize = -1\n") + data,
            metaimage_header("ElementNumberOfChannels = 1000000\n") + data,
            metaimage_header().substr(0, 80)};
}

std::vector<std::string> contour_json_seeds() {
    const std::string good = format_json_contours(contour_test::tilted_rings(2, 2));
    return {good, good.substr(0, good.size() / 2),
            R"({"format": "anatomesh-contours", "version": 1, "slices": []})", std::string(200, '['),
            R"({"format": "anatomesh-contours", "version": 1e400})"};
}

std::vector<std::string> project_seeds() {
    std::vector<std::string> seeds;
    for (unsigned seed = 0; seed < 4; ++seed) {
        drawing_for_test::RandomSteps steps(seed);
        EditHistory history;
        std::string text = head_record({}) + "\n";
        for (std::uint64_t n = 1; n < 25; ++n) {
            const bool is_undo = n % 6 == 0 && !history.done().empty();
            const Edit edit = is_undo ? history.done().back() : steps.step(history.drawing());
            text += (is_undo ? move_record(n, "undo", edit.name) : apply_record(n, edit)) + "\n";
            static_cast<void>(is_undo ? history.undo().ok() : history.apply(edit).ok());
        }
        seeds.push_back(std::move(text));
    }
    return seeds;
}

std::vector<std::string> csl_seeds() {
    return {
        "CSLC\n2 99\n\n1 11 3 0 0 1 -5\n\n0 0 5\n10 0 5\n10 10 5\n0 10 5\n2 2 5\n2 8 5\n8 8 5\n8 2 5\n"
        "20 0 5\n30 0 5\n20 1.5e1 5\n\n4 2 0 1 2 3\n4h0 2 4 5 6 7\n3 7 8 9 10\n\n"
        "12 3 1 0 0 2 -16\n0 0 8\n1 0 8\n0 1 8\n3 2 0 1 2\n",
        "CSLC\n1 1\n1 3 1 0 0 0 0\n0 0 0\n1 0 0\n0 1 0\n3 1 0 1 2\n",
        "CSLC\n4000000000 1\n1 4000000000 1 0 0 1 0\n",
        "CSLC\n1 1\n1 3 1 0 0 1 0\nnan 0 0\n1 0 0\n0 1 0\n3h7 1 0 1 9\n"};
}

std::vector<std::string> inv3_seeds() {
    const std::string data = Nifti().default_data();
    const std::string good = project(plist(), data);
    return {good,
            deflated(good),
            project(plist("int16", "900000000 900000000 9"), data),
            project("<plist><dict>", data),
            good.substr(0, 700),
            tar_entry("main.plist", plist(), 077777777777)};
}

}  // namespace anatomesh::fuzz
