// Limits: the sizes beyond which the program refuses an input or a model, each of which --limit NAME=VALUE
// sets.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "anatomesh_io/contour/contour_limits.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/network/request_budget.h"
#include "anatomesh_io/project/read_project.h"

namespace anatomesh {

// Defaults are those of the readers and of the pipeline.
struct Limits {
    InputLimits input;
    ContourLimits contour;
    RequestLimits request;  // to a peer
    std::uint64_t project_points = ProjectLimits{}.points;
    std::uint64_t voxels;
    std::uint64_t tetrahedra;
    std::uint64_t memory_bytes = 0;  // 0: 80 % of what the machine, or the control group of the process, has

    Limits();
};

// Every limit on a line: its name, default, unit and meaning.
std::string limits_text();

// --limit NAME=VALUE, once per mention. An unknown name or a value out of range is a usage error.
void add_limit_option(CLI::App& verb, Limits& limits);

// The memory that a run may take: the limit, or 80 % of what there is. 0: not known.
std::uint64_t allowed_memory(const Limits& limits);

}  // namespace anatomesh
