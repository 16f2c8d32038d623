#include "anatomesh/pipeline/retry/retry_for_mean_ratio.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace anatomesh::retry_for_mean_ratio_test {
namespace {

Model with_mean(double mean, std::size_t cells = 1000) {
    Model model;
    model.mesh.cells.resize(cells);
    model.report.counts.tetrahedra = cells;
    model.report.quality.radius_edge.mean = mean;
    return model;
}

Warning warned(const std::string& code) {
    return {code, "", {}, ""};
}

struct Outcome {
    Model model;
    std::vector<double> tried;  // target_mean_ratio of each build
    std::vector<std::string> warnings;
    bool taken = false;  // another than the first
};

// Every run costs five cells and one of the means given.
Outcome run(Model first, std::vector<double> means, const std::vector<std::string>& codes = {}) {
    Outcome done;
    RunContext context;
    context.warn(warned("first"));
    std::size_t cells = first.mesh.cells.size();
    const auto build = [&](double target_mean_ratio) -> Result<Model> {
        const std::size_t n = done.tried.size();
        done.tried.push_back(target_mean_ratio);
        context.warnings.clear();
        if (n < codes.size()) context.warn(warned(codes[n]));
        if (n >= means.size()) return Error{ErrorKind::geometry, "E-PIP-002", "", {}, ""};
        return with_mean(means[n], cells += 5);
    };
    Result<RetriedModel> retried = retry_for_mean_ratio(std::move(first), 1, build, context);
    EXPECT_TRUE(retried.ok());
    if (retried.ok()) {
        done.model = std::move(retried.value().model);
        done.taken = retried.value().target_mean_ratio.has_value();
        EXPECT_EQ(retried.value().runs, done.tried.size());
    }
    for (const Warning& warning : context.warnings) done.warnings.push_back(warning.code);
    return done;
}

TEST(RetryForMeanRatio, LeavesEvenAndLargeModels) {
    EXPECT_TRUE(run(with_mean(0.95), {0.9}).tried.empty());
    EXPECT_TRUE(run(with_mean(0.99, 30000), {0.9}).tried.empty());
}

TEST(RetryForMeanRatio, TakesTheFirstThatIsEven) {
    const Outcome done = run(with_mean(0.97), {0.96, 0.945, 0.93}, {"first", "first"});
    EXPECT_EQ(done.tried.size(), 2U);
    EXPECT_GT(done.tried[0], done.tried[1]);
    EXPECT_TRUE(done.taken);
    EXPECT_EQ(done.model.report.quality.radius_edge.mean, 0.945);
    EXPECT_EQ(done.model.mesh.cells.size(), 1010U);
}

// Bad cells are what the mean was bought with.
TEST(RetryForMeanRatio, OfSeveralEvenOnesTakesThatWithFewestBadCells) {
    RunContext context;
    std::vector<std::uint64_t> bad{4, 3, 5};
    std::size_t runs = 0;
    const auto build = [&](double) -> Result<Model> {
        Model model = with_mean(0.94, 20000);
        model.report.listed_cells.total = bad[runs++];
        return model;
    };
    const auto retried = retry_for_mean_ratio(with_mean(0.97, 15000), 1, build, context);
    ASSERT_TRUE(retried.ok());
    EXPECT_EQ(runs, 3U);
    EXPECT_EQ(retried.value().model.report.listed_cells.total, 3U);
}

TEST(RetryForMeanRatio, ElseTheOneWithTheLeastMean) {
    const Outcome done = run(with_mean(0.97), {0.955, 0.96, 0.965});
    EXPECT_EQ(done.tried.size(), 3U);
    EXPECT_EQ(done.model.report.quality.radius_edge.mean, 0.955);
    EXPECT_TRUE(done.warnings.empty()) << "those of the model that is taken";
    EXPECT_EQ(run(with_mean(0.97), {0.96}).model.report.quality.radius_edge.mean, 0.96) << "then no models";
}

TEST(RetryForMeanRatio, NoCellsAreGivenForNextToNothing) {
    const Outcome done = run(with_mean(0.97), {0.969, 0.968, 0.967});
    EXPECT_FALSE(done.taken);
    EXPECT_EQ(done.model.mesh.cells.size(), 1000U);
    EXPECT_EQ(done.warnings, std::vector<std::string>{"first"});
    EXPECT_TRUE(run(with_mean(0.951), {0.9499}).taken);
}

TEST(RetryForMeanRatio, AWorseOneIsNotTakenNorAreItsWarnings) {
    const Outcome done = run(with_mean(0.97), {0.94, 0.94, 0.94}, {"one", "two", "three"});
    EXPECT_EQ(done.tried.size(), 3U);
    EXPECT_FALSE(done.taken);
    EXPECT_EQ(done.model.report.quality.radius_edge.mean, 0.97);
    EXPECT_EQ(done.warnings, std::vector<std::string>{"first"});
}

TEST(RetryForMeanRatio, EndsWhenItIsCancelled) {
    RunContext context;
    const auto build = [](double) -> Result<Model> {
        return Error{ErrorKind::cancelled, "E-RUN-001", "", {}, ""};
    };
    const Result<RetriedModel> model = retry_for_mean_ratio(with_mean(0.97), 1, build, context);
    ASSERT_FALSE(model.ok());
    EXPECT_EQ(model.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace anatomesh::retry_for_mean_ratio_test
