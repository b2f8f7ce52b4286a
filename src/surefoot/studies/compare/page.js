// Draws the comparison, fills its table and says its finding, as the reader chooses.
"use strict";

(() => {
  const {
    data, angles, state, byId, plain, percent, element, shape, placeOf, showTip, coarse, point, around, drawLimits,
    drawPolar, wordsOf, refresh, start,
  } = page;
  const { methods } = data;
  const starts = data.choices.phase.values;
  const shown = new Set(methods.keys());
  const failureWords = { fell: "fell", unsettled: "did not settle" };
  let marks = [];
  let held = -1;

  // ---- what was measured ----
  const places = new Map();
  const pushes = data.pushes.map(([speed, duration, phase, angle, point, finite, fixed, causal]) => {
    const push = { speed, duration, phase, point, finite, fixed, causal, cells: [] };
    places.set(`${speed}/${duration}/${phase}/${angle}`, push);
    return push;
  });
  for (const [method, push, failing, survived, deltaV, failure] of data.cells) {
    const { cells, phase, finite, causal } = pushes[push];
    cells[method] = {
      phase, failing, survived, deltaV, open: failing === Infinity, failure: data.failures[failure],
      fraction: Math.min(survived / finite, 1), causal: Math.min(survived / causal, 1),
    };
  }

  // ---- numbers of a phase, or of all of them: the worst, or the mean ----
  const isMean = (phase) => starts[phase] === "mean";
  function pushesAt(phase, angle) {
    const one = typeof starts[phase] === "number";
    return [...starts.keys()]
      .filter((index) => !one || index === phase)
      .map((index) => places.get(`${state.speed}/${state.duration}/${index}/${angle}`))
      .filter(Boolean);
  }
  const min = (values) => values.reduce((low, value) => Math.min(low, value), Infinity);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const drawn = (phase, values) =>
    values.length === 0 ? NaN : isMean(phase) ? mean(values) : min(values);
  const limitAt = (phase, angle, kind) => drawn(phase, pushesAt(phase, angle).map((push) => push[kind]));
  const limitsOf = (phase) => Object.fromEntries(["finite", "point", "fixed"].map((kind) =>
    [kind, angles.map((_, angle) => limitAt(phase, angle, kind))]));

  /** What one method survives in one direction. */
  function reading(method, phase, angle) {
    const there = pushesAt(phase, angle);
    const cells = there.map((push) => push.cells[method]).filter(Boolean);
    if (cells.length === 0) return null;
    const hardest = cells.reduce((low, cell) => (cell.survived < low.survived ? cell : low));
    const over = (name) => drawn(phase, cells.map((cell) => cell[name]));
    return {
      method, angle, cells, hardest, of: there.length, survived: over("survived"), failing: over("failing"),
      fraction: over("fraction"), limit: limitAt(phase, angle, "finite"),
      open: isMean(phase) ? cells.some((cell) => cell.open) : hardest.open,
      hollow: !isMean(phase) && hardest.failure === "unsettled",
    };
  }
  function score(method) {
    const possible = angles.reduce((sum, _, angle) => sum + pushesAt(state.phase, angle).length, 0);
    const readings = angles.map((_, angle) => reading(method, state.phase, angle)).filter(Boolean);
    const cells = readings.flatMap((entry) => entry.cells);
    const count = (failure) => cells.filter((cell) => cell.failure === failure).length;
    const some = cells.length > 0;
    return {
      method, possible, cells: cells.length, complete: cells.length === possible,
      mean: mean(readings.map((entry) => entry.fraction)), causal: mean(cells.map((cell) => cell.causal)),
      worst: some ? min(cells.map((cell) => cell.fraction)) : NaN,
      open: cells.some((cell) => cell.open && cell.fraction < 1),
      fell: count("fell"), unsettled: count("unsettled"),
    };
  }

  // ---- words ----
  /** An impulse; one decimal where it is a mean. */
  const newtons = (value) => (isMean(state.phase) ? value.toFixed(1) : String(Number(value.toFixed(3))));
  const atLeast = (entry) => (entry.open ? "≥ " : "");
  const phaseWords = () =>
    ({ worst: "worst phase of each direction", mean: "mean over the phases" })[starts[state.phase]] ?? `phase ${wordsOf("phase")}`;
  /** The main finding of the choice, as a sentence or two. */
  function finding() {
    const scores = [...shown].map(score);
    const whole = scores.filter((own) => own.complete && own.cells).sort((a, b) => b.mean - a.mean);
    const leg = wordsOf("speed") === "unlimited" ? "without limit" : `of ${wordsOf("speed")}`;
    const where = `With a leg speed ${leg} and pushes of ${wordsOf("duration")} (${phaseWords()})`;
    if (whole.length === 0) return `${where}, none of the methods shown was measured in every cell.`;
    const [best, second] = whole;
    const [first, next] = whole.map((own) => methods[own.method].label);
    const share = (own) => `${own.open ? "at least " : ""}${percent(own.mean)}`;
    const tied = second && percent(second.mean) === percent(best.mean);
    let words = `${where}, ${first}${tied ? ` and ${next} survive` : " survives"} ${second ? "the most: " : ""}` +
      `${share(best)} of the limit on average${tied ? "" : ` and ${percent(best.worst)} in the worst cell`}.`;
    if (second && !tied) words += ` ${next} follows with ${share(second)}.`;
    const survived = angles.map((_, angle) => reading(best.method, state.phase, angle)?.survived ?? Infinity);
    const weakest = data.angleWords[survived.indexOf(min(survived))];
    words += ` For ${first} the weakest direction is ${weakest}, ${newtons(min(survived))} N s.`;
    const partial = scores.length - whole.length;
    const [was, is] = partial === 1 ? ["was", "is"] : ["were", "are"];
    return partial ? `${words} ${partial} of the methods shown ${was} measured on fewer cells and ${is} not ranked.` : words;
  }
  function tipLines(entry) {
    const [one] = entry.cells;
    const share = `${atLeast(entry)}${percent(entry.fraction)}`;
    const lines = [`${methods[entry.method].label}, ${data.angleWords[entry.angle]}`];
    if (entry.cells.length === 1) {
      lines.push(`survives ${newtons(one.survived)} N s: ${share} of the limit, ${entry.limit.toFixed(1)} N s`);
      lines.push(one.open ? `nothing failed up to ${plain(one.survived, 4)} N s`
        : `${failureWords[one.failure]} at ${plain(one.failing, 4)} N s (${one.deltaV.toFixed(3)} m/s)`);
    } else {
      const [when, kind] = isMean(state.phase) ? ["on average", "mean"] : [`in phase ${plain(starts[entry.hardest.phase])}`, "worst"];
      lines.push(`survives ${newtons(entry.survived)} N s ${when}`);
      lines.push(`${kind} share ${share}; ${entry.cells.length} of ${entry.of} phases measured`);
    }
    return lines.map((line) => line.replaceAll(" N s", "\u00a0N\u00a0s"));
  }

  // ---- the map ----
  const largest = () => Math.max(1e-9, ...pushes
    .filter((push) => push.speed === state.speed && push.duration === state.duration)
    .map((push) => push.finite));
  const colourOf = (method) => `--own: light-dark(${methods[method].colours})`;
  const outline = (method, x, y, size) =>
    `M${methods[method].outline.map(([right, up]) => `${(x + size * right).toFixed(1)},${(y - size * up).toFixed(1)}`).join("L")}Z`;
  function drawMethods(picture, phase, scale, marked) {
    const found = [];
    const every = Math.max(1, Math.floor(angles.length / 16));
    for (const method of [...shown].sort((a, b) => b - a)) {
      const group = shape(picture, "g", { class: "method", "data-method": method, style: colourOf(method) });
      const readings = angles.map((_, angle) => reading(method, phase, angle));
      const kind = coarse ? " guide" : methods[method].dashed ? " dashed" : "";
      shape(group, "path", { d: around(readings.map((entry) => entry?.survived ?? NaN), scale), class: `line${kind}` });
      for (const entry of marked ? readings.filter(Boolean) : []) {
        const [x, y] = point(angles[entry.angle], entry.survived * scale);
        found.push({ ...entry, x, y });
        const tip = point(angles[entry.angle], entry.survived * scale + 16);
        if (entry.open) shape(group, "path", { d: `M${x},${y}L${tip}`, class: "line open" });
        if (entry.angle % every === 0)
          shape(group, "path", { d: outline(method, x, y, 5), class: entry.hollow ? "mark hollow" : "mark" });
      }
    }
    return found;
  }
  function drawMap() {
    const picture = byId("map");
    drawPolar(picture, limitsOf(state.phase), largest(), (scale) => {
      marks = drawMethods(picture, state.phase, scale, true);
    });
    shape(picture, "circle", { r: 9, class: "pick", id: "pick", visibility: "hidden" });
    byId("map-caption").textContent = `Largest survived impulse [N s], seen from above; leg speed ${wordsOf("speed")}, ` +
      `pushes of ${wordsOf("duration")}, ${phaseWords()}.`;
    hold(-1);
  }
  function drawSmall() {
    for (const picture of document.querySelectorAll("svg[data-phase]")) {
      const phase = Number(picture.dataset.phase);
      picture.replaceChildren();
      drawLimits(picture, limitsOf(phase), 100 / largest());
      drawMethods(picture, phase, 100 / largest(), false);
    }
  }

  // ---- one number, by pointer or by keys ----
  /** Show the number of one mark, or none. */
  function hold(index) {
    held = index;
    const entry = marks[index];
    const [picture, ring] = [byId("map"), byId("pick")];
    ring.setAttribute("visibility", entry ? "visible" : "hidden");
    for (const [key, value] of Object.entries({ cx: entry?.x ?? 0, cy: entry?.y ?? 0 })) ring.setAttribute(key, value);
    for (const group of picture.querySelectorAll(".method"))
      group.classList.toggle("quiet", entry !== undefined && Number(group.dataset.method) !== entry.method);
    showTip(picture, entry ? [entry.x, entry.y] : [], entry ? tipLines(entry) : []);
  }
  function follow(event) {
    const [x, y] = placeOf(event, byId("map"));
    const distances = marks.map((entry) => Math.hypot(entry.x - x, entry.y - y));
    const closest = distances.indexOf(Math.min(...distances));
    hold(distances[closest] < 22 ? closest : -1);
  }
  function press(event) {
    if (event.key === "Escape") return hold(-1);
    const turn = { ArrowLeft: 1, ArrowRight: -1 }[event.key] ?? 0;
    const next = { ArrowDown: 1, ArrowUp: -1 }[event.key] ?? 0;
    if ((!turn && !next) || marks.length === 0) return;
    event.preventDefault();
    const now = marks[held] ?? marks.reduce((first, entry) =>
      (entry.method - first.method || entry.angle - first.angle) < 0 ? entry : first);
    const alike = held < 0 ? [now] : marks.filter((entry) =>
      (turn ? entry.method === now.method : entry.angle === now.angle));
    alike.sort((a, b) => (turn ? a.angle - b.angle : a.method - b.method));
    const step = held < 0 ? 0 : turn + next;
    hold(marks.indexOf(alike[(alike.indexOf(now) + step + alike.length) % alike.length]));
  }

  // ---- the table ----
  const cell = (text, kind = "number") => element("td", { class: kind }, text);
  function nameOf(index) {
    const { label, adapts, dashed } = methods[index];
    const box = element("input", { type: "checkbox", "data-method": index });
    box.checked = shown.has(index);
    const name = element("label", {}, box);
    const swatch = shape(name, "svg", { viewBox: "0 0 34 16", class: "swatch", "aria-hidden": "true" });
    shape(swatch, "path", { d: "M1,8H33", class: `line${dashed ? " dashed" : ""}` });
    shape(swatch, "path", { d: outline(index, 17, 8, 5), class: "mark" });
    name.append(element("span", {}, label, element("small", {}, `adapts: ${adapts}`)));
    return element("th", { scope: "row" }, name);
  }
  function rowOf(index, ways) {
    const own = score(index);
    const star = own.complete || !own.cells ? "" : "*";
    const bar = element("span", { class: "bar", style: `--share: ${100 * (own.mean || 0)}%` }, `${atLeast(own)}${percent(own.mean)}${star}`);
    const failing = ways.map((angle) => {
      const entry = angle < 0 ? null : reading(index, state.phase, angle);
      if (!entry) return "–";
      return entry.failing === Infinity ? `> ${newtons(entry.survived)}` : newtons(entry.failing);
    });
    const row = element("tr", { style: colourOf(index) }, nameOf(index), element("td", {}, bar), ...[
      `${percent(own.worst)}${star}`, ...failing, own.cells ? `${own.fell} / ${own.unsettled}` : "–",
      methods[index].p50, methods[index].tail, own.complete ? String(own.cells) : `${own.cells} of ${own.possible}`,
      `${percent(own.causal)}${star}`,
    ].map((text) => cell(text)));
    row.classList.toggle("off", !shown.has(index));
    return row;
  }
  function fillTable() {
    const ways = Object.values(data.directions).map((angle) => angles.indexOf(angle));
    byId("rows").replaceChildren(...[...methods.keys()].map((index) => rowOf(index, ways)));
    const limits = ways.map((angle) => (angle < 0 ? NaN : limitAt(state.phase, angle, "finite")));
    byId("limits").replaceChildren(
      element("th", { scope: "row" }, "Theoretical limit"), element("td", {}, "100 %"), cell("100 %"),
      ...limits.map((limit) => cell(Number.isNaN(limit) ? "–" : limit.toFixed(1))), element("td", { colspan: 5 }));
    const means = {
      worst: "Mean: over the directions, of the worst phase of each. Directions [N s]: the smallest failing impulse over the phases.",
      mean: "Mean: over all directions and phases. Directions [N s]: the mean of the smallest failing impulses.",
    }[starts[state.phase]] ?? "Mean: over the directions. Directions [N s]: the smallest failing impulse.";
    byId("table-note").textContent = means + (methods.every((_, index) => score(index).complete) ? ""
      : " * stands on fewer cells than were measured by others: does not compare directly.");
  }

  // ---- the reader's choice ----
  function label(key, index) {
    const words = data.choices[key].words[index];
    if (key !== "phase") return words;
    const own = element("span", { class: "small" });
    shape(own, "svg", { viewBox: "-105 -105 210 210", "aria-hidden": "true", "data-phase": index });
    own.append(words);
    return own;
  }
  function draw() {
    const focused = document.activeElement?.dataset?.method;
    drawMap();
    drawSmall();
    fillTable();
    if (focused !== undefined) document.querySelector(`input[data-method="${focused}"]`)?.focus();
    byId("finding").textContent = finding();
  }
  function show(indices) {
    shown.clear();
    for (const index of indices) shown.add(index);
  }
  const asked = () => (shown.size === methods.length ? {}
    : { methods: [...shown].sort((a, b) => a - b).map((index) => methods[index].key).join(",") });
  function read(address) {
    const keys = address.get("methods")?.split(",");
    if (keys) show([...methods.keys()].filter((index) => keys.includes(methods[index].key)));
  }

  byId("rows").addEventListener("change", (event) => {
    const method = Number(event.target.dataset.method);
    if (event.target.checked) shown.add(method);
    else shown.delete(method);
    refresh();
  });
  byId("all").addEventListener("click", () => { show(methods.keys()); refresh(); });
  byId("none").addEventListener("click", () => { show([]); refresh(); });
  for (const event of ["pointermove", "pointerdown"]) byId("map").addEventListener(event, follow);
  for (const event of ["pointerleave", "blur"]) byId("map").addEventListener(event, () => hold(-1));
  byId("map").addEventListener("keydown", press);
  start({ draw, label, asked, read });
})();
