// The page: what is on, what is pointed at, and how view, charts and table tell each other.

const data = JSON.parse(document.getElementById("data").textContent);
const find = (selector) => document.querySelector(selector);
const findAll = (selector) => [...document.querySelectorAll(selector)];
const several = data.entries.length > 1;
const SPIKE = 1000;

for (const entry of data.entries) {
  entry.hidden = false;
  entry.paint = entry.colour;
  entry.starts = new Set([0]);
  entry.along.span.forEach((span, i, all) => {
    if (i && span !== all[i - 1] && entry.first_spans.includes(span)) entry.starts.add(i);
  });
}

const shown = { combScale: 1, times: 1 };
for (const button of findAll("[data-show]")) shown[button.dataset.show] = button.getAttribute("aria-pressed") === "true";

const scene = new Scene(find("#view"), data, shown);
const range = [0, Math.max(...data.entries.map((entry) => entry.length))];

const deviations = new Chart(find("#deviation"), data, range, {
  series: (entry) => [
    ...(entry.between.room && !several ? [{ s: entry.between.s, y: entry.between.room, colour: PAINT.axis, thick: 1, quiet: true }] : []),
    { s: entry.between.s, y: entry.between.off, colour: entry.colour, alpha: several ? 0.55 : 0.8, thick: 1 },
    { s: entry.s, y: entry.off, colour: several ? entry.colour : data.sets[entry.set].colour, dots: true },
  ],
  levels: (entries) => {
    const tolerances = [...new Set(entries.map((entry) => entry.tolerance).filter((t) => t !== null))];
    return tolerances.map((value) => ({ value, name: `tolerance ${words(value)}`, colour: PAINT.ink }));
  },
  marks: (entries) =>
    entries.map((entry) => ({
      entry,
      s: entry.s[entry.worst.shown],
      value: entry.worst.off,
      point: entry.worst.shown,
      name: several ? "" : `point ${entry.worst.row}: ${words(entry.worst.off, 4)}`,
      colour: several ? entry.colour : PAINT.ink,
    })),
  valueAt: ({ entry, s, point }) =>
    point !== undefined ? entry.off[point] : entry.between.off[nearestRow(entry.between.s, s)],
});

const curvatures = data.entries[0].along.bend && new Chart(find("#curvature"), data, range, {
  series: (entry) => [
    { s: entry.along.s, y: entry.along.bend, colour: several ? entry.colour : "#009E73", breaks: entry.starts, thick: 1.4 },
  ],
  levels: () => [],
  marks: () => [],
  valueAt: ({ bend }) => bend,
});
const charts = [deviations, curvatures].filter(Boolean);

// What is pointed at: {entry, s} on a curve, {entry, point} or {entry, pole}; as one record for all to show.
function record(hit) {
  if (!hit) return null;
  const { entry, point, pole } = hit;
  if (pole !== undefined) return { entry, pole, place: entry.poles[pole], s: NaN };
  const at = placeAt(entry, point === undefined ? hit.s : entry.s[point]);
  return point === undefined ? { entry, ...at } : { entry, ...at, point, place: data.sets[entry.set].at[point] };
}

let pinned = null;

function show(hit, x, y, over) {
  const at = record(hit) ?? pinned;
  scene.cursor = at;
  scene.redraw();
  for (const chart of charts) {
    chart.cursor = at && Number.isFinite(at.s) ? at : null;
    chart.redraw();
  }
  const tip = find("#tip");
  tip.hidden = !hit;
  find("#readout").textContent = at ? lines(at).join("   ") : find("#readout").dataset.idle;
  if (!hit) return;
  tip.replaceChildren(...lines(at).map((text) => Object.assign(document.createElement("div"), { textContent: text })));
  const box = over.getBoundingClientRect();
  const width = tip.offsetWidth;
  tip.style.left = `${clamp(box.left + x + 16, 4, window.innerWidth - width - 8)}px`;
  tip.style.top = `${clamp(box.top + y + 16, 4, window.innerHeight - tip.offsetHeight - 8)}px`;
}

function lines({ entry, place, s, bend, point, pole }) {
  const unit = data.unit ? ` ${data.unit}` : "";
  const said = [];
  if (several) said.push(entry.name);
  if (point !== undefined) said.push(`point ${data.sets[entry.set].rows[point]}: off by ${words(entry.off[point], 4)}${unit}`);
  if (pole !== undefined) said.push(`pole ${pole}`);
  const coordinates = place.map((x, j) => `${data.axes[j]} ${words(x + data.centre[j], 7)}`);
  said.push(coordinates.slice(0, 6).join("  "));
  if (Number.isFinite(s)) said.push(`${words(s, 6)}${unit} along the curve`);
  if (bend !== null && bend !== undefined && pole === undefined) {
    const radius = Math.abs(bend) > 0 ? `radius ${words(1 / Math.abs(bend), 5)}${unit}` : "straight";
    said.push(`curvature ${words(bend, 4)}, ${radius}`);
  }
  return said;
}

function pin(hit) {
  pinned = record(hit);
  show(null);
}

// The view comes so near that some dozen points' distance fills it.
function visit(hit) {
  pin(hit);
  if (!pinned) return;
  const entry = pinned.entry;
  const spacing = entry.length / Math.max(data.sets[entry.set].total, 1);
  scene.goTo(pinned.place, Math.min(scene.width, scene.height) / Math.min(24 * spacing, scene.size / 6));
}

scene.hoverHook = (hit, x, y) => show(hit, x, y, scene.canvas);
scene.clickHook = pin;
for (const chart of charts) {
  chart.hoverHook = (hit, x, y) => show(hit, x, y, chart.canvas);
  chart.clickHook = visit;
  chart.rangeHook = ([low, high]) => {
    [range[0], range[1]] = [low, high];
    charts.forEach((each) => each.redraw());
  };
}

// Whether the largest curvature is out of all proportion to that along most of the curves.
function spiky(entries) {
  const bends = entries.flatMap((entry) => entry.along.bend.map(Math.abs)).sort((a, b) => a - b);
  return bends.at(-1) > SPIKE * (bends[Math.floor(bends.length / 2)] || Infinity);
}

const redraw = () => [scene, ...charts].forEach((each) => each.redraw());

function press(button, on) {
  button.setAttribute("aria-pressed", String(on));
}

for (const button of findAll("[data-show]"))
  button.addEventListener("click", () => {
    const name = button.dataset.show;
    press(button, (shown[name] = !shown[name]));
    for (const slider of findAll(`[data-for="${name}"]`)) slider.hidden = !shown[name];
    redraw();
  });
for (const button of findAll("[data-entry]"))
  button.addEventListener("click", () => {
    const entry = data.entries[Number(button.dataset.entry)];
    const last = !entry.hidden && data.entries.filter((each) => !each.hidden).length === 1;
    if (last) return;
    entry.hidden = !entry.hidden;
    press(button, !entry.hidden);
    redraw();
  });
for (const button of findAll("[data-log]"))
  button.addEventListener("click", () => {
    const chart = button.dataset.log === "deviation" ? deviations : curvatures;
    press(button, (chart.log = !chart.log));
    chart.redraw();
  });
for (const button of findAll("[data-look]")) button.addEventListener("click", () => scene.reset(button.dataset.look));
for (const button of findAll("[data-go]"))
  button.addEventListener("click", () => {
    const entry = data.entries[Number(button.dataset.go)];
    visit(button.dataset.at ? { entry, s: Number(button.dataset.at) } : { entry, point: entry.worst.shown });
  });
find("#whole").addEventListener("click", () => {
  scene.reset();
  charts[0].rangeHook([0, Math.max(...data.entries.map((entry) => entry.length))]);
  pin(null);
});
find("#save").addEventListener("click", () =>
  scene.canvas.toBlob((blob) => {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: "curve.png" });
    link.click();
    URL.revokeObjectURL(link.href);
  }),
);
for (const [k, choice] of findAll("[data-axis]").entries())
  choice.addEventListener("change", () => {
    const chosen = [...scene.chosen];
    chosen[k] = Number(choice.value);
    scene.chooseAxes(chosen);
  });

const scale = find("#comb-scale");
scale?.addEventListener("input", () => {
  shown.combScale = 10 ** Number(scale.value);
  scene.redraw();
});
// Times 1 is true to scale; at the right end the farthest point stands off by a quarter of the view.
const times = find("#times");
function magnify() {
  const farthest = Math.max(...data.entries.map((entry) => entry.worst.off), 1e-300);
  const most = Math.max(1, (0.25 * scene.size) / farthest);
  shown.times = Number(Math.exp(Number(times.value) * Math.log(most)).toPrecision(2));
  find("#times-said").textContent = `× ${words(shown.times, 2)}`;
  scene.redraw();
}
times.addEventListener("input", magnify);
magnify();
document.addEventListener("keydown", (event) => event.key === "Escape" && pin(null));
// On dark paper curves are drawn lighter.
const lighter = (colour) =>
  "#" + [1, 3, 5].map((k) => Math.round(0.65 * parseInt(colour.slice(k, k + 2), 16) + 0.35 * 255).toString(16)).join("");
function dress() {
  for (const entry of data.entries) entry.colour = theme.matches ? lighter(entry.paint) : entry.paint;
  redraw();
}
theme.addEventListener("change", dress);
dress();
// One spike would press all else to the floor.
if (curvatures && spiky(data.entries)) find("[data-log=curvature]").click();
document.documentElement.dataset.ready = "yes";
