#include "anatomesh_io/dicom/choose.h"

#include <gtest/gtest.h>

#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/dicom_fixtures.h"
#include "anatomesh_io/dicom/dicom_source.h"
#include "anatomesh_io/dicom/write_objects.h"

namespace anatomesh::choose_test {
namespace {

using fixtures::ct_series;
using fixtures::Reading;

ContourSet square_set(double z0, int slices, double shift = 0) {
    ContourSet set;
    set.structures.push_back({1, "square", {1, 2, 3}});
    for (int k = 0; k < slices; ++k) {
        const double z = z0 + 3 * k;
        set.slices.push_back({{{0, 0, z}, {0, 0, 1}}, static_cast<std::uint32_t>(k), 1, ""});
        set.contours.push_back(
            {0, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(set.points.size()), 4});
        for (const auto& [x, y] : {std::pair{-9.0, -19.5}, {-4.0, -19.5}, {-4.0, -19.0}, {-9.0, -19.0}})
            set.points.push_back({x + shift, y, z});
    }
    return set;
}

// A CT of `slices` images and an RTSTRUCT that refers to them.
struct Study : Reading {
    explicit Study(const ContourSet& set, const std::vector<fixtures::SliceFile>& slices = ct_series(5))
        : Reading(slices) {
        scan();
        const auto source = dicom_source(*folder, folder->series[0].objects, true);
        EXPECT_TRUE(source.ok());
        rtstruct = format_rtstruct(set, source.value());
    }
    Result<DicomChoice> choose(const std::string& series = "") {
        scan();
        return choose_dicom(*folder, series, context);
    }
    std::string rtstruct;
};

std::string code_of(const Result<DicomChoice>& choice) {
    return choice.ok() ? "" : choice.error().code;
}

TEST(DicomChoice, G24_the_series_that_contours_refer_to) {
    Study study(square_set(30, 5));
    auto other = ct_series(3);
    for (auto& file : other) {
        file.set(tags::series_instance, "UI", "1.2.3.55");
        file.set(tags::modality, "CS", "PT");
        file.set(tags::sop_instance, "UI", file.uid() + ".9");
    }
    for (std::size_t k = 0; k < other.size(); ++k)
        study.disk.write("folder/pet" + std::to_string(k), other[k].bytes());
    study.disk.write("folder/rubbish.txt", "rubbish");
    EXPECT_EQ(code_of(study.choose()), "E-DCM-029");  // two image series, nothing drawn
    study.disk.write("folder/contours", study.rtstruct);
    const auto choice = study.choose();
    ASSERT_TRUE(choice.ok()) << to_line(choice.error());
    EXPECT_EQ(choice.value().kind, DicomKind::rtstruct);
    EXPECT_EQ(choice.value().images.size(), 5u);
    for (const std::uint32_t index : choice.value().images)
        EXPECT_EQ(study.folder->objects[index].series, "1.2.3.2");
}

TEST(DicomChoice, series_are_chosen_by_uid_or_by_name) {
    Study study(square_set(30, 5));
    study.disk.write("folder/contours", study.rtstruct);
    for (const std::string& name : {std::string("1.2.3.2"), series_name("1.2.3.2")}) {
        const auto choice = study.choose(name);
        ASSERT_TRUE(choice.ok()) << to_line(choice.error());
        EXPECT_EQ(choice.value().kind, DicomKind::image);
        EXPECT_EQ(choice.value().objects.size(), 5u);
    }
    const auto none = study.choose("1.2.3.4711");
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, "E-DCM-028");
    EXPECT_NE(none.error().next_step.find("RTSTRUCT"), std::string::npos) << none.error().next_step;
    EXPECT_NE(none.error().next_step.find("5 images of 5 x 4"), std::string::npos) << none.error().next_step;
}

TEST(DicomChoice, G23_one_series_uid_in_two_studies) {
    Study study(square_set(30, 5));
    auto copies = fixtures::ct_series(5);
    for (std::size_t k = 0; k < copies.size(); ++k) {
        copies[k].set(tags::study_instance, "UI", "1.2.3.77");
        copies[k].set(tags::sop_instance, "UI", copies[k].uid() + ".9");
        study.disk.write("folder/copy" + std::to_string(k), copies[k].bytes());
    }
    EXPECT_EQ(code_of(study.choose()), "E-DCM-029");
    EXPECT_EQ(code_of(study.choose("1.2.3.2")), "E-DCM-028");
    ASSERT_EQ(study.folder->series.size(), 2u);
    EXPECT_NE(study.folder->series[0].name, study.folder->series[1].name);
    for (const DicomSeries& series : std::vector<DicomSeries>(study.folder->series)) {
        const auto choice = study.choose(series.name);
        ASSERT_TRUE(choice.ok()) << to_line(choice.error());
        ASSERT_EQ(choice.value().objects.size(), 5u);
        EXPECT_EQ(study.folder->objects[choice.value().objects[0]].study, series.study);
    }
    // Contours go with the images of their own study.
    study.disk.write("folder/contours", study.rtstruct);
    const auto choice = study.choose();
    ASSERT_TRUE(choice.ok()) << to_line(choice.error());
    ASSERT_EQ(choice.value().images.size(), 5u);
    for (const std::uint32_t index : choice.value().images)
        EXPECT_NE(study.folder->objects[index].study, "1.2.3.77");
}

TEST(DicomChoice, RS32_two_structure_sets) {
    Study study(square_set(30, 5));
    study.disk.write("folder/contours", study.rtstruct);
    Study second(square_set(30, 4));
    study.disk.write("folder/more", second.rtstruct);
    EXPECT_EQ(code_of(study.choose()), "E-DCM-029");
}

TEST(DicomChoice, G06_a_structure_set_that_is_there_twice) {
    Study study(square_set(30, 5));
    study.disk.write("folder/contours", study.rtstruct);
    study.disk.write("folder/deep copy", study.rtstruct);
    const auto choice = study.choose();
    ASSERT_TRUE(choice.ok()) << to_line(choice.error());
    EXPECT_EQ(choice.value().objects.size(), 1u);
    EXPECT_EQ(choice.value().images.size(), 5u);
    EXPECT_TRUE(study.warned("W-DCM-003"));
}

TEST(DicomChoice, RS21_G05_images_that_are_not_here) {
    Study study(square_set(30, 5));
    Reading alone;
    alone.disk.write("folder/contours", study.rtstruct);
    alone.scan();
    const auto choice = choose_dicom(*alone.folder, "", alone.context);
    ASSERT_TRUE(choice.ok());
    EXPECT_TRUE(choice.value().images.empty());
    EXPECT_TRUE(alone.warned("W-DCM-018"));
    EXPECT_NE(alone.warnings().find("5 of 5"), std::string::npos) << alone.warnings();
}

// What choosing gives for an RTSTRUCT of the usual series beside `images`.
std::string beside(const std::vector<fixtures::SliceFile>& images, const ChooseOptions& options,
                   Reading& reading) {
    Study study(square_set(30, 5));
    reading.disk.write("folder/contours", study.rtstruct);
    for (std::size_t k = 0; k < images.size(); ++k)
        reading.disk.write(fixtures::name_of_slice(static_cast<int>(k)), images[k].bytes());
    reading.scan();
    return code_of(choose_dicom(*reading.folder, "", reading.context, options));
}

TEST(DicomChoice, RS22_RS34_another_frame_of_reference) {
    auto moved = ct_series(5);
    for (auto& file : moved) file.set(tags::frame_of_reference, "UI", "7.7.7");
    Reading refused, ignored;
    EXPECT_EQ(beside(moved, {}, refused), "E-DCM-032");
    EXPECT_EQ(beside(moved, {.ignore_frame_of_reference = true}, ignored), "");
    EXPECT_TRUE(ignored.warned("W-DCM-022"));
}

TEST(DicomChoice, RS23_another_patient) {
    auto others = ct_series(5);
    for (auto& file : others) file.set(tags::patient_id, "LO", "another");
    Reading refused, ignored;
    EXPECT_EQ(beside(others, {}, refused), "E-DCM-033");
    EXPECT_EQ(beside(others, {.ignore_patient = true}, ignored), "");
    EXPECT_TRUE(ignored.warned("W-DCM-022"));
}

TEST(DicomChoice, G34_the_same_series_under_other_uids) {
    const auto renamed = [](double shift) {
        auto files = ct_series(5);
        for (std::size_t k = 0; k < files.size(); ++k) {
            auto& file = files[k];
            file.set(tags::series_instance, "UI", "9.9.2");
            file.set(tags::study_instance, "UI", "9.9.1");
            file.set(tags::frame_of_reference, "UI", "9.9.3");
            file.set(tags::sop_instance, "UI", "9.9.4." + std::to_string(k));
            file.set(tags::patient_id, "LO", "somebody");
            file.set(tags::image_position, "DS",
                     fixtures::numbers({-10, -20, 30 + 3.0 * static_cast<double>(k) + shift}));
        }
        return files;
    };
    Reading refused;
    EXPECT_EQ(beside(renamed(0), {}, refused), "E-DCM-035");
    for (const double shift : {0.0, 1.0}) {
        Reading reading;
        EXPECT_EQ(beside(renamed(shift), {.match_by_geometry = true}, reading), "");
        const auto raw = read_contours(reading.disk.path("folder/contours"), {}, reading.context);
        ASSERT_TRUE(raw.ok());
        const auto images = match_images(raw.value(), *reading.folder);
        ASSERT_EQ(images.ok(), shift == 0);
        if (!images.ok()) {
            EXPECT_EQ(images.error().code, "E-DCM-036");
            continue;
        }
        EXPECT_EQ(images.value().size(), 5u);
    }
}

TEST(DicomChoice, D01_nothing_usable) {
    Reading reading;
    reading.disk.write("folder/notes.txt", "notes");
    reading.scan();
    EXPECT_EQ(code_of(choose_dicom(*reading.folder, "", reading.context)), "E-DCM-031");
}

// The warnings, or the error's code, of contours beside the images that they refer to.
std::string beside_images(const ContourSet& set, const AcceptContours& accept = {},
                          const std::vector<fixtures::SliceFile>& slices = ct_series(5)) {
    Study study(set, slices);
    study.disk.write("folder/contours", study.rtstruct);
    const auto choice = study.choose();
    EXPECT_TRUE(choice.ok());
    ReadContoursOptions as_they_are;
    as_they_are.unit_mm = 1;
    const auto raw = read_contours(study.disk.path("folder/contours"), as_they_are, study.context);
    EXPECT_TRUE(raw.ok());
    const auto status =
        check_against_images(raw.value(), *study.folder, choice.value().images, accept, study.context);
    return status.ok() ? study.warnings() : status.error().code;
}

// The squares reach from x = -9 to -4; the images begin half a pixel before x = -10.
TEST(DicomChoice, RS31_contours_partly_outside_their_images_are_told) {
    for (const double shift : {-0.5, 0.0, 0.3})
        EXPECT_EQ(beside_images(square_set(30, 5, shift)), "") << shift;
    for (const double shift : {-2.7, -3.5, -5.0}) {
        ContourSet set = square_set(30, 5);
        for (std::uint32_t k = 8; k < 12; ++k) set.points[k].x += shift;  // the third slice, at z = 36
        const std::string told = beside_images(set);
        EXPECT_NE(told.find("W-DCM-027"), std::string::npos) << told;
        EXPECT_NE(told.find("1 contours reach"), std::string::npos) << told;
        EXPECT_NE(told.find("square"), std::string::npos) << told;
        EXPECT_NE(told.find("z = 36"), std::string::npos) << told;
        EXPECT_NE(told.find("mm outside"), std::string::npos) << told;
        EXPECT_EQ(told.find("W-DCM-020"), std::string::npos) << told;
    }
    // Wholly outside, beside the others: the slice and the distance are told too.
    ContourSet beyond = square_set(30, 8);
    const std::string told = beside_images(beyond);
    EXPECT_NE(told.find("z = 51"), std::string::npos) << told;
    EXPECT_NE(told.find("9 mm outside"), std::string::npos) << told;
}

TEST(DicomChoice, RS10_RS31_planes_and_places_against_the_images) {
    EXPECT_EQ(beside_images(square_set(30, 5)), "");
    EXPECT_EQ(beside_images(square_set(30.01, 5)), "");
    EXPECT_NE(beside_images(square_set(31.5, 4)).find("W-DCM-019"), std::string::npos);
    EXPECT_NE(beside_images(square_set(30, 8)).find("W-DCM-020"), std::string::npos);  // partly
    for (const ContourSet& set : {square_set(30, 5, 500), square_set(300, 5)}) {
        EXPECT_EQ(beside_images(set), "E-DCM-037");
        EXPECT_NE(beside_images(set, {.outside = true}).find("W-DCM-020"), std::string::npos);
    }
}

TEST(DicomChoice, RS24_contours_that_refer_to_an_image_elsewhere) {
    // Made beside images that lie two slices higher under the same names.
    auto lower = ct_series(5);
    Study study(square_set(30, 5));
    for (std::size_t k = 0; k < lower.size(); ++k)
        lower[k].set(tags::image_position, "DS",
                     fixtures::numbers({-10, -20, 30 + 3.0 * static_cast<double>(k) - 6}));
    for (const bool is_moved : {false, true}) {
        Reading reading(is_moved ? lower : ct_series(5));
        reading.disk.write("folder/contours", study.rtstruct);
        reading.scan();
        const auto choice = choose_dicom(*reading.folder, "", reading.context);
        ASSERT_TRUE(choice.ok());
        const auto set = DataSet::parse(study.rtstruct, "contours");
        ASSERT_TRUE(set.ok());
        ASSERT_TRUE(
            check_references(set.value().root(), *reading.folder, choice.value().images, reading.context)
                .ok());
        EXPECT_EQ(reading.warned("W-DCM-024"), is_moved) << reading.warnings();
        if (is_moved) {
            EXPECT_NE(reading.warnings().find("5 contours"), std::string::npos) << reading.warnings();
        }
    }
}

TEST(DicomChoice, RS30_coordinates_in_cm_or_m) {
    for (const double unit : {10.0, 1000.0}) {
        ContourSet set = square_set(30, 5);
        for (Vec3& point : set.points) point = (1 / unit) * point;
        for (Slice& slice : set.slices) slice.plane.origin = (1 / unit) * slice.plane.origin;
        EXPECT_EQ(beside_images(set), "E-DCM-038");
        EXPECT_EQ(beside_images(set, {.outside = true}), "E-DCM-038");
        const std::string taken = beside_images(set, {.outside = true, .unit_is_given = true});
        EXPECT_NE(taken.find("W-DCM-020"), std::string::npos) << taken;
    }
    EXPECT_EQ(beside_images(square_set(31.5, 4)).find("E-DCM-038"), std::string::npos);
}

// In metres all slices lie within the tolerance of the one image at the origin.
TEST(DicomChoice, RS30_coordinates_in_cm_or_m_that_all_lie_on_one_image) {
    const Vec3 shift{10, 20, -30};
    for (const double spacing : {0.6, 1.0, 3.0}) {
        auto images = ct_series(9, spacing);
        for (std::size_t k = 0; k < images.size(); ++k)
            images[k].set(tags::image_position, "DS",
                          fixtures::numbers({0, 0, spacing * static_cast<double>(k)}));
        for (const double unit : {1.0, 1000.0}) {
            ContourSet set = square_set(30, 5);
            for (Vec3& point : set.points) {
                point += shift;
                point = (1 / unit) * Vec3{point.x, point.y, point.z / 3 * spacing};
            }
            for (std::size_t k = 0; k < set.slices.size(); ++k)
                set.slices[k].plane.origin = {0, 0, spacing * static_cast<double>(k) / unit};
            EXPECT_EQ(beside_images(set, {}, images), unit == 1 ? "" : "E-DCM-038") << spacing;
        }
    }
}

// A cochlea on slices 0.3 mm apart looks like centimetres, but its images say that it is not.
TEST(DicomChoice, the_word_on_the_unit_is_taken_back_where_images_agree) {
    for (const double z : {30.0, 31.5}) {
        Study study(square_set(z, 4), ct_series(5));
        study.disk.write("folder/contours", study.rtstruct);
        const auto choice = study.choose();
        ASSERT_TRUE(choice.ok());
        const auto raw = read_contours(study.disk.path("folder/contours"), {}, study.context);
        ASSERT_TRUE(raw.ok());
        study.context.warn({"W-RTS-006", "they may be in centimetres", {}, ""});
        ASSERT_TRUE(
            check_against_images(raw.value(), *study.folder, choice.value().images, {}, study.context).ok());
        EXPECT_EQ(study.warnings().find("W-RTS-006") == std::string::npos, z == 30) << study.warnings();
    }
}

// With a gantry tilt the images are shifted against each other: what lies within the pixels of one lies beside those
// of the first.
TEST(DicomChoice, images_that_are_shifted_against_each_other) {
    for (const double shift : {-30.0, -9.0, 9.0, 30.0}) {
        std::vector<fixtures::SliceFile> slices = ct_series(5);
        ContourSet set = square_set(30, 5);
        for (std::size_t k = 0; k < 5; ++k) {
            const double by = shift * static_cast<double>(k);
            slices[k].set(tags::image_position, "DS",
                          fixtures::numbers({-10, -20 + by, 30 + 3.0 * static_cast<double>(k)}));
            for (std::size_t p = 0; p < 4; ++p) set.points[4 * k + p].y += by;
        }
        EXPECT_EQ(beside_images(set, {}, slices), "") << shift;
        EXPECT_NE(beside_images(square_set(30, 5), {}, slices).find("W-DCM-020"), std::string::npos)
            << "straight up, they leave the images";
    }
}

TEST(DicomChoice, RS33_images_feet_first) {
    // Rows and slices run the other way; the contours stay where they are.
    std::vector<fixtures::SliceFile> slices;
    for (int k = 0; k < 5; ++k)
        slices.push_back(fixtures::ct_slice(k, {-2, -20, 42 - 3.0 * k}, 5, 4, {-1, 0, 0}, {0, 1, 0}));
    EXPECT_EQ(beside_images(square_set(30, 5), {}, slices), "");
}

TEST(DicomChoice, G33_numbers_rounded_between_slices_and_contours) {
    // Slices every 0.48828125 mm, written as 0.488281; contours at the exact places.
    std::vector<fixtures::SliceFile> slices;
    for (int k = 0; k < 60; ++k) slices.push_back(fixtures::ct_slice(k, {-10, -20, 30 + k * 0.488281}));
    ContourSet set = square_set(30, 60);
    for (std::size_t k = 0; k < 60; ++k) {
        set.slices[k].plane.origin.z = 30 + static_cast<double>(k) * 0.48828125;
        for (std::size_t p = 0; p < 4; ++p) set.points[4 * k + p].z = set.slices[k].plane.origin.z;
    }
    EXPECT_EQ(beside_images(set, {}, slices), "");
}

}  // namespace
}  // namespace anatomesh::choose_test
