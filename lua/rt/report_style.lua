-- The style sheet of a report. Colours of curves: Okabe and Ito's palette, told apart with all kinds of colour vision; the same in gnuplot's plots.
return [=[
:root{color-scheme:light dark;--bg:#fdfdfc;--fg:#1b1f24;--soft:#59616b;--line:#d9dbde;--panel:#fff;--tint:#f2f3f4;--link:#0b5cad;
--bad:#a8201a;--badbg:#fdefee;--warn:#7a4b00;--warnbg:#fff6e3;--focus:#0b5cad;
--c1:#0072b2;--c2:#d55e00;--c3:#007f5f;--c4:#b0528b;--c5:#b07c00;--c6:#3b8fc4;--c7:#5b6470}
@media (prefers-color-scheme:dark){:root{--bg:#14171a;--fg:#e6e8ea;--soft:#a3abb3;--line:#353b41;--panel:#1b1f23;--tint:#23282d;--link:#7ab8f5;
--bad:#ff9d94;--badbg:#3a1c1a;--warn:#f0c36b;--warnbg:#352a12;--focus:#7ab8f5;
--c1:#4aa8e0;--c2:#f0803c;--c3:#2fbf97;--c4:#e08fc0;--c5:#e6b23a;--c6:#8fd0f5;--c7:#a3abb3}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;text-size-adjust:100%}
body{margin:0;background:var(--bg);color:var(--fg);font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue","Noto Sans",
"DejaVu Sans",sans-serif}
main,header.top,footer{max-width:1240px;margin:0 auto;padding:0 24px}
header.top{padding-top:36px}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 6px;font-weight:650;letter-spacing:-.01em;overflow-wrap:anywhere}
h2{font-size:1.25rem;margin:44px 0 14px;font-weight:650;padding-bottom:6px;border-bottom:1px solid var(--line)}
h3{font-size:1rem;margin:0 0 2px;font-weight:650}
p{margin:0 0 12px;max-width:78ch}
a{color:var(--link)}
.soft,.sub{color:var(--soft)}
.sub{margin-bottom:14px;max-width:none;overflow-wrap:anywhere}
nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:4px 18px;padding:0;margin:14px 0 0}
pre{background:var(--tint);border-radius:6px;padding:10px 14px;margin:0 0 12px;font:.86rem/1.5 ui-monospace,"SFMono-Regular",Menlo,Consolas,
"DejaVu Sans Mono",monospace;
white-space:pre-wrap;overflow-wrap:anywhere}
pre.command{user-select:all;-webkit-user-select:all}
code{font-family:ui-monospace,"SFMono-Regular",Menlo,Consolas,"DejaVu Sans Mono",monospace;font-size:.92em}
:focus-visible{outline:2px solid var(--focus);outline-offset:2px;border-radius:3px}
.skip{position:absolute;left:-9999px}
.skip:focus{left:12px;top:12px;background:var(--panel);padding:6px 12px;z-index:9}
.facts{display:grid;grid-template-columns:repeat(auto-fill,minmax(150px,1fr));gap:14px 24px;margin:22px 0 6px}
.facts div{border-top:2px solid var(--line);padding-top:8px}
.facts dt{color:var(--soft);font-size:.82rem}
.facts dd{margin:0;font-size:1.28rem;font-weight:600;font-variant-numeric:tabular-nums;line-height:1.3;overflow-wrap:anywhere}
.facts dd small{display:block;font-size:.8rem;font-weight:400;color:var(--soft);line-height:1.4}
.warnings{background:var(--warnbg);border-left:4px solid var(--warn);padding:10px 16px;border-radius:0 6px 6px 0;margin:20px 0}
.warnings.bad{background:var(--badbg);border-color:var(--bad)}
.warnings ul{margin:4px 0;padding-left:20px}
.warnings li{overflow-wrap:anywhere;margin:3px 0}
.warnings strong{color:var(--warn)}.warnings.bad strong{color:var(--bad)}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,380px),1fr));gap:22px}
figure{margin:0;background:var(--panel);border:1px solid var(--line);border-radius:8px;padding:14px 14px 12px;min-width:0;break-inside:avoid}
figcaption{font-size:.88rem;color:var(--soft);margin-top:4px;overflow-wrap:anywhere}
.legend{list-style:none;display:flex;flex-wrap:wrap;gap:2px 16px;margin:6px 0 4px;padding:0;font-size:.88rem}
.legend li{display:flex;align-items:center;gap:6px;min-width:0;overflow-wrap:anywhere}
.sample{flex:none}
svg.chart{display:block;width:100%;height:auto;max-width:640px;font-family:inherit}
.chart text{fill:var(--fg);font-variant-numeric:tabular-nums}
.chart text.on-light{fill:#000}.chart text.on-dark{fill:#fff}
.chart text.tick{fill:var(--soft);font-size:12px}
.chart text.name{font-size:13px}
.chart text.note{fill:var(--soft);font-size:11.5px}.chart text.strong{fill:var(--fg);font-size:12.5px}
.grid{stroke:var(--line);stroke-width:1}.axis{stroke:var(--soft);stroke-width:1}
.over{fill:var(--tint)}.none{fill:var(--tint)}
.curve{fill:none;stroke-width:2;stroke:currentColor;stroke-linejoin:round}.dashed{stroke-dasharray:7 4}
.bar{fill:none;stroke:currentColor;stroke-width:1.3}
.mark{fill:currentColor;stroke:currentColor;stroke-width:1.6}.mark.hollow{fill:var(--panel)}
.ideal{fill:none;stroke:var(--soft);stroke-width:1.5;stroke-dasharray:2 4;stroke-linecap:round}
.busy{fill:var(--c1)}.busy.hollow{fill:none;stroke:var(--c1);stroke-width:1.2}.wall{stroke:var(--c2);stroke-width:2}
.c1{color:var(--c1)}.c2{color:var(--c2)}.c3{color:var(--c3)}.c4{color:var(--c4)}.c5{color:var(--c5)}.c6{color:var(--c6)}.c7{color:var(--c7)}
.scroll{overflow-x:auto;border:1px solid var(--line);border-radius:8px;background:var(--panel);max-height:82vh;overflow-y:auto}
table{border-collapse:separate;border-spacing:0;width:100%;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:6px 12px;text-align:left;border-bottom:1px solid var(--line);vertical-align:top;white-space:nowrap}
tbody tr:last-child td,tbody tr:last-child th{border-bottom:0}
tbody th{font-weight:400}
td.n,th.n{text-align:right}
.star{display:inline-block;width:0}
td.n small{display:block;color:var(--soft);font-size:.78rem}
.wrap th{white-space:normal;min-width:6em}.wrap td{white-space:normal}
td.words{white-space:normal;overflow-wrap:anywhere;min-width:9em;unicode-bidi:isolate}
thead th{position:sticky;top:0;background:var(--tint);font-weight:600;z-index:1}
thead th .unit{font-weight:400;color:var(--soft)}
thead th[aria-sort]{padding:0}
thead th button{all:unset;display:block;box-sizing:border-box;width:100%;padding:6px 12px;cursor:pointer;white-space:nowrap}
thead th button:hover{color:var(--link)}
thead th button:focus-visible{outline:2px solid var(--focus);outline-offset:-2px}
th[aria-sort] button::after{content:"\2195";opacity:.4;margin-left:.35em}
th[aria-sort=ascending] button::after{content:"\2191";opacity:1}th[aria-sort=descending] button::after{content:"\2193";opacity:1}
tbody tr:hover td,tbody tr:hover th{background:var(--tint)}
tr.failed td,tr.failed th{color:var(--bad)}
.tag{font-size:.78rem;border:1px solid currentColor;border-radius:9px;padding:0 7px;white-space:nowrap}
.tools{display:flex;flex-wrap:wrap;gap:10px 20px;align-items:end;margin:0 0 12px}
.tools label{font-size:.86rem;color:var(--soft);display:flex;flex-direction:column;gap:2px;min-width:0}
table.few .more{display:none}
.tools label.row{flex-direction:row;align-items:center;gap:6px}
.tools output{font-size:.86rem;color:var(--soft)}
input,select,button.plain{font:inherit;color:inherit;background:var(--panel);border:1px solid var(--soft);border-radius:6px;padding:5px 9px;
max-width:100%}
input[type=range]{padding:0;accent-color:var(--link);width:200px}
select{width:min(100%,340px)}
button.plain{cursor:pointer}
fieldset{border:0;padding:0;margin:0;display:flex;flex-wrap:wrap;gap:4px 14px;font-size:.9rem}
legend{font-size:.86rem;color:var(--soft);padding:0;float:left;width:100%}
.tools fieldset label{flex-direction:row;align-items:center;gap:5px;color:var(--fg)}
fieldset input{accent-color:var(--link)}
.stage{display:grid;gap:12px;grid-template-columns:1fr;max-width:1000px}
.stage.side{grid-template-columns:repeat(auto-fit,minmax(min(100%,300px),1fr));max-width:none}
.pane{position:relative;background:#808080;border-radius:4px;overflow:hidden;touch-action:pan-y;isolation:isolate}
.pane img{display:block;width:100%;height:auto;image-rendering:auto}
.pane img.small{image-rendering:pixelated}
.pane .over-image{position:absolute;inset:0;width:100%;height:100%;object-fit:contain}
.pane.slide{cursor:ew-resize}
.pane.difference{background:#000}.pane.difference .over-image{mix-blend-mode:difference}
.divider{position:absolute;top:0;bottom:0;width:2px;background:#fff;box-shadow:0 0 0 1px #0008;pointer-events:none}
.corner{position:absolute;top:8px;padding:1px 8px;background:#000b;color:#fff;font-size:.8rem;border-radius:4px;max-width:46%;overflow:hidden;
text-overflow:ellipsis;white-space:nowrap}
.corner.a{left:8px}.corner.b{right:8px}
.gallery{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,190px),1fr));gap:18px 16px;margin-top:16px;padding:0;list-style:none}
.gallery img{display:block;width:100%;height:auto;background:var(--tint);border-radius:4px}
.gallery img.small{image-rendering:pixelated}
.gallery .cap{font-size:.82rem;line-height:1.4;margin-top:4px;overflow-wrap:anywhere}
.gallery .pick{display:flex;gap:6px;margin-top:4px}
.gallery .pick button{font-size:.78rem;padding:1px 9px}
dl.machine{display:grid;grid-template-columns:minmax(120px,max-content) 1fr;gap:4px 20px;margin:0;font-size:.92rem}
dl.machine dt{color:var(--soft)}dl.machine dd{margin:0;overflow-wrap:anywhere}
details{margin:10px 0}summary{cursor:pointer}
footer{color:var(--soft);font-size:.86rem;padding-top:30px;padding-bottom:40px;margin-top:40px;border-top:1px solid var(--line)}
[hidden]{display:none!important}
@media (max-width:560px){main,header.top,footer{padding-left:14px;padding-right:14px}header.top{padding-top:20px}h1{font-size:1.5rem}
th,td{padding:5px 9px}thead th button{padding:5px 9px}figure{padding:10px 8px}.gallery{grid-template-columns:repeat(auto-fill,minmax(140px,1fr))}
dl.machine{grid-template-columns:1fr}dl.machine dd{margin-bottom:6px}}
@media print{:root{color-scheme:light;--bg:#fff;--fg:#000;--soft:#444;--line:#bbb;--panel:#fff;--tint:#f2f2f2;--link:#000}
@page{margin:13mm 12mm}
body{font-size:9.5pt;line-height:1.4}main,header.top,footer{padding:0;max-width:none}header.top{padding-top:0}
nav,.tools,.compare,.skip,.pick{display:none!important}
h1{font-size:17pt}h2{font-size:12.5pt;margin:20px 0 8px}h2,h3{break-after:avoid}h3{font-size:9.5pt}
.facts{gap:8px 18px;margin:12px 0 4px;grid-template-columns:repeat(5,1fr)}.facts dd{font-size:11.5pt}.warnings{margin:10px 0;break-inside:avoid}
pre,.gallery li,.facts div{break-inside:avoid}
.plots{grid-template-columns:1fr 1fr;gap:10px}figure{padding:8px}figcaption,.legend{font-size:7.5pt;line-height:1.3}.legend{gap:0 10px}
svg.chart{max-width:none}.gallery{grid-template-columns:repeat(4,1fr);gap:10px;margin-top:8px}.gallery .cap{font-size:7.5pt}
.scroll{max-height:none;overflow:visible;border:0}table{font-size:7.5pt}.more{display:none}
th,td{padding:2px 5px;white-space:normal}td.n,td.n small{white-space:nowrap}td.n small{font-size:6.5pt}
thead{display:table-header-group}thead th{position:static}tr{break-inside:avoid}
thead th[aria-sort]{padding:2px 4px}thead th button{display:contents}th[aria-sort] button::after{content:none}
dl.machine{font-size:8.5pt}footer{margin-top:16px;padding:8px 0 0}}
]=]
