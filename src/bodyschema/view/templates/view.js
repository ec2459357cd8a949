
"use strict";
// The scene of one result, drawn with WebGL 2 when something changes. Units m, z up, quaternions
// x y z w, matrices column by column.

const scene = JSON.parse(document.getElementById("scene").textContent);
const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const COLOURS = ["#3b2a8f", "#2f7fb8", "#35b07c", "#d9c22e", "#e0591b"];
const $ = (id) => document.getElementById(id);

function floats(text) { return new Float32Array(bytes(text).buffer); }
function bytes(text) { return Uint8Array.from(atob(text), (c) => c.charCodeAt(0)); }
function element(name, text, kind) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (kind) made.className = kind;
  return made;
}

// ---- numbers ---------------------------------------------------------------------------------
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const long = (a) => Math.hypot(...a);
const unit = (a) => { const n = long(a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };

function times(A, B) {
  const C = new Float32Array(16);
  for (let c = 0; c < 4; c++)
    for (let r = 0; r < 4; r++)
      for (let k = 0; k < 4; k++) C[4 * c + r] += A[4 * k + r] * B[4 * c + k];
  return C;
}
function columns(x, y, z, p) { return new Float32Array([...x, 0, ...y, 0, ...z, 0, ...p, 1]); }
function quaternionTimes(a, b) {
  const [ax, ay, az, aw] = a, [bx, by, bz, bw] = b;
  return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
}
function power(q, k) {
  const s = q[3] < 0 ? -1 : 1, half = Math.acos(Math.min(1, s * q[3])), n = Math.sin(half);
  const scale = n > 1e-9 ? Math.sin(k * half) / n : k;
  return [s * q[0] * scale, s * q[1] * scale, s * q[2] * scale, Math.cos(k * half)];
}
function posed(p, q) {
  const [x, y, z, w] = q;
  return columns([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)], p);
}
function moved(T, p) {
  return [0, 1, 2].map((r) => T[r] * p[0] + T[4 + r] * p[1] + T[8 + r] * p[2] + T[12 + r]);
}
/** Takes the unit cylinder along z, or a cone, from a to b. */
function between(a, b, radius) {
  const d = sub(b, a), z = unit(d), other = Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const x = unit(cross(other, z)), y = cross(z, x);
  return columns(x.map((v) => v * radius), y.map((v) => v * radius), d, a);
}

// ---- what is drawn ---------------------------------------------------------------------------
const n = scene.rows.length, F = scene.frames.length, size = scene.size;
const after = floats(scene.after), before = scene.before ? floats(scene.before) : null;
const state = { posture: 0, side: "after", yaw: 0.9, pitch: 0.35, distance: 3 * size, target: [0, 0, 0],
  factors: { ...scene.factors }, shown: {} };

function part(poses, k) {
  const at = 7 * (state.posture * F + k);
  return [Array.from(poses.subarray(at, at + 3)), Array.from(poses.subarray(at + 3, at + 7))];
}
function poseAfter(k) { return posed(...part(after, k)); }
/** The frame as it was modelled, its difference drawn `correction` times as large. */
function poseBefore(k) {
  const [p, q] = part(after, k), [pb, qb] = part(before, k), times = state.factors.correction;
  const turn = quaternionTimes(qb, [-q[0], -q[1], -q[2], q[3]]);
  return posed(add(p, sub(pb, p), times), quaternionTimes(power(turn, times), q));
}
function triple(values, k) { return Array.from(values.subarray(3 * k, 3 * k + 3)); }

for (const mark of scene.marks) {
  mark.places = floats(mark.places);
  mark.before = floats(mark.before);
  mark.after = floats(mark.after);
  if (mark.arrows) mark.arrows = mark.arrows.map(floats);
}
for (const e of scene.ellipsoids) { e.centre = floats(e.centre); e.axes = floats(e.axes); }
for (const f of scene.forces) { f.start = floats(f.start); f.vector = floats(f.vector); }

/** Largest error of a unit that has a colour of its own: 95 of 100 are smaller. */
function highest(unitName, side) {
  const all = scene.marks.filter((m) => m.unit === unitName)
    .flatMap((m) => Array.from(m[side]).filter((_, i) => !m.bad[i])).sort((a, b) => a - b);
  return all[Math.floor(0.95 * (all.length - 1))] || 1e-9;
}
function rgb(text) { return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255); }
const RAMP = COLOURS.map(rgb);
function coloured(share) {
  const t = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1), i = Math.min(Math.floor(t), RAMP.length - 2);
  return RAMP[i].map((v, k) => v + (t - i) * (RAMP[i + 1][k] - v));
}
function palette() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(["body", "line", "space", "before", "after", "bad", "mark", "doubtful"]
    .map((name) => [name, rgb(style.getPropertyValue("--" + name).trim())]));
}

// ---- WebGL -----------------------------------------------------------------------------------
const canvas = $("space");
const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
const SOLID = [`#version 300 es
in vec3 place; uniform mat4 view, model; out vec3 world;
void main() { vec4 w = model * vec4(place, 1.0); world = w.xyz; gl_Position = view * w; }`,
`#version 300 es
precision highp float; in vec3 world; uniform vec3 eye; uniform vec4 colour; out vec4 pixel;
void main() {
  vec3 normal = normalize(cross(dFdx(world), dFdy(world))), sight = normalize(eye - world);
  if (dot(normal, sight) < 0.0) normal = -normal;
  float light = 0.42 + 0.4 * max(dot(normal, sight), 0.0) + 0.18 * (0.5 + 0.5 * normal.z);
  pixel = vec4(colour.rgb * light, colour.a);
}`];
const DOTS = [`#version 300 es
in vec3 place; in vec4 tint; uniform mat4 view; uniform float scale; out vec4 c;
void main() { gl_Position = view * vec4(place, 1.0); gl_PointSize = scale * tint.a; c = vec4(tint.rgb, 1.0); }`,
`#version 300 es
precision highp float; in vec4 c; uniform float lines; out vec4 pixel;
void main() {
  float r = length(gl_PointCoord - 0.5);
  if (lines < 0.5 && r > 0.5) discard;
  pixel = vec4(lines < 0.5 && r > 0.38 ? vec3(1.0) : c.rgb, 1.0);
}`];

function program([vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  ["place", "tint"].forEach((name, k) => gl.bindAttribLocation(made, k, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const at = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const name = gl.getActiveUniform(made, k).name;
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}
function mesh(vertices, faces) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
  return { array, count: faces.length };
}
/** A surface of revolution round z; rings are [radius, height]. */
function turned(rings, sides) {
  const vertices = [], faces = [];
  rings.forEach(([r, z], i) => {
    for (let s = 0; s < sides; s++) {
      const a = (2 * Math.PI * s) / sides, t = (s + 1) % sides, k = i * sides;
      vertices.push(r * Math.cos(a), r * Math.sin(a), z);
      if (i) faces.push(k - sides + s, k - sides + t, k + s, k - sides + t, k + t, k + s);
    }
  });
  return mesh(new Float32Array(vertices), new Uint32Array(faces));
}
function makeMeshes() {
  const arc = Array.from({ length: 13 }, (_, i) => (Math.PI * i) / 12);
  return {
    ball: turned(arc.map((a) => [Math.sin(a), -Math.cos(a)]), 20),
    stick: turned([[0, 0], [1, 0], [1, 1], [0, 1]], 10),
    cone: turned([[0, 0], [1, 0], [0, 1]], 10),
    links: scene.shapes.map((s) => mesh(floats(s.vertices), new Uint32Array(bytes(s.faces).buffer))),
  };
}

let solid, dots, meshes, view, eye;
function draw(which, model, colour, alpha = 1) {
  gl.uniformMatrix4fv(solid.at.model, false, model);
  gl.uniform4f(solid.at.colour, ...colour, alpha);
  gl.bindVertexArray(which.array);
  gl.drawElements(gl.TRIANGLES, which.count, gl.UNSIGNED_INT, 0);
}
function ball(p, r, colour) { draw(meshes.ball, columns([r, 0, 0], [0, r, 0], [0, 0, r], p), colour); }
function arrow(p, v, colour, radius) {
  const length = long(v);
  if (length < 1e-9) return;
  const head = Math.min(0.4 * length, 7 * radius), neck = add(p, v, 1 - head / length);
  draw(meshes.stick, between(p, neck, radius), colour);
  draw(meshes.cone, between(neck, add(p, v), 2.6 * radius), colour);
}
function drawBody(pose, colour, alpha, only) {
  if (state.shown.shapes !== false)
    scene.shapes.forEach((s, i) => { if (only(s.frame)) draw(meshes.links[i], pose(s.frame), colour, alpha); });
  if (!state.shown.sticks) return;
  for (let k = 0; k < F; k++) {
    if (!only(k)) continue;
    const p = Array.from(pose(k).subarray(12, 15));
    if (scene.joint[k]) draw(meshes.ball, columns([0.014 * size, 0, 0], [0, 0.014 * size, 0], [0, 0, 0.014 * size], p), colour, alpha);
    const up = scene.parent[k];
    if (up < 0) continue;
    const from = Array.from(pose(up).subarray(12, 15));
    if (long(sub(p, from)) > 1e-4) draw(meshes.stick, between(from, p, 0.006 * size), colour, alpha);
  }
}
function drawFrames() {
  const tints = [[0.85, 0.2, 0.15], [0.15, 0.6, 0.2], [0.2, 0.4, 0.9]];
  for (const k of scene.named) {
    const T = poseAfter(k), p = Array.from(T.subarray(12, 15));
    tints.forEach((c, i) => {
      const axis = Array.from(T.subarray(4 * i, 4 * i + 3));
      draw(meshes.stick, between(p, add(p, axis, 0.05 * size), 0.0035 * size), c);
    });
  }
}
function drawArrows(colours) {
  for (const mark of scene.marks.filter((m) => m.arrows))
    ["before", "after"].forEach((side, s) => {
      if (!state.shown[side + "Arrows"]) return;
      for (let i = 0; i < mark.rows.length; i++) {
        const v = triple(mark.arrows[s], i).map((x) => x * state.factors.arrows);
        if (!mark.bad[i]) arrow(triple(mark.places, i), v, colours[side], 0.0022 * size);
      }
    });
  for (const f of scene.forces)
    arrow(triple(f.start, state.posture), triple(f.vector, state.posture).map((x) => x * scene.force_length),
      colours.bad, 0.006 * size);
}
function drawEllipsoids(colours) {
  for (const e of scene.ellipsoids) {
    if (!state.shown[e.kind]) continue;
    const k = e.true ? 1 : state.factors.ellipsoids, at = 9 * state.posture;
    const A = Array.from(e.axes.subarray(at, at + 9), (v) => k * v);  // rows: x, y, z of the axes
    const axis = (c) => [A[c], A[3 + c], A[6 + c]];
    draw(meshes.ball, columns(axis(0), axis(1), axis(2), triple(e.centre, state.posture)),
      e.kind === "load" ? colours.doubtful : colours.mark, e.kind === "load" ? 0.35 : 0.4);
  }
}
function drawDots(values, kind, scale) {
  gl.useProgram(dots.made);
  gl.uniformMatrix4fv(dots.at.view, false, view);
  gl.uniform1f(dots.at.scale, scale);
  gl.uniform1f(dots.at.lines, kind === gl.LINES ? 1 : 0);
  gl.bindVertexArray(dotArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, dotBuffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.DYNAMIC_DRAW);
  gl.drawArrays(kind, 0, values.length / 7);
}
function dotValues(colours) {
  const values = [], row = scene.rows[state.posture];
  for (const mark of scene.marks) {
    const most = highest(mark.unit, state.side);
    for (let i = 0; i < mark.rows.length; i++) {
      const colour = mark.bad[i] ? colours.bad : coloured(mark[state.side][i] / most);
      values.push(...triple(mark.places, i), ...colour, mark.rows[i] === row ? 16 : mark.bad[i] ? 11 : 8);
    }
  }
  return values;
}
function floorValues(colours) {
  const values = [], step = 10 ** Math.floor(Math.log10(size / 1.5)), half = step * Math.ceil((0.8 * size) / step);
  const [cx, cy] = [0, 1].map((k) => step * Math.round(box.middle[k] / step));
  for (let t = -half; t <= half + 1e-9; t += step)
    for (const [a, b] of [[[cx + t, cy - half], [cx + t, cy + half]], [[cx - half, cy + t], [cx + half, cy + t]]])
      values.push(...a, box.floor, ...colours.line, 1, ...b, box.floor, ...colours.line, 1);
  return values;
}

function sight() {
  const { yaw, pitch, distance, target } = state;
  const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
  const right = [-Math.sin(yaw), Math.cos(yaw), 0], up = cross(back, right);
  eye = add(target, back, distance);
  const near = distance / 100, far = distance * 20, f = 1 / Math.tan(0.3), wide = canvas.width / canvas.height;
  const lens = new Float32Array([f / Math.max(wide, 1), 0, 0, 0, 0, (f * wide) / Math.max(wide, 1), 0, 0,
    0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
  if (wide >= 1) { lens[0] = f / wide; lens[5] = f; }
  const look = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0,
    right[2], up[2], back[2], 0, -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
  view = times(lens, look);
  return { right, up };
}
let asked = false;
function redraw() { if (gl && !asked) { asked = true; requestAnimationFrame(render); } }
function render() {
  asked = false;
  const ratio = window.devicePixelRatio || 1, colours = palette();
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  sight();
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(...colours.space, 1);
  gl.depthMask(true);
  gl.disable(gl.BLEND);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  if (state.shown.floor) drawDots(floorValues(colours), gl.LINES, 1);
  gl.useProgram(solid.made);
  gl.uniformMatrix4fv(solid.at.view, false, view);
  gl.uniform3f(solid.at.eye, ...eye);
  if (state.shown.after) drawBody(poseAfter, colours.body, 1, () => true);
  if (state.shown.names) drawFrames();
  drawArrows(colours);
  if (state.shown.seen) drawDots(dotValues(colours), gl.POINTS, ratio);
  gl.useProgram(solid.made);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthMask(false);
  if (before && state.shown.before) drawBody(poseBefore, colours.before, 0.3, (k) => scene.corrected[k]);
  drawEllipsoids(colours);
  writeLabels(ratio);
}
function onScreen(p) {
  const w = view[3] * p[0] + view[7] * p[1] + view[11] * p[2] + view[15];
  const [x, y] = [0, 1].map((r) => (view[r] * p[0] + view[4 + r] * p[1] + view[8 + r] * p[2] + view[12 + r]) / w);
  return w > 0 ? [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight] : null;
}
/** Names beside what they name; one that would cover another is left out. */
function writeLabels() {
  const place = $("labels"), taken = [];
  place.replaceChildren();
  const wanted = state.shown.names ? scene.named.map((k) => [scene.frames[k], part(after, k)[0]]) : [];
  for (const e of scene.ellipsoids.filter((e) => e.kind === "load" && state.shown.load))
    wanted.push([e.name, triple(e.centre, state.posture)]);
  for (const f of scene.forces) wanted.push([f.name, triple(f.start, state.posture)]);
  for (const [name, p] of wanted) {
    const at = onScreen(p);
    if (!at || taken.some((o) => Math.abs(o[0] - at[0]) < 70 && Math.abs(o[1] - at[1]) < 16)) continue;
    taken.push(at);
    const label = element("span", name);
    label.style.transform = `translate(${at[0] + 8}px, ${at[1] - 8}px)`;
    place.append(label);
  }
}

// ---- the box round everything ----------------------------------------------------------------
function boxOf() {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const take = (p) => p.forEach((v, k) => { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); });
  for (let k = 0; k < F; k++) take(part(after, k)[0]);
  for (const s of scene.shapes) {
    const T = poseAfter(s.frame), v = floats(s.vertices);
    for (let i = 0; i < v.length / 3; i += 7) take(moved(T, triple(v, i)));
  }
  for (const m of scene.marks) for (let i = 0; i < m.rows.length; i++) if (!m.bad[i]) take(triple(m.places, i));
  for (const e of scene.ellipsoids.filter((e) => e.kind === "load"))
    for (const c of [0, 1, 2])
      for (const sign of [-1, 1]) take(add(triple(e.centre, 0), [0, 3, 6].map((r) => e.axes[r + c]), sign));
  for (const f of scene.forces) take(add(triple(f.start, 0), triple(f.vector, 0), scene.force_length));
  const middle = low.map((v, k) => (v + high[k]) / 2);
  return { middle, floor: low[2], radius: Math.max(long(sub(high, low)) / 2, 0.03) };
}
const box = boxOf();
function fit(yaw = 0.9, pitch = 0.35) {
  Object.assign(state, { yaw, pitch, target: [...box.middle], distance: 3.3 * box.radius });
  redraw();
}

// ---- the panel -------------------------------------------------------------------------------
function number(v) { return v >= 100 ? v.toFixed(0) : v.toPrecision(3); }
function addSwitch(key, text, on, factor, kind) {
  const label = element("label", undefined, "switch"), box = element("input");
  Object.assign(box, { type: "checkbox", checked: on });
  state.shown[key] = on;
  box.addEventListener("change", () => { state.shown[key] = box.checked; redraw(); });
  label.append(box, " ", element("span", text, kind));
  $("switches").append(label);
  if (factor) addFactor(factor, text);
}
function addFactor(key, text) {
  const line = element("div", undefined, "factor"), slider = element("input"), says = element("output");
  const index = Math.max(FACTORS.indexOf(state.factors[key]), 0);
  Object.assign(slider, { type: "range", min: 0, max: FACTORS.length - 1, value: index });
  slider.setAttribute("aria-label", `how many times too large: ${text}`);
  const tell = () => {
    state.factors[key] = FACTORS[slider.value];
    says.textContent = state.factors[key] === 1 ? "true to scale" : `drawn ×${state.factors[key]}`;
    slider.setAttribute("aria-valuetext", says.textContent);
    redraw();
  };
  slider.addEventListener("input", tell);
  tell();
  line.append(slider, says);
  $("switches").append(line);
}
function makeSwitches() {
  const arrows = scene.marks.some((m) => m.arrows), has = (kind) => scene.ellipsoids.some((e) => e.kind === kind);
  addSwitch("after", "the body as found", true, null, "after");
  if (before) addSwitch("before", `as it was believed; up to ${number(scene.shift.mm)} mm off, at ${scene.shift.at}`, true, "correction", "before");
  if (scene.shapes.length) addSwitch("shapes", "shapes of the links", true);
  addSwitch("sticks", "joints and sticks", !scene.shapes.length);
  if (scene.marks.length) addSwitch("seen", "places that were seen", true);
  if (arrows) addSwitch("beforeArrows", `errors before (${scene.words[0]}), as arrows`, false, null, "before");
  if (arrows) addSwitch("afterArrows", `errors after (${scene.words[1]}), as arrows`, true, "arrows", "after");
  if (has("uncertainty")) addSwitch("uncertainty", "where it may be (95 %)", true, "ellipsoids", "mark");
  if (has("load")) addSwitch("load", "loads, as bodies that move alike", true);
  addSwitch("names", "frames and names", true);
  addSwitch("floor", "floor", true);
  for (const [name, yaw, pitch] of [["All", 0.9, 0.35], ["Front", 0, 0], ["Side", -Math.PI / 2, 0], ["Top", 0, 1.55]]) {
    const button = element("button", name);
    button.type = "button";
    button.addEventListener("click", () => fit(yaw, pitch));
    $("views").append(button);
  }
}
function writeScales() {
  $("scales").replaceChildren();
  for (const name of new Set(scene.marks.map((m) => m.unit))) {
    const scale = element("div", undefined, "scale"), bar = element("div", undefined, "bar"), ends = element("div", undefined, "ends");
    bar.style.background = `linear-gradient(to right, ${COLOURS.join(", ")})`;
    ends.append(element("span", `0 ${name}`), element("span", `${number(highest(name, state.side))} ${name} and more`));
    scale.append(bar, ends);
    $("scales").append(scale);
  }
  if (scene.forces.length) $("scales").append(element("p", `Arrows of touches: 1 N is drawn as ${number(1e3 * scene.force_length)} mm.`));
  if (scene.marks.some((m) => m.bad.includes(true))) $("scales").append(element("p", "Red, a little larger: outlier rows.", "bad"));
}
function writeWhere() {
  const row = scene.rows[state.posture], found = [];
  for (const m of scene.marks) {
    const i = m.rows.indexOf(row);
    if (i >= 0) found.push(`${m.label} ${number(m.before[i])} → ${number(m.after[i])} ${m.unit}`);
  }
  $("where").textContent = row < 0 ? "No recorded posture." : `Row ${row}, ${state.posture + 1} of ${n}` +
    (found.length ? `; error ${found.slice(0, 4).join("; ")}${found.length > 4 ? ` and ${found.length - 4} more` : ""}` : "");
}
function go(k) {
  state.posture = (k + n) % n;
  $("slider").value = state.posture;
  writeWhere();
  redraw();
}
function writeTexts() {
  $("verdict").textContent = scene.verdict;
  $("verdict").className = scene.tone;
  $("trust").hidden = !scene.trust.length;
  $("trust").append(...scene.trust.map((text) => element("li", text)));
  $("notes").append(...scene.notes.map((text) => element("li", text)));
  $("frames").hidden = !scene.placed.length;
  for (const one of scene.placed) {
    const line = element("tr"), head = element("th", one.name);
    head.scope = "row";
    line.append(head, ...["parent", "place", "turn", "error"].map((key) => element("td", one[key])));
    $("placed").append(line);
  }
  $("errors").hidden = !scene.marks.length && !scene.forces.length;
  $("side").parentElement.hidden = !scene.marks.length;
  $("posture").hidden = n < 2;
  $("slider").max = n - 1;
}

// ---- hands on --------------------------------------------------------------------------------
function turn(dx, dy) {
  state.yaw -= dx;
  state.pitch = Math.min(1.55, Math.max(-1.55, state.pitch + dy));
  redraw();
}
function shift(dx, dy) {
  const { right, up } = sight(), k = (0.62 * state.distance) / canvas.clientHeight;
  state.target = add(add(state.target, right, -k * dx), up, k * dy);
  redraw();
}
function zoom(k) {
  state.distance = Math.min(Math.max(state.distance * k, 0.05 * box.radius), 30 * box.radius);
  redraw();
}
function nearest(x, y) {
  let best = null, least = 12;
  for (const m of state.shown.seen ? scene.marks : [])
    for (let i = 0; i < m.rows.length; i++) {
      const at = onScreen(triple(m.places, i)), d = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
      if (d < least) { least = d; best = { m, i, at }; }
    }
  return best;
}
function tell(x, y) {
  const found = nearest(x, y), tip = $("tip");
  tip.hidden = !found;
  if (!found) return;
  const { m, i, at } = found;
  tip.textContent = `row ${m.rows[i]}, ${m.label}: ${number(m.before[i])} ${m.unit} before, ${number(m.after[i])} after` + (m.bad[i] ? "; outlier" : "");
  tip.style.left = `${Math.min(at[0] + 12, canvas.clientWidth - 200)}px`;
  tip.style.top = `${at[1] + 12}px`;
}
function listen() {
  const held = new Map();
  let far = 0;
  const spot = (e) => { const r = canvas.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
  canvas.addEventListener("pointerdown", (e) => { held.set(e.pointerId, spot(e)); far = 0; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", (e) => {
    const now = spot(e), was = held.get(e.pointerId);
    if (!was) { tell(...now); return; }
    const [dx, dy] = [now[0] - was[0], now[1] - was[1]];
    far += Math.abs(dx) + Math.abs(dy);
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== e.pointerId)[1];
      zoom(long([...sub([...was, 0], [...other, 0])]) / (long(sub([...now, 0], [...other, 0])) || 1));
      shift(dx / 2, dy / 2);
    } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) shift(dx, dy);
    else turn(dx * 0.008, dy * 0.008);
    held.set(e.pointerId, now);
  });
  for (const kind of ["pointerup", "pointercancel"])
    canvas.addEventListener(kind, (e) => {
      held.delete(e.pointerId);
      const found = kind === "pointerup" && far < 4 ? nearest(...spot(e)) : null;
      const k = found ? scene.rows.indexOf(found.m.rows[found.i]) : -1;
      if (k >= 0) go(k);
    });
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(0.0012 * e.deltaY)); }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (way) e.shiftKey ? shift(30 * way[0], 30 * way[1]) : turn(0.12 * way[0], 0.12 * way[1]);
    else if (e.key === "+" || e.key === "=") zoom(0.85);
    else if (e.key === "-") zoom(1 / 0.85);
    else if (e.key === "Home") fit();
    else return;
    e.preventDefault();
  });
  $("slider").addEventListener("input", () => go(Number($("slider").value)));
  $("side").addEventListener("change", () => { state.side = $("side").value; writeScales(); redraw(); });
  let clock = 0;
  $("play").addEventListener("click", () => {
    clock = clock ? (clearInterval(clock), 0) : setInterval(() => go(state.posture + 1), 400);
    $("play").textContent = clock ? "Stop" : "Play";
  });
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
}

writeTexts();
writeScales();
let dotArray, dotBuffer;
if (gl) {
  solid = program(SOLID);
  dots = program(DOTS);
  meshes = makeMeshes();
  dotArray = gl.createVertexArray();
  dotBuffer = gl.createBuffer();
  gl.bindVertexArray(dotArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, dotBuffer);
  [[0, 3, 0], [1, 4, 12]].forEach(([k, count, offset]) => {
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, count, gl.FLOAT, false, 28, offset);
  });
  gl.enable(gl.DEPTH_TEST);
  makeSwitches();
  listen();
  fit();
} else $("failed").hidden = false;
go(0);
