#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cmath>

#include "anatomesh_io/image/phantom_fixtures.h"

namespace anatomesh::read_image_test {
namespace {

using namespace fixtures;

void expect_phantom(const Outcome& outcome, const Phantom& phantom, const char* format) {
    ASSERT_TRUE(outcome.ok()) << format << " " << to_line(outcome.error);
    for (int k = 0; k < 5; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 3; ++i) {
                const Vec3 expected = phantom.origin + static_cast<double>(i) * phantom.step[0] +
                                      static_cast<double>(j) * phantom.step[1] +
                                      static_cast<double>(k) * phantom.step[2];
                expect_position(outcome.loaded, i, j, k, expected);
                const int n = (k * 4 + j) * 3 + i;
                EXPECT_EQ(outcome.loaded.image.voxels[n], n * n % 61 + n) << format;
            }
}

TEST(ReadImage, N22_one_phantom_in_every_format_is_at_one_place) {
    for (const Phantom& phantom : {axis_phantom(), oblique_phantom()}) {
        expect_phantom(read_bytes(phantom.nifti(2)), phantom, "NIfTI-2");
        expect_phantom(read_bytes(phantom.nrrd(false)), phantom, "NRRD LPS");
        expect_phantom(read_bytes(phantom.nrrd(true)), phantom, "NRRD RAS");
        expect_phantom(read_bytes(phantom.metaimage()), phantom, "MetaImage");
    }
    expect_phantom(read_bytes(axis_phantom().nifti(1)), axis_phantom(), "NIfTI-1");
}

// ---- mutation

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return state_ >> 33;
    }
    std::size_t below(std::size_t bound) { return next() % bound; }

  private:
    std::uint64_t state_;
};

// Bytes flipped, replaced by extremes, inserted, removed, or the end cut off; mostly within the header.
std::string mutated(std::string bytes, std::size_t header, Random& random) {
    const std::size_t changes = 1 + random.below(8);
    for (std::size_t c = 0; c < changes && !bytes.empty(); ++c) {
        const std::size_t at =
            random.below(random.below(8) == 0 ? bytes.size() : std::min(header, bytes.size()));
        constexpr std::array<char, 8> extremes = {'\0', '\x7f', '\x80', '\xff', '0', '9', '-', '\n'};
        switch (random.below(6)) {
            case 0:
                bytes[at] ^= static_cast<char>(1 << random.below(8));
                break;
            case 1:
                bytes[at] = extremes[random.below(extremes.size())];
                break;
            case 2:
                bytes[at] = static_cast<char>(random.below(256));
                break;
            case 3:
                bytes.insert(at, 1 + random.below(4), extremes[random.below(extremes.size())]);
                break;
            case 4:
                bytes.erase(at, 1 + random.below(4));
                break;
            default:
                if (random.below(8) == 0) bytes.resize(at);
        }
    }
    return bytes;
}

TEST(ReadImage, N23_mutated_files_are_refused_or_read_never_a_crash) {
    const Folder folder;
    const Phantom phantom = oblique_phantom();
    const std::string one = phantom.nifti(1), two = phantom.nifti(2);
    const std::string nrrd = phantom.nrrd(true), meta = phantom.metaimage();
    const std::string packed = deflated(one);
    const std::string packed_nrrd = nrrd_header("", "space: RAS\n", "gzip") + deflated(phantom.data());
    struct Case {
        const std::string& bytes;
        std::size_t header;
    };
    const std::array<Case, 6> cases = {{{one, 352},
                                        {two, 544},
                                        {nrrd, nrrd.size() - 120},
                                        {meta, meta.size() - 120},
                                        {packed, packed.size()},
                                        {packed_nrrd, packed_nrrd.size()}}};
    Random random(20060407);
    int read_whole = 0, refused = 0;
    forget_peak_memory();
    const std::uint64_t before = memory_now();
    for (const Case& which : cases)
        for (int round = 0; round < 1000; ++round) {
            const Outcome outcome = read(folder.write("mutant", mutated(which.bytes, which.header, random)));
            if (!outcome.ok()) {
                ++refused;
                continue;
            }
            ++read_whole;
            const auto& image = outcome.loaded.image;
            EXPECT_EQ(image.voxels.size(), image.geometry.voxel_count());
            EXPECT_LE(image.voxels.size(), 4096U);
            for (const float value : image.voxels) EXPECT_TRUE(std::isfinite(value));
            RunContext context;
            (void)to_label_map(outcome.loaded, context).ok();
        }
    EXPECT_GT(refused, 1000);
    EXPECT_GT(read_whole, 100);
    EXPECT_LE(peak_memory(), before + (std::uint64_t{64} << 20));
}

// ---- what is no image

TEST(ReadImage, D24_special_files_are_refused_at_once) {
    const Folder folder;
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(::mkfifo(folder.path("pipe").c_str(), 0600), 0);
    EXPECT_EQ(read(folder.path("pipe")).code, "E-INP-004");
    EXPECT_EQ(read(folder.path("")).code, "E-INP-003");
    std::filesystem::create_symlink("/dev/zero", folder.path("zero"));
    EXPECT_EQ(read(folder.path("zero")).code, "E-INP-004");
    std::filesystem::create_symlink("loop", folder.path("loop"));
    EXPECT_EQ(read(folder.path("loop")).code, "E-INP-005");
    EXPECT_EQ(read(folder.path("absent")).code, "E-INP-001");
    EXPECT_EQ(read(std::string(10000, 'x')).code, "E-INP-005");
    folder.write("secret", Nifti().bytes());
    std::filesystem::permissions(folder.path("secret"), std::filesystem::perms::none);
    if (::geteuid() != 0) {
        EXPECT_EQ(read(folder.path("secret")).code, "E-INP-002");
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST(ReadImage, limits_of_the_file) {
    ReadImageOptions options;
    options.limits.max_file_bytes = 100;
    const Outcome outcome = read_bytes(Nifti().bytes(), options);
    EXPECT_EQ(outcome.code, "E-INP-008");
    EXPECT_EQ(static_cast<int>(outcome.error.kind), 5);
    options = {};
    options.max_voxels = 59;
    EXPECT_EQ(read_bytes(Nifti().bytes(), options).code, "E-IMG-004");
    options.max_voxels = 60;
    EXPECT_TRUE(read_bytes(Nifti().bytes(), options).ok());
}

// A DICOM file of explicit little endian that says nothing but its class.
std::string dicom(const std::string& uid) {
    std::string bytes(128, '\0');
    bytes += "DICM";
    std::string padded = uid + (uid.size() % 2 ? std::string(1, '\0') : "");
    bytes += std::string("\2\0\2\0UI", 6);
    put<std::uint16_t>(bytes, bytes.size(), static_cast<std::uint16_t>(padded.size()));
    return bytes + padded;
}

TEST(ReadImage, L01_to_L12_a_dicom_segmentation_is_named_and_refused) {
    for (const auto& [uid, name] : {std::pair{"1.2.840.10008.5.1.4.1.1.66.4", "Segmentation Storage"},
                                    {"1.2.840.10008.5.1.4.1.1.66.7", "Label Map Segmentation Storage"}}) {
        const Outcome outcome = read_bytes(dicom(uid));
        EXPECT_EQ(outcome.code, "E-IMG-002");
        EXPECT_NE(outcome.error.message.find("does not read DICOM objects of this kind"), std::string::npos);
        EXPECT_NE(outcome.error.message.find(name), std::string::npos);
        EXPECT_EQ(outcome.error.place.value, uid);
        EXPECT_NE(outcome.error.next_step.find("NIfTI"), std::string::npos);
    }
    EXPECT_EQ(read_bytes(dicom("1.2.840.10008.5.1.4.1.1.2")).code, "E-IMG-002");
}

TEST(ReadImage, files_of_other_kinds_are_named) {
    const Outcome mesh = read_bytes("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    EXPECT_EQ(mesh.code, "E-IMG-001");
    EXPECT_NE(mesh.error.message.find("Gmsh"), std::string::npos);
    EXPECT_EQ(read_bytes("no such thing").code, "E-IMG-001");
    EXPECT_EQ(read_bytes(deflated("no such thing")).code, "E-IMG-001");
}

TEST(ReadImage, cancelled) {
    const std::atomic<bool> cancel = true;
    RunContext context;
    context.cancel = &cancel;
    const Folder folder;
    const auto result = read_image(folder.write("image", Nifti().bytes()), {}, context);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().kind, ErrorKind::cancelled);
}

// ---- real images

TEST(ReadImage, real_images) {
    const char* given = std::getenv("ANATOMESH_DATA");
    const std::filesystem::path folder = given ? given : ANATOMESH_SOURCE_DIR "/../shared/data";
    if (!std::filesystem::exists(folder / "head_masks")) GTEST_SKIP() << "real images are not here";
    struct Real {
        const char* path;
        bool labels;
        std::size_t structures;
    };
    for (const Real& real : {Real{"head_masks/Skull.nrrd", true, 1},
                             {"body_ct_mr_labels/example_seg_fast_force_split.nii.gz", true, 61},
                             {"body_ct_mr_labels/example_seg_dicom.nii.gz", true, 31},
                             {"body_ct_mr_labels/example_seg_mr.nii.gz", true, 23},
                             {"spine_ct_labels/sub-verse004_seg-vert_msk.nii.gz", true, 9},
                             {"body_ct_mr_labels/example_ct.nii.gz", false, 0},
                             {"body_ct_mr_labels/example_mr_sm.nii.gz", false, 0},
                             {"tracked_ultrasound/SpinePhantomFreehandReconstructed.mha", false, 0}}) {
        const Outcome outcome = read((folder / real.path).string());
        ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
        EXPECT_EQ(looks_like_label_map(outcome.loaded.facts), real.labels) << real.path;
        if (!real.labels) continue;
        RunContext context;
        const auto map = to_label_map(outcome.loaded, context);
        ASSERT_TRUE(map.ok());
        EXPECT_EQ(map.value().structures.size(), real.structures) << real.path;
    }
}

}  // namespace
}  // namespace anatomesh::read_image_test
