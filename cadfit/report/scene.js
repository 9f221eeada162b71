// The view: points, curves, poles, knots, combs, corners and deviations, drawn on a plain canvas.

class Scene {
  constructor(canvas, data, shown) {
    Object.assign(this, { canvas, data, shown, cursor: null, hoverHook: () => {}, clickHook: () => {} });
    this.camera = new Camera(data.axes.length < 3);
    this.chooseAxes(data.axes.map((_, j) => j).slice(0, 3));
    this.dirty = false;
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.listen();
  }

  // Which coordinates are drawn along x, y and z.
  chooseAxes(axes) {
    this.chosen = axes;
    const stretch = this.data.stretch;
    this.flatten = (rows) => {
      const out = new Float64Array(3 * rows.length);
      rows.forEach((row, i) => axes.forEach((axis, j) => (out[3 * i + j] = row[axis] * (stretch[axis] ?? 1))));
      return out;
    };
    const layer = (rows) => {
      const at = this.flatten(rows);
      return { at, px: new Float64Array((at.length / 3) * 2), rows };
    };
    this.sets = this.data.sets.map((set) => layer(set.at));
    this.layers = this.data.entries.map((entry) => {
      const samples = entry.along.s.map((_, i) => bezier(entry.chain, entry.along.span[i], entry.along.t[i]));
      return {
        curve: layer(entry.chain),
        poles: layer(entry.poles),
        feet: layer(samples),
        bends: entry.along.curvature ? this.flatten(entry.along.curvature) : null,
        off: this.flatten(entry.off_vectors),
      };
    });
    const all = [...this.sets.map((set) => set.at), ...this.layers.map((each) => each.feet.at)];
    this.low = [Infinity, Infinity, Infinity];
    this.high = this.low.map((x) => -x);
    for (const at of all)
      for (let i = 0; i < at.length; i++) {
        if (at[i] < this.low[i % 3]) this.low[i % 3] = at[i];
        if (at[i] > this.high[i % 3]) this.high[i % 3] = at[i];
      }
    this.size = Math.hypot(...this.low.map((x, j) => this.high[j] - x)) || 1;
    this.moved = false;
    this.redraw();
  }

  reset(look) {
    if (look) this.camera.look(look);
    this.moved = false;
    this.redraw();
  }

  // Move to a place (a row of coordinates), and zoom in unless near already.
  goTo(place, pixels) {
    this.moved = true;
    this.camera.target = [...this.flatten([place])];
    this.camera.scale = clamp(Math.max(this.camera.scale, pixels), this.camera.least, this.camera.most);
    this.redraw();
  }

  redraw() {
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.dirty = false;
    const { pen, width, height } = sized(this.canvas);
    Object.assign(this.camera, { width, height });
    if (!width || !height) return;
    if (!this.moved) this.camera.frame(this.low, this.high);
    pen.font = FONT;
    Object.assign(this, { pen, width, height });
    if (this.camera.flat) this.drawGrid();
    else this.drawBox();
    const on = (name) => this.shown[name];
    const entries = this.data.entries.map((entry, k) => [entry, this.layers[k]]).filter(([entry]) => !entry.hidden);
    if (on("comb")) for (const each of entries) this.drawComb(...each);
    if (on("poles")) for (const each of entries) this.drawPoles(...each);
    if (on("curve")) for (const each of entries) this.drawCurve(...each);
    if (on("knots")) for (const each of entries) this.drawKnots(...each);
    if (on("deviation")) for (const each of entries) this.drawDeviation(...each);
    if (on("points")) this.data.sets.forEach((set, k) => this.drawPoints(set, this.sets[k]));
    if (on("corners")) this.data.sets.forEach((set, k) => this.drawCorners(set, this.sets[k]));
    if (on("worst")) for (const [entry] of entries) this.drawWorst(entry);
    if (this.cursor) this.drawCursor();
  }

  drawGrid() {
    const { pen, width, height, camera, data } = this;
    const edges = [camera.step(-width / 2, height / 2), camera.step(width / 2, -height / 2)];
    pen.lineWidth = 1;
    const names = [];
    for (const axis of [0, 1]) {
      const name = this.chosen[axis];
      const [stretch, origin] = [data.stretch[name] ?? 1, data.centre[name]];
      const real = edges.map((edge) => (camera.target[axis] + edge[axis]) / stretch + origin);
      const { values, text } = ticks(real[0], real[1], (axis ? height / 60 : width / 100) | 0);
      for (const value of values) {
        const at = [0, 0, 0];
        at[axis] = (value - origin) * stretch;
        const pixel = Math.round(camera.pixel(at)[axis]) + 0.5;
        pen.strokeStyle = Math.abs(value) < 1e-12 * Math.abs(real[1] - real[0]) ? "#cfd6de" : "#edf0f3";
        pen.beginPath();
        pen.moveTo(axis ? 0 : pixel, axis ? pixel : 0);
        pen.lineTo(axis ? width : pixel, axis ? pixel : height);
        pen.stroke();
        if (axis ? pixel < height - 26 && pixel > 28 : pixel > 50 && pixel < width - 64)
          names.push([text(value), axis ? 6 : pixel, axis ? pixel + 4 : height - 7, FAINT, axis ? "left" : "center"]);
      }
      const named = data.axes[name] + (data.unit && !(data.graph && axis === 0) ? ` (${data.unit})` : "");
      names.push([named, axis ? 6 : width - 8, axis ? 15 : height - 7, INK, axis ? "left" : "right"]);
    }
    for (const each of names) label(pen, ...each);
  }

  // The box around everything, with ticks along an edge of each direction.
  drawBox() {
    const { pen, camera, low, high, data } = this;
    const corner = (k) => [0, 1, 2].map((j) => ((k >> j) & 1 ? high : low)[j]);
    const at = [...Array(8).keys()].map((k) => camera.pixel(corner(k)));
    pen.lineWidth = 1;
    pen.strokeStyle = "#dde2e8";
    pen.beginPath();
    for (let k = 0; k < 8; k++)
      for (const j of [0, 1, 2]) {
        if ((k >> j) & 1) continue;
        pen.moveTo(...at[k]);
        pen.lineTo(...at[k | (1 << j)]);
      }
    pen.stroke();
    const middle = camera.pixel(low.map((x, j) => (x + high[j]) / 2));
    for (const j of [0, 1, 2]) {
      const edges = [...Array(8).keys()].filter((k) => !((k >> j) & 1)).map((k) => [at[k], at[k | (1 << j)], k]);
      const [a, b] = edges[0];
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length < 30) continue;
      const upright = Math.abs(b[1] - a[1]) > 1.5 * Math.abs(b[0] - a[0]);
      const rank = ([p, q]) => (upright ? -(p[0] + q[0]) : p[1] + q[1]);
      const [start, end] = edges.reduce((best, edge) => (rank(edge) > rank(best) ? edge : best));
      const centre = [(start[0] + end[0]) / 2, (start[1] + end[1]) / 2];
      const out = [centre[0] - middle[0], centre[1] - middle[1]];
      const size = Math.hypot(...out) || 1;
      const aside = (far) => [(out[0] / size) * far, (out[1] / size) * far];
      const name = this.chosen[j];
      const [stretch, origin] = [data.stretch[name] ?? 1, data.centre[name]];
      const real = [low[j], high[j]].map((x) => x / stretch + origin);
      const { values, text } = ticks(real[0], real[1], Math.min(5, length / 60));
      pen.textBaseline = "middle";
      for (const value of values) {
        const part = (value - real[0]) / (real[1] - real[0] || 1);
        const [x, y] = [start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])];
        const [dx, dy] = aside(15);
        label(pen, text(value), x + dx, y + dy, FAINT, "center");
      }
      const [dx, dy] = aside(36);
      const named = data.axes[name] + (data.unit ? ` (${data.unit})` : "");
      label(pen, named, centre[0] + dx, centre[1] + dy, INK, "center");
      pen.textBaseline = "alphabetic";
    }
  }

  drawCurve(entry, { curve }) {
    const { pen, camera, width, height } = this;
    const p = camera.project(curve.at, curve.px);
    pen.strokeStyle = entry.colour;
    pen.lineWidth = 1.8;
    pen.lineJoin = pen.lineCap = "round";
    pen.beginPath();
    let here = [NaN, NaN];
    const piece = (x0, y0, x1, y1, x2, y2, x3, y3, depth) => {
      const [left, right] = [Math.min(x0, x1, x2, x3), Math.max(x0, x1, x2, x3)];
      const [top, bottom] = [Math.min(y0, y1, y2, y3), Math.max(y0, y1, y2, y3)];
      if (right < -9 || left > width + 9 || bottom < -9 || top > height + 9) return;
      if (right - left + bottom - top > 6 * (width + height) && depth < 40) {
        // Halved here, where numbers are long: the canvas has short ones, and would shake at a deep zoom.
        const [ax, ay, bx, by, cx, cy] = [(x0 + x1) / 2, (y0 + y1) / 2, (x1 + x2) / 2, (y1 + y2) / 2, (x2 + x3) / 2, (y2 + y3) / 2];
        const [dx, dy, ex, ey] = [(ax + bx) / 2, (ay + by) / 2, (bx + cx) / 2, (by + cy) / 2];
        const [fx, fy] = [(dx + ex) / 2, (dy + ey) / 2];
        piece(x0, y0, ax, ay, dx, dy, fx, fy, depth + 1);
        piece(fx, fy, ex, ey, cx, cy, x3, y3, depth + 1);
        return;
      }
      if (!(Math.abs(here[0] - x0) + Math.abs(here[1] - y0) <= 1.5)) pen.moveTo(x0, y0);
      else if (Math.abs(here[0] - x3) + Math.abs(here[1] - y3) < 0.6 && right - left + bottom - top < 1) return;
      pen.bezierCurveTo(x1, y1, x2, y2, x3, y3);
      here = [x3, y3];
    };
    for (let i = 0; i + 7 < p.length; i += 6) piece(p[i], p[i + 1], p[i + 2], p[i + 3], p[i + 4], p[i + 5], p[i + 6], p[i + 7], 0);
    pen.stroke();
  }

  drawKnots(entry, { curve }) {
    const { pen, camera } = this;
    const p = camera.project(curve.at, curve.px);
    pen.strokeStyle = entry.colour;
    pen.lineWidth = 1.4;
    pen.beginPath();
    for (let i = 0; i + 1 < p.length; i += 6) {
      const [from, to] = i + 7 < p.length ? [i, i + 6] : [i - 6, i];
      let [dx, dy] = [p[to] - p[from], p[to + 1] - p[from + 1]];
      if (i + 7 < p.length && Math.hypot(p[i + 2] - p[i], p[i + 3] - p[i + 1]) > 1e-9) [dx, dy] = [p[i + 2] - p[i], p[i + 3] - p[i + 1]];
      const size = Math.hypot(dx, dy) || 1;
      pen.moveTo(p[i] - (dy / size) * 6, p[i + 1] + (dx / size) * 6);
      pen.lineTo(p[i] + (dy / size) * 6, p[i + 1] - (dx / size) * 6);
    }
    pen.stroke();
  }

  drawPoles(entry, { poles }) {
    const { pen, camera, data } = this;
    const p = camera.project(poles.at, poles.px);
    const several = data.entries.length > 1;
    pen.strokeStyle = several ? entry.colour : "#7b8490";
    pen.globalAlpha = several ? 0.6 : 1;
    pen.lineWidth = 1;
    let start = 0;
    for (const count of entry.pole_counts) {
      pen.beginPath();
      for (let i = start; i < start + count; i++) pen.lineTo(p[2 * i], p[2 * i + 1]);
      pen.stroke();
      start += count;
    }
    pen.fillStyle = "#fff";
    for (let i = 0; i < start; i++) {
      pen.fillRect(p[2 * i] - 2.5, p[2 * i + 1] - 2.5, 5, 5);
      pen.strokeRect(p[2 * i] - 2.5, p[2 * i + 1] - 2.5, 5, 5);
    }
    pen.globalAlpha = 1;
  }

  drawPoints(set, layer) {
    const { pen, camera, data, width, height } = this;
    const p = camera.project(layer.at, layer.px);
    const spacing = (camera.scale * data.entries[0].length * (data.graph ? data.stretch[0] : 1)) / Math.max(set.at.length, 1);
    const r = clamp(0.3 * spacing, 1.2, 3);
    pen.fillStyle = set.colour;
    let [lastX, lastY] = [NaN, NaN];
    pen.beginPath();
    for (let i = 0; i < p.length; i += 2) {
      const [x, y] = [p[i], p[i + 1]];
      if (x < -9 || x > width + 9 || y < -9 || y > height + 9) continue;
      if (Math.abs(x - lastX) + Math.abs(y - lastY) < 0.7) continue;
      [lastX, lastY] = [x, y];
      if (r < 1.5) pen.rect(x - r, y - r, 2 * r, 2 * r);
      else {
        pen.moveTo(x + r, y);
        pen.arc(x, y, r, 0, 7);
      }
    }
    pen.fill();
  }

  drawCorners(set, layer) {
    const { pen, camera } = this;
    const p = camera.project(layer.at, layer.px);
    pen.strokeStyle = INK;
    pen.lineWidth = 1.3;
    for (const i of set.corners) {
      const [x, y] = [p[2 * i], p[2 * i + 1]];
      pen.beginPath();
      for (const [dx, dy] of [[0, -7], [7, 0], [0, 7], [-7, 0]]) pen.lineTo(x + dx, y + dy);
      pen.closePath();
      pen.stroke();
    }
  }

  // Teeth against the curvature vectors, some five pixels apart, and the line through all their tips.
  drawComb(entry, { feet, bends }) {
    if (!bends) return;
    const { pen, camera, data } = this;
    const long = (data.tooth * this.shown.combScale) / (data.sharpest || 1);
    const tips = new Float64Array(feet.at.length);
    for (let i = 0; i < tips.length; i++) tips[i] = feet.at[i] - long * bends[i];
    const p = camera.project(feet.at, feet.px);
    const q = camera.project(tips, new Float64Array(p.length));
    pen.strokeStyle = data.entries.length > 1 ? entry.colour : "#009E73";
    const apart = clamp((entry.length * camera.scale) / 260, 4, 1e9);
    const [s, k] = [entry.along.s, camera.scale];
    pen.globalAlpha = 0.45;
    pen.lineWidth = 0.8;
    pen.beginPath();
    let last = -Infinity;
    for (let i = 0; i < s.length; i++) {
      if ((s[i] - last) * k < apart && entry.along.span[i] === entry.along.span[Math.max(i - 1, 0)]) continue;
      last = s[i];
      pen.moveTo(p[2 * i], p[2 * i + 1]);
      pen.lineTo(q[2 * i], q[2 * i + 1]);
    }
    pen.stroke();
    pen.globalAlpha = 1;
    pen.lineWidth = 1.1;
    pen.beginPath();
    for (let i = 0; i < s.length; i++) pen[entry.starts.has(i) ? "moveTo" : "lineTo"](q[2 * i], q[2 * i + 1]);
    pen.stroke();
  }

  // From the foot of each point a whisker as many times longer than its deviation as the page says.
  drawDeviation(entry, { off }) {
    const { pen, camera } = this;
    const at = this.sets[entry.set].at;
    const tips = new Float64Array(at.length);
    const feet = new Float64Array(at.length);
    const times = this.shown.times;
    for (let i = 0; i < at.length; i++) {
      feet[i] = at[i] - off[i];
      tips[i] = feet[i] + times * off[i];
    }
    const p = camera.project(feet, new Float64Array((at.length / 3) * 2));
    const q = camera.project(tips, new Float64Array(p.length));
    pen.strokeStyle = this.data.entries.length > 1 ? entry.colour : "#CC79A7";
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (let i = 0; i < p.length; i += 2) {
      pen.moveTo(p[i], p[i + 1]);
      pen.lineTo(q[i], q[i + 1]);
    }
    pen.stroke();
  }

  drawWorst(entry) {
    const { pen } = this;
    const [x, y] = this.pixelOf(this.data.sets[entry.set].at[entry.worst.shown]);
    const several = this.data.entries.length > 1;
    pen.strokeStyle = several ? entry.colour : INK;
    pen.lineWidth = 1.6;
    pen.beginPath();
    pen.arc(x, y, 8, 0, 7);
    pen.stroke();
    if (several) return;
    const right = x < this.width - 170;
    label(pen, `farthest point: ${words(entry.worst.off, 3)}`, x + (right ? 12 : -12), y - 10, INK, right ? "left" : "right");
  }

  drawCursor() {
    const { pen, camera, cursor, data } = this;
    const [x, y] = this.pixelOf(cursor.place);
    if (data.axes.length === 2 && !data.graph && cursor.curvature) {
      const size = Math.hypot(...cursor.curvature);
      const radius = camera.scale / size;
      if (radius < 20 * (this.width + this.height)) {
        // The circle that meets the curve best.
        const centre = this.pixelOf(cursor.place.map((v, j) => v + cursor.curvature[j] / size ** 2));
        pen.strokeStyle = "rgba(91,101,115,0.55)";
        pen.setLineDash([4, 4]);
        pen.lineWidth = 1;
        pen.beginPath();
        pen.arc(centre[0], centre[1], radius, 0, 7);
        pen.stroke();
        pen.setLineDash([]);
      }
    }
    pen.fillStyle = "#fff";
    pen.strokeStyle = INK;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc(x, y, 4.5, 0, 7);
    pen.fill();
    pen.stroke();
  }

  pixelOf(place) {
    return this.camera.pixel(this.flatten([place]));
  }

  // What is under the pointer: a pole, a point, a place on a curve; null where nothing is near.
  under(x, y) {
    const near = (layer, reach) => {
      let [best, square] = [-1, reach * reach];
      const p = layer.px;
      for (let i = 0; i < p.length; i += 2) {
        const far = (p[i] - x) ** 2 + (p[i + 1] - y) ** 2;
        if (far < square) [best, square] = [i / 2, far];
      }
      return best;
    };
    const visible = this.data.entries.map((entry, k) => [entry, this.layers[k]]).filter(([entry]) => !entry.hidden);
    if (this.shown.points)
      for (const [entry] of visible) {
        const row = near(this.sets[entry.set], 7);
        if (row >= 0) return { entry, point: row };
      }
    if (this.shown.poles)
      for (const [entry, each] of visible) {
        const row = near(each.poles, 7);
        if (row >= 0) return { entry, pole: row };
      }
    for (const [entry, each] of visible) {
      this.camera.project(each.feet.at, each.feet.px);
      const row = near(each.feet, 14);
      if (row >= 0) return { entry, s: this.refined(entry, row, x, y) };
    }
    return null;
  }

  // The arc length nearest to the pointer about a sample.
  refined(entry, row, x, y) {
    const s = entry.along.s;
    let [best, least] = [s[row], Infinity];
    const [low, high] = [s[Math.max(row - 2, 0)], s[Math.min(row + 2, s.length - 1)]];
    for (let k = 0; k <= 40; k++) {
      const at = low + ((high - low) * k) / 40;
      const [px, py] = this.pixelOf(placeAt(entry, at).place);
      const far = Math.hypot(px - x, py - y);
      if (far < least) [best, least] = [at, far];
    }
    return best;
  }

  listen() {
    const { canvas, camera } = this;
    const held = new Map();
    let moved = 0;
    const here = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, here(event));
      moved = 0;
      canvas.setPointerCapture?.(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y] = here(event);
      const before = held.get(event.pointerId);
      if (!before) return this.hoverHook(this.under(x, y), x, y);
      const [dx, dy] = [x - before[0], y - before[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      this.moved = true;
      if (held.size === 2) {
        const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
        const spread = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
        camera.zoom(spread([x, y]) / Math.max(spread(before), 1), (x + other[0]) / 2, (y + other[1]) / 2);
        camera.pan(dx / 2, dy / 2);
      } else if (camera.flat || event.shiftKey || event.buttons & 6) camera.pan(dx, dy);
      else camera.rotate(dx * 0.008, dy * 0.008);
      held.set(event.pointerId, [x, y]);
      this.redraw();
    });
    const drop = (event) => {
      if (held.delete(event.pointerId) && moved < 4 && event.type === "pointerup") this.clickHook(this.under(...here(event)));
    };
    canvas.addEventListener("pointerup", drop);
    canvas.addEventListener("pointercancel", drop);
    canvas.addEventListener("pointerleave", () => held.size || this.hoverHook(null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => this.reset());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 33 : 1;
      this.moved = true;
      camera.zoom(Math.exp(-clamp(event.deltaY * lines, -300, 300) * 0.002), ...here(event));
      this.redraw();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      const factor = { "+": 1.25, "=": 1.25, "-": 0.8 }[event.key];
      this.moved ||= Boolean(step || factor);
      if (step && (camera.flat || event.shiftKey)) camera.pan(40 * step[0], 40 * step[1]);
      else if (step) camera.rotate(-0.1 * step[0], -0.1 * step[1]);
      else if (factor) camera.zoom(factor, this.width / 2, this.height / 2);
      else if (event.key === "0") this.reset();
      else return;
      event.preventDefault();
      this.redraw();
    });
  }
}
