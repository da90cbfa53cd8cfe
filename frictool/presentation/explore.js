"use strict";
/* Charts of a page: each <svg> with data (chart_data.py) is shown as uPlot charts that a reader can
   zoom and read. Without this script, and on paper, the <svg> is shown. */
(() => {
  const GAP = 65535, STEPS = 65534, NEAREST = 8, REACH = 40;
  const GRID = "#e3e7ec", INK = "#1d2733";
  const charts = [];

  /* the values of a signal; on a logarithmic axis their decimal logarithms are stored */
  function unpack([low, high, text], logarithmic) {
    const bytes = Uint8Array.from(atob(text), one => one.charCodeAt(0));
    const steps = new DataView(bytes.buffer), out = new Float64Array(bytes.length / 2);
    const span = (high - low || 1) / STEPS;
    for (let k = 0; k < out.length; k++) {
      const step = steps.getUint16(2 * k, true);
      const value = step === GAP ? NaN : low + step * span;
      out[k] = logarithmic ? 10 ** value : value;
    }
    return out;
  }

  function rises(values) {
    for (let k = 1; k < values.length; k++) if (!(values[k] >= values[k - 1])) return false;
    return true;
  }

  /* "position [rad]" -> its unit */
  const unit = label => (label.match(/\[([^\]]*)\]\s*$/) || ["", ""])[1];
  const quantity = label => label.replace(/\s*\[[^\]]*\]\s*$/, "");

  function outline(u, i) {
    const part = u.parts[i], [xs, ys] = u.data[i], path = new Path2D();
    const box = u.bbox, right = box.left + box.width, bottom = box.top + box.height;
    const px = value => u.valToPos(value, "x", true), py = value => u.valToPos(value, "y", true);
    const clipped = value => Math.max(-1e5, Math.min(1e5, value));
    if (part.kind === "horizontal") {
      path.moveTo(box.left, py(ys[0])); path.lineTo(right, py(ys[0]));
    } else if (part.kind === "vertical") {
      path.moveTo(px(xs[0]), box.top); path.lineTo(px(xs[0]), bottom);
    } else if (part.kind === "across") {
      const a = py(Math.min(...ys)), b = py(Math.max(...ys));
      path.rect(box.left, clipped(b), box.width, clipped(a) - clipped(b));
    } else if (part.kind === "along") {
      const a = px(Math.min(...xs)), b = px(Math.max(...xs));
      path.rect(clipped(a), box.top, clipped(b) - clipped(a), box.height);
    } else if (part.kind === "points") {
      const half = devicePixelRatio * Math.min(2, Math.max(1, part.width * 0.5));
      for (let k = 0; k < xs.length; k++) {
        const x = px(xs[k]), y = py(ys[k]);
        if (x >= box.left && x <= right && y >= box.top && y <= bottom)
          path.rect(x - half, y - half, 2 * half, 2 * half);
      }
    } else {
      let pen = false;
      for (let k = 0; k < xs.length; k++) {
        if (Number.isNaN(xs[k]) || Number.isNaN(ys[k])) { pen = false; continue; }
        const x = clipped(px(xs[k])), y = clipped(py(ys[k]));
        if (pen) path.lineTo(x, y); else path.moveTo(x, y);
        pen = true;
      }
    }
    const filled = ["area", "across", "along", "points"].includes(part.kind);
    return { stroke: filled ? null : path, fill: filled ? path : null, clip: null, band: null,
             gaps: null, flags: 1 };
  }

  /* index of the sample of a curve that is nearest to the mouse, or null */
  function nearest(u, i) {
    const part = u.parts[i], [xs, ys] = u.data[i], { left, top } = u.cursor;
    if (!["line", "points"].includes(part.kind) || !u.series[i].show || left < 0) return null;
    if (part.rises) {
      const at = u.posToVal(left, "x");
      if (at < xs[0] || at > xs[xs.length - 1]) return null;
      let low = 0, high = xs.length - 1;
      while (high - low > 1) { const mid = (low + high) >> 1; if (xs[mid] < at) low = mid; else high = mid; }
      return at - xs[low] < xs[high] - at ? low : high;
    }
    let best = null, least = REACH * REACH;
    for (let k = 0; k < xs.length; k++) {
      const dx = u.valToPos(xs[k], "x") - left, dy = u.valToPos(ys[k], "y") - top;
      const distance = dx * dx + dy * dy;
      if (distance < least) { least = distance; best = k; }
    }
    return best;
  }

  function shown(value, span) {
    if (!Number.isFinite(value)) return "–";
    const digits = Math.max(3, Math.min(9, 3 + Math.ceil(Math.log10(Math.abs(value) / span + 1e-12))));
    return String(Number(value.toPrecision(digits)));
  }

  function readout(u) {
    const box = u.readout, { left, top, idxs } = u.cursor;
    if (left == null || left < 0 || !u.mouse) { box.hidden = true; return; }
    const rows = [];
    for (let i = 1; i < u.parts.length; i++) {
      const at = idxs[i];
      if (at == null || !["line", "points"].includes(u.parts[i].kind)) continue;
      const x = u.data[i][0][at], y = u.data[i][1][at];
      if (Number.isNaN(y)) continue;
      rows.push({ part: u.parts[i], x, y, distance: Math.abs(u.valToPos(y, "y") - top) });
    }
    rows.sort((a, b) => a.distance - b.distance);
    const near = rows.slice(0, NEAREST);
    box.replaceChildren();
    if (!near.length) { box.hidden = true; return; }
    const view = [u.scales.x.max - u.scales.x.min, u.scales.y.max - u.scales.y.min];
    const line = (text, colour) => {
      const row = box.appendChild(document.createElement("div"));
      if (colour) {
        const mark = row.appendChild(document.createElement("span"));
        mark.className = "mark"; mark.style.background = colour;
      }
      row.append(text);
    };
    line(`${quantity(u.texts.x)} ${shown(near[0].x, view[0])} ${unit(u.texts.x)}`);
    for (const { part, y } of near)
      line(`${part.label || quantity(u.texts.y)}: ${shown(y, view[1])} ${unit(u.texts.y)}`, part.colour);
    box.hidden = false;
    const width = u.over.clientWidth;
    box.style.left = left < width / 2 ? `${left + 14}px` : "";
    box.style.right = left < width / 2 ? "" : `${width - left + 14}px`;
    box.style.top = "4px";
  }

  /* charts with one abscissa: those of a figure, and all charts over time of the page */
  const linked = u => charts.filter(one => one.figure === u.figure || (u.time && one.time && u.texts.x === one.texts.x));

  function follow(u) {
    if (u.following) return;
    const { min, max } = u.scales.x;
    for (const one of linked(u)) {
      if (one === u || (one.scales.x.min === min && one.scales.x.max === max)) continue;
      one.following = true;
      one.batch(() => one.setScale("x", { min, max }));
      one.following = false;
    }
  }

  function whole(u) {
    for (const one of linked(u)) {
      one.following = true;
      one.view = { x: one.full.x, y: one.full.y };
      one.batch(() => { one.setScale("x", span(one.full.x)); one.setScale("y", span(one.full.y)); });
      one.following = false;
    }
  }
  const span = ([min, max]) => ({ min, max });

  function build(host, figure, panel, last, height) {
    const parts = [null, ...panel.series];
    const data = [null, ...panel.series.map(one => one.data.map((packed, k) => unpack(packed, panel.log[k])))];
    for (let i = 1; i < parts.length; i++) parts[i].rises = rises(data[i][0]);
    const div = host.appendChild(document.createElement("div"));
    div.className = "panel";
    const value = (_, values) => {
      const small = Math.max(...values.map(Math.abs)) < 1e-3;
      return values.map(one => one == null ? "" : small && one ? Number(one.toPrecision(6)).toExponential()
                                               : String(Number(one.toPrecision(6))));
    };
    const axis = { stroke: INK, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
                   grid: { stroke: GRID, width: 1 }, ticks: { stroke: GRID, width: 1 }, values: value };
    const texts = { x: panel.x || host.dataset.x || "", y: panel.y };
    const side = {
      size: (_, texts) => 16 + 8 * Math.max(4, ...(texts || []).map(one => one.length)),
      space: (u, i, low, high, room) => Math.min(30, room / 6),
      ...(panel.ticks ? { splits: () => panel.ticks[0], values: () => panel.ticks[1] } : {}) };
    const ordered = ([a, b]) => a < b ? [a, b] : [b, a];
    const own = { x: ordered(panel.xlim), y: ordered(panel.ylim) };
    const options = {
      mode: 2, width: host.clientWidth, height, legend: { show: false }, title: "",
      padding: [8, 10, 0, 0],
      cursor: {
        drag: { x: true, y: true, uni: 24, setScale: true }, dataIdx: nearest,
        points: { show: false }, bind: { dblclick: u => () => { whole(u); return null; } },
      },
      scales: Object.fromEntries(["x", "y"].map((key, k) => [key, {
        time: false, dir: panel[key + "lim"][0] < panel[key + "lim"][1] ? 1 : -1, distr: panel.log[k] ? 3 : 1, range: u => (u.view || own)[key] }])),
      axes: [{ ...axis, scale: "x", label: last ? texts.x : undefined, size: 34, labelSize: 18,
               space: 58 },
             { ...axis, scale: "y", label: texts.y, labelSize: 20, ...side }],
      series: parts.map((one, i) => i === 0 ? {} : {
        label: one.label, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        stroke: one.colour, fill: one.colour, width: one.width || 0, dash: one.dash || undefined,
        alpha: one.alpha, paths: outline, points: { show: false } }),
      hooks: {
        setScale: [(u, key) => {
          u.view = { ...(u.view || own), [key]: [u.scales[key].min, u.scales[key].max] };
          if (key === "x" && u.figure) follow(u);
        }],
        setCursor: [readout],
      },
    };
    const u = new uPlot({ ...options, hooks: { ...options.hooks, init: [one => { one.parts = parts; }] } },
                        data, div);
    u.texts = texts; u.full = own; u.time = /^time/.test(texts.x);
    u.readout = u.over.appendChild(document.createElement("div"));
    u.readout.className = "readout"; u.readout.hidden = true;
    u.over.addEventListener("mouseenter", () => { u.mouse = true; });
    u.over.addEventListener("mouseleave", () => { u.mouse = false; u.readout.hidden = true; });
    u.figure = figure;
    charts.push(u);
    return u;
  }

  function legend(host, own) {
    const seen = new Map();
    for (const u of own) u.parts.forEach((one, i) => {
      if (i && one.group) (seen.get(one.group) || seen.set(one.group, []).get(one.group)).push([u, i]);
    });
    const list = document.createElement("div");
    list.className = "toggles";
    for (const [label, members] of seen) {
      if (seen.size < 2) break;
      const button = list.appendChild(document.createElement("button"));
      const mark = button.appendChild(document.createElement("span"));
      mark.className = "mark"; mark.style.background = members[0][0].parts[members[0][1]].colour;
      button.type = "button"; button.append(label); button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        const show = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(show));
        for (const [u, i] of members) u.setSeries(i, { show });
      });
    }
    return list;
  }

  function tools(host, own) {
    const bar = document.createElement("div");
    bar.className = "tools";
    const add = (text, action) => {
      const button = bar.appendChild(document.createElement("button"));
      button.type = "button"; button.textContent = text; button.addEventListener("click", action);
    };
    for (const view of JSON.parse(host.closest("figure").dataset.views || "[]"))
      add(view.name, () => go(own, view));
    add("whole figure", () => own.forEach(whole));
    return bar;
  }

  /* show a range: panel number, xlim, ylim */
  function go(own, view) {
    const u = own[view.panel || 0];
    u.following = true;
    if (view.xlim) u.setScale("x", span(view.xlim));
    if (view.ylim) u.setScale("y", span(view.ylim));
    u.following = false;
    if (view.xlim) follow(u);
  }

  function show(svg) {
    const figure = svg.closest("figure"), text = svg.querySelector("metadata.chart-data");
    if (!text) return;
    const panels = JSON.parse(text.textContent), host = document.createElement("div");
    host.className = "chart";
    svg.before(host);
    const box = svg.viewBox.baseVal, room = host.clientWidth;
    const total = Math.max(230, Math.min(640, room * box.height / box.width));
    const sum = panels.reduce((all, one) => all + one.height, 0);
    host.dataset.x = panels[panels.length - 1].x;
    const own = panels.map((panel, k) => build(
      host, figure, panel, k === panels.length - 1,
      Math.max(120, Math.round((total - 50) * panel.height / sum) + (k === panels.length - 1 ? 50 : 22))));
    host.append(legend(host, own), tools(host, own));
    svg.classList.add("static");
    const heights = own.map(u => u.height);
    new ResizeObserver(() => own.forEach((u, k) => {
      if (host.clientWidth > 0 && host.clientWidth !== u.width)
        u.setSize({ width: host.clientWidth, height: heights[k] });
    })).observe(host);
    figure.charts = [...(figure.charts || []), ...own];
  }

  for (const svg of document.querySelectorAll("figure > svg")) show(svg);
  for (const link of document.querySelectorAll("a[data-view]"))
    link.addEventListener("click", () => {
      const figure = document.getElementById(link.hash.slice(1));
      if (figure && figure.charts) go(figure.charts, JSON.parse(link.dataset.view));
    });
})();
