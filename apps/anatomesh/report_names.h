// What a report says of the names of DICOM inputs: folders and files are often called after the patient.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/measure/report.h"

namespace anatomesh {

// Where there are DICOM inputs, calls them "DICOM input" in the report: in its list of inputs, its warnings
// and the command line, of which `words` are those behind the program's name. There other files are named
// without their folders, and `series` by shown_series.
void hide_dicom_names(ModelReport& report, std::vector<std::string> words, const std::string& series);

// How `--series` is written down: a UID as the name that info shows.
std::string shown_series(const std::string& series);

}  // namespace anatomesh
