// Files in a tar archive held in memory. Nothing is written anywhere: names are only compared.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

struct TarEntry {
    std::string_view name;  // as stored, cut to 100 bytes; a view of the archive
    std::span<const std::byte> content;
};

// The regular files of the archive, in its order. ustar, GNU and pax archives; links, folders and extended
// headers are passed over. Linear in the number of entries.
// Errors (input): E-INV-001 damaged header, -002 an entry passes the end of the archive, -003 too many
// entries.
Result<std::vector<TarEntry>> tar_entries(std::span<const std::byte> archive, const std::string& path);

}  // namespace anatomesh
