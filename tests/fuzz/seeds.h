// Small whole files of every kind that is fuzzed, good and wrong, by the generators of the rooms' own tests.
#pragma once

#include <string>
#include <vector>

namespace anatomesh::fuzz {

std::vector<std::string> dicom_series_seeds();
std::vector<std::string> rtstruct_seeds();
std::vector<std::string> seg_seeds();
std::vector<std::string> nifti_seeds();
std::vector<std::string> nrrd_seeds();
std::vector<std::string> metaimage_seeds();
std::vector<std::string> contour_json_seeds();
std::vector<std::string> project_seeds();  // records, a line each, without their checksums
std::vector<std::string> csl_seeds();
std::vector<std::string> inv3_seeds();

}  // namespace anatomesh::fuzz
