#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh_io/report/html_text.h"
#include "anatomesh_io/report/report_charts.h"
#include "anatomesh_io/report/report_html.h"
#include "anatomesh_io/report/report_json.h"

namespace anatomesh::report_test {
namespace {

const std::string hostile =
    "</script><script>alert(1)</script>\"><img src=x onerror='alert(2)'>{{7*7}}\xE2\x80\xAE\xFF";

// A ball of two structures with a contour, every field of the report filled.
struct Sample {
    TetMesh mesh = testing::rounded_mesh(6, 30, [](int i, int, int) { return Region(i < 3 ? 1 : 2); });
    RegionTable regions{{{}, {0}, {1}}};
    std::vector<Structure> structures{{3, "liver", {10, 20, 30}}, {4, hostile, {40, 50, 60}}};
    ContourSet contours;
    ModelReport report;

    Sample() {
        contours.structures = structures;
        contours.slices.resize(1);
        contours.slices[0].contour_count = 1;
        contours.slices[0].name = "k = 0";
        contours.contours = {{0, 0, 0, 3}};
        contours.points = {mesh.points[0], mesh.points[1], mesh.points[2]};
        RunContext context;
        const std::vector<double> volumes{60000, 60000};
        measure_model({mesh, regions, structures, &contours, volumes}, context, report);
        report.provenance.version = "0.1.0";
        report.provenance.command = "anatomesh model " + hostile;
        report.provenance.libraries = {{"CGAL", "5.5.1"}};
        report.provenance.inputs = {{"b.nii", "NIfTI-1", std::string(64, 'b'), 10},
                                    {hostile, "NRRD", std::string(64, 'a'), 20}};
        report.provenance.options = {{"size", hostile}, {"threads", "2"}};
        report.conventions.hole_rule = "even-odd";
        report.conventions.end_caps = "half";
        report.meshing.share_culled = 0.25;
        report.run.stages = {{"cull", 0.5, 10, 20, {{"culled_share", 0.25}}}, {"refine", 1.5, 30, 40, {}}};
        report.warnings = {{"W-CON-001", hostile, {hostile, hostile, hostile, hostile, hostile}, hostile}};
        report.contours.log = {{hostile, hostile, hostile, hostile, 5, 4, 0.1, 0.2}};
        report.listed_cells.cells.push_back({1, 3.5, 4.5, {1, 2, 3}, hostile});
        report.listed_cells.total = 1;
    }
    std::string page() const { return report_html(report, mesh, regions, &contours); }
};

TEST(ReportJson, is_valid_against_its_schema) {
    const std::string python = "/usr/bin/python3";
    if (std::system((python + " -c 'import jsonschema' > /dev/null 2>&1").c_str()) != 0) {
        GTEST_SKIP() << "needs python3-jsonschema";
    }
    const std::filesystem::path file =
        std::filesystem::path(::testing::TempDir()) / "anatomesh_report_test.json";
    Sample sample;
    for (const char* name : {"1", "2"}) sample.report.provenance.options.emplace_back("structure", name);
    std::ofstream(file) << report_json(sample.report);
    const std::string script = std::string(ANATOMESH_SOURCE_DIR) + "/tests/formats/report_schema_test.py";
    EXPECT_EQ(std::system((python + " '" + script + "' '" + file.string() + "'").c_str()), 0);

    Sample broken;
    broken.report.quality.radius_edge.max = std::numeric_limits<double>::infinity();
    broken.report.quality.edge_mm.min = std::numeric_limits<double>::quiet_NaN();
    std::ofstream(file) << report_json(broken.report);
    EXPECT_EQ(std::system((python + " '" + script + "' '" + file.string() + "'").c_str()), 0);
    std::filesystem::remove(file);
}

TEST(ReportJson, two_runs_differ_in_timing_alone) {
    Sample one, two;
    two.report.provenance.command = "anatomesh model --threads 7 x";
    two.report.run.stages[0].seconds = 9;
    two.report.run.work = {1, 2, 3, 4};
    two.report.provenance.options[1].second = "7";
    std::reverse(two.report.provenance.inputs.begin(), two.report.provenance.inputs.end());
    auto a = nlohmann::ordered_json::parse(report_json(one.report));
    auto b = nlohmann::ordered_json::parse(report_json(two.report));
    EXPECT_NE(a.dump(), b.dump());
    EXPECT_EQ(a["timing"]["total_seconds"], 2.0);
    EXPECT_EQ(b["timing"]["threads"], "7");
    EXPECT_TRUE(a["timing"]["work"]["field_values"].is_null());
    EXPECT_EQ(b["timing"]["work"]["meshings"], 1);
    EXPECT_EQ(b["timing"]["work"]["delaunay_cells"], 2);
    EXPECT_EQ(b["timing"]["work"]["edited_cells"], 3);
    EXPECT_EQ(b["timing"]["work"]["field_values"], 4);
    a.erase("timing");
    b.erase("timing");
    EXPECT_EQ(a.dump(), b.dump());
}

TEST(ReportJson, an_option_that_was_repeated_has_all_its_values) {
    Sample sample;
    for (const char* name : {"GTV", "CTV", "PTV1"})
        sample.report.provenance.options.emplace_back("priority", name);
    const auto options = nlohmann::ordered_json::parse(report_json(sample.report))["options"];
    EXPECT_EQ(options["priority"], nlohmann::ordered_json({"GTV", "CTV", "PTV1"}));
    EXPECT_TRUE(options[sample.report.provenance.options[0].first].is_string());
}

TEST(ReportJson, what_is_not_known_is_null) {
    Sample sample;
    sample.report.structures[0].volume.field_mm3 = 0;
    sample.report.quality.radius_edge.max = std::numeric_limits<double>::infinity();
    const auto json = nlohmann::json::parse(report_json(sample.report));
    EXPECT_TRUE(json["structures"][0]["volume_field_mm3"].is_null());
    EXPECT_TRUE(json["quality"]["radius_edge"]["max"].is_null());
    EXPECT_EQ(json["counts"]["tetrahedra"], 6 * 6 * 6 * 6);
    EXPECT_EQ(json["certificate"].size(), 6u);
    EXPECT_EQ(json["certificate"][1]["state"], "broken");  // the contour is no section of the ball
}

TEST(ReportHtml, WB13_hostile_names_stay_text) {
    const std::string page = Sample().page();
    EXPECT_EQ(page.find("<script>alert"), std::string::npos);
    EXPECT_EQ(page.find("<img"), std::string::npos);
    EXPECT_EQ(page.find("onerror='"), std::string::npos);
    EXPECT_EQ(page.find('\xFF'), std::string::npos);
    EXPECT_NE(page.find("&lt;script&gt;alert(1)&lt;/script&gt;"), std::string::npos);
    // The scripts: the data blocks and the viewer, no more.
    const std::regex opening("<script");
    const auto scripts =
        std::distance(std::sregex_iterator(page.begin(), page.end(), opening), std::sregex_iterator());
    EXPECT_EQ(scripts, 10);
}

TEST(ReportHtml, WB21_nothing_is_loaded_from_elsewhere) {
    const std::string page = Sample().page();
    EXPECT_EQ(page.find("http://"), std::string::npos);
    EXPECT_EQ(page.find("https://"), std::string::npos);
    EXPECT_EQ(page.find(" src="), page.find(" src=x"));  // only the hostile name's, as text
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(ReportHtml, same_bytes_and_every_part_is_there) {
    const std::string page = Sample().page();
    EXPECT_EQ(page, Sample().page());
    for (const char* part :
         {"Certificate", "Radius-edge ratio", "Dihedral angles", "Structures", "Stages", "Warnings",
          "How the contours were read", "as published", "22&#8239;900", "172&#8239;500",
          "distance map of a slice", "id=\"cells\"", "id=\"contours\"", "Contours</label>"}) {
        EXPECT_NE(page.find(part), std::string::npos) << part;
    }
}

TEST(ReportHtml, a_model_too_big_for_a_page_is_shown_as_a_preview) {
    const Sample sample;
    const std::string page = report_html(sample.report, sample.mesh, sample.regions, nullptr, {100});
    EXPECT_NE(page.find("Preview:"), std::string::npos);
    EXPECT_NE(page.find("id=\"cells\"></script>"), std::string::npos);
    EXPECT_EQ(page.find("data-mode=\"cells\""), std::string::npos);
}

TEST(ReportHtml, a_quarter_million_cells_stay_below_20_MB) {
    Sample sample;
    sample.mesh = testing::rounded_mesh(35, 100, [](int, int, int) { return Region(1); });
    ASSERT_GT(sample.mesh.cells.size(), 250'000u);
    EXPECT_LT(report_html(sample.report, sample.mesh, sample.regions, nullptr).size(), 10'000'000u);
}

TEST(ReportHtml, an_empty_report_makes_a_page) {
    EXPECT_NE(report_html({}, {}, {}, nullptr).find("</html>"), std::string::npos);
}

TEST(HtmlText, escapes_and_repairs) {
    EXPECT_EQ(escape_html("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
    EXPECT_EQ(escape_html("\xC3\xA9\xF0\x9F\x92\x80"), "\xC3\xA9\xF0\x9F\x92\x80");
    const std::string bad = "\xEF\xBF\xBD";
    EXPECT_EQ(escape_html("\xC0\x80"), bad + bad);            // overlong
    EXPECT_EQ(escape_html("\xED\xA0\x80"), bad + bad + bad);  // surrogate
    EXPECT_EQ(escape_html("\xE2\x82"), bad + bad);            // cut off
    EXPECT_EQ(escape_html(std::string("\0\x1B", 2)), bad + bad);
    EXPECT_EQ(outside_html("x"), "<bdi>x</bdi>");
    EXPECT_EQ(grouped(std::uint64_t{1234567}), "1&#8239;234&#8239;567");
    EXPECT_EQ(grouped(-1234.5, 1), "&minus;1&#8239;234.5");
    EXPECT_EQ(grouped(-0.001, 1), "0.0");
    EXPECT_EQ(grouped(HUGE_VAL, 1), "&ndash;");
}

TEST(HtmlText, base64_of_every_length) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("\xFF\xFE\xFD\xFC"), "//79/A==");
}

TEST(ReportCharts, bars_beyond_the_bound_are_marked) {
    const std::string svg = histogram_svg({0, 4, {5, 0, 2, 1}}, {2.0, true, 1, 0, "x"});
    const auto count = [&](const std::string& word) {
        std::size_t n = 0;
        for (std::size_t at = svg.find(word); at != std::string::npos; at = svg.find(word, at + 1)) ++n;
        return n;
    };
    EXPECT_EQ(count("class=\"ok\""), 1u);
    EXPECT_EQ(count("class=\"over\""), 2u);
    EXPECT_EQ(count("class=\"bound\""), 1u);
}

}  // namespace
}  // namespace anatomesh::report_test
