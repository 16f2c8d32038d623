#include "program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "anatomesh/base/standard_arithmetic.h"
#include "command_words.h"
#include "help_text.h"
#include "limits.h"
#include "option_values.h"
#include "session.h"
#include "shell_texts.h"
#include "signals.h"
#include "verbs.h"

namespace anatomesh {

namespace {

constexpr const char* version = ANATOMESH_VERSION;
// No more threads can be asked for: more is a slip. [threads; >= 1; C]
constexpr std::uint32_t most_threads = 1024;

constexpr const char* exit_codes =
    R"(Exit codes:
  0    The command is done.
  2    The command is wrong.
  3    The input is wrong.
  4    The input can be read, but no correct model can be made of it.
  5    A limit is exceeded, or the memory does not suffice.
  6    A file, the network or another program on the network failed.
  7    The program found an error in its own result.
  130  The user cancelled the run.
No file is written unless the exit code is 0.)";

// Thrown by --limits while options are parsed, as --help is by CLI11.
struct LimitsAsked {};

struct CommonOptions {
    bool json = false, quiet = false;
    std::uint32_t threads = 0;
    Limits limits;
};

struct VerbEntry {
    const char* name;
    const char* description;  // One sentence without its full stop.
    Work (*declare)(CLI::App&);
    std::vector<std::string> most_used;  // The options that --help shows; none if it shows all.
    const char* examples;
};

const VerbEntry verb_entries[] = {
    {"info",
     "Say what is in an image, label map or contour file",
     declare_info,
     {"--series", "--volume", "--frame", "--image-to-probe", "--json"},
     R"(Examples:
  anatomesh info liver.nii.gz
  anatomesh info rtss.dcm --json)"},
    {"segment",
     "Find a structure in a grey image and write its label map or its contours",
     declare_segment,
     {"--output", "--threshold", "--seed", "--method", "--keep-largest", "--fill-holes", "--close", "--name",
      "--recipe", "--per-slice"},
     R"(Examples:
  anatomesh segment ct.nii.gz --threshold 226 --keep-largest 1 --fill-holes -o bone.nrrd
  anatomesh segment ct.nii.gz --seed 62.5,-20,113 --name spleen -o spleen.json
  anatomesh segment ct.nii.gz --threshold 150:1500 --seed 30,5,-410 --close 3 -o femur.nii.gz
  anatomesh segment sweep.igs.mha --despeckle 0.5 --method chan-vese --seed-voxel 300,200,10 -o cyst.json
  anatomesh segment ct.nii.gz --recipe organs.json -o organs.nrrd)"},
    {"contours",
     "Write the contours of an image, label map or contour file",
     declare_contours,
     {"--output", "--structure", "--threshold", "--keep-largest", "--every", "--offset", "--epsilon",
      "--without", "--close-gaps", "--report"},
     R"(Examples:
  anatomesh contours labels.nii.gz -o organs.vtp
  anatomesh contours Cranium.inv3 --threshold 226 --keep-largest 1 --every 2 -o skull.json
  anatomesh contours rtss.dcm --structure GTV -o gtv.csl)"},
    {"field",
     "Write contours as an image: a bit volume, or a map of the distance in mm",
     declare_field,
     {"--output", "--what", "--pixel", "--structure", "--threshold", "--keep-largest", "--every"},
     R"(Examples:
  anatomesh field rtss.dcm --structure GTV -o gtv_distance.nrrd
  anatomesh field organs.json --what bits --pixel 0.5 -o organs.nii.gz)"},
    {"model",
     "Make a tetrahedral model of a label map, a grey image or contours, with a report",
     declare_model,
     {"--output", "--threshold", "--keep-largest", "--structure", "--every", "--size", "--priority",
      "--close-gaps", "--surface", "--html"},
     R"(Examples:
  anatomesh model labels.nii.gz -o organs.vtu
  anatomesh model rtss.dcm --structure Liver --structure GTV -o liver.vtu --surface liver.stl
  anatomesh model Cranium.inv3 --threshold 226 --keep-largest 1 -o skull.vtu --html skull.html)"},
    {"check",
     "Check a tetrahedral model: closed surfaces, shapes of tetrahedra, contours",
     declare_check,
     {"--contours", "--structure", "--frame", "--volume", "--without", "--json"},
     R"(Examples:
  anatomesh check skull.vtu
  anatomesh check skull.vtu --contours skull.json --json)"},
    {"compare",
     "Measure the distance between two surfaces or models in mm, both ways",
     declare_compare,
     {},
     R"(Examples:
  anatomesh compare skull.vtu reference.stl
  anatomesh compare before.vtu after.vtu --json)"},
    {"convert",
     "Write a model in another format, or its surface",
     declare_convert,
     {},
     R"(Examples:
  anatomesh convert skull.vtu -o skull.msh
  anatomesh convert skull.vtu -o skull.inp --order 2
  anatomesh convert skull.vtu -o skull.feb --grey ct.nii.gz --material bone.json)"},
    {"project",
     "Say what is in a project file, write its contours, or recover a damaged one",
     declare_project,
     {},
     R"(Examples:
  anatomesh project liver.project
  anatomesh project liver.project --contours liver.json
  anatomesh project damaged.project --recover liver.project)"},
    {"receive",
     "Receive DICOM objects from scanners and archives, and make models of them on request",
     declare_receive,
     {},
     R"(Examples:
  anatomesh receive incoming
  anatomesh receive incoming --address 0.0.0.0 --port 104 --allow CT1@10.0.0.7 --plain --model)"},
    {"query",
     "List the studies, series or instances of an archive",
     declare_query,
     {},
     R"(Examples:
  anatomesh query --from ORTHANC@127.0.0.1:4242 --match StudyDate=20260101- --keep-patient-ids
  anatomesh query --from https://pacs/dicom-web --level series --study 1.2.840.1)"},
    {"fetch",
     "Fetch a study, series or instance from an archive",
     declare_fetch,
     {},
     R"(Examples:
  anatomesh fetch --from ORTHANC@127.0.0.1:4242 --study 1.2.840.1 -o incoming
  anatomesh fetch --from https://pacs/dicom-web --study 1.2.840.1 --series 1.2.840.1.1 -o incoming)"},
    {"send",
     "Send DICOM objects to an archive",
     declare_send,
     {},
     R"(Examples:
  anatomesh send model_surface.dcm --to ORTHANC@127.0.0.1:4242
  anatomesh send incoming/1.2.840.1 --to https://pacs/dicom-web --user me --password-file secret)"},
    {"where-next",
     "Name the planes where one more contour would improve the model most",
     declare_where_next,
     {"--count", "--structure", "--threshold", "--keep-largest", "--every", "--size", "--json"},
     R"(Examples:
  anatomesh where-next rtss.dcm --structure GTV
  anatomesh where-next labels.nii.gz --count 3 --json)"},
};

Work declare_completion(CLI::App& verb, const CLI::App& app) {
    auto shell = std::make_shared<std::string>();
    add_choice(verb, "SHELL", *shell, {"bash", "zsh", "fish"}, "The shell that the script is for.")
        ->required();
    return [shell, &app](Session& session) {
        if (*shell == "bash") return print_answer(session, bash_completion(app));
        if (*shell == "zsh") return print_answer(session, zsh_completion(app));
        return print_answer(session, fish_completion(app));
    };
}

void add_limits_flag(CLI::App& app) {
    app.add_flag_callback(
        "--limits", [] { throw LimitsAsked{}; }, "List all limits with their names and values.");
}

void describe_help(CLI::App& verb) {
    verb.get_option("--help")->description("List the most used options.")->group(option_group::run);
    verb.get_option("--help-all")->description("List all options in groups.")->group(option_group::run);
}

void add_common(CLI::App& verb, CommonOptions& common) {
    verb.add_flag("--json", common.json, "Print the answer as one JSON object, for programs.");
    verb.add_flag("--quiet", common.quiet,
                  "Print no progress, no warnings and no summary. Errors are always printed.");
    add_count(verb, "--threads", common.threads, 1, most_threads,
              "Number of threads, 1 to 1024. Default: all processors.");
    add_limit_option(verb, common.limits);
    add_limits_flag(verb);
    describe_help(verb);
    group_new_options(verb, option_group::run);
}

const std::vector<CommandList> command_lists{
    {"Commands that make and examine models",
     {"info", "segment", "contours", "field", "model", "check", "compare", "convert", "where-next",
      "project"}},
    {"Commands that talk to an archive by DICOM", {"receive", "query", "fetch", "send"}},
    {"Commands for the shell", {"completion", "manual"}}};

std::vector<std::string> most_used_of(const std::string& name) {
    for (const VerbEntry& entry : verb_entries)
        if (name == entry.name) return entry.most_used;
    return {};
}

std::vector<const CLI::App*> parsed_commands(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* each) { return each->parsed(); });
}

std::string help_for(const CLI::App& app, bool complete) {
    const std::vector<const CLI::App*> parsed = parsed_commands(app);
    if (!parsed.empty())
        return command_help(*parsed.back(), most_used_of(parsed.back()->get_name()), complete);
    std::string text = program_help(app, command_lists);
    if (!complete) return text;
    for (const CommandList& list : command_lists) {
        for (const std::string& name : list.commands)
            text += fmt::format("\n{}\n\n{}", std::string(80, '-'),
                                command_help(*app.get_subcommand(name), {}, true));
    }
    return text;
}

// CLI11 throws for help, version and wrong commands alike.
int end_of_parsing(const CLI::App& app, const CLI::ParseError& stop, Session& session) {
    if (stop.get_exit_code() == 0) {
        const bool is_version = dynamic_cast<const CLI::CallForVersion*>(&stop) != nullptr;
        const bool is_complete = dynamic_cast<const CLI::CallForAllHelp*>(&stop) != nullptr;
        const Status printed = print_answer(
            session, is_version ? fmt::format("anatomesh {}\n", version) : help_for(app, is_complete));
        if (printed) return 0;
        print_error(session, printed.error());
        return exit_code(printed.error());
    }
    const Error error{
        ErrorKind::usage, "E-CMD-001", stop.what(), {}, "the option --help of each command describes it"};
    print_error(session, error);
    return exit_code(error);
}

int finish(const Status& status, Session& session) {
    print_warnings(session);
    if (status) return 0;
    print_error(session, status.error());
    return exit_code(status.error());
}

int run(int argc, const char* const* argv, Session& session) {
    CLI::App app{"anatomesh makes tetrahedral models of anatomy from contours on medical image slices",
                 "anatomesh"};
    app.set_help_flag("-h,--help", "List the commands.");
    app.set_help_all_flag("--help-all", "List the commands with all their options.");
    app.set_version_flag("--version", version, "Print the version.");
    add_limits_flag(app);
    app.footer(exit_codes);
    app.require_subcommand(1);

    CommonOptions common;
    std::vector<std::pair<CLI::App*, Work>> verbs;
    for (const VerbEntry& entry : verb_entries) {
        CLI::App* verb = app.add_subcommand(entry.name, entry.description);
        verb->footer(entry.examples);
        Work work = entry.declare(*verb);
        add_common(*verb, common);
        verbs.emplace_back(verb, std::move(work));
    }
    CLI::App* completion =
        app.add_subcommand("completion", "Print the script that completes commands in a shell");
    completion->footer(
        "Example:\n  anatomesh completion bash > ~/.local/share/bash-completion/completions/anatomesh");
    verbs.emplace_back(completion, declare_completion(*completion, app));
    describe_help(*completion);
    CLI::App* manual = app.add_subcommand("manual", "Print the manual page");
    describe_help(*manual);
    manual->footer("Example:\n  anatomesh manual | man -l -");
    verbs.emplace_back(manual,
                       [&app](Session& each) { return print_answer(each, manual_page(app, version)); });

    const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
    // Errors of the words themselves are answered in the form that was asked for.
    for (const std::string& word : words) session.json = session.json || word == "--json";
    if (const Status words_are_known = check_words(app, words); !words_are_known)
        return finish(words_are_known, session);
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError& stop) {
        return end_of_parsing(app, stop, session);
    } catch (const LimitsAsked&) {
        return finish(print_answer(session, limits_text()), session);
    }
    session.json = common.json;
    session.quiet = common.quiet;
    session.limits = common.limits;
    session.context.threads = common.threads > 0 ? static_cast<int>(common.threads) : available_processors();
    for (const auto& [verb, work] : verbs) {
        if (verb->parsed()) return finish(work(session), session);
    }
    return 0;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
    const StandardArithmetic arithmetic;
    Session session;
    const ProcessState process = prepare_process();
    session.context.cancel = process.cancel;
    session.output_closed = process.output_closed;
    Error error{
        ErrorKind::internal, "E-CMD-011", "", {}, "please report this with the command and the input"};
    try {
        session.words.assign(argv + std::min(argc, 1), argv + argc);
        return run(argc, argv, session);
    } catch (const std::bad_alloc&) {
        error = {ErrorKind::limit,
                 "E-CMD-010",
                 "the memory does not suffice",
                 {},
                 "a larger --size or --every needs less memory"};
    } catch (const std::exception& unexpected) {
        error.message = fmt::format("an unexpected error occurred: {}", unexpected.what());
    } catch (...) {
        error.message = "an unexpected error of unknown kind occurred";
    }
    print_error(session, error);
    return exit_code(error);
}

}  // namespace anatomesh
