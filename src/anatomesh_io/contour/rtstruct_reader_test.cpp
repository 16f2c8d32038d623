#include "anatomesh_io/contour/rtstruct_reader.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <sstream>

#include "anatomesh/geom/box.h"
#include "anatomesh_io/contour/contour_test_support.h"
#include "anatomesh_io/contour/read_contours.h"

namespace anatomesh::rtstruct_reader_test {
namespace {

using namespace contour_test;

struct TestContour {
    std::string data = R"(0\0\5\10\0\5\0\10\5)";
    std::string type = "CLOSED_PLANAR";
    std::optional<std::string> count = {};  // as the data has them when not given
};

struct TestRoi {
    int number = 1;
    std::string name = "GTV";
    std::vector<TestContour> contours = {TestContour{}};
    std::string color = R"(255\0\10)";
    std::optional<int> referenced = {};  // another number in ROIContourSequence
    std::string frame = {};              // of reference
};

void put(DcmItem& item, const DcmTagKey& tag, const std::string& text) {
    ASSERT_TRUE(item.putAndInsertOFStringArray(tag, OFString(text.c_str(), text.size())).good())
        << tag.toString();
}

DcmItem& new_item(DcmItem& parent, const DcmTagKey& sequence) {
    DcmItem* item = nullptr;
    EXPECT_TRUE(parent.findOrCreateSequenceItem(sequence, item, -2).good());
    return *item;
}

void add_roi(DcmItem& data, const TestRoi& roi) {
    DcmItem& declared = new_item(data, DCM_StructureSetROISequence);
    put(declared, DCM_ROINumber, std::to_string(roi.number));
    put(declared, DCM_ROIName, roi.name);
    if (!roi.frame.empty()) put(declared, DCM_ReferencedFrameOfReferenceUID, roi.frame);
    DcmItem& drawn = new_item(data, DCM_ROIContourSequence);
    put(drawn, DCM_ReferencedROINumber, std::to_string(roi.referenced.value_or(roi.number)));
    put(drawn, DCM_ROIDisplayColor, roi.color);
    for (const TestContour& contour : roi.contours) {
        DcmItem& item = new_item(drawn, DCM_ContourSequence);
        put(item, DCM_ContourGeometricType, contour.type);
        const auto points = (std::count(contour.data.begin(), contour.data.end(), '\\') + 1) / 3;
        put(item, DCM_NumberOfContourPoints, contour.count.value_or(std::to_string(points)));
        put(item, DCM_ContourData, contour.data);
    }
}

struct TestFile {
    std::vector<TestRoi> rois = {};
    std::string sop_class = UID_RTStructureSetStorage;
    std::string character_set = "ISO_IR 192";
    E_TransferSyntax syntax = EXS_LittleEndianExplicit;
    E_EncodingType encoding = EET_UndefinedLength;
};

std::string bytes_of(const TestFile& test) {
    DcmFileFormat file;
    DcmDataset& data = *file.getDataset();
    put(data, DCM_SpecificCharacterSet, test.character_set);
    put(data, DCM_SOPClassUID, test.sop_class);
    put(data, DCM_SOPInstanceUID, "1.2.3.4");
    put(data, DCM_Modality, "RTSTRUCT");
    for (const TestRoi& roi : test.rois) add_roi(data, roi);
    Folder folder;
    const std::string path = folder.file("rs.dcm");
    EXPECT_TRUE(file.saveFile(path.c_str(), test.syntax, test.encoding).good());
    std::ifstream stream(path, std::ios::binary);
    std::stringstream content;
    content << stream.rdbuf();
    return content.str();
}

std::string bytes_of_rois(const std::vector<TestRoi>& rois) {
    return bytes_of({.rois = rois});
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(std::min(at, text.size()), what.size(), with);
}

Result<RawContours> read(const std::string& bytes, RunContext& context, const ContourLimits& limits = {}) {
    return read_with(read_rtstruct, bytes, context, FileFrame::unknown, limits);
}

RawContours read_whole(const std::string& bytes, const std::vector<std::string>& warnings = {}) {
    RunContext context;
    auto result = read(bytes, context);
    EXPECT_TRUE(result.ok()) << to_line(result.error());
    EXPECT_EQ(codes(context), warnings);
    return result.ok() ? std::move(result).value() : RawContours{};
}

testing::AssertionResult refused(const std::vector<TestRoi>& rois, const char* code, const char* text = "") {
    RunContext context;
    return fails(read(bytes_of_rois(rois), context), code, text);
}

// A square of this side on each of nine slices.
std::string squares(double side, double spacing) {
    TestRoi roi;
    roi.contours.clear();
    for (int k = 0; k < 9; ++k) {
        const std::string a = std::to_string(side), z = "\\" + std::to_string(k * spacing);
        roi.contours.push_back({.data = "0\\0" + z + "\\" + a + "\\0" + z + "\\" + a + "\\" + a + z});
    }
    return bytes_of_rois({roi});
}

TEST(RtStruct, RS30_contours_in_centimetres_are_asked_about) {
    read_whole(squares(200, 3));
    read_whole(squares(20, 0.3), {"W-RTS-006"});
    read_whole(squares(0.5, 0.1), {"W-RTS-006"});
    read_whole(squares(20, 0.488));  // a small one beside thin slices
    read_whole(squares(3, 0.6));     // a small organ
    read_whole(squares(120, 0.4));   // a detailed one
}

// Slices that no scanner takes: whoever wrote them did not mean mm.
TEST(RtStruct, RS30_contours_in_metres_are_refused_unless_their_unit_is_given) {
    for (const double mm : {1.0, 2.5, 3.0, 5.0}) {
        for (const double size : {8.0, 40.0, 180.0}) {
            const std::string bytes = squares(size / 1000, mm / 1000);
            RunContext context;
            EXPECT_TRUE(fails(read(bytes, context), "E-RTS-011", "mm apart"));
            Folder folder;
            const std::string path = folder.file("metres.dcm");
            std::ofstream(path, std::ios::binary) << bytes;
            for (const double unit : {1.0, 10.0, 1000.0}) {
                ReadContoursOptions options;
                options.unit_mm = unit;
                RunContext quiet;
                const auto raw = read_contours(path, options, quiet);
                ASSERT_TRUE(raw.ok()) << to_line(raw.error());
                EXPECT_TRUE(codes(quiet).empty());
                Box3 box;
                for (const Vec3& point : raw.value().points) box.extend(point);
                EXPECT_NEAR(box.high.z - box.low.z, 8 * mm * unit / 1000, 1e-5 * unit) << unit;
            }
        }
    }
}

TEST(RtStruct, RS22_contours_of_several_frames_of_reference_are_told_apart) {
    const auto spaces = [](const std::vector<std::string>& frames) {
        std::vector<TestRoi> rois;
        for (const std::string& frame : frames) {
            rois.push_back({});
            rois.back().number = static_cast<int>(rois.size());
            rois.back().name = "ROI " + std::to_string(rois.size());
            rois.back().frame = frame;
        }
        const RawContours raw = read_whole(bytes_of_rois(rois));
        std::vector<std::uint32_t> found;
        for (const RawContour& contour : raw.contours) found.push_back(contour.space);
        return found;
    };
    EXPECT_EQ(spaces({"1.2.3", "1.2.3"}), (std::vector<std::uint32_t>{1, 1}));
    EXPECT_EQ(spaces({"1.2.3", "1.2.4", "1.2.3"}), (std::vector<std::uint32_t>{1, 2, 1}));
    EXPECT_EQ(spaces({"", "1.2.3"}), (std::vector<std::uint32_t>{0, 1}));
    EXPECT_EQ(spaces({"", ""}), (std::vector<std::uint32_t>{0, 0}));
}

TEST(RtStruct, reads_the_same_in_every_encoding) {
    const std::vector<TestRoi> rois = {
        {.number = 5, .name = "liver", .contours = {{}, {.data = R"( 1.5 \-2e1\+3\4\5\6)"}}},
        {.number = 2, .name = "spleen"}};
    for (const E_TransferSyntax syntax : {EXS_LittleEndianImplicit, EXS_LittleEndianExplicit,
                                          EXS_BigEndianExplicit, EXS_DeflatedLittleEndianExplicit}) {
        for (const E_EncodingType encoding : {EET_UndefinedLength, EET_ExplicitLength}) {
            const RawContours raw =
                read_whole(bytes_of({.rois = rois, .syntax = syntax, .encoding = encoding}));
            ASSERT_EQ(raw.structures.size(), 2u);
            EXPECT_EQ(raw.structures[0].number, 2);
            EXPECT_EQ(raw.structures[1].number, 5);
            EXPECT_EQ(raw.structures[1].name, "liver");
            EXPECT_EQ(raw.structures[1].color, (std::array<std::uint8_t, 3>{255, 0, 10}));
            ASSERT_EQ(raw.contours.size(), 3u);
            EXPECT_EQ(raw.contours[0].structure, 1u);
            EXPECT_EQ(raw.contours[1].name, "ROI 5, contour 1");
            EXPECT_EQ(raw.contours[1].point_count, 2u);
            EXPECT_EQ(raw.points[3], (Vec3{1.5, -20, 3}));
            EXPECT_EQ(raw.contours[2].structure, 0u);
            EXPECT_EQ(raw.contours[2].plane, -1);
            EXPECT_EQ(raw.frame, Frame::lps);
            EXPECT_EQ(raw.pixel_mm, 0);
            EXPECT_TRUE(raw.planes.empty());
        }
    }
}

TEST(RtStruct, RS01_no_contours_lists_the_names) {
    EXPECT_TRUE(refused({}, "E-CIO-006", "no structures"));
    EXPECT_TRUE(refused(
        {{.number = 1, .name = "liver", .contours = {}}, {.number = 2, .name = "aorta", .contours = {}}},
        "E-CIO-006", "liver, aorta"));
    RunContext context;
    DcmFileFormat file;
    put(*file.getDataset(), DCM_SOPClassUID, UID_CTImageStorage);
    const std::string image = bytes_of({.rois = {}, .sop_class = UID_CTImageStorage});
    EXPECT_TRUE(fails(read(image, context), "E-RTS-002"));
}

TEST(RtStruct, RS02_roi_without_contours_is_skipped_by_name) {
    RunContext context;
    const auto raw =
        read(bytes_of_rois({{.number = 1, .name = "liver", .contours = {}}, {.number = 2, .name = "aorta"}}),
             context);
    ASSERT_TRUE(raw.ok());
    ASSERT_EQ(codes(context), std::vector<std::string>{"W-CIO-003"});
    EXPECT_EQ(context.warnings[0].place.structure, "liver");
    ASSERT_EQ(raw.value().structures.size(), 1u);
    EXPECT_EQ(raw.value().structures[0].name, "aorta");
}

TEST(RtStruct, RS03_numbers_twice_or_dangling) {
    EXPECT_TRUE(
        refused({{.number = 3, .name = "a"}, {.number = 3, .name = "b"}}, "E-RTS-004", "structure b"));
    EXPECT_TRUE(refused({{.number = 3, .name = "a"}, {.number = 4, .name = "b", .referenced = 3}},
                        "E-RTS-004", "structure a"));
    const RawContours raw =
        read_whole(bytes_of_rois({{.number = 3, .name = "a"}, {.number = 4, .name = "b", .referenced = 9}}),
                   {"W-RTS-001", "W-CIO-003"});
    ASSERT_EQ(raw.structures.size(), 2u);
    EXPECT_EQ(raw.structures[1].number, 9);
    EXPECT_EQ(raw.structures[1].name, "");
}

TEST(RtStruct, RS04_equal_names_are_both_kept) {
    for (const char* name : {"Liver", "liver", "LI VER", "Liver "}) {
        const RawContours raw = read_whole(
            bytes_of_rois({{.number = 1, .name = "Liver"}, {.number = 2, .name = name}}), {"W-CIO-004"});
        EXPECT_EQ(raw.structures.size(), 2u);
    }
}

TEST(RtStruct, RS05_values_not_three_a_point) {
    const auto with = [](const char* data) {
        return std::vector<TestRoi>{{.number = 7, .contours = {{}, {.data = data}}}};
    };
    EXPECT_TRUE(
        refused(with(R"(0\0\5\10\0\5\0\10)"), "E-RTS-006", "structure GTV, contour ROI 7, contour 1"));
    EXPECT_TRUE(refused(with(""), "E-RTS-006", "missing or empty"));
    EXPECT_TRUE(refused(with("   "), "E-RTS-006"));
    EXPECT_TRUE(refused(with(R"(0\0\5\)"), "E-RTS-006", "4 values"));
    EXPECT_TRUE(refused(with(R"(0\0\5\10\0\)"), "E-RTS-007", "contour 1, point 1"));
    EXPECT_TRUE(refused(with(R"(0\\5\10\0\5)"), "E-RTS-007", "contour 1, point 0"));
}

TEST(RtStruct, RS06_stated_count_differs_and_the_data_wins) {
    const RawContours raw = read_whole(bytes_of_rois({{.contours = {{.count = "4"}, {.count = "x"}}}}),
                                       {"W-RTS-002", "W-RTS-002"});
    EXPECT_EQ(raw.contours[0].point_count, 3u);
    EXPECT_EQ(raw.contours[1].point_count, 3u);
}

TEST(RtStruct, RS07_D19_values_that_are_no_coordinates) {
    std::string many;
    for (int i = 0; i < 299'999; ++i) many += R"(1\)";
    for (const char* bad :
         {"NaN", "Inf", "-inf", "1.2.3", "1,5", "1e400", "0x10", "1 2", "--1", "+-1", "1e"}) {
        const std::string data = std::string(R"(0\0\5\10\)") + bad + R"(\5\0\10\5)";
        EXPECT_TRUE(refused({{.contours = {{}, {.data = data}}}}, "E-RTS-007", "ROI 1, contour 1, point 1"))
            << bad;
    }
    for (const char* bad : {"1e30", "-10000001"}) {
        const std::string data = std::string(R"(0\0\5\10\)") + bad + R"(\5\0\10\5)";
        EXPECT_TRUE(refused({{.contours = {{.data = data}}}}, "E-CIO-005", "ROI 1, contour 0, point 1"))
            << bad;
    }
    std::string in_the_middle = many + "1";
    in_the_middle[300'000] = 'x';
    EXPECT_TRUE(refused({{.contours = {{.data = in_the_middle}}}}, "E-RTS-007", "point 50000"));
    const RawContours raw =
        read_whole(bytes_of_rois({{.contours = {{.data = "0\\0\\ 1.5 \\ +1E1\\-.5\\5."}}}}));
    EXPECT_EQ(raw.points[0], (Vec3{0, 0, 1.5}));
    EXPECT_EQ(raw.points[1], (Vec3{10, -0.5, 5}));
}

TEST(RtStruct, RS08_types_are_kept_and_nothing_is_closed) {
    const RawContours raw =
        read_whole(bytes_of_rois({{.contours = {{.data = R"(1\2\3)", .type = "POINT"},
                                                {.data = R"(1\2\3\4\5\6)", .type = "POINT"},
                                                {.type = "OPEN_PLANAR"},
                                                {.type = "OPEN_NONPLANAR"},
                                                {.data = R"(1\2\3)"},
                                                {.data = R"(1\2\3\4\5\6)"}}}}));
    using enum ContourKind;
    const ContourKind kinds[] = {point, point, open, open, closed_planar, closed_planar};
    const std::uint32_t counts[] = {1, 2, 3, 3, 1, 2};
    ASSERT_EQ(raw.contours.size(), 6u);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(raw.contours[i].kind, kinds[i]) << i;
        EXPECT_EQ(raw.contours[i].point_count, counts[i]) << i;
    }
    EXPECT_TRUE(refused({{.contours = {{}, {.type = "CLOSED"}}}}, "E-RTS-008", "ROI 1, contour 1"));
    read_whole(bytes_of_rois({{.contours = {{.type = ""}}}}), {"W-RTS-003"});
}

TEST(RtStruct, RS09_points_off_their_plane_are_read_as_they_are) {
    const RawContours raw =
        read_whole(bytes_of_rois({{.contours = {{.data = R"(0\0\5\10\0\5.01\0\10\5\0\5\10)"}}}}));
    EXPECT_EQ(raw.points[1].z, 5.01);
    EXPECT_EQ(raw.points[3].z, 10);
}

TEST(RtStruct, RS13_RS14_RS16_RS17_direction_nesting_keyholes_and_overlaps_are_left_as_they_are) {
    const std::string outer = R"(0\0\5\30\0\5\30\30\5\0\30\5)", inner = R"(9\9\5\9\20\5\20\20\5\20\9\5)";
    const std::string keyhole = R"(0\0\5\9\9\5\9\20\5\20\20\5\9\9\5\0\0\5\0\30\5\30\30\5\30\0\5)";
    const std::string overlap = R"(20\20\5\50\20\5\50\50\5)";
    const RawContours raw = read_whole(bytes_of_rois(
        {{.contours = {{.data = outer}, {.data = inner}, {.data = keyhole}, {.data = overlap}}}}));
    const std::uint32_t counts[] = {4, 4, 9, 3};
    ASSERT_EQ(raw.contours.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(raw.contours[i].point_count, counts[i]);
    EXPECT_EQ(raw.points[5], (Vec3{9, 20, 5}));
    EXPECT_EQ(raw.points[8 + 4], (Vec3{9, 9, 5}));
}

TEST(RtStruct, RS15_exclusive_or_is_told_from_closed) {
    for (int depth = 1; depth <= 5; ++depth) {
        std::vector<TestContour> contours;
        for (int i = 0; i < depth; ++i) contours.push_back({.type = "CLOSEDPLANAR_XOR"});
        const RawContours raw = read_whole(bytes_of_rois({{.contours = contours}}));
        ASSERT_EQ(raw.contours.size(), static_cast<std::size_t>(depth));
        for (const RawContour& contour : raw.contours)
            EXPECT_EQ(contour.kind, ContourKind::closed_planar_xor);
    }
}

TEST(RtStruct, RS27_data_beyond_64_KiB) {
    std::string data;
    for (int i = 0; i < 20'000; ++i)
        data += (i ? R"(\)" : "") + std::to_string(i) + ".25\\" + std::to_string(-i) + "\\5";
    ASSERT_GT(data.size(), std::size_t{1} << 16);
    const std::vector<TestRoi> rois = {{.number = 1, .contours = {{}, {.data = data}, {}}}};
    const std::string implicit = bytes_of({.rois = rois, .syntax = EXS_LittleEndianImplicit});
    const std::string as_un = bytes_of_rois(rois);
    const std::string head("\x06\x30\x50\x00", 4), un(head + std::string("UN\0\0", 4));
    ASSERT_NE(as_un.find(un), std::string::npos);
    const std::string as_ob = replaced(as_un, un, head + std::string("OB\0\0", 4));
    const std::string as_ut = replaced(as_un, un, head + std::string("UT\0\0", 4));
    for (const std::string& bytes : {implicit, as_un, as_ob, as_ut}) {
        const RawContours raw = read_whole(bytes);
        ASSERT_EQ(raw.contours.size(), 3u);
        EXPECT_EQ(raw.contours[1].point_count, 20'000u);
        EXPECT_EQ(raw.points[3 + 19'999], (Vec3{19'999.25, -19'999, 5}));
        EXPECT_EQ(raw.contours[2].point_count, 3u);
    }
}

TEST(RtStruct, RS28_hostile_names_are_text) {
    for (const std::string& name :
         {std::string("../../x"), std::string("CON"), std::string("a/b"), std::string(),
          std::string(10'000, 'n'), std::string("\xF0\x9F\xAB\x80"),
          std::string("a\xE2\x80\x8F"
                      "b"),
          std::string("a\nb\x1B[31m"), std::string("%s%n"), std::string("<b>&\"'")}) {
        RunContext context;
        const auto raw = read(bytes_of_rois({{.number = 1, .name = name}}), context);
        ASSERT_TRUE(raw.ok()) << to_line(raw.error());
        EXPECT_EQ(raw.value().structures[0].name, name);
    }
}

TEST(RtStruct, D21_names_in_other_character_sets) {
    const auto name_in = [](const char* set, const char* name, const std::vector<std::string>& warnings) {
        return read_whole(bytes_of({.rois = {{.name = name}}, .character_set = set}), warnings)
            .structures[0]
            .name;
    };
    EXPECT_EQ(name_in("ISO_IR 100", "L\xF6we", {}), "L\xC3\xB6we");
    EXPECT_EQ(name_in("ISO_IR 192", "L\xC3\xB6we", {}), "L\xC3\xB6we");
    EXPECT_EQ(name_in("no such set", "L\xF6we", {"W-RTS-004"}), "L\xEF\xBF\xBDwe");
}

TEST(RtStruct, colour_that_is_none) {
    for (const char* color : {R"(1\2)", R"(1\2\256)", R"(1\2\3\4)", "red"})
        EXPECT_EQ(read_whole(bytes_of_rois({{.color = color}}), {"W-RTS-005"}).structures[0].color,
                  Structure{}.color);
    EXPECT_EQ(read_whole(bytes_of_rois({{.color = ""}})).structures[0].color, Structure{}.color);
}

TEST(RtStruct, RS26_limits_before_memory) {
    std::vector<TestRoi> rois = {};
    for (int i = 0; i < 2'000; ++i) rois.push_back({.number = i, .name = std::to_string(i)});
    const std::string many = bytes_of_rois(rois);
    EXPECT_EQ(read_whole(many).structures.size(), 2'000u);
    const std::string two = bytes_of_rois({{.contours = {{}, {.data = R"(1\2\3\4\5\6\7\8\9\10\11\12)"}}}});
    RunContext context;
    EXPECT_TRUE(fails(read(many, context, {.structures = 1'999}), "E-CIO-001"));
    EXPECT_TRUE(fails(read(many, context, {.contours = 1'999}), "E-CIO-002"));
    EXPECT_TRUE(fails(read(two, context, {.points_per_contour = 3}), "E-CIO-003", "contour 1"));
    EXPECT_TRUE(fails(read(two, context, {.points = 6}), "E-CIO-004", "contour 1"));
    EXPECT_TRUE(fails(read(two, context, {.coordinate_mm = 11}), "E-CIO-005", "contour 1, point 3"));
    EXPECT_TRUE(
        read(two, context, {.structures = 1, .contours = 2, .points_per_contour = 4, .points = 7}).ok());
}

TEST(RtStruct, D03_truncated_anywhere) {
    for (const E_TransferSyntax syntax :
         {EXS_LittleEndianImplicit, EXS_LittleEndianExplicit, EXS_DeflatedLittleEndianExplicit}) {
        const std::string whole =
            bytes_of({.rois = {{.number = 1}, {.number = 2, .name = "b"}}, .syntax = syntax});
        read_whole(whole);
        for (std::size_t size = 0; size < whole.size(); ++size) {
            RunContext context;
            ASSERT_FALSE(read(whole.substr(0, size), context).ok()) << size;
        }
    }
}

TEST(RtStruct, D22_mutations_never_crash) {
    std::mt19937 random(7);
    for (const E_TransferSyntax syntax :
         {EXS_LittleEndianImplicit, EXS_LittleEndianExplicit, EXS_BigEndianExplicit}) {
        const std::string whole =
            bytes_of({.rois = {{.number = 1}, {.number = 2, .name = "b"}}, .syntax = syntax});
        for (int i = 0; i < 2'000; ++i) {
            std::string bytes = whole;
            for (unsigned k = 0, n = 1 + random() % 16; k < n; ++k) {
                const std::size_t at = 132 + random() % (bytes.size() - 132);
                switch (random() % 4) {
                    case 0:
                        bytes[at] = static_cast<char>(random());
                        break;
                    case 1:
                        bytes[at] = "\0\xFF\\UNSQOB"[random() % 9];
                        break;
                    case 2:
                        bytes.erase(at, 1 + random() % 8);
                        break;
                    default:
                        bytes.insert(at,
                                     std::string("\xFE\xFF\x00\xE0\xFF\xFF\xFF\xFF", 8).substr(random() % 8));
                }
                if (bytes.size() < 200) break;
            }
            RunContext context;
            const auto result = read(bytes, context);
            if (!result.ok()) {
                EXPECT_FALSE(result.error().code.empty());
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::rtstruct_reader_test
