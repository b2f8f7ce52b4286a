// Draws the map, the scan of one cell and the polar map of its phase, and follows the reader.
"use strict";

(() => {
  const {
    data, phases, angles, step, cells, cellAt, walkAt, shows, ranges, colours, angleWords, pushWords, newtons, percent, plain, describe,
    top, state, RECOVERED, stride,
  } = pushMap;
  const byId = (id) => document.getElementById(id);
  const namespace = byId("map").namespaceURI;
  const classes = ["recovered", "unsettled", "fell"];
  let rects = [];
  let box = { width: 640, height: 380, left: 44, right: 6, top: 8, bottom: 40 };

  // ---- elements ----
  function shape(parent, name, attributes, text) {
    const node = document.createElementNS(namespace, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    parent.append(node);
    return node;
  }
  function fresh(id, width, height) {
    const picture = byId(id);
    picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
    picture.replaceChildren();
    return picture;
  }
  const widthOf = (id) => Math.max(280, Math.round(byId(id).clientWidth) || 640);
  const ticksOf = (least, most, wanted) => {
    const rough = (most - least) / wanted || 1;
    const power = 10 ** Math.floor(Math.log10(rough));
    const apart = power * [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough * 0.999);
    const ticks = [];
    for (let tick = Math.ceil(least / apart - 1e-9) * apart; tick <= most + 1e-9; tick += apart) ticks.push(Number(tick.toPrecision(6)));
    return ticks;
  };
  const colourOf = (key, value) => {
    const [least, most] = ranges[key];
    const place = Math.min(1, Math.max(0, (value - least) / (most - least))) * (colours.length - 1);
    const below = Math.min(Math.floor(place), colours.length - 2);
    const parts = [below, below + 1].map((index) => [1, 3, 5].map((i) => parseInt(colours[index].slice(i, i + 2), 16)));
    return `rgb(${parts[0].map((v, i) => Math.round(v + (place - below) * (parts[1][i] - v))).join(",")})`;
  };

  // ---- the heat map ----
  const across = () => (box.width - box.left - box.right) / angles.length;
  const along = () => (box.height - box.top - box.bottom) / phases.length;
  const cornerOf = (cell) => [box.left + cell.angle * across(), box.height - box.bottom - (cell.phase + 1) * along()];
  function layMap() {
    box.width = widthOf("map");
    box.height = Math.round(Math.min(460, Math.max(240, 0.58 * box.width)));
    const picture = fresh("map", box.width, box.height);
    rects = cells.map((cell) => {
      const [x, y] = cornerOf(cell);
      return shape(picture, "rect", {
        x: x.toFixed(2), y: y.toFixed(2), width: (across() + 0.3).toFixed(2), height: (along() + 0.3).toFixed(2), class: "cell",
      });
    });
    const size = Math.max(1.6, Math.min(4, 0.3 * Math.min(across(), along())));
    for (const cell of cells.filter((one) => one.hole)) {
      const [x, y] = cornerOf(cell).map((v, i) => v + 0.5 * [across(), along()][i]);
      const d = `M${x - size},${y - size}L${x + size},${y + size}M${x + size},${y - size}L${x - size},${y + size}`;
      shape(picture, "path", { d, class: "hole halo" });
      shape(picture, "path", { d, class: "hole" });
    }
    for (const [name, angle] of Object.entries(data.directions)) {
      const x = box.left + (angle / 360) * (box.width - box.left - box.right) + 0.5 * across();
      shape(picture, "line", { x1: x, x2: x, y1: box.height - box.bottom, y2: box.height - box.bottom + 5, class: "tick" });
      shape(picture, "text", { x: Math.max(x, 24), y: box.height - box.bottom + 17, class: "label middle" }, name);
      shape(picture, "text", { x: Math.max(x, 24), y: box.height - box.bottom + 32, class: "label middle quietly" }, `${angle}°`);
    }
    for (const tick of ticksOf(0, 1, 5).filter((value) => value < 1)) {
      const y = box.height - box.bottom - (tick * phases.length + 0.5) * along();
      if (y < box.top - 1) continue;
      shape(picture, "text", { x: box.left - 6, y: y + 4, class: "label end" }, plain(tick));
    }
    const middle = 0.5 * (box.top + box.height - box.bottom);
    shape(picture, "text", { transform: `translate(11,${middle}) rotate(-90)`, class: "label middle quietly" }, "phase of the step");
    shape(picture, "rect", { class: "pick", id: "pick" });
  }
  function colourMap() {
    const show = shows[state.show];
    cells.forEach((cell, index) => {
      const value = show.value(cell, state.number);
      const walk = show.moves ? walkAt(cell, state.number) : null;
      const beyond = show.moves && state.number * step > cell.limit;
      const kind = !Number.isNaN(value) ? "" : beyond ? " beyond" : walk !== null && walk.fate === 1 ? " lost unsettled" : " lost";
      rects[index].setAttribute("class", `cell${kind}`);
      rects[index].setAttribute("fill", kind ? "none" : colourOf(state.show, value));
    });
    const [x, y] = cornerOf(chosen());
    const pick = byId("pick");
    for (const [key, value] of Object.entries({ x: x - 1, y: y - 1, width: across() + 2.3, height: along() + 2.3 })) pick.setAttribute(key, value.toFixed(1));
    const when = show.moves ? ` under ${newtons(state.number * step)}` : "";
    byId("map-caption").textContent = `${show.words}${when} [${show.unit}], by direction and phase of the push.` +
      (show.moves ? " Dark grey: it falls; amber: it does not settle; pale: above the limit." : "");
  }
  function drawScale() {
    const show = shows[state.show];
    const width = widthOf("scale");
    const picture = fresh("scale", width, 44);
    const [least, most] = ranges[state.show];
    const [left, right] = [box.left, width - 6];
    const count = 60;
    for (let part = 0; part < count; part += 1) {
      const value = least + ((part + 0.5) / count) * (most - least);
      shape(picture, "rect", {
        x: (left + (part / count) * (right - left)).toFixed(1), y: 6, width: ((right - left) / count + 0.4).toFixed(1), height: 12,
        fill: colourOf(state.show, value),
      });
    }
    for (const tick of ticksOf(least, most, width < 420 ? 4 : 7)) {
      if (show.whole && !Number.isInteger(tick)) continue;
      const x = left + ((tick - least) / (most - least)) * (right - left);
      shape(picture, "line", { x1: x, x2: x, y1: 18, y2: 22, class: "tick" });
      shape(picture, "text", { x: Math.min(x, width - 12), y: 35, class: "label middle" }, show.text(tick));
    }
    shape(picture, "text", { x: 2, y: 17, class: "label quietly" }, show.unit);
  }

  // ---- the scan of one cell ----
  const chosen = () => cellAt(state.phase, state.angle);
  function drawScan() {
    const cell = chosen();
    const width = widthOf("scan");
    const rows = [["fate", 8, 44], ["steps", 74, 160], ["margin", 190, 276]];
    const picture = fresh("scan", width, 318);
    const [left, right] = [44, width - 8];
    const x = (impulse) => left + (impulse / top) * (right - left);
    const bar = Math.max(1.2, x(step) - x(0));
    for (const tick of ticksOf(0, top, width < 420 ? 5 : 8)) {
      shape(picture, "line", { x1: x(tick), x2: x(tick), y1: 8, y2: 276, class: "grid" });
      shape(picture, "text", { x: x(tick), y: 292, class: "label middle" }, plain(tick));
    }
    shape(picture, "text", { x: 0.5 * (left + right), y: 311, class: "label middle quietly" }, "impulse [N s]");
    for (const [name, above, below] of rows.slice(1)) {
      const [least, most] = [Math.min(0, ranges[name][0]), ranges[name][1]];
      const y = (value) => below - ((value - least) / (most - least)) * (below - above);
      shape(picture, "text", { x: left, y: above - 7, class: "label quietly" }, `${name === "steps" ? "steps to recover" : "margin [cm]"}`);
      for (const tick of ticksOf(least, most, 3)) {
        if (name === "steps" && !Number.isInteger(tick)) continue;
        shape(picture, "line", { x1: left, x2: right, y1: y(tick), y2: y(tick), class: tick === 0 ? "tick" : "grid" });
        shape(picture, "text", { x: left - 6, y: y(tick) + 4, class: "label end" }, plain(tick));
      }
      for (const walk of cell.walks) {
        const value = name === "steps" ? walk.steps : 100 * walk.margin;
        // A robot that falls has no steps to recover, and a margin far below what is drawn.
        if (Number.isNaN(value) || walk.fate === 2 || (name === "steps" && walk.fate !== RECOVERED)) continue;
        shape(picture, "circle", {
          cx: x(walk.impulse).toFixed(1), cy: y(Math.min(most, Math.max(least, value))).toFixed(1), r: 2, class: `dot ${classes[walk.fate]}`,
        });
      }
    }
    for (const walk of cell.walks) {
      const tall = [36, 27, 15][walk.fate];
      shape(picture, "rect", { x: (x(walk.impulse) - 0.45 * bar).toFixed(1), y: 44 - tall, width: (0.9 * bar).toFixed(1), height: tall, class: `fate ${classes[walk.fate]}` });
    }
    shape(picture, "path", { d: `M${x(cell.fixed)},4V276`, class: "limit fixed" });
    shape(picture, "path", { d: `M${x(cell.limit)},4V276`, class: "limit" });
    shape(picture, "path", { d: `M${x(cell.causal)},4V276`, class: "limit causal" });
    const now = x(state.number * step);
    shape(picture, "path", { d: `M${now},4V276`, class: "now" });
    shape(picture, "path", { d: `M${now - 5},0h10l-5,7Z`, class: "now-tip" });
    byId("scan-caption").textContent =
      `Every impulse that was walked, ${pushWords(angles[cell.angle])} at ${plain(phases[cell.phase])} of the step: ` +
      `a tall bar recovers, a low one falls. Limit ${newtons(Number(cell.limit.toFixed(1)))}, survived ${newtons(cell.survived)}.`;
  }

  // ---- the polar map of one phase ----
  /** Seen from above: angle 0 is up, 90 is to the left. */
  const point = (angle, radius) => {
    const turn = (angle * Math.PI) / 180;
    return [-Math.sin(turn) * radius, -Math.cos(turn) * radius];
  };
  function drawPolar() {
    const picture = byId("polar");
    picture.replaceChildren();
    const scale = 200 / top;
    const row = angles.map((_, angle) => cellAt(state.phase, angle));
    const outline = (value) => `M${row.map((cell) => point(angles[cell.angle], value(cell) * scale).map((v) => v.toFixed(1)).join(",")).join("L")}Z`;
    for (const tick of ticksOf(0, top, 4).slice(1)) shape(picture, "circle", { r: tick * scale, class: "ring" });
    for (const [name, angle] of Object.entries(data.directions)) {
      const [x, y] = point(angle, 218);
      shape(picture, "line", { x2: x, y2: y, class: "ring" });
      const turn = { outward: -90, inward: 90 }[name] ?? 0;
      const [atX, atY] = point(angle, 232);
      shape(picture, "text", { transform: `translate(${atX},${atY}) rotate(${turn})`, class: "way" }, name);
    }
    shape(picture, "path", { d: outline((cell) => cell.limit), class: "reach finite" });
    shape(picture, "path", { d: outline((cell) => cell.limit), class: "limit" });
    shape(picture, "path", { d: outline((cell) => cell.causal), class: "limit causal" });
    shape(picture, "path", { d: outline((cell) => cell.fixed), class: "limit fixed" });
    shape(picture, "path", { d: outline((cell) => cell.survived), class: "survived" });
    const free = [225, 315, 135, 45].map((angle) => row.reduce((best, cell) => (Math.abs(angles[cell.angle] - angle) < Math.abs(angles[best.angle] - angle) ? cell : best)))
      .reduce((low, cell) => (cell.limit < low.limit ? cell : low));
    for (const tick of ticksOf(0, top, 4).slice(1)) {
      const [x, y] = point(angles[free.angle], tick * scale);
      shape(picture, "text", { x, y, class: "radius" }, plain(tick));
    }
    const cell = chosen();
    const [x, y] = point(angles[cell.angle], 212);
    shape(picture, "line", { x2: x, y2: y, class: "now" });
    const [atX, atY] = point(angles[cell.angle], cell.survived * scale);
    shape(picture, "circle", { cx: atX, cy: atY, r: 6, class: "spot" });
    byId("polar-caption").textContent =
      `Largest survived impulse [N s] at ${plain(phases[state.phase])} of the step, seen from above, and the limit around it.`;
  }

  // ---- the reader's choice ----
  const sliders = {
    impulse: { most: () => Math.floor(top / step / stride), get: () => Math.round(state.number / stride), set: (v) => { state.number = v * stride; }, text: () => newtons(state.number * step) },
    phase: { most: () => phases.length - 1, get: () => state.phase, set: (v) => { state.phase = v; }, text: () => plain(phases[state.phase]) },
    angle: { most: () => angles.length - 1, get: () => state.angle, set: (v) => { state.angle = v; }, text: () => angleWords(angles[state.angle]) },
  };
  function refresh() {
    for (const input of document.querySelectorAll("input[name=show]")) input.checked = input.value === state.show;
    for (const [id, slider] of Object.entries(sliders)) {
      byId(id).value = slider.get();
      byId(id).setAttribute("aria-valuetext", slider.text());
      byId(`${id}-value`).textContent = slider.text();
    }
    colourMap();
    drawScale();
    drawScan();
    drawPolar();
    byId("said").textContent = describe(chosen(), state.number);
    const asked = { show: state.show, phase: plain(phases[state.phase]), angle: plain(angles[state.angle], 4), impulse: plain(state.number * step, 4) };
    history.replaceState(null, "", `#${new URLSearchParams(asked)}`);
  }
  function readAddress() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const nearest = (values, value) => values.reduce((best, other, index) => (Math.abs(other - value) < Math.abs(values[best] - value) ? index : best), 0);
    const number = (key) => (asked.has(key) && Number.isFinite(Number(asked.get(key))) ? Number(asked.get(key)) : null);
    if (Object.hasOwn(shows, asked.get("show") ?? "")) state.show = asked.get("show");
    if (number("phase") !== null) state.phase = nearest(phases, number("phase"));
    if (number("angle") !== null) state.angle = nearest(angles, number("angle"));
    if (number("impulse") !== null) state.number = stride * Math.min(sliders.impulse.most(), Math.max(0, Math.round(number("impulse") / step / stride)));
  }
  const under = (event) => {
    const around = byId("map").getBoundingClientRect();
    const x = ((event.clientX - around.left) / around.width) * box.width;
    const y = ((event.clientY - around.top) / around.height) * box.height;
    const angle = Math.floor((x - box.left) / across());
    const phase = Math.floor((box.height - box.bottom - y) / along());
    const inside = angle >= 0 && angle < angles.length && phase >= 0 && phase < phases.length;
    return inside ? cellAt(phase, angle) : null;
  };
  function hover(event) {
    const cell = under(event);
    const tip = byId("tip");
    tip.hidden = cell === null;
    if (cell === null) return;
    const lines = [
      `${angleWords(angles[cell.angle])}, ${plain(phases[cell.phase])} of the step`,
      `survives ${newtons(cell.survived)}${Number.isNaN(cell.share) ? "" : `, ${percent(cell.share)} of the limit`}`,
    ];
    const show = shows[state.show];
    const value = show.value(cell, state.number);
    if (show.moves) {
      const walk = walkAt(cell, state.number);
      const when = newtons(state.number * step);
      if (state.number * step > cell.limit) lines.push(`${when}: above the limit`);
      else lines.push(Number.isNaN(value) ? `${when}: ${pushMap.fates[walk.fate]}` : `${when}: ${show.words.toLowerCase()} ${show.text(value)}${show.whole ? "" : ` ${show.unit}`}`);
    }
    tip.replaceChildren(...lines.map((line) => Object.assign(document.createElement("span"), { textContent: line })));
    const around = byId("map").getBoundingClientRect();
    const left = event.clientX - around.left - tip.offsetWidth / 2;
    tip.style.left = `${Math.max(0, Math.min(left, around.width - tip.offsetWidth))}px`;
    const above = event.clientY - around.top;
    tip.style.top = `${above > tip.offsetHeight + 14 ? above - tip.offsetHeight - 12 : above + 18}px`;
  }
  function choose(event) {
    const cell = under(event);
    if (cell === null) return;
    [state.phase, state.angle] = [cell.phase, cell.angle];
    refresh();
  }
  function press(event) {
    const turn = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    const next = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? 0;
    if (!turn && !next) return;
    event.preventDefault();
    state.angle = (state.angle + turn + angles.length) % angles.length;
    state.phase = Math.min(phases.length - 1, Math.max(0, state.phase + next));
    refresh();
  }
  function redraw() {
    layMap();
    refresh();
  }

  const weakest = cells.reduce((least, cell) => (cell.share < least.share ? cell : least));
  [state.phase, state.angle] = [weakest.phase, weakest.angle];
  state.number = stride * Math.floor(weakest.survived / step / stride);
  readAddress();
  for (const [id, slider] of Object.entries(sliders)) {
    byId(id).max = slider.most();
    byId(id).addEventListener("input", (event) => { slider.set(Number(event.target.value)); refresh(); });
  }
  byId("show").addEventListener("change", (event) => { state.show = event.target.value; refresh(); });
  byId("map").addEventListener("pointermove", hover);
  byId("map").addEventListener("pointerleave", () => { byId("tip").hidden = true; });
  byId("map").addEventListener("click", choose);
  byId("map").addEventListener("keydown", press);
  addEventListener("hashchange", () => { readAddress(); refresh(); });
  addEventListener("resize", redraw);
  document.documentElement.classList.add("live");
  redraw();
})();
