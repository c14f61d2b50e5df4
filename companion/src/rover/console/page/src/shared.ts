// What the pages share: who is there, which run is shown, and one line at the foot for what has just happened.
import { h } from "./dom";
import { get, Live, type Json } from "./api";
import { t } from "./strings";

export const live = new Live();
export const status = h("p", { role: "status", class: "status" });

export const now: { people: Json | null; running: string; shown: string; runs: Json[]; resume: string } = {
  people: null, running: "", shown: "", runs: [], resume: "",
};

const watchers = new Set<() => void>();

/** Called whenever `now` has changed. */
export function onChange(watcher: () => void): void {
  watchers.add(watcher);
}

export function changed(): void {
  for (const watcher of watchers) watcher();
}

export function tell(text: string): void {
  status.textContent = text;
}

/** Does something that the server may refuse, and says so if it does. */
export function attempt(action: () => Promise<unknown>): void {
  action().catch((error: unknown) => tell(t("error", { why: error instanceof Error ? error.message : String(error) })));
}

export function operates(): boolean {
  return now.people?.operates === true;
}

export function mayOperate(): boolean {
  return now.people?.me?.role === "operator";
}

/** The list of runs anew; a run on its way is the one that is live. */
export async function refreshRuns(): Promise<void> {
  const told = await get("runs");
  now.runs = told.runs;
  const running = now.runs.find((run) => run.state === "running")?.name ?? told.beginning[0] ?? "";
  now.running = running;
  if (!now.shown) now.shown = running || now.runs[0]?.name || "";
  live.open(running);
  changed();
}
