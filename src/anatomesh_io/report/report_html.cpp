#include "anatomesh_io/report/report_html.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/base/number_text.h"
#include "anatomesh_io/report/html_text.h"
#include "anatomesh_io/report/report_assets.h"
#include "anatomesh_io/report/report_charts.h"
#include "anatomesh_io/report/report_slice.h"

namespace anatomesh {

namespace {

// The page lists no more cells; report.json has them all. [rows; >= 1; B]
constexpr std::size_t max_listed_rows = 200;
// The page lists no more lines of the contours' log, so that browsers open it at once. [rows; >= 1; B]
constexpr std::size_t max_log_rows = 5000;
// The page lists no more warnings, so that browsers open it at once. [rows; >= 1; B]
constexpr std::size_t max_warning_rows = 2000;

std::string cell(const std::string& html) {
    return "<td>" + html + "</td>";
}
std::string text_cell(const std::string& html) {
    return "<td class=\"text\">" + html + "</td>";
}
std::string number_cell(const std::string& html) {
    return "<td class=\"n\">" + html + "</td>";
}
std::string row(const std::string& cells) {
    return "<tr>" + cells + "</tr>\n";
}

// The header from labels; those that begin with # are numbers.
std::string table(std::initializer_list<const char*> labels, const std::string& rows) {
    std::string head;
    for (const char* label : labels) {
        const bool is_number = label[0] == '#';
        head +=
            std::string(is_number ? "<th class=\"n\">" : "<th>") + (is_number ? label + 1 : label) + "</th>";
    }
    return "<div class=\"scroll\"><table><thead>" + row(head) + "</thead><tbody>\n" + rows +
           "</tbody></table></div>";
}

std::string section(const char* title, const std::string& content) {
    return std::string("<section><h2>") + title + "</h2>" + content + "</section>\n";
}

std::string folded(const char* title, std::uint64_t count, const std::string& content) {
    return std::string("<section><details><summary>") + title + " <span class=\"count\">(" + grouped(count) +
           ")</span></summary><div class=\"tall\">" + content + "</div></details></section>\n";
}

std::string color_chip(const std::array<std::uint8_t, 3>& c) {
    return "<span class=\"chip\" style=\"background:rgb(" + std::to_string(c[0]) + "," +
           std::to_string(c[1]) + "," + std::to_string(c[2]) + ")\"></span>";
}

std::string structure_name(const StructureReport& structure) {
    return structure.name.empty() ? "structure " + std::to_string(structure.number)
                                  : outside_html(structure.name);
}

double total_seconds(const ModelReport& report) {
    double total = 0;
    for (const StageReport& stage : report.run.stages) total += stage.seconds;
    return total;
}

std::string heading(const ModelReport& report) {
    std::string files;
    for (const InputReport& input : report.provenance.inputs)
        files += (files.empty() ? "" : ", ") + outside_html(input.file);
    const std::size_t count = report.structures.size();
    std::string sub = count == 1 ? "1 structure" : grouped(std::uint64_t{count}) + " structures";
    sub +=
        report.conventions.space == "LPS" ? " &middot; patient coordinates (LPS)" : " &middot; frame unknown";
    sub += " &middot; millimetres &middot; anatomesh " + escape_html(report.provenance.version);
    return "<header><h1>" + (files.empty() ? std::string("Model") : files) + "</h1><p class=\"sub\">" + sub +
           "</p></header>\n";
}

std::string tile(const std::string& value, const char* label) {
    return "<div><b>" + value + "</b><span>" + label + "</span></div>";
}

std::string tiles(const ModelReport& report) {
    std::string html = "<div class=\"tiles\">" + tile(grouped(report.counts.tetrahedra), "tetrahedra") +
                       tile(grouped(report.counts.vertices), "vertices") +
                       tile(grouped(report.counts.surface_triangles), "surface triangles");
    if (report.counts.contour_vertices > 0)
        html += tile(grouped(report.counts.contour_vertices), "contour vertices");
    if (report.counts.slices > 0) html += tile(grouped(report.counts.slices), "slices");
    html += tile(grouped(report.quality.radius_edge.mean, 2), "mean radius-edge");
    if (!report.run.stages.empty()) html += tile(grouped(total_seconds(report), 2) + " s", "all stages");
    return html + "</div>\n";
}

std::string structure_switches(const ModelReport& report) {
    if (report.structures.size() < 2) return {};
    std::string html = "<div class=\"names\">";
    for (std::size_t s = 0; s < report.structures.size(); ++s) {
        html += "<label><input type=\"checkbox\" checked data-structure=\"" + std::to_string(s) + "\">" +
                color_chip(report.structures[s].color) + structure_name(report.structures[s]) + "</label>";
    }
    return html + "</div>";
}

std::string viewer(const ModelReport& report, const Scene& scene) {
    std::string html = R"html(<section class="viewer"><div class="tools">
<span class="seg"><button type="button" data-mode="surface" aria-pressed="true">Surface</button>)html";
    html += R"html(<button type="button" data-mode="section" aria-pressed="false">Cut</button>)html";
    if (scene.cells_drawn)
        html +=
            R"html(<button type="button" data-mode="cells" aria-pressed="false">Whole cells</button>)html";
    html += R"html(</span>
<span id="cut-tools" hidden style="display:inline-flex;flex-wrap:wrap;gap:8px 14px;align-items:center"><span class="seg"><button type="button" data-axis="0" aria-pressed="false">Sagittal</button><button type="button" data-axis="1" aria-pressed="false">Coronal</button><button type="button" data-axis="2" aria-pressed="true">Axial</button><button type="button" data-axis="3" aria-pressed="false">Facing me</button></span>
<input type="range" id="place" min="0" max="1" step="0.002" value="0.5" aria-label="Position of the cutting plane">
<button type="button" id="flip">Other side</button>
<label>Cells by <select id="color"><option value="structure">structure</option><option value="quality">radius-edge ratio</option></select></label></span>
<label><input type="checkbox" id="edges"> Edges</label>
)html";
    html += scene.has_contours
                ? R"html(<label><input type="checkbox" id="contour-lines"> Contours</label>)html"
                : R"html(<label hidden><input type="checkbox" id="contour-lines"> Contours</label>)html";
    html +=
        R"html(<span style="flex:1"></span><span class="seg"><button type="button" data-look="0,0">Front</button><button type="button" data-look="1.5708,0">Left</button><button type="button" data-look="0,1.5707">Top</button><button type="button" data-look="-0.6,0.28">Reset</button></span></div>
<div class="stage" id="stage"><canvas id="view" tabindex="0" aria-label="3D view of the model"></canvas>
<div class="hud tl"><span id="cut-note"></span><span id="ramp" hidden><br>radius-edge 0.6 <svg width="120" height="9" style="vertical-align:-1px"><defs><linearGradient id="g"><stop offset="0" stop-color="#3a66a8"/><stop offset=".25" stop-color="#70b2c4"/><stop offset=".5" stop-color="#eee2a0"/><stop offset=".75" stop-color="#e28c4e"/><stop offset="1" stop-color="#b22a2e"/></linearGradient></defs><rect width="120" height="9" rx="2" fill="url(#g)"/></svg> 2</span></div>
<div class="hud bl"><svg id="compass" width="80" height="80" aria-hidden="true"></svg></div>
<div class="hud br"><div id="scale-text"></div><div class="scale" id="scale"></div></div>
<div class="message" id="message" hidden></div><noscript><div class="message">The 3D view needs JavaScript. Everything else on this page is complete.</div></noscript></div>)html";
    html += structure_switches(report) +
            "</section>\n<p class=\"note\">Drag to turn, shift-drag or right-drag to move, "
            "wheel to zoom; L, P, S point to the patient's left, back and head.";
    if (!scene.cells_drawn) {
        html +=
            " Preview: this model has too many tetrahedra for a page, so the cut shows its surface alone.";
    }
    return html + "</p>\n";
}

std::string certificate(const ModelReport& report) {
    std::string rows;
    for (const Clause& clause : report.certificate) {
        const char* kind = clause.state == ClauseState::kept     ? "kept\">kept"
                           : clause.state == ClauseState::moved  ? "wait\">moved"
                           : clause.state == ClauseState::broken ? "broken\">broken"
                                                                 : "wait\">not promised yet";
        rows += row(number_cell(std::to_string(clause.number)) +
                    cell("<span class=\"state " + std::string(kind) + "</span>") +
                    text_cell(escape_html(clause.statement)) + text_cell(outside_html(clause.evidence)));
    }
    return section("Certificate", table({"#", "State", "What is promised", "What was measured"}, rows));
}

std::string quality(const ModelReport& report) {
    const QualityReport& q = report.quality;
    const std::string ratio =
        histogram_svg(q.radius_edge.histogram, {2.0, true, 0.5, 1, "circumradius / shortest edge"}) +
        "<p class=\"note\">Mean " + grouped(q.radius_edge.mean, 3) + ", 99 % below " +
        grouped(q.radius_edge.p99, 2) + ", largest " + grouped(q.radius_edge.max, 2) +
        "; above 2: " + grouped(q.radius_edge.over_2) + " (" +
        fixed_text(100 * q.radius_edge.share_over_2, 3) + " %).</p>";
    const std::string angles =
        histogram_svg(q.dihedral_deg.histogram,
                      {10.0, false, 15, 0, "smallest dihedral angle of a tetrahedron, degrees"}) +
        "<p class=\"note\">Smallest " + grouped(q.dihedral_deg.min, 2) + "&deg;, 1 % below " +
        grouped(q.dihedral_deg.p01, 1) + "&deg;, median " + grouped(q.dihedral_deg.median_min, 1) +
        "&deg;; below 10&deg;: " + grouped(q.dihedral_deg.below_10) +
        ", below 15&deg;: " + grouped(q.dihedral_deg.below_15) + "; largest angle " +
        grouped(q.dihedral_deg.max, 1) + "&deg;. Edges " + grouped(q.edge_mm.min, 3) + " to " +
        grouped(q.edge_mm.max, 2) + " mm, mean " + grouped(q.edge_mm.mean, 2) + " mm.</p>";
    return "<div class=\"grid2\">" + section("Radius-edge ratio", ratio) +
           section("Dihedral angles", angles) + "</div>\n";
}

std::string milliliters(double mm3) {
    return mm3 > 0 ? grouped(mm3 / 1000, 3) : std::string("&ndash;");
}

std::string structures(const ModelReport& report) {
    std::string rows;
    for (const StructureReport& s : report.structures) {
        const std::string on = s.fidelity.vertices > 0 ? grouped(s.fidelity.vertices_on_surface) + " of " +
                                                             grouped(s.fidelity.vertices)
                                                       : std::string("&ndash;");
        rows +=
            row(text_cell(color_chip(s.color) + structure_name(s)) + number_cell(std::to_string(s.number)) +
                number_cell(grouped(s.tetrahedra)) + number_cell(grouped(s.surface.triangles)) +
                number_cell(milliliters(s.volume.mesh_mm3)) + number_cell(milliliters(s.volume.field_mm3)) +
                number_cell(milliliters(s.volume.slices_mm3)) +
                number_cell(grouped(s.surface.area_mm2 / 100, 1)) +
                number_cell(grouped(std::uint64_t{s.pieces})) +
                number_cell(grouped(std::uint64_t{s.surface.components})) +
                number_cell(std::to_string(s.surface.genus)) + number_cell(on));
    }
    std::string rule;
    if (!report.conventions.end_caps.empty())
        rule = "<p class=\"note\">End caps: " + outside_html(report.conventions.end_caps) + ".</p>";
    return section("Structures",
                   table({"Structure", "#No.", "#Tetrahedra", "#Triangles", "#Volume by mesh, ml",
                          "#by field, ml", "#by slices, ml", "#Surface, cm&sup2;", "#Pieces", "#Shells",
                          "#Genus", "#Contour vertices on surface"},
                         rows) +
                       rule);
}

std::string stage_figures(const StageReport& stage) {
    std::string html;
    for (const auto& [name, value] : stage.figures) {
        const bool whole = value == std::floor(value) && std::abs(value) < 1e15;
        std::string label = name;
        std::replace(label.begin(), label.end(), '_', ' ');
        html += (html.empty() ? "" : ", ") + escape_html(label) + " " + grouped(value, whole ? 0 : 3);
    }
    return html;
}

std::string stages(const ModelReport& report) {
    if (report.run.stages.empty()) return {};
    const double total = total_seconds(report);
    double longest = 0;
    for (const StageReport& stage : report.run.stages) longest = std::max(longest, stage.seconds);
    std::string rows;
    for (const StageReport& stage : report.run.stages) {
        const double share = longest > 0 ? 100 * stage.seconds / longest : 0;
        rows += row(cell(escape_html(stage.name)) + number_cell(grouped(stage.seconds, 3)) +
                    "<td style=\"width:22%\"><div class=\"bar\" style=\"width:" + fixed_text(share, 1) +
                    "%\"></div></td>" + number_cell(stage.points ? grouped(stage.points) : "") +
                    number_cell(stage.cells ? grouped(stage.cells) : "") + text_cell(stage_figures(stage)));
    }
    rows += row(cell("<b>all</b>") + "<td class=\"n sum\">" + grouped(total, 3) +
                "</td><td></td><td></td><td></td><td></td>");
    return section("Stages", table({"Stage", "#Seconds", "", "#Points", "#Tetrahedra", "Figures"}, rows));
}

// Archip et al. 2006, the skull, as published there.
std::string beside_the_paper(const ModelReport& report) {
    if (report.counts.contour_vertices == 0) return {};
    const auto line = [](const char* what, const std::string& ours, const char* theirs) {
        return row(cell(what) + number_cell(ours) + number_cell(theirs));
    };
    const double seconds = total_seconds(report);
    const std::string spacing =
        report.lengths.slice_spacing_mm > 0 ? grouped(report.lengths.slice_spacing_mm, 2) + " mm" : "&ndash;";
    std::string rows =
        line("Slices", grouped(report.counts.slices), "55") + line("Slice spacing", spacing, "3 mm") +
        line("Points (contour vertices)", grouped(report.counts.contour_vertices), "22&#8239;900") +
        line("Tetrahedra", grouped(report.counts.tetrahedra), "172&#8239;500") +
        line("Share culled", fixed_text(100 * report.meshing.share_culled, 1) + " %", "up to 40 %") +
        line("Mean radius-edge ratio before refinement",
             report.meshing.radius_edge_mean_before_refinement > 0
                 ? grouped(report.meshing.radius_edge_mean_before_refinement, 2)
                 : std::string("&ndash;"),
             "2.0") +
        line("Mean radius-edge ratio after refinement", grouped(report.quality.radius_edge.mean, 2), "0.9") +
        line("Time, all stages", report.run.stages.empty() ? "&ndash;" : grouped(seconds, 2) + " s", "10 s");
    return section("Beside the paper's skull",
                   table({"", "#This model", "#Archip et al. 2006, as published"}, rows) +
                       "<p class=\"note\">N. Archip, R. Rohling, V. Dessenne, P.-J. Erard, L.-P. Nolte: "
                       "Anatomical structure "
                       "modeling from medical images. Computer Methods and Programs in Biomedicine 82 (2006) "
                       "203-215, Table 1. "
                       "Another skull, another machine.</p>");
}

std::string place_html(const Place& place) {
    std::string html;
    const auto add = [&](const char* label, const std::string& text) {
        if (!text.empty()) html += (html.empty() ? "" : ", ") + std::string(label) + outside_html(text);
    };
    add("", place.file);
    add("structure ", place.structure);
    add("slice ", place.slice);
    add("contour ", place.contour);
    add("value ", place.value);
    return html;
}

std::string more_rows(std::size_t shown, std::uint64_t total) {
    if (shown >= total) return {};
    return "<p class=\"note\">The first " + grouped(std::uint64_t{shown}) + " of " + grouped(total) +
           "; all of them are in report.json.</p>";
}

std::string warnings(const ModelReport& report) {
    if (report.warnings.empty()) return section("Warnings", "<p class=\"note\">None.</p>");
    std::string rows;
    const std::size_t shown = std::min(report.warnings.size(), max_warning_rows);
    for (std::size_t i = 0; i < shown; ++i) {
        const Warning& warning = report.warnings[i];
        rows += row("<td class=\"mono\">" + escape_html(warning.code) + "</td>" +
                    text_cell(place_html(warning.place)) + text_cell(outside_html(warning.message)) +
                    text_cell(outside_html(warning.what_was_done)));
    }
    const std::string content =
        table({"Code", "Where", "What", "What was done"}, rows) + more_rows(shown, report.warnings.size());
    return shown <= 12 ? section("Warnings", content) : folded("Warnings", report.warnings.size(), content);
}

std::string listed_cells(const ModelReport& report) {
    if (report.listed_cells.total == 0) return {};
    std::string rows;
    const std::size_t shown = std::min(report.listed_cells.cells.size(), max_listed_rows);
    for (std::size_t i = 0; i < shown; ++i) {
        const ListedCell& listed = report.listed_cells.cells[i];
        rows += row(number_cell(std::to_string(listed.cell)) + number_cell(grouped(listed.value, 2)) +
                    number_cell(grouped(listed.min_dihedral_deg, 2)) + number_cell(grouped(listed.at[0], 2)) +
                    number_cell(grouped(listed.at[1], 2)) + number_cell(grouped(listed.at[2], 2)) +
                    text_cell(listed.forced_by.empty() ? "&ndash;" : outside_html(listed.forced_by)));
    }
    return folded("Tetrahedra with a radius-edge ratio above 2 or an angle below 10 degrees",
                  report.listed_cells.total,
                  table({"#Cell", "#Ratio", "#Angle", "#x, mm", "#y, mm", "#z, mm", "Forced by"}, rows) +
                      more_rows(shown, report.listed_cells.total));
}

std::string contour_log(const ModelReport& report) {
    if (report.contours.log.empty()) return {};
    std::string rows;
    const std::size_t shown = std::min(report.contours.log.size(), max_log_rows);
    for (std::size_t i = 0; i < shown; ++i) {
        const ContourReport& entry = report.contours.log[i];
        rows += row(text_cell(outside_html(entry.structure)) + text_cell(outside_html(entry.slice)) +
                    text_cell(outside_html(entry.name)) + text_cell(outside_html(entry.rule)) +
                    number_cell(grouped(std::uint64_t{entry.points_in})) +
                    number_cell(grouped(std::uint64_t{entry.points_kept})) +
                    number_cell(grouped(entry.max_displacement_mm, 3)) +
                    number_cell(grouped(entry.area_change_mm2, 3)));
    }
    return folded("How the contours were read", report.contours.log.size(),
                  table({"Structure", "Slice", "Contour", "Rule", "#Points in", "#Points kept",
                         "#Largest move in reading, mm", "#Area changed, mm&sup2;"},
                        rows) +
                      more_rows(shown, report.contours.log.size()));
}

std::string origin(const ModelReport& report) {
    std::string inputs, options;
    for (const InputReport& input : report.provenance.inputs) {
        inputs += row(text_cell(outside_html(input.file)) + cell(escape_html(input.format)) +
                      number_cell(grouped(input.bytes)) + "<td class=\"text mono\">" +
                      escape_html(input.sha256) + "</td>");
    }
    for (const auto& [name, value] : report.provenance.options) {
        options += row(cell(escape_html(name)) + text_cell(outside_html(value)));
    }
    for (const auto& [name, version] : report.provenance.libraries) {
        options += row(cell(escape_html(name)) + text_cell(outside_html(version)));
    }
    std::string content;
    if (!report.provenance.command.empty())
        content += "<p class=\"mono text\">" + outside_html(report.provenance.command) + "</p>";
    if (!inputs.empty())
        content += "<h3>Inputs</h3>" + table({"File", "Format", "#Bytes", "SHA-256"}, inputs);
    if (!options.empty())
        content +=
            "<h3 style=\"margin-top:14px\">Options and versions</h3>" + table({"Name", "Value"}, options);
    return content.empty() ? content : section("How it was made", content);
}

std::string contour_and_distance(const ContourSet* contours) {
    const std::string figure = contours ? slice_figure(*contours) : std::string();
    return figure.empty() ? figure : section("Contours and distance map of a slice", figure);
}

}  // namespace

std::string report_html(const ModelReport& report, const TetMesh& mesh, const RegionTable& regions,
                        const ContourSet* contours, const SceneOptions& options) {
    const Scene scene = make_scene(report, mesh, regions, contours, options);
    std::string html =
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
        "'unsafe-inline'; "
        "script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"referrer\" "
        "content=\"no-referrer\">\n<title>";
    html += report.provenance.inputs.empty() ? std::string("Model")
                                             : escape_html(report.provenance.inputs.front().file);
    html += " - anatomesh</title>\n<style>";
    html += report_style;
    html += "</style>\n</head>\n<body>\n<main>\n";
    html += heading(report) + tiles(report) + viewer(report, scene) + certificate(report) + quality(report) +
            structures(report) + contour_and_distance(contours) + stages(report) + beside_the_paper(report) +
            warnings(report) + listed_cells(report) + contour_log(report) + origin(report);
    html += "<footer>Made by anatomesh " + escape_html(report.provenance.version) +
            ". Not a certified medical device.</footer>\n</main>\n" + scene.html + "<script>";
    html += report_viewer_script;
    return html + "</script>\n</body>\n</html>\n";
}

}  // namespace anatomesh
