// The gallery: frames with outlines, filters over their objects, and a dialog with methods side by side, depth and 3D.
let gallery;
const TRUE = "#2ecc71";
const FILTERS = ["class", "distance", "visibility", "light", "failure"];
const BATCH = 24;
const state = {};
let order = [];
let open = 0;

const svg = (tag, attributes, ...children) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
};

// The values by which a filter finds an object; failures are those of the chosen method, or of all.
function tagsOf(object, filter) {
  if (filter !== "failure") return [object.tags[filter]].filter(Boolean);
  const names = state.method ? [state.method] : Object.keys(object.answers);
  return names.filter((name) => name in object.answers).map((name) => object.answers[name].failure);
}

const isIn = ({ values }, { index, low, high }) => values[index] !== null && values[index] >= low && values[index] < high;
const matches = (object) => FILTERS.every((name) => !state[name] || tagsOf(object, name).includes(state[name]))
  && (!state.range || isIn(object, state.range));
const isFiltered = () => state.range || FILTERS.some((name) => state[name]);
const isShown = (frame) => (!state.data || frame.data === state.data) && (!isFiltered() || frame.objects.some(matches));

function picture(frame, methods) {
  const [width, height] = frame.size;
  const lines = svg("svg", { viewBox: `-0.5 -0.5 ${width} ${height}`, preserveAspectRatio: "none" });
  for (const object of frame.objects) {
    const other = isFiltered() && !matches(object) ? "other" : "";
    const name = svg("title", {});
    name.textContent = describe(object);
    lines.append(svg("path", { d: object.path, class: other }, name));
    for (const method of methods) {
      const path = object.answers[method]?.path;
      if (path) lines.append(svg("path", { d: path, class: other, style: `stroke: ${gallery.methods[method]}` }));
    }
  }
  const image = element("img", { src: frame.picture, alt: frame.name, loading: "lazy", decoding: "async", width, height });
  return element("div", { className: "picture" }, image, lines);
}

function describe({ tags, values: [distance, visible, lux] }) {
  const facts = [distance !== null && `${distance} m`, visible !== null && `${Math.round(100 * visible)} % visible`,
    lux !== null && `${lux} lx`];
  return [tags.class, ...facts.filter(Boolean)].join(", ");
}

function show() {
  order = gallery.frames.filter(isShown);
  if (state.sort) order.sort((a, b) => b.badness - a.badness);
  document.getElementById("frames").replaceChildren();
  add();
  const range = state.range ? ` with an object of ${state.range.label}` : "";
  document.getElementById("count").textContent = `${order.length} of ${gallery.frames.length} frames${range}`;
}

// Cards are made when they come into sight, some at a time.
function add() {
  const place = document.getElementById("frames");
  const methods = state.method ? [state.method] : Object.keys(gallery.methods);
  const start = place.childElementCount;
  order.slice(start, start + BATCH).forEach((frame, number) => {
    const open = () => enlarge(start + number);
    const made = element("figure", { tabIndex: 0, onclick: open }, picture(frame, methods),
      element("figcaption", { className: "soft", textContent: `${frame.name}: ${frame.objects.length} objects` }));
    made.onkeydown = (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault(); // else the key presses the first button of the dialog
      open();
    };
    place.append(made);
  });
}

function choices() {
  const form = document.getElementById("filters");
  const select = (name, title, options) => form.append(element("select", {
    name, ariaLabel: title, onchange: (event) => { state[name] = event.target.value; show(); },
  }, new Option(`${title}: all`, ""), ...options.map(([text, value]) => new Option(text, value))));
  const datasets = [...new Set(gallery.frames.map((frame) => frame.data))];
  if (datasets.length > 1) select("data", "data", datasets.map((name) => [name, name]));
  for (const name of FILTERS) {
    const counts = {};
    for (const tag of gallery.frames.flatMap((frame) => frame.objects.flatMap((item) => tagsOf(item, name)))) {
      counts[tag] = (counts[tag] ?? 0) + 1;
    }
    const tags = Object.keys(counts).sort(compared);
    if (tags.length) select(name, name, tags.map((tag) => [`${tag} (${counts[tag]})`, tag]));
  }
  const methods = Object.keys(gallery.methods);
  if (methods.length) {
    select("method", "method", methods.map((name) => [name, name]));
    form.append(element("label", {}, element("input", {
      type: "checkbox", name: "sort", onchange: (event) => { state.sort = event.target.checked; show(); },
    }), " worst first"));
  }
  form.append(element("button", { type: "button", textContent: "show all", onclick: () => { clear(); show(); } }));
}

function clear() {
  const form = document.getElementById("filters");
  form.reset();
  for (const name of Object.keys(state)) delete state[name];
  return form;
}

// Show the objects of a group of a table: of a class, or with a value between two numbers.
function only(kind, label) {
  const form = clear();
  if (kind === "class") form.elements.class.value = state.class = label;
  else {
    const [low, high = Infinity] = label.match(/[\d.]+/g).map(Number);
    state.range = { index: Number(kind), low, high, label };
  }
  show();
}

function enlarge(at) {
  open = (at + order.length) % order.length;
  const frame = order[open];
  const dialog = document.getElementById("frame");
  const methods = Object.keys(gallery.methods).filter((name) => frame.objects.some((item) => name in item.answers));
  const figure = (names, caption) => element("figure", {}, picture(frame, names), element("figcaption", { textContent: caption }));
  dialog.querySelector("h3").textContent = `${frame.data}, ${frame.name}`;
  const panels = dialog.querySelector(".panels");
  panels.querySelectorAll("figure").forEach((item) => item.remove());
  panels.prepend(...(methods.length ? methods.map((name) => figure([name], name)) : [figure([], "")]));
  const head = ["object", ...methods].map((name) => element("th", { textContent: name }));
  const rows = frame.objects.map((object) => element("tr", {}, element("td", { textContent: describe(object) }),
    ...methods.map((name) => element("td", { textContent: object.answers[name]?.words ?? "" }))));
  dialog.querySelector(".scroll").replaceChildren(element("table", {}, element("tr", {}, ...head), ...rows));
  if (!dialog.open) dialog.showModal();
  inSpace(frame, methods);
}

// The depth image in metres, row by row, and the colours of its pixels.
async function depthOf({ png, pixels, scale: [nearest, farthest, steps] }) {
  const [codes, colors] = await Promise.all([png, pixels].map(async (src) => {
    const image = element("img", { src });
    await image.decode();
    const canvas = element("canvas", { width: image.width, height: image.height });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return { width: image.width, height: image.height, data: context.getImageData(0, 0, image.width, image.height).data };
  }));
  const [width, height] = [colors.width, colors.height];
  const metres = Array.from({ length: width * height }, (_, at) => {
    const code = 16 * codes.data[4 * at] + codes.data[4 * (at + width * height)];
    return code && nearest * (farthest / nearest) ** ((code - 1) / (steps - 1));
  });
  return { width, height, metres, colors: colors.data };
}

// Plotly's axes are x right, y ahead, z up; those of the camera x right, y down, z ahead.
const trace = (points, more) => ({ type: "scatter3d", x: points.map((p) => p?.[0]), y: points.map((p) => p?.[2]),
  z: points.map((p) => p && -p[1]), hoverinfo: "name", ...more });
const box = (corners) => (corners.length ? gallery.edges.flatMap(([a, b]) => [corners[a], corners[b], null]) : []);

function clouds(depth, { metres, width, colors }) {
  const [fx, fy, cx, cy] = depth.camera;
  const points = [];
  const color = [];
  metres.forEach((z, at) => {
    if (!z) return;
    points.push([((at % width) - cx) / fx * z, (Math.floor(at / width) - cy) / fy * z, z]);
    color.push(`rgb(${colors[4 * at]},${colors[4 * at + 1]},${colors[4 * at + 2]})`);
  });
  return trace(points, { name: "cloud", mode: "markers", marker: { size: 2, color } });
}

function sweep(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const values = new Int16Array(bytes.buffer);
  const points = Array.from({ length: values.length / 3 }, (_, at) => [0, 1, 2].map((k) => values[3 * at + k] / 100));
  return trace(points, { name: "LiDAR", mode: "markers", marker: { size: 1.5, color: "#e0457b" } });
}

// The first view: from behind the camera at the objects; Plotly measures in the longest side of all that is there.
function viewOf(traces, frame) {
  const spans = ["x", "y", "z"].map((axis) => {
    const values = traces.flatMap((item) => item[axis]).filter((value) => value != null);
    return [Math.min(...values), Math.max(...values)];
  });
  const longest = Math.max(...spans.map(([low, high]) => high - low), 1e-3);
  const near = frame.objects.flatMap((item) => item.corners);
  const at = near.length ? [0, 2, 1].map((k) => near.reduce((sum, p) => sum + p[k], 0) / near.length) : null;
  const center = spans.map(([low, high], k) => (at ? (k === 2 ? -at[k] : at[k]) - (low + high) / 2 : 0) / longest);
  const away = at ? Math.min(1.2, Math.max(0.2, 1.4 * Math.hypot(...at) / longest)) : 1.2;
  const eye = { x: center[0], y: center[1] - 0.9 * away, z: center[2] + 0.35 * away };
  const [x, y, z] = center;
  return { camera: { eye, center: { x, y, z }, up: { x: 0, y: 0, z: 1 } }, aspectmode: "manual",
    aspectratio: Object.fromEntries(["x", "y", "z"].map((axis, k) => [axis, Math.max(spans[k][1] - spans[k][0], 1e-3) / longest])),
    ...Object.fromEntries(["x", "y", "z"].map((axis, k) => [`${axis}axis`, { range: spans[k], showticklabels: false,
      title: { text: "" }, showbackground: false }])) };
}

async function inSpace(frame, methods) {
  await library;
  const [space, flat] = ["space", "depth"].map((id) => document.getElementById(id));
  for (const place of [space, flat]) Plotly.purge(place);
  const line = (points, name, color, more = {}) => trace(points, { name, mode: "lines", line: { color, width: 4 }, ...more });
  const traces = [line(frame.objects.flatMap((item) => box(item.corners)), "ground truth", TRUE)];
  for (const name of methods) {
    const points = frame.objects.flatMap((item) => box(item.answers[name]?.corners ?? []));
    traces.push(line(points, name, gallery.methods[name]));
  }
  const tracks = frame.objects.flatMap((item) => (item.way.length ? [...item.way, null] : []));
  if (tracks.length) traces.push(line(tracks, "tracks", "#c58bff"));
  if (frame.way.length) traces.push(line(frame.way, "way of the camera", "#e0b000", { mode: "lines+markers", marker: { size: 3 } }));
  if (frame.sweep) traces.push(sweep(frame.sweep));
  const image = frame.depth && await depthOf(frame.depth);
  if (frame !== order[open]) return;
  if (image) {
    traces.push(clouds(frame.depth, image));
    const z = Array.from({ length: image.height }, (_, row) =>
      image.metres.slice(row * image.width, (row + 1) * image.width).map((value) => value || null));
    Plotly.newPlot(flat, [{ type: "heatmap", z, colorscale: "Portland", reversescale: true, hovertemplate: "%{z:.2f} m<extra></extra>",
      colorbar: { ticksuffix: " m", thickness: 12 } }], layoutOf({ height: flat.clientHeight,
      margin: { l: 8, r: 8, t: 8, b: 8 }, xaxis: { visible: false },
      yaxis: { visible: false, autorange: "reversed", scaleanchor: "x" } }), PLOT);
  }
  if (!traces.some(({ x }) => x.length)) return;
  const scene = viewOf(traces, frame);
  space.first = scene.camera;
  Plotly.newPlot(space, traces, layoutOf({ height: space.clientHeight, margin: { l: 0, r: 0, t: 0, b: 0 }, scene }), PLOT);
}

// Keys turn (arrows) and zoom (+ and -) the view in space; 0 goes back to the first view.
function turn(event) {
  const space = event.currentTarget;
  const moved = { ArrowLeft: [1, -0.1, 0], ArrowRight: [1, 0.1, 0], ArrowUp: [1, 0, 0.1], ArrowDown: [1, 0, -0.1],
    "+": [0.87, 0, 0], "=": [0.87, 0, 0], "-": [1.15, 0, 0], 0: [1, 0, 0] }[event.key];
  if (!moved || !space.first) return;
  event.preventDefault();
  event.stopPropagation();
  const camera = event.key === "0" ? space.first : space.layout.scene.camera;
  const { eye, center } = camera;
  const [x, y, z] = ["x", "y", "z"].map((axis) => eye[axis] - center[axis]);
  const radius = Math.hypot(x, y, z) * moved[0];
  const round = Math.atan2(y, x) + moved[1];
  const up = Math.max(-1.5, Math.min(1.5, Math.asin(z / Math.hypot(x, y, z)) + moved[2]));
  Plotly.relayout(space, { "scene.camera": { ...camera, eye: { x: center.x + radius * Math.cos(round) * Math.cos(up),
    y: center.y + radius * Math.sin(round) * Math.cos(up), z: center.z + radius * Math.sin(up) } } });
}

async function start() {
  gallery = JSON.parse(await unpacked("gallery-data"));
  choices();
  show();
  const dialog = document.getElementById("frame");
  document.getElementById("space").onkeydown = turn;
  new IntersectionObserver(([{ isIntersecting }]) => isIntersecting && add(), { rootMargin: "900px" })
    .observe(document.getElementById("more"));
  for (const button of dialog.querySelectorAll("button[type=button]")) button.onclick = () => enlarge(open + Number(button.value));
  dialog.onkeydown = ({ key }) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
    if (step) enlarge(open + step);
  };
  for (const cell of document.querySelectorAll("table[data-groups] tbody td:first-child")) {
    const [kind, label] = [cell.closest("table").dataset.groups, cell.textContent];
    cell.replaceChildren(element("a", { href: "#gallery", textContent: label, onclick: () => only(kind, label) }));
  }
  document.querySelectorAll("[data-frame]").forEach((item) => {
    item.onclick = () => {
      const at = order.findIndex((frame) => `${frame.data}, ${frame.name}` === item.dataset.frame);
      if (at >= 0) enlarge(at);
    };
  });
}

if (document.getElementById("gallery-data")) start();
