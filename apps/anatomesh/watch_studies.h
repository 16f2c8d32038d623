// StudyWatch: makes a model of every received study that has an RTSTRUCT or SEG, once it is complete.
//
// A study is complete when nothing of it has come for a while, no association that brought some of it is
// open, and all images that its RTSTRUCT and SEG objects refer to are there. What comes later makes another
// version; earlier ones stay. A model is made by the program itself in a process of its own, one after
// another, so that whatever a study holds cannot harm the receiver: a crash, the end of memory or a model without
// an end is one failure in the log, and the studies after it have their turn. The study that has waited longest
// is the next. Of a model that failed no output stays, and it is tried again only when more of its study comes.
//
//   FOLDER/models/STUDY/1/model.vtu, .stl, .report.json, .html, surface.dcm     the first version
//   FOLDER/models/STUDY/1/failure.txt                                           why there is none
//   FOLDER/models/STUDY/1/instances.sha256                                      of which objects it is
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "anatomesh_io/network/object_store.h"

namespace anatomesh {

// A model takes no longer: the largest that were measured take some minutes. [s; > 0; B]
inline constexpr double most_model_seconds = 1800;

struct WatchOptions {
    double settle_seconds = 30;  // nothing has come. > 0
    // How long images that are missing are waited for, in settle_seconds, until a line says so. > 0
    double patience = 20;
    bool keep_patient_ids = false;              // of the models
    double model_seconds = most_model_seconds;  // a process is ended after so long. > 0
};

class StudyWatch {
  public:
    // Looks at what is in the folder already: studies without a model of all they hold are made up for.
    StudyWatch(std::string folder, const WatchOptions& options, std::function<void(const std::string&)> say);
    StudyWatch(const StudyWatch&) = delete;
    StudyWatch& operator=(const StudyWatch&) = delete;
    ~StudyWatch();

    void arrived(const StoreOutcome& outcome);
    // Called several times a second; `busy` studies are still coming in. Starts and reaps processes.
    void tick(const std::vector<std::string>& busy);
    // Ends the process that runs, if one does, within seconds; what it would have made is not there.
    void end();
    std::uint64_t models() const { return models_; }

  private:
    using Clock = std::chrono::steady_clock;

    struct Study {
        Clock::time_point last;
        std::set<std::string> instances, references;  // UIDs
        bool has_structures = false;                  // an RTSTRUCT or SEG
        bool is_due = false;                          // something came since the last model
        bool was_missed = false;                      // a line said what is missing
    };

    void add(const std::string& study, const ObjectIdentity& identity);
    void look_around();
    std::size_t missing(const Study& study) const;
    void start_next(const std::vector<std::string>& busy);
    void start(const std::string& name, Study& study);
    void check_time();
    void reap();
    void note_failure(const std::string& reason);

    std::string folder_;
    WatchOptions options_;
    std::function<void(const std::string&)> say_;
    std::map<std::string, Study> studies_;  // by the names of their folders
    pid_t child_ = -1;
    Clock::time_point child_begun_, child_asked_;  // asked: to end
    bool is_asked_ = false;
    std::string child_study_, child_folder_;
    std::uint64_t models_ = 0;
};

}  // namespace anatomesh
