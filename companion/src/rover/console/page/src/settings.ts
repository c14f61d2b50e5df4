// The plan's fields: each is a key of the mission file.
import { field, h, section } from "./dom";
import type { Json } from "./api";
import { t, type Key } from "./strings";

type Put = (table: string, key: string, value: unknown) => void;
interface Entry { table: string; key: string; label: Key; kind: "number" | "text" | "flag"; scale?: number; index?: number }

const GROUPS: [Key, Entry[]][] = [
  ["mission", [
    { table: "mission", key: "max_duration_s", label: "max_duration", kind: "number" },
    { table: "mission", key: "required_coverage", label: "required_coverage", kind: "number", scale: 100 },
    { table: "mission", key: "return_home", label: "return_home", kind: "flag" },
  ]],
  ["launch", [
    { table: "launch", key: "x_m", label: "launch_x", kind: "number" },
    { table: "launch", key: "y_m", label: "launch_y", kind: "number" },
    { table: "launch", key: "heading_deg", label: "launch_heading", kind: "number" },
  ]],
  ["site", [
    { table: "site", key: "name", label: "site_name", kind: "text" },
    { table: "site", key: "organisation", label: "organisation", kind: "text" },
    { table: "site", key: "operator", label: "operator", kind: "text" },
    { table: "site", key: "date", label: "date", kind: "text" },
    { table: "site", key: "weather", label: "weather", kind: "text" },
    { table: "site", key: "origin", label: "latitude", kind: "number", index: 0 },
    { table: "site", key: "origin", label: "longitude", kind: "number", index: 1 },
    { table: "site", key: "bearing_deg", label: "bearing", kind: "number" },
  ]],
  ["lanes", [
    { table: "lanes", key: "width_m", label: "lane_width", kind: "number" },
    { table: "lanes", key: "heading_deg", label: "lane_heading", kind: "number" },
    { table: "lanes", key: "overlap_m", label: "lane_overlap", kind: "number" },
  ]],
];

/** `put` is called with what has been changed; `offer` is told which sections the reader knows. */
export function settings(put: Put) {
  let shown: Json = {};
  const controls: [Entry, HTMLInputElement][] = [];

  function control(entry: Entry): HTMLElement {
    const input: HTMLInputElement = h("input", {
      type: entry.kind === "flag" ? "checkbox" : entry.kind === "number" ? "number" : "text", step: "any",
      change: () => put(entry.table, entry.key, value(entry, input)),
    });
    controls.push([entry, input]);
    return field(t(entry.label), input);
  }

  function value(entry: Entry, input: HTMLInputElement): unknown {
    if (entry.kind === "flag") return input.checked;
    if (entry.kind === "text") return input.value;
    const number = input.value === "" ? undefined : Number(input.value) / (entry.scale ?? 1);
    if (entry.index === undefined) return number;
    const pair = [...(shown[entry.table]?.[entry.key] ?? [0, 0])];
    if (number === undefined) return undefined;
    pair[entry.index] = number;
    return pair;
  }

  const groups = GROUPS.map(([title, entries]): [string, HTMLElement] => [
    entries[0]?.table ?? "", section(t(title), h("div", { class: "fields" }, ...entries.map(control))),
  ]);

  return {
    element: h("div", { class: "column" }, ...groups.map(([, group]) => group)),
    offer(sections: Json): void {
      for (const [table, group] of groups) group.hidden = !sections[table];
    },
    show(document: Json): void {
      shown = document;
      for (const [entry, input] of controls) {
        if (input === window.document.activeElement) continue;
        let known = document[entry.table]?.[entry.key];
        if (entry.index !== undefined) known = known?.[entry.index];
        if (entry.kind === "flag") input.checked = known ?? true;
        else input.value = known === undefined ? "" : String(entry.scale ? Number((known * entry.scale).toFixed(6)) : known);
      }
    },
  };
}
