#include "anatomesh/pipeline/even_out.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace anatomesh {
namespace {

Model with_mean(double mean, std::size_t cells = 1000) {
    Model model;
    model.mesh.cells.resize(cells);
    model.report.tetrahedra = cells;
    model.report.quality.radius_edge_mean = mean;
    return model;
}

Warning warned(const std::string& code) {
    return {code, "", {}, ""};
}

struct Outcome {
    Model model;
    std::vector<double> tried;  // even_mean of each build
    std::vector<std::string> warnings;
};

// Every try costs five cells and one of the means given.
Outcome run(Model first, std::vector<double> means, const std::vector<std::string>& codes = {}) {
    Outcome done;
    RunContext context;
    context.warn(warned("first"));
    std::size_t cells = first.mesh.cells.size();
    const auto build = [&](double even_mean) -> Result<Model> {
        const std::size_t n = done.tried.size();
        done.tried.push_back(even_mean);
        context.warnings.clear();
        if (n < codes.size()) context.warn(warned(codes[n]));
        if (n >= means.size()) return Error{ErrorKind::geometry, "E-PIP-002", "", {}, ""};
        return with_mean(means[n], cells += 5);
    };
    Result<Model> model = even_out(std::move(first), 1, build, context);
    EXPECT_TRUE(model.ok());
    if (model.ok()) done.model = std::move(model.value());
    for (const Warning& warning : context.warnings) done.warnings.push_back(warning.code);
    return done;
}

TEST(EvenOut, LeavesEvenAndLargeModels) {
    EXPECT_TRUE(run(with_mean(0.95), {0.9}).tried.empty());
    EXPECT_TRUE(run(with_mean(0.99, 30000), {0.9}).tried.empty());
}

TEST(EvenOut, TakesTheFirstThatIsEven) {
    const Outcome done = run(with_mean(0.97), {0.96, 0.94, 0.93}, {"first", "first"});
    EXPECT_EQ(done.tried.size(), 2U);
    EXPECT_GT(done.tried[0], done.tried[1]);
    EXPECT_EQ(done.model.report.quality.radius_edge_mean, 0.94);
    EXPECT_EQ(done.model.mesh.cells.size(), 1010U);
}

TEST(EvenOut, ElseTheOneWithTheLeastMean) {
    const Outcome done = run(with_mean(0.97), {0.96});
    EXPECT_EQ(done.tried.size(), 2U) << "the last one without a model";
    EXPECT_EQ(done.model.report.quality.radius_edge_mean, 0.96);
    EXPECT_TRUE(done.warnings.empty()) << "those of the model that is taken";
}

TEST(EvenOut, AWorseOneIsNotTakenNorAreItsWarnings) {
    const Outcome done = run(with_mean(0.97), {0.94, 0.94}, {"one", "two"});
    EXPECT_EQ(done.tried.size(), 2U);
    EXPECT_EQ(done.model.report.quality.radius_edge_mean, 0.97);
    EXPECT_EQ(done.warnings, std::vector<std::string>{"first"});
}

TEST(EvenOut, EndsWhenItIsCancelled) {
    RunContext context;
    const auto build = [](double) -> Result<Model> {
        return Error{ErrorKind::cancelled, "E-RUN-001", "", {}, ""};
    };
    const Result<Model> model = even_out(with_mean(0.97), 1, build, context);
    ASSERT_FALSE(model.ok());
    EXPECT_EQ(model.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace anatomesh
