// A chart over the arc length: wheel and drag zoom it, the pointer is told to the view, a click goes there.

const MARGIN = { left: 66, right: 14, top: 8, bottom: 24 };

class Chart {
  constructor(canvas, data, range, options) {
    Object.assign(this, { canvas, data, range, log: false, cursor: null, hoverHook: () => {}, clickHook: () => {}, rangeHook: () => {} });
    Object.assign(this, options);
    this.dirty = false;
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.listen();
  }

  redraw() {
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => this.draw());
  }

  get entries() {
    return this.data.entries.filter((entry) => !entry.hidden);
  }

  // The lowest and the highest value shown.
  limits() {
    let [low, high] = [0, 0];
    let least = Infinity;
    const [from, to] = this.range;
    const take = (s, y) => {
      for (let i = 0; i < s.length; i++) {
        if (s[i] < from || s[i] > to) continue;
        const value = this.log ? Math.abs(y[i]) : y[i];
        if (value < low) low = value;
        if (value > high) high = value;
        if (value > 0 && value < least) least = value;
      }
    };
    for (const entry of this.entries) for (const { s, y, quiet } of this.series(entry)) if (!quiet) take(s, y);
    for (const level of this.levels(this.entries)) if (level.value < 8 * high || !high || this.log) high = Math.max(high, level.value);
    if (!(high > low)) high = low + 1;
    if (this.log) return [Math.max(least, high * 1e-5), high * 1.4];
    const room = 0.07 * (high - low);
    return [low < 0 ? low - room : 0, high > 0 ? high + room : 0];
  }

  draw() {
    this.dirty = false;
    const { pen, width, height } = sized(this.canvas);
    if (!width || !height) return;
    pen.font = FONT;
    const box = { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: height - MARGIN.bottom };
    const [low, high] = this.limits();
    const [from, to] = this.range;
    const x = (s) => box.left + ((s - from) / (to - from)) * (box.right - box.left);
    const up = (value) => (this.log ? Math.log(Math.max(Math.abs(value), low) / low) / Math.log(high / low) : (value - low) / (high - low));
    const y = (value) => box.bottom - up(value) * (box.bottom - box.top);
    Object.assign(this, { pen, box, x, y });
    this.drawAxes(low, high);
    pen.save();
    pen.beginPath();
    pen.rect(box.left, box.top - 6, box.right - box.left, box.bottom - box.top + 6);
    pen.clip();
    this.drawCorners();
    for (const entry of this.entries) for (const series of this.series(entry)) this.drawSeries(series);
    const levels = this.levels(this.entries).filter(({ value }) => value <= high);
    for (const level of levels) this.drawLevel(level);
    pen.restore();
    for (const mark of this.marks(this.entries)) this.drawMark(mark, levels);
    if (this.cursor) this.drawCursor();
    if (this.selection) {
      pen.fillStyle = "rgba(0,114,178,0.12)";
      pen.fillRect(this.selection[0], box.top, this.selection[1] - this.selection[0], box.bottom - box.top);
    }
  }

  drawAxes(low, high) {
    const { pen, box, x, y } = this;
    const [from, to] = this.range;
    pen.lineWidth = 1;
    const line = (colour, x0, y0, x1, y1) => {
      pen.strokeStyle = colour;
      pen.beginPath();
      pen.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
      pen.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
      pen.stroke();
    };
    const across = ticks(from, to, (box.right - box.left) / 90);
    pen.fillStyle = PAINT.faint;
    pen.textAlign = "center";
    for (const value of across.values) {
      line(PAINT.grid, x(value), box.top, x(value), box.bottom);
      pen.fillText(across.text(value), x(value), box.bottom + 15);
    }
    let upward = ticks(low, high, (box.bottom - box.top) / 22);
    if (this.log) {
      const values = [];
      for (let power = Math.ceil(Math.log10(low)); 10 ** power <= high; power++) values.push(10 ** power);
      const every = Math.ceil(values.length / Math.max(2, (box.bottom - box.top) / 24));
      upward = { values: values.filter((_, k) => k % every === 0), text: (value) => words(value, 3) };
    }
    pen.textAlign = "right";
    for (const value of upward.values) {
      line(value === 0 && low < 0 ? PAINT.axis : PAINT.grid, box.left, y(value), box.right, y(value));
      pen.fillText(upward.text(value), box.left - 7, y(value) + 4);
    }
    line(PAINT.axis, box.left, box.bottom, box.right, box.bottom);
    line(PAINT.axis, box.left, box.top, box.left, box.bottom);
  }

  drawCorners() {
    const { pen, box, x } = this;
    pen.strokeStyle = PAINT.edge;
    pen.setLineDash([2, 3]);
    pen.beginPath();
    for (const entry of this.entries)
      for (const s of entry.joints) {
        pen.moveTo(x(s), box.top);
        pen.lineTo(x(s), box.bottom);
      }
    pen.stroke();
    pen.setLineDash([]);
  }

  drawSeries({ s, y: values, colour, dots, breaks, alpha = 1, thick = 1.3 }) {
    const { pen, x, y, box } = this;
    const [from, to] = this.range;
    pen.globalAlpha = alpha;
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = thick;
    pen.beginPath();
    if (dots) {
      const r = clamp((0.3 * (box.right - box.left) * (s.at(-1) - s[0])) / ((to - from) * s.length || 1), 1.1, 2.6);
      for (let i = 0; i < s.length; i++) {
        if (s[i] < from || s[i] > to) continue;
        if (r < 1.5) pen.rect(x(s[i]) - r, y(values[i]) - r, 2 * r, 2 * r);
        else {
          pen.moveTo(x(s[i]) + r, y(values[i]));
          pen.arc(x(s[i]), y(values[i]), r, 0, 7);
        }
      }
      if (s.length > 5000) pen.globalAlpha = 0.5;
      pen.fill();
    } else {
      pen.lineJoin = "bevel";
      for (let i = 0; i < s.length; i++) pen[breaks?.has(i) ? "moveTo" : "lineTo"](clamp(x(s[i]), -1e4, 1e5), y(values[i]));
      pen.stroke();
    }
    pen.globalAlpha = 1;
  }

  // The name stands at the end of the line that is farther from the marks.
  drawLevel({ value, name, colour }) {
    const { pen, box, x, y } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = 1.2;
    pen.setLineDash([6, 4]);
    pen.beginPath();
    pen.moveTo(box.left, y(value));
    pen.lineTo(box.right, y(value));
    pen.stroke();
    pen.setLineDash([]);
    const places = this.marks(this.entries).map(({ s }) => x(s));
    const atEnd = Math.min(...places) - box.left < box.right - Math.max(...places);
    const below = y(value) - box.top < 14;
    label(pen, name, atEnd ? box.right - 8 : box.left + 8, y(value) + (below ? 14 : -5), colour, atEnd ? "right" : "left");
  }

  // The name stands above the ring, or below it where above is no room, or a level's line.
  drawMark({ s, value, name, colour }, levels) {
    const { pen, box, x, y } = this;
    const [px, py] = [x(s), y(value)];
    if (px < box.left - 1 || px > box.right + 1) return;
    pen.strokeStyle = colour;
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(px, py, 6, 0, 7);
    pen.stroke();
    const right = px < box.right - 150;
    const crossed = (baseline) => levels.some((level) => Math.abs(y(level.value) - baseline + 4) < 9);
    const [above, below] = [py - 7, py + 16];
    const free = (baseline) => baseline > box.top + 8 && baseline < box.bottom + 4 && !crossed(baseline);
    const baseline = [above, below, py - 20, py + 28].find(free) ?? above;
    label(pen, name, px + (right ? 9 : -9), baseline, PAINT.ink, right ? "left" : "right");
  }

  drawCursor() {
    const { pen, box, x, y, cursor } = this;
    const px = x(cursor.s);
    if (px < box.left - 1 || px > box.right + 1) return;
    pen.strokeStyle = PAINT.faint;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(px, box.top);
    pen.lineTo(px, box.bottom);
    pen.stroke();
    const value = this.valueAt(cursor);
    if (value === null || value === undefined) return;
    pen.fillStyle = PAINT.paper;
    pen.strokeStyle = PAINT.ink;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc(px, clamp(y(value), box.top, box.bottom), 4, 0, 7);
    pen.fill();
    pen.stroke();
  }

  // The entry and the arc length under the pointer: with several entries the one whose value is nearest.
  under(px, py) {
    if (!this.box || px < this.box.left - 8 || px > this.box.right + 8) return null;
    const [from, to] = this.range;
    const part = clamp((px - this.box.left) / (this.box.right - this.box.left), 0, 1);
    const s = from + part * (to - from);
    let [found, least] = [null, Infinity];
    for (const mark of this.marks(this.entries))
      if (Math.hypot(this.x(mark.s) - px, this.y(mark.value) - py) < 10) return { entry: mark.entry, s: mark.s, point: mark.point };
    for (const entry of this.entries) {
      const here = { entry, s: clamp(s, 0, entry.length) };
      const value = this.valueAt({ ...here, ...placeAt(entry, here.s) });
      const far = value === null ? 1e6 : Math.abs(this.y(value) - py);
      if (far < least) [found, least] = [here, far];
    }
    return found;
  }

  listen() {
    const { canvas } = this;
    let from = null;
    const here = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const whole = () => [0, Math.max(...this.entries.map((entry) => entry.length))];
    canvas.addEventListener("pointerdown", (event) => {
      from = here(event)[0];
      canvas.setPointerCapture?.(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y] = here(event);
      if (from !== null && Math.abs(x - from) > 4) {
        const { left, right } = this.box;
        this.selection = [Math.min(x, from), Math.max(x, from)].map((v) => clamp(v, left, right));
        this.redraw();
      } else this.hoverHook(this.under(x, y), x, y);
    });
    canvas.addEventListener("pointerup", (event) => {
      const chosen = this.selection;
      [from, this.selection] = [null, null];
      if (!chosen) return this.clickHook(this.under(...here(event)));
      const { left, right } = this.box;
      const [low, high] = this.range;
      const at = chosen.map((x) => low + ((x - left) / (right - left)) * (high - low));
      if (at[1] > at[0]) this.rangeHook(at);
      this.redraw();
    });
    canvas.addEventListener("pointerleave", () => this.hoverHook(null));
    canvas.addEventListener("dblclick", () => this.rangeHook(whole()));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const [low, high] = this.range;
      const middle = low + ((here(event)[0] - this.box.left) / (this.box.right - this.box.left)) * (high - low);
      const factor = Math.exp(clamp(event.deltaY, -300, 300) * 0.002);
      const [first, last] = whole();
      const next = [middle + (low - middle) * factor, middle + (high - middle) * factor].map((s) => clamp(s, first, last));
      if (next[1] - next[0] > last * 1e-9) this.rangeHook(next);
    }, { passive: false });
  }
}
