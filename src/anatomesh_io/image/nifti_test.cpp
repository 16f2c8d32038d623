#include <cmath>
#include <limits>

#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::nifti_test {
namespace {

using namespace fixtures;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Nifti, good_image_reads_in_both_versions_and_byte_orders) {
    for (const int version : {1, 2})
        for (const std::endian order : {std::endian::little, std::endian::big}) {
            Nifti nifti;
            nifti.version = version;
            nifti.order = order;
            const Outcome outcome = read_bytes(nifti.bytes());
            ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
            EXPECT_TRUE(outcome.warnings.empty());
            ASSERT_EQ(outcome.loaded.image.voxels.size(), 60U);
            for (int n = 0; n < 60; ++n) EXPECT_EQ(outcome.loaded.image.voxels[n], n % 7);
            // RAS (10, 20, 30) is LPS (-10, -20, 30).
            expect_position(outcome.loaded, 0, 0, 0, {-10, -20, 30});
            expect_position(outcome.loaded, 2, 3, 4, {-11.5, -21.5, 38});
            EXPECT_EQ(outcome.loaded.inputs.size(), 1U);
            EXPECT_EQ(outcome.loaded.inputs[0].sha256.size(), 64U);
        }
}

TEST(Nifti, N01_short_files_and_wrong_magic) {
    const std::string good = Nifti().bytes();
    EXPECT_EQ(read_bytes("").code, "E-IMG-001");
    EXPECT_EQ(read_bytes(good.substr(0, 347)).code, "E-NII-001");
    EXPECT_EQ(read_bytes(good.substr(0, 348)).code, "E-NII-007");
    EXPECT_EQ(read_bytes(good.substr(0, 351)).code, "E-NII-007");
    Nifti nifti;
    nifti.magic = "n+3";
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-003");
    nifti.magic = "N+1";
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-003");
    // NIfTI-2 in the clothes of NIfTI-1, and the other way round.
    nifti.magic = std::string("n+2\0", 4);
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-003");
    nifti.version = 2;
    nifti.magic = std::string("n+1\0\r\n\032\n", 8);
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-003");
    // A swapped header size claims the other byte order for the fields.
    std::string swapped = good;
    put<std::int32_t>(swapped, 0, 348, std::endian::big);
    EXPECT_EQ(read_bytes(swapped).code, "E-NII-004");
    // A size that fits neither, with the magic in place.
    std::string odd = good;
    put<std::int32_t>(odd, 0, 349);
    EXPECT_EQ(read_bytes(odd).code, "E-NII-002");
}

TEST(Nifti, N02_number_of_axes_out_of_range) {
    for (const int version : {1, 2})
        for (const int axes : {-1, 0, 8, 200}) {
            Nifti nifti;
            nifti.version = version;
            nifti.dim[0] = axes;
            EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-004") << axes;
        }
    for (const int size : {0, -1, -32768}) {
        Nifti nifti;
        nifti.dim[2] = size;
        EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-004") << size;
    }
}

TEST(Nifti, N03_claims_more_voxels_than_it_has) {
    forget_peak_memory();
    const std::uint64_t before = memory_now();
    Nifti nifti;
    nifti.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1};
    const std::string bytes = nifti.bytes().substr(0, 377);
    EXPECT_EQ(read_bytes(bytes).code, "E-IMG-005");
    EXPECT_EQ(read_bytes(deflated(bytes)).code, "E-IMG-004");  // its length is not known: the limit speaks
    nifti.dim = {3, 300, 300, 300, 1, 1, 1, 1};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-005");
    EXPECT_EQ(read_bytes(deflated(nifti.bytes())).code, "E-IMG-005");
    nifti.version = 2;
    const std::int64_t huge = std::int64_t{1} << 62;
    nifti.dim = {3, huge, huge, huge, 1, 1, 1, 1};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-003");
    const std::int64_t large = std::int64_t{1} << 31;
    nifti.dim = {3, large, large, large, 1, 1, 1, 1};
    EXPECT_FALSE(read_bytes(nifti.bytes()).ok());
    // 2^32 x 2^32 x ... wraps to a small number in 64 bits.
    nifti.dim = {5, std::int64_t{1} << 22, std::int64_t{1} << 21, std::int64_t{1} << 21, 8, 1, 1, 1};
    EXPECT_FALSE(read_bytes(nifti.bytes()).ok());
    nifti.dim = {7, 3, 4, 5, huge, huge, huge, huge};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-004");
    EXPECT_LE(peak_memory(), before + (std::uint64_t{16} << 20));
}

TEST(Nifti, N04_vox_offset) {
    for (const double offset : {nan, infinity, -1.5, -352.0, 1e30, 353.0, 352.5, 0.0, 348.0}) {
        Nifti nifti;
        nifti.vox_offset = offset;
        EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-007") << offset;
    }
    Nifti nifti;
    nifti.vox_offset = 100000;
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-007");
    nifti.vox_offset = 360;  // leaves 112 bytes for 120
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-005");
}

TEST(Nifti, N05_pixdim_and_qfac) {
    for (const double spacing : {0.0, -1.0, nan, infinity, 1e-30}) {
        Nifti nifti;
        nifti.pixdim[2] = spacing;
        EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-008") << spacing;
    }
    Nifti nifti;
    nifti.qform_code = 1;
    nifti.sform_code = 0;
    nifti.pixdim[0] = 0;
    const Outcome outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome.warned("W-NII-001"));
    expect_position(outcome.loaded, 0, 0, 1, {-10, -20, 32});
    nifti.pixdim[0] = -1;
    expect_position(read_bytes(nifti.bytes()).loaded, 0, 0, 1, {-10, -20, 28});
    nifti.pixdim[0] = 0.5;
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-009");
    nifti.pixdim[0] = nan;
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-009");
}

TEST(Nifti, qform_rotates_as_the_standard_says) {
    Nifti nifti;
    nifti.qform_code = 1;
    nifti.sform_code = 0;
    // A quarter turn about z: i runs to +y, j to -x (RAS).
    nifti.quaternion = {0, 0, std::sqrt(0.5)};
    Outcome outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok());
    expect_position(outcome.loaded, 1, 0, 0, {-10, -20.75, 30}, 1e-5);
    expect_position(outcome.loaded, 0, 1, 0, {-9.5, -20, 30}, 1e-5);
    // A half turn about y (a = 0).
    nifti.quaternion = {0, 1, 0};
    outcome = read_bytes(nifti.bytes());
    expect_position(outcome.loaded, 1, 1, 1, {-9.25, -20.5, 28});
    nifti.quaternion = {0, 1, 0.2};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-011");
    nifti.quaternion = {0, nan, 0};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-011");
}

TEST(Nifti, N06_qform_and_sform_disagree) {
    Nifti nifti;
    nifti.qform_code = 1;
    EXPECT_TRUE(read_bytes(nifti.bytes()).ok());  // they agree
    nifti.qoffset[0] = 10.005;
    EXPECT_TRUE(read_bytes(nifti.bytes()).ok());
    nifti.qoffset[0] = 13;
    const Outcome refused = read_bytes(nifti.bytes());
    EXPECT_EQ(refused.code, "E-NII-012");
    EXPECT_EQ(static_cast<int>(refused.error.kind), 3);
    EXPECT_EQ(refused.error.place.value, "3 mm");
    EXPECT_NE(refused.error.next_step.find("--use qform"), std::string::npos);
    ReadImageOptions options;
    options.nifti_transform = NiftiTransform::qform;
    Outcome chosen = read_bytes(nifti.bytes(), options);
    ASSERT_TRUE(chosen.ok());
    EXPECT_TRUE(chosen.warned("W-NII-004"));
    expect_position(chosen.loaded, 0, 0, 0, {-13, -20, 30});
    options.nifti_transform = NiftiTransform::sform;
    chosen = read_bytes(nifti.bytes(), options);
    ASSERT_TRUE(chosen.ok());
    EXPECT_TRUE(chosen.warned("W-NII-004"));
    expect_position(chosen.loaded, 0, 0, 0, {-10, -20, 30});
    // Mirrored about the middle of a single layer: no voxel moves, and still they disagree.
    Nifti flat;
    flat.dim = {3, 3, 4, 1, 1, 1, 1, 1};
    flat.data = std::string(24, '\1');
    flat.qform_code = 1;
    flat.pixdim[0] = -1;
    EXPECT_EQ(read_bytes(flat.bytes()).code, "E-NII-012");
    // A transform that is asked for and is not there.
    Nifti lone;
    options.nifti_transform = NiftiTransform::qform;
    EXPECT_EQ(read_bytes(lone.bytes(), options).code, "E-NII-015");
}

TEST(Nifti, N06_a_broken_qform_can_be_left_aside) {
    Nifti nifti;
    nifti.qform_code = 1;
    nifti.quaternion = {3, 0, 0};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-011");
    ReadImageOptions options;
    options.nifti_transform = NiftiTransform::sform;
    const Outcome outcome = read_bytes(nifti.bytes(), options);
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome.warned("W-NII-004"));
}

TEST(Nifti, N07_no_orientation) {
    Nifti nifti;
    nifti.sform_code = 0;
    const Outcome refused = read_bytes(nifti.bytes());
    EXPECT_EQ(refused.code, "E-NII-013");
    EXPECT_NE(refused.error.next_step.find("--assume-orientation"), std::string::npos);
    ReadImageOptions options;
    options.assume_orientation = "RAS";
    Outcome outcome = read_bytes(nifti.bytes(), options);
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome.warned("W-NII-005"));
    expect_position(outcome.loaded, 1, 1, 1, {-0.75, -0.5, 2});
    options.assume_orientation = "SPL";
    expect_position(read_bytes(nifti.bytes(), options).loaded, 1, 1, 1, {2, 0.5, 0.75});
    for (const char* wrong : {"RAR", "RA", "LPSS", "ras", "xyz"}) {
        options.assume_orientation = wrong;
        EXPECT_EQ(read_bytes(nifti.bytes(), options).code, "E-IMG-011") << wrong;
    }
    nifti.qform_code = -1;
    EXPECT_EQ(read_bytes(nifti.bytes(), options).code, "E-NII-014");
}

TEST(Nifti, N08_singular_sheared_and_left_handed_sform) {
    Nifti nifti;
    nifti.srow = {0.75, 0.75, 0, 10, 0, 0, 0, 20, 0, 0, 2, 30};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-007");
    nifti.srow = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-007");
    nifti.srow = {nan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-006");
    nifti.srow = {1, 0, 0, 1e30, 0, 1, 0, 0, 0, 0, 1, 0};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-006");
    nifti.srow = {0.75, 0, 0.5, 10, 0, 0.5, 0.25, 20, 0, 0, 2, 30};
    const Outcome sheared = read_bytes(nifti.bytes());
    ASSERT_TRUE(sheared.ok());
    expect_position(sheared.loaded, 1, 2, 4, {-12.75, -22, 38});
    nifti.srow = {-0.75, 0, 0, 10, 0, 0.5, 0, 20, 0, 0, 2, 30};
    const Outcome left_handed = read_bytes(nifti.bytes());
    ASSERT_TRUE(left_handed.ok());
    expect_position(left_handed.loaded, 2, 0, 0, {-8.5, -20, 30});
}

TEST(Nifti, N09_units_are_converted) {
    const Outcome millimetres = read_bytes(Nifti().bytes());
    for (const auto& [units, factor] : {std::pair{1, 1000.0}, std::pair{3, 0.001}})
        for (const bool by_qform : {false, true}) {
            Nifti nifti;
            nifti.units = units | 8;  // time in seconds
            nifti.qform_code = by_qform;
            nifti.sform_code = !by_qform;
            const Outcome outcome = read_bytes(nifti.bytes());
            ASSERT_TRUE(outcome.ok());
            expect_position(outcome.loaded, 2, 1, 3,
                            factor * millimetres.loaded.image.geometry.position(2, 1, 3));
            EXPECT_TRUE(outcome.warnings.empty());
        }
    Nifti nifti;
    nifti.units = 0;
    const Outcome outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome.warned("W-NII-002"));
}

TEST(Nifti, N10_compression_is_seen_by_content) {
    const std::string plain = Nifti().bytes();
    const Outcome named_plain = read_bytes(deflated(plain), {}, "image.nii");
    ASSERT_TRUE(named_plain.ok());
    EXPECT_TRUE(named_plain.warnings.empty());
    const Outcome named_gzip = read_bytes(plain, {}, "image.nii.gz");
    ASSERT_TRUE(named_gzip.ok());
    for (const std::size_t cut : {0, 1, 100, 348, 400}) {
        const std::string members = deflated(plain.substr(0, cut)) + deflated(plain.substr(cut));
        const Outcome outcome = read_bytes(members);
        ASSERT_TRUE(outcome.ok()) << cut << to_line(outcome.error);
        EXPECT_EQ(outcome.loaded.image.voxels, named_gzip.loaded.image.voxels);
    }
    const Outcome trailing = read_bytes(deflated(plain) + "left over");
    ASSERT_TRUE(trailing.ok());
    EXPECT_TRUE(trailing.warned("W-INP-001"));
    const Outcome longer = read_bytes(plain + "left over");
    ASSERT_TRUE(longer.ok());
    EXPECT_TRUE(longer.warned("W-IMG-001"));
}

TEST(Nifti, N11_damaged_gzip_is_never_a_short_image) {
    std::string plain = Nifti().bytes();
    const std::string good = deflated(plain);
    for (std::size_t size = 2; size < good.size(); ++size)
        EXPECT_FALSE(read_bytes(good.substr(0, size)).ok()) << size;
    for (std::size_t back = 1; back <= 8; ++back) {  // the CRC and the length
        std::string wrong = good;
        wrong[wrong.size() - back] ^= 1;
        EXPECT_EQ(read_bytes(wrong).code, "E-INP-011") << back;
    }
    EXPECT_EQ(read_bytes(good.substr(0, good.size() - 3)).code, "E-INP-010");
}

TEST(Nifti, N12_gzip_bomb) {
    // 10 GB of zeros: one member of 64 MiB, 160 times.
    const std::string member = deflated(std::string(std::size_t{64} << 20, '\0'), 31, 1);
    std::string zeros;
    for (int i = 0; i < 160; ++i) zeros += member;
    Nifti honest, lying, large;
    honest.version = 2;
    honest.datatype = 2;
    honest.bitpix = 8;
    honest.dim = {3, 2048, 2048, 2560, 1, 1, 1, 1};
    large = honest;
    large.dim = {3, 1024, 1024, 2048, 1, 1, 1, 1};
    for (const Nifti& nifti : {honest, lying, large}) {
        const std::string start = nifti.header() + std::string(4, '\0');
        const std::string bytes = deflated(start) + zeros;
        forget_peak_memory();
        const std::uint64_t before = memory_now();
        const Outcome outcome = read_bytes(bytes);
        EXPECT_EQ(outcome.code, "E-INP-012");
        EXPECT_EQ(outcome.error.kind, ErrorKind::limit);
        EXPECT_LE(peak_memory(), before + (std::uint64_t{256} << 20) + 4 * bytes.size());
    }
    // A label map that is nearly empty is no bomb, though it shrinks a thousandfold.
    Nifti sparse = honest;
    sparse.dim = {3, 512, 512, 120, 1, 1, 1, 1};
    sparse.data = std::string(std::size_t{512} * 512 * 120, '\0');
    sparse.data[1000] = 1;
    const std::string small = deflated(sparse.bytes(), 31, 1);
    ASSERT_GT(sparse.data.size() / small.size(), 200U);
    EXPECT_TRUE(read_bytes(small).ok());
}

TEST(Nifti, N13_scale) {
    Nifti nifti;
    nifti.slope = 0;
    nifti.intercept = 5;  // has no meaning beside a slope of 0
    Outcome outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels[3], 3);
    EXPECT_TRUE(outcome.warnings.empty());
    nifti.slope = nan;
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-010");
    nifti.slope = infinity;
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-NII-010");
    nifti.slope = 2.5;
    outcome = read_bytes(nifti.bytes());
    ASSERT_TRUE(outcome.ok());
    EXPECT_TRUE(outcome.warned("W-IMG-003"));
    EXPECT_EQ(outcome.loaded.image.voxels[3], 12.5F);
}

TEST(Nifti, N14_volumes_and_voxel_types) {
    Nifti nifti;
    nifti.dim = {4, 3, 4, 5, 2, 1, 1, 1};
    std::vector<std::int16_t> values;
    for (int n = 0; n < 120; ++n) values.push_back(static_cast<std::int16_t>(n));
    nifti.data = values_as_bytes(values);
    const Outcome refused = read_bytes(nifti.bytes());
    EXPECT_EQ(refused.code, "E-IMG-008");
    EXPECT_NE(refused.error.next_step.find("--volume N, 0 to 1"), std::string::npos);
    ReadImageOptions options;
    options.volume = 1;
    Outcome outcome = read_bytes(nifti.bytes(), options);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels.front(), 60);
    EXPECT_EQ(outcome.loaded.image.voxels.back(), 119);
    options.volume = 2;
    EXPECT_EQ(read_bytes(nifti.bytes(), options).code, "E-IMG-009");
    nifti.dim = {5, 3, 4, 5, 1, 2, 1, 1};
    EXPECT_EQ(read_bytes(nifti.bytes()).code, "E-IMG-008");
    nifti.dim = {4, 3, 4, 5, 1, 1, 1, 1};  // one volume is no choice
    EXPECT_TRUE(read_bytes(nifti.bytes()).ok());

    for (const auto& [datatype, bits, name] :
         {std::tuple{128, 24, "RGB24"}, std::tuple{32, 64, "complex64"}, std::tuple{1536, 128, "float128"},
          std::tuple{1, 1, "binary"}, std::tuple{2304, 32, "RGBA32"}, std::tuple{77, 8, "unknown"}}) {
        Nifti other;
        other.datatype = static_cast<std::int16_t>(datatype);
        other.bitpix = static_cast<std::int16_t>(bits);
        const Outcome wrong = read_bytes(other.bytes());
        EXPECT_EQ(wrong.code, "E-NII-005");
        EXPECT_NE(wrong.error.message.find(name), std::string::npos);
    }
    Nifti contradictory;
    contradictory.bitpix = 32;
    EXPECT_EQ(read_bytes(contradictory.bytes()).code, "E-NII-006");
}

template <class T>
void expect_type(int datatype, const char* name) {
    Nifti nifti;
    nifti.datatype = static_cast<std::int16_t>(datatype);
    nifti.bitpix = 8 * sizeof(T);
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        nifti.order = order;
        std::vector<T> values;
        for (int n = 0; n < 60; ++n) values.push_back(static_cast<T>(n == 59 ? 100 : n));
        nifti.data = values_as_bytes(values, order);
        const Outcome outcome = read_bytes(nifti.bytes());
        ASSERT_TRUE(outcome.ok()) << name;
        EXPECT_EQ(outcome.loaded.facts.voxel_type, name);
        EXPECT_EQ(outcome.loaded.image.voxels[42], 42);
        EXPECT_EQ(outcome.loaded.facts.high, 100);
        EXPECT_EQ(outcome.loaded.facts.distinct, 60U);
    }
}

TEST(Nifti, N14_every_type_of_number_is_read) {
    expect_type<std::uint8_t>(2, "uint8");
    expect_type<std::int8_t>(256, "int8");
    expect_type<std::uint16_t>(512, "uint16");
    expect_type<std::int16_t>(4, "int16");
    expect_type<std::uint32_t>(768, "uint32");
    expect_type<std::int32_t>(8, "int32");
    expect_type<std::uint64_t>(1280, "uint64");
    expect_type<std::int64_t>(1024, "int64");
    expect_type<float>(16, "float32");
    expect_type<double>(64, "float64");
}

TEST(Nifti, N15_extensions) {
    const auto with_extension = [](std::int32_t size) {
        Nifti nifti;
        nifti.extensions = std::string("\1\0\0\0", 4);
        put<std::int32_t>(nifti.extensions, 4, size);
        nifti.extensions.resize(4 + 32, 'x');
        return read_bytes(nifti.bytes());
    };
    const Outcome good = with_extension(32);
    ASSERT_TRUE(good.ok());
    EXPECT_TRUE(good.warnings.empty());
    for (const std::int32_t size : {0, -16, 17, 8, 48, std::numeric_limits<std::int32_t>::max(),
                                    std::numeric_limits<std::int32_t>::min()}) {
        const Outcome outcome = with_extension(size);
        ASSERT_TRUE(outcome.ok()) << size;
        EXPECT_TRUE(outcome.warned("W-NII-003")) << size;
        EXPECT_EQ(outcome.loaded.image.voxels, good.loaded.image.voxels);
    }
}

TEST(Nifti, N16_header_and_data_in_two_files) {
    Nifti nifti;
    nifti.magic = std::string("ni1\0", 4);
    nifti.vox_offset = 0;
    const Folder folder;
    const std::string header = folder.write("pair.hdr", nifti.header());
    EXPECT_EQ(read(header).code, "E-NII-016");
    folder.write("pair.img", nifti.default_data().substr(0, 119));
    EXPECT_EQ(read(header).code, "E-IMG-005");
    folder.write("pair.img", nifti.default_data());
    const Outcome outcome = read(header);
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.loaded.image.voxels[8], 1);
    EXPECT_EQ(outcome.loaded.inputs.size(), 2U);
    std::filesystem::remove(folder.path("pair.img"));
    folder.write("pair.img.gz", deflated(nifti.default_data()));
    EXPECT_TRUE(read(header).ok());
    const std::string analyze = std::string("\x5c\1\0\0", 4) + std::string(344, '\0');
    EXPECT_EQ(read_bytes(analyze).code, "E-NII-003");
}

}  // namespace
}  // namespace anatomesh::nifti_test
