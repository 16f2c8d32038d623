#include "anatomesh_io/dicom/choose.h"

#include <gtest/gtest.h>

#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/dicom/dicom_fixtures.h"
#include "anatomesh_io/dicom/dicom_source.h"
#include "anatomesh_io/dicom/write_objects.h"

namespace anatomesh {
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

TEST(DicomChoice, RS32_two_structure_sets) {
    Study study(square_set(30, 5));
    study.disk.write("folder/contours", study.rtstruct);
    Study second(square_set(30, 4));
    study.disk.write("folder/more", second.rtstruct);
    EXPECT_EQ(code_of(study.choose()), "E-DCM-029");
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

TEST(DicomChoice, RS22_RS34_another_frame_of_reference) {
    Study study(square_set(30, 5));
    auto moved = ct_series(5);
    for (auto& file : moved) file.set(tags::frame_of_reference, "UI", "7.7.7");
    Reading reading(moved);
    reading.disk.write("folder/contours", study.rtstruct);
    reading.scan();
    EXPECT_EQ(code_of(choose_dicom(*reading.folder, "", reading.context)), "E-DCM-032");
}

TEST(DicomChoice, RS23_another_patient) {
    Study study(square_set(30, 5));
    auto others = ct_series(5);
    for (auto& file : others) file.set(tags::patient_id, "LO", "another");
    Reading reading(others);
    reading.disk.write("folder/contours", study.rtstruct);
    reading.scan();
    EXPECT_EQ(code_of(choose_dicom(*reading.folder, "", reading.context)), "E-DCM-033");
}

TEST(DicomChoice, D01_nothing_usable) {
    Reading reading;
    reading.disk.write("folder/notes.txt", "notes");
    reading.scan();
    EXPECT_EQ(code_of(choose_dicom(*reading.folder, "", reading.context)), "E-DCM-031");
}

TEST(DicomChoice, RS10_RS31_planes_and_places_against_the_images) {
    const auto warnings_of = [](const ContourSet& set) {
        Study study(set);
        study.disk.write("folder/contours", study.rtstruct);
        const auto choice = study.choose();
        EXPECT_TRUE(choice.ok());
        const auto raw = read_contours(study.disk.path("folder/contours"), {}, study.context);
        EXPECT_TRUE(raw.ok());
        check_against_images(raw.value(), *study.folder, choice.value().images, study.context);
        return study.warnings();
    };
    EXPECT_EQ(warnings_of(square_set(30, 5)), "");
    EXPECT_EQ(warnings_of(square_set(30.01, 5)), "");
    EXPECT_NE(warnings_of(square_set(31.5, 4)).find("W-DCM-019"), std::string::npos);
    EXPECT_NE(warnings_of(square_set(30, 5, 500)).find("W-DCM-020"), std::string::npos);
    EXPECT_NE(warnings_of(square_set(300, 5)).find("W-DCM-020"), std::string::npos);
}

}  // namespace
}  // namespace anatomesh
