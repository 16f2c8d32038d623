#include "anatomesh_io/report/report_assets.h"

namespace anatomesh {

const std::string_view report_style = R"css(
:root{color-scheme:light dark;--page:#f4f5f7;--card:#fff;--ink:#1b2430;--soft:#5a6675;--faint:#8a94a1;--line:#dfe3e8;
--accent:#1f5f8b;--accent-soft:#e3eef6;--view:#eef1f4;--view2:#d9dfe6;--good:#1d7a4f;--good-soft:#e0f2e9;--wait:#7a5b00;
--wait-soft:#fbf0cf;--bad:#b3261e;--bad-soft:#fbe4e2;--bar:#5d8fb3;--bar-bad:#c8544b;--stripe:#f8f9fb}
@media (prefers-color-scheme:dark){:root{--page:#12161b;--card:#1a2027;--ink:#e4e9ef;--soft:#a3aebb;--faint:#75808d;
--line:#2c353f;--accent:#7db8e0;--accent-soft:#1f3444;--view:#20272f;--view2:#0e1216;--good:#6fd0a0;--good-soft:#17362a;
--wait:#e3c15d;--wait-soft:#382f14;--bad:#f08a82;--bad-soft:#44211f;--bar:#5d93b8;--bar-bad:#d0645b;--stripe:#1e252d}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
main{max-width:1180px;margin:0 auto;padding:28px 20px 48px}
h1{font-size:25px;font-weight:650;margin:0;letter-spacing:-.01em;overflow-wrap:anywhere}
h2{font-size:16px;font-weight:650;margin:0 0 12px}
h3{font-size:13px;font-weight:600;margin:0 0 6px;color:var(--soft)}
p{margin:6px 0}.sub{color:var(--soft);overflow-wrap:anywhere}.note{color:var(--soft);font-size:13px}
section,.card{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:18px 20px;margin-top:16px}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:1px;background:var(--line);border:1px solid var(--line);border-radius:8px;overflow:hidden;margin-top:18px}
.tiles div{background:var(--card);padding:12px 16px}
.tiles b{display:block;font-size:21px;font-weight:620;font-variant-numeric:tabular-nums;letter-spacing:-.01em}
.tiles span{font-size:12.5px;color:var(--soft)}
.grid2{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,440px),1fr));gap:16px;margin-top:16px}
.grid2>section{margin-top:0}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13.5px;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:6px 10px;border-bottom:1px solid var(--line);vertical-align:top}
th{font-weight:600;color:var(--soft);font-size:12.5px;vertical-align:bottom;line-height:1.3}
tbody tr:last-child td,tbody tr:last-child th{border-bottom:0}
td.n,th.n{text-align:right}td.n{white-space:nowrap}td.text{overflow-wrap:anywhere;min-width:150px}
td.sum{font-weight:600}.mono{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;font-size:12.5px}
.state{display:inline-block;padding:1px 9px;border-radius:10px;font-size:12.5px;font-weight:600;white-space:nowrap}
.kept{color:var(--good);background:var(--good-soft)}.wait{color:var(--wait);background:var(--wait-soft)}.broken{color:var(--bad);background:var(--bad-soft)}
.chip{display:inline-block;width:11px;height:11px;border-radius:3px;border:1px solid rgba(128,128,128,.5);margin-right:7px;vertical-align:-1px}
.bar{height:9px;border-radius:2px;background:var(--bar);min-width:1px;margin-top:6px}
details summary{cursor:pointer;font-weight:600;font-size:16px}details[open] summary{margin-bottom:12px}
details .count{font-weight:400;color:var(--soft);font-size:14px}
.tall{max-height:420px;overflow:auto}
svg.chart{display:block;width:100%;height:auto}svg.chart text{font:11px system-ui,sans-serif;fill:var(--soft)}
svg.chart .ok{fill:var(--bar)}svg.chart .over{fill:var(--bar-bad)}svg.chart .axis{stroke:var(--faint);stroke-width:1}
svg.chart .gridline{stroke:var(--line);stroke-width:1}svg.chart .bound{stroke:var(--bad);stroke-width:1.2;stroke-dasharray:4 3}
.viewer{padding:0;overflow:hidden}
.tools{display:flex;flex-wrap:wrap;gap:8px 14px;align-items:center;padding:10px 14px;border-bottom:1px solid var(--line);font-size:13px}
.tools label{display:inline-flex;align-items:center;gap:6px;white-space:nowrap}.tools input[type=range]{width:190px;accent-color:var(--accent)}
.tools input[type=checkbox]{accent-color:var(--accent);margin:0}
.seg{display:inline-flex;border:1px solid var(--line);border-radius:6px;overflow:hidden}
.seg button{border:0;border-right:1px solid var(--line);border-radius:0}.seg button:last-child{border-right:0}
button,select{font:inherit;font-size:13px;color:var(--ink);background:var(--card);border:1px solid var(--line);border-radius:6px;padding:4px 10px;cursor:pointer}
button:hover{background:var(--accent-soft)}button[aria-pressed=true]{background:var(--accent-soft);color:var(--accent);font-weight:600}
button:focus-visible,select:focus-visible,input:focus-visible,canvas:focus-visible,summary:focus-visible{outline:2px solid var(--accent);outline-offset:1px}
.stage{position:relative;height:min(66vh,620px);min-height:340px;background:linear-gradient(var(--view),var(--view2))}
.stage canvas{position:absolute;inset:0;width:100%;height:100%;touch-action:none;cursor:grab;display:block}.stage canvas:active{cursor:grabbing}
.hud{position:absolute;pointer-events:none;font-size:12.5px;color:var(--soft);font-variant-numeric:tabular-nums}
.hud.tl{left:14px;top:10px}.hud.bl{left:14px;bottom:12px}.hud.br{right:14px;bottom:12px;text-align:right}
.hud svg text{font:600 12px system-ui,sans-serif}
.scale{height:5px;border:1.5px solid var(--soft);border-top:0;margin:0 0 0 auto}
.names{display:flex;flex-wrap:wrap;gap:6px 16px;padding:10px 14px;border-top:1px solid var(--line);font-size:13px;max-height:120px;overflow:auto}
.names label{display:inline-flex;align-items:center;overflow-wrap:anywhere}.names input{margin:0 7px 0 0;accent-color:var(--accent)}
.message{position:absolute;inset:0;display:flex;align-items:center;justify-content:center;text-align:center;padding:30px;color:var(--soft)}
[hidden]{display:none!important}
footer{color:var(--faint);font-size:12.5px;margin-top:22px}
@media print{.viewer{display:none}body{background:#fff}section,.card{break-inside:avoid}.tall{max-height:none}}
)css";

}  // namespace anatomesh
