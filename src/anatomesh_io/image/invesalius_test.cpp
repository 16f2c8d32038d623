#include <cstdlib>

#include "anatomesh_io/image/image_fixtures.h"
#include "anatomesh_io/image/invesalius_fixtures.h"

namespace anatomesh::invesalius_test {
namespace {

using namespace fixtures;

const std::string data = Nifti().default_data();

TEST(InVesalius, rows_run_to_anterior) {
    for (const std::string& bytes : {deflated(project(plist(), data)), project(plist(), data)}) {
        const Outcome outcome = read_bytes(bytes);
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        EXPECT_EQ(outcome.loaded.kind, FileKind::invesalius);
        EXPECT_EQ(outcome.loaded.image.geometry.size, (std::array<std::uint32_t, 3>{3, 4, 5}));
        expect_position(outcome.loaded, 2, 3, 4, {1.5, -1.5, 8});
        for (int n = 0; n < 60; ++n) EXPECT_EQ(outcome.loaded.image.voxels[n], n % 7);
    }
}

TEST(InVesalius, N03_claims_more_voxels_than_it_has) {
    EXPECT_EQ(read_bytes(project(plist("int16", "1000 1000 1000"), data)).code, "E-IMG-005");
    EXPECT_EQ(read_bytes(project(plist("int16", "900000000 900000000 900000000"), data)).code, "E-IMG-004");
    EXPECT_EQ(read_bytes(project(plist("int16", "5 4 3"), data.substr(1))).code, "E-IMG-005");
    for (const char* shape : {"5 4", "5 4 3 1", "0 4 3", "-5 4 3", "5.5 4 3", "x 4 3", "1e300 4 3"})
        EXPECT_EQ(read_bytes(project(plist("int16", shape), data)).code, "E-INV-006") << shape;
    for (const char* spacing : {"0 1 1", "nan 1 1", "1 1", "-1 1 1"})
        EXPECT_EQ(read_bytes(project(plist("int16", "5 4 3", spacing), data)).code, "E-INV-006") << spacing;
    EXPECT_EQ(read_bytes(project(plist("object"), data)).code, "E-INV-007");
}

TEST(InVesalius, N11_damaged_archives) {
    const std::string good = project(plist(), data);
    const std::string packed = deflated(good);
    for (std::size_t size = 20; size < packed.size(); size += 7)
        EXPECT_FALSE(read_bytes(packed.substr(0, size)).ok()) << size;
    EXPECT_EQ(read_bytes(tar_entry("main.plist", "")).code, "E-INV-004");
    EXPECT_EQ(read_bytes(tar_entry("other", "x")).code, "E-INV-005");
    EXPECT_EQ(read_bytes(tar_entry("main.plist", plist())).code, "E-INV-005");
    EXPECT_EQ(read_bytes(tar_entry("a/main.plist", plist()) + tar_entry("b/main.plist", plist())).code,
              "E-INV-005");
    EXPECT_EQ(read_bytes(tar_entry("main.plist", plist(), 077777777777)).code, "E-INV-002");
    std::string wrong_sum = good;
    wrong_sum[0] = 'x';
    EXPECT_EQ(read_bytes(wrong_sum).code, "E-INV-001");
    EXPECT_EQ(read_bytes(good.substr(0, good.size() - 1024 - 512)).code, "E-INV-002");
}

TEST(InVesalius, N11_damaged_property_lists) {
    const auto read_list = [](const std::string& list) { return read_bytes(project(list, data)).code; };
    const std::string good = plist();
    for (std::size_t size = 0; size + 15 < good.size(); ++size)
        EXPECT_FALSE(read_bytes(project(good.substr(0, size), data)).ok()) << size;
    std::string deep = "<plist>";
    for (int i = 0; i < 100000; ++i) deep += "<dict><key>k</key>";
    EXPECT_EQ(read_list(deep), "E-INV-004");
    EXPECT_EQ(read_list("<plist><dict></array></plist>"), "E-INV-004");
    EXPECT_EQ(read_list("<plist><string>x</string></plist>"), "E-INV-004");
    EXPECT_EQ(read_list("<plist><dict></></dict></plist>"), "E-INV-004");
    EXPECT_EQ(read_list("<plist><dict><key>a</key><string>x</integer></dict></plist>"), "E-INV-004");
}

TEST(InVesalius, real_skull) {
    const char* folder = std::getenv("ANATOMESH_DATA");
    std::string path =
        (folder ? std::string(folder) : ANATOMESH_SOURCE_DIR "/../shared/data") + "/skull_ct/Cranium.inv3";
    if (!std::filesystem::exists(path)) path = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "Cranium.inv3 (Debian package invesalius-examples) is not here";
    const Outcome outcome = read(path);
    ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
    EXPECT_EQ(outcome.loaded.image.geometry.size, (std::array<std::uint32_t, 3>{256, 256, 108}));
    EXPECT_EQ(outcome.loaded.facts.low, -1024);
    EXPECT_FALSE(looks_like_label_map(outcome.loaded.facts));
    std::size_t bone = 0;
    for (const float value : outcome.loaded.image.voxels) bone += value >= 226;
    EXPECT_NEAR(static_cast<double>(bone), 0, 7077888 * 0.2);
    EXPECT_GT(bone, 200000U);
    expect_position(outcome.loaded, 100, 100, 100, {95.70312, -95.70312, 150});
}

}  // namespace
}  // namespace anatomesh::invesalius_test
