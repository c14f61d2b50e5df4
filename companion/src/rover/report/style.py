"""The report's style sheet: light, printable, readable on a telephone in the sun."""

STYLE = """
:root { color-scheme: light; --ink: #22262a; --faint: #5d656c; --line: #d9dde0; --paper: #fff; --soft: #f5f6f7;
  --note: #1f5f99; --warn: #8a5a00; --alarm: #b3161d; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 1rem 1.25rem 4rem; }
h1 { font-size: 1.05rem; font-weight: 600; margin: 0 0 .6rem; color: var(--faint); }
h1 strong { color: var(--ink); }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; padding-bottom: .25rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
p { margin: .4rem 0; max-width: 46rem; }
ul { margin: .4rem 0; padding-left: 1.2rem; max-width: 46rem; }
li { margin: .25rem 0; }
.faint { color: var(--faint); font-size: .92rem; }
.status { border-left: .55rem solid var(--note); background: #eef4fa; padding: .9rem 1.1rem; margin: 0 0 1rem; }
.status b { display: block; font-size: 1.9rem; line-height: 1.15; color: var(--note); }
.status span { font-size: 1.1rem; }
.status.warn { border-color: #d79212; background: #fdf6e7; } .status.warn b { color: var(--warn); }
.status.alarm { border-color: var(--alarm); background: #fdeeee; } .status.alarm b { color: var(--alarm); }
.simulated { border: 2px dashed var(--alarm); color: var(--alarm); font-weight: 600; padding: .45rem .8rem;
  margin: 0 0 1rem; max-width: none; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.2rem, 1fr)); gap: .6rem; margin: 0; }
.figures div { background: var(--soft); border-radius: .4rem; padding: .6rem .8rem; display: flex;
  flex-direction: column-reverse; justify-content: flex-end; }
.figures dt { color: var(--faint); font-size: .88rem; line-height: 1.3; }
.figures dd { margin: 0; font-size: 1.6rem; font-weight: 650; line-height: 1.2; font-variant-numeric: tabular-nums; }
.map { display: block; width: 100%; height: auto; border: 1px solid var(--line); border-radius: .4rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .95rem; }
th { text-align: left; font-weight: 600; color: var(--faint); font-size: .85rem; }
th, td { padding: .45rem .7rem .45rem 0; border-bottom: 1px solid var(--line); vertical-align: middle; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.id { font-size: 1.25rem; font-weight: 700; color: var(--alarm); }
.visits { display: flex; flex-wrap: wrap; gap: 1rem; }
.visits figure { margin: 0; flex: 1 1 15rem; max-width: 24rem; }
.visit { display: block; width: 100%; }
.thumbnail { display: block; width: 5.2rem; height: 5.2rem; border-radius: .25rem; }
.bad { color: var(--alarm); font-weight: 700; }
.good { font-weight: 600; }
.total td { font-weight: 650; border-top: 2px solid var(--ink); }
.pairs { margin: .4rem 0; max-width: 46rem; }
.pairs div { display: flex; justify-content: space-between; gap: 1.5rem; padding: .28rem 0;
  border-bottom: 1px solid var(--line); }
.pairs dt { color: var(--faint); }
.pairs dd { margin: 0; text-align: right; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.limits { background: #fdf6e7; border-left: .35rem solid #d79212; padding: .5rem 1.1rem; }
details { margin: .8rem 0; } summary { cursor: pointer; font-weight: 600; }
.wall { border: 1px dotted var(--faint); padding: .5rem .8rem; color: var(--faint); font-size: .92rem; }
@media (max-width: 40rem) {
  main { padding: .8rem .8rem 3rem; }
  .status b { font-size: 1.5rem; }
  .figures { grid-template-columns: 1fr 1fr; }
  .indications thead { display: none; }
  .indications tr { display: grid; grid-template-columns: 5.8rem 1fr 1fr; column-gap: .6rem; padding: .6rem 0;
    border-bottom: 1px solid var(--line); }
  .indications td { border: 0; padding: .1rem 0; text-align: left; white-space: normal; }
  .indications td::before { content: attr(data-title) " "; color: var(--faint); font-size: .82rem; }
  .indications td:nth-child(1), .indications td:nth-child(2) { grid-column: 1; }
  .indications td:nth-child(2) { grid-row: 2 / span 4; }
  .indications td:nth-child(3), .indications td:last-child { grid-column: 2 / span 2; }
}
@page { size: A4; margin: 16mm 15mm 18mm;
  @bottom-left { content: string(title); font: 8pt sans-serif; color: #5d656c; }
  @bottom-right { content: counter(page) " / " counter(pages); font: 8pt sans-serif; color: #5d656c; } }
@media print {
  h1 { string-set: title content(); } .figures { grid-template-columns: repeat(4, 1fr); }
  body { font-size: 10.5pt; } main { max-width: none; padding: 0; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h2 { break-after: avoid; } tr, .status, .figures div, .limits { break-inside: avoid; }
  .map { max-height: 17cm; width: auto; max-width: 100%; margin: 0 auto; }
  details::details-content { content-visibility: visible; height: auto; }
}
"""
