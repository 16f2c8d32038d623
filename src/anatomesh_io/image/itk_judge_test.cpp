// ITK as independent judge of positions and values. Debian's ITK 5.2 compiles with g++ alone.
#if defined(__GNUC__) && !defined(__clang__)

#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include "anatomesh_io/image/phantom_fixtures.h"

namespace anatomesh::itk_judge_test {
namespace {

using namespace fixtures;

using ItkImage = itk::Image<std::int16_t, 3>;

template <class ImageIO>
ItkImage::Pointer read_by_itk(const std::string& path) {
    auto reader = itk::ImageFileReader<ItkImage>::New();
    reader->SetImageIO(ImageIO::New());
    reader->SetFileName(path);
    reader->Update();
    return reader->GetOutput();
}

void expect_same(const Outcome& outcome, const ItkImage& judge) {
    ASSERT_TRUE(outcome.ok()) << to_line(outcome.error);
    const auto& geometry = outcome.loaded.image.geometry;
    for (std::uint32_t k = 0; k < geometry.size[2]; ++k)
        for (std::uint32_t j = 0; j < geometry.size[1]; ++j)
            for (std::uint32_t i = 0; i < geometry.size[0]; ++i) {
                const ItkImage::IndexType index = {{i, j, k}};
                ItkImage::PointType point;
                judge.TransformIndexToPhysicalPoint(index, point);
                expect_position(outcome.loaded, i, j, k, {point[0], point[1], point[2]}, 1e-5);
                EXPECT_EQ(outcome.loaded.image.voxels[geometry.index(i, j, k)], judge.GetPixel(index));
            }
}

TEST(ItkJudge, N22_itk_reads_our_phantoms_at_the_same_place) {
    const Folder folder;
    for (const Phantom& phantom : {axis_phantom(), oblique_phantom()}) {
        const std::string nifti = folder.write("phantom.nii", phantom.nifti(1));
        expect_same(read(nifti), *read_by_itk<itk::NiftiImageIO>(nifti));
        for (const bool ras : {false, true}) {
            const std::string nrrd = folder.write("phantom.nrrd", phantom.nrrd(ras));
            expect_same(read(nrrd), *read_by_itk<itk::NrrdImageIO>(nrrd));
        }
        const std::string meta = folder.write("phantom.mha", phantom.metaimage());
        expect_same(read(meta), *read_by_itk<itk::MetaImageIO>(meta));
    }
}

TEST(ItkJudge, N22_images_written_by_itk_are_read_at_the_same_place) {
    const Folder folder;
    const std::string source = folder.write("phantom.mha", oblique_phantom().metaimage());
    const ItkImage::Pointer image = read_by_itk<itk::MetaImageIO>(source);
    const std::array<itk::ImageIOBase::Pointer, 3> writers = {
        itk::NiftiImageIO::New(), itk::NrrdImageIO::New(), itk::MetaImageIO::New()};
    const std::array<const char*, 3> names = {"by_itk.nii.gz", "by_itk.nrrd", "by_itk.mha"};
    for (std::size_t i = 0; i < 3; ++i)
        for (const bool compressed : {false, true}) {
            auto writer = itk::ImageFileWriter<ItkImage>::New();
            writer->SetImageIO(writers[i]);
            writer->SetInput(image);
            writer->SetUseCompression(compressed);
            writer->SetFileName(folder.path(names[i]));
            writer->Update();
            expect_same(read(folder.path(names[i])), *image);
        }
}

}  // namespace
}  // namespace anatomesh::itk_judge_test

#endif
