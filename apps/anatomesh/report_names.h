// What a report says of the names of DICOM inputs: folders and files are often called after the patient.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/measure/report.h"

namespace anatomesh {

// Calls DICOM inputs "DICOM input" in the report: in its list of inputs, its warnings and the command line,
// there also as `typed`, the words of the command line that name inputs. `series`, a UID if it is one,
// becomes the name that info shows.
void hide_dicom_names(ModelReport& report, const std::vector<std::string>& typed, const std::string& series);

// How `--series` is written down: a UID as the name that info shows.
std::string shown_series(const std::string& series);

}  // namespace anatomesh
