// Plan: a mission file drawn on the map, or edited as text; either way the reader of `rover run` has the last word.
import { Draw, Modify, Snap } from "ol/interaction";
import { createEmpty, extend } from "ol/extent";
import { Circle, Point, Polygon } from "ol/geom";
import { get, post, type Json } from "./api";
import { Chart, disc, dot, feature, missionFeatures, outline } from "./chart";
import { checks } from "./checks";
import { button, choice, choose, field, fill, h, minutes, number, section } from "./dom";
import { settings } from "./settings";
import { readShapes, type Shape } from "./shapes";
import { attempt, mayOperate, onChange, refreshRuns, tell } from "./shared";
import { t, type Key } from "./strings";

const CHECK_AFTER_MS = 300;
// A hand on a mouse is no surveyor: what is drawn is rounded to 5 cm, what is typed or imported to 1 mm.
const rounded = (grid: number) => (value: number) => Math.round(Math.round(value / grid) * grid * 1000) / 1000;
const DRAWN = rounded(0.05);
const EXACT = rounded(0.001);
const START: Json = {
  mission: { name: "field", max_duration_s: 900 },
  area: { width_m: 3, height_m: 3 },
  launch: { x_m: 0.45, y_m: 0.45, heading_deg: 45 },
};

type Tool = "area" | "exclude" | "obstacle" | "goal" | "launch" | "marker";

export function plan() {
  let document: Json = structuredClone(START);
  let history: Json[] = [];
  let timer = 0;
  let typed = false;

  const chart = new Chart([], ["plan_file"]);
  const text = h("textarea", { rows: 16, spellcheck: "false", class: "toml" });
  const corners = h("textarea", { rows: 4, spellcheck: "false" });
  const problem = h("p", { class: "problem", role: "status" });
  const estimate = h("dl", { class: "pairs" });
  const names = choice([]);
  const name = h("input", { type: "text", value: "field", maxlength: 64, pattern: "[A-Za-z0-9][\\w\\-]*" });
  const form = settings((section_, key, value) => change((doc) => set(doc, section_, key, value)));

  function set(doc: Json, table: string, key: string, value: unknown): void {
    doc[table] ??= {};
    if (value === undefined || value === "") delete doc[table][key];
    else doc[table][key] = value;
    if (Object.keys(doc[table]).length === 0) delete doc[table];
  }

  /** What has been typed and not been read yet comes first: no edit may undo it. */
  function change(edit: (doc: Json) => void): void {
    if (!typed) { apply(edit); return; }
    clearTimeout(timer);
    attempt(async () => { await check({ text: text.value }); apply(edit); });
  }

  function apply(edit: (doc: Json) => void): void {
    history = [...history.slice(-49), structuredClone(document)];
    edit(document);
    show();
    later({ document });
  }

  function later(content: Json): void {
    clearTimeout(timer);
    fill(problem, t("checking"));
    timer = window.setTimeout(() => attempt(() => check(content)), CHECK_AFTER_MS);
  }

  async function check(content: Json): Promise<void> {
    if (!mayOperate()) return;
    const told = await post("missions/check", { name: name.value || "mission", ...content });
    if (content.text === text.value) typed = false;
    take(told, content.text === undefined);
  }

  function take(told: Json, withText: boolean): void {
    if (Object.keys(told.document).length) document = told.document;
    if (withText) text.value = told.text;
    fill(problem, told.problem || t("problem_none"));
    problem.classList.toggle("bad", told.problem !== "");
    fill(estimate, ...(told.estimate ? estimateRows(told.estimate) : []));
    show();
    fit();
  }

  function show(): void {
    chart.put("plan_file", drawn(document));
    form.show(document);
    corners.value = (document.area?.polygon ?? []).map(([x, y]: number[]) => `${x}, ${y}`).join("\n");
  }

  function fit(): void {
    const extent = createEmpty();
    for (const each of chart.source("plan_file").getFeatures()) extend(extent, each.getGeometry()!.getExtent());
    if (Number.isFinite(extent[0])) chart.fit(`${name.value} ${extent.map((v) => Math.ceil(v)).join()}`, extent);
  }

  // -- drawing --
  let tools: (Draw | Modify | Snap)[] = [];
  const KINDS: Record<Tool, "Polygon" | "Circle" | "Point"> = {
    area: "Polygon", exclude: "Polygon", obstacle: "Circle", goal: "Point", launch: "Point", marker: "Point",
  };

  function draw(tool: Tool | "move", pressed: HTMLButtonElement): void {
    const again = pressed.getAttribute("aria-pressed") === "true";
    for (const each of tools) chart.map.removeInteraction(each);
    tools = [];
    for (const each of bar.querySelectorAll("[aria-pressed]")) each.setAttribute("aria-pressed", "false");
    if (again) return;
    pressed.setAttribute("aria-pressed", "true");
    const source = chart.source("plan_file");
    if (tool === "move") {
      const modify = new Modify({ source });
      modify.on("modifyend", () => change((doc) => moved(doc, source.getFeatures())));
      tools = [modify];
    } else {
      const pen = new Draw({ type: KINDS[tool] });
      pen.on("drawend", ({ feature: f }) => change((doc) => add(doc, tool, f.getGeometry(), DRAWN)));
      tools = [pen];
    }
    tools.push(new Snap({ source }));
    for (const each of tools) chart.map.addInteraction(each);
  }

  const toolButton = (tool: Tool | "move") => {
    const made: HTMLButtonElement = button(t(`draw_${tool}` as Key), () => draw(tool, made), { "aria-pressed": "false" });
    return made;
  };
  const bar = h("div", { class: "tools", role: "toolbar", "aria-label": t("draw") },
    ...(["area", "exclude", "obstacle", "goal", "launch"] as const).map(toolButton));

  const file = h("input", { type: "file", accept: ".toml,.geojson,.json,.kml", change: () => attempt(load) });

  async function load(): Promise<void> {
    const chosen = file.files?.[0];
    if (!chosen) return;
    const content = await chosen.text();
    file.value = "";
    if (/\.toml$/i.test(chosen.name)) {
      name.value = chosen.name.replace(/\.toml$/i, "").replace(/[^\w-]+/g, "-");
      text.value = content;
      return check({ text: content });
    }
    try {
      const { shapes, origin } = readShapes(chosen.name, content, document);
      if (!shapes.length) return tell(t("import_none", { name: chosen.name }));
      change((doc) => {
        if (origin) doc.site = { ...doc.site, origin: [origin.latitude, origin.longitude], bearing_deg: origin.bearing_deg };
        shapes.forEach((shape, index) => take_in(doc, shape, index));
      });
      tell(t("imported", { count: shapes.length }));
    } catch (error) {
      tell(t("import_bad", { name: chosen.name, why: error instanceof Error ? error.message : String(error) }));
    }
  }

  function save(): void {
    attempt(async () => {
      const told = await post("missions", { name: name.value, text: text.value });
      take(told, true);
      tell(t("saved", { name: name.value }));
      await list();
      choose(names, [...names.options].map((each) => [each.value, each.text]), name.value);
      await refreshRuns();
    });
  }

  async function list(): Promise<void> {
    const told = await get("missions");
    choose(names, [...told.own, ...told.shipped].map((each: string) => [each, each]));
    const keys: Json = told.sections;
    form.offer(keys);
    if (keys.markers && !bar.querySelector("[data-marker]")) {
      const marker = toolButton("marker");
      marker.dataset.marker = "";
      bar.append(marker);
    }
  }

  function open(): void {
    attempt(async () => {
      const told = await get(`missions/${encodeURIComponent(names.value)}`);
      name.value = names.value;
      history = [];
      take(told, true);
    });
  }

  function download(): void {
    const address = URL.createObjectURL(new Blob([text.value], { type: "application/toml" }));
    const link = h("a", { href: address, download: `${name.value}.toml` });
    link.click();
    URL.revokeObjectURL(address);
  }

  function undo(): void {
    const before = history.pop();
    if (!before) return;
    document = before;
    show();
    later({ document });
  }

  text.addEventListener("input", () => { typed = true; later({ text: text.value }); });
  const applyCorners = () => change((doc) => {
    const points = corners.value.split("\n").map((row) => row.split(/[\s,;]+/).filter(Boolean).map(Number))
      .filter((row) => row.length === 2 && row.every(Number.isFinite));
    add(doc, "area", outline(points));
  });

  const element = h("div", { class: "page" },
    section(t("mission"),
      h("div", { class: "row" }, field(t("mission_load"), names), button(t("load"), open),
        button(t("new_mission"), () => { document = structuredClone(START); history = []; show(); later({ document }); }),
        field(t("import_file"), file)),
      bar, h("p", { class: "hint" }, t("draw_help")), chart.element,
      h("div", { class: "row" }, button(t("undo"), undo)),
      problem,
      h("div", { class: "row" }, field(t("file_name"), name), button(t("save"), save, { class: "primary" }), button(t("download"), download))),
    h("div", { class: "column" },
      section(t("estimate"), estimate),
      form.element,
      section(t("corners"), field(t("corners"), corners), button(t("apply"), applyCorners)),
      section(t("toml"), field(t("toml"), text)),
      checks(() => document, () => problem.textContent ?? ""),
    ));

  let begun = false;
  onChange(() => { if (!begun && mayOperate()) { begun = true; show(); later({ document }); } });
  return { element, shown: () => { chart.shown(); attempt(list); requestAnimationFrame(fit); } };
}

function estimateRows(told: Json): HTMLElement[] {
  const from = told.runs ? ` (${t("est_from", { runs: told.runs })})` : "";
  const rows: [Key, string][] = [
    ["est_area", `${number(told.area_m2, 1)} m²`],
    ["est_duration", told.duration_s === null ? t("est_unknown") : minutes(told.duration_s) + from],
    ["est_energy", told.energy_wh === null ? "–" : `${number(told.energy_wh, 1)} / ${number(told.battery_wh, 1)} Wh`],
    ["est_coverage", told.coverage === null ? "–" : `${number(100 * told.coverage, 0)} %`],
  ];
  return rows.flatMap(([key, value]) => [h("dt", {}, t(key)), h("dd", {}, value)]);
}

/** The document as it stands, also one that the reader refuses. */
function drawn(doc: Json) {
  const area = doc.area ?? {};
  const launch = doc.launch ?? {};
  const mission = {
    area: {
      width_m: area.width_m ?? 1, height_m: area.height_m ?? 1,
      polygon: area.polygon ?? [], exclude: area.exclude ?? [], obstacles: area.obstacles ?? [],
    },
    goals: doc.mission?.goals ?? [],
    launch: { x: launch.x_m ?? 0, y: launch.y_m ?? 0, heading: ((launch.heading_deg ?? 0) * Math.PI) / 180 },
  };
  const plates = doc.markers?.plates ?? [];
  return [...missionFeatures(mission), ...plates.map(([x, y]: number[]) => feature("marker", dot(x ?? 0, y ?? 0)))];
}

function add(doc: Json, tool: Tool, geometry: unknown, round = EXACT): void {
  doc.area ??= {};
  doc.mission ??= {};
  if (geometry instanceof Polygon) {
    const ring = (geometry.getCoordinates()[0] ?? []).slice(0, -1).map((point) => point.slice(0, 2).map(round));
    if (tool === "exclude") doc.area.exclude = [...(doc.area.exclude ?? []), ring];
    else { doc.area.polygon = ring; delete doc.area.width_m; delete doc.area.height_m; }
  } else if (geometry instanceof Circle) {
    const [x = 0, y = 0] = geometry.getCenter();
    doc.area.obstacles = [...(doc.area.obstacles ?? []), [round(x), round(y), round(geometry.getRadius())]];
  } else if (geometry instanceof Point) {
    const [x = 0, y = 0] = geometry.getCoordinates().map(round);
    if (tool === "launch") doc.launch = { ...doc.launch, x_m: x, y_m: y };
    else if (tool === "marker") doc.markers = { ...doc.markers, plates: [...(doc.markers?.plates ?? []), [x, y]] };
    else doc.mission.goals = [...(doc.mission.goals ?? []), [x, y]];
  }
}

/** Everything anew from what the map shows. */
function moved(doc: Json, features: { get(key: string): any; getGeometry(): any }[]): void {
  const of = (style: string) => features.filter((each) => each.get("style") === style).map((each) => each.getGeometry());
  const [area] = of("area");
  doc.area.exclude = doc.mission.goals = doc.area.obstacles = undefined;
  if (area) add(doc, "area", area);
  for (const each of of("exclude")) add(doc, "exclude", each);
  for (const each of of("obstacle")) add(doc, "obstacle", each);
  for (const each of of("goal")) add(doc, "goal", each);
  for (const each of of("launch")) add(doc, "launch", each);
  for (const key of ["exclude", "obstacles"]) if (doc.area[key] === undefined) delete doc.area[key];
  if (doc.mission.goals === undefined) delete doc.mission.goals;
}

function take_in(doc: Json, shape: Shape, index: number): void {
  const kind = shape.kind;
  if (shape.point) {
    const tool: Tool = /launch|start/.test(kind) ? "launch" : /marker|plate/.test(kind) ? "marker" : "goal";
    add(doc, tool, dot(shape.point[0] ?? 0, shape.point[1] ?? 0));
  } else if (shape.polygon) {
    const circle = /obstacle/.test(kind);
    if (circle) add(doc, "obstacle", around(shape.polygon));
    else add(doc, /exclu|keep-?out|hole/.test(kind) || (index > 0 && kind !== "area") ? "exclude" : "area", outline(shape.polygon));
  }
}

function around(polygon: number[][]): Circle {
  const [x = 0, y = 0] = [0, 1].map((axis) => polygon.reduce((sum, point) => sum + (point[axis] ?? 0), 0) / polygon.length);
  return disc(x, y, Math.max(...polygon.map(([px = 0, py = 0]) => Math.hypot(px - x, py - y))));
}
