// Session: what every verb shares while one command runs: the context of the run, and how to talk to the
// user.
//
// Answers go to standard output, everything else to standard error. Text from files is shown with control
// characters replaced, so that a name cannot drive the terminal.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "limits.h"

namespace anatomesh {

struct Session {
    RunContext context;
    Limits limits;
    std::vector<std::string> words;  // the command line without the program's name
    bool json = false;               // the answer as one JSON object
    bool quiet = false;              // no progress, no warnings, no summary; errors are always said
    bool output_closed = false;      // standard output was closed when the program began
    bool answered = false;           // an answer was printed
};

// The exit code that an error stands for.
int exit_code(const Error& error);

// Writes the answer to standard output. A pipe that nobody reads any more ends the output quietly; any other
// failure is an Error E-CMD-009.
Status print_answer(Session& session, std::string_view text);

// One line on standard error, control characters shown as '?'.
void print_line(const std::string& line);

// The error as one line on standard error; when the session answers in JSON and has not answered yet, also as
// a JSON object on standard output. So there is one JSON document, whatever happens.
void print_error(const Session& session, const Error& error);

// The warnings on standard error, at most five of a code, then how many more; nothing when quiet.
void print_warnings(const Session& session);

// Same text with control characters replaced by '?'. Newlines are kept.
std::string printable(std::string_view text);

// The same without newlines: for names from files, which must not look like lines of ours.
std::string on_one_line(std::string_view text);

}  // namespace anatomesh
