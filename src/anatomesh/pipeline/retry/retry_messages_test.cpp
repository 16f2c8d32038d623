#include "anatomesh/pipeline/retry/retry_messages.h"

#include <gtest/gtest.h>

#include <string>

namespace anatomesh::retry_messages_test {
namespace {

TEST(RetryMessages, a_model_built_again_says_why_and_how) {
    RunOutcome outcome;
    const Warning refused = built_again(NextRun::finer, outcome, "clause 6 is broken (12 % of 3)", 1.5);
    EXPECT_EQ(refused.code, "W-PIP-001");
    EXPECT_NE(refused.message.find("too long for the smallest parts: clause 6 is broken"), std::string::npos);
    EXPECT_EQ(refused.message.find("12 %"), std::string::npos) << "figures of a model that nobody gets";
    outcome.course.conformed = true;
    outcome.score.bad = 1e-3;
    EXPECT_NE(
        built_again(NextRun::same_size, outcome, "", 1.5).message.find("without a reason in the contours"),
        std::string::npos);
    EXPECT_EQ(sought_by(NextRun::same_size, outcome),
              "another way to build it for the sake of the certificate");
    outcome.score.kept_contract = true;
    EXPECT_EQ(sought_by(NextRun::same_size, outcome),
              "another way to build it for the sake of ill-shaped tetrahedra");
    outcome.score.torn = true;
    EXPECT_EQ(sought_by(NextRun::finer, outcome), "a shorter edge length for the sake of torn walls");
}

TEST(RetryMessages, bumps_between_dense_planes_are_no_bad_cells) {
    RunOutcome bumpy;
    bumpy.course.conformed = true;
    bumpy.score.kept_contract = bumpy.score.deviates = true;
    const std::string bumps = "bumps between dense planes";
    EXPECT_NE(built_again(NextRun::same_size, bumpy, "", 1.5).message.find(bumps), std::string::npos);
    EXPECT_NE(sought_by(NextRun::same_size, bumpy).find(bumps), std::string::npos);
    bumpy.score.bad = 1e-3;
    EXPECT_EQ(built_again(NextRun::same_size, bumpy, "", 1.5).message.find(bumps), std::string::npos);
    EXPECT_EQ(sought_by(NextRun::same_size, bumpy).find(bumps), std::string::npos);
}

}  // namespace
}  // namespace anatomesh::retry_messages_test
