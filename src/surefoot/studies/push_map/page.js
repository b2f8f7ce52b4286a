// Draws the map, the scan of one cell and the polar map of its phase, and says what was measured there.
"use strict";

(() => {
  const {
    data, angles, state, byId, plain, percent, shape, ticks, path, placeOf, showTip, point, around, drawPolar, wordsOf,
    choose, refresh, start,
  } = page;
  const { step, top } = data;
  const phases = data.choices.phase.values;
  const impulses = data.choices.impulse.values;
  const RECOVERED = 0;
  const UNSETTLED = 1;
  const FELL = 2;
  const classes = ["recovered", "unsettled", "fell"];
  const fates = ["recovered", "did not settle", "fell"];
  let rects = [];
  let places = {};

  // ---- cells and their walks ----
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = (text) => new DataView(bytes(text).buffer);
  const [count, gap, code, margin] = [view(data.count), bytes(data.gap), bytes(data.code), view(data.margin)];
  let at = 0;
  function walksOf(index) {
    const walks = [];
    let number = 0;
    for (let walk = 0; walk < count.getUint16(2 * index, true); walk += 1, at += 1) {
      number += gap[at];
      const [steps, tenths] = [code[at] & 63, margin.getInt16(2 * at, true)];
      walks.push({
        impulse: number * step, fate: code[at] >> 6, steps: steps === 63 ? NaN : steps,
        margin: tenths === -32768 ? NaN : tenths / 100,
      });
    }
    return walks;
  }
  const cells = data.limit.map((limit, index) => ({
    phase: Math.floor(index / angles.length), angle: index % angles.length, walks: walksOf(index), limit,
    causal: data.limit_causal[index], fixed: data.limit_fixed[index], survived: data.survived[index],
    share: data.share[index], hole: data.holes[index] > 0,
  }));
  const cellAt = (phase, angle) => cells[phase * angles.length + angle];
  const chosen = () => cellAt(state.phase, state.angle);
  const pushed = () => impulses[state.impulse];
  /** The walk of a cell at an impulse, or the closest one below; undefined above the last. */
  const walkAt = (cell, impulse) =>
    impulse > cell.walks.at(-1).impulse + 1e-9 ? undefined : cell.walks.findLast((walk) => walk.impulse <= impulse + 1e-9);
  /** What colours a cell; `per walk` it depends on the impulse. */
  const shown = () => data.shows[state.show];
  function valueOf(cell) {
    const { key, per_walk: perWalk, factor } = shown();
    const walk = perWalk ? walkAt(cell, pushed()) : null;
    if (perWalk && walk?.fate !== RECOVERED) return NaN;
    return perWalk ? walk[key] : factor * cell[key];
  }

  // ---- words ----
  const newtons = (value) => `${plain(value, 4)}\u00a0N\u00a0s`;
  const limitWords = (cell) => newtons(Number(cell.limit.toFixed(1)));
  const pushWords = (angle) => `${data.choices.angle.words[angle].includes("(") ? "" : "towards "}${data.choices.angle.words[angle]}`;
  function describe(cell) {
    const failing = cell.walks.find((walk) => walk.fate !== RECOVERED);
    const scan = failing
      ? `it survives ${newtons(cell.survived)} and ${failing.fate === FELL ? "falls" : "does not settle"} at ${newtons(failing.impulse)}`
      : `nothing failed up to ${newtons(cell.survived)}`;
    const share = Number.isNaN(cell.share) ? "" : `; the limit is ${limitWords(cell)}, which makes ${percent(cell.share)}`;
    const hole = cell.hole ? " A harder push than that is survived again." : "";
    const walk = walkAt(cell, pushed());
    const steps = `${walk?.steps} step${walk?.steps === 1 ? "" : "s"}`;
    const then = walk && [`recovers within ${steps}, with a margin of ${plain(walk.margin)} cm`, "does not settle", "falls"][walk.fate];
    return `Pushed ${pushWords(cell.angle)} at ${plain(phases[cell.phase])} of the step, ${scan}${share}.${hole}` +
      (walk ? ` Under ${newtons(walk.impulse)} it ${then}.` : ` ${newtons(pushed())} is above what was tried here.`);
  }
  function tipLines(cell) {
    const share = Number.isNaN(cell.share) ? "" : `, ${percent(cell.share)} of the limit`;
    const lines = [
      `${data.choices.angle.words[cell.angle]}, ${plain(phases[cell.phase])} of the step`,
      `survives ${newtons(cell.survived)}${share}`,
    ];
    const { per_walk: perWalk, words, unit, whole } = shown();
    const value = valueOf(cell);
    const said = pushed() > cell.limit ? "above the limit"
      : Number.isNaN(value) ? fates[walkAt(cell, pushed()).fate]
      : `${words.toLowerCase()} ${plain(value)}${whole ? "" : ` ${unit}`}`;
    return perWalk ? [...lines, `${newtons(pushed())}: ${said}`] : lines;
  }

  // ---- pictures ----
  function fresh(id, height) {
    const picture = byId(id);
    const width = Math.max(280, Math.round(picture.clientWidth) || 640);
    picture.setAttribute("viewBox", `0 0 ${width} ${height(width)}`);
    picture.replaceChildren();
    return [picture, width, height(width)];
  }
  const scaled = ([min, max], [from, to]) => (value) => from + ((value - min) / (max - min)) * (to - from);
  function mark(picture, x, y, text, kind) {
    shape(picture, "text", { x, y, class: `label ${kind}` }, text);
  }

  // ---- the heat map ----
  function layMap() {
    const [picture, width, height] = fresh("map", (wide) => Math.round(Math.min(460, Math.max(240, 0.58 * wide))));
    const x = scaled([0, angles.length], [44, width - 6]);
    const y = scaled([0, phases.length], [height - 40, 8]);
    const size = { width: x(1) - x(0) + 0.3, height: y(0) - y(1) + 0.3 };
    places = { x, y, size };
    rects = cells.map((cell) => shape(picture, "rect", { x: x(cell.angle), y: y(cell.phase + 1), ...size }));
    for (const cell of cells.filter((one) => one.hole))
      shape(picture, "text", { x: x(cell.angle + 0.5), y: y(cell.phase + 0.5), class: "hole" }, "×");
    for (const [name, angle] of Object.entries(data.directions)) {
      const middle = x((angle / 360) * angles.length + 0.5);
      shape(picture, "line", { x1: middle, x2: middle, y1: y(0), y2: y(0) + 5, class: "tick" });
      mark(picture, Math.max(middle, 24), y(0) + 17, name, "middle");
      mark(picture, Math.max(middle, 24), y(0) + 32, `${angle}°`, "middle quietly");
    }
    for (const tick of ticks(0, 1 - 0.6 / phases.length, 5)) mark(picture, 38, y(tick * phases.length + 0.5) + 4, plain(tick), "end");
    const middle = `translate(11,${y(0.5 * phases.length)}) rotate(-90)`;
    shape(picture, "text", { transform: middle, class: "label middle quietly" }, "phase of the step");
    shape(picture, "rect", { class: "pick", id: "pick" });
  }
  function colourOf(value, [min, max]) {
    const { colours } = data;
    const place = Math.min(1, Math.max(0, (value - min) / (max - min))) * (colours.length - 1);
    const below = Math.min(Math.floor(place), colours.length - 2);
    const [from, to] = [below, below + 1].map((index) => [1, 3, 5].map((i) => parseInt(colours[index].slice(i, i + 2), 16)));
    return `rgb(${from.map((v, i) => Math.round(v + (place - below) * (to[i] - v))).join(",")})`;
  }
  function colourMap() {
    const { words, unit, range, per_walk: perWalk } = shown();
    cells.forEach((cell, index) => {
      const value = valueOf(cell);
      const unsettled = walkAt(cell, pushed())?.fate === UNSETTLED ? " unsettled" : "";
      const lost = perWalk && pushed() > cell.limit ? " beyond" : ` lost${unsettled}`;
      rects[index].setAttribute("class", `cell${Number.isNaN(value) ? lost : ""}`);
      rects[index].setAttribute("fill", Number.isNaN(value) ? "none" : colourOf(value, range));
    });
    const { x, y, size } = places;
    const frame = { x: x(state.angle) - 1, y: y(state.phase + 1) - 1, width: size.width + 2, height: size.height + 2 };
    for (const [key, value] of Object.entries(frame)) byId("pick").setAttribute(key, value.toFixed(1));
    byId("map-caption").textContent = `${words}${perWalk ? ` under ${newtons(pushed())}` : ""} [${unit}], by direction and phase of the push.` +
      (perWalk ? " Dark grey: it falls; amber: it does not settle; pale: above the limit." : "");
  }
  function drawScale() {
    const { unit, range, whole } = shown();
    const [picture, width] = fresh("scale", () => 44);
    const x = scaled(range, [44, width - 6]);
    picture.style.background = `linear-gradient(to right, ${data.colours}) 44px 6px / ${width - 50}px 12px no-repeat`;
    for (const tick of ticks(...range, width < 420 ? 4 : 7)) {
      if (whole && !Number.isInteger(tick)) continue;
      shape(picture, "line", { x1: x(tick), x2: x(tick), y1: 18, y2: 22, class: "tick" });
      mark(picture, Math.min(x(tick), width - 12), 35, plain(tick, 4), "middle");
    }
    mark(picture, 2, 17, unit, "quietly");
  }

  // ---- the scan of one cell ----
  function drawQuantity(picture, x, { key, heading, range, whole }, [above, below], walks) {
    const [min, max] = [Math.min(0, range[0]), range[1]];
    const y = scaled([min, max], [below, above]);
    const [left, right] = [x(0), x(top)];
    mark(picture, left, above - 7, heading, "quietly");
    for (const tick of ticks(min, max, 3)) {
      if (whole && !Number.isInteger(tick)) continue;
      shape(picture, "line", { x1: left, x2: right, y1: y(tick), y2: y(tick), class: tick === 0 ? "tick" : "grid" });
      mark(picture, left - 6, y(tick) + 4, plain(tick), "end");
    }
    for (const walk of walks) {
      // A robot that falls has no steps to recover, and a margin far below what is drawn.
      if (Number.isNaN(walk[key]) || walk.fate === FELL) continue;
      const value = Math.min(max, Math.max(min, walk[key]));
      shape(picture, "circle", { cx: x(walk.impulse), cy: y(value), r: 2, class: `dot ${classes[walk.fate]}` });
    }
  }
  function drawScan() {
    const cell = chosen();
    const [picture, width] = fresh("scan", () => 318);
    const x = scaled([0, top], [44, width - 8]);
    const bar = Math.max(1.2, x(step) - x(0));
    for (const tick of ticks(0, top, width < 420 ? 5 : 8)) {
      shape(picture, "line", { x1: x(tick), x2: x(tick), y1: 8, y2: 276, class: "grid" });
      mark(picture, x(tick), 292, plain(tick), "middle");
    }
    mark(picture, x(0.5 * top), 311, "impulse [N s]", "middle quietly");
    data.shows.filter((show) => show.per_walk).forEach((show, row) =>
      drawQuantity(picture, x, show, [74 + 116 * row, 160 + 116 * row], cell.walks));
    for (const walk of cell.walks) {
      const height = [36, 27, 15][walk.fate];
      const place = { x: x(walk.impulse) - 0.45 * bar, y: 44 - height, width: 0.9 * bar, height };
      shape(picture, "rect", { ...place, class: `fate ${classes[walk.fate]}` });
    }
    for (const kind of ["fixed", "limit", "causal"])
      shape(picture, "path", { d: `M${x(cell[kind])},4V276`, class: `limit ${kind}` });
    shape(picture, "path", { d: `M${x(pushed())},4V276`, class: "now" });
    shape(picture, "path", { d: `M${x(pushed()) - 5},0h10l-5,7Z`, class: "now-tip" });
    byId("scan-caption").textContent =
      `Every impulse that was walked, ${pushWords(cell.angle)} at ${plain(phases[cell.phase])} of the step: ` +
      `a tall bar recovers, a low one falls. Limit ${limitWords(cell)}, survived ${newtons(cell.survived)}.`;
  }

  // ---- the polar map of one phase ----
  function drawAround() {
    const row = angles.map((_, angle) => cellAt(state.phase, angle));
    const limits = { finite: row.map((cell) => cell.limit), causal: row.map((cell) => cell.causal), fixed: row.map((cell) => cell.fixed) };
    drawPolar(byId("polar"), limits, top, (scale) => {
      shape(byId("polar"), "path", { d: around(row.map((cell) => cell.survived), scale), class: "survived" });
    });
    const angle = angles[state.angle];
    shape(byId("polar"), "path", { d: path([[0, 0], point(angle, 212)]), class: "now" });
    const [cx, cy] = point(angle, (200 / top) * chosen().survived);
    shape(byId("polar"), "circle", { cx, cy, r: 6, class: "spot" });
    byId("polar-caption").textContent =
      `Largest survived impulse [N s] at ${wordsOf("phase")} of the step, seen from above, and the limit around it.`;
  }

  // ---- the reader's choice ----
  function draw() {
    if (rects.length === 0) layMap();
    colourMap();
    drawScale();
    drawScan();
    drawAround();
    byId("said").textContent = describe(chosen());
  }
  function under(event) {
    const { x, y } = places;
    const [across, up] = placeOf(event, byId("map"));
    const angle = Math.floor((across - x(0)) / (x(1) - x(0)));
    const phase = Math.floor((up - y(0)) / (y(1) - y(0)));
    const inside = angle >= 0 && angle < angles.length && phase >= 0 && phase < phases.length;
    return inside ? { phase, angle } : null;
  }
  function hover(event) {
    const place = under(event);
    showTip(byId("map"), placeOf(event, byId("map")), place ? tipLines(cellAt(place.phase, place.angle)) : []);
  }
  function press(event) {
    const turn = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    const next = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? 0;
    if (!turn && !next) return;
    event.preventDefault();
    const phase = Math.min(phases.length - 1, Math.max(0, state.phase + next));
    choose({ phase, angle: (state.angle + turn + angles.length) % angles.length });
  }

  byId("map").addEventListener("pointermove", hover);
  byId("map").addEventListener("pointerleave", () => showTip(byId("map"), [], []));
  byId("map").addEventListener("click", (event) => choose(under(event) ?? {}));
  byId("map").addEventListener("keydown", press);
  addEventListener("resize", () => { layMap(); refresh(); });
  start({ draw });
})();
