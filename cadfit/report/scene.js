// The view, drawn on a plain canvas: what is on, where the camera is, and what the pointer does and is over.

const MANY = 1000; // points

class Scene extends Layers {
  constructor(canvas, data, shown) {
    super();
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
    const many = this.data.sets.some((set) => set.at.length > MANY); // they would hide the curve
    const points = () => on("points") && this.data.sets.forEach((set, k) => this.drawPoints(set, this.sets[k]));
    if (many) points();
    if (on("curve")) for (const each of entries) this.drawCurve(...each);
    if (on("knots")) for (const each of entries) this.drawKnots(...each);
    if (on("deviation")) for (const each of entries) this.drawDeviation(...each);
    if (!many) points();
    if (on("corners")) this.data.sets.forEach((set, k) => this.drawCorners(set, this.sets[k]));
    if (on("worst")) for (const [entry] of entries) this.drawWorst(entry);
    if (this.cursor) this.drawCursor();
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
