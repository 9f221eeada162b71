// Numbers, ticks and pieces of curves: what the view and the charts share.

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function words(x, digits = 6) {
  if (!Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e7 || size < 1e-4) {
    const [head, power] = x.toExponential(digits - 1).split("e");
    return `${head.includes(".") ? head.replace(/\.?0+$/, "") : head}e${power.replace("+", "")}`;
  }
  const text = size >= 10 ** digits ? String(Number(x.toPrecision(digits))) : x.toPrecision(digits);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

// Round values between low and high, about `count` of them, and how to write them.
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  if (!(rough > 0)) return { values: [], text: words };
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((m) => m * power >= rough * 0.999) ?? 10);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) values.push(k * step);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const plain = largest < 1e6 && decimals <= 7;
  const digits = Math.ceil(Math.log10(largest / step)) + 1;
  const text = (x) => (Math.abs(x) < step * 1e-6 ? "0" : plain ? x.toFixed(decimals) : words(x, clamp(digits, 2, 12)));
  return { values, text };
}

// The last row of a rising list that is at most x.
function rowOf(list, x) {
  let low = 0;
  let high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle] <= x) low = middle;
    else high = middle - 1;
  }
  return low;
}

// The row of a list, rising or not, whose value is nearest to x.
function nearestRow(list, x) {
  let best = 0;
  for (let i = 1; i < list.length; i++) if (Math.abs(list[i] - x) < Math.abs(list[best] - x)) best = i;
  return best;
}

function bezier(chain, span, t) {
  const [p, q, r, s] = chain.slice(3 * span, 3 * span + 4);
  const o = 1 - t;
  return p.map((_, j) => o * o * o * p[j] + 3 * o * o * t * q[j] + 3 * o * t * t * r[j] + t * t * t * s[j]);
}

// Where a curve is at the arc length s: the place, the curvature, the span.
function placeAt(entry, s) {
  const along = entry.along;
  let i = Math.min(rowOf(along.s, s), along.s.length - 2);
  while (i > 0 && along.span[i] !== along.span[i + 1]) i--;
  const gap = along.s[i + 1] - along.s[i];
  const part = gap > 0 ? clamp((s - along.s[i]) / gap, 0, 1) : 0;
  const mix = (a, b) => a + part * (b - a);
  const span = along.span[i];
  return {
    s: clamp(s, 0, entry.length),
    place: bezier(entry.chain, span, mix(along.t[i], along.t[i + 1])),
    bend: along.bend ? mix(along.bend[i], along.bend[i + 1]) : null,
    curvature: along.curvature ? along.curvature[i].map((x, j) => mix(x, along.curvature[i + 1][j])) : null,
    span,
  };
}

// A canvas as large as its box, in the screen's own pixels.
function sized(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

// Text that stays readable over lines.
function label(pen, text, x, y, colour, align = "left") {
  pen.save();
  pen.textAlign = align;
  pen.lineJoin = "round";
  pen.lineWidth = 3;
  pen.strokeStyle = PAINT.halo;
  pen.strokeText(text, x, y);
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
  pen.restore();
}

const FONT = '11.5px system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';

// The colours of the page, by the names they have in its style; they change with the theme.
const PAINT = {};
const theme = window.matchMedia("(prefers-color-scheme: dark)");
function mix() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "faint", "paper", "halo", "grid", "axis", "edge", "poles"])
    PAINT[name] = style.getPropertyValue(`--${name}`).trim();
}
mix();
theme.addEventListener("change", mix);
