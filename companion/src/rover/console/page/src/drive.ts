// Drive: the mission on its way, and what may be said to it.
import { get, post, type Json } from "./api";
import { Chart, feature, outline } from "./chart";
import { button, choice, choose, field, fill, h, minutes, number, section } from "./dom";
import { showGoals, showPlan, showRover, showTrack, VECTORS, zoneFeatures } from "./field";
import { Picture } from "./picture";
import { attempt, live, now, onChange, operates, refreshRuns, tell } from "./shared";
import { Signals } from "./signals";
import { t, word, type Key } from "./strings";

const path = (run: string) => `runs/${encodeURIComponent(run)}`;

export function drive() {
  let judgements: Json[] = [];
  let shownRun = "";

  const chart = new Chart(["temperature", "seen", "obstacles"], VECTORS);
  const picture = new Picture();
  const signals = new Signals([[t("sigma"), "m"], [t("relative_sigma"), "m"], [t("battery"), "V"]]);
  const facts = h("dl", { class: "pairs facts" });
  const headline = h("p", { class: "headline", role: "status" }, t("none_running"));
  const events = h("ol", { class: "events", "aria-live": "polite", tabindex: 0, "aria-label": t("events") });
  const said = h("pre", { class: "said", tabindex: 0, "aria-label": t("said") });
  const goals = choice([]);

  // -- commands --
  function say(op: string, id = ""): void {
    attempt(async () => {
      const told = await post(`${path(now.running)}/tell`, { op, ...(id ? { id } : {}) });
      tell(t("told", { word: word(op), says: told.says }));
    });
  }
  const words = (["pause", "go", "home", "stop"] as const).map((op) => button(t(op), () => say(op), { class: "command" }));
  const skip = button(t("skip"), () => goals.value && say("skip", goals.value), { class: "command" });
  const commands = section(t("commands"), h("div", { class: "row" }, ...words), h("div", { class: "row" }, field(t("skip_goal"), goals), skip));

  // -- start --
  const mission = choice([]);
  const rig = choice([["sitl", "sitl"], ["emulator", "emulator"], ["device", "device"]]);
  const seed = h("input", { type: "number", min: 0, value: 1 });
  const port = h("input", { type: "text" });
  const camera = h("input", { type: "text" });
  const resume = choice([["", t("resume_none")]]);
  const onDevice = h("div", { class: "fields" }, field(t("port"), port), field(t("camera_source"), camera));
  const go = button(t("start"), () => attempt(begin), { class: "primary" });
  const start = section(t("start_title"),
    h("div", { class: "fields" }, field(t("mission_drive"), mission), field(t("rig"), rig), field(t("seed"), seed), field(t("resume"), resume)),
    onDevice, go);
  rig.addEventListener("change", () => { onDevice.hidden = rig.value !== "device"; });
  onDevice.hidden = true;

  async function begin(): Promise<void> {
    const told = await post("runs", {
      mission: mission.value, rig: rig.value, seed: Number(seed.value), port: port.value, camera_source: camera.value,
      resume: resume.value || null,
    });
    now.shown = told.run;
    headline.textContent = t("starting");
    await refreshRuns();
  }

  async function list(): Promise<void> {
    const told = await get("missions");
    choose(mission, [...told.own, ...told.shipped].map((each: string) => [each, each]));
    choose(resume, [["", t("resume_none")], ...now.runs.filter((run) => run.can_go_on).map((run): [string, string] => [run.name, run.name])], now.resume || undefined);
    now.resume = "";
  }

  // -- what comes --
  live.on("state", (state) => {
    const { status, mission: told, firmware } = state;
    clearFor(now.running);
    headline.textContent = told.says;
    headline.dataset.state = told.state;
    const rows: [Key, string][] = [
      ["time", minutes(status.time)], ["surveyed", `${number(100 * status.surveyed, 0)} %`], ["left", minutes(status.remaining)],
      ["firmware", firmware.meaning ?? status.firmware],
      ["battery", `${number(status.battery)} V`], ["battery_left", `${minutes(status.energy_s)}, ${number(status.energy_wh, 1)} Wh`],
      ["link", t("link_value", { lost: status.lost_frames, trip: number(status.round_trip * 1000, 1) })],
      ["position", `${number(status.x)}, ${number(status.y)} m, ${number((status.heading * 180) / Math.PI, 0)}°`],
      ["sigma", `${number(100 * status.sigma, 1)} cm`], ["relative_sigma", `${number(100 * state.relative_sigma, 1)} cm`],
      ["goals", `${status.goals_done} / ${status.goals}`], ["indications", String(status.indications)],
      ...(status.waits_for ? [["waits", status.waits_for] as [Key, string]] : []),
    ];
    fill(facts, ...rows.flatMap(([key, value]) => [h("dt", {}, t(key)), h("dd", {}, value)]));
    fill(events, ...state.events.slice(-30).reverse().map((each: Json) => h("li", {}, h("time", {}, `${number(each.t, 1)} s `), each.text)));
    choose(goals, told.goals.map((id: string) => [id, id]));
    chart.put("zones", zoneFeatures(state.places, state.zones, judgements));
    showGoals(chart, state.goals.filter((goal: Json) => goal.state === "pending"));
    showPlan(chart, state.plan);
    showRover(chart, status.x, status.y, status.heading, status.sigma);
    const { width_m: width, height_m: height } = state.area;
    chart.put("plan_file", [feature("area", outline([[0, 0], [width, 0], [width, height], [0, height]]))]);
    chart.fit(`${now.running} ${width} ${height}`, [0, 0, width, height]);
    signals.add(t("sigma"), status.time, status.sigma);
    signals.add(t("relative_sigma"), status.time, state.relative_sigma);
    signals.add(t("battery"), status.time, status.battery);
    if (state.outcome) headline.textContent = t("ending", state.outcome);
  });
  live.on("map", (map) => {
    for (const name of ["temperature", "seen", "obstacles"] as const) chart.raster(name, map[name], map.width_m, map.height_m);
  });
  live.on("track", ({ points }) => showTrack(chart, points.map(([, x, y]: number[]) => [x, y])));
  live.on("picture", ({ png, candidates, t: time }) => void picture.show(`data:image/png;base64,${png}`, candidates, time));
  live.on("link", ({ running }) => { if (!running && now.running) attempt(look); });

  function clearFor(run: string): void {
    if (run === shownRun) return;
    shownRun = run;
    judgements = [];
    signals.clear();
    attempt(look);
  }

  /** What only the console knows of the run that is shown. */
  async function look(): Promise<void> {
    const run = now.running || now.shown;
    if (!run) return;
    const told = await get(path(run));
    judgements = told.judgements;
    fill(said, ...(told.process?.said ?? []).map((each: string) => `${each}\n`));
    if (told.summary.status) headline.textContent = t("ended", { status: told.summary.status, reason: told.summary.reason });
    else if (told.process?.exit_code > 0) headline.textContent = (told.process.said ?? []).at(-1) ?? "";
  }

  onChange(() => {
    const running = now.running !== "";
    for (const each of [...words, skip]) each.disabled = !running || !operates();
    go.disabled = running || !operates();
    start.hidden = running;
    if (!running) { attempt(look); if (!headline.textContent) headline.textContent = t("none_running"); }
  });

  const element = h("div", { class: "page" },
    h("div", { class: "column wide" },
      section(t("map"), headline, chart.element, h("p", { class: "hint" }, t("legend_seen"))),
      section(t("signals"), signals.element)),
    h("div", { class: "column" },
      start, commands, section(t("state"), facts), section(t("thermal"), picture.canvas), section(t("events"), events), section(t("said"), said)));
  return { element, shown: () => { chart.shown(); attempt(list); } };
}
