// Draws the comparison, fills its table, and follows what the reader chooses.
"use strict";

(() => {
  const {
    data, speeds, angles, coarse, state, number, plain, newtons, percent, speedWords, angleWords, timeWords,
    phaseWords, failureWords, pushesAt, limitAt, reading, score, finding,
  } = comparison;
  const byId = (id) => document.getElementById(id);
  const namespace = byId("map").namespaceURI;
  const wedge = 14;
  let marks = [];
  let held = -1;

  // ---- elements ----
  function element(name, attributes = {}, ...children) {
    const node = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }
  function shape(parent, name, attributes, text) {
    const node = document.createElementNS(namespace, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    parent.append(node);
    return node;
  }
  const outline = (method, x, y, size) =>
    `M${data.methods[method].outline
      .map(([right, up]) => `${(x + size * right).toFixed(1)},${(y - size * up).toFixed(1)}`)
      .join("L")}Z`;
  function swatch(method) {
    const picture = document.createElementNS(namespace, "svg");
    for (const [key, value] of [["viewBox", "0 0 34 16"], ["class", "swatch"], ["aria-hidden", "true"]])
      picture.setAttribute(key, value);
    picture.style.setProperty("--own", `var(--m${method})`);
    const dashed = data.methods[method].dashed ? " dashed" : "";
    shape(picture, "path", { d: "M1,8H33", class: `line${dashed}` });
    shape(picture, "path", { d: outline(method, 17, 8, 5), class: "mark" });
    return picture;
  }

  // ---- the map ----
  /** Seen from above: angle 0 is up, 90 is to the left. */
  const point = (angle, radius, scale) => {
    const turn = (angle * Math.PI) / 180;
    return [-Math.sin(turn) * radius * scale, -Math.cos(turn) * radius * scale];
  };
  const joined = (points) => {
    // A gap wherever a direction was not measured; closed only if none is missing.
    const whole = points.every(([x]) => !Number.isNaN(x));
    let path = "";
    let pen = false;
    for (const [x, y] of whole ? points : [...points, points[0]]) {
      if (Number.isNaN(x)) { pen = false; continue; }
      path += `${pen ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`;
      pen = true;
    }
    return whole ? `${path}Z` : path;
  };
  const largest = () => {
    let most = 0;
    for (const phase of data.phases.keys())
      for (const angle of angles.keys())
        for (const push of pushesAt(phase, angle)) most = Math.max(most, push.finite);
    return most || 1;
  };
  function ringValues(most) {
    const rough = most / 3.5;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough);
    return Array.from({ length: Math.floor(most / step) }, (_, index) => step * (index + 1));
  }

  function drawLimits(picture, phase, scale) {
    for (const [name, filled] of [["finite", true], ["point", true], ["fixed", false]]) {
      const radii = angles.map((_, angle) => limitAt(phase, angle, name));
      if (!coarse) {
        const path = joined(radii.map((radius, index) => point(angles[index], radius, scale)));
        if (filled) shape(picture, "path", { d: path, class: `reach ${name}` });
        shape(picture, "path", { d: path, class: `limit ${name}` });
        continue;
      }
      radii.forEach((radius, index) => {
        if (Number.isNaN(radius)) return;
        const [from, to] = [-1, 1].map((side) =>
          point(angles[index] + side * wedge, radius, scale).map((v) => v.toFixed(1)));
        const turned = `A${radius * scale},${radius * scale} 0 0 0 ${to}`;
        if (name === "finite")
          shape(picture, "path", { d: `M0,0L${from}${turned}Z`, class: "reach point" });
        shape(picture, "path", { d: `M${from}${turned}`, class: `limit ${name}` });
      });
    }
  }

  function drawMethods(picture, phase, scale, small) {
    const found = [];
    const every = Math.max(1, Math.floor(angles.length / 16));
    for (const method of [...state.shown].sort((a, b) => b - a)) {
      const group = shape(picture, "g", { class: "method", "data-method": method });
      group.style.setProperty("--own", `var(--m${method})`);
      const readings = angles.map((_, angle) => reading(method, phase, angle));
      const points = readings.map((entry, index) =>
        entry ? point(angles[index], entry.survived, scale) : [NaN, NaN]);
      const kind = coarse ? " guide" : data.methods[method].dashed ? " dashed" : "";
      shape(group, "path", { d: joined(points), class: `line${kind}` });
      if (small) continue;
      readings.forEach((entry, index) => {
        if (!entry) return;
        const [x, y] = points[index];
        found.push({ ...entry, x, y });
        if (entry.open) {
          const [tipX, tipY] = point(angles[index], entry.survived + 16 / scale, scale);
          shape(group, "path", { d: `M${x},${y}L${tipX},${tipY}`, class: "line open" });
        }
        if (index % every === 0)
          shape(group, "path", { d: outline(method, x, y, 5), class: entry.hollow ? "mark hollow" : "mark" });
      });
    }
    return found;
  }

  function drawMap() {
    const picture = byId("map");
    picture.replaceChildren();
    const most = largest();
    const scale = 200 / most;
    for (const value of ringValues(most * 1.08)) {
      shape(picture, "circle", { r: value * scale, class: "ring" });
    }
    for (const [name, angle] of Object.entries(data.directions)) {
      const [x, y] = point(angle, 218, 1);
      shape(picture, "line", { x2: x, y2: y, class: "ring" });
      const turn = { outward: -90, inward: 90 }[name] ?? 0;
      const [atX, atY] = point(angle, 232, 1);
      shape(picture, "text", { transform: `translate(${atX},${atY}) rotate(${turn})`, class: "way" }, name);
    }
    drawLimits(picture, state.phase, scale);
    marks = drawMethods(picture, state.phase, scale, false);
    const free = [225, 315, 135, 45].reduce((low, angle) =>
      (near(angle) < near(low) ? angle : low));
    for (const value of ringValues(most * 1.08)) {
      const [x, y] = point(free, value, scale);
      shape(picture, "text", { x, y, class: "radius" }, plain(value));
    }
    shape(picture, "circle", { r: 9, class: "pick", id: "pick", visibility: "hidden" });
    byId("map-caption").textContent =
      `Largest survived impulse [N s], seen from above; leg speed ${speedWords(speeds[state.speed])}, ` +
      `pushes of ${plain(data.durations[state.duration])} s, ${phaseWords(state.phase)}.`;
    release();
  }
  function near(angle) {
    const apart = angles.map((other) => Math.abs(other - angle));
    return limitAt(state.phase, apart.indexOf(Math.min(...apart)), "finite");
  }

  // ---- one number, by pointer or by keys ----
  function tell(entry) {
    const one = entry.cells.length === 1 ? entry.cells[0] : null;
    const lines = [`${data.methods[entry.method].label}, ${angleWords(angles[entry.angle])}`];
    const share = `${entry.open ? "≥ " : ""}${percent(entry.fraction)} of the limit, ${entry.limit.toFixed(1)} N s`;
    if (one) {
      lines.push(`survives ${newtons(one.survived)} N s: ${share}`);
      lines.push(one.open ? `nothing failed up to ${plain(one.scanned, 4)} N s`
        : `${failureWords[one.failure]} at ${plain(one.failing, 4)} N s (${one.deltaV.toFixed(3)} m/s)`);
    } else {
      const name = state.phase === "mean" ? "on average" : `in phase ${plain(data.phases[entry.hardest.phase])}`;
      lines.push(`survives ${newtons(entry.survived)} N s ${name}`);
      lines.push(`${state.phase === "mean" ? "mean" : "worst"} share ${entry.open ? "≥ " : ""}${percent(entry.fraction)}; ${entry.cells.length} of ${entry.of} phases measured`);
    }
    return lines.map((line) => line.replaceAll(" N s", "\u00a0N\u00a0s"));
  }
  function hold(index) {
    held = index;
    const entry = marks[index];
    const ring = byId("pick");
    ring.setAttribute("cx", entry.x);
    ring.setAttribute("cy", entry.y);
    ring.setAttribute("visibility", "visible");
    for (const group of byId("map").querySelectorAll(".method"))
      group.classList.toggle("quiet", Number(group.dataset.method) !== entry.method);
    const tip = byId("tip");
    tip.replaceChildren(...tell(entry).map((line) => element("span", {}, line)));
    tip.hidden = false;
    const box = byId("map").getBoundingClientRect();
    const left = ((entry.x + 250) / 500) * box.width;
    tip.style.left = `${Math.max(0, Math.min(left - tip.offsetWidth / 2, box.width - tip.offsetWidth))}px`;
    const top = ((entry.y + 250) / 500) * box.height;
    tip.style.top = `${top > tip.offsetHeight + 18 ? top - tip.offsetHeight - 14 : top + 16}px`;
  }
  function release() {
    held = -1;
    byId("tip").hidden = true;
    byId("pick")?.setAttribute("visibility", "hidden");
    for (const group of byId("map").querySelectorAll(".quiet")) group.classList.remove("quiet");
  }
  function follow(event) {
    const box = byId("map").getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 500 - 250;
    const y = ((event.clientY - box.top) / box.height) * 500 - 250;
    const apart = marks.map((entry) => Math.hypot(entry.x - x, entry.y - y));
    const closest = apart.indexOf(Math.min(...apart));
    if (closest >= 0 && apart[closest] < 22) hold(closest);
    else release();
  }
  function press(event) {
    if (event.key === "Escape") return release();
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
  function fillTable() {
    const ways = Object.values(data.directions).map((angle) => angles.indexOf(angle));
    const body = byId("rows");
    body.replaceChildren();
    for (const [index, method] of data.methods.entries()) {
      const own = score(index);
      const box = element("input", { type: "checkbox", "data-method": index });
      box.checked = state.shown.has(index);
      const name = element("label", {}, box, swatch(index),
        element("span", {}, method.label, element("small", {}, `adapts: ${method.adapts}`)));
      const star = own.complete || !own.cells ? "" : "*";
      const share = element("span", { class: "bar" }, `${own.open ? "≥ " : ""}${percent(own.mean)}${star}`);
      share.style.setProperty("--share", `${100 * (own.mean || 0)}%`);
      share.style.setProperty("--own", `var(--m${index})`);
      const cell = (text, kind = "number") => element("td", { class: kind }, text);
      const failing = ways.map((angle) => {
        const entry = angle < 0 ? null : reading(index, state.phase, angle);
        if (!entry) return cell("–");
        return cell(entry.failing === Infinity ? `> ${newtons(entry.survived)}` : newtons(entry.failing));
      });
      const row = element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, share),
        cell(`${percent(own.worst)}${star}`), ...failing,
        cell(own.cells ? `${own.fell} / ${own.unsettled}` : "–"),
        cell(timeWords(number(method.p50))), cell(timeWords(number(method.tail))),
        cell(own.complete ? String(own.cells) : `${own.cells} of ${own.possible}`),
        cell(`${percent(own.causal)}${star}`));
      row.classList.toggle("off", !box.checked);
      body.append(row);
    }
    const limits = ways.map((angle) => (angle < 0 ? NaN : limitAt(state.phase, angle, "finite")));
    byId("limits").replaceChildren(
      element("th", { scope: "row" }, "Theoretical limit"), element("td", {}, "100 %"), element("td", { class: "number" }, "100 %"),
      ...limits.map((limit) => element("td", { class: "number" }, Number.isNaN(limit) ? "–" : limit.toFixed(1))),
      element("td", { colspan: 5 }));
    const means = { worst: "Mean: over the directions, of the worst phase of each. Newtons: the smallest failing impulse over the phases.",
      mean: "Mean: over all directions and phases. Newtons: the mean of the smallest failing impulses." }[state.phase] ??
      "Mean: over the directions. Newtons: the smallest failing impulse.";
    byId("table-note").textContent = means.replace("Newtons", "Directions [N s]") +
      (data.methods.some((_, index) => !score(index).complete) ? " * stands on fewer cells than were measured by others: does not compare directly." : "");
  }

  // ---- the reader's choice ----
  function readAddress() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const find = (values, text) => values.findIndex((value) => String(value) === text || Math.abs(value - Number(text)) < 5e-4 || (value === Infinity && text === "inf"));
    const set = (key, values) => {
      const index = asked.has(key) ? find(values, asked.get(key)) : -1;
      if (index >= 0) state[key] = index;
    };
    set("speed", speeds);
    set("duration", data.durations);
    set("phase", data.phases);
    if (data.phases.length > 1 && ["worst", "mean"].includes(asked.get("phase"))) state.phase = asked.get("phase");
    if (asked.has("methods")) {
      const keys = asked.get("methods").split(",");
      state.shown = new Set([...data.methods.keys()].filter((index) => keys.includes(data.methods[index].key)));
    }
  }
  function writeAddress() {
    const asked = new URLSearchParams({
      speed: data.speeds[state.speed], duration: data.durations[state.duration],
      phase: typeof state.phase === "string" ? state.phase : plain(data.phases[state.phase]),
    });
    if (state.shown.size < data.methods.length)
      asked.set("methods", [...state.shown].sort((a, b) => a - b).map((index) => data.methods[index].key).join(","));
    history.replaceState(null, "", `#${asked.toString().replaceAll("%2C", ",")}`);
  }
  function offer(key, values, words) {
    for (const value of values) {
      const input = element("input", { type: "radio", name: key, value });
      input.checked = String(state[key]) === String(value);
      input.addEventListener("change", () => { state[key] = value; refresh(); });
      byId(key).append(element("label", {}, input, words(value)));
    }
  }
  function phaseLabel(phase) {
    const picture = document.createElementNS(namespace, "svg");
    picture.setAttribute("viewBox", "-105 -105 210 210");
    picture.setAttribute("aria-hidden", "true");
    picture.dataset.phase = phase;
    const word = typeof phase === "string" ? phase : plain(data.phases[phase]);
    return element("span", { class: "small" }, picture, word);
  }
  function drawSmall() {
    const scale = 100 / largest();
    for (const picture of document.querySelectorAll("svg[data-phase]")) {
      const phase = picture.dataset.phase;
      picture.replaceChildren();
      const which = Number.isNaN(Number(phase)) ? phase : Number(phase);
      drawLimits(picture, which, scale);
      drawMethods(picture, which, scale, true);
    }
  }
  function refresh() {
    for (const key of ["speed", "duration", "phase"])
      for (const input of document.querySelectorAll(`input[name=${key}]`))
        input.checked = input.value === String(state[key]);
    const focused = document.activeElement?.dataset?.method;
    drawMap();
    drawSmall();
    fillTable();
    if (focused !== undefined) document.querySelector(`input[data-method="${focused}"]`)?.focus();
    byId("finding").textContent = finding();
    writeAddress();
  }
  function show(indices) {
    state.shown = new Set(indices);
    refresh();
  }

  readAddress();
  offer("speed", [...speeds.keys()], (index) => speedWords(speeds[index]));
  offer("duration", [...data.durations.keys()], (index) => `${plain(data.durations[index])} s`);
  offer("phase", [...data.phases.keys(), ...(data.phases.length > 1 ? ["worst", "mean"] : [])], phaseLabel);
  byId("rows").addEventListener("change", (event) => {
    const method = Number(event.target.dataset.method);
    if (event.target.checked) state.shown.add(method);
    else state.shown.delete(method);
    refresh();
  });
  byId("all").addEventListener("click", () => show(data.methods.keys()));
  byId("none").addEventListener("click", () => show([]));
  byId("map").addEventListener("pointermove", follow);
  byId("map").addEventListener("pointerdown", follow);
  byId("map").addEventListener("pointerleave", release);
  byId("map").addEventListener("keydown", press);
  byId("map").addEventListener("blur", release);
  addEventListener("hashchange", () => { readAddress(); refresh(); });
  document.documentElement.classList.add("live");
  refresh();
})();
