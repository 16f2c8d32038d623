#include "anatomesh_io/image/tracked_frames.h"

#include <cmath>

#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::tracked_frames_test {
namespace {

using namespace fixtures;

std::string matrix(Vec3 x, Vec3 y, Vec3 z, Vec3 shift) {
    std::string text;
    for (const auto& [a, b, c, d] : {std::array{x.x, y.x, z.x, shift.x}, std::array{x.y, y.y, z.y, shift.y},
                                     std::array{x.z, y.z, z.z, shift.z}, std::array{0.0, 0.0, 0.0, 1.0}})
        for (const double value : {a, b, c, d}) text += std::to_string(value) + " ";
    return text;
}

struct Sequence {
    int columns = 9, rows = 7, frames = 4;
    std::string more, orientation = "MFA";
    std::vector<std::string> probe_to_tracker, reference_to_tracker, status;

    // The probe turns about y by 0.2 a frame; the reference lies at (0, 0, 100) of the tracker.
    Sequence() {
        for (int f = 0; f < frames; ++f) {
            const double a = 0.2 * f;
            probe_to_tracker.push_back(matrix({std::cos(a), 0, -std::sin(a)}, {0, 1, 0},
                                              {std::sin(a), 0, std::cos(a)}, {5.0 * f, 0, 100}));
            reference_to_tracker.push_back(matrix({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 100}));
            status.push_back("OK");
        }
    }
    KeyValues keys() const {
        KeyValues keys{{"UltrasoundImageOrientation", orientation}};
        for (std::size_t f = 0; f < probe_to_tracker.size(); ++f) {
            const std::string name = "Seq_Frame000" + std::to_string(f) + "_";
            keys.emplace_back(name + "ProbeToTrackerTransform", probe_to_tracker[f]);
            keys.emplace_back(name + "ProbeToTrackerTransformStatus", status[f]);
            keys.emplace_back(name + "ReferenceToTrackerTransform", reference_to_tracker[f]);
            keys.emplace_back(name + "ReferenceToTrackerTransformStatus", "OK");
            keys.emplace_back(name + "Timestamp", "1." + std::to_string(f));
        }
        return keys;
    }
    // A disc of 200 in the middle of every frame.
    std::string pixels() const {
        std::string bytes;
        for (int f = 0; f < frames; ++f)
            for (int j = 0; j < rows; ++j)
                for (int i = 0; i < columns; ++i)
                    bytes += static_cast<char>(std::hypot(i - 4, j - 3) < 2.5 ? 200 : 10);
        return bytes;
    }
    std::string metaimage() const {
        std::string header =
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
            "CompressedData = False\nDimSize = 9 7 4\nElementSpacing = 1 1 1\nOffset = 0 0 0\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementType = MET_UCHAR\nKinds = domain domain list\n";
        for (const auto& [key, value] : keys()) header += key + " = " + value + "\n";
        return header + more + "ElementDataFile = LOCAL\n" + pixels();
    }
    std::string nrrd() const {
        std::string header =
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9 7 4\nencoding: raw\n"
            "kinds: domain domain list\nspace directions: (1,0,0) (0,1,0) none\n";
        for (const auto& [key, value] : keys()) header += key + ":=" + value + "\n";
        return header + "\n" + pixels();
    }
};

ReadImageOptions tracked() {
    ReadImageOptions options;
    options.tracked = true;
    // Pixels of 0.5 x 0.25 mm; the image's corner at (-2, 0, 10) of the probe.
    options.image_to_probe = {0.5, 0, 0, -2, 0, 0.25, 0, 0, 0, 0, 1, 10};
    return options;
}

TEST(TrackedFrames, each_frame_lies_where_its_pose_says) {
    for (const std::string& file : {Sequence().metaimage(), Sequence().nrrd()}) {
        const Outcome outcome = read_bytes(file, tracked());
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        ASSERT_EQ(outcome.loaded.poses.size(), 4u);
        EXPECT_FALSE(outcome.loaded.known_axes);
        EXPECT_TRUE(outcome.warned("W-TRK-002"));
        for (int f = 0; f < 4; ++f) {
            const FramePose& pose = outcome.loaded.poses[static_cast<std::size_t>(f)];
            const double a = 0.2 * f;
            const auto at = [&](double i, double j) {  // the pixel in the probe, turned and moved
                const Vec3 p{0.5 * i - 2, 0.25 * j, 10};
                return Vec3{std::cos(a) * p.x + std::sin(a) * p.z + 5 * f, p.y,
                            -std::sin(a) * p.x + std::cos(a) * p.z};
            };
            for (const auto& [i, j] : {std::pair{0.0, 0.0}, {8.0, 6.0}}) {
                const Vec3 found = pose.origin + i * pose.step[0] + j * pose.step[1];
                EXPECT_NEAR(length(found - at(i, j)), 0, 1e-4) << f;
            }
        }
    }
}

TEST(TrackedFrames, a_sequence_is_never_taken_for_a_volume) {
    EXPECT_EQ(read_bytes(Sequence().metaimage()).code, "E-TRK-005");
    EXPECT_EQ(read_bytes(Sequence().nrrd()).code, "E-TRK-005");
}

TEST(TrackedFrames, targets_and_axes) {
    ReadImageOptions options = tracked();
    options.pose_to = "Tracker";
    const Outcome tracker = read_bytes(Sequence().metaimage(), options);
    ASSERT_TRUE(tracker.ok()) << to_line(tracker.error);
    EXPECT_NEAR(tracker.loaded.poses[0].origin.z, 110, 1e-4);
    options = tracked();
    options.frame = ImageFrame::ras;
    const Outcome ras = read_bytes(Sequence().metaimage(), options);
    EXPECT_TRUE(ras.loaded.known_axes);
    EXPECT_NEAR(ras.loaded.poses[0].origin.x, 2, 1e-6);
    options.pose_to = "Stylus";
    EXPECT_EQ(read_bytes(Sequence().metaimage(), options).code, "E-TRK-001");
    options = tracked();
    options.image_to_probe.clear();
    const Outcome uncalibrated = read_bytes(Sequence().metaimage(), options);
    EXPECT_EQ(uncalibrated.code, "E-TRK-001");
    EXPECT_NE(uncalibrated.error.next_step.find("--image-to-probe"), std::string::npos);
    // A calibration in the file, for all frames.
    Sequence calibrated;
    calibrated.more =
        "ImageToProbeTransform = " + matrix({0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 1}, {-2, 0, 10}) + "\n";
    EXPECT_TRUE(read_bytes(calibrated.metaimage(), options).ok());
}

TEST(TrackedFrames, orientations_of_the_image) {
    for (const auto& [orientation, x, y] :
         {std::tuple{"MF", -2.0, 0.0}, {"UF", 2.0, 0.0}, {"MN", -2.0, 1.5}, {"UNA", 2.0, 1.5}}) {
        Sequence sequence;
        sequence.orientation = orientation;
        const Outcome outcome = read_bytes(sequence.metaimage(), tracked());
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        EXPECT_NEAR(outcome.loaded.poses[0].origin.x, x, 1e-6) << orientation;
        EXPECT_NEAR(outcome.loaded.poses[0].origin.y, y, 1e-6) << orientation;
    }
    Sequence sequence;
    sequence.orientation = "FM";
    EXPECT_EQ(read_bytes(sequence.metaimage(), tracked()).code, "E-TRK-006");
}

// PLUS reads no pixels of such frames: what is stored there is left over from others.
TEST(TrackedFrames, frames_without_an_image_are_left_out) {
    for (unsigned invalid = 0; invalid < 16; ++invalid) {
        Sequence sequence;
        std::vector<std::uint32_t> rest;
        for (std::uint32_t f = 0; f < 4; ++f) {
            const bool is_invalid = (invalid >> f & 1) != 0;
            sequence.more += "Seq_Frame000" + std::to_string(f) +
                             "_ImageStatus = " + (is_invalid ? "INVALID" : "OK") + "\n";
            if (!is_invalid) rest.push_back(f);
        }
        const Outcome outcome = read_bytes(sequence.metaimage(), tracked());
        if (rest.empty()) {
            EXPECT_EQ(outcome.code, "E-TRK-004");
            continue;
        }
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        std::vector<std::uint32_t> read;
        for (const FramePose& pose : outcome.loaded.poses) read.push_back(pose.frame);
        EXPECT_EQ(read, rest) << invalid;
        EXPECT_EQ(outcome.warned("W-TRK-001"), invalid != 0);
    }
}

TEST(TrackedFrames, colour_frames_are_said_to_be_so) {
    Sequence sequence;
    sequence.more = "UltrasoundImageType = RGB_COLOR\nElementNumberOfChannels = 3\n";
    const Outcome outcome = read_bytes(sequence.metaimage(), tracked());
    EXPECT_EQ(outcome.code, "E-IMG-008");
    EXPECT_NE(outcome.error.message.find("3 channels"), std::string::npos) << outcome.error.message;
}

TEST(TrackedFrames, frames_without_a_pose_are_left_out_and_wrong_ones_refused) {
    Sequence sequence;
    sequence.status[1] = "INVALID";
    const Outcome lost = read_bytes(sequence.metaimage(), tracked());
    ASSERT_TRUE(lost.ok());
    EXPECT_EQ(lost.loaded.poses.size(), 3u);
    EXPECT_EQ(lost.loaded.poses[1].frame, 2u);
    EXPECT_TRUE(lost.warned("W-TRK-001"));
    sequence.status = {"INVALID", "MISSING", "", "x"};
    EXPECT_EQ(read_bytes(sequence.metaimage(), tracked()).code, "E-TRK-004");
    for (const auto& [text, code] : {std::pair{"1 0 0 0", "E-TRK-002"},
                                     {"1 0 0 x 0 1 0 0 0 0 1 0 0 0 0 1", "E-TRK-002"},
                                     {"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "E-TRK-002"},
                                     {"1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1", "E-TRK-002"},
                                     {"0 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "E-TRK-003"},
                                     {"1 1 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "E-TRK-003"},
                                     {"1 0 0 1e9 0 1 0 0 0 0 1 0 0 0 0 1", "E-TRK-003"}}) {
        Sequence wrong;
        wrong.probe_to_tracker[2] = text;
        EXPECT_EQ(read_bytes(wrong.metaimage(), tracked()).code, code) << text;
    }
}

std::string code_with_probe(const std::string& probe_to_tracker) {
    Sequence sequence;
    sequence.probe_to_tracker[2] = probe_to_tracker;
    return read_bytes(sequence.metaimage(), tracked()).code;
}

std::string code_with_calibration(const std::vector<double>& matrix) {
    ReadImageOptions options = tracked();
    options.image_to_probe = matrix;
    return read_bytes(Sequence().metaimage(), options).code;
}

TEST(TrackedFrames, C31_matrices_that_are_no_rotation) {
    EXPECT_EQ(code_with_probe("1.000001 0 0 5 0 1 0 0 0.000001 0 1 100 0 0 0 1"), "");
    EXPECT_EQ(code_with_probe("1.01 0 0 5 0 1 0 0 0 0 1 100 0 0 0 1"), "E-TRK-003");
    EXPECT_EQ(code_with_probe("1 0.01 0 5 0 1 0 0 0 0 1 100 0 0 0 1"), "E-TRK-003");
    EXPECT_EQ(code_with_probe("1 0 0 5 0 1 0.01 0 0 0 1 100 0 0 0 1"), "E-TRK-003");
    for (const char* mirrored : {"-1 0 0 5 0 1 0 0 0 0 1 100 0 0 0 1", "1 0 0 5 0 1 0 0 0 0 -1 100 0 0 0 1",
                                 "0 1 0 5 1 0 0 0 0 0 1 100 0 0 0 1"})
        EXPECT_EQ(code_with_probe(mirrored), "E-TRK-007") << mirrored;
    EXPECT_EQ(code_with_probe("nan 0 0 5 0 1 0 0 0 0 1 100 0 0 0 1"), "E-TRK-002");
    EXPECT_EQ(code_with_probe("1 0 0 0 0 1 0 0 0 0 1 0 5 0 100 1"), "E-TRK-002");  // by columns
}

TEST(TrackedFrames, C31_calibrations_that_are_no_rotation_and_scales) {
    EXPECT_EQ(code_with_calibration({0.5, 5e-7, 0, -2, 0, 0.25, 0, 0, 0, 0, 1, 10}), "");
    EXPECT_EQ(code_with_calibration({0.5, 0.025, 0, -2, 0, 0.25, 0, 0, 0, 0, 1, 10}), "E-TRK-003");
    EXPECT_EQ(code_with_calibration({0.5, 0, 0, -2, 0, NAN, 0, 0, 0, 0, 1, 10}), "E-TRK-002");
    EXPECT_EQ(code_with_calibration({0.5, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 1, 0, -2, 0, 10, 1}), "E-TRK-002");
    EXPECT_EQ(code_with_calibration({-0.5, 0, 0, -2, 0, 0.25, 0, 0, 0, 0, 1, 10}), "E-TRK-007");
    // Said to be meant so: the image is seen from behind.
    ReadImageOptions behind = tracked();
    behind.image_to_probe = {-0.5, 0, 0, 2, 0, 0.25, 0, 0, 0, 0, -1, 10};
    const Outcome outcome = read_bytes(Sequence().metaimage(), behind);
    ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
    EXPECT_NEAR(length(outcome.loaded.poses[0].step[0] - Vec3{-0.5, 0, 0}), 0, 1e-9);
}

TEST(TrackedFrames, contours_lie_in_the_planes_of_their_frames) {
    const Outcome outcome = read_bytes(Sequence().metaimage(), tracked());
    ASSERT_TRUE(outcome.ok());
    const GreyImage& image = outcome.loaded.image;
    LabelMap labels;
    labels.geometry = image.geometry;
    labels.structures.push_back({5, "disc", {1, 2, 3}});
    for (const float value : image.voxels) labels.voxels.push_back(value > 100);
    RunContext context;
    const auto traced =
        trace_frames(labels, outcome.loaded.poses, Frame::unknown, &image, 100, 0, {}, context);
    ASSERT_TRUE(traced.ok()) << to_line(traced.error());
    const ContourSet& set = traced.value().kept;
    ASSERT_EQ(set.slices.size(), 4u);
    EXPECT_EQ(set.frame, Frame::unknown);
    EXPECT_EQ(set.structures[0].number, 5);
    for (const Contour& contour : set.contours) {
        const FramePose& pose = outcome.loaded.poses[contour.slice];
        const Vec3 normal = normalized(cross(pose.step[0], pose.step[1]));
        const Vec3 middle = pose.origin + 4.0 * pose.step[0] + 3.0 * pose.step[1];
        for (const Vec3& p : set.points_of(contour)) {
            EXPECT_NEAR(dot(p - pose.origin, normal), 0, 1e-9);
            const Vec3 w = p - middle;
            const double i = dot(w, pose.step[0]) / squared_length(pose.step[0]),
                         j = dot(w, pose.step[1]) / squared_length(pose.step[1]);
            EXPECT_NEAR(std::hypot(i, j), 2.5, 0.6);
        }
    }
}

}  // namespace
}  // namespace anatomesh::tracked_frames_test
