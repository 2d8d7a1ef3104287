"use strict";
// Draws one or two recorded motions on canvases: a camera, solids sorted from far to near, a slider for both.
// Everything is in metres, newtons and seconds; poses were computed before, so nothing here knows joints.
var ambleReplay = ambleReplay || (function () {
  const FIELD = 1.9; // focal length over the height of the canvas
  const SHOWN = [["forces", "contact forces"], ["cones", "friction cones"], ["holds", "footholds"],
    ["mass", "centre of mass"], ["links", "links"]];
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2];

  // --- numbers of the page ---

  function bytes(text) {
    const raw = atob(text), found = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
    return found.buffer;
  }

  function unpack(motion) {
    for (const key of ["poses", "footPoints", "forces", "normals", "center"]) motion[key] = new Float32Array(bytes(motion[key]));
    motion.stance = new Uint8Array(bytes(motion.stance));
    motion.domains = new Uint16Array(bytes(motion.domains));
    motion.ground.heights = new Float32Array(bytes(motion.ground.heights));
    motion.meshes = motion.meshes.map(([link, vertices, faces]) => ({ link, vertices: new Float32Array(bytes(vertices)), faces: new Uint16Array(bytes(faces)) }));
    motion.meshed = new Set(motion.meshes.map((mesh) => mesh.link));
    motion.track = smoothed(motion);
    return motion;
  }

  // The camera follows the centre of mass averaged over a cycle, so that the sway of the base is seen.
  function smoothed(motion) {
    const n = motion.frames, sums = new Float64Array(3 * (n + 1)), track = new Float32Array(3 * n);
    for (let i = 0; i < 3 * n; i++) sums[i + 3] = sums[i] + motion.center[i];
    const half = Math.round((n - 1) / motion.cycles / 2);
    for (let i = 0; i < n; i++) {
      const reach = Math.min(half, i, n - 1 - i), from = i - reach, past = i + reach + 1;
      for (let k = 0; k < 3; k++) track[3 * i + k] = (sums[3 * past + k] - sums[3 * from + k]) / (past - from);
    }
    return track;
  }

  // --- vectors ---

  const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const norm = (a) => Math.sqrt(dot(a, a));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const size = norm(a) || 1; return [a[0] / size, a[1] / size, a[2] / size]; };

  function turned(q, v) { // v turned by the unit quaternion (x, y, z, w)
    const t = cross(q, v).map((x) => 2 * x), u = cross(q, t);
    return [v[0] + q[3] * t[0] + u[0], v[1] + q[3] * t[1] + u[1], v[2] + q[3] * t[2] + u[2]];
  }

  // --- a motion at one time ---

  function at(motion, time) {
    const place = Math.max(0, Math.min(1, time / motion.duration)) * (motion.frames - 1);
    const low = Math.min(Math.floor(place), motion.frames - 1), high = Math.min(low + 1, motion.frames - 1), w = place - low;
    const mix = (array, size, i) => {
      const found = [];
      for (let k = 0; k < size; k++) found.push((1 - w) * array[low * i.of + i.at + k] + w * array[high * i.of + i.at + k]);
      return found;
    };
    const feet = motion.feet.length, links = motion.links.length;
    const state = { time: place / (motion.frames - 1) * motion.duration, poses: [], feet: [], forces: [], normals: [], stance: [],
      center: mix(motion.center, 3, { of: 3, at: 0 }), track: mix(motion.track, 3, { of: 3, at: 0 }),
      domain: motion.domainNames[motion.domains[low]] };
    for (let i = 0; i < links; i++) {
      const pose = mix(motion.poses, 7, { of: 7 * links, at: 7 * i }), q = pose.slice(3), size = Math.hypot(...q);
      state.poses.push({ origin: pose.slice(0, 3), turn: q.map((x) => x / size) });
    }
    for (let i = 0; i < feet; i++) { // forces jump at events: those of the frame, not a mixture
      const row = 3 * (low * feet + i);
      state.feet.push(mix(motion.footPoints, 3, { of: 3 * feet, at: 3 * i }));
      state.forces.push(Array.from(motion.forces.subarray(row, row + 3)));
      state.normals.push(Array.from(motion.normals.subarray(row, row + 3)));
      state.stance.push(motion.stance[low * feet + i] === 1);
    }
    return state;
  }

  function height(ground, x, y) {
    const [nx, ny] = ground.counts;
    const u = Math.max(0, Math.min(nx - 1.001, (x - ground.origin[0]) / ground.cell));
    const v = Math.max(0, Math.min(ny - 1.001, (y - ground.origin[1]) / ground.cell));
    const i = Math.floor(u), j = Math.floor(v), h = (a, b) => ground.heights[a * ny + b];
    return (1 - u + i) * ((1 - v + j) * h(i, j) + (v - j) * h(i, j + 1)) + (u - i) * ((1 - v + j) * h(i + 1, j) + (v - j) * h(i + 1, j + 1));
  }

  // --- camera ---

  function camera(view, target, width, high) {
    const ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth), ce = Math.cos(view.elevation), se = Math.sin(view.elevation);
    const back = [ca * ce, sa * ce, se], right = [-sa, ca, 0], up = cross(back, right);
    const eye = add(target, back, view.distance), focal = FIELD * high;
    return {
      eye, back, right, up,
      see(p) {
        const d = add(p, eye, -1), depth = -dot(d, back);
        const scale = focal / Math.max(depth, 1e-3 * view.distance);
        return { x: width / 2 + scale * dot(d, right), y: high / 2 - scale * dot(d, up), depth, scale };
      },
    };
  }

  // --- drawing ---

  function colour(text, light) { // "#rrggbb" made lighter (> 0) or darker (< 0)
    const parts = [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16));
    return "rgb(" + parts.map((c) => Math.round(light > 0 ? c + (255 - c) * light : c * (1 + light))).join(",") + ")";
  }

  function capsule(ctx, a, b, radius, tint) { // a, b: as seen by the camera
    const ra = Math.max(1, radius * a.scale), rb = Math.max(1, radius * b.scale);
    const angle = Math.atan2(b.y - a.y, b.x - a.x), nx = -Math.sin(angle), ny = Math.cos(angle);
    const lit = ny < 0 ? 1 : -1, r = Math.max(ra, rb), mx = (a.x + b.x) / 2, my = (a.y + b.y) / 2;
    const shade = ctx.createLinearGradient(mx + lit * r * nx, my + lit * r * ny, mx - lit * r * nx, my - lit * r * ny);
    shade.addColorStop(0, colour(tint, 0.35));
    shade.addColorStop(0.5, colour(tint, 0.05));
    shade.addColorStop(1, colour(tint, -0.35));
    ctx.beginPath();
    ctx.arc(a.x, a.y, ra, angle + Math.PI / 2, angle - Math.PI / 2);
    ctx.arc(b.x, b.y, rb, angle - Math.PI / 2, angle + Math.PI / 2);
    ctx.closePath();
    ctx.fillStyle = shade;
    ctx.fill();
    ctx.strokeStyle = colour(tint, -0.5);
    ctx.lineWidth = 0.7;
    ctx.stroke();
  }

  function polygon(ctx, points, fill, stroke) {
    ctx.beginPath();
    points.forEach((p, i) => (i ? ctx.lineTo(p.x, p.y) : ctx.moveTo(p.x, p.y)));
    ctx.closePath();
    if (fill) { ctx.fillStyle = fill; ctx.fill(); }
    if (stroke) { ctx.strokeStyle = stroke; ctx.lineWidth = 0.8; ctx.stroke(); }
  }

  function box(items, eye, pose, low, high, tint) {
    const corner = (i) => add(pose.origin, turned(pose.turn, [i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]]), 1);
    const faces = [[[0, 2, 6, 4], [-1, 0, 0]], [[1, 5, 7, 3], [1, 0, 0]], [[0, 4, 5, 1], [0, -1, 0]], [[2, 3, 7, 6], [0, 1, 0]], [[0, 1, 3, 2], [0, 0, -1]], [[4, 6, 7, 5], [0, 0, 1]]];
    const shown = [];
    for (const [ids, axis] of faces) {
      const points = ids.map(corner), out = turned(pose.turn, axis);
      if (dot(out, add(eye.eye, points[0], -1)) <= 0) continue;
      shown.push({ points, light: 0.3 * out[2] + 0.12 * dot(out, eye.back) - 0.08 });
    }
    const middle = eye.see(add(pose.origin, turned(pose.turn, low.map((x, k) => (x + high[k]) / 2)), 1));
    items.push({ depth: middle.depth, draw: (ctx) => shown.forEach((f) => polygon(ctx, f.points.map(eye.see), colour(tint, f.light), colour(tint, -0.5))) });
  }

  function arrow(ctx, from, to, tint, width) {
    const angle = Math.atan2(to.y - from.y, to.x - from.x), length = Math.hypot(to.x - from.x, to.y - from.y);
    if (length < 2) return;
    const head = Math.min(3.2 * width, 0.6 * length);
    ctx.strokeStyle = ctx.fillStyle = tint;
    ctx.lineWidth = width;
    ctx.lineCap = "butt";
    ctx.beginPath();
    ctx.moveTo(from.x, from.y);
    ctx.lineTo(to.x - 0.8 * head * Math.cos(angle), to.y - 0.8 * head * Math.sin(angle));
    ctx.stroke();
    const wing = (side) => ({ x: to.x - head * Math.cos(angle + side), y: to.y - head * Math.sin(angle + side) });
    polygon(ctx, [to, wing(0.42), wing(-0.42)], tint);
  }

  function circle(center, normal, radius, count) { // points of a circle about a normal
    const helper = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const u = unit(cross(normal, helper)), v = cross(normal, u), found = [];
    for (let i = 0; i < count; i++) {
      const a = (2 * Math.PI * i) / count;
      found.push(add(add(center, u, radius * Math.cos(a)), v, radius * Math.sin(a)));
    }
    return found;
  }

  function cone(items, eye, foot, normal, friction, size, tint) {
    const slant = Math.sqrt(1 + friction * friction), ring = circle(add(foot, normal, size / slant), normal, (size * friction) / slant, 28).map(eye.see);
    const apex = eye.see(foot);
    items.push({ depth: apex.depth - 1e-3, draw: (ctx) => {
      ctx.globalAlpha = 0.1;
      ring.forEach((p, i) => polygon(ctx, [apex, p, ring[(i + 1) % ring.length]], tint));
      ctx.globalAlpha = 0.75;
      polygon(ctx, ring, null, tint);
      ctx.globalAlpha = 1;
    } });
  }

  function ground(ctx, motion, eye, target, tint) {
    const g = motion.ground, [nx, ny] = g.counts, reach = 7 * motion.length;
    const point = (i, j) => [g.origin[0] + i * g.cell, g.origin[1] + j * g.cell, g.heights[i * ny + j]];
    ctx.strokeStyle = tint;
    ctx.lineWidth = 1;
    const edge = (p, q) => {
      const far = Math.hypot((p[0] + q[0]) / 2 - target[0], (p[1] + q[1]) / 2 - target[1]) / reach;
      const a = eye.see(p), b = eye.see(q);
      if (far > 1 || a.depth < 0.2 * motion.length || b.depth < 0.2 * motion.length) return;
      ctx.globalAlpha = 0.9 * (1 - far * far);
      ctx.beginPath();
      ctx.moveTo(a.x, a.y);
      ctx.lineTo(b.x, b.y);
      ctx.stroke();
    };
    for (let i = 0; i < nx; i++) for (let j = 0; j < ny; j++) {
      if (i + 1 < nx) edge(point(i, j), point(i + 1, j));
      if (j + 1 < ny) edge(point(i, j), point(i, j + 1));
    }
    ctx.globalAlpha = 1;
  }

  function shadows(ctx, motion, state, eye, tint) {
    const down = (p) => eye.see([p[0], p[1], height(motion.ground, p[0], p[1])]);
    const places = motion.shapes.map(([kind, link, ...v]) => {
      const place = (p) => down(add(state.poses[link].origin, turned(state.poses[link].turn, p), 1));
      const [ax, ay, az, bx, by, bz, radius] = v, z = (az + bz) / 2;
      if (kind === "box") return { box: [[ax, ay, z], [bx, ay, z], [bx, by, z], [ax, by, z]].map(place) };
      return { line: [place([ax, ay, az]), place([bx, by, bz])], radius };
    });
    places.filter((p) => p.box).forEach((p) => polygon(ctx, p.box, tint));
    const lines = places.filter((p) => p.line); // one path: where bones cross, the shadow is not darker
    if (!lines.length) return;
    ctx.strokeStyle = tint;
    ctx.lineCap = ctx.lineJoin = "round";
    ctx.lineWidth = lines.reduce((sum, p) => sum + p.radius * (p.line[0].scale + p.line[1].scale), 0) / lines.length;
    ctx.beginPath();
    lines.forEach(({ line: [a, b] }) => { ctx.moveTo(a.x, a.y); ctx.lineTo(b.x, b.y); });
    ctx.stroke();
  }

  function footholds(ctx, motion, state, eye, paint) {
    for (const [foot, start, end, x, y, z] of motion.footholds) {
      const now = start <= state.time && state.time <= end;
      const ring = circle([x, y, z], [0, 0, 1], 0.045 * motion.length, 16).map(eye.see);
      ctx.globalAlpha = now ? 0.9 : start > state.time ? 0.28 : 0.5;
      polygon(ctx, ring, start > state.time ? null : now ? paint.stance : paint.swing, paint.stance);
    }
    ctx.globalAlpha = 1;
  }

  // What each foot uses of its cone decides the colour; a tenth of a percent is rounding of the numbers of this page.
  const slips = (force, normal, friction) => {
    const along = dot(force, normal);
    return norm(add(force, normal, -along)) > 1.001 * friction * Math.max(along, 0) + 1e-6;
  };

  function draw(stage, motion, time, view, shown) {
    const canvas = stage.canvas, ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, high = canvas.clientHeight;
    if (!width || !high) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(high * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(high * ratio);
    }
    const ctx = canvas.getContext("2d"), state = at(motion, time), paint = stage.paint;
    const fit = Math.max(1, 1.15 * high / width), seen = { ...view, distance: view.distance * motion.length * fit };
    const low = height(motion.ground, state.track[0], state.track[1]);
    const target = [state.track[0], state.track[1], low + 0.45 * (state.track[2] - low)];
    const eye = camera(seen, target, width, high), items = [];
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, high);
    ground(ctx, motion, eye, target, paint.ground);
    if (shown.links) shadows(ctx, motion, state, eye, paint.shade);
    if (shown.holds) footholds(ctx, motion, state, eye, paint);
    if (shown.links) solids(items, eye, motion, state, paint);
    contacts(items, eye, motion, state, paint, shown);
    if (shown.mass) {
      const c = eye.see(state.center), g = eye.see([state.center[0], state.center[1], height(motion.ground, state.center[0], state.center[1])]);
      items.push({ depth: -1, draw: () => mark(ctx, c, g, paint.mass) });
    }
    items.sort((a, b) => b.depth - a.depth).forEach((item) => item.draw(ctx));
    stage.state.textContent = state.domain + " · " + speed(motion, time).toFixed(3) + " m/s";
  }

  // Mean speed over the cycle about this time, along the ground.
  function speed(motion, time) {
    const n = motion.frames, per = Math.max(1, Math.round((n - 1) / motion.cycles));
    const at = Math.round(Math.max(0, Math.min(1, time / motion.duration)) * (n - 1));
    const from = Math.max(0, Math.min(at - (per >> 1), n - 1 - per)), to = Math.min(n - 1, from + per);
    const dx = motion.center[3 * to] - motion.center[3 * from], dy = motion.center[3 * to + 1] - motion.center[3 * from + 1];
    return Math.hypot(dx, dy) / ((to - from) / (n - 1) * motion.duration);
  }

  function mark(ctx, c, g, tint) {
    ctx.strokeStyle = tint;
    ctx.lineWidth = 1.2;
    ctx.setLineDash([4, 3]);
    ctx.beginPath();
    ctx.moveTo(c.x, c.y);
    ctx.lineTo(g.x, g.y);
    ctx.stroke();
    ctx.setLineDash([]);
    for (const [p, size] of [[c, 6], [g, 3]]) {
      ctx.beginPath();
      ctx.arc(p.x, p.y, size, 0, 2 * Math.PI);
      ctx.fillStyle = tint;
      ctx.fill();
      ctx.strokeStyle = "#ffffff";
      ctx.stroke();
      ctx.strokeStyle = tint;
    }
  }

  // Every triangle is painted by itself, lit from above and from the camera; its border closes the seams.
  function mesh(items, eye, pose, shown, tint) {
    const places = [], seen = [];
    for (let i = 0; i < shown.vertices.length; i += 3) {
      places.push(add(pose.origin, turned(pose.turn, Array.from(shown.vertices.subarray(i, i + 3))), 1));
      seen.push(eye.see(places[places.length - 1]));
    }
    for (let i = 0; i < shown.faces.length; i += 3) {
      const [a, b, c] = shown.faces.subarray(i, i + 3), out = unit(cross(add(places[b], places[a], -1), add(places[c], places[a], -1)));
      const facing = dot(out, add(eye.eye, places[a], -1)) < 0 ? -1 : 1; // files do not agree on which side is out
      const fill = colour(tint, 0.3 * facing * out[2] + 0.3 * facing * dot(out, eye.back) - 0.2);
      items.push({ depth: (seen[a].depth + seen[b].depth + seen[c].depth) / 3, draw: (ctx) => polygon(ctx, [seen[a], seen[b], seen[c]], fill, fill) });
    }
  }

  function solids(items, eye, motion, state, paint) {
    for (const shown of motion.meshes) mesh(items, eye, state.poses[shown.link], shown, shown.link ? paint.link : paint.base);
    for (const [kind, link, ax, ay, az, bx, by, bz, radius] of motion.shapes) {
      if (motion.meshed.has(link)) continue;
      const pose = state.poses[link];
      if (kind === "box") { box(items, eye, pose, [ax, ay, az], [bx, by, bz], paint.base); continue; }
      const a = eye.see(add(pose.origin, turned(pose.turn, [ax, ay, az]), 1));
      const b = eye.see(add(pose.origin, turned(pose.turn, [bx, by, bz]), 1));
      items.push({ depth: (a.depth + b.depth) / 2, draw: (ctx) => capsule(ctx, a, b, radius, paint.link) });
    }
  }

  function contacts(items, eye, motion, state, paint, shown) {
    state.feet.forEach((foot, i) => {
      const p = eye.see(foot), force = state.forces[i], stands = state.stance[i];
      items.push({ depth: p.depth - 1e-3, draw: (ctx) => capsule(ctx, p, p, 0.03 * motion.length, stands ? paint.stance : paint.swing) });
      if (!stands) return;
      const bad = slips(force, state.normals[i], motion.friction);
      if (shown.cones) cone(items, eye, foot, state.normals[i], motion.friction, 0.55 * motion.length, bad ? paint.slip : paint.cone);
      const tip = eye.see(add(foot, force, (1.2 * motion.length) / motion.weight));
      if (shown.forces) items.push({ depth: p.depth - 2e-3, draw: (ctx) => arrow(ctx, p, tip, bad ? paint.slip : paint.force, Math.max(2, 0.022 * motion.length * p.scale)) });
    });
  }

  // --- the strip below the slider: when each foot stands ---

  function strip(canvas, motions, time, longest, paint) {
    const ratio = window.devicePixelRatio || 1, row = 7, width = canvas.clientWidth;
    const rows = motions.map((m) => m.feet.length), high = row * rows.reduce((a, b) => a + b, 0) + 4 * (motions.length - 1);
    canvas.style.height = high + "px";
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(high * ratio);
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    let top = 0;
    motions.forEach((motion, k) => {
      ctx.fillStyle = paint[k].sky;
      ctx.fillRect(0, top, (width * motion.duration) / longest, row * rows[k]);
      ctx.fillStyle = paint[k].bar;
      for (const [foot, start, end] of motion.footholds) ctx.fillRect((start / longest) * width, top + row * foot + 1, Math.max(1, ((end - start) / longest) * width - 0.5), row - 2);
      top += row * rows[k] + 4;
    });
    ctx.fillStyle = paint[0].force;
    ctx.fillRect((time / longest) * width - 0.75, 0, 1.5, high);
  }

  // --- the page ---

  function element(tag, parent, attributes, text) {
    const made = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
    if (text) made.textContent = text;
    parent.appendChild(made);
    return made;
  }

  function paints(node) {
    const style = getComputedStyle(node), found = {};
    for (const key of ["ink", "ground", "link", "base", "stance", "swing", "force", "cone", "slip", "mass", "shade", "sky", "bar"]) found[key] = style.getPropertyValue("--" + key).trim();
    return found;
  }

  function controls(root, motions, longest) {
    const panel = element("div", root, { class: "panel" }), row = element("div", panel, { class: "row" });
    const play = element("button", row, { type: "button" }, "play");
    const rate = element("select", row, { "aria-label": "speed" });
    SPEEDS.forEach((s) => { const o = element("option", rate, { value: s }, s + " ×"); o.selected = s === 0.5; });
    const time = element("span", row, { class: "time" });
    const slider = element("input", panel, { type: "range", min: 0, max: longest, step: "any", value: 0, "aria-label": "time, s" });
    const footfall = element("canvas", panel, { class: "footfall", title: "when each foot stands: " + motions[0].feet.join(", ") });
    const switches = element("div", panel, { class: "row switches" }), shown = {};
    for (const [key, text] of SHOWN) {
      const label = element("label", switches), input = element("input", label, { type: "checkbox" });
      input.checked = shown[key] = true;
      label.append(" " + text);
      input.addEventListener("change", () => { shown[key] = input.checked; });
    }
    return { play, rate, time, slider, footfall, shown };
  }

  function steer(canvas, view, changed) { // one pointer turns, two or the wheel come closer
    const touches = new Map();
    const gap = () => { const [a, b] = [...touches.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); touches.set(e.pointerId, { x: e.clientX, y: e.clientY }); });
    canvas.addEventListener("pointermove", (e) => {
      const old = touches.get(e.pointerId);
      if (!old) return;
      const before = touches.size === 2 ? gap() : 0;
      touches.set(e.pointerId, { x: e.clientX, y: e.clientY });
      if (touches.size === 1) {
        view.azimuth -= 0.008 * (e.clientX - old.x);
        view.elevation = Math.max(-0.1, Math.min(1.5, view.elevation + 0.008 * (e.clientY - old.y)));
      } else if (touches.size === 2) view.distance = Math.max(1.5, Math.min(20, (view.distance * before) / gap()));
      changed();
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => touches.delete(e.pointerId));
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      view.distance = Math.max(1.5, Math.min(20, view.distance * Math.exp(0.001 * e.deltaY)));
      changed();
    }, { passive: false });
  }

  return function (name) {
    const root = document.getElementById(name), motions = JSON.parse(document.getElementById(name + "-motion").textContent).motions.map(unpack);
    const longest = Math.max(...motions.map((m) => m.duration)), view = { azimuth: -1.05, elevation: 0.24, distance: 4.6 };
    const stages = element("div", root, { class: "stages" }), parts = motions.map((motion) => {
      const node = element("div", stages, { class: "stage" }), canvas = element("canvas", node, { role: "img", "aria-label": "replay of " + motion.label });
      const label = element("div", node, { class: "label" }, motion.label);
      return { canvas, state: element("span", label, { class: "state" }), paint: paints(root) };
    });
    const ui = controls(root, motions, longest), asked = /[#&]t=([0-9.]+)/.exec(window.location.hash);
    let time = asked ? Math.min(longest, Number(asked[1])) : 0, last = null;
    let playing = !asked && !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    let dirty = true;
    const changed = () => { dirty = true; };
    const start = (wanted) => { playing = wanted; ui.play.textContent = playing ? "pause" : "play"; };
    start(playing);
    parts.forEach((part) => steer(part.canvas, view, changed));
    ui.play.addEventListener("click", () => { if (!playing && time >= longest) time = 0; start(!playing); changed(); });
    ui.slider.addEventListener("input", () => { start(false); time = Number(ui.slider.value); changed(); });
    root.addEventListener("change", changed);
    window.addEventListener("resize", changed);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { parts.forEach((part) => { part.paint = paints(root); }); changed(); });
    root.tabIndex = 0;
    root.addEventListener("keydown", (e) => {
      if (e.target.tagName === "SELECT" || (e.target.tagName === "INPUT" && e.key !== " ")) return;
      const step = { ArrowRight: 1 / 60, ArrowLeft: -1 / 60 }[e.key];
      if (step) { start(false); time = Math.max(0, Math.min(longest, time + step)); } else if (e.key === " " && e.target.tagName !== "BUTTON") ui.play.click(); else return;
      e.preventDefault();
      changed();
    });
    (function tick(now) {
      if (playing && last !== null) {
        time += ((now - last) / 1000) * Number(ui.rate.value);
        if (time > longest) time = 0;
        dirty = true;
      }
      last = now === undefined ? null : now;
      if (dirty) {
        dirty = false;
        motions.forEach((motion, i) => draw(parts[i], motion, time, view, ui.shown));
        strip(ui.footfall, motions, time, longest, parts.map((part) => part.paint));
        ui.slider.value = time;
        ui.time.textContent = time.toFixed(3) + " s of " + longest.toFixed(2) + " s";
      }
      window.requestAnimationFrame(tick);
    })();
  };
})();
