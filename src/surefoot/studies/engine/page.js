// What pages that draw themselves share: words, elements, polar maps, choices and their address.
"use strict";

const page = (() => {
  const byId = (id) => document.getElementById(id);
  const spelled = new Map([["inf", Infinity], ["nan", NaN]]);
  const data = JSON.parse(byId("data").textContent, (_, value) => (spelled.has(value) ? spelled.get(value) : value));
  const { angles, choices, directions } = data;

  // ---- words ----
  const plain = (value, digits = 3) => String(Number(value.toPrecision(digits)));
  const percent = (share) => (Number.isNaN(share) ? "–" : `${(100 * share).toFixed(0)} %`);

  // ---- elements ----
  function dressed(node, attributes, children) {
    for (const [key, value] of Object.entries(attributes))
      node.setAttribute(key, typeof value === "number" ? Number(value.toFixed(2)) : value);
    node.append(...children);
    return node;
  }
  const element = (name, attributes = {}, ...children) =>
    dressed(document.createElement(name), attributes, children);
  const namespace = byId("map").namespaceURI;
  /** A part of a picture, appended to its parent. */
  function shape(parent, name, attributes, ...children) {
    const node = dressed(document.createElementNS(namespace, name), attributes, children);
    parent.append(node);
    return node;
  }
  /** Round values over a range, about as many as are wanted. */
  function ticks(min, max, wanted) {
    const rough = (max - min) / wanted || 1;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough * 0.999);
    const found = [];
    for (let tick = Math.ceil(min / step - 1e-9) * step; tick <= max + 1e-9; tick += step) found.push(Number(tick.toPrecision(6)));
    return found;
  }
  /** The path through points: a gap where one is NaN, closed if none is. */
  function path(points) {
    const whole = points.every(([x]) => !Number.isNaN(x));
    let text = "";
    let down = false;
    for (const [x, y] of whole ? points : [...points, points[0]]) {
      if (!Number.isNaN(x)) text += `${down ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`;
      down = !Number.isNaN(x);
    }
    return whole ? `${text}Z` : text;
  }
  /** The coordinates of an event in a picture. */
  function placeOf(event, picture) {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
    return [x, y];
  }
  /** Show lines of words beside a place of a picture, inside of it; hide them if there are none. */
  function showTip(picture, place, lines) {
    const tip = byId("tip");
    tip.hidden = lines.length === 0;
    if (tip.hidden) return;
    tip.replaceChildren(...lines.map((line) => element("span", {}, line)));
    const { x, y } = new DOMPoint(...place).matrixTransform(picture.getCTM());
    const room = picture.getBoundingClientRect().width - tip.offsetWidth;
    tip.style.left = `${Math.max(0, Math.min(x - tip.offsetWidth / 2, room))}px`;
    tip.style.top = `${y > tip.offsetHeight + 18 ? y - tip.offsetHeight - 14 : y + 16}px`;
  }

  // ---- polar maps, seen from above: angle 0 is up, 90 is to the left ----
  const wedge = 14;
  /** With few directions nothing is drawn between them but a guide. */
  const coarse = angles.length < 8;
  const nearest = (values, value) =>
    values.reduce((best, other, index) => (Math.abs(other - value) < Math.abs(values[best] - value) ? index : best), 0);
  function point(angle, radius) {
    const turn = (angle * Math.PI) / 180;
    return [-Math.sin(turn) * radius, -Math.cos(turn) * radius];
  }
  const around = (radii, scale) => path(radii.map((radius, index) => point(angles[index], radius * scale)));
  /** Draw limits, by their kinds: a radius for each direction. */
  function drawLimits(picture, limits, scale) {
    for (const [kind, radii] of Object.entries(limits)) {
      if (!coarse) {
        shape(picture, "path", { d: around(radii, scale), class: `limit area ${kind}` });
        continue;
      }
      radii.forEach((radius, index) => {
        if (Number.isNaN(radius)) return;
        const [from, to] = [-wedge, wedge].map((side) =>
          point(angles[index] + side, radius * scale).map((v) => v.toFixed(1)));
        const arc = `${from}A${radius * scale},${radius * scale} 0 0 0 ${to}`;
        if (kind === "finite") shape(picture, "path", { d: `M0,0L${arc}Z`, class: "reach" });
        shape(picture, "path", { d: `M${arc}`, class: `limit ${kind}` });
      });
    }
  }
  /** Draw a map: rings, directions, limits, whatever `draw(scale)` adds, and the radii of the rings over it. */
  function drawPolar(picture, limits, max, draw) {
    const scale = 200 / max;
    const rings = ticks(0, 1.08 * max, 3.5).slice(1);
    picture.replaceChildren();
    for (const ring of rings) shape(picture, "circle", { r: ring * scale, class: "ring" });
    for (const [name, angle] of Object.entries(directions)) {
      const [x, y] = point(angle, 218);
      shape(picture, "line", { x2: x, y2: y, class: "ring" });
      const transform = `translate(${point(angle, 232)}) rotate(${{ outward: -90, inward: 90 }[name] ?? 0})`;
      shape(picture, "text", { transform, class: "way" }, name);
    }
    drawLimits(picture, limits, scale);
    draw(scale);
    const near = (angle) => limits.finite[nearest(angles, angle)];
    const free = [225, 315, 135, 45].reduce((low, angle) => (near(angle) < near(low) ? angle : low));
    for (const ring of rings) {
      const [x, y] = point(free, ring * scale);
      shape(picture, "text", { x, y, class: "radius" }, plain(ring));
    }
  }

  // ---- choices: `state` has the index of the chosen value of each ----
  const state = {};
  const wordsOf = (key) => choices[key].words[state[key]];
  let shown = {};
  /** Draw the page, with the controls as the choices are, and put these behind its address. */
  function refresh() {
    for (const key of Object.keys(choices)) {
      const control = byId(key);
      for (const input of control.querySelectorAll("input")) input.checked = Number(input.value) === state[key];
      if (control.type !== "range") continue;
      control.value = state[key];
      control.setAttribute("aria-valuetext", wordsOf(key));
      byId(`${key}-value`).textContent = wordsOf(key);
    }
    shown.draw();
    const asked = Object.entries(choices).map(([key, { values }]) => [key, values[state[key]]]);
    const spoken = asked.map(([key, value]) => [key, value === Infinity ? "inf" : Number.isFinite(value) ? plain(value, 4) : value]);
    const address = new URLSearchParams([...spoken, ...Object.entries(shown.asked())]);
    history.replaceState(null, "", `#${address.toString().replaceAll("%2C", ",")}`);
  }
  function choose(changes) {
    Object.assign(state, changes);
    refresh();
  }
  function readAddress() {
    const asked = new URLSearchParams(location.hash.slice(1));
    for (const [key, { values }] of Object.entries(choices)) {
      const text = asked.get(key) ?? "";
      const value = spelled.get(text) ?? Number(text || NaN);
      const same = values.findIndex((one) => one === value || one === text);
      if (same >= 0) state[key] = same;
      else if (Number.isFinite(value)) state[key] = nearest(values, value);
    }
    shown.read(asked);
  }
  /** Build the controls and draw the page.
      own: `draw()`; perhaps `label(key, index)` on a button, and `asked()` and `read(asked)` of what else
      stands behind the address. */
  function start(own) {
    shown = { label: (key, index) => choices[key].words[index], asked: () => ({}), read: () => {}, ...own };
    for (const [key, { values, chosen }] of Object.entries(choices)) {
      const control = byId(key);
      state[key] = chosen;
      if (control.type === "range") {
        control.max = values.length - 1;
        control.addEventListener("input", () => choose({ [key]: Number(control.value) }));
        continue;
      }
      for (const index of values.keys()) {
        const input = element("input", { type: "radio", name: key, value: index });
        input.addEventListener("change", () => choose({ [key]: index }));
        control.append(element("label", {}, input, shown.label(key, index)));
      }
    }
    readAddress();
    addEventListener("hashchange", () => { readAddress(); refresh(); });
    document.documentElement.classList.add("live");
    refresh();
  }

  return {
    data, angles, state, byId, plain, percent, element, shape, ticks, path, placeOf, showTip, coarse, point, around,
    drawLimits, drawPolar, wordsOf, choose, refresh, start,
  };
})();
