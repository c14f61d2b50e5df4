// The check list before a start: this computer, the mission file, and the hours at which mines show.
import { post, type Json } from "./api";
import { button, choice, field, fill, h, section } from "./dom";
import { attempt } from "./shared";
import { t } from "./strings";

const SOILS = ["dry-sand", "loam", "clay", "moist-clay"];

export function checks(mission: () => Json, problem: () => string): HTMLElement {
  const list = h("ul", { class: "checks", "aria-live": "polite" });
  const soil = choice(SOILS.map((each) => [each, each]), "loam");
  const date = h("input", { type: "date", value: new Date().toISOString().slice(0, 10) });
  const latitude = h("input", { type: "number", step: "any", value: 45 });

  const row = (ok: boolean, name: string, detail: string) =>
    h("li", { class: ok ? "ok" : "bad" }, h("span", { "aria-hidden": "true" }, ok ? "✓ " : "✗ "), h("strong", {}, name), ` ${detail}`,
      h("time", {}, ` ${new Date().toLocaleTimeString()}`));

  async function run(): Promise<void> {
    fill(list, h("li", {}, t("checking")));
    const rows = [row(problem() === t("problem_none"), t("check_mission"), problem())];
    try {
      const told = await post("doctor");
      rows.push(...told.checks.map((check: Json) => row(check.ok, check.name, check.detail)));
    } catch (error) {
      rows.push(row(false, "rover doctor", String(error instanceof Error ? error.message : error)));
    }
    fill(list, ...rows);
    try {
      const origin = mission().site?.origin;
      const site = { soil: soil.value, latitude_deg: origin?.[0] ?? Number(latitude.value), date: date.value };
      const told = await post("when", { site });
      rows.push(...told.depths.map((depth: Json) => row(depth.hours_seen.length > 0, t("check_when"), depth.hours_seen.length
        ? t("when_line", { depth: depth.depth_cm, hour: depth.hour, hours: spans(depth.hours_seen) })
        : t("when_never", { depth: depth.depth_cm }))));
    } catch (error) {
      rows.push(row(false, t("check_when"), String(error instanceof Error ? error.message : error)));
    }
    fill(list, ...rows);
  }

  return section(t("checks"),
    h("div", { class: "fields" }, field(t("soil"), soil), field(t("date"), date), field(t("latitude"), latitude)),
    button(t("run_checks"), () => attempt(run)), list);
}

function spans(hours: string[]): string {
  return hours.length > 2 ? `${hours[0]} … ${hours[hours.length - 1]} (${hours.length})` : hours.join(", ");
}
