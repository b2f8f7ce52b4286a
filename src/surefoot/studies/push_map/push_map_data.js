// Unpacks the map, and says what its numbers mean.
"use strict";

const pushMap = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = (text) => new DataView(bytes(text).buffer);
  const { phases, angles, step } = data;
  const count = view(data.count);
  const gap = bytes(data.gap);
  const code = bytes(data.code);
  const margin = view(data.margin);
  const RECOVERED = 0;
  const fates = ["recovered", "did not settle", "fell"];

  // ---- cells ----
  const cells = [];
  let at = 0;
  for (let index = 0; index < phases.length * angles.length; index += 1) {
    const walks = [];
    let number = 0;
    for (let walk = 0; walk < count.getUint16(2 * index, true); walk += 1, at += 1) {
      number += gap[at];
      const steps = code[at] & 63;
      const tenths = margin.getInt16(2 * at, true);
      walks.push({
        number, impulse: number * step, fate: code[at] >> 6, steps: steps === 63 ? NaN : steps,
        margin: tenths === -32768 ? NaN : tenths / 1e4,
      });
    }
    const failing = walks.findIndex((walk) => walk.fate !== RECOVERED);
    const limit = data.limit[index];
    const survived = failing < 0 ? walks.at(-1).impulse : Math.max(walks[failing].impulse - step, 0);
    cells.push({
      phase: Math.floor(index / angles.length), angle: index % angles.length, walks, limit,
      causal: data.causal[index], fixed: data.fixed[index], survived, failing: failing < 0 ? null : walks[failing],
      share: limit > 0 ? Math.min(survived / limit, 1) : NaN,
      hole: failing >= 0 && walks.slice(failing).some((walk) => walk.fate === RECOVERED),
    });
  }
  const cellAt = (phase, angle) => cells[phase * angles.length + angle];

  /** The walk of a cell at an impulse, or the closest one below; null above the last. */
  function walkAt(cell, number) {
    if (number > cell.walks.at(-1).number) return null;
    let found = cell.walks[0];
    for (const walk of cell.walks) {
      if (walk.number > number) break;
      found = walk;
    }
    return found;
  }

  // ---- what may be coloured ----
  const under = (name) => (cell, number) => {
    const walk = walkAt(cell, number);
    return walk === null || walk.fate !== RECOVERED ? NaN : walk[name];
  };
  const percent = (share) => `${Math.round(100 * share)} %`;
  const plain = (value, digits = 3) => String(Number(value.toPrecision(digits)));
  const shows = {
    survived: { words: "Largest survived impulse", unit: "N s", value: (cell) => cell.survived, text: (v) => plain(v, 4) },
    share: { words: "Share of the theoretical limit", unit: "%", value: (cell) => 100 * cell.share, text: (v) => plain(v) },
    steps: { words: "Steps to recover", unit: "steps", value: under("steps"), text: String, whole: true, moves: true },
    margin: { words: "Margin", unit: "cm", value: (cell, number) => 100 * under("margin")(cell, number), text: (v) => plain(v), moves: true },
  };
  const ranges = {};
  for (const key of Object.keys(shows)) {
    let [least, most] = [Infinity, -Infinity];
    const see = (value) => {
      if (value < least) least = value;
      if (value > most) most = value;
    };
    for (const cell of cells) {
      if (key === "survived" || key === "share") see(shows[key].value(cell));
      else
        for (const walk of cell.walks)
          if (walk.fate === RECOVERED) see(key === "steps" ? walk.steps : 100 * walk.margin);
    }
    if (!(least <= most)) [least, most] = [0, 1];
    ranges[key] = least === most ? [least - 1, most + 1] : [least, most];
    // Of less than a tenth of the limit, the steps of the scan are a good part.
    if (key === "share") ranges[key] = [Math.min(least, 90), 100];
  }

  // Viridis, from the least to the most: even in lightness, distinct for every colour vision.
  const colours = [
    "#440154", "#48186a", "#472d7b", "#424086", "#3b528b", "#33638d", "#2c728e", "#26828e", "#21918c", "#1fa088",
    "#28ae80", "#3fbc73", "#5ec962", "#84d44b", "#addc30", "#d8e219", "#fde725",
  ];

  // ---- words ----
  const names = Object.entries(data.directions);
  const angleWords = (angle) => {
    const name = names.find(([, value]) => Math.abs(value - angle) < 1e-6);
    return name ? `${name[0]} (${plain(angle)}°)` : `${plain(angle, 4)}°`;
  };
  const pushWords = (angle) => (angleWords(angle).includes("(") ? angleWords(angle) : `towards ${angleWords(angle)}`);
  const newtons = (value) => `${plain(value, 4)}\u00a0N\u00a0s`;
  function describe(cell, number) {
    const where = `Pushed ${pushWords(angles[cell.angle])} at ${plain(phases[cell.phase])} of the step`;
    const most = cell.failing === null
      ? `nothing failed up to ${newtons(cell.survived)}`
      : `it survives ${newtons(cell.survived)} and ${cell.failing.fate === 2 ? "falls" : "does not settle"} at ${newtons(cell.failing.impulse)}`;
    const share = Number.isNaN(cell.share) ? "" : `; the limit is ${newtons(Number(cell.limit.toFixed(1)))}, which makes ${percent(cell.share)}`;
    const walk = walkAt(cell, number);
    let then = ` ${newtons(number * step)} is above what was tried here.`;
    if (walk !== null) {
      const after = walk.fate === RECOVERED
        ? `recovers within ${walk.steps} step${walk.steps === 1 ? "" : "s"}, with a margin of ${plain(100 * walk.margin)} cm`
        : ["", "does not settle", "falls"][walk.fate];
      then = ` Under ${newtons(walk.impulse)} it ${after}.`;
    }
    return `${where}, ${most}${share}.${cell.hole ? " A harder push than that is survived again." : ""}${then}`;
  }

  const top = Math.max(...cells.map((cell) => Math.max(cell.limit, cell.walks.at(-1).impulse)));
  const state = { show: "survived", phase: 0, angle: 0, number: 0 };
  return {
    data, phases, angles, step, cells, cellAt, walkAt, shows, ranges, colours, angleWords, pushWords, newtons, percent,
    plain, describe, top, state, fates, RECOVERED,
    stride: Math.max(1, Math.round(data.coarse / step)),
  };
})();
