// Review: the runs of the folder, one of them again over time, and beside another.
import { get, type Json } from "./api";
import { Chart, disc, dot, feature, outline } from "./chart";
import { button, choice, choose, field, fill, h, number, section } from "./dom";
import { showPlan, showRover, showTrack, zoneFeatures } from "./field";
import { Picture } from "./picture";
import { attempt, now, onChange, tell } from "./shared";
import { Signals } from "./signals";
import { t, word } from "./strings";

const SAME_M = 0.3;
const STEP_S = 0.5;
const path = (run: string) => `runs/${encodeURIComponent(run)}`;
const before = (entries: Json[], time: number) => entries.filter((each) => each.t <= time).at(-1);

export function review() {
  let run = "";
  let replay: Json | null = null;
  let told: Json = {};
  let other: Json[] = [];
  let playing = 0;

  const chart = new Chart(["seen", "obstacles"], ["plan_file", "zones", "track", "plan", "sigma", "other"]);
  const picture = new Picture();
  const signals = new Signals([[t("battery"), "V"]]);
  const filter = h("input", { type: "search", input: () => drawRuns() });
  const rows = h("tbody", {});
  const slider = h("input", { type: "range", min: 0, max: 1, step: 0.1, value: 0, input: () => show() });
  const at = h("output", {});
  const play = button(t("play"), toggle);
  const events = h("ol", { class: "events", tabindex: 0, "aria-label": t("events") });
  const files = h("ul", { class: "files" });
  const headline = h("p", { class: "headline" });
  const goOn = button(t("go_on"), () => { now.resume = run; location.hash = "drive"; });
  goOn.hidden = true;
  const compare = choice([["", t("compare_none")]]);
  const difference = h("p", { role: "status" });

  function drawRuns(): void {
    const wanted = filter.value.trim().toLowerCase();
    const shown = now.runs.filter((each) => `${each.utc} ${each.name} ${each.mission} ${each.site?.name ?? ""}`.toLowerCase().includes(wanted));
    fill(rows, ...shown.map((each) => h("tr", { class: each.name === run ? "chosen" : "" },
      h("td", {}, button(each.utc.replace("T", " ").slice(0, 16), () => open(each.name), { "aria-pressed": String(each.name === run) })),
      h("td", {}, each.site?.name || each.mission || each.name),
      h("td", {}, each.state === "over" ? `${each.status}: ${each.reason}` : word(each.state)))));
    if (!shown.length) fill(rows, h("tr", {}, h("td", { colspan: 3 }, t("runs_none"))));
  }

  function open(name: string): void {
    run = now.shown = name;
    replay = null;
    drawRuns();
    attempt(async () => {
      headline.textContent = t("loading");
      told = await get(path(name));
      drawFiles();
      goOn.hidden = !told.run?.can_go_on;
      headline.textContent = told.summary.status ? t("ended", { status: told.summary.status, reason: told.summary.reason }) : word(told.run?.state ?? "");
      try {
        const known = await get(`${path(name)}/replay`);
        if (run === name) { replay = known; begin(); }
      } catch (error) {
        tell(error instanceof Error ? error.message : t("replay_none"));
      }
    });
  }

  function drawFiles(): void {
    const link = (name: string, text: string, save: boolean) =>
      h("a", { href: `api/${path(run)}/files/${name}${save ? "?save" : ""}`, ...(save ? { download: "" } : { target: "_blank", rel: "noopener" }) }, text);
    const names: string[] = told.run?.files ?? [];
    fill(files,
      names.includes("report.html") && h("li", {}, link("report.html", t("report"), false)),
      ...names.map((name) => h("li", {}, link(name, name, true))));
  }

  function begin(): void {
    if (!replay) return;
    const end = replay.poses.at(-1)?.[0] ?? 1;
    slider.max = String(end);
    slider.value = String(end);
    signals.set(t("battery"), replay.battery);
    const map = replay.maps.at(-1);
    const size = map ? [map.width_m, map.height_m] : [3, 3];
    chart.put("plan_file", [feature("area", outline([[0, 0], [size[0], 0], size, [0, size[1]]]))]);
    chart.fit(run, [0, 0, size[0], size[1]]);
    show();
  }

  function show(): void {
    if (!replay) return;
    const time = Number(slider.value);
    at.textContent = `${number(time, 1)} s`;
    slider.setAttribute("aria-valuetext", at.textContent);
    const driven = replay.poses.filter((pose: number[]) => (pose[0] ?? 0) <= time);
    showTrack(chart, driven.map(([, x, y]: number[]) => [x, y]));
    const pose = driven.at(-1) ?? replay.poses[0];
    if (pose) showRover(chart, pose[1], pose[2], pose[3], NaN);
    showPlan(chart, before(replay.plans, time)?.points ?? []);
    const last = time >= Number(slider.max) - STEP_S && told.summary.detections;
    const places: Json[] = last ? told.summary.detections : (before(replay.places, time)?.places ?? []);
    chart.put("zones", zoneFeatures(places, places.map((place) => ({ ...place, r: place.zone_radius_m ?? 0.15 })), told.judgements));
    const map = before(replay.maps, time) ?? replay.maps[0];
    if (map) for (const name of ["seen", "obstacles"] as const) chart.raster(name, map[name], map.width_m, map.height_m);
    fill(events, ...replay.events.filter((each: Json) => each.t <= time).slice(-20).reverse()
      .map((each: Json) => h("li", {}, h("time", {}, `${number(each.t, 1)} s `), each.text)));
    const index = Math.max(0, replay.pictures.findLastIndex((each: number) => each <= time));
    if (replay.pictures.length) void picture.show(`api/${path(run)}/pictures/${index}`, [], replay.pictures[index]);
  }

  function toggle(): void {
    if (playing) { clearInterval(playing); playing = 0; play.textContent = t("play"); return; }
    if (Number(slider.value) >= Number(slider.max)) slider.value = "0";
    play.textContent = t("halt");
    playing = window.setInterval(() => {
      slider.value = String(Number(slider.value) + STEP_S);
      show();
      if (Number(slider.value) >= Number(slider.max)) toggle();
    }, 250);
  }

  async function side(): Promise<void> {
    other = compare.value ? ((await get(path(compare.value))).summary.detections ?? []) : [];
    chart.put("other", other.map((place) => feature("other", compareShape(place), {})));
    const own: Json[] = told.summary?.detections ?? [];
    const near = (a: Json, b: Json) => Math.hypot(a.x - b.x, a.y - b.y) <= SAME_M;
    const both = own.filter((a) => other.some((b) => near(a, b))).length;
    const lost = other.filter((b) => !own.some((a) => near(a, b))).length;
    difference.textContent = compare.value
      ? t("compare_line", { both, only_a: own.length - both, only_b: lost, a: run, b: compare.value, m: SAME_M }) : "";
  }
  compare.addEventListener("change", () => attempt(side));

  onChange(() => {
    if (element.hidden) return;
    drawRuns();
    choose(compare, [["", t("compare_none")], ...now.runs.map((each): [string, string] => [each.name, each.name])]);
  });

  const element = h("div", { class: "page aside" },
    h("div", { class: "column" },
      section(t("runs"), field(t("filter"), filter), h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": t("runs") },
        h("table", {}, h("thead", {}, h("tr", {}, h("th", { scope: "col" }, t("when")), h("th", { scope: "col" }, t("what")), h("th", { scope: "col" }, t("how")))), rows))),
      section(t("export"), files),
      section(t("compare"), field(t("compare"), compare), difference)),
    h("div", { class: "column wide" },
      section(t("replay"), headline, goOn, chart.element, h("div", { class: "row slider" }, play, field(t("slider"), slider), at)),
      section(t("thermal"), picture.canvas), section(t("signals"), signals.element), section(t("events"), events)));
  return {
    element,
    shown: () => { chart.shown(); drawRuns(); if (now.shown && now.shown !== run) open(now.shown); },
  };
}

function compareShape(place: Json) {
  return place.sigma_m > 0.05 ? disc(place.x, place.y, place.sigma_m) : dot(place.x, place.y);
}
