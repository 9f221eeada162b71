// How the view looks at the world: turned, moved and scaled, without perspective, so curves stay exact at any zoom.

class Camera {
  constructor(flat) {
    this.flat = flat;
    this.target = [0, 0, 0];
    this.scale = 1;
    this.width = this.height = 1;
    this.look(flat ? "top" : "iso");
  }

  look(name) {
    const [third, sixth] = [Math.sqrt(1 / 3), Math.sqrt(1 / 6)];
    const half = Math.SQRT1_2;
    this.turn = {
      top: [1, 0, 0, 0, 1, 0, 0, 0, 1],
      front: [1, 0, 0, 0, 0, 1, 0, -1, 0],
      side: [0, 1, 0, 0, 0, 1, 1, 0, 0],
      iso: [half, half, 0, -sixth, sixth, 2 * sixth, third, -third, third],
    }[name];
  }

  // Right, up and toward the eye of points, n times three numbers, as pixels in `out`, n times two.
  project(points, out) {
    const [a, b, c, d, e, f] = this.turn;
    const [x0, y0, z0] = this.target;
    const k = this.scale;
    const [cx, cy] = [this.width / 2, this.height / 2];
    for (let i = 0, j = 0; j < out.length; i += 3, j += 2) {
      const x = points[i] - x0;
      const y = points[i + 1] - y0;
      const z = points[i + 2] - z0;
      out[j] = cx + k * (a * x + b * y + c * z);
      out[j + 1] = cy - k * (d * x + e * y + f * z);
    }
    return out;
  }

  pixel(point) {
    return this.project(point, [0, 0]);
  }

  // The world's step that moves by that many pixels on the screen.
  step(right, down) {
    const m = this.turn;
    return [0, 1, 2].map((j) => (m[j] * right - m[3 + j] * down) / this.scale);
  }

  pan(right, down) {
    const step = this.step(right, down);
    this.target = this.target.map((x, j) => x - step[j]);
  }

  zoom(factor, x, y) {
    const next = clamp(this.scale * factor, this.least, this.most);
    const ratio = next / this.scale;
    const step = this.step(x - this.width / 2, y - this.height / 2);
    this.target = this.target.map((value, j) => value + step[j] * (1 - 1 / ratio));
    this.scale = next;
  }

  // Turn with the drag: about the world's upright axis and the screen's horizontal one.
  rotate(right, down) {
    const [s, c] = [-Math.sin(right), Math.cos(right)];
    const m = this.turn;
    const spun = [0, 3, 6].flatMap((r) => [m[r] * c - m[r + 1] * s, m[r] * s + m[r + 1] * c, m[r + 2]]);
    const [sd, cd] = [Math.sin(down), Math.cos(down)];
    const up = [0, 1, 2].map((j) => spun[3 + j] * cd - spun[6 + j] * sd);
    const near = [0, 1, 2].map((j) => spun[3 + j] * sd + spun[6 + j] * cd);
    this.turn = [...spun.slice(0, 3), ...up, ...near];
  }

  // Show a box, [low, high] of three numbers each, whole.
  frame(low, high, margin = 0.82) {
    this.target = low.map((x, j) => (x + high[j]) / 2);
    this.scale = 1;
    const corners = [...Array(8).keys()].flatMap((k) => [0, 1, 2].map((j) => ((k >> j) & 1 ? high : low)[j]));
    const at = this.project(corners, new Float64Array(16));
    const spread = (from) => {
      const values = [...at].filter((_, i) => i % 2 === from);
      return Math.max(...values) - Math.min(...values);
    };
    const size = Math.hypot(...low.map((x, j) => high[j] - x)) || 1;
    const fits = Math.min(this.width / (spread(0) || size * 1e-9), this.height / (spread(1) || size * 1e-9));
    this.scale = margin * fits;
    this.least = this.scale / 50;
    this.most = (1e9 * Math.min(this.width, this.height)) / size;
  }
}
