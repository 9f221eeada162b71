// What the view stands on: in the plane a grid, in space a box, with their scales.

class Ground {
  drawGrid() {
    const { pen, width, height, camera, data } = this;
    const edges = [camera.step(-width / 2, height / 2), camera.step(width / 2, -height / 2)];
    pen.lineWidth = 1;
    const names = [];
    for (const axis of [0, 1]) {
      const name = this.chosen[axis];
      const [stretch, origin] = [data.stretch[name] ?? 1, data.centre[name]];
      const real = edges.map((edge) => (camera.target[axis] + edge[axis]) / stretch + origin);
      const { values, text } = ticks(real[0], real[1], (axis ? height / 60 : width / 80) | 0);
      for (const value of values) {
        const at = [0, 0, 0];
        at[axis] = (value - origin) * stretch;
        const pixel = Math.round(camera.pixel(at)[axis]) + 0.5;
        pen.strokeStyle = Math.abs(value) < 1e-12 * Math.abs(real[1] - real[0]) ? PAINT.edge : PAINT.grid;
        pen.beginPath();
        pen.moveTo(axis ? 0 : pixel, axis ? pixel : 0);
        pen.lineTo(axis ? width : pixel, axis ? pixel : height);
        pen.stroke();
        if (axis ? pixel < height - 26 && pixel > 28 : pixel > 24 && pixel < width - 64)
          names.push([text(value), axis ? 6 : pixel, axis ? pixel + 4 : height - 7, PAINT.faint, axis ? "left" : "center"]);
      }
      const named = data.axes[name] + (data.unit && !(data.graph && axis === 0) ? ` (${data.unit})` : "");
      names.push([named, axis ? 6 : width - 8, axis ? 15 : height - 7, PAINT.ink, axis ? "left" : "right"]);
    }
    for (const each of names) label(pen, ...each);
  }

  // The box around everything, with ticks along an edge of each direction.
  drawBox() {
    const { pen, camera, low, high, data } = this;
    const corner = (k) => [0, 1, 2].map((j) => ((k >> j) & 1 ? high : low)[j]);
    const at = [...Array(8).keys()].map((k) => camera.pixel(corner(k)));
    pen.lineWidth = 1;
    pen.strokeStyle = PAINT.edge;
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
        label(pen, text(value), x + dx, y + dy, PAINT.faint, "center");
      }
      const [dx, dy] = aside(36);
      const named = data.axes[name] + (data.unit ? ` (${data.unit})` : "");
      label(pen, named, centre[0] + dx, centre[1] + dy, PAINT.ink, "center");
      pen.textBaseline = "alphabetic";
    }
  }
}
