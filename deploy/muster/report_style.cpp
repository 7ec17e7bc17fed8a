#include "deploy/muster/report.h"

namespace muster::command {

const char* const kReportStyle = R"css(
:root{color-scheme:light dark;--bg:#faf9f6;--panel:#fff;--sunk:#eceeea;--ink:#1c2024;--soft:#5d646b;--rule:#e2e0da;
--station:#0d7a66;--explorer:#2459c9;--inspector:#c4520f;--meeting:#8a3ab9;--waiting:#e0b040;--travelling:#aeb8c0;--charging:#6aa84f;
--holding:#59616a;--returning:#8894a0;--rest:#e7e5df;--lost:#c5283d;--found:#9aa3ab;--good:#0d7a66;--bad:#c5283d;--halo:#fff}
@media(prefers-color-scheme:dark){:root{--bg:#111417;--panel:#191d21;--sunk:#15191c;--ink:#e9e7e2;--soft:#9aa2aa;--rule:#2a3036;
--station:#3ec6a6;--explorer:#7da6ff;--inspector:#ff9a57;--meeting:#cf8df0;--waiting:#c99a32;--travelling:#56616b;--charging:#86c46a;
--holding:#98a1aa;--returning:#707c88;--rest:#262c31;--lost:#ff6673;--found:#6f7982;--good:#3ec6a6;--bad:#ff6673;--halo:#111417}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,"Noto Sans","DejaVu Sans",sans-serif;font-variant-numeric:tabular-nums}
main{max-width:1240px;margin:0 auto;padding:56px 40px 40px}
h1,h2{font-family:"Iowan Old Style","Palatino Linotype",Palatino,"Book Antiqua",Georgia,"Noto Serif","DejaVu Serif",serif;font-weight:500;letter-spacing:-.015em;margin:0}
h1{font-size:clamp(2.2rem,5vw,3.6rem);line-height:1.08;margin:.2em 0 .3em}
h2{font-size:1.6rem;line-height:1.2}
h3{font-size:.8rem;font-weight:600;color:var(--soft);margin:0 0 .6em;letter-spacing:.02em}
ul{list-style:none;margin:0;padding:0}
figure{margin:0}
section{margin-top:64px}
.facts{display:flex;flex-wrap:wrap;gap:0 .6em;color:var(--soft);font-size:.95rem}
.facts li+li::before{content:"·";margin-right:.6em}
.facts .name{color:var(--ink);font-weight:600}
.lede{font-size:1.2rem;max-width:44em;margin:0;color:var(--soft)}
.callout{border-left:3px solid var(--lost);padding:.2em 0 .2em 1em;margin:1.4em 0 0}
.says{color:var(--soft);margin:.3em 0 1.4em;max-width:50em}
.quiet{color:var(--soft)}
.tiles{display:grid;grid-template-columns:repeat(6,1fr);gap:1px;margin:40px 0 0;background:var(--panel);border:1px solid var(--rule);border-radius:10px;overflow:hidden}
.tile{background:var(--panel);padding:18px 20px 16px;box-shadow:0 0 0 1px var(--rule)}
.tile dt{font-size:.82rem;color:var(--soft)}
.tile dd{margin:.1em 0 0;font-size:1.9rem;line-height:1.2;letter-spacing:-.02em;white-space:nowrap}
.tile small{font-size:.85rem;color:var(--soft);margin-left:.35em;letter-spacing:0}
.tile.good dd{color:var(--good)}.tile.bad dd{color:var(--bad)}
.site,.chart{background:var(--panel);border:1px solid var(--rule);border-radius:10px;padding:24px}
.views{display:grid;grid-template-columns:1fr 1fr;gap:28px}
.drawing{position:relative;background:var(--sunk);border-radius:6px;overflow:hidden;max-height:78vh;margin:0 auto}
.drawing img,.drawing svg{position:absolute;inset:0;width:100%;height:100%;display:block}
.drawing img{image-rendering:pixelated}
.track{fill:none;stroke-width:1.2;stroke-opacity:.55;stroke-linejoin:round;vector-effect:non-scaling-stroke}
.track.station{stroke:var(--station)}.track.explorer{stroke:var(--explorer)}.track.inspector{stroke:var(--inspector)}
.feature{stroke:var(--halo);stroke-width:.8;vector-effect:non-scaling-stroke}
.feature.unseen{fill:var(--lost)}.feature.found{fill:var(--explorer)}.feature.inspected{fill:var(--inspector)}.feature.delivered{fill:var(--station)}
.trail{fill:none;stroke-width:2.5;stroke-linejoin:round;stroke-linecap:round;vector-effect:non-scaling-stroke}
.trail.station{stroke:var(--station)}.trail.explorer{stroke:var(--explorer)}.trail.inspector{stroke:var(--inspector)}
.live .track{stroke-opacity:.18}
.robot circle{stroke:var(--halo);stroke-width:2;vector-effect:non-scaling-stroke}
.robot.station circle{fill:var(--station)}.robot.explorer circle{fill:var(--explorer)}.robot.inspector circle{fill:var(--inspector)}.robot.lost circle{fill:var(--lost)}
.robot text{fill:var(--halo);text-anchor:middle;dominant-baseline:central;font-weight:700}
.scale{border:1px solid var(--soft);border-top:0;height:6px;margin-top:8px;position:relative}
.scale span{position:absolute;left:calc(100% + 8px);top:-9px;font-size:.78rem;color:var(--soft);white-space:nowrap}
.legend{display:flex;flex-wrap:wrap;gap:4px 18px;font-size:.86rem;color:var(--soft);margin-bottom:18px}
.legend.stacked{margin:20px 0 0}
.legend li{display:flex;align-items:center;gap:7px}
.legend b{color:var(--ink);font-weight:600}
.legend i{width:14px;height:12px;border-radius:2px;flex:none}
.legend i.thin{height:4px}
.legend i.dot{width:10px;height:10px;border-radius:50%}
.legend i.dot.station,.legend i.dot.delivered{background:var(--station)}.legend i.dot.explorer,.legend i.dot.found{background:var(--explorer)}
.legend i.dot.inspector,.legend i.dot.inspected{background:var(--inspector)}.legend i.dot.unseen{background:var(--lost)}
.legend i.dot.feature{width:7px;height:7px}
.legend i.line{height:3px}.legend i.line.found{background:var(--explorer)}.legend i.line.inspected{background:var(--inspector)}.legend i.line.delivered{background:var(--station)}
.player{display:flex;align-items:center;gap:14px;margin-top:22px}
.player[hidden]{display:none}
.player button{width:38px;height:38px;border-radius:50%;border:1px solid var(--rule);background:var(--bg);color:var(--ink);font-size:.8rem;cursor:pointer;flex:none}
.player button:hover{border-color:var(--soft)}
.player input{flex:1;accent-color:var(--ink);min-width:0}
.player output{min-width:3.6em;text-align:right;font-weight:600}
.plot{position:relative;height:300px;margin:0 0 0 44px;border-bottom:1px solid var(--soft)}
.plot svg{position:absolute;inset:0;width:100%;height:100%;overflow:visible}
.plot path{fill:none;stroke-width:2;vector-effect:non-scaling-stroke;stroke-linejoin:round}
.plot .found{stroke:var(--explorer);stroke-width:1.5}.plot .inspected{stroke:var(--inspector);stroke-width:1.5}.plot .delivered{stroke:var(--station);stroke-width:2.5}
.plot .area{fill:var(--station);fill-opacity:.1;stroke:none}
.grid{position:absolute;left:0;right:0;border-top:1px solid var(--rule)}
.grid span{position:absolute;right:calc(100% + 10px);top:-.8em;font-size:.8rem;color:var(--soft)}
.milestone{position:absolute;top:0;bottom:0;border-left:1px dashed var(--soft)}
.milestone span{position:absolute;bottom:10px;left:6px;font-size:.78rem;color:var(--soft);white-space:nowrap;background:var(--panel);padding:0 3px}
.milestone.left span{left:auto;right:6px}
.milestone+.milestone span{bottom:36px}
.axis{position:relative;height:1.6em;margin-left:44px;font-size:.8rem;color:var(--soft)}
.axis span{position:absolute;top:6px;transform:translateX(-50%)}
.axis span:first-child{transform:none}.axis span.last{transform:translateX(-100%)}
.rows{position:relative}
.row{display:flex;align-items:center;height:32px}
.who{width:104px;flex:none;font-size:.86rem;white-space:nowrap}
.who.station{color:var(--station)}.who.explorer{color:var(--explorer)}.who.inspector{color:var(--inspector)}
.lane{flex:1;height:24px;min-width:0}
.lane svg{width:100%;height:100%;display:block;border-radius:2px}
.dense .row{height:17px}.dense .lane{height:14px}.dense .who{font-size:.72rem}
.over{position:absolute;left:104px;right:0;top:0;bottom:0;pointer-events:none}
.under-rows .axis{margin-left:104px}
.cursor{position:absolute;top:0;bottom:0;width:0;border-left:1.5px solid var(--ink);left:100%;opacity:0}
.live .cursor{opacity:.75}
.a-exploring{fill:var(--explorer);background:var(--explorer)}.a-inspecting{fill:var(--inspector);background:var(--inspector)}
.a-meeting{fill:var(--meeting);background:var(--meeting)}.a-waiting{fill:var(--waiting);background:var(--waiting)}
.a-travelling{fill:var(--travelling);background:var(--travelling)}.a-charging{fill:var(--charging);background:var(--charging)}
.a-holding{fill:var(--holding);background:var(--holding)}.a-returning{fill:var(--returning);background:var(--returning)}
.a-landing,.a-landed,.a-idle{fill:var(--rest);background:var(--rest)}.a-lost{fill:var(--lost);background:var(--lost);fill-opacity:.35}
.c-station{fill:var(--station);background:var(--station)}.c-explorer{fill:var(--explorer);background:var(--explorer)}.c-inspector{fill:var(--inspector);background:var(--inspector)}
.columns{columns:3;column-gap:40px;margin-top:20px}
.numbers{display:block;border-collapse:collapse;width:100%;font-size:.86rem}
.numbers tbody{display:block}
.numbers tr{display:flex;justify-content:space-between;gap:12px;border-bottom:1px solid var(--rule);padding:5px 0;break-inside:avoid}
.numbers th{font-weight:400;color:var(--soft);text-align:left;overflow-wrap:anywhere}
.numbers th i{font-style:normal}
.numbers td{text-align:right;overflow-wrap:anywhere;min-width:3em}
section>h3{margin-top:32px}
.grid-table{border-collapse:collapse;font-size:.86rem;min-width:min(100%,560px)}
.grid-table th,.grid-table td{padding:5px 20px 5px 0;text-align:right;border-bottom:1px solid var(--rule);font-weight:400}
.grid-table th:first-child{text-align:left}
.grid-table thead th{color:var(--soft)}
footer{margin-top:64px;padding-top:20px;border-top:1px solid var(--rule);color:var(--soft);font-size:.86rem}
footer p{margin:.3em 0}
code{font-family:ui-monospace,"SF Mono",Menlo,Consolas,"DejaVu Sans Mono",monospace;font-size:.92em}
@media(max-width:980px){.tiles{grid-template-columns:repeat(3,1fr)}main{padding:36px 24px}.views{grid-template-columns:1fr}.columns{columns:2}section{margin-top:48px}}
@media(max-width:560px){.tiles{grid-template-columns:repeat(2,1fr)}main{padding:24px 14px}.columns{columns:1}.site,.chart{padding:14px}}
@media print{.player{display:none}section{break-inside:avoid}}
)css";

}  // namespace muster::command
