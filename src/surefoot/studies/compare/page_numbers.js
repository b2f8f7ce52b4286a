// What the page says: the comparison that is embedded in it, its numbers, and their words.
"use strict";

const comparison = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const number = (value) => (value === "inf" ? Infinity : value === "nan" ? NaN : value);
  const speeds = data.speeds.map(number);
  const angles = data.angles;
  const coarse = angles.length < 8;

  // pushes[speed][duration][phase][angle] = {limits, cells by method}
  const pushes = new Map();
  const place = (speed, duration, phase, angle) => `${speed}/${duration}/${phase}/${angle}`;
  const listed = data.pushes.map(([speed, duration, phase, angle, point, finite, fixed, unknown]) => {
    const causal = number(unknown);
    const push = { phase, point, finite, fixed, causal, cells: [] };
    pushes.set(place(speed, duration, phase, angle), push);
    return push;
  });
  for (const [method, push, impulse, deltaV, step, scanned, failure] of data.cells) {
    const failing = number(impulse);
    const open = failing === Infinity;
    const survived = open ? scanned : Math.max(failing - step, 0);
    const at = listed[push];
    at.cells[method] = {
      failing, deltaV: number(deltaV), open, scanned, survived, phase: at.phase,
      failure: data.failures[failure], fraction: Math.min(survived / at.finite, 1),
      causal: Math.min(survived / at.causal, 1),
    };
  }

  const state = {
    speed: data.choice.speed, duration: data.choice.duration, phase: data.choice.phase,
    shown: new Set(data.methods.keys()),
  };

  // ---- words ----
  const plain = (value, digits = 3) => String(Number(value.toPrecision(digits)));
  const percent = (value) => (Number.isNaN(value) ? "–" : `${(100 * value).toFixed(0)} %`);
  const speedWords = (value) => (value === Infinity ? "unlimited" : `${plain(value)} m/s`);
  const between = (angle) => {
    const names = Object.keys(data.directions);
    const first = Math.floor(angle / 90);
    return [names[first], names[(first + 1) % names.length]];
  };
  /** An impulse; one decimal where it is a mean. */
  const newtons = (value) =>
    state.phase === "mean" ? value.toFixed(1) : String(Number(value.toFixed(3)));
  const angleWords = (angle) =>
    Object.keys(data.directions).find((name) => data.directions[name] === angle) ??
    `${plain(angle, 4)}°, between ${between(angle).join(" and ")}`;
  const timeWords = (seconds) => {
    if (Number.isNaN(seconds)) return "–";
    const units = [["s", 1], ["ms", 1e-3], ["µs", 1e-6], ["ns", 1e-9]];
    const [unit, scale] = units.find(([, size]) => seconds >= size) ?? units[3];
    return `${plain(seconds / scale)} ${unit}`;
  };
  const phaseWords = (phase) =>
    ({ worst: "worst phase of each direction", mean: "mean over the phases" })[phase] ??
    `phase ${plain(data.phases[phase])}`;
  const failureWords = { fell: "fell", unsettled: "did not settle" };

  // ---- numbers of the current choice ----
  const phasesOf = (phase) => (typeof phase === "string" ? [...data.phases.keys()] : [phase]);
  const pushesAt = (phase, angle) =>
    phasesOf(phase)
      .map((index) => pushes.get(place(state.speed, state.duration, index, angle)))
      .filter(Boolean);
  const least = (values) => values.reduce((low, value) => Math.min(low, value), Infinity);
  const mean = (values) =>
    values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : NaN;
  const drawn = (phase, values) =>
    values.length === 0 ? NaN : phase === "mean" ? mean(values) : least(values);

  const limitAt = (phase, angle, name) =>
    drawn(phase, pushesAt(phase, angle).map((push) => push[name]));

  /** What one method does in one direction: over one phase, or over all of them. */
  function reading(method, phase, angle) {
    const there = pushesAt(phase, angle);
    const cells = there.map((push) => push.cells[method]).filter(Boolean);
    if (cells.length === 0) return null;
    const survived = drawn(phase, cells.map((cell) => cell.survived));
    const hardest = cells.reduce((low, cell) => (cell.survived < low.survived ? cell : low));
    return {
      method, angle, cells, survived, hardest, of: there.length,
      failing: drawn(phase, cells.map((cell) => cell.failing)),
      fraction: drawn(phase, cells.map((cell) => cell.fraction)),
      limit: limitAt(phase, angle, "finite"),
      open: phase === "mean" ? cells.some((cell) => cell.open) : hardest.open,
      hollow: phase !== "mean" && hardest.failure === "unsettled",
    };
  }

  function score(method) {
    const possible = angles.reduce((sum, _, angle) => sum + pushesAt(state.phase, angle).length, 0);
    const readings = angles.map((_, angle) => reading(method, state.phase, angle)).filter(Boolean);
    const cells = readings.flatMap((entry) => entry.cells);
    const count = (failure) => cells.filter((cell) => cell.failure === failure).length;
    return {
      method, possible, cells: cells.length, complete: cells.length === possible,
      mean: mean(readings.map((entry) => entry.fraction)),
      causal: mean(cells.map((cell) => cell.causal)),
      worst: cells.length ? least(cells.map((cell) => cell.fraction)) : NaN,
      open: cells.some((cell) => cell.open && cell.fraction < 1),
      fell: count("fell"), unsettled: count("unsettled"),
    };
  }

  // ---- the finding ----
  /** The main finding of the current choice, as a sentence or two. */
  function finding() {
    const scores = [...state.shown].map(score);
    const whole = scores.filter((own) => own.complete && own.cells).sort((a, b) => b.mean - a.mean);
    const where = `With a leg speed ${speeds[state.speed] === Infinity ? "without limit" : `of ${speedWords(speeds[state.speed])}`}` +
      ` and pushes of ${plain(data.durations[state.duration])} s (${phaseWords(state.phase)})`;
    if (whole.length === 0) return `${where}, none of the methods shown was measured in every cell.`;
    const label = (own) => data.methods[own.method].label;
    const [best, second] = whole;
    const least = (own) => (own.open ? "at least " : "");
    const tied = second && percent(second.mean) === percent(best.mean);
    let words = `${where}, ${label(best)}${tied ? ` and ${label(second)}` : ""} survive${tied ? "" : "s"} ` +
      `${whole.length > 1 ? "the most: " : ""}${least(best)}${percent(best.mean)} of the limit on average` +
      `${tied ? "" : ` and ${percent(best.worst)} in the worst cell`}.`;
    if (second && !tied) words += ` ${label(second)} follows with ${least(second)}${percent(second.mean)}.`;
    const shares = angles.map((_, angle) => reading(best.method, state.phase, angle)?.survived ?? Infinity);
    words += ` For ${label(best)} the weakest direction is ${angleWords(angles[shares.indexOf(Math.min(...shares))])}, ${newtons(Math.min(...shares))} N s.`;
    const partial = scores.length - whole.length;
    if (partial) words += ` ${partial} of the methods shown ${partial === 1 ? "was" : "were"} measured on fewer cells and ${partial === 1 ? "is" : "are"} not ranked.`;
    return words;
  }

  return {
    data, speeds, angles, coarse, state, number, plain, newtons, percent, speedWords, angleWords, timeWords,
    phaseWords, failureWords, pushesAt, limitAt, reading, score, finding,
  };
})();
