// The description of a mesh as lines of text, the same in the comments of every format:
//
//   SPACE=LPS
//   UNIT=mm
//   STRUCTURE 5 255 0 0 Liver        number, colour, name
//   REGION 1 = 5                     region, numbers of the structures it lies in
//   MATERIAL 1 12000 0.3 1.8e-09     from 1 on: Young's modulus in MPa, Poisson's ratio, density in t/mm3 or
//   0 NOTE version=0.1.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

std::vector<std::string> description_lines(const MeshDescription& description);

// Collects the lines of a file that is being read; lines of other kinds (foreign comments) are passed over.
class DescriptionReader {
  public:
    explicit DescriptionReader(std::string path) : path_(std::move(path)) { description_.space.clear(); }

    // Blanks around the line are ignored. Errors: E-MDL-011; E-MDL-017 a unit other than the millimetre.
    Status take(std::string_view line);
    const MeshDescription& description() const { return description_; }  // as far as it was read
    bool has_regions() const { return regions() > 1; }
    bool has_materials() const { return !description_.materials.empty(); }
    std::size_t regions() const { return description_.regions.members.size(); }  // outside included

    // The regions of cells (or sides of triangles) by the numbers that the file shows: by the table where the
    // file has one, else one structure per number. An empty list of labels: every cell is structure 1.
    Result<std::vector<Region>> regions_of_labels(const std::vector<std::int64_t>& labels, std::size_t cells);
    // The regions of cells by the region's own index. Requires: has_regions().
    Result<std::vector<Region>> regions_of_indices(const std::vector<std::int64_t>& indices) const;

    // Materials of cells by their numbers in the file, from 1 on; an empty list stays empty.
    Result<std::vector<std::uint32_t>> materials_of_numbers(const std::vector<std::int64_t>& numbers) const;

    // Warns when the file did not say its axes.
    MeshDescription finish(RunContext& context);

  private:
    Status take_unit(const std::string& unit);
    Status take_structure(std::string_view rest);
    Status take_region(std::string_view rest);
    Status take_material(std::string_view rest);

    std::string path_;
    MeshDescription description_;
    std::map<std::int32_t, std::uint32_t> index_of_number_;
};

}  // namespace anatomesh
