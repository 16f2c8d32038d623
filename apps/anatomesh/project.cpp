// anatomesh project: what is in a project file; its contours, and what can be read of a damaged one.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/plural.h"
#include "anatomesh/live/edit/drawn_contours.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/project/read_project.h"
#include "answer.h"
#include "help_text.h"
#include "option_values.h"
#include "outputs.h"
#include "verbs.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

struct ProjectOptions {
    std::string input, contours, recovered;  // the last two empty: none
};

// The list of steps shows so many of them as text; --json lists all. [steps; >= 1; D a choice, measurement not recorded]
constexpr std::size_t most_steps_shown = 10;

struct DrawnCounts {
    std::size_t planes = 0, rings = 0, points = 0, proposals = 0;
};

Json structures_json(const Drawing& drawing) {
    std::map<std::int32_t, DrawnCounts> counts;
    for (const auto& entry : drawing.rings().entries()) {
        DrawnCounts& of_structure = counts[entry.key.structure];
        ++of_structure.planes;
        of_structure.rings += entry.value->rings.size();
        of_structure.points += entry.value->points.size();
    }
    for (const auto& entry : drawing.proposals().entries()) ++counts[entry.key.structure].proposals;
    Json list = Json::array();
    for (const std::int32_t number : drawing.order()) {
        const DrawnStructure& drawn = *drawing.structure(number);
        const DrawnCounts& of_structure = counts[number];
        list.push_back({{"number", number},
                        {"name", drawn.structure.name},
                        {"color", drawn.structure.color},
                        {"locked", drawn.locked},
                        {"planes", of_structure.planes},
                        {"contours", of_structure.rings},
                        {"points", of_structure.points},
                        {"proposals", of_structure.proposals}});
    }
    return list;
}

// The next step to be undone or redone first.
Json names_json(std::span<const Edit> steps) {
    Json list = Json::array();
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) list.push_back(step->name);
    return list;
}

Json answer_of(const Project& project, const ProjectOptions& options) {
    const Drawing& drawing = project.history.drawing();
    Json answer;
    answer["file"] = options.input;
    answer["space"] = drawing.source().frame == Frame::lps ? "LPS" : "unknown";
    answer["unit"] = "mm";
    answer["records"] = project.records;
    answer["planes"] = drawing.planes().entries().size();
    answer["pins"] = drawing.pins().entries().size();
    answer["left_out"] = slices_left_out(drawing);
    answer["structures"] = structures_json(drawing);
    answer["undo"] = names_json(project.history.done());
    answer["redo"] = names_json(project.history.undone());
    if (!options.contours.empty()) answer["contours"] = options.contours;
    if (!options.recovered.empty()) answer["recovered"] = options.recovered;
    return answer;
}

std::string steps_text(const char* title, const Json& steps) {
    if (steps.empty()) return "";
    std::string text = fmt::format("  {}, of {}:\n", title, counted(steps.size(), "step"));
    for (std::size_t i = 0; i < std::min(steps.size(), most_steps_shown); ++i)
        text += fmt::format("    {}\n", on_one_line(steps[i].get<std::string>()));
    return text;
}

std::string text_of(const Json& answer) {
    std::string text = fmt::format("{}: {}, {}, {}\n", answer["file"].get<std::string>(),
                                   counted(answer["records"].get<std::uint64_t>(), "record"),
                                   counted(answer["planes"].get<std::size_t>(), "plane"),
                                   counted(answer["structures"].size(), "structure"));
    for (const Json& each : answer["structures"]) {
        text += fmt::format("  {:>6}  {:<32} {} on {}{}\n", each["number"].get<std::int32_t>(),
                            on_one_line(each["name"].get<std::string>()),
                            counted(each["contours"].get<std::size_t>(), "contour"),
                            counted(each["planes"].get<std::size_t>(), "plane"),
                            each["locked"].get<bool>() ? ", locked" : "");
    }
    for (const Json& name : answer["left_out"])
        text += fmt::format("  left out of models by --without: {}\n", on_one_line(name.get<std::string>()));
    return text + steps_text("next to undo", answer["undo"]) + steps_text("next to redo", answer["redo"]);
}

Status check_options(const ProjectOptions& options) {
    if (!options.contours.empty() && !options.recovered.empty())
        return Error{ErrorKind::usage,
                     "E-CMD-008",
                     "--contours and --recover do not go together",
                     {options.input, "", "", "", ""},
                     "recover the project, then write the contours of what was recovered"};
    if (!options.contours.empty()) {
        ANATOMESH_CHECK_STATUS(check_extension(options.contours, {".json"}));
    }
    for (const std::string& output : {options.contours, options.recovered}) {
        if (output.empty()) continue;
        ANATOMESH_CHECK_STATUS(check_outputs({options.input}, {output}));
    }
    return Nothing{};
}

Status run_project(const ProjectOptions& options, Session& session) {
    ANATOMESH_CHECK_STATUS(check_options(options));
    const ProjectLimits limits{session.limits.input, session.limits.project_points};
    if (!options.recovered.empty()) {
        ANATOMESH_TRY(const Project project,
                      save_readable_part(options.input, options.recovered, limits, session.context));
        return give_summary(session, answer_of(project, options),
                            fmt::format("{}: {}\n", options.recovered, counted(project.records, "record")));
    }
    ANATOMESH_TRY(const Project project, read_project(options.input, {limits, false}, session.context));
    const Json answer = answer_of(project, options);
    if (options.contours.empty()) return give_answer(session, answer, text_of(answer));
    const ContourSet set = drawn_contours(project.history.drawing());
    if (set.contours.empty())
        return Error{ErrorKind::input,
                     "E-CIO-006",
                     "the project holds no contours",
                     {options.input, "", "", "", ""},
                     "accept proposals, or draw"};
    AtomicFileSet files;
    ANATOMESH_CHECK_STATUS(
        files.add(options.contours, format_contours(set, ContourFormat::json, session.context)));
    return files.commit([&] {
        return give_summary(
            session, answer,
            fmt::format("{}: {} on {}\n", options.contours, counted(set.contours.size(), "contour"),
                        counted(set.slices.size(), "slice")));
    });
}

}  // namespace

Work declare_project(CLI::App& verb) {
    auto options = std::make_shared<ProjectOptions>();
    verb.add_option("PROJECT", options->input, "Project file: what was drawn, and the steps that led to it.")
        ->type_name("FILE")
        ->required();
    add_text(verb, "--contours", options->contours, "OUT",
             "Write the contours as they are now: .json. Slices that are left out are among them; the answer "
             "names them for --without.");
    add_text(verb, "--recover", options->recovered, "OUT",
             "Write the records before the first damaged one to a project file of its own.");
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_project(*options, session); };
}

}  // namespace anatomesh
