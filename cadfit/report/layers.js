// What the view draws of fits: curves, knots, poles, points, corners, combs, deviations, and what is pointed at.

class Layers extends Ground {
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
    pen.strokeStyle = several ? entry.colour : PAINT.poles;
    pen.globalAlpha = several ? 0.6 : 1;
    pen.lineWidth = 1;
    let start = 0;
    for (const count of entry.pole_counts) {
      pen.beginPath();
      for (let i = start; i < start + count; i++) pen.lineTo(p[2 * i], p[2 * i + 1]);
      pen.stroke();
      start += count;
    }
    pen.fillStyle = PAINT.paper;
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
    pen.fillStyle = data.entries.length > 1 ? PAINT.ink : set.colour;
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
    pen.strokeStyle = PAINT.ink;
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
    pen.strokeStyle = several ? entry.colour : PAINT.ink;
    pen.lineWidth = 1.6;
    pen.beginPath();
    pen.arc(x, y, 8, 0, 7);
    pen.stroke();
    if (several) return;
    const right = x < this.width - 170;
    const off = words(entry.worst.off, 3) + (this.data.unit ? ` ${this.data.unit}` : "");
    label(pen, `farthest point: ${off}`, x + (right ? 12 : -12), y - 10, PAINT.ink, right ? "left" : "right");
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
        pen.strokeStyle = PAINT.faint;
        pen.setLineDash([4, 4]);
        pen.lineWidth = 1;
        pen.beginPath();
        pen.arc(centre[0], centre[1], radius, 0, 7);
        pen.stroke();
        pen.setLineDash([]);
      }
    }
    pen.fillStyle = PAINT.paper;
    pen.strokeStyle = PAINT.ink;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc(x, y, 4.5, 0, 7);
    pen.fill();
    pen.stroke();
  }
}
