"""How the report looks: on screens light and dark, wide and narrow, and on paper."""

STYLE = """
:root { --ink:#1b2530; --soft:#566373; --line:#dfe4ea; --page:#f6f7f9; --card:#ffffff; --accent:#0b5c96;
  --warn:#8a4b00; --warn-card:#fff5e3; --warn-line:#f0b75a; --stable:#0072b2; --failed:#b84a00;
  --undecided:#666d76; }
@media (prefers-color-scheme: dark) { :root { --ink:#e7ebf0; --soft:#a3afbd; --line:#343d49; --page:#14181e;
  --card:#1d232b; --accent:#7cc0f0; --warn:#ffd08a; --warn-card:#33270f; --warn-line:#8a6420;
  --stable:#6cbcf0;
  --failed:#ff9a57; --undecided:#b3bac4; } }
* { box-sizing:border-box; }
html { scroll-behavior:smooth; -webkit-text-size-adjust:100%; }
body { margin:0; background:var(--page); color:var(--ink);
  font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif; }
main { max-width:1120px; margin:0 auto; padding:0 20px 64px; }
nav { position:sticky; top:0; z-index:2; background:var(--card); border-bottom:1px solid var(--line);
  padding:9px 20px; display:flex; gap:4px 20px; flex-wrap:wrap; justify-content:center; font-size:14px; }
nav a { color:var(--soft); text-decoration:none; } nav a:hover, nav a:focus { color:var(--accent); }
header { padding:30px 0 4px; }
.case-title { margin:0 0 12px; color:var(--soft); font-size:17px; }
h1 { margin:0; font-weight:600; line-height:1.2; font-size:clamp(21px,3vw,28px); }
h1 .number { display:inline-block; font-size:clamp(46px,7.2vw,72px); font-weight:700; line-height:1;
  letter-spacing:-.02em; color:var(--accent); margin:0 .12em; font-variant-numeric:tabular-nums; }
h1 .how { display:block; font-size:17px; font-weight:400; color:var(--soft); margin-top:10px; }
.verdict { font-size:18px; margin:14px 0 0; max-width:78ch; }
section { margin-top:40px; scroll-margin-top:52px; }
h2 { font-size:22px; margin:0 0 12px; padding-bottom:7px; border-bottom:2px solid var(--line); }
h3 { font-size:17px; margin:24px 0 8px; }
p { margin:10px 0; max-width:82ch; }
ul { margin:8px 0; padding-left:22px; max-width:82ch; } li { margin:4px 0; }
.note { border-left:4px solid var(--warn-line); background:var(--warn-card); padding:11px 16px; margin:14px
  0;
  border-radius:0 8px 8px 0; } .note p, .note ul { margin:4px 0; } .note strong { color:var(--warn); }
.static { color:var(--soft); font-size:15px; border-left:4px solid var(--line); padding:4px 16px;
  margin:14px 0; }
.grid { display:grid; grid-template-columns:repeat(2,minmax(0,1fr)); gap:16px; align-items:start; }
figure { margin:14px 0; } .grid figure { margin:0; }
.paper { background:#fff; border:1px solid var(--line); border-radius:10px; padding:10px; text-align:center;
  }
.paper img { display:block; margin:0 auto; max-width:100%; height:auto; } .wide .paper img { width:1000px; }
.half .paper img { width:100%; }
figcaption { color:var(--soft); font-size:14px; line-height:1.45; padding:7px 4px 0; max-width:92ch; }
.scroll { overflow-x:auto; margin:12px 0; background:var(--card); border:1px solid var(--line);
  border-radius:10px; }
table { border-collapse:collapse; width:100%; font-size:14.5px; font-variant-numeric:tabular-nums; }
th, td { padding:7px 13px; text-align:left; vertical-align:top; border-bottom:1px solid var(--line); }
tbody tr:last-child td { border-bottom:0; }
th { color:var(--soft); font-weight:600; font-size:13px; vertical-align:bottom; }
th.n, td.n { text-align:right; } td.n { white-space:nowrap; }
.trials td:nth-child(4) { min-width:230px; } .trials { font-size:13.5px; } .trials th, .trials td {
  padding:6px 10px; }
.compare td { font-size:16px; vertical-align:middle; } .compare td:first-child { white-space:nowrap; }
  .compare td:last-child { font-size:14px; color:var(--soft);
  min-width:150px; }
.compare tbody tr:first-child td:not(:last-child) { font-weight:650; }
.scale { width:220px; height:19px; display:block; } .scale .axis { stroke:var(--line); stroke-width:2; }
.scale .band { fill:var(--accent); opacity:.2; } .scale .ours { fill:var(--accent); }
.scale .theirs { fill:var(--card); stroke:var(--ink); stroke-width:2; }
.stable { color:var(--stable); font-weight:600; } .failed { color:var(--failed); font-weight:600; }
.undecided { color:var(--undecided); font-weight:600; }
.pairs { display:grid; grid-template-columns:repeat(auto-fill,minmax(300px,1fr)); gap:0 32px; margin:12px 0;
  }
.pairs div { display:flex; justify-content:space-between; gap:16px; border-bottom:1px solid var(--line);
  padding:6px 0; }
.pairs dt { color:var(--soft); } .pairs dd { margin:0; text-align:right; overflow-wrap:anywhere;
  font-variant-numeric:tabular-nums; }
pre, code { font:13.5px/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace; }
pre { background:var(--card); border:1px solid var(--line); border-radius:10px; padding:14px 16px;
  overflow-x:auto; margin:12px 0; }
.case .t { color:var(--accent); } .case .k { color:var(--ink); font-weight:600; } .case .c {
  color:var(--soft); font-style:italic; }
@media (max-width:760px) { .grid { grid-template-columns:1fr; } nav { justify-content:flex-start; } .scale {
  width:150px; }
  nav { position:static; } .compare td:first-child { white-space:normal; } .compare td { font-size:15px; }
  .compare th:nth-child(4), .compare td:nth-child(4) { display:none; } th, td { padding:6px 9px; } }
@media print { :root { --ink:#000; --soft:#444; --line:#ccc; --page:#fff; --card:#fff; --accent:#0b5c96;
  --warn:#6b3a00;
  --warn-card:#fff; --stable:#005a8d; --failed:#a04000; --undecided:#555; }
  nav { display:none; } body { font-size:10.5pt; } main { max-width:none; padding:0; } section {
  margin-top:20px; }
  figure, tr, .note, .pairs div { break-inside:avoid; } h2, h3 { break-after:avoid; } .scroll {
  overflow:visible; }
  table { font-size:8.5pt; } th, td { padding:3px 6px; } pre { white-space:pre-wrap; font-size:8.5pt; }
  .wide .paper img { width:100%; } @page { margin:15mm; } }
"""
