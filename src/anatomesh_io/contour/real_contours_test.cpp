// Real structure sets and contour lists. The counts are those that pydicom and VTK find.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/contour/write_contours.h"

namespace anatomesh::real_contours_test {
namespace {

using namespace contour_test;

struct RealFile {
    const char* path;
    std::size_t structures, contours, points;
    std::vector<std::string> warnings;
};

const RealFile files[] = {
    {"abdomen_rtstruct/Pancreas-CT-CB_001/mask/1-1.dcm", 5, 296, 145'659, {}},
    {"thigh_mr/STS_001/MR_T1/mask/1-1.dcm", 2, 52, 48'174, {}},
    {"breast_ct_rtstruct/rtss.dcm", 9, 441, 88'158, {"W-CIO-003"}},
    {"sarcoma_ct_mr/STS_001/CT/mask/RS.dcm", 1, 32, 21'029, {}},
    {"sarcoma_ct_mr/STS_027/MR_T1/mask/RS.dcm", 1, 62, 52'272, {}},
    {"eclipse_contours/EclipseEnt_Structures.seg", 16, 423, 75'860, {"W-CIO-001"}},
    {"eclipse_contours/EclipseProstate_Structures.seg", 6, 210, 55'720, {"W-CIO-001"}},
    {"contours/abdomen_mr_20x3mm_spleen_liver_kidneys.csl", 5, 93, 7'570, {"W-CIO-001"}},
    {"contours/fetal_brain_mr_3orient_aligned.csl", 1, 52, 10'898, {"W-CIO-001"}},
    {"contours/pelvis_ct_labels_3mm.csl", 11, 432, 29'156, {"W-CIO-001"}},
    {"contours/heart_cmr_lv_epi_patient_1.csl", 1, 19, 2'635, {"W-CIO-001"}},
};

class RealContours : public testing::TestWithParam<RealFile> {};

TEST_P(RealContours, counts_are_those_of_other_readers) {
    const char* named = std::getenv("ANATOMESH_DATA");
    const std::filesystem::path data = named ? named : ANATOMESH_SOURCE_DIR "/../shared/data";
    if (!std::filesystem::exists(data / GetParam().path))
        GTEST_SKIP() << "set ANATOMESH_DATA to the folder of real data";
    RunContext context;
    const auto result = read_contours((data / GetParam().path).string(), {}, context);
    ASSERT_TRUE(result.ok()) << to_line(result.error());
    const RawContours& raw = result.value();
    EXPECT_EQ(raw.structures.size(), GetParam().structures);
    EXPECT_EQ(raw.contours.size(), GetParam().contours);
    EXPECT_EQ(raw.points.size(), GetParam().points);
    EXPECT_EQ(codes(context), GetParam().warnings);
    for (const RawContour& contour : raw.contours) ASSERT_EQ(contour.kind, ContourKind::closed_planar);

    // What has planes goes through every format and comes back to the last bit.
    if (raw.planes.empty()) return;
    const ContourSet set = set_of(raw);
    for (const char* name : {"one.json", "one.vtp", "one.csl"}) {
        Folder folder;
        ASSERT_TRUE(write_contours(set, folder.file(name), context).ok());
        const auto again = read_contours(folder.file(name), {}, context);
        ASSERT_TRUE(again.ok()) << to_line(again.error());
        EXPECT_EQ(again.value().points, raw.points) << name;
        const ContourFormat format = contour_format_of(name).value();
        EXPECT_EQ(format_contours(set_of(again.value()), format, context),
                  format_contours(set, format, context))
            << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Files, RealContours, testing::ValuesIn(files));

}  // namespace
}  // namespace anatomesh::real_contours_test
