// The look of a player inside its own shadow root; colours of the page around are taken where it names them.

export const STYLE = `
:host { display: block; container-type: inline-size; }
:host(.fill) { display: flex; flex-direction: column; flex: 1; }
.fill { display: flex; flex-direction: column; flex: 1; }
.fill .view { display: grid; grid-template-rows: minmax(240px, 1fr); flex: 1; }
.fill .stage { height: auto; align-self: stretch; }
.player {
  --ink: var(--text, #1b1f27); --faint: var(--quiet, #5c6370); --rule: var(--line, #d9dce2); --lead: var(--accent, #1f6f54);
  --paper: var(--card, #ffffff); --safe: #2f9e6e; --clash: #d1202f; --mountain: #d1202f; --valley: #1c5fd4; --flat: #6a4fc0; --slit: #20242e;
  color: var(--ink); font: 14px/1.45 system-ui, sans-serif; text-align: left;
}
.dark {
  --ink: var(--text, #e7e9ee); --faint: var(--quiet, #a2a9b6); --rule: var(--line, #343a45); --lead: var(--accent, #63c9a2);
  --paper: var(--card, #1d2128); --safe: #4fc08d; --clash: #ff6a5e; --mountain: #ff5c5c; --valley: #5b9dff; --flat: #a690f2; --slit: #0d0f13;
}
* { box-sizing: border-box; }
[hidden] { display: none !important; }
.view { position: relative; }
.stage { position: relative; height: var(--stage, clamp(300px, 56cqi, 560px)); border: 1px solid var(--rule); border-radius: 10px;
  background: radial-gradient(ellipse at 50% 35%, color-mix(in srgb, var(--paper) 96%, var(--ink)), color-mix(in srgb, var(--paper) 88%, var(--ink)));
  cursor: grab; touch-action: pan-y; overflow: hidden; user-select: none; -webkit-user-select: none; }
.stage:active { cursor: grabbing; }
.stage canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
.tag { position: absolute; left: 8px; top: 8px; max-width: calc(100% - 16px); margin: 0; font-size: 13px; pointer-events: none; font-variant-numeric: tabular-nums; }
.tag > * { display: table; padding: 2px 8px; border-radius: 6px; background: color-mix(in srgb, var(--paper) 78%, transparent); }
.tag > :empty { display: none; }
.tag strong { color: var(--clash); font-weight: 600; }
.corner { position: absolute; right: 8px; bottom: 8px; display: flex; gap: 4px; }
button, select { font: inherit; color: inherit; background: var(--paper); border: 1px solid var(--rule); border-radius: 7px; cursor: pointer; min-height: 32px; padding: 0 9px; }
button:hover, select:hover { border-color: var(--lead); }
.corner button { width: 34px; padding: 0; font-size: 16px; line-height: 1; }
:focus-visible { outline: 2px solid var(--lead); outline-offset: 2px; }
.bar { display: flex; align-items: center; gap: 12px; margin-top: 10px; }
.go { flex: none; width: 44px; height: 40px; padding: 0; color: var(--paper); background: var(--lead); border-color: transparent; }
.go svg { display: block; width: 18px; height: 18px; margin: auto; fill: currentColor; }
.slider { position: relative; flex: 1; min-width: 0; height: 40px; }
.track { position: absolute; left: 9px; right: 9px; top: 17px; height: 6px; border-radius: 3px; background: var(--rule); }
.track i { position: absolute; top: 0; bottom: 0; border-radius: 3px; background: var(--safe); }
.track b { position: absolute; top: -7px; bottom: -7px; width: 3px; margin-left: -1.5px; border-radius: 2px; background: var(--clash); }
input[type="range"] { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; background: none; appearance: none; -webkit-appearance: none; cursor: pointer; border-radius: 6px; }
input[type="range"]::-webkit-slider-runnable-track { background: none; height: 18px; }
input[type="range"]::-moz-range-track { background: none; height: 18px; }
input[type="range"]::-webkit-slider-thumb { -webkit-appearance: none; width: 18px; height: 18px; border-radius: 50%; background: var(--paper); border: 3px solid var(--lead); }
input[type="range"]::-moz-range-thumb { width: 12px; height: 12px; border-radius: 50%; background: var(--paper); border: 3px solid var(--lead); }
.place { flex: none; min-width: 5.5em; text-align: right; font-variant-numeric: tabular-nums; font-weight: 600; }
.tools { display: flex; flex-wrap: wrap; align-items: center; gap: 8px 18px; margin-top: 8px; color: var(--faint); font-size: 13px; }
.tools label { display: flex; align-items: center; gap: 7px; min-height: 32px; }
.tools select, .tools button { color: var(--ink); }
.looks { display: flex; gap: 4px; }
.key { display: flex; flex-wrap: wrap; gap: 2px 14px; margin: 8px 0 0; padding: 0; list-style: none; color: var(--faint); font-size: 12.5px; }
.key li { display: flex; align-items: center; gap: 6px; }
.key i { width: 18px; height: 4px; border-radius: 2px; }
.key .mountain { background: var(--mountain); } .key .valley { background: var(--valley); } .key .flat { background: var(--flat); }
.key .slit { background: var(--slit); box-shadow: 0 0 0 1px var(--faint); } .key .safe { background: var(--safe); } .key .clash { background: var(--clash); width: 3px; height: 14px; }
.source { margin: 8px 0 0; color: var(--faint); font-size: 12.5px; max-width: 90ch; overflow-wrap: anywhere; }
.stills { display: none; }
@container (max-width: 520px) {
  .bar { gap: 8px; } .place { min-width: 4.6em; }
  .view { display: grid; grid-template-columns: 1fr auto; gap: 8px; align-items: start; }
  .fill .view { grid-template-rows: minmax(240px, 1fr) auto; }
  .stage { grid-column: 1 / 3; }
  .tag, .corner { position: static; }
  .tag { min-height: 3em; }
  .tag > * { padding: 0; background: none; }

  .corner button, button, select { min-height: 38px; } .corner button { width: 40px; } .go { width: 46px; height: 44px; }
}
@media print {
  .view, .fill .view, .bar, .tools, .of-clash { display: none; }
  .stills { display: grid; grid-template-columns: repeat(5, 1fr); gap: 6px; padding-right: 2px; break-inside: avoid; }
  .stills figure { margin: 0; min-width: 0; }
  .stills canvas { display: block; width: 100%; border: 1px solid #bbbbbb; border-radius: 4px; }
  .stills figcaption { font-size: 9px; line-height: 1.3; color: #444444; }
  .key, .source { font-size: 9px; margin-top: 4px; }
  .key i { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .player { --ink: #000000; --faint: #444444; --paper: #ffffff; break-inside: avoid; }
}
`;
