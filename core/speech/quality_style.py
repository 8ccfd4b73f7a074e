"""How the speech quality report looks, on a screen and on paper."""

STYLE = """
:root{--ink:#1d2329;--soft:#5c6873;--line:#d9dfe4;--paper:#fff;--ground:#f3f5f7;--accent:#0b6bcb;
--wrong:#ffe066;--lost:#c92a2a;--more:#2b8a3e}
@media(prefers-color-scheme:dark){:root{--ink:#e6eaee;--soft:#9aa7b2;--line:#343d46;--paper:#1b2127;--ground:#12161a;
--accent:#6cb2f7;--wrong:#8a6d00;--lost:#ff8787;--more:#69db7c}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:60rem;margin:2rem auto;padding:2rem 2.5rem;background:var(--paper);border-radius:12px}
h1{margin:0;font-size:1.9rem;letter-spacing:-.01em}
header p,.note{color:var(--soft);margin:.3rem 0 0}
.note{font-size:.875rem}
section{margin-top:2rem}
section>h2{font-size:1.1rem;margin:0 0 .6rem}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(11rem,1fr));gap:1rem}
.tiles div{border:1px solid var(--line);border-radius:10px;padding:1rem}
.tiles h2{font-size:.875rem;font-weight:500;color:var(--soft);margin:0}
.tiles b{display:block;font-size:2.2rem;line-height:1.2;font-variant-numeric:tabular-nums}
.tiles sub{line-height:0}
.tiles small{color:var(--soft)}
.verdict{margin:1.2rem 0 0;font-size:1.1rem;font-weight:600;color:var(--accent)}
table{width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.4rem .6rem;border-bottom:1px solid var(--line);vertical-align:top;font-weight:400}
thead th{color:var(--soft);font-size:.875rem}
.numbers td,.numbers thead th{text-align:right}
.numbers th:first-child{text-align:left}
.texts td{width:33.3%}
.measures th{width:10rem;color:var(--soft)}
.measures td:nth-child(2){white-space:nowrap;font-weight:600}
mark{background:var(--wrong);color:inherit;border-radius:3px;padding:0 .2em}
del{color:var(--lost)}
ins{color:var(--more);text-decoration:none;border-bottom:2px solid}
figure{margin:1rem 0 0}
figcaption{color:var(--soft);font-size:.875rem}
img{display:block;width:100%;border-radius:6px}
@media(max-width:40rem){main{margin:0;padding:1.2rem;border-radius:0}.texts td{width:auto}}
@media print{body{background:#fff;color:#000}main{margin:0;padding:0;max-width:none}
section{break-inside:avoid}.texts tr{break-inside:avoid}mark,img{print-color-adjust:exact}}
"""
