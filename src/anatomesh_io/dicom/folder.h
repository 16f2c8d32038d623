// read_dicom_folder: the DICOM objects in a folder, whatever their files are called, and what else lies
// there.
//
// Privacy. A file is called by its number in the order of the paths ("FOLDER file 17"), a series by eight
// hexadecimal digits of the SHA-256 of its UID: names and UIDs of the outside often hold names and dates of
// patients. With keep_names they are called as they are.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/dicom/object.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

struct DicomFolderOptions {
    bool keep_names = false;
    InputLimits limits;
    std::uint64_t max_files = 2'000'000;  // looked at
    std::uint64_t max_objects = 100'000;
    FrameOptions frames;  // see object.h
};

// Objects of one study, series and patient; for images one volume, or several.
struct DicomSeries {
    std::string study, uid, name;  // name: how messages call it, and --series too
    DicomKind kind = DicomKind::other;
    std::vector<std::uint32_t> objects;  // indices into DicomFolder::objects
};

struct DicomFolder {
    std::string path;
    std::vector<DicomObject> objects;  // by patient, study, series, instance: not by the names of the files
    std::vector<DicomSeries> series;   // likewise; a series of several kinds of objects stands once a kind
    std::uint64_t files = 0;           // regular files looked at
    std::uint64_t skipped = 0;         // no DICOM, or none that is read (DICOMDIR)
    std::vector<Error> damaged;        // files that begin as DICOM, are damaged and do not say their series
};

// Looks into every regular file of the folder and of the folders in it; links to folders, devices, sockets
// are passed over. A path that is a file gives a folder of that one. Reads every DICOM file whole. Errors:
// E-INP-* for the folder itself; E-DCM-030 too many files or objects (limit). Warns W-DCM-001 of files
// skipped, W-DCM-002 of damaged ones.
Result<DicomFolder> read_dicom_folder(const std::string& path, const DicomFolderOptions& options,
                                      RunContext& context);

// The name of a series in messages: eight hexadecimal digits (in a folder in which several series have one
// UID, eight more behind a hyphen).
std::string series_name(const std::string& uid);

}  // namespace anatomesh
